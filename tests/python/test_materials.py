# Materials: known values, agreement of what belongs together, shapes, seeds, threads, and everything that can be wrong.
import os
import signal
import threading

import lacquer
import numpy as np
import pytest

UP = (0, 0, 1)
OBLIQUE_O, OBLIQUE_I = (-0.6, 0, 0.8), (0, 0.6, 0.8)


def ink():
    """Ink that only absorbs, over paper; its value is known."""
    return lacquer.stack([
        "interface",
        lacquer.material("slab", {"spectrum sigma_t": [(360, 0.5), (830, 0.5)]}, eta=1, thickness=1, albedo=(0, 0, 0)),
        lacquer.material("diffuse", reflectance=[(360, 0.6), (830, 0.6)]),
    ])


def ink_value(cos_o, cos_i):
    return 0.6 / np.pi * np.exp(-0.5 * (1 / cos_o + 1 / cos_i))


def varnished():
    return lacquer.stack([
        lacquer.material("dielectric", roughness=0.05),
        lacquer.material("slab", eta=1.5, sigma_t=(1, 1, 1), albedo=(0.5, 0.7, 0.95), phase="hg", g=0.5),
        lacquer.material("conductor", roughness=0.1),
    ])


def directions(n, seed=0, lower=False):
    """Uniform on the upper hemisphere, or on the sphere."""
    w = np.random.default_rng(seed).normal(size=(n, 3))
    w /= np.linalg.norm(w, axis=-1, keepdims=True)
    if not lower:
        w[:, 2] = np.abs(w[:, 2])
    return w


# ---- Known values ----


def test_diffuse_is_exact():
    f = lacquer.material("diffuse", reflectance=0.25).evaluate(OBLIQUE_O, OBLIQUE_I, wavelengths=[400, 550, 700])
    assert f.value == pytest.approx(np.full(3, 0.25 / np.pi), rel=1e-5)
    assert np.all(f.error == 0)
    f = lacquer.material("diffuse", reflectance=0.25).evaluate(OBLIQUE_O, OBLIQUE_I)
    assert f.value == pytest.approx(np.full(3, 0.25 / np.pi), rel=1e-5)


@pytest.mark.parametrize("wavelengths", [None, [450, 470, 490, 510, 530, 550, 570, 590, 610, 650]])
def test_stack_has_its_closed_form(wavelengths):
    """Of one material for four pairs. Within 4.5 standard errors and rounding: less than one failure in 1e4 runs."""
    o = np.array([UP, OBLIQUE_O, OBLIQUE_O, (0.8, 0, 0.6)], dtype=float)
    i = np.array([UP, OBLIQUE_I, UP, (0, 0.8, 0.6)], dtype=float)
    f = ink().evaluate(o, i, samples=4096, wavelengths=wavelengths)
    expected = ink_value(o[:, 2], i[:, 2])[:, None]

    def agrees(expected):
        return np.all(np.abs(f.value - expected) <= 4.5 * f.error + 1e-6)

    assert agrees(expected)
    assert np.all(f.error < 0.01 * expected)
    assert not agrees(1.05 * expected)  # negative control: 5 % would be noticed


def test_estimators_agree():
    o, i = np.broadcast_to(OBLIQUE_O, (8, 3)), directions(8)
    values = [varnished().evaluate(o, i, samples=2048, seed=s, estimator=e)
              for s, e in enumerate(["bidirectional", "pairproduct", "halfvector"])]
    for other in values[1:]:
        sigma = np.hypot(values[0].error, other.error)
        assert np.all(np.abs(values[0].value - other.value) <= 5 * sigma)
        # Negative control: 15 % more is noticed.
        assert np.any(np.abs(values[0].value - 1.15 * other.value) > 5 * sigma)


def test_reciprocity():
    o, i = directions(16, 1), directions(16, 2)
    copper = lacquer.material("conductor", eta="metal-Cu-eta", k="metal-Cu-k", roughness=0.2)
    assert copper.evaluate(o, i).value == pytest.approx(copper.evaluate(i, o).value, rel=1e-4)
    assert copper.type == "conductor" and not copper.is_stochastic and varnished().is_stochastic


def test_modes_differ_by_the_squared_index():
    glass = lacquer.material("dielectric", eta=1.5, roughness=0.3)
    o, i = (0.1, 0, 1), (0, 0.1, -1)
    radiance, importance = (glass.evaluate(o, i, mode=m).value for m in ("radiance", "importance"))
    assert importance == pytest.approx(1.5 ** 2 * radiance, rel=1e-3) and np.all(radiance > 0)


def test_dispersion():
    """Each wavelength refracts by itself, so their order does not matter."""
    glass = lacquer.material("dielectric", eta="glass-BK7", roughness=0.2)
    lambdas = [400, 450, 500, 550, 600, 630, 660, 700, 750, 800]
    o, i = (0.3, 0, 1), (-0.35, 0, -1)
    together = glass.evaluate(o, i, wavelengths=lambdas).value
    alone = [glass.evaluate(o, i, wavelengths=[x]).value[0] for x in lambdas]
    assert together == pytest.approx(alone, rel=1e-6)
    assert len(set(together)) == 10
    with pytest.raises(lacquer.UsageError, match="disperses"):
        glass.sample(o, wavelengths=[400, 500])
    assert glass.sample(o, wavelengths=[400]).weight.shape == (1,)
    paint = lacquer.material("diffuse")
    assert paint.sample(o, wavelengths=lambdas[:8]).weight.shape == (8,)
    with pytest.raises(lacquer.UsageError, match="at most 8 wavelengths"):
        paint.sample(o, wavelengths=lambdas[:9])


def test_albedo_and_furnace():
    paint = lacquer.material("diffuse", reflectance=[(360, 0.4), (830, 0.4)])
    energy = paint.albedo(OBLIQUE_I)
    assert energy.reflected == pytest.approx(np.full(3, 0.4), abs=1e-4)
    assert np.all(energy.transmitted == 0)
    glass = lacquer.material("dielectric", eta=1.5)
    for energy in (glass.albedo(OBLIQUE_I), glass.furnace(OBLIQUE_O)):
        total = energy.reflected + energy.transmitted
        assert total == pytest.approx(np.ones(3), abs=0.02)
        assert np.all(energy.transmitted > 0.5)
    assert paint.albedo(np.zeros((0, 3))).reflected.shape == (0, 3)


def test_albedo_is_the_integral_of_values():
    """Of the ink: 2 pi mean(f cos) over the hemisphere. 1 % is about 4 standard errors of both together."""
    i = directions(20000, 3)
    f = ink().evaluate(i, UP, samples=8).value[:, 1]
    integral = 2 * np.pi * f * i[:, 2]
    sampled = ink().albedo(UP, samples=20000)
    error = np.hypot(integral.std() / np.sqrt(len(i)), sampled.reflected_error[1])
    assert abs(integral.mean() - sampled.reflected[1]) < 4 * error
    assert error < 0.01 * sampled.reflected[1]


# ---- Samples and densities ----


@pytest.mark.parametrize("type, parameters", [("conductor", dict(roughness=0.3)), ("diffuse", dict(reflectance=0.5))])
def test_samples_agree_with_values(type, parameters):
    m = lacquer.material(type, **parameters)
    wo = np.broadcast_to(OBLIQUE_O, (512, 3))
    lambdas = [450, 550, 650]
    s = m.sample(wo, wavelengths=lambdas)
    ok = s.pdf > 0
    assert ok.mean() > 0.7  # some facets send the light down
    f = m.evaluate(wo[ok], s.wi[ok], wavelengths=lambdas).value
    assert s.weight[ok] == pytest.approx(f * np.abs(s.wi[ok][:, 2:]) / s.pdf[ok, None], rel=1e-3)
    assert m.pdf(wo[ok], s.wi[ok]).value == pytest.approx(s.pdf[ok], rel=1e-3)
    assert np.linalg.norm(s.wi[ok], axis=-1) == pytest.approx(1, abs=1e-5)
    assert np.all(s.wi[~ok] == 0) and np.all(s.weight[~ok] == 0)


def test_density_integrates_to_the_draws_that_succeed():
    """Both by counting: the standard error of the difference is about 0.005."""
    metal = lacquer.material("conductor", roughness=0.3)
    density = metal.pdf(UP, directions(200000, 4))
    succeeded = np.mean(metal.sample(np.broadcast_to(UP, (20000, 3))).pdf > 0)
    integral = 2 * np.pi * density.value.mean()
    assert integral == pytest.approx(succeeded, abs=0.025)
    assert 1.05 * integral != pytest.approx(succeeded, abs=0.025)  # negative control
    assert np.all(density.error == 0)
    assert np.all(varnished().pdf(UP, directions(4), samples=16, layered_pdf="unbiased").error > 0)


def test_lobes():
    mirror = lacquer.material("conductor").sample(OBLIQUE_O)
    assert lacquer.Lobes(int(mirror.lobe)) == lacquer.Lobes.SPECULAR | lacquer.Lobes.REFLECTION
    assert mirror.wi == pytest.approx((0.6, 0, 0.8), abs=1e-6)


# ---- Shapes, seeds, threads ----


@pytest.mark.parametrize("o, i, shape", [
    ((3,), (3,), ()), ((5, 3), (3,), (5,)), ((3,), (5, 3), (5,)), ((5, 1, 3), (4, 3), (5, 4)), ((0, 3), (3,), (0,)),
    ((2, 0, 3), (1, 3), (2, 0)), ((1, 1, 1, 3), (3,), (1, 1, 1)),
])
@pytest.mark.parametrize("wavelengths", [None, [500], [400, 430, 450, 470, 500, 530, 550, 570, 600]])
def test_shapes(o, i, shape, wavelengths):
    m = lacquer.material("diffuse")
    f = m.evaluate(np.ones(o), np.ones(i), wavelengths=wavelengths)
    assert f.value.shape == f.error.shape == shape + (3 if wavelengths is None else len(wavelengths),)
    assert m.pdf(np.ones(o), np.ones(i)).value.shape == shape
    s = m.sample(np.ones(o))
    assert s.wi.shape == s.weight.shape == o and s.pdf.shape == s.lobe.shape == o[:-1]
    assert m.albedo(np.ones(o), samples=1).reflected.shape == o


def test_kinds_of_arrays():
    m = lacquer.material("conductor", roughness=0.3)
    expected = m.evaluate(OBLIQUE_O, OBLIQUE_I).value
    for o in ([-3, 0, 4], np.array([-6, 0, 8], dtype=np.int16), np.array([-0.6, 0, 0.8], dtype=np.float16),
              np.float32([-0.6, 9, 0, 9, 0.8])[::2], np.array([-6e200, 0, 8e200]), np.array([-6e-300, 0, 8e-300])):
        assert m.evaluate(o, OBLIQUE_I).value == pytest.approx(expected, rel=2e-2)
    many = np.asfortranarray(np.broadcast_to(OBLIQUE_O, (7, 3)))
    assert m.evaluate(many, OBLIQUE_I).value == pytest.approx(np.broadcast_to(expected, (7, 3)), rel=1e-6)


def test_seeds():
    m = varnished()
    a, b, c = (m.evaluate(OBLIQUE_O, directions(9), samples=4, seed=s).value for s in (1, 1, 2))
    assert np.array_equal(a, b) and not np.array_equal(a, c)
    a, b, c = (m.sample(directions(9), seed=s).wi for s in (1, 1, 2))
    assert np.array_equal(a, b) and not np.array_equal(a, c)
    a, b, c = (m.albedo(UP, samples=64, seed=s).reflected for s in (1, 1, 2))
    assert np.array_equal(a, b) and not np.array_equal(a, c)


def test_errors_are_standard_errors():
    """Of 400 independent means, by their own scatter: the ratio has a standard deviation of 4 %."""
    m = varnished()
    f = m.evaluate(np.broadcast_to(OBLIQUE_O, (400, 3)), OBLIQUE_I, samples=64)
    ratio = f.value[:, 1].std() / np.sqrt(np.mean(f.error[:, 1] ** 2))
    assert 0.8 < ratio < 1.25
    assert np.all(np.isnan(m.evaluate(OBLIQUE_O, OBLIQUE_I, samples=1).error))


def test_threads_evaluate_at_once():
    m = varnished()
    o = directions(64)
    expected = {e: m.evaluate(o, UP, samples=8, estimator=e).value for e in ("bidirectional", "forward")}
    fresh, results = varnished(), {}

    def run(key, estimator):
        results[key] = fresh.evaluate(o, UP, samples=8, estimator=estimator).value

    threads = [threading.Thread(target=run, args=((k, e), e)) for k in range(3) for e in expected]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 6
    assert all(np.array_equal(value, expected[estimator]) for (_, estimator), value in results.items())


def test_evaluates_while_a_scene_renders():
    m, o = varnished(), directions(300)
    expected = m.evaluate(o, UP, samples=8).value
    scene = lacquer.parse('Film "rgb" "integer xresolution" 64 "integer yresolution" 64\nCamera "perspective"\nWorldBegin\n'
                          'LightSource "infinite"\nTranslate 0 0 3 Shape "sphere"\n')
    image, ended, images = scene.render(spp=4).image, threading.Event(), []

    def render():
        while not ended.is_set():
            images.append(scene.render(spp=4).image)

    thread = threading.Thread(target=render)
    thread.start()
    values = [m.evaluate(o, UP, samples=8).value for _ in range(10)]
    ended.set()
    thread.join()
    assert all(np.array_equal(v, expected) for v in values)
    assert images and all(np.array_equal(i, image) for i in images)


@pytest.mark.parametrize("wavelengths", [None, [500]])
def test_interrupt(wavelengths):
    m = varnished()
    for call in (lambda n: m.evaluate(UP, OBLIQUE_I, samples=n, wavelengths=wavelengths), lambda n: m.albedo(UP, samples=n),
                 lambda n: m.pdf(UP, OBLIQUE_I, samples=n, layered_pdf="unbiased")):
        timer = threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT))
        call(1)
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            call(1 << 40)


# ---- Making them ----


def test_text_renders_as_the_scene_does():
    head = 'Film "rgb" "integer xresolution" 8 "integer yresolution" 8\nCamera "perspective"\nWorldBegin\n'
    body = '\nLightSource "infinite"\nNamedMaterial "x"\nTranslate 0 0 3 Shape "sphere"\n'
    image = lacquer.parse(head + varnished().text("x") + body).render(spp=16).image
    assert image.shape == (8, 8, 3) and image.min() > 0
    scene = lacquer.parse(head + varnished().text("x") + body)
    assert np.array_equal(scene.material("x").evaluate(OBLIQUE_O, OBLIQUE_I).value,
                          varnished().evaluate(OBLIQUE_O, OBLIQUE_I).value)


def test_stacks_in_stacks_and_mixes():
    inner = lacquer.stack([lacquer.material("dielectric", roughness=0.1), lacquer.material("diffuse")])
    outer = lacquer.stack([lacquer.material("dielectric", roughness=0.2), inner])
    assert np.all(outer.evaluate(OBLIQUE_O, OBLIQUE_I, samples=64).value > 0)
    mix = lacquer.material("mix", amount=0.5, materials=[lacquer.material("diffuse", reflectance=0.2),
                                                         lacquer.material("diffuse", reflectance=0.6)])
    f = mix.evaluate(OBLIQUE_O, OBLIQUE_I, samples=64, wavelengths=[500, 600])
    assert f.value == pytest.approx(np.full(2, 0.4 / np.pi), rel=0.25) and np.all(f.error > 0)


def test_names_with_dots_and_types():
    a = lacquer.material("coatedconductor", interface__roughness=0.3)
    b = lacquer.material("coatedconductor", {"float interface.roughness": 0.3})
    assert a.text() == b.text()
    assert lacquer.material("coateddiffuse", maxdepth=7, remaproughness=False).text().count("integer maxdepth") == 1


# ---- What is wrong ----


@pytest.mark.parametrize("o", [
    (float("nan"), 0, 1), (float("inf"), 0, 1), (0, 0, 0), (0, 1), (1, 2, 3, 4), 5, None, "up", ("a", "b", "c"),
    [[0, 0, 1], [0, 1]], np.zeros((3, 2)), np.ones((3, 3), dtype=complex), np.ones(3, dtype=bool), [[None, 0, 1]],
    np.array([b"x", b"y", b"z"]), object(), {}, np.zeros((4, 0)), (1 << 2000, 0, 1), [[0, 0, 1], [0, 0, 0]],
])
def test_wrong_directions(o):
    m = lacquer.material("diffuse")
    for call in (lambda: m.evaluate(o, UP), lambda: m.evaluate(UP, o), lambda: m.pdf(o, UP), lambda: m.pdf(UP, o),
                 lambda: m.sample(o), lambda: m.albedo(o), lambda: m.furnace(o)):
        with pytest.raises(lacquer.UsageError, match="w[oi]"):
            call()


def test_the_bad_direction_is_named():
    w = np.ones((4, 5, 3))
    w[2, 3, 1] = np.nan
    with pytest.raises(lacquer.UsageError, match=r"wo\[2, 3\]"):
        lacquer.material("diffuse").evaluate(w, UP)
    with pytest.raises(lacquer.UsageError, match=r"\(4, 3\) and \(5, 3\) do not fit"):
        lacquer.material("diffuse").evaluate(np.ones((4, 3)), np.ones((5, 3)))


@pytest.mark.parametrize("parameters, text", [
    (dict(samples=0), "from 1"), (dict(samples=1.5), "integer"), (dict(samples="x"), "integer"),
    (dict(samples=1 << 70), "from 1"), (dict(seed=-1), "from 0"), (dict(seed=1 << 64), "from 0"),
    (dict(estimator="bidirectionl"), 'did you mean "bidirectional"'), (dict(estimator=3), "unknown"),
    (dict(layered_pdf="gausian"), 'did you mean "gaussian"'), (dict(mode="light"), "radiance"),
    (dict(wavelengths=[]), "at least one"), (dict(wavelengths=500), "one axis"), (dict(wavelengths=[300]), "360 to 830"),
    (dict(wavelengths=[float("nan")]), "360 to 830"), (dict(wavelengths=["green"]), "nanometres"),
    (dict(wavelengths=[[500]]), "one axis"),
])
def test_wrong_arguments(parameters, text):
    with pytest.raises(lacquer.UsageError) as caught:
        varnished().evaluate(UP, UP, **parameters)
    assert text in str(caught.value)


def test_estimators_are_for_stacks():
    with pytest.raises(lacquer.UsageError, match="whose value is exact"):
        lacquer.material("diffuse").evaluate(UP, UP, estimator="forward")


@pytest.mark.parametrize("make, text", [
    (lambda: lacquer.material("difuse"), 'did you mean "diffuse"'),
    (lambda: lacquer.material(3), "unknown"),
    (lambda: lacquer.material("diffuse", reflectanc=0.5), 'did you mean "reflectance"'),
    (lambda: lacquer.material("diffuse", reflectance=(2, 0, 0)), "reflectance"),
    (lambda: lacquer.material("diffuse", reflectance=float("nan")), "finite"),
    (lambda: lacquer.material("diffuse", reflectance=None), "reflectance"),
    (lambda: lacquer.material("diffuse", reflectance=[]), "reflectance"),
    (lambda: lacquer.material("diffuse", reflectance='x" "y'), "quotes"),
    (lambda: lacquer.material("diffuse", {"rgb reflectance": (1, 2)}), "reflectance"),
    (lambda: lacquer.material("diffuse", {3: 1}), "text"),
    (lambda: lacquer.material("diffuse", {'x" "float y': 1}), "quotes"),
    (lambda: lacquer.material("coateddiffuse", maxdepth=1.5), "integer"),
    (lambda: lacquer.material("conductor", eta="metal-Xx-eta", k="metal-Cu-k"), "metal-Xx-eta"),
    (lambda: lacquer.material("diffuse", normalmap="nowhere.png"), "nowhere.png"),
    (lambda: lacquer.stack([]), "at least one"),
    (lambda: lacquer.stack(3), "list"),
    (lambda: lacquer.stack("interface"), "list"),
    (lambda: lacquer.stack([3]), r"layers[0]"),
    (lambda: lacquer.stack(["diffuse"]), r"layers[0]"),
    (lambda: lacquer.stack([lacquer.material("slab")]), "slab"),
    (lambda: lacquer.stack([lacquer.material("diffuse"), lacquer.material("diffuse")]), "lets no light through"),
    (lambda: lacquer.stack([lacquer.material("dielectric"), lacquer.material("slab", sigma=1),
                            lacquer.material("diffuse")]), "sigma"),
    (lambda: lacquer.stack([lacquer.material("diffuse")], estimator="x"), "x"),
    (lambda: lacquer.Material(), "lacquer.material()"),
])
def test_wrong_materials(make, text):
    with pytest.raises(lacquer.Error) as caught:
        make()
    assert text in str(caught.value)


def test_what_scatters_nothing_by_itself():
    for type in ("slab", "interface"):
        with pytest.raises(lacquer.SceneError):
            lacquer.material(type).evaluate(UP, UP)


def test_materials_of_scenes_are_no_layers():
    scene = lacquer.parse('WorldBegin\nMakeNamedMaterial "a" "string type" "diffuse"\n')
    with pytest.raises(lacquer.UsageError, match="taken from a scene"):
        lacquer.stack([scene.material("a")])
    with pytest.raises(lacquer.UsageError, match="text()"):
        scene.material("a").text()
