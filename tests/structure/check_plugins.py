#!/usr/bin/env python3
"""Compares the names that the program registers with the table of docs/format.md, and docs/plugins.md with what
`lacquer plugins --markdown` prints.

usage: check_plugins.py LACQUER
Prints each difference and a closing line 'N passed, N failed'. The check is itself checked: a name that only one side
has must be found, for every kind.
"""
import os
import re
import subprocess
import sys

DOCS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "docs")
DOCUMENT = os.path.join(DOCS, "format.md")
GENERATED = os.path.join(DOCS, "plugins.md")
# First cells of rows of the table "Names", and the kinds of plugin that they document.
ROWS = {
    "camera": ["camera"],
    "film": ["film"],
    "pixel filter": ["pixel filter"],
    "sampler": ["sampler"],
    "integrator": ["integrator"],
    "light sampler": ["light sampler"],
    "light": ["light"],
    "area light": ["area light"],
    "material": ["material"],
    "texture, `float` and `spectrum`": ["float texture", "spectrum texture"],
    "texture, `float`": ["float texture"],
    "texture, `spectrum`": ["spectrum texture"],
    "shape": ["shape"],
    "medium": ["medium"],
    "phase function": ["phase"],
    "accelerator": ["accelerator"],
    "sensor": ["sensor"],
    "colour space": ["colour space"],
}
# Parameters of the table of layered materials whose last cell lists plugins.
PARAMETERS = {"`estimator`": "estimator", "`pdf`": "pdf"}


def names_in(cell):
    """Names of a cell: those in backticks, without what brackets, a colon or a semicolon add about them."""
    plain = re.sub(r"\([^()]*\)", "", cell)
    return set(re.findall(r"`([^`]+)`", re.split(r"[:;]", plain)[0]))


def documented(text):
    """Sets of names by kind."""
    found = {}
    for line in text.splitlines():
        cells = [c.strip() for c in line.strip().strip("|").split("|")]
        if len(cells) < 2:
            continue
        for kind in ROWS.get(cells[0], []):
            found.setdefault(kind, set()).update(names_in(cells[1]))
        if cells[0] in PARAMETERS and len(cells) == 4:
            found.setdefault(PARAMETERS[cells[0]], set()).update(names_in(cells[3]))
    return found


def registered(lacquer):
    found = {}
    for line in subprocess.run([lacquer, "plugins"], check=True, capture_output=True, text=True).stdout.splitlines():
        kind, name = line.split("\t")
        found.setdefault(kind, set()).add(name)
    return found


def differences(program, document):
    for kind in sorted(program.keys() | document.keys()):
        here, there = program.get(kind, set()), document.get(kind, set())
        for name in sorted(here - there):
            yield f'{kind} "{name}" is registered, but docs/format.md does not list it'
        for name in sorted(there - here):
            yield f'docs/format.md lists {kind} "{name}", which is not registered'


def missed(program, text):
    """Made-up differences that the check does not find: each name is taken out of either side in turn."""
    document = documented(text)
    for kind, names in program.items():
        for name in names:
            less = {**program, kind: names - {name}}
            if not any(f'"{name}"' in d for d in differences(less, document)):
                yield f"not noticed: {kind} {name} is no longer registered"
        without = re.sub(rf"(\*\*)?`{re.escape(min(names))}`(\*\*)?", "", text)
        if not any(f'{kind} "{min(names)}" is registered' in d for d in differences(program, documented(without))):
            yield f"not noticed: {kind} {min(names)} is no longer documented"


def is_stale(lacquer):
    """docs/plugins.md is made by the program."""
    made = subprocess.run([lacquer, "plugins", "--markdown"], check=True, capture_output=True, text=True).stdout
    with open(GENERATED, encoding="utf-8") as file:
        if file.read() != made:
            yield "docs/plugins.md is old: lacquer plugins --markdown > docs/plugins.md"


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    program = registered(sys.argv[1])
    with open(DOCUMENT, encoding="utf-8") as file:
        text = file.read()
    found = list(differences(program, documented(text))) + list(missed(program, text)) + list(is_stale(sys.argv[1]))
    for line in found:
        print(line)
    count = sum(len(names) for names in program.values()) + 1
    print(f"{max(0, count - len(found))} passed, {len(found)} failed")
    sys.exit(1 if found or not count else 0)


main()
