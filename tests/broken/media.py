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

CASES = GRIDS + NANOVDB
