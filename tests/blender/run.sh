#!/usr/bin/env bash
# Tests of the exporter for Blender: tests/blender/run.sh LACQUER [FOLDER]
#   LACQUER   the program
#   FOLDER    where the scenes, their exports and images are left; by default a temporary one
# Makes scenes by Blender's Python, renders them by Cycles, exports them, renders what was exported, and compares. Skips with the
# reason where Blender (or its Cycles) is not there. Takes about four minutes. Ends with a line "N passed, N failed, N skipped".
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
lacquer=$(realpath "${1:?usage: tests/blender/run.sh LACQUER [FOLDER]}") || exit 1
python=/usr/bin/python3; [ -x "$python" ] || python=python3
blender=${BLENDER:-blender}
skip() { echo "SKIP the exporter for Blender: $1"; echo "0 passed, 0 failed, 1 skipped"; exit 0; }
command -v "$blender" >/dev/null || skip "there is no program $blender (apt-get install blender)"
"$python" -c "import numpy, OpenImageIO" 2>/dev/null || skip "$python lacks numpy or OpenImageIO"
work=${2:-}
if [ -z "$work" ]; then work=$(mktemp -d); trap 'rm -rf "$work"' EXIT; fi
mkdir -p "$work" && work=$(cd "$work" && pwd) || exit 1
export PYTHONDONTWRITEBYTECODE=1
run_blender() { "$blender" --background --factory-startup --python-exit-code 70 "$@"; }
run_blender --python-expr 'import bpy, numpy; bpy.context.scene.render.engine = "CYCLES"' >"$work/log" 2>&1 ||
    skip "$blender has no Cycles or no numpy: $(grep -m 1 Error "$work/log")"
if ! run_blender --python "$here/make_scenes.py" -- "$work" >"$work/log" 2>&1; then
    tail -n 30 "$work/log"
    echo "FAILED: the scenes could not be made"
    echo "0 passed, 1 failed, 0 skipped"
    exit 1
fi
passed=0 failed=0
# count LINE: adds up "N passed, N failed"
count() { read -r p f < <(sed -nE 's/^([0-9]+) passed, ([0-9]+) failed.*/\1 \2/p' <<<"$1"); passed=$((passed + ${p:-0})) failed=$((failed + ${f:-1})); }
"$python" "$here/check.py" "$lacquer" "$work" | tee "$work/log"
count "$(tail -n 1 "$work/log")"

# The operator of the menu, as a user has it: installed from an archive, enabled, called.
(cd "$here/../../addons/blender" && "$python" -m zipfile -c "$work/lacquer_export.zip" lacquer_export) || failed=$((failed + 1))
mkdir -p "$work/scripts/addons"
export BLENDER_USER_SCRIPTS=$work/scripts
if run_blender --python "$here/operator_check.py" -- "$work" >"$work/log" 2>&1; then passed=$((passed + 1)); else
    failed=$((failed + 1)); tail -n 30 "$work/log"; echo "FAILED: the operator"
fi
echo "$passed passed, $failed failed, 0 skipped"
[ "$failed" -eq 0 ]
