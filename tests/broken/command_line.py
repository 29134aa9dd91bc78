"""Command lines: wrong ones, with an answer that helps, and right ones, which do what they say."""
import gzip
import json
import os
import re
import signal
import subprocess


from run import Case, health
from scenes import SMALL, options, world

GOOD = world('Shape "sphere"')


def usage(name, args, says, **more):
    return Case("usage-" + name, more.pop("scene", GOOD), says, 1, args, **more)


CASES = [
    usage("unknown-option", ["--sppp", "4"], ["--sppp", '"--spp"']),
    usage("unknown-option-far", ["--frobnicate"], ["--frobnicate", "--help"]),
    usage("option-without-value", ["--spp"], ["--spp"]),
    usage("estimator-unknown", ["--estimator", "bidirectinal"],
          ["--estimator", '"bidirectinal"', '"bidirectional"?', "unidirectional"]),
    usage("layered-pdf-unknown", ["--layered-pdf", "aproximate"],
          ["--layered-pdf", '"aproximate"', '"approximate"?', "unbiased"]),
    usage("help-as-unknown", ["--help-as", "pdf"], ["--help-as", "pdf", "man", "bash"]),
    usage("spp-zero", ["--spp", "0"], ["--spp", "0"]),
    usage("spp-word", ["--spp", "many"], ["--spp", "many"]),
    usage("spp-huge", ["--spp", "1e99"], ["--spp", "1e99"]),
    usage("spp-two-billion", ["--spp", "2000000000"], ["--spp", "2000000000"]),
    usage("threads-negative", ["--nthreads", "-3"], ["--nthreads", "-3"]),
    usage("seed-huge", ["--seed", "99999999999"], ["--seed", "99999999999"]),
    usage("resolution-word", ["--resolution", "axb"], ["--resolution", '"axb"', "WIDTHxHEIGHT"]),
    usage("resolution-one-number", ["--resolution", "64"], ["--resolution", '"64"', "WIDTHxHEIGHT"]),
    usage("resolution-zero", ["--resolution", "0x5"], ["--resolution", '"0x5"']),
    usage("resolution-two-billion", ["--resolution", "2000000000x2000000000"], ["--resolution", "65536"]),
    usage("cropwindow-three", ["--cropwindow", "0,1,0"], ["--cropwindow", '"0,1,0"']),
    usage("cropwindow-nan", ["--cropwindow", "0,nan,0,1"], ["--cropwindow", '"0,nan,0,1"']),
    usage("cropwindow-above-one", ["--cropwindow", "0,2,0,1"], ["--cropwindow", '"0,2,0,1"', "from 0 to 1"]),
    usage("cropwindow-below-zero", ["--cropwindow=-.1,1,0,1"], ["--cropwindow", '"-.1,1,0,1"', "from 0 to 1"]),
    usage("cropwindow-empty", ["--cropwindow", ".5,.5,0,1"], ["crop window", "no pixel", "8 x 8"]),
    usage("pixel-outside", ["--pixel", "100,100"], ["pixel", "8 x 8"]),
    usage("pixel-huge", ["--pixel", "2147483647,0"], ["--pixel", '"2147483647,0"']),
    usage("pixelbounds-reversed", ["--pixelbounds", "5,2,0,8"], ["pixel bounds", "no pixel"]),
    usage("sample-range-reversed", ["--sample-range", "1:0"], ["--sample-range", '"1:0"']),
    usage("sample-range-words", ["--sample-range", "a:b"], ["--sample-range", '"a:b"']),
    usage("sample-range-beyond", ["--sample-range", "0:9"], ["--sample-range", '"0:9"', "at most 1"]),
    usage("time-limit-negative", ["--time-limit", "-1"], ["--time-limit", "-1"]),
    usage("time-limit-nan", ["--time-limit", "nan"], ["--time-limit", "nan"]),
    usage("time-limit-word", ["--time-limit", "soon"], ["--time-limit", "soon"]),
    usage("aov-unknown", ["--aov", "albdo"], ["--aov", '"albdo"', '"albedo"']),
    usage("texture-memory-word", ["--texture-memory", "much"], ["--texture-memory", "much"]),
    usage("texture-memory-small", ["--texture-memory", "1"], ["--texture-memory", "16"]),
    usage("displacement-edge-scale-zero", ["--displacement-edge-scale", "0"], ["--displacement-edge-scale"]),
    usage("log-level", ["--log-level", "loud"], ["--log-level", "loud", "verbose"]),
    usage("log-level-misspelt", ["--log-level", "verbos", "--log-file", "log"], ["--log-level", '"verbos"', '"verbose"?']),
    usage("coordinates", ["--render-coord-sys", "mars"], ["--render-coord-sys", "mars", "cameraworld"]),
    usage("coordinates-misspelt", ["--render-coord-sys", "cameraword"],
          ["--render-coord-sys", '"cameraword"', '"cameraworld"?']),
    usage("empty-display-server", ["--display-server", ""], ["--display-server", "empty"]),
    usage("empty-log-file", ["--log-file", ""], ["--log-file", "empty"]),
    usage("empty-crop", ["--cropwindow", ""], ["--cropwindow", "empty"]),
    usage("empty-estimator", ["--estimator", ""], ["--estimator", "empty"]),
    usage("reference-without-out", ["--mse-reference-image", "x.exr"],
          ["--mse-reference-image", "--mse-reference-out"]),
]


# ---- Checks of what works ----

CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


SCENE = """Film "rgb" "integer xresolution" 48 "integer yresolution" 32 "string filename" "scene.exr"
Sampler "zsobol" "integer pixelsamples" 8
LookAt 0 1 -4  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "infinite" "rgb L" [.4 .5 .6]
LightSource "point" "point3 from" [2 3 -3] "rgb I" [9 9 9]
Material "conductor" "float roughness" 0.2
Shape "sphere"
Material "diffuse"
Translate 0 -1 0 Rotate 90 1 0 0
Shape "disk" "float radius" 5
"""


def write(folder, name, text):
    path = os.path.join(folder, name)
    with open(path, "wb") as f:
        f.write(text if isinstance(text, bytes) else text.encode())
    return path


def render(tool, folder, *args, scene=SCENE, status=0, stdin=None, **more):
    """Runs on scene.pbrt, which is written first, and demands the exit status."""
    if scene is not None:
        write(folder, "scene.pbrt", scene)
        args = ("scene.pbrt",) + args
    result = tool.run(args + ("--nthreads", "2"), folder, stdin=stdin, **more)
    problems = health(result)
    assert not problems, "; ".join(problems) + ": " + result.err
    assert result.status == status, "exit status %d, not %d: %s" % (result.status, status, result.err.strip())
    return result


def oiiotool(folder, *args):
    done = subprocess.run(["oiiotool"] + list(args), cwd=folder, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, "oiiotool %s: %s" % (" ".join(args), done.stdout)
    return done.stdout


def info(folder, name="scene.exr"):
    return oiiotool(folder, "--info", "-v", name)


def pixels(folder, name="scene.exr"):
    """Digest of the pixel values, whatever the metadata."""
    return re.search(r"SHA-1: (\w+)", oiiotool(folder, "--info", "-v", "--hash", name)).group(1)


def has(text, *fragments):
    for fragment in fragments:
        assert re.search(fragment, text), "no %r in:\n%s" % (fragment, text)


def left(folder):
    return sorted(n for n in os.listdir(folder) if n != "scene.pbrt")


TEXTURED = SCENE.replace('Material "conductor" "float roughness" 0.2', """
Texture "noise" "spectrum" "imagemap" "string filename" "noise.png"
Material "diffuse" "texture reflectance" "noise\"""")


@check
def textures_on_disk_give_the_same_image(tool, folder):
    oiiotool(folder, "--create", "1000x1000", "3", "--noise:type=uniform:min=0:max=1", "-d", "uint8", "-o", "noise.png")
    render(tool, folder, scene=TEXTURED)
    in_memory = pixels(folder)
    cache = ("--texture-memory", "16", "--texture-cache", "cache")
    for _ in range(2):
        result = render(tool, folder, *cache, scene=TEXTURED)
        assert pixels(folder) == in_memory, "another image from tiles"
        assert len(os.listdir(os.path.join(folder, "cache"))) == 1
    assert "reparing" not in result.err, "the image was prepared twice: " + result.err
    # A folder that cannot be is said once, and does not matter.
    write(folder, "file", "")
    result = render(tool, folder, "--texture-memory", "16", "--texture-cache", "file/cache", scene=TEXTURED)
    has(result.err, "cannot be kept in file/cache")
    assert pixels(folder) == in_memory
    # A prepared file that breaks is made anew.
    (name,) = os.listdir(os.path.join(folder, "cache"))
    with open(os.path.join(folder, "cache", name), "r+b") as f:
        f.truncate(1000)
    render(tool, folder, *cache, scene=TEXTURED)
    assert pixels(folder) == in_memory
    # Without images, their mean.
    render(tool, folder, "--disable-image-textures", scene=TEXTURED)
    assert pixels(folder) != in_memory


@check
def help_is_on_stdout(tool, folder):
    result = render(tool, folder, "--help", scene=None)
    has(result.out.decode(), "--spp", "--outfile", "--aov", "Exit status")
    assert not result.err, "something on stderr: " + result.err
    for command in [[], ["bsdf"], ["bulk"], ["compare"], ["convert"], ["diff"], ["estimate"], ["info"], ["merge"],
                    ["plugins"]]:
        text = tool.run([*command, "--help"], folder).out.decode()
        longest = max(text.splitlines(), key=len)
        assert len(longest) <= 120, "lacquer %s: a line of %d characters: %s" % (command, len(longest), longest)
        assert text.count("Usage:") == 1, "usage of lacquer %s told %d times" % (command, text.count("Usage:"))


@check
def help_for_shells_is_on_stdout(tool, folder):
    result = render(tool, folder, "--help-as", "bash", scene=None)
    has(result.out.decode(), r"complete .* lacquer$", "--spp", "--metric")
    assert not result.err, "something on stderr: " + result.err


@check
def version_is_on_stdout(tool, folder):
    result = render(tool, folder, "--version", scene=None)
    has(result.out.decode(), r"^lacquer \d+\.\d+")
    assert not result.err, "something on stderr: " + result.err


@check
def options_in_the_spelling_of_pbrt(tool, folder):
    render(tool, folder, "-spp", "2", "--OutFile=a.exr", "--disable_pixel_jitter", "--quiet")
    has(info(folder, "a.exr"), r"samplesPerPixel: 2\b")


@check
def the_verb_render_may_be_said(tool, folder):
    write(folder, "scene.pbrt", SCENE)
    render(tool, folder, "render", "scene.pbrt", "--spp", "1", scene=None)
    assert left(folder) == ["scene.exr"], "wrote %s" % left(folder)


@check
def spp_and_resolution_are_taken(tool, folder):
    # The sampler zsobol takes a power of two; the others take what is asked for.
    render(tool, folder, "--spp", "3", "--resolution", "20x10", scene=SCENE.replace("zsobol", "halton"))
    has(info(folder), r"20 x +10, 3 channel, float openexr", r"samplesPerPixel: 3\b")
    render(tool, folder, "--spp", "5")
    has(info(folder), r"48 x +32", r"samplesPerPixel: 4\b")


# A pdf has effects only where light may be found in two ways: a lamp with a surface.
LAYERED = SCENE.replace('"conductor" "float roughness" 0.2', '"coatedconductor" "float interface.roughness" 0.2 %s') + (
    'AreaLightSource "diffuse" "rgb L" [4 4 4]\nTranslate 2 -1 -3\nShape "sphere" "float radius" 0.7\n')


@check
def estimator_and_pdf_of_the_command_line_replace_those_of_the_scene(tool, folder):
    def image(parameters, *args):
        render(tool, folder, "--quiet", *args, scene=LAYERED % parameters)
        return pixels(folder)

    forward = image('"string estimator" "forward"')
    unbiased = image('"string pdf" "unbiased"')
    assert forward != image(""), "the scene's estimator has no effect"
    assert forward == image("", "--estimator", "forward")
    assert forward == image('"string estimator" "unidirectional"', "--estimator", "forward")
    assert unbiased != image(""), "the scene's pdf has no effect"
    assert unbiased == image("", "--layered-pdf", "unbiased")


@check
def a_log_on_a_full_disk_is_an_error_after_the_image(tool, folder):
    result = render(tool, folder, "--log-file", "/dev/full", "--log-level", "verbose", status=3)
    has(result.err, r"error: /dev/full: cannot be written: No space left on device; the log is incomplete")
    assert left(folder) == ["scene.exr"], left(folder)
    # Nothing is logged at this level: nothing is lost.
    render(tool, folder, "--log-file", "/dev/full")


@check
def the_scene_of_the_readme_renders_as_it_stands(tool, folder):
    with open(os.path.join(os.path.dirname(__file__), "..", "..", "README.md"), encoding="utf-8") as f:
        scene = re.search(r"^```\n(LookAt.*?)^```", f.read(), re.S | re.M).group(1)
    result = render(tool, folder, "--resolution", "32x24", "--spp", "1", scene=scene)
    has(result.err, r"kettle\.png: 32 x 24 pixels, 1 sample each")
    assert "warning" not in result.err, result.err
    assert left(folder) == ["kettle.png"], left(folder)


@check
def cropwindow_is_a_part_of_the_same_image(tool, folder):
    render(tool, folder, "--outfile", "whole.exr")
    render(tool, folder, "--cropwindow", "0.25,0.75,0.5,1", "--outfile", "crop.exr")
    has(info(folder, "crop.exr"), r"24 x +16", r"pixel data origin: x=12, y=16",
        r"full/display size: 48 x 32")
    oiiotool(folder, "whole.exr", "--cut", "24x16+12+16", "-o", "cut.exr")
    same = pixels(folder, "cut.exr") == pixels(folder, "crop.exr")
    assert same, "the pixels differ from those of the whole image"


@check
def pixel_is_one_pixel_of_the_same_image(tool, folder):
    render(tool, folder, "--outfile", "whole.exr")
    render(tool, folder, "--pixel", "24,16", "--outfile", "one.exr")
    has(info(folder, "one.exr"), r"1 x +1,", r"pixel data origin: x=24, y=16")
    oiiotool(folder, "whole.exr", "--cut", "1x1+24+16", "-o", "cut.exr")
    assert pixels(folder, "cut.exr") == pixels(folder,
                                               "one.exr"), "the pixel differs from that of the whole image"


@check
def outfile_chooses_the_format(tool, folder):
    for name, expected in [("a.png", r"uint8 png"), ("a.exr", r"float openexr"), ("a.pfm", r"float pnm"),
                           ("a.tif", r"float tiff"),
                           ("a.jpg", r"uint8 jpeg")]:
        render(tool, folder, "--spp", "1", "--outfile", name)
        has(info(folder, name), "48 x +32", expected)
    assert left(folder) == ["a.exr", "a.jpg", "a.pfm", "a.png", "a.tif"], "wrote %s" % left(folder)


@check
def scene_from_standard_input(tool, folder):
    render(tool, folder, "--outfile", "a.exr", scene=None, stdin=SCENE.encode())
    has(info(folder, "a.exr"), "48 x +32")


@check
def error_in_standard_input_has_its_position(tool, folder):
    result = render(tool, folder, scene=None, stdin=b'WorldBegin\n  Shpae "sphere"\n', status=2)
    has(result.err, r"^<stdin>:2:3: error: unknown directive Shpae")


@check
def gzipped_scene(tool, folder):
    write(folder, "scene.pbrt.gz", gzip.compress(SCENE.encode()))
    render(tool, folder, "scene.pbrt.gz", "--outfile", "zipped.exr", scene=None)
    render(tool, folder, "--outfile", "plain.exr")
    assert pixels(folder, "zipped.exr") == pixels(folder,
                                                  "plain.exr"), "another image than that of the plain text"


@check
def two_scene_files_are_one_scene(tool, folder):
    before, after = SCENE.split("Material", 1)
    write(folder, "one.pbrt", before)
    write(folder, "two.pbrt", "Material" + after)
    render(tool, folder, "one.pbrt", "two.pbrt", "--outfile", "two.exr", scene=None)
    render(tool, folder, "--outfile", "whole.exr")
    assert pixels(folder, "two.exr") == pixels(folder, "whole.exr"), "another image than that of one file"


@check
def statistics_are_json_on_stdout(tool, folder):
    result = render(tool, folder, "--stats-json", "-")
    statistics = json.loads(result.out)
    assert statistics["samples_per_pixel"] == 8 and statistics["complete"] is True, result.out
    assert statistics["rays"]["camera"] == 48 * 32 * 8, result.out
    assert statistics["bad_samples"] == 0 and statistics["memory_bytes"]["peak"] > 0, result.out
    assert {"parse", "build", "render", "write"} <= set(statistics["seconds"]), result.out


@check
def statistics_are_json_in_a_file(tool, folder):
    result = render(tool, folder, "--stats-json", "s.json", "--quiet")
    assert not result.out and not result.err, "output beside the file"
    with open(os.path.join(folder, "s.json")) as f:
        assert json.load(f)["image"] == "scene.exr"


@check
def statistics_for_people(tool, folder):
    result = render(tool, folder, "--stats")
    has(result.err, "samples", "rays")
    assert not result.out, "statistics on stdout"


@check
def extra_outputs_are_channels(tool, folder):
    render(tool, folder, "--aov", "albedo,ng,normal,position,depth,uv,variance,samples")
    text = info(folder)
    has(text, r"20 channel")
    channels = re.search(r"channel list: (.*)", text).group(1)
    for name in "R G B Albedo.R Albedo.B N.X Ns.Z P.Y Z u v Variance.Y samples".split():
        assert name in channels.replace(",", " ").split(), "no channel %s in %s" % (name, channels)
    render(tool, folder, "--outfile", "plain.exr")
    oiiotool(folder, "scene.exr", "--ch", "R,G,B", "-o", "rgb.exr")
    assert pixels(folder, "rgb.exr") == pixels(folder, "plain.exr"), "extra outputs change the image"


@check
def metadata_are_readable(tool, folder):
    render(tool, folder, "--spp", "4", "--seed", "7")
    has(info(folder), r"samplesPerPixel: 4\b", r"seed: 7\b", r"renderTimeSeconds: [0-9.e-]+",
        r"worldToCamera: ", r"worldToNDC: ",
        r'Software: "Lacquer \d', r"chromaticities: 0\.64")


@check
def metadata_of_a_wide_colour_space(tool, folder):
    render(tool, folder, scene='ColorSpace "rec2020"\n' + SCENE)
    has(info(folder), r"chromaticities: 0\.708, 0\.292, 0\.17, 0\.797, 0\.131, 0\.046, 0\.312")


@check
def a_log_file_holds_what_went_wrong(tool, folder):
    result = render(tool, folder, "--log-file", "log", scene=GOOD.replace("Shape", "Shepe", 1), status=2)
    with open(os.path.join(folder, "log"), encoding="utf-8") as f:
        log = f.read()
    assert "error: " in log and "Shepe" in log and "Shepe" in result.err, log


@check
def pixels_do_not_depend_on_threads(tool, folder):
    digests = []
    for threads in ("1", "2", "7"):
        write(folder, "scene.pbrt", SCENE)
        result = tool.run(["scene.pbrt", "--nthreads", threads, "--quiet", "--outfile", "t%s.exr" % threads,
                           "--aov", "variance,depth"], folder)
        assert result.status == 0, result.err
        digests.append(pixels(folder, "t%s.exr" % threads))
    assert digests[0] == digests[1] == digests[2], "the pixels differ: %s" % digests


@check
def pixels_depend_on_the_seed(tool, folder):
    render(tool, folder, "--seed", "1", "--outfile", "a.exr")
    render(tool, folder, "--seed", "2", "--outfile", "b.exr")
    assert pixels(folder, "a.exr") != pixels(folder, "b.exr"), "two seeds, one image"


@check
def sample_ranges_add_up(tool, folder):
    # The mean of two images of floats agrees with the whole to a few units in the last place.
    render(tool, folder, "--outfile", "all.exr")
    render(tool, folder, "--sample-range", "0:4", "--outfile", "a.exr")
    render(tool, folder, "--sample-range", "4:8", "--outfile", "b.exr")
    has(info(folder, "a.exr"), r"samplesPerPixel: 4\b")
    oiiotool(folder, "a.exr", "b.exr", "--add", "--mulc", "0.5", "-o", "mean.exr")
    text = oiiotool(folder, "all.exr", "mean.exr", "--fail", "1e-4", "--warn", "1e-4", "--diff")
    has(text, "PASS")


LONG = SCENE.replace("zsobol", "halton").replace("48", "320").replace('"integer yresolution" 32',
                                                                        '"integer yresolution" 240')


@check
def time_limit_alone_is_success(tool, folder):
    result = render(tool, folder, "--time-limit", "0.5",
                    scene=LONG.replace("pixelsamples\" 8", "pixelsamples\" 1000000"))
    assert result.seconds < 10, "took %.1f s" % result.seconds
    has(info(folder), r"320 x +240", r"samplesPerPixel: \d+")


@check
def time_limit_before_spp_is_status_5(tool, folder):
    result = render(tool, folder, "--time-limit", "0.5", "--spp", "1000000", scene=LONG, status=5)
    has(result.err, "time limit", r"of 1000000 samples")
    has(info(folder), r"320 x +240")


@check
def spp_within_the_time_limit_is_success(tool, folder):
    render(tool, folder, "--time-limit", "100", "--spp", "4")
    has(info(folder), r"samplesPerPixel: 4\b")


def interrupted(tool, folder, number, status, *options):
    result = render(tool, folder, "--spp", "1000000", *options, scene=LONG, status=status,
                    signal_after=(1.5, number))
    assert result.seconds < 10, "took %.1f s" % result.seconds
    has(result.err, "stopped by a signal", "scene.exr holds the image")
    has(info(folder), r"320 x +240", r"samplesPerPixel: \d+")
    statistics = oiiotool(folder, "--stats", "scene.exr")
    has(statistics, r"Stats NanCount: 0 0 0", r"Stats InfCount: 0 0 0")
    assert not re.search(r"Stats Avg: 0\.0+ ", statistics), "the image is black"
    assert left(folder) == ["scene.exr"], "leaves %s" % left(folder)
    return result


@check
def interrupt_leaves_denoising_for_later(tool, folder):
    result = interrupted(tool, folder, signal.SIGINT, 130, "--denoise")
    has(result.err, "not denoised, since a signal came")
    has(info(folder), r"Half\.R", r"Albedo\.R")


@check
def interrupt_writes_the_image(tool, folder):
    interrupted(tool, folder, signal.SIGINT, 130)


@check
def termination_writes_the_image(tool, folder):
    interrupted(tool, folder, signal.SIGTERM, 143)


@check
def broken_scene_keeps_the_old_image(tool, folder):
    render(tool, folder)
    with open(os.path.join(folder, "scene.exr"), "rb") as f:
        before = f.read()
    render(tool, folder, scene=SCENE + 'Shape "sphere" "float raduis" 1\n', status=2)
    render(tool, folder, scene=SCENE + 'Shape "plymesh" "string filename" "no.ply"\n', status=3)
    with open(os.path.join(folder, "scene.exr"), "rb") as f:
        assert f.read() == before, "the old image was changed"


@check
def quiet_says_nothing(tool, folder):
    result = render(tool, folder, "--quiet", scene=SCENE + "TransformBegin TransformEnd\n")
    assert not result.err and not result.out, "says %r" % (result.err or result.out)


@check
def warnings_have_positions(tool, folder):
    result = render(tool, folder, scene=SCENE + "  TransformBegin\nTransformEnd\n")
    has(result.err, r"scene\.pbrt:13:3: warning: TransformBegin")
    assert result.err.count("warning:") == 1, "more than one warning: " + result.err


@check
def no_terminal_codes_in_a_file(tool, folder):
    # health() looks for them; the end of the render is told in one line.
    result = render(tool, folder, env={"TERM": "xterm-256color"})
    assert "\r" not in result.err and len(result.err.splitlines()) == 1, "says %r" % result.err
    has(result.err, r"scene\.exr: 48 x 32 pixels, 8 samples each")


@check
def partial_images_are_written(tool, folder):
    write(folder, "scene.pbrt", LONG)
    result = tool.run(["scene.pbrt", "--spp", "1000000", "--nthreads", "2", "--write-partial-images",
                       "--resolution", "64x48"], folder,
                      signal_after=(2.0, signal.SIGKILL))
    assert result.status == -signal.SIGKILL, "exit status %d" % result.status
    assert os.path.exists(os.path.join(folder, "scene.exr")), "no image while it renders"
    has(info(folder), r"64 x +48", r"samplesPerPixel: \d+")


@check
def errors_against_a_reference_are_listed(tool, folder):
    render(tool, folder, "--spp", "64", "--seed", "9", "--outfile", "ref.exr")
    render(tool, folder, "--spp", "16", "--mse-reference-image", "ref.exr", "--mse-reference-out", "mse.txt")
    with open(os.path.join(folder, "mse.txt")) as f:
        rows = [tuple(map(float, line.split(","))) for line in f]
    assert [r[0] for r in rows] == [8, 16], "rows %s" % rows
    assert rows[0][1] > rows[1][1] > 0, "the error does not fall: %s" % rows


@check
def a_scene_without_light_is_a_warning(tool, folder):
    result = render(tool, folder, scene=SMALL + 'WorldBegin\nShape "sphere"\n')
    has(result.err, "warning: the scene has no light")


@check
def an_empty_world_renders(tool, folder):
    render(tool, folder, scene=world(""))


@check
def long_valid_numbers_render(tool, folder):
    zeros = "0" * 1000000
    text = 'Shape "sphere" "float radius" 1.%s\nTranslate 0.%s1 0 0\nShape "sphere"' % (zeros, zeros)
    render(tool, folder, scene=world(text))


@check
def many_scopes_render(tool, folder):
    render(tool, folder, scene=world("AttributeBegin Translate 1 0 0 AttributeEnd\n" * 300000))


def layered(slab, coat):
    return ('Texture "steep" "float" "checkerboard" "float tex1" -1e30 "float tex2" 1e30\n'
            'MakeNamedMaterial "a" "string type" "slab" MakeNamedMaterial "b" "string type" "slab"\n'
            'MakeNamedMaterial "coat" "string type" "dielectric" %s\n'
            'MakeNamedMaterial "matter" "string type" "slab" %s\n'
            'Material "layered" "string stack" ["coat" "matter" "coat"] Shape "sphere"\n' % (coat, slab))


ODD = [
    'Transform [1e30 0 0 0  0 1e30 0 0  0 0 1e30 0  0 0 0 1e-30] Shape "sphere"',
    'ConcatTransform [1 0 0 0  0 1 0 1  0 0 1 0  0 0 0 1] Shape "sphere"',
    'Scale 1e-15 1 1e15 Shape "sphere"',
    'Shape "sphere" "float radius" 1e-30',
    'Shape "sphere" "float radius" 1e30',
    'Shape "disk" "float height" 1e38',
    'Shape "trianglemesh" "point3 P" [0 0 0 0 0 0 0 0 0]',
    'Shape "trianglemesh" "point3 P" [-1 -1 2 1 -1 2 0 1 2] "normal N" [0 0 0 0 0 0 0 0 0]',
    'LightSource "infinite" "rgb L" [1e38 1e38 1e38] Shape "sphere"',
    'LightSource "point" "rgb I" [1e30 1e30 1e30] Shape "sphere"',
    'LightSource "spot" "float coneangle" 1e-30 Shape "sphere"',
    'Material "dielectric" "float eta" 1e30 Shape "sphere"',
    'Material "conductor" "float roughness" 1e30 Shape "sphere"',
    'Material "conductor" "float roughness" -1e30 Shape "sphere"',
    'ObjectBegin "a" Shape "sphere" ObjectEnd Scale 1e-25 1e-25 1e-25 ObjectInstance "a"',
    'ObjectBegin "a" Shape "sphere" ObjectEnd\n'
    'ActiveTransform EndTime Scale 1e-25 1e-25 1e-25 ObjectInstance "a"',
    'Texture "f" "float" "fbm" "integer octaves" 2000000000\n'
    'Material "diffuse" "texture displacement" "f" Shape "sphere"',
    'Material "coateddiffuse" "float thickness" 1e38 "float g" -1e30 "rgb albedo" [1 1 1] Shape "sphere"',
    'Material "coateddiffuse" "float thickness" -1e38 "float eta" 1e30 "integer maxdepth" 2147483647\n'
    'Shape "sphere"',
    'Material "coatedconductor" "float interface.eta" 1e-30 "float interface.roughness" 1e30 Shape "sphere"',
] + [layered(slab, coat) for slab, coat in [
    ('"rgb sigma_t" [1e38 1e38 1e38] "float thickness" 1e38', ""),
    ('"rgb sigma_t" [1e-38 1 1e38] "rgb albedo" [1 1 1]', '"float rotation" 1e30'),
    ('"rgb sigma_t" [9 9 9] "rgb albedo" [1 1 1] "string phase" "vmf" "float kappa" 1e38', ""),
    ('"rgb sigma_t" [9 9 9] "rgb albedo" [1 1 1] "string phase" "hg" "float g" 1', '"float roughness" 1e30'),
    ('"rgb sigma_t" [1 1 1] "rgb albedo" [1 1 1] "string phase" "table" "float table" [0 3e38 3e38]', ""),
    ('"rgb sigma_t" [1 1 1] "rgb albedo" [1 1 1] "string phase" "mixture" "string phases" ["a" "b"]\n'
     '"float weights" [3e38 3e38]', ""),
    ('"rgb sigma_t" [1 1 1] "rgb albedo" [1 1 1] "string phase" "fibre" "float stddev" 1e-38\n'
     '"vector3 orientation" [1e38 -1e38 1e38] "float rotation" 1e38', ""),
    ('"rgb sigma_t" [1 1 1] "rgb albedo" [1 1 1] "string phase" "sggx" "float roughness" 0\n'
     '"vector3 orientation" [1e-38 0 0]', '"texture displacement" "steep"'),
    ('"float eta" 1e30', '"float uroughness" 1e-30 "float vroughness" 1'),
]]

THIN = 'MakeNamedMedium "m" "string type" "homogeneous" %s MediumInterface "m" Camera "perspective"'
ODD_CAMERAS = [
    # Thin media without walls: light scatters, if at all, where floats end.
    THIN % '"rgb sigma_a" [0 0 0] "rgb sigma_s" [1e-38 1e-38 1e-38]',
    THIN % '"rgb sigma_a" [1e-38 1e-38 1e-38] "rgb sigma_s" [2e-38 1e-38 0] "rgb Le" [1 1 1]',
    THIN % '"rgb sigma_a" [1e-30 1e-25 1e-20] "rgb sigma_s" [1e-20 1e-25 1e-30]',
    THIN % '"rgb sigma_a" [1e-38 1e-38 1e-38] "rgb sigma_s" [0 0 0] "rgb Le" [1 1 1]',
    'Camera "perspective" "float lensradius" 3.4e38',
    'Camera "perspective" "float fov" 1e-30',
    'Camera "orthographic" "float screenwindow" [-1 1 3.4e38 1]',
    'Translate 1e30 0 0 Camera "perspective"',
]


@check
def odd_numbers_give_finite_pixels(tool, folder):
    sun = 'LightSource "distant"'
    for scene in [world(text) for text in ODD] + [options(text) + sun for text in ODD_CAMERAS]:
        render(tool, folder, "--quiet", "--outfile", "odd.exr", scene=scene)
        has(oiiotool(folder, "--stats", "odd.exr"), r"Stats NanCount: 0 0 0", r"Stats InfCount: 0 0 0")


@check
def pixel_stats_are_an_image_beside_the_image(tool, folder):
    render(tool, folder, "--quiet", "--cropwindow", "0,.5,0,1", "--outfile", "plain.exr")
    assert left(folder) == ["plain.exr"]
    for args, scene in (["--pixelstats"], SCENE), ([], 'Option "pixelstats" true\n' + SCENE):
        render(tool, folder, "--quiet", "--cropwindow", "0,.5,0,1", "--outfile", "a.b.exr", *args, scene=scene)
        assert left(folder) == ["a.b-pixelstats.exr", "a.b.exr", "plain.exr"]
        assert pixels(folder, "a.b.exr") == pixels(folder, "plain.exr"), "the image changes"
        header = json.loads(tool.run(["info", "--json", "a.b-pixelstats.exr"], folder).out)[0]
        channels = {c["name"]: c for c in header["channels"]}
        assert sorted(channels) == ["rays", "shadowrays", "time", "vertices"], channels
        has(info(folder, "a.b-pixelstats.exr"), "24 x   32", "display size: 48 x 32")
        os.remove(os.path.join(folder, "a.b-pixelstats.exr"))


@check
def surfaces_can_be_forced_to_be_diffuse(tool, folder):
    render(tool, folder, "--quiet")
    shiny = pixels(folder)
    render(tool, folder, "--quiet", "--force-diffuse")
    matte = pixels(folder)
    render(tool, folder, "--quiet", scene='Option "forcediffuse" true\n' + SCENE)
    assert matte == pixels(folder) and matte != shiny
    render(tool, folder, "--quiet", "--force-diffuse", scene='Option "forcediffuse" false\n' + SCENE)
    assert pixels(folder) == shiny, "the file does not win over the command line"
