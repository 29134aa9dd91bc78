#!/usr/bin/env python3
"""Checks what scripts/figures-estimation computes itself: the regression of images and the posterior on a grid, for images that are known.

usage: check_estimation_figures.py
Closing line: 'N passed, N failed'. The control: images that tell the asymmetry must not give the ridge of the similarity relation.
"""
import math
import os
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts"))
import similarity  # noqa: E402

POINTS = [(g, r / (1 - g)) for g in (0.05, 0.3, 0.5, 0.7, 0.8, 0.9) for r in (0.08, 0.12, 0.17, 0.24, 0.33)]


def models_of(slope):
    """Of images that depend on (1 - g) sigma_s, and with a slope of the logarithm on g."""
    def log_value(b, g, s):
        return -1 + (0.2 + 0.05 * b) * math.log((1 - g) * s / 0.16) + slope * (b - 6) * (g - 0.8)

    models = [similarity.regression(POINTS, [log_value(b, g, s) for g, s in POINTS]) for b in range(similarity.NUM_BINS)]
    observed = [math.exp(log_value(b, *similarity.TRUTH)) for b in range(similarity.NUM_BINS)]
    return models, observed


def moments_of(slope):
    models, observed = models_of(slope)
    chi2, masses = similarity.posterior(models, observed, True)
    assert abs(sum(m for _, _, m in masses) - 1) < 1e-9
    return chi2, similarity.moments(masses, lambda g, s: (1 - g) * s), similarity.moments(masses, lambda g, s: g)


def solves_linear_equations():
    found = similarity.solve([[0, 2, 1], [1, 0, 3], [2, 1, 0]], [7, 10, 4])
    return max(abs(a - b) for a, b in zip(found, (1, 2, 3))) < 1e-12


def regression_has_cubics_exactly():
    models, _ = models_of(0.3)
    return max(deviation for _, deviation in models) < 1e-4


def ridge_is_the_similarity_relation():
    chi2, (reduced, sd), (g, g_sd) = moments_of(0)
    # 12 values of 4 % and more with slopes of .2 to .75: nearly .04 / |slopes| = 2 %; g is uniform but for sigma_s <= 2.
    return chi2 < 0.2 and abs(reduced / 0.166 - 1) < 0.05 and sd / reduced < 0.05 and g_sd > 0.2


def control_tells_the_asymmetry():
    _, _, (g, g_sd) = moments_of(1)
    return abs(g - 0.8) < 0.03 and g_sd < 0.03


def contours_hold_the_truth():
    models, observed = models_of(0)
    _, masses = similarity.posterior(models, observed, True)
    return any(abs(g - 0.8) < 0.01 and low <= 0.85 and high >= 0.8 for g, low, high in similarity.contour(masses, 0.9))


def main():
    checks = [solves_linear_equations, regression_has_cubics_exactly, ridge_is_the_similarity_relation, control_tells_the_asymmetry,
              contours_hold_the_truth]
    failed = [check.__name__ for check in checks if not check()]
    for name in failed:
        print("failed: " + name)
    print("%d passed, %d failed" % (len(checks) - len(failed), len(failed)))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
