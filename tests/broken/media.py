"""Broken media: parameters of grids and clouds, and NanoVDB files. A @ stands before the place that the message must
name; see run.Case."""
import struct
import zlib

from run import Case
from scenes import world


def medium(name, kind, parameters, says, status=2, **more):
    return Case("medium-" + name, world('MakeNamedMedium "m" "string type" "%s" %s\n'
                                        'MediumInterface "m" "" Material "interface" Shape "sphere"' % (kind, parameters)),
                says, status, **more)


GRIDS = [
    Case("medium-unknown", world('@MakeNamedMedium "m" "string type" "unifromgrid"'),
         ["unifromgrid", '"uniformgrid"']),
    Case("medium-grid-without-density", world('@MakeNamedMedium "m" "string type" "uniformgrid"'),
         ['needs "float density"']),
    medium("grid-count", "uniformgrid", '@"float density" [1 2 3] "integer nx" 2', ["2 values", "2 x 1 x 1", "has 3"]),
    medium("grid-negative", "uniformgrid", '@"float density" [1 -3] "integer nx" 2', ["density", "negative", "-3"]),
    medium("grid-no-voxels", "uniformgrid", '"float density" [1] @"integer ny" 0', ["ny", "0"]),
    medium("grid-too-many-voxels", "uniformgrid",
           '"float density" [1] @"integer nx" 60000 "integer ny" 60000 "integer nz" 60000', ["60000", "2^31"]),
    medium("grid-flat-box", "uniformgrid", '"float density" [1] @"point3 p1" [1 1 0]', ["volume"]),
    medium("grid-two-emissions", "uniformgrid", '"float density" [1] "rgb Le" [1 1 1] @"float temperature" [900]',
           ['"Le"', '"temperature"']),
    medium("grid-temperature-count", "uniformgrid", '"float density" [1] @"float temperature" [900 800]', ["has 2"]),
    medium("grid-lescale-count", "uniformgrid", '"float density" [1 1] "integer nx" 2 "rgb Le" [1 1 1] '
           '@"float Lescale" 3', ["Lescale", "2 values", "has 1"]),
    medium("grid-lescale-negative", "uniformgrid", '"float density" [1] "rgb Le" [1 1 1] @"float Lescale" -3',
           ["Lescale", "-3"]),
    medium("grid-scale-negative", "uniformgrid", '"float density" [1] @"float scale" -3', ["scale", "-3"]),
    medium("grid-sigma-negative", "uniformgrid", '"float density" [1] @"rgb sigma_a" [1 -1 1]', ["sigma_a"]),
    medium("grid-misspelt", "uniformgrid", '"float density" [1] @"float densty" 3', ['"float densty"', '"density"']),
    Case("medium-rgbgrid-without-sigma", world('@MakeNamedMedium "m" "string type" "rgbgrid"'), ["sigma_a", "sigma_s"]),
    medium("rgbgrid-count", "rgbgrid", '@"rgb sigma_a" [1 1 1  1 1 1]', ["1 values", "has 2"]),
    medium("rgbgrid-odd", "rgbgrid", '@"rgb sigma_a" [1 1 1 1]', ["multiple of 3"]),
    medium("rgbgrid-negative", "rgbgrid", '@"rgb sigma_s" [1 -1 1]', ["sigma_s", "negative"]),
    medium("rgbgrid-emits-without-absorbing", "rgbgrid", '"rgb sigma_s" [1 1 1] @"rgb Le" [1 1 1]',
           ["Le", '"sigma_a"']),
    medium("grid-overflow", "uniformgrid", '@"float density" [1e30] "rgb sigma_a" [1e10 1e10 1e10]', ["too large"]),
    medium("homogeneous-overflow", "homogeneous", '"rgb sigma_a" [3e38 3e38 3e38] @"rgb sigma_s" [3e38 3e38 3e38]',
           ["too large"]),
    medium("cloud-overflow", "cloud", '"rgb sigma_a" [3e38 3e38 3e38] @"rgb sigma_s" [3e38 3e38 3e38]', ["too large"]),
    medium("homogeneous-emission-overflow", "homogeneous", '@"rgb Le" [1e30 1e30 1e30] "float Lescale" 1e30',
           ["emission", "too large"]),
    medium("homogeneous-preset-and-sigma", "homogeneous", '"string preset" "Skin1" @"rgb sigma_a" [1 1 1]',
           ['"sigma_a"', '"preset"']),
    medium("cloud-negative", "cloud", '@"float wispiness" -1', ["wispiness", "-1"]),
    medium("cloud-flat-box", "cloud", '@"point3 p0" [0 1 0]', ["volume"]),
    medium("cloud-scale", "cloud", '@"float scale" 2', ['"float scale"']),
]

# ---- Phase functions ----


def phase(name, parameters, says, before="", **more):
    return Case("phase-" + name, world('%sMakeNamedMedium "m" "string type" "homogeneous" %s\n'
                                       'MediumInterface "m" "" Material "interface" Shape "sphere"' %
                                       (before, parameters)), says, **more)


def phase_file(name, text, says):
    """A table from a file, with the mark in the file."""
    return phase("file-" + name, '"string phase" "table" "string tablefile" "t.txt"', ["t.txt"] + says,
                 files={"t.txt": text})


OTHER = 'MakeNamedMedium "fog" "string type" "homogeneous"\n'
# Each mixes the one before twice.
DEEP = OTHER + "".join('MakeNamedMedium "m%d" "string type" "homogeneous" "string phase" "mixture" "string phases" '
                       '["%s" "%s"]\n' % (i, *[("m%d" % (i - 1)) if i else "fog"] * 2) for i in range(6))

PHASES = [
    phase("unknown", '@"string phase" "henyey"', ['"henyey"', '"hg"']),
    phase("foreign-parameter", '@"float kappa" 3', ['"kappa"', '"hg"', '"vmf"']),
    phase("foreign-g", '"string phase" "sggx" @"float g" 0.3', ['"g"', '"sggx"', '"hg"']),
    phase("misspelt", '"string phase" "vmf" @"float kapa" 3', ['"float kapa"', '"kappa"']),
    phase("texture", '"string phase" "sggx" @"texture roughness" "t"', ["medium", '"float roughness"'],
          before='Texture "t" "float" "constant"\n'),
    phase("orientationmap", '"string phase" "sggx" @"string orientationmap" "o.png"',
          ["medium", '"vector3 orientation"']),
    phase("orientation", '"string phase" "fibre" @"vector3 orientation" [0 0 0]', ["no length"]),
    phase("stddev", '"string phase" "fibre" @"float stddev" 0', ["positive"]),
    phase("roughness", '"string phase" "sggx" @"float roughness" 1.5', ["1.5", "[0, 1]"]),
    phase("kappa", '"string phase" "vmf" @"float kappa" -1', ["-1", "at least 0"]),
    phase("table-negative", '"string phase" "table" @"float table" [1 2 -1]', ["-1", "negative"]),
    phase("table-short", '"string phase" "table" @"float table" [1]', ["1 values", "two or more"]),
    phase("table-rows", '"string phase" "table" @"float table" [1 2 3 4 5] "float wavelengths" [400 500]',
          ["5 values", "2 wavelengths"]),
    phase("table-angles", '"string phase" "table" @"float table" [1 2] "float angles" [0 90 180]',
          ["2 values", "expected 3"]),
    phase("table-angles-end", '"string phase" "table" "float table" [1 2] @"float angles" [0 90]', ["180"]),
    phase("table-angles-order", '"string phase" "table" "float table" [1 1 1 1] @"float angles" [0 90 80 180]',
          ["80", "after 90"]),
    phase("table-wavelengths-order", '"string phase" "table" "float table" [1 1 1 1] @"float wavelengths" [500 400]',
          ["400", "after 500"]),
    phase("table-black", '"string phase" "table" @"float table" [1 1 0 0] "float wavelengths" [400 500]', ["500 nm"]),
    phase("table-twice", '"string phase" "table" "string tablefile" "t.txt" @"float table" [1 2]',
          ['"table"', '"tablefile"']),
    phase("mixture-of-none", '"string phase" "mixture"', ["earlier media"]),
    phase("mixture-unknown", '"string phase" "mixture" @"string phases" ["fgo"]', ['"fgo"', 'mean "fog"?'],
          before=OTHER),
    phase("mixture-itself", '"string phase" "mixture" @"string phases" ["m"]', ['"m"', "before this one"]),
    phase("mixture-weights", '"string phase" "mixture" "string phases" ["fog"] @"float weights" [1 2]', ["2 values for 1"],
          before=OTHER),
    # Who mixes one that could not be made is not to blame.
    phase("mixture-of-broken", '"string phase" "mixture" "string phases" ["bad"]', ["-1"],
          before='MakeNamedMedium "bad" "string type" "homogeneous" "string phase" "vmf" @"float kappa" -1\n'),
    phase("mixture-deep", '"string phase" "mixture" "string phases" ["m5"]', ["more than 64 phase functions"],
          before=DEEP, errors=(1, 3)),
    phase("file-missing", '"string phase" "table" @"string tablefile" "t.txt"', ["t.txt", "No such file"], status=3),
    phase("file-is-folder", '"string phase" "table" @"string tablefile" "t.txt"', ["t.txt", "folder"], status=3,
          files={"t.txt": None}),
    phase_file("empty", "", ["ends before 180"]),
    phase_file("cut", "wavelengths 400 500\n0 1 2\n90 1 2\n", ["ends before 180"]),
    phase_file("word", "0 1\n90 @one\n180 1", ["one"]),
    phase_file("not-finite", "0 1\n90 @1e99\n180 1", ["1e99"]),
    phase_file("binary", bytes(range(256)) * 100, []),
    phase_file("columns", "wavelengths 400 500\n0 1 2\n@90 1\n180 1 1", ["1 values", "expected 2"]),
    phase_file("without-wavelengths", "@0 1 2\n180 1 1", ['"wavelengths"']),
    phase_file("no-wavelengths", "@wavelengths\n0 1\n180 1", ["no wavelengths"]),
    phase_file("wavelengths-order", "wavelengths 500 @400\n0 1 2\n180 1 1", ["400", "after 500"]),
    phase_file("angle-order", "0 1\n90 1\n@80 1\n180 1", ["80", "after 90"]),
    phase_file("angle-too-large", "0 1\n@270 1", ["270", "180"]),
    phase_file("first-angle", "@10 1\n180 1", ["10", "expected 0"]),
    phase_file("negative", "0 1\n90 @-2\n180 1", ["-2", "negative"]),
    phase_file("black", "wavelengths 400 500\n0 1 0\n180 1 0", ["column 2"]),
]

# ---- Files of bulk scattering ----

BULK = """{"format": "lacquer-bulk", "version": 1, "units": {"length": "mm", "angle": "deg", "wavelength": "nm"},
 "mode": "medium", "isotropic": true, "host_index": 1,
 "wavelengths": [400, 700], "angles": [0, 90, 180], "sigma_s": [2, 1], "sigma_a": [0, 0.1], "g": [0, 0],
 "phase": [[0.0795774715, 0.0795774715, 0.0795774715], [0.0795774715, 0.0795774715, 0.0795774715]]}"""


def bulk(name, parameters, says, before="", after="", text=BULK, **more):
    """A medium of a file in which one text is replaced by another."""
    assert before in text, name
    return medium("bulk-" + name, "homogeneous", '"string bulk" "t.json" ' + parameters, says,
                  files={"t.json": text.replace(before, after, 1)}, **more)


def bulk_file(name, before, after, says, **more):
    return bulk("file-" + name, "", ["t.json"] + says, before, after, **more)


BULKS = [
    medium("bulk-missing", "homogeneous", '@"string bulk" "t.json"', ["t.json", "No such file"], 3),
    bulk("and-sigma", '@"rgb sigma_s" [1 1 1]', ['"sigma_s"', '"bulk"']),
    bulk("and-g", '@"float g" 0.5', ['"g"', '"bulk"']),
    bulk("and-preset", '@"string preset" "Skin1"', ['"preset"', '"bulk"']),
    bulk("and-hg", '"string phase" "hg"', ['"bulk"', '"hg"']),
    medium("bulk-without-file", "homogeneous", '"string phase" "bulk"', ['"string bulk"']),
    Case("medium-bulk-slab", world('MakeNamedMaterial "s" "string type" "slab" "string bulk" "t.json" '
                                   '@"rgb sigma_t" [1 1 1]'), ['"sigma_t"', '"bulk"'], files={"t.json": BULK}),
    Case("medium-bulk-rgbgrid", world('MakeNamedMedium "m" "string type" "rgbgrid" @"string bulk" "t.json"'),
         ['"rgbgrid"', "voxels"], files={"t.json": BULK}),
    bulk_file("empty", BULK, "@", ["no JSON"]),
    medium("bulk-file-binary", "homogeneous", '"string bulk" "t.json"', ["t.json", "no JSON"],
           files={"t.json": bytes(range(256)) * 100}),
    bulk_file("cut", "[0.0795774715, 0.0795774715, 0.0795774715]]}", "[0.07@", ["no JSON", "end of input"]),
    bulk_file("deep", "400", "[" * 62 + "@" + "[" * 3000000, ["nested more than 64 deep"]),
    bulk_file("nan", "400", "@NaN", ["no JSON"]),
    bulk_file("overflow", "400", "@1e999", ["1e999", "range"]),
    bulk_file("version", '"version": 1', '"version": @2', ["2", "expected 1"]),
    bulk_file("oriented", BULK[BULK.index("true"):BULK.index("2, 1]")],
              BULK[BULK.index("true"):BULK.index("2, 1]")].replace("true", "false") + "@",
              ["found 2", "a list of numbers"]),
    bulk_file("misspelt", '"sigma_a"', '@"sigma_b"', ['"sigma_b"']),
    bulk_file("twice", '"g": [0, 0]', '"g": [0, 0], @"g": [0, 0]', ["twice"]),
    bulk_file("missing-key", '"g": [0, 0],', "", ['no "g"']),
    bulk_file("negative", "[2, 1]", "[2, @-1]", ["-1", "at least 0"]),
    bulk_file("short", "[2, 1]", "@[2]", ["1 numbers", "expected 2"]),
    bulk_file("angles", "[0, 90, 180]", "@[0, 90, 170]", ["170", "180"]),
    bulk_file("wavelengths-order", "[400, 700]", "[700, @400]", ["400", "after 700"]),
    bulk_file("norm", "[[0.0795774715", "[@[0.08", ["400 nm", "integrates to 1.0013", "expected 1"]),
]

# ---- NanoVDB ----

NAME = b"density\0"


def header(magic=b"NanoVDB0", version=32, grids=1, codec=0):
    return magic + struct.pack("<IHH", version << 21 | 4 << 10 | 2, grids, codec)


def entry(unpacked, packed, name=NAME, name_size=None):
    """What a file says about a grid of `packed` bytes."""
    return (struct.pack("<4Q2I", unpacked, packed, 0, 1, 1, 2) + bytes(48 + 24 + 24) +
            struct.pack("<I", len(name) if name_size is None else name_size) + bytes(16 + 12 + 8) + name)


def grid(magic=b"NanoVDB0", root=64, tiles=1, kind=1, size=200000, tile_child=0, box=(0, 7)):
    """An unpacked grid: one root with one tile of value 1, without checksums."""
    identity = struct.pack("<9f", *(1, 0, 0, 0, 1, 0, 0, 0, 1))
    map_f = identity + identity + bytes(16)
    double = struct.pack("<9d", *(1, 0, 0, 0, 1, 0, 0, 0, 1))
    map_d = double + double + bytes(32)
    data = magic + b"\xff" * 8 + struct.pack("<IIIIQ", 32 << 21 | 4 << 10 | 2, 0, 0, 1, size)
    data += b"density".ljust(256, b"\0") + map_f + map_d + bytes(48 + 24) + struct.pack("<II", 2, kind)
    data = data.ljust(672, b"\0")
    data += struct.pack("<4Q", 0, 0, 0, root) + bytes(32)
    data += struct.pack("<6iI5f", *([box[0]] * 3 + [box[1]] * 3), tiles, 0, 0, 1, 0, 0).ljust(64, b"\0")
    data += struct.pack("<QqIf", 0, tile_child, 1, 1.0).ljust(32, b"\0")
    return data


def file_of(data, codec=0, unpacked=None, **more):
    return header(codec=codec) + entry(len(data) if unpacked is None else unpacked, len(data), **more) + data


def zipped(data):
    packed = zlib.compress(data)
    return struct.pack("<Q", len(packed)) + packed


def nanovdb(name, content, says, status=2, extra="", **more):
    return medium("nanovdb-" + name, "nanovdb", '@"string filename" "m.nvdb" ' + extra, ["m.nvdb"] + says, status,
                  files={} if content is None else {"m.nvdb": content}, **more)


NANOVDB = [
    Case("medium-nanovdb-without-name", world('@MakeNamedMedium "m" "string type" "nanovdb"'), ['"string filename"']),
    nanovdb("missing", None, ["No such file"], 3),
    Case("medium-nanovdb-is-folder", world('MakeNamedMedium "m" "string type" "nanovdb" @"string filename" "m.nvdb"'),
         ["m.nvdb", "folder"], 3, files={"m.nvdb": None}),
    nanovdb("empty", b"", ["is not a NanoVDB file"]),
    nanovdb("text", "Shape", ["is not a NanoVDB file"]),
    nanovdb("other-magic", header(b"NanoVDB1"), ["is not a NanoVDB file"]),
    nanovdb("old", header(version=28), ["version 28", "32"]),
    nanovdb("unknown-codec", header(codec=7), ["unknown way"]),
    nanovdb("without-grids", header(grids=0), ["no grids"]),
    nanovdb("list-cut", header() + entry(0, 0)[:50], ["ends within its list"]),
    nanovdb("long-name", header() + entry(0, 0, name_size=1 << 31), ["ends within its list"]),
    nanovdb("grid-cut", file_of(grid())[:-100], ["ends within the grid", '"density"']),
    nanovdb("packed-huge", header() + entry(1 << 60, 1 << 60), ["ends within the grid"]),
    nanovdb("garbage-behind", file_of(grid()) + b"garbage!", ["no grid begins"]),
    nanovdb("other-name", file_of(grid()), ['no grid "smoke"', '"density"'], extra='"string gridname" "smoke"'),
    nanovdb("other-temperature", file_of(grid()), ['no grid "heat"', '"density"'],
            extra='"string temperaturename" "heat"'),
    nanovdb("tiny-grid", file_of(b"x" * 100), ["cannot hold"]),
    nanovdb("claims-more", file_of(grid(), unpacked=1 << 40), ["cannot hold"]),
    nanovdb("zip-claims-more", file_of(zipped(grid()), 1, unpacked=1 << 40), ["cannot hold"]),
    nanovdb("zip-damaged", file_of(zipped(grid())[:60] + b"\xff" * 60, 1, unpacked=len(grid())), ["damaged", "density"]),
    nanovdb("zip-short", file_of(b"\1\2\3", 1, unpacked=len(grid())), ["ends early"]),
    nanovdb("blosc-damaged", file_of(struct.pack("<Q", 60) + b"\2\1\1\4" * 15, 2, unpacked=len(grid())), ["Blosc"]),
    nanovdb("no-grid-inside", file_of(grid(magic=b"12345678")), ["does not begin"]),
    nanovdb("of-doubles", file_of(grid(kind=2)), ["double", "floats"]),
    nanovdb("unknown-type", file_of(grid(kind=4000000)), ["floats"]),
    nanovdb("root-outside", file_of(grid(root=1 << 50)), ["outside"]),
    nanovdb("root-unaligned", file_of(grid(root=65)), ["outside"]),
    nanovdb("tiles-outside", file_of(grid(tiles=4000000000)), ["outside"]),
    nanovdb("child-outside", file_of(grid(tile_child=1 << 40)), ["nodes", "outside"]),
    nanovdb("child-before", file_of(grid(tile_child=-(1 << 40))), ["nodes", "outside"]),
    nanovdb("child-cut", file_of(grid(tile_child=64)), ["nodes", "outside"]),
    nanovdb("box-inverted", file_of(grid(box=(7, 0))), ["in order"]),
    nanovdb("box-huge", file_of(grid(box=(-2000000000, 2000000000))), ["beyond"]),
    nanovdb("too-wide", file_of(grid(box=(0, 1 << 20))), ["spans", "limit"]),
]

CASES = GRIDS + PHASES + BULKS + NANOVDB
