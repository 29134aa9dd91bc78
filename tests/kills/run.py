#!/usr/bin/python3
"""Renders that are killed at random moments, time and again: each goes on from its state to the bits of one that nobody killed.

usage: run.py LACQUER [--kills N] [--seed N] [CASE ...]

Of all films, of auxiliary outputs and passes, of light that is traced from the lights, of adaptive sampling and of noise targets, as
many kills for each, N together (80). The moments are uniform over the time that a whole render takes, and a little more: while a
scene is read, pilots are taken, samples are added, states and images are written. After every kill the image is the old one, to the
byte, or the finished one, and nothing lies about but the states. Needs Debian's openimageio-tools.
Exit status: 0 passed; 1 failed.
"""
import argparse
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time

SCENE = """LookAt 0 1 -4  0 0.3 0  0 1 0
Camera "perspective" "float fov" 40 "float lensradius" 0.02 "float focaldistance" 4
Film "FILM" "integer xresolution" 160 "integer yresolution" 120 "string filename" "image.exr"
Sampler "SAMPLER" "integer pixelsamples" 32
Integrator "INTEGRATOR"
WorldBegin
LightSource "infinite" "rgb L" [.1 .12 .15]
AttributeBegin AreaLightSource "diffuse" "rgb L" [9 8 7] "string group" "key"
Translate 0 3 0 Rotate 90 1 0 0 Shape "disk" "float radius" 0.7 AttributeEnd
AttributeBegin Material "conductor" "float roughness" 0.2 Translate -0.8 0.6 0 Shape "sphere" "float radius" 0.6 AttributeEnd
AttributeBegin Material "dielectric" Translate 0.7 0.5 0.2 Shape "sphere" "float radius" 0.5 AttributeEnd
Material "coateddiffuse"
Shape "bilinearmesh" "point3 P" [-5 0 -5  5 0 -5  -5 0 5  5 0 5]
"""
# Name: film, sampler, integrator, options.
CASES = {
    "rgb": ("rgb", "zsobol", "path", []),
    "outputs": ("rgb", "halton", "volpath", ["--aov", "half,depth,albedo,variance,cryptoobject,samples"]),
    "passes": ("rgb", "sobol", "path", ["--aov", "direct,lightgroups,emission"]),
    "spectral": ("spectral", "independent", "path", []),
    "gbuffer": ("gbuffer", "paddedsobol", "volpath", []),
    "bdpt": ("rgb", "zsobol", "bdpt", []),
    "lightpath": ("rgb", "halton", "lightpath", []),
    "adaptive": ("rgb", "zsobol", "path", ["--adaptive", "--aov", "half"]),
    "noise": ("rgb", "sobol", "path", ["--spp", "4096", "--noise-target", "20%"]),
    "adaptive-noise": ("rgb", "halton", "path", ["--spp", "4096", "--noise-target", "20%", "--adaptive"]),
}
OLD = b"an image of yesterday"
STATE = ["--checkpoint", "a.state", "--checkpoint-every", "0.1"]
KNOWN = {"scene.pbrt", "whole.exr", "image.exr", "a.state", "a.state.previous", "a.state.lock"}


def pixels(path):
    """Digest of the values of all channels, whatever the metadata."""
    done = subprocess.run(["oiiotool", "--info", "-v", "--hash", path], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    found = re.search(r"SHA-1: (\w+)", done.stdout)
    return found.group(1) if found else done.stdout


class KilledRender:
    """One case in a folder of its own."""

    def __init__(self, name, lacquer, folder, moments):
        film, sampler, integrator, options = CASES[name]
        self.name, self.folder, self.moments = name, folder, moments
        self.command = [lacquer, "scene.pbrt", "--quiet", *options]
        text = SCENE.replace("FILM", film).replace("SAMPLER", sampler).replace("INTEGRATOR", integrator)
        with open(self.path("scene.pbrt"), "w", encoding="utf-8") as file:
            file.write(text)
        start = time.monotonic()
        subprocess.run([*self.command, "--outfile", "whole.exr"], cwd=folder, check=True)
        self.seconds = time.monotonic() - start
        self.expected = pixels(self.path("whole.exr"))
        self.problems = []

    def path(self, name):
        return os.path.join(self.folder, name)

    def run(self):
        """One render from the start to its end. How often it was killed."""
        for name in set(os.listdir(self.folder)) - {"scene.pbrt", "whole.exr"}:
            os.remove(self.path(name))
        with open(self.path("image.exr"), "wb") as file:
            file.write(OLD)
        kills = 0
        while True:
            resume = ["--resume", "a.state"] if os.path.exists(self.path("a.state")) else []
            # Another number of threads each time.
            threads = str(self.moments.randint(1, 3))
            # pylint: disable-next=consider-using-with
            process = subprocess.Popen([*self.command, *STATE, *resume, "--nthreads", threads], cwd=self.folder, stderr=subprocess.PIPE)
            try:
                # Early moments often, so that a render that must be done anew does not go on for ever.
                process.wait(self.moments.random() * 1.2 * self.seconds)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
            err = process.communicate()[1].decode()
            kills += process.returncode == -signal.SIGKILL
            self.check(process.returncode, kills, err)
            if process.returncode != -signal.SIGKILL or self.problems:
                return kills

    def check(self, status, kills, err):
        after = "%s, after %d kills: " % (self.name, kills)
        if status not in (0, -signal.SIGKILL):
            self.problems.append(after + "status %d: %s" % (status, err))
        strange = set(os.listdir(self.folder)) - KNOWN
        if strange:
            self.problems.append(after + "there is " + ", ".join(sorted(strange)))
        with open(self.path("image.exr"), "rb") as file:
            is_old = file.read() == OLD
        if status == 0 and is_old:
            self.problems.append(after + "finished without an image")
        elif not is_old and pixels(self.path("image.exr")) != self.expected:
            self.problems.append(after + "another image")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lacquer")
    parser.add_argument("cases", nargs="*", metavar="CASE")
    parser.add_argument("--kills", type=int, default=80)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    cases = options.cases or list(CASES)
    moments = random.Random(options.seed)
    problems, total = [], 0
    for name in cases:
        with tempfile.TemporaryDirectory() as folder:
            render = KilledRender(name, os.path.abspath(options.lacquer), folder, moments)
            kills = renders = 0
            while kills < options.kills / len(cases) and not render.problems:
                kills += render.run()
                renders += 1
            print("%s: %d kills in %d renders of %.1f s" % (name, kills, renders, render.seconds), flush=True)
            problems += render.problems
            total += kills
    for problem in problems:
        print("FAIL  " + problem)
    print("%d passed, %d failed" % (total, len(problems)))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
