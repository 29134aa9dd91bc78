"""Formulas between what Blender's parameters mean and what interfaces of a stack take."""
import math


def fresnel(cosine, eta):
    """Reflectance of a smooth dielectric, unpolarised; eta is the index behind over the one in front."""
    sine2 = (1 - cosine * cosine) / (eta * eta)
    if sine2 >= 1:
        return 1.0
    inner = math.sqrt(1 - sine2)
    parallel = (eta * cosine - inner) / (eta * cosine + inner)
    perpendicular = (cosine - eta * inner) / (cosine + eta * inner)
    return (parallel * parallel + perpendicular * perpendicular) / 2


def mean_fresnel(eta, steps=256):
    """Reflectance for diffuse light, the integral of 2 cos F over the cosine, by the midpoint rule."""
    nodes = [(i + 0.5) / steps for i in range(steps)]
    return sum(2 * c * fresnel(c, eta) for c in nodes) / steps


def mean_fresnel_below(eta):
    """The same from below: what enters leaves, so 1 - F_below = (1 - F_above) / eta^2."""
    return 1 - (1 - mean_fresnel(eta)) / (eta * eta)


def reflectance_from_below(etas):
    """Reflectance for diffuse light that meets interfaces from below; etas are relative indices, outermost first."""
    above = below = 0.0
    for eta in etas:
        f_above, f_below = mean_fresnel(eta), mean_fresnel_below(eta)
        among = 1 - below * f_above
        above, below = (above + (1 - above) * f_above * (1 - below) / among,
                        f_below + (1 - f_below) * below * (1 - f_above) / among)
    return below


def eta_of_f0(f0):
    """Relative index of a dielectric that reflects f0 at normal incidence."""
    root = math.sqrt(min(max(f0, 0.0), 0.98))
    return (1 + root) / (1 - root)


def base_reflectance(color, below):
    """Reflectance of a diffuse base such that what leaves it, over a white base, is `color`.

    Of the light that leaves the base `below` comes back from the interfaces: color = r (1 - below) / (1 - below r). This is
    Saunderson's correction, solved for r. Works for numbers and for arrays.
    """
    return color / (1 - below * (1 - color))


def metal_reflectance_under(color, eta):
    """The "reflectance" of a conductor that reflects `color` at normal incidence under a medium of index eta.

    A conductor with a reflectance R has the index 1 and k^2 = 4 R / (1 - R); under a coat both are divided by its index:
    color = ((1 - eta)^2 + k^2) / ((1 + eta)^2 + k^2). Less than F0 of index 1 over eta there is not: 0 then.
    """
    color = color.clip(0, 0.9999) if hasattr(color, "clip") else min(max(color, 0.0), 0.9999)
    k2 = (color * (1 + eta) ** 2 - (1 - eta) ** 2) / (1 - color)
    k2 = k2.clip(0) if hasattr(k2, "clip") else max(k2, 0.0)
    return k2 / (4 + k2)


def anisotropic_alphas(roughness, anisotropy):
    """alpha along the tangent and across it, of Principled's roughness: [Burley 2012]."""
    aspect = math.sqrt(1 - 0.9 * min(max(anisotropy, 0.0), 1.0))
    return roughness * roughness / aspect, roughness * roughness * aspect


def luminance(color):
    """Of linear sRGB, as Blender turns colours into numbers."""
    return 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]


def srgb_to_linear(values):
    """Arrays of encoded values in [0, 1]."""
    import numpy as np
    return np.where(values <= 0.04045, values / 12.92, ((np.maximum(values, 0) + 0.055) / 1.055) ** 2.4)
