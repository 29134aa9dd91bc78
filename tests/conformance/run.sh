#!/usr/bin/env bash
# Renders the conformance scenes and compares them with their references.
# usage: run.sh LACQUER [NAME ...]
# Without names: every scene that is not listed in not-yet.txt must pass, and every listed one must still be refused
# with exit status 2 (a scene of the list that renders has to leave the list). Those of known-differences.txt pass
# within limits of their own.
set -u
lacquer=$(realpath "$1"); shift
here=$(cd "$(dirname "$0")" && pwd)
out=$(mktemp -d); trap 'rm -rf "$out"' EXIT
# The system's python has the image library; another python may come first in PATH.
python=/usr/bin/python3; [ -x "$python" ] || python=python3

waiting=$(sed -e 's/#.*//' "$here/not-yet.txt" | awk 'NF {print $1}')
failed=0
if [ $# -gt 0 ]; then
    names=("$@")
else
    names=()
    for scene in "$here"/*.pbrt; do
        name=$(basename "$scene" .pbrt)
        if grep -qx "$name" <<<"$waiting"; then
            "$lacquer" "$scene" --quiet --spp 1 --resolution 8x8 --outfile "$out/waiting.exr" >"$out/log" 2>&1
            status=$?
            if [ $status -ne 2 ]; then
                echo "FAIL  $name is listed in not-yet.txt, but exits with status $status instead of 2"
                failed=$((failed + 1))
            fi
        else
            names+=("$name")
        fi
    done
    for name in $waiting; do
        [ -f "$here/$name.pbrt" ] || { echo "FAIL  not-yet.txt names $name, which is no scene"; failed=$((failed + 1)); }
    done
    for name in $(sed -e 's/#.*//' "$here/known-differences.txt" | awk 'NF {print $1}'); do
        [ -f "$here/$name.pbrt" ] ||
            { echo "FAIL  known-differences.txt names $name, which is no scene"; failed=$((failed + 1)); }
    done
fi
# The limits are the same at all samples, and are about errors: what keeps them at 64 has no error that 256 would show, but
# for one that 64 samples' noise happens to take back. What does not is rendered with four times as many.
render() {
    local spp=$1 name; shift
    for name in "$@"; do
        rm -f "$out/$name.exr"
        "$lacquer" "$here/$name.pbrt" --quiet --spp "$spp" --outfile "$out/$name.exr" >"$out/log" 2>&1 ||
            { echo "FAIL  $name: exit status $?"; cat "$out/log"; }
    done
}
render 64 "${names[@]}"
"$python" "$here/compare.py" "$out" "${names[@]}" >"$out/first"
mapfile -t again < <(awk '$1 == "FAIL" {print $2}' "$out/first")
if [ ${#again[@]} -gt 0 ]; then
    echo "rendered again, with 256 samples: ${again[*]}"
    render 256 "${again[@]}"
    "$python" "$here/compare.py" "$out" "${names[@]}" || failed=$((failed + 1))
else
    cat "$out/first"
fi
exit $((failed > 0))
