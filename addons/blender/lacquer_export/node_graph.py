"""Follows links of node trees, through reroutes and groups, and reads sockets as expressions."""
import math

from .expressions import Checker, Constant, Image, COMPLEMENT, mixture, product
from .report import where_of

EXTENSIONS = {"REPEAT": "repeat", "EXTEND": "clamp", "CLIP": "black"}


class Graph:
    """A node tree of a material, light or world. `owner` names it in warnings."""

    def __init__(self, owner, report, images):
        self.owner = owner
        self.report = report
        self.images = images

    def warn(self, node, message):
        self.report.warn(where_of(self.owner, node), message)

    def output_node(self, kind):
        """The active output node, or None. `kind` is its type, as OUTPUT_MATERIAL."""
        tree = self.owner.node_tree
        if kind == "OUTPUT_MATERIAL":
            found = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
            return found
        nodes = [n for n in tree.nodes if n.type == kind]
        return next((n for n in nodes if n.is_active_output), nodes[0] if nodes else None)

    def follow(self, socket, groups=()):
        """What feeds an input: (source node, its output socket, groups around it), or (None, the socket, groups) if nothing does."""
        while socket.is_linked:
            link = socket.links[0]
            node, output = link.from_node, link.from_socket
            if node.mute:
                inner = next((l.from_socket for l in node.internal_links if l.to_socket == output), None)
                if inner is None:
                    break
                socket = inner
            elif node.type == "REROUTE":
                socket = node.inputs[0]
            elif node.type == "GROUP" and node.node_tree:
                exits = [n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT"]
                end = next((n for n in exits if n.is_active_output), exits[0] if exits else None)
                if end is None:
                    break
                groups += (node,)
                socket = next(s for s in end.inputs if s.identifier == output.identifier)
            elif node.type == "GROUP_INPUT" and groups:
                socket = next(s for s in groups[-1].inputs if s.identifier == output.identifier)
                groups = groups[:-1]
            else:
                return node, output, groups
        return None, socket, groups

    def read(self, node, name, groups=()):
        """The expression of the input `name` of a node: a constant where nothing is linked or can be translated."""
        return self.read_socket(node.inputs[name], groups)

    def read_socket(self, socket, groups=()):
        source, last, inner = self.follow(socket, groups)
        if source is None:
            return default_of(last)
        handler = HANDLERS.get(source.type)
        result = handler(self, source, last, inner) if handler else None
        if result is not None:
            return result
        default = default_of(socket)
        reason = "has no image that can be read" if source.type == "TEX_IMAGE" else "is not translated"
        self.warn(source, f"{reason}; \"{socket.name}\" of \"{socket.node.name}\" has its own value "
                          f"{shown(default)} instead")
        return default

    def constant(self, node, name, groups=()):
        """The number of an input that cannot be a texture in the format."""
        value = self.read(node, name, groups)
        if isinstance(value, Constant):
            return value.number()
        default = default_of(node.inputs[name]).number()
        self.warn(node, f"\"{name}\" cannot be a texture here; it has its own value {shown(Constant(default))} instead")
        return default


def default_of(socket):
    value = getattr(socket, "default_value", 0.0)
    if hasattr(value, "__len__"):
        return Constant(tuple(float(v) for v in value[:3]))
    return Constant(float(value))


def shown(constant):
    if hasattr(constant.value, "__len__"):
        return "(" + ", ".join("%.4g" % v for v in constant.value) + ")"
    return "%.4g" % constant.value


# ---- Nodes that give values ----


def read_rgb(graph, node, output, groups):
    return Constant(tuple(float(v) for v in output.default_value[:3]))


def read_value(graph, node, output, groups):
    return Constant(float(output.default_value))


def uv_mapping(graph, node, groups):
    """(scale, offset) of the texture coordinates of a node, which are uv of the active map in the end."""
    source, output, inner = graph.follow(node.inputs["Vector"], groups)
    scale, offset = (1.0, 1.0), (0.0, 0.0)
    if source is not None and source.type == "MAPPING":
        scale, offset = mapping_of(graph, source, inner)
        source, output, inner = graph.follow(source.inputs["Vector"], inner)
        if source is None:
            graph.warn(node, "has a mapping of nothing; uv is taken instead")
            return scale, offset
    if source is None:
        if node.type != "TEX_IMAGE":
            graph.warn(node, "generated coordinates are not translated; uv is taken instead")
    elif source.type == "UVMAP":
        if source.uv_map:
            graph.images.note_uv_map(graph, source)
    elif not (source.type == "TEX_COORD" and output.name == "UV"):
        graph.warn(node, f"coordinates \"{output.name}\" of \"{source.name}\" are not translated; uv is taken instead")
    return scale, offset


def mapping_of(graph, node, groups):
    """Scale and offset of a Mapping node, without its rotation."""
    location = default_or_zero(graph, node, "Location", groups)
    rotation = default_or_zero(graph, node, "Rotation", groups)
    scale = graph.read(node, "Scale", groups)
    scale = scale.color() if isinstance(scale, Constant) else (1.0, 1.0, 1.0)
    if any(abs(math.remainder(r, 2 * math.pi)) > 1e-6 for r in rotation):
        graph.warn(node, "the rotation of texture coordinates is not translated; none is taken instead")
    if node.vector_type == "TEXTURE":  # the inverse
        if 0 in scale[:2]:
            graph.warn(node, "has a scale of 0; 1 is taken instead")
            scale = (1.0, 1.0, 1.0)
        return (1 / scale[0], 1 / scale[1]), (-location[0] / scale[0], -location[1] / scale[1])
    if node.vector_type != "POINT":
        location = (0.0, 0.0, 0.0)
    return tuple(scale[:2]), tuple(location[:2])


def default_or_zero(graph, node, name, groups):
    if name not in node.inputs or not node.inputs[name].enabled:
        return (0.0, 0.0, 0.0)
    value = graph.read(node, name, groups)
    return value.color() if isinstance(value, Constant) else (0.0, 0.0, 0.0)


def read_image(graph, node, output, groups):
    image = graph.images.usable(graph, node)
    if image is None:
        return None
    if node.projection != "FLAT":
        graph.warn(node, f"projection {node.projection} is not translated; flat by uv is taken instead")
    scale, offset = uv_mapping(graph, node, groups)
    nearest = node.interpolation == "Closest"
    return Image(image, "alpha" if output.name == "Alpha" else "color", scale, offset, EXTENSIONS[node.extension],
                 "point" if nearest else "bilinear")


def read_checker(graph, node, output, groups):
    scale, offset = uv_mapping(graph, node, groups)
    factor = graph.constant(node, "Scale", groups)
    first, second = Constant(1.0), Constant(0.0)
    if output.name == "Color":
        first, second = graph.read(node, "Color1", groups), graph.read(node, "Color2", groups)
    return Checker(first, second, tuple(s * factor for s in scale), tuple(o * factor for o in offset))


def blend(graph, node, mode, inputs, groups):
    """A mixing node: (factor, first, second) by their sockets."""
    amount, first, second = (graph.read_socket(s, groups) for s in inputs)
    if mode == "MIX":
        return mixture(first, second, amount)
    if mode == "MULTIPLY":
        return mixture(first, product(first, second), amount)
    return None


def read_mix(graph, node, output, groups):
    """The node Mix of Blender 3.4, which has the sockets of all its types; those of the chosen one are enabled."""
    if node.data_type == "VECTOR":
        return None
    enabled = [s for s in node.inputs if s.enabled]
    mode = node.blend_type if node.data_type == "RGBA" else "MIX"
    return blend(graph, node, mode, enabled, groups)


def read_mix_rgb(graph, node, output, groups):
    return blend(graph, node, node.blend_type, list(node.inputs)[:3], groups)


def read_invert(graph, node, output, groups):
    amount, color = graph.read(node, "Fac", groups), graph.read(node, "Color", groups)
    return mixture(color, color.map(COMPLEMENT), amount)


def read_math(graph, node, output, groups):
    a, b = (graph.read_socket(s, groups) for s in list(node.inputs)[:2])
    if node.operation == "MULTIPLY":
        return product(a, b)
    if all(isinstance(e, Constant) for e in (a, b)):
        x, y = a.number(), b.number()
        table = {"ADD": lambda: x + y, "SUBTRACT": lambda: x - y, "DIVIDE": lambda: x / y if y else 0.0,
                 "POWER": lambda: x ** y if x > 0 else 0.0, "MINIMUM": lambda: min(x, y), "MAXIMUM": lambda: max(x, y)}
        return Constant(table[node.operation]()) if node.operation in table else None
    if node.operation == "SUBTRACT" and isinstance(a, Constant) and a.number() == 1:
        return b.map(COMPLEMENT)
    return None


HANDLERS = {"RGB": read_rgb, "VALUE": read_value, "TEX_IMAGE": read_image, "TEX_CHECKER": read_checker, "MIX": read_mix,
            "MIX_RGB": read_mix_rgb, "INVERT": read_invert, "MATH": read_math}
