"""Colours as laboratories write them."""
from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _lacquer

# From linear sRGB to XYZ, where white has Y = 1 [IEC 61966-2-1].
_XYZ_FROM_RGB = np.array([[0.4123908, 0.3575843, 0.1804808], [0.2126390, 0.7151687, 0.0721923], [0.0193308, 0.1191948, 0.9505322]])
_WHITE = _XYZ_FROM_RGB.sum(axis=1)


def lab(rgb: Any) -> NDArray[np.float64]:
    """CIE L*a*b* under D65 of linear sRGB reflectances, (..., 3) both; white, (1, 1, 1), is (100, 0, 0)."""
    rgb = np.asarray(rgb, dtype=float)
    if rgb.shape[-1:] != (3,):
        raise ValueError(f"colours have the shape {rgb.shape}; expected (..., 3)")
    xyz = rgb @ _XYZ_FROM_RGB.T
    return np.array([_lacquer.lab(*v, list(_WHITE)) for v in xyz.reshape(-1, 3)]).reshape(rgb.shape)


def delta_e2000(a: Any, b: Any) -> NDArray[np.float64]:
    """Colour difference CIEDE2000 of L*a*b* colours, (..., 3) both, by numpy's rules of broadcasting; about 1 is the least that is seen."""
    a, b = np.broadcast_arrays(np.asarray(a, dtype=float), np.asarray(b, dtype=float))
    if a.shape[-1:] != (3,):
        raise ValueError(f"colours have the shape {a.shape}; expected (..., 3)")
    pairs = zip(a.reshape(-1, 3).tolist(), b.reshape(-1, 3).tolist())
    return np.array([_lacquer.delta_e2000(x, y) for x, y in pairs]).reshape(a.shape[:-1])
