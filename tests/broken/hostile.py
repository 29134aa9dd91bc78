"""Streams that fail, outputs that would destroy inputs, names that would steer a terminal: nothing good is lost."""
import fcntl
import os
import pty
import signal
import subprocess
import time

from command_line import LONG, SCENE, has, left, pixels, render, write
from run import Case

CASES = [
    Case("log-over-scene", SCENE, ["scene.pbrt: is there already and is no log"], 3, ["--log-file", "scene.pbrt"]),
    Case("stats-over-scene", SCENE, ["scene.pbrt: is read for this image; --stats-json"], 3, ["--stats-json", "scene.pbrt"]),
    Case("stats-over-link-to-scene", SCENE, ["link: is read for this image; --stats-json"], 3, ["--stats-json", "link"],
         prepare=lambda folder: os.symlink("scene.pbrt", os.path.join(folder, "link"))),
    Case("stats-over-other-name-of-scene", SCENE, ["other: is read for this image; --stats-json"], 3, ["--stats-json", "./other"],
         prepare=lambda folder: os.link(os.path.join(folder, "scene.pbrt"), os.path.join(folder, "other"))),
    Case("stats-over-included", SCENE + 'Include "more.pbrt"\n', ["more.pbrt: is read for this image"], 3,
         ["--stats-json", "more.pbrt"], files={"more.pbrt": 'Shape "sphere"\n'}),
    Case("stats-over-image", SCENE, ["scene.exr: the scene's film and --stats-json name the same file"], 3,
         ["--stats-json", "scene.exr"]),
    Case("checkpoint-over-image", SCENE, ["--outfile and --checkpoint name the same file"], 3,
         ["--outfile", "a.exr", "--checkpoint", "./a.exr"]),
]

CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


def run(tool, folder, *args, stderr, scene=SCENE):
    write(folder, "scene.pbrt", scene)
    return subprocess.run([tool.path, "scene.pbrt", *args], cwd=folder, stdin=subprocess.DEVNULL, stderr=stderr, timeout=60)


def textured(folder, name="wood.png"):
    """A scene with the image `name`, which is made."""
    subprocess.run(["oiiotool", "--pattern", "constant:color=.2,.5,.3", "8x8", "3", "-o", name], cwd=folder, check=True)
    return SCENE + 'Texture "t" "spectrum" "imagemap" "string filename" "%s"\n' % name


@check
def textures_are_not_replaced(tool, folder):
    scene = textured(folder)
    before = open(os.path.join(folder, "wood.png"), "rb").read()
    for args, says in ((["--outfile", "wood.png"], "--outfile"), (["--stats-json", "wood.png"], "--stats-json")):
        has(render(tool, folder, *args, scene=scene, status=3).err, "wood.png: is read for this image; " + says)
    scene = scene.replace("scene.exr", "wood.png")
    has(render(tool, folder, scene=scene, status=3).err, "wood.png: is read for this image; the scene's film")
    assert open(os.path.join(folder, "wood.png"), "rb").read() == before


@check
def no_standard_error_costs_no_image(tool, folder):
    render(tool, folder)
    good = pixels(folder)

    def expect(stderr):
        os.remove(os.path.join(folder, "scene.exr"))
        done = run(tool, folder, "--stats", stderr=stderr)
        assert done.returncode == 0, done
        assert pixels(folder) == good
        assert left(folder) == ["scene.exr"], left(folder)

    with open("/dev/full", "w") as full:
        expect(full)
    reader, writer = os.pipe()
    os.close(reader)
    expect(writer)
    os.close(writer)
    os.remove(os.path.join(folder, "scene.exr"))
    # The number of a stream that is closed would be that of the next file: a message would stand in it.
    done = subprocess.run(["sh", "-c", 'exec "$0" scene.pbrt --stats 2>&-', tool.path], cwd=folder, timeout=60)
    assert done.returncode == 0 and pixels(folder) == good
    assert left(folder) == ["scene.exr"], left(folder)


@check
def a_terminal_that_is_closed_ends_the_render_with_its_image(tool, folder):
    write(folder, "scene.pbrt", LONG)
    master, slave = pty.openpty()

    def lead():
        os.setsid()
        fcntl.ioctl(slave, 0x540E, 0)  # TIOCSCTTY: the terminal of this session
    process = subprocess.Popen([tool.path, "scene.pbrt", "--spp", "100000"], cwd=folder, stdin=slave, stdout=slave, stderr=slave,
                               preexec_fn=lead)
    os.close(slave)
    time.sleep(3)
    os.close(master)
    assert process.wait(timeout=60) == 129
    assert pixels(folder) and left(folder) == ["scene.exr"], left(folder)


@check
def nohup_is_obeyed(tool, folder):
    write(folder, "scene.pbrt", LONG)
    process = subprocess.Popen(["nohup", tool.path, "scene.pbrt", "--spp", "100000"], cwd=folder, stdin=subprocess.DEVNULL,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(3)
    process.send_signal(signal.SIGHUP)
    time.sleep(1)
    assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    assert process.wait(timeout=60) == 143


@check
def closed_pipes_behind_results_are_no_error(tool, folder):
    render(tool, folder)
    command = '"$0" cat scene.exr | head -c 10; echo ${PIPESTATUS[0]}'
    done = subprocess.run(["bash", "-c", command, tool.path], cwd=folder, capture_output=True, text=True, timeout=60)
    assert done.stdout.endswith("%d\n" % (128 + signal.SIGPIPE)), done
    assert not done.stderr, done
    with open("/dev/full", "w") as full:
        done = subprocess.run([tool.path, "cat", "scene.exr"], cwd=folder, stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 3 and "standard output cannot be written" in done.stderr, done


@check
def images_go_through_links_and_pipes(tool, folder):
    os.mkdir(os.path.join(folder, "out"))
    os.symlink("out/real.exr", os.path.join(folder, "link.exr"))
    render(tool, folder, "--outfile", "link.exr")
    assert os.path.islink(os.path.join(folder, "link.exr"))
    good = pixels(folder, "out/real.exr")
    os.mkfifo(os.path.join(folder, "pipe.exr"))
    with open(os.path.join(folder, "got.exr"), "wb") as got:
        reader = subprocess.Popen(["cat", "pipe.exr"], cwd=folder, stdout=got)
        render(tool, folder, "--outfile", "pipe.exr")
        assert reader.wait(timeout=20) == 0
    assert pixels(folder, "got.exr") == good


@check
def a_full_disk_keeps_the_old_image(tool, folder):
    render(tool, folder)
    old = pixels(folder)
    write(folder, "scene.pbrt", SCENE)
    done = subprocess.run(["sh", "-c", 'ulimit -f 2; exec "$0" scene.pbrt --spp 9', tool.path], cwd=folder,
                          stderr=subprocess.PIPE, text=True, timeout=60)
    assert done.returncode == 3 and "scene.exr: cannot be written: File too large" in done.stderr, done
    assert pixels(folder) == old and left(folder) == ["scene.exr"], left(folder)


@check
def a_log_is_only_written_over_a_log(tool, folder):
    for _ in range(2):
        render(tool, folder, "--log-file", "a.log", "--log-level", "verbose")
    write(folder, "a.log", "a diary")
    render(tool, folder, "--log-file", "a.log", status=3)
    assert open(os.path.join(folder, "a.log")).read() == "a diary"


STEERING = "\x1b]0;owned\x07\x1b[31m\u009b31m"


@check
def names_steer_no_terminal(tool, folder):
    scene = SCENE.replace('WorldBegin', 'WorldBegin\nMakeNamedMaterial "%s" "string type" "diffuse"' % STEERING)
    scene += textured(folder, "a.png").split("\n")[-2].replace("a.png", STEERING + ".png")
    has(render(tool, folder, scene=scene, status=3).err, r"\?\]0;owned\?\?\[31m\?+31m.png")
    # Channels of an image, and a file's name.
    name = STEERING.replace("/", "") + ".exr"
    subprocess.run(["oiiotool", "--pattern", "constant:color=.2,.5,.3", "8x8", "3", "--chnames", "R,G,%s.B" % STEERING, "-o", name],
                   cwd=folder, check=True)
    for args in (["info", name], ["diff", name, name, "--channels", "all"], ["diff", name, name], ["convert", name, name + ".pfm"], ["render", name]):
        result = tool.run(args, folder)
        text = result.out.decode() + result.err
        assert not set(text) & set("\x1b\x07\x9b"), (args, text)


@check
def a_name_steers_no_log(tool, folder):
    scene = SCENE + 'Texture "t" "spectrum" "imagemap" "string filename" "%s.png"\n' % STEERING
    render(tool, folder, "--log-file", "a.log", "--log-level", "verbose", scene=scene, status=3)
    assert b"\x1b" not in open(os.path.join(folder, "a.log"), "rb").read()


SANDBOX = ["--sandbox", "--outfile", "out/a.exr"]


def confined(tool, folder, scene, *args, status):
    """Renders stranger/scene.pbrt in the sandbox; None where this system has none, which must be an error."""
    write(folder, "stranger/scene.pbrt", scene)
    result = tool.run(["stranger/scene.pbrt", *SANDBOX, *args, "--nthreads", "2"], folder)
    if "this system cannot confine a program" in result.err:
        assert result.status == 3 and not os.path.exists(os.path.join(folder, "out", "a.exr")), result
        return None
    assert result.status == status, result
    return result


@check
def a_sandbox_confines_a_scene(tool, folder):
    for name in ("stranger", "out", "secret"):
        os.mkdir(os.path.join(folder, name))
    image = textured(folder, "secret/a.png")
    if confined(tool, folder, SCENE, status=0) is None:
        return
    # The same file by a path, an absolute path and a link; each is read without the sandbox.
    os.symlink("../secret/a.png", os.path.join(folder, "stranger", "link.png"))
    for name in ("../secret/a.png", os.path.join(folder, "secret", "a.png"), "link.png"):
        scene = image.replace("secret/a.png", name)
        has(confined(tool, folder, scene, status=3).err, r"a\.png|link\.png", "Permission denied")
        confined(tool, folder, scene, "--sandbox-read", "secret", status=0)
    write(folder, "secret/words", "a password\n")
    result = confined(tool, folder, SCENE + 'Include "../secret/words"\n', status=3)
    assert "password" not in result.err, result.err
    # Formats that need a library, which is loaded then.
    write(folder, "stranger/scene.pbrt", SCENE)
    assert tool.run(["stranger/scene.pbrt", "--sandbox", "--outfile", "out/a.png"], folder).status == 0


@check
def a_sandbox_confines_outputs(tool, folder):
    for name in ("stranger", "out", "secret"):
        os.mkdir(os.path.join(folder, name))
    render(tool, folder, "--outfile", "secret/a.exr")
    old = pixels(folder, "secret/a.exr")
    if confined(tool, folder, SCENE, status=0) is None:
        return
    scene = SCENE.replace("scene.exr", os.path.join(folder, "secret", "a.exr"))
    write(folder, "stranger/scene.pbrt", scene)
    result = tool.run(["scene.pbrt", "--sandbox"], os.path.join(folder, "stranger"))
    assert result.status == 3, result
    has(result.err, r"a\.exr: cannot be written: Permission denied")
    text = os.path.join(folder, "secret", "words")
    errors = 'Option "msereferenceimage" "../secret/a.exr"\nOption "msereferenceout" "%s"\n' % text
    assert tool.run(["scene.pbrt", "--outfile", "a.exr"], os.path.join(folder, "stranger")).status == 0
    confined(tool, folder, errors + SCENE, "--sandbox-read", "secret", status=3)
    assert not os.path.exists(text)
    assert pixels(folder, "secret/a.exr") == old
    # All that a render can write, where the command line says so.
    os.mkdir(os.path.join(folder, "logs"))
    confined(tool, folder, SCENE, "--checkpoint", "out/a.state", "--log-file", "logs/log", "--stats-json", "logs/a.json", status=0)
    confined(tool, folder, SCENE, "--resume", "out/a.state", status=0)


@check
def a_pipe_as_scene_is_told_of(tool, folder):
    os.mkfifo(os.path.join(folder, "pipe"))
    process = subprocess.Popen([tool.path, "pipe"], cwd=folder, stderr=subprocess.PIPE, text=True)
    assert process.stderr.readline() == "reading the scene from the pipe pipe\n"
    write(folder, "pipe", SCENE)
    assert process.wait(timeout=20) == 0 and left(folder) == ["pipe", "scene.exr"], left(folder)


@check
def too_little_memory_is_no_bug(tool, folder):
    """With less and less of it, from enough to too little for the program to start."""
    if tool.sanitized:
        return  # takes terabytes of addresses
    write(folder, "scene.pbrt", SCENE)
    statuses = []
    for megabytes in range(400, 120, -20):
        command = 'ulimit -v %d; exec "$0" scene.pbrt --nthreads 2' % (megabytes << 10)
        done = subprocess.run(["sh", "-c", command, tool.path], cwd=folder, capture_output=True, text=True, timeout=60)
        statuses.append(done.returncode)
        if done.returncode == -signal.SIGABRT and "scene.exr: 48 x 32 pixels" in done.stderr:
            continue  # Embree, which has no memory to end with, after the image
        assert done.returncode in (0, 2, 3, 127), (megabytes, done)
        assert done.returncode != 2 or "not enough memory" in done.stderr, (megabytes, done)
    assert 0 in statuses and 2 in statuses, statuses
