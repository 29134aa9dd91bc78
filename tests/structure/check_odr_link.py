#!/usr/bin/env python3
"""Lets the compiler compare the definitions of all translation units of lacquer: link-time optimisation, -Wodr.

usage: check_odr_link.py FOLDER
FOLDER   of the build, made where it is not there; nothing of it is run
Sees what check_odr.py cannot: types, enums and signatures as they are after macros, templates and aliases. Bodies of inline
functions are not compared by it, names in unnamed namespaces are left out by both. Skips where the compiler is not GCC.
Prints the warnings and a closing line 'N passed, N failed'. The check is itself checked: two programs, of two files each, of
which one has two structs of one name.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
COMPILER = os.environ.get("CXX", "c++")
COMPILE = ["-O0", "-flto", "-fno-fat-lto-objects"]
LINK = ["-flto=%d" % (os.cpu_count() or 1), "-Wodr"]
WARNING = re.compile(r"^.*\[-W(?:odr|lto-type-mismatch)\]$", re.M)

FIRST = "#include <vector>\nnamespace a { struct Interval { double low, high; }; }\n" \
        "double First() { return std::vector<a::Interval>(3)[0].low; }\n"
SECOND = "#include <vector>\nnamespace %s { struct Interval { int low; }; }\n" \
         "double First();\nint main() { return int(First()) + std::vector<%s::Interval>(3)[0].low; }\n"


def run(command, folder):
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace")


def warnings_of(namespace):
    """Of the linker, for a program with a::Interval and one of `namespace`."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (("first", FIRST), ("second", SECOND % (namespace, namespace))):
            with open(os.path.join(folder, name + ".cpp"), "w", encoding="utf-8") as file:
                file.write(text)
            made = run([COMPILER, *COMPILE, "-c", name + ".cpp"], folder)
            if made.returncode:
                sys.exit(made.stderr)
        return WARNING.findall(run([COMPILER, *COMPILE, *LINK, "first.o", "second.o", "-o", "program"], folder).stderr)


def main():
    folder = os.path.abspath(sys.argv[1])
    if "Free Software Foundation" not in run([COMPILER, "--version"], ROOT).stdout:
        print("SKIP: definitions compared by the linker: %s is not GCC" % COMPILER)
        print("0 passed, 0 failed, 1 skipped")
        return
    passed = failed = 0
    for namespace, broken in (("a", True), ("b", False)):
        if bool(warnings_of(namespace)) == broken:
            passed += 1
        else:
            failed += 1
            print("control: two structs Interval, in a and in %s: %s" % (namespace, "not found" if broken else "found"))
    configured = run(["cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Debug",
                      "-DCMAKE_CXX_FLAGS_DEBUG=" + " ".join(COMPILE), "-DCMAKE_EXE_LINKER_FLAGS=" + " ".join(LINK),
                      "-DLACQUER_TESTS=OFF", "-DLACQUER_BENCH=OFF", "-DLACQUER_INSTALL=OFF"], ROOT)
    if configured.returncode:
        sys.exit(configured.stdout + configured.stderr)
    program = os.path.join(folder, "src", "cmd", "lacquer")
    if os.path.exists(program):
        os.remove(program)      # the linker speaks when it links
    built = run(["ninja", "-C", folder, "lacquer"], ROOT)
    if built.returncode or not os.path.exists(program):
        sys.exit(built.stdout[-4000:] + built.stderr)
    found = WARNING.findall(built.stdout)
    for warning in found:
        print(warning)
    print("%d passed, %d failed" % (passed + (not found), failed + len(found)))
    sys.exit(1 if failed or found else 0)


if not shutil.which("ninja"):
    sys.exit("check_odr_link.py needs ninja")
main()
