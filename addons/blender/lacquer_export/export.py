"""Exports a scene of Blender: a .pbrt file and a folder of meshes and images beside it."""
import os
from dataclasses import dataclass

import bpy

from . import camera, lights, world
from .assets import Assets, write_whole
from .images import Images
from .materials import Materials
from .meshes import GEOMETRY, Meshes
from .render_view import render_settings, rendered_objects
from .report import ExportFileError, Report, where_of
from .scene_text import SceneText
from .textures import Textures


@dataclass
class Options:
    only_selected: bool = False
    hide_lamps: bool = False  # lamps with a size light the scene but are not seen themselves


@dataclass
class Summary:
    objects: int
    lamps: int
    warnings: list


def export(context, path, options=None, listener=None):
    """Writes the scene of `context` and returns a Summary; ExportError where it cannot be written. Warnings go to `listener`."""
    options = options or Options()
    report = Report(listener)
    path = os.path.abspath(bpy.path.abspath(path))
    if not os.path.isdir(os.path.dirname(path)):
        raise ExportFileError(f"{path}: its folder does not exist")
    if os.path.isdir(path):
        raise ExportFileError(f"{path}: is a folder")
    with render_settings(context):
        text, counts = describe(context, path, options, report)
    write_whole(path, text.encode("utf-8"))
    return Summary(*counts, report.warnings)


def describe(context, path, options, report):
    """The text of the scene; meshes and images are written on the way."""
    depsgraph = context.evaluated_depsgraph_get()
    head, body, placed = SceneText(), SceneText(), SceneText()
    head.comment(f"Scene \"{context.scene.name}\", frame {context.scene.frame_current}, by the exporter of Lacquer for Blender")
    camera.write(head, context.scene, depsgraph, report, path)
    placed.names = body.names  # one set of names
    assets = Assets(path)
    images = Images(assets, report)
    textures = Textures(body, images)
    materials = Materials(body, textures, images, report)
    meshes = Meshes(materials, assets, report)
    world.write(placed, context.scene.world, report, images)
    num_lamps = visit(context, depsgraph, options, report, meshes, placed, images)
    meshes.write(placed, textures)
    images.check_uv_maps(context.scene.objects)
    return "\n".join([head.text(), "WorldBegin\n", body.text(), placed.text()]), (meshes.count, num_lamps)


def visit(context, depsgraph, options, report, meshes, placed, images):
    """All that the evaluated scene shows, instances of collections and of geometry nodes included. Returns the number of lamps."""
    shown = rendered_objects(context.view_layer)
    num_lamps = 0
    # Curves and texts come twice: as themselves, and as the mesh that they become.
    meshed = {i.object.original for i in depsgraph.object_instances if i.object.type == "MESH" and i.object.original.type != "MESH"}
    for instance in depsgraph.object_instances:
        owner, original = instance.object, instance.object.original
        base = instance.parent.original if instance.is_instance else original
        if not instance.show_self or original.hide_render or base not in shown:
            continue
        if options.only_selected and not base.select_get():
            continue
        matrix = instance.matrix_world.copy()
        if owner.type == "LIGHT":
            num_lamps += lights.write(placed, owner.data, matrix, report, images, options.hide_lamps)
        elif owner.type in GEOMETRY and (owner.type == "MESH" or original not in meshed):
            if abs(matrix.to_3x3().determinant()) < 1e-30:
                report.warn(where_of(original), "has a scale of 0; it is left out")
                continue
            meshes.add(owner, matrix)
        elif owner.type in ("VOLUME", "CURVES", "HAIR", "POINTCLOUD", "GPENCIL"):
            report.warn(where_of(original), f"objects of type {owner.type} are not translated; it is left out")
    warn_particles(shown, report)
    return num_lamps


def warn_particles(objects, report):
    for owner in objects:
        for system in getattr(owner, "particle_systems", []):
            if system.settings.render_type == "PATH":
                report.warn(where_of(owner), f"hair of particle system \"{system.name}\" is not translated; it is left out")
