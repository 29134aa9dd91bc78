#!/usr/bin/env python3
"""Judges the messages of commits by CONTRIBUTING.md, "Commits".

usage: check_commits.py
Of the commits after BASE; in a clone without it (a shallow one), of those that are there and younger. Where there is no
repository, or no git, it says that it skips. A body is asked for since BODY_BASE, where more changes than a subject can explain.
Prints each violation and a closing line 'N passed, N failed'. The check is itself checked: made-up messages that break each
rule must be found.
"""
import os
import re
import subprocess
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
# The check came with this commit; history before it has its exceptions.
BASE = "766b17e8b26702fac70ee3bf48401662226071fc"
BASE_DATE = "2026-11-22T13:10:17+00:00"
BODY_BASE = "c067ab886cd8e03922d2ceb2830965af58ffc50a"
BODY_DATE = "2026-11-22T14:22:56+00:00"
# Beyond this, a commit needs a body. Files that only move count for nothing, and documents explain themselves.
MAX_FILES, MAX_LINES = 3, 30

KINDS = "feat|fix|perf|test|docs|build|refactor"
SUBJECT = re.compile(r"(%s)(\([\w./, -]+\))?: \S" % KINDS)
FOLDERS = r"(?:home|root|tmp|work|Users|mnt|media|opt|var|private|srv)"
MACHINE_PATH = re.compile(r"(?:^|[\s'\"`(])(/%s/[\w./-]+|[A-Za-z]:(?:\\+\w|/%s/)[\w.\\/-]*)" % (FOLDERS, FOLDERS), re.M)


def size_of(numstat):
    """Files and lines of code that a commit changes, of what `git log --numstat -M` says."""
    files = lines = 0
    for row in filter(None, numstat.split("\n")):
        added, deleted, path = row.split("\t", 2)
        changed = (1 if added == "-" else int(added) + int(deleted))     # "-": not a text
        if changed and not path.rstrip("}").endswith(".md"):
            files += 1
            lines += changed
    return files, lines


def violations(message, size=(0, 0)):
    """Reasons against a message. @param size  files and lines, from where on bodies are asked for"""
    lines = message.strip("\n").split("\n")
    subject, body = lines[0], "\n".join(lines[1:])
    merge = subject.startswith("Merge ")
    if not merge and not SUBJECT.match(subject) and not subject.startswith("Revert "):
        yield "begins with none of %s(scope): what" % KINDS
    if re.search(r"\b(wip|fixup!|squash!)", message, re.I):
        yield "is work in progress"
    match = MACHINE_PATH.search(message)
    if match:
        yield "names a path of a machine: %s" % match.group(1)
    if len(lines) > 1 and lines[1].strip():
        yield "has no empty line below the subject"
    if subject.startswith("perf") and not re.search(r"\d", body):
        yield "claims speed and shows no figures"
    if not merge and not body.strip() and (size[0] > MAX_FILES or size[1] > MAX_LINES):
        yield "changes %d files and %d lines, and no body says why" % size


CONTROLS = [
    ("update things", True),
    ("wip: chains", True),
    ("feat(chains): wip", True),
    ("Feat(chains): mixtures", True),
    ("fix(scene):", True),
    ("Merge /tmp/w/params/main", True),
    ("Merge branch 'main' of /home/someone/lacquer", True),
    ("fix(scene): a\nb", True),
    ("fix(scene): as in C:\\Users\\me\\scene.pbrt", True),
    ("fix(scene): as in C:/Users/me/scene.pbrt", True),
    ("fix(scene): a ratio 2:3 and a drive c:", False),
    ("perf(path): vertices are made in place", True),
    ("perf(path): vertices are made in place\n\nrender_bench: 3.2 s before, 2.9 s after", False),
    ("feat(phases): phase functions are plugins, of slabs and of media", False),
    ("build: a second run sees that there is nothing to do", False),
    ("fix(image, cmd): names like dir/name.png in /usr/share", False),
    ("Merge branch 'chains'", False),
    ("test(core): a swipe", False),
]
MOVES = "".join("0\t0\tsrc/{a => b}/%d.h\n" % i for i in range(300))
# Messages with what they change.
SIZED_CONTROLS = [
    ("refactor(layered): a change of 300 files without a body", MOVES.replace("0\t0", "1\t1"), True),
    ("refactor(layered): a change of many lines", "20\t11\tsrc/a.cpp\n", True),
    ("refactor(layered): a change of four files", "".join("1\t0\tsrc/%d.h\n" % i for i in range(4)), True),
    ("refactor(layered): images\n", "".join("-\t-\tscenes/%d.png\n" % i for i in range(4)), True),
    ("refactor(layered): a change of 300 files\n\nwith a body", MOVES.replace("0\t0", "1\t1"), False),
    ("refactor(layered): 300 files move", MOVES + "1\t1\tsrc/CMakeLists.txt\n", False),
    ("fix(layered): a wrong sign", "1\t1\tsrc/a.cpp\n25\t3\ttests/a_test.cpp\n", False),
    ("docs: a chapter", "300\t100\tdocs/guide.md\n0\t200\tdocs/{a.md => b.md}\n", False),
    ("Merge branch 'chains'", "300\t100\tsrc/a.cpp\n", False),
]


def git(*arguments):
    return subprocess.run(["git", "-C", ROOT, *arguments], capture_output=True, text=True, errors="replace")


def main():
    passed = failed = 0
    for message, numstat, broken in [(m, "", b) for m, b in CONTROLS] + SIZED_CONTROLS:
        reasons = list(violations(message, size_of(numstat)))
        if any(reasons) == broken:
            passed += 1
        else:
            failed += 1
            print("control: %r: %s" % (message, reasons or "not found"))

    def log(base, date, *arguments):
        """The log since a commit, or since its date where there is no such commit."""
        found = git("log", *arguments, base + "..HEAD")
        return git("log", *arguments, "--since=" + date, "HEAD") if found.returncode else found

    try:
        found = log(BASE, BASE_DATE, "--format=%x01%h%x00%B%x00", "--numstat", "-M")
        with_body = set(log(BODY_BASE, BODY_DATE, "--format=%h").stdout.split())
    except FileNotFoundError:
        found = None
    if found is None or found.returncode:
        print("SKIP: messages of commits: no git repository")
        print("%d passed, %d failed, 1 skipped" % (passed, failed))
        sys.exit(1 if failed else 0)
    for entry in filter(None, found.stdout.split("\x01")):
        commit, message, numstat = entry.split("\0")
        reasons = list(violations(message, size_of(numstat) if commit in with_body else (0, 0)))
        for reason in reasons:
            print("%s %s" % (commit, reason))
        failed += bool(reasons)
        passed += not reasons
    print("%d passed, %d failed" % (passed, failed))
    sys.exit(1 if failed else 0)


main()
