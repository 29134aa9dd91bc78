#!/usr/bin/env python3
"""Checks what scripts/figures-bulk does to tables: from balls that shadow themselves back to the medium, and fewer angles; and the tables
of scenes/bulk: norm, energy balance of their clusters (1e-10), size, that each is used and each that is used is there, and what the
figures say of them.

usage: check_bulk_tables.py
Random walks of this file, by Henyey and Greenstein's own formula and with the direction in which light leaves, play the part of Maxwell's
equations for balls of four optical thicknesses. Closing line: 'N passed, N failed'. The check is itself checked: what the balls scatter
as it is must be found wrong, and so must tables that are broken.
"""
import json
import math
import os
import random
import re
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts"))
import bulk_chapter  # noqa: E402
from bulk_figures import SCENES, TABLES  # noqa: E402
from bulk_tables import moments, norm, of_medium, thinned  # noqa: E402

BALL, PARTICLE, SIGMA, G, WALKS = 1.0, 0.2, 2.0, 0.5, 40000
ANGLES = [2.0 * i for i in range(91)]


def henyey_greenstein(rng, g):
    s = (1 - g * g) / (1 - g + 2 * g * rng.random())
    return (1 + g * g - s * s) / (2 * g)


def leave(rng, radius, sigma, g):
    """The cosine between the directions in which light enters and leaves a ball, or None where nothing scattered it."""
    x, y = 1.0, 1.0
    while x * x + y * y > 1:
        x, y = rng.uniform(-1, 1), rng.uniform(-1, 1)
    p = [x * radius, y * radius, -radius * math.sqrt(1 - x * x - y * y)]
    d, scattered = [0.0, 0.0, 1.0], False
    while True:
        t = rng.expovariate(sigma)
        p = [a + t * b for a, b in zip(p, d)]
        if sum(a * a for a in p) > radius * radius:
            return d[2] if scattered else None
        scattered = True
        c, azimuth = henyey_greenstein(rng, g), rng.uniform(0, 2 * math.pi)
        helper = [1.0, 0.0, 0.0] if abs(d[0]) < 0.7 else [0.0, 1.0, 0.0]
        u = [d[1] * helper[2] - d[2] * helper[1], d[2] * helper[0] - d[0] * helper[2], d[0] * helper[1] - d[1] * helper[0]]
        length = math.sqrt(sum(a * a for a in u))
        u = [a / length for a in u]
        v = [d[1] * u[2] - d[2] * u[1], d[2] * u[0] - d[0] * u[2], d[0] * u[1] - d[1] * u[0]]
        s = math.sqrt(1 - c * c)
        d = [c * a + s * (math.cos(azimuth) * b + math.sin(azimuth) * e) for a, b, e in zip(d, u, v)]


def ball(thickness, seed):
    """What a ball of that thickness scatters: (sigma_s as `lacquer bulk` counts it, p at ANGLES, its mean cosine)."""
    rng, reach = random.Random(seed), BALL + PARTICLE
    cosines = [c for c in (leave(rng, reach, thickness / (2 * reach), G) for _ in range(WALKS)) if c is not None]
    share = len(cosines) / WALKS
    # Moments, and p from them.
    sums = [0.0] * 13
    for c in cosines:
        a, b = 1.0, c
        sums[0] += 1
        sums[1] += c
        for n in range(2, 13):
            a, b = b, ((2 * n - 1) * c * b - (n - 1) * a) / n
            sums[n] += b
    p = []
    for angle in ANGLES:
        c = math.cos(math.radians(angle))
        a, b, value = 1.0, c, sums[0] + 3 * sums[1] * c
        for n in range(2, 13):
            a, b = b, ((2 * n - 1) * c * b - (n - 1) * a) / n
            value += (2 * n + 1) * sums[n] * b
        p.append(max(0.0, value / (4 * math.pi * len(cosines))))
    return share * reach * reach / (4 / 3 * BALL ** 3), p, sums[1] / sums[0]


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
    passed = failed = 0

    def check(good, text):
        nonlocal passed, failed
        passed += good
        failed += not good
        if not good:
            print("FAIL  " + text)

    for thickness in (0.3, 1, 2, 3.5):
        # All that scatters, as if it were in the ball of the centres.
        sigma = thickness / (2 * (BALL + PARTICLE)) * ((BALL + PARTICLE) / BALL) ** 3
        measured, p, g = ball(thickness, round(10 * thickness))
        found, row, tau = of_medium(measured, ANGLES, p, BALL, PARTICLE, 12)
        found_g = moments(ANGLES, row, 1)[1]
        text = "thickness %g: sigma %.4f (%.4f), g %.3f (%.3f)" % (thickness, found, sigma, found_g, G)
        check(abs(found / sigma - 1) < 0.03 and abs(tau / thickness - 1) < 0.03, text)
        check(abs(found * (1 - found_g) / (sigma * (1 - G)) - 1) < 0.04, text)
        if thickness >= 1:  # the control
            check(abs(measured / sigma - 1) > 0.2 and abs(g - G) > 0.05, "control at " + text)

    p = [math.exp(-a / 40) for a in ANGLES]
    scale = norm(ANGLES, p)
    small = thinned({"angles": ANGLES, "phase": [[v / scale for v in p]], "mueller": [[]]}, 4)
    check(len(small["angles"]) == 46 and abs(norm(small["angles"], small["phase"][0]) - 1) < 1e-6 and "mueller" not in small, "thinned")
    check_tables(check)
    print("%d passed, %d failed" % (passed, failed))
    sys.exit(1 if failed else 0)


main()
