# Sourced by scripts/render, scripts/python and scripts/test: what a fresh Debian 12 machine needs. Does only what is missing.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { printf '%s\n' "$*" >&2; }

packages=(
    clang lld g++ cmake ninja-build ccache git
    libtbb-dev libembree-dev libopenexr-dev libpng-dev libopenimageio-dev openimageio-tools libglm-dev zlib1g-dev libnanovdb-dev
    libblosc-dev libpugixml-dev
    libfmt-dev libcli11-dev nlohmann-json3-dev libgtest-dev libbenchmark-dev libceres-dev libeigen3-dev libapriltag-dev libjs-chart.js
    python3 python3-numpy python3-openimageio python3-colormath python3-dev pybind11-dev
)

# What the examples in Python draw with, beside them.
python_packages=(python3-matplotlib)

# What the tests need beside them: the compiler's sanitizers, and what judges the text of the sources. Warnings,
# layout and checks differ from version to version: these are those of Debian 12.
test_packages=(libclang-rt-14-dev clang-format-14 clang-tidy-14 python3-pytest "${python_packages[@]}")

# What the test of the report's page needs beside them, as far as the commands are not there: some packages of node bring
# npm along, and some exclude Debian's.
browser_packages() {
    command -v chromium >/dev/null || echo chromium
    command -v node >/dev/null || echo nodejs
    command -v npm >/dev/null || echo npm
}

# Installs the packages that are not there yet, of the list above and of those named: install_packages [PACKAGE ...]
install_packages() {
    local missing=() package
    for package in "${packages[@]}" "$@"; do
        dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
    done
    [ ${#missing[@]} -eq 0 ] && return 0
    if ! command -v apt-get >/dev/null; then
        say "Lacquer needs these Debian packages, or what they are called here: ${missing[*]}"
        return 1
    fi
    local sudo=()
    if [ "$(id -u)" -ne 0 ]; then
        if ! command -v sudo >/dev/null; then
            say "Lacquer needs some packages, and only root may install them. Please run, as root:"
            say "  apt-get update && apt-get install --no-install-recommends ${missing[*]}"
            return 1
        fi
        sudo=(sudo)
    fi
    say "Installing: ${missing[*]}"
    local log; log=$(mktemp)
    if ! { "${sudo[@]}" apt-get update -qq &&
           "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"; } \
            >"$log" 2>&1; then
        cat "$log" >&2
        say "The packages could not be installed; see above."
        return 1
    fi
    rm -f "$log"
}

# Configures a preset, if that is not done yet.
configure() {
    local preset=$1 dir=$root/build/$1
    # A preset that has changed may name another compiler: then from the start.
    if [ ! -f "$dir/build.ninja" ] || [ "$root/CMakePresets.json" -nt "$dir/build.ninja" ]; then
        say "Configuring ($preset)"
        (cd "$root" && cmake --fresh --preset "$preset" >"$root/build-$preset.log" 2>&1) ||
            { cat "$root/build-$preset.log" >&2; rm -f "$root/build-$preset.log"; return 1; }
        rm -f "$root/build-$preset.log"
    fi
}

# Configures and builds a preset: build PRESET [TARGET ...]
build() {
    local preset=$1; shift
    local dir=$root/build/$preset
    configure "$preset" || return 1
    # ninja -n tells in an instant whether there is anything to do.
    if [ "$(ninja -C "$dir" -n "$@" 2>/dev/null | tail -n 1)" = "ninja: no work to do." ]; then return 0; fi
    say "Building ($preset): a few minutes the first time"
    if [ -t 2 ]; then
        ninja -C "$dir" "$@" >&2
    else
        local log; log=$(mktemp)
        ninja -C "$dir" "$@" >"$log" 2>&1 || { tail -n 60 "$log" >&2; rm -f "$log"; return 1; }
        rm -f "$log"
    fi
}
