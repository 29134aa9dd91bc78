"""lacquer info and lacquer convert on scenes: right answers, and wrong command lines and scenes."""
import glob
import json
import os
import struct

from run import Case, health
from command_line import GOOD, SCENE, has, left, pixels, render, write
from standard_input import MESH

HERE = os.path.dirname(os.path.abspath(__file__))


def wrong(name, args, says, status=1, scene=GOOD, **more):
    return Case("scenes-" + name, None, says, status, args, dict({"a.pbrt": scene}, **more.pop("files", {})), **more)


BROKEN = 'WorldBegin\n  Shpae "sphere"\n'

CASES = [
    wrong("info-missing", ["info", "none.pbrt"], ["none.pbrt", "No such file"], 3),
    wrong("info-wrong-scene", ["info", "a.pbrt"], ["a.pbrt:2:3: error: unknown directive Shpae"], 2, BROKEN),
    wrong("info-wrong-plugin", ["info", "a.pbrt"], ["float raduis", '"radius"?'], 2,
          'WorldBegin Shape "sphere" "float raduis" 1'),
    wrong("info-missing-asset", ["info", "a.pbrt"], ["none.ply"], 3,
          'WorldBegin Shape "plymesh" "string filename" "none.ply"'),
    wrong("info-empty-stdin", ["info", "-"], ["<stdin>: error: standard input holds no scene"], 2),
    wrong("info-stdin-twice", ["info", "-", "-"], ["twice"]),
    wrong("convert-scene-as-image", ["convert", "a.pbrt", "b.exr"], ["a.pbrt is a scene", "--format"]),
    wrong("convert-scene-and-image-option", ["convert", "a.pbrt", "--format", "--half"], ["--half", "for images"]),
    wrong("convert-outdir-without-toply", ["convert", "a.pbrt", "--format", "--outdir", "o"], ["--outdir", "--toply"]),
    wrong("convert-min-triangles", ["convert", "a.pbrt", "--toply", "--min-triangles", "0"], ["--min-triangles"]),
    wrong("convert-onto-itself", ["convert", "a.pbrt", "./a.pbrt", "--format"], ["./a.pbrt", "input file"], 3),
    wrong("convert-to-gz", ["convert", "a.pbrt", "b.pbrt.gz", "--format"], ["b.pbrt.gz", "plain text"]),
    wrong("convert-folder", ["convert", "a.pbrt", "no/b.pbrt", "--format"], ["no/b.pbrt", "folder does not exist"], 3),
    wrong("convert-outdir-parent", ["convert", "a.pbrt", "--toply", "--outdir", "no/way"], ["no/way"], 3),
    wrong("convert-missing", ["convert", "none.pbrt", "--format"], ["none.pbrt"], 3),
    wrong("convert-empty-stdin", ["convert", "-", "--format"], ["standard input holds no scene"], 2),
    wrong("convert-unknown-directive", ["convert", "a.pbrt", "--format"],
          ["a.pbrt:2:3: error: expected a directive, found Shpae", '"Shape"?'], 2, BROKEN),
    wrong("convert-not-a-number", ["convert", "a.pbrt", "--format"], ["a.pbrt:1:24: error: Translate: expected a number, found x"],
          2, "WorldBegin Translate 1 x 2"),
    wrong("convert-no-string", ["convert", "a.pbrt", "--format"], ["Shape: expected a type in quotes, found sphere"],
          2, "WorldBegin Shape sphere"),
    wrong("convert-unterminated", ["convert", "a.pbrt", "--format"], ["a.pbrt:1:7: error: unterminated string"], 2,
          'Shape "sphere'),
    wrong("convert-open-list", ["convert", "a.pbrt", "--format"], ["never closed"], 2,
          'Shape "sphere" "float radius" [ 1'),
    wrong("convert-one-word", ["convert", "a.pbrt", "--format"], ['"radius"', '"type name"'], 2,
          'Shape "sphere" "radius" 1'),
    wrong("convert-fifteen-numbers", ["convert", "a.pbrt", "--format"], ["Transform: a matrix has 16 numbers, not 15"], 2,
          "Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0]"),
    wrong("convert-ends-early", ["convert", "a.pbrt", "--format"], ["LookAt: the file ends where a number is expected"], 2, "LookAt 1 2 3"),
]

CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


def run(tool, folder, *args, status=0, stdin=None):
    result = tool.run(args, folder, stdin=stdin)
    problems = health(result)
    assert not problems, "; ".join(problems) + ": " + result.err
    assert result.status == status, "%s: exit status %d, not %d: %s" % (" ".join(args), result.status, status,
                                                                        result.err.strip())
    return result


# ---- info ----

RICH = """Film "rgb" "integer xresolution" 64 "integer yresolution" 48 "string filename" "rich.exr"
Sampler "halton" "integer pixelsamples" 5
Camera "perspective"
Integrator "path"
WorldBegin
LightSource "point"
LightSource "infinite"
Texture "bricks" "spectrum" "imagemap" "string filename" "bricks.png"
Texture "again" "float" "imagemap" "string filename" "bricks.png"
Texture "lonely" "float" "constant"
MakeNamedMaterial "coat" "string type" "dielectric"
MakeNamedMaterial "base" "string type" "diffuse" "texture reflectance" "bricks"
MakeNamedMaterial "stack" "string type" "layered" "string stack" ["coat" "base"] "string estimator" "bidirectional"
MakeNamedMaterial "never" "string type" "diffuse" "texture displacement" "again"
NamedMaterial "stack"
Shape "plymesh" "string filename" "m.ply"
Material "coateddiffuse"
ObjectBegin "o"
  Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0] "integer indices" [0 1 2 1 2 3]
ObjectEnd
Translate 1 0 0 ObjectInstance "o"
Translate 1 0 0 ObjectInstance "o"
Material "diffuse"
AreaLightSource "diffuse"
Shape "sphere"
Include "more.pbrt"
"""


def png(width, height):
    """Bytes of a grey image."""
    import zlib
    rows = b"".join(b"\0" + bytes((x * 7 + y * 3) % 256 for x in range(width)) for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def rich(folder):
    write(folder, "a.pbrt", RICH)
    write(folder, "m.ply", MESH)
    write(folder, "more.pbrt", 'Shape "disk"\n')
    write(folder, "bricks.png", png(24, 16))


@check
def info_of_a_scene_is_json(tool, folder):
    rich(folder)
    result = run(tool, folder, "info", "--json", "a.pbrt")
    assert not result.err, result.err
    scene, = json.loads(result.out)
    expected = dict(kind="scene", file="a.pbrt", image="rich.exr", resolution=[64, 48], samples_per_pixel=5,
                    camera="perspective", film="rgb", sampler="halton", integrator="path", color_space="srgb",
                    shapes=dict(plymesh=1, trianglemesh=1, sphere=1, disk=1), triangles=3, other_primitives=3,
                    objects=1, instances=2, placed_primitives=1 + 2 * 2 + 2, lights=dict(point=1, infinite=1),
                    area_lights=dict(diffuse=2), emitting_primitives=2)
    # The sphere and the disk are one primitive each: 3 triangles and 2 others.
    expected["other_primitives"] = 2
    for key, value in expected.items():
        assert scene[key] == value, "%s is %r, not %r" % (key, scene[key], value)
    materials = {m["name"]: m for m in scene["materials"]}
    assert materials["stack"]["estimator"] == "bidirectional" and materials["stack"]["shapes"] == 1, materials
    assert materials["coat"]["used"] and materials["base"]["used"] and not materials["never"]["used"], materials
    assert [m["estimator"] for m in scene["materials"] if m["type"] == "coateddiffuse"] == ["auto"], materials
    textures = {t["name"]: t for t in scene["textures"]}
    assert textures["bricks"]["resolution"] == [32, 16] and textures["bricks"]["bytes"] >= 32 * 16, textures
    assert textures["lonely"]["file"] is None and textures["again"]["file"] == "bricks.png", textures
    files = {os.path.basename(f["file"]): (f["role"], f["bytes"]) for f in scene["files"]}
    assert files == {"a.pbrt": ("scene", len(RICH)), "more.pbrt": ("scene", 13), "m.ply": ("shape", len(MESH)),
                     "bricks.png": ("texture", len(png(24, 16)))}, files
    memory = scene["memory_bytes"]
    assert memory["total"] == sum(v for k, v in memory.items() if k != "total") > 0, memory
    warnings = "\n".join(scene["warnings"])
    has(warnings, r'a\.pbrt:14:1: warning: nothing uses the material "never"',
        r'a\.pbrt:10:1: warning: nothing uses the texture "lonely"')
    assert len(scene["warnings"]) == 2, warnings
    assert left(folder) == ["a.pbrt", "bricks.png", "m.ply", "more.pbrt"], left(folder)


@check
def info_knows_the_media_of_a_mixture(tool, folder):
    medium = 'MakeNamedMedium "%s" "string type" "homogeneous" %s\n'
    mixture = '"string phase" "mixture" "string phases" ["%s" "ice"]'
    write(folder, "a.pbrt", "".join(medium % named for named in [
        ("ice", ""), ("dust", ""), ("soot", ""), ("inner", mixture % "dust"), ("outer", mixture % "inner"),
        ("other", mixture % "soot")]) + 'WorldBegin\nMediumInterface "outer" ""\nMaterial "interface"\nShape "sphere"\n')
    scene, = json.loads(run(tool, folder, "info", "--json", "a.pbrt").out)
    unused = [w for w in scene["warnings"] if "nothing uses" in w]
    assert len(unused) == 2 and '"soot"' in unused[0] and '"other"' in unused[1], unused


@check
def info_forecasts_what_a_render_takes(tool, folder):
    rich(folder)
    scene, = json.loads(run(tool, folder, "info", "--json", "a.pbrt").out)
    statistics = json.loads(render(tool, folder, "a.pbrt", "--spp", "1", "--stats-json", "-", scene=None).out)
    for key in "geometry", "acceleration_structure":
        assert scene["memory_bytes"][key] == statistics["memory_bytes"][key], (key, scene["memory_bytes"])
    assert scene["resolution"] == statistics["resolution"]
    assert scene["lights"]["point"] + scene["lights"]["infinite"] + scene["emitting_primitives"] == statistics["lights"]


@check
def info_takes_what_a_material_says_before_what_it_inherits(tool, folder):
    write(folder, "a.pbrt", """WorldBegin
AttributeBegin
Attribute "material" "string estimator" "forward"
Material "coateddiffuse" "string estimator" "auto"
Shape "sphere"
Material "coateddiffuse"
Shape "sphere"
AttributeEnd
LightSource "infinite"
""")
    scene, = json.loads(run(tool, folder, "info", "--json", "a.pbrt").out)
    said = [m["estimator"] for m in scene["materials"] if m["type"] == "coateddiffuse"]
    assert said == ["auto", "forward"], said


@check
def info_forecasts_films_and_media(tool, folder):
    memory = {}
    for film in "rgb", "gbuffer", "spectral":
        write(folder, "a.pbrt", """Film "%s" "integer xresolution" 100 "integer yresolution" 50 "string filename" "a.exr"
WorldBegin
LightSource "infinite"
MakeNamedMedium "smoke" "string type" "uniformgrid" "integer nx" 2 "integer ny" 2 "integer nz" 2
    "float density" [ 1 2 3 4 5 6 7 8 ]
AttributeBegin
Material "interface"
MediumInterface "smoke" ""
Shape "sphere"
AttributeEnd
""" % film)
        scene, = json.loads(run(tool, folder, "info", "--json", "a.pbrt").out)
        memory[film] = scene["memory_bytes"]
    assert all(m["media"] >= 8 * 4 for m in memory.values()), memory
    # At the least a double for each channel and pixel: 3, 24 and 3 + 16 channels.
    for film, channels in ("rgb", 3), ("gbuffer", 24), ("spectral", 19):
        assert memory[film]["film"] >= 5000 * channels * 8, (film, memory)


@check
def info_of_a_scene_is_a_table(tool, folder):
    rich(folder)
    text = run(tool, folder, "info", "a.pbrt").out.decode()
    has(text, r"^a\.pbrt: 64 x 48 pixels, 5 samples each, to rich\.exr", r"integrator +path", r"3 triangles, 2 others",
        r"stack +layered +bidirectional +auto +1", r'bricks\.png +texture "bricks" +32 x 16', "memory",
        'nothing uses the material "never"')
    assert max(map(len, text.splitlines())) < 160, "long lines"


@check
def info_of_images_and_a_scene_in_pieces(tool, folder):
    before, after = SCENE.split("Material", 1)
    write(folder, "one.pbrt", before)
    render(tool, folder, "--spp", "1")
    image, scene = json.loads(run(tool, folder, "info", "--json", "one.pbrt", "scene.exr", "-",
                                  stdin=("Material" + after).encode()).out)
    assert image["kind"] == "image" and image["file"] == "scene.exr", image
    assert scene["kind"] == "scene" and scene["file"] == "one.pbrt <stdin>", scene
    assert scene["shapes"] == {"disk": 1, "sphere": 1}, scene


@check
def info_goes_on_after_an_image_that_cannot_be_read(tool, folder):
    write(folder, "a.pbrt", SCENE)
    result = run(tool, folder, "info", "none.exr", "a.pbrt", status=3)
    has(result.err, r"^error: none\.exr: there is no such file")
    has(result.out.decode(), r"^a\.pbrt: 48 x 32 pixels")


POINT = 'LightSource "point"\n'


@check
def info_warns_of_what_will_not_be_seen(tool, folder):
    def warnings(text):
        write(folder, "a.pbrt", text)
        return "\n".join(json.loads(run(tool, folder, "info", "--json", "a.pbrt").out)[0]["warnings"])

    head = 'Film "rgb" "integer xresolution" 8 "integer yresolution" 8\n'
    mirror = head + 'WorldBegin\nLightSource "%s"\nMaterial "%s"\nShape "sphere"\n'
    has(warnings(mirror % ("point", "conductor")), 'a.pbrt:4:1: warning: the conductor "@1" is perfectly smooth',
        "the image will be black")
    has(warnings(mirror % ("distant", "dielectric")), 'the dielectric "@1" is perfectly smooth')
    has(warnings(mirror % ("point", "conductor") + 'Material "diffuse" Shape "disk"\n'), "perfectly smooth")
    for text in (mirror % ("infinite", "conductor"), mirror % ("point", 'conductor" "float roughness" 0.1 "string x'),
                 mirror % ("point", "diffuse")):
        text = text.replace(' "string x"', "")
        assert not warnings(text), "%s\n%s" % (text, warnings(text))
    has(warnings(head + 'WorldBegin\nShape "sphere"\n'), "the scene has no light")
    has(warnings(head + "WorldBegin\n" + POINT), "the scene has no shape")
    has(warnings(head + 'Integrator "randomwalk"\nWorldBegin\nShape "sphere"\n' + POINT), '"randomwalk" finds lights by chance')


# ---- convert ----

UGLY = """# The head
LookAt 0 1 -4   0 0 0 # towards
  0 1 0
Camera "perspective" "float   fov" [40] # a long lens


# two lines
# of comments
WorldBegin AttributeBegin Translate 1 0 0 Shape "sphere" # behind
"float radius" [ # the radius
.5 ] "string a" "quoted \\"b\\" and \\\\" AttributeEnd MediumInterface "" # outside
Transform [1 0 0 0 # x
0 1 0 0 0 0 1 0 0 0 0 1]
Option "seed" 3
Texture "t" "float" "scale"
# before the factor
"float scale" [+1.50E+0] # factor
"texture tex" "u"
# the end
"""


@check
def format_keeps_comments_and_numbers(tool, folder):
    write(folder, "ugly.pbrt", UGLY)
    text = run(tool, folder, "convert", "ugly.pbrt", "--format").out.decode()
    for comment in ("# The head", "# towards", "# a long lens", "# two lines\n# of comments\nWorldBegin", "# behind",
                    "# the radius", "# x", "# before the factor", "# factor", "# the end", "# outside"):
        assert comment in text, "no %r in:\n%s" % (comment, text)
    for piece in ("+1.50E+0", '"float radius" .5', '"quoted \\"b\\" and \\\\"', "\nAttributeBegin\n    Translate 1 0 0\n"):
        assert piece in text, "no %r in:\n%s" % (piece, text)
    assert run(tool, folder, "convert", "-", "--format", stdin=text.encode()).out.decode() == text, "not idempotent"
    run(tool, folder, "convert", "ugly.pbrt", "b.pbrt", "--format")
    with open(os.path.join(folder, "b.pbrt")) as f:
        assert f.read() == text
    with open(os.path.join(folder, "ugly.pbrt")) as f:
        assert f.read() == UGLY, "the input was changed"


def grid(n):
    """A trianglemesh of 2 n^2 triangles with normals and uv, its numbers in odd spellings."""
    points = ["%.9g %.7e %g" % (x / n - 0.5, 0.1 * ((x * y) % 3) / 3, y / n - 0.5) for y in range(n + 1) for x in
              range(n + 1)]
    uv = ["%g %g" % (x / n, y / n) for y in range(n + 1) for x in range(n + 1)]
    indices = []
    for y in range(n):
        for x in range(n):
            a = y * (n + 1) + x
            indices += [a, a + 1, a + n + 1, a + n + 1, a + 1, a + n + 2]
    return ('Shape "trianglemesh"\n  "point3 P" [%s]\n  "point2 uv" [%s] # texture\n  "normal N" [%s]\n'
            '  "integer indices" [%s]\n  "float alpha" 1\n' % ("\n".join(points), " ".join(uv), "0 1 0.1 " * len(points),
                                                             " ".join(map(str, indices))))


@check
def meshes_in_ply_files_give_the_same_image(tool, folder):
    scene = (SCENE + 'Texture "c" "spectrum" "checkerboard"\nMaterial "diffuse" "texture reflectance" "c"\n'
             'AttributeBegin Translate 0 0 1 Rotate 20 1 0 0\n' + grid(12) + 'AttributeEnd\n'
             'AreaLightSource "diffuse"\nScale 1 1 -1\n' + grid(11) +
             'Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0]\n')
    render(tool, folder, "--outfile", "before.exr", scene=scene)
    result = run(tool, folder, "convert", "scene.pbrt", "after.pbrt", "--toply")
    has(result.err, "2 meshes in PLY files")
    with open(os.path.join(folder, "after.pbrt")) as f:
        text = f.read()
    has(text, '"string filename" "scene-mesh-00001.ply"', "# texture", '"float alpha" 1', r'"point3 P" \[ 0 0 0')
    render(tool, folder, "after.pbrt", "--outfile", "after.exr", scene=None)
    assert pixels(folder, "before.exr") == pixels(folder, "after.exr"), "another image"
    # Again: the same files. From a pipe and into a folder, all of them.
    run(tool, folder, "convert", "scene.pbrt", "again.pbrt", "--toply")
    with open(os.path.join(folder, "again.pbrt")) as f:
        assert f.read() == text
    result = run(tool, folder, "convert", "-", "--toply", "--outdir", "plys", "--min-triangles", "1",
                 stdin=scene.encode())
    names = sorted(os.listdir(os.path.join(folder, "plys")))
    assert names == ["scene-mesh-0000%d.ply" % i for i in (1, 2, 3)], names
    render(tool, folder, "-", "--outfile", "piped.exr", scene=None, stdin=result.out)
    assert pixels(folder, "before.exr") == pixels(folder, "piped.exr"), "another image"


@check
def meshes_never_overwrite_files(tool, folder):
    write(folder, "scene.pbrt", SCENE + grid(12))
    write(folder, "scene-mesh-00001.ply", "precious")
    run(tool, folder, "convert", "scene.pbrt", "b.pbrt", "--toply")
    with open(os.path.join(folder, "scene-mesh-00001.ply")) as f:
        assert f.read() == "precious"
    with open(os.path.join(folder, "b.pbrt")) as f:
        has(f.read(), "scene-mesh-00002.ply")


@check
def meshes_that_ply_cannot_hold_stay(tool, folder):
    for extra in ('"vector3 S" [1 0 0 1 0 0 1 0 0]', '"integer indices" [0 1 3]', '"point3 P" [1 2 3]',
                  '"normal N" [0 0 1]', '"float uv" [0 0 1 0 1 1]'):
        text = 'Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0] %s\n' % extra
        result = run(tool, folder, "convert", "-", "--toply", "--min-triangles", "1", stdin=text.encode())
        has(result.out.decode(), 'Shape "trianglemesh"')
    assert not left(folder), left(folder)


@check
def a_scene_written_elsewhere_is_a_warning(tool, folder):
    write(folder, "m.ply", MESH)
    write(folder, "a.pbrt", SCENE + 'Shape "plymesh" "string filename" "m.ply"\n')
    os.mkdir(os.path.join(folder, "sub"))
    has(run(tool, folder, "convert", "a.pbrt", "sub/a.pbrt", "--format").err, "warning: sub/a.pbrt: the files")
    assert not run(tool, folder, "convert", "a.pbrt", "b.pbrt", "--format").err


@check
def upgraded_scenes_render(tool, folder):
    for path in sorted(glob.glob(os.path.join(HERE, "v3", "*.pbrt"))):
        with open(path) as f:
            text = f.read()
        write(folder, "v3.pbrt", text)
        result = tool.run(["v3.pbrt", "--spp", "1"], folder)
        assert result.status == 2 and "pbrt-v3" in result.err, "%s is no scene of pbrt-v3" % path
        # The errors that it must give stand in the file, and some of the warnings.
        warnings = [line[len("# warns "):] for line in text.splitlines() if line.startswith("# warns ")]
        expected = [line[len("# says "):] for line in text.splitlines() if line.startswith("# says ")]
        result = run(tool, folder, "convert", "v3.pbrt", "v4.pbrt", "--upgrade", status=2 if expected else 0)
        for message in expected:
            assert message in result.err, "no %r in:\n%s" % (message, result.err)
        assert result.err.count("error:") == len(expected), result.err
        for message in warnings:
            assert result.err.count(message) == 1, "not once %r in:\n%s" % (message, result.err)
        if not expected:
            render(tool, folder, "v4.pbrt", "--spp", "1", "--outfile", "v4.exr", scene=None)
        upgraded = run(tool, folder, "convert", "v4.pbrt", "--upgrade", status=2 if expected else 0)
        with open(os.path.join(folder, "v4.pbrt")) as f:
            assert upgraded.out.decode() == f.read(), "upgrading twice changes " + path
