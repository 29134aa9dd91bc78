#!/usr/bin/env python3
"""Renders every scene of the project, tiny and with one sample, by a program with sanitizers: nothing may go wrong.

usage: smoke.py LACQUER

All of tests/conformance and of scenes/, layered ones also by each estimator and density, one scene by each integrator. What
the images show is checked elsewhere, by programs that are faster. Closing line: 'N passed, N failed'. The check is itself
checked: a scene that is not there must be found to fail.
"""
import glob
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
CONFORMANCE, SCENES = os.path.join(ROOT, "tests", "conformance"), os.path.join(ROOT, "scenes")
LAYERED = ("guo2018/fig02-microflakes", "guo2018/fig08-unbiased", "guo2018/fig13-satin", "xia2020/fig05-sphere")
TINY = ["--quiet", "--spp", "1", "--resolution", "24x24", "--nthreads", "1"]


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def whole_scenes():
    """Those that no other one includes, without those that are refused so far."""
    refused = {line.split("#")[0].strip() for line in read(os.path.join(CONFORMANCE, "not-yet.txt")).split("\n")}
    paths = glob.glob(os.path.join(CONFORMANCE, "*.pbrt")) + glob.glob(os.path.join(SCENES, "**", "*.pbrt"), recursive=True)
    parts = {os.path.normpath(os.path.join(os.path.dirname(path), name))
             for path in paths for name in re.findall(r'^\s*(?:Include|Import)\s+"([^"]+)"', read(path), re.MULTILINE)}
    return sorted(p for p in paths if p not in parts and os.path.splitext(os.path.basename(p))[0] not in refused)


def jobs(plugins):
    """Arguments and, where it is not a file's, the text of each render."""
    for path in whole_scenes():
        yield [path], None
    for name in LAYERED:
        path = os.path.join(SCENES, name + ".pbrt")
        for estimator in plugins["estimator"]:
            yield [path, "--estimator", estimator], None
        for density in plugins["pdf"]:
            yield [path, "--estimator", "bidirectional", "--layered-pdf", density], None
    text = read(os.path.join(SCENES, "first-light.pbrt"))
    for integrator in plugins["integrator"]:
        if integrator not in ("function", "simplevolpath"):  # no scene, and media without surfaces
            yield ["-"], re.sub(r'Integrator "path"[^\n]*', 'Integrator "%s"' % integrator, text)


def complaint(lacquer, job, folder, number):
    """Empty if a render went through."""
    arguments, text = job
    image = os.path.join(folder, "%d.exr" % number)
    run = subprocess.run([lacquer, *arguments, *TINY, "--outfile", image], capture_output=True, text=True, cwd=SCENES,
                         input=text or "")
    if run.returncode == 0 and os.path.exists(image):
        return ""
    return "exit status %d: %s" % (run.returncode, (run.stdout + run.stderr)[-2000:])


def main():
    lacquer = os.path.abspath(sys.argv[1])
    plugins = {}
    for line in subprocess.run([lacquer, "plugins"], capture_output=True, text=True, check=True).stdout.split("\n"):
        kind, _, name = line.partition("\t")
        plugins.setdefault(kind, []).append(name)
    work = list(jobs(plugins))
    passed = failed = 0
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(os.cpu_count()) as pool:
        control = complaint(lacquer, ([os.path.join(folder, "nothing.pbrt")], None), folder, len(work))
        problems = list(pool.map(lambda job: complaint(lacquer, job[1], folder, job[0]), enumerate(work)))
    for (arguments, text), problem in zip(work, problems):
        passed += not problem
        failed += bool(problem)
        if problem:
            print("FAIL  %s %s: %s" % (" ".join(arguments), re.findall(r"Integrator[^\n]*", text or ""), problem))
    passed += bool(control)
    if not control:
        failed += 1
        print("FAIL  negative control: a scene that is not there")
    print("%d passed, %d failed" % (passed, failed))
    sys.exit(1 if failed else 0)


main()
