"""Images in arrays and in files."""
from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Any, Callable, Mapping, NamedTuple, Sequence, Union

import numpy as np

from . import _arguments as check
from . import _lacquer
from ._errors import UsageError

__all__ = ["Image", "Progress", "denoise", "read_image", "write_image"]

Path = Union[str, "os.PathLike[str]"]


class Progress(NamedTuple):
    """What a progress callback hears: ``done`` of ``total`` units of the work ``stage``."""

    stage: str
    done: int
    total: int

    @property
    def fraction(self) -> float:
        """From 0 to 1."""
        return self.done / self.total if self.total > 0 else 0.0


def teller(progress: Callable[[Progress], object] | None) -> Any:
    """What the native part calls, of what a user has given."""
    check.callback(progress)
    return None if progress is None else lambda *state: progress(Progress(*state))


@dataclass
class Image:
    """An image: ``pixels`` of shape (height, width, channels), float32, linear values, rows from the top.

    ``channels`` are the names of the last axis ("R", "G", "B", ...). ``metadata`` has texts, integers, numbers, lists of
    numbers, and matrices of shape (4, 4) that act on column vectors.
    """

    pixels: np.ndarray
    channels: list[str]
    metadata: dict[str, Any] = field(default_factory=dict)

    def __getitem__(self, channel: str) -> np.ndarray:
        """One channel by its name, of shape (height, width)."""
        name = check.choice("channel", channel, self.channels)
        return self.pixels[..., self.channels.index(name)]

    def write(self, path: Path, *, half: bool = False) -> None:
        """As write_image()."""
        write_image(path, self.pixels, channels=self.channels, metadata=self.metadata, half=half)

    def denoise(self, *, denoiser: str = "nfor", progress: Callable[[Progress], object] | None = None) -> Image:
        """As lacquer.denoise()."""
        return denoise(self, denoiser=denoiser, progress=progress)


def from_native(native: Any) -> Image:
    return Image(native.array(), list(native.channels()), native.metadata())


def read_image(path: Path, *, encoding: str = "sRGB") -> Image:
    """Reads an image file: EXR, PNG, JPEG, HDR, PFM, PPM, TIFF, BMP, GIF, WebP or TGA.

    :param encoding: of 8- and 16-bit PNG files: "sRGB", "linear" or "gamma x". Other 8-bit formats always are sRGB,
        everything else is linear. Values come out linear.
    :raises FileError: if the file cannot be read or is damaged.
    """
    return from_native(_lacquer.read_image(check.path("path", path), check.text("encoding", encoding)))


def write_image(path: Path, pixels: Any, *, channels: Sequence[str] | None = None,
                metadata: Mapping[str, Any] | None = None, half: bool = False) -> None:
    """Writes an image; the extension of the name chooses the format.

    The file is written under a temporary name and then renamed: a failure leaves what was there.

    :param pixels: linear values, of shape (height, width) or (height, width, channels), rows from the top. 8-bit formats
        get sRGB values clamped to [0, 1].
    :param channels: names; default "Y" for one channel, "R", "G", "B" for three, and "A" behind them for four.
    :param metadata: of EXR files, as Image has it.
    :param half: 16-bit floats where the format has them.
    :raises FileError: for an unknown extension, a missing folder, a full disk.
    """
    native = _native_image(pixels, channels, metadata)
    native.write(check.path("path", path), check.boolean("half", half))


def denoise(image: Image, *, denoiser: str = "nfor",
            progress: Callable[[Progress], object] | None = None) -> Image:
    """An image without the noise of its render, as ``lacquer denoise`` makes it.

    :param image: with the channels of ``aov=["half", "variance", "albedo", "normal", "depth"]``; "oidn" needs albedo and
        normal only
    :param denoiser: "nfor", our own, or "oidn", Intel Open Image Denoise, where Lacquer was built with it
    :param progress: called with a Progress now and then; what it raises goes on to the caller
    :return: a new image with all channels but those of the halves; it cannot be denoised again.
    :raises UsageError: what is missing in the image, or why it will not do.
    """
    if not isinstance(image, Image):
        raise UsageError(f"image: expected a lacquer.Image, not {check.shown(image)}")
    native = _native_image(image.pixels, image.channels, image.metadata)
    return from_native(_lacquer.denoise(native, check.denoiser(denoiser), teller(progress)))


def _native_image(pixels: Any, channels: Sequence[str] | None, metadata: Mapping[str, Any] | None) -> Any:
    array = check.numbers("pixels", pixels, "an array of numbers of shape (height, width) or (height, width, channels)")
    if array.ndim == 2:
        array = array[..., np.newaxis]
    if array.ndim != 3 or 0 in array.shape:
        raise UsageError("pixels: expected an array of shape (height, width) or (height, width, channels), "
                         f"none of them 0, not {np.shape(pixels)}")
    if channels is None:
        names = {1: ["Y"], 3: ["R", "G", "B"], 4: ["R", "G", "B", "A"]}.get(array.shape[2])
        if names is None:
            raise UsageError(f"channels: expected {array.shape[2]} names")
    else:
        names = [check.text("channels", name) for name in
                 check.items("channels", channels, array.shape[2], f"{array.shape[2]} names")]
        if len(set(names)) != len(names) or "" in names:
            raise UsageError("channels: expected names that differ and are not empty")
    with np.errstate(over="ignore"):
        values = array.astype(np.float32)
    return _lacquer.Image(values, names, {check.text("metadata", k): v for k, v in (metadata or {}).items()})
