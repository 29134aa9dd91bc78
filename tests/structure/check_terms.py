#!/usr/bin/env python3
"""Finds terms that CONTRIBUTING.md, "Terms", calls old, in sources, tests, scripts, scenes and documents.

usage: check_terms.py
An old term between backticks is a name, `Draw...` the beginning of one and `...Pays` its end; others are words of comments,
texts and documents, in singular or plural. Words that mean something else everywhere are not looked for, and where a name
or a word is right in one place, that place stands below with the reason; a place where nothing is found has to go.
Prints each violation and a closing line 'N passed, N failed'. The check is itself checked: a line with each old term must be
found.
"""
import fnmatch
import os
import re
import subprocess
import sys

import cpp_scan

ROOT = cpp_scan.ROOT
KINDS = (".h", ".cpp", ".py", ".md", ".pbrt", ".sh", ".cmake", ".txt")
# What tells of the terms themselves, and what is not ours.
SKIPPED = ("CONTRIBUTING.md", "tests/structure/check_terms.py", "data/*", "tests/report/*", "*.bib")

# Words that are right nearly everywhere, and why.
EVERYDAY = {
    "way": "a manner, or where light goes",
    "level": "of detail, of a hierarchy, of a log",
    "lead": "steps that lead somewhere",
    "ball": "a sphere in a scene",
    "turned over": "an edge of a map, a triangle",
}
# Words that are wrong in these places only.
ONLY_IN = {
    "chain": ("src/layered/*", "src/gaussfit/*", "src/measure/*", "src/pbrt/scattering/*", "tests/layered/*", "bench/*",
              "docs/layered.md", "docs/product-sampling.md", "README.md"),
    "leans": ("src/*", "tests/*", "docs/*", "README.md"),
}
# (term, where, text around it, why it is right there)
RIGHT = [
    ("chain", "*", r"Markov chain", "a term of the field"),
    ("Draw…", "src/plot/*", r"Draw\w+", "on a canvas"),
    ("Draw…", "src/cmd/*", r"Draw\w+", "on a canvas"),
    ("Anywhere", "src/pbrt/scene/directive*", r"Anywhere", "where a directive may stand"),
    ("Things", "tests/integrators/*", r"Things under a light", "a sentence begins"),
    ("picture", "scripts/make-xia2020", r"picture frame", "a piece of furniture"),
]


def old_terms(contributing):
    """The old terms of the table, as it writes them."""
    section = contributing.split("## Terms", 1)[1].split("\n## ", 1)[0]
    for row in re.findall(r"^\|([^|\n]+)\|[^|\n]+\|[^\n]*$", section, re.M):
        row = re.sub(r"\([^)]*\)", "", row).strip()
        if row in ("was", "") or set(row) <= set("-"):
            continue
        for term in row.split(","):
            yield term.strip()


def pattern_of(term):
    """Of a term of the table; a second alternative of its name."""
    if term.startswith("`"):
        name = term.strip("`")
        if name.endswith("…"):
            return re.compile(r"\b%s[A-Z]\w*" % re.escape(name[:-1]))
        if name.startswith("…"):
            return re.compile(r"\b\w*[a-z]%s\b" % re.escape(name[1:]))
        return re.compile(r"\b%s\b" % re.escape(name))
    words = [re.escape(word) for word in term.split()]
    return re.compile(r"(?<![\w.])%ss?(?!\w)" % r"(?:\s+|\s*\n\s*(?://+|#)\s*)".join(words), re.I)


def is_in(path, places):
    return any(fnmatch.fnmatch(path, place) for place in places)


def findings(term, path, text, used):
    """Lines with the term; exceptions that apply are added to `used`."""
    name = term.strip("`")
    if name in EVERYDAY or name in ONLY_IN and not is_in(path, ONLY_IN[name]):
        return
    for match in pattern_of(term).finditer(text):
        line = text[text.rfind("\n", 0, match.start()) + 1:(text + "\n").index("\n", match.end())]
        reasons = [r for r in RIGHT if r[0] == name and fnmatch.fnmatch(path, r[1]) and
                   any(m.start() <= match.start() - text.rfind("\n", 0, match.start()) - 1 < m.end()
                       for m in re.finditer(r[2], line))]
        used.update(reasons)
        if not reasons:
            yield "%s:%d: \"%s\" is an old term; see CONTRIBUTING.md, \"Terms\"" % (
                path, text.count("\n", 0, match.start()) + 1, match.group(0))


def made_up(term):
    """A line with the term."""
    name = term.strip("`")
    if term.startswith("`"):
        return "x = %s(y);" % (name.replace("…", "Rays") if name.endswith("…") else name.replace("…", "rays"))
    return "// Here the %s of it." % name


def sources():
    try:
        listed = subprocess.run(["git", "-C", ROOT, "ls-files"], capture_output=True, text=True)
        names = listed.stdout.split("\n") if listed.returncode == 0 else []
    except FileNotFoundError:
        names = []
    if not any(names):
        names = [os.path.relpath(os.path.join(folder, name), ROOT) for top in ("src", "addons", "tests", "bench", "docs", "scripts", "scenes")
                 for folder, _, files in os.walk(os.path.join(ROOT, top)) for name in files]
    for path in names:
        if (path.endswith(KINDS) or path.startswith("scripts/")) and not is_in(path, SKIPPED):
            try:
                yield path, cpp_scan.read(path)
            except (UnicodeDecodeError, FileNotFoundError):
                continue


def main():
    terms = list(old_terms(cpp_scan.read("CONTRIBUTING.md")))
    used = set()
    controls = [(term, True, list(findings(term, "src/layered/x.cpp", made_up(term), set())))
                for term in terms if term not in EVERYDAY]
    controls += [(line, False, [f for term in terms for f in findings(term, "src/layered/x.cpp", line, set())])
                 for line in ("auto w = SamplePath(u);", "// A Markov chain of images, in any way.", "kMaxDepth, kMinCos",
                              "`RunningVariance` of the paths", "x.lead = Bending(y);")]
    controls.append(("a term in two lines", True, list(findings("counted walk", "src/x.h", "/// a counted\n/// walk of", set()))))
    passed, failed = cpp_scan.count_controls(controls)
    if len(terms) < 30:
        print("only %d old terms found in CONTRIBUTING.md" % len(terms))
        failed += 1
    names = {term.strip("`") for term in terms}
    for path, text in sources():
        found = [f for term in terms for f in findings(term, path, text, used)]
        for reason in found:
            print(reason)
        failed += bool(found)
        passed += not found
    stale = [r for r in RIGHT if r not in used] + [n for n in (*EVERYDAY, *ONLY_IN) if n not in names]
    for entry in stale:
        print("nothing needs this entry of check_terms.py: %s" % (entry,))
    failed += len(stale)
    print("%d passed, %d failed" % (passed, failed))
    sys.exit(1 if failed else 0)


main()
