"""The files beside a scene: a folder of their own, names that occur once, and files that are whole or not there."""
import os

from .report import ExportFileError
from .scene_text import file_stem


class Assets:
    """The folder `<scene>-files` beside the scene. Paths in the scene are relative to the scene."""

    def __init__(self, scene_path):
        self.scene_path = os.path.abspath(scene_path)
        self.folder = os.path.splitext(self.scene_path)[0] + "-files"
        self.used = set()

    def reserve(self, name, extension):
        """A new name of a file in the folder."""
        stem, count = file_stem(name), 1
        candidate = stem + extension
        while candidate.lower() in self.used:
            count += 1
            candidate = f"{stem}-{count}{extension}"
        self.used.add(candidate.lower())
        return candidate

    def write(self, name, extension, data):
        """Writes bytes to a new file and returns its path for the scene."""
        file = self.reserve(name, extension)
        write_whole(os.path.join(self.folder, file), data)
        return os.path.basename(self.folder) + "/" + file


def write_whole(path, data):
    """Writes under a temporary name first, so that what was there stays if something fails."""
    temporary = path + ".part"
    try:
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(temporary, "wb") as file:
            file.write(data)
        os.replace(temporary, path)
    except OSError as error:
        if os.path.exists(temporary):
            os.unlink(temporary)
        raise ExportFileError(f"{path}: cannot be written: {error.strerror or error}") from error
