#!/usr/bin/env python3
"""Checks what scripts/figures-bulk does to tables: fewer angles, and still the same p there, with an integral of 1; and the tables of
scenes/bulk: norm, energy balance of their clusters (1e-10), size, that each is used and each that is used is there, and what the figures
say of them.

usage: check_bulk_tables.py
Closing line: 'N passed, N failed'. The check is itself checked: a p that is not scaled must be found wrong, and so must tables that are
broken.
"""
import json
import math
import os
import re
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts"))
import bulk_chapter  # noqa: E402
from bulk_figures import SCENES, TABLES  # noqa: E402
from bulk_tables import norm, thinned  # noqa: E402

ANGLES = [2.0 * i for i in range(91)]


# ---- The tables of scenes/bulk ----

LARGEST = 25000  # bytes of a table


def faults_of(table, size):
    """What is wrong with a table of so many bytes."""
    faults = []
    if size > LARGEST:
        faults.append("%d bytes" % size)
    clusters = table["made"]["input"].get("method", "clusters") == "clusters" and "realisations" in table["made"]
    if clusters and not table["made"].get("energy_error", 1) < 1e-10:
        faults.append("energy does not balance")
    if table["angles"][0] != 0 or table["angles"][-1] != 180:
        faults.append("angles")
    if table["isotropic"] and any(abs(norm(table["angles"], p) - 1) > 1e-6 for p in table["phase"]):
        faults.append("norm")
    return faults


def names_used():
    """Tables that a scene has, or a part of scripts/figures-bulk puts into one."""
    names = {"counts-%d-%d" % (n, a) for n in bulk_chapter.COUNTS for a in bulk_chapter.RADII}
    names |= {"correlated-" + kind for kind in bulk_chapter.ARRANGEMENTS} | {"rainbow-%d" % nm for nm in bulk_chapter.MONOCHROME}
    for scene in sorted(os.listdir(SCENES)):
        if scene.endswith(".pbrt"):
            with open(os.path.join(SCENES, scene), encoding="utf-8") as file:
                names |= set(re.findall(r'"tables/([\w-]+)\.json"', file.read()))
    return names


def check_tables(check):
    tables = {}
    for name in sorted(n[:-5] for n in os.listdir(TABLES) if n.endswith(".json")):
        path = os.path.join(TABLES, name + ".json")
        with open(path, encoding="utf-8") as file:
            tables[name] = json.load(file)
        faults = faults_of(tables[name], os.path.getsize(path))
        check(not faults, "%s: %s" % (name, ", ".join(faults)))
    check(names_used() == set(tables), "tables that are not used, or not there: %s" % sorted(names_used() ^ set(tables)))
    # More spheres in a cluster: a higher peak straight on, and each scatters less.
    for radius in bulk_chapter.RADII:
        row = [tables["counts-%d-%d" % (n, radius)] for n in bulk_chapter.COUNTS]
        check(all(a["phase"][0][0] < b["phase"][0][0] and a["sigma_s"][0] > b["sigma_s"][0] for a, b in zip(row, row[1:])),
              "counts at a radius of %d nm" % radius)
    scattered = [tables["correlated-" + kind]["sigma_s"][0] for kind in bulk_chapter.ARRANGEMENTS]
    check(scattered == sorted(scattered, reverse=True), "spheres that keep apart scatter most, clumped ones least")
    # The controls.
    good = tables["counts-10-500"]
    broken = [dict(good, made=dict(good["made"], energy_error=1e-9)), dict(good, phase=[[1.00001 * p for p in good["phase"][0]]]),
              dict(good, angles=good["angles"][1:], phase=[good["phase"][0][1:]])]
    check(all(faults_of(table, 1000) for table in broken) and bool(faults_of(good, 30000)), "controls of tables")


def main():
    results = []
    # Of exp(-a cos), whose integral is known.
    p = [math.exp(3 * math.cos(math.radians(a))) for a in ANGLES]
    results.append(("norm", abs(norm(ANGLES, p) / (4 * math.pi * math.sinh(3) / 3) - 1) < 1e-3))
    scale = norm(ANGLES, p)
    p = [v / scale for v in p]
    small = thinned({"angles": ANGLES, "phase": [p], "mueller": [[]], "g": [0.5]}, 6)
    (row,) = small["phase"]
    results.append(("angles", small["angles"] == [6.0 * i for i in range(31)]))
    results.append(("keys", sorted(small) == ["angles", "g", "phase"]))
    results.append(("integral", abs(norm(small["angles"], row) - 1) < 1e-8))
    results.append(("values", all(abs(row[i] / p[3 * i] - 1) < 0.02 for i in range(31))))
    results.append(("control", abs(norm(small["angles"], p[::3]) - 1) > 1e-4))
    check_tables(lambda good, name: results.append((name, good)))
    failed = [name for name, good in results if not good]
    for name in failed:
        print("FAIL  " + name)
    print("%d passed, %d failed" % (len(results) - len(failed), len(failed)))
    sys.exit(1 if failed else 0)


main()
