"""Numbers, noise, and writers for images and meshes, in plain Python: what make-guo2018 is made of."""
import gzip
import math
import os
import random
import struct
import zlib

OUT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scenes", "guo2018")


# ---- numbers ---------------------------------------------------------------------------------------------------

def clamp(x, low=0.0, high=1.0):
    return low if x < low else high if x > high else x


def smoothstep(low, high, x):
    t = clamp((x - low) / (high - low))
    return t * t * (3 - 2 * t)


def lerp(t, a, b):
    return a + (b - a) * t


def mix_rgb(t, a, b):
    return tuple(lerp(t, x, y) for x, y in zip(a, b))


def normalize(v):
    length = math.sqrt(sum(c * c for c in v))
    return tuple(c / length for c in v)


class Noise:
    """Smooth noise in [-1, 1]: random numbers on a lattice between which a quintic fades."""

    def __init__(self, seed):
        rng = random.Random(seed)
        self.values = [rng.uniform(-1, 1) for _ in range(256)]
        self.order = list(range(256))
        rng.shuffle(self.order)

    def at(self, x, y, z=0.0, period=0):
        """With a period, x and y repeat after so many lattice cells."""
        xi, yi, zi = math.floor(x), math.floor(y), math.floor(z)
        fx, fy, fz = x - xi, y - yi, z - zi
        sx, sy, sz = (f * f * f * (f * (f * 6 - 15) + 10) for f in (fx, fy, fz))
        x1, y1 = xi + 1, yi + 1
        if period:
            xi, x1, yi, y1 = xi % period, x1 % period, yi % period, y1 % period
        order, values = self.order, self.values

        def plane(k):
            o = order[k & 255]
            row0, row1 = order[(o + yi) & 255], order[(o + y1) & 255]
            a = lerp(sx, values[order[(row0 + xi) & 255]], values[order[(row0 + x1) & 255]])
            b = lerp(sx, values[order[(row1 + xi) & 255]], values[order[(row1 + x1) & 255]])
            return lerp(sy, a, b)

        return plane(zi) if fz == 0 else lerp(sz, plane(zi), plane(zi + 1))

    def octaves(self, p, count, gain=0.5, period=0):
        total, weight, scale = 0.0, 1.0, 1
        for _ in range(count):
            total += weight * self.at(*(c * scale for c in p), period=period * scale)
            weight *= gain
            scale *= 2
        return total


# ---- files -----------------------------------------------------------------------------------------------------

def path_of(name):
    path = os.path.join(OUT, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    return path


def filtered_row(row, above, stride):
    """The cheaper of PNG's filters 'sub' and 'up', by the sum of differences."""
    sub = bytes((row[i] - (row[i - stride] if i >= stride else 0)) & 255 for i in range(len(row)))
    up = bytes((a - b) & 255 for a, b in zip(row, above))
    cost = [sum(min(c, 256 - c) for c in line) for line in (sub, up)]
    return b"\x01" + sub if cost[0] <= cost[1] else b"\x02" + up


def write_png(name, width, height, pixel, channels, bits=8):
    """pixel(x, y) gives a tuple of `channels` (1 or 3) numbers in [0, 1], y counted from the top."""
    top = (1 << bits) - 1
    kind = ">%dH" % (width * channels) if bits == 16 else "%dB" % (width * channels)
    lines, above = [], bytes(width * channels * bits // 8)
    for y in range(height):
        row = struct.pack(kind, *(int(clamp(c) * top + 0.5) for x in range(width) for c in pixel(x, y)))
        lines.append(filtered_row(row, above, channels * bits // 8))
        above = row

    def chunk(tag, data):
        return struct.pack(">I", len(data)) + tag + data + struct.pack(">I", zlib.crc32(tag + data))

    header = struct.pack(">IIBBBBB", width, height, bits, {1: 0, 3: 2}[channels], 0, 0, 0)
    with open(path_of(name), "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header))
        file.write(chunk(b"IDAT", zlib.compress(b"".join(lines), 9)) + chunk(b"IEND", b""))


def srgb(linear):
    return tuple(12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055 for c in map(clamp, linear))


def encoded(vector):
    return tuple(0.5 + 0.5 * c for c in normalize(vector))


def field(width, height, f):
    """f(u, v) at the texel centres, as rows from the top."""
    return [[f((x + 0.5) / width, 1 - (y + 0.5) / height) for x in range(width)] for y in range(height)]


def write_gray(name, heights, bits=8):
    write_png(name, len(heights[0]), len(heights), lambda x, y: (heights[y][x],), 1, bits)


def write_normals(name, heights, scale, stretch=lambda y: 1.0):
    """Normals of a height field that repeats along u. `scale`: height of 1 over the texture's width;
    `stretch(row)`: how much shorter a step in u is there than on average."""
    width, height = len(heights[0]), len(heights)

    def pixel(x, y):
        row, above, below = heights[y], heights[max(y - 1, 0)], heights[min(y + 1, height - 1)]
        slope_u = (row[(x + 1) % width] - row[x - 1]) * 0.5 * width * scale * stretch(y)
        slope_v = (above[x] - below[x]) * 0.5 * width * scale
        return encoded((-slope_u, -slope_v, 1))

    write_png(name, width, height, pixel, 3)


def write_radiance(name, size, pixel):
    """A Radiance image (shared exponent, run lengths) of linear colours."""
    def rgbe(rgb):
        high = max(rgb)
        if high < 1e-9:
            return (0, 0, 0, 0)
        mantissa, exponent = math.frexp(high)
        return tuple(int(c * mantissa * 256 / high) for c in rgb) + (exponent + 128,)

    def runs(line):
        out, i = bytearray(), 0
        while i < len(line):
            n = 1
            while i + n < len(line) and n < 127 and line[i + n] == line[i]:
                n += 1
            if n > 3:
                out += bytes((128 + n, line[i]))
            else:
                n = 1
                while i + n < len(line) and n < 128 and line[i + n:i + n + 4].count(line[i + n]) < 4:
                    n += 1
                out += bytes((n,)) + line[i:i + n]
            i += n
        return out

    with open(path_of(name), "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (size, size))
        for y in range(size):
            texels = [rgbe(pixel(x, y)) for x in range(size)]
            file.write(struct.pack(">BBH", 2, 2, size))
            for c in range(4):
                file.write(runs(bytes(t[c] for t in texels)))


def write_ply(name, vertices, quads):
    """vertices: (position, normal, uv); gzipped binary PLY."""
    header = ["ply", "format binary_little_endian 1.0", "element vertex %d" % len(vertices)]
    header += ["property float " + p for p in ("x", "y", "z", "nx", "ny", "nz", "u", "v")]
    header += ["element face %d" % len(quads), "property list uchar int vertex_indices", "end_header", ""]
    body = b"".join(struct.pack("<8f", *p, *n, *uv) for p, n, uv in vertices)
    body += b"".join(struct.pack("<B4i", 4, *q) for q in quads)
    with open(path_of(name), "wb") as file:
        file.write(gzip.compress("\n".join(header).encode() + body, 9, mtime=0))


def write_grid(name, nu, nv, position, uv, close_u):
    """A surface over a grid of nu x nv cells: position(s, t), s and t in [0, 1], with smooth normals by
    finite differences; out of the surface is d/ds x d/dt. With close_u the position repeats in s."""
    vertices, step = [], 1e-4
    for j in range(nv + 1):
        for i in range(nu + 1):
            s, t = i / nu, j / nv
            # At the ends of t, where a surface may come to a point, the normal of a ring close by.
            tn = clamp(t, 2e-3, 1 - 2e-3)
            low, high = (s - step, s + step) if close_u else (max(s - step, 0), min(s + step, 1))
            ds = [b - a for a, b in zip(position(low, tn), position(high, tn))]
            dt = [b - a for a, b in zip(position(s, tn - step), position(s, tn + step))]
            n = (ds[1] * dt[2] - ds[2] * dt[1], ds[2] * dt[0] - ds[0] * dt[2], ds[0] * dt[1] - ds[1] * dt[0])
            vertices.append((position(s, t), normalize(n), uv(s, t)))
    row = nu + 1
    quads = [(j * row + i, j * row + i + 1, (j + 1) * row + i + 1, (j + 1) * row + i)
             for j in range(nv) for i in range(nu)]
    write_ply(name, vertices, quads)


def catmull_rom(points, t):
    """A smooth curve through points of any dimension, t in [0, 1]."""
    span = t * (len(points) - 1)
    i = min(int(span), len(points) - 2)
    f = span - i
    a, b, c, d = (points[clamp(k, 0, len(points) - 1)] for k in (i - 1, i, i + 1, i + 2))
    return tuple(0.5 * (2 * q + (r - p) * f + (2 * p - 5 * q + 4 * r - s) * f * f
                        + (3 * q - p - 3 * r + s) * f ** 3) for p, q, r, s in zip(a, b, c, d))


def write_lathe(name, profile, nu, nv, repeats):
    """The surface of revolution of a profile (r, z), from the foot up. u runs around `repeats` times; v is arc
    length in the same scale, where the body is widest."""
    def position(s, t):
        r, z = catmull_rom(profile, t)
        return (max(r, 0) * math.cos(2 * math.pi * s), max(r, 0) * math.sin(2 * math.pi * s), z)

    lengths = [0.0]
    for k in range(1, 401):
        lengths.append(lengths[-1] + math.dist(catmull_rom(profile, (k - 1) / 400), catmull_rom(profile, k / 400)))
    scale = repeats / (2 * math.pi * max(r for r, _ in profile))
    write_grid(name, nu, nv, position, lambda s, t: (repeats * s, scale * lengths[round(400 * t)]), True)
