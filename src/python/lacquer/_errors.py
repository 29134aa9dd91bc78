"""Exceptions and warnings of the package."""
from __future__ import annotations

from typing import NamedTuple, Sequence

__all__ = ["Diagnostic", "Error", "FileError", "SceneError", "SceneWarning", "UsageError"]


class Diagnostic(NamedTuple):
    """One problem and its place; line and column count from 1, line 0 means the file as a whole."""

    file: str
    line: int
    column: int
    message: str


class Error(Exception):
    """What all errors of the package are.

    ``str(error)`` is the text that the command line shows. ``file``, ``line`` and ``column`` are the place of the first
    problem ("" and 0 where there is none), ``diagnostics`` are all problems.
    """

    def __init__(self, text: str, places: Sequence[tuple[str, int, int, str]] = ()) -> None:
        super().__init__(text)
        self.diagnostics = [Diagnostic(*place) for place in places]
        first = self.diagnostics[0] if self.diagnostics else Diagnostic("", 0, 0, text)
        self.file, self.line, self.column, self.message = first

    def __str__(self) -> str:
        return str(self.args[0])


class SceneError(Error, ValueError):
    """The scene, or a file that it names, says something impossible (exit status 2 of the command line)."""


class FileError(Error, OSError):
    """A file cannot be read or written (exit status 3 of the command line)."""


class UsageError(Error, ValueError):
    """An argument makes no sense (exit status 1 of the command line)."""


class SceneWarning(UserWarning):
    """Something about a scene that is worth knowing and no error."""
