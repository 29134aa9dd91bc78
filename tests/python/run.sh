#!/usr/bin/env bash
# Tests of the module of Python: tests/python/run.sh BUILD
#   BUILD   folder of a finished build, with LACQUER_PYTHON
# Runs pytest on this folder, and both examples on small inputs. Ends with a line "N passed, N failed, N skipped".
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
build=$(cd "${1:?usage: tests/python/run.sh BUILD}" && pwd) || exit 1
python=/usr/bin/python3; [ -x "$python" ] || python=python3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if ! "$python" -c "import pytest, numpy" 2>"$work/log"; then
    echo "SKIP the module of Python: $(tail -n 1 "$work/log")"
    echo "0 passed, 0 failed, 1 skipped"
    exit 0
fi
export PYTHONPATH=$build/python PYTHONDONTWRITEBYTECODE=1 MPLCONFIGDIR=$work
"$python" -m pytest -q -p no:cacheprovider --basetemp "$work/pytest" "$here" --lacquer "$build/src/cmd/lacquer" | tee "$work/log"
last=$(tail -n 1 "$work/log")
count() { sed -nE "s/.*\b([0-9]+) $1.*/\1/p" <<<"$last" | grep . || echo 0; }
passed=$(count passed) failed=$(($(count failed) + $(count error))) skipped=$(count skipped)
[ "$passed" -gt 0 ] || failed=$((failed + 1))

# check NAME COMMAND...: the command succeeds; if not, what it printed is shown
check() {
    local name=$1; shift
    if "$@" >"$work/log" 2>&1; then passed=$((passed + 1)); else
        failed=$((failed + 1)); echo "FAILED: $name"; tail -n 30 "$work/log"
    fi
}
if "$python" -c "import matplotlib" 2>"$work/log"; then
    examples=$here/../../examples/python
    check "the lobe is drawn" "$python" "$examples/lobe.py" "$work/lobe.png"
    check "it is an image" test -s "$work/lobe.png"
    check "estimators are compared" "$build/src/cmd/lacquer" compare "$here/../../scenes/first-light.pbrt" --resolution 48x27 \
        --estimators bidirectional,auto --equal-samples 2 --runs 2 --reference-spp 16 --quiet --out "$work/compared"
    check "the comparison is drawn" "$python" "$examples/equal_time.py" "$work/compared/results.json" "$work/compared.png"
    check "it is an image" test -s "$work/compared.png"
    check "control: other JSON is refused" sh -c "echo '{}' >'$work/other.json'; ! '$python' '$examples/equal_time.py' '$work/other.json'"
else
    skipped=$((skipped + 1)); echo "SKIP the examples: matplotlib is not installed"
fi
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ]
