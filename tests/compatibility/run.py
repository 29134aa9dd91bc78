#!/usr/bin/python3
"""Renders a scene for each oddity of pbrt-v4 that changes images, and checks which way Lacquer takes.

usage: run.py LACQUER [NAME ...] [--jobs N]

NAME   only the cases whose names contain one of these

Each scene is made so that one number tells the two ways apart: pbrt-v4's own, and what a reader of the parameters would
expect. docs/compatibility.md has the choices and their reasons. A case passes if the number is that of the way that is
documented. Where a small change of the scene leads to the other number, the changed scene must give that one: this
control shows that the check would notice. Exit status: 0 all passed; 1 some failed. Needs Debian's python3-openimageio
and python3-numpy. Closing line: 'N passed, N failed'.
"""
import argparse
import concurrent.futures
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass

import numpy as np
import OpenImageIO as oiio

HERE = os.path.dirname(os.path.abspath(__file__))
DOCUMENT = os.path.join(HERE, "..", "..", "docs", "compatibility.md")
SCENE_ERROR = 2                        # exit status
REFUSED = "refused"                    # in place of a number: an error at a line of the scene
RENDERED = "rendered"                  # any image


@dataclass
class Case:
    name: str                          # of the scene, without .pbrt
    choice: str                        # "follows" pbrt-v4, or "differs"
    here: object                       # what Lacquer must give: a number, (left, right), or REFUSED
    other: object                      # where it follows: the expectation without the oddity; else pbrt-v4's
    control: tuple = ()                # (text, replacement), ...: leads from `here` to `other`
    tolerance: float = 0.01            # of the larger of the two; at least four standard deviations of the noise
    measure: str = "luminance"         # or "samples", those that the file says each pixel has


KY = 106.856895                        # the photometric factor, the integral of the observer's y
BLACK_BODY = 94.663                    # the same of a black body at 6500 K with the peak 1, times y
ABSORBED = 1 - np.exp(-1)
ONES = " ".join(["1"] * 8)
DARK = " ".join([f"{1 / KY:.8f}"] * 8)
CASES = [
    Case("directionmix", "follows", 0.8, 0.2, (("[0 0 1]", "[0 1 0]"),)),
    Case("dots", "follows", 0.8, 0.2, (("inside", "?"), ("outside", "inside"), ("?", "outside"))),
    # What pbrt-v4 makes of it is not defined; the other number is that of a reader that lets the shape emit.
    Case("emitter-in-object", "differs", (0, 1), (4, 1),
         (("ObjectBegin \"lamp\"", "AttributeBegin"), ("ObjectEnd", "AttributeEnd"), ("ObjectInstance \"lamp\"", ""))),
    Case("emitter-with-alpha", "follows", 0.25, 0.5, (('"rgb L" [1 1 1]', '"rgb L" [2 2 2]'),), 0.03),
    Case("encoding-of-tga", "follows", 0.2158605, 128 / 255, (("grey128.tga", "grey128.png"),)),
    Case("environment-illuminance", "follows", 0.6467, 1 / np.pi,
         (('illuminance" [1]', 'illuminance" [0.49218]'),)),
    Case("glass-outside-its-table", "follows", 1, 0.75 / 9, (("[360 3 361 3]", "[360 3 830 3]"),), 0.05),
    Case("grid-before-camera", "differs", np.exp(-1.5), 1,
         (('p0" [-1 -1 -1]', 'p0" [-1 -1 -11]'), ('p1" [1 1 1]', 'p1" [1 1 -9]')), 0.02),
    Case("grid-emission-tent", "follows", 0.31022, ABSORBED,
         (('"rgb Le"', f'"float Lescale" [{ONES}] "rgb Le"'),), 0.02),
    Case("image-as-number", "follows", 0.8, 0.4, (('"point"', '"bilinear"'),)),
    Case("image-as-number-far", "follows", 0.8, 0.4, (("[100000]", "[1]"),)),
    Case("image-with-alpha-as-number", "follows", 0.8, 0.2, (('"point"', '"bilinear"'),)),
    Case("instance-in-fog", "differs", np.exp(-1.5), np.exp(-0.5),
         (('Material "conductor"', 'MediumInterface "fog" "" Material "conductor"'),)),
    Case("loopsubdiv-boundary", "differs", 4 / 9, 0.36,
         (("[-1 -1 0  -1 1 0  1 1 0  1 -1 0]", "[-0.9 -0.9 0  -0.9 0.9 0  0.9 0.9 0  0.9 -0.9 0]"),)),
    Case("loopsubdiv-emitter", "follows", (0, 1), (1, 1),
         (("  Shape \"loopsubdiv\"", "ReverseOrientation Shape \"loopsubdiv\""),)),
    Case("mirrored-emitters", "follows", (0, 1), (1, 1),
         (("Translate -1 0 0\n  Scale -1 1 1", "Translate -1 0 0"),)),
    Case("path-shadow-at-interface", "follows", 0, 1, (('"path"', '"volpath"'),)),
    Case("rgbgrid-emission", "follows", KY * ABSORBED, ABSORBED,
         (('Lescale" [1]', f'Lescale" [{1 / KY:.8f}]'),), 0.03),
    Case("scale-of-inverted-image", "follows", 0.8, 0.3, (('"float scale" [0.5]', '"texture scale" "half"'),)),
    Case("shading-normals-decide", "follows", 0.3, 0, (('    "normal N"', "#"),)),
    Case("spectral-film-light-tracing", "differs", REFUSED, RENDERED, (('"spectral"', '"rgb"'),)),
    Case("spectrum-texture-above-one", "differs", 0.25, REFUSED,
         (('"conductor" "texture eta" "index" "texture k" "nothing" "float roughness" [0]',
           '"diffuse" "texture reflectance" "index"'),)),
    Case("temperature-emission", "follows", BLACK_BODY * ABSORBED, BLACK_BODY / KY * ABSORBED,
         (('"float Lescale" [' + ONES, '"float Lescale" [' + DARK),), 0.03),
    # Nothing in a scene makes these two right; 0 is what is left of light if no sample of the removed part counts.
    Case("trimmed-disk-emitter", "follows", 0.5, 0, (), 0.03),
    Case("trimmed-sphere-emitter", "follows", 0.5, 0, (), 0.02),
    Case("zsobol-samples", "follows", 64, 100, (('"zsobol"', '"independent"'),), measure="samples"),
]


def middle(pixels):
    height, width = pixels.shape
    return float(pixels[height // 4:height - height // 4, width // 4:width - width // 4].mean())


def measured(path, case):
    """The number of the image: (left, right) of the middles of its halves where the case has two."""
    image = oiio.ImageBuf(path)
    if image.has_error:
        raise IOError(image.geterror())
    if case.measure == "samples":
        return image.spec().get_int_attribute("samplesPerPixel", -1)
    rgb = np.asarray(image.get_pixels(oiio.FLOAT), dtype=np.float64)[..., :3]
    luminance = rgb @ [0.2126, 0.7152, 0.0722]
    width = luminance.shape[1] // 2
    if isinstance(case.here, tuple):
        return middle(luminance[:, :width]), middle(luminance[:, width:])
    return float(luminance.mean())


def render(lacquer, scene, case, folder, name):
    """What the scene gives: a number, or REFUSED."""
    out = os.path.join(folder, name + ".exr")
    done = subprocess.run([lacquer, scene, "--quiet", "--outfile", out], capture_output=True, text=True, timeout=120)
    if done.returncode == SCENE_ERROR:
        return REFUSED
    if done.returncode != 0:
        raise IOError(f"exit status {done.returncode}: {done.stderr.strip()}")
    return measured(out, case)


def scale(case):
    numbers = [x for x in (case.here, case.other) if not isinstance(x, str)]
    return max(np.max(np.abs(x)) for x in numbers) if numbers else 1


def agrees(value, expected, case):
    if expected == RENDERED:
        return value != REFUSED
    if isinstance(value, str) or isinstance(expected, str):
        return isinstance(value, str) and isinstance(expected, str) and value == expected
    return bool(np.all(np.abs(np.subtract(value, expected)) <= case.tolerance * scale(case)))


def apart(case):
    """Whether no value could agree with both numbers, nor come near to it."""
    if isinstance(case.here, str) or isinstance(case.other, str):
        return case.here != case.other
    return np.max(np.abs(np.subtract(case.here, case.other))) >= 5 * case.tolerance * scale(case)


def changed_scene(case, text):
    for old, new in case.control:
        if old not in text:
            raise ValueError(f"the scene does not hold {old!r}, which the control replaces")
        text = text.replace(old, new)
    # The scene moves to another folder.
    return text.replace('"textures/', f'"{HERE}/textures/')


def judge(lacquer, case, folder):
    """[(passed, line)] of the case and of its control."""
    scene = os.path.join(HERE, case.name + ".pbrt")
    lines = []

    def add(name, value, expected, unexpected):
        passed = apart(case) and agrees(value, expected, case) and not agrees(value, unexpected, case)
        lines.append((passed, f"{name}: {show(value)}, expected {show(expected)} and not {show(unexpected)}"))

    try:
        add(f"{case.name} ({case.choice})", render(lacquer, scene, case, folder, case.name), case.here, case.other)
        if case.control:
            with open(scene) as file:
                text = changed_scene(case, file.read())
            path = os.path.join(folder, case.name + "-control.pbrt")
            with open(path, "w") as file:
                file.write(text)
            value = render(lacquer, path, case, folder, case.name + "-control")
            add(f"{case.name} (control)", value, case.other, case.here)
    except (IOError, ValueError, subprocess.TimeoutExpired) as e:
        lines.append((False, f"{case.name}: {e}"))
    return lines


def show(value):
    if isinstance(value, tuple):
        return "(" + ", ".join(f"{v:.4g}" for v in value) + ")"
    return value if isinstance(value, str) else f"{value:.4g}"


def inventory():
    """Scenes, cases and the rows of the document must be the same."""
    with open(DOCUMENT) as file:
        document = file.read()
    scenes = {name[:-5] for name in os.listdir(HERE) if name.endswith(".pbrt")}
    cases = {case.name for case in CASES}
    return ([(False, f"{name}.pbrt has no case") for name in sorted(scenes - cases)] +
            [(False, f"{name}: no such scene") for name in sorted(cases - scenes)] +
            [(False, f"{name} is not in docs/compatibility.md") for name in sorted(cases)
             if f"`{name}`" not in document])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("lacquer")
    parser.add_argument("names", nargs="*")
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    lacquer = os.path.abspath(args.lacquer)
    cases = [c for c in CASES if not args.names or any(n in c.name for n in args.names)]
    if not cases:
        sys.exit("no case has such a name")
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        results = [line for lines in pool.map(lambda c: judge(lacquer, c, folder), cases) for line in lines]
    results += inventory()
    for passed, line in results:
        print("ok  " if passed else "FAIL", line)
    failed = sum(not passed for passed, _ in results)
    print(f"{len(results) - failed} passed, {failed} failed")
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
