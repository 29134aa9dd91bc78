"""Materials of Blender as materials of the scene: each shader node by its function, Principled by principled.py."""
from . import optics, principled
from .expressions import SQUARE, Constant, Function, is_constant
from .node_graph import Graph
from .report import where_of
from .surfaces import BLACK, Invisible, Surface, added, emission_of, mixed

GREY = (0.8, 0.8, 0.8)


class Materials:
    """Writes each material once, when an object needs it."""

    def __init__(self, scene, textures, images, report):
        self.scene = scene
        self.textures = textures
        self.images = images
        self.report = report
        self.surfaces = {}
        self.owner_name = ""
        self.parts = {}
        self.has_black = False
        scene.unique(BLACK)  # taken, whatever the materials of the file are called

    def surface(self, material):
        """The Surface of a material, or of an empty slot (None)."""
        if material not in self.surfaces:
            self.surfaces[material] = self.translate(material)
        return self.surfaces[material]

    def translate(self, material):
        self.owner_name = material.name if material else "no material"
        if material is None or not material.use_nodes:
            color = tuple(material.diffuse_color[:3]) if material else GREY
            return Surface(self.define("", "diffuse", [("rgb", "reflectance", color)]))
        graph = Graph(material, self.report, self.images)
        output = graph.output_node("OUTPUT_MATERIAL")
        if output is None:
            self.report.warn(where_of(material), "has no output node; black is taken instead")
            return Surface(self.black())
        for name in ("Volume", "Displacement"):
            if graph.follow(output.inputs[name])[0] is not None:
                graph.warn(output, f"\"{name}\" is not translated; none is taken instead")
        result = self.shader(graph, output.inputs["Surface"])
        return Surface(None, alpha=Constant(0.0)) if isinstance(result, Invisible) else result

    def shader(self, graph, socket, groups=()):
        """The Surface of what feeds a shader socket, or Invisible."""
        node, _, inner = graph.follow(socket, groups)
        if node is None:
            return Surface(self.black())
        handler = SHADERS.get(node.type)
        if handler:
            return handler(self, graph, node, inner)
        color = next((node.inputs[n] for n in ("Color", "Base Color") if n in node.inputs), None)
        if color is None:
            graph.warn(node, "is not translated; black is taken instead")
            return Surface(self.black())
        graph.warn(node, "is not translated; a diffuse surface of its colour is taken instead")
        value = graph.read_socket(color, inner)
        return Surface(self.define("diffuse", "diffuse", [self.textures.color_parameter("reflectance", value)]))

    def define(self, part, kind, params):
        """Writes a named material, "owner" or "owner, part", and returns its name; the same one is written once a material."""
        params = tuple(params)
        key = (self.owner_name, kind, repr(params))
        if key not in self.parts:
            name = self.scene.unique(self.owner_name + (f", {part}" if part else ""))
            self.scene.directive("MakeNamedMaterial", name, params=[("string", "type", kind), *params])
            self.parts[key] = name
        return self.parts[key]

    def black(self):
        if not self.has_black:
            params = [("string", "type", "diffuse"), ("rgb", "reflectance", (0, 0, 0))]
            self.scene.directive("MakeNamedMaterial", BLACK, params=params)
        self.has_black = True
        return BLACK

    def roughness(self, expression, anisotropy=0.0):
        """Parameters of an interface whose alpha is the square of Blender's roughness."""
        params = [("bool", "remaproughness", False)]
        if isinstance(expression, Constant):
            along, across = optics.anisotropic_alphas(max(expression.number(), 0.0), anisotropy)
            if along == across:
                return params + [("float", "roughness", along)]
            return params + [("float", "uroughness", along), ("float", "vroughness", across)]
        alpha = expression.map(SQUARE)
        if anisotropy == 0:
            return params + [self.textures.float_parameter("roughness", alpha)]
        ratio = optics.anisotropic_alphas(1.0, anisotropy)
        stretched = [expression.map(Function(f"square-{r:.4f}", lambda x, r=r: x * x * r)) for r in ratio]
        return params + [self.textures.float_parameter(n, e) for n, e in zip(("uroughness", "vroughness"), stretched)]

    def bumps(self, graph, node, groups, name="Normal"):
        """Parameters of what feeds a normal input: a normal map or a height."""
        source, _, inner = graph.follow(node.inputs[name], groups)
        if source is None:
            return []
        if source.type == "NORMAL_MAP":
            return self.normal_map(graph, source, inner)
        if source.type == "BUMP":
            return self.bump(graph, source, inner)
        graph.warn(source, f"is not translated; \"{name}\" of \"{node.name}\" is the surface's own instead")
        return []

    def normal_map(self, graph, node, groups):
        strength = graph.constant(node, "Strength", groups)
        color = graph.read(node, "Color", groups)
        if node.space != "TANGENT":
            graph.warn(node, f"space {node.space} is not translated; no normal map is taken instead")
            return []
        if node.uv_map:
            self.images.note_uv_map(graph, node)
        if isinstance(color, Constant) or not hasattr(color, "image"):
            graph.warn(node, "has no image as its colour; no normal map is taken instead")
            return []
        if color.scale != (1.0, 1.0) or color.offset != (0.0, 0.0):
            graph.warn(node, "the mapping of a normal map is not translated; plain uv is taken instead")
        if not color.image.is_float and color.image.colorspace_settings.name == "sRGB":
            graph.warn(node, f"image \"{color.image.name}\" should be Non-Color; its stored values are taken instead")
        return [("string", "normalmap", self.images.normal_file(color.image, strength))]

    def bump(self, graph, node, groups):
        if graph.follow(node.inputs["Normal"], groups)[0] is not None:
            graph.warn(node, "a second normal below a bump is not translated; the bump alone is taken instead")
        height = graph.read(node, "Height", groups)
        amount = graph.constant(node, "Distance", groups) * graph.constant(node, "Strength", groups)
        if isinstance(height, Constant) or amount == 0:
            return []
        amount = -amount if node.invert else amount
        name = self.textures.write("float", "height", "scale", [self.textures.float_parameter("tex", height),
                                                               ("float", "scale", amount)])
        return [("texture", "displacement", name)]


def distribution(graph, node):
    """Parameters for the choice of microfacets of Glossy, Glass and Refraction."""
    kind = getattr(node, "distribution", "GGX")
    if kind == "BECKMANN":
        return [("string", "distribution", "beckmann")]
    if kind == "MULTI_GGX":
        return [("bool", "multiscatter", True)]
    if kind not in ("GGX", "SHARP"):
        graph.warn(node, f"distribution {kind} is not translated; GGX is taken instead")
    return []


def facets(writer, graph, node, groups):
    sharp = getattr(node, "distribution", "") == "SHARP"
    roughness = Constant(0.0) if sharp else graph.read(node, "Roughness", groups)
    anisotropy = 0.0
    params = distribution(graph, node)
    if node.type == "BSDF_ANISOTROPIC":
        anisotropy = graph.constant(node, "Anisotropy", groups)
        if anisotropy:
            params.append(("float", "rotation", 360 * graph.constant(node, "Rotation", groups)))
    return writer.roughness(roughness, anisotropy) + params


def diffuse(writer, graph, node, groups):
    if graph.constant(node, "Roughness", groups) > 0:
        graph.warn(node, "the roughness of a diffuse surface is not translated; 0 is taken instead")
    color = writer.textures.color_parameter("reflectance", graph.read(node, "Color", groups))
    return Surface(writer.define("diffuse", "diffuse", [color] + writer.bumps(graph, node, groups)))


def glossy(writer, graph, node, groups):
    color = writer.textures.color_parameter("reflectance", graph.read(node, "Color", groups))
    params = facets(writer, graph, node, groups) + writer.bumps(graph, node, groups)
    return Surface(writer.define("glossy", "conductor", [color] + params))


def glass(writer, graph, node, groups):
    if node.type == "BSDF_REFRACTION":
        graph.warn(node, "refraction without reflection is not translated; glass is taken instead")
    eta = graph.constant(node, "IOR", groups)
    params = facets(writer, graph, node, groups) + writer.bumps(graph, node, groups)
    return Surface(principled.tinted_glass(writer, graph, node, graph.read(node, "Color", groups), eta, params))


def translucent(writer, graph, node, groups):
    color = writer.textures.color_parameter("transmittance", graph.read(node, "Color", groups))
    params = [("rgb", "reflectance", (0, 0, 0)), color] + writer.bumps(graph, node, groups)
    return Surface(writer.define("translucent", "diffusetransmission", params))


def emission(writer, graph, node, groups):
    light = emission_of(graph, node, graph.read(node, "Color", groups), graph.constant(node, "Strength", groups))
    return Surface(writer.black(), light)


def transparent(writer, graph, node, groups):
    if not is_constant(graph.read(node, "Color", groups), 1):
        graph.warn(node, "the colour of transparency is not translated; white is taken instead")
    return Invisible()


def mix_shader(writer, graph, node, groups):
    sockets = [s for s in node.inputs if s.type == "SHADER"]
    parts = [writer.shader(graph, s, groups) for s in sockets]
    coat = fresnel_coat(writer, graph, node, groups, sockets, parts)
    return coat or mixed(writer, graph, node, *parts, graph.read(node, "Fac", groups))


def fresnel_coat(writer, graph, node, groups, sockets, parts):
    """A Glossy BSDF mixed over another shader by a Fresnel node is a stack: a dielectric over the other."""
    source, _, inner = graph.follow(node.inputs["Fac"], groups)
    top, _, top_groups = graph.follow(sockets[1], groups)
    if source is None or source.type != "FRESNEL" or top is None or not top.type.startswith("BSDF_GLOSSY"):
        return None
    base = parts[0]
    if isinstance(base, Invisible) or not base.can_be_stacked or base.material == BLACK:
        return None
    eta = graph.constant(source, "IOR", inner)
    params = [("float", "eta", eta)] + facets(writer, graph, top, top_groups) + writer.bumps(graph, top, top_groups)
    coat = writer.define("coat", "dielectric", params)
    stack = writer.define("coated", "layered", [("string", "stack", [coat, base.material])])
    return Surface(stack, base.emission, base.alpha)


def add_shader(writer, graph, node, groups):
    return added(graph, node, *(writer.shader(graph, s, groups) for s in node.inputs))


SHADERS = {"BSDF_PRINCIPLED": principled.translate, "BSDF_DIFFUSE": diffuse, "BSDF_GLOSSY": glossy,
           "BSDF_ANISOTROPIC": glossy, "BSDF_GLASS": glass, "BSDF_REFRACTION": glass, "BSDF_TRANSLUCENT": translucent,
           "BSDF_TRANSPARENT": transparent, "EMISSION": emission, "MIX_SHADER": mix_shader, "ADD_SHADER": add_shader}
