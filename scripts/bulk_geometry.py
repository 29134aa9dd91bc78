#!/usr/bin/env python3
"""Writes what the scenes of the chapter's figures are made of: scenes/bulk/geometry/knot.ply.gz and clusters.pbrt.gz.

usage: scripts/bulk_geometry.py
The same bytes each time.
"""
import gzip
import math
import os
import random
import struct

OUT = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "scenes", "bulk", "geometry")


def write(name, data):
    with open(os.path.join(OUT, name), "wb") as file, gzip.GzipFile(filename="", mode="wb", fileobj=file, mtime=0) as zipped:
        zipped.write(data)


# ---- A trefoil knot, thick on one side and thin on the other ----

RING, TURN, THIN, THICK = 1.1, 0.5, 0.07, 0.5  # radii: of the torus that it winds on, of its winding, of the tube


def unit(v):
    length = math.sqrt(sum(x * x for x in v))
    return [x / length for x in v]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def on_torus(t, turn):
    ring = RING + turn * math.cos(3 * t)
    return [ring * math.cos(2 * t), ring * math.sin(2 * t), turn * math.sin(3 * t)]


def knot(steps=216, around=28):
    """A ring of points at each step. Where the tube is thick its neighbour on the torus, half a period on, is thin."""
    vertices, faces = [], []
    for i in range(steps):
        t = 2 * math.pi * i / steps
        middle, ahead, behind = on_torus(t, TURN), on_torus(t + 1e-4, TURN), on_torus(t - 1e-4, TURN)
        tangent = unit([a - b for a, b in zip(ahead, behind)])
        v = unit(cross(tangent, [a - b for a, b in zip(middle, on_torus(t, 0))]))
        u = cross(v, tangent)
        tube = THIN + (THICK - THIN) * (0.5 - 0.5 * math.cos(t))
        for j in range(around):
            c, s = math.cos(2 * math.pi * j / around), math.sin(2 * math.pi * j / around)
            vertices.append([m + tube * (c * a + s * b) for m, a, b in zip(middle, u, v)])
            a, b = i * around + j, i * around + (j + 1) % around
            c, d = (a + around) % (steps * around), (b + around) % (steps * around)
            faces += [(a, b, d), (a, d, c)]
    return vertices, faces


def write_knot():
    vertices, faces = knot()
    header = ("ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
              "element face %d\nproperty list uchar int vertex_indices\nend_header\n" % (len(vertices), len(faces)))
    # Three decimals pack better.
    body = b"".join(struct.pack("<3f", *(round(x, 3) for x in v)) for v in vertices)
    write("knot.ply.gz", header.encode() + body + b"".join(struct.pack("<B3i", 3, *f) for f in faces))


# ---- A density of clusters that is correlated ----

NX, NY, NZ, CORRELATION, CONTRAST, SEED = 64, 64, 8, 2.5, 1.0, 1  # voxels; length in voxels; deviation of ln density


def smoothed(field, size, stride, radius):
    """Gaussian weights along one axis of a periodic grid."""
    weights = [math.exp(-0.5 * (k / CORRELATION) ** 2) for k in range(-radius, radius + 1)]
    result = []
    for i in range(len(field)):
        at = i // stride % size
        result.append(sum(w * field[i + ((at + k) % size - at) * stride] for k, w in zip(range(-radius, radius + 1), weights)))
    return result


def density():
    """Log-normal, mean 1: exp of white noise that a Gaussian has smoothed."""
    rng = random.Random(SEED)
    field = [rng.gauss(0, 1) for _ in range(NX * NY * NZ)]
    for size, stride in ((NX, 1), (NY, NX), (NZ, NX * NY)):
        field = smoothed(field, size, stride, round(3 * CORRELATION))
    deviation = math.sqrt(sum(x * x for x in field) / len(field))
    field = [math.exp(CONTRAST * x / deviation) for x in field]
    mean = sum(field) / len(field)
    return [x / mean for x in field]


def write_density():
    lines = ["# Log-normal density of clusters, mean 1: scripts/bulk_geometry.py.",
             'Attribute "medium" "integer nx" %d "integer ny" %d "integer nz" %d "float density" [' % (NX, NY, NZ)]
    values = ["%.2f" % x for x in density()]
    lines += [" ".join(values[i:i + NX]) for i in range(0, len(values), NX)]
    write("clusters.pbrt.gz", ("\n".join(lines) + "\n]\n").encode())


if __name__ == "__main__":
    os.makedirs(OUT, exist_ok=True)
    write_knot()
    write_density()
