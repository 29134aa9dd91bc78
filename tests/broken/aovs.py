"""Auxiliary outputs, cryptomattes and the gbuffer film: wrong use, and what the written files say."""
import json
import os
import re
import struct

from run import Case
from command_line import SCENE, has, info, oiiotool, pixels, render, write

SMALL = 'Film "%s" "integer xresolution" 8 "integer yresolution" 8 %s\nWorldBegin LightSource "infinite" Shape "sphere"\n'


def film(parameters, says, **more):
    return Case("aovs-gbuffer-" + more.pop("name"), SMALL % ("gbuffer", parameters), says, **more)


def expression(text, says, name, scene=SCENE):
    return Case("aovs-lpe-" + name, scene, says, 1, ["--aov", "lpe:a=" + text])


def grouped(parameter):
    return 'WorldBegin\nLightSource "point" %s\nShape "sphere"\n' % parameter


CASES = [
    film('@"string coordinatesystem" "wrold"', ['"wrold"', '"world"', "camera"], name="space"),
    film('@"string filename" "a.png"', ['"gbuffer"', "EXR", '"a.png"'], name="png"),
    film('@"string coordinatesytem" "world"', ['"coordinatesystem"'], name="parameter"),
    film("", ['"gbuffer"', "EXR", '"b.png"'], name="outfile-png", status=1, args=["--outfile", "b.png"]),
    Case("aovs-ranks-odd", SCENE, ["--cryptomatte-ranks", '"3"', "even"], 1,
         ["--aov", "cryptoobject", "--cryptomatte-ranks", "3"]),
    Case("aovs-ranks-many", SCENE, ["--cryptomatte-ranks", "16"], 1, ["--cryptomatte-ranks", "18"]),
    Case("aovs-crypto-misspelt", SCENE, ['"cryptobject"', '"cryptoobject"?'], 1, ["--aov", "cryptobject"]),
    expression("C<RX>L", ["character 4", '"X" is no event', "\n    C<RX>L\n       ^"], name="letter"),
    expression("C<RD", ["character 2", "never closed", "  ^"], name="open"),
    expression("CD*", ["CD*", "matches no path", "L, B or O"], name="endless"),
    expression("C.*<L'kye'>", ["character 6", '"kye"', '"key"?'], name="group", scene=grouped('"string group" "key"')),
    Case("aovs-passes-nameless", SCENE, ['"lpe:C.*L"', "lpe:NAME=EXPRESSION"], 1, ["--aov", "lpe:C.*L"]),
    Case("aovs-passes-twice", SCENE, ["two passes", '"direct"'], 1, ["--aov", "direct,lpe:direct=CL"]),
    Case("aovs-passes-taken", SCENE, ['"Albedo"', "have that name"], 1, ["--aov", "lpe:Albedo=CL"]),
    Case("aovs-passes-misspelt", SCENE, ['"indirct"', '"indirect"?'], 1, ["--aov", "indirct"]),
    Case("aovs-passes-many", SCENE, ["65 passes", "64"], 1,
         ["--aov", ",".join("lpe:p%d=CL" % i for i in range(65))]),
    Case("aovs-passes-png", SCENE, ["--aov", "EXR", '"a.png"'], 1, ["--aov", "alpha,direct", "--outfile", "a.png"]),
    Case("aovs-passes-bdpt", 'Integrator "bdpt"\n' + SCENE, ["passes", '"volpath"'], 1, ["--aov", "direct"]),
    Case("aovs-passes-lightpath", 'Integrator "lightpath"\n' + SCENE, ["layered.single", '"path"', '"volpath"'], 1,
         ["--aov", "layered.single"]),
    Case("aovs-layered-misspelt", SCENE, ['"layered.singel"', '"layered.single"?'], 1, ["--aov", "layered.singel"]),
    Case("aovs-layered-alone", SCENE, ['"layered"', "unknown"], 1, ["--aov", "layered"]),
    Case("aovs-layered-belcour", 'WorldBegin\nLightSource "infinite"\nMaterial "coateddiffuse"\nShape "sphere"\n',
         ["layered.surface", "cannot be told apart", "auto, bidirectional"], 1,
         ["--aov", "layered.rest", "--estimator", "belcour"]),
    Case("aovs-layered-taken", SCENE, ['"motion"', "have that name"], 1,
         ["--aov", "lpe:motion=CL"]),
    Case("aovs-layered-png", SCENE, ["--aov", "EXR", '"a.png"'], 1,
         ["--aov", "layered.single", "--outfile", "a.png"]),
    Case("aovs-motion-misspelt", SCENE, ['"moton"', '"motion"?'], 1, ["--aov", "moton"]),
    Case("aovs-motion-spherical", 'Camera "spherical"\nWorldBegin\nLightSource "infinite"\n',
         ['"motion"', '"perspective"', '"orthographic"'], 1, ["--aov", "motion"]),
    Case("aovs-motion-png", SCENE, ["--aov", "EXR", '"a.png"'], 1, ["--aov", "motion", "--outfile", "a.png"]),
    Case("aovs-half-bdpt", 'Integrator "bdpt"\n' + SCENE, ['"half"', '"path"', '"volpath"'], 1, ["--aov", "half"]),
    Case("aovs-half-lightpath", 'Integrator "lightpath"\n' + SCENE, ['"half"', '"path"'], 1, ["--aov", "depth,half"]),
    Case("aovs-group-empty", grouped('@"string group" ""'), ["light group", "is empty"]),
    Case("aovs-group-characters", grouped('@"string group" "a.b"'), ["light group", "letters"]),
    Case("aovs-group-area", 'WorldBegin\nAreaLightSource "diffuse" @"string group" ""\nShape "sphere"\n',
         ["light group", "is empty"]),
    Case("aovs-group-attribute", 'WorldBegin\nAttribute "light" "string group" "a b"\nLightSource "point"\n',
         ["light group", "letters"]),
    Case("aovs-group-many", "WorldBegin\n" + "".join(
        'LightSource "point" "string group" "g%d"\n' % i for i in range(48)) +
        'LightSource "point" @"string group" "g48"\n', ['"g48"', "one light group too many", "48"]),
    Case("aovs-crypto-png", SCENE, ["--aov", "EXR", '"a.png"'], 1,
         ["--aov", "cryptoobject", "--outfile", "a.png"]),
]

CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


# Holes, a moving thing, a lens, instances that overlap, and two materials on several things.
THINGS = """Film "rgb" "integer xresolution" 40 "integer yresolution" 30 "string filename" "scene.exr"
Sampler "independent" "integer pixelsamples" 32
PixelFilter "gaussian"
LookAt 0 1 -6  0 0 0  0 1 0
Camera "perspective" "float fov" 40 "float lensradius" .15 "float focaldistance" 6
WorldBegin
LightSource "infinite"
MakeNamedMaterial "a" "string type" "diffuse" "rgb reflectance" [%s %s %s]
MakeNamedMaterial "b" "string type" "diffuse" "rgb reflectance" [%s %s %s]
Texture "holes" "float" "checkerboard" "float uscale" 9 "float vscale" 5 "float tex1" .3 "float tex2" 1
ObjectBegin "ball"
NamedMaterial "b"
Shape "sphere" "float radius" .7
ObjectEnd
NamedMaterial "a"
Shape "sphere" "texture alpha" "holes"
AttributeBegin Translate -1 0 -1 ObjectInstance "ball" AttributeEnd
AttributeBegin Translate 1.2 0 1 ObjectInstance "ball" AttributeEnd
AttributeBegin
ActiveTransform EndTime Translate 1 .5 0 ActiveTransform All
Translate .5 .9 -1 Shape "disk" "float radius" .5
AttributeEnd
NamedMaterial "b"
Translate 0 -1 0 Rotate 90 1 0 0
Shape "disk" "float radius" 2
"""


WHITE = 'Material "diffuse" "rgb reflectance" [1 1 1]'


def things(a=.5, b=.5):
    return THINGS % (a, a, a, b, b, b)


def planes(tool, folder, name, channels):
    """Values of channels, each a list over the pixels (rows from below)."""
    result = {}
    for i in range(0, len(channels), 3):
        three = (channels[i:i + 3] + 2 * channels[:1])[:3]
        oiiotool(folder, name, "--ch", ",".join("%s=%s" % pair for pair in zip("RGB", three)), "-o", "three.exr")
        done = tool.run(["convert", "three.exr", "three.pfm", "--quiet"], folder)
        assert done.status == 0, done.err
        with open(os.path.join(folder, "three.pfm"), "rb") as f:
            head, size, order, data = f.read().split(b"\n", 3)
        width, height = map(int, size.split())
        values = struct.unpack("<%df" % (3 * width * height), data)
        for k, channel in enumerate(three):
            result[channel] = values[k::3]
    return result


def bits(value):
    return "%08x" % struct.unpack("<I", struct.pack("<f", value))[0]


def metadata(tool, folder, name):
    done = tool.run(["info", "--json", name], folder)
    assert done.status == 0, done.err
    return json.loads(done.out)[0]["metadata"]


def mattes(tool, folder, name, layer, ranks=6):
    """name -> coverage of each pixel, as a compositor decodes it."""
    header = metadata(tool, folder, name)
    keys = [k for k, v in header.items() if re.fullmatch(r"cryptomatte/[0-9a-f]{7}/name", k) and v == layer]
    assert len(keys) == 1, header
    prefix = keys[0][:-len("name")]
    assert header[prefix + "hash"] == "MurmurHash3_32" and header[prefix + "conversion"] == "uint32_to_float32"
    manifest = json.loads(header[prefix + "manifest"])
    channels = ["%s%02d.%s" % (layer, i // 2, c) for i in range(ranks) for c in ("rg" if i % 2 == 0 else "ba")]
    values = planes(tool, folder, name, channels)
    result = {}
    for thing, code in manifest.items():
        result[thing] = [sum(values[c][p] for i, c in zip(channels[::2], channels[1::2]) if bits(values[i][p]) == code)
                         for p in range(len(values[channels[0]]))]
    return result


def close(a, b, tolerance, what):
    worst = max(abs(x - y) for x, y in zip(a, b))
    assert len(a) == len(b) and worst <= tolerance, "%s: differs by %g" % (what, worst)


@check
def cryptomattes_are_coverages_by_brute_force(tool, folder):
    """A matte equals the albedo of the same samples where the thing alone is white and all else black.

    All samples have the same wavelengths: then the albedo is the mean of zeros and ones, without noise of colour.
    """
    def albedo(scene):
        render(tool, folder, "--quiet", "--disable-wavelength-jitter", "--aov", "albedo", scene=scene)
        return planes(tool, folder, "scene.exr", ["Albedo.R"])["Albedo.R"]

    names = ["sphere@scene.pbrt:16", "disk@scene.pbrt:21", "disk@scene.pbrt:25", "ball", "ball#2"]
    render(tool, folder, "--quiet", "--aov", "cryptoobject,cryptomaterial", scene=things())
    objects = mattes(tool, folder, "scene.exr", "CryptoObject")
    materials = mattes(tool, folder, "scene.exr", "CryptoMaterial")
    assert sorted(objects) == sorted(names), list(objects)
    assert sorted(materials) == ["a", "b", "default"] and not any(materials["default"]), list(materials)
    for material, colors in (("a", (1, 0)), ("b", (0, 1))):
        close(materials[material], albedo(things(*colors)), 2e-5, material)
    # Every object of a material, painted alone.
    everything = things(0, 0).split("\n")
    for name, line in ((names[0], 16), (names[1], 21), (names[2], 25)):
        painted = list(everything)
        painted[line - 1] = re.sub("(Shape .*)", r"AttributeBegin %s \1 AttributeEnd" % WHITE, painted[line - 1])
        close(objects[name], albedo("\n".join(painted)), 2e-5, name)
    both = [x + y for x, y in zip(objects["ball"], objects["ball#2"])]
    close(both, albedo(things(0, 0).replace('Shape "sphere" "float radius" .7',
                                            WHITE + ' Shape "sphere" "float radius" .7')), 2e-5, "both balls")
    # All objects together cover what all materials do.
    close([sum(v) for v in zip(*objects.values())], [sum(v) for v in zip(*materials.values())], 2e-5, "sum")
    assert 0.2 < max(objects["ball#2"]) <= 1, "the second ball is not seen"


@check
def passes_are_layers_that_sum_to_the_image(tool, folder):
    """Through the file, by pass and by group; they change neither colours nor alpha, whatever the threads."""
    scene = things().replace('LightSource "infinite"', """LightSource "infinite" "string group" "sky"
LightSource "point" "point3 from" [0 4 -4] "rgb I" [9 6 3]""")
    render(tool, folder, "--quiet", "--outfile", "plain.exr", scene=scene)
    names = "alpha,emission,direct,indirect,lightgroups"
    render(tool, folder, "--quiet", "--aov", names, scene=scene)
    done = tool.run(["scene.pbrt", "--quiet", "--nthreads", "7", "--aov", names, "--outfile", "more.exr"], folder)
    assert done.status == 0 and pixels(folder, "scene.exr") == pixels(folder, "more.exr"), "threads change passes"
    oiiotool(folder, "scene.exr", "--ch", "R,G,B", "-o", "rgb.exr")
    assert pixels(folder, "rgb.exr") == pixels(folder, "plain.exr"), "passes change the image"
    for layers in (("emission", "direct", "indirect"), ("lightgroup.sky", "nolightgroup")):
        total = [[0.0] * 1200 for _ in range(3)]
        for layer in layers:
            done = tool.run(["convert", "scene.exr", "layer.exr", "--layer", layer], folder)
            assert done.status == 0, done.err
            values = planes(tool, folder, "layer.exr", ["R", "G", "B"])
            total = [[x + y for x, y in zip(t, values[c])] for t, c in zip(total, "RGB")]
        whole = planes(tool, folder, "plain.exr", ["R", "G", "B"])
        for sums, c in zip(total, "RGB"):
            close(sums, whole[c], 1e-5, " + ".join(layers))
    done = tool.run(["convert", "scene.exr", "layer.exr", "--layer", "indirct"], folder)
    assert done.status == 1, done.status
    has(done.err, "--layer", '"indirect"')


@check
def alpha_goes_into_png(tool, folder):
    """Divided by alpha there, as that format has it: a disk of one colour has that colour at its edge, too."""
    scene = 'LookAt 0 0 -5  0 0 0  0 1 0 Camera "perspective" "float fov" 40 ' + SMALL.replace(
        'LightSource "infinite"', 'LightSource "point" "point3 from" [0 0 -50]') % ("rgb", "")
    render(tool, folder, "--quiet", "--spp", "64", "--aov", "alpha", "--outfile", "a.exr", scene=scene)
    render(tool, folder, "--quiet", "--spp", "64", "--aov", "alpha", "--outfile", "a.png", scene=scene)
    alpha = planes(tool, folder, "a.exr", ["A"])["A"]
    assert min(alpha) == 0 and max(alpha) == 1 and any(0 < a < 1 for a in alpha), alpha
    has(info(folder, "a.png"), "4 channel")
    flat = scene.replace('Shape "sphere"', 'AreaLightSource "diffuse" "rgb L" [.5 .25 .1] "bool twosided" true Shape "disk"')
    render(tool, folder, "--quiet", "--spp", "64", "--aov", "alpha", "--outfile", "b.png", scene=flat)
    # oiiotool would multiply by alpha again.
    done = tool.run(["convert", "b.png", "b.exr"], folder)
    assert done.status == 0, done.err
    edge = [g for g in planes(tool, folder, "b.exr", ["G"])["G"] if g > 0]
    assert max(edge) - min(edge) < 0.03 and len(edge) > 20, edge


@check
def ids_have_manifests_and_do_not_change_the_image(tool, folder):
    render(tool, folder, "--quiet", "--outfile", "plain.exr", scene=things())
    render(tool, folder, "--quiet", "--aov", "object,material,cryptoobject", "--cryptomatte-ranks", "2", scene=things())
    header = metadata(tool, folder, "scene.exr")
    objects = json.loads(header["objectManifest"])
    assert sorted(objects.values()) == [1, 2, 3, 4, 5] and objects["ball"] == 4, objects
    assert json.loads(header["materialManifest"]) == {"a": 1, "b": 2, "default": 3}, header
    values = planes(tool, folder, "scene.exr", ["object.id", "material.id", "CryptoObject00.r", "CryptoObject00.g"])
    assert set(values["object.id"]) == {0, 1, 2, 3, 4, 5} and set(values["material.id"]) == {0, 1, 2}
    codes = json.loads(next(v for k, v in header.items() if k.endswith("manifest") and k.startswith("cryptomatte")))
    for number, code, coverage in zip(values["object.id"], values["CryptoObject00.r"], values["CryptoObject00.g"]):
        assert number == 0 or objects[[n for n in codes if codes[n] == bits(code)][0]] == number
        assert number != 0 or coverage < 0.5
    oiiotool(folder, "scene.exr", "--ch", "R,G,B", "-o", "rgb.exr")
    assert pixels(folder, "rgb.exr") == pixels(folder, "plain.exr"), "extra outputs change the image"


@check
def all_outputs_do_not_depend_on_threads(tool, folder):
    digests = set()
    everything = "albedo,normal,ng,position,depth,uv,variance,samples,object,material,cryptoobject,cryptomaterial"
    scene = things().replace("diffuse", "coateddiffuse", 1)
    for threads in ("1", "5"):
        write(folder, "scene.pbrt", scene)
        done = tool.run(["scene.pbrt", "--quiet", "--nthreads", threads, "--aov", everything], folder)
        assert done.status == 0, done.err
        digests.add(pixels(folder))
    assert len(digests) == 1, digests


@check
def half_floats_leave_ids_whole(tool, folder):
    scene = things().replace('"string filename"', '"bool savefp16" true "string filename"')
    render(tool, folder, "--quiet", "--aov", "albedo,depth,cryptoobject", "--outfile", "half.exr", scene=scene)
    render(tool, folder, "--quiet", "--aov", "albedo,depth,cryptoobject", "--outfile", "float.exr", scene=things())
    has(info(folder, "half.exr"), r"R \(half\)", r"Albedo.R \(half\)", r"Z \(float\)", r"CryptoObject02.a \(float\)")
    for group in ("00.r,CryptoObject00.g,CryptoObject00.b", "02.a,Z"):
        for name in ("half", "float"):
            oiiotool(folder, name + ".exr", "--ch", "CryptoObject" + group, "-o", name + "-part.exr")
        assert pixels(folder, "half-part.exr") == pixels(folder, "float-part.exr"), group


@check
def albedo_of_glass_is_one_and_of_others_below(tool, folder):
    """Glass loses nothing, from outside and from inside; metals, coats and rough glass seen from inside do.

    There, facets beyond the critical angle reflect into the surface, and single scattering loses that light:
    by the GGX distribution 5.7 % of them at alpha 0.22 and index 1.5.
    """
    ball = SCENE.replace('Material "conductor" "float roughness" 0.2', "%s")

    def albedo(material):
        render(tool, folder, "--quiet", "--pixel", "24,15", "--aov", "albedo", "--outfile", "a.exr", scene=ball % material)
        return [planes(tool, folder, "a.exr", ["Albedo." + c])["Albedo." + c][0] for c in "RGB"]

    for turned in ("", "ReverseOrientation "):
        for roughness in ("0", "0.05"):
            value = albedo(turned + 'Material "dielectric" "float roughness" ' + roughness)
            least = 0.9 if turned and roughness != "0" else 0.995
            assert all(least < v <= 1 for v in value), (turned, roughness, value)
        assert all(0.9999 < v <= 1 for v in albedo(turned + 'Material "thindielectric"'))
    gold = albedo('Material "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" "metal-Au-k" "float roughness" 0')
    assert 1 >= gold[0] > gold[1] > gold[2] > 0.2, gold
    bare = albedo('Material "diffuse" "rgb reflectance" [.8 .4 .2]')
    close(bare, [.8, .4, .2], 0.08, "diffuse")  # eight samples of eight wavelengths
    coated = albedo('Material "coateddiffuse" "rgb reflectance" [.8 .4 .2]')
    assert all(0.05 < v < 1 for v in coated), coated


GBUFFER = ("R G B Albedo.R Albedo.G Albedo.B P.X P.Y P.Z dzdx dzdy N.X N.Y N.Z Ns.X Ns.Y Ns.Z u v "
           "Variance.R Variance.G Variance.B RelativeVariance.R RelativeVariance.G RelativeVariance.B").split()


@check
def gbuffers_have_the_channels_of_pbrt(tool, folder):
    scene = SCENE.replace('Film "rgb"', 'Film "gbuffer" %s')
    render(tool, folder, "--outfile", "plain.exr")
    render(tool, folder, "--quiet", scene=scene % "")
    header = json.loads(tool.run(["info", "--json", "scene.exr"], folder).out)[0]
    assert sorted(c["name"] for c in header["channels"]) == sorted(GBUFFER), header["channels"]
    oiiotool(folder, "scene.exr", "--ch", "R,G,B", "-o", "rgb.exr")
    assert pixels(folder, "rgb.exr") == pixels(folder, "plain.exr"), "the colours are not those of the film rgb"
    # In world space it says the same as the outputs of the command line.
    render(tool, folder, "--quiet", scene=scene % '"string coordinatesystem" "world"')
    render(tool, folder, "--quiet", "--aov", "albedo,position,ng,normal,uv", "--outfile", "aovs.exr")
    for name in ("scene", "aovs"):
        oiiotool(folder, name + ".exr", "--ch", ",".join(GBUFFER[3:9] + GBUFFER[11:19]), "-o", name + "-part.exr")
    assert pixels(folder, "scene-part.exr") == pixels(folder, "aovs-part.exr"), "the film and --aov differ"


@check
def gbuffer_and_outputs_share_a_file(tool, folder):
    scene = SCENE.replace('Film "rgb"', 'Film "gbuffer"')
    render(tool, folder, "--quiet", "--outfile", "film.exr", scene=scene)
    render(tool, folder, "--quiet", "--aov", "position,depth,cryptoobject", scene=scene)
    oiiotool(folder, "scene.exr", "--ch", ",".join(GBUFFER), "-o", "part.exr")
    oiiotool(folder, "film.exr", "--ch", ",".join(GBUFFER), "-o", "film-part.exr")
    assert pixels(folder, "part.exr") == pixels(folder, "film-part.exr"), "--aov changes the film's channels"
    values = planes(tool, folder, "scene.exr", ["P.Z", "Z"])
    close(values["P.Z"], values["Z"], 1e-5, "camera space")


@check
def merging_ids_is_refused(tool, folder):
    for seed in ("1", "2"):
        render(tool, folder, "--quiet", "--seed", seed, "--aov", "cryptoobject,samples", "--outfile", seed + ".exr",
               scene=things())
    done = tool.run(["merge", "1.exr", "2.exr", "--outfile", "m.exr"], folder)
    assert done.status == 3, done
    has(done.err, "1.exr", "CryptoObject00", "no average")
    assert not os.path.exists(os.path.join(folder, "m.exr"))


@check
def light_tracing_has_outputs_as_well(tool, folder):
    for name in ("path", "lightpath"):
        scene = 'Integrator "%s"\n' % name + SCENE
        render(tool, folder, "--quiet", "--aov", "depth,normal,uv,object", "--outfile", name + ".exr", scene=scene)
        oiiotool(folder, name + ".exr", "--ch", "Z,N.X,N.Y,N.Z,u,v,object", "-o", name + "-part.exr")
    assert pixels(folder, "lightpath-part.exr") == pixels(folder, "path-part.exr")


def table_of_integrators():
    """Rows of the table in the documents: for each integrator the words of its columns."""
    here = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(here, "..", "..", "docs", "aovs.md")) as f:
        section = f.read().split("## Which integrator has what", 1)[1].split("\n## ", 1)[0]
    rows = {}
    for line in section.splitlines():
        if line.startswith("| `"):
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            for name in re.findall(r"`(\w+)`", cells[0]):
                rows[name] = cells[1:]
    return rows


FOG = """Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "string filename" "scene.exr"
Sampler "independent" "integer pixelsamples" 4
WorldBegin
LightSource "infinite"
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [.1 .1 .1] "rgb sigma_s" [.2 .2 .2]
Material "interface" MediumInterface "fog" "" Translate 0 0 2 Shape "sphere"
"""
FIRST_HITS = {"albedo": "Albedo.R", "alpha": "A", "normal": "Ns.Z", "ng": "N.Z", "position": "P.Z", "depth": "Z",
              "motion": "motion.X", "uv": "u", "object": "object.id", "material": "material.id",
              "cryptoobject": "CryptoObject00.r", "cryptomaterial": "CryptoMaterial00.r"}


@check
def every_integrator_has_what_the_table_says(tool, folder):
    """Each output under each integrator: values that are not all 0, or a usage error that names who can."""
    plugins = [line.split("\t") for line in tool.run(["plugins"], folder).out.decode().splitlines()]
    names = [name for kind, name in plugins if kind == "integrator"]
    rows = table_of_integrators()
    assert sorted(rows) == sorted(names), (sorted(rows), names)
    moving = things().replace("Camera", "ActiveTransform EndTime Translate .1 0 0 ActiveTransform All\nCamera")
    for name, (first, variance, half, passes) in rows.items():
        scene = 'Integrator "%s"\n' % name + (FOG if name == "simplevolpath" else moving)
        write(folder, "scene.pbrt", scene)

        def channels(outputs):
            """Those with a value other than 0; None: an error."""
            done = tool.run(["scene.pbrt", "--quiet", "--spp", "2", "--resolution", "12x9", "--aov", outputs], folder)
            assert done.status in (0, 1), (name, outputs, done)
            if done.status == 1:
                has(done.err, '"path"', '"volpath"')
                return None
            lines = [line.split() for line in tool.run(["info", "scene.exr"], folder).out.decode().splitlines()]
            return {w[0] for w in lines if len(w) == 6 and w[1][-1].isdigit() and (float(w[1]) or float(w[2]))}

        found = channels(",".join([*FIRST_HITS, "variance"]))
        for output, channel in FIRST_HITS.items():
            expected = first == "yes" or "`%s`" % output in first
            assert (channel in found) == expected, (name, output, found)
        assert ("Variance.Y" in found) == (variance != "zero"), (name, variance)
        for outputs, channel, says in (("half", "Half.R", half), ("lpe:all=C.*,lightgroups", "all.R", passes),
                                       ("layered.rest,direct", "direct.R", passes)):
            found = channels(outputs)
            assert (found is not None) == (says == "yes"), (name, outputs, found)
            # The background alone is no direct light.
            assert found is None or channel in found, (name, outputs, found)
