#!/usr/bin/env python3
"""Adds a plugin of each kind, as docs/architecture.md, "Adding something", has it: one file, and one line of CMake.

usage: check_adding.py BUILD
BUILD  folder of a build that has made lacquer

Every file of the folder adding is a whole plugin, and so is the texture of docs/architecture.md. Its comment says in which
folder of src it would stand, and how a scene ("Scene:") or a command line ("Run:") would use it. Each is compiled there, by
the command of the files beside it, and linked to the program; nothing else changes. That program must list what scenes can
name, render scenes that do, and obey the command lines, and a misspelt parameter must be answered with the right one. A
further kind is a further file.
Prints what is wrong and a closing line 'N passed, N failed'. The check is itself checked: the program as built must refuse
all of it.
"""
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
BEFORE_WORLD = ("PixelFilter", "Integrator", "Sampler", "Film", "Camera")


@dataclass
class Example:
    file: str
    text: str
    folder: str      # of src
    scene: str       # how a scene uses it, or ""
    run: str         # how a command line does, or ""
    registered: list  # (kind as LACQUER_REGISTER has it, name)


def registrations(text):
    return re.findall(r'LACQUER_REGISTER\((\w+), "(\w+)"', text)


def examples():
    folder = os.path.join(HERE, "adding")
    for name in sorted(os.listdir(folder)):
        with open(os.path.join(folder, name), encoding="utf-8") as file:
            text = file.read()
        comment = " ".join(re.sub(r"^// ?", "", line).strip() for line in text.split("\n#include")[0].split("\n"))
        folder_of, use, words = re.search(r"Stands in (src/\S+)\. (Scene|Run): (.*)", comment).groups()
        yield Example(name, text, folder_of, words.strip() if use == "Scene" else "", words.strip() if use == "Run" else "",
                      registrations(text))
    with open(os.path.join(ROOT, "docs", "architecture.md"), encoding="utf-8") as file:
        said = re.search(r"`(src/[^`]*)/(\w+\.cpp)`:\n\n```cpp\n(.*?)```.*?a\s+scene\s+can\s+say\s+`([^`]*)`", file.read(), re.S)
    yield Example(said.group(2), said.group(3), said.group(1), re.sub(r"\s+", " ", said.group(4)), "",
                  registrations(said.group(3)))


def is_folder_as_one(path, folder):
    """True for the file by which LACQUER_GROUP_FOLDERS compiles the files of the folder together."""
    return re.search("/Unity/unity_%s_cxx.cxx$" % re.sub(r"\W", "_", folder), path) is not None


def compiler_of(build, folder):
    """The command that compiles a file of the folder, without the file."""
    with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as file:
        entries = json.load(file)
    for entry in entries:
        # Paths may differ by links or mounts; what follows the repository's root does not.
        if os.path.relpath(os.path.dirname(entry["file"]), ROOT) == folder or is_folder_as_one(entry["file"], folder):
            words = shlex.split(entry["command"])
            start = next(i for i, w in enumerate(words) if re.search(r"(\+\+|/cc|/gcc|/clang)(-\d+)?$", w))
            words = words[start:]
            output = words.index("-o")
            return entry["directory"], words[:output] + words[output + 2:words.index("-c")]
    raise SystemExit("%s: nothing is compiled there" % folder)


def compile_example(build, example, scratch):
    source = os.path.join(scratch, example.file)
    with open(source, "w", encoding="utf-8") as file:
        file.write(example.text)
    directory, words = compiler_of(build, example.folder)
    run = subprocess.run(words + ["-o", source + ".o", "-c", source], cwd=directory, capture_output=True, text=True)
    return source + ".o", run.stderr if run.returncode else ""


def link(build, objects, program):
    command = subprocess.run(["ninja", "-C", build, "-t", "commands", "src/cmd/lacquer"], capture_output=True, text=True,
                             check=True).stdout.strip().split("\n")[-1]
    assert " -o src/cmd/lacquer " in command, command
    added = " ".join(map(shlex.quote, objects))
    command = command.replace(" -o src/cmd/lacquer ", " %s -o %s " % (added, shlex.quote(program)))
    run = subprocess.run(command, shell=True, cwd=build, capture_output=True, text=True)
    return run.stderr if run.returncode else ""


def scene_of(found, change=lambda text: text):
    """A scene that uses all of them."""
    said = [change(e.scene) for e in found if e.scene]
    before = [s for s in said if s.startswith(BEFORE_WORLD)]
    world = sorted((s for s in said if not s.startswith(BEFORE_WORLD)), key=lambda s: not s.startswith("Texture"))
    world = [s + ('\nShape "sphere"' if s.startswith("Material") else "") for s in world]
    return "\n".join(['Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "string filename" "out.exr"',
                      'Sampler "independent" "integer pixelsamples" 2', *before,
                      'LookAt 0 0 5 0 0 0 0 1 0 Camera "perspective" "float fov" 40', "WorldBegin",
                      'LightSource "infinite" "float scale" 0.5', *world]) + "\n"


def run(program, *arguments, scene=None, folder=None):
    return subprocess.run([program, *arguments], input=scene, cwd=folder, capture_output=True, text=True)


def judge(build, scratch):
    """Yields (claim, what is wrong or "")."""
    found = list(examples())
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        compiled = list(pool.map(lambda e: compile_example(build, e, scratch), found))
    for example, (_, errors) in zip(found, compiled):
        yield "%s compiles in %s" % (example.file, example.folder), errors
    program = os.path.join(scratch, "lacquer")
    errors = link(build, [o for o, wrong in compiled if not wrong], program)
    yield "all link to the program", errors
    if errors:
        return
    known = {tuple(line.split("\t")) for line in run(program, "plugins").stdout.split("\n") if "\t" in line}
    built = {tuple(line.split("\t")) for line in run(os.path.join(build, "src/cmd/lacquer"), "plugins").stdout.split("\n")
             if "\t" in line}
    new = sorted(known - built)
    wanted = sorted(name for e in found for _, name in e.registered if e.scene)
    yield "the program lists what was added, and it alone", "" if sorted(name for _, name in new) == wanted else str(new)

    for title, chosen in (("all of them", found), ("all but the integrator",
                                                  [e for e in found if not e.scene.startswith("Integrator")])):
        path = os.path.join(scratch, "scene.pbrt")
        with open(path, "w", encoding="utf-8") as file:
            file.write(scene_of(chosen))
        answer = run(program, "--quiet", path, folder=scratch)
        yield "a scene with %s renders" % title, "" if answer.returncode == 0 and not answer.stderr else answer.stderr or "failed"
        answer = run(os.path.join(build, "src/cmd/lacquer"), "--quiet", path, folder=scratch)
        yield "and does not without them", "" if answer.returncode else "it did"
    with open(path, "w", encoding="utf-8") as file:
        file.write(scene_of([]))
    for example in found:
        if example.run:
            words = shlex.split(example.run)
            answer = run(program, *words, folder=scratch)
            yield "lacquer %s works" % example.run, "" if answer.returncode == 0 else answer.stderr or "failed"
            answer = run(os.path.join(build, "src/cmd/lacquer"), *words, folder=scratch)
            yield "and does not without it", "" if answer.returncode else "it did"
    with open(path, "w", encoding="utf-8") as file:
        file.write(scene_of(found, lambda text: text.replace("numexample", "numexampel")))
    answer = run(program, "--quiet", path, folder=scratch)
    misspelt = sum("numexample" in e.scene for e in found)
    yield ("their misspelt parameters are reported, with the right ones",
           "" if answer.stderr.count('"numexample"') >= misspelt else answer.stderr)


def main():
    build = os.path.abspath(sys.argv[1])
    passed = failed = 0
    with tempfile.TemporaryDirectory() as scratch:
        for claim, wrong in judge(build, scratch):
            passed += not wrong
            failed += bool(wrong)
            if wrong:
                print("not so: %s\n%s" % (claim, wrong))
    print("%d passed, %d failed" % (passed, failed))
    sys.exit(1 if failed else 0)


main()
