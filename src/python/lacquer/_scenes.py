"""Scenes: reading, changing, rendering."""
from __future__ import annotations

import json
import os
import warnings
from dataclasses import dataclass
from typing import Any, Callable, Sequence

import numpy as np

from . import _arguments as check
from . import _lacquer
from ._errors import SceneError, SceneWarning, UsageError
from ._images import Image, Path, Progress, from_native, teller
from ._materials import Material

__all__ = ["RenderResult", "Scene", "load", "parse"]


@dataclass
class RenderResult:
    """What a render gives.

    ``pixels`` has the shape (height, width, channels), float32, linear values, rows from the top; its channels are the
    names in ``names``. ``metadata`` is that of the written image, ``statistics`` what ``--stats-json`` writes.
    """

    pixels: np.ndarray
    names: list[str]
    metadata: dict[str, Any]
    statistics: dict[str, Any]
    warnings: list[str]
    _native: Any
    _half: bool

    @property
    def image(self) -> np.ndarray:
        """Radiance as linear RGB in the colour space of the film, of shape (height, width, 3)."""
        return self.pixels[..., :3]

    @property
    def channels(self) -> dict[str, np.ndarray]:
        """All channels by name, each of shape (height, width): "R", "G", "B", and those of auxiliary outputs."""
        return {name: self.pixels[..., i] for i, name in enumerate(self.names)}

    @property
    def complete(self) -> bool:
        """False if a callback or a time limit came before all samples were taken."""
        return bool(self.statistics["complete"])

    def denoise(self, *, denoiser: str = "nfor",
                progress: Callable[[Progress], object] | None = None) -> RenderResult:
        """A result without the noise, as lacquer.denoise() makes it, whatever was done to ``pixels`` meanwhile.

        render(denoise=True) does both in one go, and needs no ``aov`` for it.

        :raises UsageError: what is missing in the image, or why it will not do.
        """
        native = _lacquer.denoise(self._native, check.denoiser(denoiser), teller(progress))
        image = from_native(native)
        return RenderResult(image.pixels, image.channels, image.metadata, self.statistics, self.warnings, native,
                            self._half)

    def write(self, path: Path, *, half: bool | None = None) -> None:
        """Writes the image as the command line would, whatever was done to ``pixels`` meanwhile.

        :param half: 16-bit floats; None: as the scene says.
        """
        self._native.write(check.path("path", path), self._half if half is None else check.boolean("half", half))


def _warn(texts: Sequence[str]) -> None:
    for text in texts:
        warnings.warn(text, SceneWarning, stacklevel=3)


class Scene:
    """A scene that load() or parse() has read. Rendering does not change it; set() does."""

    def __init__(self, native: Any) -> None:
        if not isinstance(native, _lacquer.ParsedScene):
            raise UsageError("scenes are made by lacquer.load() and lacquer.parse()")
        self._native = native

    def __repr__(self) -> str:
        return f"<lacquer.Scene {self._native.name!r}>"

    @property
    def materials(self) -> dict[str, str]:
        """Names of the materials and their types; "@1", "@2", ... are the unnamed ones in the order of the file."""
        return dict(self._native.materials())

    @property
    def parts(self) -> dict[str, str]:
        """What set() takes beside materials, and of which type it is: camera, film, filter, sampler, integrator,
        accelerator; "light@1", ..., "arealight@1", ..., "shape@1", ... in the order of the file. Shapes in object
        definitions are not among them.
        """
        return dict(self._native.parts())

    def copy(self) -> Scene:
        """A scene that is changed by itself. Costs nothing until then."""
        return Scene(self._native.copy())

    def set(self, target: str, value: Any) -> None:
        """Sets a parameter of a material or of another part of the scene, as ``lacquer compare --vary`` does.

        :param target: "PART.PARAMETER" or "PART.TYPE PARAMETER", where PART is one of ``materials`` or ``parts``:
            "coat.roughness", "paint.rgb reflectance", "camera.fov", "light@1.scale". Without a type it is that which the
            parameter has in the scene; else that of the value: bool, string, integer for whole numbers of film, sampler
            and integrator, float for other numbers.
        :param value: a number, a text, True or False, or several numbers.
        :raises UsageError: for an unknown part, with the nearest name, and for a value that is none of the type.

        That a part knows its parameters is checked when it is built: by render() or material(). Parameters of render(),
        such as ``spp`` and ``resolution``, win over what is set here.
        """
        check.text("target", target)
        if isinstance(value, (bool, np.bool_)):
            text = "true" if value else "false"
        elif isinstance(value, str):
            text = check.text("value", value)
        else:
            numbers = check.numbers("value", value, "a number, a text, or several numbers").ravel()
            whole = np.asarray(value).dtype.kind in "iu"
            text = " ".join(str(int(x)) if whole else _number_text("value", x) for x in numbers)
        self._native.set(target, text, _type_of(target, value))

    def material(self, name: str, *, uv: Sequence[float] = (0.5, 0.5)) -> Material:
        """One of the materials, as the scene is now.

        :param name: one of ``materials``
        :param uv: where its textures are looked up
        :raises SceneError: for an unknown name, with the nearest one.
        """
        point = [check.number("uv", x) for x in check.items("uv", uv, 2, "two numbers")]
        native = _lacquer.SurfaceMaterial(self._native, check.text("name", name), point, check.texture_folders())
        _warn(native.warnings())
        return Material._of_scene(native, name)

    def render(self, *, spp: int | None = None, seed: int | None = None,
               resolution: Sequence[int] | None = None, cropwindow: Sequence[float] | None = None,
               pixelbounds: Sequence[int] | None = None, pixel: Sequence[int] | None = None,
               sample_range: Sequence[int] | None = None, time_limit: float | None = None,
               aov: Sequence[str] = (), cryptomatte_ranks: int = 6, estimator: str | None = None,
               layered_pdf: str | None = None, quick: bool = False, disable_image_textures: bool = False,
               texture_memory: int = 512, nthreads: int = 0, denoise: bool = False, denoiser: str = "nfor",
               progress: Callable[[Progress], object] | None = None, **options: Any) -> RenderResult:
        """Renders the scene: the same bits as the command line, whatever the number of threads.

        Parameters have the names and meanings that ``lacquer render --help`` gives them, with "_" for "-"; None means
        what the scene says.

        :param spp: samples per pixel
        :param seed: of all random numbers
        :param resolution: width and height [pixels]
        :param cropwindow: x0, x1, y0, y1 from 0 to 1, as fractions of the image
        :param pixelbounds: x0, x1, y0, y1 [pixels]
        :param pixel: x, y: this one only
        :param sample_range: first sample and the one behind the last
        :param time_limit: of rendering [s]
        :param aov: auxiliary outputs, more entries of ``channels`` (docs/aovs.md)
        :param estimator: of every layered material
        :param layered_pdf: density of every layered material
        :param texture_memory: for image textures [MiB]
        :param nthreads: 0: all processors
        :param denoise: removes the noise after the render; a render that was stopped keeps what denoise() of the result
            needs
        :param denoiser: "nfor", our own, or "oidn", Intel Open Image Denoise, where Lacquer was built with it
        :param progress: called some fifty times a second with a Progress, on the calling thread. If it returns False,
            the render stops, and the result holds the samples so far. If it raises, the exception goes on to the caller.
        :param options: the other options of scenes: disable_pixel_jitter, disable_wavelength_jitter,
            disable_texture_filtering, displacement_edge_scale, force_diffuse, render_coord_sys
        :raises SceneError: the scene is wrong; with all problems and their places
        :raises UsageError: a parameter is

        Other threads of Python run meanwhile. Ctrl-C stops the render and raises KeyboardInterrupt. Renders of several
        threads wait for each other, since each of them uses all processors.
        """
        request = _lacquer.RenderRequest()
        if seed is not None:
            options["seed"] = check.integer("seed", seed, -(1 << 31), (1 << 31) - 1)
        for name in options:
            known = [*_lacquer.options(), *_RENDER_PARAMETERS]
            if name not in known:
                raise UsageError(f"render() has no parameter {check.shown(name)}{_lacquer.did_you_mean(name, known)}")
        request.options = options
        if spp is not None:
            request.spp = check.integer("spp", spp, 1, 1 << 24)
        if resolution is not None:
            request.resolution = _integers("resolution", resolution, 2, "width and height", 1, check.MAX_SIDE)
        _set_part(request, cropwindow, pixelbounds, pixel)
        if sample_range is not None:
            request.sample_range = _integers("sample_range", sample_range, 2, "first and end", 0, 1 << 24)
            if not request.sample_range[0] < request.sample_range[1]:
                raise UsageError(f"sample_range: expected first < end, not {check.shown(sample_range)}")
        if time_limit is not None:
            request.time_limit = check.number("time_limit", time_limit)
            if not request.time_limit > 0:
                raise UsageError(f"time_limit: expected a positive number of seconds, not {time_limit}")
        if isinstance(aov, str):
            aov = [name for name in aov.split(",") if name]
        request.aovs = [_aov(name) for name in aov or ()]
        request.cryptomatte_ranks = check.integer("cryptomatte_ranks", cryptomatte_ranks, 2, 64)
        if request.cryptomatte_ranks % 2:
            raise UsageError(f"cryptomatte_ranks: expected an even number, not {cryptomatte_ranks}")
        if estimator is not None:
            request.estimator = check.choice("estimator", estimator, _lacquer.estimators())
        if layered_pdf is not None:
            request.layered_pdf = check.choice("layered_pdf", layered_pdf, _lacquer.layered_pdfs())
        request.quick = check.boolean("quick", quick)
        request.disable_image_textures = check.boolean("disable_image_textures", disable_image_textures)
        request.textures = check.texture_folders(check.integer("texture_memory", texture_memory, 16, 1 << 20))
        request.threads = check.integer("nthreads", nthreads, 0, 1024)
        request.denoise = check.boolean("denoise", denoise)
        request.denoiser = check.denoiser(denoiser)
        native, statistics, messages, half = self._native.render(request, teller(progress))
        image: Image = from_native(native)
        _warn(messages)
        return RenderResult(image.pixels, image.channels, image.metadata, json.loads(statistics), messages, native,
                            half)


_RENDER_PARAMETERS = [name for name in Scene.render.__kwdefaults__ or {}]


def _aov(name: Any) -> str:
    if isinstance(name, str) and name.startswith("lpe:"):
        return name  # its expression is read when the scene's light groups are known
    return check.choice("aov", name, _lacquer.aovs())


def _type_of(target: str, value: Any) -> str:
    """Of a parameter whose type neither the target nor the scene tells."""
    if isinstance(value, (bool, np.bool_)):
        return "bool"
    if isinstance(value, str):
        return "string"
    counts = target.split(".")[0] in ("film", "sampler", "integrator")
    return "integer" if counts and np.asarray(value).dtype.kind in "iu" else "float"


def _number_text(name: str, value: Any) -> str:
    return repr(float(np.float32(check.number(name, value))))


def _integers(name: str, value: Any, count: int, what: str, low: int, high: int) -> list[int]:
    return [check.integer(name, x, low, high) for x in check.items(name, value, count, what)]


def _set_part(request: Any, cropwindow: Any, pixelbounds: Any, pixel: Any) -> None:
    """Which part of the image is asked for; a pixel wins over bounds, as on the command line."""
    if cropwindow is not None:
        crop = [check.number("cropwindow", x) for x in check.items("cropwindow", cropwindow, 4, "x0, x1, y0, y1")]
        if not all(0 <= x <= 1 for x in crop):
            raise UsageError(f"cropwindow: expected x0, x1, y0, y1 from 0 to 1, not {check.shown(cropwindow)}")
        request.crop_window = crop
    high = check.MAX_SIDE - 1
    if pixelbounds is not None:
        request.pixel_bounds = _integers("pixelbounds", pixelbounds, 4, "x0, x1, y0, y1", -(1 << 30), 1 << 30)
    if pixel is not None:
        x, y = _integers("pixel", pixel, 2, "x, y", 0, high)
        request.pixel_bounds = [x, x + 1, y, y + 1]


def load(path: Path | Sequence[Path]) -> Scene:
    """Reads a scene file (.pbrt, .pbrt.gz), or several that count as one scene.

    Files that it names (meshes, textures) are opened by render() and material().

    :raises SceneError: with everything that is wrong, and the places
    :raises FileError: if a file cannot be read
    """
    several = not isinstance(path, (str, bytes, os.PathLike))
    try:
        paths = [check.path("path", p) for p in path] if several else [check.path("path", path)]  # type: ignore
    except TypeError:
        raise UsageError(f"path: expected a path or several, not {check.shown(path)}") from None
    if not paths:
        raise UsageError("path: expected at least one")
    native = _lacquer.load(paths)
    _warn(native.warnings)
    return Scene(native)


def parse(text: str, folder: Path = "", *, name: str = "<string>") -> Scene:
    """Reads a scene from a text.

    :param folder: where relative paths are looked for; "": in the current directory
    :param name: of the text in messages
    """
    if check.text("text", text).strip() == "":
        raise SceneError(f"{name}: error: the text holds no scene", [(name, 0, 0, "the text holds no scene")])
    native = _lacquer.parse(text, check.text("name", name), check.path("folder", folder) if folder != "" else "")
    _warn(native.warnings)
    return Scene(native)
