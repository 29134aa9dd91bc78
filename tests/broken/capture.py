"""lacquer capture: photographs and views that are none, wrong command lines, and right runs."""
import json
import math
import os
import struct
import zlib

from command_line import has, write
from run import Case

SIZE = 16
EDGE = 10.0  # of the sample [cm]


def png(pixels):
    """Bytes of an RGB image with 16 bits; pixels: rows of triples in [0,1]."""
    rows = b"".join(b"\0" + b"".join(struct.pack(">HHH", *(round(65535 * v) for v in rgb)) for rgb in row) for row in pixels)

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", len(pixels[0]), len(pixels), 16, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def photograph(camera, albedo=(0.5, 0.3, 0.1)):
    """What a camera with the light at its place sees of a matt sample: albedo cos / (pi d^2), times 1500."""
    rows = []
    for i in range(SIZE):
        y = -((i + 0.5) / SIZE - 0.5) * EDGE
        row = []
        for j in range(SIZE):
            x = ((j + 0.5) / SIZE - 0.5) * EDGE
            d2 = (camera[0] - x) ** 2 + (camera[1] - y) ** 2 + camera[2] ** 2
            row.append([min(1, 1500 * a / math.pi * camera[2] / math.sqrt(d2) / d2) ** (1 / 2.2) for a in albedo])
        rows.append(row)
    return png(rows)


CAMERAS = [(0, 0, 22), (6, 0, 20), (-6, 1, 20), (0, 6, 20), (1, -6, 20)]
VIEWS = {"unit": "cm", "size": EDGE, "views": [{"image": "%d.png" % k, "camera": list(c)} for k, c in enumerate(CAMERAS)]}
FILES = {"views.json": json.dumps(VIEWS), "old.json": "kept", **{"%d.png" % k: photograph(c) for k, c in enumerate(CAMERAS)}}
RUN = ["--views", "views.json", "--out", "out", "--resolution", "16"]


# One that holds nothing.
SAFETENSORS = struct.pack("<Q", 8) + b"{}      "


def usage(name, args, says, status=1, files_too=None, **more):
    return Case("capture-" + name, None, says, status, ["capture", *args], {**FILES, "folder": None, **(files_too or {})}, **more)


def views(name, change, says, status=2):
    """views.json with something changed in it."""
    text = json.loads(json.dumps(VIEWS))
    text = change(text) or text
    return Case("capture-views-" + name, None, says, status, ["capture", *RUN],
                {**FILES, "views.json": text if isinstance(text, str) else json.dumps(text)})


CASES = [
    usage("nothing", [], ["--out is required"]),
    usage("no-photographs", ["--out", "out"], ["photographs are required", "--views"]),
    usage("no-out", ["0.png"], ["--out is required"]),
    usage("both", ["0.png", *RUN], ["--views", "both are given"]),
    usage("no-file", ["none.png", "--out", "out"], ["none.png"], 3),
    usage("empty-folder", ["folder", "--out", "out"], ["folder"], 3),
    usage("no-image", ["old.json", "--out", "out"], ["old.json"], 2),
    usage("no-tags", ["0.png", "1.png", "2.png", "--out", "out"], ["0.png", "no tags"], 2, errors=3),
    usage("out-is-the-input", ["--views", "views.json", "--out", "."], ["--out wants another folder"], 3),
    usage("out-is-a-file", ["--views", "views.json", "--out", "old.json"], ["old.json"], 3),
    usage("card-and-photographs", ["0.png", "--card", "card.svg"], ["--card writes the card"]),
    usage("card-below-nothing", ["--card", "no/card.svg"], ["no/card.svg"], 3),
    usage("card-size", ["--card", "card.svg", "--size", "0"], ["--size", "0"]),
    usage("size-nan", [*RUN, "--size", "nan"], ["--size", "nan"]),
    usage("response", [*RUN, "--response", "sgrb"], ["sgrb", 'did you mean "srgb"?']),
    usage("as", [*RUN, "--as", "mxi"], ["mxi", 'did you mean "mix"?']),
    usage("light-word", [*RUN, "--light", "bright"], ["--light", '"bright"', "auto"]),
    usage("light-two", [*RUN, "--light", "1,2"], ["--light", "three"]),
    usage("light-zero", [*RUN, "--light", "0"], ["--light", "above 0"]),
    usage("flash-with-views", [*RUN, "--flash", "1,0,0"], ["--flash", "no effect with --views"]),
    usage("flash-two", ["0.png", "--out", "out", "--flash", "1,0"], ["--flash", "three numbers"]),
    usage("focal-with-views", [*RUN, "--focal", "900"], ["--focal", "no effect with --views"]),
    usage("response-with-views", [*RUN, "--response", "linear"], ["--response", "no effect with --views"]),
    usage("size-with-views", [*RUN, "--size", "20"], ["--size", "no effect with --views"]),
    usage("depth-with-views", [*RUN, "--depth", "0.1"], ["--depth", "no effect with --views"]),
    usage("depth-below-zero", ["0.png", "--out", "out", "--depth", "-1"], ["--depth", "-1"]),
    usage("depth-of-the-card", ["0.png", "--out", "out", "--size", "5", "--depth", "6"], ["--depth", "less than the size"]),
    usage("flash-far", ["0.png", "--out", "out", "--flash", "1e300,0,0"], ["--flash", "within 1000 cm"]),
    usage("light-huge", [*RUN, "--light", "1e20"], ["--light", "1e+12"]),
    usage("light-tiny", [*RUN, "--light", "1,1,1e-40"], ["--light", "1e-12"]),
    usage("photograph-without-name", ["", "--out", "out"], ["no name"]),
    usage("final-resolution-above-the-images", [*RUN, "--final-resolution", "32"], ["0.png", "16 x 16", "32 x 32"], 2),
    usage("final-resolution", [*RUN, "--final-resolution", "24"], ["--final-resolution", "24", "32"]),
    usage("resolution-above-the-images", ["--views", "views.json", "--out", "out", "--resolution", "64"], ["0.png", "64"], 2),
    usage("hold-out-all", [*RUN, "--hold-out", "5"], ["--hold-out", "fewer than the 5"]),
    # The builds that are tested here have no libtorch.
    usage("prior-without-its-program", [*RUN, "--prior", "x.safetensors"], ["no lacquer-materialgan", "libtorch-dev"]),
    usage("prior-options-without-it", [*RUN, "--strategy", "2"], ["--strategy", "--prior"]),
    usage("resume-another", [*RUN, "--resume", "--iterations", "7"], ["checkpoint.safetensors", "no checkpoint"], 3,
          files_too={"out": None, "out/checkpoint.safetensors": SAFETENSORS}),
    usage("resume-damaged", [*RUN, "--resume"], ["checkpoint.safetensors"], 3,
          files_too={"out": None, "out/checkpoint.safetensors": "x"}),
    usage("iterations-zero", [*RUN, "--iterations", "0"], ["--iterations", "0"]),
    usage("option", [*RUN, "--iteration", "1"], ["--iteration", '"--iterations"?']),
    views("no-json", lambda v: "{", ["views.json:1:"]),
    views("unknown-key", lambda v: v.update(lihgtPower=[1, 1, 1]), ["views.json:1:", "lihgtPower", "lightPower"]),
    views("camera-below", lambda v: v["views"][1].update(camera=[0, 0, -3]), ["views.json:1:", "camera"]),
    views("camera-short", lambda v: v["views"][0].update(camera=[0, 0]), ["views.json:1:", "camera"]),
    views("no-views", lambda v: v.update(views=[]), ["views.json:1:", "views"]),
    views("all-tests", lambda v: [w.update(use="test") for w in v["views"]] and None, ["fit"]),
    views("no-image", lambda v: v["views"][2].update(image="none.png"), ["none.png"], 3),
    views("size-zero", lambda v: v.update(size=0), ["views.json:1:", "size"]),
]

CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


def prepare(folder):
    for name, content in FILES.items():
        write(folder, name, content)


@check
def captured_maps_are_those_of_the_photographs(tool, folder):
    prepare(folder)
    result = tool.run(["capture", *RUN, "--hold-out", "1", "--iterations", "200"], folder)
    assert result.status == 0, result.err
    has(result.err, "predict the held-out photographs", "report.html")
    out = os.path.join(folder, "out")
    for name in ("albedo.exr specular.exr alpha.exr normal.exr dif.png nom.png rgh.png spe.png material.pbrt turntable.pbrt "
                 "views.json result.json report.html").split():
        assert os.path.getsize(os.path.join(out, name)) > 60, name
    with open(os.path.join(out, "result.json"), encoding="utf-8") as file:
        numbers = json.load(file)
    assert numbers["fit_rmse"] < 0.01 and numbers["test_rmse"] < 0.02, numbers["verdict"]
    assert [v["use"] for v in numbers["views"]].count("test") == 1
    # A photograph under another sample's name would be seen.
    with open(os.path.join(folder, "2.png"), "wb") as file:
        file.write(photograph(CAMERAS[2], (0.05, 0.6, 0.6)))
    result = tool.run(["capture", *RUN[:3], "wrong", *RUN[4:], "--iterations", "200"], folder)
    assert result.status == 0, result.err
    with open(os.path.join(folder, "wrong", "result.json"), encoding="utf-8") as file:
        assert json.load(file)["fit_rmse"] > 0.05


@check
def captures_have_the_same_bits_on_any_threads_and_again_from_their_views(tool, folder):
    prepare(folder)
    for name, source, threads in (("a", "views.json", "1"), ("b", "views.json", "2"), ("c", "a/views.json", "2")):
        result = tool.run(["capture", "--views", source, "--out", name, "--resolution", "16", "--iterations", "40", "--nthreads", threads,
                           "--final-resolution", "16"], folder)
        assert result.status == 0, result.err
    for name in ("albedo.exr", "alpha.exr", "normal.exr", "spe.png"):
        contents = set()
        for run in "abc":
            with open(os.path.join(folder, run, name), "rb") as file:
                contents.add(file.read())
        assert len(contents) == 1, name


@check
def a_captured_material_renders(tool, folder):
    prepare(folder)
    for kind in ("svbrdf", "mix", "coated"):
        result = tool.run(["capture", *RUN[:3], kind, *RUN[4:], "--as", kind, "--iterations", "30", "--frames", "2"], folder)
        assert result.status == 0, result.err
        assert os.path.exists(os.path.join(folder, kind, "turntable.0002.pbrt"))
        result = tool.run([os.path.join(kind, "turntable.pbrt"), "--spp", "1", "--resolution", "32x32", "--outfile", kind + ".pfm"], folder)
        assert result.status == 0 and "error" not in result.err, result.err
        assert os.path.getsize(os.path.join(folder, kind + ".pfm")) > 12000


@check
def a_capture_that_is_stopped_has_its_maps(tool, folder):
    prepare(folder)
    result = tool.run(["capture", *RUN, "--iterations", "400000", "--time-limit", "1"], folder)
    assert result.status == 5, result.err
    has(result.err, "end of the time")
    assert os.path.getsize(os.path.join(folder, "out", "albedo.exr")) > 60
    has(open(os.path.join(folder, "out", "report.html"), encoding="utf-8").read(), "stopped before its end")


@check
def a_capture_goes_on_to_the_same_bits(tool, folder):
    prepare(folder)
    run = lambda out, *more: tool.run(["capture", *RUN[:3], out, *RUN[4:], "--iterations", "4000", *more], folder)
    result = run("part", "--time-limit", "0.3")
    assert result.status == 5, result.err
    has(result.err, "--resume goes on")
    # Another problem is refused by what differs, and nothing is lost.
    result = run("part", "--resume", "--iterations", "4001")
    assert result.status == 3, result.err
    has(result.err, "--iterations 4000, and this one has 4001")
    for out, more in (("part", ["--resume"]), ("whole", [])):
        result = run(out, *more)
        assert result.status == 0, result.err
        assert not os.path.exists(os.path.join(folder, out, "checkpoint.safetensors"))
    for name in ("albedo.exr", "alpha.exr", "normal.exr", "spe.png"):
        assert read(folder, "part", name) == read(folder, "whole", name), name
    history = [json.loads(read(folder, out, "result.json"))["history"] for out in ("part", "whole")]
    assert history[0] == history[1] and len(history[0]) >= 200, len(history[0])


def read(*parts):
    with open(os.path.join(*parts), "rb") as file:
        return file.read()


@check
def photographs_behind_links_are_not_overwritten(tool, folder):
    prepare(folder)
    os.mkdir(os.path.join(folder, "out"))
    os.mkdir(os.path.join(folder, "links"))
    for k in range(5):
        os.rename(os.path.join(folder, "%d.png" % k), os.path.join(folder, "out", "0%d.png" % k))
        os.symlink("../out/0%d.png" % k, os.path.join(folder, "links", "p%d.png" % k))
    for name, image in (("direct.json", "out/0%d.png"), ("by-links.json", "links/p%d.png")):
        views = {**VIEWS, "views": [{**view, "image": image % k} for k, view in enumerate(VIEWS["views"])]}
        write(folder, name, json.dumps(views))
    before = [read(folder, "out", "0%d.png" % k) for k in range(5)]
    for args in (["--views", "direct.json"], ["--views", "by-links.json"], ["links"]):
        result = tool.run(["capture", *args, "--out", "out", "--resolution", "16"], folder)
        assert result.status == 3, result.err
        has(result.err, "which is read; --out wants another folder")
    assert before == [read(folder, "out", "0%d.png" % k) for k in range(5)] and len(os.listdir(os.path.join(folder, "out"))) == 5


@check
def a_stopped_capture_keeps_the_maps_of_one_that_was_not(tool, folder):
    prepare(folder)
    assert tool.run(["capture", *RUN, "--iterations", "100"], folder).status == 0
    before = {name: read(folder, "out", name) for name in ("albedo.exr", "result.json", "report.html")}
    result = tool.run(["capture", *RUN, "--iterations", "400000", "--time-limit", "0.3"], folder)
    assert result.status == 5, result.err
    has(result.err, "keeps the maps that it had, and --resume goes on")
    assert before == {name: read(folder, "out", name) for name in before}
    # What was held out is another problem, by its name.
    result = tool.run(["capture", *RUN, "--iterations", "400000", "--resume", "--hold-out", "1"], folder)
    assert result.status == 3, result.err
    has(result.err, "--hold-out 0, and this one has 1")


@check
def the_card_is_a_drawing_of_its_size(tool, folder):
    result = tool.run(["capture", "--card", "card.svg", "--size", "12"], folder)
    assert result.status == 0, result.err
    with open(os.path.join(folder, "card.svg"), encoding="utf-8") as file:
        text = file.read()
    has(text, "<svg", 'width="140mm"', "12 cm")
