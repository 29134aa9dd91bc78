"""Builders for the scenes of this folder, inside Blender: nodes, meshes, lamps, cameras, images."""
import math

import bpy
import numpy as np


def empty_scene(width=32, height=32, samples=16):
    """A scene with nothing in it, set up so that Cycles writes linear values."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.resolution_percentage = 100
    scene.cycles.samples = samples
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.cycles.sample_clamp_indirect = 0
    scene.cycles.blur_glossy = 0
    return scene


def place(data, name, location=(0, 0, 0), rotation=(0, 0, 0), scale=(1, 1, 1)):
    """A new object with this data; rotation in degrees."""
    owner = bpy.data.objects.new(name, data)
    owner.location, owner.scale = location, scale
    owner.rotation_euler = [math.radians(a) for a in rotation]
    bpy.context.scene.collection.objects.link(owner)
    return owner


def camera(location, rotation, **settings):
    data = bpy.data.cameras.new("Camera")
    for key, value in settings.items():
        setattr(data, key, value)
    bpy.context.scene.camera = place(data, "Camera", location, rotation)
    return bpy.context.scene.camera


def lamp(kind, location, rotation=(0, 0, 0), **settings):
    data = bpy.data.lights.new(kind.capitalize(), kind)
    for key, value in settings.items():
        setattr(data, key, value)
    return place(data, data.name, location, rotation)


def mesh(operator, name, material=None, smooth=False, **arguments):
    """An object made by an operator of bpy.ops.mesh."""
    getattr(bpy.ops.mesh, operator)(**arguments)
    owner = bpy.context.object
    owner.name = owner.data.name = name
    if smooth:
        owner.data.polygons.foreach_set("use_smooth", [True] * len(owner.data.polygons))
    if material:
        owner.data.materials.append(material)
    return owner


def material(name, kind="BsdfPrincipled", **inputs):
    """A material with one shader node; inputs by name, with _ for spaces; sockets of other nodes are linked."""
    data = bpy.data.materials.new(name)
    data.use_nodes = True
    tree = data.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    shader = node(data, kind, **inputs)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return data


def node(owner, kind, **inputs):
    """A new node of a material or world; an input is a value, or an output that is linked to it."""
    tree = owner.node_tree
    made = tree.nodes.new("ShaderNode" + kind)
    for name, value in inputs.items():
        socket = made.inputs[name.replace("_", " ")]
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, socket)
        elif hasattr(socket.default_value, "__len__") and len(socket.default_value) == 4:
            socket.default_value = (*value, 1)
        else:
            socket.default_value = value
    return made


def shader_of(data):
    """The shader node that material() made."""
    return next(n for n in data.node_tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"].links[0].from_node


def world(color=(0, 0, 0), strength=1.0):
    data = bpy.data.worlds.new("World")
    data.use_nodes = True
    background = data.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*color, 1)
    background.inputs["Strength"].default_value = strength
    bpy.context.scene.world = data
    return data


def image(name, pixels, path=None, space=None):
    """A packed image of pixels (height, width, 3 or 4), rows from the top; with a path of .exr it has floats."""
    pixels = np.asarray(pixels, dtype=np.float32)
    height, width = pixels.shape[:2]
    if pixels.shape[2] == 3:
        pixels = np.concatenate([pixels, np.ones((height, width, 1), np.float32)], axis=2)
    made = bpy.data.images.new(name, width, height, alpha=True, float_buffer=bool(path and path.endswith(".exr")))
    # Blender 3.4 would encode a float image as sRGB when it saves it, were it Linear.
    made.colorspace_settings.name = "Non-Color" if made.is_float else space or "sRGB"
    made.pixels.foreach_set(pixels[::-1].ravel())
    if path:
        made.file_format = "OPEN_EXR" if path.endswith(".exr") else "PNG"
        made.filepath_raw = path
        made.save()
        bpy.data.images.remove(made)
        made = bpy.data.images.load(path)
        made.colorspace_settings.name = space or ("Linear" if made.is_float else "sRGB")
    made.pack()
    return made


def image_node(owner, picked, interpolation="Closest"):
    made = node(owner, "TexImage")
    made.image = picked
    made.interpolation = interpolation
    return made


def render_cycles(path, passes=False):
    """Renders the scene by Cycles to an EXR file; with passes also position and normal."""
    scene = bpy.context.scene
    layer = bpy.context.view_layer
    layer.use_pass_position = layer.use_pass_normal = passes
    scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER" if passes else "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
