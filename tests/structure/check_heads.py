#!/usr/bin/env python3
"""Checks that the comment at the head of each plugin lists its parameters.

usage: check_heads.py
A plugin is a source file with LACQUER_REGISTER. Each parameter that it reads must stand in quotes in the comment at its
head ("float maxanisotropy", "filename"); parameters that a shared reader reads must be named in a comment of that reader,
of its header, or at the head of a plugin beside it. What stands in quotes after a type must be read somewhere. Types and defaults
of a head are compared with those of the code where that has them as literals. Prints each violation and a closing line
'N passed, N failed'. The check is itself checked: a parameter taken out of a head, for every one, must be missed, and so
must another type or default in its place.
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


# Types that a head may give what Params::GetX() reads.
TYPE_OF = {"Float": {"float"}, "Int": {"integer"}, "Bool": {"bool"}, "String": {"string"}, "Choice": {"string"},
           "Point2": {"point2"}, "Point3": {"point3"}, "Vector2": {"vector2"}, "Vector3": {"vector3"}, "Normal": {"normal"},
           "Rgb": {"rgb"}, "Spectrum": {"spectrum"}}
GET = re.compile(r'\.Get(?:Optional)?(%s)s?(?:InRange)?\s*\(\s*"([\w.]+)"(?:,\s*("[^"]*"|[\w.+-]+))?\s*[,)]' % "|".join(TYPE_OF))


def rows_of(comment):
    """{name: (type, default)} of a head; the default is None where the row gives none for each of its names."""
    found = {}
    for line in comment.split("\n"):
        match = re.match(r'//   ("[^"]+"(?: \[\d*\])?(?:, "[^"]+"(?: \[\d*\])?)*)(?:  +(.*))?$', line)
        if not match:
            continue
        names = re.findall(r'"([^"]+)"', match.group(1))
        column = re.split(r"  +", match.group(2) or "")[0].strip()
        defaults = [column] if len(names) == 1 else [d.strip() for d in column.split(",")]
        for i, name in enumerate(names):
            kind, _, last = name.rpartition(" ")
            if kind in TYPES:
                default = defaults[i] if len(defaults) == len(names) else column if len(defaults) == 1 else None
                found[last] = (kind, default or None)
    return found


def value_of(text):
    """A literal of the code or of a head as a number or a word; None if it is neither."""
    text = text.strip('"')
    text = {"Infinity": "infinity"}.get(text, text)
    number = re.fullmatch(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)f?", text)
    if number:
        return float(number.group(1))
    return text if re.fullmatch(r"[a-z][\w.-]*", text) else None


def contradictions(code, comment):
    """Rows of a head that the calls of the code contradict: (name, what the head says, what the code says)."""
    rows = rows_of(comment)
    for getter, name, literal in GET.findall(strip_comments(code)):
        kind, default = rows.get(name, (None, None))
        if kind is None:
            continue
        if kind.replace(" texture", "") not in TYPE_OF[getter]:
            yield name, kind, "/".join(TYPE_OF[getter])
        # A name of the code's in lower case ("fallback") is no literal; words stand in quotes there.
        is_literal = literal and (literal[0] == '"' or literal in ("true", "false", "Infinity") or isinstance(value_of(literal), float))
        if is_literal and default and value_of(default) is not None and value_of(literal) not in (None, value_of(default)):
            yield name, default, literal


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
    passed = failed = compared = defaults = 0
    for row, broken in [('"float g"                   0.5  mean cosine', True), ('"float g"  0  mean cosine', False),
                        ('"integer g"  0  mean cosine', True), ('"float f", "float g"  1, 2  both', True),
                        ('"float f", "float g"  1, 0  both', False), ('"float g" []  0  some', False)]:
        found = list(contradictions('x = params.GetFloat("g", 0.f);', "// Medium.\n//\n//   " + row + "\n"))
        if bool(found) == broken:
            passed += 1
        else:
            failed += 1
            print(f"control: {row}: {found or 'not found'}")
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
        found += [f'{path}: "{name}" is {said} in the head, and {read} in the code'
                  for name, said, read in contradictions(texts[path], head)]
        for name, (kind, default) in rows_of(head).items():  # negative controls
            getters = [g for g, n, _ in GET.findall(strip_comments(texts[path])) if n == name]
            other = re.sub(rf'"{kind} {re.escape(name)}"', f'"vector2 {name}"', head)
            if getters and not any(n == name for n, _, _ in contradictions(texts[path], other)):
                found.append(f'{path}: not noticed: another type of "{name}"')
            compared += bool(getters)
            if default and value_of(default) is not None:
                other = re.sub(rf'("{kind} {re.escape(name)}".*?  +){re.escape(default)}\b', r"\g<1>12345", head)
                literal = any(n == name and value_of(text or "x y") == value_of(default)
                              for _, n, text in GET.findall(strip_comments(texts[path])))
                if literal and other != head and not any(contradictions(texts[path], other)):
                    found.append(f'{path}: not noticed: another default of "{name}"')
                defaults += literal and other != head
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
    if len(plugins) < 60 or compared < 80 or defaults < 40:
        print(f"only {len(plugins)} plugins, {compared} types and {defaults} defaults found")
        failed += 1
    print(f"{passed} passed, {failed} failed")
    sys.exit(1 if failed else 0)


main()
