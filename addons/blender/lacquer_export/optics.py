"""Formulas between what Blender's parameters mean and what interfaces of a stack take."""
import math


def eta_of_f0(f0):
    """Relative index of a dielectric that reflects f0 at normal incidence."""
    root = math.sqrt(min(max(f0, 0.0), 0.98))
    return (1 + root) / (1 - root)


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
