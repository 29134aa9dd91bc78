"""What a socket of a shader is, as a small tree that textures can be made of: constants, images, checkers, mixtures, products.

A tree knows nothing of Blender's nodes; node_graph.py makes it, textures.py writes it.
"""
from dataclasses import dataclass, field, replace

from . import optics


@dataclass(frozen=True)
class Function:
    """A function of values, number by number, with a name that tells it from others."""
    name: str
    apply: object = field(compare=False)
    is_unbounded: bool = False  # its values may be more than 1

    def __call__(self, values):
        return self.apply(values)


SQUARE = Function("square", lambda x: x * x)
COMPLEMENT = Function("complement", lambda x: 1 - x)


@dataclass(frozen=True)
class Constant:
    """A number, or three of a colour."""
    value: object

    def color(self):
        return tuple(self.value) if hasattr(self.value, "__len__") else (self.value,) * 3

    def number(self):
        return optics.luminance(self.value) if hasattr(self.value, "__len__") else self.value

    def map(self, function):
        if hasattr(self.value, "__len__"):
            return Constant(tuple(float(function(v)) for v in self.value))
        return Constant(float(function(self.value)))


@dataclass(frozen=True)
class Image:
    """An image of Blender, seen through uv * scale + offset. `channel` is color or alpha."""
    image: object
    channel: str = "color"
    scale: tuple = (1.0, 1.0)
    offset: tuple = (0.0, 0.0)
    wrap: str = "repeat"
    filter: str = "bilinear"
    functions: tuple = ()

    def map(self, function):
        return replace(self, functions=self.functions + (function,))


@dataclass(frozen=True)
class Checker:
    first: object
    second: object
    scale: tuple = (1.0, 1.0)
    offset: tuple = (0.0, 0.0)

    def map(self, function):
        return replace(self, first=self.first.map(function), second=self.second.map(function))


@dataclass(frozen=True)
class Mixture:
    """(1 - amount) first + amount second."""
    first: object
    second: object
    amount: object

    def map(self, function):
        return replace(self, first=self.first.map(function), second=self.second.map(function))


@dataclass(frozen=True)
class Product:
    first: object
    second: object

    def map(self, function):
        """Only powers go through products; others are taken of the factors, of which textures.py warns."""
        return replace(self, first=self.first.map(function), second=self.second.map(function))


def is_constant(expression, value=None):
    return isinstance(expression, Constant) and (value is None or all(abs(c - value) < 1e-7 for c in expression.color()))


def product(first, second):
    if isinstance(first, Constant) and isinstance(second, Constant):
        if not hasattr(first.value, "__len__") and not hasattr(second.value, "__len__"):
            return Constant(first.value * second.value)
        return Constant(tuple(a * b for a, b in zip(first.color(), second.color())))
    if is_constant(first, 1):
        return second
    for factor, other in ((first, second), (second, first)):
        if isinstance(factor, Constant) and isinstance(other, (Checker, Mixture)):
            return replace(other, first=product(factor, other.first), second=product(factor, other.second))
    return first if is_constant(second, 1) else Product(first, second)


def mixture(first, second, amount):
    if is_constant(amount, 0) or first == second:
        return first
    if is_constant(amount, 1):
        return second
    if all(isinstance(e, Constant) for e in (first, second, amount)):
        a = amount.number()
        return Constant(tuple((1 - a) * x + a * y for x, y in zip(first.color(), second.color())))
    return Mixture(first, second, amount)
