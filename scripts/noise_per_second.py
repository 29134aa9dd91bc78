"""Which of two ways to render has less noise in the same time."""
import json
import os
import subprocess
import sys

import numpy as np
import OpenImageIO as oiio

from small_scenes import SmallScene


def rgb_of(path):
    image = oiio.ImageBuf(path)
    names = list(image.spec().channelnames)
    return image.get_pixels(oiio.FLOAT)[:, :, [names.index(c) for c in "RGB"]].astype(np.float64)


class Way:
    """A program with options.

    edit: of the scene's text, which is then read from standard input; None: the file as it is
    """

    def __init__(self, name, program, *options, edit=None):
        self.name, self.program, self.options, self.edit = name, program, options, edit


def render(way, scene, samples, seed):
    """Image, and the seconds of rendering, pilots included."""
    path, stats = (os.path.abspath(os.path.join(scene.folder, "%s-%d-%d%s" % (way.name, samples, seed, end))) for end in (".exr", ".json"))
    source, text, folder = scene.path, None, None
    if way.edit:
        with open(scene.path, encoding="utf-8") as file:
            source, text = "-", way.edit(file.read())
        folder = os.path.dirname(os.path.abspath(scene.path))  # of the files that the text names
    done = subprocess.run([way.program, source, "--resolution", "%dx%d" % scene.size, "--spp", str(samples), "--seed",
                           str(seed), "--outfile", path, "--stats-json", stats, "--quiet", *way.options],
                          check=False, input=text, text=True, cwd=folder)
    if done.returncode:
        sys.exit("%s: status %d" % (scene.path, done.returncode))
    with open(stats, encoding="utf-8") as file:
        seconds = json.load(file)["seconds"]
    return rgb_of(path), seconds["render"] + seconds.get("pilots", 0)


def by_each_seed(renders, seeds):
    """(images, seconds) of two ways, those of each seed: in turn, so that what else the machine does meets both.

    renders: for each way a function of the seed to (image, seconds)
    """
    images, seconds = ([], []), ([], [])
    for seed in range(1, seeds + 1):
        for i in (0, 1) if seed % 2 else (1, 0):
            image, took = renders[i](seed)
            images[i].append(image)
            seconds[i].append(took)
    return [np.array(i) for i in images], [np.array(s) for s in seconds]


def jackknife(estimate, seeds):
    """Standard error by leaving out one seed after the other: of estimate(i), which leaves out the i-th."""
    left_out = np.array([estimate(i) for i in range(seeds)])
    return np.sqrt((seeds - 1) / seeds * np.sum((left_out - left_out.mean(axis=0)) ** 2, axis=0))


def standard_error_of(gain, images, seconds):
    """Of gain(images, seconds), by leaving out one seed after the other."""
    return jackknife(lambda i: gain(*([np.delete(m, i, axis=0) for m in ways] for ways in (images, seconds))), len(seconds[0]))


class Comparison:
    """Of two ways, over seeds: numbers of the second one to those of the first. The error is the mean over pixels and channels of
    variance / (mean^2 + 0.01), the variance being that between seeds; the efficiency is 1 / (error x time).

    images, seconds: for each way, those of each seed
    """

    def __init__(self, images, seconds):
        mean = (images[0].mean(axis=0) + images[1].mean(axis=0)) / 2
        self.errors = [np.mean(i.var(axis=0, ddof=1) / (mean ** 2 + 0.01)) for i in images]
        self.time = seconds[1].mean() / seconds[0].mean()
        self.gain = self.errors[0] / (self.errors[1] * self.time)


class Measurement:
    """Two ways of rendering one scene."""

    def __init__(self, scene, ways, samples, seeds):
        self.images, self.seconds = by_each_seed([lambda seed, way=way: render(way, scene, samples, seed) for way in ways], seeds)
        self.all = Comparison(self.images, self.seconds)

    def standard_error(self):
        """Of the efficiency."""
        return standard_error_of(lambda images, seconds: Comparison(images, seconds).gain, self.images, self.seconds)

    def difference(self):
        """Of the mean images' luminances, and its standard error: neither way is biased if it is nothing."""
        luminance = [i.mean(axis=(1, 2)) @ (0.2126, 0.7152, 0.0722) for i in self.images]
        error = np.sqrt(sum(l.var(ddof=1) / len(l) for l in luminance))
        mean = luminance[0].mean()
        return luminance[1].mean() / mean - 1, error / mean
