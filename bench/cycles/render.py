"""Renders by Cycles, inside Blender: blender --background SCENE.blend --python render.py -- OUT.exr SAMPLES SEED THREADS

Prints "SECONDS x": those of the samples. What comes before the first is as long for one sample as for many, and is taken off.
"""
import sys
import time

import bpy

path, samples, seed, threads = sys.argv[sys.argv.index("--") + 1:]
scene = bpy.context.scene
scene.render.threads_mode, scene.render.threads = "FIXED", int(threads)
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.use_persistent_data = False  # with it, Blender 3.4 keeps the number of samples
samples = int(samples)


def seconds_of(count, number):
    scene.cycles.samples, scene.cycles.seed = count, number
    start = time.perf_counter()
    bpy.ops.render.render()
    return time.perf_counter() - start


seconds_of(1, int(seed) + 1000)  # so that files and kernels are there
first = seconds_of(1, int(seed) + 1000)
print("SECONDS %.4f" % ((seconds_of(samples, int(seed)) - first) * samples / (samples - 1)))
bpy.data.images["Render Result"].save_render(path)
