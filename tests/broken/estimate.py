"""lacquer estimate: photographs that are none, wrong command lines, and a right run."""
import json
import math
import os
import struct
import subprocess

from run import Case

PHOTO = ["photo.png", "--model", "leather", "--out", "out"]


def usage(name, args, says, status=1, **more):
    return Case("estimate-" + name, None, says, status, ["estimate", *args], {"photo.png": "no image", "old.json": "kept"}, **more)


CASES = [
    usage("no-photo", ["--model", "leather", "--out", "out"], ["photo is required"]),
    usage("no-model", ["photo.png", "--out", "out"], ["--model is required", "bump, leather"]),
    usage("no-out", PHOTO[:3], ["--out is required"]),
    usage("model", ["photo.png", "--model", "lether", "--out", "out"], ["lether", 'did you mean "leather"?']),
    usage("no-file", ["none.png", *PHOTO[1:]], ["none.png"], 3),
    usage("no-image", PHOTO, ["photo.png"], 2),
    usage("fix-unknown", [*PHOTO, "--fix", "ruogh=.3"], ["--fix", "ruogh", 'did you mean "rough"?']),
    usage("free-unknown", [*PHOTO, "--free", "nosuch"], ["--free", "nosuch", "axis_x"]),
    usage("size-zero", [*PHOTO, "--size", "0"], ["--size", "0"]),
    usage("distance-negative", [*PHOTO, "--distance", "-3"], ["--distance", "-3"]),
    usage("fov-flat", [*PHOTO, "--fov", "180"], ["--fov", "between 0 and 180"]),
    usage("samples-zero", [*PHOTO, "--samples", "0"], ["--samples", "0"]),
    usage("chains-zero", [*PHOTO, "--chains", "0"], ["--chains", "0"]),
    usage("summaries", [*PHOTO, "--summaries", "colour,ringz"], ["ringz", 'did you mean "rings"?']),
    usage("crop-word", [*PHOTO, "--crop", "left"], ["--crop", '"left"', "x0 < x1"]),
    usage("tone", [*PHOTO, "--tone", "rgb"], ["--tone", "srgb"]),
    usage("method", [*PHOTO, "--method", "emulatd"], ["emulatd", 'did you mean "emulated"?']),
    usage("sampler", [*PHOTO, "--sampler", "nuts"], ["--sampler", "nuts", "hmc"]),
    usage("seeds", [*PHOTO, "--seeds", "0"], ["--seeds", "0"]),
    usage("error-word", [*PHOTO, "--error", "hand"], ["--error", '"hand"', "hand:S with S > 0"]),
    usage("error-zero", [*PHOTO, "--error", "hand:0", "--method", "fixed-seed"], ["--error", "S > 0"]),
    usage("error-emulated", [*PHOTO, "--error", "hand:.02"], ["--error", "--method fixed-seed"]),
    usage("time-limit", [*PHOTO, "--time-limit", "0"], ["--time-limit", "0"]),
    usage("checkpoint", [*PHOTO, "--checkpoint-every", "-1"], ["--checkpoint-every", "-1"]),
    usage("prior-set", [*PHOTO, "--prior-set", "tset"], ["tset", 'did you mean "test"?']),
    usage("cells", [*PHOTO, "--cells", "jitered"], ["jitered", 'did you mean "jittered"?']),
    usage("noise", [*PHOTO, "--noise", "all"], ["--noise", "any"]),
    usage("vgg-without-file", [*PHOTO, "--summaries", "vgg"], ["--vgg FILE"]),
    usage("vgg-missing", [*PHOTO, "--vgg", "none.safetensors"], ["none.safetensors"], 3),
    usage("vgg-no-tensors", [*PHOTO, "--vgg", "photo.png"], ["photo.png"], 3),
    usage("prior-sd", ["--model", "leather", "--simulate", "a.png", "--prior", "rough=normal(.2,0,.1,.8)"],
          ["--prior", "SD > 0"]),
    usage("prior-bounds", ["--model", "leather", "--simulate", "a.png", "--prior", "rough=normal(.2,.1,.8,.1)"],
          ["--prior", "LOW < HIGH"]),
    usage("prior-negative", ["--model", "leather", "--simulate", "a.png", "--prior", "height=normal(.1,.1,-1,1)"],
          ["prior of height", "no negative limits"]),
    usage("prior-albedo", ["--model", "leather", "--simulate", "a.png", "--prior", "r=normal(.4,.3,0,5)"],
          ["prior of r reaches from 0 to 5", "from 0 to 1"]),
    usage("prior-twice", ["--model", "leather", "--simulate", "a.png", "--prior", "r=normal(.4,.3,0,1)", "r=normal(.5,.3,0,1)"],
          ["--prior: r is there twice"]),
    usage("fix-twice", ["--model", "leather", "--simulate", "a.png", "--fix", "r=.3", "r=.4"], ["--fix: r is there twice"]),
    usage("fix-and-prior", ["--model", "leather", "--simulate", "a.png", "--fix", "r=.3", "--prior", "r=normal(.5,.3,0,1)"],
          ["--prior: r is fixed by --fix"]),
    usage("fix-and-free", ["--model", "leather", "--simulate", "a.png", "--fix", "axis_x=.3", "--free", "axis_x"],
          ["--free: axis_x is fixed by --fix"]),
    usage("fix-all", ["--model", "bump", "--sbc", "20", "--fix", "light=999", "r=.4", "g=.4", "b=.4", "rough=.2", "fsigma=1",
                      "height=.02", "vig=10"], ["none is left to be estimated"]),
    usage("size", [*PHOTO, "--size", "0"], ["--size: 0; expected a number above 0"]),
    usage("resolution-100", [*PHOTO, "--resolution", "100"], ["--resolution: 100", "multiple of 16", "96 or 112"]),
    usage("robust-model", [*PHOTO, "--robust"], ["--robust has no effect with --model"]),
    usage("candidates-model", [*PHOTO, "--candidates", "c.csv"], ["--candidates has no effect with --model"]),
    usage("material-model", [*PHOTO, "--material", "paint"], ["--material has no effect with --model"]),
    usage("json-alone", [*PHOTO, "--json"], ["--json has no effect without --models"]),
    usage("fov-too-many", [*PHOTO, "--fov", "40", "--size", "10", "--distance", "25"], ["--fov has no effect", "two of the three"]),
    usage("cells-metal", ["--model", "metal", "--simulate", "a.png", "--cells", "any"], ["--cells has no effect on metal"]),
    usage("noise-flakes", ["--model", "flakes", "--simulate", "a.png", "--noise", "ridged"], ["--noise has no effect on flakes"]),
    usage("prior-name", ["--model", "leather", "--simulate", "a.png", "--prior", "ruogh=normal(.2,.1,.1,.8)"],
          ["ruogh", 'did you mean "rough"?']),
    usage("fix-name", ["--model", "leather", "--simulate", "a.png", "--fix", "ruogh=.2"], ["ruogh", 'did you mean "rough"?']),
    usage("fix-word", ["--model", "leather", "--simulate", "a.png", "--fix", "rough=high"], ["--fix", "NAME=VALUE"]),
    usage("fix-outside", ["--model", "leather", "--simulate", "a.png", "--fix", "rough=3"], ["rough", "3", "outside"]),
    usage("simulate-nowhere", ["--model", "leather", "--simulate", "no/a.png"], ["no/a.png", "its folder does not exist"], 3),
]


CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


def slow(function):
    """Of a check that takes half a minute of a processor and more: run.py leaves it out without --slow."""
    function.is_slow = True
    return function


SMALL = ["--model", "bump", "--resolution", "64", "--size", "6", "--distance", "25", "--summaries", "colour,rings",
         *(f"--fix={name}={value}" for name, value in (("r", .4), ("g", .4), ("b", .4), ("vig", 10), ("fsigma", 1), ("height", .01)))]


@check
def estimate_writes_files_that_are_whole_whatever_the_threads(tool, folder):
    made = tool.run(["estimate", *SMALL, "--simulate", "a.png", "--seed", "5"], folder)
    assert made.status == 0, made.err
    for threads in ("1", "2"):
        done = tool.run(["estimate", "a.png", *SMALL, "--truth", "a.png.json", "--out", "out" + threads, "--samples", "200",
                         "--warmup", "100", "--nthreads", threads, "--quiet"], folder)
        assert done.status in (0, 4), done.err
    files = ["chain-1.csv", "chain-4.csv", "posterior.json", "summary.csv", "map.json", "runs.bin", "material.pbrt", "maps/normal.exr"]
    for name in files:
        one, two = (open(os.path.join(folder, out, name), "rb").read() for out in ("out1", "out2"))
        assert one and (one == two or name.endswith(".exr")), name
    posterior = json.loads(open(os.path.join(folder, "out1", "posterior.json")).read())["posterior"]
    assert sorted(posterior) == ["light", "rough"] and len(posterior["light"]) == 4, sorted(posterior)
    # A finished run is not written over, and --resume gives the same bits.
    again = tool.run(["estimate", "a.png", *SMALL, "--out", "out1"], folder)
    assert again.status == 3 and "--resume" in again.err, again.err
    other = tool.run(["estimate", "a.png", *SMALL, "--out", "out1", "--samples", "300", "--warmup", "100", "--resume"], folder)
    assert other.status == 3 and "samples" in other.err, other.err
    before = open(os.path.join(folder, "out1", "chain-2.csv"), "rb").read()
    resumed = tool.run(["estimate", "a.png", *SMALL, "--truth", "a.png.json", "--out", "out1", "--samples", "200", "--warmup", "100",
                        "--resume", "--quiet"], folder)
    assert resumed.status == done.status, resumed.err
    assert open(os.path.join(folder, "out1", "chain-2.csv"), "rb").read() == before
    rendered = tool.run(["photograph.pbrt", "--spp", "4", "--quiet"], os.path.join(folder, "out1"))
    assert rendered.status == 0, rendered.err


@check
def estimate_says_in_the_report_what_the_file_has_lost(tool, folder):
    made = tool.run(["estimate", *SMALL, "--resolution", "96", "--simulate", "a.png", "--seed", "5"], folder)
    assert made.status == 0, made.err
    subprocess.run(["oiiotool", "a.png", "-o", "a.jpg"], cwd=folder, check=True)
    for name, loses in (("a.png", False), ("a.jpg", True)):
        done = tool.run(["estimate", name, *SMALL, "--simulated-resolution", "64", "--map-only", "--out", name + ".out"], folder, timeout=120)
        assert done.status == 0, done.err
        page = open(os.path.join(folder, name + ".out", "report.html")).read()
        for text in (done.err, page):
            assert ("JPEG leaves out fine detail" in text) == loses and "simulated with 64 x 64" in text, (name, text[:2000])


@check
def estimate_goes_on_where_the_time_ended(tool, folder):
    made = tool.run(["estimate", *SMALL, "--simulate", "a.png", "--seed", "6"], folder)
    assert made.status == 0, made.err
    run = ["estimate", "a.png", *SMALL, "--method", "fixed-seed", "--seeds", "1", "--samples", "100", "--warmup", "100", "--chains", "2",
           "--quiet"]
    whole = tool.run([*run, "--out", "whole"], folder, timeout=120)
    assert whole.status in (0, 4), whole.err
    # What is not kept is done anew each time: a later limit is amid the chains or in what follows them. Beside other work the mode's
    # time is not known so well: if no limit fell there, all is tried again.
    hasCheckpoint = False
    for attempt in range(6):
        parts = "parts-%d" % attempt
        stopped, limit = tool.run([*run, "--out", parts, "--time-limit", "1e-3"], folder), whole.seconds * (.4 + .1 * attempt)
        assert stopped.status == 5 and "--resume" in stopped.err, (stopped.status, stopped.err)
        while stopped.status == 5 and limit < 60:
            stopped = tool.run([*run, "--out", parts, "--resume", "--time-limit", str(limit), "--checkpoint-every", ".1"], folder,
                               timeout=120)
            hasCheckpoint |= os.path.exists(os.path.join(folder, parts, "checkpoint.json"))
            limit *= 1.25
        if hasCheckpoint:
            break
    assert stopped.status == whole.status and hasCheckpoint, (stopped.status, hasCheckpoint, stopped.err)
    for name in ("chain-1.csv", "chain-2.csv", "posterior.json", "map.json"):
        one, two = (open(os.path.join(folder, out, name), "rb").read() for out in ("whole", parts))
        assert one and one == two, name
    assert not os.path.exists(os.path.join(folder, parts, "checkpoint.json"))
    # Chains outlive results that cannot be written, and neither a mode nor another run takes them away.
    os.makedirs(os.path.join(folder, "blocked", "chain-1.csv"))
    blocked = tool.run([*run, "--out", "blocked"], folder, timeout=120)
    assert blocked.status == 3 and "chain-1.csv" in blocked.err, (blocked.status, blocked.err)
    for more in ([], ["--map-only"]):
        refused = tool.run([*run, "--out", "blocked", *more], folder)
        assert refused.status == 3 and "checkpoint.json" in refused.err and "--resume" in refused.err, refused.err
    os.rmdir(os.path.join(folder, "blocked", "chain-1.csv"))
    resumed = tool.run([*run, "--out", "blocked", "--resume"], folder, timeout=120)
    assert resumed.status == whole.status, resumed.err
    one, two = (open(os.path.join(folder, out, "chain-1.csv"), "rb").read() for out in ("whole", "blocked"))
    assert one == two and not os.path.exists(os.path.join(folder, "blocked", "checkpoint.json"))


@check
def estimate_finds_a_mode(tool, folder):
    made = tool.run(["estimate", *SMALL, "--simulate", "a.png", "--seed", "7"], folder)
    assert made.status == 0, made.err
    truth = json.loads(open(os.path.join(folder, "a.png.json")).read())["parameters"]
    mode = tool.run(["estimate", "a.png", *SMALL, "--map-only", "--explain", "--out", "mode"], folder, timeout=120)
    assert mode.status == 0 and "mode, emulated" in mode.err, mode.err
    fixed = tool.run(["estimate", "a.png", *SMALL, "--map-only", "--method", "fixed-seed", "--seeds", "2", "--out", "fixed"], folder, timeout=120)
    assert fixed.status == 0 and "mode by 2 fixed seeds" in fixed.err, fixed.err
    found = json.loads(open(os.path.join(folder, "mode", "map.json")).read())["parameters"]
    assert abs(found["light"] / truth["light"] - 1) < .1 and abs(found["rough"] - truth["rough"]) < .1, (found, truth)
    table = open(os.path.join(folder, "mode", "explain.txt")).read().splitlines()
    assert [line.split()[0] for line in table[2:]][-1] == "all" and "gram" in [line.split()[0] for line in table[2:]], table
    assert not os.path.exists(os.path.join(folder, "mode", "chain-1.csv"))


PLASTER = ["--model", "plaster", "--resolution", "64", "--size", "25", "--fix", "rough_var=.2", "--fix", "slope=2", "--fix", "height=.2",
           "--fix", "r=.4", "--fix", "g=.4", "--fix", "b=.4", "--fix", "vig=10"]


@check
def estimate_has_no_derivatives_by_what_is_counted(tool, folder):
    made = tool.run(["estimate", *PLASTER, "--simulate", "b.png", "--seed", "2"], folder)
    assert made.status == 0, made.err
    wrong = tool.run(["estimate", "b.png", *PLASTER, "--method", "fixed-seed", "--sampler", "hmc", "--out", "wrong"], folder)
    assert wrong.status == 1 and "frequency has no derivative" in wrong.err, wrong.err


@check
@slow
def estimate_tells_kinds_apart(tool, folder):
    made = tool.run(["estimate", *PLASTER, "--simulate", "b.png", "--seed", "2", "--noise", "ridged"], folder)
    assert made.status == 0, made.err
    kinds = tool.run(["estimate", "b.png", *PLASTER, "--noise", "any", "--out", "kinds", "--samples", "100", "--warmup", "100"], folder,
                     timeout=240)
    assert kinds.status in (0, 4), kinds.err
    found = {kind["noise"]: kind["probability"] for kind in json.loads(open(os.path.join(folder, "kinds", "kinds.json")).read())}
    assert sorted(found) == ["band-limited", "ridged", "spectral"] and abs(sum(found.values()) - 1) < 1e-9, found
    assert found["ridged"] > .5, found


# ---- Measurements of layers ----

STACK = '''WorldBegin
Texture "worn" "float" "constant" "float value" [.2]
MakeNamedMaterial "coat" "string type" "dielectric" "float roughness" [0.2] "bool remaproughness" false
MakeNamedMaterial "slab" "string type" "slab" "float eta" [1.5] "rgb sigma_t" [.4 .2 .1]
MakeNamedMaterial "base" "string type" "diffuse" "rgb reflectance" [.8 .6 .4]
MakeNamedMaterial "metal" "string type" "conductor" "texture roughness" "worn"
MakeNamedMaterial "paint" "string type" "layered" "string stack" ["coat" "slab" "base"]
'''
HEAD = "theta_i,phi_i,theta_o,phi_o,r,g,b\n"
ROWS = "".join(f"{i},0,{o},180,.3,.2,.1\n" for i in (10, 50) for o in (0, 20, 40, 60))
LAYERS = ["data.csv", "--scene", "s.pbrt", "--free", "coat.roughness", "--out", "out"]


def layers(name, data, says, args=None, status=2, scene=STACK, **more):
    return Case("estimate-layers-" + name, None, says, status, ["estimate", *(LAYERS if args is None else args)],
                {"s.pbrt": scene, "data.csv": data}, **more)


def free(*names):
    return ["data.csv", "--scene", "s.pbrt", "--free", ",".join(names), "--out", "out"]


CASES += [
    layers("below", HEAD + ROWS + "10,0,@95,180,.1,.1,.1\n", ["theta_o", "95", "below the surface", "0 to below 90"]),
    layers("light-below", HEAD + ROWS + "@120,0,10,180,.1,.1,.1\n", ["theta_i", "below the surface"]),
    layers("horizon", HEAD + ROWS + "10,0,@90,180,.1,.1,.1\n", ["theta_o", "90"]),
    layers("negative-angle", HEAD + ROWS + "@-10,0,10,180,.1,.1,.1\n", ["theta_i", "-10"]),
    layers("zero", HEAD + ROWS + "10,0,10,180,.1,@0,.1\n", ["g is 0", "positive reflectance"]),
    layers("negative", HEAD + ROWS + "10,0,10,180,.1,.1,@-.1\n", ["b is -0.1", "positive reflectance"]),
    layers("tiny", HEAD + ROWS + "10,0,10,180,.1,@1e-200,.1\n", ["g is 1e-200", "at least 1e-12"]),
    layers("huge", HEAD + ROWS + "10,0,10,180,.1,@1e200,.1\n", ["g is 1e+200", "at most 1e+09"]),
    layers("word", HEAD + ROWS + "10,0,10,180,@high,.1,.1\n", ["r", "high", "expected a number"]),
    layers("nan", HEAD + ROWS + "10,0,10,180,@nan,.1,.1\n", ["nan", "expected a number"]),
    layers("ragged", HEAD + ROWS + "@10,0,10,180,.1,.1\n", ["6 values", "expected 7"]),
    layers("long-row", HEAD + ROWS + "@10,0,10,180,.1,.1,.1,.1\n", ["8 values", "expected 7"]),
    layers("semicolons", "@" + (HEAD + ROWS).replace(",", ";"), ["semicolons", "expected commas between columns"]),
    layers("tabs", "@" + (HEAD + ROWS).replace(",", "\t"), ["tabs", "expected commas between columns"]),
    layers("semicolons-below", HEAD + "@10;0;10;180;.1;.1;.1\n", ["1 values", "semicolons"]),
    layers("decimal-commas", HEAD + "@10,0,10,180,0,1,0,1,0,1\n", ["10 values", "expected 7", "with points"]),
    layers("sd", HEAD.replace("b\n", "b,sd\n") + "10,0,10,180,.1,.1,.1,@-1\n", ["sd is -1"]),
    layers("column", "@theta_i,phi_i,theta_o,phi_o,red,g,b\n" + ROWS, ["unknown column", "red"]),
    layers("no-column", "@theta_i,phi_i,theta_o,r,g,b\n10,0,10,.1,.1,.1\n", ['no column "phi_o"']),
    layers("wavelength", "theta_i,phi_i,theta_o,phi_o,wavelength,value\n10,0,10,180,@3000,.1\n", ["wavelength is 3000", "360 to 830"]),
    layers("both", "@theta_i,phi_i,theta_o,phi_o,wavelength,value,r\n10,0,10,180,500,.1,.1\n", ["one of the two"]),
    layers("few", HEAD + "10,0,10,180,.1,.1,.1\n10,0,20,180,.1,.1,.1\n", ["has 2 rows", "at least 3"]),
    layers("no-rows", HEAD, ["no rows"]),
    layers("empty", "", ["has no columns"]),
    layers("no-data", HEAD + ROWS, ["none.csv"], ["none.csv", *LAYERS[1:]], 3),
    layers("no-scene", HEAD + ROWS, ["none.pbrt"], ["data.csv", "--scene", "none.pbrt", *LAYERS[3:]], 3),
    layers("data-required", HEAD + ROWS, ["data are required"], LAYERS[1:], 1),
    layers("free-required", HEAD + ROWS, ["--free is required"], [*LAYERS[:3], "--out", "out"], 1),
    layers("out-required", HEAD + ROWS, ["--out is required"], LAYERS[:5], 1),
    layers("name", HEAD + ROWS, ['no material "cout"', 'did you mean "coat"?'], free("cout.roughness"), status=1),
    layers("parameter", HEAD + ROWS, ["ruoghness", 'did you mean "roughness"?'], free("coat.ruoghness"),
           scene=STACK.replace('MakeNamedMaterial "coat"', '@MakeNamedMaterial "coat"'), status=1),
    layers("texture", HEAD + ROWS, ["is a texture"], [*free("metal.roughness"), "--material", "gold"],
           scene=STACK.replace('"texture roughness"', '@"texture roughness"')
           + 'MakeNamedMaterial "gold" "string type" "layered" "string stack" ["coat" "slab" "metal"]\n', status=1),
    layers("string", HEAD + ROWS, ["is no number"], free("coat.remaproughness"),
           scene=STACK.replace('"bool remaproughness"', '@"bool remaproughness"'), status=1),
    layers("elsewhere", HEAD + ROWS, ['no part of material "paint"'], free("metal.roughness"),
           scene=STACK.replace('MakeNamedMaterial "metal"', '@MakeNamedMaterial "metal"'), status=1),
    layers("twice", HEAD + ROWS, ["are one number"], free("slab.sigma_t", "slab.sigma_t.r"),
           scene=STACK.replace('MakeNamedMaterial "slab"', '@MakeNamedMaterial "slab"'), status=1),
    layers("material", HEAD + ROWS, ["paimt", 'did you mean "paint"?'], [*LAYERS, "--material", "paimt"], status=1),
    layers("which-material", HEAD + ROWS, ["several layered materials", "paint, other"],
           scene=STACK + 'MakeNamedMaterial "other" "string type" "layered" "string stack" ["coat" "slab" "base"]\n', status=1),
    layers("prior-name", HEAD + ROWS, ["coat.ruoghness", 'did you mean "coat.roughness"?'],
           [*LAYERS, "--prior", "coat.ruoghness=normal(.1,.1,.01,.5)"], status=1),
    layers("prior-beyond", HEAD + ROWS, ["prior of coat.roughness reaches from 0 to 5", "from 0 to 1"],
           [*LAYERS, "--prior", "coat.roughness=normal(.3,.1,0,5)"], 1),
    layers("prior-noise", HEAD + ROWS, ["LOW > 0"], [*LAYERS, "--prior", "noise=normal(.1,.1,0,.5)"], 1),
    layers("model", HEAD + ROWS, ["--model has no effect"], [*LAYERS, "--model", "leather"], 1),
    *(layers(option[2:], HEAD + ROWS, [option + " has no effect with --scene"], [*LAYERS, option, value], 1)
      for option, value in (("--size", "10"), ("--distance", "25"), ("--fov", "40"), ("--crop", "0,8,0,8"), ("--tone", "linear"))),
    layers("candidates", HEAD + ROWS, ["c.csv"], [*LAYERS, "--candidates", "c.csv"], 3),
]


@check
def estimate_of_layers_has_the_same_bits_whatever_the_threads_and_after_a_stop(tool, folder):
    with open(os.path.join(folder, "s.pbrt"), "w") as scene:
        scene.write(STACK.replace('"paint" "string type" "layered" "string stack" ["coat" "slab" "base"]',
                                  '"paint" "string type" "layered" "string stack" ["coat" "slab" "iron"]')
                    .replace('MakeNamedMaterial "metal"', 'MakeNamedMaterial "iron" "string type" "conductor" "float roughness" .3\n'
                             'MakeNamedMaterial "metal"'))
    names = ["--scene", "s.pbrt", "--free", "coat.roughness,slab.sigma_t,slab.thickness"]
    with open(os.path.join(folder, "data.csv"), "w") as data:
        data.write(HEAD + ROWS + ROWS.replace("180", "90"))
    made = tool.run(["estimate", "data.csv", *names, "--simulate", "a.csv", "--prior", "noise=normal(.05,.001,.01,.2)", "--seed", "5"], folder)
    assert made.status == 0, made.err
    run = ["estimate", "a.csv", *names, "--truth", "a.csv.json", "--samples", "150", "--warmup", "100"]
    for threads in ("1", "7"):
        done = tool.run([*run, "--out", "out" + threads, "--nthreads", threads], folder, timeout=120)
        assert done.status in (0, 4) and "product alone" in done.err and "next measurement" in done.err, done.err
    stopped, limit = tool.run([*run, "--out", "parts", "--time-limit", "1e-3"], folder), done.seconds / 2
    assert stopped.status == 5 and "--resume" in stopped.err, (stopped.status, stopped.err)
    while stopped.status == 5 and limit < 100:
        stopped = tool.run([*run, "--out", "parts", "--resume", "--time-limit", str(limit), "--checkpoint-every", ".1"], folder, timeout=120)
        limit *= 1.5
    assert stopped.status == done.status, (stopped.status, stopped.err)
    for name in ("chain-1.csv", "chain-4.csv", "posterior.json", "summary.csv", "map.json", "runs.bin", "material.pbrt", "material-8.pbrt"):
        first = open(os.path.join(folder, "out1", name), "rb").read()
        for out in ("out7", "parts"):
            assert first and first == open(os.path.join(folder, out, name), "rb").read(), (out, name)
    summary = open(os.path.join(folder, "out1", "summary.txt")).read()
    assert "slab.sigma_t x slab.thickness" in summary, summary
    again = tool.run([*run, "--out", "out1"], folder)
    assert again.status == 3 and "--resume" in again.err, again.err
    other = tool.run([*run, "--out", "out1", "--robust", "--resume"], folder)
    assert other.status == 3 and "robust" in other.err, other.err
    with open(os.path.join(folder, "ball.pbrt"), "w") as ball:
        ball.write('LookAt 0 -4 0 0 0 0 0 0 1\nCamera "perspective"\nFilm "rgb" "integer xresolution" 16 "integer yresolution" 16\n'
                   'WorldBegin\nLightSource "infinite"\nInclude "out1/material.pbrt"\nNamedMaterial "paint"\nShape "sphere"\n')
    rendered = tool.run(["ball.pbrt", "--spp", "4", "--outfile", "ball.exr", "--quiet"], folder)
    assert rendered.status == 0, rendered.err


CAMERA = '''LookAt 0 0 4 0 0 0 0 1 0
Camera "perspective" "float fov" 30
PixelFilter "box"
Film "rgb" "integer xresolution" 24 "integer yresolution" 24
WorldBegin
LightSource "distant" "point3 from" [1 0 4] "point3 to" [0 0 0] "rgb L" [2 2 2]
LightSource "infinite" "rgb L" [.3 .3 .3]
'''
PLANE = 'NamedMaterial "paint"\nShape "bilinearmesh" "point3 P" [-1 -1 0  1 -1 0  -1 1 0  1 1 0]\n'


def pfm(width, height, value=.5):
    return b"PF\n%d %d\n-1\n" % (width, height) + struct.pack("<f", value) * (3 * width * height)


def photograph(name, image, says, more=(), status=2):
    return Case("estimate-photograph-of-a-scene-" + name, None, says, status,
                ["estimate", "a.pfm", "--scene", "s.pbrt", "--free", "coat.roughness", "--out", "out", *more],
                {"s.pbrt": CAMERA + STACK.replace("WorldBegin\n", "") + PLANE, "a.pfm": image})


CASES += [
    photograph("ratio", pfm(24, 12), ["a.pfm", "24 x 12", "ratio of the scene's film, 24 x 24"]),
    photograph("small", pfm(8, 8), ["a.pfm", "8 x 8", "at least 12 x 12"]),
    photograph("nan", pfm(24, 24, math.nan), ["a.pfm", "not finite"]),
    photograph("dark", pfm(24, 24, 0), ["a.pfm", "0 values that are bright enough", "at least 3"]),
    photograph("torn", pfm(24, 24)[:-100], ["a.pfm"]),
    photograph("exposure-twice", pfm(24, 24), ["exposure"], ["--free", "exposure", "--free", "exposure"], 1),
    layers("exposure-misspelt", HEAD + ROWS, ['"exposur": expected MATERIAL.PARAMETER', 'did you mean "exposure"?'],
           free("coat.roughness", "exposur"), status=1),
    # What the scene misspells is the scene's: at its place, whatever the options say.
    layers("type-of-part", HEAD + ROWS, ["dielectrc", 'did you mean "dielectric"?'], free("coat.roughness"),
           scene=STACK.replace('MakeNamedMaterial "coat" "string type" "dielectric"',
                               '@MakeNamedMaterial "coat" "string type" "dielectrc"')),
    layers("type-of-stack", HEAD + ROWS, ["layerd", 'did you mean "layered"?'], free("coat.roughness"),
           scene=STACK.replace('MakeNamedMaterial "paint" "string type" "layered"',
                               '@MakeNamedMaterial "paint" "string type" "layerd"')),
    layers("exposure", HEAD + ROWS, ["--free exposure", "photographs"], free("coat.roughness", "exposure"), 1),
]


@check
@slow
def estimate_takes_a_photograph_of_a_scene_as_data_and_finds_its_exposure(tool, folder):
    with open(os.path.join(folder, "s.pbrt"), "w") as scene:
        scene.write(CAMERA + STACK.replace("WorldBegin\n", "") + PLANE)
    rendered = tool.run(["s.pbrt", "--spp", "64", "--outfile", "a.exr", "--quiet"], folder)
    assert rendered.status == 0, rendered.err
    brighter = tool.run(["convert", "a.exr", "b.pfm", "--scale", "1.5"], folder)
    assert brighter.status == 0, brighter.err
    run = ["estimate", "b.pfm", "--scene", "s.pbrt", "--free", "base.reflectance,exposure", "--samples", "300", "--warmup", "200"]
    narrow = [*run, "--prior", "base.reflectance=normal(.6,.001,.5,.66)", "--out", "out"]
    done = tool.run(narrow, folder, timeout=240)
    assert done.status in (0, 4) and "photograph" in done.err, done.err
    found = json.loads(open(os.path.join(folder, "out", "map.json")).read())["parameters"]
    assert abs(found["exposure"] / 1.5 - 1) < .05, found
    page = open(os.path.join(folder, "out", "report.html")).read()
    assert "gain over the scene" in page and "a photograph, 432 values" in page


@check
def estimate_takes_values_at_wavelengths(tool, folder):
    with open(os.path.join(folder, "s.pbrt"), "w") as scene:
        scene.write(STACK)
    head = "theta_i,phi_i,theta_o,phi_o,wavelength,value\n"
    with open(os.path.join(folder, "where.csv"), "w") as where:
        where.write(head + "".join(f"{i},0,{o},180,{nm},.1\n" for nm in (450, 550, 650) for i in (10, 50) for o in (0, 10, 30, 50, 65)))
    names = ["--scene", "s.pbrt", "--free", "coat.roughness"]
    made = tool.run(["estimate", "where.csv", *names, "--simulate", "a.csv", "--prior", "noise=normal(.02,.0001,.01,.2)"], folder)
    assert made.status == 0, made.err
    first = open(os.path.join(folder, "a.csv")).read().splitlines()
    assert "wavelength,value" in first[0] and len(first) == 31, first[:2]
    done = tool.run(["estimate", "a.csv", *names, "--truth", "a.csv.json", "--out", "out", "--samples", "500", "--warmup", "300"], folder,
                    timeout=240)
    assert done.status in (0, 4), done.err
    posterior = json.loads(open(os.path.join(folder, "out", "posterior.json")).read())["posterior"]["coat.roughness"]
    draws = sorted(x for chain in posterior for x in chain)
    assert draws[len(draws) // 100] < .2 < draws[-len(draws) // 100] and draws[-1] - draws[0] < .2, (draws[0], draws[-1])
    assert "650" in open(os.path.join(folder, "out", "report.html")).read()
