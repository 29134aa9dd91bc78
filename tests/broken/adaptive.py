"""render --adaptive and --noise-target: the command line, parts and states."""
import json
import os

from command_line import LONG, SCENE, has, left, oiiotool, pixels, render, usage
from run import Case

BDPT = SCENE.replace("WorldBegin", 'Integrator "bdpt"\nWorldBegin')
MLT = SCENE.replace("WorldBegin", 'Integrator "mlt"\nWorldBegin')
SPPM = SCENE.replace("WorldBegin", 'Integrator "sppm"\nWorldBegin')
CASES = [
    usage("noise-target-zero", ["--noise-target", "0"], ["--noise-target", '"0"', "0.5%"]),
    usage("noise-target-whole", ["--noise-target", "100%"], ["--noise-target", '"100%"', "below 1"]),
    usage("noise-target-words", ["--noise-target", "low"], ["--noise-target", '"low"']),
    usage("noise-target-unit", ["--noise-target", "5 dB"], ["--noise-target", '"5 dB"']),
    usage("noise-target-range", ["--noise-target", "1%", "--sample-range", "0:1"], ["--noise-target", "--sample-range"]),
    Case("adaptive-bdpt", BDPT, ["--adaptive", "light from the lights", '"volpath"'], 1, ["--adaptive"]),
    Case("adaptive-mlt", MLT, ["--adaptive", "light from the lights"], 1, ["--adaptive"]),
    Case("sample-range-mlt", MLT, ["--sample-range", "Markov chains", '"bdpt"'], 1, ["--sample-range", "0:1"]),
    Case("checkpoint-mlt", MLT, ["--checkpoint", "Markov chains"], 1, ["--checkpoint", "a.state"]),
    Case("pixelstats-mlt", MLT, ["--pixelstats", "Markov chains"], 1, ["--pixelstats"]),
    Case("half-mlt", MLT, ['"half"', '"path"'], 1, ["--aov", "half"]),
    Case("passes-mlt", MLT, ["passes", '"volpath"'], 1, ["--aov", "direct"]),
    Case("denoise-mlt", MLT, ["--denoise", "traced from the lights"], 1, ["--denoise"]),
    Case("noise-target-bdpt", BDPT, ["--noise-target", "light from the lights"], 1, ["--noise-target", "1%"]),
    Case("adaptive-sppm", SPPM, ["--adaptive", "photons that all pixels share", '"volpath"'], 1, ["--adaptive"]),
    Case("noise-target-sppm", SPPM, ["--noise-target", "photons"], 1, ["--noise-target", "1%"]),
]

CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


@check
def adaptive_samples_are_as_many_on_average(tool, folder):
    result = render(tool, folder, "--adaptive", "--spp", "64", "--stats-json", "s.json", "--nthreads", "1")
    has(result.err, r"samples on average \(\d+ to \d+\)", "pilot samples")
    with open(os.path.join(folder, "s.json"), encoding="utf-8") as file:
        stats = json.load(file)
    assert 60 < stats["samples"]["mean"] <= 64, stats["samples"]
    assert stats["samples_per_pixel"] == 64 and stats["complete"] and stats["seconds"]["pilots"] > 0
    render(tool, folder, "--adaptive", "--spp", "64", "--nthreads", "2", "--outfile", "two.exr")
    assert pixels(folder) == pixels(folder, "two.exr")
    render(tool, folder, "--spp", "64", "--outfile", "even.exr")
    assert pixels(folder) != pixels(folder, "even.exr")


@check
def adaptive_is_no_other_render_where_noise_is_even(tool, folder):
    # A wall that fills the image; by zsobol, whose points depend on how many a pixel may get.
    scene = SCENE[:SCENE.index("LightSource")] + 'LightSource "infinite"\nShape "disk" "float radius" 1000 "float height" 9\n'
    result = render(tool, folder, "--adaptive", "--spp", "64", scene=scene)
    has(result.err, "every pixel gets the same number of samples")
    oiiotool(folder, "scene.exr", "--ch", "R,G,B", "-o", "colours.exr")
    render(tool, folder, "--spp", "64", "--outfile", "even.exr", scene=scene)
    assert pixels(folder, "colours.exr") == pixels(folder, "even.exr")


@check
def adaptive_parts_are_one_render(tool, folder):
    options = ["--adaptive", "--spp", "48", "--aov", "half,depth,variance"]
    scene = SCENE.replace("zsobol", "sobol")
    render(tool, folder, *options, scene=scene)
    for name, samples in (("a", "0:5"), ("b", "5:30"), ("c", "30:48")):
        render(tool, folder, *options, "--sample-range", samples, "--checkpoint", name + ".state", "--outfile", name + ".exr", scene=scene)
    result = tool.run(["merge", "c.state", "a.state", "b.state", "--outfile", "merged.exr"], folder)
    assert result.status == 0, result.err
    assert pixels(folder) == pixels(folder, "merged.exr")
    result = tool.run(["merge", "a.state", "c.state", "--outfile", "part.exr"], folder)
    assert result.status == 3, result.err
    has(result.err, "samples 5 to 29 of all pixels are missing")


@check
def adaptive_renders_are_resumed(tool, folder):
    scene = SCENE.replace("zsobol", "independent")
    render(tool, folder, "--adaptive", "--spp", "16", "--checkpoint", "a.state", scene=scene)
    render(tool, folder, "--adaptive", "--spp", "16", "--resume", "a.state", "--outfile", "again.exr", scene=scene)
    assert pixels(folder) == pixels(folder, "again.exr")
    has(render(tool, folder, "--spp", "16", "--resume", "a.state", scene=scene, status=3).err, "another render.*adaptive")
    # More samples, for which a render from the start would take more pilots, are divided as the first render had it.
    render(tool, folder, "--adaptive", "--spp", "160", "--resume", "a.state", "--outfile", "more.exr", "--stats-json", "s.json", scene=scene)
    with open(os.path.join(folder, "s.json"), encoding="utf-8") as file:
        assert 150 < json.load(file)["samples"]["mean"] <= 160
    assert pixels(folder, "more.exr") != pixels(folder)


@check
def crops_of_adaptive_renders_are_not_merged(tool, folder):
    for name, crop in (("a", "0,1,0,.5"), ("b", "0,1,.5,1")):
        render(tool, folder, "--adaptive", "--cropwindow", crop, "--checkpoint", name + ".state", "--outfile", name + ".exr")
    result = tool.run(["merge", "a.state", "b.state", "--outfile", "merged.exr"], folder)
    assert result.status == 3, result.err
    has(result.err, "each crop by itself", "--sample-range")
    assert "merged.exr" not in left(folder)


@check
def a_noise_target_stops_the_render(tool, folder):
    spent = []
    for target in ("20%", "0.05"):
        result = render(tool, folder, "--noise-target", target, "--spp", "4096", "--stats-json", "s.json")
        has(result.err, r"relative error of 95 % of the pixels is [\d.]+ %")
        with open(os.path.join(folder, "s.json"), encoding="utf-8") as file:
            stats = json.load(file)
        assert stats["complete"] and stats["noise"] <= (0.2 if "%" in target else float(target)), stats
        spent.append(stats["samples_per_pixel"])
    assert spent[0] < spent[1] < 4096, spent
    # No channels are left of what the noise was measured by.
    assert b"Half" not in tool.run(["info", "scene.exr"], folder).out


@check
def a_noise_target_that_is_not_reached_is_told(tool, folder):
    result = render(tool, folder, "--noise-target", "0.1%", "--spp", "16")
    has(result.err, "warning.*relative error of 95 % of the pixels is .* after 16 samples per pixel, above the target of 0.1 %", "--spp allows more")


@check
def a_noise_target_is_resumed(tool, folder):
    scene = LONG.replace("320", "64")
    options = ["--noise-target", "3%", "--spp", "4096", "--adaptive"]
    render(tool, folder, *options, "--outfile", "whole.exr", scene=scene)
    render(tool, folder, *options, "--time-limit", "0.1", "--checkpoint", "a.state", "--outfile", "part.exr", scene=scene, status=5)
    render(tool, folder, *options, "--resume", "a.state", scene=scene)
    assert pixels(folder) == pixels(folder, "whole.exr")
