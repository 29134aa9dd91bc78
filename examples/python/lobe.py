#!/usr/bin/env python3
"""Draws a lobe of a layered material with its error: what a stack sends into the plane of incidence, by two estimators.

usage: scripts/python examples/python/lobe.py [lobe.png]
"""
import sys

import matplotlib
import numpy as np

import lacquer

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of the backend)

ESTIMATORS = ["bidirectional", "pairproduct"]
SAMPLES = 64
INCIDENCE = 40  # degrees

varnished = lacquer.stack([
    lacquer.material("dielectric", roughness=0.01),
    lacquer.material("slab", eta=1.5, thickness=0.4, sigma_t=(1, 1, 1), albedo=(0.95, 0.7, 0.4), phase="hg", g=0.6),
    lacquer.material("conductor", eta="metal-Cu-eta", k="metal-Cu-k", roughness=0.05),
])

angles = np.linspace(-88, 88, 177)
theta = np.radians(angles)
wo = np.stack([np.sin(theta), np.zeros_like(theta), np.cos(theta)], axis=-1)
wi = np.array([-np.sin(np.radians(INCIDENCE)), 0, np.cos(np.radians(INCIDENCE))])

lobes = {name: varnished.evaluate(wo, wi, samples=SAMPLES, seed=seed, estimator=name)
         for seed, name in enumerate(ESTIMATORS)}

figure, (top, bottom) = plt.subplots(2, 1, figsize=(7, 5.5), sharex=True, height_ratios=[3, 1], constrained_layout=True)
for name, style in zip(ESTIMATORS, ["-", "--"]):
    f = lobes[name]
    for channel, color in enumerate(["tab:red", "tab:green", "tab:blue"]):
        value, error = f.value[:, channel], 2 * f.error[:, channel]
        top.plot(angles, value, style, color=color, linewidth=1, label=f"{name}, {'RGB'[channel]}")
        top.fill_between(angles, value - error, value + error, color=color, alpha=0.2, linewidth=0)
top.set_ylabel("f [1/sr]")
top.set_ylim(bottom=0)
top.set_title(f"Varnished copper, light from {INCIDENCE}°; bands: two standard errors of {SAMPLES} evaluations",
              fontsize="medium")
top.legend(ncols=2, fontsize="small")

a, b = (lobes[name] for name in ESTIMATORS)
sigmas = (a.value - b.value)[:, 1] / np.hypot(a.error, b.error)[:, 1]
bottom.plot(angles, sigmas, "k.", markersize=3)
bottom.axhspan(-2, 2, color="gray", alpha=0.2, linewidth=0)
bottom.set_ylabel("difference,\nstandard errors")
bottom.set_xlabel("angle of the view direction [degrees]; the mirror direction is "
                  f"{INCIDENCE}")
path = sys.argv[1] if len(sys.argv) > 1 else "lobe.png"
figure.savefig(path, dpi=110)
print(f"{path}: |difference| beyond 2 standard errors at {np.mean(np.abs(sigmas) > 2):.1%} of the angles "
      "(expected 4.6%)")
