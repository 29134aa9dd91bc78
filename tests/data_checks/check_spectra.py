#!/usr/bin/python3
"""Checks the measured constants under data/spectra against published figures.

usage: check_spectra.py [directory of the spectra]

Needs numpy. Where colormath can be imported, the observer and the illuminants are also compared with its tables.
Prints one line for each check; the exit status is 1 if a check failed.
"""

import sys
from pathlib import Path

import numpy as np

GRID = np.arange(360.0, 831.0)

# CIE 15:2004: chromaticities of the illuminants under the 2 degree observer.
WHITE = {
    "stdillum-A": (0.44758, 0.40745), "illum-cieD50": (0.34567, 0.35851), "stdillum-D50": (0.33690, 0.35810), "stdillum-D65": (0.31272, 0.32903),
    "illum-acesD60": (0.32168, 0.33767),
    "stdillum-F1": (0.3131, 0.3371), "stdillum-F2": (0.3721, 0.3751), "stdillum-F3": (0.4091, 0.3941),
    "stdillum-F4": (0.4402, 0.4031), "stdillum-F5": (0.3138, 0.3452), "stdillum-F6": (0.3779, 0.3882),
    "stdillum-F7": (0.3129, 0.3292), "stdillum-F8": (0.3458, 0.3586), "stdillum-F9": (0.3741, 0.3727),
    "stdillum-F10": (0.3458, 0.3588), "stdillum-F11": (0.3805, 0.3769), "stdillum-F12": (0.4370, 0.4042),
}
# M1, M2 of the daylight illuminants.
DAYLIGHT = {"illum-cieD50": (-1.039, 0.363), "stdillum-D65": (-0.295, -0.689), "illum-acesD60": (-0.536, -0.519)}
METALS = ("Ag", "Al", "Au", "Cu", "CuZn", "MgO", "TiO2")
# n and k at one tabulated wavelength, from the handbooks.
METAL_ROWS = {"Ag": (495.936707, 0.130, None), "Al": (309.960449, 0.294, None),
              "Au": (495.936707, 0.916, 1.840), "Cu": (495.936707, 1.135, 2.564),
              "CuZn": (550, 0.527, 2.765), "MgO": (589.258972, 1.73737, 0), "TiO2": (499.919006, 3.03, 0)}
GLASSES = {"BK7": 1.51680, "BAF10": 1.67003, "FK51A": 1.48656, "LASF9": 1.85025,
           "F5": 1.67271, "F10": 1.72828, "F11": 1.78472}
# Linear sRGB of smooth copper in a white environment at 0 and 60 degrees: renders by pbrt-v4, Monte Carlo error 0.001.
COPPER = {0: (0.9555, 0.6376, 0.5373), 60: (0.9469, 0.6379, 0.5477)}
COPPER_TOLERANCE = 1e-3
# IEC 61966-2-1 primaries.
SRGB_PRIMARIES = np.array([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]])


class Report:
    """Counts checks and, unless quiet, prints a line for each."""

    def __init__(self, quiet=False):
        self.quiet = quiet
        self.passed = self.failed = self.skipped = 0

    def check(self, ok, what):
        self.passed += bool(ok)
        self.failed += not ok
        if not self.quiet:
            print(("ok    " if ok else "FAIL  ") + what)

    def near(self, what, value, expected, tolerance):
        value, expected = np.atleast_1d(value), np.atleast_1d(expected)
        error = np.abs(value - expected).max()
        self.check(error <= tolerance, f"{what}: {numbers(value)}, expected {numbers(expected)}, "
                                       f"error {error:.2g} <= {tolerance:g}")

    def skip(self, what):
        self.skipped += 1
        print("skip  " + what)

    def finish(self):
        tail = f", {self.skipped} skipped" if self.skipped else ""
        print(f"{self.passed} passed, {self.failed} failed{tail}")
        return 1 if self.failed else 0


def numbers(values):
    return " ".join(f"{v:.9g}" for v in values)


def read_table(path):
    """Rows of numbers; at least one comment line must come first, and wavelengths must rise."""
    lines = path.read_text(encoding="ascii").splitlines()
    if not lines[0].startswith("#") or not any("source" in line for line in lines if line.startswith("#")):
        raise ValueError(f"{path}: no comment lines that name the source")
    table = np.array([[float(field) for field in line.split()] for line in lines if not line.startswith("#")])
    if not (np.diff(table[:, 0]) > 0).all():
        raise ValueError(f"{path}: wavelengths do not rise")
    return table


def read_sellmeier(path):
    rows = [line.split() for line in path.read_text(encoding="ascii").splitlines() if not line.startswith("#")]
    if len(rows) != 1 or rows[0][0] != "sellmeier" or len(rows[0]) != 7:
        raise ValueError(f"{path}: expected one row 'sellmeier B1 B2 B3 C1 C2 C3'")
    return np.array([float(field) for field in rows[0][1:]])


def on_grid(table, column=1):
    """Values at integer nm 360..830: linear in between, constant beyond the ends."""
    return np.interp(GRID, table[:, 0], table[:, column])


def chromaticity(spectrum, observer):
    xyz = spectrum @ observer
    return xyz[:2] / xyz.sum()


def chromaticity_5nm(table, observer):
    """The sum of CIE 15 for fluorescent lamps: 380..780 nm in steps of 5 nm."""
    xyz = table[:, 1] @ observer[20:421:5]
    return xyz[:2] / xyz.sum()


def sellmeier_index(coefficients, nm):
    b, c = coefficients[:3], coefficients[3:]
    square = (nm * 1e-3) ** 2
    return np.sqrt(1 + (b * square / (square - c)).sum())


def conductor_reflectance(eta, k, cos_theta):
    """Unpolarised Fresnel reflectance of a conductor in air."""
    index = eta + 1j * k
    transmitted = np.sqrt(index**2 - (1 - cos_theta**2))
    across = (cos_theta - transmitted) / (cos_theta + transmitted)
    along = (index**2 * cos_theta - transmitted) / (index**2 * cos_theta + transmitted)
    return (np.abs(across) ** 2 + np.abs(along) ** 2) / 2


def reflected_srgb(reflectance, light, observer):
    """Linear sRGB of the reflected light; the light itself is (1, 1, 1)."""
    white = light @ observer / (light @ observer[:, 1])
    xyz = (reflectance * light) @ observer / (light @ observer[:, 1])
    primaries = np.column_stack([SRGB_PRIMARIES, 1 - SRGB_PRIMARIES.sum(axis=1)]).T
    rgb_to_xyz = primaries * np.linalg.solve(primaries, white)
    return np.linalg.solve(rgb_to_xyz, xyz)


def check_observer(report, table):
    y_sum = on_grid(table, 2).sum()
    report.near("observer: sum of y at integer nm", y_sum, 106.856895, 0.01)
    report.check((table[:, 0] == GRID).all(), "observer: every integer nm from 360 to 830")
    report.near("observer: column sums against the CIE data table", table[:, 1:].sum(axis=0),
                (106.865469489595, 106.856917101172, 106.892251278636), 1e-9)
    report.near("observer: y at 555 nm", table[195, 2], 1, 0)


def check_illuminants(report, folder, tables, observer):
    for name, white in WHITE.items():
        fluorescent = name.startswith("stdillum-F")
        report.near(f"{name}: x y at integer nm", chromaticity(on_grid(tables[name]), observer), white,
                    5e-4 if fluorescent else 2e-4)
        if fluorescent:
            report.near(f"{name}: x y as CIE 15 sums it", chromaticity_5nm(tables[name], observer), white, 1e-4)
    components = read_table(folder / "daylight-components.txt")
    for name, (m1, m2) in DAYLIGHT.items():
        daylight = components[:, 1] + m1 * components[:, 2] + m2 * components[:, 3]
        error = np.abs(daylight - tables[name][:, 1]).max()
        report.near(f"{name}: largest distance from the daylight components", error, 0, 1e-3)
    nm = tables["stdillum-A"][:, 0]
    planck = 100 * (560 / nm) ** 5 * np.expm1(1.435e7 / (2848 * 560)) / np.expm1(1.435e7 / (2848 * nm))
    report.near("stdillum-A: largest ratio to the defining equation, less 1",
                np.abs(tables["stdillum-A"][:, 1] / planck - 1).max(), 0, 1e-5)


def check_metals(report, folder, light, observer):
    for name in METALS:
        eta, k = (read_table(folder / f"metal-{name}-{part}.txt") for part in ("eta", "k"))
        report.check((eta[:, 0] == k[:, 0]).all() and eta[0, 0] <= 360 and eta[-1, 0] >= 767,
                     f"metal-{name}: eta and k share {len(eta)} wavelengths, {eta[0, 0]:g}..{eta[-1, 0]:g} nm")
        if name in METAL_ROWS:
            nm, n_there, k_there = METAL_ROWS[name]
            row = np.searchsorted(eta[:, 0], nm)
            report.near(f"metal-{name}: n at {nm:.2f} nm", eta[row, 1], n_there, 1e-9)
            if k_there is not None:
                report.near(f"metal-{name}: k at {nm:.2f} nm", k[row, 1], k_there, 1e-9)
        if name == "Cu":
            check_copper(report, on_grid(eta), on_grid(k), light, observer)


def check_copper(report, eta, k, light, observer):
    for degrees, expected in COPPER.items():
        cos_theta = np.cos(np.radians(degrees))
        rgb = reflected_srgb(conductor_reflectance(eta, k, cos_theta), light, observer)
        report.near(f"metal-Cu: linear sRGB at {degrees} degrees under D65", rgb, expected, COPPER_TOLERANCE)
    wrong = reflected_srgb(conductor_reflectance(eta, k * 1.05, 1), light, observer)
    error = np.abs(wrong - COPPER[0]).max()
    report.check(error > COPPER_TOLERANCE, f"control: copper with k 5 % too large is rejected, error {error:.2g}")


def check_glasses(report, folder):
    for name, n_d in GLASSES.items():
        coefficients = read_sellmeier(folder / f"glass-{name}.txt")
        report.near(f"glass-{name}: n_d", sellmeier_index(coefficients, 587.5618), n_d, 1e-5)
    wrong = read_sellmeier(folder / "glass-BK7.txt")
    wrong[0] *= 1.001
    error = abs(sellmeier_index(wrong, 587.5618) - GLASSES["BK7"])
    report.check(error > 1e-5, f"control: glass-BK7 with B1 0.1 % too large is rejected, error {error:.2g}")


def check_sky(report, folder):
    sun, ozone = read_table(folder / "sun.txt"), read_table(folder / "ozone.txt")
    report.near("sun: irradiance of 360 to 840 nm [W m^-2]", sun[:, 1].sum() * 10, 745.44, 0.01)
    # A black body of the sun's effective temperature has its irradiance within 3 % in this range.
    metres = sun[:, 0] * 1e-9
    planck = 2 * 6.62607e-34 * 2.99792e8**2 / metres**5 / np.expm1(0.0143878 / metres / 5772)
    black_body = np.pi * (6.957e8 / 1.495979e11)**2 * planck.sum() * 1e-8
    report.near("sun over a black body of 5772 K", sun[:, 1].sum() * 10 / black_body, 1, 0.03)
    report.near("ozone: wavelength of the Chappuis band's peak", ozone[ozone[:, 1].argmax(), 0], 605, 0.1)
    report.near("ozone: peak [1e-25 m^2]", ozone[:, 1].max() * 1e25, 5.02, 0.01)


def check_controls(report, observer_table, tables, observer):
    """A wrong table must be noticed: run the same checks on it and expect failures."""
    quiet = Report(quiet=True)
    perturbed = observer_table.copy()
    perturbed[:, 2] *= 1.001
    check_observer(quiet, perturbed)
    report.check(quiet.failed == 3, "control: observer with y 0.1 % too large fails in sum, column sums and peak")
    for name in ("stdillum-D65", "stdillum-F10"):
        tilted = tables[name].copy()
        tilted[:, 1] *= 1 + 1e-4 * (tilted[:, 0] - 560)
        error = np.abs(chromaticity(on_grid(tilted), observer) - WHITE[name]).max()
        report.check(error > 5e-4, f"control: {name} tilted by 1e-4 per nm is rejected, error {error:.2g}")


def check_against_colormath(report, observer_table, tables):
    """colormath: 10 nm tables for 340..830 nm, zero where it has no data; its A and D series are coarse."""
    try:
        from colormath import spectral_constants as other
    except ImportError:
        report.skip("colormath cannot be imported: no cross-check of observer and illuminants")
        return
    nm = np.arange(340, 831, 10)
    theirs = np.column_stack([getattr(other, f"STDOBSERV_{axis}2") for axis in "XYZ"])[2:]
    report.near("observer: largest distance from colormath", np.abs(observer_table[::10, 1:] - theirs).max(), 0, 1e-4)
    for name in ("A", "D50", "D65", "F2", "F7", "F11"):
        theirs = np.asarray(getattr(other, f"REFERENCE_ILLUM_{name}"))
        table = tables["illum-cieD50" if name == "D50" else f"stdillum-{name}"]
        known = (theirs > 0) & (nm >= 380) & (nm <= 780)
        ours = np.interp(nm[known], table[:, 0], table[:, 1])
        tolerance = 1e-9 if name[0] == "F" else 0.15
        error = np.abs(ours - theirs[known]).max()
        report.near(f"stdillum-{name}: largest distance from colormath", error, 0, tolerance)


def main():
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[2] / "data" / "spectra"
    report = Report()
    observer_table = read_table(root / "observer" / "cie1931.txt")
    observer = np.column_stack([on_grid(observer_table, column) for column in (1, 2, 3)])
    tables = {name: read_table(root / "illuminants" / f"{name}.txt") for name in WHITE}
    check_observer(report, observer_table)
    check_illuminants(report, root / "illuminants", tables, observer)
    check_metals(report, root / "metals", on_grid(tables["stdillum-D65"]), observer)
    check_glasses(report, root / "glasses")
    check_sky(report, root / "sky")
    check_controls(report, observer_table, tables, observer)
    check_against_colormath(report, observer_table, tables)
    return report.finish()


if __name__ == "__main__":
    sys.exit(main())
