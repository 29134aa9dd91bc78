"""What scripts/figures-bulk does to tables of `lacquer bulk`: fewer angles, and a medium's coefficients from those of a ball of it."""
import bisect
import math
import random


def legendre(cosine, degree):
    """P_0 ... P_degree."""
    values = [1.0, cosine]
    for n in range(2, degree + 1):
        values.append(((2 * n - 1) * cosine * values[-1] - (n - 1) * values[-2]) / n)
    return values


def cosines(angles):
    return [math.cos(math.radians(a)) for a in angles]


def norm(angles, p):
    """2 pi times the integral over the cosine, linear in it between angles."""
    c = cosines(angles)
    return math.pi * sum((p[i] + p[i + 1]) * (c[i] - c[i + 1]) for i in range(len(c) - 1))


def moments(angles, p, degree):
    """Means of P_0 ... P_degree over p, and 1 for the first one. Two points a step suffice at a degree each."""
    c, sums = cosines(angles), [0.0] * (degree + 1)
    for i in range(len(c) - 1):
        for t in (0.2113248654, 0.7886751346):
            weight = math.pi * (c[i] - c[i + 1]) * (p[i] + t * (p[i + 1] - p[i]))
            for n, value in enumerate(legendre(c[i] + t * (c[i + 1] - c[i]), degree)):
                sums[n] += weight * value
    return [s / sums[0] for s in sums]


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


# ---- From a ball to the medium that it was cut from ----
#
# The mode "medium" gives the light that a ball of the medium scatters beside its mean field. Where the ball is thick that light was
# scattered several times on its way out, and the ball shadows itself: C_sca over volume depends on the size. But energy is conserved:
# C_sca is all that the mean field loses, which for rays through a ball of radius R and of optical thickness t across its middle is
# pi R^2 lost_share(t). Solved for t it gives sigma_s. Random walks in such a ball give the shares of light that was scattered once,
# twice, ..., and with them the moments of p: those of light that was scattered n times are n-th powers, nearly. Without absorption.


def lost_share(t):
    """Of what falls on a ball of optical thickness t across its middle."""
    return 2 * t / 3 if t < 1e-3 else 1 - 2 * (1 - (1 + t) * math.exp(-t)) / (t * t)


def solve(function, value, low, high):
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if function(middle) < value else (low, middle)
    return (low + high) / 2


def cosine_sampler(angles, p):
    c, cdf = cosines(angles), [0.0]
    for i in range(len(c) - 1):
        cdf.append(cdf[-1] + (c[i] - c[i + 1]) * (p[i] + p[i + 1]) / 2)

    def sample(rng):
        x = rng.random() * cdf[-1]
        i = min(bisect.bisect_right(cdf, x), len(c) - 1) - 1
        return c[i] + (c[i + 1] - c[i]) * (x - cdf[i]) / (cdf[i + 1] - cdf[i])

    return sample


def turned(d, cosine, azimuth):
    """A direction at that angle to the unit vector d."""
    x, y, z = d
    sign = 1.0 if z >= 0 else -1.0
    a = -1 / (sign + z)
    b, sine = x * y * a, math.sqrt(max(0.0, 1 - cosine * cosine))
    u, v = sine * math.cos(azimuth), sine * math.sin(azimuth)
    return (u * (1 + sign * x * x * a) + v * b + cosine * x, u * sign * b + v * (sign + y * y * a) + cosine * y,
            -u * sign * x - v * y + cosine * z)


def orders(thickness, sample, degree, walks=30000, seed=1):
    """Of the light that a ball scatters: the shares that it scatters once, twice, ..., and the moments of the direction in which it
    leaves."""
    rng, counts, sums = random.Random(seed), {}, [0.0] * (degree + 1)
    for _ in range(walks):
        b = math.sqrt(rng.random())
        half = math.sqrt(1 - b * b)
        # What passes through is not followed.
        weight = -math.expm1(-half * thickness)
        t = -2 / thickness * math.log1p(-weight * rng.random())
        p, d, n = (b, 0.0, t - half), (0.0, 0.0, 1.0), 0
        while n < 200 and sum(q * q for q in p) <= 1:
            n += 1
            d = turned(d, sample(rng), 2 * math.pi * rng.random())
            t = -2 * math.log(1 - rng.random()) / thickness
            p = tuple(q + t * e for q, e in zip(p, d))
        counts[n] = counts.get(n, 0) + weight
        sums = [s + weight * value for s, value in zip(sums, legendre(d[2], degree))]
    total = sum(counts.values())
    return {n: count / total for n, count in counts.items()}, [s / total for s in sums]


def of_medium(sigma, angles, p, ball_radius, particle_radius, degree=16):
    """(sigma_s, p, optical thickness of the ball) of the medium, from those of the ball.
    @param ball_radius  that the centres are in, as `sigma` counts its volume; particles reach farther by their own radius"""
    reach = ball_radius + particle_radius
    share = sigma * 4 / 3 * ball_radius ** 3 / (reach * reach)
    if share > 0.97:
        raise ValueError("the ball lets no light through: take fewer particles")
    thickness = solve(lost_share, share, 0, 50)
    measured, rows, found = moments(angles, p, degree), [legendre(c, degree) for c in cosines(angles)], p
    for _ in range(4):
        shares, leaving = orders(thickness, cosine_sampler(angles, found), degree)

        def powers(y):
            return sum(s * y ** n for n, s in shares.items())

        # What leaves is a little more forward than the powers, which do not know where it leaves.
        once = []
        for n, y in enumerate(moments(angles, found, degree)):
            wanted = measured[n] - (leaving[n] - powers(y))
            once.append(solve(powers, wanted, *((0, 1) if wanted > 0 else (-1, 0))))
        rise = [(2 * n + 1) / (4 * math.pi) * (y - m) for n, (y, m) in enumerate(zip(once, measured))]
        found = [max(0.0, v + sum(a * b for a, b in zip(rise[1:], row[1:]))) for v, row in zip(p, rows)]
        scale = norm(angles, found)
        found = [v / scale for v in found]
    return thickness / (2 * reach) * (reach / ball_radius) ** 3, found, thickness


def table_of_medium(table, ball_radius, particle_radius):
    """A table of the mode "medium" with coefficients of the medium; lengths of both radii in um. Second: optical thicknesses."""
    new, thicknesses = dict(table, sigma_s=[], phase=[], g=[]), []
    del new["standard_error"]  # of the ball
    new["made"] = dict(table["made"], then="from the ball to the medium: scripts/bulk_tables.py")
    for sigma, p in zip(table["sigma_s"], table["phase"]):
        sigma, p, thickness = of_medium(sigma / 1000, table["angles"], p, ball_radius, particle_radius)
        new["sigma_s"].append(float("%.9g" % (sigma * 1000)))
        new["phase"].append(p)
        new["g"].append(float("%.9g" % moments(table["angles"], p, 1)[1]))
        thicknesses.append(thickness)
    return new, thicknesses
