"""lacquer bulk: particles that make no sense, wrong command lines, and right runs."""
import json
import os
import re
import signal

from run import HERE, Case, health
from command_line import has, write

FAT = """{
  "wavelengths": [450, 650, 100], "host": {"index": 1.33},
  "species": [{"name": "fat", "index": 1.46, "radius": 0.06, "volume fraction": 0.03}],
  "arrangement": {"kind": "cut", "count": 4, "mode": "medium"}, "length": "um", "seed": 1
}
"""


def broken(name, what, by, says, status=2, args=("--out", "milk.json"), **more):
    assert what in FAT, what
    return Case("bulk-" + name, None, says, status, ["bulk", "p.json", *args], {"p.json": FAT.replace(what, by)},
                **more)


def usage(name, args, says, status=1, **more):
    return Case("bulk-" + name, None, says, status, ["bulk", *args], {"p.json": FAT, "old.json": "kept", "folder": None},
                **more)


CASES = [
    usage("no-input", ["--out", "m.json"], ["input", "lacquer bulk --help"]),
    usage("no-out", ["p.json"], ["--out is required"]),
    usage("no-file", ["none.json", "--out", "m.json"], ["none.json: cannot be opened: No such file"], 3),
    usage("a-folder", ["folder", "--out", "m.json"], ["folder"], 3),
    # Said before the work, which would not end in time.
    usage("out-below-nothing", ["p.json", "--out", "no/m.json", "--realisations", "1000000"],
          ["no/m.json", "its folder does not exist"], 3),
    usage("out-is-a-folder", ["p.json", "--out", "folder", "--realisations", "1000000"], ["folder", "is a folder"], 3),
    usage("out-is-the-input", ["p.json", "--out", "./p.json"], ["--out", "another file than the particles"]),
    usage("zero-realisations", ["p.json", "--out", "m.json", "--realisations", "0"], ["--realisations", "0"]),
    usage("one-realisation", ["p.json", "--out", "m.json", "--realisations", "1"], ["--realisations", "at least 2"]),
    usage("huge-realisations", ["p.json", "--out", "m.json", "--realisations", "1e300"], ["--realisations", "1e300"]),
    usage("error-and-realisations", ["p.json", "--out", "m.json", "--error", "1%", "--realisations", "9"],
          ["--error", "--realisations"]),
    usage("error-zero", ["p.json", "--out", "m.json", "--error", "0"], ["--error", '"0"', "1%"]),
    usage("error-nan", ["p.json", "--out", "m.json", "--error", "nan"], ["--error", '"nan"']),
    usage("error-unit", ["p.json", "--out", "m.json", "--error", "1pc"], ["--error", '"1pc"']),
    usage("time-negative", ["p.json", "--out", "m.json", "--time", "-1m"], ["--time", '"-1m"', "10m"]),
    usage("time-unit", ["p.json", "--out", "m.json", "--time", "1d"], ["--time", '"1d"', "2h"]),
    usage("time-infinite", ["p.json", "--out", "m.json", "--time", "1e400"], ["--time", '"1e400"']),
    usage("wavelengths-word", ["p.json", "--out", "m.json", "--wavelengths", "red"], ["--wavelengths", '"red"']),
    usage("wavelengths-falling", ["p.json", "--out", "m.json", "--wavelengths", "700:400:50"],
          ["--wavelengths", "BEGIN:END:STEP"]),
    usage("wavelengths-many", ["p.json", "--out", "m.json", "--wavelengths", "400:700:1e-9"], ["at most 1000"]),
    usage("wavelengths-comma", ["p.json", "--out", "m.json", "--wavelengths", "400,"], ["--wavelengths", '"400,"']),
    usage("seed-negative", ["p.json", "--out", "m.json", "--seed", "-1"], ["--seed"]),
    usage("threads", ["p.json", "--out", "m.json", "--nthreads", "-1"], ["--nthreads"]),
    usage("option", ["p.json", "--out", "m.json", "--realizations", "3"], ["--realizations", '"--realisations"?']),
    broken("peak-between-incidences", FAT, """{"wavelengths": 550, "species": [{"name": "w", "index": 1.33, "radius": 0.3,
        "volume fraction": 0.05}], "host": {"index": 1}, "arrangement": {"kind": "disc", "deviations": [1.2, 1.2, 0.3], "count": 6,
        "mode": "aggregate", "oriented": true, "incidences": 5}}""", ["p.json", "expected more incidences"],
           args=("--out", "milk.json", "--realisations", "2"), warns=True),
    broken("no-json", FAT, "@", ["this is no JSON"]),
    broken("binary", FAT, "@\u0001\u0002", ["this is no JSON"]),
    broken("cut-short", FAT, FAT[:120] + "@", ["this is no JSON"]),
    broken("deep", FAT, "[" * 64 + "@" + "[" * 1000000, ["nested more than 64 deep"]),
    broken("key", '"radius"', '@"raduis"', ['unknown key "raduis"; did you mean "radius"?']),
    broken("key-twice", '"index": 1.46', '"index": 1.46, @"index": 1.5', ["this key stands in the file twice"]),
    broken("radius-negative", "0.06", "@-0.06", ["found -0.06", "a radius above 0"]),
    broken("radius-huge", "0.06", "@1e308", ["found 1e+308", "a radius above 0"]),
    broken("radius-nan", "0.06", "@NaN", ["this is no JSON"]),
    broken("radius-large", "0.06", "@90", ["size parameter", "at most 200"]),
    broken("gain", "1.46", "[1.46, @-0.01]", ["exp(-iwt)", "positive imaginary part"]),
    broken("absorbing-host", "1.33", "[1.33, @0.01]", ["found 0.01; expected 0", "does not absorb"]),
    broken("invisible", "1.46", "@1.33", ["the index of the host", "scatter nothing"]),
    broken("material", "1.46", '@"glas-BK7"', ['unknown material "glas-BK7"; did you mean "glass-BK7"?']),
    broken("material-range", "1.46", '@"metal-Au"', ["from 360 to 830 nm; 300 nm"],
           args=("--out", "m.json", "--wavelengths", "300,500")),
    broken("fraction", "0.03", "@0.6", ["add up to 0.6", "up to 0.5"]),
    broken("count-huge", '"count": 4', '"count": @1e308', ["found 1e+308", "expected a number in"]),
    broken("unknowns", '"count": 4', '"count": @1000000', ["unknowns", "GB", "at most 2e+06"]),
    broken("no-room", FAT[FAT.index("0.03"):],
           '0.07}], "arrangement": @{"kind": "poisson-disc", "distance": 1.5, "count": 3, "mode": "medium"}}',
           ["3 particles at a volume fraction", "find no places"]),
    broken("overlap", '{"kind": "cut", "count": 4, "mode": "medium"}',
           '{"kind": "list", "particles": [{"center": [0, 0, 0]}, @{"center": [0, 0.1, 0]}]}',
           ["overlaps number 1 by 0.02 um"]),
    broken("kind", '"cut"', '@"cuts"', ['found "cuts"', 'did you mean "cut"?']),
    broken("memory", "0.03", "1e-8", ["p.json:4:18", "GB of memory, and this machine has"]),
    broken("thin", "0.03", "1e-9", ["lie in a ball of", "at most 1000 times"], errors=1),
]


# ---- Checks of what works ----

CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


def bulk(tool, folder, *args, text=FAT, status=0, **more):
    write(folder, "p.json", text)
    result = tool.run(("bulk", "p.json") + args, folder, **more)
    problems = health(result)
    assert not problems, "; ".join(problems) + ": " + result.err
    assert result.status == status, "exit status %d, not %d: %s" % (result.status, status, result.err.strip())
    return result


def read(folder, name):
    with open(os.path.join(folder, name), "rb") as f:
        return f.read()


@check
def bulk_writes_a_table_that_a_scene_renders(tool, folder):
    result = bulk(tool, folder, "--out", "milk.json", "--realisations", "6")
    table = json.loads(read(folder, "milk.json"))
    assert table["wavelengths"] == [450, 550, 650] and table["mode"] == "medium", table["wavelengths"]
    made = table["made"]
    assert made["input"] == json.loads(FAT) and made["realisations"] == 6 and made["seed"] == 1, made
    assert 0 < made["energy_error"] < 1e-10, made
    has(result.err, r"sigma_s \[1/mm\]", r"milk.json: 3 wavelengths; realisations: 6")
    assert sorted(os.listdir(folder)) == ["milk.json", "p.json"], "leaves %s" % os.listdir(folder)
    write(folder, "scene.pbrt", """Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "string filename" "a.exr"
        WorldBegin LightSource "infinite" MakeNamedMedium "milk" "string type" "homogeneous" "string bulk" "milk.json"
        MediumInterface "milk" "" Material "interface" Translate 0 0 3 Shape "sphere\"""")
    rendered = tool.run(["scene.pbrt", "--spp", "4", "--nthreads", "2"], folder)
    assert rendered.status == 0, rendered.err


@check
def the_documented_droplets_become_a_glass(tool, folder):
    with open(os.path.join(HERE, "..", "..", "docs", "bulk.md"), encoding="utf-8") as f:
        text = f.read()
    (particles,) = re.findall(r"```json\n(.*?)```", text, re.S)
    (scene,) = re.findall(r"```pbrt\n(.*?)```", text, re.S)
    result = bulk(tool, folder, "--dry-run", text=particles)
    assert result.out.decode().splitlines()[0] in text, "the document has another plan than " + result.out.decode()
    assert not result.err, "warns: " + result.err
    thick = bulk(tool, folder, "--dry-run", text=particles.replace('"count": 20', '"count": 100'))
    has(thick.err, "warning: a ball of 100 particles has an optical depth")
    bulk(tool, folder, "--out", "milk.json", "--realisations", "2", "--wavelengths", "400:700:150", text=particles)
    rows = {float(m.group(1)): float(m.group(2)) for m in re.finditer(r"^ +(\d{3})  ([\d.]+) \+- ", text, re.M)}
    table = json.loads(read(folder, "milk.json"))
    for wavelength, sigma in zip(table["wavelengths"], table["sigma_s"]):
        assert abs(sigma / rows[wavelength] - 1) < 0.4, "%s nm: %s, documented %s" % (wavelength, sigma, rows[wavelength])
    write(folder, "glass.pbrt", scene)
    rendered = tool.run(["glass.pbrt", "--resolution", "16x16", "--spp", "2", "--nthreads", "2"], folder)
    assert rendered.status == 0 and "warning" not in rendered.err, rendered.err
    result = bulk(tool, folder, "--out", "m.json", text=particles.replace("0.03", "0.6"), status=2)
    line = next(x for x in result.err.splitlines() if "error: " in x)
    assert line.replace("p.json", "droplets.json") in text, "the document has another message than " + line


@check
def bulk_does_not_depend_on_threads(tool, folder):
    for threads in "1", "2", "5":
        bulk(tool, folder, "--out", threads, "--realisations", "11", "--nthreads", threads, "--quiet")
    assert read(folder, "1") == read(folder, "2") == read(folder, "5"), "tables differ"
    bulk(tool, folder, "--out", "other", "--realisations", "11", "--seed", "2", "--quiet")
    assert read(folder, "1") != read(folder, "other"), "two seeds, one table"


def realisations_of(result):
    """How many a run says that it has done. None on a machine so busy that it had just begun."""
    if "stopped by a signal; nothing is written" in result.err:
        return 0
    done = re.search(r"stopped by a signal after (\d+) realisations; m.json.part holds them, and --resume", result.err)
    assert done, result.err
    return int(done.group(1))


def interrupted(tool, folder, number, status):
    """Stopped, the table of before stays, and going on by other threads gives the bytes of an undisturbed run."""
    write(folder, "m.json", "kept")
    more = ("--out", "m.json", "--realisations")
    result = bulk(tool, folder, *more, "1000000", status=status, signal_after=(tool.moment(1), number))
    assert result.seconds < 15, "took %.1f s" % result.seconds
    done = realisations_of(result)
    assert read(folder, "m.json") == b"kept"
    count = str(done + 5)
    bulk(tool, folder, *more, count, "--resume", "--nthreads", "1")
    assert sorted(os.listdir(folder)) == ["m.json", "p.json"], "leaves %s" % os.listdir(folder)
    bulk(tool, folder, "--out", "whole.json", "--realisations", count, "--nthreads", "3")
    assert read(folder, "m.json") == read(folder, "whole.json"), "going on gives another table"


@check
def bulk_goes_on_after_an_interrupt(tool, folder):
    interrupted(tool, folder, signal.SIGINT, 130)


@check
def bulk_goes_on_after_termination(tool, folder):
    interrupted(tool, folder, signal.SIGTERM, 143)


SIZES = FAT.replace('"seed": 1', '"seed": 1, "sizes": [2, 3, 4]').replace("450, 650, 100", "550")


ORIENTED = """{ "wavelengths": [550], "host": {"index": 1},
  "species": [{"name": "water", "index": [1.33, 0.01], "radius": 0.06, "volume fraction": 0.05}],
  "arrangement": {"kind": "disc", "deviations": [0.2, 0.2, 0.08], "count": 3, "mode": "MODE", "oriented": true,
                  "incidences": 3, "azimuths": 5} }"""


@check
def bulk_goes_on_with_oriented_ensembles(tool, folder):
    text = ORIENTED.replace("MODE", "medium")
    stopped = bulk(tool, folder, "--out", "m.json", "--realisations", "1000000", text=text, status=130,
                   signal_after=(tool.moment(1), signal.SIGINT))
    count = str(max(16, realisations_of(stopped) + 5))
    bulk(tool, folder, "--out", "m.json", "--realisations", count, "--resume", "--nthreads", "1", text=text)
    assert sorted(os.listdir(folder)) == ["m.exr", "m.json", "p.json"], "leaves %s" % os.listdir(folder)
    bulk(tool, folder, "--out", "w.json", "--realisations", count, "--nthreads", "3", text=text)
    # The file names its image; all else is the same.
    assert read(folder, "m.json") == read(folder, "w.json").replace(b"w.exr", b"m.exr"), "another table"
    assert read(folder, "m.exr") == read(folder, "w.exr"), "another image"
    bulk(tool, folder, "--out", "c.json", "--realisations", str(int(count) - 1), text=text)
    assert read(folder, "c.exr") != read(folder, "w.exr"), "the control is the same"


@check
def bulk_has_all_limits_for_oriented_ensembles(tool, folder):
    text = ORIENTED.replace("MODE", "aggregate")
    made = lambda name: json.loads(read(folder, name))["made"]["realisations"]
    for name, threads in ("a.json", "1"), ("b.json", "3"):
        bulk(tool, folder, "--out", name, "--error", "2%", "--nthreads", threads, text=text)
    assert read(folder, "a.exr") == read(folder, "b.exr"), "the error ends at another number"
    bulk(tool, folder, "--out", "c.json", "--error", "1.2%", text=text)
    assert made("a.json") % 8 == made("c.json") % 8 == 0 and made("c.json") > made("a.json") >= 16, made("c.json")
    result = bulk(tool, folder, "--out", "d.json", "--time", "0.4s", text=text)
    assert result.seconds < 15 and made("d.json") >= 1, "took %.1f s" % result.seconds
    result = bulk(tool, folder, "--out", "e.json", "--time", "0.3s", "--error", "0.001%", text=text, status=5)
    has(result.err, "error: the time came before the error 0.001%; e.json is valid")
    result = bulk(tool, folder, "--out", "f.json", "--realisations", "2", "--check-degree", text=text)
    has(result.err, r"degree \d+ instead of \d+ at 550 nm")
    chapter = bulk(tool, folder, "--out", "g.json", "--realisations", "3", text=ORIENTED.replace("MODE", "chapter"))
    has(chapter.err, 'warning: the average "chapter" does not conserve energy')
    assert "conserve" not in result.err, "warns of an average that does"


@check
def bulk_plans_all_directions_of_oriented_ensembles(tool, folder):
    def seconds(incidences):
        text = ORIENTED.replace("MODE", "aggregate").replace('"count": 3', '"count": 30')
        plan = bulk(tool, folder, "--dry-run", "--nthreads", "2",
                    text=text.replace('"incidences": 3', '"incidences": %d' % incidences)).out.decode()
        has(plan, "%d incidences, %d angles, 5 azimuths" % (incidences, 2 * incidences - 1))
        found = re.search(r"a solution: ([\d.:]+)( s)? a realisation", plan)
        return sum(float(x) * 60 ** i for i, x in enumerate(reversed(found.group(1).split(":")))), plan
    (few, _), (many, plan) = seconds(3), seconds(60)
    assert many > 8 * few, plan


@check
def bulk_says_what_it_cannot_report_before_the_work(tool, folder):
    for text in FAT, ORIENTED.replace("MODE", "medium"):
        write(folder, "file", "a file")
        os.makedirs(os.path.join(folder, "page", "report.html"), exist_ok=True)
        long = ("--out", "m.json", "--realisations", "1000000", "--report")
        has(bulk(tool, folder, *long, "file", text=text, status=3).err, "file: is no folder")
        has(bulk(tool, folder, *long, "no/page", text=text, status=3).err, "this folder cannot be made")
        has(bulk(tool, folder, *long, "page", text=text, status=3).err, "report.html.*is a folder")
        has(bulk(tool, folder, *long, "m.json.part", text=text, status=1).err, "--report")
    has(bulk(tool, folder, "--out", "m.exr", "--realisations", "1000000", text=text, status=1).err, "does not end in .exr")


@check
def bulk_goes_on_amid_several_sizes(tool, folder):
    interrupted_run = bulk(tool, folder, "--out", "m.json", "--realisations", "1000000", "--time", "1h", "--nthreads", "1",
                           text=SIZES, status=130, signal_after=(tool.moment(1), signal.SIGINT))
    first = realisations_of(interrupted_run)
    bulk(tool, folder, "--out", "m.json", "--realisations", str(first + 2), "--resume", text=SIZES)
    bulk(tool, folder, "--out", "whole.json", "--realisations", str(first + 2), "--nthreads", "2", text=SIZES)
    assert read(folder, "m.json") == read(folder, "whole.json"), "going on gives another table"
    made = json.loads(read(folder, "m.json"))["made"]
    assert [s.get("particles") for s in made["sizes"]] == [2, 3, 4, None], made["sizes"]


@check
def bulk_refuses_checkpoints_that_are_not_its_own(tool, folder):
    long = ("--out", "m.json", "--realisations", "1000000")
    bulk(tool, folder, *long, status=130, signal_after=(tool.moment(1), signal.SIGINT))
    part = read(folder, "m.json.part")
    # Hours of work are not overwritten.
    result = bulk(tool, folder, *long, status=3)
    has(result.err, "m.json.part", "--resume goes on with it")
    for other in [FAT.replace("1.46", "1.47"), FAT.replace('"seed": 1', '"seed": 2')]:
        result = bulk(tool, folder, *long, "--resume", text=other, status=3)
        has(result.err, "m.json.part: this checkpoint is of other particles")
    result = bulk(tool, folder, *long, "--resume", "--wavelengths", "500", status=3)
    has(result.err, "m.json.part: this checkpoint is of other particles")
    result = bulk(tool, folder, "--out", "m.json", "--realisations", "2", "--resume", status=1)
    has(result.err, r"at least \d+, as m.json.part has them already")
    assert read(folder, "m.json.part") == part, "the checkpoint has changed"
    for damaged, says in [(part[:-9], "is damaged"), (part[:5000] + b"x" + part[5001:], "is damaged"),
                          (b"", "is no checkpoint"), (b"lacquer", "is no checkpoint")]:
        write(folder, "m.json.part", damaged)
        has(bulk(tool, folder, *long, "--resume", status=3).err, says)
    os.remove(os.path.join(folder, "m.json.part"))
    has(bulk(tool, folder, "--out", "m.json", "--realisations", "3", "--resume").err, "there is no m.json.part")


@check
def bulk_tells_what_it_would_do(tool, folder):
    result = bulk(tool, folder, "--dry-run")
    has(result.out.decode(), r"4 particles in a ball of 0\.\d+ um, kR = ", r"degree \d+ of each, \d+ of all: .* unknowns",
        "memory .* GB", r"products a solution: .* a realisation, .* for 50")
    assert not result.err and os.listdir(folder) == ["p.json"], result.err
    thick = FAT.replace("0.06", "0.5").replace('"count": 4', '"count": 100').replace("0.03", "0.2")
    result = bulk(tool, folder, "--dry-run", text=thick)
    has(result.err, "warning: a ball of 100 particles has an optical depth of .* expected at most 0.3")
    wide = FAT.replace("0.06", "4").replace('"count": 4', '"count": 1').replace("medium", "aggregate")
    result = bulk(tool, folder, "--dry-run", text=wide.replace("0.03", "0.3"))
    has(result.err, "warning: waves of degree .* lose digits")
    several = bulk(tool, folder, "--dry-run", text=SIZES).out.decode()
    has(several, "^2 particles", "\n3 particles", "\n4 particles")


@check
def bulk_ends_by_error_and_by_time(tool, folder):
    bulk(tool, folder, "--out", "a.json", "--error", "10%", "--nthreads", "1")
    bulk(tool, folder, "--out", "b.json", "--error", "0.1", "--nthreads", "3")
    assert read(folder, "a.json") == read(folder, "b.json"), "the error ends at another number"
    few = json.loads(read(folder, "a.json"))["made"]["realisations"]
    bulk(tool, folder, "--out", "c.json", "--error", "2%")
    more = json.loads(read(folder, "c.json"))["made"]["realisations"]
    assert few % 8 == more % 8 == 0 and few >= 16 and more > 2 * few, "%d and %d realisations" % (few, more)
    result = bulk(tool, folder, "--out", "d.json", "--time", "0.4s")
    assert result.seconds < 15, "took %.1f s" % result.seconds
    done = json.loads(read(folder, "d.json"))["made"]["realisations"]
    assert done > 2, done
    bulk(tool, folder, "--out", "e.json", "--realisations", str(done))
    assert read(folder, "d.json") == read(folder, "e.json"), "the clock changes the table"
    result = bulk(tool, folder, "--out", "f.json", "--time", "0.3s", "--error", "0.001%", status=5)
    has(result.err, "error: the time came before the error 0.001%; f.json is valid")
    json.loads(read(folder, "f.json"))


@check
def bulk_extrapolates_over_sizes(tool, folder):
    result = bulk(tool, folder, "--out", "m.json", "--realisations", "12", text=SIZES)
    has(result.err, "2 particles, R = ", "3 particles, R = ", "4 particles, R = ", "extrapolated to 1/R = 0")
    table = json.loads(read(folder, "m.json"))
    last = table["made"]["sizes"][-1]
    assert table["sigma_s"] == last["sigma_s"], "the table has other coefficients"
    assert table["standard_error"]["sigma_s"] == last["standard_error"]["sigma_s"]
    largest = table["made"]["sizes"][-2]
    assert table["g"] == largest["g"], "the phase function is not that of the largest ball"
    # By hand, from the values in the file: weighted least squares in 1/R.
    sizes = table["made"]["sizes"][:-1]
    x = [1 / s["radius_um"] for s in sizes]
    y = [s["sigma_s"][0] for s in sizes]
    w = [s["standard_error"]["sigma_s"][0] ** -2 for s in sizes]
    mx, my = (sum(a * b for a, b in zip(w, v)) / sum(w) for v in (x, y))
    slope = sum(a * (b - mx) * (c - my) for a, b, c in zip(w, x, y)) / sum(a * (b - mx) ** 2 for a, b in zip(w, x))
    expected = my - slope * mx
    assert abs(last["sigma_s"][0] / max(expected, 0) - 1) < 1e-6, (last["sigma_s"], expected)


@check
def bulk_checks_its_degree(tool, folder):
    # Two metal spheres that touch need more degrees than two apart: the change must be seen.
    close = FAT.replace('{"kind": "cut", "count": 4, "mode": "medium"}', """{"kind": "list", "mode": "aggregate",
        "particles": [{"center": [0, 0, 0]}, {"center": [0, 0, 0.12]}]}""").replace("1.46", "[0.2, 3.5]")
    far = close.replace("0.12]", "3]")
    changes = []
    for text in close, far:
        result = bulk(tool, folder, "--out", "m.json", "--realisations", "2", "--check-degree", text=text)
        found = re.search(r"degree (\d+) instead of (\d+) at 450 nm: C_ext ([-+.e\d]+) %, C_sca ([-+.e\d]+) %", result.err)
        assert found and int(found.group(1)) == int(found.group(2)) + 2, result.err
        changes.append(abs(float(found.group(3))))
    assert changes[0] > 0.1 and changes[1] < 1e-3, changes


@check
def bulk_survives_odd_numbers(tool, folder):
    odd = ["-0.0", "1e308", "5e-324", "1e-30", "9007199254740993", "null", "[]", "[[1e308]]"]
    for value in ['[450, 650, 100]', '1.33', '1.46', '0.06', '0.03', '4', "1\n"]:
        assert value in FAT, value
        for number in odd:
            text = FAT.replace(value, number, 1) if value != "4" else FAT.replace('"count": 4', '"count": ' + number)
            write(folder, "p.json", text)
            result = tool.run(["bulk", "p.json", "--out", "m.json", "--realisations", "2", "--quiet"], folder)
            problems = health(result)
            assert not problems and result.status in (0, 2), "%s for %s: %s %d: %s" % (number, value, problems, result.status,
                                                                                         result.err)
