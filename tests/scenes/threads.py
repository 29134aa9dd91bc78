#!/usr/bin/env python3
"""Renders eleven scenes on four threads by a program with the thread sanitizer: no two of them may touch the same data at once.

usage: threads.py LACQUER

What is shared is in them: textures in memory and in prepared files, splats, auxiliary outputs and passes, adaptive sampling,
checkpoints amid passes, the denoiser. Closing line: 'N passed, N failed'. The check is itself checked: a program with a race must be
found out.
"""
import glob
import os
import subprocess
import sys
import tempfile

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
SCENES = os.path.join(ROOT, "scenes")
SMALL = ["--spp", "4", "--resolution", "48x40", "--nthreads", "4", "--quiet"]
RENDERS = [
    ["first-light.pbrt", "--aov", "half,albedo,normal,depth,variance,cryptoobject,motion"],
    ["first-light.pbrt", "--aov", "direct,lightgroups,emission", "--adaptive"],
    ["sky.pbrt", "--denoise"],
    ["brushed-varnish.pbrt", "--checkpoint", "a.state", "--checkpoint-every", "0.1"],
    ["campfire.pbrt"],
    ["burning-glass.pbrt"],
    ["through-the-lens.pbrt", "--time-limit", "2"],
    ["moving-coats.pbrt", "--adaptive", "--noise-target", "50%"],
    ["fur/fur.pbrt"],
    ["guo2018/fig01-vases.pbrt", "--texture-memory", "16", "--texture-cache", "none"],
    ["xia2020/fig01-objects.pbrt", "--texture-cache", "cache"],
    ["BDPT"],
]
RACE = """#include <thread>
int main() { int x = 0; std::thread t([&] { ++x; }); ++x; t.join(); return 0; }
"""


def complaint(command, folder, status=0):
    """Empty if a program went through without a race."""
    run = subprocess.run(command, capture_output=True, text=True, cwd=folder, check=False, timeout=1800)
    if "ThreadSanitizer" in run.stderr:
        return run.stderr[-6000:]
    return "" if run.returncode == status else "status %d: %s" % (run.returncode, run.stderr[-2000:])


def bdpt_scene(folder):
    """A scene of the project by an integrator that adds light to any pixel."""
    with open(os.path.join(SCENES, "first-light.pbrt"), encoding="utf-8") as file:
        lines = ['Integrator "bdpt"' if line.startswith("Integrator") else line.rstrip("\n") for line in file]
    path = os.path.join(folder, "bdpt.pbrt")
    for part in glob.glob(os.path.join(SCENES, "*")):
        os.symlink(part, os.path.join(folder, os.path.basename(part)))
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    return path


def main():
    lacquer = os.path.abspath(sys.argv[1])
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        race = os.path.join(folder, "race")
        with open(race + ".cpp", "w", encoding="utf-8") as file:
            file.write(RACE)
        subprocess.run(["clang++", "-g", "-fsanitize=thread", race + ".cpp", "-o", race], check=True)
        if "data race" not in complaint([race], folder):
            print("FAIL  a race is not found")
            failed += 1
        for i, (name, *options) in enumerate(RENDERS):
            path = bdpt_scene(folder) if name == "BDPT" else os.path.join(SCENES, name)
            says = complaint([lacquer, path, *SMALL, *options, "--outfile", os.path.join(folder, "%d.exr" % i)], folder)
            if says:
                failed += 1
                print("FAIL  %s: %s" % (" ".join([name, *options]), says))
    print("%d passed, %d failed" % (len(RENDERS) + 1 - failed, failed))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
