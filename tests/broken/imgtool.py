"""The commands of pbrt's imgtool (assemble, average, bloom, cat, ...) and the options of convert: wrong use, and right runs."""
import json
import math
import os
import re
import struct
import subprocess

from command_line import SCENE, has, pixels, render, write
from image_commands import GREY, OTHER_SIZE, close, pfm, run, table, wrong

CASES = [
    wrong("assemble-size", ["assemble", "a.pfm", "small.pfm", "--outfile", "m.exr"], ["small.pfm", "4 x 8"], 3),
    wrong("average-nothing", ["average", "none", "--outfile", "m.exr"], ["none", "no file has this name"], 3),
    wrong("average-size", ["average", "a.pfm", "small.pfm", "--outfile", "m.exr"], ["small.pfm", "does not fit"], 3),
    wrong("error-no-reference", ["error", "a.pfm"], ["--reference"]),
    wrong("error-only-reference", ["error", "a.pfm", "--reference", "a.pfm"], ["no image beside the reference"]),
    wrong("bloom-level", ["bloom", "a.pfm", "--outfile", "old.png"], ["--level"]),
    wrong("bloom-width", ["bloom", "a.pfm", "--outfile", "old.png", "--level", "1", "--width", "0"], ["--width"]),
    wrong("cat-two-forms", ["cat", "a.pfm", "--csv", "--sort"], ["only one of"]),
    wrong("cat-channel", ["cat", "a.pfm", "--channels", "Q"], ["--channels", '"Q"']),
    wrong("falsecolor-max", ["falsecolor", "a.pfm", "--outfile", "old.png", "--maxvalue", "-1"], ["maxvalue", "above 0"]),
    wrong("makeequiarea-mapping", ["makeequiarea", "a.pfm", "--outfile", "m.exr", "--mapping", "latlon"],
          ['"latlon"', '"latlong"?']),
    wrong("makeequiarea-ball", ["makeequiarea", "a.pfm", "--outfile", "m.exr", "--mapping", "angular"],
          ["a.pfm", "square"], 3),
    wrong("makesky-night", ["makesky", "--outfile", "m.exr", "--time", "2026-12-21 23:00 Z", "--latitude", "50",
                            "--longitude", "0"], ["night"]),
    wrong("makesky-time", ["makesky", "--outfile", "m.exr", "--time", "noon"], ["time", "noon", "2026-06-21"]),
    wrong("makesky-place", ["makesky", "--outfile", "m.exr", "--time", "2026-06-21 12:00"], ["--latitude"]),
    wrong("makesky-nan", ["makesky", "--outfile", "m.exr", "--elevation", "nan"], ["--elevation", '"nan"', "finite"]),
    wrong("makesky-two-suns", ["makesky", "--outfile", "m.exr", "--time", "2026-06-21 12:00", "--latitude", "50",
                               "--longitude", "0", "--elevation", "5"], ["--time", "--elevation"]),
    wrong("makesky-place-alone", ["makesky", "--outfile", "m.exr", "--latitude", "50"], ["--latitude", "--time"]),
    wrong("bloom-nan", ["bloom", "a.pfm", "--outfile", "old.png", "--level", "nan"], ["--level", '"nan"', "finite"]),
    wrong("scalenormalmap-infinite", ["scalenormalmap", "a.pfm", "--outfile", "old.png", "--scale", "inf"],
          ["--scale", '"inf"', "finite"]),
    wrong("falsecolor-tiny", ["falsecolor", "a.pfm", "--outfile", "old.png", "--maxvalue", "1e-60"], ["maxvalue", "1e-60"]),
    wrong("error-only-reference-by-another-name", ["error", "a.pfm", "--reference", "./a.pfm"],
          ["no image beside the reference"]),
    wrong("makeemitters-missing", ["makeemitters", "none.exr"], ["none.exr: there is no such file"], 3),
    wrong("splitn-one", ["splitn", "a.pfm", "--outfile", "m.exr"], ["at least two"]),
    wrong("splitn-crop", ["splitn", "a.pfm", "a.pfm", "--outfile", "m.exr", "--crop", "4,2", "--cropsize", "8"],
          ["crop", "8 x 4"]),
    wrong("whitebalance-none", ["whitebalance", "a.pfm", "--outfile", "m.exr"], ["--temperature", "--primaries"]),
    wrong("whitebalance-illuminant", ["whitebalance", "a.pfm", "--outfile", "m.exr", "--illuminant", "D66"],
          ['"D66"', '"D65"']),
    wrong("whitebalance-primaries", ["whitebalance", "a.pfm", "--outfile", "m.exr", "--primaries", "1,2"], ["1,2"]),
    wrong("convert-repeat", ["convert", "a.pfm", "b.exr", "--repeatpix", "60000"], ["--repeatpix", "too many"]),
    wrong("convert-maxluminance", ["convert", "a.pfm", "old.png", "--maxluminance", "4"], ["--tonemap reinhard"]),
    wrong("convert-channels", ["convert", "a.pfm", "b.exr", "--channels", "R,Z"], ["--channels", '"Z"']),
    wrong("convert-channel-twice", ["convert", "a.pfm", "b.exr", "--channels", "R,R"], ["--channels", "R is there twice"]),
    *(wrong(name + "-folder", [name, *words, "--outfile", "no/m.exr"], ["no/m.exr", "does not exist"], 3)
      for name, words in [("makesky", ["--elevation", "30"]), ("makeequiarea", ["a.pfm"]), ("bloom", ["a.pfm", "--level", "1"]),
                          ("falsecolor", ["a.pfm"]), ("assemble", ["a.pfm"]), ("average", ["a", "b"]),
                          ("whitebalance", ["a.pfm", "--temperature", "5000"])]),
    *(wrong(name + "-folder", [name, *words, "--outfile", "no/m.exr"], ["no/m.exr", "does not exist"], 3)
      for name, words in [("merge", ["none.exr", "a.pfm"]), ("splitn", ["none.exr", "a.pfm"]), ("scalenormalmap", ["none.exr"])]),
    # The name of the output is looked at before any input is read: none.exr is not there.
    *(wrong(name + "-extension", [name, *words, "--outfile", "m.jpgg"], ["m.jpgg", "no image format", "exr"], 3)
      for name, words in [("makesky", ["--elevation", "30"]), ("makeequiarea", ["none.exr"]),
                          ("bloom", ["none.exr", "--level", "1"]), ("falsecolor", ["none.exr"]), ("assemble", ["none.exr"]),
                          ("average", ["none.exr", "none.exr"]), ("whitebalance", ["none.exr", "--temperature", "5000"]),
                          ("merge", ["none.exr", "none.exr"]), ("splitn", ["none.exr", "none.exr"]),
                          ("scalenormalmap", ["none.exr"]), ("denoise", ["none.exr"])]),
    wrong("diff-extension", ["diff", "none.exr", "a.pfm", "--outfile", "m.jpgg"], ["m.jpgg", "no image format"], 4),
    wrong("convert-extension", ["convert", "none.exr", "m.jpgg"], ["m.jpgg", "no image format"], 3),
    wrong("error-extension", ["error", "a", "--reference", "none.exr", "--errorfile", "m.jpgg"],
          ["m.jpgg", "no image format"], 3),
    wrong("falsecolor-ramp-extension", ["falsecolor", "none.exr", "--outfile", "m.png", "--ramp", "r.jpgg"],
          ["r.jpgg", "no image format"], 3),
    wrong("falsecolor-ramp-outfile", ["falsecolor", "a.pfm", "--outfile", "m.png", "--ramp", "./m.png"],
          ["--ramp", "./m.png", "another file"]),
    wrong("denoise-noisefile-outfile", ["denoise", "a.pfm", "--outfile", "m.exr", "--noisefile", "m.exr"],
          ["--noisefile", "another file"]),
    wrong("falsecolor-ramp-folder", ["falsecolor", "a.pfm", "--outfile", "m.png", "--ramp", "no/r.png"],
          ["no/r.png", "does not exist"], 3),
    wrong("help-unknown", ["help", "comapre"], ['"comapre"', '"compare"?']),
    wrong("denoise-no-channels", ["denoise", "a.pfm", "--outfile", "m.exr"], ["a.pfm", "Half.R", "--denoise"], 3),
    wrong("denoise-denoiser", ["denoise", "a.pfm", "--outfile", "m.exr", "--denoiser", "nfro"],
          ["--denoiser", '"nfro"', '"nfor"?', "oidn"]),
    wrong("denoise-folder", ["denoise", "a.pfm", "--outfile", "m.exr", "--noisefile", "no/n.exr"],
          ["no/n.exr", "does not exist"], 3),
    wrong("denoise-missing", ["denoise", "none.exr", "--outfile", "m.exr"], ["none.exr: there is no such file"], 3),
    wrong("no-command-with-dash", ["make-sky"], ["no command and no file", '"makesky"?']),
    wrong("no-command-like-it", ["frobnicate"], ["no command and no file", "lacquer help"]),
    wrong("command-of-pbrt", ["denoise-optix"], ["denoise-optix of pbrt", "lacquer denoise"]),
    wrong("program-of-pbrt", ["plytool"], ["plytool of pbrt", "--toply"]),
    wrong("option-of-pbrt", ["a.pbrt", "--toply"], ["--toply of pbrt", "lacquer convert"]),
    wrong("option-of-pbrt-in-front", ["-Format", "a.pbrt"], ["-Format of pbrt", "lacquer convert"]),
    wrong("option-of-pbrt-with-value", ["a.pbrt", "--gpu-device=1"], ["--gpu-device=1 of pbrt", "processors"]),
    wrong("no-command", ["comapre"], ["no command and no file", '"compare"?']),
]

CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


def values(tool, folder, name):
    """Rows of pixels, each a list of numbers."""
    rows = run(tool, folder, "cat", name, "--list", quiet=True).out.decode()
    return json.loads(rows)


def same(rows, expected, tolerance=1e-6):
    """Values against expected(x, y), which gives the channels."""
    for y, row in enumerate(rows):
        for x, pixel in enumerate(row):
            for found, value in zip(pixel, expected(x, y)):
                assert abs(found - value) <= tolerance, "pixel %d, %d is %s, not %s" % (x, y, pixel, expected(x, y))


RAMP = pfm(8, 4, lambda x, y: (x / 8, y / 4, (x + y) / 16))


@check
def cat_prints_pixels_in_three_forms(tool, folder):
    write(folder, "a.pfm", RAMP)
    same(values(tool, folder, "a.pfm"), lambda x, y: (x / 8, y / 4, (x + y) / 16))
    lines = run(tool, folder, "cat", "a.pfm", "--csv", "--channels", "G").out.decode().split()
    assert lines == [",".join(["%g" % (y / 4)] * 8) for y in range(4)], lines
    lines = run(tool, folder, "cat", "a.pfm", "--crop", "6,8,3,4").out.decode().splitlines()
    assert lines == ["(6, 3): 0.75 0.75 0.5625", "(7, 3): 0.875 0.75 0.625"], lines
    last = run(tool, folder, "cat", "a.pfm", "--sort").out.decode().splitlines()[-1]
    assert last.startswith("(7, 3)"), last


@check
def convert_has_the_options_of_imgtool(tool, folder):
    write(folder, "a.pfm", RAMP)
    a = lambda x, y: (x / 8, y / 4, (x + y) / 16)
    luminance = lambda c: 0.212639 * c[0] + 0.715169 * c[1] + 0.072192 * c[2]
    for options, expected, tolerance in [
            (["--flipy"], lambda x, y: a(x, 3 - y), 1e-6),
            (["--scale", "3"], lambda x, y: [3 * v for v in a(x, y)], 1e-6),
            (["--bw"], lambda x, y: [sum(a(x, y)) / 3] * 3, 1e-6),
            (["--gamma", "2"], lambda x, y: [v * v for v in a(x, y)], 1e-6),
            (["--repeatpix", "3"], lambda x, y: a(x // 3, y // 3), 1e-6),
            (["--clamp", "0.4"], lambda x, y: [v * min(1, 0.4 / max(*a(x, y), 1e-9)) for v in a(x, y)], 1e-6),
            (["--clamp", "0.4", "--scale", "3"], lambda x, y: [3 * v * min(1, 0.4 / max(*a(x, y), 1e-9)) for v in a(x, y)], 1e-6),
            (["--scale", "4", "--preservecolors"],
             lambda x, y: [4 * v / max(1, *[4 * w for w in a(x, y)]) for v in a(x, y)], 1e-6),
            (["--tonemap", "reinhard", "--maxluminance", "2"],
             lambda x, y: [v * (1 + luminance(a(x, y)) / 4) / (1 + luminance(a(x, y))) for v in a(x, y)], 1e-4)]:
        run(tool, folder, "convert", "a.pfm", "b.exr", *options, quiet=True)
        same(values(tool, folder, "b.exr"), expected, tolerance)
    run(tool, folder, "convert", "a.pfm", "b.exr", "--channels", "B,R", quiet=True)
    assert sorted(json.loads(run(tool, folder, "info", "--json", "b.exr").out)[0]["channels"][i]["name"]
                  for i in range(2)) == ["B", "R"]


@check
def convert_despikes_single_pixels(tool, folder):
    write(folder, "a.pfm", pfm(8, 4, lambda x, y: 1000 if (x, y) == (5, 2) else 0.5))
    result = run(tool, folder, "convert", "a.pfm", "b.exr", "--despike", "10")
    has(result.err, "1 pixel exceed")
    same(values(tool, folder, "b.exr"), lambda x, y: [0.5] * 3)
    # An edge of many bright pixels is no spike.
    write(folder, "edge.pfm", pfm(8, 4, lambda x, y: 1000 if x > 3 else 0.5))
    run(tool, folder, "convert", "edge.pfm", "b.exr", "--despike", "10", "--quiet")
    same(values(tool, folder, "b.exr"), lambda x, y: [1000 if x > 3 else 0.5] * 3, 1e-3)


@check
def assembled_crops_are_the_whole_render(tool, folder):
    render(tool, folder, "--quiet", "--spp", "4", "--outfile", "all.exr")
    for name, crop in (("a.exr", "0,0.5,0,1"), ("b.exr", "0.5,1,0,0.5"), ("c.exr", "0.5,1,0.5,1")):
        render(tool, folder, "--quiet", "--spp", "4", "--cropwindow", crop, "--outfile", name)
    result = run(tool, folder, "assemble", "c.exr", "a.exr", "b.exr", "--outfile", "m.exr")
    assert "warning" not in result.err, result.err
    assert pixels(folder, "m.exr") == pixels(folder, "all.exr"), "the crops are not the whole"
    has(run(tool, folder, "assemble", "a.exr", "a.exr", "--outfile", "n.exr").err, "pixels are in no image",
        "pixels are in several images")


@check
def averages_and_errors_of_sets(tool, folder):
    for i, value in enumerate((0.25, 0.5, 1.5)):
        write(folder, "r-%d.pfm" % i, pfm(8, 4, lambda x, y: value))
    write(folder, "ref.pfm", pfm(8, 4, lambda x, y: 0.5))
    has(run(tool, folder, "average", "r-", "--outfile", "m.exr").err, "the mean of 3 images")
    same(values(tool, folder, "m.exr"), lambda x, y: [0.75] * 3)
    out = run(tool, folder, "error", "r-", "--reference", "ref.pfm", "--errorfile", "e.exr").out.decode()
    words = dict(zip(["MSE", "deviation", "images"], [w.split()[-1] for w in out.strip().split("\t")]))
    errors = [0.0625, 0, 1]
    mean = sum(errors) / 3
    close(words["MSE"], mean, 1e-7)
    close(words["deviation"], math.sqrt(sum((e - mean) ** 2 for e in errors) / 2), 1e-7)
    same(values(tool, folder, "e.exr"), lambda x, y: [mean] * 3)
    # The root of a mean is taken last, over the channels, too.
    write(folder, "c.pfm", pfm(8, 4, lambda x, y: (0.5, 0.5, 0.9)))
    out = run(tool, folder, "error", "c.pfm", "--reference", "ref.pfm", "--metric", "RMSE").out.decode()
    close(out.split()[1], 0.4 / math.sqrt(3), 1e-6)
    # What an earlier run has written under the prefix is none of the images.
    for _ in range(2):
        has(run(tool, folder, "average", "r-", "--outfile", "r-mean.exr").err, "the mean of 3 images")
    os.remove(os.path.join(folder, "r-mean.exr"))
    for _ in range(2):
        out = run(tool, folder, "error", "r-", "--reference", "ref.pfm", "--errorfile", "r-e.exr").out.decode()
        has(out, "images 3")


@check
def small_skies_have_the_energy_of_large_ones(tool, folder):
    means = []
    for side in ("512", "64", "16"):
        for sun in ([], ["--sun"]):
            run(tool, folder, "makesky", "--elevation", "35", "--azimuth", "50", "--resolution", side, "--outfile", "s.exr",
                *sun, "--quiet", quiet=True)
            rows = values(tool, folder, "s.exr")
            means.append(sum(p[1] for row in rows for p in row) / len(rows) ** 2)
    for small in (means[2:4], means[4:6]):
        close(small[0], means[0], 0.01 * means[0])
        close(small[1] - small[0], means[1] - means[0], 0.01 * (means[1] - means[0]))


@check
def bloom_adds_light_around_bright_pixels(tool, folder):
    write(folder, "a.pfm", pfm(64, 64, lambda x, y: (100, 50, 0) if (x, y) == (32, 32) else 0))
    run(tool, folder, "bloom", "a.pfm", "--level", "10", "--scale", "0.3", "--outfile", "b.exr", "--quiet")
    b = values(tool, folder, "b.exr")
    total = [sum(p[c] for row in b for p in row) for c in range(3)]
    # Five blurs keep the light, but for what leaves the image.
    close(total[0], 130, 0.5)
    close(total[1], 65, 0.3)
    assert total[2] == 0 and b[32][40][0] > 1e-3 > b[2][2][0], "the light is not around the pixel"
    has(run(tool, folder, "bloom", "a.pfm", "--level", "1000", "--outfile", "c.exr").err, "no pixel exceeds 1000")


@check
def false_colors_and_normals(tool, folder):
    write(folder, "a.pfm", pfm(8, 4, lambda x, y: x / 7 - 0.5))
    run(tool, folder, "falsecolor", "a.pfm", "--plusminus", "--outfile", "b.exr", "--ramp", "ramp.png", "--quiet")
    same(values(tool, folder, "b.exr"), lambda x, y: (max(1 - 2 * x / 7, 0), max(2 * x / 7 - 1, 0), 0), 1e-5)
    assert os.path.exists(os.path.join(folder, "ramp.png"))
    n = (0.3, -0.2, math.sqrt(1 - 0.13))
    write(folder, "n.pfm", pfm(8, 4, lambda x, y: tuple(0.5 * v + 0.5 for v in n)))
    run(tool, folder, "scalenormalmap", "n.pfm", "--scale", "2", "--outfile", "m.exr")
    length = math.sqrt((2 * n[0]) ** 2 + (2 * n[1]) ** 2 + n[2] ** 2)
    scaled = [0.5 + v / length for v in (n[0], n[1], 0.5 * n[2])]
    same(values(tool, folder, "m.exr"), lambda x, y: scaled, 1e-5)
    # Through bytes, and back by a scale of 1.
    run(tool, folder, "scalenormalmap", "n.pfm", "--scale", "2", "--outfile", "m.png")
    run(tool, folder, "scalenormalmap", "m.png", "--outfile", "k.exr")
    same(values(tool, folder, "k.exr"), lambda x, y: scaled, 0.01)


@check
def strips_and_squares_side_by_side(tool, folder):
    for i in range(2):
        write(folder, "s%d.pfm" % i, pfm(8, 4, lambda x, y: i + x / 10))
    run(tool, folder, "splitn", "s0.pfm", "s1.pfm", "--outfile", "m.exr", "--crop", "3,1", "--cropsize", "2")
    rows = values(tool, folder, "m.exr")
    assert len(rows) == 6 and len(rows[0]) == 8
    same(rows[:4], lambda x, y: [(x >= 4) + x / 10] * 3)
    same([row[:4] for row in rows[4:]], lambda x, y: [(x >= 2) + (3 + x % 2) / 10] * 3)


@check
def white_balance_makes_the_illuminant_white(tool, folder):
    # The colour of illuminant A in linear sRGB, by its chromaticity 0.44758, 0.40745.
    x, y = 0.44758, 0.40745
    X, Z = x / y, (1 - x - y) / y
    rgb = (3.2404542 * X - 1.5371385 - 0.4985314 * Z, -0.9692660 * X + 1.8760108 + 0.0415560 * Z,
           0.0556434 * X - 0.2040259 + 1.0572252 * Z)
    write(folder, "a.pfm", pfm(8, 4, lambda x, y: rgb))
    for option in (["--illuminant", "A"], ["--primaries", "0.44758,0.40745"], ["--temperature", "2856"]):
        run(tool, folder, "whitebalance", "a.pfm", "--outfile", "b.exr", *option)
        pixel = values(tool, folder, "b.exr")[0][0]
        tolerance = 0.04 if option[0] == "--temperature" else 3e-3
        assert max(abs(v - 1) for v in pixel) < tolerance, "%s gives %s" % (option, pixel)


LIGHT = ('Film "rgb" "integer xresolution" 48 "integer yresolution" 32 "string filename" "x.exr"\n'
         'LookAt 0 0 0  0 1 0.3  0 0 1 Camera "perspective" "float fov" 90\n'
         'Sampler "independent" "integer pixelsamples" 64\nIntegrator "path"\nWorldBegin\n%s\n'
         'Material "diffuse" Translate 0 4 0 Shape "sphere"\n')


@check
def made_maps_are_the_same_light(tool, folder):
    sky = '"float elevation" 35 "float azimuth" 150 "spectrum groundalbedo" [300 0.5 900 0.5]'
    render(tool, folder, "--quiet", "--outfile", "sky.exr",
           scene=LIGHT % ('LightSource "infinite" "string model" "sky" "bool ground" false ' + sky))
    run(tool, folder, "makesky", "--outfile", "m.exr", "--elevation", "35", "--azimuth", "150", "--sun", "--resolution",
        "1024", "--quiet")
    render(tool, folder, "--quiet", "--outfile", "map.exr",
           scene=LIGHT % 'LightSource "infinite" "string filename" "m.exr"')
    # Noise of 64 samples in a mean of 1,536 pixels, and the sun as texels.
    sums = [[sum(p[c] for row in values(tool, folder, name) for p in row) for c in range(3)]
            for name in ("sky.exr", "map.exr")]
    for c in range(3):
        assert abs(sums[0][c] / sums[1][c] - 1) < 0.03, sums
    # A panorama, read as it is and through makeequiarea.
    write(folder, "pano.pfm", pfm(64, 32, lambda x, y: (1 + x / 64, 1 + y / 32, 2 if (x, y) == (20, 12) else 1)))
    run(tool, folder, "makeequiarea", "pano.pfm", "--outfile", "square.exr", "--quiet")
    for name, light in (("direct.exr", '"string filename" "pano.pfm" "string mapping" "latlong"'),
                        ("made.exr", '"string filename" "square.exr"')):
        render(tool, folder, "--quiet", "--outfile", name, scene=LIGHT % ('LightSource "infinite" ' + light))
    run(tool, folder, "diff", "direct.exr", "made.exr", "--metric", "MAE", "--tolerance", "1e-3", quiet=True)


@check
def emitters_of_an_image_are_a_scene(tool, folder):
    write(folder, "a.pfm", pfm(4, 2, lambda x, y: (1 + x, 2, 1.5) if y == 0 else 0))
    text = run(tool, folder, "makeemitters", "a.pfm", quiet=True).out.decode()
    assert text.count("AreaLightSource") == 4, text
    write(folder, "lights.pbrt", text)
    camera = ('LookAt 0.5 0.25 1  0.5 0.25 0  0 1 0 Camera "orthographic" "float screenwindow" [-.5 .5 -.25 .25]\n'
              'Film "rgb" "integer xresolution" 4 "integer yresolution" 2 "string filename" "x.exr"\n'
              'PixelFilter "box" Sampler "independent" "integer pixelsamples" 1024\nWorldBegin Include "lights.pbrt"\n')
    render(tool, folder, "--quiet", "--outfile", "b.exr", scene=camera)
    rows = values(tool, folder, "b.exr")
    # pbrt's cameras see a left-handed space: x runs to the left here.
    same(rows, lambda x, y: (4 - x, 2, 1.5) if y == 0 else (0, 0, 0), 0.1)


@check
def emitters_are_means_of_squares(tool, folder):
    # Of 5 x 3 pixels in squares of 2, those at the far edges are smaller.
    write(folder, "a.pfm", pfm(5, 3, lambda x, y: (1 if (x, y) == (0, 0) else 0, 2 if x == 4 else 0, 0)))
    text = run(tool, folder, "makeemitters", "a.pfm", "--downsample", "2", quiet=True).out.decode()
    lights = re.findall(r'"rgb L" \[(\S+) (\S+) (\S+)\]', text)
    assert lights == [("0.25", "0", "0"), ("0", "2", "0"), ("0", "2", "0")], text
    write(folder, "nan.pfm", pfm(2, 1, lambda x, y: float("nan") if x else 1))
    has(run(tool, folder, "makeemitters", "nan.pfm").err, "warning: nan.pfm")


@check
def denoised_renders_are_nearer_to_the_truth(tool, folder):
    scene = SCENE.replace("zsobol", "independent")
    render(tool, folder, "--quiet", "--spp", "1024", "--seed", "9", "--outfile", "truth.exr", scene=scene)
    render(tool, folder, "--quiet", "--spp", "8", "--aov", "half,variance,albedo,normal,depth", "--outfile", "n.exr",
           scene=scene)
    render(tool, folder, "--quiet", "--spp", "8", "--denoise", "--outfile", "one.exr", scene=scene)
    run(tool, folder, "denoise", "n.exr", "--outfile", "two.exr", "--noisefile", "left.exr", "--quiet", quiet=True)
    run(tool, folder, "diff", "one.exr", "two.exr", "--channels", "R,G,B", "--tolerance", "0", quiet=True)
    assert len(json.loads(run(tool, folder, "info", "--json", "one.exr").out)[0]["channels"]) == 3
    errors = [float(table(run(tool, folder, "diff", name, "truth.exr", "--channels", "R,G,B"))[0]["mean"])
              for name in ("n.exr", "one.exr")]
    assert errors[1] < 0.6 * errors[0], errors
    for denoised in ("one.exr", "two.exr"):  # not once more
        has(run(tool, folder, "denoise", denoised, "--outfile", "x.exr", status=3).err, "Half.R")
    # What is known before the render is said before it, to --quiet as well, and nothing is written.
    for quiet in ((), ("--quiet",)):
        has(render(tool, folder, "--spp", "1", "--denoise", "--outfile", "x.exr", *quiet, scene=scene, status=1).err,
            "--denoise: the image has one sample in each pixel")
    splats = scene.replace("WorldBegin", 'Integrator "bdpt"\nWorldBegin')
    has(render(tool, folder, "--denoise", "--quiet", "--outfile", "x.exr", scene=splats, status=1).err,
        "--denoise: the image has light that is traced from the lights")
    assert not os.path.exists(os.path.join(folder, "x.exr"))


@check
def pixels_for_a_full_disk_are_a_failure(tool, folder):
    write(folder, "a.pfm", RAMP)
    for name in ("cat", "makeemitters"):
        with open("/dev/full", "w") as full:
            result = subprocess.run([tool.path, name, "a.pfm"], cwd=folder, stdout=full, stderr=subprocess.PIPE, timeout=60)
        assert result.returncode == 3, "%s: status %d" % (name, result.returncode)
        has(result.stderr.decode(), "standard output cannot be written")
        assert b"bug" not in result.stderr, result.stderr


@check
def help_lists_the_commands(tool, folder):
    text = run(tool, folder, "help", quiet=True).out.decode()
    has(text, "makesky", "whitebalance", "Averages renders of one image")
    assert run(tool, folder, "help", "diff").out == run(tool, folder, "diff", "--help").out


@check
def bad_values_of_inputs_are_told(tool, folder):
    nan = pfm(8, 4, lambda x, y: (math.nan, 0.5, 0.5) if x == 3 and y == 1 else (0.5, 0.5, 0.5))
    write(folder, "nan.pfm", nan)
    write(folder, "a.pfm", GREY)
    for words in (["whitebalance", "nan.pfm", "--temperature", "5000"], ["assemble", "nan.pfm"], ["splitn", "a.pfm", "nan.pfm"],
                  ["scalenormalmap", "nan.pfm"]):
        has(run(tool, folder, *words, "--outfile", "m.exr").err, r"warning: nan\.pfm: 1 values are NaN and 0 infinite",
            "first is R at x 3, y ")
        # The negative control: nothing is said of what is finite.
        finite = [w.replace("nan", "a") for w in words]
        assert "NaN" not in run(tool, folder, *finite, "--outfile", "m.exr").err


@check
def a_wide_bloom_is_the_sum_of_its_weights(tool, folder):
    # One bright pixel, blurred by a Gaussian that is far wider than the image: nearly the same everywhere, and what a
    # direct sum of the weights says.
    write(folder, "dot.pfm", pfm(16, 8, lambda x, y: (100.0, 0.0, 0.0) if (x, y) == (5, 2) else (0.0, 0.0, 0.0)))
    run(tool, folder, "bloom", "dot.pfm", "--outfile", "b.pfm", "--level", "1", "--width", "31", "--iterations", "1",
        "--scale", "1", "--quiet", quiet=True)
    weights = [math.exp(-0.5 * (i / 5) ** 2) for i in range(-15, 16)]
    with open(os.path.join(folder, "b.pfm"), "rb") as f:
        header, data = [f.readline() for _ in range(3)], f.read()
    values = struct.unpack(("<" if float(header[2]) < 0 else ">") + "%df" % (len(data) // 4), data)[::3]
    assert len(values) == 16 * 8
    bright = max(range(len(values)), key=lambda i: values[i])
    by, bx = divmod(bright, 16)
    for i, value in enumerate(values):
        y, x = divmod(i, 16)
        expected = 100 * weights[15 + x - bx] * weights[15 + y - by] / sum(weights) ** 2 + (100 if i == bright else 0)
        close(value, expected, 1e-4)
