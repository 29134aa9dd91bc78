"""What scripts/figures-bulk and scripts/figures-estimation share: the program, tables of `lacquer bulk`, and images."""
import json
import os
import re
import struct
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SCENES = os.path.join(ROOT, "scenes", "bulk")
TABLES = os.path.join(SCENES, "tables")


def program_for(given):
    """The path of the program that was given, or of the one of the release build, which is built first."""
    if given:
        return os.path.abspath(given)
    subprocess.run(["bash", "-c", "source scripts/setup.sh && install_packages && build release lacquer"], cwd=ROOT, check=True)
    return os.path.join(ROOT, "build", "release", "src", "cmd", "lacquer")


def run_program(program, arguments, statuses=(0,), **streams):
    """Runs it, and leaves where it ends with another status. @param streams  of subprocess.run"""
    print("lacquer " + " ".join(arguments), file=sys.stderr, flush=True)
    try:
        done = subprocess.run([program, *arguments], text=True, check=False, **streams)
    except OSError as error:
        sys.exit("%s: %s" % (program, error.strerror))
    if done.returncode not in statuses:
        sys.exit("lacquer %s: status %d\n%s" % (" ".join(arguments), done.returncode, done.stderr or ""))
    return done


class Lacquer:
    """The program, the folder for its images, and the effort."""

    def __init__(self, program, out, tables=False, realisations=1, spp=None):
        self.program, self.out = program, out
        self.tables, self.times, self.spp = tables, realisations, spp
        self.energy_error, self.clusters = 0, 0  # the worst, and of how many realisations, since they were set

    def run(self, *arguments, scene=None):
        """@param scene  text of one, instead of a file's"""
        return run_program(self.program, arguments, cwd=SCENES, stdout=subprocess.PIPE, input=scene).stdout

    def table(self, name, change, realisations):
        """The table of scenes/bulk/particles/NAME.json after `change` of what it says."""
        with open(os.path.join(SCENES, "particles", name + ".json"), encoding="utf-8") as file:
            particles = json.load(file)
        change(particles)
        paths = [os.path.join(self.out, "%s.%s" % (name, end)) for end in ("particles.json", "table.json")]
        with open(paths[0], "w", encoding="utf-8") as file:
            json.dump(particles, file)
        self.run("bulk", paths[0], "--out", paths[1], "--realisations", str(max(2, round(self.times * realisations))), "--quiet")
        with open(paths[1], encoding="utf-8") as file:
            table = json.load(file)
        if "energy_error" in table["made"]:
            self.energy_error = max(self.energy_error, table["made"]["energy_error"])
            directions = 1 if table["isotropic"] else len(table["sigma_s"][0])
            self.clusters += table["made"]["realisations"] * len(table["wavelengths"]) * directions
        return table

    def render(self, scene, *options, text=None, name=None):
        """The image of a scene, or of `text` in place of it: its path and its rows of (R, G, B) from the top."""
        path = os.path.join(self.out, (name or scene) + ".pfm")
        effort = ["--spp", str(self.spp)] if self.spp else []
        self.run("-" if text else scene + ".pbrt", "--quiet", "--outfile", path, *effort, *options, scene=text)
        return path, read_pfm(path)

    def render_grid(self, scene, name, cells):
        """Variants of a scene beside and below each other: the path of the image, and its cells.
        @param cells  rows of functions that change the text of the scene"""
        with open(os.path.join(SCENES, scene + ".pbrt"), encoding="utf-8") as file:
            text = file.read()
        images = [[self.render(scene, text=change(text), name="cell")[1] for change in row] for row in cells]
        path = os.path.join(self.out, name + ".pfm")
        write_pfm(path, beside(images))
        return path, images


def with_table(name, scale, more=""):
    """A change of a scene: the table of its medium, millimetres a unit, and more parameters."""
    def change(text):
        new = '"string bulk" "tables/%s.json" "float scale" [%g] %s' % (name, scale, more)
        text, count = re.subn(r'"string bulk" "tables/[^"]*" "float scale" \[[^]]*\]', new, text)
        if count != 1:
            raise ValueError("the scene has no table and scale, or several")
        return text
    return change


# ---- Tables ----

def write_table(name, table):
    text = json.dumps(table, separators=(", ", ": "))
    with open(os.path.join(TABLES, name + ".json"), "w", encoding="utf-8") as file:
        file.write(text.replace('], [', '],\n  [').replace(', "', ',\n"') + "\n")


def read_table(name):
    with open(os.path.join(TABLES, name + ".json"), encoding="utf-8") as file:
        return json.load(file)


# ---- Images ----

def read_pfm(path):
    """Rows of (R, G, B) from the top; of an image with one channel three times that."""
    with open(path, "rb") as file:
        kind, size, scale = (file.readline().split() for _ in range(3))
        channels = {b"PF": 3, b"Pf": 1}.get(kind[0])
        if not channels:
            sys.exit("%s is no PFM image" % path)
        width, height = map(int, size)
        order = "<" if float(scale[0]) < 0 else ">"
        numbers = struct.unpack("%s%df" % (order, channels * width * height), file.read(4 * channels * width * height))
    repeat = 3 // channels
    rows = [[tuple(repeat * numbers[channels * (y * width + x):channels * (y * width + x + 1)]) for x in range(width)]
            for y in range(height)]
    return rows[::-1]


def write_pfm(path, rows):
    with open(path, "wb") as file:
        file.write(b"PF\n%d %d\n-1\n" % (len(rows[0]), len(rows)))
        for row in reversed(rows):
            file.write(struct.pack("<%df" % (3 * len(row)), *(c for pixel in row for c in pixel)))


def beside(images, gap=4, paper=(1, 1, 1)):
    """One image of rows of images of one size."""
    rows = []
    for line in images:
        if rows:
            rows += [[paper] * len(rows[0])] * gap
        for parts in zip(*line):
            row = list(parts[0])
            for part in parts[1:]:
                row += [paper] * gap + list(part)
            rows.append(row)
    return rows


def mean_of(image, x0, x1, y0, y1):
    """R, G, B of a part of an image, limits as fractions of it."""
    height, width = len(image), len(image[0])
    pixels = [image[y][x] for y in range(round(y0 * height), round(y1 * height)) for x in range(round(x0 * width), round(x1 * width))]
    return [sum(p[c] for p in pixels) / len(pixels) for c in range(3)]


def luminance(rgb):
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
