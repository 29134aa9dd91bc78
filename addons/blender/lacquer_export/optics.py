"""Formulas between what Blender's parameters mean and what interfaces of a stack take."""
import math


def eta_of_f0(f0):
    """Relative index of a dielectric that reflects f0 at normal incidence."""
    root = math.sqrt(min(max(f0, 0.0), 0.98))
    return (1 + root) / (1 - root)


def metal_k(color, eta):
    """The k of a conductor of index eta that reflects `color` at normal incidence under a medium of this index.

    Index and k are divided by that of the medium, so the relative index is 1, and color = k^2 / (4 eta^2 + k^2). Takes numbers and
    arrays.
    """
    color = color.clip(0, 0.9999) if hasattr(color, "clip") else min(max(color, 0.0), 0.9999)
    return 2 * eta * (color / (1 - color)) ** 0.5


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
