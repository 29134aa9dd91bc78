#!/usr/bin/env python3
"""Writes the seeds of the fuzz targets, and the dictionary of scenes, anew: make_seeds.py LACQUER (the program). Inputs that once broke a reader, seeds/*/found-*,
stay, and so do the grids seeds/nanovdb/fog-*, which NanoVDB's own library has written. scripts/fuzz adds files of other folders."""
import gzip
import json
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy
import OpenImageIO as oiio

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE.parent / "broken"))
import assets  # noqa: E402
import bulk  # noqa: E402
import media  # noqa: E402

SEEDS = HERE / "seeds"


def put(target, name, content):
    folder = SEEDS / target
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())


def image(target, name, channels=3, kind="uint8", size=(6, 5), tile=0, names=(), **attributes):
    """An image by OpenImageIO, of a smooth pattern."""
    spec = oiio.ImageSpec(*size, channels, kind)
    spec.attribute("DateTime", "2000:01:01 00:00:00")
    for key, value in attributes.items():
        spec.attribute(key, value)
    if names:
        spec.channelnames = tuple(names)
    if tile:
        spec.tile_width = spec.tile_height = tile
    pixels = numpy.fromfunction(lambda y, x, c: (x + 2 * y + c) % 9 / 10, (size[1], size[0], channels), dtype=int)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, name)
        out = oiio.ImageOutput.create(path)
        assert out and out.open(path, spec), oiio.geterror()
        assert out.write_image(pixels.astype(numpy.float32)), out.geterror()
        out.close()
        put(target, name, pathlib.Path(path).read_bytes())


def images():
    for compression in ("none", "rle", "zips", "zip", "piz", "pxr24", "b44", "dwaa"):
        image("exr", compression + ".exr", 3, "half", compression=compression)
    image("exr", "tiles.exr", 4, "float", (20, 18), 16, compression="zip")
    image("exr", "grey.exr", 1, "uint")
    noise = ["R", "G", "B"] + ["MeanVariance." + channel for channel in "RGBY"]
    image("reference_image", "noise.exr", 7, "float", names=noise, compression="zip")
    image("reference_image", "plain.png")
    put("exr", "plain.exr", assets.exr())
    put("exr", "cut.exr", assets.exr(cut=40))
    for channels in (1, 2, 3, 4):
        image("png", "bytes-%d.png" % channels, channels)
    image("png", "words.png", 3, "uint16")
    palette = assets.png_chunk(b"PLTE", bytes(range(12))) + assets.png_chunk(b"tRNS", b"\x80\xff")
    rows = zlib.compress(b"\0\x1b\xe4" * 4)
    put("png", "palette.png", assets.png_header(8, 4, 2, 3) + palette + assets.png_chunk(b"IDAT", rows) + assets.png_end())
    put("png", "filters.png", assets.png(4, 5, b"".join(bytes([f]) + b"\x11" * 12 for f in range(5))))
    image("hdr", "pattern.hdr", 3, "float", (12, 5))
    put("hdr", "runs.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 16\n" + (b"\2\2\0\x10" + b"\x90\x40" * 4) * 2)
    put("hdr", "color.pfm", b"PF\n3 2\n-1.0\n" + struct.pack("<18f", *(i / 4 for i in range(18))))
    put("hdr", "grey.pfm", b"Pf\n2 2\n1.0\n" + struct.pack(">4f", 0, 1, 2, 3))
    put("hdr", "color.ppm", b"P6 2 2 255\n" + bytes(range(12)))
    put("hdr", "text.pgm", b"P2\n# a comment\n2 2 15\n0 5 10 15\n")
    for name in ("a.jpg", "a.gif", "a.bmp", "a.tif", "a.webp"):
        image("hdr", name)


def meshes():
    put("ply", "text.ply", assets.ply())
    put("ply", "little.ply", assets.binary_ply("<"))
    put("ply", "big.ply", assets.binary_ply(">"))
    put("ply", "zipped.ply.gz", gzip.compress(assets.ply().encode(), mtime=0))
    put("ply", "all.ply", """ply
format ascii 1.0
comment every property that is read, and some that are not
element vertex 4
property float x
property float y
property double z
property float nx
property float ny
property float nz
property float u
property float v
property uchar red
element face 2
property list uchar uint vertex_indices
property int face_indices
element edge 1
property list int short ends
end_header
0 0 0 0 0 1 0 0 9
1 0 0 0 0 1 1 0 9
1 1 0 0 0 1 1 1 9
0 1 0 0 0 1 0 1 9
4 0 1 2 3 7
3 0 1 2 8
2 0 1
""")


def tables():
    put("spectrum_file", "three.spd", "# wavelength, value\n400 0.5\n550 1.25e0\n700 .25\n")
    put("spectrum_file", "one-line.spd", "360 1 830 2")
    put("lens_file", "thin.dat", assets.GOOD_LENS)
    put("lens_file", "panchro.dat", (ROOT / "scenes/lenses/lee-speed-panchro-50mm.dat").read_bytes())
    put("measured_bsdf", "smallest.bsdf", assets.tensors())
    put("measured_bsdf", "cut.bsdf", assets.tensors()[:-20])
    put("phase_table", "plain.txt", "# angle, value\n0 4\n45 2\n90 1\n180 1\n")
    put("phase_table", "wavelengths.txt", "wavelengths 450 550 650\n0 12 11 10\n90 2 2 1\n180 .5 .5 .5\n")
    put("lobe_table", "reflection.txt", (ROOT / "data/lobes/beckmann-reflection.txt").read_bytes())
    put("bulk_table", "two.json", media.BULK)
    put("bulk_table", "zipped.json.gz", gzip.compress(media.BULK.encode(), mtime=0))
    oriented = json.loads((ROOT / "scenes/bulk/tables/disc.json").read_text())
    put("bulk_table", "oriented.json", json.dumps(oriented))
    put("particles", "fat.json", bulk.FAT)
    put("particles", "ensemble.json", json.dumps({
        "wavelengths": [500, 600], "host": {"wavelengths": [400, 700], "index": [1.34, 1.33]},
        "species": [{"name": "a", "index": [1.5, 0.01], "radius": {"kind": "lognormal", "median": 0.1, "sigma": 0.2},
                     "volume fraction": 0.1}],
        "arrangement": {"kind": "independent"}, "length": "um", "seed": 3}))
    put("views", "ours.json", json.dumps({
        "unit": "cm", "size": 10.88, "response": "srgb", "lightPower": [1500, 1400, 1300],
        "views": [{"image": "00.png", "camera": [0, 0, 25], "light": [1, 0, 25], "use": "fit"},
                  {"image": "01.png", "camera": [-3, 2.5, 2e1], "use": "test"}]}))
    put("views", "published.json", json.dumps({
        "im_size": 6.848, "light_pow": 1500, "idx": [1, 0], "camera_pos": [[0, 0, 16], [2.5, 0, 16]],
        "light_pos": [[0, 0, 16], [2.5, 0, 16]]}))
    directions = "10,0,10,180,"
    put("measurement", "colors.csv", "theta_i,phi_i,theta_o,phi_o,r,g,b\n" + directions + ".1,.2,.3\n")
    put("measurement", "spectral.csv", "# lamp 2\nwavelength,value,sd,theta_i,phi_i,theta_o,phi_o\n500,.1,.01,10,0,20,90\n")


def estimation():
    bits = lambda x: struct.unpack("<Q", struct.pack("<d", x))[0]  # noqa: E731
    vector = [bits(0.5), bits(-2)]
    vectors = ("y", "gradient", "metric", "window_mean", "window_squares", "gradient_mean", "gradient_squares", "log_steps")
    whole = ("step", "adaptation_count", "kind", "window_count")
    numbers = ("log_density", "log_step", "log_step_average", "adaptation_error", "adaptation_center", "accepted")
    state = {**{key: vector for key in vectors}, **{key: 7 for key in whole}, **{key: bits(1.5) for key in numbers}}
    draw = [vector, bits(-3), 1, bits(0.9), bits(0.1), 4, False, True, bits(2)]
    put("chain_checkpoint", "chain.json", json.dumps(
        {"lacquer_checkpoint": 2, "settings": "settings", "states": [state], "draws": [[draw]]}))
    for kind, size in (("F32", 4), ("F16", 2)):
        header = json.dumps({"__metadata__": {"a": "b"},
                             "weight": {"dtype": kind, "shape": [2, 3], "data_offsets": [0, 6 * size]}}).encode()
        put("safetensors", kind.lower() + ".safetensors", struct.pack("<Q", len(header)) + header + b"\0\x3c" * (3 * size))
    # Here and below, checksums are made right by the target.
    put("bulk_checkpoint", "two.part", b"lacquer-bulk-part 1\n" + struct.pack("<3Q2dQ1dQ", 0, 2, 2, 1, 2, 1, 3, 0))
    record = struct.pack("<Q5dQ", 1, 0.25, -1, 1, 2, 3, 0)
    put("run_log", "one.bin", b"lqruns01" + struct.pack("<2Q", 2, 3) + record)
    put("run_log", "torn.bin", b"lqruns01" + struct.pack("<2Q", 2, 3) + record * 2 + record[:20])


def volumes():
    tile = media.grid()
    put("nanovdb_patches", "magic", struct.pack("<I4s", 0, b"Nano"))
    put("tiled_texture", "magic", struct.pack("<I4s", 0, b"II*\0"))
    put("nanovdb", "tile.nvdb", media.file_of(tile))
    put("nanovdb", "tile-zip.nvdb", media.file_of(media.zipped(tile), 1, unpacked=len(tile)))
    put("nanovdb", "blosc-damaged.nvdb", media.file_of(struct.pack("<Q", 60) + b"\2\1\1\4" * 15, 2, unpacked=len(tile)))


def languages():
    for i, text in enumerate(("C<RS>*D.*L", "CD[<TD>V]+('key'|B)?", "C[^S]*O")):
        put("light_path", "expression-%d" % i, text)
    for i, text in enumerate(("left:0,20,2,20", "0.1,0.5,0.2,1", "coat.roughness=0.1,0.2", "light@1.rgb L=1 1 1",
                              "# box left 0.1 0.5 0.2 0.6\nWorldBegin")):
        put("comparison_text", "text-%d" % i, text)
    put("earlier_files", "results.json", json.dumps({"schema": "lacquer-compare-1", "files": ["images/a.png", "crops/b.exr", "../c"]}))
    put("earlier_files", "table.json", json.dumps({"schema": "lacquer-bsdf-1", "files": ["a.png", "/b.exr", "c/d.png", 3]}))
    put("light_path", "time", "2026-06-21T15:30:05+02:00")


def states(lacquer):
    scene = (SEEDS / "scene_build" / "all.pbrt").read_bytes()
    with tempfile.TemporaryDirectory() as folder:
        for name, options in (("plain", []), ("outputs", ["--aov", "variance,albedo,cryptoobject,direct"])):
            path = os.path.join(folder, name + ".state")
            subprocess.run([lacquer, "render", "-", "--quiet", "--resolution", "5x4", "--spp", "2", "--checkpoint", path, "--outfile",
                            os.path.join(folder, "a.exr"), *options], input=scene, check=True, cwd=folder)
            state = pathlib.Path(path).read_bytes()
            put("render_state", name + ".state", state)
            put("state_header", name + ".json", state[24:24 + struct.unpack_from("<Q", state, 16)[0]])


def scenes():
    text = (SEEDS / "scene_build" / "all.pbrt").read_bytes()
    put("scene_file", "zipped.pbrt.gz", gzip.compress(text, mtime=0))
    put("scene_file", "members.pbrt.gz", gzip.compress(text[:900], mtime=0) + gzip.compress(text[900:], mtime=0))
    put("scene_text", "options.pbrt", 'ColorSpace "rec2020"\nOption "disablewavelengthjitter" true\nLookAt 0 0 5  0 0 0  0 1 0\n'
        'CoordinateSystem "here" CoordSysTransform "camera"\nTransformTimes 0 1 ActiveTransform EndTime\n'
        'ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1]\nActiveTransform All Identity\n'
        'Attribute "shape" "float alpha" 0.5\nWorldBegin\nReverseOrientation\n')
    v3 = HERE.parent / "broken" / "v3"
    put("scene_statements", "v3.pbrt", (v3 / "all.pbrt").read_bytes())
    put("scene_statements", "v3-impossible.pbrt", (v3 / "impossible.pbrt").read_bytes())


def dictionary():
    """Directives, names of plugins, and the parameters that heads of files tell."""
    words = set(re.findall(r'^    \{"(\w+)"', (ROOT / "src/pbrt/scene/directives.cpp").read_text(), re.M))
    for row in re.findall(r"^\| (?:\w+ ?)+ \| (.*) \|$", (ROOT / "docs/plugins.md").read_text(), re.M):
        words |= {'"%s"' % name for name in re.findall(r"`([^`]+)`", row)[:20]}
    for path in (ROOT / "src").rglob("*.cpp"):
        words |= {'"%s"' % name for name in re.findall(r'^//.*?"(\w+ \w+)"', path.read_text(), re.M)}
    words |= {'"texture %s"' % name for name in ("reflectance", "roughness", "displacement", "alpha", "tex")}
    text = "# Words of scene files; make_seeds.py writes them.\n" + "".join(
        '"%s"\n' % word.replace('"', '\\"') for word in sorted(words))
    (HERE / "dictionaries").mkdir(exist_ok=True)
    (HERE / "dictionaries" / "scene.dict").write_text(text)


if __name__ == "__main__":
    dictionary()
    for make in (images, meshes, tables, estimation, volumes, languages, scenes):
        make()
    states(sys.argv[1])
