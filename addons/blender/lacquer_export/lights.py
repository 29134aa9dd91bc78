"""Lamps of Blender as lights. docs/blender.md has the formulas; P is the power [W], times the colour.

A point lamp has the radiant intensity P / (4 pi), a spot the same along its axis, a sun the irradiance that its strength says,
and an area lamp the radiance P / (4 A): its flux is pi/4 P.
"""
import math

from .node_graph import Graph
from .expressions import Constant
from .report import where_of

ELLIPSE_SIDES = 64


def write(text, light, matrix, report, images, hidden):
    """A lamp (a data-block) at a place. `hidden`: lamps with a size are invisible themselves."""
    color, strength = emission_of(light, report, images)
    if strength <= 0 or max(color) <= 0:
        return False
    if not light.use_shadow:
        report.warn(where_of(light), "light without shadows is not translated; it casts shadows")
    if getattr(getattr(light, "cycles", None), "is_portal", False):
        report.warn(where_of(light), "portals are not translated; none is taken instead")
        return False
    text.comment(light.name)
    text.begin("AttributeBegin")
    WRITERS[light.type](text, light, matrix, color, strength, report, hidden)
    text.end("AttributeEnd")
    return True


def emission_of(light, report, images):
    """(colour, strength): of the lamp and, if it has nodes, of the Emission node that feeds its output."""
    color, strength = tuple(light.color), light.energy
    if not light.use_nodes:
        return color, strength
    graph = Graph(light, report, images)
    output = graph.output_node("OUTPUT_LIGHT")
    node, _, groups = graph.follow(output.inputs["Surface"]) if output else (None, None, ())
    if node is None:
        return color, 0.0
    if node.type != "EMISSION":
        graph.warn(node, "is not translated; the lamp's own colour and power are taken instead")
        return color, strength
    factor = graph.read(node, "Color", groups)
    if not isinstance(factor, Constant):
        graph.warn(node, "textures of lamps are not translated; white is taken instead")
        factor = Constant(1.0)
    return (tuple(a * b for a, b in zip(color, factor.color())), strength * graph.constant(node, "Strength", groups))


def emitter(text, color, radiance, hidden):
    """The area light and the matter of its shape, and the parameters that shape needs."""
    text.directive("AreaLightSource", "diffuse", params=[("rgb", "L", color), ("float", "scale", radiance)])
    text.directive("Material", "diffuse", params=[("rgb", "reflectance", (0, 0, 0))])
    return [("float", "alpha", 0)] if hidden else []


def write_point(text, light, matrix, color, power, report, hidden):
    place = tuple(matrix.translation)
    radius = light.shadow_soft_size
    intensity = power / (4 * math.pi)
    if radius <= 0:
        text.directive("LightSource", "point", params=[("rgb", "I", color), ("float", "scale", intensity), ("point3", "from", place)])
        return
    # A ball of this radiance has that intensity in all directions.
    text.line("Translate " + " ".join("%.8g" % x for x in place))
    params = emitter(text, color, intensity / (math.pi * radius * radius), hidden)
    text.directive("Shape", "sphere", params=[("float", "radius", radius), *params])


def write_spot(text, light, matrix, color, power, report, hidden):
    place = matrix.translation
    axis = -matrix.col[2].to_3d().normalized()
    cone = light.spot_size / 2
    # The edge is a smooth step of the cosine, from the cone's to this one.
    inner = math.cos(cone) + (1 - math.cos(cone)) * light.spot_blend
    delta = cone - math.acos(min(inner, 1.0))
    if light.shadow_soft_size > 0:
        report.warn(where_of(light), "the radius of a spot is not translated; a point is taken instead")
    middle = math.cos(cone - delta / 2)
    if middle < 0.95:
        report.warn(where_of(light), f"Cycles dims spots by the cosine to their axis, to {middle:.2f} at the edge; it is not "
                                     "translated, and the intensity is constant inside instead")
    text.directive("LightSource", "spot", params=[
        ("rgb", "I", color), ("float", "scale", power / (4 * math.pi)), ("point3", "from", tuple(place)),
        ("point3", "to", tuple(place + axis)), ("float", "coneangle", math.degrees(cone)),
        ("float", "conedeltaangle", max(math.degrees(delta), 1e-3))])


def write_sun(text, light, matrix, color, irradiance, report, hidden):
    axis = -matrix.col[2].to_3d().normalized()
    if math.degrees(light.angle) > 0.6:
        report.warn(where_of(light), f"a sun of {math.degrees(light.angle):.3g} degrees is not translated; one without a width "
                                     "is taken instead")
    text.directive("LightSource", "distant", params=[("rgb", "L", color), ("float", "scale", irradiance),
                                                     ("point3", "from", (0, 0, 0)), ("point3", "to", tuple(axis))])


def write_area(text, light, matrix, color, power, report, hidden):
    is_round = light.shape in ("DISK", "ELLIPSE")
    x = matrix.col[0].to_3d() * light.size
    y = matrix.col[1].to_3d() * (light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size)
    area = x.length * y.length * (math.pi / 4 if is_round else 1)
    if area <= 0:
        report.warn(where_of(light), "has no area; it is left out")
        return
    if abs(light.spread - math.pi) > 1e-3:
        report.warn(where_of(light), "the spread of light is not translated; a half space is taken instead")
    corners = [(-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5)]
    if is_round:
        turns = [-2 * math.pi * i / ELLIPSE_SIDES for i in range(ELLIPSE_SIDES)]
        # A polygon of the same area as the ellipse.
        grow = math.sqrt(2 * math.pi / (ELLIPSE_SIDES * math.sin(2 * math.pi / ELLIPSE_SIDES)))
        corners = [(0.5 * grow * math.cos(t), 0.5 * grow * math.sin(t)) for t in turns]
    points = [tuple(matrix.translation + x * u + y * v) for u, v in corners]
    # It shines along -z of the lamp: counter-clockwise seen from there, also where its matrix mirrors.
    mirrored = matrix.to_3x3().determinant() < 0
    indices = [(0, i + 1, i) if mirrored else (0, i, i + 1) for i in range(1, len(points) - 1)]
    params = emitter(text, color, power / (4 * area), hidden)
    text.directive("Shape", "trianglemesh", params=[("integer", "indices", indices), ("point3", "P", points), *params])


WRITERS = {"POINT": write_point, "SPOT": write_spot, "SUN": write_sun, "AREA": write_area}
