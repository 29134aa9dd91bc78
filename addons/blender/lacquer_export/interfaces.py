"""What rough interfaces do to diffuse light from below: a random walk through them, with the BSDF that the renderer has.

Interfaces are (relative index, alpha), outermost first: GGX with single scattering, so that some light is lost between facets.
"""
from functools import lru_cache

import numpy as np

NUM_PATHS = 1 << 15
MAX_EVENTS = 60
SMOOTH = 1e-3


def visible_normals(w, alpha, u, v):
    """Facets seen from w (n, 3), z > 0: [Heitz 2018]."""
    stretched = w * [alpha, alpha, 1]
    stretched /= np.linalg.norm(stretched, axis=1, keepdims=True)
    length2 = stretched[:, 0] ** 2 + stretched[:, 1] ** 2
    root = np.sqrt(np.maximum(length2, 1e-20))
    across = np.stack([-stretched[:, 1] / root, stretched[:, 0] / root, 0 * root], axis=1)
    across[length2 < 1e-14] = (1, 0, 0)
    other = np.cross(stretched, across)
    radius, phi = np.sqrt(u), 2 * np.pi * v
    x, y = radius * np.cos(phi), radius * np.sin(phi)
    s = (1 + stretched[:, 2]) / 2
    y = (1 - s) * np.sqrt(np.maximum(1 - x * x, 0)) + s * y
    z = np.sqrt(np.maximum(1 - x * x - y * y, 0))
    normal = x[:, None] * across + y[:, None] * other + z[:, None] * stretched
    normal = np.stack([alpha * normal[:, 0], alpha * normal[:, 1], np.maximum(normal[:, 2], 1e-9)], axis=1)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def smith_lambda(w, alpha):
    cosine2 = np.maximum(w[:, 2] ** 2, 1e-12)
    return (np.sqrt(1 + alpha * alpha * (1 - cosine2) / cosine2) - 1) / 2


def scatter(w, eta, alpha, rng):
    """Light that arrives from w (z > 0 on its side), eta behind over before: where it goes, and its weight, 0 where it is lost."""
    n = len(w)
    normal = np.tile([0.0, 0.0, 1.0], (n, 1)) if alpha < SMOOTH else visible_normals(w, alpha, rng.random(n), rng.random(n))
    cosine = np.sum(w * normal, axis=1)
    inner2 = 1 - (1 - cosine ** 2) / (eta * eta)
    inner = np.sqrt(np.maximum(inner2, 0))
    parallel = (eta * cosine - inner) / (eta * cosine + inner)
    perpendicular = (cosine - eta * inner) / (cosine + eta * inner)
    reflectance = np.where(inner2 > 0, (parallel ** 2 + perpendicular ** 2) / 2, 1.0)
    is_reflected = rng.random(n) < reflectance
    out = np.where(is_reflected[:, None], 2 * cosine[:, None] * normal - w,
                   (cosine / eta - inner)[:, None] * normal - w / eta)
    weight = np.where((out[:, 2] > 0) == is_reflected, 1.0, 0.0)
    if alpha >= SMOOTH:
        seen, lit = smith_lambda(w, alpha), smith_lambda(out, alpha)
        weight *= (1 + seen) / (1 + seen + lit)
    return out, weight


@lru_cache(maxsize=None)
def from_below(interfaces):
    """(returned, escaped): parts of diffuse light from below the last interface that come back down, and that get out."""
    rng = np.random.default_rng(1)
    radius, phi = np.sqrt(rng.random(NUM_PATHS)), 2 * np.pi * rng.random(NUM_PATHS)
    travel = np.stack([radius * np.cos(phi), radius * np.sin(phi), np.sqrt(1 - radius ** 2)], axis=1)
    place = np.full(NUM_PATHS, len(interfaces))  # the medium; 0 is outside
    weight = np.ones(NUM_PATHS)
    returned = escaped = 0.0
    for _ in range(MAX_EVENTS):
        rising = travel[:, 2] > 0
        met = np.where(rising, place - 1, place)
        for k, (eta, alpha) in enumerate(interfaces):
            for is_rising in (True, False):
                chosen = np.flatnonzero((met == k) & (rising == is_rising))
                if not len(chosen):
                    continue
                flip = np.array([1, 1, -1 if is_rising else 1])
                out, factor = scatter(-travel[chosen] * flip, 1 / eta if is_rising else eta, alpha, rng)
                passed = out[:, 2] < 0
                travel[chosen] = out * flip
                weight[chosen] *= factor
                place[chosen] += passed * (-1 if is_rising else 1)
        out = (place == 0) & (travel[:, 2] > 0)
        down = (place == len(interfaces)) & (travel[:, 2] < 0)
        escaped += weight[out].sum()
        returned += weight[down].sum()
        left = ~(out | down) & (weight > 0)
        travel, place, weight = travel[left], place[left], weight[left]
        if not len(weight):
            break
    return returned / NUM_PATHS, escaped / NUM_PATHS


@lru_cache(maxsize=None)
def color_correction(interfaces, is_lossless=False):
    """(gain, returned, escaped) for base_reflectance(): gain is what rough interfaces lose of the light that enters.

    `is_lossless`: the interfaces have all orders of scattering. From above little light is lost between facets, and that is
    taken to go where the rest goes; from below it follows by reciprocity, for diffuse light: escaped = entered / index^2.
    """
    if is_lossless:
        reflected, entered = from_below(tuple((1 / eta, alpha) for eta, alpha in reversed(interfaces)))
        escaped = entered / (reflected + entered) / np.prod([eta for eta, _ in interfaces]) ** 2
        return 1.0, 1 - escaped, escaped
    returned, escaped = from_below(interfaces)
    _, smooth = from_below(tuple((eta, 0.0) for eta, _ in interfaces))
    return smooth / escaped, returned, escaped


def base_reflectance(color, correction):
    """Reflectance of a diffuse base such that what leaves the stack, over a white one without losses, is `color`.

    Of the light that leaves the base `returned` comes back and `escaped` gets out: color = r escaped / (1 - r returned) / gain.
    Without losses that is Saunderson's correction, solved for r. More than 1 there is not. Takes numbers and arrays.
    """
    gain, returned, escaped = correction
    color = color * gain
    return np.minimum(color / (escaped + color * returned), 1.0)
