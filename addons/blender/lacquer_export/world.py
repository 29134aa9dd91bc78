"""The world: a colour, an environment image or a sky, as an infinite light."""
import math

from .expressions import Constant
from .node_graph import Graph
from .report import where_of

# From directions of the image to Blender's: Blender's column is 1/2 - phi / 2 pi, that of "latlong" phi / 2 pi.
MIRROR_X = ((-1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))

# What a sky of strength 1 is multiplied by, so that the irradiance of level ground under a sun at 30 degrees, default values
# else, is that of Cycles 3.4 (green channel). Cycles' Nishita model has single scattering only: more of its light is the sun's.
SKY_SCALES = {("NISHITA", True): 90, ("NISHITA", False): 33, ("HOSEK_WILKIE", False): 0.76, ("PREETHAM", False): 5.4}


def write(text, world, report, images):
    if world is None:
        return
    if not world.use_nodes:
        write_constant(text, tuple(world.color), 1.0)
        return
    graph = Graph(world, report, images)
    output = graph.output_node("OUTPUT_WORLD")
    if output is None:
        return
    if graph.follow(output.inputs["Volume"])[0] is not None:
        graph.warn(output, "the volume of a world is not translated; none is taken instead")
    node, _, groups = graph.follow(output.inputs["Surface"])
    if node is None:
        return
    if node.type != "BACKGROUND":
        graph.warn(node, "is not translated; a black world is taken instead")
        return
    strength = graph.constant(node, "Strength", groups)
    source, _, inner = graph.follow(node.inputs["Color"], groups)
    if source is not None and source.type == "TEX_ENVIRONMENT":
        if write_image(text, graph, source, inner, strength, images):
            return
        graph.warn(source, "has no image that can be read; a black world is taken instead")
        return
    if source is not None and source.type == "TEX_SKY":
        write_sky(text, graph, source, inner, strength)
        return
    color = graph.read(node, "Color", groups)
    if not isinstance(color, Constant):
        graph.warn(node, "its colour is a texture that is no Environment Texture; grey of 0.5 is taken instead")
        color = Constant(0.5)
    write_constant(text, color.color(), strength)


def write_constant(text, color, strength):
    if strength > 0 and max(color) > 0:
        text.directive("LightSource", "infinite", params=[("rgb", "L", color), ("float", "scale", strength)])


def write_image(text, graph, node, groups, strength, images):
    """False where there is no image."""
    from mathutils import Matrix
    image = images.usable(graph, node)
    if image is None:
        return False
    mapping = {"EQUIRECTANGULAR": "latlong", "MIRROR_BALL": "mirrorball"}[node.projection]
    if mapping == "mirrorball":
        graph.warn(node, "the orientation of mirror balls is not tested; it is that of the format")
    rotation = rotation_of(graph, node, groups)
    path, _ = images.color_file(image)
    if strength <= 0:
        return True
    text.begin("AttributeBegin")
    text.transform(rotation.inverted() @ Matrix(MIRROR_X))
    text.directive("LightSource", "infinite", params=[("string", "filename", path), ("string", "mapping", mapping),
                                                      ("float", "scale", strength)])
    text.end("AttributeEnd")
    return True


def write_sky(text, graph, node, groups, strength):
    """As the sky of the format: of the same sun and about the same brightness, not of the same formulas."""
    nishita = node.sky_type == "NISHITA"
    disk = nishita and node.sun_disc
    if nishita:
        elevation, rotation = node.sun_elevation, node.sun_rotation  # from +y toward +x
        sun = (math.cos(elevation) * math.sin(rotation), math.cos(elevation) * math.cos(rotation), math.sin(elevation))
        turbidity = 1 + 2 * node.dust_density
        if node.altitude > 500 or abs(node.air_density - 1) > 0.05:
            graph.warn(node, "altitude and density of air are not translated; clean air at the level of the sea is taken instead")
        if disk and abs(node.sun_intensity - 1) > 0.01:
            graph.warn(node, "the intensity of the sun is not translated; 1 is taken instead")
    else:
        length = math.sqrt(sum(x * x for x in node.sun_direction)) or 1
        sun, turbidity = tuple(x / length for x in node.sun_direction), node.turbidity
    graph.warn(node, "becomes the format's own sky: the same sun, about the same brightness, other colours")
    if strength <= 0:
        return
    params = [("string", "model", "sky"), ("vector3", "sundirection", sun), ("float", "turbidity", min(max(turbidity, 1), 30)),
              ("bool", "sun", disk), ("bool", "ground", not nishita),
              ("float", "scale", strength * SKY_SCALES[node.sky_type, disk])]
    if nishita:
        params.append(("float", "ozone", min(300 * node.ozone_density, 1000)))
    else:
        params.append(("rgb", "groundalbedo", (node.ground_albedo,) * 3))
    text.begin("AttributeBegin")
    text.transform(rotation_of(graph, node, groups).inverted())
    text.directive("LightSource", "infinite", params=params)
    text.end("AttributeEnd")


def rotation_of(graph, node, groups):
    """The matrix that a Mapping node applies to directions before they are looked up."""
    from mathutils import Euler, Matrix
    source, output, inner = graph.follow(node.inputs["Vector"], groups)
    matrix = Matrix.Identity(4)
    if source is not None and source.type == "MAPPING":
        values = {name: graph.read(source, name, inner) for name in ("Location", "Rotation", "Scale")
                  if source.inputs[name].enabled}
        if not all(isinstance(v, Constant) for v in values.values()):
            graph.warn(source, "cannot be a texture here; no mapping is taken instead")
            values = {}
        values = {name: v.color() for name, v in values.items()}
        matrix = Euler(values.get("Rotation", (0, 0, 0)), "XYZ").to_matrix().to_4x4()
        if source.vector_type == "TEXTURE":
            matrix.invert()
        if any(abs(x) > 1e-6 for x in values.get("Location", ())) and source.vector_type in ("POINT", "TEXTURE"):
            graph.warn(source, "the location of an environment's mapping is not translated; 0 is taken instead")
        scale = values.get("Scale", (1, 1, 1))
        if any(abs(x - y) > 1e-6 * math.fabs(x) for x in scale for y in scale) or scale[0] <= 0:
            graph.warn(source, "the scale of an environment's mapping is not translated; 1 is taken instead")
        source, output, inner = graph.follow(source.inputs["Vector"], inner)
    if source is not None and not (source.type == "TEX_COORD" and output.name == "Generated") and source.type != "NEW_GEOMETRY":
        graph.report.warn(where_of(graph.owner, source), f"coordinates \"{output.name}\" are not translated; directions are taken "
                                                         "instead")
    return matrix
