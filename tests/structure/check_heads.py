#!/usr/bin/env python3
"""Checks that the comment at the head of each plugin lists its parameters.

usage: check_heads.py
A plugin is a source file with LACQUER_REGISTER. Each parameter that it reads must stand in quotes in the comment at its
head ("float maxanisotropy", "filename"); parameters that a shared reader reads must be named in a comment of that reader,
of its header, or at the head of a plugin beside it. What stands in quotes after a type must be read somewhere. Prints each violation and a closing line
'N passed, N failed'. The check is itself checked: a parameter taken out of a head, for every one, must be missed.
"""
import os
import re
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "src")
TYPES = ("float", "integer", "bool", "string", "point2", "point3", "vector2", "vector3", "normal", "rgb", "spectrum",
         "float texture", "spectrum texture")
# Plugins whose parameters are no directive's own: estimators and densities of layered materials, light samplers.
WITHOUT_DIRECTIVE = {"LayeredEstimatorKind", "LayeredPdfKind", "LightSamplerKind"}
# Kinds of names, as Params and its helpers take them.
NAME = r"(?:const char\*|std::string_view|const std::string&)"


def strip_comments(text):
    """Code without comments; strings stay."""
    return re.sub(r'("(?:\\.|[^"\\\n])*")|//[^\n]*', lambda m: m.group(1) or "", text)


def head_of(text):
    return re.match(r"(?:[ \t]*//[^\n]*\n)*", text).group(0)


def comments_of(text):
    return "\n".join(re.findall(r"//[^\n]*", text))


def readers_of(texts):
    """Names of functions that take parameters (or the arguments of a factory) and then the name of one."""
    found = set()
    for text in texts:
        code = strip_comments(text)
        found.update(re.findall(rf"\b(\w+)\(const (?:Params|\w*Args)& \w*,\s*{NAME} (?:name|parameter)\b", code))
        found.update(re.findall(rf"\bauto (\w+) = \[[^\]]*\]\(\s*{NAME} (?:name|parameter)\b", code))
    return found - {"Fail", "LocOf", "Has", "RequireFinite"}


def reads(text, readers):
    """Names of parameters that a file reads by themselves, not with a prefix."""
    code = strip_comments(text)
    names = set(re.findall(r'\.Get\w+\s*\(\s*"([\w.]+)"', code))
    names.update(re.findall(r'\.Ignore\s*\(\s*"\w+",\s*"([\w.]+)"', code))
    call = rf'\b(?:{"|".join(sorted(readers))})\s*\(\s*(?:(?:\w+\.)?\w+,\s*)?"([\w.]+)"'
    names.update(re.findall(call, code))
    return names


def quoted(comment):
    """Names in quotes: the last word of each."""
    joined = re.sub(r"\n\s*///?\s*", " ", comment)
    return {q.split()[-1] for q in re.findall(r'"([^"]+)"', joined) if q.split()}


def declared(comment):
    """Names that a head gives a type."""
    joined = re.sub(r"\n\s*///?\s*", " ", comment)
    return {q.rsplit(" ", 1)[1] for q in re.findall(r'"([^"]+)"', joined)
            if " " in q and q.rsplit(" ", 1)[0] in TYPES}


def missing(names, comment):
    return sorted(names - quoted(comment))


def sources():
    for folder, _, files in os.walk(ROOT):
        for name in sorted(files):
            if name.endswith((".h", ".cpp")):
                full = os.path.join(folder, name)
                with open(full, encoding="utf-8") as file:
                    yield os.path.relpath(full, ROOT).replace(os.sep, "/"), file.read()


def main():
    texts = dict(sources())
    readers = readers_of(texts.values())
    passed = failed = 0
    everything = set()
    plugins = {}
    for path, text in texts.items():
        names = reads(text, readers)
        everything |= names | set(re.findall(r'"([\w.]+)"', strip_comments(text)))
        kinds = set(re.findall(r"LACQUER_REGISTER\((\w+)", text)) if path.endswith(".cpp") else set()
        if kinds - WITHOUT_DIRECTIVE:
            plugins[path] = names
    for path, names in plugins.items():
        head = head_of(texts[path])
        found = [f'{path}: reads "{name}", which the comment at its head does not list' for name in missing(names, head)]
        if not head:
            found.append(f"{path}: has no comment at its head")
        # With a prefix ("interface.eta"), a name is put together: its last part is read.
        found += [f'{path}: lists "{name}", which nothing reads' for name in sorted(declared(head))
                  if name not in everything and name.split(".")[-1] not in everything]
        for name in names:  # negative control
            if name in quoted(head) and not missing(names, re.sub(rf"\b{re.escape(name)}\b", "", head)):
                found.append(f'{path}: not noticed: "{name}" is no longer in the head')
        for line in found:
            print(line)
        failed += bool(found)
        passed += not found
    for path, text in texts.items():
        # Measured BRDFs have fields with names, not parameters.
        if path in plugins or not re.search(r"pbrt/(?!core|scene|base|bxdfs)|layered/", path):
            continue
        names = reads(text, readers)
        stem = os.path.splitext(path)[0]
        about = "".join(comments_of(texts.get(stem + end, "")) for end in (".h", ".cpp"))
        about += "".join(head_of(texts[p]) for p in plugins if os.path.dirname(p) == os.path.dirname(path))
        found = [f'{path}: reads "{name}", which no comment of it, its header or a plugin beside it names'
                 for name in sorted(names)
                 if not re.search(rf"(?<![\w.]){re.escape(name)}(?![\w.])", about)]
        for line in found:
            print(line)
        failed += bool(found)
        passed += bool(names) and not found
    if len(plugins) < 60:
        print(f"only {len(plugins)} plugins found")
        failed += 1
    print(f"{passed} passed, {failed} failed")
    sys.exit(1 if failed else 0)


main()
