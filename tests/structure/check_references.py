#!/usr/bin/env python3
"""Checks citations against docs/references.bib: each one has an entry, and each entry is cited.

usage: check_references.py
Citations are "[Walter et al. 2007]", "[Heitz 2018, sec. 3; Walsh 1926]" in comments and documents, "[IEC 61966-2-1]" for
standards, and `Xia2020` in documents. The key of an entry is the first author's family name and the year, with a letter
where that is needed: "[Guo et al. 2020b]". Prints each problem and a closing line 'N passed, N failed'. The check is
itself checked: without any of its entries it must complain.
"""
import os
import re
import sys
import unicodedata

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
FOLDERS = ("src", "addons", "tests", "bench", "docs", "scripts", "scenes")
KINDS = (".h", ".cpp", ".md", ".py")
STANDARDS = ("CIE", "IEC", "ITU-R", "SMPTE")
NAME = r"(?:[A-Z]\w*[- ])*(?:d'|[A-Z])[\w'-]+"
CITATION = re.compile(rf"^({NAME})(?: et al\.| and ({NAME}))? ((?:19|20)\d\d[a-z]?)(?![\d-])")


def entries(bib):
    """Keys, with the text of each entry; a list, so that doubles show."""
    found = []
    for match in re.finditer(r"^@\w+\{([^,\s]+),(.*?)(?=^@|\Z)", bib, re.M | re.S):
        found.append((match.group(1), match.group(2)))
    return found


def ascii_of(name):
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    return re.sub(r"[^A-Za-z]", "", plain)


def keys_of(first, second, year):
    """The keys that a citation may mean: Conty Estevez is Conty, Van Oosterom is VanOosterom."""
    names = [ascii_of(first), ascii_of(first.split(" ")[0])]
    return {n + year for n in names} | ({n + ascii_of(second) + year for n in names} if second else set())


def has_authors(text, written):
    """True if an entry has as many authors as a citation says, and the second one that it names."""
    field = re.search(r"author = \{(.*)\},?$", text, re.M)
    authors = re.sub(r"\\['\"`~^vcr]|[{}]", "", field.group(1)).split(" and ") if field else []
    citation = CITATION.match(written)
    if not citation:
        return True
    if citation.group(2):
        return len(authors) == 2 and ascii_of(citation.group(2)) in ascii_of(authors[1])
    return len(authors) >= 3 if " et al." in written else len(authors) == 1


def citations(text):
    """(what is written, keys or standard) of each citation in a text."""
    text = re.sub(r"[ \t]*\n[ \t]*(?:///?<?|#|\*)?[ \t]*", " ", text)
    for match in re.finditer(r"\[([^\[\]`]{4,200})\]", text):
        for part in match.group(1).split(";"):
            part = part.strip()
            found = CITATION.match(part)
            if found:
                yield part, keys_of(*found.groups()), None
            elif re.match(rf"(?:{'|'.join(STANDARDS)}) [\w.: -]*\d", part):
                yield part, set(), re.match(r"[^,]+", part).group(0).strip()
            elif re.match(rf"{NAME}(?: et al\.| and {NAME})?,? ?\d\d(?:\d\d)?(?!\w)", part) and re.search("et al|and", part):
                yield part, set(), None
    for match in re.finditer(r"`([A-Z][A-Za-z]+(?:19|20)\d\d[a-z]?)`", text):
        yield match.group(0), {match.group(1)}, None


def texts():
    for folder in FOLDERS:
        for where, _, names in os.walk(os.path.join(ROOT, folder)):
            for name in sorted(names):
                path = os.path.join(where, name)
                if name.endswith(KINDS) and os.path.abspath(path) != os.path.abspath(__file__):
                    with open(path, encoding="utf-8") as file:
                        yield os.path.relpath(path, ROOT), file.read()


def problems(cited, listed):
    """What is wrong with these citations [(place, what is written, keys, standard)] and entries."""
    found, used = [], set()
    known = [key for key, _ in listed]
    for place, written, keys, standard in cited:
        if standard:
            hits = {key for key, text in listed if standard in text}
        else:
            hits = {key for key, text in listed if key in keys and has_authors(text, written)}
        if not hits:
            found.append(f"{place}: [{written}] is not in docs/references.bib")
        used |= hits
    for key in sorted(set(known)):
        if known.count(key) > 1:
            found.append(f"docs/references.bib: two entries {key}")
        if key not in used:
            found.append(f"docs/references.bib: nothing cites {key}")
    if known != sorted(known, key=str.lower):
        found.append("docs/references.bib: the entries are not in alphabetical order")
    return found


def main():
    with open(os.path.join(ROOT, "docs/references.bib"), encoding="utf-8") as file:
        listed = entries(file.read())
    cited = [(path, *citation) for path, text in texts() for citation in citations(text)]
    found = problems(cited, listed)
    for line in found:
        print(line)
    passed, failed = len(listed) + len(cited) - len(found), len(found)
    # Each entry that is taken away must be missed, and one that is there twice be noticed.
    for i, (key, _) in enumerate(listed):
        missed = [line for line in problems(cited, listed[:i] + listed[i + 1:]) if line not in found]
        if not missed and f"docs/references.bib: nothing cites {key}" not in found:
            print(f"negative control: nobody misses {key}")
            failed += 1
    if not any("two entries" in line for line in problems(cited, listed + listed[:1])):
        print("negative control: an entry that is there twice was not noticed")
        failed += 1
    for text, wanted in (("a [Walter et al.\n    /// 2007] b", {"Walter2007"}),
                         ("[Heitz 2018, sec. 3; Arvo 1995]", {"Heitz2018", "Arvo1995"}),
                         ("[d'Eon and Irving 2011]", {"dEon2011", "dEonIrving2011"}), ("[1, 2007] x[i]", set()),
                         ("[Guo et al. 2020; Guo et al. 2020b]", {"Guo2020", "Guo2020b"})):
        got = set().union(*(keys for _, keys, _ in citations(text)))
        if got != wanted:
            print(f"negative control: {text!r} cites {got}, not {wanted}")
            failed += 1
    print(f"{passed} passed, {failed} failed")
    sys.exit(failed > 0)


main()
