"""The text of a scene: directives with typed parameters, escaped strings, names that occur once."""
import re

import numpy as np

# pbrt's escapes in strings.
ESCAPES = {"\\": "\\\\", "\"": "\\\"", "\n": "\\n", "\r": "\\r", "\t": "\\t", "\b": "\\b", "\f": "\\f"}
INTEGER_TYPES = ("integer",)


def quote(text):
    return "\"" + "".join(ESCAPES.get(c, c) for c in text) + "\""


def number(value):
    """The shortest text that is the same 32-bit float, never in a form that the format lacks."""
    value = np.float32(value)
    if not np.isfinite(value):
        raise ValueError(f"{value} is no number of the scene format")
    return str(value + np.float32(0)).removesuffix(".0")  # no negative zero


def flatten(value):
    if isinstance(value, (str, bool, int, float)):
        return [value]
    return [item for part in value for item in flatten(part)]


def parameter(kind, name, value):
    """A parameter with its type: `"float fov" 40`; lists and vectors stand in brackets."""
    items = flatten(value)
    if kind in ("string", "texture", "spectrum") and all(isinstance(item, str) for item in items):
        words = [quote(item) for item in items]
    elif kind == "bool":
        words = ["true" if item else "false" for item in items]
    elif kind in INTEGER_TYPES:
        words = [str(int(item)) for item in items]
    else:
        words = [number(item) for item in items]
    is_list = not isinstance(value, (str, bool, int, float))
    return f"{quote(kind + ' ' + name)} " + (f"[ {' '.join(words)} ]" if is_list else words[0])


class SceneText:
    """Lines of a scene file, and the names that it has used."""

    WIDTH = 120

    def __init__(self):
        self.lines = []
        self.indent = 0
        self.names = set()

    def line(self, text=""):
        self.lines.append("    " * self.indent + text if text else "")

    def comment(self, text):
        self.line("# " + " ".join(text.split()))

    def directive(self, name, *arguments, params=()):
        """A directive with quoted arguments and (type, name, value) parameters; long ones go on in further lines."""
        words = [name] + [quote(argument) for argument in arguments]
        parts = [" ".join(words)] + [parameter(*p) for p in params]
        if len("  ".join(parts)) + 4 * self.indent <= self.WIDTH:
            self.line("  ".join(parts))
            return
        self.line(parts[0])
        for part in parts[1:]:
            self.line("    " + part)

    def transform(self, matrix, name="Transform"):
        """A 4 x 4 matrix for column vectors; the format counts by columns."""
        self.line(f"{name} [ " + " ".join(number(matrix[r][c]) for c in range(4) for r in range(4)) + " ]")

    def begin(self, name, *arguments):
        self.directive(name, *arguments)
        self.indent += 1

    def end(self, name):
        self.indent -= 1
        self.line(name)

    def unique(self, name):
        """`name`, or with a number if something else has it."""
        candidate, count = name, 1
        while candidate in self.names:
            count += 1
            candidate = f"{name}.{count}"
        self.names.add(candidate)
        return candidate

    def text(self):
        return "\n".join(self.lines) + "\n"


def file_stem(name):
    """A name without anything that a file system or a scene could mind."""
    return re.sub(r"[^A-Za-z0-9._-]+", "_", name).strip("._") or "unnamed"
