#!/usr/bin/env bash
# The generator of materials: its unit tests, in one process, for they share one short training, bad input for the program, and
# the converter of published checkpoints. Says that it skips what was not built. Closes with "N passed, N failed, N skipped".
# usage: run.sh BUILD-FOLDER
set -u
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
tests=$1/tests/materialgan/lacquer_materialgan_tests program=$1/src/cmd/lacquer-materialgan
python=/usr/bin/python3; [ -x "$python" ] || python=python3
log=$(mktemp); trap 'rm -f "$log"' EXIT
passed=0 failed=0 skipped=0
if [ -x "$tests" ]; then
    OMP_NUM_THREADS=1 "$tests" --gtest_brief=1 >"$log" 2>&1
    status=$?
    cat "$log"
    passed=$(sed -nE 's/^\[ *PASSED *\] ([0-9]+) tests?.*/\1/p' "$log" | tail -n 1)
    total=$(sed -nE 's/^\[=+\] ([0-9]+) tests? from .* ran.*/\1/p' "$log" | tail -n 1)
    passed=${passed:-0} failed=$((${total:-0} - passed))
    [ $status -ne 0 ] && [ "$failed" -le 0 ] && failed=1  # it crashed
else
    echo "SKIP: built without libtorch (libtorch-dev, -DLACQUER_MATERIALGAN=ON)"
    skipped=1
fi
# Scripts that close with "N passed, N failed"; one that does not has failed.
run_script() {
    "$python" "$@" >"$log" 2>&1
    cat "$log"
    local p f
    p=$(sed -nE 's/^([0-9]+) passed.*/\1/p' "$log" | tail -n 1) f=$(sed -nE 's/^[0-9]+ passed, ([0-9]+) failed.*/\1/p' "$log" | tail -n 1)
    passed=$((passed + ${p:-0})) failed=$((failed + ${f:-1}))
}
[ -x "$program" ] && OMP_NUM_THREADS=1 run_script "$here/broken.py" "$program"
run_script "$here/convert.py"
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ]
