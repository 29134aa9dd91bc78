"""The scene of docs/blender.md: a coat over metal and over plastic, glass, gold, an image texture, instances, a mirrored object."""
import math

import bpy
import numpy as np

import build


def label():
    """An image that is not the same from any side: stripes that change colour along u, with a dark corner."""
    size = 64
    u, v = np.meshgrid((np.arange(size) + 0.5) / size, (np.arange(size) + 0.5) / size)
    stripes = (np.floor(v * 8) % 2)[:, :, None]
    pixels = stripes * np.stack([0.9 - 0.6 * u, 0.5 + 0 * u, 0.2 + 0.7 * u], axis=2) + (1 - stripes) * 0.85
    pixels[(u < 0.25) & (v < 0.25)] = 0.05
    return pixels


def sky():
    """A bright window to one side, a warm one to the other, dim elsewhere."""
    width, height = 256, 128
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    pixels = np.ones((height, width, 3)) * np.array([0.16, 0.2, 0.26]) * (1.2 - v)[:, :, None]
    pixels[(abs(u - 0.3) < 0.05) & (abs(v - 0.3) < 0.1)] = (9, 10, 12)
    pixels[(abs(u - 0.75) < 0.03) & (abs(v - 0.35) < 0.12)] = (14, 8, 4)
    return pixels


def surroundings():
    data = build.world(strength=1)
    texture = build.node(data, "TexEnvironment")
    texture.image = build.image("windows", sky(), bpy.app.tempdir + "windows.exr")
    data.node_tree.links.new(texture.outputs[0], data.node_tree.nodes["Background"].inputs["Color"])
    build.lamp("AREA", (-3, -2, 5), (25, -30, 0), energy=350, shape="DISK", size=1.5, color=(1, 0.95, 0.85))
    floor = build.material("Floor", Roughness=0.35)
    checker = build.node(floor, "TexChecker", Color1=(0.55, 0.55, 0.52), Color2=(0.16, 0.17, 0.19), Scale=16,
                         Vector=build.node(floor, "TexCoord").outputs["UV"])
    floor.node_tree.links.new(checker.outputs["Color"], build.shader_of(floor).inputs["Base Color"])
    build.mesh("primitive_plane_add", "Floor", floor, size=16)


def objects():
    paint = build.material("Car paint", Base_Color=(0.55, 0.02, 0.03), Metallic=0.9, Roughness=0.45, Clearcoat=1,
                           Clearcoat_Roughness=0.03)
    build.mesh("primitive_uv_sphere_add", "Paint", paint, True, segments=64, ring_count=32, radius=1, location=(-2.3, 0.2, 1))
    glass = build.material("Glass", Base_Color=(0.85, 0.95, 0.9), Roughness=0, Transmission=1, IOR=1.5)
    head = build.mesh("primitive_monkey_add", "Glass head", glass, True, location=(0.1, -0.4, 0.93), rotation=(-0.5, 0, 0.25))
    head.modifiers.new("Subdivision", "SUBSURF").render_levels = 2
    gold = build.material("Gold", Base_Color=(1.0, 0.72, 0.3), Metallic=1, Roughness=0.25)
    build.mesh("primitive_torus_add", "Gold ring", gold, True, major_segments=96, minor_segments=32, major_radius=0.7,
               minor_radius=0.22, location=(2.3, -0.6, 0.85), rotation=(1.3, 0, -0.4))
    vase = build.material("Lacquered label", Roughness=0.6, Clearcoat=1, Clearcoat_Roughness=0.05)
    texture = build.image_node(vase, build.image("label", label()), "Linear")
    vase.node_tree.links.new(texture.outputs["Color"], build.shader_of(vase).inputs["Base Color"])
    build.mesh("primitive_cylinder_add", "Label", vase, True, vertices=64, radius=0.7, depth=1.8, location=(0.9, 2.2, 0.9))
    blue = build.material("Blue plastic", Base_Color=(0.05, 0.15, 0.6), Roughness=0.3)
    left = build.mesh("primitive_monkey_add", "Blue head", blue, True, location=(-1.6, 2.6, 0.9), rotation=(-0.4, 0, 0.6))
    left.modifiers.new("Subdivision", "SUBSURF").render_levels = 2
    mirrored = build.place(left.data, "Mirrored head", (3.2, 2.4, 0.9), (-23, 0, -34), (-1, 1, 1))
    mirrored.modifiers.new("Subdivision", "SUBSURF").render_levels = 2
    pawns()


def pawns():
    """A row of instances of one mesh."""
    white = build.material("Porcelain", Base_Color=(0.8, 0.8, 0.78), Roughness=0.1)
    first = build.mesh("primitive_cone_add", "Pawn", white, vertices=6, radius1=0.25, radius2=0.05, depth=0.6,
                       location=(-3.2, -1.6, 0.3))
    for i in range(1, 7):
        build.place(first.data, "Pawn", (-3.2 + i * 1.05, -1.6 - 0.2 * math.sin(i), 0.3), (0, 0, 17 * i), (1, 1, 1 + 0.05 * i))


def make(width=240, height=135, samples=128):
    scene = build.empty_scene(width, height, samples)
    scene.cycles.max_bounces = scene.cycles.transmission_bounces = scene.cycles.glossy_bounces = 16
    scene.cycles.caustics_refractive = scene.cycles.caustics_reflective = True
    surroundings()
    objects()
    build.camera((0.4, -8.2, 4.1), (66, 0, 2), lens=42)
