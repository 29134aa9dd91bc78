"""Principled BSDF as stacks: a coat over a diffuse base below a dielectric, over metal, or over glass.

Each share of the node (metal, transmission, coat) is a material of its own, and `mix` has them in their amounts. Every
metal reflects at normal incidence what the node's parameters say, and a diffuse base has the colour that they say, for what
lies above is taken out of it (interfaces.py).
"""
import math

from . import optics
from .expressions import Constant, Function, is_constant, mixture
from .interfaces import base_reflectance, color_correction
from .surfaces import Surface, emission_of, mixed

COAT_ETA = 1.5
MULTISCATTER_ALPHA = 0.3
# Inputs without a counterpart: warned of where they are not 0.
IGNORED = {"Specular Tint": "no tint", "Sheen": "no sheen"}


def translate(writer, graph, node, groups):
    """The Surface of a Principled BSDF."""
    read = lambda name: graph.read(node, name, groups)  # noqa: E731
    for name, instead in IGNORED.items():
        if not is_constant(read(name), 0):
            graph.warn(node, f"\"{name}\" is not translated; {instead} is taken instead")
    light = emission_of(graph, node, read("Emission"), graph.constant(node, "Emission Strength", groups))
    coat = read("Clearcoat")
    body = None
    if not is_constant(coat, 1):
        body = Base(writer, graph, node, groups, None).surface()
    if not is_constant(coat, 0):
        coated = Base(writer, graph, node, groups, coat_of(writer, graph, node, groups)).surface()
        body = coated if body is None else mixed(writer, graph, node, body, coated, coat)
    return Surface(body.material, light, read("Alpha"), body.can_be_stacked)


def coat_of(writer, graph, node, groups):
    """The name of the coat's interface, whose normal is its own."""
    params = [("float", "eta", COAT_ETA)] + writer.roughness(graph.read(node, "Clearcoat Roughness", groups))
    return writer.define("coat", "dielectric", params + writer.bumps(graph, node, groups, "Clearcoat Normal"))


class Base:
    """What lies below the coat, or all there is without one. `coat` is the name of an interface or None."""

    def __init__(self, writer, graph, node, groups, coat):
        self.writer, self.graph, self.node, self.groups, self.coat = writer, graph, node, groups, coat
        self.color = graph.read(node, "Base Color", groups)
        self.roughness = graph.read(node, "Roughness", groups)
        self.anisotropy = graph.constant(node, "Anisotropic", groups)
        self.facets = writer.roughness(self.roughness, self.anisotropy)
        if self.anisotropy:
            self.facets.append(("float", "rotation", 360 * graph.constant(node, "Anisotropic Rotation", groups)))
        self.bumps = writer.bumps(graph, node, groups)

    def surface(self):
        metallic = self.graph.read(self.node, "Metallic", self.groups)
        transmission = self.graph.read(self.node, "Transmission", self.groups)
        body = None
        if not is_constant(metallic, 1):
            if not is_constant(transmission, 1):
                body = Surface(self.plastic())
            if not is_constant(transmission, 0):
                clear = Surface(self.glass())
                body = clear if body is None else mixed(self.writer, self.graph, self.node, body, clear, transmission)
        if not is_constant(metallic, 0):
            metal = Surface(self.metal())
            body = metal if body is None else mixed(self.writer, self.graph, self.node, body, metal, metallic)
        return body

    def stack(self, part, layers, params=()):
        """A layered material with the coat on top, if there is one."""
        layers = ([self.coat] if self.coat else []) + layers
        if len(layers) == 1:
            return layers[0]
        part = f"coated {part}" if self.coat else part
        return self.writer.define(part, "layered", [("string", "stack", layers), *params])

    def diffuse_color(self):
        """The base colour, with the share that Principled gives to subsurface scattering as plain diffuse."""
        amount = self.graph.read(self.node, "Subsurface", self.groups)
        if is_constant(amount, 0):
            return self.color
        self.graph.warn(self.node, "\"Subsurface\" is not translated; a diffuse surface of its colour is taken instead")
        return mixture(self.color, self.graph.read(self.node, "Subsurface Color", self.groups), amount)

    def plastic(self):
        """A diffuse base below a dielectric whose index has the reflectance that "Specular" says, 8 % at 1.

        That index is the base's own: below a coat the boundary is the one between the two media, and there is none where the
        base's index is not the higher one.
        """
        color = self.diffuse_color()
        f0 = 0.08 * self.graph.constant(self.node, "Specular", self.groups)
        eta = optics.eta_of_f0(f0) / (COAT_ETA if self.coat else 1.0)
        has_surface = eta > 1.005
        interfaces = ([(COAT_ETA, self.alpha("Clearcoat Roughness"))] if self.coat else [])
        interfaces += [(round(eta, 6), self.alpha("Roughness"))] if has_surface else []
        # Above a white base rough facets would lose a third of the light: then all orders of scattering are worth their time.
        is_lossless = has_surface and self.alpha("Roughness") > MULTISCATTER_ALPHA
        if interfaces:
            correction = color_correction(tuple(interfaces), is_lossless)
            name = f"below-{correction[1]:.4f}-{correction[2]:.4f}"
            color = color.map(Function(name, lambda c: base_reflectance(c, correction)))
        reflectance = self.writer.textures.color_parameter("reflectance", color)
        if not has_surface:
            return self.stack("diffuse", [self.writer.define("base", "diffuse", [reflectance] + self.bumps)])
        # Over a single dielectric the whole is bent, so that the pair keeps its closed form; a coat keeps its own normal.
        inner = self.bumps if self.coat else []
        orders = [("bool", "multiscatter", True)] if is_lossless else []
        surface = self.writer.define("specular", "dielectric", [("float", "eta", eta)] + self.facets + orders + inner)
        base = self.writer.define("base", "diffuse", [reflectance] + inner)
        return self.stack("plastic", [surface, base], [] if self.coat else self.bumps)

    def alpha(self, name):
        """Of an interface for the correction of colours; smooth where a texture says it."""
        roughness = self.graph.read(self.node, name, self.groups)
        return round(max(roughness.number(), 0.0) ** 2, 4) if isinstance(roughness, Constant) else 0.0

    def metal(self):
        """Under a coat the index is the coat's, so that the metal reflects as it does without."""
        if self.coat:
            k = self.color.map(Function("metal-k", lambda c: optics.metal_k(c, COAT_ETA), is_unbounded=True))
            params = [("rgb", "eta", (COAT_ETA,) * 3), self.writer.textures.color_parameter("k", k, "unbounded")]
        else:
            params = [self.writer.textures.color_parameter("reflectance", self.color)]
        return self.stack("metal", [self.writer.define("metal", "conductor", params + self.facets + self.bumps)])

    def glass(self):
        """Rough glass; its transmission is as rough as Principled says, its reflection as well."""
        extra = self.graph.constant(self.node, "Transmission Roughness", self.groups)
        facets = self.facets
        if extra > 0:
            self.graph.warn(self.node, "\"Transmission Roughness\" is not translated; \"Roughness\" is taken instead")
        eta = self.graph.constant(self.node, "IOR", self.groups)
        name = tinted_glass(self.writer, self.graph, self.node, self.color, eta, facets + self.bumps)
        return self.stack("glass", [name])


def tinted_glass(writer, graph, node, color, eta, params):
    """The name of a dielectric, or of one over an absorbing slab with the colour's transmittance at normal incidence.

    Blender multiplies by the colour at each refraction; the slab does so straight on, and absorbs more along slanted paths.
    """
    if is_constant(color, 1):
        return writer.define("glass", "dielectric", [("float", "eta", eta), *params])
    if not isinstance(color, Constant):
        graph.warn(node, "the colour of glass cannot be a texture; white is taken instead")
        return writer.define("glass", "dielectric", [("float", "eta", eta), *params])
    depth = tuple(-math.log(min(max(c, 1e-4), 1.0)) for c in color.color())
    surface = writer.define("glass", "dielectric", params)
    tint = writer.define("tint", "slab", [("float", "eta", eta), ("rgb", "sigma_t", depth)])
    return writer.define("tinted glass", "layered", [("string", "stack", [surface, tint, "interface"]), ("float", "eta", eta)])
