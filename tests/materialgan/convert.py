#!/usr/bin/env python3
"""Checks scripts/convert-materialgan: both kinds of files that torch.save() wrote, and files that are bad.

usage: convert.py
PyTorch is not needed: a file is written as it would write one, with doubles for its classes. Prints what is wrong and a
closing line 'N passed, N failed'; says so where there is no numpy.
"""
import collections
import io
import json
import os
import pickle
import resource
import struct
import subprocess
import sys
import tempfile
import types
import zipfile

try:
    import numpy
except ImportError:
    print("0 passed, 0 failed, 1 skipped: no numpy")
    sys.exit(0)

HERE = os.path.dirname(os.path.abspath(__file__))
CONVERT = os.path.join(HERE, "..", "..", "scripts", "convert-materialgan")
REFERENCE = os.path.join(HERE, "data", "generator_reference.safetensors")

torch, utils = types.ModuleType("torch"), types.ModuleType("torch._utils")
torch._utils = utils


class FloatStorage:
    """A storage: some numbers with a key."""

    def __init__(self, key, values):
        self.key, self.values = key, numpy.asarray(values, "<f4")


def _rebuild_tensor_v2(*_):
    raise NotImplementedError


FloatStorage.__module__, FloatStorage.__qualname__, torch.FloatStorage = "torch", "FloatStorage", FloatStorage
_rebuild_tensor_v2.__module__, utils._rebuild_tensor_v2 = "torch._utils", _rebuild_tensor_v2
sys.modules |= {"torch": torch, "torch._utils": utils}


class View:
    def __init__(self, storage, offset, size, stride):
        self.arguments = (storage, offset, size, stride, False, collections.OrderedDict())

    def __reduce__(self):
        return _rebuild_tensor_v2, self.arguments


class Pickler(pickle.Pickler):
    def __init__(self, file, is_zip):
        super().__init__(file, protocol=2)
        self.is_zip, self.storages = is_zip, {}

    def persistent_id(self, obj):
        if not isinstance(obj, FloatStorage):
            return None
        self.storages[obj.key] = obj
        saved = ("storage", FloatStorage, obj.key, "cpu", len(obj.values))
        return saved if self.is_zip else saved + (None,)


def save_zip(path, content):
    file = io.BytesIO()
    pickler = Pickler(file, True)
    pickler.dump(content)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("archive/data.pkl", file.getvalue())
        for key, storage in pickler.storages.items():
            archive.writestr(f"archive/data/{key}", storage.values.tobytes())


def save_legacy(path, content):
    with open(path, "wb") as file:
        for head in (0x1950A86A20F9469CFC6C, 1001, {"little_endian": True}):
            pickle.dump(head, file, protocol=2)
        pickler = Pickler(file, False)
        pickler.dump(content)
        pickle.dump(sorted(pickler.storages), file, protocol=2)
        for _, storage in sorted(pickler.storages.items()):
            file.write(struct.pack("<q", len(storage.values)) + storage.values.tobytes())


def read(path):
    """Tensors and metadata of a file of ours."""
    with open(path, "rb") as file:
        data = file.read()
    length = struct.unpack("<Q", data[:8])[0]
    header = json.loads(data[8:8 + length])
    metadata = header.pop("__metadata__")
    tensors = {}
    for name, entry in header.items():
        begin, end = entry["data_offsets"]
        tensors[name] = numpy.frombuffer(data[8 + length + begin:8 + length + end], "<f4").reshape(entry["shape"])
    return tensors, metadata


def state_of(tensors):
    """As a network gives it: in the order of its parts, one tensor transposed in memory, two in one storage."""
    state = collections.OrderedDict()
    for i, (name, values) in enumerate(tensors.items()):
        if i % 2 == 0 and values.ndim == 2:
            rows, columns = values.shape
            storage = FloatStorage(str(i), numpy.concatenate((numpy.zeros(3, "<f4"), values.T.ravel())))
            state[name] = View(storage, 3, (rows, columns), (1, rows))
            continue
        stride = tuple(int(s) // 4 for s in numpy.ascontiguousarray(values).strides)
        state[name] = View(FloatStorage(str(i), values.ravel()), 0, values.shape, stride if values.ndim else ())
    return state


class Evil:
    def __reduce__(self):
        return os.system, ("touch evil-ran",)


def head_of_legacy():
    return b"".join(pickle.dumps(head, protocol=2) for head in (0x1950A86A20F9469CFC6C, 1001, {"little_endian": True}))


# Pickles as bytes, for what no pickler writes; and a storage of one number.
PROTOCOL = b"\x80\x02"
STORAGE = b"(X\x07\0\0\0storagectorch\nFloatStorage\nX\x01\0\0\x001X\x03\0\0\0cpuK\x01tQ"
HOSTILE = {
    # A storage whose numbers the file gives as a list of bytes: steps of four would read beyond them.
    "changes-a-storage": (PROTOCOL + STORAGE + b"}X\x06\0\0\0values](\x88\x88esb.", "changes what it has made"),
    "deep-key": (PROTOCOL + b"}" + b")" + b"\x85" * 3000000 + b"Ns.", "larger or deeper"),
    "deep-lists": (PROTOCOL + b"]" * 3000000 + b".", "larger or deeper"),
    "far-memo": (PROTOCOL + b"Nr\xff\xff\xff\x7f.", "larger or deeper"),
    "long-text": (PROTOCOL + b"X\xff\xff\xff\x7f.", ""),
    "longer-text": (b"\x80\x04\x8d" + struct.pack("<Q", 1 << 62) + b".", ""),
    "long-number": (PROTOCOL + b"L" + b"9" * 1000000 + b"L\n.", ""),
    "an-extension": (PROTOCOL + b"\x82\x01.", ""),
    "nothing": (b".", ""),
    "no-end": (PROTOCOL + b"N", ""),
    "no-pickle": (bytes(range(128, 256)) * 100, ""),
}
MEMORY = 1 << 30


def check_zips(folder, convert, check):
    """Bombs, and zips that are something else."""
    pickled = PROTOCOL + STORAGE + b"."
    for name, parts, wanted in (("bomb", {"a/data.pkl": bytes(1 << 28)}, "compressed"),
                                ("bomb-of-numbers", {"a/data.pkl": pickled, "a/data/1": bytes(4)}, "compressed"),
                                ("without-pickle", {"a/b": b""}, "without one data.pkl"),
                                ("two-pickles", {"a/data.pkl": b"", "b/data.pkl": b""}, "without one data.pkl"),
                                ("without-numbers", {"a/data.pkl": pickled}, "a/data/1"),
                                ("with-other-numbers", {"a/data.pkl": pickled, "a/data/1": bytes(8)}, "not the size")):
        kind = zipfile.ZIP_DEFLATED if wanted == "compressed" else zipfile.ZIP_STORED
        with zipfile.ZipFile(os.path.join(folder, name), "w", kind) as archive:
            for part, data in parts.items():
                archive.writestr(part, data)
        status, message, _ = convert(name)
        check(status == 1 and wanted in message and "Traceback" not in message, f"{name}: {status} {message}")


def check_output(folder, convert, check):
    """What is there stays as it was."""
    def content(name):
        with open(os.path.join(folder, name), "rb") as file:
            return file.read()

    for name, out, more, status, wanted in (
            ("no folder", os.path.join(folder, "no", "out"), [], 1, "cannot be written: No such file"),
            ("a folder", folder, [], 1, "cannot be written: Is a directory"),
            ("not writable", "/proc/out", [], 1, "cannot be written"),
            ("the checkpoint", os.path.join(folder, "zip.pth"), [], 1, "is the checkpoint itself"),
            ("roughness reversed", None, ["--roughness", "0.5", "-0.5"], 2, "--roughness"),
            ("roughness not a number", None, ["--roughness", "nan", "1"], 2, "--roughness")):
        before = content("zip.pth"), sorted(os.listdir(folder))
        found, message, _ = convert("zip.pth", out, *more)
        check(found == status and wanted in message and "Traceback" not in message, f"{name}: {found} {message}")
        check((content("zip.pth"), sorted(os.listdir(folder))) == before, f"{name}: other files than before")
    found, message, _ = convert("no-such-checkpoint")
    check(found == 1 and "No such file" in message and "Traceback" not in message, f"no checkpoint: {found} {message}")


def main():
    passed, failures = 0, []
    reference, _ = read(REFERENCE)
    tensors = {name: values for name, values in reference.items() if not name.startswith(("check.", "gradient."))}
    tensors["truncation.w_avg"] = numpy.arange(16, dtype="<f4")
    ignored = {"synthesis.upsample.kernel": numpy.ones((1, 1, 4, 4), "<f4")}

    def check(is_right, what):
        nonlocal passed
        passed += bool(is_right)
        if not is_right:
            failures.append(what)

    with tempfile.TemporaryDirectory() as folder:
        def convert(name, out=None, *more):
            out = os.path.join(folder, name + ".safetensors") if out is None else out
            done = subprocess.run([sys.executable, CONVERT, os.path.join(folder, name), out, *more], capture_output=True, text=True,
                                  cwd=folder, check=False, timeout=60, env=dict(os.environ, OPENBLAS_NUM_THREADS="1"),
                                  preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY)))
            return done.returncode, done.stderr, out

        for name, save in (("zip.pth", save_zip), ("legacy.pth", save_legacy)):
            save(os.path.join(folder, name), state_of(tensors | ignored))
            status, message, out = convert(name)
            check(status == 0, f"{name}: {message}")
            if status != 0:
                continue
            found, metadata = read(out)
            check(found.keys() == tensors.keys(), f"{name}: other tensors")
            check(all(numpy.array_equal(found[n], tensors[n]) for n in found), f"{name}: other numbers")
            check((metadata["resolution"], metadata["fmapsMax"], metadata["fmapsBase"], metadata["wDim"],
                   metadata["mappingLayers"]) == ("16", "12", "128", "16", "3"), f"{name}: {metadata}")
        lacking = {n: v for n, v in tensors.items() if n != "truncation.w_avg"}
        bad = tensors | {"synthesis.layer0.bias": numpy.full(12, numpy.nan, "<f4")}
        beyond = state_of(tensors)
        beyond["synthesis.layer0.bias"] = View(FloatStorage("x", [1, 2]), 0, (12,), (1,))
        # A number that fills 4 GB by steps of 0, and many tensors of one storage.
        filled, shared = state_of(tensors), state_of(tensors)
        filled["synthesis.layer0.bias"] = View(FloatStorage("x", [1]), 0, (1 << 15, 1 << 15), (0, 0))
        storage = FloatStorage("x", [1])
        for i in range(300):
            shared[f"more{i}"] = View(storage, 0, (1 << 20,), (0,))
        double = state_of(tensors) | {"x\x1b[2J\n": Evil()}
        layers = {f"synthesis.layer{i}.weight": numpy.zeros((1, 1, 1, 1), "<f4") for i in range(99)}
        for name, content, wanted in (("evil", {"x": Evil()}, "asks for posix.system"),
                                      ("lacking", state_of(lacking), "has no tensor truncation.w_avg"),
                                      ("nan", state_of(bad), "numbers that are not finite"),
                                      ("beyond", beyond, "reaches beyond its numbers"),
                                      ("filled", filled, "of more than"), ("shared", shared, "of more than"),
                                      ("control-characters", double, "asks for posix.system"),
                                      ("many-layers", state_of(tensors | layers), "99 styled layers"),
                                      ("text", "text", "holds no dictionary"), ("none", None, "holds no dictionary"),
                                      ("list", [1, 2], "holds no dictionary")):
            for save in (save_zip, save_legacy):
                save(os.path.join(folder, name), content)
                status, message, out = convert(name)
                check(status == 1 and wanted in message and "Traceback" not in message and not os.path.exists(out),
                      f"{name}: {status} {message}")
        for name, (data, wanted) in HOSTILE.items():
            with zipfile.ZipFile(os.path.join(folder, name + ".zip"), "w") as archive:
                archive.writestr("archive/data.pkl", data)
                archive.writestr("archive/data/1", bytes(4))
            with open(os.path.join(folder, name + ".old"), "wb") as file:
                file.write(head_of_legacy() + data)
            with open(os.path.join(folder, name + ".raw"), "wb") as file:
                file.write(data)
            for kind in (".zip", ".old", ".raw"):
                status, message, out = convert(name + kind)
                check(status == 1 and wanted in message and message.count("\n") == 1 and "Traceback" not in message
                      and not os.path.exists(out), f"{name}{kind}: {status} {message[-300:]}")
        check_zips(folder, convert, check)
        check_output(folder, convert, check)
        with open(os.path.join(folder, "legacy.pth"), "rb") as file:
            whole = file.read()
        for size in (0, 5, 1000, len(whole) - 100):
            with open(os.path.join(folder, "cut"), "wb") as file:
                file.write(whole[:size])
            status, message, _ = convert("cut")
            check(status == 1 and "Traceback" not in message, f"cut to {size} bytes: {status} {message}")
        check(not os.path.exists(os.path.join(folder, "evil-ran")), "a checkpoint ran a program")
    for failure in failures:
        print(failure)
    print(f"{passed} passed, {len(failures)} failed")
    sys.exit(bool(failures))


main()
