#!/usr/bin/env python3
"""Draws what `lacquer compare` has measured: noise over time, and how much less noisy than the baseline each is.

usage: scripts/python examples/python/equal_time.py DIR/results.json [equal-time.png]
"""
import json
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of the backend)

if not 2 <= len(sys.argv) <= 3:
    sys.exit(__doc__.strip())
try:
    with open(sys.argv[1], encoding="utf-8") as file:
        results = json.load(file)
except (OSError, ValueError) as error:  # no file, no text, no JSON
    sys.exit(f"{sys.argv[1]}: cannot be read: {error}")
if not isinstance(results, dict) or results.get("schema") != "lacquer-compare-1":
    sys.exit(f"{sys.argv[1]}: no results of lacquer compare of a known schema")

variant, box = results["variants"][0], 0
name = results["boxes"][box]["name"]
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), constrained_layout=True)

for estimator in variant["estimators"]:
    points = [p for p in estimator["boxes"][box]["convergence"] if p["rmse"] is not None]
    left.loglog([p["seconds"] for p in points], [p["rmse"] for p in points], "o-", markersize=3, label=estimator["name"])
times = np.array(left.get_xlim())
first = variant["estimators"][0]["boxes"][box]["convergence"][0]
left.loglog(times, first["rmse"] * np.sqrt(first["seconds"] / times), "k--", linewidth=0.7, label="slope of -1/2")
left.set_xlim(times)
for axis in (left.xaxis, left.yaxis):
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter("{x:.2g}")
    axis.set_tick_params(which="both", labelsize="small")
left.set_xlabel("seconds of rendering")
left.set_ylabel("RMSE")
left.set_title(f"{results['scene']}, box \"{name}\"", fontsize="medium")
left.legend(fontsize="small")

shown = [e for e in variant["estimators"] if e["boxes"][box]["rmse_reduction"]["value"] is not None]
for row, estimator in enumerate(shown):
    ratio = estimator["boxes"][box]["rmse_reduction"]
    low = ratio["low"] if ratio["low"] is not None else ratio["value"]
    high = ratio["high"] if ratio["high"] is not None else ratio["value"]
    right.errorbar(ratio["value"], row, xerr=[[ratio["value"] - low], [high - ratio["value"]]], fmt="o", capsize=4)
right.axvline(1, color="k", linewidth=0.7, linestyle="--")
right.set_yticks(range(len(shown)), [e["name"] for e in shown])
right.invert_yaxis()
right.margins(y=0.3)
right.set_xlabel(f"RMSE of {results['baseline']} over that of the estimator,\nwith 95 % intervals")
right.set_title("equal time" if results["budget"]["kind"] == "time" else "equal samples", fontsize="medium")

path = sys.argv[2] if len(sys.argv) > 2 else "equal-time.png"
figure.savefig(path, dpi=110)
print(path)
