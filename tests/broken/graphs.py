"""Deep and shared graphs of textures, mixes, stacks and mixtures of phases: an answer in time, and one message, for
render, info and bsdf alike. run.health() has the limits of time and memory, and sees a stack that overflows."""
from command_line import pixels
from run import positions
from scene_commands import run, write

CASES = []
CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


# Limits of scene/texture_store.h.
MAX_DEPTH = 1000
MAX_EVALUATIONS = 1 << 16

HEAD = """Film "rgb" "integer xresolution" 16 "integer yresolution" 12 "string filename" "scene.exr"
Sampler "independent" "integer pixelsamples" 1
LookAt 0 0 3  0 0 0  0 1 0
Camera "perspective"
WorldBegin
LightSource "infinite"
"""


def scene(lines, material):
    return HEAD + "\n".join(lines) + "\n" + 'MakeNamedMaterial "m" %s\nNamedMaterial "m"\nShape "sphere"\n' % material


SPECTRUM = '"string type" "diffuse" "texture reflectance" "t%d"'
FLOAT = '"string type" "dielectric" "texture roughness" "t%d"'


def chain(count, kind="spectrum", marked=None):
    """Textures t0 ... of which each needs the one before; a mark stands before `marked`."""
    return ['Texture "t0" "%s" "checkerboard"' % kind] + [
        '%sTexture "t%d" "%s" "scale" "float scale" .999 "texture tex" "t%d"' % ("@" * (i == marked), i, kind, i - 1)
        for i in range(1, count)
    ]


def circle(count, marked):
    return ['Texture "t%d" "spectrum" "scale" %s"texture tex" "t%d"' % (i, "@" * (i == marked), (i + 1) % count)
            for i in range(count)]


def doubling(count, marked=None):
    """Each is the mean of the one before and itself: 2^count - 1 evaluations for a look-up of the last."""
    return ['Texture "t0" "spectrum" "checkerboard"'] + [
        '%sTexture "t%d" "spectrum" "mix" "texture tex1" "t%d" "texture tex2" "t%d"' %
        ("@" * (i == marked), i, i - 1, i - 1) for i in range(1, count)
    ]


def commands():
    return [("scene.pbrt", "--outfile", "scene.exr", "--nthreads", "2", "--quiet"), ("info", "scene.pbrt"),
            ("bsdf", "scene.pbrt", "--material", "m", "--wi", "30,0", "--out", "o", "--samples", "1",
             "--resolution", "16", "--quiet")]


def accepted(tool, folder, text):
    write(folder, "scene.pbrt", text)
    for command in commands():
        run(tool, folder, *command)


def refused(tool, folder, text, *says):
    """By one message, which stands at the mark."""
    plain, marks = positions("scene.pbrt", text)
    write(folder, "scene.pbrt", plain)
    for command in commands():
        result = run(tool, folder, *command, status=2)
        messages = [line for line in result.err.splitlines() if "error: " in line]
        assert len(messages) == 1, "%s: %d messages: %s" % (command, len(messages), "\n".join(messages[:5]))
        assert messages[0].startswith("%s:%d:%d: error: " % marks[0]), "%s: not at %s: %s" % (command, marks[0], messages[0])
        for fragment in says:
            assert fragment in messages[0], "%s: does not say %r: %s" % (command, fragment, messages[0])


@check
def chains_of_textures_end_at_the_stated_depth(tool, folder):
    for kind, material in (("spectrum", SPECTRUM), ("float", FLOAT)):
        accepted(tool, folder, scene(chain(MAX_DEPTH, kind), material % (MAX_DEPTH - 1)))
        for count in (MAX_DEPTH + 1, 12000):
            refused(tool, folder, scene(chain(count, kind, MAX_DEPTH), material % (count - 1)),
                    '"t%d"' % MAX_DEPTH, "are %d inside" % (MAX_DEPTH + 1), "at most %d" % MAX_DEPTH)


@check
def chains_of_textures_in_any_order_give_the_same_image(tool, folder):
    lines = chain(MAX_DEPTH)
    digests = set()
    for order in (lines, lines[::-1], lines[1::2] + lines[::2]):
        accepted(tool, folder, scene(order, SPECTRUM % (MAX_DEPTH - 1)))
        digests.add(pixels(folder))
    assert len(digests) == 1, "%d images" % len(digests)
    # The image knows how long the chain is.
    accepted(tool, folder, scene(chain(MAX_DEPTH - 50), SPECTRUM % (MAX_DEPTH - 51)))
    assert pixels(folder) not in digests, "50 textures make no difference"


@check
def circles_of_textures_name_some_members(tool, folder):
    # The place is where the one that stands first in the file is asked for, whoever asks from outside.
    refused(tool, folder, scene(circle(1, 0), SPECTRUM % 0), '"t0" depends on itself')
    refused(tool, folder, scene(circle(2, 1), SPECTRUM % 1), '"t0" depends on itself, by way of "t1"')
    refused(tool, folder, scene(circle(30000, 29999), SPECTRUM % 17),
            '"t0" depends on itself, by way of "t1", "t2", "t3" and 29996 more')


@check
def evaluations_of_shared_textures_are_limited(tool, folder):
    accepted(tool, folder, scene(doubling(16), SPECTRUM % 15))
    assert 2**16 - 1 <= MAX_EVALUATIONS < 2**17 - 1
    for count in (17, 40, 900):
        refused(tool, folder, scene(doubling(count, 16), SPECTRUM % (count - 1)), '"t16"', str(2**17 - 1), str(MAX_EVALUATIONS))


@check
def wide_graphs_of_textures_are_no_deep_ones(tool, folder):
    # 12,000 textures over one: each is two deep.
    lines = ['Texture "base" "float" "checkerboard"']
    lines += ['Texture "t%d" "float" "scale" "texture tex" "base"' % i for i in range(12000)]
    accepted(tool, folder, scene(lines, FLOAT % 11999))


def mixes(count, second):
    """@param second  for material i, the index of its second part; the first one is i - 1"""
    return ['MakeNamedMaterial "m0" "string type" "diffuse"'] + [
        'MakeNamedMaterial "m%d" "string type" "mix" "string materials" ["m%d" "m%d"]' % (i, i - 1, second(i))
        for i in range(1, count)
    ]


@check
def mixes_of_mixes_render(tool, folder):
    for count, second in ((40, lambda i: i - 1), (12000, lambda i: i - 1), (12000, lambda i: 0)):
        # A certain draw of the part that is deepest.
        top = '"string type" "mix" "string materials" ["m%d" "m%d"] "float amount" 0' % (count - 1, count - 1)
        accepted(tool, folder, scene(mixes(count, second), top))


@check
def deep_mixes_go_to_the_last_part(tool, folder):
    """The amounts are 0, so that each draw is the first part, and the image is that of the last one."""
    first = [line + ' "float amount" 0' * (i > 0) for i, line in enumerate(mixes(12000, lambda i: 0))]
    top = '"string type" "mix" "string materials" ["m11999" "m0"] "float amount" 0'
    accepted(tool, folder, scene(first, top))
    deep = pixels(folder)
    accepted(tool, folder, scene(first[:1], '"string type" "diffuse"'))
    assert pixels(folder) == deep, "another image"
    first[0] = 'MakeNamedMaterial "m0" "string type" "diffuse" "rgb reflectance" [.1 .2 .3]'
    accepted(tool, folder, scene(first, top))
    assert pixels(folder) != deep, "the last part makes no difference"


def refused_by_many(tool, folder, text, first):
    """By twenty messages and the note that there may be more: what is not said takes no time either."""
    write(folder, "scene.pbrt", text)
    for command in commands()[:2]:
        result = run(tool, folder, *command, status=2)
        messages = [line for line in result.err.splitlines() if "error: " in line]
        assert len(messages) == 21, "%s: %d messages" % (command, len(messages))
        assert "stopped after 20 errors" in messages[-1], messages[-1]
        assert first in messages[0], messages[0]
        assert 'did you mean "' in messages[-2], messages[-2]


@check
def many_wrong_names_take_no_time(tool, folder):
    """Each is looked for among all others."""
    lines = ['Texture "t%d" "spectrum" "scale" "texture tex" "u%d"' % (i, i) for i in range(12000)]
    refused_by_many(tool, folder, scene(lines, '"string type" "diffuse"'), '"u0"')


@check
def mixes_of_later_materials_take_no_time(tool, folder):
    for count, amount in ((12000, ""), (30000, ' "float amount" 0')):
        # A material that is there, and one of each mix that comes after it: the last one closes the circle.
        lines = ['MakeNamedMaterial "m%d" "string type" "diffuse"' % (count + 1)]
        lines += ['MakeNamedMaterial "m%d" "string type" "mix" "string materials" ["m%d" "m%d"]%s' %
                  (i, count + 1, (i + 1) % count, amount) for i in range(count)]
        refused_by_many(tool, folder, scene(lines, '"string type" "diffuse"'), '"m1"')


@check
def stacks_in_stacks_render(tool, folder):
    lines = ['MakeNamedMaterial "s0" "string type" "conductor"'] + [
        'MakeNamedMaterial "s%d" "string type" "layered" "string stack" ["s%d"]' % (i, i - 1) for i in range(1, 12000)]
    accepted(tool, folder, scene(lines, '"string type" "layered" "string stack" ["s11999"]'))


@check
def mixtures_of_phases_are_limited(tool, folder):
    lines = ['MakeNamedMaterial "p0" "string type" "slab"'] + [
        'MakeNamedMaterial "p%d" "string type" "slab" "string phase" "mixture" %s"string phases" ["p%d" "p%d"]' %
        (i, "@" * (i == 6), i - 1, i - 1) for i in range(1, 7)]
    refused(tool, folder, scene(lines, '"string type" "layered" "string stack" ["" "p6" ""]'),
            "more than 64 phase functions")
