#!/usr/bin/env python3
"""Checks scenes of Blender that were exported and rendered: check.py LACQUER FOLDER

FOLDER has what make_scenes.py made. Places and normals are compared with Cycles' passes and with Blender's own projection, light
with closed forms and with Cycles, materials in a white furnace with closed forms. Prints what fails and a closing line
'N passed, N failed'. Each kind of comparison has a negative control.
"""
import json
import math
import os
import subprocess
import sys

import numpy as np

import images

HERE = os.path.dirname(os.path.abspath(__file__))
EXPORT = os.path.join(HERE, "..", "..", "scripts", "blender-export")
LACQUER, FOLDER = sys.argv[1:3]
with open(os.path.join(FOLDER, "facts.json"), encoding="utf-8") as facts_file:
    FACTS = json.load(facts_file)
passed = failed = 0


def check(name, is_right, found=""):
    global passed, failed
    passed += bool(is_right)
    failed += not is_right
    if not is_right:
        print(f"FAILED: {name}: {found}")


def path(name, extension):
    return os.path.join(FOLDER, name + extension)


def run(*command, **settings):
    return subprocess.run(command, capture_output=True, text=True, **settings)


def export(name):
    """(status, standard error) of the export of a scene, and its text."""
    done = run(EXPORT, path(name, ".blend"), path(name, ".pbrt"))
    return done.returncode, done.stderr


def text_of(name):
    with open(path(name, ".pbrt"), encoding="utf-8") as file:
        return file.read()


def render(name, *options):
    done = run(LACQUER, path(name, ".pbrt"), "--quiet", "--outfile", path(name, "-lacquer.exr"), *options)
    check(f"{name} renders without a word", done.returncode == 0 and not done.stderr.strip(), done.stderr)
    return images.read(path(name, "-lacquer.exr"))


def cycles(name):
    return images.read(path(name, "-cycles.exr"))[0]


def is_near(found, expected, tolerance):
    """Relative to the largest expected component; numbers or arrays."""
    scale = max(np.max(np.abs(expected)), 1e-9)
    return bool(np.all(np.abs(np.asarray(found) - expected) <= tolerance * scale))


# ---- Places ----

def agreement(ours, theirs, limit):
    """Part of the pixels whose vectors differ by less than the limit."""
    seen = np.linalg.norm(theirs, axis=2) > 0
    return float(np.mean(np.linalg.norm(ours - theirs, axis=2)[seen] < limit))


def check_camera(name):
    facts = FACTS[name]
    status, said = export(name)
    check(f"{name}: no warnings", status == 0 and "0 warnings" in said and "warning:" not in said, said)
    text = text_of(name)
    counts = text.count("ObjectInstance"), text.count('Shape "plymesh"')
    check(f"{name}: each object once", counts == (7, 10), counts)
    channels, _ = render(name, "--spp", "16", "--aov", "position,normal")
    ours, normals = images.vectors(channels, "P"), images.vectors(channels, "Ns")
    other = cycles(name)
    theirs, their_normals = images.vectors(other, "Position"), images.vectors(other, "Normal")
    if facts["border"]:
        left, right, low, high = facts["border"]
        height, width = theirs.shape[:2]
        theirs = theirs[round((1 - high) * height):round((1 - low) * height), round(left * width):round(right * width)]
        their_normals = their_normals[:theirs.shape[0], :theirs.shape[1]] if their_normals.shape == theirs.shape else \
            their_normals[round((1 - high) * height):round((1 - low) * height), round(left * width):round(right * width)]
    check(f"{name}: size", ours.shape == theirs.shape, (ours.shape, theirs.shape))
    if ours.shape != theirs.shape:
        return
    # Cycles takes one sample anywhere in the pixel (and its filter), Lacquer the mean: a pixel is 0.1 wide or so. At edges of
    # objects both may be anywhere.
    near = agreement(ours, theirs, 0.3)
    check(f"{name}: positions as in Cycles", near > 0.9, near)
    check(f"{name}: normals as in Cycles", agreement(normals, their_normals, 0.25) > 0.85, agreement(normals, their_normals, 0.25))
    for what, moved in (("mirrored", ours[:, ::-1]), ("upside down", ours[::-1]), ("shifted", np.roll(ours, 4, axis=1))):
        check(f"{name}: control: {what} is noticed", agreement(moved, theirs, 0.3) < 0.7, agreement(moved, theirs, 0.3))
    check(f"{name}: control: flipped normals are noticed", agreement(-normals, their_normals, 0.25) < 0.1)
    check_projection(name, ours, facts)


def check_projection(name, ours, facts):
    """Points of the ground, and where Blender says that they are seen."""
    height, width = ours.shape[:2]
    num_seen = 0
    for point, (x, y) in zip(facts["points"], facts["views"]):
        if facts["border"]:
            left, right, low, high = facts["border"]
            x, y = (x - left) / (right - left), (y - low) / (high - low)
        column, row = math.floor(x * width), math.floor((1 - y) * height)
        if not (0 <= column < width and 0 <= row < height) or abs(ours[row, column][2]) > 1e-3:
            continue  # outside, or behind an object
        num_seen += 1
        check(f"{name}: {point} is seen where Blender says", np.linalg.norm(ours[row, column] - point) < 0.2, ours[row, column])
    check(f"{name}: points are seen", num_seen >= 1, num_seen)


# ---- Lights ----

def rectangle_irradiance(radiance, a, b, h):
    """At the foot of the centre of a rectangle 2a x 2b at height h, parallel to it: four times that of a corner."""
    x, y = a / h, b / h
    corner = (x / math.hypot(1, x) * math.atan(y / math.hypot(1, x)) + y / math.hypot(1, y) * math.atan(x / math.hypot(1, y)))
    return radiance * 2 * corner


def ellipse_irradiance(radiance, a, b, h, steps=400):
    """The same of an ellipse with these half axes, by the midpoint rule in polar coordinates of its square."""
    r = (np.arange(steps) + 0.5) / steps
    phi = (np.arange(steps) + 0.5) / steps * 2 * np.pi
    x, y = a * np.outer(r, np.cos(phi)), b * np.outer(r, np.sin(phi))
    d2 = x * x + y * y + h * h
    return radiance * float(np.sum(h * h / d2 ** 2 * r[:, None])) * a * b * (1 / steps) * (2 * np.pi / steps)


def spot_irradiance(power, distance, axis_deg, size_deg, blend):
    """On a plane whose normal points to the lamp; the lamp's axis is turned away."""
    edge = math.cos(math.radians(size_deg / 2))
    t = min(max((math.cos(math.radians(axis_deg)) - edge) / ((1 - edge) * blend), 0), 1)
    return power / (4 * math.pi) / distance ** 2 * t * t * (3 - 2 * t)


IRRADIANCES = {
    "point": 100 / (4 * math.pi) / 4,
    "point-soft": 100 / (4 * math.pi) / 4,
    "sun": 3 * math.cos(math.radians(40)),
    "spot-inside": spot_irradiance(100, 2, 0, 60, 0.5),
    "spot-edge": spot_irradiance(100, 2, 14, 36, 0.6),
    "area-square": rectangle_irradiance(100 / (4 * 1.5 ** 2), 0.75, 0.75, 2),
    "area-rectangle": rectangle_irradiance(100 / (4 * 0.8 * 3.6), 0.4, 1.8, 2),
    "area-disk": math.pi * 100 / (4 * math.pi * 0.75 ** 2) * 0.75 ** 2 / (0.75 ** 2 + 4),
    "area-ellipse": ellipse_irradiance(100 / (4 * math.pi * 0.75 * 0.25), 0.75, 0.25, 2),
    "mesh": rectangle_irradiance(5, 0.5, 0.5, 2),
    "world": math.pi * 2 * np.array([0.2, 0.5, 0.9]),
}
# What Cycles does otherwise, so that only the closed form is asked: see docs/blender.md.
UNLIKE_CYCLES = {"spot-edge": "Cycles multiplies by the cosine to the axis", "point-soft": "Cycles has a disk, not a ball"}


def check_lamp(name, irradiance):
    status, said = export("lamp-" + name)
    check(f"lamp {name}: exports", status == 0, said)
    channels, _ = render("lamp-" + name, "--spp", "256")
    found = images.rgb(channels).mean(axis=(0, 1))
    expected = 0.5 / math.pi * irradiance * np.ones(3)
    # Means over 256 pixels of 256 samples: the noise of all is below 0.3 %; the patch is 0.05 wide, at 2 below the lamps.
    check(f"lamp {name}: closed form", is_near(found, expected, 0.01), (found, expected))
    check(f"lamp {name}: control: 3 % are noticed", not is_near(found * 1.03, expected, 0.01))
    theirs = images.rgb(cycles("lamp-" + name)).mean(axis=(0, 1))
    if name not in UNLIKE_CYCLES:
        check(f"lamp {name}: as in Cycles", is_near(found, theirs, 0.015), (found, theirs))


# ---- Environments ----

def check_environment(name):
    facts = FACTS[name]
    status, said = export(name)
    check(f"{name}: exports", status == 0 and "0 warnings" in said, said)
    channels, _ = render(name, "--spp", "64")
    found = images.rgb(channels)
    height, width = found.shape[:2]
    # Corners of the frame from the upper right, clockwise.
    upper_right, lower_right, lower_left, upper_left = np.array(facts["corners"])
    x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    direction = upper_left + x[:, :, None] * (upper_right - upper_left) + y[:, :, None] * (lower_left - upper_left)
    direction /= np.linalg.norm(direction, axis=2, keepdims=True)
    expected = 0.5 + 0.5 * direction @ np.array(facts["rotation"]).T
    error = float(np.abs(found - expected).max())
    # The image has 256 columns: half a texel is 0.012 of a direction, and the equal-area map has as many texels.
    check(f"{name}: values by direction", error < 0.03, error)
    theirs = images.rgb(cycles(name))
    check(f"{name}: as in Cycles", np.abs(found - theirs).max() < 0.03, np.abs(found - theirs).max())
    for what, turned in (("mirrored", direction * [-1, 1, 1]), ("turned by 5 degrees", turn(direction, 5)), ("upside down", -direction)):
        other = 0.5 + 0.5 * turned @ np.array(facts["rotation"]).T
        check(f"{name}: control: {what} is noticed", np.abs(found - other).max() > 0.035, np.abs(found - other).max())


def turn(directions, degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return directions @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])


def check_sky(name):
    """The two skies differ in colour and some in brightness and in the light around the sun, not in where the sun is."""
    status, said = export(name)
    check(f"{name}: exports and says what it is", status == 0 and "the format's own sky" in said, said)
    found, theirs = (image.mean(axis=2) for image in (images.rgb(render(name, "--spp", "64")[0]), images.rgb(cycles(name))))
    ratio = found.mean() / theirs.mean()
    check(f"{name}: brightness of Cycles", 0.7 < ratio < 1.4, ratio)

    def likeness(image):
        return float(np.corrcoef(np.log(image).ravel(), np.log(theirs).ravel())[0, 1])

    like = likeness(found)
    check(f"{name}: shading of Cycles", like > (0.7 if name in ("sky-hosek", "sky-preetham") else 0.9), like)
    for what, turned in (("mirrored", found[:, ::-1]), ("upside down", found[::-1]), ("turned", np.rot90(found))):
        check(f"{name}: control: {what} is noticed", likeness(turned) < like - 0.05, (likeness(turned), like))


# ---- Materials ----

COLOR = 0.5
F0 = 0.04


def over(reflectance, base):
    """A smooth interface over a mirror, straight on: all reflections between the two."""
    return reflectance + (1 - reflectance) ** 2 * base / (1 - reflectance * base)


def glass_block(color, reflectance=F0):
    """Two faces straight on; the colour counts at each passage between the surface and the inside."""
    inside = color * (1 - reflectance) / (1 - color ** 2 * reflectance)
    return reflectance + (1 - reflectance) * color * inside


FURNACES = {
    "plastic": F0 + (1 - F0) * COLOR,
    "rough-plastic": F0 + (1 - F0) * COLOR,
    "rougher-plastic": F0 + (1 - F0) * COLOR,
    "roughest-plastic": F0 + (1 - F0) * COLOR,
    "coated-plastic": F0 + (1 - F0) * COLOR,
    "metal": COLOR,
    "coated-metal": over(F0, COLOR),
    "mixed": 0.25 * (COLOR + over(F0, COLOR) + 2 * (F0 + (1 - F0) * COLOR)),
    "glass": glass_block(COLOR),
    "emission": 3 * np.array([0.6, 0.7, 0.9]),
}
# Directives that the text must have, besides its values.
STACKS = {
    "plastic": ['"string stack" [ "Plastic, specular" "Plastic, base" ]'],
    "coated-plastic": ['"string stack" [ "Lacquered \\"wood\\", coat" "Lacquered \\"wood\\", base" ]'],
    "coated-metal": ['"string stack" [ "Car paint, coat" "Car paint, metal" ]'],
    "mixed": ['"string type" "mix"', '"string stack" [ "Half metal, coat" "Half metal, metal.2" ]'],
    "glass": ['"string stack" [ "Bottle, glass" "Bottle, tint" "interface" ]'],
}


def check_materials():
    for name, expected in FURNACES.items():
        status, said = export("material-" + name)
        check(f"material {name}: exports", status == 0 and "0 warnings" in said, said)
        channels, _ = render("material-" + name, "--spp", "1024")
        found = images.rgb(channels)[4:-4, 4:-4].mean(axis=(0, 1))  # away from the world at the edges
        # 64 pixels of 1024 samples: 0.2 %. Rough interfaces lose some light, and reflect a little more than smooth ones.
        tolerance = 0.03 if name.startswith("rough") else 0.01
        check(f"material {name}: closed form", is_near(found, expected, tolerance), (found, expected))
        check(f"material {name}: control: an error is noticed", not is_near(found * (1 + 2.5 * tolerance), expected, tolerance))
        text = text_of("material-" + name)
        for line in STACKS.get(name, []):
            check(f"material {name}: the stack is in the text", line in text, text)


def quarters(name):
    """Mean colours of the four quarters of an image, by rows."""
    status, said = export(name)
    check(f"{name}: exports", status == 0 and "0 warnings" in said, said)
    image = images.rgb(render(name, "--spp", "256")[0])
    n = len(image) // 2
    return np.array([[image[1:n - 1, 1:n - 1].mean(axis=(0, 1)), image[1:n - 1, n + 1:-1].mean(axis=(0, 1))],
                     [image[n + 1:-1, 1:n - 1].mean(axis=(0, 1)), image[n + 1:-1, n + 1:-1].mean(axis=(0, 1))]])


def check_textures():
    grey = ((0.5 + 0.055) / 1.055) ** 2.4  # sRGB
    expected = np.array([[(1, 0, 0), (0, 1, 0)], [(0, 0, 1), (grey, grey, grey)]])
    found = quarters("material-textured")
    # Primaries of reflectance 1 are smooth spectra: within 2 %.
    check("texture: texels are where they are in Blender", is_near(found, expected, 0.02), found)
    check("texture: control: rows exchanged", not is_near(found[::-1], expected, 0.02))
    check("texture: control: columns exchanged", not is_near(found[:, ::-1], expected, 0.02))
    base = ((np.array([[0.3, 0.5], [0.7, 0.85]])[:, :, None] + 0.055) / 1.055) ** 2.4 * np.ones(3)
    for name, expected in (("textured-plastic", F0 + (1 - F0) * base), ("textured-metal", over(F0, base))):
        found = quarters("material-" + name)
        # Stored in 8 bits: half a step of the darkest grey is 1 % of it.
        check(f"{name}: reflectances are computed for each texel", is_near(found, expected, 0.01), (found, expected))
    check_normal_map()
    holes = quarters("material-alpha")
    expected = np.array([[(1, 1, 1), (0, 0, 0)], [(0.498, 0.498, 0.498), (0, 0, 0)]])
    check("alpha: holes are where they are in Blender", is_near(holes, expected, 0.02), holes)


def check_normal_map():
    status, said = export("material-normal-map")
    check("normal map: exports", status == 0 and "0 warnings" in said, said)
    channels, _ = render("material-normal-map", "--spp", "16", "--aov", "normal")
    found = images.vectors(channels, "Ns")[8, 8]
    expected = np.array([0.5 * 0.48, 0.5 * -0.36, 0.8])
    expected /= np.linalg.norm(expected)
    # 8 bits for a component.
    check("normal map: with its strength", np.abs(found - expected).max() < 0.01, (found, expected))
    check("normal map: control: green downward", np.abs(found * [1, -1, 1] - expected).max() > 0.1)


# ---- What cannot be translated ----

WARNINGS = [
    'warning: material "Noisy", node "Noise Texture" (ShaderNodeTexNoise): is not translated; "Base Color" of "Principled BSDF" has its '
    "own value (0.8, 0.8, 0.8) instead",
    'warning: material "Noisy", node "Image Texture" (ShaderNodeTexImage): has no image that can be read; "Roughness" of "Principled '
    'BSDF" has its own value 0.5 instead',
    'warning: material "Noisy", node "Principled BSDF" (ShaderNodeBsdfPrincipled): "Sheen" is not translated; no sheen is taken instead',
    'warning: material "Toon", node "Toon BSDF" (ShaderNodeBsdfToon): is not translated; a diffuse surface of its colour is taken instead',
    'warning: object "Flat": has a scale of 0; it is left out',
    'warning: spot light "Spot": the radius of a spot is not translated; a point is taken instead',
]


def check_messages():
    status, said = export("odd")
    check("odd scene: exports", status == 0, said)
    for warning in WARNINGS:
        check("odd scene: " + warning, said.split("\n").count(warning) == 1, said)
    check("odd scene: the missing image is named", "not-there.png) cannot be read" in said, said)
    channels, _ = render("odd", "--spp", "1")
    check("odd scene: finite", np.isfinite(images.rgb(channels)).all())
    status, said = export("no-camera")
    check("no camera: status 2 and a message", status == 2 and 'scene "Scene" has no camera' in said, (status, said))
    check("no camera: nothing is written", not os.path.exists(path("no-camera", ".pbrt")))
    broken = path("broken", ".blend")
    with open(broken, "w", encoding="utf-8") as file:
        file.write("no scene of Blender")
    out = path("unwritten", ".pbrt")
    for what, arguments, wanted, text, settings in (
            ("no such scene", [path("none", ".blend"), out], 3, "there is no such file", {}),
            ("no scene of Blender", [broken, out], 3, "cannot be read", {}),
            ("no folder", [path("odd", ".blend"), os.path.join(FOLDER, "none", "x.pbrt")], 3, "its folder does not exist", {}),
            ("another ending", [path("odd", ".blend"), path("x", ".obj")], 1, "ends with .pbrt", {}),
            ("an unknown option", ["--fast", path("odd", ".blend"), out], 1, "unknown option --fast", {}),
            ("one file", [out], 1, "usage:", {}),
            ("no Blender", [path("odd", ".blend"), out], 1, "Blender is not installed",
             {"env": {**os.environ, "BLENDER": "/nowhere/blender"}})):
        done = run(EXPORT, *arguments, **settings)
        check(f"{what}: status {wanted} and a message", done.returncode == wanted and text in done.stderr,
              (done.returncode, done.stderr))
        check(f"{what}: nothing is written", not os.path.exists(out))


# ---- The whole: against Cycles, object by object ----

def luminance(image):
    return image @ [0.2126, 0.7152, 0.0722]


def check_show():
    status, said = export("show")
    check("show: exports without warnings", status == 0 and "0 warnings" in said, said)
    text = text_of("show")
    check("show: the pawns are instances", text.count('ObjectInstance "Pawn"') == 7, text.count("ObjectInstance"))
    check("show: paths are relative", FOLDER not in text)
    channels, metadata = render("show", "--spp", "128", "--aov", "object")
    ours, theirs = luminance(images.rgb(channels)), luminance(images.rgb(cycles("show")))
    ids = channels["object.id"].astype(int)
    print("mean luminance by object: Lacquer, Cycles, ratio")
    for object_name, number in json.loads(metadata["objectManifest"]).items():
        seen = ids == number
        if seen.sum() < 150:
            continue
        pair = ours[seen].mean(), theirs[seen].mean()
        print(f"  {object_name:16} {pair[0]:.3f} {pair[1]:.3f} {pair[0] / pair[1]:.2f}")
        # Bases under a surface are lit by what it does not reflect, and tints of glass count at inner reflections too.
        limit = {"Glass_head": 0.35, "Paint": 0.25, "Label": 0.25}.get(object_name, 0.15)
        check(f"show: {object_name} is about as bright as in Cycles", abs(pair[0] / pair[1] - 1) < limit, pair)


def check_hidden_lamp():
    """Lamps that are not seen light a diffuse surface all the same."""
    done = run(EXPORT, "--hide-lamps", path("lamp-area-square", ".blend"), path("lamp-area-square", ".pbrt"))
    check("hidden lamp: exports", done.returncode == 0, done.stderr)
    found = images.rgb(render("lamp-area-square", "--spp", "256")[0]).mean(axis=(0, 1))
    check("hidden lamp: closed form", is_near(found, 0.5 / math.pi * IRRADIANCES["area-square"] * np.ones(3), 0.01), found)


def check_bounces():
    """Cycles' number does not count the first surface, and maxdepth does."""
    ours, theirs = [], []
    for name in ("bounces-0", "bounces-1"):
        status, said = export(name)
        check(f"{name}: exports", status == 0, said)
        ours.append(images.rgb(render(name, "--spp", "256")[0]).mean())
        theirs.append(images.rgb(cycles(name)).mean())
        check(f"{name}: as bright as in Cycles", abs(ours[-1] / theirs[-1] - 1) < 0.02, (ours, theirs))
    check("bounces: control: one more is noticed", ours[1] / ours[0] > 1.1, ours)


def main():
    for name in FACTS:
        if name.startswith("camera-"):
            check_camera(name)
    for name, irradiance in IRRADIANCES.items():
        check_lamp(name, irradiance)
    check_hidden_lamp()
    check_bounces()
    for name in FACTS:
        if name.startswith("environment-"):
            check_environment(name)
        if name.startswith("sky-"):
            check_sky(name)
    check_materials()
    check_textures()
    check_messages()
    check_show()
    print(f"{passed} passed, {failed} failed")
    sys.exit(1 if failed else 0)


main()
