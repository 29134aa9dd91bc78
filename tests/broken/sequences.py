"""render --frames: each frame has the bits of a render of its own; what fails or is killed costs only itself."""
import json
import os
import random
import signal
import subprocess
import time

from command_line import SCENE, has, left, pixels, usage, write
from run import health

CASES = [
    usage("frames-reversed", ["--frames", "3-1", "--outfile", "a.#.exr"], ["--frames", '"3-1"', "1-5"]),
    usage("frames-alike", ["--frames", "1-3", "--outfile", "a.#.exr"], ["--frames", "would be the same", "--vary"]),
    usage("frames-one-image", ["--frames", "1-3", "--outfile", "a.exr", "--vary", "camera.fov=1:2"], ["--outfile", '"a.exr"', "#"]),
    usage("frames-no-outfile", ["--frames", "1-3", "--vary", "camera.fov=1:2"], ["--frames needs --outfile"]),
    usage("frames-too-few-values", ["--frames", "1-3", "--outfile", "a.#.exr", "--vary", "camera.fov=1,2"],
          ["--vary", "2 values for 3 frames"]),
    usage("vary-alone", ["--vary", "camera.fov=1"], ["--vary", "--frames"]),
    usage("restart-alone", ["--restart"], ["--restart", "--frames"]),
    usage("restart-without-summary", ["--frames", "1-3", "--outfile", "a.#.exr", "--vary", "camera.fov=1:2", "--restart"],
          ["--restart", "--summary"]),
]

CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


def sequence(tool, folder, *args, status=0):
    result = tool.run(["shot.##.pbrt", "--outfile", "a.##.exr", "--nthreads", "2", "--summary", "s.json", *args], folder)
    problems = health(result)
    assert not problems and result.status == status, (problems, result)
    return result


def statuses(folder):
    with open(os.path.join(folder, "s.json")) as f:
        return {frame["frame"]: frame["status"] for frame in json.load(f)["frames"]}


def shots(folder, count):
    """Scenes that share a texture and a mesh; the second to last one has others."""
    for name, color in (("wood.png", ".2,.5,.3"), ("other.png", ".9,.1,.3")):
        subprocess.run(["oiiotool", "--pattern", "checker:color1=%s" % color, "8x8", "3", "-o", name], cwd=folder, check=True)
    write(folder, "tri.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
          "element face 1\nproperty list uchar int vertex_indices\nend_header\n-3 -3 -.1\n5 -3 -.1\n-3 5 -.1\n3 0 1 2\n")
    for i in range(1, count + 1):
        world = SCENE.replace("LookAt 0", "LookAt %g" % (0.1 * i)) + (
            'Texture "t" "spectrum" "imagemap" "string filename" "%s"\nMaterial "diffuse" "texture reflectance" "t"\n'
            'Translate 0 %g 0 Shape "plymesh" "string filename" "tri.ply"\n' % ("other.png" if i == count - 1 else "wood.png", i))
        write(folder, "shot.%02d.pbrt" % i, world)


def alone(tool, folder, frame, *args):
    result = tool.run(["shot.%02d.pbrt" % frame, "--outfile", "alone.exr", "--nthreads", "1", "--quiet", *args], folder)
    assert result.status == 0, result
    return pixels(folder, "alone.exr")


@check
def frames_have_the_bits_of_renders_of_their_own(tool, folder):
    shots(folder, 4)
    sequence(tool, folder, "--frames", "1-4")
    assert statuses(folder) == {1: 0, 2: 0, 3: 0, 4: 0}
    images = [pixels(folder, "a.%02d.exr" % i) for i in range(1, 5)]
    assert images == [alone(tool, folder, i) for i in range(1, 5)]
    assert len(set(images)) == 4
    # The same with textures on disk, and in another order.
    sequence(tool, folder, "--frames", "3,1-2,4", "--texture-memory", "16", "--texture-cache", "none")
    assert [pixels(folder, "a.%02d.exr" % i) for i in range(1, 5)] == images


@check
def a_frame_that_fails_stops_no_other(tool, folder):
    shots(folder, 4)
    write(folder, "shot.02.pbrt", "Shape")
    os.remove(os.path.join(folder, "shot.03.pbrt"))
    result = sequence(tool, folder, "--frames", "1-4", status=2)
    has(result.err, r"shot\.02\.pbrt:1", r"shot\.03\.pbrt: cannot be opened")
    assert statuses(folder) == {1: 0, 2: 2, 3: 3, 4: 0}
    shots(folder, 4)
    before = os.stat(os.path.join(folder, "a.01.exr")).st_ino
    result = sequence(tool, folder, "--frames", "1-4", "--restart")
    assert statuses(folder) == {1: 0, 2: 0, 3: 0, 4: 0} and "(1 of 4)" not in result.err, result.err
    assert os.stat(os.path.join(folder, "a.01.exr")).st_ino == before, "frame 1 was rendered again"


@check
def a_file_that_changes_between_frames_is_read_again(tool, folder):
    shots(folder, 2)
    os.replace(os.path.join(folder, "wood.png"), os.path.join(folder, "old.png"))
    os.mkfifo(os.path.join(folder, "shot.03.pbrt"))
    for name in ("shot.01.pbrt", "shot.02.pbrt"):
        text = open(os.path.join(folder, name)).read()
        write(folder, name, text.replace("other.png", "wood.png"))
    os.link(os.path.join(folder, "old.png"), os.path.join(folder, "wood.png"))
    text = open(os.path.join(folder, "shot.02.pbrt")).read()
    process = subprocess.Popen([tool.path, "shot.##.pbrt", "--frames", "1,3", "--outfile", "a.##.exr"], cwd=folder,
                               stderr=subprocess.DEVNULL)
    for _ in range(1000):
        if os.path.exists(os.path.join(folder, "a.01.exr")):
            break
        time.sleep(0.02)
    os.replace(os.path.join(folder, "other.png"), os.path.join(folder, "wood.png"))
    write(folder, "shot.03.pbrt", text)  # to the pipe, which the second frame waits at
    assert process.wait(timeout=60) == 0
    assert pixels(folder, "a.03.exr") == alone(tool, folder, 2)
    os.replace(os.path.join(folder, "old.png"), os.path.join(folder, "wood.png"))
    assert pixels(folder, "a.03.exr") != alone(tool, folder, 2)


@check
def what_varies_is_what_the_scene_could_say(tool, folder):
    write(folder, "shot.pbrt", SCENE)
    args = ["shot.pbrt", "--frames", "5-7", "--outfile", "v.#.exr", "--vary", "camera.fov=30:50", "--quiet", "--vary",
            "light@2.scale=1,2,3"]
    assert tool.run(args, folder).status == 0
    for i, (fov, scale) in enumerate(((30, 1), (40, 2), (50, 3))):
        text = SCENE.replace('"float fov" 40', '"float fov" %d' % fov).replace('[9 9 9]', '[9 9 9] "float scale" %d' % scale)
        write(folder, "one.pbrt", text)
        assert tool.run(["one.pbrt", "--quiet"], folder).status == 0
        assert pixels(folder, "v.%d.exr" % (5 + i)) == pixels(folder)


@check
def killed_sequences_go_on_to_the_same_bits(tool, folder):
    shots(folder, 3)
    args = ["--frames", "1-3", "--restart", "--spp", "64", "--checkpoint", "#.state", "--checkpoint-every", "0.1", "--resolution",
            "160x120"]
    random.seed(5)
    kills = 0
    for _ in range(30):
        seconds = random.uniform(0.05, 0.6)
        result = tool.run(["shot.##.pbrt", "--outfile", "a.##.exr", "--summary", "s.json", "--nthreads", "2", *args], folder,
                          signal_after=(seconds, signal.SIGKILL))
        assert result.status in (0, -signal.SIGKILL), result
        if result.status == 0:
            break
        kills += 1
    if result.status != 0:
        sequence(tool, folder, *args)
    assert kills > 1 and statuses(folder) == {1: 0, 2: 0, 3: 0}, (kills, statuses(folder))
    for i in range(1, 4):
        assert pixels(folder, "a.%02d.exr" % i) == alone(tool, folder, i, "--spp", "64", "--resolution", "160x120"), i
    assert not [name for name in left(folder) if name.startswith(".lacquer")], left(folder)


@check
def a_signal_ends_a_sequence_with_its_image(tool, folder):
    shots(folder, 3)
    result = tool.run(["shot.##.pbrt", "--outfile", "a.##.exr", "--frames", "1-3", "--summary", "s.json", "--spp", "100000"], folder,
                      signal_after=(2, signal.SIGINT))
    assert result.status == 130, result
    assert statuses(folder) == {1: 130} and os.path.exists(os.path.join(folder, "a.01.exr"))
    assert not os.path.exists(os.path.join(folder, "a.02.exr"))


@check
def a_damaged_summary_is_refused(tool, folder):
    shots(folder, 2)
    sequence(tool, folder, "--frames", "1-2")
    whole = open(os.path.join(folder, "s.json")).read()
    for text in ("", "{}", whole[:50], whole.replace('"frame": 1', '"frame": "one"'), whole.replace("a.01.exr\"", "a.01.exr")):
        write(folder, "s.json", text)
        result = tool.run(["shot.##.pbrt", "--outfile", "a.##.exr", "--frames", "1-2", "--summary", "s.json", "--restart"], folder)
        assert result.status in (2, 3) and "s.json" in result.err, (text, result)
        assert open(os.path.join(folder, "s.json")).read() == text
