"""Lacquer: a spectral renderer for layered materials.

>>> import lacquer
>>> scene = lacquer.load("scenes/first-light.pbrt")
>>> result = scene.render(spp=16)
>>> result.image.shape
(405, 720, 3)

Scenes are read by load() and parse(), materials made by material() and stack() or taken from a scene, images read and
written by read_image() and write_image(), and denoised by denoise(). docs/python.md has the conventions: shapes, units, directions, threads.
"""
from ._colors import delta_e2000, lab
from ._errors import Diagnostic, Error, FileError, SceneError, SceneWarning, UsageError
from ._images import Image, Progress, denoise, read_image, write_image
from ._lacquer import version as __version__
from ._materials import Energy, Lobes, Material, Samples, Values, material, stack
from ._scenes import RenderResult, Scene, load, parse

__all__ = [
    "Diagnostic", "Energy", "Error", "FileError", "Image", "Lobes", "Material", "Progress", "RenderResult", "Samples",
    "Scene", "SceneError", "SceneWarning", "UsageError", "Values", "delta_e2000", "denoise", "lab", "load", "material", "parse", "read_image",
    "stack", "write_image",
]
