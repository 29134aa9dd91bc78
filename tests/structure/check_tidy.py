#!/usr/bin/env python3
"""clang-tidy, as .clang-tidy has it, on what changed.

usage: check_tidy.py BUILD [--all | --since REVISION] [--seconds N]
BUILD      folder of a build by Clang, whose commands are taken
--all      every file of src, tests and bench
--since    what changed since that commit, or is not committed; default: since the branch left origin/main, or, where it has
           not left it, in the last 5 commits
--seconds  begins no further file after so long, and says how many were left; default: no limit

A changed header is seen through the .cpp beside it, or else through one that includes it; of what is found, only that in
changed lines counts (--all: everything).
Prints the warnings and a closing line 'N passed, N failed, N skipped', files counted. The check is itself checked: a file with
a mistake must be found.
"""
import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor

import cpp_scan

ROOT = cpp_scan.ROOT
class AllLines:
    def __contains__(self, line):
        return True


ALL_LINES = AllLines()
CONTROL = """#include <string>
#include <utility>
namespace lacquer {
size_t Lengths(std::string text);
size_t Lengths(std::string text) {
    const std::string moved = std::move(text);
    return moved.size() + text.size();
}
}  // namespace lacquer
"""


def git(*arguments):
    run = subprocess.run(["git", "-C", ROOT, *arguments], capture_output=True, text=True, errors="replace")
    return run.stdout.strip() if run.returncode == 0 else ""


def changed(since):
    """Changed files, each with the numbers of its changed lines."""
    if not since:
        head, fork = git("rev-parse", "HEAD"), git("merge-base", "HEAD", "origin/main")
        since = fork if fork and fork != head else git("rev-list", "--first-parent", "--max-count=6", "HEAD").split("\n")[-1]
    lines, name = {}, None
    for line in git("diff", "-U0", "--no-color", since, "--").split("\n"):
        hunk = re.match(r"@@ -\S+ \+(\d+)(?:,(\d+))? @@", line)
        if line.startswith("+++ "):
            name = line[6:]
        elif hunk:
            first, count = int(hunk[1]), int(hunk[2] or 1)
            lines.setdefault(name, set()).update(range(first, first + count))
    for new in git("ls-files", "--others", "--exclude-standard").split("\n"):
        lines[new] = ALL_LINES
    return {n: l for n, l in lines.items() if n.endswith((".h", ".cpp")) and os.path.exists(os.path.join(ROOT, n))}


def translation_units(names, compiled):
    """The files to look at, for changed files."""
    chosen = []
    for name in names:
        if name in compiled:
            chosen.append(name)
        elif name.endswith(".h"):
            beside = name[:-2] + ".cpp"
            included = re.sub(r"^(src|tests)/", "", name)
            users = [beside] if beside in compiled else [c for c in sorted(compiled) if '#include "%s"' % included in cpp_scan.read(c)]
            chosen += users[:1]
    return sorted(set(chosen))


def tidy(arguments):
    """Warnings of a file, or those of the compiler where it did not understand it."""
    run = subprocess.run([shutil.which("clang-tidy-14") or "clang-tidy", "--quiet", *arguments], capture_output=True, text=True,
                         cwd=ROOT)
    warnings = [line for line in run.stdout.split("\n") if re.search(r": (warning|error): ", line)]
    if run.returncode and not warnings:
        warnings = [run.stdout + run.stderr]
    return warnings


def is_in(warning, lines):
    """Whether it is about one of these lines of files; what has no place counts."""
    place = re.match(r"(\S+?):(\d+):", warning)
    return not place or int(place[2]) in lines.get(os.path.relpath(place[1], ROOT), ())


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--since")
    parser.add_argument("--seconds", type=float)
    options = parser.parse_args()
    with open(os.path.join(options.build, "compile_commands.json"), encoding="utf-8") as file:
        compiled = {os.path.relpath(entry["file"], ROOT) for entry in json.load(file)}
    compiled = {name for name in compiled if name.startswith(("src/", "tests/", "bench/"))}
    touched = {} if options.all else changed(options.since)
    names = sorted(compiled) if options.all else translation_units(touched, compiled)

    start = time.monotonic()
    passed = failed = skipped = 0
    with tempfile.TemporaryDirectory() as folder:
        control = os.path.join(folder, "control.cpp")
        with open(control, "w", encoding="utf-8") as file:
            file.write(CONTROL)
        found = tidy([control, "--config-file=" + os.path.join(ROOT, ".clang-tidy"), "--", "-std=c++20"])
        if any("bugprone-use-after-move" in warning for warning in found):
            passed += 1
        else:
            failed += 1
            print("negative control not found: a use after a move", *found)

    place = os.path.join(ROOT, "a.h") + ":%d:1: warning: w"
    if is_in(place % 7, {"a.h": {7}}) and not is_in(place % 8, {"a.h": {7}}) and is_in(place % 8, {"a.h": ALL_LINES}):
        passed += 1
    else:
        failed += 1
        print("negative control not told apart: a warning beside the changed line")

    def judge(name):
        if options.seconds and time.monotonic() - start > options.seconds:
            return name, None
        warnings = tidy(["-p", options.build, name])
        return name, [w for w in warnings if options.all or "error: " in w or is_in(w, touched)]

    seen = set()
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for name, warnings in pool.map(judge, names):
            if warnings is None:
                skipped += 1
                continue
            for warning in warnings:
                if warning not in seen:
                    print(warning)
                    seen.add(warning)
            failed += bool(warnings)
            passed += not warnings
    if skipped:
        print("SKIP  clang-tidy: no time for %d of %d changed files; scripts/test full takes all" % (skipped, len(names)))
    print("%d passed, %d failed, %d skipped" % (passed, failed, skipped))
    sys.exit(1 if failed else 0)


main()
