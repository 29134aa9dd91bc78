"""Parts of scripts/figures-bulk: the figures of chapter 4 of Guo's dissertation."""
import math
import os

from bulk_figures import mean_of, read_pfm, read_table, with_table, write_table
from bulk_tables import thinned
from chart_svg import lines as line_chart
from chart_svg import polar, sheet

# ---- Curves: figures 4.3 to 4.5 and 4.7 ----

CHAPTER = [  # figure, what differs, key and its values, averages
    ("4.5 (a)", "volume fraction", "volume fraction", [0.02, 0.05, 0.15], ["aggregate"]),
    ("4.5 (b)", "radius [nm]", "radius", [400, 500, 600], ["aggregate"]),
    ("4.5 (c)", "spheres", "count", [1, 10, 50, 100, 500], ["aggregate", "medium"]),
    ("4.7", "deviation of radii [nm]", "sigma", [0, 50, 100], ["aggregate"]),
]
NM = [600, 700]  # of the chapter's text, and of its captions
MANY = 500  # so many spheres take minutes: few realisations, and at one wavelength


def set_case(particles, key, value, mode):
    (species,) = particles["species"]
    particles["arrangement"].update({"mode": mode, "kind": "cut" if mode == "medium" else "uniform"})
    if key == "count":
        particles["arrangement"]["count"] = value
        if value == 1:
            particles["method"] = "independent"
        if value == MANY:
            particles["wavelengths"] = NM[-1]
    elif key == "sigma":
        species["radius"] = {"normal": {"mean": species["radius"], "sigma": value}} if value else species["radius"]
    else:
        species[key] = value


def single_spheres(lacquer):
    """Figures 4.3 and 4.4: one absorbing sphere, C over the geometric cross section and g."""
    lines = ["| radius | Q_ext | Q_sca | g |", "|" + "---|" * 4]
    for radius in (300, 600, 900):
        def change(particles, radius=radius):
            particles["method"], particles["wavelengths"] = "independent", 600
            particles["species"][0].update({"index": [1.5, 0.1], "radius": radius})

        table = lacquer.table("chapter", change, 0)
        # C over volume, times volume over the geometric cross section [mm].
        length = 4 / 3 * radius * 1e-6 / table["made"]["input"]["species"][0]["volume fraction"]
        lines.append("| %d nm | %.6f | %.6f | %.6f |" % (
            radius, (table["sigma_s"][0] + table["sigma_a"][0]) * length, table["sigma_s"][0] * length, table["g"][0]))
    return lines


def case(lacquer, key, value, mode):
    """Of clusters and of lone spheres: (angles and p at 700 nm, sigma_s over that of lone ones, g and p(0) at each wavelength)."""
    table = lacquer.table("chapter", lambda p: set_case(p, key, value, mode), 5 if (key, value) == ("count", MANY) else 12)

    def alone(particles):
        set_case(particles, key, value, mode)
        particles["method"] = "independent"

    lone, numbers = lacquer.table("chapter", alone, 0), {}
    for i, nm in enumerate(table["wavelengths"]):
        numbers[nm] = (table["sigma_s"][i] / lone["sigma_s"][i], table["g"][i], table["phase"][i][0])
    return list(zip(table["angles"], table["phase"][-1])), numbers


def chapter(lacquer):
    """Phase functions of clusters: charts, and their numbers."""
    lines = single_spheres(lacquer) + [
        "", "| figure | | average | " + " | ".join("σ_s over that of lone spheres, g, p(0) [1/sr] at %d nm" % nm for nm in NM) + " |",
        "|" + "---|" * 5]
    drawings = []
    for figure, title, key, values, modes in CHAPTER:
        series = []
        for mode in modes:
            for value in values:
                if mode == "medium" and value in (1, MANY):
                    continue
                line, numbers = case(lacquer, key, value, mode)
                name = "total" if mode == "aggregate" else "incoherent"
                # At half a degree and less all is as straight on.
                series.append((("-" if mode == "medium" else "") + "%g %s" % (value, name if len(modes) > 1 else ""),
                               [(max(0.5, a), p) for a, p in line if a != 0], values.index(value)))
                cells = ["%.3f, %.3f, %.2f" % numbers[nm] if nm in numbers else "" for nm in NM]
                lines.append("| %s | %s %g | %s | %s |" % (figure, title, value, name, " | ".join(cells)))
        drawings.append(line_chart("Scattering angle [degrees]", "p [1/sr]", series, log_x=True, log_y=True, x_range=(0.5, 180),
                                   y_range=(1e-3, 1e3), title="%s: %s" % (figure, title)))
    sheet(os.path.join(lacquer.out, "chapter.svg"), drawings, columns=2)
    return lines


# ---- Figure 4.8 ----

def rainbow_tables(lacquer):
    def alone(particles):
        particles["method"] = "independent"

    write_table("rainbow-clusters", thinned(lacquer.table("rainbow", lambda particles: None, 6), 1))
    write_table("rainbow-independent", thinned(lacquer.table("rainbow", alone, 0), 1))
    colours_tables(lacquer)


def rainbow(lacquer):
    """Colours of the rings of rainbow.pbrt."""
    image = lacquer.render("rainbow")[1]
    lines = ["| angle | clusters: R, G, B over their mean | lone spheres |", "|" + "---|" * 3]
    for degrees in (6, 8, 10, 12, 17, 26):
        cells = []
        for sign in (-1, 1):  # the upper half of the image has the clusters
            y = 0.5 + sign * 0.5 * math.tan(math.radians(degrees)) / math.tan(math.radians(40))
            rgb = mean_of(image, 0.48, 0.52, y - 0.008, y + 0.008)
            cells.append(", ".join("%.2f" % (3 * c / sum(rgb)) for c in rgb))
        lines.append("| %d° | %s |" % (degrees, " | ".join(cells)))
    return lines


# ---- A solid of these media: figures 4.6, 4.9 and 4.11 ----

COUNTS, RADII = [1, 10, 50, 100], [400, 500, 600]


def counts_tables(lacquer):
    for count in COUNTS:
        for radius in RADII:
            def change(particles, count=count, radius=radius):
                particles["wavelengths"] = NM[-1]
                set_case(particles, "count", count, "aggregate")
                set_case(particles, "radius", radius, "aggregate")

            write_table("counts-%d-%d" % (count, radius), thinned(lacquer.table("chapter", change, 24), 2, 30))


def through_strand(image):
    """Brightness of the lamp of knot.pbrt behind the thin strand, with what the strand adds, over that of the bare lamp."""
    return mean_of(image, 0.6125, 0.6625, 0.5875, 0.6375)[1] / 2


def counts(lacquer):
    """Figure 4.6: how bright knots are, and the lamp behind them."""
    path, images = lacquer.render_grid("knot", "counts", [[with_table("counts-%d-%d" % (n, a), 0.02) for n in COUNTS] for a in RADII])
    lines = [path, "| radius | " + " | ".join("%d: σ_s [1/mm], g, image, lamp" % n for n in COUNTS) + " |", "|" + "---|" * 5]
    for radius, row in zip(RADII, images):
        cells = []
        for count, image in zip(COUNTS, row):
            table = read_table("counts-%d-%d" % (count, radius))
            cells.append("%.1f, %.3f, %.3f, %.2f" % (
                table["sigma_s"][0], table["g"][0], mean_of(image, 0, 1, 0, 1)[1], through_strand(image)))
        lines.append("| %d nm | %s |" % (radius, " | ".join(cells)))
    return lines


MONOCHROME = [450, 550, 650]


def colours_tables(lacquer):
    """One wavelength of rainbow-clusters each."""
    table = read_table("rainbow-clusters")
    for nm in MONOCHROME:
        i = table["wavelengths"].index(nm)
        one = dict(table, wavelengths=[nm], **{key: [table[key][i]] for key in ("sigma_s", "sigma_a", "g", "phase")})
        one["standard_error"] = {key: [value[i]] for key, value in table["standard_error"].items()}
        write_table("rainbow-%d" % nm, one)


def colours(lacquer):
    """Figure 4.9: clusters at all wavelengths, at each of three, and lone spheres at all."""
    names = ["rainbow-clusters"] + ["rainbow-%d" % nm for nm in MONOCHROME] + ["rainbow-independent"]
    path, (images,) = lacquer.render_grid("knot", "colours", [[with_table(name, 0.008) for name in names]])
    lines = [path, "| table | mean of the image: R, G, B |", "|" + "---|" * 2]
    return lines + ["| %s | %.3f, %.3f, %.3f |" % (name, *mean_of(image, 0, 1, 0, 1)) for name, image in zip(names, images)]


def axes(lacquer):
    """Figure 4.11: discs with their axis along x, y and z of the image: to the side, along the view, up."""
    changes = [with_table("disc", 0.012, '"vector3 orientation" [%s]' % axis) for axis in ("1 0 0", "0 1 0", "0 0 1")]
    path, (images,) = lacquer.render_grid("knot", "axes", [changes])
    return [path, "| axis | mean of the image: R, G, B | lamp |", "|" + "---|" * 3] + [
        "| %s | %.3f, %.3f, %.3f | %.2f |" % (axis, *mean_of(image, 0, 1, 0, 1), through_strand(image)) for axis, image in zip("xyz", images)]


# ---- Figure 4.10: slices of the phase function of discs ----

INCIDENCES = [0, 60]


def slice_of(p, angles, azimuths, incidence):
    """p in the plane of the axis and of the incident light: (angle from the axis, to the side of the light's flight; p).
    @param p  rows of the table's image"""
    rows = p[angles.index(incidence) * len(angles):][:len(angles)]
    there = [(a, row[0][0]) for a, row in zip(angles, rows)]
    back = [(-a, row[azimuths - 1][0]) for a, row in zip(angles, rows)]
    return there + back[::-1]


def slices(lacquer):
    """p of discs for light along two directions, beside that of lone spheres."""
    def change(particles):
        particles["wavelengths"] = NM[-1]
        particles["arrangement"].update({"incidences": 31, "azimuths": 61})

    def alone(particles):
        change(particles)
        particles["method"], particles["arrangement"] = "independent", {}

    lone = lacquer.table("disc", alone, 0)
    table = lacquer.table("disc", change, 10)
    image = os.path.join(lacquer.out, "disc.table.pfm")
    lacquer.run("convert", os.path.join(lacquer.out, "disc.table.exr"), image)
    p, drawings = read_pfm(image), []
    lines = ["| light at | σ_s [1/mm] | p straight on, back, to the side [1/sr] |", "|" + "---|" * 3]
    for incidence in INCIDENCES:
        found = slice_of(p, table["angles"], table["azimuths"], incidence)
        sphere = [(a + incidence, q) for a, q in zip(lone["angles"], lone["phase"][0])]
        sphere = sphere[::-1] + [(2 * incidence - a, q) for a, q in sphere]
        drawings.append(polar([("clusters", found), ("-lone spheres", sphere, 2)], 1e-3, 1e2, incidence,
                              title="Light %d° from the axis" % incidence))
        at = dict((a % 360, q) for a, q in found)
        lines.append("| %d° | %.1f | %.2f, %.4f, %.4f |" % (incidence, table["sigma_s"][0][table["angles"].index(incidence)], at[incidence],
                                                         at[incidence + 180], at[incidence + 90]))
    sheet(os.path.join(lacquer.out, "slices.svg"), drawings, columns=2)
    return lines


# ---- Figure 4.12: particles that are correlated, in clusters that are ----

ARRANGEMENTS = {"poisson-disc": {"distance": 1.7}, "uniform": {}, "clumped": {"children": 20, "spread": 2.5}}


def correlated_tables(lacquer):
    for kind in ARRANGEMENTS:
        def change(particles, kind=kind):
            particles["arrangement"].update({"kind": kind, **ARRANGEMENTS[kind]})

        write_table("correlated-" + kind, thinned(lacquer.table("correlated", change, 12), 2, 30))


def evenly(text):
    """The slab's density is 1 everywhere."""
    return text.replace('Include "geometry/clusters.pbrt.gz"', "").replace('"uniformgrid" "point3 p0" [-1.6 -1.6 0] "point3 p1" [1.6 1.6 0.4]',
                                                                           '"homogeneous"')


def correlated(lacquer):
    """Slabs: even and correlated density (rows) of clusters of three arrangements (columns)."""
    changes = [with_table("correlated-" + kind, 0.1) for kind in ARRANGEMENTS]
    path, images = lacquer.render_grid("correlated", "correlated", [[lambda text, c=c: evenly(c(text)) for c in changes], changes])
    lines = [path, "| arrangement | σ_s [1/mm] | g | p(0) [1/sr] | mean of the image, even | correlated density |", "|" + "---|" * 6]
    for kind, *column in zip(ARRANGEMENTS, *images):
        table = read_table("correlated-" + kind)
        lines.append("| %s | %.1f | %.3f | %.1f | %.4f | %.4f |" % (
            kind, table["sigma_s"][0], table["g"][0], table["phase"][0][0], *(mean_of(image, 0, 1, 0, 1)[1] for image in column)))
    return lines


def nothing(lacquer):
    """A part without tables."""


PARTS = {"chapter": (nothing, chapter), "rainbow": (rainbow_tables, rainbow), "counts": (counts_tables, counts),
         "colours": (colours_tables, colours), "axes": (nothing, axes), "slices": (nothing, slices),
         "correlated": (correlated_tables, correlated)}
