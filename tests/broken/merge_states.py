"""lacquer merge and info of states, and lacquer farm: parts of a render are the whole, to the bit, or refused."""
import ctypes
import json
import os
import random
import signal
import struct
import subprocess
import zlib

from command_line import LONG, SCENE, has, left, pixels, render, write
from run import Case

GBUFFER = SCENE.replace('"rgb"', '"gbuffer"', 1)
SPECTRAL = SCENE.replace('"rgb"', '"spectral" "integer nbuckets" 5', 1)
BDPT = SCENE.replace("LookAt", 'Integrator "bdpt" "integer maxdepth" 4\nLookAt', 1)
OUTPUTS = "variance,half,albedo,depth,object,cryptoobject,cryptomaterial,direct,indirect,lpe:first=CD.*"

CASES = [
    Case("merge-partial-images", None, ["--partial", "states"], 1, ["merge", "a.exr", "b.exr", "--outfile", "c.exr", "--partial"]),
    Case("merge-state-and-other", None, ["b.txt", "is no state"], 1, ["merge", "a.state", "b.txt", "--outfile", "c.exr"],
         files={"a.state": "lacquer-state 2\n", "b.txt": "an essay"}),
    Case("merge-state-bounds", None, ["--pixelbounds", '"1,2"'], 1,
         ["merge", "a.state", "--outfile", "c.exr", "--pixelbounds", "1,2"], files={"a.state": "lacquer-state 2\n"}),
    Case("merge-state-empty", None, ["a.state", "damaged"], 3, ["merge", "a.state", "--outfile", "c.exr"],
         files={"a.state": "lacquer-state 2\n"}),
    Case("info-state-empty", None, ["a.state", "damaged"], 3, ["info", "a.state"], files={"a.state": "lacquer-state 2\n"}),
    Case("farm-too-many-jobs", None, ["--jobs", "at most 8"], 1,
         ["farm", "split", "s.pbrt", "--jobs", "9", "--outfile", "a.exr", "--folder", "farm"], files={"s.pbrt": SCENE}),
    Case("farm-too-many-rows", None, ["--jobs", "at most 32"], 1,
         ["farm", "split", "s.pbrt", "--jobs", "33", "--rows", "--outfile", "a.exr", "--folder", "farm"],
         files={"s.pbrt": SCENE}),
    Case("farm-rows-of-splats", None, ["--rows", '"bdpt"', "samples"], 1,
         ["farm", "split", "s.pbrt", "--jobs", "3", "--rows", "--outfile", "a.exr", "--folder", "farm"],
         files={"s.pbrt": 'Integrator "bdpt"\n' + SCENE}),
    Case("farm-chains", None, ['"mlt"', "Markov chains", "divided"], 1,
         ["farm", "split", "s.pbrt", "--jobs", "3", "--outfile", "a.exr", "--folder", "farm"],
         files={"s.pbrt": 'Integrator "mlt"\n' + SCENE}),
    Case("farm-rows-adaptive", None, ["--rows does not go with --adaptive"], 1,
         ["farm", "split", "s.pbrt", "--jobs", "3", "--rows", "--render-options", "--adaptive", "--outfile", "a.exr", "--folder", "farm"],
         files={"s.pbrt": SCENE}),
    Case("farm-noise-target", None, ["--noise-target", "say --spp"], 1,
         ["farm", "split", "s.pbrt", "--jobs", "3", "--render-options", "-noisetarget 5%", "--outfile", "a.exr", "--folder", "farm"],
         files={"s.pbrt": SCENE}),
    Case("farm-samples-of-the-renders", None, ["--render-options: --spp", "farm split itself"], 1,
         ["farm", "split", "s.pbrt", "--jobs", "3", "--render-options", "--nthreads 1 -spp=64", "--outfile", "a.exr", "--folder", "farm"],
         files={"s.pbrt": SCENE}),
    Case("farm-range-of-the-renders", None, ["--render-options: --sample-range", "tasks"], 1,
         ["farm", "split", "s.pbrt", "--jobs", "3", "--render-options", "--sample_range 0:4", "--outfile", "a.exr", "--folder", "farm"],
         files={"s.pbrt": SCENE}),
    Case("farm-unknown-action", None, ['"spilt"', '"split"'], 1,
         ["farm", "spilt", "s.pbrt", "--jobs", "9", "--outfile", "a.exr", "--folder", "farm"]),
    Case("farm-no-scene", None, ["none.pbrt", "No such file"], 3,
         ["farm", "split", "none.pbrt", "--jobs", "2", "--outfile", "a.exr", "--folder", "farm"]),
]

CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


def run(tool, folder, *args, status=0):
    result = tool.run(args, folder)
    assert result.status == status, "status %d: %s" % (result.status, result.err)
    return result


def part(tool, folder, name, *args, scene=SCENE):
    """The state of a part of a render."""
    render(tool, folder, "--checkpoint", name + ".state", "--outfile", name + ".exr", *args, scene=scene)
    return name + ".state"


def partition(moments, samples, width, height):
    """Boxes of samples and pixels: ranges, and of each range crops of its own, or none."""
    first = 0
    while first < samples:
        end = min(samples, first + moments.randint(1, 4))
        x, y = moments.randint(1, width - 1), moments.randint(1, height - 1)
        crops = moments.choice([[(0, width, 0, height)], [(0, x, 0, height), (x, width, 0, height)],
                                [(0, width, 0, y), (0, x, y, height), (x, width, y, height)]])
        for crop in crops:
            yield ["--sample-range", "%d:%d" % (first, end), "--pixelbounds", "%d,%d,%d,%d" % crop]
        first = end


def parts_are_the_whole(tool, folder, scene, *options):
    """By partitions in any order with any threads, at once and by a tree of merges."""
    render(tool, folder, "--outfile", "whole.exr", *options, scene=scene)
    moments = random.Random(scene)
    for trial in range(2):
        states = []
        for box in partition(moments, 8, 48, 32):
            states.append(part(tool, folder, "p%d-%d" % (trial, len(states)), *box, *options, "--nthreads",
                               str(moments.randint(1, 5)), scene=scene))
        moments.shuffle(states)
        run(tool, folder, "merge", *states, "--outfile", "one.exr")
        assert pixels(folder, "one.exr") == pixels(folder, "whole.exr"), trial
        half = len(states) // 2
        run(tool, folder, "merge", *states[:half], "--outfile", "a%d.state" % trial)
        run(tool, folder, "merge", "a%d.state" % trial, *states[half:], "--outfile", "tree.exr")
        assert pixels(folder, "tree.exr") == pixels(folder, "whole.exr"), trial
    # Controls: what lacks a part, and what has one twice.
    missing = run(tool, folder, "merge", *states[1:], "--outfile", "none.exr", status=3)
    has(missing.err, "none.exr: is not written: samples? .* are missing; with --partial")
    assert "none.exr" not in left(folder)
    run(tool, folder, "merge", *states[1:], "--partial", "--outfile", "part.exr")
    assert pixels(folder, "part.exr") != pixels(folder, "whole.exr")
    has(run(tool, folder, "merge", *states, states[0], "--outfile", "none.exr", status=3).err,
        r"%s: has samples? .*, as .*\.state has" % states[0])


@check
def parts_of_rgb_films_are_the_whole(tool, folder):
    parts_are_the_whole(tool, folder, SCENE)


@check
def parts_of_gbuffer_films_are_the_whole(tool, folder):
    parts_are_the_whole(tool, folder, GBUFFER)


@check
def parts_of_spectral_films_are_the_whole(tool, folder):
    parts_are_the_whole(tool, folder, SPECTRAL)


@check
def parts_with_outputs_and_passes_are_the_whole(tool, folder):
    parts_are_the_whole(tool, folder, SCENE, "--aov", OUTPUTS)


@check
def ranges_of_splats_are_the_whole_and_crops_are_refused(tool, folder):
    states = [part(tool, folder, "p%d" % first, "--sample-range", "%d:%d" % (first, first + 2), "--nthreads",
                   str(1 + first), scene=BDPT) for first in (4, 0, 6, 2)]
    render(tool, folder, "--outfile", "whole.exr", scene=BDPT)
    run(tool, folder, "merge", *states, "--outfile", "one.exr")
    assert pixels(folder, "one.exr") == pixels(folder, "whole.exr")
    crops = [part(tool, folder, "c%d" % y, "--pixelbounds", "0,48,%d,%d" % (y, y + 16), scene=BDPT) for y in (0, 16)]
    has(run(tool, folder, "merge", *crops, "--outfile", "none.exr", status=3).err, "--sample-range")


def unpacked(packed, size):
    """The bytes of an array that is one block."""
    block = ctypes.create_string_buffer(size)
    blosc = ctypes.CDLL("libblosc.so.1")
    assert blosc.blosc_decompress_ctx(packed, block, ctypes.c_size_t(size), 1) == size, "of one block"
    return bytearray(block.raw)


def stored(block):
    """A buffer of Blosc that is not packed: versions, flags, width, then the sizes unpacked, of a block, and in all."""
    return struct.pack("<BBBBIII", 2, 1, 0x2, 8, len(block), len(block), len(block) + 16) + block


def flip_a_value(path):
    """One bit of the sum of a pixel, under a checksum that is right."""
    with open(path, "rb") as f:
        data = f.read()
    at = 16
    at += 8 + struct.unpack_from("<Q", data, at)[0] + 8 + 8      # header, its checksum, number of arrays
    for array in range(2):                                       # "counts", then "colors"
        at += 8 + struct.unpack_from("<Q", data, at)[0] + 8 + 8  # name, its checksum, kind
        size = struct.unpack_from("<Q", data, at)[0]
        at += 8
        packed, _ = struct.unpack_from("<QQ", data, at)
        if array == 0:
            at += 16 + packed
    block = unpacked(data[at + 16:at + 16 + packed], size)
    block[4] ^= 1                                                # of the first number
    new = stored(bytes(block))
    with open(path, "wb") as f:
        f.write(data[:at] + struct.pack("<QQ", len(new), zlib.crc32(new)) + new + data[at + 16 + packed:])


@check
def a_flipped_value_shows_and_a_flipped_byte_is_refused(tool, folder):
    states = [part(tool, folder, name, "--sample-range", samples) for name, samples in (("a", "0:4"), ("b", "4:8"))]
    run(tool, folder, "merge", *states, "--outfile", "one.exr")
    flip_a_value(os.path.join(folder, "b.state"))
    run(tool, folder, "merge", *states, "--outfile", "two.exr")
    assert pixels(folder, "one.exr") != pixels(folder, "two.exr")
    with open(os.path.join(folder, "b.state"), "r+b") as f:
        f.seek(-50, os.SEEK_END)
        f.write(b"?")
    has(run(tool, folder, "merge", *states, "--outfile", "two.exr", status=3).err, "b.state: this state is damaged")
    has(run(tool, folder, "info", "b.state", status=3).err, "b.state: this state is damaged")


@check
def states_of_different_renders_are_not_merged(tool, folder):
    a = part(tool, folder, "a", "--sample-range", "0:4")
    others = {"seed": part(tool, folder, "b", "--sample-range", "4:8", "--seed", "3"),
              "aov": part(tool, folder, "c", "--sample-range", "4:8", "--aov", "depth"),
              "resolution": part(tool, folder, "d", "--sample-range", "4:8", "--resolution", "24x16"),
              "scene.pbrt": part(tool, folder, "e", "--sample-range", "4:8", scene=SCENE.replace("0.2", "0.3")),
              "--spp 16": part(tool, folder, "f", "--sample-range", "4:8", "--spp", "16")}
    for difference, other in others.items():
        err = run(tool, folder, "merge", a, other, "--outfile", "none.exr", status=3).err
        has(err, "%s: cannot be merged with a.state: it is the state of another render.*%s" % (other, difference))
    assert "none.exr" not in left(folder)
    has(run(tool, folder, "merge", a, "--outfile", "a.state", status=1).err, "is one of the states")


@check
def info_tells_what_a_state_holds(tool, folder):
    a = part(tool, folder, "a", "--sample-range", "0:4", "--aov", "depth,direct")
    text = run(tool, folder, "info", a).out.decode()
    has(text, "a.state: a state, .* MB, written .* ago, undamaged", r"scene.pbrt \(1 files\); integrator volpath, sampler zsobol",
        "48 x 32", "holds: samples 0 to 3 of all pixels", "of 8 samples per pixel", "outputs: depth.*passes: direct")
    told = json.loads(run(tool, folder, "info", "--json", a).out)[0]
    assert told["kind"] == "state" and told["parts"] == [
        {"pixels": [0, 48, 0, 32], "first_sample": 0, "samples": 4, "most_samples": 4}], told
    assert 0 <= told["age_seconds"] < 60 and told["bytes"] == os.path.getsize(os.path.join(folder, a))


@check
def a_merged_state_goes_on(tool, folder):
    states = [part(tool, folder, name, "--sample-range", samples) for name, samples in (("a", "2:5"), ("b", "0:2"))]
    run(tool, folder, "merge", *states, "--outfile", "all.state")
    render(tool, folder, "--resume", "all.state", "--outfile", "two.exr")
    render(tool, folder, "--outfile", "one.exr")
    assert pixels(folder, "one.exr") == pixels(folder, "two.exr")
    crop = part(tool, folder, "c", "--pixelbounds", "0,48,0,9")
    run(tool, folder, "merge", crop, "--outfile", "crop.state")
    has(render(tool, folder, "--resume", "crop.state", status=3).err, "another render.*pixelbounds")


def shell(folder, command, **more):
    return subprocess.run(command, shell=True, cwd=folder, capture_output=True, text=True, timeout=60, **more)


@check
def a_farm_of_plain_commands_makes_the_image(tool, folder):
    """With one task that is killed amid its work and run again, and one that is run twice."""
    scene = LONG.replace("halton", "zsobol")
    write(folder, "scene.pbrt", scene)
    render(tool, folder, "--spp", "24", "--outfile", "whole.exr", scene=scene)
    for division in ([], ["--rows"]):
        farm = "it's a farm" + "".join(division)
        run(tool, folder, "farm", "split", "scene.pbrt", "--jobs", "3", "--spp", "24", "--outfile", "one.exr", "--folder",
            farm, "--checkpoint-every", "0.1", "--render-options", "--nthreads 2", *division)
        path = os.path.join(folder, farm)
        with open(os.path.join(path, "tasks.txt")) as f:
            tasks = f.read().splitlines()
        assert len(tasks) == 3, tasks
        killed = subprocess.Popen(tasks[1], shell=True, cwd="/", preexec_fn=os.setsid, stderr=subprocess.DEVNULL)
        try:
            killed.wait(0.7)
        except subprocess.TimeoutExpired:
            os.killpg(killed.pid, signal.SIGKILL)
            killed.wait()
        for task in tasks[:2] + tasks[:1]:
            result = shell("/", task)
            assert result.returncode == 0, result.stderr
        merge = "sh '%s/merge.sh'" % path.replace("'", "'\\''")
        early = shell("/", merge)
        assert early.returncode == 3 and "are missing" in early.stderr, early.stderr
        assert shell("/", tasks[2]).returncode == 0
        result = shell("/", merge)
        assert result.returncode == 0, result.stderr
        assert pixels(folder, "one.exr") == pixels(folder, "whole.exr"), division
        os.remove(os.path.join(folder, "one.exr"))
        again = run(tool, folder, "farm", "split", "scene.pbrt", "--jobs", "3", "--outfile", "one.exr", "--folder", farm, status=3)
        has(again.err, "is of an earlier render in parts")
