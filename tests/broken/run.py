#!/usr/bin/python3
"""Runs lacquer on broken scenes, broken assets and odd command lines, and judges how it answers.

usage: run.py LACQUER [NAME ...] [-v] [--jobs N] [--only broken | working] [--slow]

NAME    only the cases whose names contain one of these
-v      shows every message, and what each case took
--only  the cases, which Lacquer has to refuse, or the checks of what it has to do, which take most of the time
--slow  the slow checks as well, which are left out where neither this nor a NAME asks for them

A case passes if the exit status, the number of error messages, their positions and the stated fragments are
as expected, nothing was left behind, and the process neither crashed, nor took more than 20 s, nor held more
than 2 GB.
Exit status: 0 all passed; 1 some failed.
"""
import argparse
import concurrent.futures
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field

HERE = os.path.dirname(os.path.abspath(__file__))
TIMEOUT_SECONDS = 20
MEMORY_BYTES = 2 << 30
ADDRESS_SPACE_KIB = 2560 << 10  # of a process without sanitizers, whose shadow memory takes terabytes
MARK = "@"


@dataclass
class Case:
    """A scene, or the files and arguments of a run, and the answer that a user should get.

    A @ in `scene` or in a text of `files` is left out of the written file; it stands before the place that
    one error message must name as file:line:column.
    """
    name: str
    scene: "str | bytes | None"
    says: list                       # fragments that the messages must have
    status: int = 2
    args: list = field(default_factory=list)     # after the scene; without a scene: all of them
    files: dict = field(default_factory=dict)    # name -> text, bytes, or None for a folder
    prepare: object = None           # called with the folder, for files that are more than their content
    errors: object = None            # number of error messages; default: one for each mark, at least one
    warns: bool = False              # warnings may stand beside the errors


@dataclass
class Result:
    status: int                      # as subprocess has it: negative for a signal
    out: bytes
    err: str
    seconds: float
    peak_bytes: int


class Tool:
    """The program under test."""

    def __init__(self, path):
        self.path = os.path.abspath(path)
        with open(self.path, "rb") as f:
            self.sanitized = b"__asan_init" in f.read()

    def moment(self, seconds):
        """When a run that took `seconds` to be amid its work is there: one with sanitizers starts more slowly."""
        return seconds * (3 if self.sanitized else 1)

    def run(self, args, folder, stdin=None, timeout=TIMEOUT_SECONDS, signal_after=None, env=None):
        """Runs with `args` in `folder`; signal_after = (seconds, signal) interrupts it."""
        command = [self.path] + [str(a) for a in args]
        if not self.sanitized:
            command = ["sh", "-c", 'ulimit -v %d; exec "$0" "$@"' % ADDRESS_SPACE_KIB] + command
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            start = time.monotonic()
            process = subprocess.Popen(command, cwd=folder,
                                       stdin=subprocess.PIPE if stdin is not None else subprocess.DEVNULL,
                                       stdout=out, stderr=err, env=dict(os.environ, **(env or {})))
            if stdin is not None:
                try:
                    process.stdin.write(stdin)
                    process.stdin.close()
                except BrokenPipeError:
                    pass
            status, usage = self._wait(process, start, timeout, signal_after)
            seconds = time.monotonic() - start
            out.seek(0)
            err.seek(0)
            return Result(status, out.read(), err.read().decode("utf-8", "replace"), seconds,
                          usage.ru_maxrss * 1024)

    @staticmethod
    def _wait(process, start, timeout, signal_after):
        # os.wait4 gives the memory of this one child.
        while True:
            pid, code, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                process.returncode = os.waitstatus_to_exitcode(code)
                return process.returncode, usage
            seconds = time.monotonic() - start
            if signal_after and seconds > signal_after[0]:
                process.send_signal(signal_after[1])
                signal_after = None
            if seconds > timeout:
                process.kill()
            time.sleep(0.002 if seconds < 0.5 else 0.02)


def health(result, timeout=TIMEOUT_SECONDS):
    """What no run may do, whatever it is given."""
    problems = []
    if result.seconds > timeout:
        problems.append("hangs: not done after %d s" % timeout)
    elif result.status < 0:
        problems.append("crashed: %s" % signal.Signals(-result.status).name)
    if result.status == 70 or "bug in Lacquer" in result.err:
        problems.append("reports a bug of its own")
    if "Sanitizer" in result.err or "runtime error:" in result.err:
        problems.append("sanitizer report")
    if result.peak_bytes > MEMORY_BYTES:
        problems.append("took %d MB" % (result.peak_bytes >> 20))
    if "\x1b" in result.err:
        problems.append("terminal codes on a stderr that is no terminal")
    if re.search(r"[\x00-\x08\x0b-\x1a\x1c-\x1f\x7f]", result.err):
        problems.append("control characters in the messages")
    return problems


def write_file(folder, name, content):
    path = os.path.join(folder, name)
    if content is None:
        os.mkdir(path)
        return
    with open(path, "wb") as f:
        f.write(content if isinstance(content, bytes) else content.encode())


def positions(name, text):
    """The text without its marks, and the (file, line, column) of each."""
    if not isinstance(text, str) or MARK not in text:
        return text, []
    marks = []
    parts = text.split(MARK)
    plain = parts[0]
    for part in parts[1:]:
        line_start = plain.rfind("\n") + 1
        marks.append((name, plain.count("\n") + 1, len(plain[line_start:].encode()) + 1))
        plain += part
    return plain, marks


def run_case(case, tool):
    """(problems, what the run said)"""
    with tempfile.TemporaryDirectory(prefix="lacquer-broken-") as folder:
        marks = []
        for name, content in list(case.files.items()) + ([("scene.pbrt",
                                                           case.scene)] if case.scene is not None else []):
            plain, found = positions(name, content)
            marks += found
            write_file(folder, name, plain)
        if case.prepare:
            case.prepare(folder)
        before = set(os.listdir(folder))
        args = ["scene.pbrt", "--nthreads", "2"] + case.args if case.scene is not None else case.args
        result = tool.run(args, folder)
        left = sorted(set(os.listdir(folder)) - before)
        return judge(case, result, marks, left), result


def judge(case, result, marks, left):
    problems = health(result)
    if result.status != case.status:
        problems.append("exit status %d, not %d" % (result.status, case.status))
    lines = result.err.splitlines()
    messages = [line for line in lines if re.match(r"(?:.*: )?error: ", line)]
    # Beside the messages there are warnings, and under a message the line of the file with a mark.
    stray = [line for line in lines if not re.match(r"(?:.*: )?(?:error|warning): |  ", line)]
    if stray:
        problems.append("prints %r" % stray[0][:100])
    wanted = case.errors if case.errors is not None else max(1, len(marks))
    if isinstance(wanted, int):
        wanted = (wanted, wanted)
    if not wanted[0] <= len(messages) <= wanted[1]:
        expected = " to ".join(map(str, sorted(set(wanted))))
        problems.append("%d error messages, not %s" % (len(messages), expected))
    for name, line, column in marks:
        place = "%s:%d:%d: error: " % (name, line, column)
        if not any(m.startswith(place) or m.startswith("./" + place) for m in messages):
            problems.append("no message at %s:%d:%d" % (name, line, column))
    for fragment in case.says:
        if fragment not in result.err:
            problems.append("does not say %r" % fragment)
    if not case.warns and "warning:" in result.err:
        problems.append("warns as well")
    if result.out:
        problems.append("writes to stdout: %r" % result.out[:60])
    if left:
        problems.append("leaves %s behind" % ", ".join(left))
    return problems


def run_check(check, tool):
    """A check is a function of (tool, folder) that raises AssertionError; its name is its claim."""
    with tempfile.TemporaryDirectory(prefix="lacquer-check-") as folder:
        start = time.monotonic()
        try:
            said = check(tool, folder) or ""
            return [], Result(0, b"", said, time.monotonic() - start, 0)
        except AssertionError as problem:
            return [str(problem)], Result(0, b"", "", time.monotonic() - start, 0)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("lacquer")
    parser.add_argument("names", nargs="*")
    parser.add_argument("-v", "--verbose", action="store_true")
    parser.add_argument("--only", choices=["broken", "working"])
    parser.add_argument("--slow", action="store_true")
    parser.add_argument("--jobs", type=int, default=min(4, os.cpu_count() or 1))
    options = parser.parse_intermixed_args()

    import adaptive
    import aovs
    import appearance
    import assets
    import bulk
    import capture
    import checkpoints
    import command_line
    import compare
    import display
    import estimate
    import graphs
    import hostile
    import image_commands
    import imgtool
    import media
    import merge_states
    import scene_commands
    import scenes
    import sequences
    import standard_input
    tool = Tool(options.lacquer)
    parts = [scenes, assets, command_line, adaptive, appearance, checkpoints, merge_states, standard_input, image_commands, imgtool, compare, display, media, aovs, scene_commands, graphs, hostile, sequences,
             bulk, capture, estimate]
    work = [(c.name, run_case, c) for part in parts for c in part.CASES]
    work += [(f.__name__.replace("_", "-"), run_check, f) for part in parts for f in getattr(part, "CHECKS", [])]
    names = [name for name, _, _ in work]
    twice = {n for n in names if names.count(n) > 1}
    assert not twice, "two cases of one name: %s" % twice
    work = [w for w in work if not options.names or any(n in w[0] for n in options.names)]
    if options.only:
        work = [w for w in work if (w[1] is run_case) == (options.only == "broken")]

    if not options.slow and not options.names:
        work = [w for w in work if not getattr(w[2], "is_slow", False)]

    failed = 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        outcomes = pool.map(lambda w: w[1](w[2], tool), work)
        for (name, _, _), (problems, result) in zip(work, outcomes):
            if options.verbose:
                print("---- %s: exit %d, %.2f s, %d MB" % (name, result.status, result.seconds,
                                                           result.peak_bytes >> 20))
                print(result.err, end="")
            if problems:
                failed += 1
                got = next((m for m in result.err.splitlines() if "error" in m), "")
                print("FAIL  %s: %s%s" % (name, "; ".join(problems),
                                          "  [got: %s]" % got[:240] if got else ""))
            sys.stdout.flush()
    print("%d passed, %d failed" % (len(work) - failed, failed))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.path.insert(0, HERE)
    sys.modules["run"] = sys.modules["__main__"]
    sys.exit(main())
