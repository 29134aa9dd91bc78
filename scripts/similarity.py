"""The similarity relation as a posterior distribution: figure 6.4 of [Guo 2021] with scattering of a slab by `volpath`.

A slab of thickness 10 with known absorption, an unknown coefficient of scattering and an unknown asymmetry of Henyey and Greenstein's
phase function. What leaves it, by the angle, is nearly a function of (1 - g) sigma_s alone, if the light comes from behind.
"""
import math
import os

from bulk_figures import luminance
from chart_svg import lines

SIGMA_A, THICKNESS = 0.02, 10.0
TRUTH = (0.80, 0.83)        # g, sigma_s: (1 - g) sigma_s = 0.166
REDUCED = (0.07, 0.36)      # where it is looked for
NUM_BINS = 12
NOISE = (0.04, 0.01)        # deviations: part of the value, part of the peak

# The camera is above the slab, which is so wide that its sides are nowhere near.
SCENE = """
Option "disablewavelengthjitter" true
%(camera)s "string filename" "slab.pfm"
PixelFilter "box"
Sampler "independent" "integer pixelsamples" %(spp)d "integer seed" %(seed)d
Integrator "volpath" "integer maxdepth" 400
WorldBegin
MakeNamedMedium "slab" "string type" "homogeneous" "rgb sigma_a" [%(absorbed)g %(absorbed)g %(absorbed)g]
    "rgb sigma_s" [%(scattered)g %(scattered)g %(scattered)g] "float g" %(g)g
%(light)s
Material "interface"
MediumInterface "slab" ""
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2000 -2000 %(top)g 2000 -2000 %(top)g 2000 2000 %(top)g -2000 2000 %(top)g]
Shape "trianglemesh" "integer indices" [0 2 1 0 3 2] "point3 P" [-2000 -2000 0 2000 -2000 0 2000 2000 0 -2000 2000 0]
"""


def by_cosine(x, y):
    """Of a row of a spherical camera: bins of equal width in the cosine of the angle of exit, from 0.1 to 1."""
    return int((1 - math.cos(math.pi * (y + 0.5) / 64)) / 0.9 * NUM_BINS)


def by_radius(x, y):
    """Of a pixel of a camera that looks straight down: rings of equal width."""
    return int(math.hypot(x - 11.5, y - 11.5) / 12 * NUM_BINS)


# Of each light: the camera and its film, the bins of pixels, the light.
LIGHTS = {
    # The first rows of an image of all directions, that of straight down in front.
    "behind": ('LookAt 0 0 12  1 0 12  0 0 -1 Camera "spherical" "string mapping" "equirectangular"\n'
               'Film "rgb" "integer xresolution" 18 "integer yresolution" 64 "integer pixelbounds" [0 18 0 30]', by_cosine,
               'LightSource "distant" "point3 from" [0 0 -1] "point3 to" [0 0 0] "rgb L" [1 1 1]'),
    "flash": ('LookAt 0 0 35  0 0 0  0 1 0 Camera "perspective" "float fov" 90\n'
              'Film "rgb" "integer xresolution" 24 "integer yresolution" 24', by_radius,
              'LightSource "point" "point3 from" [0 0 35] "rgb I" [1000 1000 1000]')}


def profile(lacquer, light, g, sigma_s, seed, effort):
    """Mean luminance by the angle."""
    camera, bin_of, source = LIGHTS[light]
    text = SCENE % {"camera": camera, "spp": effort, "seed": seed, "absorbed": SIGMA_A, "scattered": sigma_s, "g": g, "light": source,
                    "top": THICKNESS}
    image = lacquer.render("slab", text=text, name="slab")[1]
    sums, counts = [0.0] * NUM_BINS, [0] * NUM_BINS
    for y, row in enumerate(image):
        for x, pixel in enumerate(row):
            k = bin_of(x, y)
            if k < NUM_BINS:
                sums[k] += luminance(pixel)
                counts[k] += 1
    return [s / n for s, n in zip(sums, counts)]


# ---- What the images are between those that were rendered ----

def terms(g, sigma_s):
    """All products of at most three of two variables near [-1, 1]."""
    u, v = 2 * g - 1, math.log((1 - g) * sigma_s / 0.16)
    return [u ** i * v ** j for i in range(4) for j in range(4 - i)]


def solve(matrix, values):
    """By Gauss's elimination with pivots."""
    n = len(values)
    rows = [list(row) + [value] for row, value in zip(matrix, values)]
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(rows[i][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(k + 1, n):
            factor = rows[i][k] / rows[k][k]
            rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k])]
    for k in reversed(range(n)):
        rows[k][n] = (rows[k][n] - sum(rows[k][j] * rows[j][n] for j in range(k + 1, n))) / rows[k][k]
    return [row[n] for row in rows]


def regression(points, values):
    """Coefficients of the terms, and the deviation that is left: the noise of the renders."""
    basis = [terms(*p) for p in points]
    n = len(basis[0])
    gram = [[sum(b[i] * b[j] for b in basis) + (1e-9 if i == j else 0) for j in range(n)] for i in range(n)]
    found = solve(gram, [sum(b[i] * v for b, v in zip(basis, values)) for i in range(n)])
    residuals = [v - sum(c * t for c, t in zip(found, b)) for b, v in zip(basis, values)]
    return found, math.sqrt(sum(r * r for r in residuals) / max(1, len(points) - n))


# ---- The posterior, on a grid ----

GRID = [(0.95 * (i + 0.5) / 76, 0.1 * 20 ** ((j + 0.5) / 120)) for i in range(76) for j in range(120)]


def posterior(models, observed, is_exposure_known):
    """(g, sigma_s, mass) where there is some. The prior is uniform in both."""
    noise = [math.hypot(NOISE[0] * v, NOISE[1] * max(observed)) for v in observed]
    found = []
    for g, sigma_s in GRID:
        if not REDUCED[0] < (1 - g) * sigma_s < REDUCED[1]:
            continue
        basis = terms(g, sigma_s)
        predicted = [math.exp(sum(c * t for c, t in zip(model, basis))) for model, _ in models]
        # The regression errs by some of the renders' noise.
        sds = [math.hypot(s, 0.3 * model[1] * p) for s, model, p in zip(noise, models, predicted)]
        scale = 1.0
        if not is_exposure_known:
            scale = (sum(p * v / s ** 2 for p, v, s in zip(predicted, observed, sds)) /
                     sum(p * p / s ** 2 for p, s in zip(predicted, sds)))
        chi2 = sum(((scale * p - v) / s) ** 2 for p, v, s in zip(predicted, observed, sds))
        found.append((g, sigma_s, chi2))
    least = min(chi2 for _, _, chi2 in found)
    masses = [(g, s, s * math.exp(-0.5 * (chi2 - least))) for g, s, chi2 in found]
    total = sum(m for _, _, m in masses)
    return least, [(g, s, m / total) for g, s, m in masses]


def moments(masses, value):
    mean = sum(m * value(g, s) for g, s, m in masses)
    return mean, math.sqrt(sum(m * (value(g, s) - mean) ** 2 for g, s, m in masses))


def contour(masses, part):
    """The region that holds a part of all: for each g of the grid the least and the largest sigma_s in it."""
    level, total = 0.0, 0.0
    for mass in sorted((m / s for _, s, m in masses), reverse=True):
        level = mass
        total += mass
        if total >= part * sum(m / s for _, s, m in masses):
            break
    ends = {}
    for g, s, m in masses:
        if m / s >= level:
            low, high = ends.get(g, (s, s))
            ends[g] = (min(low, s), max(high, s))
    return sorted((g, *e) for g, e in ends.items())


def similarity(lacquer, times=1.0):
    """Renders the grid for both lights; a table, and one chart for each light."""
    effort = max(8, round(300 * times))
    gs = [0.05, 0.2, 0.35, 0.5, 0.62, 0.72, 0.8, 0.86, 0.91]
    points = [(g, r / (1 - g)) for g in gs for r in (0.075, 0.105, 0.14, 0.18, 0.235, 0.34) if 0.08 < r / (1 - g) < 2.6]
    table = ["| light | exposure | χ²/p | (1 − g) σ_s, true 0.166 | g, true .80 | σ_s, true .83 | mass at g < .6, > .85 |", "|---|---|---|---|---|---|---|"]
    drawings, verdicts = [], []
    for light in LIGHTS:
        images = [profile(lacquer, light, g, s, 1, effort) for g, s in points]
        observed = profile(lacquer, light, *TRUTH, 2, 16 * effort)
        models = [regression(points, [math.log(max(p[b], 1e-12)) for p in images]) for b in range(NUM_BINS)]
        for is_known in (True, False):
            chi2, masses = posterior([m for m in models], observed, is_known)
            (red, red_sd), (g, g_sd), (s, s_sd) = (moments(masses, f) for f in (lambda g, s: (1 - g) * s, lambda g, s: g, lambda g, s: s))
            below, above = sum(m for g_, _, m in masses if g_ < 0.6), sum(m for g_, _, m in masses if g_ > 0.85)
            table.append("| %s | %s | %.1f | %.3f ± %.3f (%.0f %%) | %.2f ± %.2f | %.2f ± %.2f (%.0f %%) | %.2f, %.2f |" % (
                light, "known" if is_known else "free", chi2 / NUM_BINS, red, red_sd, 100 * red_sd / red, g, g_sd, s, s_sd, 100 * s_sd / s,
                below, above))
            if is_known:
                if light == "behind":
                    verdicts = [("sd of (1 − g) σ_s below 10 %", red_sd < 0.1 * red), ("sd of σ_s above 35 %", s_sd > 0.35 * s),
                                ("true value within 2 sd", abs(red - 0.166) < 2 * red_sd), ("mass at g below .6 and above .85", below > 0.01 and above > 0.01)]
                region = contour(masses, 0.9)
                curve = [(0.166 / (1 - 0.95 * i / 200), 0.95 * i / 200) for i in range(201)]
                drawings.append(lines("σ_s", "g", [
                    ("90 % of the posterior", [(low, g_) for g_, low, _ in region] + [(high, g_) for g_, _, high in reversed(region)]),
                    ("-(1 − g) σ_s = 0.166", [p for p in curve if p[0] <= 2]),
                    ("truth", [(TRUTH[1] - 0.02, TRUTH[0]), (TRUTH[1] + 0.02, TRUTH[0])])], x_range=(0, 2), y_range=(0, 1),
                    legend_top=340, title="Light %s" % ("from behind" if light == "behind" else "as a flash")))
        table.append("| %s | noise of renders | %.1f %% a ring | | | | |" % (light, 100 * sum(m[1] for m in models) / NUM_BINS))
    return table, drawings, verdicts
