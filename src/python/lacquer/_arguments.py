"""Checks of arguments: each gives what the native part takes, or raises a UsageError that says what was expected."""
from __future__ import annotations

import math
import operator
import os
import tempfile
from typing import Any, Iterable, Sequence

import numpy as np

from . import _lacquer
from ._errors import UsageError

MAX_SIDE = 1 << 16
MAX_SAMPLES = 1 << 40


def shown(value: Any) -> str:
    """A value in messages, of bounded length."""
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def unknown(name: str, known: Iterable[str]) -> str:
    known = list(known)
    return f"unknown {shown(name)}{_lacquer.did_you_mean(str(name), known)} (known: {', '.join(known)})"


def integer(name: str, value: Any, low: int, high: int) -> int:
    try:
        if isinstance(value, (bool, np.bool_)):
            raise TypeError
        number = operator.index(value)
    except TypeError:
        raise UsageError(f"{name}: expected an integer, not {shown(value)}") from None
    if not low <= number <= high:
        raise UsageError(f"{name}: expected an integer from {low} to {high}, not {number}")
    return number


def number(name: str, value: Any) -> float:
    try:
        if isinstance(value, (str, bytes, bool, np.bool_)):
            raise TypeError
        result = float(value)
    except (TypeError, ValueError, OverflowError):
        raise UsageError(f"{name}: expected a number, not {shown(value)}") from None
    if not math.isfinite(result):
        raise UsageError(f"{name}: expected a finite number, not {result}")
    return result


def boolean(name: str, value: Any) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise UsageError(f"{name}: expected True or False, not {shown(value)}")
    return bool(value)


def text(name: str, value: Any) -> str:
    if not isinstance(value, str):
        raise UsageError(f"{name}: expected a text, not {shown(value)}")
    try:
        value.encode()
    except UnicodeEncodeError:
        raise UsageError(f"{name}: {shown(value)} is no valid Unicode") from None
    return value


def choice(name: str, value: Any, known: Iterable[str]) -> str:
    known = list(known)
    if not isinstance(value, str) or value not in known:
        raise UsageError(f"{name}: {unknown(value, known)}")
    return value


def denoiser(value: Any) -> str:
    reasons = dict(_lacquer.denoisers())
    name = choice("denoiser", value, reasons)
    if reasons[name]:
        raise UsageError(f"denoiser: {shown(name)} cannot be had: {reasons[name]}")
    return name


def callback(value: Any) -> Any:
    if value is not None and not callable(value):
        raise UsageError(f"progress: expected something that can be called, not {shown(value)}")
    return value


def path(name: str, value: Any) -> str:
    try:
        result = os.fsdecode(os.fspath(value))
    except TypeError:
        raise UsageError(f"{name}: expected a path, not {shown(value)}") from None
    if "\0" in result:
        raise UsageError(f"{name}: a path has no zero byte")
    try:
        return text(name, result)
    except UsageError:
        raise UsageError(f"{name}: the path {shown(value)} is no valid UTF-8") from None


def items(name: str, value: Any, count: int, what: str) -> Sequence[Any]:
    try:
        if isinstance(value, (str, bytes)):
            raise TypeError
        result = list(value)
    except TypeError:
        raise UsageError(f"{name}: expected {what}, not {shown(value)}") from None
    if len(result) != count:
        raise UsageError(f"{name}: expected {what}, not {shown(value)}")
    return result


def numbers(name: str, value: Any, what: str) -> np.ndarray:
    """An array of float64 of whatever shape; finite or not."""
    try:
        array = np.asarray(value)
        if array.dtype.kind == "O" or (array.size == 0 and array.dtype.kind == "f"):
            array = array.astype(np.float64)
        if array.dtype.kind not in "fiu":
            raise TypeError
        return array.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        raise UsageError(f"{name}: expected {what}, not {shown(value)}") from None


def directions(name: str, value: Any) -> np.ndarray:
    """Unit vectors of float64 in an array of shape (..., 3)."""
    array = numbers(name, value, "an array of numbers of shape (..., 3)")
    if array.ndim < 1 or array.shape[-1] != 3:
        raise UsageError(f"{name}: expected an array of shape (..., 3), not {array.shape}")
    # Scaled first, so that neither huge nor tiny vectors lose their length.
    largest = np.max(np.abs(array), axis=-1, keepdims=True) if array.size else np.ones(array.shape[:-1] + (1,))
    bad = ~(np.isfinite(largest[..., 0]) & (largest[..., 0] > 0))
    if np.any(bad):
        index = tuple(int(i) for i in np.argwhere(bad)[0])
        where = f"[{', '.join(map(str, index))}]" if index else ""
        raise UsageError(f"{name}{where}: {array[index].tolist()} is no direction: "
                         "expected finite numbers that are not all 0")
    array = array / largest
    return array / np.linalg.norm(array, axis=-1, keepdims=True)


def rows(array: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Directions as the native part takes them: rows of three float32."""
    return np.ascontiguousarray(np.broadcast_to(array, shape + (3,)).reshape(-1, 3), dtype=np.float32)


def pairs(wo: Any, wi: Any) -> tuple[np.ndarray, np.ndarray, tuple[int, ...]]:
    """Two arrays of directions by the rules of broadcasting, and the shape of the result without the last axis."""
    o, i = directions("wo", wo), directions("wi", wi)
    try:
        shape = np.broadcast_shapes(o.shape[:-1], i.shape[:-1])
    except ValueError:
        raise UsageError(f"wo and wi: the shapes {o.shape} and {i.shape} do not fit together") from None
    return rows(o, shape), rows(i, shape), shape


def wavelengths(value: Any) -> list[float]:
    """[nm]; empty for None."""
    if value is None:
        return []
    array = numbers("wavelengths", value, "wavelengths in nanometres")
    if array.ndim != 1 or array.size < 1:
        raise UsageError(f"wavelengths: expected an array of one axis and at least one number, not {array.shape}")
    if not np.all((array >= 360) & (array <= 830)):
        raise UsageError("wavelengths: expected numbers from 360 to 830 nm")
    return [float(x) for x in array]


def texture_folders(megabytes: int = 512) -> tuple[int, str, str]:
    """Memory for image textures, and folders for those beyond it, as the command line chooses them."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    if not os.path.isabs(base):
        base = os.path.join(os.environ.get("HOME", ""), ".cache")
    cache = os.path.join(base, "lacquer", "textures") if os.path.isabs(base) else ""
    return megabytes, cache, tempfile.gettempdir()
