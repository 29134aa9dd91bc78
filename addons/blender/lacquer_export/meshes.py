"""Objects of the evaluated scene: geometry with modifiers as PLY files, and instances where several objects share it."""
from dataclasses import dataclass, field

import numpy as np

from . import ply
from .expressions import is_constant
from .report import where_of

GEOMETRY = {"MESH", "CURVE", "SURFACE", "FONT", "META"}


@dataclass
class Part:
    """The triangles of one material slot of a mesh: a file, and what they look like."""
    path: str
    surface: object


@dataclass
class Shared:
    """Geometry with its materials, and the matrices of the objects that have it."""
    name: str
    parts: list
    matrices: list = field(default_factory=list)


class Meshes:
    def __init__(self, materials, assets, report):
        self.materials = materials
        self.assets = assets
        self.report = report
        self.shared = {}
        self.count = 0

    def add(self, owner, matrix):
        """An object of the evaluated scene, at a place."""
        slots = tuple(slot.material.original if slot.material else None for slot in owner.material_slots)
        # Meshes with modifiers have data of their own; what is no mesh yet becomes one for each object.
        made_of = owner.data if owner.type == "MESH" else owner.original
        key = (owner.type, made_of.as_pointer(), slots)
        if key not in self.shared:
            self.shared[key] = Shared(owner.name, self.parts(owner, slots))
        if self.shared[key].parts:
            self.shared[key].matrices.append(matrix)
            self.count += 1

    def parts(self, owner, slots):
        mesh = owner.to_mesh()
        if mesh is None:
            return []
        try:
            return self.split(owner, mesh, slots)
        finally:
            owner.to_mesh_clear()

    def split(self, owner, mesh, slots):
        """A part for each material of the mesh."""
        triangles = Triangles(mesh)
        if not triangles.is_finite():
            self.report.warn(where_of(owner.original), "has vertices that are no numbers; it is left out")
            return []
        used = np.unique(np.clip(triangles.materials, 0, max(len(slots) - 1, 0)))
        parts = []
        for index in used:
            material = slots[index] if slots else None
            chosen = np.clip(triangles.materials, 0, max(len(slots) - 1, 0)) == index
            name = owner.name if len(used) == 1 else f"{owner.name}-{material.name if material else index}"
            surface = self.materials.surface(material)
            if surface.material is None and surface.emission is None:
                continue
            parts.append(Part(self.assets.write(name, ".ply", triangles.encode(chosen)), surface))
        return parts

    def write(self, text, textures):
        """Each geometry once: in place, or as an object with instances where it occurs more often."""
        for shared in self.shared.values():
            emits = any(part.surface.emission for part in shared.parts)
            if len(shared.matrices) < 2 or emits:  # objects cannot emit
                for matrix in shared.matrices:
                    text.comment(shared.name)
                    text.begin("AttributeBegin")
                    text.transform(matrix)
                    write_parts(text, textures, shared.parts, self.report)
                    text.end("AttributeEnd")
                continue
            name = text.unique(shared.name)
            text.begin("ObjectBegin", name)
            write_parts(text, textures, shared.parts, self.report)
            text.end("ObjectEnd")
            for matrix in shared.matrices:
                text.begin("AttributeBegin")
                text.transform(matrix)
                text.directive("ObjectInstance", name)
                text.end("AttributeEnd")


def write_parts(text, textures, parts, report):
    for part in parts:
        surface = part.surface
        params = [("string", "filename", part.path)]
        if not is_constant(surface.alpha, 1):
            params.append(textures.float_parameter("alpha", surface.alpha))
        if surface.emission:
            text.begin("AttributeBegin")
            write_emission(text, textures, surface.emission, report)
        text.directive("NamedMaterial", surface.material)
        text.directive("Shape", "plymesh", params=params)
        if surface.emission:
            text.end("AttributeEnd")


def write_emission(text, textures, emission, report):
    """Meshes of Blender shine to both sides."""
    color, strength = emission
    params = [("float", "scale", strength), ("bool", "twosided", True)]
    if hasattr(color, "value"):
        params.insert(0, ("rgb", "L", color.color()))
    elif hasattr(color, "image") and color.channel == "color" and not color.functions:
        params.insert(0, ("string", "filename", textures.images.color_file(color.image)[0]))
        if color.scale != (1.0, 1.0) or color.offset != (0.0, 0.0):
            report.warn(f"image \"{color.image.name}\"", "the mapping of an emission is not translated; plain uv is taken instead")
    else:
        report.warn("emission", "only plain images and colours can emit; white is taken instead")
        params.insert(0, ("rgb", "L", (1, 1, 1)))
    text.directive("AreaLightSource", "diffuse", params=params)


class Triangles:
    """The triangles of a mesh, with normals and uv at their corners."""

    def __init__(self, mesh):
        mesh.calc_loop_triangles()
        mesh.calc_normals_split()  # flat, smooth, by angle, custom: all of it ends in the normals of corners
        count = len(mesh.loop_triangles)
        self.positions = read(mesh.vertices, "co", len(mesh.vertices), 3)
        self.corners = read(mesh.loop_triangles, "vertices", count, 3, np.int32)
        self.materials = read(mesh.loop_triangles, "material_index", count, 1, np.int32)[:, 0]
        self.normals = read(mesh.loop_triangles, "split_normals", count * 3, 3).reshape(count, 3, 3)
        loops = read(mesh.loop_triangles, "loops", count, 3, np.int32)
        layer = mesh.uv_layers.active and next((l for l in mesh.uv_layers if l.active_render), mesh.uv_layers.active)
        self.uvs = read(layer.data, "uv", len(mesh.loops), 2)[loops] if layer else None
        polygons = read(mesh.polygons, "use_smooth", len(mesh.polygons), 1, bool)[:, 0]
        self.is_flat = not polygons.any() and not mesh.has_custom_normals

    def is_finite(self):
        return bool(np.isfinite(self.positions).all())

    def encode(self, chosen):
        """The PLY file of some triangles; corners with the same position, normal and uv are one vertex."""
        columns = [self.positions[self.corners[chosen]]]
        if not self.is_flat:
            columns.append(self.normals[chosen])
        if self.uvs is not None:
            columns.append(self.uvs[chosen])
        rows = np.concatenate(columns, axis=2).reshape(-1, sum(c.shape[2] for c in columns))
        rows = np.ascontiguousarray(rows.astype(np.float32) + np.float32(0))  # no negative zeros
        keys = rows.view([("", rows.dtype)] * rows.shape[1])[:, 0]
        _, first, faces = np.unique(keys, return_index=True, return_inverse=True)
        vertices = rows[first]
        at = 3
        normals = uvs = None
        if not self.is_flat:
            normals, at = vertices[:, 3:6], 6
        if self.uvs is not None:
            uvs = vertices[:, at:at + 2]
        return ply.encode(vertices[:, :3], faces.reshape(-1, 3), normals, uvs)


def read(collection, attribute, count, width, dtype=np.float32):
    values = np.empty(count * width, dtype=dtype)
    collection.foreach_get(attribute, values)
    return values.reshape(count, width)
