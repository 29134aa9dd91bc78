"""The add-on as a user has it: installed from an archive, enabled, called by its operator, with warnings and errors as reports."""
import os
import sys

import bpy

FOLDER = sys.argv[sys.argv.index("--") + 1]
OUT = os.path.join(FOLDER, "operator.pbrt")

bpy.ops.preferences.addon_install(filepath=os.path.join(FOLDER, "lacquer_export.zip"))
bpy.ops.preferences.addon_enable(module="lacquer_export")
bpy.ops.wm.open_mainfile(filepath=os.path.join(FOLDER, "odd.blend"))

bpy.data.objects["Toon"].select_set(True)
assert bpy.ops.export_scene.lacquer(filepath=OUT, only_selected=True, hide_lamps=True) == {"FINISHED"}
with open(OUT, encoding="utf-8") as file:
    text = file.read()
assert text.count("Shape ") == 1 and "Toon" in text, text

# What the export changes for its time is as it was.
assert bpy.ops.export_scene.lacquer(filepath=OUT) == {"FINISHED"}
bpy.ops.wm.open_mainfile(filepath=os.path.join(FOLDER, "camera-wide.blend"))
before = [(o.name, o.hide_viewport, [(m.show_viewport, getattr(m, "levels", 0)) for m in o.modifiers]) for o in bpy.data.objects]
assert bpy.ops.export_scene.lacquer(filepath=OUT) == {"FINISHED"}
after = [(o.name, o.hide_viewport, [(m.show_viewport, getattr(m, "levels", 0)) for m in o.modifiers]) for o in bpy.data.objects]
assert before == after, (before, after)

bpy.ops.wm.open_mainfile(filepath=os.path.join(FOLDER, "no-camera.blend"))
try:
    bpy.ops.export_scene.lacquer(filepath=OUT)
except RuntimeError as error:
    assert "has no camera" in str(error), error
else:
    raise AssertionError("a scene without a camera was exported")
bpy.ops.preferences.addon_disable(module="lacquer_export")
