"""Writes expressions as parameters: numbers and colours in place, everything else as named textures."""
from .expressions import SQUARE, Checker, Constant, Image, Mixture, Product


class Textures:
    def __init__(self, scene, images):
        self.scene = scene
        self.images = images
        self.names = {}

    def float_parameter(self, name, expression):
        """(type, name, value) of a float or float texture."""
        if isinstance(expression, Constant):
            return ("float", name, expression.number())
        return ("texture", name, self.texture("float", expression))

    def color_parameter(self, name, expression, kind="spectrum"):
        """(type, name, value) of a colour: a reflectance in [0, 1], or of the kind "unbounded" anything from 0 on."""
        if isinstance(expression, Constant):
            return ("rgb", name, clipped(expression.color(), kind))
        return ("texture", name, self.texture(kind, expression))

    def texture(self, kind, expression):
        """The name of a texture of this kind with this expression, written where it is new."""
        key = (kind, expression)
        if key not in self.names:
            self.names[key] = WRITERS[type(expression)](self, kind, expression)
        return self.names[key]

    def part(self, kind, name, expression):
        return self.float_parameter(name, expression) if kind == "float" else self.color_parameter(name, expression, kind)

    def write(self, kind, stem, plugin, params):
        name = self.scene.unique(stem)
        self.scene.directive("Texture", name, "spectrum" if kind == "unbounded" else kind, plugin, params=params)
        return name


def clipped(color, kind):
    return tuple(max(c, 0.0) if kind == "unbounded" else min(max(c, 0.0), 1.0) for c in color)


def mapping_parameters(expression):
    params = []
    for letter, scale, offset in zip("uv", expression.scale, expression.offset):
        params += [("float", letter + "scale", scale)] if scale != 1 else []
        params += [("float", letter + "delta", offset)] if offset != 0 else []
    return params


def write_constant(textures, kind, expression):
    params = [("float", "value", expression.number())] if kind == "float" else [("rgb", "value", clipped(expression.color(), kind))]
    return textures.write(kind, "constant", "constant", params)


def write_image(textures, kind, expression):
    encoding = "linear"
    if kind == "float" or expression.channel == "alpha":
        path = textures.images.number_file(expression.image, expression.channel, expression.functions)
    elif expression.functions:
        path = textures.images.mapped_file(expression.image, expression.functions)
    else:
        path, encoding = textures.images.color_file(expression.image)
    params = [("string", "filename", path)]
    if path.endswith(".png"):
        params.append(("string", "encoding", encoding))
    if expression.wrap != "repeat":
        params.append(("string", "wrap", expression.wrap))
    if expression.filter != "bilinear":
        params.append(("string", "filter", expression.filter))
    return textures.write(kind, expression.image.name, "imagemap", params + mapping_parameters(expression))


def write_checker(textures, kind, expression):
    params = [textures.part(kind, "tex1", expression.first), textures.part(kind, "tex2", expression.second)]
    return textures.write(kind, "checker", "checkerboard", params + mapping_parameters(expression))


def write_mixture(textures, kind, expression):
    params = [textures.part(kind, "tex1", expression.first), textures.part(kind, "tex2", expression.second),
              textures.float_parameter("amount", expression.amount)]
    return textures.write(kind, "mix", "mix", params)


def write_product(textures, kind, expression):
    """As a mixture between black and one factor where both are colours, for "scale" takes a number."""
    first, second = expression.first, expression.second
    if any(function != SQUARE for part in (first, second) for function in getattr(part, "functions", ())):
        textures.images.report.warn("textures", "what is computed of a product of textures is computed of its factors instead")
    if kind == "float" or is_grey(second):
        return textures.write(kind, "product", "scale", [textures.part(kind, "tex", first), textures.float_parameter("scale", second)])
    if is_grey(first):
        return write_product(textures, kind, Product(second, first))
    params = [textures.part(kind, "tex1", Constant((0.0, 0.0, 0.0))), textures.part(kind, "tex2", first),
              textures.float_parameter("amount", second)]
    textures.images.report.warn("textures", "a product of two colours is not translated; the second one's luminance is "
                                            "taken instead")
    return textures.write(kind, "product", "mix", params)


def is_grey(expression):
    """Whether all that an expression can be is a number."""
    if isinstance(expression, Constant):
        return max(expression.color()) - min(expression.color()) < 1e-6
    return isinstance(expression, Image) and expression.channel == "alpha"


WRITERS = {Constant: write_constant, Image: write_image, Checker: write_checker, Mixture: write_mixture, Product: write_product}
