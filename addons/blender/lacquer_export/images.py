"""Images of Blender as files that the format reads: copied where they can be, computed where they cannot."""
import os

import numpy as np

from . import optics, pfm, png
from .report import ExportFileError

# Formats that both read alike, by Blender's name, and the extension of the copy.
COPIED = {"PNG": ".png", "JPEG": ".jpg", "TARGA": ".tga", "TARGA_RAW": ".tga", "BMP": ".bmp", "HDR": ".hdr", "OPEN_EXR": ".exr",
          "OPEN_EXR_MULTILAYER": None, "TIFF": None}
LINEAR_SPACES = {"Non-Color", "Raw", "Linear", "Linear Rec.709", "Linear BT.709"}
FLOAT_FORMATS = {"HDR", "OPEN_EXR"}


class Images:
    def __init__(self, assets, report):
        self.assets = assets
        self.report = report
        self.paths = {}
        self.uv_maps = []

    def note_uv_map(self, graph, node):
        """Meshes have one uv map in the scene, the active one of each: objects say later whether that is the one meant."""
        self.uv_maps.append((graph, node))

    def check_uv_maps(self, objects):
        """Warns of nodes that name a uv map which some mesh with their material does not show."""
        for graph, node in self.uv_maps:
            for owner in objects:
                names = [layer.name for layer in getattr(owner.data, "uv_layers", []) if layer.active_render]
                if graph.owner in [slot.material for slot in owner.material_slots] and names and names[0] != node.uv_map:
                    graph.warn(node, f"the uv map \"{node.uv_map}\" of \"{owner.name}\" is not translated; its active one "
                                     f"\"{names[0]}\" is taken instead")

    def usable(self, graph, node):
        """The image of a node, or None with a warning about why not (the caller says what is taken instead)."""
        image = node.image
        if image is None:
            return None
        if image.source in ("SEQUENCE", "MOVIE"):
            graph.warn(node, f"image \"{image.name}\" is animated; its frame of now is taken instead")
        if image.source == "TILED":
            graph.warn(node, f"image \"{image.name}\" has tiles; its first tile is taken instead")
        if image.size[0] == 0 or image.size[1] == 0 or image.channels == 0 or not len(image.pixels):
            graph.warn(node, f"image \"{image.name}\" ({image.filepath}) cannot be read")
            return None
        space = image.colorspace_settings.name
        if space != "sRGB" and space not in LINEAR_SPACES:
            graph.warn(node, f"colour space \"{space}\" of image \"{image.name}\" is not translated; sRGB is taken instead")
        return image

    def color_file(self, image):
        """(path, encoding) of a file with the image's own colours."""
        key = (image.name_full, "color")
        if key not in self.paths:
            self.paths[key] = self.copied(image) or (self.computed(image, "color", ()), "linear")
        return self.paths[key]

    def number_file(self, image, channel, functions):
        """The path of a grey linear file: the luminance, or the alpha, after functions."""
        key = (image.name_full, "number", channel, functions)
        if key not in self.paths:
            self.paths[key] = self.computed(image, "luminance" if channel == "color" else channel, functions)
        return self.paths[key]

    def mapped_file(self, image, functions):
        """The path of a linear colour file after functions."""
        key = (image.name_full, "mapped", functions)
        if key not in self.paths:
            self.paths[key] = self.computed(image, "color", functions)
        return self.paths[key]

    def normal_file(self, image, strength):
        """The path of a normal map, as stored, with its slope multiplied."""
        key = (image.name_full, "normal", round(strength, 6))
        if key not in self.paths:
            values = pixels_of(image)[:, :, :3]
            normal = values * 2 - 1
            normal[:, :, :2] *= strength
            normal /= np.maximum(np.linalg.norm(normal, axis=2, keepdims=True), 1e-9)
            self.paths[key] = self.assets.write(stem_of(image), ".png", png.encode(normal * 0.5 + 0.5))
        return self.paths[key]

    def copied(self, image):
        """(path, encoding) of a copy of the file, packed or on disk; None where the file cannot be used as it is."""
        extension = COPIED.get(image.file_format)
        is_linear = image.colorspace_settings.name in LINEAR_SPACES
        if extension is None or image.is_dirty or image.source not in ("FILE", "SEQUENCE"):
            return None
        if is_linear and image.file_format not in FLOAT_FORMATS | {"PNG"}:
            return None  # the format decodes 8-bit files that are no PNG as sRGB
        if not is_linear and image.file_format in FLOAT_FORMATS:
            return None  # and takes these as linear
        if image.packed_file:
            data = image.packed_file.data
        else:
            path = bpy_path(image)
            if not os.path.isfile(path):
                return None
            try:
                with open(path, "rb") as file:
                    data = file.read()
            except OSError as error:
                raise ExportFileError(f"{path}: cannot be read: {error.strerror}") from error
        encoding = "linear" if is_linear else "sRGB"
        return self.assets.write(stem_of(image), extension, data), encoding

    def computed(self, image, channel, functions):
        values = pixels_of(image)
        if channel == "alpha":
            values = values[:, :, 3] if values.shape[2] > 3 else np.ones(values.shape[:2])
        else:
            values = linear_colors(image, values)
            if channel == "luminance":
                values = optics.luminance(np.moveaxis(values, 2, 0))
        for function in functions:
            values = function(values)
        name = "-".join([stem_of(image)] + ([channel] if channel != "color" else []) + [f.name for f in functions])
        if image.is_float or any(f.is_unbounded for f in functions):
            return self.assets.write(name, ".pfm", pfm.encode(values))
        return self.assets.write(name, ".png", png.encode(values))


def bpy_path(image):
    import bpy
    return bpy.path.abspath(image.filepath, library=image.library)


def stem_of(image):
    return os.path.splitext(os.path.basename(image.name))[0]


def pixels_of(image):
    """(height, width, channels) as stored, rows from the top."""
    values = np.empty(len(image.pixels), dtype=np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], image.channels)[::-1].astype(np.float64)


def linear_colors(image, values):
    """(height, width, 3) linear values: images of bytes are as stored, those of floats already linear."""
    values = values[:, :, :3] if values.shape[2] >= 3 else np.repeat(values[:, :, :1], 3, axis=2)
    is_encoded = not image.is_float and image.colorspace_settings.name not in LINEAR_SPACES
    return optics.srgb_to_linear(values) if is_encoded else values
