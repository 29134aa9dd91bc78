"""render --checkpoint and --resume: what is refused, and what a killed render leaves."""
import os
import random
import signal
import subprocess
import time

from command_line import LONG, SCENE, has, left, pixels, render, usage, write
from run import Case

EVERY = ["--checkpoint", "a.state", "--checkpoint-every", "0.1"]

CASES = [
    usage("checkpoint-every-zero", ["--checkpoint-every", "0"], ["--checkpoint-every", "0"]),
    usage("checkpoint-pixelstats", ["--checkpoint", "a.state", "--pixelstats"], ["--pixelstats", "--checkpoint"]),
    Case("checkpoint-folder", SCENE, ["no/a.state", "does not exist"], 3, ["--checkpoint", "no/a.state"]),
    Case("resume-missing", SCENE, ["none.state", "No such file"], 3, ["--resume", "none.state"]),
    Case("resume-no-state", SCENE, ["b.state", "is no state of a render"], 3, ["--resume", "b.state"],
         files={"b.state": "an essay"}),
    Case("resume-another-version", SCENE, ["b.state", "another version"], 3, ["--resume", "b.state"],
         files={"b.state": "lacquer-state 1\n"}),
]

CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


def refused(tool, folder, *args, scene=SCENE, status=3):
    before = pixels(folder)
    err = render(tool, folder, *args, scene=scene, status=status).err
    assert pixels(folder) == before, "the image has changed"
    return err


@check
def states_of_other_renders_are_refused(tool, folder):
    scene = SCENE.replace("zsobol", "independent")
    render(tool, folder, "--checkpoint", "a.state", scene=scene)
    resume = ["--resume", "a.state"]
    has(refused(tool, folder, *resume, scene=scene.replace("0.2", "0.3")), "a.state.*another render.*scene.pbrt")
    has(refused(tool, folder, *resume, "--seed", "5", scene=scene), "another render.*seed")
    has(refused(tool, folder, *resume, "--aov", "depth", scene=scene), "another render.*aov.*depth")
    has(refused(tool, folder, *resume, "--cropwindow", "0,1,0,.5", scene=scene), "another render.*pixelbounds")
    has(refused(tool, folder, *resume, "--sample-range", "2:8", scene=scene), "another render.*sample-range")
    has(refused(tool, folder, *resume, "--spp", "4", scene=scene), "8 samples in each pixel, more than the 4")
    has(refused(tool, folder, "--checkpoint", "a.state", scene=scene), "a.state: is there already", "--resume a.state")
    with open(os.path.join(folder, "a.state"), "r+b") as f:
        f.seek(-100, os.SEEK_END)
        f.write(b"oops")
    has(refused(tool, folder, *resume, scene=scene), "a.state: this state is damaged")
    # The values of this sampler depend on their number.
    render(tool, folder, "--checkpoint", "b.state")
    has(refused(tool, folder, "--resume", "b.state", "--spp", "32"), r"sampler.*--spp 8")


@check
def resuming_with_more_samples_is_one_render(tool, folder):
    scene = SCENE.replace("zsobol", "independent")
    render(tool, folder, "--spp", "5", "--checkpoint", "a.state", scene=scene)
    render(tool, folder, "--spp", "16", "--resume", "a.state", "--outfile", "two.exr", scene=scene)
    render(tool, folder, "--spp", "16", "--outfile", "one.exr", scene=scene)
    assert pixels(folder, "one.exr") == pixels(folder, "two.exr")
    assert pixels(folder, "one.exr") != pixels(folder, "scene.exr")


@check
def a_killed_render_goes_on_to_the_same_bits(tool, folder):
    moments = random.Random(1)
    options = ["--spp", "16", "--aov", "variance,depth,cryptoobject", "--quiet"]
    render(tool, folder, *options, "--outfile", "whole.exr", scene=LONG)
    kills = 0
    for _ in range(40):
        resume = ["--resume", "a.state"] if os.path.exists(os.path.join(folder, "a.state")) else []
        result = tool.run(["scene.pbrt", *options, *EVERY, *resume], folder,
                          signal_after=(0.5 + moments.random(), signal.SIGKILL))
        assert result.status in (0, -signal.SIGKILL), result.err
        if result.status == 0:
            break
        kills += 1
        image = os.path.join(folder, "scene.exr")
        if os.path.exists(image):  # killed between its image and its exit
            assert pixels(folder) == pixels(folder, "whole.exr"), "an image before the end"
            os.remove(image)
        known = {"scene.pbrt", "whole.exr", "a.state", "a.state.previous", "a.state.lock"}
        assert set(os.listdir(folder)) <= known, os.listdir(folder)
    assert kills > 0 and result.status == 0, "%d kills, status %d" % (kills, result.status)
    assert pixels(folder) == pixels(folder, "whole.exr")
    assert "a.state.lock" not in left(folder), left(folder)


@check
def a_signal_keeps_the_state(tool, folder):
    result = render(tool, folder, "--spp", "1000000", "--checkpoint", "a.state", scene=LONG.replace("halton", "independent"),
                    status=130, signal_after=(1.5, signal.SIGINT))
    has(result.err, "stopped by a signal")
    assert "a.state" in left(folder)
    render(tool, folder, "--spp", "1000000", "--time-limit", "0.3", "--resume", "a.state", "--checkpoint", "a.state",
           scene=LONG.replace("halton", "independent"), status=5)


@check
def two_renders_do_not_share_a_state(tool, folder):
    write(folder, "scene.pbrt", LONG)
    first = subprocess.Popen([tool.path, "scene.pbrt", "--spp", "1000000", "--quiet", "--outfile", "first.exr", *EVERY], cwd=folder)
    try:
        state = os.path.join(folder, "a.state")
        for _ in range(1000):
            if os.path.exists(state):
                break
            time.sleep(0.02)
        second = tool.run(["scene.pbrt", "--spp", "1000000", "--resume", "a.state", *EVERY], folder)
        assert second.status == 3, second.err
        has(second.err, "a.state: is in use by another process")
    finally:
        first.kill()
        first.wait()


@check
def a_checkpoint_that_cannot_be_written_costs_no_image(tool, folder):
    # A limit on the sizes of files, which acts like a full disk, between those of image and state.
    write(folder, "scene.pbrt", LONG)
    command = 'ulimit -f 800; exec "$0" scene.pbrt --spp 64 --outfile scene.png ' + " ".join(EVERY)
    done = subprocess.run(["sh", "-c", command, tool.path], cwd=folder, stderr=subprocess.PIPE, text=True, timeout=60)
    assert done.returncode == 3, done
    has(done.stderr, "warning: a.state: cannot be written: File too large", "error: a.state: cannot be written")
    # On a slow machine the first states, of few tiles, are small enough, and stay.
    assert "scene.png" in left(folder) and set(left(folder)) <= {"a.state", "a.state.previous", "scene.png"}, left(folder)
