#!/usr/bin/python3
"""Renders by several processes under Open MPI on this machine: the bits of one process, whatever dies.

usage: run.py LACQUER [--scaling [--resolution WxH] [--spp N]] [CASE ...]

Up to four ranks share the processors of this machine (mpirun --oversubscribe). Of all films, auxiliary outputs, passes and light that
is traced from the lights; with ranks and managers that are killed, stopped, cannot read the scene, or run something else. --scaling
measures instead how much faster several ranks are, for docs/farm.md. Skips with a reason where mpirun is not installed, or Lacquer was
built without MPI (Debian: apt-get install libopenmpi-dev openmpi-bin, then configure anew). Needs Debian's openimageio-tools.
Exit status: 0 passed or skipped; 1 failed.
"""
import argparse
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

SCENE = """LookAt 0 1 -4  0 0.3 0  0 1 0
Camera "perspective" "float fov" 40 "float lensradius" 0.02 "float focaldistance" 4
Film "FILM" "integer xresolution" 160 "integer yresolution" 120 "string filename" "image.exr"
Sampler "SAMPLER" "integer pixelsamples" 32
Integrator "INTEGRATOR"
WorldBegin
LightSource "infinite" "rgb L" [.1 .12 .15]
AttributeBegin AreaLightSource "diffuse" "rgb L" [9 8 7] "string group" "key"
Translate 0 3 0 Rotate 90 1 0 0 Shape "disk" "float radius" 0.7 AttributeEnd
AttributeBegin Material "conductor" "float roughness" 0.2 Translate -0.8 0.6 0 Shape "sphere" "float radius" 0.6 AttributeEnd
AttributeBegin Material "dielectric" Translate 0.7 0.5 0.2 Shape "sphere" "float radius" 0.5 AttributeEnd
Material "coateddiffuse"
Shape "bilinearmesh" "point3 P" [-5 0 -5  5 0 -5  -5 0 5  5 0 5]
"""
# Name: film, sampler, integrator, options.
BITS = {
    "rgb": ("rgb", "zsobol", "path", []),
    "outputs": ("rgb", "halton", "volpath", ["--aov", "half,depth,albedo,variance,cryptoobject,cryptomaterial,samples"]),
    "passes": ("rgb", "sobol", "path", ["--aov", "direct,lightgroups,emission,half"]),
    "spectral": ("spectral", "independent", "path", []),
    "gbuffer": ("gbuffer", "paddedsobol", "volpath", []),
    "bdpt": ("rgb", "zsobol", "bdpt", ["--spp", "8"]),
    "lightpath": ("rgb", "halton", "lightpath", ["--aov", "depth"]),
    "crop": ("gbuffer", "zsobol", "path", ["--cropwindow", "0.2,0.71,0.1,0.8", "--sample-range", "3:17"]),
}
MPIRUN = ["mpirun", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none"]
LONG = ["--spp", "100000"]
EVERY = ["--checkpoint", "a.state", "--checkpoint-every", "0.3"]


def pixels(path):
    """Digest of the values of all channels, whatever the metadata."""
    done = subprocess.run(["oiiotool", "--info", "-v", "--hash", path], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    found = re.search(r"SHA-1: (\w+)", done.stdout)
    return found.group(1) if found else done.stdout


def wait(what, seconds, condition):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return
        time.sleep(0.05)
    raise AssertionError("%s: not within %d s" % (what, seconds))


class Bench:
    """A folder with a scene, and ways to render it."""

    def __init__(self, lacquer, folder):
        self.lacquer, self.folder = lacquer, folder

    def path(self, name):
        return os.path.join(self.folder, name)

    def scene(self, name, film, sampler, integrator):
        text = SCENE.replace("FILM", film).replace("SAMPLER", sampler).replace("INTEGRATOR", integrator)
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)

    def clear(self):
        for name in os.listdir(self.folder):
            os.remove(self.path(name))
        # Its numbers do not depend on how many there are: a state of more samples can go on to fewer.
        self.scene("scene.pbrt", "rgb", "halton", "path")

    def mpi(self, ranks, options, scene="scene.pbrt", program=None):
        """The command of so many ranks, without mpirun."""
        return ["-np", str(ranks), program or self.lacquer, "render", "--mpi", scene, "--nthreads", "1", *options]

    def start(self, command):
        # pylint: disable-next=consider-using-with
        return subprocess.Popen(command, cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def run(self, command, seconds=300):
        """Status and messages. Whatever happens, it must end."""
        return self.end(self.start(command), seconds)

    def end(self, process, seconds=60):
        try:
            said = process.communicate(timeout=seconds)[0]
        except subprocess.TimeoutExpired as e:
            process.kill()
            raise AssertionError("hangs: %s" % " ".join(process.args)) from e
        return process.returncode, said

    def render(self, ranks, options):
        """By so many ranks; 0: without MPI."""
        command = [*MPIRUN, *self.mpi(ranks, options)] if ranks > 0 else [self.lacquer, "scene.pbrt", *options]
        status, said = self.run(command)
        assert status == 0, "status %d: %s" % (status, said)
        return said

    def ranks(self, mpirun):
        """Processes of a job by their ranks."""
        found = {}
        for name in filter(str.isdigit, os.listdir("/proc")):
            try:
                with open("/proc/%s/stat" % name, encoding="utf-8") as file:
                    parent = int(file.read().rsplit(")", 1)[1].split()[1])
                with open("/proc/%s/environ" % name, "rb") as file:
                    rank = re.search(rb"OMPI_COMM_WORLD_RANK=(\d+)", file.read())
            except (OSError, IndexError):
                continue
            if parent == mpirun.pid and rank:
                found[int(rank.group(1))] = int(name)
        return found

    def is_whole(self, image):
        """An image that is there has all its bytes."""
        return subprocess.run(["oiiotool", "--stats", image], cwd=self.folder, capture_output=True, check=False).returncode == 0


def same_bits(bench, name):
    film, sampler, integrator, options = BITS[name]
    bench.scene("scene.pbrt", film, sampler, integrator)
    bench.render(0, [*options, "--outfile", "whole.exr", "--stats-json", "whole.json"])
    expected = pixels(bench.path("whole.exr"))
    for ranks in (1, 2, 4):
        bench.render(ranks, [*options, "--outfile", "mpi.exr", "--stats-json", "mpi.json"])
        assert pixels(bench.path("mpi.exr")) == expected, "another image by %d ranks" % ranks
        with open(bench.path("whole.json"), encoding="utf-8") as a, open(bench.path("mpi.json"), encoding="utf-8") as b:
            one, all_ranks = json.load(a), json.load(b)
        for key in ("rays", "bad_samples", "samples", "samples_per_pixel", "mean_path_length", "complete"):
            assert one[key] == all_ranks[key], "%s: %s and %s" % (key, one[key], all_ranks[key])
        assert all_ranks["threads"] == ranks, all_ranks["threads"]
    # The comparison sees what it should.
    bench.render(2, [*options, "--outfile", "mpi.exr", "--seed", "7"])
    assert pixels(bench.path("mpi.exr")) != expected, "the comparison does not see another seed"


def without_mpirun(bench):
    bench.render(0, ["--outfile", "whole.exr"])
    status, said = bench.run([bench.lacquer, "render", "--mpi", "scene.pbrt", "--outfile", "mpi.exr"])
    assert status == 0, said
    assert pixels(bench.path("mpi.exr")) == pixels(bench.path("whole.exr"))


def resumed(bench, samples):
    """A state that a job has left, taken up by one process and by three ranks: the bits of a whole render."""
    shutil.copy(bench.path("a.state"), bench.path("b.state"))
    options = ["--spp", str(samples)]
    bench.render(0, [*options, "--outfile", "whole.exr"])
    bench.render(0, [*options, "--resume", "a.state", "--outfile", "one.exr"])
    bench.render(3, [*options, "--resume", "b.state", "--outfile", "three.exr"])
    for name in ("one.exr", "three.exr"):
        assert pixels(bench.path(name)) == pixels(bench.path("whole.exr")), name + " is another image"


def info(bench):
    """What the state says of itself."""
    done = subprocess.run([bench.lacquer, "info", "a.state", "--json"], cwd=bench.folder, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)[0]


def most_samples(bench):
    return max(part["most_samples"] for part in info(bench)["parts"])


def killed(bench, victim):
    """A rank is killed in mid-render: the job ends by itself, and goes on from its state."""
    process = bench.start([*MPIRUN, *bench.mpi(4, [*LONG, *EVERY, "--outfile", "mpi.exr", "--write-partial-images"])])
    wait("a state and an image", 60, lambda: os.path.exists(bench.path("a.state.previous")) and os.path.exists(bench.path("mpi.exr")))
    os.kill(bench.ranks(process)[victim], signal.SIGKILL)
    status, said = bench.end(process, 30)
    assert status != 0, said
    assert bench.is_whole("mpi.exr")
    strange = set(os.listdir(bench.folder)) - {"scene.pbrt", "mpi.exr", "a.state", "a.state.previous", "a.state.lock"}
    assert not strange, strange
    resumed(bench, most_samples(bench) + 20)


def stopped(bench, number, expected):
    """A signal at mpirun: the image and the state are written."""
    mpirun = [*MPIRUN, "--mca", "odls_base_sigkill_timeout", "2"]
    process = bench.start([*mpirun, *bench.mpi(3, [*LONG, "--checkpoint", "a.state", "--outfile", "mpi.exr"])])
    wait("ranks", 30, lambda: len(bench.ranks(process)) == 3)
    time.sleep(1.5)
    assert not os.path.exists(bench.path("mpi.exr"))
    process.send_signal(number)
    status, said = bench.end(process, 30)
    assert status == expected and "stopped by a signal" in said, "status %d: %s" % (status, said)
    assert bench.is_whole("mpi.exr")
    resumed(bench, most_samples(bench) + 20)


def from_one_process(bench):
    """A render that one process has begun, and that was stopped amid a pass."""
    process = bench.start([bench.lacquer, "scene.pbrt", *LONG, *EVERY, "--outfile", "mpi.exr", "--nthreads", "2"])
    wait("a state", 30, lambda: os.path.exists(bench.path("a.state")))
    process.send_signal(signal.SIGTERM)
    status, said = bench.end(process)
    assert status == 143, said
    resumed(bench, most_samples(bench) + 20)


def job_of_two(bench, first, second, expected, *texts):
    """Two ranks with different commands: they end with this status and these texts, each once."""
    status, said = bench.run([*MPIRUN, *first, ":", *second], 60)
    assert status == expected, "status %d: %s" % (status, said)
    for text in texts:
        assert said.count(text) == 1, "%d times \"%s\": %s" % (said.count(text), text, said)
    assert not os.path.exists(bench.path("image.exr"))


def unreadable_scene(bench):
    with open(bench.path("other.pbrt"), "w", encoding="utf-8") as file:
        file.write('WorldBegin\nShape "sphere" "float radius" [')
    missing = bench.mpi(1, [], "missing.pbrt")
    job_of_two(bench, bench.mpi(1, []), missing, 3, "rank 1 on ", "missing.pbrt")
    job_of_two(bench, bench.mpi(1, []), bench.mpi(1, [], "other.pbrt"), 2, "rank 1 on ", "other.pbrt")
    job_of_two(bench, missing, bench.mpi(1, []), 3, "error: missing.pbrt")
    # The same error on all ranks is said once.
    job_of_two(bench, missing, missing, 3, "missing.pbrt")


def another_render(bench):
    bench.scene("other.pbrt", "rgb", "halton", "path")
    with open(bench.path("other.pbrt"), "a", encoding="utf-8") as file:
        file.write("# changed\n")
    job_of_two(bench, bench.mpi(1, []), bench.mpi(1, [], "other.pbrt"), 3, "differs from rank 0 in the scene's file \"")
    job_of_two(bench, bench.mpi(1, []), bench.mpi(1, ["--seed", "7"]), 3, "differs from rank 0 in \"seed\"")
    job_of_two(bench, bench.mpi(1, []), bench.mpi(1, ["--spp", "31"]), 3, "differs from rank 0 in the samples")


def another_build(bench):
    """The program with another version of the compiler among its texts."""
    bench.render(0, ["--checkpoint", "a.state"])
    os.remove(bench.path("image.exr"))
    version = info(bench)["program"]["compiler"].encode()
    with open(bench.lacquer, "rb") as file:
        program = file.read()
    changed = program.replace(b"\0" + version + b"\0", b"\0" + b"x" + version[1:] + b"\0")
    assert changed != program, "the program does not contain the version of its compiler"
    with open(bench.path("changed"), "wb") as file:
        file.write(changed)
    os.chmod(bench.path("changed"), 0o755)
    job_of_two(bench, bench.mpi(1, []), bench.mpi(1, [], program=bench.path("changed")), 3, "differs from rank 0 in the program's compiler")


def refused(bench):
    for option in (["--frames", "1-2"], ["--adaptive"], ["--noise-target", "5%"], ["--time-limit", "3"], ["--pixelstats"],
                   ["--mse-reference-image", "a.exr", "--mse-reference-out", "a.txt"], ["--sandbox"]):
        status, said = bench.run([*MPIRUN, *bench.mpi(2, option)], 60)
        assert status == 1 and said.count("error: %s does not go with --mpi" % option[0]) == 1, "status %d: %s" % (status, said)
    bench.scene("guided.pbrt", "rgb", "halton", 'path" "bool guiding" true "string lightsampler" "bvh')
    status, said = bench.run([*MPIRUN, *bench.mpi(2, [], "guided.pbrt")], 60)
    assert status == 1 and said.count("a guide learns from all of it") == 1, "status %d: %s" % (status, said)
    status, said = bench.run([*MPIRUN, *bench.mpi(2, [], "-")], 60)
    assert status == 1 and "standard input" in said, said
    status, said = bench.run([*MPIRUN, *bench.mpi(2, ["--outfile", "no/such/folder.exr"])], 60)
    assert status == 3 and said.count("no/such") >= 1, said


def live(bench):
    """Images on the way, and a state that is there before."""
    process = bench.start([*MPIRUN, *bench.mpi(3, [*LONG, "--outfile", "mpi.exr", "--write-partial-images"])])
    wait("an image", 60, lambda: os.path.exists(bench.path("mpi.exr")))
    assert process.poll() is None and bench.is_whole("mpi.exr")
    process.send_signal(signal.SIGUSR1)
    assert bench.end(process, 30)[0] == 143


CASES = {name: (lambda bench, name=name: same_bits(bench, name)) for name in BITS}
CASES.update({
    "without-mpirun": without_mpirun,
    "worker-killed": lambda bench: killed(bench, 3),
    "manager-killed": lambda bench: killed(bench, 0),
    "user-signal": lambda bench: stopped(bench, signal.SIGUSR1, 143),
    "terminated": lambda bench: stopped(bench, signal.SIGTERM, 1),  # mpirun's own status
    "interrupted": lambda bench: stopped(bench, signal.SIGINT, 1),
    "from-one-process": from_one_process,
    "unreadable-scene": unreadable_scene,
    "another-render": another_render,
    "another-build": another_build,
    "refused": refused,
    "live": live,
})


def best_rate(bench, ranks, threads, size):
    """Samples per second, seconds of processors, and what the log says of adding, of the best of five renders."""
    best = (0, 0, "")
    for _ in range(5):
        before = sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
        options = [*size, "--outfile", "mpi.exr", "--stats-json", "mpi.json", "--quiet", "--log-file", "mpi.log",
                   "--log-level", "verbose"]
        command = [*MPIRUN, *bench.mpi(ranks, options)] if ranks else [bench.lacquer, "scene.pbrt", "--nthreads", "1", *options]
        command[command.index("--nthreads") + 1] = str(threads)
        status, said = bench.run(command, 900)
        assert status == 0, said
        with open(bench.path("mpi.json"), encoding="utf-8") as file, open(bench.path("mpi.log"), encoding="utf-8") as log:
            added = re.search(r"added .*", log.read())
            used = sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2]) - before
            best = max(best, (json.load(file)["samples_per_second"], used, added.group(0) if added else ""))
    return best


def scaling(bench, resolution, samples):
    """Rates of several ranks against one process on one thread."""
    bench.clear()
    processors, alone = os.cpu_count(), 0
    print("%s pixels, %s samples each, %d processors" % (resolution, samples, processors))
    print("| processes | threads each | thousand samples per second | efficiency | seconds of processors | rank 0 |\n|---|---|---|---|---|---|")
    for ranks, threads in ((0, 1), (0, 2), (1, 1), (1, 2), (2, 1), (4, 1)):
        rate, used, added = best_rate(bench, ranks, threads, ["--resolution", resolution, "--spp", samples])
        alone = alone or rate
        # By as many processors as there are, where ranks share them.
        part = rate / alone / min(max(1, ranks) * threads, processors)
        print("| %s | %d | %.0f | %.0f %% | %.1f | %s |" % (ranks or "without MPI", threads, rate / 1e3, 100 * part, used, added), flush=True)


def why_skipped(lacquer):
    if not shutil.which("mpirun"):
        return "mpirun is not installed (Debian: openmpi-bin)"
    done = subprocess.run([lacquer, "render", "--mpi", "/dev/null"], capture_output=True, text=True, check=False)
    if "liblacquer_mpi.so" in done.stderr:
        return "Lacquer was built without MPI (Debian: libopenmpi-dev, then configure anew)"
    return ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lacquer")
    parser.add_argument("cases", nargs="*", metavar="CASE")
    parser.add_argument("--scaling", action="store_true")
    parser.add_argument("--resolution", default="320x240", help="of --scaling")
    parser.add_argument("--spp", default="64", help="of --scaling")
    options = parser.parse_args()
    lacquer = os.path.abspath(options.lacquer)
    why = why_skipped(lacquer)
    if why:
        print("SKIP: %s\n0 passed, 0 failed, 1 skipped" % why)
        return 0
    passed = failed = 0
    with tempfile.TemporaryDirectory(prefix="lacquer-mpi-") as folder:
        bench = Bench(lacquer, folder)
        if options.scaling:
            scaling(bench, options.resolution, options.spp)
            return 0
        for name in options.cases or CASES:
            start = time.monotonic()
            try:
                bench.clear()
                CASES[name](bench)
                passed += 1
                print("%s: %.1f s" % (name, time.monotonic() - start), flush=True)
            except (AssertionError, OSError, KeyError, subprocess.SubprocessError) as e:
                failed += 1
                print("FAIL  %s: %s" % (name, e), flush=True)
    print("%d passed, %d failed" % (passed, failed))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
