"""Makes the scenes of tests/blender: blender --background --factory-startup --python make_scenes.py -- FOLDER

Each scene is FOLDER/NAME.blend and, by Cycles, FOLDER/NAME-cycles.exr; FOLDER/facts.json has what check.py must know of them.
"""
import json
import math
import os
import sys

import bpy
import numpy as np
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Euler

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import build  # noqa: E402  (after the path)
import show_scene  # noqa: E402

FOLDER = sys.argv[sys.argv.index("--") + 1]
FACTS = {}


def save(name, passes=False, cycles=True, **facts):
    path = os.path.join(FOLDER, name)
    if cycles:
        build.render_cycles(path + "-cycles.exr", passes)
    bpy.ops.wm.save_as_mainfile(filepath=path + ".blend", copy=True)
    FACTS[name] = facts


# ---- Cameras and geometry ----

CAMERAS = {
    "camera-wide": {"lens": 40, "resolution": (96, 60)},
    "camera-tall": {"lens": 30, "resolution": (60, 96), "shift_x": 0.1, "shift_y": -0.15},
    "camera-vertical": {"lens": 30, "resolution": (192, 120), "sensor_fit": "VERTICAL", "sensor_height": 18, "percentage": 50},
    "camera-horizontal": {"lens": 30, "resolution": (60, 96), "sensor_fit": "HORIZONTAL"},
    "camera-ortho": {"type": "ORTHO", "ortho_scale": 9, "resolution": (96, 60), "shift_x": 0.1},
    "camera-border": {"lens": 40, "resolution": (96, 60), "border": (0.25, 0.75, 0.1, 0.6)},
}


def geometry():
    """Objects that any mistake about transforms, modifiers or instances would move: nothing is symmetric."""
    grey = build.material("Grey", "BsdfDiffuse", Color=(0.5, 0.5, 0.5))
    red = build.material("Red", "BsdfDiffuse", Color=(0.6, 0.1, 0.1))
    build.mesh("primitive_plane_add", "Ground", grey, size=40)
    monkey = build.mesh("primitive_monkey_add", "Monkey", grey, smooth=True, location=(-1.6, 0, 1), rotation=(0.2, 0.1, 0.4))
    monkey.data.materials.append(red)
    for polygon in monkey.data.polygons:
        polygon.material_index = int(polygon.center.x > 0.3)
    modifier = monkey.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 0, 2
    mirrored = build.place(build.mesh("primitive_cone_add", "Cone", red, location=(1.8, -1.5, 0.6), vertices=7).data, "Mirrored",
                           (1.6, 1.2, 0.9), (20, 30, 40), (-1, 0.8, 0.5))
    build.place(mirrored.data, "Third", (-0.2, 2.2, 0.7), (-60, 10, 0), (0.7, 0.7, -0.7))
    torus = build.mesh("primitive_torus_add", "Torus", grey, smooth=True, location=(0.6, -0.4, 0.5), rotation=(0.7, 0.2, 0))
    torus.scale = (-0.8, 0.8, 0.8)
    array = build.mesh("primitive_cube_add", "Stairs", red, size=0.4, location=(-2.6, -2, 0.2))
    steps = array.modifiers.new("Array", "ARRAY")
    steps.count, steps.relative_offset_displace = 4, (1, 0.3, 0.5)
    group(red)
    bpy.ops.object.metaball_add(location=(3, -3, 0.3), radius=0.5)
    bpy.context.object.data.materials.append(grey)
    hidden = build.mesh("primitive_uv_sphere_add", "Hidden", red, location=(0, -2, 1))
    hidden.hide_render = True
    build.mesh("primitive_uv_sphere_add", "Unseen", red, radius=0.4, location=(0.4, -2.4, 0.4)).hide_viewport = True


def group(material):
    """A collection of a mesh and a text that is in the scene by two empties only, one of which mirrors."""
    collection = bpy.data.collections.new("Group")
    block = build.mesh("primitive_cube_add", "Block", material, size=0.5, location=(0, 0.6, 0.25))
    bpy.ops.object.text_add(location=(0, 0, 0.1), rotation=(1.2, 0, 0.3))
    letters = bpy.context.object
    letters.data.body, letters.data.extrude = "Rg", 0.05
    for owner in (block, letters):
        collection.objects.link(owner)
        bpy.context.scene.collection.objects.unlink(owner)
    for place, scale in (((-0.9, -2.6, 0), (1, 1, 1)), ((3.2, 0.6, 0), (-1, 1, 1.4))):
        empty = build.place(None, "Empty", place, (0, 0, 25), scale)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection


def cameras():
    for name, settings in CAMERAS.items():
        settings = dict(settings)
        scene = build.empty_scene(*settings.pop("resolution"), samples=1)
        geometry()
        build.world((1, 1, 1))
        scene.render.resolution_percentage = settings.pop("percentage", 100)
        border = settings.pop("border", None)
        owner = build.camera((4.5, -6, 5), (56, 4, 36), **settings)
        if border:
            scene.render.use_border = True
            (scene.render.border_min_x, scene.render.border_max_x, scene.render.border_min_y, scene.render.border_max_y) = border
        bpy.context.view_layer.update()
        points = [(0, 0, 0), (1, -1, 0), (-1, -2, 0), (2, 1, 0), (-2, 2.5, 0)]
        views = [list(world_to_camera_view(scene, owner, owner.location.__class__(p)))[:2] for p in points]
        save(name, passes=True, points=points, views=views, border=border)


# ---- Lamps over a grey plane, seen from above ----

def emitting_quad():
    quad = build.mesh("primitive_plane_add", "Quad", build.material("Glow", "Emission", Color=(1, 1, 1), Strength=5), size=1)
    quad.location, quad.rotation_euler = (0, 0, 2), (math.pi, 0, 0)


LAMPS = {
    "point": lambda: build.lamp("POINT", (0, 0, 2), energy=100, shadow_soft_size=0),
    "point-soft": lambda: build.lamp("POINT", (0, 0, 2), energy=100, shadow_soft_size=0.3),
    "sun": lambda: build.lamp("SUN", (0, 0, 2), (0, 40, 0), energy=3, angle=0),
    "spot-inside": lambda: build.lamp("SPOT", (0, 0, 2), energy=100, spot_size=math.radians(60), spot_blend=0.5, shadow_soft_size=0),
    "spot-edge": lambda: build.lamp("SPOT", (0, 0, 2), (0, 14, 0), energy=100, spot_size=math.radians(36), spot_blend=0.6,
                                    shadow_soft_size=0),
    "area-square": lambda: build.lamp("AREA", (0, 0, 2), energy=100, shape="SQUARE", size=1.5),
    "area-rectangle": lambda: build.lamp("AREA", (0, 0, 2), energy=100, shape="RECTANGLE", size=1, size_y=3),
    "area-disk": lambda: build.lamp("AREA", (0, 0, 2), energy=100, shape="DISK", size=1.5),
    "area-ellipse": lambda: build.lamp("AREA", (0, 0, 2), energy=100, shape="ELLIPSE", size=1.5, size_y=0.5),
    "mesh": emitting_quad,
    "world": lambda: build.world((0.2, 0.5, 0.9), 2),
}


def lamps():
    for name, add in LAMPS.items():
        scene = build.empty_scene(16, 16, samples=256)
        scene.cycles.max_bounces = 1
        # The camera is below the lamps and looks at a patch around the origin.
        build.camera((0, 0, 1), (0, 0, 0), type="ORTHO", ortho_scale=0.02)
        build.mesh("primitive_plane_add", "Ground", build.material("Grey", "BsdfDiffuse", Color=(0.5, 0.5, 0.5)), size=60)
        lamp = add()
        if name == "area-rectangle":
            lamp.scale = (-0.8, 1.2, 1)
        save("lamp-" + name)


def bounces():
    """A corner whose planes light each other."""
    for count in (0, 1):
        scene = build.empty_scene(16, 16, samples=256)
        scene.cycles.max_bounces = count
        build.camera((0, -6, 3), (60, 0, 0), lens=40)
        white = build.material("White", "BsdfDiffuse", Color=(0.8, 0.8, 0.8))
        build.mesh("primitive_plane_add", "Ground", white, size=20)
        build.mesh("primitive_plane_add", "Wall", white, size=20, location=(0, 1, 0), rotation=(math.pi / 2, 0, 0))
        build.lamp("POINT", (0, -0.5, 1.5), energy=100, shadow_soft_size=0)
        save("bounces-%d" % count)


# ---- Environments ----

def environments():
    """An image whose value is linear in the direction, by what Blender looks up: column 1/2 - phi / 2 pi."""
    width, height = 256, 128
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    phi, theta = (0.5 - u) * 2 * np.pi, v * np.pi
    pixels = 0.5 + 0.5 * np.stack([np.cos(phi) * np.sin(theta), np.sin(phi) * np.sin(theta), np.cos(theta)], axis=2)
    for name, rotation in (("environment-plain", None), ("environment-turned", (25, -40, 70))):
        build.empty_scene(32, 24, samples=16)
        build.camera((0, 0, 0), (75, 0, 30), lens=18)
        data = build.world()
        texture = build.node(data, "TexEnvironment")
        texture.image = build.image("sky", pixels, os.path.join(FOLDER, "sky.exr"))
        data.node_tree.links.new(texture.outputs[0], data.node_tree.nodes["Background"].inputs["Color"])
        matrix = np.eye(3)
        if rotation:
            angles = [math.radians(a) for a in rotation]
            mapping = build.node(data, "Mapping", Rotation=angles,
                                 Vector=build.node(data, "TexCoord").outputs["Generated"])
            data.node_tree.links.new(mapping.outputs[0], texture.inputs[0])
            matrix = np.array(Euler(angles, "XYZ").to_matrix())
        bpy.context.view_layer.update()
        owner = bpy.context.scene.camera
        corners = [list(owner.matrix_world.to_3x3() @ c) for c in owner.data.view_frame(scene=bpy.context.scene)]
        save(name, rotation=matrix.tolist(), corners=corners)


# ---- Skies over a grey ball on a plane, seen from above ----

SKIES = {
    "sky-disk": {"sky_type": "NISHITA", "sun_elevation": math.radians(40), "sun_rotation": math.radians(130)},
    "sky-plain": {"sky_type": "NISHITA", "sun_elevation": math.radians(20), "sun_rotation": math.radians(-30), "sun_disc": False},
    "sky-hosek": {"sky_type": "HOSEK_WILKIE", "sun_direction": (0.5, 0.6, 0.6), "turbidity": 3},
    "sky-preetham": {"sky_type": "PREETHAM", "sun_direction": (-0.5, 0.6, 0.6), "turbidity": 3},
}


def skies():
    for name, settings in SKIES.items():
        scene = build.empty_scene(48, 48, samples=128)
        scene.cycles.max_bounces = 1
        build.camera((0, 0, 12), (0, 0, 0), lens=60)
        grey = build.material("Grey", "BsdfDiffuse", Color=(0.5, 0.5, 0.5))
        build.mesh("primitive_plane_add", "Ground", grey, size=40).location = (0, 0, -1)
        build.mesh("primitive_uv_sphere_add", "Ball", grey, segments=64, ring_count=32)
        data = build.world()
        texture = build.node(data, "TexSky")
        for setting, value in settings.items():
            setattr(texture, setting, value)
        data.node_tree.links.new(texture.outputs[0], data.node_tree.nodes["Background"].inputs["Color"])
        save(name)


# ---- Materials in a white furnace, and textures ----

# A grey, for products of coloured reflectances are not those of their colours.
GREY = (0.5, 0.5, 0.5)
MATERIALS = {
    "rough-plastic": lambda: build.material("Plastic", Base_Color=GREY, Roughness=0.5),
    "rougher-plastic": lambda: build.material("Plastic", Base_Color=GREY, Roughness=0.7),
    "roughest-plastic": lambda: build.material("Plastic", Base_Color=GREY, Roughness=1),
    "plastic": lambda: build.material("Plastic", Base_Color=GREY, Roughness=0),
    "coated-plastic": lambda: build.material("Lacquered \"wood\"", Base_Color=GREY, Roughness=0, Clearcoat=1,
                                             Clearcoat_Roughness=0),
    "metal": lambda: build.material("Metal", Base_Color=GREY, Roughness=0, Metallic=1),
    "coated-metal": lambda: build.material("Car paint", Base_Color=GREY, Roughness=0, Metallic=1, Clearcoat=1,
                                           Clearcoat_Roughness=0),
    "mixed": lambda: build.material("Half metal", Base_Color=GREY, Roughness=0, Metallic=0.5, Clearcoat=0.5,
                                    Clearcoat_Roughness=0),
    "glass": lambda: build.material("Bottle", Base_Color=GREY, Roughness=0, Transmission=1, IOR=1.5),
    "textured": lambda: textured(),
    "textured-plastic": lambda: textured_stack("Printed", Clearcoat=1),
    "textured-metal": lambda: textured_stack("Etched", Clearcoat=1, Metallic=1),
    "alpha": lambda: alpha(),
    "normal-map": lambda: tilted(),
    "emission": lambda: build.material("Glow", Base_Color=(0, 0, 0), Specular=0, Emission=(0.6, 0.7, 0.9), Emission_Strength=3),
}
GREYS = [[0.3, 0.5], [0.7, 0.85]]
TILT = (0.48, -0.36, 0.8)
TEXELS = [[(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)], [(0.0, 0.0, 1.0), (0.5, 0.5, 0.5)]]


def textured():
    data = build.material("Textured", "BsdfDiffuse")
    texture = build.image_node(data, build.image("texels", TEXELS))
    data.node_tree.links.new(texture.outputs["Color"], build.shader_of(data).inputs["Color"])
    return data


def textured_stack(name, **inputs):
    """Greys under a coat: their reflectances are computed for each texel."""
    data = build.material(name, Roughness=0, Clearcoat_Roughness=0, **inputs)
    texture = build.image_node(data, build.image("greys", [[(g,) * 3 for g in row] for row in GREYS]))
    data.node_tree.links.new(texture.outputs["Color"], build.shader_of(data).inputs["Base Color"])
    return data


def tilted():
    """A normal map of one direction, with half of its slope."""
    data = build.material("Tilted", "BsdfDiffuse", Color=GREY)
    pixels = np.tile(np.array(TILT, np.float32) * 0.5 + 0.5, (4, 4, 1))
    texture = build.image_node(data, build.image("tilt", pixels, space="Non-Color"))
    normal = build.node(data, "NormalMap", Strength=0.5, Color=texture.outputs["Color"])
    data.node_tree.links.new(normal.outputs["Normal"], build.shader_of(data).inputs["Normal"])
    return data


def alpha():
    """Holes where the image's alpha is 0, and half of it where that is a half."""
    data = build.material("Holes", Base_Color=(0, 0, 0), Specular=0)
    pixels = [[(1, 1, 1, 0), (1, 1, 1, 1)], [(1, 1, 1, 0.5), (1, 1, 1, 1)]]
    texture = build.image_node(data, build.image("holes", pixels))
    data.node_tree.links.new(texture.outputs["Alpha"], build.shader_of(data).inputs["Alpha"])
    return data


def materials():
    for name, make in MATERIALS.items():
        scene = build.empty_scene(16, 16, samples=64)
        scene.cycles.max_bounces = scene.cycles.transmission_bounces = scene.cycles.glossy_bounces = 24
        build.world((1, 1, 1))
        build.camera((0, 0, 3), (0, 0, 0), type="ORTHO", ortho_scale=2)
        data = make()
        if name == "glass":
            build.mesh("primitive_cube_add", "Block", data, size=4, location=(0, 0, -1))
        else:
            build.mesh("primitive_plane_add", "Plate", data, size=2)
        save("material-" + name)


# ---- What cannot be translated ----

def odd():
    build.empty_scene(8, 8, samples=1)
    build.camera((0, 0, 3), (0, 0, 0), type="ORTHO", ortho_scale=2)
    noisy = build.material("Noisy", Sheen=0.5)
    shader = build.shader_of(noisy)
    noise = build.node(noisy, "TexNoise")
    noisy.node_tree.links.new(noise.outputs["Color"], shader.inputs["Base Color"])
    lost = bpy.data.images.load(os.path.join(FOLDER, "sky.exr"))
    lost.filepath = "//not-there.png"
    missing = build.image_node(noisy, lost)
    noisy.node_tree.links.new(missing.outputs["Color"], shader.inputs["Roughness"])
    build.mesh("primitive_plane_add", "Two\nlines \"quoted\" \\ and ünï/../code", noisy, size=2)
    build.mesh("primitive_plane_add", "Toon", build.material("Toon", "BsdfToon", Color=(1, 0, 0)), size=1)
    build.mesh("primitive_plane_add", "Empty slot", None, size=1).data.materials.append(None)
    build.mesh("primitive_plane_add", "Flat", None, size=1).scale = (0, 0, 0)
    build.lamp("SPOT", (0, 0, 2), energy=10, shadow_soft_size=0.1)
    save("odd", cycles=False)
    bpy.context.scene.camera = None
    save("no-camera", cycles=False)


def main():
    cameras()
    lamps()
    bounces()
    environments()
    skies()
    materials()
    odd()
    show_scene.make()
    save("show", samples=bpy.context.scene.cycles.samples)
    with open(os.path.join(FOLDER, "facts.json"), "w", encoding="utf-8") as file:
        json.dump(FACTS, file, indent=1)


main()
