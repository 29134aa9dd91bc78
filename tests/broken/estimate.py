"""lacquer estimate: photographs that are none, wrong command lines, and a right run."""
import json
import os

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
    usage("fix-unknown", [*PHOTO, "--fix", "ruogh=.3"], ["photo.png"], 2),
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
    usage("error-zero", [*PHOTO, "--error", "hand:0", "--map-only"], ["--error", "S > 0"]),
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
def estimate_goes_on_where_the_time_ended(tool, folder):
    made = tool.run(["estimate", *SMALL, "--simulate", "a.png", "--seed", "6"], folder)
    assert made.status == 0, made.err
    run = ["estimate", "a.png", *SMALL, "--method", "fixed-seed", "--seeds", "1", "--samples", "150", "--warmup", "100", "--quiet"]
    whole = tool.run([*run, "--out", "whole"], folder, timeout=120)
    assert whole.status in (0, 4), whole.err
    stopped, limit = tool.run([*run, "--out", "parts", "--time-limit", "1e-3"], folder), 0.5
    assert stopped.status == 5 and "--resume" in stopped.err, (stopped.status, stopped.err)
    hasCheckpoint = False
    while stopped.status == 5 and limit < 60:
        stopped = tool.run([*run, "--out", "parts", "--resume", "--time-limit", str(limit), "--checkpoint-every", ".1"], folder, timeout=120)
        hasCheckpoint |= os.path.exists(os.path.join(folder, "parts", "checkpoint.json"))
        limit *= 1.5
    assert stopped.status == whole.status and hasCheckpoint, (stopped.status, stopped.err)
    for name in ("chain-1.csv", "chain-4.csv", "posterior.json", "map.json"):
        one, two = (open(os.path.join(folder, out, name), "rb").read() for out in ("whole", "parts"))
        assert one and one == two, name
    assert not os.path.exists(os.path.join(folder, "parts", "checkpoint.json"))


@check
def estimate_finds_a_mode_and_tells_kinds_apart(tool, folder):
    made = tool.run(["estimate", *SMALL, "--simulate", "a.png", "--seed", "7"], folder)
    assert made.status == 0, made.err
    truth = json.loads(open(os.path.join(folder, "a.png.json")).read())["parameters"]
    mode = tool.run(["estimate", "a.png", *SMALL, "--map-only", "--explain", "--out", "mode"], folder, timeout=120)
    assert mode.status == 0 and "mode by 4 fixed seeds" in mode.err, mode.err
    found = json.loads(open(os.path.join(folder, "mode", "map.json")).read())["parameters"]
    assert abs(found["light"] / truth["light"] - 1) < .1 and abs(found["rough"] - truth["rough"]) < .1, (found, truth)
    table = open(os.path.join(folder, "mode", "explain.txt")).read().splitlines()
    assert [line.split()[0] for line in table[2:]][-1] == "all" and "gram" in [line.split()[0] for line in table[2:]], table
    assert not os.path.exists(os.path.join(folder, "mode", "chain-1.csv"))
    plaster = ["--model", "plaster", "--resolution", "64", "--size", "25", "--fix", "rough_var=.2", "--fix", "slope=2", "--fix", "height=.2",
               "--fix", "r=.4", "--fix", "g=.4", "--fix", "b=.4", "--fix", "vig=10"]
    made = tool.run(["estimate", *plaster, "--simulate", "b.png", "--seed", "2", "--noise", "ridged"], folder)
    assert made.status == 0, made.err
    kinds = tool.run(["estimate", "b.png", *plaster, "--noise", "any", "--out", "kinds", "--samples", "100", "--warmup", "100"], folder,
                     timeout=240)
    assert kinds.status in (0, 4), kinds.err
    found = {kind["noise"]: kind["probability"] for kind in json.loads(open(os.path.join(folder, "kinds", "kinds.json")).read())}
    assert sorted(found) == ["band-limited", "ridged", "spectral"] and abs(sum(found.values()) - 1) < 1e-9, found
    assert found["ridged"] > .5, found
    wrong = tool.run(["estimate", "b.png", *plaster, "--method", "fixed-seed", "--sampler", "hmc", "--out", "wrong"], folder)
    assert wrong.status == 1 and "frequency has no derivative" in wrong.err, wrong.err
