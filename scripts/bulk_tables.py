"""What scripts/figures-bulk does to tables of `lacquer bulk`: fewer angles."""
import math


def norm(angles, p):
    """2 pi times the integral over the cosine, linear in it between angles."""
    c = [math.cos(math.radians(a)) for a in angles]
    return math.pi * sum((p[i] + p[i + 1]) * (c[i] - c[i + 1]) for i in range(len(c) - 1))


def thinned(table, step, fine=0):
    """Only angles that are multiples of `step` degrees, and all below `fine`; no Mueller matrices; p scaled so that its integral stays
    1."""
    kept = [i for i, a in enumerate(table["angles"]) if a < fine or abs(a / step - round(a / step)) < 1e-9]
    small = {key: value for key, value in table.items() if key != "mueller"}
    small["angles"] = [table["angles"][i] for i in kept]
    small["phase"] = []
    for p in table["phase"]:
        row = [p[i] for i in kept]
        scale = norm(small["angles"], row)
        small["phase"].append([float("%.9g" % (v / scale)) for v in row])
    return small
