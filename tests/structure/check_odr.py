#!/usr/bin/env python3
"""Finds what the one-definition rule forbids and no compiler of one file sees.

usage: check_odr.py
Two rules, over src, tests and bench:
  - a name of a namespace has one definition: two classes of one name in two files, of which each translation unit sees its
    own, share the functions that the compiler makes for them (destructors, std::vector of them), and the linker keeps one
    of each. Only unnamed namespaces, and constants of a .cpp file, are a file's own.
  - a function of a nested namespace does not hide one of an outer namespace's headers: in lacquer::layered, a
    Dot(Vec2, Vec2) hides lacquer::Dot(Vec3, Vec3), and a Vec3 turns into a Vec2 without a word.
Functions of one signature that are not inline are the linker's business, and found as well.
Prints each violation and a closing line 'N passed, N failed'. The check is itself checked on made-up files.
"""
import collections
import re
import sys

import cpp_scan

# Of these files and others, a build has one or the other.
ALTERNATIVES = ("src/pbrt/core/parallel_std.cpp",)


def second_definitions(entities):
    """Names of a namespace that are defined twice, and members in two files."""
    targets = collections.defaultdict(set)
    for e in entities:
        if e.kind == "alias" and not e.member:
            targets[e.name].add(e.parameters)
    aliases = {name: texts.pop() for name, texts in targets.items() if len(texts) == 1}
    places = collections.defaultdict(dict)
    for e in entities:
        if not e.defined or e.local or e.kind == "using" or e.name == "main" or e.path in ALTERNATIVES:
            continue
        if e.kind == "alias" and e.path.endswith(".cpp"):
            continue       # has no linkage
        key = (e.namespace, e.name, plain_types(e.parameters, aliases) if e.kind == "function" else None)
        places[key].setdefault((e.path, e.line), e)
    for (namespace, name, parameters), where in sorted(places.items(), key=str):
        # A bench and a test are never in one program, and benches have mains of their own.
        if next(iter(where.values())).member and len({path for path, _ in where}) == 1:
            continue       # of one class, as const and not
        tops = collections.Counter(path.split("/")[0] for path, _ in where)
        if len(where) > 1 and (tops["src"] + max(tops["tests"], tops["bench"]) > 1):
            signature = "" if parameters is None else "(%s)" % parameters
            yield "%s::%s%s is defined in %s" % (namespace, name, signature,
                                                 " and in ".join("%s:%d" % place for place in sorted(where)))


def plain_types(parameters, aliases):
    """Types as written, with what their aliases stand for."""
    for _ in range(8):
        written, parameters = parameters, re.sub(
            r"(?<![\w:])(?:lacquer::)?([A-Za-z_]\w*)(?!\w|::)", lambda m: aliases.get(m.group(1)) or m.group(0), parameters)
        if parameters == written:
            break
    return parameters


def hidden_functions(entities):
    """Functions of src's nested namespaces that hide those of an outer one's headers and take as many arguments."""
    outer = collections.defaultdict(list)
    brought = {(e.path, e.namespace, e.name) for e in entities if e.kind == "using"}
    for e in entities:
        if e.kind == "function" and not e.member and not e.local and e.path.endswith(".h"):
            outer[e.namespace, e.name].append(e)
    for e in entities:
        if e.kind != "function" or e.member or e.name.startswith("operator ") or not e.path.startswith("src/"):
            continue
        parts = e.namespace.split("::")
        for above in ("::".join(parts[:n]) for n in range(1, len(parts))):
            for h in outer.get((above, e.name), []):
                if arity(h) == arity(e) and (e.path, e.namespace, e.name) not in brought:
                    yield "%s:%d: %s::%s(%s) hides %s(%s) of %s; rename it, or say 'using %s::%s;' before it" % (
                        e.path, e.line, e.namespace, e.name, e.parameters, above + "::" + h.name, h.parameters, h.path, above,
                        h.name)


def arity(function):
    return function.parameters.count(", ") + bool(function.parameters)


def judge(entities):
    return [*second_definitions(entities), *hidden_functions(entities)]


# Made-up files, and whether they break a rule.
CONTROLS = [
    ("two classes of one name", True, {
        "src/a.cpp": "namespace lacquer {\nstruct Interval {\n    double low, high;\n};\n}",
        "src/b.cpp": "namespace lacquer {\nclass Interval final : public Base {\n    int n;\n};\n}"}),
    ("two enums", True, {
        "src/a.h": "namespace lacquer {\nenum class Side { Left };\n}",
        "src/b.cpp": "namespace lacquer {\nenum class Side : uint8_t { Top };\n}"}),
    ("two inline functions", True, {
        "src/a.h": "namespace lacquer {\ninline float Sqr(float x) { return x * x; }\n}",
        "src/b.h": "namespace lacquer {\ninline float Sqr(float value) { return value; }\n}"}),
    ("two templates", True, {
        "src/a.h": "namespace lacquer {\ntemplate <class T>\nstruct Box {\n    T t;\n};\n}",
        "src/b.h": "namespace lacquer {\ntemplate <class T>\nstruct Box {\n    T t, u;\n};\n}"}),
    ("two inline variables", True, {
        "src/a.h": "namespace lacquer {\ninline constexpr int kSize = 3;\n}",
        "src/b.h": "namespace lacquer {\ninline constexpr int kSize = 4;\n}"}),
    ("a class and an alias in headers", True, {
        "src/a.h": "namespace lacquer {\nclass Row {};\n}", "src/b.h": "namespace lacquer {\nusing Row = int;\n}"}),
    ("a test's class and the library's", True, {
        "src/a.cpp": "namespace lacquer::cmd {\nstruct Fixture {};\n}",
        "tests/b.cpp": "namespace lacquer::cmd {\nstruct Fixture {};\n}"}),
    ("two operators", True, {
        "src/a.h": "namespace lacquer {\ninline Vec2 operator+(Vec2 a, Vec2 b) { return a; }\n}",
        "src/b.h": "namespace lacquer {\ninline Vec2 operator+(Vec2 u, Vec2 v) { return v; }\n}"}),
    ("two types of C", True, {
        "src/a.h": "namespace lacquer {\ntypedef struct {\n    int n;\n} Row;\n}",
        "src/b.h": "namespace lacquer {\nstruct Row {\n    float n;\n};\n}"}),
    ("a member twice", True, {
        "src/a.h": "namespace lacquer {\ninline int Row::Size(int k) const {\n    return k;\n}\n}",
        "src/b.h": "namespace lacquer {\ninline int Row::Size(int n) const {\n    return n + 1;\n}\n}"}),
    ("a member with and without const", False, {
        "src/a.h": "namespace lacquer {\nstruct Row {\n    int& At(int k) { return n; }\n    const int& At(int k) const { return n; }\n"
                   "};\n}"}),
    ("two names of one type", True, {
        "src/a.h": "namespace lacquer {\nusing RGB = glm::vec3;\nusing Point = glm::vec3;\n"
                   "inline float Mean(RGB c) { return 0; }\n}",
        "src/b.h": "namespace lacquer {\ninline float Mean(Point p) { return 1; }\n}"}),
    ("names of two types", False, {
        "src/a.h": "namespace lacquer {\nusing RGB = glm::vec3;\nusing Point = glm::vec2;\n"
                   "inline float Mean(RGB c) { return 0; }\n}",
        "src/b.h": "namespace lacquer {\ninline float Mean(Point p) { return 1; }\n}"}),
    ("two operators of two types", False, {
        "src/a.h": "namespace lacquer {\ninline Vec2 operator+(Vec2 a, Vec2 b) { return a; }\n}",
        "src/b.h": "namespace lacquer {\ninline Vec3 operator+(Vec3 a, Vec3 b) { return a; }\n}"}),
    ("unnamed namespaces", False, {
        "src/a.cpp": "namespace lacquer {\nnamespace {\nstruct Row {};\n}\n}",
        "src/b.cpp": "namespace lacquer {\nnamespace {\nstruct Row {};\n}\n}"}),
    ("two namespaces", False, {
        "src/a.h": "namespace lacquer::compare {\nstruct Interval {};\n}",
        "src/b.h": "namespace lacquer::cmd {\nstruct Interval {};\n}"}),
    ("overloads and specialisations", False, {
        "src/a.h": "namespace lacquer {\ninline float Sqr(float x) { return x * x; }\ntemplate <class T>\nstruct Box {};\n}",
        "src/b.h": "namespace lacquer {\ninline double Sqr(double x) { return x * x; }\ntemplate <>\nstruct Box<int> {};\n}"}),
    ("a declaration and a definition", False, {
        "src/a.h": "namespace lacquer {\nclass Row;\nfloat F(int n = 3);\n}",
        "src/b.cpp": "namespace lacquer {\nclass Row {};\nfloat F(int n) { return n; }\n}"}),
    ("a nested function that hides", True, {
        "src/a.h": "namespace lacquer {\ninline float Dot(Vec3 a, Vec3 b) { return 0; }\n}",
        "src/b.h": "namespace lacquer::layered {\ninline float Dot(Vec2 a, Vec2 b) { return 0; }\n}"}),
    ("one that hides from an unnamed namespace", True, {
        "src/a.h": "namespace lacquer {\nfloat Dot(Vec3 a, Vec3 b);\n}",
        "src/b.cpp": "namespace lacquer::layered {\nnamespace {\nfloat Dot(Vec2 a, Vec2 b) { return 0; }\n}\n}"}),
    ("an overload that brings the others along", False, {
        "src/a.h": "namespace lacquer {\nfloat Dot(Vec3 a, Vec3 b);\n}",
        "src/b.h": "namespace lacquer::layered {\nusing lacquer::Dot;\ninline float Dot(Vec2 a, Vec2 b) { return 0; }\n}"}),
]


def main():
    passed, failed = cpp_scan.count_controls([
        (name, broken, judge([e for path, text in sources.items() for e in cpp_scan.scan(path, text)]))
        for name, broken, sources in CONTROLS])
    entities = cpp_scan.scan_all("src", "tests", "bench")
    for reason in judge(entities):
        print(reason)
        failed += 1
    for path in cpp_scan.files("src", "tests", "bench"):
        for line in cpp_scan.lost(path):
            print("%s:%d: cpp_scan.py does not understand this definition" % (path, line))
            failed += 1
    passed += len({e.path for e in entities})
    print("%d passed, %d failed" % (passed, failed))
    sys.exit(1 if failed else 0)


main()
