"""Add-on of Blender: File > Export > Lacquer / pbrt-v4 (.pbrt). docs/blender.md says what is translated and how."""
import bpy
from bpy.props import BoolProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from .export import Options, export
from .report import ExportError

bl_info = {
    "name": "Lacquer / pbrt-v4 format",
    "author": "The authors of Lacquer",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "File > Export > Lacquer / pbrt-v4 (.pbrt)",
    "description": "Exports scenes for Lacquer: Principled materials become layered ones",
    "category": "Import-Export",
}


class EXPORT_SCENE_OT_lacquer(bpy.types.Operator, ExportHelper):
    """Write the scene for Lacquer, with its meshes and images in a folder beside it"""
    bl_idname = "export_scene.lacquer"
    bl_label = "Export for Lacquer"
    bl_options = {"PRESET"}

    filename_ext = ".pbrt"
    filter_glob: StringProperty(default="*.pbrt", options={"HIDDEN"})
    only_selected: BoolProperty(name="Selected objects only", default=False)
    hide_lamps: BoolProperty(name="Hide lamps", default=False,
                             description="Lamps with a size light the scene, but neither the camera nor mirrors see them")

    def execute(self, context):
        options = Options(self.only_selected, self.hide_lamps)
        try:
            summary = export(context, self.filepath, options, lambda text: self.report({"WARNING"}, text))
        except ExportError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{summary.objects} objects, {summary.lamps} lamps, {len(summary.warnings)} warnings")
        return {"FINISHED"}


def menu(self, context):
    self.layout.operator(EXPORT_SCENE_OT_lacquer.bl_idname, text="Lacquer / pbrt-v4 (.pbrt)")


def register():
    bpy.utils.register_class(EXPORT_SCENE_OT_lacquer)
    bpy.types.TOPBAR_MT_file_export.append(menu)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(menu)
    bpy.utils.unregister_class(EXPORT_SCENE_OT_lacquer)
