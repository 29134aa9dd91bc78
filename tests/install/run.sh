#!/usr/bin/env bash
# What `cmake --install` puts in place: tests/install/run.sh BUILD
#   BUILD   folder of a finished build, with LACQUER_INSTALL
# Installs into a folder of its own and asks: are the parts there, does the program run, does it load OpenImageIO by need only and
# say so if it cannot, is the manual page one, do completions complete, and does a program that only knows find_package(Lacquer)
# get the right value of a layered material? Negative controls: without one header it does not compile, and with the archive not
# linked as a whole there is no layered material.
# Ends with a line "N passed, N failed[, N skipped]".
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
build=$(cd "${1:?usage: tests/install/run.sh BUILD}" && pwd) || exit 1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
prefix=$work/prefix
passed=0 failed=0 skipped=0
# check NAME COMMAND...: the command succeeds; if not, what it printed is shown
check() {
    local name=$1; shift
    if "$@" >"$work/log" 2>&1; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1)); echo "FAILED: $name"; tail -n 30 "$work/log"
    fi
}
refuse() { ! "$@"; }
skip() { skipped=$((skipped + 1)); echo "SKIP $1"; }
finish() { echo "$passed passed, $failed failed, $skipped skipped"; [ "$failed" -eq 0 ]; exit; }

check "cmake --install" cmake --install "$build" --prefix "$prefix"
[ "$failed" -eq 0 ] || finish
for part in bin/lacquer bin/gaussfit include/lacquer/measure/scene_material.h \
        share/doc/lacquer/docs/library.md share/lacquer/scenes/first-light.pbrt \
        share/lacquer/blender/lacquer_export/__init__.py share/man/man1/lacquer.1 \
        share/man/man1/gaussfit.1 share/bash-completion/completions/lacquer share/zsh/site-functions/_lacquer \
        share/fish/vendor_completions.d/lacquer.fish; do
    check "installed: $part" test -s "$prefix/$part"
done
archive() { find "$prefix" -path '*lib*' -name liblacquer.a -size +1M | grep .; }
check "installed: the library" archive
loaded=$(find "$prefix" -name liblacquer_openimageio.so -not -path '*-packages/*')
check "installed: what programs load" test -s "$loaded"
check "no installed header shows OpenImageIO" refuse grep -rqF '<OpenImageIO/' "$prefix/include/lacquer"

# ---- The module of Python ----

python=/usr/bin/python3; [ -x "$python" ] || python=python3
if grep -q '^LACQUER_PYTHON:BOOL=ON' "$build/CMakeCache.txt"; then
    module=$(dirname "$(find "$prefix" -name __init__.py -path '*-packages/lacquer/*')")
    for part in py.typed _lacquer.pyi _scenes.py; do check "installed: $part" test -e "$module/$part"; done
    check "installed: the examples" test -x "$prefix/share/doc/lacquer/examples/python/lobe.py"
    check "the installed module evaluates" env -C "$work" PYTHONPATH="$(dirname "$module")" PYTHONDONTWRITEBYTECODE=1 "$python" -c \
        'import lacquer; f = lacquer.material("diffuse").evaluate((0, 0, 1), (0, 0, 1)); assert abs(f.value[1] - 0.159) < 1e-3'
    check "the component installs alone" cmake --install "$build" --prefix "$work/alone" --component python
    # Nothing of the rest is there: it has what it loads.
    module=$(dirname "$(find "$work/alone" -name __init__.py -path '*-packages/lacquer/*')")
    check "the component alone writes and reads images" env -C "$work" PYTHONPATH="$(dirname "$module")" PYTHONDONTWRITEBYTECODE=1 \
        "$python" -c 'import lacquer; lacquer.write_image("p.exr", [[1, 2]]); assert lacquer.read_image("p.exr").pixels.sum() == 3'
    check "nothing else is in it" sh -c "! find '$work/alone' -name 'liblacquer.a' -o -name lacquer -type f | grep ."
else
    skip "the module of Python: the build has none"
fi

# ---- The programs ----

export PATH=$prefix/bin:$PATH
cd "$work" || exit 1
check "an installed scene renders" lacquer "$prefix/share/lacquer/scenes/first-light.pbrt" --resolution 16x12 --spp 1 \
    --quiet --outfile first-light.exr
# loads COMMAND...: the command lets the dynamic linker open OpenImageIO
loads() { LD_DEBUG=files "$@" >trace.txt 2>&1; grep -q 'file=libOpenImageIO\.so.*generating link map' trace.txt; }
tiny=(--resolution 16x12 --spp 1 --quiet)
scene=$prefix/share/lacquer/scenes/first-light.pbrt
echo 'Shape "sphere"' >broken.pbrt
check "--help loads no OpenImageIO" refuse loads lacquer --help
check "a broken scene loads none" refuse loads lacquer broken.pbrt
check "a render to PFM loads none" refuse loads lacquer "$scene" "${tiny[@]}" --outfile first-light.pfm
check "nor does one to EXR" refuse loads lacquer "$scene" "${tiny[@]}" --outfile first-light.exr
check "nor does one to PNG" refuse loads lacquer "$scene" "${tiny[@]}" --outfile first-light.png
check "a render to TIFF loads it" loads lacquer "$scene" "${tiny[@]}" --outfile first-light.tif

# Without what it loads: one message with the file, the folder and the reason, status 3, and no file is touched.
# fails TEXT...: such a render does so, and says all of this
fails() {
    cp first-light.tif before.tif
    lacquer "$scene" "${tiny[@]}" --outfile first-light.tif >message.txt 2>&1; local status=$? text
    cat message.txt
    [ $status -eq 3 ] && [ "$(wc -l <message.txt)" -eq 1 ] && cmp first-light.tif before.tif || return 1
    for text in "error: liblacquer_openimageio.so: " "$@"; do grep -qF -- "$text" message.txt || return 1; done
}
mv "$loaded" kept.so
check "without what it loads, a render to TIFF says so" fails "cannot open shared object file" "$prefix/bin/../"
check "and those to PFM, EXR and PNG need nothing" eval 'lacquer "$scene" "${tiny[@]}" --outfile first-light.pfm &&
    lacquer "$scene" "${tiny[@]}" --outfile first-light.exr && lacquer "$scene" "${tiny[@]}" --outfile first-light.png'
echo "no library" >"$loaded"
check "a file that is no library is named" fails "file too short"
echo 'extern "C" void other() {}' >other.cpp
"${CXX:-c++}" -shared -fPIC -o "$loaded" other.cpp
check "so is a library that is another" fails "undefined symbol"
echo 'extern "C" const void* LacquerOpenImageIO(int) { return nullptr; }' >other.cpp
"${CXX:-c++}" -shared -fPIC -o "$loaded" other.cpp
check "one of another version is refused" fails "another version of Lacquer"
mv kept.so "$loaded"
check "control: with it the same render works" refuse fails

if command -v man >/dev/null; then
    for program in lacquer gaussfit; do
        page() {
            LC_ALL=C.UTF-8 MANWIDTH=80 man --warnings -l "$prefix/share/man/man1/$program.1" >page.txt 2>warnings.txt
            cat warnings.txt; [ ! -s warnings.txt ] && grep -q -- --help-as page.txt
        }
        check "manual page of $program" page
    done
    # Every option of every command: what --help prints is what the page describes.
    commands=$(sed -nE 's/^\.SS "lacquer (.*)"$/\1/p' "$prefix/share/man/man1/lacquer.1")
    check "the manual page has commands" test "$(wc -w <<<"$commands")" -ge 7
    options() { for command in render $commands; do lacquer "$command" --help; done |
        grep -oE '^  (-h,)?--[a-z-]+' | grep -oE -- '--[a-z-]+' | sort -u; }
    for option in $(options); do
        check "the manual page has $option" grep -qF -- "\\fB${option//-/\\-}\\fR" "$prefix/share/man/man1/lacquer.1"
    done
else
    skip "the manual pages: man is not installed"
fi
# complete WORD...: what bash offers for the last word
complete_in_bash() {
    bash --norc -c 'source "$0" && COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) && _lacquer 2>/dev/null
        printf "%s\n" "${COMPREPLY[@]}"' "$prefix/share/bash-completion/completions/lacquer" "$@"
}
# grep reads to the end: who writes to it must not be stopped.
offers() { local wanted=$1; shift; complete_in_bash "$@" | tee /dev/stderr | grep -xF -- "$wanted" >/dev/null; }
check "bash completes commands" offers compare lacquer comp
check "bash completes options of rendering" offers --outfile lacquer scene.pbrt --out
check "bash completes options of commands" offers --wi lacquer bsdf scene.pbrt --w
check "bash completes values" offers fish lacquer --help-as f
check "bash completes estimators" offers bidirectional lacquer bsdf scene.pbrt --estimator bi
check "bash completes lists" offers auto,bidirectional lacquer compare scene.pbrt --estimators auto,bi
check "bash completes densities" offers gaussian lacquer --layered-pdf g
check "bash completes outputs" offers albedo lacquer --aov al
check "bash completes tone maps" offers reinhard lacquer convert a.exr b.png --tonemap r
check "bash completes metrics" offers FLIP lacquer diff a.exr b.exr --metric F
check "bash completes spaces" offers cameraworld lacquer --render-coord-sys c
check "bash completes levels" offers verbose lacquer --log-level v
check "bash completes names of files" offers first-light.exr lacquer --outfile first
check "bash completes scenes" offers first-light.exr lacquer info first
check "bash completes folders" offers prefix lacquer bsdf scene.pbrt --out pre
check "bash offers no files for folders" refuse offers first-light.exr lacquer bsdf scene.pbrt --out first
check "bash offers no files for texts" refuse offers first-light.exr lacquer --resolution first
check "bash offers no files for choices" refuse offers first-light.exr lacquer --estimator first
check "bash offers no options of other commands" refuse offers --wi lacquer diff a.exr --w
for shell in zsh fish; do
    command -v $shell >/dev/null || { skip "completions for $shell: it is not installed"; continue; }
    for file in "$prefix"/share/zsh/site-functions/_* "$prefix"/share/fish/vendor_completions.d/*; do
        [[ $file == */$shell/* ]] && check "$shell reads $(basename "$file")" $shell -n "$file"
    done
done

# ---- The library ----

# program NAME OPTION...: the program, built outside of the tree
program() {
    local name=$1; shift
    cmake -G Ninja -S "$here/program" -B "$work/$name" -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$prefix" "$@" &&
        cmake --build "$work/$name"
}
# is_near FILE VALUE: the three numbers of a line, within 4 of the standard errors behind them (and rounding)
is_near() {
    cat "$1"
    awk -v v="$2" '{ for (i = 1; i <= 3; ++i) { d = $i - v; if (d < 0) d = -d; if (!(d <= 4 * $4 + 1e-6)) bad = 1 }
        if (!($4 < 0.01 * v)) bad = 1; lines++ } END { exit bad || lines != 1 }' "$1"
}
check "a program finds the package" program whole -DLINKED=lacquer
check "it evaluates a layered material" sh -c "whole/evaluate '$here/ink.pbrt' inked >inked.txt"
check "the value is the closed form" is_near inked.txt "$(awk 'BEGIN { print 0.6 / 3.14159265359 * exp(-0.5 * 2 / 0.8) }')"
check "it evaluates a diffuse material" sh -c "whole/evaluate '$here/ink.pbrt' paper >paper.txt"
check "that value is the closed form" is_near paper.txt "$(awk 'BEGIN { print 0.6 / 3.14159265359 }')"
# An image file: the program is linked with OpenImageIO, wherever it stands and whatever is installed beside it.
printf 'PF\n1 1\n-1.0\n\0\0\0\077\0\0\0\077\0\0\0\077' >half.pfm   # 0.5 three times
cat >textured.pbrt <<EOF
WorldBegin
Texture "half" "spectrum" "imagemap" "string filename" "half.pfm"
MakeNamedMaterial "textured" "string type" "diffuse" "texture reflectance" "half"
EOF
mv "$loaded" kept.so
check "it evaluates an image texture" sh -c "whole/evaluate textured.pbrt textured >textured.txt"
mv kept.so "$loaded"
check "that value is the closed form" is_near textured.txt "$(awk 'BEGIN { print 0.5 / 3.14159265359 }')"
# Objects that pass spectra in another way ask for a name that the library has not.
wants() {
    "${CXX:-c++}" -std=c++20 -O1 "$1" -I"$prefix/include/lacquer" -c "$here/program/evaluate.cpp" -o object.o &&
        nm -u object.o | grep -o 'passesSpectraBy[A-Za-z]*' | sort -u >wanted.txt && [ "$(wc -l <wanted.txt)" -eq 1 ]
}
has_wanted() { nm --defined-only "$(archive)" 2>/dev/null >names.txt; [ -s wanted.txt ] && grep -qFf wanted.txt names.txt; }
if grep -q '^flags.* avx ' /proc/cpuinfo && grep -q '^LACQUER_NATIVE:BOOL=ON' "$build/CMakeCache.txt"; then
    check "objects with AVX name their way" wants -mavx
    check "and link with the library" has_wanted
    check "objects without it name another" wants -mno-avx
    check "and do not" refuse has_wanted
else
    skip "objects with AVX: neither the machine nor the library has it"
fi
check "control: 5 % more is noticed" refuse is_near inked.txt "$(awk 'BEGIN { print 0.63 / 3.14159265359 * exp(-0.5 * 2 / 0.8) }')"

# What docs/library.md shows is what was built, and each header that it names can be included alone.
code() { awk -v language="$1" '/^```/ { on = $0 == "```" language; next } on' "$prefix/share/doc/lacquer/docs/library.md"; }
check "the documented program is this one" diff <(code cpp) "$here/program/evaluate.cpp"
check "the documented build file is this one" diff <(code cmake) <(sed 's/\${LINKED}/lacquer/' "$here/program/CMakeLists.txt")
headers=$(grep -oE '`(measure|plot|compare|pbrt)/[a-z_/]+\.h`' "$prefix/share/doc/lacquer/docs/library.md" | tr -d '`' | sort -u)
for header in $headers; do
    echo "#include \"$header\"" >alone.cpp
    check "$header stands alone" "${CXX:-c++}" -std=c++20 -fsyntax-only -I"$prefix/include/lacquer" alone.cpp
done

# As a subdirectory: it configures, every step of the program is known, and no warning of ours is an error there.
subdirectory() {
    mkdir -p outer && cp "$here/program/evaluate.cpp" outer/ && cat >outer/CMakeLists.txt <<EOF
cmake_minimum_required(VERSION 3.25)
project(outer LANGUAGES CXX ASM)
add_subdirectory("$here/../.." lacquer)
add_executable(evaluate evaluate.cpp)
target_link_libraries(evaluate PRIVATE Lacquer::lacquer)
EOF
    cmake -G Ninja -S outer -B outer/build "$@" && cmake --build outer/build --target evaluate -- -n
}
check "a project may have this one as a subdirectory" subdirectory
check "no warnings of ours there" refuse grep -q -e -Werror outer/build/compile_commands.json
counted=(-DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=Release -DLACQUER_GROUP_FOLDERS=ON)
reconfigure() { rm -rf outer/build && cmake -G Ninja -S outer -B outer/build "${counted[@]}" "$@"; }
profiled() { reconfigure "$@" && grep -q -e -fprofile-use outer/build/compile_commands.json; }
if command -v clang++ >/dev/null; then
    check "no counts of ours there" refuse profiled
    check "control: LACQUER_PROFILE=use is seen" profiled -DLACQUER_PROFILE=use
fi
check "control: LACQUER_WERROR is seen" sh -c "cmake -DLACQUER_WERROR=ON outer/build && grep -q -e -Werror outer/build/compile_commands.json"

# ---- Negative controls ----

check "control: a program that takes what it names" program parts -DLINKED=archive
complains() { local wanted=$1; shift; ! "$@" >complaint.txt 2>&1 && { cat complaint.txt; grep -qF "$wanted" complaint.txt; }; }
# Some plugins come along with what it names; those of textures have files of their own.
cat >stone.pbrt <<EOF
WorldBegin
Texture "veins" "spectrum" "marble"
MakeNamedMaterial "stone" "string type" "diffuse" "texture reflectance" "veins"
EOF
check "a program that takes all knows plugins that nothing names" whole/evaluate stone.pbrt stone
check "control: it knows no such plugins" complains '"marble"' parts/evaluate stone.pbrt stone
rm "$prefix/include/lacquer/pbrt/base/bxdf.h"
check "control: a missing header is noticed" complains "pbrt/base/bxdf.h: No such file" program lacking -DLINKED=lacquer
finish
