"""The camera, the film, the sampler and the integrator: what stands before WorldBegin."""
import math
import os

from .report import ExportError, where_of

# Camera space of the format is left-handed: it looks along +z, Blender's camera along -z.
MIRROR_Z = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, -1, 0), (0, 0, 0, 1))


def write(text, scene, depsgraph, report, scene_path):
    if scene.camera is None:
        raise ExportError(f"scene \"{scene.name}\" has no camera: set one in the scene's properties")
    if scene.camera.type != "CAMERA":
        raise ExportError(f"the active camera \"{scene.camera.name}\" of scene \"{scene.name}\" is no camera but "
                          f"{scene.camera.type.lower()}")
    write_camera(text, scene, scene.camera.evaluated_get(depsgraph), report)
    write_film(text, scene, scene_path)
    write_settings(text, scene)


def write_camera(text, scene, owner, report):
    from mathutils import Matrix
    camera = owner.data
    text.comment(owner.name)
    location, rotation, _ = owner.matrix_world.decompose()
    world_from_camera = Matrix.Translation(location) @ rotation.to_matrix().to_4x4()
    text.transform(Matrix(MIRROR_Z) @ world_from_camera.inverted())
    # The corners of the frame have sensor fit, shift and aspect in them.
    corners = camera.view_frame(scene=scene)
    is_orthographic = camera.type == "ORTHO"
    if camera.type == "PANO":
        report.warn(where_of(camera), "panoramic cameras are not translated; a perspective one is taken instead")
    points = [(c.x, c.y) if is_orthographic else (c.x / -c.z, c.y / -c.z) for c in corners]
    xs, ys = zip(*points)
    window = (min(xs), max(xs), min(ys), max(ys))
    params = depth_of_field(scene, owner, report)
    if is_orthographic:
        text.directive("Camera", "orthographic", params=[("float", "screenwindow", window), *params])
        return
    # The angle of the shorter side; a screen unit is half of that side.
    half = min(window[1] - window[0], window[3] - window[2]) / 2
    params = [("float", "fov", math.degrees(2 * math.atan(half))),
              ("float", "screenwindow", [w / half for w in window]), *params]
    text.directive("Camera", "perspective", params=params)


def depth_of_field(scene, owner, report):
    camera = owner.data
    focus = camera.dof
    if not focus.use_dof:
        return []
    if focus.aperture_blades or focus.aperture_ratio != 1:
        report.warn(where_of(camera), "blades and ratio of the aperture are not translated; a round one is taken instead")
    distance = focus.focus_distance
    if focus.focus_object:
        point = owner.matrix_world.inverted() @ focus.focus_object.matrix_world.translation
        distance = abs(point.z) * owner.matrix_world.to_scale().z
    length = 1.0 if camera.type == "ORTHO" else camera.lens / 1000  # millimetres
    return [("float", "lensradius", length / (2 * max(focus.aperture_fstop, 1e-5))),
            ("float", "focaldistance", max(distance, 1e-5))]


def write_film(text, scene, scene_path):
    render = scene.render
    width = max(1, int(render.resolution_x * render.resolution_percentage / 100))
    height = max(1, int(render.resolution_y * render.resolution_percentage / 100))
    image = os.path.splitext(os.path.basename(scene_path))[0] + ".exr"
    params = [("integer", "xresolution", width), ("integer", "yresolution", height), ("string", "filename", image)]
    if render.use_border:
        # Blender counts from the bottom, films from the top.
        params.append(("float", "cropwindow", (render.border_min_x, render.border_max_x,
                                               1 - render.border_max_y, 1 - render.border_min_y)))
    exposure = getattr(getattr(scene, "cycles", None), "film_exposure", 1.0)
    if exposure != 1:
        params.append(("float", "iso", 100 * exposure))
    text.directive("Film", "rgb", params=params)


def write_settings(text, scene):
    cycles = getattr(scene, "cycles", None)
    samples = cycles.samples if cycles and scene.render.engine == "CYCLES" else scene.eevee.taa_render_samples
    text.directive("Sampler", "zsobol", params=[("integer", "pixelsamples", max(1, min(samples, 2 ** 24)))])
    # Cycles counts the bounces after the first surface, whose direct light is there without any.
    text.directive("Integrator", "path", params=[("integer", "maxdepth", (cycles.max_bounces if cycles else 12) + 1)])
