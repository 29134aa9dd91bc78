#!/usr/bin/env python3
"""Runs the fuzz targets for some minutes, spread over them and over the processors; see scripts/fuzz --help."""
import argparse
import concurrent.futures
import hashlib
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
LIMITS = ["-timeout=10", "-rss_limit_mb=2048", "-max_len=32768"]
PROGRESS_SECONDS = 30
# A target that breaks so often has its rest of the time cut: it would only find the same again.
MOST_BREAKS = 8
# Set where the user ends the run: what was done until then is reported.
STOPPED = threading.Event()
# Files of other folders that are inputs as well.
MORE_SEEDS = {
    "bulk_table": ["scenes/bulk/tables/*.json"],
    "exr": ["tests/conformance/refs/*.exr"],
    "lobe_table": ["data/lobes/*.txt"],
    "ply": ["tests/conformance/geometry/*.ply"],
    "scene_build": ["tests/conformance/*.pbrt"],
    "scene_statements": ["tests/conformance/*.pbrt", "tests/compatibility/*.pbrt"],
    "scene_text": ["tests/conformance/*.pbrt", "tests/compatibility/*.pbrt", "scenes/*.pbrt"],
}
STATUS = re.compile(r"^#(\d+)\t.*? cov: (\d+) ft: \d+ corp: (\d+)", re.M)
FINAL = re.compile(r"^stat::(\w+):\s+(\d+)", re.M)
LOADED = re.compile(r"^INFO: Loaded \d+ modules\s+\((\d+) inline", re.M)
SUMMARY = re.compile(r"^SUMMARY: (.*)$", re.M)
UNCAUGHT = re.compile(r"^terminate called.*?'([^']*)'\s*(?:what\(\):\s*(.*))?", re.M)
ARTIFACT = re.compile(r"Test unit written to (.*)$", re.M)


def absolute(path):
    return pathlib.Path(path).resolve()


def clock(seconds):
    return "%d:%02d" % divmod(int(seconds), 60)


class Target:
    """One target: what its runs have done so far."""

    def __init__(self, name, options):
        self.name, self.options = name, options
        self.corpus = options.corpus / name
        self.findings_folder = options.findings / name
        self.executions, self.coverage, self.edges, self.seconds, self.peak_mb = 0, 0, 0, 0.0, 0
        self.findings = {}  # by what they are: the input
        self.log = self.process = None

    def prepare(self):
        """More files beside the seeds of the repository, which are handed over as a folder."""
        self.corpus.mkdir(parents=True, exist_ok=True)
        for pattern in MORE_SEEDS.get(self.name, []):
            for path in sorted(ROOT.glob(pattern)):
                copy = self.corpus / ("repository-" + path.name)
                if path.stat().st_size <= 32768 and not copy.exists():
                    shutil.copyfile(path, copy)

    def command(self, *more):
        return [str(self.options.program), "--target=" + self.name, *LIMITS, *more]

    def dictionary(self):
        for name in (self.name, self.name.split("_")[0]):
            path = HERE / "dictionaries" / (name + ".dict")
            if path.exists():
                return ["-dict=" + str(path)]
        return []

    def run(self, seconds):
        """Until the time is up, beginning again after each finding."""
        self.prepare()
        end = time.monotonic() + seconds
        for _ in range(MOST_BREAKS):
            left = int(end - time.monotonic())
            if left <= 0 or STOPPED.is_set() or not self.run_once(left):
                break

    def stop(self):
        if self.process:
            os.kill(self.process.pid, signal.SIGTERM)

    def run_once(self, seconds):
        """True if it ended by a finding."""
        with tempfile.TemporaryDirectory(prefix="lacquer-fuzz-") as folder:
            self.log = pathlib.Path(folder) / "log"
            command = self.command("-max_total_time=%d" % seconds, "-print_final_stats=1", "-artifact_prefix=%s/" % folder,
                                   *self.dictionary(), str(self.corpus), str(HERE / "seeds" / self.name))
            with open(self.log, "w") as log:
                self.process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT, **self.inside(folder))
            # Time of the processor and not of the clock: a machine may have other work to do.
            _, status, usage = os.wait4(self.process.pid, 0)
            self.process = None
            self.seconds += usage.ru_utime + usage.ru_stime
            text = self.log.read_text(errors="replace")
            self.log = None
            self.count(text)
            found = status != 0 and not STOPPED.is_set()  # libFuzzer fails where it is interrupted, too
            if found:
                self.keep(text, folder)
        return found

    def count(self, text):
        lines, final = STATUS.findall(text), dict(FINAL.findall(text))
        self.executions += int(final.get("number_of_executed_units", lines[-1][0] if lines else 0))
        self.coverage = max([self.coverage] + [int(line[1]) for line in lines])
        self.peak_mb = max(self.peak_mb, int(final.get("peak_rss_mb", 0)))
        if loaded := LOADED.search(text):
            self.edges = int(loaded[1])

    def keep(self, text, folder):
        """Keeps the input, what was said of it, and how to see it again; of each kind of finding the first input."""
        summary, uncaught, artifact = SUMMARY.search(text), UNCAUGHT.search(text), ARTIFACT.search(text)
        what = " ".join(filter(None, uncaught.groups())) if uncaught else summary[1] if summary else "ended without a word"
        if what in self.findings:
            return
        if "timeout" in what and artifact and self.passes(artifact[1], folder):
            print("%s: an input took 10 s by the clock, and does not by itself; it does not count" % self.name, flush=True)
            return
        self.findings_folder.mkdir(parents=True, exist_ok=True)
        kept = self.findings_folder / hashlib.sha1(what.encode()).hexdigest()[:12]
        if artifact and os.path.exists(artifact[1]):
            shutil.copyfile(artifact[1], kept)
        command = " ".join(self.command(str(kept)))
        kept.with_suffix(".txt").write_text("%s\n\n%s\n\n%s" % (what, command, text[-20000:]))
        self.findings[what] = kept
        print("finding in %s: %s\n    %s" % (self.name, what, command), flush=True)

    def passes(self, path, folder):
        """An input by itself: where the machine has other work to do, the clock tells nothing of it."""
        return subprocess.run(self.command(path), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False,
                              **self.inside(folder)).returncode == 0

    @staticmethod
    def inside(folder):
        """What a run leaves behind stays in this folder."""
        return {"cwd": folder, "env": {**os.environ, "UBSAN_OPTIONS": "print_stacktrace=1", "TMPDIR": folder}}

    def progress(self):
        log = self.log
        try:
            lines = STATUS.findall(log.read_text(errors="replace")) if log else []
        except OSError:
            lines = []
        return "%s %s" % (self.name, "#%s cov %s" % lines[-1][:2] if lines else "begins")


def spread(targets, seconds, jobs):
    """Runs all targets, `jobs` at a time, each as long as all others."""
    share = seconds * jobs / len(targets)
    start = time.monotonic()
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        runs = {pool.submit(target.run, share): target for target in targets}
        waiting = set(runs)

        def stop(*_):
            STOPPED.set()
            for target in targets:
                target.stop()

        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, stop)
        while waiting:
            done, waiting = concurrent.futures.wait(waiting, PROGRESS_SECONDS, concurrent.futures.FIRST_EXCEPTION)
            for run in done:
                run.result()  # raises what has gone wrong here
            print("%s of about %s, %d of %d targets done; %s" % (
                clock(time.monotonic() - start), clock(seconds), len(targets) - len(waiting), len(targets),
                ", ".join(runs[run].progress() for run in runs if run.running())), flush=True)


def report(targets):
    row = "%-18s %12s %8s %16s %7s %7s %8s"
    print("\n" + row % ("target", "executions", "per s", "coverage", "corpus", "MB", "findings"))
    for t in targets:
        print(row % (t.name, "{:,}".format(t.executions), "{:,.0f}".format(t.executions / max(t.seconds, 1e-3)),
                     "%d of %d" % (t.coverage, t.edges), len(list(t.corpus.iterdir())), t.peak_mb, len(t.findings)))
    found = sum(len(t.findings) for t in targets)
    print("%s executions in %.1f hours of processors; coverage counts edges of the program's code, MB is the peak" % (
        "{:,}".format(sum(t.executions for t in targets)), sum(t.seconds for t in targets) / 3600))
    for t in targets:
        for what, kept in t.findings.items():
            print("%s: %s\n    %s" % (t.name, what, " ".join(t.command(str(kept)))))
    # Targets pass or fail; scripts/test adds this line up.
    failed = sum(1 for t in targets if t.findings)
    print("%d findings" % found)
    print("%d passed, %d failed" % (len(targets) - failed, failed))
    return 1 if found else 0


def main():
    parser = argparse.ArgumentParser(
        prog="scripts/fuzz", formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Builds the fuzz targets (preset fuzz: libFuzzer with address and undefined-behaviour sanitizers) and runs "
        "them.\nThe minutes are spread over the targets, which run on all processors. Ctrl-C ends the run early, with its report.",
        epilog="Grown corpora stay in build/fuzz-corpus, findings come to build/fuzz-findings, each with the command that\n"
        "reproduces it. Exit status: 0, 1 if anything was found. Findings are crashes, reports of sanitizers, exceptions that are\n"
        "no errors of users, more than 10 s and more than 2 GB. tests/fuzz/make_seeds.py writes the seeds.")
    parser.add_argument("minutes", type=float, help="of all targets together, by the clock")
    parser.add_argument("targets", nargs="*", metavar="TARGET", help="only these; default: all of tests/fuzz")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="targets that run at a time (default: the processors)")
    parser.add_argument("--program", type=absolute, default=ROOT / "build/fuzz/tests/fuzz/lacquer_fuzz", help=argparse.SUPPRESS)
    parser.add_argument("--corpus", type=absolute, default=ROOT / "build/fuzz-corpus", help=argparse.SUPPRESS)
    parser.add_argument("--findings", type=absolute, default=ROOT / "build/fuzz-findings", help=argparse.SUPPRESS)
    options = parser.parse_args()
    known = subprocess.run([options.program, "--list"], capture_output=True, text=True, check=True).stdout.split()
    for name in options.targets:
        if name not in known:
            parser.error("unknown target \"%s\"; there are %s" % (name, ", ".join(known)))
    if not options.minutes > 0 or options.jobs < 1:
        parser.error("minutes and --jobs must be positive")
    targets = [Target(name, options) for name in options.targets or known]
    spread(targets, options.minutes * 60, options.jobs)
    return report(targets)


if __name__ == "__main__":
    sys.exit(main())
