"""What a shader of Blender becomes: a material of the scene by name, what it emits, and where it has holes."""
from dataclasses import dataclass

from .expressions import COMPLEMENT, Constant, is_constant, mixture, product


@dataclass(frozen=True)
class Surface:
    """`material` is a name, or None where there is no surface; `emission` (colour, strength) or None; `alpha` an expression."""
    material: object
    emission: object = None
    alpha: object = Constant(1.0)
    can_be_stacked: bool = True  # a mix cannot


class Invisible:
    """What a Transparent BSDF is."""


def emission_of(graph, node, color, strength):
    """(colour expression, number), or None where nothing is emitted."""
    if strength <= 0 or is_constant(color, 0):
        return None
    return color, strength


def mixed(writer, graph, node, first, second, amount):
    """Surface of (1 - amount) first + amount second; either may be Invisible."""
    if isinstance(first, Invisible) and isinstance(second, Invisible):
        return first
    if isinstance(first, Invisible):
        return Surface(second.material, second.emission, product(second.alpha, amount), second.can_be_stacked)
    if isinstance(second, Invisible):
        return Surface(first.material, first.emission, product(first.alpha, amount.map(COMPLEMENT)), first.can_be_stacked)
    emission = mixed_emission(graph, node, first.emission, second.emission, amount)
    alpha = mixture(first.alpha, second.alpha, amount)
    if is_constant(amount, 0) or first.material == second.material:
        return Surface(first.material, emission, alpha, first.can_be_stacked)
    if is_constant(amount, 1):
        return Surface(second.material, emission, alpha, second.can_be_stacked)
    name = writer.define("mix", "mix", [("string", "materials", [first.material, second.material]),
                                        writer.textures.float_parameter("amount", amount)])
    return Surface(name, emission, alpha, False)


def mixed_emission(graph, node, first, second, amount):
    if first is None and second is None:
        return None
    if not isinstance(amount, Constant):
        graph.warn(node, "emission cannot be mixed by a texture; it is taken in full instead")
        return first or second
    weighted = [(e[0], e[1] * w) for e, w in ((first, 1 - amount.number()), (second, amount.number())) if e and w > 0]
    if len(weighted) == 2:
        if all(isinstance(e[0], Constant) for e in weighted):
            total = tuple(sum(e[0].color()[i] * e[1] for e in weighted) for i in range(3))
            return Constant(total), 1.0
        graph.warn(node, "two emissions cannot be mixed by textures; the brighter one is taken instead")
        return max(weighted, key=lambda e: e[1])
    return weighted[0] if weighted else None


def added(graph, node, first, second):
    """Surface of first + second, where one of them only emits."""
    if isinstance(first, Invisible):
        return second
    if isinstance(second, Invisible):
        return first
    for body, light in ((first, second), (second, first)):
        if light.material == BLACK:
            emission = light.emission
            if body.emission and emission:
                emission = mixed_emission(graph, node, (body.emission[0], 2 * body.emission[1]),
                                          (emission[0], 2 * emission[1]), Constant(0.5))
            return Surface(body.material, emission or body.emission, body.alpha, body.can_be_stacked)
    graph.warn(node, "a sum of two scattering shaders is not translated; its first one is taken instead")
    return first


# The name of the material of what only emits.
BLACK = "black"
