"""Materials: made here or taken from scenes, evaluated over arrays of directions.

Directions are arrays of shape (..., 3) in the local frame, z along the normal, both away from the surface: wo to the
camera, wi to the light. They need not be normalised. z < 0 is below the surface.
"""
from __future__ import annotations

import enum
from typing import Any, Iterable, Mapping, NamedTuple, Sequence

import numpy as np

from . import _arguments as check
from . import _lacquer
from ._errors import UsageError

__all__ = ["Energy", "Lobes", "Material", "Samples", "Values", "material", "stack"]

# Types of parameters that their values alone do not tell.
_INTEGERS = {"maxdepth", "nsamples", "pairevents", "productevents"}
_SPECTRA = {"eta", "k", "reflectance", "transmittance", "albedo", "sigma_a", "sigma_s", "sigma_t", "mfp",
            "conductor.eta", "conductor.k", "conductor.reflectance", "interface.eta"}
# Those of them that are no index: a number is the same at all wavelengths.
_CONSTANT_SPECTRA = _SPECTRA - {"eta", "k", "conductor.eta", "conductor.k", "interface.eta"}
# What can only stand in a stack, and so cannot be built by itself.
_PARTS_OF_STACKS = {"slab", "interface"}


class Lobes(enum.IntFlag):
    """The side and the kind of a lobe."""

    NONE = 0
    REFLECTION = 1
    TRANSMISSION = 2
    DIFFUSE = 4
    GLOSSY = 8
    SPECULAR = 16


class Values(NamedTuple):
    """Means and their standard errors, of one shape. Errors are 0 for what is exact, NaN for a single sample."""

    value: np.ndarray
    error: np.ndarray


class Samples(NamedTuple):
    """Directions that were drawn; where a draw failed, everything is 0."""

    wi: np.ndarray
    """(..., 3), unit vectors."""
    weight: np.ndarray
    """f |cos theta_i| / pdf, of shape (..., 3) for linear sRGB or (..., number of wavelengths)."""
    pdf: np.ndarray
    """(...), density over solid angle [1/sr]; of specular lobes their probability. Of stacks it is 0: pdf() estimates it."""
    lobe: np.ndarray
    """(...), bits of Lobes."""


class Energy(NamedTuple):
    """Parts of the light in linear sRGB, each of shape (..., 3), with standard errors."""

    reflected: np.ndarray
    reflected_error: np.ndarray
    transmitted: np.ndarray
    transmitted_error: np.ndarray


def _query(mode: str, samples: int, seed: int, estimator: str | None, layered_pdf: str | None) -> Any:
    query = _lacquer.Query()
    query.mode = check.choice("mode", mode, ["radiance", "importance"])
    query.samples = check.integer("samples", samples, 1, check.MAX_SAMPLES)
    query.seed = check.integer("seed", seed, 0, (1 << 64) - 1)
    if estimator is not None:
        query.estimator = check.choice("estimator", estimator, _lacquer.estimators())
    if layered_pdf is not None:
        query.layered_pdf = check.choice("layered_pdf", layered_pdf, _lacquer.layered_pdfs())
    return query


class Material:
    """A material; made by material(), stack() or Scene.material().

    All random numbers of a query depend on its seed and on the index of the pair in the flattened arrays, so equal
    queries give equal bits.
    """

    def __init__(self) -> None:
        raise UsageError("materials are made by lacquer.material(), lacquer.stack() and Scene.material()")

    _native: Any
    _name: str
    _type: str
    _parameters: dict[str, Any] | None

    @classmethod
    def _new(cls, native: Any, name: str, type_: str, parameters: dict[str, Any] | None) -> Material:
        self = object.__new__(cls)
        self._native, self._name, self._type, self._parameters = native, name, type_, parameters
        return self

    @classmethod
    def _of_scene(cls, native: Any, name: str) -> Material:
        return cls._new(native, name, native.type(), None)

    def __repr__(self) -> str:
        return f"<lacquer.Material {self._name!r}, {self._type}>"

    @property
    def type(self) -> str:
        """As in scene files: "diffuse", "layered"."""
        return self._type

    def _built(self) -> Any:
        if self._native is None:
            text = "WorldBegin\n" + self.text(self._name)
            scene = _lacquer.parse(text, "<material>", "")
            self._native = _lacquer.SurfaceMaterial(scene, self._name, [0.5, 0.5], check.texture_folders())
        return self._native

    @property
    def is_stochastic(self) -> bool:
        """True if values are estimates: of stacks."""
        return bool(self._built().is_stochastic())

    def text(self, name: str = "material") -> str:
        """Directives that make this material, under a name, in a scene file: with all parts of a stack.

        :raises UsageError: for materials that were taken from a scene
        """
        if self._parameters is None:
            raise UsageError("text() is for materials that lacquer.material() or lacquer.stack() has made")
        parts: list[str] = []
        own = [_quoted(name), '"string type"', _quoted(self._type)]
        for key, value in self._parameters.items():
            own += [_quoted(_key(key, value)), _value_text(key, value, name, parts)]
        return "".join(parts) + f"MakeNamedMaterial {' '.join(own)}\n"

    def evaluate(self, wo: Any, wi: Any, *, wavelengths: Any = None, samples: int = 64, seed: int = 0,
                 estimator: str | None = None, layered_pdf: str | None = None, mode: str = "radiance") -> Values:
        """f(wo, wi) [1/sr], without the cosine; specular lobes are no part of it.

        :param wo, wi: arrays of shapes (..., 3) that broadcast
        :param wavelengths: [nm], from 360 to 830, one axis of n. None: the result is linear sRGB, from values at 32
            wavelengths, with the white of sRGB as illuminant
        :param samples: evaluations of each pair; where values are exact (not of stacks), one is enough and is taken
        :param estimator: of a layered material: "bidirectional", "auto", ... None: its own
        :param mode: "radiance", with 1/eta^2 in transmission, or "importance"
        :returns: value and standard error, each of shape (..., 3) or (..., n), float64
        """
        query = _query(mode, samples, seed, estimator, layered_pdf)
        o, i, shape = check.pairs(wo, wi)
        lambdas = check.wavelengths(wavelengths)
        value, error = self._built().evaluate(o, i, query, lambdas)
        width = (len(lambdas) or 3,)
        return Values(value.reshape(shape + width), error.reshape(shape + width))

    def pdf(self, wo: Any, wi: Any, *, samples: int = 64, seed: int = 0, layered_pdf: str | None = None,
            mode: str = "radiance") -> Values:
        """Density of wi over solid angle [1/sr] for multiple importance weights: that of sample(), or for stacks an
        estimate of one that is near it (docs/layered.md). Mean over the wavelengths. Its integral is the part of the
        draws that succeed, for stacks nearly. Value and error of shape (...).
        """
        query = _query(mode, samples, seed, None, layered_pdf)
        o, i, shape = check.pairs(wo, wi)
        value, error = self._built().pdf(o, i, query)
        return Values(value.reshape(shape), error.reshape(shape))

    def sample(self, wo: Any, *, wavelengths: Any = None, seed: int = 0, mode: str = "radiance") -> Samples:
        """Draws one wi for each wo.

        :param wo: of shape (..., 3); np.broadcast_to(w, (n, 3)) for n draws of one
        :param wavelengths: at most eight, for which weights are wanted; None: linear sRGB, from one of eight sets of
            eight wavelengths in turn, so that weights are right in the mean over eight or many more draws
        """
        query = _query(mode, 1, seed, None, None)
        o = check.directions("wo", wo)
        shape = o.shape[:-1]
        lambdas = check.wavelengths(wavelengths)
        wi, weight, pdf, lobe = self._built().sample(check.rows(o, shape), query, lambdas)
        return Samples(wi.reshape(shape + (3,)), weight.reshape(shape + (len(lambdas) or 3,)), pdf.reshape(shape),
                       lobe.reshape(shape))

    def albedo(self, wi: Any, *, samples: int = 4096, seed: int = 0) -> Energy:
        """Parts of the light from wi that leave above and below (reflected: on the side of wi), specular peaks included.

        :param samples: draws, eight each: one at each set of wavelengths
        """
        return self._energy("wi", wi, "importance", samples, seed)

    def furnace(self, wo: Any, *, samples: int = 4096, seed: int = 0) -> Energy:
        """What a camera sees in wo of a white environment, of radiance n^2 on a side of index n. 1 in sum for what
        absorbs nothing.
        """
        return self._energy("wo", wo, "radiance", samples, seed)

    def _energy(self, name: str, w: Any, mode: str, samples: int, seed: int) -> Energy:
        query = _query(mode, samples, seed, None, None)
        directions = check.directions(name, w)
        shape = directions.shape[:-1]
        parts = self._built().energy(check.rows(directions, shape), query)
        return Energy(*(part.reshape(shape + (3,)) for part in parts))


def _quoted(text: str) -> str:
    for c in text:
        if ord(c) < 32 or c in '"\\':
            raise UsageError(f"{check.shown(text)}: control characters, quotes and backslashes cannot stand in a scene")
    return f'"{text}"'


def _is_list(value: Any) -> bool:
    return isinstance(value, (list, tuple)) and len(value) > 0


def _key(key: str, value: Any) -> str:
    """Type and name of a parameter."""
    if " " in key:
        return key
    if isinstance(value, (bool, np.bool_)):
        return f"bool {key}"
    if isinstance(value, str):
        return f"{'spectrum' if key in _SPECTRA else 'string'} {key}"
    if isinstance(value, Material) or (_is_list(value) and isinstance(value[0], (str, Material))):
        return f"string {key}"
    if key in _INTEGERS:
        return f"integer {key}"
    array = check.numbers(key, value, "a number, True or False, a text, a color, a spectrum, or materials")
    if array.ndim == 2 and array.shape[1] == 2:
        return f"spectrum {key}"
    if array.ndim == 0 and key in _CONSTANT_SPECTRA:
        return f"spectrum {key}"
    return f"rgb {key}" if array.shape == (3,) else f"float {key}"


def _value_text(key: str, value: Any, name: str, parts: list[str]) -> str:
    """A value as it stands in a scene file; the directives of materials in it are added to `parts`."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (str, Material)) or (_is_list(value) and isinstance(value[0], (str, Material))):
        names = []
        for item in [value] if isinstance(value, (str, Material)) else value:
            if isinstance(item, Material):
                part = f"{name}.{key.split(' ')[-1]}{len(names)}"
                parts.append(item.text(part))
                names.append(part)
            else:
                names.append(check.text(key, item))
        return "[" + " ".join(_quoted(n) for n in names) + "]"
    array = check.numbers(key, value, "numbers").ravel()
    if array.size == 0 or not np.all(np.isfinite(array)):
        raise UsageError(f"{key}: expected finite numbers, not {check.shown(value)}")
    typed = _key(key, value)
    if typed.startswith("spectrum ") and array.size == 1:
        array = np.array([360, array[0], 830, array[0]])
    whole = typed.startswith("integer ")
    if whole and np.any(array != np.round(array)):
        raise UsageError(f"{key}: expected an integer, not {check.shown(value)}")
    return "[" + " ".join(str(int(x)) if whole else repr(float(x)) for x in array) + "]"


def material(type: str, /, parameters: Mapping[str, Any] | None = None, **more: Any) -> Material:
    """A material by its type in scene files, with the parameters that it has there (docs/format.md).

    >>> lacquer.material("coateddiffuse", reflectance=(0.6, 0.1, 0.1), roughness=0.1)
    >>> lacquer.material("conductor", {"spectrum eta": "metal-Cu-eta", "spectrum k": "metal-Cu-k"}, roughness=0.2)

    The type of a parameter follows from its value: numbers, True or False, texts (names of spectra for "eta", "k",
    "reflectance" and the like), three numbers for "rgb", pairs of wavelength and value for "spectrum", materials. One number
    for a reflectance or a coefficient holds at all wavelengths. A key such as "rgb sigma_t" says the type. In ``more``, "__" stands for the dot of "interface.roughness".

    :raises SceneError: for unknown parameters and values that make no sense, with the nearest name
    """
    check.choice("type", type, _lacquer.material_types())
    given: dict[str, Any] = {}
    for key, value in [*(parameters or {}).items(), *((k.replace("__", "."), v) for k, v in more.items())]:
        given[check.text("parameters", key)] = value
    made = Material._new(None, "material", type, given)
    made.text()
    if type not in _PARTS_OF_STACKS:
        made._built()
    return made


def stack(layers: Iterable[Material | str], /, parameters: Mapping[str, Any] | None = None, **more: Any) -> Material:
    """A layered material: interfaces from the outside in, with a slab or nothing between two of them.

    >>> lacquer.stack([
    ...     lacquer.material("dielectric", roughness=0.05),
    ...     lacquer.material("slab", eta=1.5, sigma_t=(1, 1, 1), albedo=(0.5, 0.7, 0.95), phase="hg", g=0.5),
    ...     lacquer.material("conductor", roughness=0.1),
    ... ])

    :param layers: materials made by material() or stack(), or "interface" for a boundary that is not there
    :param parameters, more: those of ``layered``: "estimator", "pdf", "maxdepth", ...
    """
    if isinstance(layers, (str, Material)):
        raise UsageError("layers: expected a list of materials")
    try:
        items = list(layers)
    except TypeError:
        raise UsageError(f"layers: expected a list of materials, not {check.shown(layers)}") from None
    for i, layer in enumerate(items):
        if not isinstance(layer, Material) and layer != "interface":
            raise UsageError(f"layers[{i}]: expected a material or \"interface\", not {check.shown(layer)}")
        if isinstance(layer, Material) and layer._parameters is None:
            raise UsageError(f"layers[{i}]: a material that was taken from a scene cannot be a layer; "
                             "make it by lacquer.material()")
    if not items:
        raise UsageError("layers: expected at least one material")
    return material("layered", {"string stack": items, **dict(parameters or {})}, **more)
