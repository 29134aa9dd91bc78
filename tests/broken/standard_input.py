"""Scenes from standard input: `lacquer render -`, and the other commands on scenes."""
import os
import pty
import subprocess

from run import Case
from command_line import GOOD, SCENE, has, info, pixels, render, write
from compare import BALL

CASES = [
    Case("stdin-twice", None, ['"-"', "twice"], 1, ["render", "-", "-"]),
    # Standard input of the cases is the empty device.
    Case("stdin-empty", None, ["<stdin>: error: standard input holds no scene"], 2, ["-"]),
    Case("stdin-empty-without-a-dash", None, ["<stdin>: error: standard input holds no scene"], 2, ["--spp", "1"]),
    Case("stdin-empty-behind-a-file", GOOD, ["<stdin>: error: standard input holds no scene"], 2, ["-"]),
    Case("stdin-empty-bsdf", None, ["<stdin>: error: standard input holds no scene"], 2,
         ["bsdf", "-", "--material", "a", "--wi", "0,0", "--out", "o"]),
    Case("stdin-empty-compare", None, ["<stdin>: error: standard input holds no scene"], 2,
         ["compare", "-", "--out", "o"]),
]

CHECKS = []

MESH = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
-1 0 0
1 0 0
0 1 0
3 0 1 2
"""


def check(function):
    CHECKS.append(function)
    return function


@check
def a_scene_from_a_pipe_is_the_same_scene(tool, folder):
    # With a texture and a mesh beside it, which are found from the current directory.
    write(folder, "m.ply", MESH)
    text = SCENE + 'Include "more.pbrt"\n'
    write(folder, "more.pbrt", 'Shape "plymesh" "string filename" "m.ply"\n')
    render(tool, folder, "--outfile", "file.exr", scene=text)
    for words in (["-"], ["render", "-"], [], ["render"]):
        result = render(tool, folder, *words, "--outfile", "pipe.exr", scene=None, stdin=text.encode())
        assert "warning" not in result.err, result.err
        assert pixels(folder, "file.exr") == pixels(folder, "pipe.exr"), "another image: %s" % words
        has(info(folder, "pipe.exr"), r'scene: "<stdin>"')


@check
def a_pipe_goes_on_where_a_file_ends(tool, folder):
    before, after = SCENE.split("Material", 1)
    write(folder, "one.pbrt", before)
    render(tool, folder, "one.pbrt", "-", "--outfile", "two.exr", scene=None, stdin=("Material" + after).encode())
    render(tool, folder, "--outfile", "whole.exr")
    assert pixels(folder, "two.exr") == pixels(folder, "whole.exr"), "another image than that of one file"
    write(folder, "two.pbrt", "Material" + after)
    render(tool, folder, "-", "two.pbrt", "--outfile", "three.exr", scene=None, stdin=before.encode())
    assert pixels(folder, "three.exr") == pixels(folder, "whole.exr"), "another image than that of one file"


@check
def a_pipe_larger_than_its_buffer(tool, folder):
    text = SCENE + "AttributeBegin Translate 1 0 0 AttributeEnd\n" * 20000
    render(tool, folder, "-", "--spp", "1", "--outfile", "a.exr", scene=None, stdin=text.encode())


@check
def errors_in_a_pipe_have_positions(tool, folder):
    for words in (["-"], ["bsdf", "-", "--material", "a", "--wi", "0,0", "--out", "o"], ["compare", "-", "--out", "o"]):
        stdin = SCENE.encode() + b'  Material "difuse"\nShape "plymesh" "string filename" "none.ply"\n'
        text = b'WorldBegin\n  Shpae "sphere"\n' if words[0] != "-" else stdin
        result = tool.run(words, folder, stdin=text)
        assert result.status == 2, result.err
        if words[0] == "-":
            has(result.err, r'(?m)^<stdin>:\d+:3: error: unknown material "difuse"',
                r"(?m)^<stdin>:\d+:\d+: error: none\.ply")
        else:
            has(result.err, r"(?m)^<stdin>:2:3: error: unknown directive Shpae")
    result = tool.run(["-"], folder, stdin=b"\x00\x01\x02 no text")
    assert result.status == 2, result.err
    has(result.err, r"<stdin>:1:1: error: this is not a text file")


@check
def a_terminal_is_no_scene(tool, folder):
    for words in (["-"], [], ["render", "-"], ["bsdf", "-", "--material", "a", "--wi", "0,0", "--out", "o"]):
        controller, terminal = pty.openpty()
        try:
            done = subprocess.run([tool.path] + words, cwd=folder, stdin=terminal, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, text=True, timeout=20)
        finally:
            os.close(controller)
            os.close(terminal)
        assert done.returncode == 1 and not done.stdout, done
        has(done.stderr, r"^error: no scene: name a scene file, or pipe a scene")


@check
def closed_standard_input_is_a_file_error(tool, folder):
    for redirection in ("<&-", "< ."):
        done = subprocess.run(["sh", "-c", '"%s" - %s' % (tool.path, redirection)], cwd=folder, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=20)
        assert done.returncode == 3 and not done.stdout, done
        has(done.stderr, r"^error: <stdin>: cannot be read: ")


@check
def bsdf_of_a_scene_from_a_pipe(tool, folder):
    result = tool.run(["bsdf", "-", "--material", "bottom", "--wi", "30,0", "--resolution", "16", "--samples", "16",
                       "--quiet", "--out", "o"], folder, stdin=BALL.encode(), timeout=60)
    assert result.status == 0, result.err
    with open(os.path.join(folder, "o", "table.json")) as f:
        has(f.read(), '"<stdin>"')


@check
def compare_of_a_scene_from_a_pipe_finds_its_boxes(tool, folder):
    result = tool.run(["compare", "-", "--estimators", "forward", "--equal-samples", "1", "--runs", "2",
                       "--reference-spp", "16", "--quiet", "--out", "o"], folder, stdin=BALL.encode())
    assert result.status == 0, result.err
    with open(os.path.join(folder, "o", "results.json")) as f:
        text = f.read()
    has(text, r'"ball"', r'"<stdin>"')
