"""Scenes made smaller, for measurements that take many renders."""
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def text_of(path):
    """A scene with the files that it includes."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    return text + "".join(text_of(os.path.join(os.path.dirname(path), name)) for name in re.findall(r'^Include "([^"]+\.pbrt)"', text, re.M))


def small_size_of(path, most_pixels):
    """Width and height of the scene's film, divided by the least whole number from 2 on that leaves so many pixels at most."""
    text = text_of(path)
    width, height = (int(re.search(r'"integer %sresolution"\s*\[?\s*(\d+)' % axis, text)[1]) for axis in "xy")
    shrink = 2
    while width // shrink * (height // shrink) > most_pixels:
        shrink += 1
    return width // shrink, height // shrink


SHARED = "SHARED"  # in paths of scenes that are not in the repository: the folder where they are


def path_of_shared(scene, shared):
    """The scene with its folder, or as it is if that is not SHARED; None if it is a whole path and nothing is there."""
    path = scene.replace(SHARED, os.path.abspath(shared), 1)
    return None if os.path.isabs(path) and not os.path.isfile(path) else path


class SmallScene:
    """A scene of the project, or any file, at a small size, and a folder for its renders.

    size: width and height, whatever its film says.
    """

    def __init__(self, scene, out, most_pixels, size=None):
        self.scene = scene
        self.path = scene if os.path.isfile(scene) else os.path.join(ROOT, "scenes", scene + ".pbrt")
        if not os.path.isfile(self.path):
            sys.exit("%s: there is no such scene" % self.path)
        self.folder = os.path.join(out, os.path.splitext(scene)[0].strip("./").replace("/", "-"))
        self.size = size or small_size_of(self.path, most_pixels)
        os.makedirs(self.folder, exist_ok=True)
