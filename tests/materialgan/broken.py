#!/usr/bin/env python3
"""Runs lacquer-materialgan on files that are no generators, on damaged ones, and with wrong options; and judges its answers.

usage: broken.py LACQUER-MATERIALGAN [NAME ...] [-v]

The cases are judged as those of tests/broken/run.py: exit status, one message that says what was expected, nothing left behind,
no crash, at most 20 s and 2 GB. Here there are checks of right runs as well, and that a file that is there stays whole when
another cannot be written. Prints what is wrong and closes with "N passed, N failed".
"""
import json
import math
import os
import random
import struct
import sys
import zlib

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "broken"))
from run import Case, Tool, run_case, run_check  # noqa: E402
from captures import checks_with  # noqa: E402

RESOLUTION, BASE, MOST, LATENT, MAPPING = 16, 64, 4, 4, 1
METADATA = {"format": "lacquer-stylegan2", "resolution": RESOLUTION, "fmapsBase": BASE, "fmapsMax": MOST, "wDim": LATENT,
            "mappingLayers": MAPPING, "lrMultiplier": 0.1, "roughnessMin": -1, "roughnessMax": 1}


# ---- files -------------------------------------------------------------------------------------------------------------------

def generator_shapes():
    """Names and shapes of the tensors of the smallest generator."""
    def maps(res):
        return min(BASE // res, MOST)

    shapes = {"mapping.dense0.fc.weight": (LATENT, LATENT), "mapping.dense0.bias": (LATENT,),
              "synthesis.early_layer.const": (1, maps(4), 4, 4), "truncation.w_avg": (LATENT,)}

    def styled(name, kernel, fan_in, fan_out):
        shapes.update({name + ".weight": (kernel, kernel, fan_in, fan_out), name + ".bias": (fan_out,),
                       name + ".style.fc.weight": (fan_in, LATENT), name + ".style.bias": (fan_in,)})

    resolutions = [4]
    while resolutions[-1] < RESOLUTION:
        resolutions += [2 * resolutions[-1]] * 2
    for i, res in enumerate(resolutions):
        styled(f"synthesis.layer{i}", 3, maps(res // 2 if i % 2 else res), maps(res))
        shapes[f"synthesis.layer{i}.noise_strength"] = ()
        if i % 2 == 0:
            styled(f"synthesis.output{i // 2}", 1, maps(res), 9)
    return shapes


def numbers(shape, seed):
    source = random.Random(seed)
    return [source.gauss(0, 1) for _ in range(math.prod(shape))]


def pack(header, data):
    text = header if isinstance(header, bytes) else json.dumps(header).encode()
    return struct.pack("<Q", len(text)) + text + data


def tensors(values, metadata=None, change=None):
    """A file of tensors; values: name -> (shape, numbers). change(header) alters what the header says."""
    header, data = {"__metadata__": {key: str(value) for key, value in (metadata or {}).items()}}, b""
    for name, (shape, these) in values.items():
        part = struct.pack("<%df" % len(these), *these)
        header[name] = {"dtype": "F32", "shape": list(shape), "data_offsets": [len(data), len(data) + len(part)]}
        data += part
    if change:
        header = change(header) or header
    return pack(header, data)


def generator(metadata=None, change=None, **values):
    """A generator of random numbers, some of them, or of what it says of itself, replaced; "" leaves one out."""
    all_values = {name: (shape, numbers(shape, name)) for name, shape in generator_shapes().items()}
    for name, these in values.items():
        all_values[name] = these
    all_values = {name: these for name, these in all_values.items() if these}
    said = {key: value for key, value in {**METADATA, **(metadata or {})}.items() if value != ""}
    return tensors(all_values, said, change)


def png(width, height, channels=3, value=128):
    """Bytes of an image with 8 bits of one value."""
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    kind = {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    rows = (b"\0" + bytes([value]) * (width * channels)) * height
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def pfm(values):
    return b"PF\n16 16\n-1\n" + struct.pack("<%df" % len(values), *values)


GOOD = generator()
LATENTS = {"wPlus": ((1, 6, LATENT), numbers((1, 6, LATENT), 1)),
           **{"noise%d" % i: ((1, 1, res, res), numbers((1, 1, res, res), i)) for i, res in enumerate([4, 8, 8, 16, 16])}}
MAPS = {"dif.png": png(16, 16), "nom.png": png(16, 16), "rgh.png": png(16, 16, 1), "spe.png": png(16, 16)}


def maps_with(**changed):
    files = {"maps": None, "g": GOOD}
    files |= {"maps/" + name: content for name, content in MAPS.items()}
    for name, content in changed.items():
        path = "maps/" + name + ".png"
        files[path] = content
        if content == "":
            del files[path]
    return files


# ---- cases -------------------------------------------------------------------------------------------------------------------

def bad_file(name, content, says):
    """A file that each command refuses in the same way; `info` is the shortest."""
    return Case("file-" + name, None, ["g", *says], 3, ["info", "g"], {"g": content}, errors=1)


def deep(kind):
    return b'{"a":' * 200000 if kind == "objects" else b"[" * 1000000


def entry(name="mapping.dense0.bias", **fields):
    """Something else in what the header says of a tensor."""
    def change(header):
        header[name].update(fields)
    return change


def sparse(path, size):
    def prepare(folder):
        with open(os.path.join(folder, path), "r+b") as file:
            file.truncate(size)
    return prepare


def overlap(header):
    header["mapping.dense0.bias"]["data_offsets"] = header["truncation.w_avg"]["data_offsets"]


def twice(header):
    text = json.dumps(header)
    return (text[:-1] + ', "truncation.w_avg": ' + json.dumps(header["truncation.w_avg"]) + "}").encode()


def bad_metadata(name, key, value, *says):
    return bad_file("says-" + name, generator({key: value}), [key, *says])


FILES = [
    bad_file("empty", b"", ["too short"]),
    bad_file("short", b"1234567", ["too short"]),
    bad_file("text", b"no tensors, but a text of some length", ["is no file of tensors (safetensors)"]),
    bad_file("png", png(64, 64), ["is no file of tensors (safetensors)"]),
    bad_file("zip", b"PK\x03\x04" + bytes(100), ["is no file of tensors (safetensors)"]),
    bad_file("folder", None, ["is a folder"]),
    bad_file("header-huge", struct.pack("<Q", 2 ** 64 - 1) + bytes(100), ["18446744073709551615 bytes", "16777216"]),
    bad_file("header-above-limit", struct.pack("<Q", 2 ** 24 + 1) + bytes(100), ["the limit is 16777216"]),
    bad_file("header-longer-than-the-file", struct.pack("<Q", 1000) + b"{}" + bytes(100), ["is cut off", "1000", "102"]),
    bad_file("header-none", struct.pack("<Q", 0), ["not JSON"]),
    bad_file("header-cut", GOOD[:100], ["is cut off"]),
    bad_file("header-no-json", pack(b"{'format'}", b""), ["not JSON"]),
    bad_file("header-list", pack(b"[1, 2]", b""), ["not JSON"]),
    bad_file("header-not-utf8", pack(b'{"\xff\xfe": 1}', b""), ["not JSON"]),
    bad_file("header-deep-arrays", pack(deep("arrays"), b""), ["nested too deeply"]),
    bad_file("header-deep-objects", pack(deep("objects"), b""), ["nested too deeply"]),
    bad_file("header-deep-metadata", pack(b'{"__metadata__":' + deep("arrays"), b""), ["nested too deeply"]),
    bad_file("header-many-numbers", pack(b'{"a":{"dtype":"F32","data_offsets":[0,0],"shape":[' + b"1," * 4000000 + b"1]}}", b""),
             ["4000001 dimensions"]),
    bad_file("header-of-spaces", pack(b"{}" + b" " * (2 ** 24 - 2), b""), ["is no generator"]),
    bad_file("no-tensors", pack(b"{}", b""), ['format is ""', '"lacquer-stylegan2" is needed']),
    bad_file("tensor-is-a-number", pack({"a": 3}, b""), ['"a"', "dtype, shape and data_offsets"]),
    bad_file("tensor-name-with-control-characters", pack({"a\x1b[31m\n": 3}, b""), ["a?[31m?"]),
    bad_file("tensor-name-long", pack({"a" * 100000: 3}, b""), ["aaaa..."]),
    bad_file("tensor-twice", generator(change=twice), ['"truncation.w_avg" twice']),
    bad_file("tensors-overlap", generator(change=overlap), ["in the same bytes"]),
    bad_file("offsets-beyond", generator(change=entry(data_offsets=[0, 10 ** 12])), ["mapping.dense0.bias", "1000000000000"]),
    bad_file("offsets-reversed", generator(change=entry(data_offsets=[8, 4])), ["bytes 8 to 4"]),
    bad_file("offsets-negative", generator(change=entry(data_offsets=[-8, 4])), ["mapping.dense0.bias"]),
    bad_file("offsets-fraction", generator(change=entry(data_offsets=[0.5, 4])), ["mapping.dense0.bias"]),
    bad_file("offsets-one", generator(change=entry(data_offsets=[0])), ["mapping.dense0.bias"]),
    bad_file("offsets-do-not-fit", generator(change=lambda h: h["mapping.dense0.bias"]["data_offsets"].__setitem__(
        1, h["mapping.dense0.bias"]["data_offsets"][1] - 4)), ["12 bytes", "mapping.dense0.bias"]),
    bad_file("shape-product-overflows", generator(change=entry("synthesis.early_layer.const", shape=[2 ** 62, 4, 4, 4])),
             ["4611686018427387904 x 4 x 4 x 4", "1 x 4 x 4 x 4 is needed"]),
    bad_file("shape-beyond-64-bits", generator(change=entry(shape=[2 ** 70])), ["mapping.dense0.bias"]),
    bad_file("shape-negative", generator(change=entry(shape=[-4])), ["mapping.dense0.bias"]),
    bad_file("shape-text", generator(change=entry(shape="4")), ["mapping.dense0.bias"]),
    bad_file("shape-wrong", generator(**{"mapping.dense0.fc.weight": ((2, 8), numbers((2, 8), 1))}), ["2 x 8", "4 x 4 is needed"]),
    bad_file("shape-of-another-rank", generator(change=entry("mapping.dense0.fc.weight", shape=[16])), ["16", "4 x 4 is needed"]),
    bad_file("type-double", generator(change=entry(dtype="F64")), ["F64", "F32 and F16"]),
    bad_file("type-bfloat", generator(change=entry(dtype="BF16")), ["BF16"]),
    bad_file("type-unknown", generator(change=entry(dtype="\x1b[2J" + "x" * 1000)), ["?[2Jxxx"]),
    bad_file("type-number", generator(change=entry(dtype=32)), ["mapping.dense0.bias"]),
    bad_file("type-half-of-as-many-bytes", generator(change=entry(dtype="F16")), ["16 bytes", "F16"]),
    bad_file("nan", generator(**{"truncation.w_avg": ((LATENT,), [0, math.nan, 0, 0])}), ["truncation.w_avg", "not finite"]),
    bad_file("infinite", generator(**{"synthesis.layer3.bias": ((MOST,), [0, 0, -math.inf, 0])}), ["layer3.bias", "not finite"]),
    bad_file("deviation-zero", generator(**{"truncation.w_std": ((LATENT,), [1, 1, 0, 1])}), ["truncation.w_std", "above 0"]),
    bad_file("lacks-the-mean", generator(**{"truncation.w_avg": ""}), ['no tensor "truncation.w_avg"']),
    bad_file("lacks-a-layer", generator(**{"synthesis.layer4.weight": ""}), ['no tensor "synthesis.layer4.weight"']),
    bad_file("lacks-a-part-of-its-encoder", generator(**{"encoder.input.weight": ((MOST, 9, 3, 3), [0] * 324)}), ["encoder."]),
    bad_file("noise-of-another-size", generator(**{"synthesis.layer2.noise": ((1, 1, 4, 4), [0] * 16)}), ["1 x 1 x 8 x 8 is needed"]),
    bad_file("cut", GOOD[:-100], ["in bytes"]),
    bad_file("longer", GOOD + bytes(100), ["100 bytes behind its tensors"]),
    bad_file("state-of-a-training", generator({"training": "lacquer-training"}), ["state of a training"]),
    bad_metadata("format", "format", "other", '"other"'),
    bad_metadata("no-resolution", "resolution", "", "does not say"),
    bad_metadata("resolution-no-power-of-two", "resolution", 48, "power of two"),
    bad_metadata("resolution-zero", "resolution", 0, "from 8 to 1024"),
    bad_metadata("resolution-huge", "resolution", 1 << 30, "from 8 to 1024"),
    bad_metadata("resolution-text", "resolution", "16 or so", '"16 or so"'),
    bad_metadata("resolution-nan", "resolution", "nan", '"nan"'),
    bad_metadata("maps-zero", "fmapsMax", 0, "from 1 to 1024"),
    bad_metadata("latent-huge", "wDim", 1 << 20, "from 1 to 4096"),
    bad_metadata("mapping-negative", "mappingLayers", -1, "from 1 to 32"),
    bad_metadata("rate", "lrMultiplier", "inf", "from 1e-06 to 1"),
    bad_file("says-roughness-empty", generator({"roughnessMin": 0.5, "roughnessMax": -0.5}), ["roughness from 0.5 to -0.5"]),
    bad_file("says-more-resolution-than-it-has", generator({"resolution": 32}), ['no tensor "synthesis.layer5.weight"']),
    bad_file("says-more-maps-than-it-has", generator({"fmapsMax": 8, "fmapsBase": 128}), ["1 x 8 x 4 x 4 is needed"]),
    bad_file("says-more-latents-than-it-has", generator({"wDim": 8}), ["8 x 8 is needed"]),
    bad_file("says-more-mapping-than-it-has", generator({"mappingLayers": 2}), ['no tensor "mapping.dense1.fc.weight"']),
    bad_file("says-text-of-control-characters", generator({"format": "\x1b[2J\n"}), ["?[2J?"]),
    Case("file-none", None, ["no-such-file"], 3, ["info", "no-such-file"], errors=1),
    Case("file-pipe", None, ["g", "not a regular file"], 3, ["info", "g"],
         prepare=lambda folder: os.mkfifo(os.path.join(folder, "g")), errors=1),
    Case("file-sparse-of-zeros", None, ["g", "not JSON"], 3, ["info", "g"], {"g": b""}, prepare=sparse("g", 3 << 30), errors=1),
    Case("file-sparse-behind-tensors", None, ["g", "bytes behind its tensors"], 3, ["info", "g"], {"g": GOOD},
         prepare=sparse("g", 3 << 30), errors=1),
]

# Each weight is finite; what comes of them is not.
TOO_LARGE = generator(**{"synthesis.layer0.weight": ((3, 3, MOST, MOST), [3e38] * (9 * MOST * MOST)),
                         "synthesis.early_layer.const": ((1, MOST, 4, 4), [3e38] * (16 * MOST))})


def latents(name, content, says):
    return Case("latents-" + name, None, says, 3, ["morph", "g", "a", "b", "--out", "out"],
                {"g": GOOD, "a": None, "b": None, "a/latent.safetensors": tensors(LATENTS), "b/latent.safetensors": content},
                errors=1)


def project(name, says, status=3, args=("--out", "out"), **changed):
    return Case("maps-" + name, None, says, status, ["project", "g", "maps", *args], maps_with(**changed), errors=1)


RUNS = [
    Case("sample-of-too-large-weights", None, ["g", "not finite"], 3, ["sample", "g", "--out", "o"], {"g": TOO_LARGE, "o": None}, errors=1),
    Case("project-of-too-large-weights", None, ["g", "not finite"], 3, ["project", "g", "maps", "--out", "o"],
         {**maps_with(), "g": TOO_LARGE, "o": None}, errors=1),
    Case("sample-of-no-generator", None, ["g", "too short"], 3, ["sample", "g", "--out", "out"], {"g": b""}, errors=1),
    Case("sample-out-is-a-file", None, ["file", "is no folder"], 3, ["sample", "g", "--out", "file"], {"g": GOOD, "file": "kept"}, errors=1),
    Case("sample-out-below-nothing", None, ["no/out", "cannot be made"], 3, ["sample", "g", "--out", "no/out"], {"g": GOOD}, errors=1),
    Case("sample-out-cannot-be-written", None, ["/proc/out"], 3, ["sample", "g", "--out", "/proc/out"], {"g": GOOD}, errors=1),
    Case("sample-out-empty", None, ["--out"], 1, ["sample", "g", "--out", ""], {"g": GOOD}, errors=1),
    latents("empty", b"", ["latent.safetensors", "too short"]),
    latents("none", b"{}", ["latent.safetensors"]),
    latents("of-another-generator", tensors({**LATENTS, "wPlus": ((1, 7, 4), numbers((1, 7, 4), 1))}), ["1 x 7 x 4", "1 x 6 x 4 is needed"]),
    latents("nan", tensors({**LATENTS, "noise0": ((1, 1, 4, 4), [math.nan] * 16)}), ["noise0", "not finite"]),
    latents("lacking", tensors({"wPlus": LATENTS["wPlus"]}), ['no tensor "noise0"']),
    Case("latents-no-folder", None, ["no/latent.safetensors"], 3, ["morph", "g", "no", "no", "--out", "out"], {"g": GOOD}, errors=1),
    project("lacking", ["maps/spe.png"], spe=""),
    project("no-image", ["maps/rgh.png"], rgh=b"no image at all"),
    project("cut-image", ["maps/dif.png"], dif=png(16, 16)[:-30]),
    project("other-size", ["maps/nom.png", "8 x 8", "16 x 16"], nom=png(8, 8)),
    project("no-square", ["maps/dif.png", "16 x 8"], dif=png(16, 8)),
    project("huge", ["maps/dif.png", "2048 x 2048", "1024"], dif=png(2048, 2048, 1)),
    project("normals-of-one-channel", ["maps/nom.png", "1 channels"], nom=png(16, 16, 1)),
    project("nan", ["maps/dif.png", "not finite"], dif=pfm([math.nan] * 768)),
    project("not-of-the-generator", ["maps", "8 x 8", "16 x 16"], **{n[:3]: png(8, 8) for n in MAPS}),
    Case("maps-no-folder", None, ["no/dif.png"], 3, ["project", "g", "no", "--out", "out"], {"g": GOOD}, errors=1),
    project("are-the-output", ["maps", "another folder"], args=("--out", "maps")),
]


def usage(name, args, says, status=1, files=None):
    return Case("usage-" + name, None, says, status, args, files or {"g": GOOD}, errors=1)


TRAIN = ["train", "--out", "x", "--resolution", "16", "--maps", "4:4", "--batch", "2", "--nthreads", "1"]


def state(name, says, metadata=None, content=None):
    """A state to go on from that is none."""
    said = {**METADATA, "training": "lacquer-training", "recipe": "", "batch": 2, "seed": 1, "steps": 1, "seconds": 1, **(metadata or {})}
    return Case("state-" + name, None, ["x.training.safetensors", *says], 3, [*TRAIN, "--steps", "2", "--resume"],
                {"x.training.safetensors": tensors({}, said) if content is None else content}, errors=1)


OPTIONS = [
    usage("nothing", [], ["subcommand is required"]),
    usage("command", ["trian"], ['"trian"', '"train"?']),
    usage("option", ["info", "g", "--frobnicate"], ["--frobnicate"]),
    usage("no-file", ["info"], ["file is required"]),
    usage("no-out", ["sample", "g"], ["--out is required"]),
    usage("psi-nan", ["sample", "g", "--out", "o", "--psi", "nan"], ["--psi", "nan"]),
    usage("psi-large", ["sample", "g", "--out", "o", "--psi", "3"], ["--psi", "3"]),
    usage("count-zero", ["sample", "g", "--out", "o", "--count", "0"], ["--count", "0"]),
    usage("count-huge", ["sample", "g", "--out", "o", "--count", "1e12"], ["--count", "1e12"]),
    usage("seed-negative", ["sample", "g", "--out", "o", "--seed", "-1"], ["--seed"]),
    usage("threads", ["info", "g", "--nthreads", "-2"], ["--nthreads", "-2"]),
    usage("space", ["project", "g", "m", "--out", "o", "--space", "w++"], ["--space", '"w++"', "w+n"]),
    usage("iterations", ["project", "g", "m", "--out", "o", "--iterations", "0"], ["--iterations", "0"]),
    usage("steps-one", ["morph", "g", "a", "b", "--out", "o", "--steps", "1"], ["--steps", "1"]),
    usage("views", ["evaluate", "g", "--views", "2"], ["--views", "2"]),
    usage("train-without-end", ["train", "--out", "x"], ["--hours", "--steps"]),
    usage("train-with-two-ends", [*TRAIN, "--steps", "2", "--hours", "1"], ["--hours", "--steps"]),
    usage("train-hours-infinite", [*TRAIN, "--hours", "inf"], ["--hours", "inf"]),
    usage("train-hours-nan", [*TRAIN, "--hours", "nan"], ["--hours", "nan"]),
    usage("train-hours-negative", [*TRAIN, "--hours", "-1"], ["--hours", "-1"]),
    usage("train-steps-fraction", [*TRAIN, "--steps", "2.5"], ["--steps", "2.5"]),
    usage("train-resolution", [*TRAIN, "--steps", "2", "--resolution", "48"], ["--resolution", "48", "power of two"]),
    usage("train-maps-word", [*TRAIN, "--steps", "2", "--maps", "many"], ["--maps", "many", "MAX:MIN"]),
    usage("train-maps-reversed", [*TRAIN, "--steps", "2", "--maps", "4:8"], ["--maps", "4:8"]),
    usage("train-maps-huge", [*TRAIN, "--steps", "2", "--maps", "99999999999:1"], ["--maps"]),
    usage("train-batch-beyond-memory", [*TRAIN, "--steps", "2", "--resolution", "1024", "--batch", "4096"], ["--batch", "at most 16"]),
    usage("train-out-below-nothing", ["train", "--out", "no/x", "--steps", "1"], ["no/x", "does not exist"], 3),
    usage("train-out-is-a-folder", ["train", "--out", "x", "--steps", "1"], ["x", "is a folder"], 3, {"x": None}),
    usage("train-out-cannot-be-written", ["train", "--out", "/proc/x", "--steps", "1"], ["/proc/x"], 3),
    usage("train-out-empty", ["train", "--out", "", "--steps", "1"], ["--out"]),
    usage("train-state-is-a-folder", [*TRAIN, "--steps", "1"], ["x.training.safetensors", "is a folder"], 3,
          {"x.training.safetensors": None}),
    usage("train-over-another-training", [*TRAIN, "--steps", "1"], ["x.training.safetensors", "--resume goes on", "remove it"], 3,
          {"x.training.safetensors": b"hours of work"}),
    usage("train-preview-is-a-folder", [*TRAIN, "--steps", "1"], ["x.preview.png", "is a folder"], 3, {"x.preview.png": None}),
    Case("state-none", None, ["x.training.safetensors"], 3, [*TRAIN, "--steps", "2", "--resume"], errors=1),
    state("empty", ["too short"], content=b""),
    state("is-a-generator", ["no state of a training"], content=GOOD),
    state("of-other-materials", ["trained on other materials"], {"recipe": "other"}),
]

CASES = FILES + RUNS + OPTIONS


# ---- checks ------------------------------------------------------------------------------------------------------------------

def write(folder, name, content):
    with open(os.path.join(folder, name), "wb") as file:
        file.write(content)


def read(folder, *names):
    with open(os.path.join(folder, *names), "rb") as file:
        return file.read()


def expect(result, status, *says):
    assert result.status == status, f"exit status {result.status}, not {status}: {result.err}"
    for fragment in says:
        assert fragment in result.err, f"does not say {fragment!r}: {result.err}"


def train(tool, folder, *more):
    """A training ends with statistics over a thousand materials, which takes a while where others compute."""
    return tool.run([*TRAIN, *more], folder, timeout=120)


def a_good_generator_works(tool, folder):
    """Negative control of all that is above: what is changed there is whole here."""
    write(folder, "g", GOOD)
    result = tool.run(["info", "g"], folder)
    expect(result, 0)
    assert b"16 x 16" in result.out, result.out
    expect(tool.run(["sample", "g", "--out", "s", "--count", "40", "--quiet", "--nthreads", "1"], folder, timeout=120), 0)
    assert len(os.listdir(os.path.join(folder, "s"))) == 41
    expect(tool.run(["project", "g", "s/0001", "--out", "p", "--iterations", "3", "--quiet", "--nthreads", "1"], folder, timeout=120), 0)
    os.makedirs(os.path.join(folder, "a"))
    write(folder, "a/latent.safetensors", tensors(LATENTS))
    expect(tool.run(["morph", "g", "a", "p", "--out", "m", "--steps", "40", "--nthreads", "1"], folder, timeout=120), 0)
    assert len(os.listdir(os.path.join(folder, "m"))) == 41


def notes_of_a_generator_are_printed_without_control_characters(tool, folder):
    write(folder, "g", generator({"source": "\x1b[2J\n" + "x" * 100000, "\x07key": "y"}))
    result = tool.run(["info", "g"], folder)
    expect(result, 0)
    assert b"\x1b" not in result.out and b"\x07" not in result.out and len(result.out) < 2000, result.out[:300]


def a_training_that_cannot_be_written_leaves_what_was_there(tool, folder):
    """Files are limited to fewer bytes than a generator has: the first that is written fails, and nothing else changes."""
    expect(train(tool, folder, "--steps", "2", "--quiet"), 0)
    before = {name: read(folder, name) for name in sorted(os.listdir(folder))}
    assert sorted(before) == ["x", "x.preview.png", "x.training.safetensors"], sorted(before)
    limited = Tool.__new__(Tool)
    limited.path, limited.sanitized = "/bin/sh", True
    args = " ".join([tool.path, *TRAIN, "--steps", "3", "--resume", "--quiet"])
    result = limited.run(["-c", "trap '' XFSZ; ulimit -f 8; exec " + args], folder, timeout=120)
    expect(result, 3, "x.training.safetensors")
    after = {name: read(folder, name) for name in sorted(os.listdir(folder))}
    assert after == before, "files have changed"
    expect(train(tool, folder, "--steps", "3", "--resume", "--quiet"), 0)


def broken_states_of_a_training_are_refused(tool, folder):
    expect(train(tool, folder, "--steps", "2", "--quiet"), 0)
    whole = read(folder, "x.training.safetensors")
    length = struct.unpack("<Q", whole[:8])[0]
    header, data = json.loads(whole[8:8 + length]), whole[8 + length:]

    def refused(change, *says):
        changed = json.loads(json.dumps(header))
        changed_data = bytearray(data)
        change(changed, changed_data)
        write(folder, "x.training.safetensors", pack(changed, bytes(changed_data)))
        expect(train(tool, folder, "--steps", "3", "--resume", "--quiet"), 3, "x.training.safetensors", *says)

    for key, value in (("batch", "0"), ("batch", "1000000000"), ("batch", "many"), ("steps", "-1"), ("steps", "9" * 18),
                       ("seconds", "inf"), ("seconds", "nan"), ("seed", "x"), ("resolution", "17")):
        refused(lambda h, _, k=key, v=value: h["__metadata__"].update({k: v}), key if value != "0" else "no images")
    for key in ("batch", "steps", "seconds", "seed", "recipe"):
        refused(lambda h, _, k=key: h["__metadata__"].pop(k))
    for name in ("adam.first0", "adam.second3", "now.mapping.dense0.bias", "average.encoder.z.bias"):
        # The bytes stay, under another name.
        refused(lambda h, _, n=name: h.update({"other": h.pop(n)}), name)
        begin = header[name]["data_offsets"][0]
        refused(lambda _, d, b=begin: d.__setitem__(slice(b, b + 4), struct.pack("<f", math.nan)), name, "not finite")
    begin = header["adam.second0"]["data_offsets"][0]
    refused(lambda _, d: d.__setitem__(slice(begin, begin + 4), struct.pack("<f", -1)), "adam.second0", "below 0")


def a_file_that_is_cut_anywhere_is_refused(tool, folder):
    for part in range(8):
        write(folder, "g", GOOD[:len(GOOD) * part // 8])
        result = tool.run(["info", "g"], folder)
        expect(result, 3, "g: ")
        assert result.err.count("\n") == 1, result.err


def bytes_that_change_never_crash(tool, folder):
    """Some mutations of the header; the fuzz target of tests/fuzz tries millions of the reader alone."""
    source = random.Random(7)
    length = struct.unpack("<Q", GOOD[:8])[0]
    for _ in range(12):
        mutated = bytearray(GOOD)
        for _ in range(source.choice([1, 2, 5])):
            mutated[source.randrange(8 + length)] = source.choice([source.randrange(256), 0x22, 0x5B, 0x7B, 0x39])
        write(folder, "g", bytes(mutated))
        result = tool.run(["info", "g"], folder)
        assert result.status in (0, 3), f"{result.status}: {result.err}"
        assert result.err.count("\n") == (result.status == 3), result.err


CHECKS = [a_good_generator_works, notes_of_a_generator_are_printed_without_control_characters,
          a_training_that_cannot_be_written_leaves_what_was_there, broken_states_of_a_training_are_refused,
          a_file_that_is_cut_anywhere_is_refused, bytes_that_change_never_crash, *checks_with(GOOD)]


def main():
    names = [a for a in sys.argv[2:] if not a.startswith("-")]
    work = [(c.name, run_case, c) for c in CASES] + [(f.__name__.replace("_", "-"), run_check, f) for f in CHECKS]
    assert len({name for name, _, _ in work}) == len(work), "two cases of one name"
    tool, passed, failed = Tool(sys.argv[1]), 0, 0
    for name, run, what in work:
        if names and not any(n in name for n in names):
            continue
        problems, result = run(what, tool)
        if "-v" in sys.argv:
            print(f"---- {name}: exit {result.status}, {result.seconds:.2f} s, {result.peak_bytes >> 20} MB\n{result.err}", end="")
        passed, failed = passed + (not problems), failed + bool(problems)
        if problems:
            print(f"FAIL  {name}: {'; '.join(problems)}  [got: {result.err.strip()[:240]}]")
        sys.stdout.flush()
    print(f"{passed} passed, {failed} failed")
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
