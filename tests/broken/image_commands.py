"""The commands on images (diff, convert, merge, info): wrong command lines, broken images, and right runs."""
import json
import math
import os
import struct
import subprocess
import sys

from run import Case, health
from command_line import SCENE, has, info, oiiotool, pixels, render, write


def pfm(width, height, value):
    """Bytes of a float image; value(x, y) gives a number or three, y from the top."""
    rows = []
    for y in reversed(range(height)):
        for x in range(width):
            v = value(x, y)
            rows += list(v) if isinstance(v, tuple) else [v] * 3
    return b"PF\n%d %d\n-1.0\n" % (width, height) + struct.pack("<%df" % len(rows), *rows)


GREY = pfm(8, 4, lambda x, y: 0.5)
OTHER_SIZE = pfm(4, 8, lambda x, y: 0.5)


def wrong(name, args, says, status=1, **more):
    return Case("images-" + name, None, says, status, args, {"a.pfm": GREY, "small.pfm": OTHER_SIZE,
                                                             "broken.exr": b"\x76\x2f\x31\x01 no more",
                                                             "text.png": b"no image", "old.png": b"kept"}, **more)


CASES = [
    wrong("diff-one-file", ["diff", "a.pfm"], ["reference", "lacquer diff --help"]),
    wrong("diff-three-files", ["diff", "a.pfm", "a.pfm", "a.pfm"], ["not expected", "a.pfm"]),
    wrong("diff-metric", ["diff", "a.pfm", "a.pfm", "--metric", "RSME"], ['"RSME"', '"RMSE"?', "MRSE", "FLIP"]),
    wrong("diff-option", ["diff", "a.pfm", "a.pfm", "--tolerence", "1"], ["--tolerence", '"--tolerance"?']),
    wrong("diff-tolerance-negative", ["diff", "a.pfm", "a.pfm", "--tolerance", "-1"], ["--tolerance", "at least 0"]),
    wrong("diff-tolerance-nan", ["diff", "a.pfm", "a.pfm", "--tolerance", "nan"], ["--tolerance", "finite"]),
    wrong("diff-tolerance-word", ["diff", "a.pfm", "a.pfm", "--tolerance", "low"], ["--tolerance", "low"]),
    wrong("diff-box", ["diff", "a.pfm", "a.pfm", "--box", "eye:1,2"], ["--box", '"eye:1,2"', "NAME:x0,x1,y0,y1"]),
    wrong("diff-box-outside", ["diff", "a.pfm", "a.pfm", "--box", "eye:20,30,2,3"], ["--box", '"eye:20,30,2,3"']),
    wrong("diff-channel", ["diff", "a.pfm", "a.pfm", "--channels", "R,g"], ["--channels", '"g"', '"G"?']),
    wrong("diff-missing", ["diff", "a.pfm", "none.exr"], ["none.exr: there is no such file"], 4),
    wrong("diff-damaged", ["diff", "broken.exr", "a.pfm"], ["broken.exr", "damaged"], 4),
    wrong("diff-no-image", ["diff", "text.png", "a.pfm"], ["text.png", "not an image"], 4),
    wrong("diff-size", ["diff", "small.pfm", "a.pfm"], ["small.pfm", "a.pfm", "4 x 8", "8 x 4"], 3),
    wrong("diff-map-format", ["diff", "a.pfm", "a.pfm", "--outfile", "m.xyz"], ["m.xyz", "no image format"], 4),
    wrong("diff-map-folder", ["diff", "a.pfm", "a.pfm", "--outfile", "no/m.png"], ["no/m.png", "does not exist"], 4),
    wrong("convert-one-file", ["convert", "a.pfm"], ["output", "lacquer convert --help"]),
    wrong("convert-missing", ["convert", "none.exr", "old.png"], ["none.exr: there is no such file"], 3),
    wrong("convert-damaged", ["convert", "broken.exr", "old.png"], ["broken.exr", "damaged"], 3),
    wrong("convert-format", ["convert", "a.pfm", "b.xyz"], ["b.xyz", "no image format", "exr"], 3),
    wrong("convert-option", ["convert", "a.pfm", "old.png", "--exposur=1"], ["--exposur", '"--exposure"?']),
    wrong("convert-exposure", ["convert", "a.pfm", "old.png", "--exposure", "1e9"], ["--exposure", "stops"]),
    wrong("convert-tonemap", ["convert", "a.pfm", "old.png", "--tonemap", "aecs"], ['"aecs"', "aces", "reinhard"]),
    wrong("convert-colorspace", ["convert", "a.pfm", "b.exr", "--colorspace", "rec202"], ['"rec202"', '"rec2020"?']),
    wrong("convert-resize", ["convert", "a.pfm", "old.png", "--resize", "8"], ['"8"', "WIDTHxHEIGHT"]),
    wrong("convert-resize-zero", ["convert", "a.pfm", "old.png", "--resize", "0x8"], ['"0x8"', "65536"]),
    wrong("convert-resize-huge", ["convert", "a.pfm", "old.png", "--resize", "60000x60000"], ["60000 x 60000"]),
    wrong("convert-crop", ["convert", "a.pfm", "old.png", "--crop", "5,3,0,1"], ["--crop", "no pixel"]),
    wrong("merge-one-file", ["merge", "a.pfm", "--outfile", "m.exr"], ["at least two"]),
    wrong("merge-no-outfile", ["merge", "a.pfm", "a.pfm"], ["--outfile"]),
    wrong("merge-no-counts", ["merge", "a.pfm", "a.pfm", "--outfile", "m.exr"],
          ["a.pfm", "how many samples", "samplesPerPixel"], 3),
    wrong("merge-missing", ["merge", "none.exr", "a.pfm", "--outfile", "m.exr"], ["none.exr"], 3),
    wrong("info-nothing", ["info"], ["files", "lacquer info --help"]),
    wrong("info-missing", ["info", "none.exr"], ["none.exr: there is no such file"], 3),
    wrong("info-damaged", ["info", "broken.exr"], ["broken.exr", "damaged"], 3),
]

CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


def run(tool, folder, *args, status=0, quiet=False):
    """Runs a command on images and demands the exit status."""
    result = tool.run(args, folder)
    problems = health(result)
    assert not problems, "; ".join(problems) + ": " + result.err
    assert result.status == status, "%s: exit status %d, not %d: %s" % (" ".join(args), result.status, status,
                                                                        result.err.strip())
    assert not (quiet and result.err), "says %r" % result.err
    return result


def table(result):
    """Rows of diff, each a dictionary by the names of the columns."""
    lines = [line.split("\t") for line in result.out.decode().splitlines()]
    assert all(len(line) == len(lines[0]) for line in lines), "a row of another length: %s" % lines
    return [dict(zip(lines[0], line)) for line in lines[1:]]


def close(value, expected, tolerance):
    assert abs(float(value) - expected) <= tolerance, "%s, not %s" % (value, expected)


@check
def image_commands_have_help(tool, folder):
    for command, words in [("diff", ["--metric", "idiff", "--tolerance"]), ("convert", ["--tonemap", "rec2020"]),
                        ("merge", ["--outfile"]), ("info", ["--json"])]:
        result = run(tool, folder, command, "--help", quiet=True)
        has(result.out.decode(), "Exit status", *words)
        assert max(map(len, result.out.decode().splitlines())) < 130, "long lines in the help of " + command


@check
def diff_is_a_table_of_the_whole_and_the_boxes(tool, folder):
    # The left half differs by 0.25, the right one by 0.5, in red only.
    write(folder, "b.pfm", GREY)
    write(folder, "a.pfm", pfm(8, 4, lambda x, y: (0.75 if x < 4 else 0.0, 0.5, 0.5)))
    for metric, left, right, mean in [
            ("MAE", 0.25, 0.5, lambda *v: sum(v) / 2),
            ("MSE", 0.0625, 0.25, lambda *v: sum(v) / 2),
            ("MRSE", 0.0625 / 0.26, 0.25 / 0.26, lambda *v: sum(v) / 2),
            ("RMSE", 0.25, 0.5, lambda *v: math.sqrt((v[0] ** 2 + v[1] ** 2) / 2))]:
        rows = table(run(tool, folder, "diff", "a.pfm", "b.pfm", "--metric", metric, "--box", "left:0,0.5,0,1",
                         "--box", "right:4,8,0,2", quiet=True))
        assert [r["region"] for r in rows] == ["all", "left", "right"], rows
        assert [rows[2][k] for k in ("x0", "x1", "y0", "y1")] == ["4", "8", "0", "2"], rows
        for row, expected in zip(rows, (mean(left, right), left, right)):
            assert row["metric"] == metric and row["G"] == row["B"] == "0", row
            close(row["R"], expected, 1e-6)
            close(row["mean"], expected / (math.sqrt(3) if metric == "RMSE" else 3), 1e-6)


@check
def diff_has_the_statuses_of_idiff(tool, folder):
    write(folder, "b.pfm", GREY)
    write(folder, "a.pfm", pfm(8, 4, lambda x, y: 0.75))
    run(tool, folder, "diff", "a.pfm", "b.pfm", quiet=True)
    run(tool, folder, "diff", "b.pfm", "b.pfm", "--tolerance", "0", quiet=True)
    run(tool, folder, "diff", "a.pfm", "b.pfm", "--tolerance", "0.25", quiet=True)
    result = run(tool, folder, "diff", "a.pfm", "b.pfm", "--tolerance", "0.2499", status=2)
    has(result.err, "error: RMSE of a.pfm is above the tolerance of 0.2499 in 4 numbers", "0.25 ")
    assert table(result), "no table beside the failure"


@check
def diff_reports_values_that_are_not_finite(tool, folder):
    for name, value in (("nan", math.nan), ("inf", math.inf)):
        write(folder, "a.pfm", pfm(8, 4, lambda x, y: value if (x, y) == (5, 2) else 0.5))
        write(folder, "b.pfm", GREY)
        for metric in ("MAE", "MRSE", "RMSE", "FLIP"):
            for pair in (("a.pfm", "b.pfm"), ("b.pfm", "a.pfm"), ("a.pfm", "a.pfm")):
                result = run(tool, folder, "diff", *pair, "--metric", metric, "--quiet", "--outfile", "m.png", status=2)
                has(result.err, r"error: a.pfm: %s; the first is R at x 5, y 2" %
                    ("3 values are NaN and 0 infinite" if name == "nan" else "0 values are NaN and 3 infinite"))
                assert not math.isfinite(float(table(result)[0]["mean"])), result.out
        # The map shows where: pure green, which the colour map has not.
        run(tool, folder, "diff", "a.pfm", "b.pfm", "--metric", "MAE", "--outfile", "m.png", "--quiet", status=2)
        has(oiiotool(folder, "m.png", "--cut", "1x1+5+2", "--printstats"), r"Stats Min: 0\.0+ 1\.0+ 0\.0+ ")


@check
def diff_writes_its_map(tool, folder):
    write(folder, "b.pfm", GREY)
    write(folder, "a.pfm", pfm(8, 4, lambda x, y: 0.5 + x / 8))
    result = run(tool, folder, "diff", "a.pfm", "b.pfm", "--metric", "MSE", "--outfile", "m.exr", quiet=True)
    stats = oiiotool(folder, "m.exr", "--printstats")
    has(stats, r"8 x +4, 3 channel, float", r"Stats Max: 0\.765625 0\.765625 0\.765625")
    close(table(result)[0]["mean"], sum((x / 8) ** 2 for x in range(8)) / 8, 1e-7)
    result = run(tool, folder, "diff", "a.pfm", "b.pfm", "--metric", "MSE", "--outfile", "m.png")
    has(result.err, r"^m\.png: MSE of each pixel, black is 0, pale yellow 0\.765625")
    # First and last row of the colour map.
    has(oiiotool(folder, "m.png", "--cut", "1x4+0+0", "--printstats"), r"Stats Max: 0\.0+ 0\.0+ 0\.015686 ")
    has(oiiotool(folder, "m.png", "--cut", "1x4+7+0", "--printstats"), r"Stats Min: 0\.988235 0\.992157 0\.749020 ")


@check
def diff_chooses_the_flip_of_the_format(tool, folder):
    write(folder, "b.pfm", GREY)
    write(folder, "a.pfm", pfm(8, 4, lambda x, y: 0.6))
    for name in "ab":
        run(tool, folder, "convert", name + ".pfm", name + ".png", quiet=True)
    screen = table(run(tool, folder, "diff", "a.png", "b.png", "--metric", "FLIP", quiet=True))[0]
    scene = table(run(tool, folder, "diff", "a.pfm", "b.pfm", "--metric", "FLIP", quiet=True))[0]
    assert (screen["metric"], scene["metric"]) == ("LDR-FLIP", "HDR-FLIP"), (screen, scene)
    assert 0 < float(screen["mean"]) < 1 and 0 < float(scene["mean"]) < 1, (screen, scene)
    same = table(run(tool, folder, "diff", "a.png", "a.png", "--metric", "FLIP", "--tolerance", "0", quiet=True))[0]
    assert same["mean"] == "0", same


@check
def diff_of_other_channels_or_colours_is_status_3(tool, folder):
    render(tool, folder, "--quiet", "--spp", "1", "--outfile", "plain.exr")
    render(tool, folder, "--quiet", "--spp", "1", "--outfile", "more.exr", "--aov", "depth")
    run(tool, folder, "convert", "plain.exr", "wide.exr", "--colorspace", "rec2020", quiet=True)
    has(run(tool, folder, "diff", "more.exr", "plain.exr", status=3).err, "channels R, G, B, Z, not R, G, B")
    rows = table(run(tool, folder, "diff", "more.exr", "plain.exr", "--channels", "R,G,B", "--tolerance", "0"))
    assert rows[0]["mean"] == "0", rows
    has(run(tool, folder, "diff", "wide.exr", "plain.exr", status=3).err, "rec2020, not in srgb", "--colorspace")


@check
def boxes_of_a_part_count_in_the_whole_frame(tool, folder):
    render(tool, folder, "--quiet", "--spp", "1", "--cropwindow", "0.25,0.75,0.5,1", "--outfile", "part.exr")
    rows = table(run(tool, folder, "diff", "part.exr", "part.exr", "--box", "a:0.5,1,0,1", "--box", "b:12,13,16,17"))
    places = [tuple(int(r[k]) for k in ("x0", "x1", "y0", "y1")) for r in rows]
    assert places == [(12, 36, 16, 32), (24, 36, 16, 32), (12, 13, 16, 17)], places
    run(tool, folder, "diff", "part.exr", "part.exr", "--box", "a:0,0.1,0,0.1", status=1)


@check
def convert_exposes_and_maps_tones(tool, folder):
    write(folder, "a.pfm", pfm(8, 4, lambda x, y: (0.25, 1.0, 4.0)))
    Y = 0.2126 * 0.25 + 0.7152 + 0.0722 * 4
    curve = lambda v: (0.6 * v * (2.51 * 0.6 * v + 0.03)) / (0.6 * v * (2.43 * 0.6 * v + 0.59) + 0.14)
    for args, expected in [
            (["--exposure", "-1.5"], [v * 2 ** -1.5 for v in (0.25, 1, 4)]),
            (["--exposure", "2", "--tonemap", "clamp"], [1, 1, 1]),
            (["--tonemap", "reinhard"], [v / (1 + Y) for v in (0.25, 1)] + [1]),
            (["--tonemap", "aces"], [min(1, curve(v)) for v in (0.25, 1, 4)])]:
        run(tool, folder, "convert", "a.pfm", "b.exr", *args, quiet=True)
        channels = json.loads(run(tool, folder, "info", "--json", "b.exr", quiet=True).out)[0]["channels"]
        for channel, value in zip(channels, expected):
            # Luminance weights are given to four digits above.
            close(channel["mean"], value, 2e-4 * value)


@check
def convert_keeps_what_it_does_not_change(tool, folder):
    render(tool, folder, "--quiet", "--spp", "4", "--seed", "7", "--aov", "albedo,samples", "--outfile", "a.exr")
    run(tool, folder, "convert", "a.exr", "b.exr", "--crop", "0.25,0.75,0.5,1", "--exposure", "1", quiet=True)
    has(info(folder, "b.exr"), r"24 x +16, 7 channel, float", r"pixel data origin: x=12, y=16",
        r"full/display size: 48 x 32", r"samplesPerPixel: 4\b", r"seed: 7\b", "worldToNDC: ", "Albedo.R", "samples")
    oiiotool(folder, "a.exr", "--ch", "Albedo.R,samples", "--cut", "24x16+12+16", "-o", "x.exr")
    oiiotool(folder, "b.exr", "--ch", "Albedo.R,samples", "-o", "y.exr")
    assert pixels(folder, "x.exr") == pixels(folder, "y.exr"), "extra channels changed"
    run(tool, folder, "convert", "a.exr", "c.exr", quiet=True)
    assert pixels(folder, "a.exr") == pixels(folder, "c.exr"), "a plain copy changed the pixels"
    run(tool, folder, "convert", "b.exr", "d.exr", "--resize", "48x32", quiet=True)
    has(info(folder, "d.exr"), r"48 x +32", r"pixel data origin: x=24, y=32", r"full/display size: 96 x 64")


@check
def convert_there_and_back_is_the_same(tool, folder):
    render(tool, folder, "--quiet", "--spp", "4", "--outfile", "a.exr")
    for space in ("rec2020", "dci-p3", "aces2065-1"):
        run(tool, folder, "convert", "a.exr", "b.exr", "--colorspace", space, quiet=True)
        assert space == json.loads(run(tool, folder, "info", "--json", "b.exr").out)[0]["color_space"]
        run(tool, folder, "convert", "b.exr", "c.exr", "--colorspace", "srgb", quiet=True)
        # Two products with matrices of condition 10, in floats.
        run(tool, folder, "diff", "c.exr", "a.exr", "--metric", "MAE", "--tolerance", "1e-6", quiet=True)


@check
def convert_resizes_without_shift_and_keeps_means(tool, folder):
    # A ramp, which any symmetric filter leaves alone but at its ends.
    write(folder, "a.pfm", pfm(64, 32, lambda x, y: (x + 0.5) / 64))
    for size in ("32x16", "128x64", "33x17"):
        width, height = map(int, size.split("x"))
        run(tool, folder, "convert", "a.pfm", "b.exr", "--resize", size, quiet=True)
        write(folder, "ramp.pfm", pfm(width, height, lambda x, y: (x + 0.5) / width))
        run(tool, folder, "convert", "ramp.pfm", "ramp.exr", quiet=True)
        run(tool, folder, "diff", "b.exr", "ramp.exr", "--metric", "MAE", "--channels", "R", "--tolerance", "0.004", quiet=True)
    write(folder, "flat.pfm", GREY)
    run(tool, folder, "convert", "flat.pfm", "b.exr", "--resize", "5x3", quiet=True)
    has(oiiotool(folder, "b.exr", "--printstats"), "5 x +3", "Stats Min: 0.5000", "Stats Max: 0.5000")


@check
def failures_keep_the_old_image(tool, folder):
    write(folder, "a.pfm", GREY)
    write(folder, "small.pfm", OTHER_SIZE)
    write(folder, "old.exr", "kept")
    run(tool, folder, "diff", "a.pfm", "small.pfm", "--outfile", "old.exr", status=3)
    run(tool, folder, "convert", "none.pfm", "old.exr", status=3)
    run(tool, folder, "merge", "a.pfm", "small.pfm", "--outfile", "old.exr", status=3)
    with open(os.path.join(folder, "old.exr")) as f:
        assert f.read() == "kept", "the old image was changed"


HALTON = SCENE.replace("zsobol", "halton")


@check
def merged_sample_ranges_are_the_whole_render(tool, folder):
    args = ("--quiet", "--spp", "64", "--aov", "variance,samples,albedo")
    render(tool, folder, *args, "--outfile", "all.exr", scene=HALTON)
    for name, samples in (("a.exr", "0:8"), ("b.exr", "8:32"), ("c.exr", "32:64")):
        render(tool, folder, *args, "--sample-range", samples, "--outfile", name, scene=HALTON)
    run(tool, folder, "merge", "c.exr", "a.exr", "b.exr", "--outfile", "m.exr", "--quiet", quiet=True)
    # Each value went through the rounding of floats three times; the largest is 1, and 64 for the counts.
    rows = table(run(tool, folder, "diff", "m.exr", "all.exr", "--channels", "R,G,B,Variance.Y,samples",
                     "--tolerance", "2e-7", quiet=True))
    assert rows[0]["samples"] == "0", rows
    # Albedos are quotients of sums: the mean of three is not quite that of the whole.
    run(tool, folder, "diff", "m.exr", "all.exr", "--channels", "Albedo.R,Albedo.G,Albedo.B", "--tolerance", "1e-3",
        quiet=True)
    merged, whole = [json.loads(run(tool, folder, "info", "--json", name).out)[0]["metadata"]
                     for name in ("m.exr", "all.exr")]
    for key in ("samplesPerPixel", "seed", "firstSample", "scene"):
        assert merged[key] == whole[key], "%s is %s, not %s" % (key, merged[key], whole[key])
    # The control: equal weights, which would be wrong.
    oiiotool(folder, "a.exr", "b.exr", "--add", "c.exr", "--add", "--mulc", "0.33333", "-o", "x.exr")
    run(tool, folder, "diff", "x.exr", "all.exr", "--channels", "R,G,B", "--tolerance", "1e-4", status=2)


@check
def merge_without_counts_per_pixel_takes_those_of_the_metadata(tool, folder):
    render(tool, folder, "--quiet", "--spp", "16", "--outfile", "all.exr", scene=HALTON)
    for name, samples in (("a.exr", "0:4"), ("b.exr", "4:16")):
        render(tool, folder, "--quiet", "--spp", "16", "--sample-range", samples, "--outfile", name, scene=HALTON)
    result = run(tool, folder, "merge", "a.exr", "b.exr", "--outfile", "m.exr")
    has(result.err, r"^m\.exr: 2 images, 16 samples per pixel")
    run(tool, folder, "diff", "m.exr", "all.exr", "--tolerance", "2e-7", quiet=True)


@check
def merge_weighs_each_pixel_by_its_samples(tool, folder):
    # 2 samples on the left and 6 on the right, as after a time limit; the second image has 2 in all pixels.
    oiiotool(folder, "--create", "8x4", "4", "--chnames", "R,G,B,samples", "--fill:color=1,1,1,2", "4x4+0+0",
             "--fill:color=1,1,1,6", "4x4+4+0", "--attrib:type=int", "samplesPerPixel", "2", "-o", "a.exr")
    oiiotool(folder, "--create", "8x4", "3", "--fill:color=4,4,4", "8x4", "--attrib:type=int", "samplesPerPixel", "2",
             "-o", "b.exr")
    for order in (("a.exr", "b.exr"), ("b.exr", "a.exr")):
        result = run(tool, folder, "merge", *order, "--outfile", "m.exr")
        has(result.err, r"^m\.exr: 2 images, 4 to 8 samples per pixel")
        has(oiiotool(folder, "m.exr", "--cut", "4x4+0+0", "--printstats"), "Constant Color: 2.5000.* 4.0000")
        has(oiiotool(folder, "m.exr", "--cut", "4x4+4+0", "--printstats"), "Constant Color: 1.7500.* 8.0000")
        has(info(folder, "m.exr"), r"samplesPerPixel: 4\b")


@check
def merged_halves_stay_halves(tool, folder):
    # The denoiser takes the noise from what the halves differ by: a sample each must not end in one half.
    aovs = ["--quiet", "--spp", "5", "--aov", "half"]
    render(tool, folder, *aovs, "--outfile", "all.exr", scene=HALTON)
    for parts in ((1, 1, 1, 1, 1), (3, 1, 1), (2, 3)):
        names = []
        for i in range(len(parts)):
            names.append("%d.exr" % i)
            render(tool, folder, *aovs, "--sample-range", "%d:%d" % (sum(parts[:i]), sum(parts[:i + 1])),
                   "--outfile", names[-1], scene=HALTON)
        run(tool, folder, "merge", *names, "--outfile", "m.exr", "--quiet", quiet=True)
        run(tool, folder, "diff", "m.exr", "all.exr", "--channels", "R,G,B,Half.R,Half.G,Half.B", "--tolerance", "1e-6",
            quiet=True)


@check
def merge_of_shared_samples_warns(tool, folder):
    for name, samples in (("a.exr", "0:8"), ("b.exr", "4:12")):
        render(tool, folder, "--quiet", "--spp", "16", "--sample-range", samples, "--outfile", name, scene=HALTON)
    render(tool, folder, "--quiet", "--spp", "8", "--seed", "1", "--outfile", "c.exr", scene=HALTON)
    has(run(tool, folder, "merge", "a.exr", "b.exr", "--outfile", "m.exr").err,
        r"warning: a\.exr and b\.exr have one seed, 0, and share samples 4 to 7")
    assert "warning" not in run(tool, folder, "merge", "a.exr", "c.exr", "--outfile", "m.exr").err
    result = json.loads(run(tool, folder, "info", "--json", "m.exr").out)[0]["metadata"]
    assert result["samplesPerPixel"] == 16 and "seed" not in result and "firstSample" not in result, result


@check
def merge_of_what_hits_warns_and_normalises(tool, folder):
    for seed in ("1", "2"):
        render(tool, folder, "--quiet", "--spp", "4", "--seed", seed, "--aov", "ng", "--outfile", seed + ".exr")
    has(run(tool, folder, "merge", "1.exr", "2.exr", "--outfile", "m.exr").err, "warning: N.X, N.Y, N.Z are means")
    oiiotool(folder, "m.exr", "--ch", "N.X,N.Y,N.Z", "--powc", "2", "--chsum", "-o", "length.exr")
    has(oiiotool(folder, "length.exr", "--printstats"), r"Stats Max: (1\.0000|0\.9999)")


OTHERS_FILES = """
import sys, numpy as np, OpenImageIO as oiio
def write(name, pixels, **attributes):
    kind, names, tile = (attributes.pop(k, None) for k in ("kind", "names", "tile"))
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind or oiio.FLOAT)
    if names: spec.channelnames = names
    if tile: spec.tile_width = spec.tile_height = tile
    for key, value in attributes.items(): spec.attribute(key, value)
    out = oiio.ImageOutput.create("exr")
    if not (out.open(name, spec) and out.write_image(pixels)): sys.exit(out.geterror())
    out.close()
ramp = np.linspace(0, 1, 40 * 50 * 3, dtype=np.float32).reshape(40, 50, 3)
write("tiled.exr", ramp, tile=16)
write("dwaa.exr", ramp, compression="dwaa")
write("b44.exr", ramp, kind=oiio.HALF, compression="b44")
write("ids.exr", (ramp[:, :, 2:] * 4000000000).astype(np.uint32), kind=oiio.UINT32, names=("id",))
"""


@check
def exr_files_of_other_programs_are_read(tool, folder):
    """Tiles, levels, several parts, lossy packing, integers."""
    subprocess.run([sys.executable, "-c", OTHERS_FILES], cwd=folder, check=True)
    oiiotool(folder, "tiled.exr", "b44.exr", "--siappend", "-o", "parts.exr")
    subprocess.run(["maketx", "tiled.exr", "-d", "float", "-o", "levels.exr"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    for name, bits, tolerance in [("tiled", 32, 1e-6), ("levels", 32, 1e-6), ("parts", 32, 1e-6), ("dwaa", 32, 1e-2), ("b44", 16, 1e-2)]:
        file = json.loads(run(tool, folder, "info", "--json", name + ".exr").out)[0]
        assert file["full_resolution"] == [50, 40] and file["format"] == "%d-bit" % bits and file["channels"][0]["name"] == "R", file
        close(file["channels"][1]["mean"], 0.5, tolerance)
    ids = json.loads(run(tool, folder, "info", "--json", "ids.exr").out)[0]["channels"][0]
    assert ids["name"] == "id", ids
    close(ids["max"], 4e9, 1e3)


@check
def info_is_json(tool, folder):
    render(tool, folder, "--quiet", "--spp", "2", "--cropwindow", "0.25,0.75,0.5,1", "--outfile", "a.exr", scene=HALTON)
    write(folder, "b.pfm", pfm(8, 4, lambda x, y: (math.nan, math.inf, x) if x < 2 else (1.0, 2.0, 3.0)))
    first, second = json.loads(run(tool, folder, "info", "--json", "a.exr", "b.pfm", quiet=True).out)
    assert first["resolution"] == [24, 16] and first["full_resolution"] == [48, 32], first
    assert first["data_window"] == {"x0": 12, "x1": 36, "y0": 16, "y1": 32}, first
    assert first["color_space"] == "srgb" and first["format"] == "32-bit", first
    assert first["metadata"]["samplesPerPixel"] == 2 and len(first["metadata"]["worldToCamera"]) == 4, first
    r, g, b = second["channels"]
    assert (r["nan"], r["inf"], g["nan"], g["inf"], b["nan"], b["inf"]) == (8, 0, 0, 8, 0, 0), second
    assert r["min"] == r["max"] == r["mean"] == 1 and b["min"] == 0 and b["max"] == 3, second
    close(b["mean"], (0 + 1 + 6 * 3) / 8, 1e-12)


@check
def info_goes_on_after_a_file_that_cannot_be_read(tool, folder):
    write(folder, "a.pfm", GREY)
    result = run(tool, folder, "info", "none.exr", "a.pfm", status=3)
    has(result.err, r"^error: none\.exr: there is no such file")
    has(result.out.decode(), r"^a\.pfm: 8 x 4 pixels, 3 channels, 32-bit", r"R +0\.5 +0\.5 +0\.5 +0 +0")
