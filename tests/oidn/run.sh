#!/usr/bin/env bash
# Builds the adapter for Open Image Denoise against a double of the library, as find_package finds it, and tests it: with
# versions 2 and 1.4, with one that is too old, and without any. usage: tests/oidn/run.sh
# Ends with a line "N passed, N failed".
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
passed=0 failed=0
# try VERSION|none EXPECTED: builds and runs; EXPECTED is 1 where the library is to be taken.
try() {
    local version=$1 expected=$2 build=$folder/build-$1 log=$folder/$1.log options=(-DCMAKE_DISABLE_FIND_PACKAGE_OpenImageDenoise=ON)
    if [ "$version" != none ]; then
        local prefix=$folder/prefix-$version/lib/cmake/OpenImageDenoise
        mkdir -p "$prefix"
        cp -r "$here/double/." "$prefix"
        cat >"$folder/version.cmake" <<END
include(CMakePackageConfigHelpers)
write_basic_package_version_file($prefix/OpenImageDenoiseConfigVersion.cmake VERSION $version COMPATIBILITY SameMajorVersion
    ARCH_INDEPENDENT)
END
        cmake -P "$folder/version.cmake"
        options=("-DCMAKE_PREFIX_PATH=$folder/prefix-$version")
    fi
    local found=0
    if cmake -S "$here" -B "$build" -DCMAKE_BUILD_TYPE=Debug "${options[@]}" "${@:3}" >"$log" 2>&1 &&
        cmake --build "$build" >>"$log" 2>&1; then
        "$build/adapter_test" >>"$log" 2>&1 || true
        grep -q '^-- Open Image Denoise' "$log" && found=1
    fi
    local line; line=$(grep -E '^[0-9]+ passed, [0-9]+ failed' "$log" | tail -n 1 || true)
    if [ -z "$line" ] || [ "$found" != "$expected" ]; then
        echo "$version: taken: $found, expected: $expected"
        cat "$log"
        failed=$((failed + 1))
        return
    fi
    grep FAILED "$log" || true
    passed=$((passed + ${line%% *} + 1)) failed=$((failed + $(sed -E 's/.*, ([0-9]+) failed/\1/' <<<"$line")))
}
try 2.3.3 1
try 1.4.3 1
try 1.3.0 0
try none 0
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
