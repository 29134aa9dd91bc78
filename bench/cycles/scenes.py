"""Builds one scene of the comparison with Cycles, inside Blender: blender --background --python scenes.py -- NAME OUT.blend

Diffuse surfaces, rough metal, and lights that are emissive meshes: what both programs model alike.
"""
import math
import os
import random
import sys

import bpy
from mathutils import Vector

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "tests", "blender"))
import build  # noqa: E402  (after the path)

BOUNCES = 5  # after the first surface


def quad(name, corners, material):
    """A rectangle or any other quadrangle."""
    data = bpy.data.meshes.new(name)
    data.from_pydata(corners, [], [(0, 1, 2, 3)])
    data.materials.append(material)
    return build.place(data, name)


def emission(name, color):
    return build.material(name, "Emission", Color=color, Strength=1.0)


def diffuse(name, color):
    return build.material(name, "BsdfDiffuse", Color=color)


def metal(name, color, roughness):
    """By GGX with a roughness of alpha = roughness^2."""
    made = build.material(name, "BsdfGlossy", Color=color, Roughness=roughness)
    build.shader_of(made).distribution = "GGX"
    return made


def look(position, target, fov):
    """A camera with a horizontal angle of view [degrees]."""
    direction = Vector(target) - Vector(position)
    rotation = [math.degrees(a) for a in direction.to_track_quat("-Z", "Y").to_euler()]
    build.camera(position, rotation, angle=math.radians(fov), clip_end=1e5)


def box(name, corners, height, material):
    """A block with a quadrangle as its floor and vertical walls."""
    vertices = [(*c, 0) for c in corners] + [(*c, height) for c in corners]
    data = bpy.data.meshes.new(name)
    data.from_pydata(vertices, [], [(4, 5, 6, 7), *[(i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i) for i in range(4)]])
    data.materials.append(material)
    build.place(data, name)


def subdivide(thing, levels):
    modifier = thing.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = levels


def cornell_box():
    """Of the sizes that Cornell University measured, in metres; the light is level with the ceiling."""
    build.empty_scene(400, 400)
    grey, red, green = diffuse("Grey", (.73, .73, .73)), diffuse("Red", (.65, .05, .05)), diffuse("Green", (.12, .45, .15))
    w, d, h = 5.528, 5.592, 5.488
    quad("Floor", [(0, 0, 0), (w, 0, 0), (w, d, 0), (0, d, 0)], grey)
    quad("Ceiling", [(0, 0, h), (0, d, h), (w, d, h), (w, 0, h)], grey)
    quad("Back", [(0, d, 0), (w, d, 0), (w, d, h), (0, d, h)], grey)
    quad("Right", [(w, 0, 0), (w, 0, h), (w, d, h), (w, d, 0)], red)
    quad("Left", [(0, 0, 0), (0, d, 0), (0, d, h), (0, 0, h)], green)
    quad("Light", [(2.13, 2.27, h - .001), (2.13, 3.32, h - .001), (3.43, 3.32, h - .001), (3.43, 2.27, h - .001)],
         emission("Lamp", (20, 17, 12)))
    box("Short", [(1.30, .65), (.82, 2.25), (2.40, 2.72), (2.90, 1.14)], 1.65, grey)
    box("Tall", [(4.23, 2.47), (2.65, 2.96), (3.14, 4.56), (4.72, 4.06)], 3.30, grey)
    look((2.78, -8, 2.73), (2.78, 0, 2.73), 37.5)


def heads():
    """Two subdivided heads in a corner, one of metal, under a small bright ball."""
    build.empty_scene(400, 400)
    wall = diffuse("Wall", (.5, .5, .8))
    quad("Floor", [(-10, -10, 0), (10, -10, 0), (10, 10, 0), (-10, 10, 0)], wall)
    quad("Wall", [(-10, 4, -10), (10, 4, -10), (10, 4, 10), (-10, 4, 10)], wall)
    for x, material in ((-1.5, diffuse("Clay", (.4, .2, .2))), (1.5, metal("Gold", (.9, .65, .3), .4))):
        head = build.mesh("primitive_monkey_add", material.name, material, smooth=True, location=(x, 0, 1.1), rotation=(0, 0, .4 * x))
        subdivide(head, 4)
    build.mesh("primitive_uv_sphere_add", "Ball", emission("Lamp", (2000, 2000, 2000)), location=(3, -5, 6), radius=.1)
    look((0, -8, 3), (0, 0, 1), 39)


def room():
    """A million triangles of things on shelves, lit through one window by a bright plane outside."""
    build.empty_scene(512, 288)
    rng = random.Random(1)
    white, wood = diffuse("White", (.75, .75, .72)), diffuse("Wood", (.35, .22, .12))
    w, d, h = 6, 5, 3
    quad("Floor", [(0, 0, 0), (w, 0, 0), (w, d, 0), (0, d, 0)], wood)
    quad("Ceiling", [(0, 0, h), (0, d, h), (w, d, h), (w, 0, h)], white)
    quad("Back", [(0, d, 0), (w, d, 0), (w, d, h), (0, d, h)], white)
    quad("Front", [(0, 0, 0), (0, 0, h), (w, 0, h), (w, 0, 0)], white)
    quad("Right", [(w, 0, 0), (w, 0, h), (w, d, h), (w, d, 0)], white)
    for name, y0, y1, z0, z1 in (("Below", 0, d, 0, .8), ("Above", 0, d, 2.4, h), ("Before", 0, 1.2, .8, 2.4), ("Behind", 3.6, d, .8, 2.4)):
        quad(name, [(0, y0, z0), (0, y1, z0), (0, y1, z1), (0, y0, z1)], white)
    quad("Sky", [(-1, 0, 0), (-1, 0, 4), (-1, d, 4), (-1, d, 0)], emission("Daylight", (18, 20, 24)))
    materials = [diffuse("Paint %d" % i, (rng.uniform(.1, .8), rng.uniform(.1, .8), rng.uniform(.1, .8))) for i in range(5)]
    materials.append(metal("Steel", (.7, .7, .7), .45))
    shapes = []
    for i, material in enumerate(materials):
        thing = build.mesh("primitive_monkey_add" if i % 2 else "primitive_torus_add", "Thing %d" % i, material, smooth=True)
        subdivide(thing, 3 if i % 2 else 2)
        bpy.context.view_layer.update()
        evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
        shapes.append(bpy.data.meshes.new_from_object(evaluated))
        bpy.data.objects.remove(thing)
    for shelf in range(3):
        quad("Shelf %d" % shelf, [(1, 4.3, .7 * shelf + .5), (5.5, 4.3, .7 * shelf + .5), (5.5, d, .7 * shelf + .5), (1, d, .7 * shelf + .5)], wood)
        for k in range(10):
            size = rng.uniform(.12, .2)
            build.place(shapes[rng.randrange(len(shapes))].copy(), "Item", (1.2 + .45 * k, 4.6, .7 * shelf + .5 + size),
                        (rng.uniform(0, 40), 0, rng.uniform(0, 360)), (size, size, size))
    look((5.3, .4, 1.6), (2.2, 4.6, 1.1), 62)


SCENES = {"cornell-box": cornell_box, "heads": heads, "room": room}


def main():
    name, path = sys.argv[sys.argv.index("--") + 1:]
    SCENES[name]()
    scene = bpy.context.scene
    build.world((0, 0, 0))
    cycles = scene.cycles
    cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 1
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = BOUNCES
    cycles.caustics_reflective = True
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0
    bpy.ops.wm.save_as_mainfile(filepath=path)
    triangles = sum(len(o.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh().loop_triangles) for o in scene.objects if o.type == "MESH")
    print("TRIANGLES %d" % triangles)


main()
