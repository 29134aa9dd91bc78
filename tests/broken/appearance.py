"""lacquer preview, the colours of bsdf, thin films and OpenPBR: wrong ones, and what they write."""
import json
import os
import struct

from command_line import has, left
from run import Case
from scenes import SMALL, world

SCENE = SMALL + """WorldBegin
Texture "thick" "float" "constant" "float value" 300
MakeNamedMaterial "satin" "string type" "conductor" "float roughness" 0.2
MakeNamedMaterial "matt" "string type" "conductor" "float roughness" 0.5
MakeNamedMaterial "paint" "string type" "openpbr" "rgb base_color" [0.6 0.05 0.02]
MakeNamedMaterial "glossy" "string type" "openpbr" "rgb base_color" [0.6 0.05 0.02] "float specular_roughness" 0.05
MakeNamedMaterial "glass" "string type" "dielectric" "float roughness" 0.3
MakeNamedMaterial "mirror" "string type" "conductor"
MakeNamedMaterial "brushed" "string type" "conductor" "float uroughness" 0.1 "float vroughness" 0.5
Material "conductor" "texture thinfilm_thickness" "thick"
Shape "sphere"
"""


def preview(name, args, says, status=1, scene=SCENE, **more):
    return Case("preview-" + name, None, says, status, ["preview"] + args, {"a.pbrt": scene}, **more)


def export(name, material, tables, says):
    args = ["bsdf", "a.pbrt", "--material", material, "--wi", "45,0", "--out", "o", "--quiet", "--export", tables]
    return Case("bsdf-export-" + name, None, says, 1, args, {"a.pbrt": SCENE})


def openpbr(name, parameters, says):
    return Case("openpbr-" + name, world('Material "openpbr" %s\nShape "sphere"' % parameters), says)
def openpbr(name, parameters, says, status=2):
    return Case("openpbr-" + name, world('Material "openpbr" %s\nShape "sphere"' % parameters), says, status)


CASES = [
    preview("nothing", [], ["scene file", "--define"]),
    preview("both", ["a.pbrt", "--define", 'Material "diffuse"'], ["--define", "both"]),
    preview("missing", ["none.pbrt"], ["none.pbrt"], 3),
    preview("material", ["a.pbrt", "--material", "piant"], ['no material "piant"', '"paint"?'], 2),
    preview("material-number", ["a.pbrt", "--material", "@2"], ['no material "@2"', '"@1"?'], 2),
    preview("no-material", ["a.pbrt"], ["no material to show"], 2, SMALL + 'WorldBegin Shape "sphere"'),
    preview("vary-thrice", ["a.pbrt"] + ["--vary", "paint.coat_weight=0,1"] * 3, ["--vary", "two directions"]),
    preview("vary-unknown", ["a.pbrt", "--vary", "piant.coat_weight=0,1", "--resolution", "16x16"], ["--vary", "piant", '"paint"']),
    preview("vary-parameter", ["a.pbrt", "--material", "paint", "--vary", "paint.coat_wieght=0,1", "--resolution", "16x16"],
            ["coat_wieght", '"coat_weight"'], 2),
    preview("vary-many", ["a.pbrt", "--vary", "paint.coat_weight=" + ",".join(["0"] * 401)], ["--vary", "401", "400"]),
    preview("outfile", ["a.pbrt", "--outfile", "no/a.png"], ["no/a.png"], 3),
    preview("outfile-format", ["a.pbrt", "--outfile", "a.xyz"], ["a.xyz"], 3),
    preview("resolution", ["a.pbrt", "--resolution", "64"], ["--resolution", "WIDTHxHEIGHT"]),
    preview("spp", ["a.pbrt", "--spp", "0"], ["--spp"]),
    preview("define-wrong", ["--define", 'Material "openpbr" "float coat_wieght" 1'], ["--define:2:", "coat_wieght", '"coat_weight"?'], 2),
    preview("reference", ["a.pbrt", "--material", "paint", "--reference", "glosy", "--resolution", "16x16"], ["glosy", '"glossy"'], 2),
    export("unknown", "matt", "rlg", ["--export", '"rlg"', '"rgl"?']),
    export("one-unknown", "matt", "merl,klmes", ["--export", '"klmes"', '"klems"?']),
    export("rgl-specular", "mirror", "rgl", ["--export rgl", '"mirror" has specular reflections', "klems"]),
    export("rgl-transmissive", "glass", "rgl", ["--export rgl", '"glass" transmits light', "klems"]),
    export("merl-anisotropic-specular", "mirror", "klems,merl-anisotropic", ["--export merl-anisotropic", '"mirror" has specular']),
    export("merl-anisotropic-transmissive", "glass", "merl-anisotropic", ["--export merl-anisotropic", '"glass" transmits']),
    Case("svbrdf-name", world('Material "svbrdf" @"rgb specluar" [0.04 0.04 0.04]\nShape "sphere"'), ["specluar", '"specular"?']),
    Case("svbrdf-roughness", world('Material "svbrdf" @"float roughness" 0.2\nShape "sphere"'), ["roughness", "svbrdf"]),
    Case("svbrdf-albedo", world('Material "svbrdf" @"rgb albedo" [2 0 0]\nShape "sphere"'), ["albedo", "[0, 1]"]),
    openpbr("weight", '@"float coat_weight" 1.5', ["coat_weight", "1.5", "from 0 to 1"]),
    openpbr("ior", '@"float specular_ior" 0', ["specular_ior", "from"]),
    openpbr("anisotropy", '@"float subsurface_scatter_anisotropy" 2', ["subsurface_scatter_anisotropy"]),
    openpbr("color", '@"rgb base_color" [2 0 0]', ["base_color"]),
    openpbr("emission", '@"float emission_luminance" -1', ["emission_luminance", "-1"]),
    openpbr("emission-color", '"float emission_luminance" 1 @"spectrum emission_color" [400 0 700 0]', ["finite luminance above zero", "integral with the luminous efficiency is 0"]),
    openpbr("coat-map", '@"string coat_normalmap" "nowhere.png"', ["nowhere.png"], 3),
    openpbr("coat-map-type", '@"float coat_normalmap" 1', ["coat_normalmap"]),
    openpbr("misspelt", '@"float coat_roughnes" 0.1', ["coat_roughnes", '"coat_roughness"?']),
    openpbr("estimator", '@"string estimator" "bidirectinal"', ["bidirectinal", '"bidirectional"']),
]

MTLX = """<?xml version="1.0"?>
<materialx version="1.38" colorspace="lin_rec709">
  <noise2d name="N" type="float"/>
  <standard_surface name="S" type="surfaceshader">
    <input name="base_color" type="color3" value="0.6, 0.05, 0.02"/>
    <input name="specular_roughness" type="float" nodename="N"/>
  </standard_surface>
  <surfacematerial name="Red" type="material"><input name="surfaceshader" type="surfaceshader" nodename="S"/></surfacematerial>
</materialx>
"""


def materialx(name, args, says, status=1, text=MTLX, **more):
    return Case("materialx-" + name, None, says, status, args, {"a.mtlx": text}, **more)


CASES += [
    materialx("missing", ["preview", "b.mtlx"], ["b.mtlx"], 3),
    materialx("no-xml", ["preview", "a.mtlx"], ["a.mtlx", "XML"], 2, "MakeNamedMaterial"),
    materialx("empty", ["preview", "a.mtlx"], ["a.mtlx", "open_pbr_surface"], 2, "<materialx/>"),
    materialx("material", ["preview", "a.mtlx", "--material", "Rde"], ['no material "Rde"', '"Red"?'], 2, warns=True),
    materialx("convert-to-image", ["convert", "a.mtlx", "a.exr"], ["a.exr", ".pbrt"]),
    materialx("convert-format", ["convert", "a.mtlx", "a.pbrt", "--format"], ["a.mtlx", "--format"]),
]

CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


def size_of_png(folder, name):
    with open(os.path.join(folder, name), "rb") as file:
        head = file.read(24)
    assert head[:8] == b"\x89PNG\r\n\x1a\n", head
    return int.from_bytes(head[16:20], "big"), int.from_bytes(head[20:24], "big")


def run(tool, folder, *args):
    with open(os.path.join(folder, "a.pbrt"), "w", encoding="utf-8") as file:
        file.write(SCENE)
    result = tool.run(args, folder)
    assert result.status == 0, result.err
    return result


@check
def preview_shows_the_last_material(tool, folder):
    run(tool, folder, "preview", "a.pbrt", "--resolution", "48x32", "--spp", "1", "--outfile", "a.exr")
    run(tool, folder, "preview", "a.pbrt", "--resolution", "48x32", "--spp", "1", "--outfile", "b.exr", "--material", "@1", "--nthreads", "1")
    run(tool, folder, "preview", "a.pbrt", "--resolution", "48x32", "--spp", "1", "--outfile", "c.exr", "--material", "paint")
    same = [open(os.path.join(folder, name), "rb").read()[-500:] for name in ("a.exr", "b.exr", "c.exr")]
    assert same[0] == same[1] and same[1] != same[2]
    result = tool.run(["preview", "--define", 'Material "diffuse"', "--resolution", "20x20", "--spp", "1"], folder)
    assert result.status == 0 and size_of_png(folder, "preview.png") == (20, 20), result.err


@check
def preview_makes_sheets(tool, folder):
    run(tool, folder, "preview", "a.pbrt", "--material", "paint", "--resolution", "24x24", "--spp", "1", "--vary",
        "paint.coat_weight=0,0.5,1", "--vary", "paint.specular_roughness=0.1,0.9", "--outfile", "sheet.png")
    width, height = size_of_png(folder, "sheet.png")
    assert width > 3 * 24 and height > 2 * 24, (width, height)


@check
def preview_prints_colors(tool, folder):
    result = run(tool, folder, "preview", "a.pbrt", "--material", "satin", "--reference", "matt", "--resolution", "16x16",
                 "--spp", "1", "--quiet")
    text = result.out.decode()
    has(text, "CIEDE2000 from \"matt\"", "45as110", "di:8", "D50", "D65")
    assert len([line for line in text.splitlines() if " D65 " in line]) == 8, text


@check
def bsdf_exports_tables(tool, folder):
    run(tool, folder, "bsdf", "a.pbrt", "--material", "@1", "--wi", "45,0", "--out", "o", "--samples", "1", "--resolution", "16", "--quiet",
        "--export", "merl,klems")
    with open(os.path.join(folder, "o", "merl.binary"), "rb") as file:
        assert file.read(12) == b"Z\0\0\0Z\0\0\0\xb4\0\0\0"
    with open(os.path.join(folder, "o", "klems.xml"), encoding="utf-8") as file:
        has(file.read(), "LBNL/Klems Full", "Reflection Front")


@check
def bsdf_exports_what_measured_reads(tool, folder):
    def survey(material, *more):
        return run(tool, folder, "bsdf", "a.pbrt", "--material", material, "--wi", "45,0", "--out", "o", "--samples", "1", "--resolution", "16", *more)

    survey("matt", "--export", "merl-anisotropic", "--quiet")
    with open(os.path.join(folder, "o", "merl-anisotropic.binary"), "rb") as file:
        assert file.read(32) == b"ANISMERL" + struct.pack("<6I", 1, 45, 36, 30, 36, 3)
    survey("matt", "--export", "rgl", "--quiet")
    with open(os.path.join(folder, "m.pbrt"), "w", encoding="utf-8") as file:
        file.write(SMALL + 'WorldBegin LightSource "infinite" Material "measured" "string filename" "o/rgl.bsdf" Shape "sphere"')
    result = tool.run(["m.pbrt", "--outfile", "m.exr"], folder)
    assert result.status == 0, result.err
    # The isotropic form does not hold this.
    has(survey("brushed", "--export", "merl").err, "warning", "--export merl: the material is anisotropic")
    assert "anisotropic" not in survey("matt", "--export", "merl").err


@check
def bsdf_has_colors(tool, folder):
    run(tool, folder, "bsdf", "a.pbrt", "--material", "@1", "--wi", "45,0", "--out", "o", "--samples", "2", "--resolution", "16", "--quiet")
    with open(os.path.join(folder, "o", "table.json"), encoding="utf-8") as file:
        colors = json.load(file)["colors"]
    by_name = {g["name"]: g for g in colors["geometries"]}
    assert by_name["di:8"]["D65"]["Y"]["value"] > 30 and by_name["45:0"]["D65"]["Y"]["value"] == 0, by_name
    assert colors["reference"] is None


@check
def openpbr_warns_of_what_is_elsewhere(tool, folder):
    def warnings_of(parameters, before="", after=""):
        with open(os.path.join(folder, "e.pbrt"), "w", encoding="utf-8") as file:
            file.write(SMALL + 'WorldBegin LightSource "infinite"\n%s Material "openpbr" %s\nShape "sphere" %s' % (before, parameters, after))
        result = tool.run(["e.pbrt", "--outfile", "e.exr"], folder)
        assert result.status == 0, result.err
        return result.err

    has(warnings_of('"float geometry_coat_tangent" 3 "float coat_darkening" 0'), "coat_rotation", "coat_darkening")
    emits = '"float emission_luminance" 3'
    assert "warning" not in warnings_of(emits)
    has(warnings_of(emits + ' "float coat_weight" 0.5'), "emission", "coat")
    has(warnings_of(emits, 'AreaLightSource "diffuse"'), "e.pbrt:", "AreaLightSource", "emission")
    has(warnings_of(emits, 'ObjectBegin "o"', 'ObjectEnd ObjectInstance "o"'), "e.pbrt:", "object", "emission")
    texture = 'Texture "t" "spectrum" "constant" "rgb value" [1 1 1]\n'
    has(warnings_of(emits + ' "texture emission_color" "t"', texture), "emission_color", "AreaLightSource")
    curve = '\nShape "curve" "point3 P" [0 0 0 0 1 0 0 2 0 0 3 0] "float width" 0.1'
    has(warnings_of(emits, after=curve), "e.pbrt:", "curve", "material's emission is left out")
    # Of many shapes of a material it is said once.
    assert warnings_of(emits, after=curve * 3).count("warning") == 1
    mixed = 'MakeNamedMaterial "glow" "string type" "openpbr" "float emission_luminance" 3 MakeNamedMaterial "dull" "string type" "diffuse"\n'
    mix = '\nMaterial "mix" "string materials" ["%s" "dull"] Shape "sphere"'
    has(warnings_of("", mixed, mix % "glow"), "e.pbrt:", "\"glow\"", "mixtures emit nothing")
    assert "warning" not in warnings_of("", mixed, mix % "dull")


@check
def emission_of_a_wrong_type_is_not_sent_to_textures(tool, folder):
    with open(os.path.join(folder, "e.pbrt"), "w", encoding="utf-8") as file:
        file.write(SMALL + 'WorldBegin Material "openpbr" "float emission_luminance" 3 "string emission_color" "red"\nShape "sphere"')
    result = tool.run(["e.pbrt", "--outfile", "e.exr"], folder)
    assert result.status == 2 and "emission_color" in result.err and "texture" not in result.err, result.err


@check
def materialx_documents_are_materials(tool, folder):
    with open(os.path.join(folder, "a.mtlx"), "w", encoding="utf-8") as file:
        file.write(MTLX)
    result = tool.run(["preview", "a.mtlx", "--resolution", "16x16", "--spp", "1"], folder)
    assert result.status == 0 and size_of_png(folder, "preview.png") == (16, 16), result.err
    has(result.err, "a.mtlx:3:", "noise2d", "specular_roughness")
    result = tool.run(["convert", "a.mtlx", "red.pbrt", "--quiet"], folder)
    assert result.status == 0 and not result.err, result.err
    with open(os.path.join(folder, "s.pbrt"), "w", encoding="utf-8") as file:
        file.write(SMALL + 'WorldBegin LightSource "infinite" Include "red.pbrt" NamedMaterial "Red" Shape "sphere"')
    result = tool.run(["s.pbrt", "--outfile", "s.exr"], folder)
    assert result.status == 0, result.err
