# Images in arrays and files, and the stubs of the native part.
import ast
import os
import subprocess
import sys

import lacquer
import numpy as np
import pytest
from lacquer import _lacquer

PIXELS = np.arange(2 * 3 * 3, dtype=np.float32).reshape(2, 3, 3) / 7


def test_round_trip(tmp_path):
    matrix = np.arange(16, dtype=np.float32).reshape(4, 4)
    metadata = {"note": "ü", "count": 3, "exposure": 0.5, "matrix": matrix}
    lacquer.write_image(tmp_path / "a.exr", PIXELS, metadata=metadata)
    image = lacquer.read_image(tmp_path / "a.exr")
    assert image.channels == ["R", "G", "B"] and image.pixels.dtype == np.float32
    assert np.array_equal(image.pixels, PIXELS) and np.array_equal(image["G"], PIXELS[..., 1])
    assert image.metadata["note"] == "ü" and image.metadata["count"] == 3 and image.metadata["exposure"] == 0.5
    assert np.array_equal(image.metadata["matrix"], matrix)
    image.write(tmp_path / "b.exr")
    assert np.array_equal(lacquer.read_image(tmp_path / "b.exr").pixels, PIXELS)


@pytest.mark.parametrize("shape, channels", [((2, 3), ["Y"]), ((2, 3, 1), ["Y"]), ((2, 3, 4), ["R", "G", "B", "A"]),
                                             ((1, 1, 3), ["R", "G", "B"])])
def test_shapes(tmp_path, shape, channels):
    pixels = np.random.default_rng(0).random(shape).astype(np.float32)
    lacquer.write_image(tmp_path / "a.exr", pixels)
    image = lacquer.read_image(tmp_path / "a.exr")
    assert image.channels == channels
    assert np.array_equal(image.pixels.reshape(shape), pixels)


def test_kinds_of_arrays(tmp_path):
    for pixels in (PIXELS.astype(np.float64), PIXELS.astype(np.float16), np.ones((2, 2), dtype=np.uint8),
                   PIXELS[::-1, ::2], [[1, 2], [3, 4]], np.asfortranarray(PIXELS)):
        lacquer.write_image(tmp_path / "a.exr", pixels)
        read = lacquer.read_image(tmp_path / "a.exr").pixels
        assert np.array_equal(read.reshape(np.shape(pixels)), np.float32(pixels))


def test_png_is_srgb(tmp_path):
    lacquer.write_image(tmp_path / "a.png", np.full((8, 8, 3), 0.2))
    assert lacquer.read_image(tmp_path / "a.png").pixels.mean() == pytest.approx(0.2, rel=0.01)
    assert lacquer.read_image(tmp_path / "a.png", encoding="linear").pixels.mean() == pytest.approx(0.4845, rel=0.01)


@pytest.mark.parametrize("call", [
    lambda p: lacquer.write_image(p / "a.xyz", PIXELS), lambda p: lacquer.write_image(p / "no" / "a.exr", PIXELS),
    lambda p: lacquer.read_image(p / "nowhere.exr"), lambda p: lacquer.read_image(p),
])
def test_files_that_cannot_be(tmp_path, call):
    with pytest.raises(lacquer.FileError):
        call(tmp_path)


def test_damaged_file_is_named(tmp_path):
    (tmp_path / "a.exr").write_bytes(b"v/1\x01 and no more")
    with pytest.raises(lacquer.FileError, match="a.exr"):
        lacquer.read_image(tmp_path / "a.exr")


@pytest.mark.parametrize("pixels", [None, "x", np.zeros((0, 3, 3)), np.zeros((3,)), np.zeros((2, 2, 2, 2)), [[1], [1, 2]],
                                    np.ones((2, 2), dtype=complex), np.zeros((2, 3, 5)), 3, np.zeros((1, 70000))])
def test_arrays_that_are_no_images(tmp_path, pixels):
    with pytest.raises(lacquer.UsageError):
        lacquer.write_image(tmp_path / "a.exr", pixels)
    assert not os.path.exists(tmp_path / "a.exr")


@pytest.mark.parametrize("parameters", [
    dict(channels=["R"]), dict(channels="RGB"), dict(channels=["R", "R", "B"]), dict(channels=["", "G", "B"]),
    dict(channels=[1, 2, 3]), dict(metadata={"x": object()}), dict(metadata={"x": 1 << 80}), dict(metadata={3: 1}),
    dict(half=1), dict(channels=3),
])
def test_wrong_arguments(tmp_path, parameters):
    with pytest.raises(lacquer.UsageError):
        lacquer.write_image(tmp_path / "a.exr", PIXELS, **parameters)


def test_wrong_reads(tmp_path):
    lacquer.write_image(tmp_path / "a.png", PIXELS)
    for encoding in ("srgbb", 3, None):
        with pytest.raises(lacquer.UsageError):
            lacquer.read_image(tmp_path / "a.png", encoding=encoding)
    with pytest.raises(lacquer.UsageError, match='did you mean "R"|known: R, G, B'):
        lacquer.read_image(tmp_path / "a.png")["Q"]
    for path in (None, 3, "a\0b"):
        with pytest.raises(lacquer.UsageError):
            lacquer.read_image(path)


FIRST_USE = """
import lacquer
loaded = lambda: "libOpenImageIO.so" in open("/proc/self/maps").read()
assert not loaded()
lacquer.material("diffuse").evaluate((0, 0, 1), (0, 0, 1))
lacquer.write_image("a.pfm", [[1, 2]])
lacquer.write_image("a.png", [[0, 1]])
assert lacquer.read_image("a.png").pixels.sum() == 1
assert not loaded()
assert lacquer.read_image("a.pfm").pixels.sum() == 3
assert loaded()
"""


def test_openimageio_comes_with_the_first_file_that_needs_it(tmp_path):
    subprocess.run([sys.executable, "-c", FIRST_USE], cwd=tmp_path, check=True)


# ---- What type checkers and help() see ----


def stub_names(body):
    return {node.name if hasattr(node, "name") else node.target.id for node in body
            if isinstance(node, (ast.ClassDef, ast.FunctionDef, ast.AnnAssign))}


def missing(stub):
    """Names that the stub lacks, or has for nothing."""
    tree = ast.parse(stub)
    found = {name for name in vars(_lacquer) if not name.startswith("__")} ^ stub_names(tree.body)
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            own = {name for name in vars(getattr(_lacquer, node.name, object)) if not name.startswith("_")}
            found |= {f"{node.name}.{n}" for n in own ^ {n for n in stub_names(node.body) if not n.startswith("_")}}
    return found


def test_stub_is_complete():
    folder = os.path.dirname(lacquer.__file__)
    with open(os.path.join(folder, "_lacquer.pyi"), encoding="utf-8") as file:
        stub = file.read()
    assert missing(stub) == set()
    assert missing(stub.replace("def energy", "def enrgy")) == {"SurfaceMaterial.energy", "SurfaceMaterial.enrgy"}
    assert os.path.exists(os.path.join(folder, "py.typed"))


def test_everything_public_is_documented():
    for name in lacquer.__all__:
        thing = getattr(lacquer, name)
        assert thing.__doc__, name
        for member, value in vars(thing).items() if isinstance(thing, type) else ():
            if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                assert value.__doc__, f"{name}.{member}"
