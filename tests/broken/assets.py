"""Broken files that a scene names: included scenes, meshes, images, spectra, and where the image goes."""
import gzip
import os
import struct
import zlib

from run import Case
from scenes import SMALL, options, world

# ---- Scenes ----

MEGABYTES = gzip.compress(b"# " + b"x" * (1 << 24) + b"\n")
BOMB = MEGABYTES * 80  # members in a row are one stream: 1.3 GB out of 1.3 MB


def link(name, target):
    return lambda folder: os.symlink(target, os.path.join(folder, name))


def pipe(name):
    return lambda folder: os.mkfifo(os.path.join(folder, name))


CHAIN = {"f%d.pbrt" % i: 'Include "f%d.pbrt"\n' % (i + 1) for i in range(100)}

SCENES = [
    Case("scene-missing", None, ["nowhere.pbrt", "No such file"], 3, ["nowhere.pbrt"]),
    Case("scene-is-folder", None, ["folder.pbrt", "is a folder"], 3, ["folder.pbrt"], {"folder.pbrt": None}),
    Case("scene-second-missing", world(""), ["nowhere.pbrt", "No such file"], 3, ["nowhere.pbrt"]),
    Case("scene-gz-is-text", None, ["scene.pbrt.gz", "no gzip data"], 2, ["scene.pbrt.gz"],
         {"scene.pbrt.gz": SMALL}),
    Case("scene-gz-garbage", None, ["scene.pbrt.gz", "gzip data is damaged"], 2, ["scene.pbrt.gz"],
         {"scene.pbrt.gz": b"\x1f\x8b\x08\0" + b"\xff" * 500}),
    Case("scene-gz-truncated", None, ["scene.pbrt.gz", "cut off"], 2, ["scene.pbrt.gz"],
         {"scene.pbrt.gz": gzip.compress(world("# %s\n" % os.urandom(20000).hex()).encode())[:9000]}),
    Case("scene-gz-bomb", None, ["scene.pbrt.gz", "larger than", "when unzipped", "PLY files"], 3, ["scene.pbrt.gz"],
         {"scene.pbrt.gz": BOMB}),
    Case("scene-gz-error-position", None, ["scene.pbrt.gz:3:16: error:", '"radius"'], 2, ["scene.pbrt.gz"],
         {"scene.pbrt.gz": gzip.compress(world('Shape "sphere" "float raduis" 1').encode())}),
    Case("scene-endless", None, ["endless.pbrt", "larger than 536870912 bytes"], 3, ["endless.pbrt"],
         prepare=link("endless.pbrt", "/dev/zero")),
    Case("include-missing", world('@Include "nowhere.pbrt"'), ["nowhere.pbrt", "Include", "No such file"], 3),
    Case("include-near-other-error", world('@Include "nowhere.pbrt"\nShape "sphere" "float radius" @-'),
         ["nowhere.pbrt", "expected a number"], 2),
    Case("include-folder", world('@Include "folder"'), ["folder"], 3, files={"folder": None}),
    Case("include-itself", world('@Include "scene.pbrt"'), ["includes itself"]),
    Case("include-in-circles", world('Include "a.pbrt"'), ["includes itself"],
         files={"a.pbrt": 'Include "b.pbrt"\n', "b.pbrt": '\n  @Include "a.pbrt"\n'}),
    Case("include-too-deep", world('Include "f0.pbrt"'), ["files deep"], files=CHAIN),
    Case("include-error-inside", world('Include "a.pbrt"'), ['"radius"'],
         files={"a.pbrt": '\n Shape "sphere" @"float raduis" 1\n'}),
    Case("include-cut-off", world('Include "a.pbrt"\n@Shape "sphere"'), ["Shape"],
         files={"a.pbrt": 'Translate 1 2'}),
    Case("include-without-name", world('Include @scene.pbrt'), ["in quotes"]),
    Case("include-gz-bomb", world('@Include "a.pbrt.gz"'), ["a.pbrt.gz", "larger than"], 3,
         files={"a.pbrt.gz": BOMB}),
    Case("include-gz-damaged", world('MakeNamedMaterial "a" "string type" "diffuse"\n@Include "a.pbrt.gz"\n'
                                     'NamedMaterial "from-there"'),
         ["a.pbrt.gz", "gzip data is damaged"], files={"a.pbrt.gz": b"\x1f\x8b\x08\0" + b"\xff" * 500}),
    Case("include-pipe", world('@Include "a.pbrt"'), ["a.pbrt", "not a regular file"], 3, prepare=pipe("a.pbrt")),
    Case("include-endless", world('@Include "a.pbrt"'), ["a.pbrt", "not a regular file"], 3,
         prepare=link("a.pbrt", "/dev/zero")),
    Case("include-binary", world('Include "a.pbrt"'), ["a.pbrt:2:4: error:", "not a text file"],
         files={"a.pbrt": b"# x\n# \xff\0\1\2"}),
    Case("import-itself", world('@Import "scene.pbrt"'), ["includes itself"]),
    Case("import-before-world", '@Import "a.pbrt"\n' + world(""), ["Import is not allowed before WorldBegin"],
         files={"a.pbrt": ""}),
    Case("import-film", world('Import "a.pbrt"'), ["in an imported file"], files={"a.pbrt": '@Film "rgb"'}),
    Case("import-twice-defined", world('MakeNamedMaterial "a" "string type" "diffuse"\nImport "a.pbrt"'),
         ["already defined at scene.pbrt:3:1"],
         files={"a.pbrt": '@MakeNamedMaterial "a" "string type" "diffuse"'}),
]

# ---- Meshes ----

MESH = world('Shape "plymesh" @"string filename" "m.ply"')


def ply(vertices="0 0 0\n1 0 0\n0 1 0\n", faces="3 0 1 2\n", form="ascii", counts=(3, 1), x="float x",
        corners="list uchar int vertex_indices"):
    return ("ply\nformat %s 1.0\nelement vertex %s\nproperty %s\nproperty float y\nproperty float z\n"
            "element face %s\nproperty %s\nend_header\n" % (form, counts[0], x, counts[1],
                                                            corners) + vertices + faces)


def binary_ply(order, vertices=(0, 0, 0, 1, 0, 0, 0, 1, 0), face=(0, 1, 2), counts=(3, 1), cut=0,
               corners="list uchar int vertex_indices",
               count_code="B", count=3):
    name = "binary_little_endian" if order == "<" else "binary_big_endian"
    body = struct.pack(order + "9f", *vertices) + struct.pack(order + count_code + "3i", count, *face)
    data = ply("", "", name, counts, corners=corners).encode() + body
    return data[:len(data) - cut]


def mesh(name, content, says, status=2, **more):
    return Case("ply-" + name, MESH, ["m.ply"] + says, status,
                files={} if content is None else {"m.ply": content}, **more)


MESHES = [
    mesh("missing", None, ["No such file"], 3),
    Case("ply-is-folder", MESH, ["m.ply", "not a regular file"], 3, files={"m.ply": None}),
    mesh("pipe", None, ["not a regular file"], 3, prepare=pipe("m.ply")),
    mesh("empty", "", ["m.ply:1", '"ply" is expected']),
    mesh("garbage", bytes(range(256)) * 20, ["m.ply:1", "no PLY header"]),
    mesh("is-a-scene", SMALL, ["m.ply:1", "no PLY header"]),
    mesh("without-format", "ply\nelement vertex 1\nproperty float x\nend_header\n1\n", ["without a format"]),
    mesh("unknown-format", ply(form="binary_middle_endian"), ["m.ply:2", '"binary_middle_endian"']),
    mesh("unknown-type", ply(x="real x"), ["m.ply:4", '"real"']),
    mesh("unknown-header-line", ply().replace("element face", "elment face"), ["m.ply:7", '"elment"']),
    mesh("header-without-end", ply().split("end_header")[0], ["end_header"]),
    mesh("long-header-line", "ply\ncomment " + "x" * 10000000, ["m.ply:2"]),
    mesh("without-vertices", ply().replace("element vertex", "element point"), ['no element "vertex"']),
    mesh("without-faces", ply().replace("element face", "element line"), ['no element "face"']),
    mesh("without-x", ply(x="float w"), ["m.ply:3", "x, y and z"]),
    mesh("without-corners", ply(corners="int material"), ["m.ply:7", "vertex_indices"]),
    mesh("count-negative", ply(counts=(-3, 1)), ["m.ply:3", '"-3"']),
    mesh("count-word", ply(counts=("many", 1)), ["m.ply:3", '"many"']),
    mesh("count-beyond-64-bits", ply(counts=("9" * 30, 1)), ["m.ply:3", "9999"]),
    mesh("count-zero-faces", ply("0 0 0\n1 0 0\n0 1 0\n", "", counts=(3, 0)), ["m.ply:7", "count 0"]),
    mesh("count-two-billion-ascii", ply(counts=(2000000000, 1)), ["m.ply:3", "2000000000", "has room for"]),
    mesh("count-two-billion-faces", ply(counts=(3, 2000000000)), ["m.ply:7", "2000000000", "has room for"]),
    mesh("count-two-billion-binary", binary_ply("<", counts=(2000000000, 1)), ["2000000000", "has room for"]),
    mesh("truncated-ascii", ply(faces="3 0 1"), ["m.ply:13", "too early"]),
    mesh("truncated-little-endian", binary_ply("<", cut=2), ["byte", "too early"]),
    mesh("truncated-big-endian", binary_ply(">", cut=2), ["byte", "too early"]),
    mesh("word-in-numbers", ply("0 0 zero\n1 0 0\n0 1 0\n"), ["m.ply:10", '"zero" is no number']),
    mesh("vertex-nan", ply("0 0 nan\n1 0 0\n0 1 0\n"), ["m.ply:10", "vertex 0", "not finite"]),
    mesh("vertex-huge", ply("0 0 0\n1 1e99 0\n0 1 0\n"), ["m.ply:11", "vertex 1", "too large"]),
    mesh("vertex-infinite-binary", binary_ply("<", (0, 0, 0, 1, 0, 0, 0, float("inf"), 0)),
         ["vertex 2", "not finite"]),
    mesh("vertex-nan-binary", binary_ply(">", (0, 0, float("nan"), 1, 0, 0, 0, 1, 0)),
         ["vertex 0", "not finite"]),
    mesh("index-too-large", ply(faces="3 0 1 3\n"), ["m.ply:13", "3"]),
    mesh("index-negative", ply(faces="3 0 -1 2\n"), ["m.ply:13", "-1"]),
    mesh("index-negative-binary", binary_ply("<", face=(0, 1, -2)), ["-2"]),
    mesh("index-fraction", ply(faces="3 0 1 1.5\n"), ["m.ply:13", "fraction"]),
    mesh("list-count-negative", ply(faces="-3 0 1 2\n"), ["m.ply:13", "-3"]),
    mesh("list-count-huge",
         binary_ply("<", corners="list uint int vertex_indices", count_code="I",
                    count=4000000000), ["too early"]),
    mesh("list-count-float", ply(corners="list float int vertex_indices"), ["m.ply:8", "float"]),
    Case("ply-in-folder", MESH.replace("m.ply", "./a/../m.ply"), ["3:17: error: m.ply:2: "], 2, files={"a": None, "m.ply": "ply\n"}),
    mesh("gz-damaged", gzip.compress(ply().encode())[:30] + b"\xff" * 40, ["gzip"]),
    mesh("gz-bomb", b"".join([gzip.compress(ply(counts=(3000000000, 1)).encode()), MEGABYTES * 80]),
         ["larger than"], 3),
]

# ---- Images ----

IMAGE = world('Texture "t" "spectrum" "imagemap" @"string filename" "i.%s"\n'
              'Material "diffuse" "texture reflectance" "t"\nShape "sphere"')


def png_chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png_header(width=4, height=4, bits=8, colour=2):
    return b"\x89PNG\r\n\x1a\n" + png_chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, colour, 0, 0, 0))


def png_end():
    return png_chunk(b"IEND", b"")


def png(width=4, height=4, rows=None, bits=8, colour=2):
    pixels = zlib.compress(rows if rows is not None else (b"\0" + b"\x80" * 3 * width) * height)
    return png_header(width, height, bits, colour) + png_chunk(b"IDAT", pixels) + png_end()


def exr(width=4, height=4, value=0.5, channels=b"BGR", cut=0):
    """Uncompressed scan lines of 32-bit floats."""
    def attribute(name, kind, data):
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(data)) + data
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    list_ = b"".join(bytes([c]) + b"\0" + struct.pack("<IIii", 2, 0, 1, 1) for c in channels) + b"\0"
    header = (b"\x76\x2f\x31\x01\x02\0\0\0" + attribute(b"channels", b"chlist",
                                                        list_) + attribute(b"compression", b"compression",
                                                                           b"\0") +
              attribute(b"dataWindow", b"box2i", window) + attribute(b"displayWindow", b"box2i", window) +
              attribute(b"lineOrder", b"lineOrder", b"\0") + attribute(b"pixelAspectRatio", b"float",
                                                                       struct.pack("<f", 1)) +
              attribute(b"screenWindowCenter", b"v2f", bytes(8)) + attribute(b"screenWindowWidth", b"float",
                                                                             struct.pack("<f", 1)) + b"\0")
    rows = min(height, 64)
    size = 4 * min(width, 64) * len(channels)
    first = len(header) + 8 * rows
    table = b"".join(struct.pack("<Q", first + y * (8 + size)) for y in range(rows))
    lines = b"".join(struct.pack("<iI", y, size) + struct.pack("<f",
                                                               value) * (size // 4) for y in range(rows))
    data = header + table + lines
    return data[:len(data) - cut]


def image(name, kind, content, says, status=2, scene=IMAGE, **more):
    files = {} if content is None else {"i." + kind: content}
    return Case("image-" + name, scene % kind, ["i." + kind] + says, status, files=files, **more)


ENVIRONMENT = world('LightSource "infinite" @"string filename" "i.%s"')
EMISSION = world('AreaLightSource "diffuse" @"string filename" "i.%s"\nShape "disk"')
NORMALS = world('Material "diffuse" @"string normalmap" "i.%s"\nShape "sphere"')

IMAGES = [
    image("missing", "png", None, ["there is no such file"], 3),
    Case("image-is-folder", IMAGE % "png", ["i.png", "not a regular file"], 3, files={"i.png": None}),
    image("pipe", "png", None, ["not a regular file"], 3, prepare=pipe("i.png")),
    image("empty", "png", b"", ["empty"]),
    image("text", "png", "this is no image", ["not an image of a known kind"]),
    image("unknown-extension", "xyz", "this is no image", ["not an image of a known kind"]),
    image("png-truncated", "png", png(64, 64, b"".join(b"\0" + os.urandom(192) for _ in range(64)))[:6000],
          ["damaged"]),
    image("png-garbage", "png", b"\x89PNG\r\n\x1a\n" + b"\xee" * 300, ["damaged"]),
    image("png-header-only", "png", png()[:33], ["damaged"]),
    image("png-no-pixels", "png", png(0, 0, b""), ["i.png"]),
    image("png-colour-type", "png", png(colour=5), ["damaged", "colour type 5"]),
    image("png-bit-depth", "png", png(bits=4), ["damaged", "4 bits in colour type 2"]),
    image("png-palette-missing", "png", png(colour=3), ["damaged", "palette is missing"]),
    image("png-row-filter", "png", png(rows=(b"\5" + b"\x80" * 12) * 4), ["damaged", "unknown filter"]),
    image("png-pixels-garbage", "png", png_header() + png_chunk(b"IDAT", b"\x78\x9c" + b"\xff" * 99) + png_end(),
          ["damaged", "make no sense"]),
    image("png-pixels-missing", "png", png_header() + png_end(), ["damaged", "no pixels"]),
    image("png-unknown-chunk", "png", png_header() + png_chunk(b"ABCD", b"") + png_end(), ["damaged", "chunk"]),
    image("png-too-few-rows", "png", png(16, 16, b"\0" * 100), ["damaged"]),
    image("png-two-billion-wide", "png", png(2000000000, 2000000000, b"\0" * 100), ["i.png"]),
    image("png-too-many-pixels", "png", png(60000, 60000, b"\0" * 100), ["60000 x 60000"]),
    image("exr-truncated", "exr", exr(cut=40), ["damaged"]),
    image("exr-garbage", "exr", b"\x76\x2f\x31\x01\x02\0\0\0" + b"\x99" * 400, ["damaged"]),
    image("exr-header-only", "exr", exr()[:60], ["damaged"]),
    image("exr-two-billion-wide", "exr", exr(2000000000, 4), ["i.exr"]),
    image("exr-too-many-pixels", "exr", exr(60000, 60000), ["damaged"]),
    image("exr-nan", "exr", exr(value=float("nan")), ["finite"]),
    image("hdr-truncated", "hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 64 +X 64\n\x02\x02",
          ["damaged"]),
    image("pfm-truncated", "pfm", b"PF\n64 64\n-1.0\n" + bytes(100), ["damaged"]),
    image("jpeg-garbage", "jpg", b"\xff\xd8\xff\xe0" + b"\x55" * 300, ["damaged"]),
    image("gif-cut", "gif", b"GIF89a\x04", ["damaged", "GIF header"]),
    image("gif-huge-canvas", "gif", b"GIF89a" + struct.pack("<HH", 65535, 65535) + bytes(20), ["65535 x 65535 pixels"]),
    image("for-two-textures", "png", "text", ["not an image"],
          scene=world('Texture "t" "spectrum" "imagemap" @"string filename" "i.%s"\n'
                      'Material "diffuse" "texture reflectance" "t"\nShape "sphere" Shape "disk"')),
    image("wrap", "png", png(), ['"repeat"', '"repaet"'],
          scene=world('Texture "t" "float" "imagemap" "string filename" "i.%s"\n'
                      ' @"string wrap" "repaet"  # i.png')),
    image("encoding", "png", png(), ['"gamma x"'],
          scene=world('Texture "t" "float" "imagemap" "string filename" "i.%s"\n'
                      ' @"string encoding" "gamma 0"  # i.png')),
    image("environment-missing", "exr", None, ["there is no such file"], 3, ENVIRONMENT),
    image("environment-not-square", "exr", exr(8, 5), ["square", '"equalarea"', "8 x 5"], scene=ENVIRONMENT),
    image("environment-mapping", "exr", exr(), ['"latlong"', '"latlon"', "did you mean"],
          scene=world('LightSource "infinite" "string filename" "i.%s"\n @"string mapping" "latlon"  # i.exr')),
    image("environment-ball-not-square", "exr", exr(8, 4), ["square", '"mirrorball"'],
          scene=world('LightSource "infinite" @"string filename" "i.%s" "string mapping" "mirrorball"')),
    image("environment-nan", "exr", exr(value=float("nan")), ["not a finite number"], scene=ENVIRONMENT),
    image("environment-grey", "exr", exr(channels=b"Y"), ["R, G and B"], scene=ENVIRONMENT),
    image("environment-and-colour", "exr", exr(), ["not from both"],
          scene=world('LightSource "infinite" @"rgb L" [1 1 1] "string filename" "i.%s"  # i.exr')),
    image("emission-infinite", "exr", exr(value=float("inf")), ["not a finite number"], scene=EMISSION),
    image("normals-grey", "exr", exr(channels=b"Y"), ["R, G and B"], scene=NORMALS),
    image("normals-missing", "png", None, ["there is no such file"], 3, NORMALS),
]

# ---- Spectra ----

SPECTRUM = world('Material "diffuse" "spectrum reflectance" "s.spd"\nShape "sphere"')
SPECTRUM_AT = SPECTRUM.replace('"spectrum', '@"spectrum')


def spectrum(name, content, says, status=2, **more):
    return Case("spectrum-file-" + name, SPECTRUM, ["s.spd"] + says, status, files={"s.spd": content}, **more)


SPECTRA = [
    Case("spectrum-file-missing", SPECTRUM_AT, ["s.spd", "No such file", '"spectrum reflectance"'], 3),
    Case("spectrum-file-is-folder", SPECTRUM_AT, ["s.spd", "is a folder"], 3, files={"s.spd": None}),
    Case("spectrum-file-pipe", SPECTRUM_AT, ["s.spd", "not a regular file"], 3, prepare=pipe("s.spd")),
    Case("spectrum-file-endless", SPECTRUM_AT, ["s.spd", "not a regular file"], 3,
         prepare=link("s.spd", "/dev/zero")),
    spectrum("empty", "", ["no samples", '"spectrum reflectance"']),
    spectrum("too-large", "400 1\n" * 3000000, ["larger than 16777216 bytes"], 3),
    spectrum("only-comments", "# nothing\n# here", ["no pairs"]),
    spectrum("word", "400 0.5\n500 @half\n", ['"half" is not a number']),
    spectrum("odd", "400 0.5\n500", ["before the value at 500 nm"]),
    spectrum("unordered", "500 0.5\n@400 0.5\n", ["increase", "400 follows 500"]),
    spectrum("negative", "400 @-0.5\n", ["-0.5", "negative"]),
    spectrum("nan", "400 @nan\n", ['"nan"']),
    spectrum("huge", "400 @1e999\n", ['"1e999"']),
    spectrum("garbage", bytes(range(128, 256)) * 3, ["not a number"]),
]

# ---- Measured BRDFs ----

MEASURED = world('Material "measured" @"string filename" "m.bsdf"\nShape "sphere"')
FLOATS, BYTES = 10, 1
FIELDS = [("theta_i", FLOATS, [2], [0, 1.5]), ("phi_i", FLOATS, [1], [0]),
          ("ndf", FLOATS, [2, 2], [1] * 4), ("sigma", FLOATS, [2, 2], [1] * 4),
          ("vndf", FLOATS, [1, 2, 2, 2], [1] * 8), ("luminance", FLOATS, [1, 2, 2, 2], [1] * 8),
          ("spectra", FLOATS, [1, 2, 1, 2, 2], [1] * 8), ("wavelengths", FLOATS, [1], [550]),
          ("jacobian", BYTES, [1], b"\1")]


def tensors(fields=FIELDS, shift=0, **changed):
    """A tensor file; `changed` replaces (type, shape, values) of a field by its name, None leaves it out."""
    fields = [(f[0],) + changed.get(f[0], f[1:]) for f in fields if changed.get(f[0], True)]
    offset = 18 + sum(2 + len(f[0]) + 2 + 1 + 8 + 8 * len(f[2]) for f in fields)
    head, data = b"tensor_file\0\1\0" + struct.pack("<I", len(fields)), b""
    for name, kind, shape, values in fields:
        head += struct.pack("<H", len(name)) + name.encode() + struct.pack(
            "<HBQ%dQ" % len(shape), len(shape), kind, offset + len(data) + shift, *shape)
        data += values if kind == BYTES else struct.pack("<%df" % len(values), *values)
    return head + data


def measured(name, content, says, status=2, **more):
    return Case("measured-" + name, MEASURED, ["m.bsdf"] + says, status, files={"m.bsdf": content}, **more)


MEASURED_CASES = [
    Case("measured-without-file", world('@Material "measured"\nShape "sphere"'), ['"string filename"']),
    Case("measured-missing", MEASURED, ["m.bsdf", "No such file"], 3),
    Case("measured-is-folder", MEASURED, ["m.bsdf", "is a folder"], 3, files={"m.bsdf": None}),
    Case("measured-endless", MEASURED, ["m.bsdf", "not a regular file"], 3, prepare=link("m.bsdf", "/dev/zero")),
    measured("empty", b"", ["tensor_file"]),
    measured("text", "400 0.5\n", ["tensor_file"]),
    measured("only-magic", b"tensor_file\0", ["ends at byte 12", "head"]),
    measured("version", b"tensor_file\0\2\0" + bytes(40), ["version 2.0", "expected 1.0"]),
    measured("many-fields", b"tensor_file\0\1\0" + b"\xff" * 40, ["byte 14", "4294967295 fields"]),
    measured("cut-in-description", tensors()[:30], ["ends at byte 30", "description of field"]),
    measured("cut-in-data", tensors()[:-20], ['field "spectra"', "outside of the file"]),
    measured("shifted", tensors(shift=1 << 62), ['field "theta_i"', "outside of the file"]),
    measured("huge-shape", tensors(vndf=(FLOATS, [1 << 60, 1 << 60, 2, 2], [1] * 8)),
             ['field "vndf"', "larger than the file"]),
    measured("no-dimension", tensors(ndf=(FLOATS, [], [])), ['field "ndf"', "0 dimensions"]),
    measured("empty-dimension", tensors(ndf=(FLOATS, [0, 2], [])), ['field "ndf"', "is 0"]),
    measured("unknown-type", tensors(ndf=(77, [2, 2], [1] * 4)), ['field "ndf"', "type 77"]),
    measured("missing-field", tensors(vndf=None), ['field "vndf"', "missing"]),
    measured("wrong-type", tensors(sigma=(5, [2, 2], [1] * 4)), ['field "sigma"', "u32", "f32"]),
    measured("wrong-dimensions", tensors(ndf=(FLOATS, [4], [1] * 4)), ['field "ndf"', "2 dimensions"]),
    measured("one-row", tensors(ndf=(FLOATS, [1, 4], [1] * 4)), ['field "ndf"', "at least two"]),
    measured("wrong-directions", tensors(vndf=(FLOATS, [2, 1, 2, 2], [1] * 8)), ['field "vndf"', "dimension 1"]),
    measured("wrong-spectra", tensors(spectra=(FLOATS, [1, 2, 2, 2, 1], [1] * 8)), ['field "spectra"', "dimension 3"]),
    measured("not-finite", tensors(spectra=(FLOATS, [1, 2, 1, 2, 2], [1] * 7 + [float("nan")])),
             ['field "spectra"', "value 8", "not finite"]),
    measured("unordered", tensors(theta_i=(FLOATS, [2], [1, 0.5])), ['field "theta_i"', "0.5 follows 1"]),
    measured("half-a-turn", tensors([("phi_i", FLOATS, [3], [0, 1, 3])] + [f for f in FIELDS if f[0] != "phi_i"]),
             ['field "phi_i"', "360"]),
    measured("without-density", tensors(jacobian=(BYTES, [1], b"\0")), ['field "jacobian"']),
]

# ---- Lenses ----

LENS = options('Camera "realistic" "string lensfile" "l.dat"')
LENS_AT = LENS.replace('"string', '@"string')
GOOD_LENS = "# thin\n50 2 1.5 20\n0 5 0 10\n-50 40 0 20\n"


def lens(name, content, says, status=2, **more):
    return Case("lens-file-" + name, LENS, ["l.dat"] + says, status, files={"l.dat": content}, **more)


def aperture(name, parameters, says, status=2, files=None, **more):
    """A good lens with other parameters."""
    return Case("lens-" + name, LENS.replace('"l.dat"', '"l.dat" ' + parameters), says, status,
                files={"l.dat": GOOD_LENS, **(files or {})}, **more)


LENSES = [
    Case("lens-file-not-named", options('@Camera "realistic"'), ['"string lensfile"']),
    Case("lens-file-missing", LENS_AT, ["l.dat", "No such file"], 3),
    Case("lens-file-is-folder", LENS_AT, ["l.dat", "is a folder"], 3, files={"l.dat": None}),
    Case("lens-file-pipe", LENS_AT, ["l.dat", "not a regular file"], 3, prepare=pipe("l.dat")),
    lens("empty", "", ["no surfaces"]),
    lens("too-large", "50 2 1.5 20\n" * 100000, ["larger than 1048576 bytes"], 3),
    lens("too-many", "50 2 1.5 20\n" * 1000 + "@50", ["1000 surfaces"]),
    lens("word", "50 2 @glass 20\n", ['"glass" is not a number']),
    lens("short", "50 2 1.5 20\n@-50 40 0\n", ["3 of its four numbers"]),
    lens("long", "@50 2 1.5 20 1\n-50 40 0 20\n", ["1 of its four numbers"]),
    lens("cut-off", "50 2 1.5 20\n@-50", ["1 of its four numbers"]),
    lens("garbage", bytes(range(128, 256)) * 3, ["not a number"]),
    lens("nan", "@nan 2 1.5 20\n", ['"nan"']),
    lens("index", "50 2 @0.7 20\n-50 40 0 20\n", ["index of refraction", "0.7"]),
    lens("thickness", "50 @-2 1.5 20\n-50 40 0 20\n", ["thickness", "-2"]),
    lens("diameter", "50 2 1.5 @-20\n-50 40 0 20\n", ["diameter", "-20"]),
    lens("diverging", "-50 2 1.5 20\n50 40 0 20\n", ["makes no image", "focal length"]),
    lens("only-a-stop", "0 2 0 20\n", ["makes no image"]),
    aperture("too-near", '@"float focusdistance" 0.1', ["0.1 m", "focuses from"]),
    aperture("focus-zero", '@"float focusdistance" 0', ["focusdistance", "positive"]),
    aperture("closed", '@"float aperturediameter" 0', ["aperturediameter", "positive"]),
    aperture("shape", '@"string aperture" "pentagram"', ['"pentagram"', 'did you mean "pentagon"?']),
    aperture("image-missing", '@"string aperture" "stop.png"', ["stop.png", "no such file"], 3),
    aperture("image-damaged", '@"string aperture" "stop.png"', ["stop.png", "not an image"],
             files={"stop.png": "no image"}),
    aperture("image-black", '@"string aperture" "stop.pgm"', ["stop.pgm", "is black"],
             files={"stop.pgm": b"P5 2 2 255\n\0\0\0\0"}),
    aperture("lensradius", '@"float lensradius" 1', ['"float lensradius"']),
    Case("lens-film-diagonal", options('Film "rgb" @"float diagonal" 0'), ["diagonal", "0"]),
]

# ---- Output ----

GOOD = world('Shape "sphere"')
OUTPUT = [
    Case("output-unknown-extension", GOOD, ["image.jpgg", "exr", "png"], 3, ["--outfile", "image.jpgg"]),
    Case("output-without-extension", GOOD, ["image", "exr", "png"], 3, ["--outfile", "image"]),
    Case("output-unknown-extension-in-scene", options('Film "rgb" "string filename" "image.abc"'),
         ["image.abc", "exr"], 3),
    Case("output-missing-folder", GOOD, ["nowhere/image.exr", "folder"], 3,
         ["--outfile", "nowhere/image.exr"]),
    Case("output-is-folder", GOOD, ["folder.exr", "is a folder"], 3, ["--outfile", "folder.exr"],
         {"folder.exr": None}),
    Case("output-file-for-folder", GOOD, ["scene.pbrt/image.exr"], 3,
         ["--outfile", "scene.pbrt/image.exr"]),
    Case("output-unwritable", GOOD, ["/proc/image.exr"], 3, ["--quiet", "--outfile", "/proc/image.exr"]),
    Case("output-stats-in-missing-folder", GOOD, ["nowhere/stats.json"], 3,
         ["--quiet", "--stats-json", "nowhere/stats.json"]),
    Case("output-log-in-missing-folder", GOOD, ["nowhere/log"], 3, ["--log-file", "nowhere/log"]),
    Case("reference-missing", GOOD, ["ref.exr", "no such file"], 3,
         ["--mse-reference-image", "ref.exr", "--mse-reference-out", "mse"]),
    Case("reference-damaged", GOOD, ["ref.exr", "damaged"], 2,
         ["--mse-reference-image", "ref.exr", "--mse-reference-out", "mse"],
         {"ref.exr": exr(cut=30)}),
    Case("reference-of-other-size", GOOD, ["ref.exr", "4 x 4", "8 x 8"], 3,
         ["--mse-reference-image", "ref.exr", "--mse-reference-out", "mse"],
         {"ref.exr": exr()}),
    Case("reference-out-in-missing-folder", GOOD, ["nowhere/mse"], 3,
         ["--quiet", "--mse-reference-image", "ref.exr", "--mse-reference-out",
          "nowhere/mse"], {"ref.exr": exr(8, 8)}),
]

CASES = SCENES + MESHES + IMAGES + SPECTRA + MEASURED_CASES + LENSES + OUTPUT
