"""Compares OpenPBR surfaces, as light that is followed through their layers, with the formulas that renderers are told to use, and makes
the charts and the table of docs/openpbr.md.

usage: scripts/figures-openpbr [--samples N] [--out DIR]

The formulas are those of the specification's layers: albedo scaling, f = f_top + (1 - E_top) f_below, with the albedo E of the upper
interface by the direction of the camera; the coat's absorption by the lengths of the two paths within it, its darkening and its roughening
of the base. E of single interfaces is taken from the simulation of just that interface, so that what differs is the layering.
"""
import argparse
import os

import lacquer
import numpy as np

from chart_svg import lines, sheet

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
ANGLES = np.array([0, 10, 20, 30, 40, 50, 60, 70, 75, 80, 85, 88])
BLACK, WHITE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)


def directions(degrees):
    angles = np.radians(degrees)
    return np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=-1)


def albedo(samples, degrees=ANGLES, **parameters):
    """Directional albedo, (angles, 3), by the simulation."""
    return lacquer.material("openpbr", **parameters).albedo(directions(degrees), samples=samples).reflected


def mean_fresnel(eta):
    """Average over the hemisphere of what a smooth boundary reflects of light from above."""
    c = (np.arange(2000) + 0.5) / 2000
    t = np.sqrt(1 - (1 - c * c) / eta ** 2)
    r = ((eta * c - t) / (eta * c + t)) ** 2 / 2 + ((c - eta * t) / (c + eta * t)) ** 2 / 2
    return np.mean(2 * c * r)


class Formulas:
    """The specification's albedos; interfaces by themselves are simulated."""

    def __init__(self, samples):
        self.samples = samples

    def interface(self, degrees, roughness, ior):
        return albedo(self.samples, degrees, base_color=BLACK, specular_roughness=roughness, specular_ior=ior)

    def glossy_diffuse(self, degrees, color, roughness, ior):
        top = self.interface(degrees, roughness, ior)
        return top + (1 - top) * np.array(color)

    def coated(self, degrees, color, roughness, ior, coat_roughness, coat_ior, coat_color):
        """A coat over a glossy diffuse base."""
        coat = self.interface(degrees, coat_roughness, coat_ior)
        rougher = min(1.0, roughness ** 4 + 2 * coat_roughness ** 4) ** 0.25
        # The base is darker because the coat sends part of its light back to it: by the reflectance of the coat's inside.
        inside = 1 - (1 - mean_fresnel(coat_ior)) / coat_ior ** 2
        base = self.glossy_diffuse(degrees, color, rougher, max(ior / coat_ior, coat_ior / ior))
        dark = (1 - inside) / (1 - np.array(color) * inside)
        refracted = np.sqrt(1 - (np.sin(np.radians(degrees)) / coat_ior) ** 2)
        mean_cosine = 2 / 3.0
        mean_refracted = np.sqrt(1 - (1 - mean_cosine ** 2) / coat_ior ** 2)
        passed = np.array(coat_color)[None, :] ** (0.5 / refracted[:, None] + 0.5 / mean_refracted)
        return coat + (1 - coat) * passed * base * dark


def delta_e(a, b):
    return lacquer.delta_e2000(lacquer.lab(a), lacquer.lab(b))


def green(values):
    return values[:, 1]


def curve(values, x=ANGLES):
    return list(zip([float(v) for v in x], [float(v) for v in values]))


class Figures:
    def __init__(self, options):
        self.samples, self.out = options.samples, options.out
        self.formulas = Formulas(options.samples)
        self.rows = []

    def compare(self, name, truth, formula):
        difference = green(formula) - green(truth)
        worst = int(np.argmax(np.abs(difference)))
        colors = delta_e(truth, formula)
        self.rows.append((name, difference[0], difference[worst], ANGLES[worst], colors[0], float(np.max(colors))))
        return truth, formula

    def glossy(self, color, roughness, ior):
        truth = albedo(self.samples, base_color=color, specular_roughness=roughness, specular_ior=ior)
        return self.compare("base %g, roughness %g, index %g" % (color[1], roughness, ior), truth,
                            self.formulas.glossy_diffuse(ANGLES, color, roughness, ior))

    def coat(self, name, color, roughness, coat_roughness, coat_ior, coat_color=WHITE):
        truth = albedo(self.samples, base_color=color, specular_roughness=roughness, coat_weight=1, coat_roughness=coat_roughness,
                       coat_ior=coat_ior, coat_color=coat_color)
        return self.compare(name, truth, self.formulas.coated(ANGLES, color, roughness, 1.5, coat_roughness, coat_ior, coat_color))

    def chart(self, title, cases):
        """cases: (label, (truth, formula))"""
        series = []
        for i, (label, (truth, formula)) in enumerate(cases):
            series += [(label, curve(green(truth)), i), ("-formula", curve(green(formula)), i)]
        return lines("angle [degrees]", "directional albedo", series, y_range=(0, 1), title=title, legend_top=260)

    def make(self):
        grey = (0.8, 0.8, 0.8)
        charts = [
            self.chart("Glossy diffuse, base 0.8, index 1.5: roughness",
                       [("roughness %g" % r, self.glossy(grey, r, 1.5)) for r in (0.1, 0.5, 1)]),
            self.chart("Glossy diffuse, base 0.8, roughness 0.3: index",
                       [("index %g" % n, self.glossy(grey, 0.3, n)) for n in (1.2, 1.5, 2.2)]),
            self.chart("Coat over base 0.8, roughness 0.5: roughness of the coat (index 1.6)",
                       [("coat %g" % r, self.coat("coat of roughness %g over 0.8" % r, grey, 0.5, r, 1.6)) for r in (0, 0.3, 0.7)]),
            self.chart("Coat over base 0.8, roughness 0.5: index of the coat",
                       [("index %g" % n, self.coat("coat of index %g over 0.8" % n, grey, 0.5, 0, n)) for n in (1.3, 1.6, 2)]),
        ]
        red = (0.6, 0.05, 0.02)
        colors = [("clear coat", self.coat("clear coat over red", red, 0.3, 0, 1.6)),
                  ("coat of honey", self.coat("coat of honey over white", (0.9, 0.9, 0.9), 0.3, 0, 1.6, (0.9, 0.55, 0.1))),
                  ("rough coat", self.coat("rough coat over red", red, 0.3, 0.5, 1.6))]
        series = [(label, curve(delta_e(*pair))) for label, pair in colors]
        charts.append(lines("angle [degrees]", "CIEDE2000", series, y_range=(0, 12),
                            title="Coats over colours: formula against simulation", legend_top=60))
        os.makedirs(self.out, exist_ok=True)
        sheet(os.path.join(self.out, "openpbr.svg"), charts, columns=2)
        return self.table()

    def table(self):
        text = "| surface | difference at 0° | largest | at | ΔE2000 at 0° | largest |\n|---|---|---|---|---|---|\n"
        for name, normal, worst, angle, color, most in self.rows:
            text += "| %s | %+.3f | %+.3f | %d° | %.1f | %.1f |\n" % (name, normal, worst, angle, color, most)
        return text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=4096, help="of each albedo")
    parser.add_argument("--out", default=os.path.join(ROOT, "build", "figures-openpbr"))
    options = parser.parse_args()
    print(Figures(options).make(), end="")


if __name__ == "__main__":
    main()
