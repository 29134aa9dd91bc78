# Scenes: the same bits as the command line, parameters, progress, cancellation, threads, errors with places.
import os
import signal
import subprocess
import threading
import time
import warnings

import lacquer
import numpy as np
import pytest

BALL = """
LookAt 0 0 4  0 0 0  0 1 0
Camera "perspective" "float fov" 40
Film "rgb" "integer xresolution" 24 "integer yresolution" 16 "string filename" "ball.exr"
Sampler "zsobol" "integer pixelsamples" 4
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
MakeNamedMaterial "paint" "string type" "coateddiffuse" "rgb reflectance" [.5 .2 .1] "float roughness" 0.1
NamedMaterial "paint"
Shape "sphere"
"""
# Renders until someone stops it.
ENDLESS = dict(spp=1 << 20, resolution=(256, 256))


def ball():
    return lacquer.parse(BALL)


def bits(array):
    return np.ascontiguousarray(array).view(np.uint32)


def rendered_by_program(program, scene, folder, *options):
    path = os.path.join(folder, "program.exr")
    subprocess.run([program, scene, "--quiet", "--outfile", path, *options], check=True)
    return lacquer.read_image(path)


@pytest.mark.parametrize("scene", ["first-light.pbrt", "campfire.pbrt", "between-facets.pbrt"])
def test_bits_are_those_of_the_command_line(program, scenes, tmp_path, scene):
    path = os.path.join(scenes, scene)
    expected = rendered_by_program(program, path, tmp_path, "--spp", "4", "--resolution", "60x40", "--seed", "5",
                                   "--aov", "albedo,normal")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for nthreads in (1, 2):
            result = lacquer.load(path).render(spp=4, resolution=(60, 40), seed=5, aov=["albedo", "normal"],
                                               nthreads=nthreads)
            assert sorted(result.names) == sorted(expected.channels)
            for name in expected.channels:
                assert np.array_equal(bits(result.channels[name]), bits(expected[name])), name
        # Negative control: another seed is another image.
        other = lacquer.load(path).render(spp=4, resolution=(60, 40), seed=6)
    assert not np.array_equal(other.channels["R"], expected["R"])
    assert result.metadata["samplesPerPixel"] == expected.metadata["samplesPerPixel"] == 4
    assert np.array_equal(result.metadata["worldToCamera"], expected.metadata["worldToCamera"])


def test_written_file_is_that_of_the_command_line(program, tmp_path):
    scene = tmp_path / "ball.pbrt"
    scene.write_text(BALL)
    expected = rendered_by_program(program, scene, tmp_path)
    result = lacquer.load(scene).render()
    result.write(tmp_path / "module.exr")
    read = lacquer.read_image(tmp_path / "module.exr")
    assert read.channels == expected.channels
    assert np.array_equal(bits(read.pixels), bits(expected.pixels))
    differing = {k for k in expected.metadata if str(expected.metadata[k]) != str(read.metadata.get(k))}
    assert differing <= {"renderTimeSeconds"}


def test_result():
    result = ball().render()
    assert result.image.shape == (16, 24, 3) and result.image.dtype == np.float32
    assert set(result.channels) == {"R", "G", "B"} and result.channels["G"].shape == (16, 24)
    assert np.array_equal(result.image[..., 1], result.channels["G"])
    assert result.complete and result.warnings == []
    assert result.statistics["samples_per_pixel"] == 4 and result.statistics["rays"]["camera"] == 4 * 24 * 16
    assert result.image[0, 0] == pytest.approx([1, 1, 1], abs=0.8)  # four samples of the lamp's wavelengths


@pytest.mark.parametrize("parameters, shape", [
    (dict(resolution=(10, 7)), (7, 10)),
    (dict(quick=True), (4, 6)),
    (dict(pixel=(3, 2)), (1, 1)),
    (dict(pixelbounds=(2, 10, 3, 5)), (2, 8)),
    (dict(cropwindow=(0, 0.5, 0, 1)), (16, 12)),
    (dict(resolution=np.array([5, 6])), (6, 5)),
])
def test_part_of_the_image(parameters, shape):
    assert ball().render(spp=1, **parameters).image.shape == shape + (3,)


def test_part_is_a_part():
    whole, part = ball().render(), ball().render(pixelbounds=(2, 10, 3, 5))
    assert np.array_equal(whole.image[3:5, 2:10], part.image)


def test_sample_ranges_add_up():
    whole = ball().render(spp=4).image
    halves = [ball().render(spp=4, sample_range=r).image for r in [(0, 2), (2, 4)]]
    assert np.mean(halves, axis=0) == pytest.approx(whole, rel=1e-4)


def test_options_of_scenes():
    assert np.any(ball().render(disable_pixel_jitter=True).image != ball().render().image)
    assert np.any(ball().render(force_diffuse=True).image != ball().render().image)


def test_set():
    scene = ball()
    before = scene.render().image
    changed = scene.copy()
    changed.set("paint.rgb reflectance", (0.5, 0.2, 0.9))
    assert changed.render().image[8, 12, 2] > 2 * before[8, 12, 2]
    assert np.array_equal(scene.render().image, before)
    changed.set("paint.rgb reflectance", [0.5, 0.2, 0.1])
    assert np.array_equal(changed.render().image, before)
    changed.set("paint.bool remaproughness", False)
    assert np.any(changed.render().image != before)


def test_set_of_other_parts():
    scene = ball()
    assert scene.parts == {"camera": "perspective", "film": "rgb", "filter": "gaussian", "sampler": "zsobol",
                           "integrator": "volpath", "accelerator": "bvh", "light@1": "infinite", "shape@1": "sphere"}
    scene.set("film.xresolution", 30)
    scene.set("sampler.pixelsamples", 2)
    result = scene.render()
    assert result.image.shape == (16, 30, 3) and result.statistics["samples_per_pixel"] == 2
    # Parameters of render() win.
    assert scene.render(spp=1, resolution=(5, 4)).image.shape == (4, 5, 3)


def test_set_has_the_bits_of_the_text():
    for target, value, old, new in [
            ("camera.fov", 30, '"float fov" 40', '"float fov" 30'),
            ("light@1.rgb L", (2, 0.5, 1), '"rgb L" [1 1 1]', '"rgb L" [2 .5 1]'),
            ("light@1.scale", 3, '"rgb L" [1 1 1]', '"rgb L" [1 1 1] "float scale" 3'),
            ("shape@1.radius", 0.5, 'Shape "sphere"', 'Shape "sphere" "float radius" 0.5'),
            ("integrator.maxdepth", 0, "WorldBegin", 'Integrator "volpath" "integer maxdepth" 0 WorldBegin')]:
        scene = ball()
        scene.set(target, value)
        image = scene.render().image
        assert np.array_equal(bits(image), bits(lacquer.parse(BALL.replace(old, new)).render().image)), target
        assert np.any(image != ball().render().image), target


def test_a_material_keeps_its_name():
    scene = lacquer.parse(BALL.replace('"paint"', '"camera"'))
    scene.set("camera.rgb reflectance", (0.1, 0.1, 0.9))
    assert np.any(scene.render().image != ball().render().image)


@pytest.mark.parametrize("target, value, words", [
    ("camrea.fov", 30, ['"camrea"', '"camera"?', "paint", "light@1"]),
    ("light@2.scale", 1, ['"light@2"', "light@1"]),
    ("shape.radius", 1, ['"shape"', "shape@1"]),
    ("camera.fov", "wide", ['"wide"', "a number"]),
    ("camera.flot fov", 30, ['"flot"', '"float"?']),
    ("paint", 30, ['"paint" names no parameter', "paint.PARAMETER"]),
])
def test_set_says_what_is_wrong(target, value, words):
    with pytest.raises(lacquer.UsageError) as error:
        ball().set(target, value)
    for word in words:
        assert word in str(error.value), error.value


def test_a_part_that_does_not_know_its_parameter():
    scene = ball()
    scene.set("camera.fovv", 30.0)
    with pytest.raises(lacquer.SceneError, match='"float fovv"; did you mean "fov"'):
        scene.render()


def test_denoised_bits_are_those_of_the_command_line(program, tmp_path):
    scene = tmp_path / "ball.pbrt"
    scene.write_text(BALL.replace("zsobol", "independent"))
    expected = rendered_by_program(program, scene, tmp_path, "--spp", "8", "--denoise")
    result = lacquer.load(scene).render(spp=8, denoise=True)
    assert result.names == ["R", "G", "B"]
    assert np.array_equal(bits(result.image), bits(expected.pixels))
    # In two steps, and from a file.
    noisy = lacquer.load(scene).render(spp=8, aov=["half", "variance", "albedo", "normal", "depth"])
    noisy.write(tmp_path / "noisy.exr")
    assert np.array_equal(bits(noisy.denoise().image), bits(expected.pixels))
    states = []
    image = lacquer.denoise(lacquer.read_image(tmp_path / "noisy.exr"), progress=states.append)
    assert np.array_equal(bits(image.pixels[..., :3]), bits(expected.pixels))
    assert "Albedo.R" in image.channels and not any(name.startswith("Half.") for name in image.channels)
    assert states[-1].stage == "denoising" and states[-1].fraction == 1
    # Negative control: before, it was another image, and it stays so.
    assert not np.array_equal(noisy.image, expected.pixels)


def test_denoised_image_is_nearer_to_the_truth():
    scene = lacquer.parse(BALL.replace("zsobol", "independent"))
    truth = scene.render(spp=1024, seed=9).image
    errors = [np.sqrt(np.mean((scene.render(spp=8, denoise=d).image - truth) ** 2)) for d in (False, True)]
    assert errors[1] < 0.9 * errors[0], errors  # 0.70 to 0.81 by four seeds


def test_a_stopped_render_keeps_what_the_denoiser_needs():
    with pytest.warns(lacquer.SceneWarning, match="not denoised, since the render was stopped"):
        result = ball().render(spp=1 << 20, resolution=(64, 64), denoise=True, progress=lambda p: p.done < 200000)
    assert "Half.R" in result.channels and not result.complete
    if result.channels["samples"].min() >= 2:
        assert result.denoise().image.shape == (64, 64, 3)


def test_what_cannot_be_denoised():
    with pytest.raises(lacquer.UsageError, match="one sample in each pixel"):
        ball().render(spp=1, denoise=True)
    with pytest.raises(lacquer.UsageError, match="traced from the lights"):
        lacquer.parse(BALL.replace("WorldBegin", 'Integrator "bdpt" WorldBegin')).render(denoise=True)
    with pytest.raises(lacquer.UsageError, match="Half.R"):
        ball().render().denoise()
    with pytest.raises(lacquer.UsageError, match='unknown .nfr.; did you mean "nfor"'):
        ball().render(denoise=True, denoiser="nfr")
    with pytest.raises(lacquer.UsageError, match="expected a lacquer.Image"):
        lacquer.denoise(np.zeros((4, 4, 3)))
    with pytest.raises(lacquer.UsageError, match="expected True or False"):
        ball().render(denoise="nfor")


def test_a_denoiser_that_was_not_built_in():
    reasons = dict(lacquer._lacquer.denoisers())
    assert reasons["nfor"] == ""
    if not reasons["oidn"]:
        pytest.skip("Open Image Denoise is built in")
    with pytest.raises(lacquer.UsageError, match="Intel Open Image Denoise was not found when Lacquer was built"):
        ball().render(denoise=True, denoiser="oidn")


def test_materials_of_a_scene():
    assert ball().materials == {"paint": "coateddiffuse"}


def test_progress():
    states = []
    ball().render(spp=64, progress=states.append)
    assert states[-1].stage == "Rendering" and states[-1].fraction == 1
    fractions = [s.fraction for s in states if s.stage == "Rendering"]
    assert fractions == sorted(fractions)


def test_callback_is_called_on_the_calling_thread():
    threads = set()
    ball().render(progress=lambda _: threads.add(threading.get_ident()))
    assert threads == {threading.get_ident()}


def test_cancelled_by_the_callback():
    result = ball().render(**ENDLESS, progress=lambda p: p.done < 1000)
    assert not result.complete and not result.statistics["complete"]
    assert result.image.shape == (256, 256, 3) and np.isfinite(result.image).all()
    assert "samples" in result.channels and result.channels["samples"].max() >= 1


def test_none_does_not_cancel():
    assert ball().render(progress=lambda _: None).complete


def test_callback_that_raises():
    def fail(_):
        raise KeyError("from the callback")

    with pytest.raises(KeyError, match="from the callback"):
        ball().render(**ENDLESS, progress=fail)
    assert ball().render().complete  # the next one renders


def test_callback_cannot_render():
    with pytest.raises(lacquer.UsageError, match="progress callback cannot render"):
        ball().render(**ENDLESS, progress=lambda _: ball().render())


def test_interrupt():
    timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        ball().render(**ENDLESS)
    assert time.monotonic() - began < 10
    assert ball().render().complete


def test_other_threads_run_meanwhile():
    counts = [0]
    stop = threading.Event()

    def count():
        while not stop.is_set():
            counts[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    ball().render(**ENDLESS, time_limit=1)
    stop.set()
    thread.join()
    assert counts[0] > 50  # of about 900: with the lock held it would be a handful


def test_threads_that_render_at_once():
    expected = ball().render().image
    images = [None] * 6

    def render(i):
        images[i] = ball().render(nthreads=1 + i % 3).image

    threads = [threading.Thread(target=render, args=(i,)) for i in range(len(images))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(image, expected) for image in images)


def test_time_limit():
    result = ball().render(spp=1 << 20, time_limit=0.5)
    assert not result.complete and 0.2 < result.statistics["seconds"]["render"] < 2


def test_relative_paths(tmp_path):
    (tmp_path / "part.pbrt").write_text('Shape "sphere"\n')
    text = BALL.replace('Shape "sphere"', 'Include "part.pbrt"')
    assert lacquer.parse(text, folder=tmp_path).render(spp=1).complete
    with pytest.raises(lacquer.Error, match="part.pbrt"):
        lacquer.parse(text, folder=tmp_path / "elsewhere")


def test_several_files(tmp_path):
    (tmp_path / "a.pbrt").write_text(BALL.split("WorldBegin")[0])
    (tmp_path / "b.pbrt").write_text("WorldBegin" + BALL.split("WorldBegin")[1])
    several = lacquer.load([tmp_path / "a.pbrt", str(tmp_path / "b.pbrt")]).render().image
    assert np.array_equal(several, ball().render().image)


def test_warnings_are_told():
    scene = lacquer.parse(BALL.replace('LightSource "infinite" "rgb L" [1 1 1]', ""))
    with pytest.warns(lacquer.SceneWarning, match="no light"):
        result = scene.render(spp=1)
    assert any("no light" in text for text in result.warnings)


# ---- What is wrong ----


def test_error_has_place_and_text_of_the_command_line(program, tmp_path):
    scene = tmp_path / "wrong.pbrt"
    scene.write_text(BALL.replace("coateddiffuse", "coatedifuse"))
    told = subprocess.run([program, scene, "--quiet"], capture_output=True, text=True)
    assert told.returncode == 2
    with pytest.raises(lacquer.SceneError) as caught:
        lacquer.load(scene).render()
    error = caught.value
    assert (error.file, error.line) == (str(scene), 8) and error.column == 1
    assert str(error) == told.stderr.splitlines()[0]
    assert 'did you mean "coateddiffuse"' in error.message
    assert isinstance(error, (ValueError, lacquer.Error)) and len(error.diagnostics) == 1


def test_all_problems_are_told():
    scene = lacquer.parse(BALL.replace("coateddiffuse", "coatedifuse").replace("sphere", "spere"), name="two")
    with pytest.raises(lacquer.SceneError) as caught:
        scene.render()
    assert [d.line for d in caught.value.diagnostics] == [8, 10]
    assert [line.split(" ")[0] for line in str(caught.value).splitlines()] == ["two:8:1:", "two:10:1:"]


def test_missing_file():
    with pytest.raises(OSError) as caught:
        lacquer.load("nowhere.pbrt")
    assert isinstance(caught.value, lacquer.FileError) and "nowhere.pbrt" in str(caught.value)


@pytest.mark.parametrize("text", ["", " \n", "WorldBegin Shape", "\0", "\x7f", "Film \"rgb\" \"integer x\" [", "é"])
def test_texts_that_are_no_scenes(text):
    with pytest.raises(lacquer.Error):
        lacquer.parse(text)


@pytest.mark.parametrize("call", [
    lambda: lacquer.parse(None), lambda: lacquer.parse(b"WorldBegin"), lambda: lacquer.parse("\ud800"),
    lambda: lacquer.load(None), lambda: lacquer.load([]), lambda: lacquer.load(3), lambda: lacquer.load([3]),
    lambda: lacquer.load("a\0b"), lambda: lacquer.Scene(3), lambda: lacquer.parse(BALL, 3),
    lambda: lacquer.load("/"),
])
def test_wrong_scenes(call):
    with pytest.raises(lacquer.Error):
        call()


def test_passes_add_up_to_the_image():
    channels = ball().render(spp=8, aov=["emission", "direct", "indirect", "lpe:all=C.*L"]).channels
    for c in "RGB":
        parts = channels["emission." + c] + channels["direct." + c] + channels["indirect." + c]
        assert channels[c].max() > 0
        np.testing.assert_allclose(parts, channels[c], rtol=1e-5, atol=1e-6)
        np.testing.assert_allclose(channels["all." + c], channels[c], rtol=1e-5, atol=1e-6)
        assert not np.allclose(channels["direct." + c], channels[c], rtol=1e-5)  # or nothing was told apart


@pytest.mark.parametrize("parameters, text", [
    (dict(sp=3), 'did you mean "spp"'), (dict(spp=0), "from 1"), (dict(spp=-5), "from 1"), (dict(spp=1.5), "integer"),
    (dict(spp="4"), "integer"), (dict(spp=True), "integer"), (dict(spp=1 << 80), "from 1"), (dict(seed="x"), "integer"),
    (dict(seed=1 << 40), "from"), (dict(resolution=(0, 4)), "from 1"), (dict(resolution=(4,)), "width and height"),
    (dict(resolution="4x4"), "width and height"), (dict(resolution=5), "width and height"),
    (dict(resolution=(1 << 20, 1)), "from 1"), (dict(cropwindow=(0, 2, 0, 1)), "from 0 to 1"),
    (dict(cropwindow=(0, float("nan"), 0, 1)), "finite"), (dict(cropwindow=(0.5, 0.5, 0, 1)), "no pixel"),
    (dict(pixelbounds=(100, 200, 0, 4)), "no pixel"), (dict(pixel=(-1, 0)), "from 0"), (dict(pixel=(999, 0)), "no pixel"),
    (dict(sample_range=(3, 2)), "first < end"), (dict(sample_range=(0, 99)), "at most 4"),
    (dict(time_limit=0), "positive"), (dict(time_limit=float("inf")), "finite"), (dict(time_limit="1"), "number"),
    (dict(aov=["albdo"]), 'did you mean "albedo"'), (dict(aov=[3]), "unknown"),
    (dict(aov="lpe:x=CQL"), "Q"), (dict(aov="lpe:"), "NAME=EXPRESSION"), (dict(aov="albedo,x"), "unknown"),
    (dict(cryptomatte_ranks=3), "even"), (dict(estimator="bidirectionl"), 'did you mean "bidirectional"'),
    (dict(layered_pdf="x"), "known"), (dict(quick=1), "True or False"), (dict(nthreads=-1), "from 0"),
    (dict(nthreads=1 << 40), "from 0"), (dict(texture_memory=1), "from 16"), (dict(progress=3), "called"),
    (dict(disable_pixel_jitter="yes"), "True or False"), (dict(displacement_edge_scale=0), "positive"),
    (dict(displacement_edge_scale="x"), "positive number"), (dict(render_coord_sys="wrld"), 'did you mean "world"'),
    (dict(mse_reference_image="x"), "no parameter"), (dict(force_diffuse=None), "True or False"),
])
def test_wrong_parameters(parameters, text):
    with pytest.raises(lacquer.UsageError) as caught:
        ball().render(**{"spp": 4, **parameters})
    assert text in str(caught.value)


@pytest.mark.parametrize("target, value", [
    ("pant.roughness", 1), ("paint", 1), ("", 1), (3, 1), ("paint.rgb reflectance", (1, 2)), ("paint.float roughness", "x"),
    ("paint.roughness", float("nan")), ("paint.roughness", []), ("paint.roughness", None), ("paint.flot roughness", 1),
    ("paint.roughness", object()),
])
def test_wrong_values(target, value):
    scene = ball()
    with pytest.raises(lacquer.UsageError):
        scene.set(target, value)
    assert scene.render(spp=1).complete


def test_set_names_what_does_not_exist():
    scene = ball()
    scene.set("paint.roughnes", 1)
    with pytest.raises(lacquer.SceneError, match='did you mean "roughness"'):
        scene.render()


def test_unknown_material():
    with pytest.raises(lacquer.SceneError, match='did you mean "paint"'):
        ball().material("pant")
    for wrong in (3, None, "", "@7"):
        with pytest.raises(lacquer.Error):
            ball().material(wrong)
    for uv in (3, (1,), ("a", "b"), (float("nan"), 0)):
        with pytest.raises(lacquer.UsageError):
            ball().material("paint", uv=uv)
