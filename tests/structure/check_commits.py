#!/usr/bin/env python3
"""Judges the messages of commits by CONTRIBUTING.md, "Commits".

usage: check_commits.py
Of the commits after BASE; in a clone without it (a shallow one), of those that are there and younger. Where there is no
repository, or no git, it says that it skips.
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

KINDS = "feat|fix|perf|test|docs|build|refactor"
SUBJECT = re.compile(r"(%s)(\([\w./, -]+\))?: \S" % KINDS)
MACHINE_PATH = re.compile(r"(?:^|[\s'\"`(])(/(?:home|root|tmp|work|Users|mnt|media|opt|var|private|srv)/[\w./-]+)", re.M)


def violations(message):
    """Reasons against a message."""
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


CONTROLS = [
    ("update things", True),
    ("wip: chains", True),
    ("feat(chains): wip", True),
    ("Feat(chains): mixtures", True),
    ("fix(scene):", True),
    ("Merge /tmp/w/params/main", True),
    ("Merge branch 'main' of /home/someone/lacquer", True),
    ("fix(scene): a\nb", True),
    ("perf(path): vertices are made in place", True),
    ("perf(path): vertices are made in place\n\nrender_bench: 3.2 s before, 2.9 s after", False),
    ("feat(phases): phase functions are plugins, of slabs and of media", False),
    ("build: a second run sees that there is nothing to do", False),
    ("fix(image, cmd): names like dir/name.png in /usr/share", False),
    ("Merge branch 'chains'", False),
    ("test(core): a swipe", False),
]


def git(*arguments):
    return subprocess.run(["git", "-C", ROOT, *arguments], capture_output=True, text=True, errors="replace")


def main():
    passed = failed = 0
    for message, broken in CONTROLS:
        if any(violations(message)) == broken:
            passed += 1
        else:
            failed += 1
            print("control: %r: %s" % (message, list(violations(message)) or "not found"))
    try:
        found = git("log", "--format=%h%x00%B%x01", BASE + "..HEAD")
        if found.returncode:
            found = git("log", "--format=%h%x00%B%x01", "--since=" + BASE_DATE, "HEAD")
    except FileNotFoundError:
        found = None
    if found is None or found.returncode:
        print("SKIP: messages of commits: no git repository")
        print("%d passed, %d failed, 1 skipped" % (passed, failed))
        sys.exit(1 if failed else 0)
    for entry in filter(None, (e.strip("\n") for e in found.stdout.split("\x01"))):
        commit, message = entry.split("\0")
        reasons = list(violations(message))
        for reason in reasons:
            print("%s %s" % (commit, reason))
        failed += bool(reasons)
        passed += not reasons
    print("%d passed, %d failed" % (passed, failed))
    sys.exit(1 if failed else 0)


main()
