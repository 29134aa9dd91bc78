"""lacquer compare: wrong command lines, stops, and what a run leaves behind."""
import json
import os
import signal

from run import Case, health
from command_line import has, oiiotool, write

BALL = """# box ball 0.2 0.8 0.25 0.75
# box of no use
LookAt 0 -4 0  0 0 0  0 0 1
Camera "perspective" "float fov" 32
Film "rgb" "integer xresolution" 32 "integer yresolution" 24
Sampler "zsobol" "integer pixelsamples" 8
Integrator "path" "integer maxdepth" 2
WorldBegin
LightSource "distant" "point3 from" [-1 -2 2] "point3 to" [0 0 0]
LightSource "infinite" "rgb L" [0.2 0.2 0.2]
MakeNamedMaterial "top" "string type" "dielectric" "float roughness" 0.3 "bool remaproughness" false
MakeNamedMaterial "clear" "string type" "slab" "float eta" 1.5
MakeNamedMaterial "bottom" "string type" "conductor" "float roughness" 0.2 "bool remaproughness" false
MakeNamedMaterial "coated" "string type" "layered" "string stack" ["top" "clear" "bottom"]
NamedMaterial "coated"
Shape "sphere"
"""


FOG = BALL.replace('Integrator "path"', 'Integrator "volpath"') + """MakeNamedMedium "fog" "string type" "homogeneous"
MediumInterface "fog" ""
Material "interface"
Shape "sphere" "float radius" 2
"""


def wrong(name, args, says, status=1, scene=BALL, files=None, **more):
    return Case("compare-" + name, None, says, status, ["compare", "scene.pbrt"] + args,
                dict({"scene.pbrt": scene, "file": "kept"}, **(files or {})), **more)


def out(*args):
    return list(args) + ["--out", "o"]


CASES = [
    wrong("no-folder", [], ["--out"]),
    wrong("estimator", out("--estimators", "bidirectional,halfvectr"), ["--estimators", '"halfvectr"', '"halfvector"?']),
    wrong("pdf", out("--estimators", "bidirectional/gausian"), ["--estimators", '"gausian"', '"gaussian"?']),
    wrong("integrator", out("--integrators", "path,bdtp"), ["--integrators", '"bdtp"', '"bdpt"?']),
    wrong("integrator-twice", out("--integrators", "path,path"), ["--integrators", "each integrator once"]),
    wrong("integrator-of-pbrt", out("--integrators", "path,function"), ["--integrators", '"function" is not in Lacquer']),
    wrong("integrator-blurred", out("--integrators", "path,sppm"), ["--integrators", '"sppm" blurs light']),
    wrong("integrator-no-light", out("--integrators", "ambientocclusion"), ["--integrators", "not its light"]),
    wrong("integrator-delta-light", out("--integrators", "path,randomwalk"),
          ["--integrators", '"randomwalk"', "never finds the light of a point"]),
    wrong("integrator-surfaces", out("--integrators", "path,simplevolpath"),
          ["--integrators", '"simplevolpath"', "cannot render this scene"]),
    wrong("integrator-media", out("--integrators", "volpath,path"), ["--integrators", '"path"', "media", "vacuum"],
          scene=FOG),
    wrong("integrator-film", out("--integrators", "path,bdpt"), ["--integrators", '"bdpt"', '"rgb" film can'],
          scene=BALL.replace('Film "rgb"', 'Film "spectral"')),
    wrong("integrator-camera", out("--integrators", "path,lightpath"), ["--integrators", '"lightpath"', "perspective"],
          scene=BALL.replace('"perspective" "float fov" 32', '"spherical"')),
    wrong("sampler", out("--samplers", "zsobol,halten"), ["--samplers", '"halten"', '"halton"?']),
    wrong("sampler-pdf", out("--samplers", "zsobol/gaussian"), ["--samplers", '"zsobol/gaussian"']),
    wrong("light-sampler", out("--light-samplers", "bvh,pover"), ["--light-samplers", '"pover"', '"power"?']),
    wrong("light-sampler-of-none", out("--light-samplers", "bvh,power"),
          ["--light-samplers", '"bdpt" of the scene has no light sampler'],
          scene=BALL.replace('Integrator "path"', 'Integrator "bdpt"')),
    wrong("denoiser", out("--denoisers", "none,nfro"), ["--denoisers", '"nfro"', '"nfor"?']),
    wrong("denoiser-twice", out("--denoisers", "nfor,nfor"), ["--denoisers", "each denoiser once"]),
    wrong("denoiser-splats", out("--denoisers", "none,nfor"), ["--denoisers", '"nfor"', "traced from the lights"],
          scene=BALL.replace('Integrator "path"', 'Integrator "bdpt"')),
    wrong("denoiser-one-sample", out("--denoisers", "none,nfor", "--equal-samples", "1"),
          ["--denoisers", '"nfor"', "one sample in each pixel"]),
    wrong("denoiser-time", out("--denoisers", "none,nfor", "--time", "0.0001"), ["--time", '"nfor"', "alone takes"]),
    wrong("denoiser-reference-by", out("--denoisers", "none,nfor", "--reference-by", "nfor"),
          ["--reference-by", "never denoised"]),
    wrong("denoiser-reference", out("--denoisers", "nfor", "--reference", "none.exr"), ["--reference", '"none"']),
    wrong("vary-resolution", out("--vary", "film.integer xresolution=16,20"), ["--vary", "same pixels"]),
    wrong("vary-part", out("--vary", "camrea.fov=30"), ["--vary", '"camrea"', '"camera"?']),
    wrong("two-kinds", out("--samplers", "zsobol", "--integrators", "path"), ["--samplers", "--integrators"]),
    wrong("two-kinds-estimators", out("--estimators", "auto", "--light-samplers", "bvh"),
          ["--estimators", "--light-samplers"]),
    wrong("integrator-baseline", out("--integrators", "path,bdpt", "--baseline", "pth"), ["--baseline", '"path"?']),
    wrong("reference-by", out("--integrators", "path,bdpt", "--reference-by", "volpth"),
          ["--reference-by", '"volpath"?']),
    wrong("reference-by-estimator", out("--reference-estimator", "halfvectr"), ["--reference-by", '"halfvector"?']),
    wrong("reference-by-media", out("--integrators", "volpath", "--reference-by", "path"),
          ["--reference-by", '"path"', "vacuum"], scene=FOG),
    wrong("estimator-twice", out("--estimators", "auto,auto"), ["--estimators", "once"]),
    wrong("baseline", out("--estimators", "auto", "--baseline", "forward"), ["--baseline", '"forward"', "auto"]),
    wrong("time", out("--time", "-1"), ["--time", "positive"]),
    wrong("time-nan", out("--time", "nan"), ["--time", "finite"]),
    wrong("time-and-samples", out("--time", "1", "--equal-samples", "4"), ["--time", "--equal-samples"]),
    wrong("samples", out("--equal-samples", "0"), ["--equal-samples"]),
    wrong("samples-that-differ", out("--samplers", "independent,zsobol", "--equal-samples", "15"),
          ["--equal-samples", "independent takes 15", "zsobol takes 8"]),
    wrong("runs", out("--runs", "0"), ["--runs"]),
    wrong("option", out("--estimater", "auto"), ["--estimater", '"--estimators"?']),
    wrong("box", out("--box", "eye:1,2,3"), ["--box", '"eye:1,2,3"']),
    wrong("box-outside", out("--box", "eye:40,50,3,9"), ["--box", '"eye:40,50,3,9"']),
    wrong("box-twice", out("--box", "eye:1,5,3,9", "--box", "eye:2,5,3,9"), ["--box", "once"]),
    wrong("resolution", out("--resolution", "12"), ["--resolution", "WIDTHxHEIGHT"]),
    wrong("vary", out("--vary", "top"), ["--vary", "MATERIAL.PARAMETER=VALUE"]),
    wrong("vary-material", out("--vary", "topp.roughness=.1"), ["--vary", '"topp"', '"top"?']),
    wrong("vary-value", out("--vary", "top.roughness=.1,rough"), ["--vary", '"rough"', "number"]),
    wrong("vary-parameter", out("--vary", "top.rougness=.1"), ["rougness", '"roughness"?'], 2),
    wrong("reference-missing", out("--reference", "none.exr", "--equal-samples", "1"), ["none.exr", "no such file"], 3),
    wrong("reference-and-spp", out("--reference", "none.exr", "--reference-spp", "64"), ["--reference-spp", "--reference"]),
    wrong("reference-and-by", out("--reference", "none.exr", "--reference-by", "bidirectional"), ["--reference-by", "--reference"]),
    wrong("reference-and-vary", out("--reference", "none.exr", "--vary", "top.roughness=.1"), ["--vary", "--reference"]),
    wrong("out-is-a-file", ["--out", "file"], ["file: is no folder"], 3),
    wrong("out-too-deep", ["--out", "a/b"], ["a/b", "cannot be made"], 3),
    wrong("scene", out(), ["sphere"], 2, scene=BALL.replace('"sphere"', '"spere"')),
    wrong("no-scene", out(), ["scene.pbrt", "No such file"], 3, files={"scene.pbrt": None}, prepare=lambda f: os.rmdir(
        os.path.join(f, "scene.pbrt"))),
]

CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


def compare(tool, folder, *args, scene=BALL, status=0, **more):
    write(folder, "scene.pbrt", scene)
    result = tool.run(("compare", "scene.pbrt", "--nthreads", "2", "--out", "o") + args, folder, **more)
    problems = health(result)
    assert not problems, "; ".join(problems) + ": " + result.err
    assert result.status == status, "exit status %d, not %d: %s" % (result.status, status, result.err.strip())
    return result


def results(folder):
    with open(os.path.join(folder, "o", "results.json"), encoding="utf-8") as f:
        return json.load(f)


SMALL = ("--equal-samples", "2", "--runs", "2", "--reference-spp", "16", "--estimators", "bidirectional,auto")


@check
def compare_judges_the_denoiser(tool, folder):
    result = compare(tool, folder, "--denoisers", "none,nfor", "--equal-samples", "4", "--runs", "2", "--reference-spp",
                     "256", scene=BALL.replace("zsobol", "independent"))
    has(result.out.decode(), "FLIP", "systematic", "nfor")
    r = results(folder)
    plain, denoised = (e["boxes"][0] for e in r["variants"][0]["estimators"])
    assert r["compared"] == "denoiser"
    assert [e["approximate"] for e in r["variants"][0]["estimators"]] == [False, True]
    assert denoised["bias"] is None and plain["bias"] is not None
    assert denoised["systematic_share"] > plain["systematic_share"] and 0 < denoised["flip"] < 1
    assert all(run["denoise_seconds"] > 0 for run in r["variants"][0]["estimators"][1]["runs"])


@check
def compare_leaves_what_its_documents_say(tool, folder):
    result = compare(tool, folder, *SMALL)
    has(result.out.decode(), "ball", "bidirectional", "auto", "RMSE reduction")
    assert sorted(os.listdir(os.path.join(folder, "o"))) == ["crops", "images", "report.html", "results.json"]
    r = results(folder)
    assert r["schema"] == "lacquer-compare-1" and r["complete"] and r["runs"] == 2
    assert r["boxes"] == [{"name": "ball", "pixels": [6, 26, 6, 18]}], r["boxes"]
    entries = r["variants"][0]["estimators"]
    assert [e["name"] for e in entries] == ["bidirectional", "auto"]
    assert len({run["seed"] for e in entries for run in e["runs"]}) == 4, "runs share seeds"
    for e in entries:
        for name in e["images"].values():
            assert os.path.exists(os.path.join(folder, "o", name)), name
        assert e["boxes"][0]["convergence"][-1]["rmse"] == e["boxes"][0]["rmse_corrected"]
    assert "--equal-samples 2" in r["command"]
    assert sorted(os.listdir(os.path.join(folder, "o", "crops"))) == [
        "ball-auto-error.png", "ball-auto.png", "ball-bidirectional-error.png", "ball-bidirectional.png",
        "ball-reference.png"]
    has(oiiotool(folder, "--info", "-v", "o/images/reference.exr"), "MeanVariance.Y", "samplesPerPixel: 16")
    with open(os.path.join(folder, "o", "report.html"), encoding="utf-8") as f:
        page = f.read()
    assert "<html" in page and "chart" in page.lower() and "src=\"http" not in page


@check
def compare_overwrites_no_reference_that_is_given(tool, folder):
    compare(tool, folder, *SMALL)
    images = os.path.join(folder, "o/images")
    run = sorted(name for name in os.listdir(images) if "run1.exr" in name)[0]
    with open(os.path.join(images, run), "rb") as f:
        before = f.read()
    result = compare(tool, folder, "--equal-samples", "2", "--reference", "o/images/" + run, status=1)
    has(result.err, "made anew", "--out")
    with open(os.path.join(images, run), "rb") as f:
        assert f.read() == before


@check
def compare_keeps_its_reference_until_the_scene_changes(tool, folder):
    first = compare(tool, folder, *SMALL)
    assert "kept" not in first.err
    time = os.stat(os.path.join(folder, "o/images/reference.exr")).st_mtime_ns
    second = compare(tool, folder, *SMALL)
    has(second.err, "reference.exr: kept")
    assert os.stat(os.path.join(folder, "o/images/reference.exr")).st_mtime_ns == time
    third = compare(tool, folder, *SMALL, scene=BALL.replace("roughness\" 0.3", "roughness\" 0.4"))
    assert "kept" not in third.err, third.err
    assert "kept" not in compare(tool, folder, *(SMALL + ("--reference-spp", "24")),
                                 scene=BALL.replace("roughness\" 0.3", "roughness\" 0.4")).err


@check
def compare_says_who_is_best_or_that_nobody_is(tool, folder):
    # The same estimator by two names of its density: which draws differ, what they find does not.
    result = compare(tool, folder, "--equal-samples", "4", "--runs", "4", "--reference-spp", "64", "--estimators",
                     "forward,bidirectional")
    box = [e["boxes"][0] for e in results(folder)["variants"][0]["estimators"]]
    assert [b["verdict"] for b in box].count("best") == 1, box
    for b in box:
        assert b["rmse_over_best"]["value"] >= 1 and 0 <= b["p_equal"] <= 1, b
        assert b["verdict"] == ("best" if b["rmse_over_best"]["value"] == 1 else
                                "worse" if b["p_equal"] < 0.05 else "indistinguishable"), b
    text = result.out.decode()
    has(text, "are indistinguishable|has the least error")


@check
def compare_removes_what_an_earlier_run_left(tool, folder):
    compare(tool, folder, *SMALL, "--vary", "top.roughness=0.1,0.3", "--box", "eye:8,16,8,16")
    for name in ("mine.png", "images/mine.exr", "crops/ball-mine.png"):
        write(os.path.join(folder, "o"), name, b"kept")
    listed = results(folder)["files"]
    assert len(listed) == len(set(listed)) == 2 * (1 + 2 * 3 + 5), listed
    for name in listed:
        assert os.path.exists(os.path.join(folder, "o", name)), name
    compare(tool, folder, "--equal-samples", "2", "--runs", "1", "--reference-spp", "16", "--estimators", "auto")
    files = {os.path.relpath(os.path.join(top, f), os.path.join(folder, "o"))
             for top, _, names in os.walk(os.path.join(folder, "o")) for f in names}
    assert files == set(results(folder)["files"]) | {"report.html", "results.json", "mine.png", "images/mine.exr",
                                                     "crops/ball-mine.png"}, sorted(files)
    # A list that was tampered with leads nowhere else.
    path = os.path.join(folder, "o", "results.json")
    r = results(folder)
    r["files"] += ["../scene.pbrt", "images/../mine.png", "/etc/passwd", "mine.png", 7, "images/.."]
    with open(path, "w", encoding="utf-8") as f:
        json.dump(r, f)
    compare(tool, folder, "--equal-samples", "2", "--runs", "1", "--reference-spp", "16", "--estimators", "auto")
    for name in ("../scene.pbrt", "mine.png", "images/mine.exr"):
        assert os.path.exists(os.path.join(folder, "o", name)), name


@check
def compare_stops_at_counts_that_are_good_for_the_sampler(tool, folder):
    # About two milliseconds a sample: some tens of samples at most.
    result = compare(tool, folder, "--time", "0.02", "--runs", "3", "--reference-spp", "16", "--estimators",
                     "bidirectional,auto")
    for e in results(folder)["variants"][0]["estimators"]:
        for run in e["runs"]:
            if run["samples_least"] < 64:
                assert run["samples_least"] == run["samples_most"], run
                assert run["samples_least"] in (1, 2, 4, 8, 12, 16, 24, 32, 48), run
        if e["seconds"] < 0.018 and e["samples_per_pixel"] < 60:
            has(result.err, 'good for the sampler "zsobol"')


@check
def compare_takes_an_image_as_reference(tool, folder):
    compare(tool, folder, *SMALL)
    os.rename(os.path.join(folder, "o/images/reference.exr"), os.path.join(folder, "r.exr"))
    compare(tool, folder, "--equal-samples", "2", "--runs", "2", "--estimators", "auto", "--reference", "r.exr")
    assert results(folder)["variants"][0]["reference"]["source"] == "file"
    assert results(folder)["variants"][0]["reference"]["noise"] == "measured"
    oiiotool(folder, "r.exr", "--ch", "R,G,B", "-o", "plain.exr")
    compare(tool, folder, "--equal-samples", "2", "--runs", "2", "--estimators", "auto", "--reference", "plain.exr")
    assert results(folder)["variants"][0]["reference"]["noise"] == "estimated"
    oiiotool(folder, "plain.exr", "--resize", "8x8", "-o", "small.exr")
    failed = compare(tool, folder, "--equal-samples", "2", "--estimators", "auto", "--reference", "small.exr", status=3)
    has(failed.err, "small.exr", "8 x 8", "32 x 24")


@check
def compare_varies_a_parameter(tool, folder):
    compare(tool, folder, *SMALL, "--vary", "top.roughness=0.1,0.3")
    variants = results(folder)["variants"]
    assert [v["label"] for v in variants] == ["top.roughness = 0.1", "top.roughness = 0.3"]
    a, b = (v["estimators"][0]["boxes"][0]["rmse"]["value"] for v in variants)
    assert a != b
    assert {"v1-reference.exr", "v2-reference.exr"} <= set(os.listdir(os.path.join(folder, "o", "images")))


@check
def compare_stopped_early_has_no_report(tool, folder):
    result = compare(tool, folder, "--time", "30", status=130, signal_after=(tool.moment(1), signal.SIGINT))
    has(result.err, "stopped by a signal", "no report")
    assert not os.path.exists(os.path.join(folder, "o", "report.html"))


@check
def compare_stopped_later_keeps_what_is_finished(tool, folder):
    result = compare(tool, folder, "--time", "0.3", "--runs", "20", "--reference-spp", "16", "--estimators",
                     "bidirectional,auto", status=143, signal_after=(tool.moment(2.5), signal.SIGTERM))
    has(result.err, "stopped by a signal", "what was finished")
    r = results(folder)
    assert not r["complete"]
    counts = [len(e["runs"]) for e in r["variants"][0]["estimators"]]
    assert counts[0] == counts[1] and 1 <= counts[0] < 20, counts


@check
def compare_spends_the_time_it_was_given(tool, folder):
    compare(tool, folder, "--time", "0.5", "--runs", "1", "--reference-spp", "16", "--estimators", "auto")
    run = results(folder)["variants"][0]["estimators"][0]["runs"][0]
    assert abs(run["seconds"] - 0.5) < 0.2, run
    assert run["samples_least"] <= run["samples_per_pixel"] <= run["samples_most"]


@check
def compare_warns_of_scenes_without_layers(tool, folder):
    scene = BALL[:BALL.index("MakeNamedMaterial")] + 'Material "diffuse"\nShape "sphere"\n'
    has(compare(tool, folder, *SMALL, scene=scene).err, "no layered material")


@check
def compare_compares_integrators_samplers_and_light_samplers(tool, folder):
    few = ("--equal-samples", "4", "--runs", "3", "--reference-spp", "64")
    lights = BALL.replace('LightSource "infinite"', 'LightSource "point" "point3 from" [0 -3 3]\nLightSource "infinite"')
    for option, noun, names, reference in (("--integrators", "integrator", ["bdpt", "path"], "volpath"),
                                           ("--samplers", "sampler", ["halton", "independent"], "zsobol"),
                                           ("--light-samplers", "light sampler", ["power", "uniform"], "bvh")):
        result = compare(tool, folder, option, ",".join(names), *few, scene=lights)
        has(result.out.decode(), *names)
        r = results(folder)
        assert r["compared"] == noun and r["estimators"] == names and r["baseline"] == names[0], r
        assert r["variants"][0]["reference"]["estimator"] == reference, r["variants"][0]["reference"]
        for e in r["variants"][0]["estimators"]:
            assert not e["approximate"] and abs(e["boxes"][0]["bias"]["z"]) < 4.5, e
            assert e["boxes"][0]["verdict"] in ("best", "indistinguishable", "worse"), e
        key = "lightSampler" if noun == "light sampler" else noun
        has(oiiotool(folder, "--info", "-v", "o/images/%s-run1.exr" % names[1]), "%s: \"%s\"" % (key, names[1]))
        # One reference for one way to render it.
        has(compare(tool, folder, option, ",".join(names), *few, scene=lights).err, "reference.exr: kept")
    assert "kept" not in compare(tool, folder, "--light-samplers", "bvh", *few, "--reference-by", "power", scene=lights).err


@check
def compare_warns_of_what_integrators_leave_out(tool, folder):
    few = ("--equal-samples", "1", "--runs", "2", "--reference-spp", "16")
    scene = BALL.replace('"integer maxdepth" 2', '"integer maxdepth" 2 "bool regularize" true "string lightsampler" "power"')
    clamped = BALL.replace('Film "rgb"', 'Film "rgb" "float maxcomponentvalue" 1')
    for option, names, says in (("--integrators", "path", "left out"), ("--light-samplers", "bvh,power", "left out"),
                                ("--estimators", "auto", "takes more from estimators")):
        has(compare(tool, folder, option, names, *few, scene=clamped).err, '"float maxcomponentvalue" .*' + says)
    # Sampling a pixel in another order changes none of its samples' distribution: clamped alike.
    assert "maxcomponent" not in compare(tool, folder, "--samplers", "halton", *few, scene=clamped).err
    err = compare(tool, folder, "--integrators", "path,bdpt,lightpath", *few, scene=scene).err
    has(err, '"bdpt" has no parameter "string lightsampler"', '"lightpath" never finds infinite lights as the background',
        '"bool regularize" changes the image')
    one = BALL.replace('LightSource "infinite" "rgb L" [0.2 0.2 0.2]\n', "")
    has(compare(tool, folder, "--light-samplers", "bvh,power", *few, scene=one).err, "one light", "render the same")
    has(compare(tool, folder, "--samplers", "stratified", "--time", "0.05", *few[2:]).err, '"stratified" does not know')
