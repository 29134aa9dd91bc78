#!/usr/bin/env python3
"""No function is longer than 60 lines.

usage: check_size.py
The functions that were longer when the limit came stand below with their lengths, which may only shrink: one that has
grown fails, and so does an entry whose function has become short or has gone.
Prints each violation and a closing line 'N passed, N failed'. The check is itself checked on made-up functions.
"""
import sys

import cpp_scan

MAX_LINES = 60
# "file: function": lines.
LONG = {
    "tests/layered/stack_table.cpp: AddMedia": 73,
    "tests/layered/strategies_test.cpp: Rows": 70,
    "tests/shapes/ply_test.cpp: Encode": 70,
    "tests/shapes/ply_test.cpp: TEST": 66,
    "tests/support/bxdf_survey.cpp: TakeSurvey": 76,
}


def long_functions(entities, known):
    """Reasons against the functions, given the known long ones."""
    left = dict(known)
    for e in entities:
        lines = e.last - e.line + 1
        if e.kind != "function" or lines <= MAX_LINES:
            continue
        key = "%s: %s" % (e.path, e.name)
        if key not in known:
            yield "%s:%d: %s has %d lines; at most %d" % (e.path, e.line, e.name, lines, MAX_LINES)
        elif lines > known[key]:
            yield "%s:%d: %s has grown from %d to %d lines" % (e.path, e.line, e.name, known[key], lines)
        left.pop(key, None)
    for key in left:
        yield "%s is no longer too long: take it out of check_size.py" % key


def made_up(lines, head="float F(float x)"):
    return cpp_scan.scan("src/x.cpp", "namespace lacquer {\n%s {\n%s}\n}\n" % (head, "    ++x;\n" * (lines - 2)))


def main():
    constructor = "Cloud::Cloud(int n)\n    : n_{n}, sums_(n) "
    controls = [
        ("61 lines", made_up(61), {}, True),
        ("60 lines", made_up(60), {}, False),
        ("a constructor", made_up(61, constructor), {}, True),
        ("a function of a class", cpp_scan.scan("src/x.h", "class A {\n  public:\n    void F() const {\n%s    }\n};\n" % (";\n" * 60)),
         {}, True),
        ("a lambda of a namespace", made_up(61, "const auto kTable = [](int n) -> float"), {}, True),
        ("a short one", made_up(60, "const auto kTable = [](int n) -> float"), {}, False),
        ("a lambda in a macro", cpp_scan.scan("src/x.cpp", "LACQUER_REGISTER(Kind, \"x\", [](const Args& a) {\n%s});\n" % (";\n" * 60)),
         {}, True),
        ("a table of lambdas", cpp_scan.scan("src/x.cpp", "constexpr Row kRows[] = {\n%s};\n" % ("    {\"x\", [](int n) { return n; }},\n" * 70)),
         {}, False),
        ("a long one in a table", cpp_scan.scan("src/x.cpp", "constexpr Row kRows[] = {\n    {\"x\", [](int n) {\n%s    }},\n};\n" % (";\n" * 60)),
         {}, True),
        ("behind a macro", made_up(61, "LACQUER_NOINLINE float F(float x)"), {}, True),
        ("behind a macro with arguments", made_up(61, "LACQUER_TARGET(\"avx2\") float F(float x)"), {}, True),
        ("as the body of a macro", made_up(61, "LACQUER_CASE(Kind, x)"), {}, True),
        ("a known one that grew", made_up(63), {"src/x.cpp: F": 62}, True),
        ("a known one", made_up(62), {"src/x.cpp: F": 62}, False),
        ("a known one that shrank", made_up(61), {"src/x.cpp: F": 62}, False),
        ("a known one that has gone", made_up(20), {"src/x.cpp: F": 62}, True),
    ]
    passed, failed = cpp_scan.count_controls(
        [(name, broken, list(long_functions(entities, known))) for name, entities, known, broken in controls])
    entities = cpp_scan.scan_all("src", "tests", "bench")
    reasons = list(long_functions(entities, LONG))
    for reason in reasons:
        print(reason)
    print("%d passed, %d failed" % (passed + len({e.path for e in entities}), failed + len(reasons)))
    sys.exit(1 if failed + len(reasons) else 0)


main()
