#!/usr/bin/env python3
"""Checks who includes whom in src against the levels of docs/architecture.md.

usage: check_includes.py
Also that only cmd prints and reads the environment and the time of day, and that integrators leave to TracedPath what they could forget.
Prints each violation and a closing line 'N passed, N failed'. The check is itself checked: a made-up violation of each
rule must be found.
"""
import os
import re
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "src")

# Inside src/pbrt each folder may include lower levels and its own folder; folders of level 1 do not know each other,
# but for the few edges below.
LEVEL = {
    "core": 0,
    "base": 1, "scattering": 1, "image": 1,
    "bxdfs": 2, "textures": 2, "shapes": 2, "cameras": 2, "samplers": 2, "filters": 2, "film": 2, "phases": 2, "guiding": 2,
    "media": 3, "materials": 3, "lights": 3, "accel": 3,
    "scene": 4,
    "integrators": 5,
}
# Material and TextureLibrary hold images; the interface headers only name the type.
EXTRA_EDGES = {("base", "image")}
# Heavy libraries and the only files that may include them.
HEAVY = {
    "embree": {"pbrt/accel/embree.cpp"},
    "OpenImageIO": {f"pbrt/image/openimageio/{name}" for name in ["openimageio.cpp", "tiles.cpp", "value_type.h"]},
    "dlfcn.h": {"pbrt/core/loaded_module.cpp"},
    "OpenImageDenoise": {"denoise/oidn.cpp"},
    "OpenEXR": {"pbrt/image/exr_file.cpp"},
    "Imath": {"pbrt/image/exr_file.cpp"},
    "nanovdb": {"pbrt/media/nanovdb_file.cpp"},
    "blosc": {"pbrt/film/state_file.cpp", "pbrt/media/nanovdb_file.cpp"},
    "ceres": {"gaussfit/fit/polynomial_fit.cpp", "estimate/mode/emulated_mode.cpp", "estimate/mode/find_modes.cpp",
              "capture/card/calibration.cpp"},
    "pybind11": {f"python/{name}" for name in ["errors.cpp", "errors.h", "images.cpp", "interruptible.cpp", "interruptible.h",
                                               "materials.cpp", "module.cpp", "module.h", "scenes.cpp"]},
    "mpi.h": {"mpi/open_mpi.cpp"},
    "apriltag": {"capture/card/tags.cpp"},
    "pugixml.hpp": {"materialx/document.cpp"},
    "torch/": {"materialgan/network/tensors.h"},
    "ATen/": {"materialgan/network/tensors.cpp", "materialgan/network/upsampling.cpp"},
}

LOADED = "pbrt/image/openimageio/"
# Folders of materialgan whose headers show tensors of libtorch.
TENSORS = tuple(f"materialgan/{folder}/" for folder in ["network", "training", "fit"])

# What the modules beside pbrt may include, of src. Nothing includes cmd but cmd itself.
MODULES = {
    "pbrt": {"pbrt"},
    "gaussfit": {"pbrt", "gaussfit"},
    "layered": {"pbrt", "gaussfit", "layered"},
    "compare": {"pbrt", "denoise", "compare"},
    "denoise": {"pbrt", "denoise"},
    "materialx": {"pbrt", "materialx"},
    "measure": {"pbrt", "layered", "measure"},
    "plot": {"pbrt", "plot"},
    "bulk": {"pbrt", "bulk"},
    "mpi": {"mpi"},
    "estimate": {"pbrt", "estimate"},
    "estimate/scene": {"pbrt", "measure", "estimate", "estimate/scene"},
    "capture": {"pbrt", "capture"},
    "materialgan": {"pbrt", "capture", "materialgan"},
    "python": {"pbrt", "layered", "compare", "denoise", "measure", "python"},
    "cmd": {"pbrt", "gaussfit", "layered", "compare", "denoise", "materialx", "measure", "plot", "bulk", "estimate", "estimate/scene", "capture", "materialgan", "mpi", "cmd"},
}
# Of pbrt, plot draws images and knows no scenes; bulk computes what scenes read, and knows none of their types; the models of
# estimate are functions of their own, on images.
SEES_OF_PBRT = {"denoise": {"core", "image"}, "plot": {"core", "image"}, "bulk": {"core", "scattering"}, "estimate": {"core", "image"},
                "capture": {"core", "image"}, "materialgan": {"core", "image"}}


def module(path):
    parts = path.split("/")
    if parts[0] == "pbrt":
        return "pbrt", parts[1]
    # What of the estimation knows the renderer is a module of its own.
    if parts[:2] == ["estimate", "scene"]:
        return "estimate/scene", None
    return parts[0], None


def violations(path, includes):
    """Reasons why `path` (relative to src) may not include what it includes."""
    top, folder = module(path)
    for include in includes:
        for library, allowed in HEAVY.items():
            if include.startswith(library) and path not in allowed:
                yield f"{path}: only {sorted(allowed) or 'nobody'} may include <{include}>"
        other_top, other = module(include)
        if ".." in include.split("/"):
            yield f"{path}: says {include}; includes are relative to src"
        if other_top not in MODULES or "/" not in include:
            continue
        # A shared object of its own, which programs load.
        if include.startswith(LOADED) and not path.startswith(LOADED):
            yield f"{path}: only {LOADED} may include {include}"
        if include.startswith(TENSORS) and top != "materialgan":
            yield f"{path}: only materialgan may include {include}"
        if other_top not in MODULES[top]:
            yield f"{path}: {top} may not include {other_top}"
        if top in SEES_OF_PBRT and other_top == "pbrt" and other not in SEES_OF_PBRT[top]:
            yield f"{path}: {top} may not include {include}"
        if top == "layered" and (include.startswith("gaussfit/fit") or other in ("scene", "integrators")):
            yield f"{path}: layered may not include {include}"
        if top == "pbrt" and other_top == "pbrt":
            if other not in LEVEL:
                yield f"{path}: {other} is no folder with a level"
            elif folder != other and LEVEL[other] >= LEVEL[folder] and (folder, other) not in EXTRA_EDGES:
                yield f"{path}: {folder} (level {LEVEL[folder]}) may not include {other} (level {LEVEL[other]})"


def includes_of(text):
    return re.findall(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', text, re.M)


PRINTS = re.compile(r"\bstd::(?:cout|cerr|clog|exit|abort|quick_exit|_Exit|terminate)\b|\bfmt::print\b"
                    r"|(?<![\w.>])(?:printf|fprintf|puts|fputs|putchar|perror|exit|_exit|abort)\s*\(")


# What a process has besides its arguments: the environment, the time of day, and the generator that all share.
READS_GLOBALS = re.compile(r"\b(?:secure_getenv|getenv|setenv|unsetenv|putenv|environ|system_clock|localtime|gettimeofday)\b"
                           r"|(?<![\w.>])(?:std::)?(?:rand|srand)\s*\(|\bstd::time\s*\(|(?<![\w.>:])time\s*\(\s*(?:nullptr|NULL|0|&)")
USES_STD = re.compile(r"\busing\s+namespace\s+std\b")


def prints(path, text):
    """Only cmd prints, ends the process or reads what belongs to it; nobody hides where a name of std comes from."""
    code = re.sub(r"//.*", "", text)
    for match in USES_STD.finditer(code):
        yield f"{path}: {match.group(0)}: names of std are written with std::"
    if path.startswith("cmd/"):
        return
    for match in [*PRINTS.finditer(code), *READS_GLOBALS.finditer(code)]:
        yield f"{path}: only cmd may use {match.group(0)}"


# What an integrator could forget belongs to one file: TracedPath makes BSDFs, records first hits and sets footprints;
# Scene counts the rays. Render loops only read what was recorded, and statistics.
DUTIES = re.compile(r"\bMakeBxDF\s*\(|\bfirstHit->Record\b|\bAccelerator\s*\(\)|\bFootprintEstimator\b|\bRayCounts\s+\w+\s*[;{]")
MAY_BEAR_THEM = {"traced_path.h", "footprint.h", "footprint.cpp", "render.cpp", "rendered_image.cpp", "guide_trial.h"}


def forgets(path, text):
    """Integrators do by TracedPath what goes with every ray and vertex."""
    if not path.startswith("pbrt/integrators/") or path.rsplit("/", 1)[1] in MAY_BEAR_THEM:
        return
    for match in DUTIES.finditer(re.sub(r"//.*", "", text)):
        yield f"{path}: integrators leave {match.group(0)} to TracedPath"


FORGETFUL = [
    "bxdf = si.material->MakeBxDF(context, lambda, state.arena);",
    "if (state.firstHit) state.firstHit->Record(si, *bxdf, wo);",
    "scene_.Accelerator().Intersect(ray, Infinity, &hit);",
    "FootprintEstimator footprint_;",
    "RayCounts uncounted;",
]

PRINTING = [
    "std::cout << n;",
    "std::cerr << n;",
    "std::clog << n;",
    "fmt::print(stderr, n);",
    'std::printf("%d", n);',
    "std::fputs(text, stderr);",
    'std::perror("x");',
    "std::exit(1);",
    "exit(1);",
    "std::abort();",
    'const char* home = std::getenv("HOME");',
    'const char* home = getenv("HOME");',
    'setenv("TZ", "UTC", 1);',
    "extern char** environ;",
    "const auto now = std::chrono::system_clock::now();",
    "const time_t now = std::time(nullptr);",
    "srand(time(0));",
    "const int n = rand() % 6;",
]
# In cmd as well.
HIDING = ["using namespace std;", "using namespace std::literals;", "void F() { using namespace std; cerr << 1; }"]
# What is none of it.
HARMLESS = [
    "const auto time = [&](int64_t i) { sink += i; };",
    "cost.evaluateNs = time([&](int64_t i) { sink += i; });",
    "const float operand(3);",
    "const auto now = std::chrono::steady_clock::now();",
    "// as getenv does",
    "using namespace measure;",
    "camera.time(0.5f);",
]

CONTROLS = [
    ("pbrt/shapes/x.cpp", ["../scene/scene.h"]),
    ("pbrt/core/x.cpp", ["pbrt/base/bxdf.h"]),
    ("pbrt/shapes/x.cpp", ["pbrt/scene/scene.h"]),
    ("pbrt/phases/x.cpp", ["pbrt/media/medium_params.h"]),
    ("pbrt/shapes/x.cpp", ["embree3/rtcore.h"]),
    ("pbrt/image/image_io.cpp", ["OpenImageIO/imageio.h"]),
    ("pbrt/image/image_io.cpp", ["pbrt/image/openimageio/value_type.h"]),
    ("pbrt/image/x.cpp", ["dlfcn.h"]),
    ("pbrt/lights/x.cpp", ["layered/stack.h"]),
    ("layered/x.cpp", ["pbrt/scene/scene.h"]),
    ("pbrt/film/x.cpp", ["cmd/console.h"]),
    ("pbrt/image/x.cpp", ["compare/metrics.h"]),
    ("layered/x.cpp", ["compare/metrics.h"]),
    ("compare/x.cpp", ["layered/stack.h"]),
    ("compare/x.cpp", ["gaussfit/lobe/lobe.h"]),
    ("compare/x.cpp", ["cmd/console.h"]),
    ("pbrt/film/x.cpp", ["measure/color_mean.h"]),
    ("layered/x.cpp", ["measure/bsdf_subject.h"]),
    ("gaussfit/lobe/x.cpp", ["layered/stack.h"]),
    ("measure/x.cpp", ["cmd/console.h"]),
    ("measure/x.cpp", ["plot/canvas.h"]),
    ("plot/x.cpp", ["measure/bsdf_result.h"]),
    ("plot/x.cpp", ["pbrt/scene/scene.h"]),
    ("bulk/x.cpp", ["pbrt/base/medium.h"]),
    ("layered/x.cpp", ["bulk/conventions.h"]),
    ("estimate/x.cpp", ["pbrt/base/material.h"]),
    ("layered/x.cpp", ["estimate/parameters.h"]),
    ("estimate/layered/x.cpp", ["estimate/scene/scene_parameters.h"]),
    ("estimate/layered/x.cpp", ["measure/scene_material.h"]),
    ("estimate/scene/x.cpp", ["cmd/console.h"]),
    ("mpi/x.cpp", ["pbrt/core/vec.h"]),
    ("pbrt/film/x.cpp", ["mpi/messenger.h"]),
    ("cmd/mpi/x.cpp", ["mpi.h"]),
    ("cmd/materialgan/x.cpp", ["torch/torch.h"]),
    ("cmd/materialgan/x.cpp", ["materialgan/network/tensors.h"]),
    ("capture/x.cpp", ["materialgan/generator_config.h"]),
]


def main():
    passed = failed = 0
    library, command = "pbrt/film/x.cpp", "cmd/x.cpp"
    controls = [(any(violations(path, includes)), f"{path} includes {includes}") for path, includes in CONTROLS]
    controls += [(any(forgets("pbrt/integrators/x.cpp", line)), f"an integrator with {line}") for line in FORGETFUL]
    controls += [(any(prints(library, line)) and not any(prints(command, line)), f"a file with {line}") for line in PRINTING]
    controls += [(any(prints(command, line)), f"a file with {line}") for line in HIDING]
    for is_found, what in controls:
        passed += is_found
        failed += not is_found
        if not is_found:
            print(f"negative control not found: {what}")
    for line in HARMLESS:
        for reason in prints(library, line):
            failed += 1
            print(f"control: {reason}")
    for folder, _, names in os.walk(ROOT):
        for name in sorted(names):
            if not name.endswith((".h", ".cpp")):
                continue
            full = os.path.join(folder, name)
            path = os.path.relpath(full, ROOT).replace(os.sep, "/")
            with open(full, encoding="utf-8") as file:
                text = file.read()
            found = [*violations(path, includes_of(text)), *prints(path, text), *forgets(path, text)]
            for reason in found:
                print(reason)
            failed += bool(found)
            passed += not found
    print(f"{passed} passed, {failed} failed")
    sys.exit(1 if failed else 0)


main()
