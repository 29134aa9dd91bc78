"""Exports a .blend file without a window: blender --background --factory-startup --python headless.py -- SCENE.blend OUT.pbrt

Called by scripts/blender-export, which has the help. Exit status: 0; 2 if the scene cannot be exported; 3 if a file cannot be
read or written.
"""
import os
import sys

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from lacquer_export.export import Options, export  # noqa: E402  (after the path)
from lacquer_export.report import ExportError, ExportFileError  # noqa: E402


def say(text):
    print(text, file=sys.stderr, flush=True)


def main(arguments):
    options = Options("--only-selected" in arguments, "--hide-lamps" in arguments)
    blend, out = [a for a in arguments if not a.startswith("--")]
    try:
        bpy.ops.wm.open_mainfile(filepath=os.path.abspath(blend))
    except RuntimeError as error:
        say(f"error: {blend}: cannot be read: {str(error).splitlines()[0].removeprefix('Error: ')}")
        return 3
    try:
        summary = export(bpy.context, os.path.abspath(out), options, lambda text: say("warning: " + text))
    except ExportError as error:
        say(f"error: {error}")
        return 3 if isinstance(error, ExportFileError) else 2
    say(f"{out}: {summary.objects} objects, {summary.lamps} lamps, {len(summary.warnings)} warnings")
    return 0


sys.exit(main(sys.argv[sys.argv.index("--") + 1:]))
