"""Broken scene texts. A @ stands before the place that the message must name; see run.Case."""
import struct

from run import Case

SMALL = ('Film "rgb" "integer xresolution" 8 "integer yresolution" 8 '
         'Sampler "independent" "integer pixelsamples" 1\n')


def world(text):
    """A scene whose world is `text`."""
    return SMALL + 'WorldBegin LightSource "infinite"\n' + text


def options(text):
    """A scene whose options are `text`."""
    return SMALL + text + '\nWorldBegin LightSource "infinite" Shape "sphere"\n'


WORDS = [
    Case("words-empty-file", "", ["scene.pbrt: error:", "WorldBegin"]),
    Case("words-only-comments", "# nothing\n# at all", ["WorldBegin"]),
    Case("words-binary-garbage", bytes((i * 2654435761 >> 7) & 255 for i in range(4000)), ["not a text file"]),
    Case("words-zeros", bytes(1000), ["scene.pbrt:1:1: error:", "not a text file"]),
    Case("words-nul-byte", world('@\0Shape "sphere"'), ["not a text file", "NUL"]),
    Case("words-control-characters", "\1\2\3\4\5\6\x0e\x0f" * 100, ["scene.pbrt:1:1: error:", "not a text file"]),
    Case("words-utf16", b"\xff\xfe" + SMALL.encode("utf-16-le"),
         ["scene.pbrt:1:1: error:", "UTF-16", "UTF-8"]),
    Case("words-byte-order-mark", b"\xef\xbb\xbf" + SMALL.encode(),
         ["scene.pbrt:1:1: error:", "byte-order mark"]),
    Case("words-unterminated-string", world('Shape @"sphere\nShape "disk"'),
         ["unterminated string", '"sphere"']),
    Case("words-unterminated-string-at-end", world('Shape "sphere" @"float rad'),
         ["unterminated string", "file's end"]),
    Case("words-unknown-escape", world(r'Shape @"sph\qere"'), [r"unknown escape \q"]),
    Case("words-unclosed-list", world('Shape "sphere" "float radius" @[ 1\n'), ["never closed"]),
    Case("words-unclosed-list-before-directive", world('Shape "sphere" "float radius" [ 1\n@Shape "disk"'),
         ['"float radius": expected a number, found Shape']),
    Case("words-unknown-directive", world('@Shpae "sphere"'),
         ["unknown directive Shpae", 'did you mean "Shape"?']),
    Case("words-directive-in-wrong-case", world('@shape "sphere"'), ["unknown directive shape", '"Shape"']),
    Case("words-number-for-directive", world('@42\nShape "sphere"'), ["42"]),
    Case("words-string-for-directive", world('Identity @"sphere"'), ["expected a directive", '"sphere"']),
    Case("words-list-for-directive", world('@[ 1 2 ]'), ["expected a directive"]),
    Case("words-missing-plugin-name", world('Shape @sphere'), ["in quotes", "sphere"]),
    Case("words-directive-cut-off", world('@Translate 1 2'), ["Translate", "the file ends", "a number"]),
    Case("words-file-ends-after-name", world('@Texture "a"'), ["Texture", "the file ends"]),
    Case("words-deep-attributes", world("AttributeBegin\n" * 1000000), ["more than", "nested AttributeBegin"],
         errors=1),
    Case("words-deep-brackets", world('Shape "sphere" "float radius" [@' + "[" * 1000000),
         ["expected a number"], errors=(1, 22)),
    Case("words-twenty-five-errors", world('Shape "sphere" "float raduis" 1\n' * 25), ["raduis"],
         errors=(20, 21)),
    Case("words-three-different-errors",
         'Camera "perspective" "float fov" @4O\nWorldBegin\n'
         '@Sahpe "sphere"\nTexture @grass "float" "constant"',
         ["4O", "Sahpe", "grass"]),
    Case("words-long-name", world('@Shape "%s"' % ("x" * 1000000)), ["unknown shape", "..."]),
]

NUMBERS = [
    Case("number-with-suffix", world('Shape "sphere" "float radius" @1.5f'), ["expected a number", "1.5f"]),
    Case("number-nan", world('Shape "sphere" "float radius" @nan'), ["expected a number", "nan"]),
    Case("number-infinite", world('Translate 0 @inf 0'), ["Translate: expected a number", "inf"]),
    Case("number-in-option", 'Option "seed" @3.5\nWorldBegin', ['Option "seed": expected an integer', "3.5"]),
    Case("number-with-comma", world('Translate @1, 2, 3'), ["expected a number", "1,"]),
    Case("number-too-large", world('Shape "sphere" "float radius" @1e39'), ["1e39", "too large"]),
    Case("number-of-a-million-digits", world('Shape "sphere" "float radius" @' + "7" * 1000000),
         ["7777", "too large"]),
    Case("number-million-digit-integer",
         options('Sampler "independent" "integer pixelsamples" @' + "7" * 1000000),
         ["7777", "too large", "integer"]),
    Case("number-integer-overflow", options('Sampler "independent" "integer pixelsamples" @3000000000'),
         ["3000000000", "too large"]),
    Case("number-fraction-for-integer", options('Sampler "independent" "integer pixelsamples" @4.0'),
         ["expected an integer", "4.0"]),
    Case("number-and-string-in-list", world('Shape "sphere" "float radius" [1 @"2"]'),
         ["expected a number", '"2"']),
    Case("number-string-for-float", world('Shape "sphere" @"float radius" "big"'),
         ['"float radius"', "a number"]),
    Case("number-number-for-string", world('Material "diffuse" @"string normalmap" 3'),
         ['"string normalmap"', "a string"]),
    Case("number-quoted-bool", world('AreaLightSource "diffuse" @"bool twosided" "true"\nShape "sphere"'),
         ["without quotes"]),
    Case("number-empty-list", world('Shape "sphere" @"float radius" []'), ['"float radius"', "no values"]),
    Case("number-missing-value", world('Shape "sphere" "float radius"\n@Shape "disk"'), ["Shape"]),
]

PARAMETERS = [
    Case("parameter-one-word", world('Shape "sphere" @"radius" 1'), ['"radius"', '"type name"']),
    Case("parameter-three-words", world('Shape "sphere" @"float the radius" 1'),
         ['"float the radius"', '"type name"']),
    Case("parameter-blank", world('Shape "sphere" @" " 1'), ["blank"]),
    Case("parameter-unknown-type", world('Shape "sphere" @"flaot radius" 1'), ['"flaot"', '"float"']),
    Case("parameter-unknown", world('Shape "sphere" @"float raduis" 2'),
         ['"float raduis"', 'did you mean "radius"?']),
    Case("parameter-unknown-without-neighbour", world('Shape "sphere" @"float temperature" 2'),
         ['sphere', '"float temperature"']),
    Case("parameter-wrong-type", world('Shape "sphere" @"integer radius" 2'),
         ['"integer radius"', '"float radius"']),
    Case("parameter-two-unknown", world('Shape "sphere" @"float raduis" 2\n  @"float zmni" 0'),
         ['"radius"', '"zmin"']),
    Case("parameter-two-values", world('Shape "sphere" @"float radius" [1 2]'),
         ['"float radius"', "1 value", "has 2"]),
    Case("parameter-point-of-two", world('LightSource "point" @"point3 from" [0 1]'),
         ['"point3 from"', "3 values", "has 2"]),
    Case("parameter-on-unused-texture", world('Texture "t" "float" "scale" @"float scael" 2'),
         ['"float scael"', '"scale"']),
    Case("parameter-on-material", world('Material "diffuse" @"rgb reflectence" [1 1 1]\nShape "sphere"'),
         ['"reflectance"']),
    Case("parameter-on-area-light",
         world('AreaLightSource "diffuse" @"rgb l" [1 1 1]\nShape "sphere" Shape "disk"'), ['"L"']),
    Case("parameter-on-camera", options('Camera "perspective" @"float fow" 40'), ['"fov"']),
    Case("parameter-on-film", options('Film "rgb" @"integer xres" 40'), ['"integer xres"', 'film "rgb"']),
    Case("parameter-on-accelerator", options('Accelerator "bvh" @"integer maxnodeprim" 4'),
         ['"maxnodeprims"']),
    Case("parameter-spectrum-in-two-forms",
         world('Material "diffuse" @"rgb reflectance" [1 1 1] "spectrum reflectance" [400 1 700 1]'),
         ['"rgb reflectance"']),
]

PLUGINS = [
    Case("plugin-" + name, text, [kind + ' "' + word + '"', near]) for name, kind, word, near, text in [
        ("camera", "unknown camera", "perspectve", '"perspective"', options('@Camera "perspectve"')),
        ("film", "unknown film", "rbg", '"rgb"', options('@Film "rbg"')),
        ("sampler", "unknown sampler", "haltn", '"halton"', options('@Sampler "haltn"')),
        ("filter", "unknown pixel filter", "gausian", '"gaussian"', options('@PixelFilter "gausian"')),
        ("integrator", "unknown integrator", "paht", '"path"', options('@Integrator "paht"')),
        ("accelerator", "unknown accelerator", "bhv", '"bvh"', options('@Accelerator "bhv"')),
        ("light", "unknown light", "infinte", '"infinite"', world('@LightSource "infinte"')),
        ("area-light", "unknown area light", "difuse", '"diffuse"',
         world('@AreaLightSource "difuse" Shape "sphere"')),
        ("material", "unknown material", "difuse", '"diffuse"', world('@Material "difuse" Shape "sphere"')),
        ("texture", "unknown float texture", "checkerbord", '"checkerboard"',
         world('@Texture "a" "float" "checkerbord"')),
        ("spectrum-texture", "unknown spectrum texture", "imgemap", '"imagemap"',
         world('@Texture "a" "spectrum" "imgemap"')),
        ("shape", "unknown shape", "shpere", '"sphere"', world('@Shape "shpere"')),
    ]
] + [
    Case("never-ptex-" + kind, world('@Texture "p" "%s" "ptex" "string filename" "x.ptx"' % kind),
         ["ptex", "not supported", "imagemap"]) for kind in ("float", "spectrum")
]

LAYERS = """MakeNamedMaterial "coat" "string type" "dielectric" "float roughness" 0.1
MakeNamedMaterial "varnish" "string type" "slab" "rgb sigma_t" [1 1 1]
MakeNamedMaterial "metal" "string type" "conductor"
MakeNamedMaterial "either" "string type" "mix" "string materials" ["coat" "metal"]
"""

# Bad stacks, and bad slabs in them.
STACKS = [
    Case("stack-" + name, world(LAYERS + 'Material "layered" @"string stack" %s\nShape "sphere"' % stack), says)
    for name, stack, says in [
        ("empty", "[]", ["outermost first"]),
        ("opaque-above", '["metal" "varnish" "metal"]', ["entry 1", '"metal"', "no light through"]),
        ("slab-first", '["varnish" "metal"]', ["entry 1", '"varnish"', "slab"]),
        ("slab-last", '["coat" "varnish"]', ["entry 2", '"varnish"', "slab"]),
        ("slab-alone", '["varnish"]', ["entry 1", '"varnish"', "slab"]),
        ("two-slabs", '["coat" "varnish" "varnish" "metal"]', ["entry 3", '"varnish"', "between the two"]),
        ("unknown-name", '["coat" "varnsh" "metal"]', ["entry 2", '"varnsh"', '"varnish"?']),
        ("mixture", '["coat" "either"]', ["entry 2", '"either"', "mix whole layered materials"]),
        ("too-long", "[" + ' "coat"' * 100_000 + "]", ["64 interfaces"]),
    ]
] + [
    Case("stack-" + name, world(LAYERS + text), says) for name, text, says in [
        ("contains-itself", 'MakeNamedMaterial "s" "string type" "layered" @"string stack" ["coat" "s"]',
         ['material "s"', "entry 2", "the material itself"]),
        ("cycle", 'MakeNamedMaterial "a" "string type" "layered" @"string stack" ["coat" "b"]\n'
         'MakeNamedMaterial "b" "string type" "layered" "string stack" ["coat" "a"]',
         ['material "a"', "entry 2", '"b"', "stands before it"]),
        ("without-stack", '@Material "layered" Shape "sphere"', ['"string stack"']),
        ("estimator", 'Material "layered" "string stack" ["coat" "metal"] @"string estimator" "bidirectinal"',
         ['"bidirectinal"', '"bidirectional"?']),
        ("pdf", 'Material "coateddiffuse" @"string pdf" "unbiassed"', ['"unbiassed"', '"unbiased"?']),
        ("nsamples", 'Material "coateddiffuse" @"integer nsamples" 0', ["nsamples", "[1, "]),
        ("maxdepth", 'Material "layered" "string stack" ["coat" "metal"] @"integer maxdepth" -1', ["maxdepth"]),
        ("of-broken-layers", 'MakeNamedMaterial "thin" "string type" "slab" @"float thickness" -1\n'
         'Material "layered" "string stack" ["coat" "thin" "metal"] Shape "sphere"', ["thickness", "-1"]),
        ("slab-as-surface", '@Material "slab" Shape "sphere"', ["slab", "has no surface", '"layered"']),
        ("named-slab-as-surface", 'NamedMaterial "varnish" @Shape "sphere"',
         ['"varnish"', "has no surface", '"layered"']),
        ("slab-albedo", 'Material "slab" @"rgb albedo" [0.5 1.5 0.5]', ["1.5", "[0, 1]"]),
        ("slab-phase", 'Material "slab" @"string phase" "henyey"', ['"henyey"', '"hg"']),
        ("slab-foreign-parameter", 'Material "slab" "string phase" "hg" @"float kappa" 3',
         ['"kappa"', '"hg"', '"vmf"']),
        ("slab-orientation", 'Material "slab" "string phase" "sggx" @"vector3 orientation" [0 0 0]',
         ["no length"]),
        ("slab-weights", 'Material "slab" "string phase" "mixture" "string phases" ["varnish"] '
         '@"float weights" [1 2]', ["2 values for 1"]),
        ("slab-mixes-no-slab", 'Material "slab" "string phase" "mixture" @"string phases" ["coat"]',
         ['"coat"', "no slab"]),
        ("slab-table", 'Material "slab" "string phase" "table" @"float table" [1 2 -1]', ["-1", "negative"]),
    ]
]

# Each mixes the one before twice: a thousand phase functions at every hit, but for the limit.
DEEP_MIXTURE = Case(
    "stack-deep-mixture",
    world('MakeNamedMaterial "m0" "string type" "slab"\n' +
          "".join('MakeNamedMaterial "m%d" "string type" "slab" "string phase" "mixture" "string phases" '
                  '["m%d" "m%d"]\n' % (i, i - 1, i - 1) for i in range(1, 12))),
    ["more than 64 phase functions"], errors=(1, 11))

NAMES = STACKS + [DEEP_MIXTURE] + [
    Case("name-undefined-material",
         world('MakeNamedMaterial "gold" "string type" "conductor"\n@NamedMaterial "golt"\nShape "sphere"'),
         ['"golt"', "not defined", '"gold"']),
    Case("name-material-twice",
         world('MakeNamedMaterial "a" "string type" "diffuse"\n'
               '@MakeNamedMaterial "a" "string type" "diffuse"'),
         ['"a"', "already defined at scene.pbrt:3:1"]),
    Case("name-texture-twice", world('Texture "a" "float" "constant"\n@Texture "a" "float" "constant"'),
         ["already defined"]),
    Case("name-object-twice", world('ObjectBegin "a" ObjectEnd\n@ObjectBegin "a" ObjectEnd'),
         ["already defined"]),
    Case("name-undefined-object", world('@ObjectInstance "tree"'), ['object "tree" is not defined']),
    Case("name-undefined-medium", world('@MediumInterface "fog" ""\nShape "sphere"'),
         ['medium "fog" is not defined']),
    Case("name-unknown-colour-space", world('@ColorSpace "sgrb"'), ['"sgrb"', '"srgb"']),
    Case("name-unknown-option", options('@Option "sede" 3'), ['"sede"', '"seed"']),
    Case("name-option-value", options('Option "disablepixeljitter" @"true"'),
         ["true or false without quotes"]),
    Case("name-option-coordinates", options('Option "rendercoordsys" @"object"'),
         ['"cameraworld"', '"object"']),
    Case("name-option-coordinates-misspelt", options('Option "rendercoordsys" @"wrold"'),
         ['"wrold"', 'did you mean "world"?']),
    Case("name-attribute-target", world('@Attribute "shapes" "float alpha" 0.5'), ['"shapes"', '"shape"']),
    Case("name-material-without-type", world('@MakeNamedMaterial "a" "rgb reflectance" [1 1 1]'),
         ['"string type"']),
    Case("name-texture-value-type", world('@Texture "a" "colour" "constant"'),
         ['"colour"', '"float" or "spectrum"']),
    Case("name-missing-texture",
         world('Texture "wood" "spectrum" "constant" "rgb value" [.5 .5 .5]\n'
               'Material "diffuse" @"texture reflectance" "wod"\nShape "sphere"'),
         ['"wod"', '"wood"']),
    Case("name-float-texture-for-spectrum",
         world('Texture "f" "float" "constant"\nMaterial "diffuse" @"texture reflectance" "f"'),
         ['"f"', "spectrum texture is expected"]),
    Case("name-texture-depends-on-itself", world('Texture "a" "float" "scale" @"texture tex" "a"'),
         ['"a" depends on itself']),
    Case("name-texture-cycle",
         world('Texture "a" "float" "scale" "texture tex" "b"\n'
               'Texture "b" "float" "scale" @"texture tex" "a"'),
         ['"a" depends on itself, by way of "b"']),
    Case("name-spectrum-texture-cycle",
         world('Texture "a" "spectrum" "mix" "texture tex1" "b"\n'
               'Texture "b" "spectrum" "mix" @"texture tex2" "a"'),
         ['"a" depends on itself, by way of "b"']),
    Case("name-mix-of-itself",
         world('MakeNamedMaterial "m" "string type" "mix" @"string materials" ["m" "m"]'), ['"m"']),
    Case("name-mix-cycle",
         world('MakeNamedMaterial "a" "string type" "mix" @"string materials" ["b" "b"]\n'
               'MakeNamedMaterial "b" "string type" "mix" "string materials" ["a" "a"]'),
         ['"b"']),
    Case("name-mix-of-three",
         world('MakeNamedMaterial "a" "string type" "diffuse"\n'
               'Material "mix" @"string materials" ["a" "a" "a"]'),
         ['"materials" has 3 names']),
    Case("name-mix-of-broken",
         world('MakeNamedMaterial "a" "string type" "diffuse" @"rgb reflectance" [2 0 0]\n'
               'MakeNamedMaterial "b" "string type" "diffuse"\n'
               'Material "mix" "string materials" ["a" "b"] Shape "sphere"'),
         ["[0, 1]"]),
    Case("name-mix-of-broken-mix",
         world('MakeNamedMaterial "a" "string type" "diffuse"\n'
               'MakeNamedMaterial "m" "string type" "mix" @"string materials" ["a" "aa"]\n'
               'Material "mix" "string materials" ["m" "a"] Shape "sphere"'),
         ['"aa"', '"a"']),
]

BLOCKS = [
    Case("block-no-world", SMALL, ["scene.pbrt: error:", "WorldBegin"]),
    Case("block-shape-before-world", '@Shape "sphere"\nWorldBegin',
         ["Shape is not allowed before WorldBegin"]),
    Case("block-film-in-world", world('@Film "rgb" "integer xresolution" 4'),
         ["Film is not allowed after WorldBegin"]),
    Case("block-world-twice", world('@WorldBegin'), ["WorldBegin is not allowed after WorldBegin"]),
    Case("block-attribute-not-closed", world('@AttributeBegin\nShape "sphere"'),
         ["AttributeBegin is never closed"]),
    Case("block-attribute-not-begun", world('Shape "sphere"\n@AttributeEnd'),
         ["AttributeEnd without AttributeBegin"]),
    Case("block-object-not-closed", world('@ObjectBegin "a"\nShape "sphere"'),
         ["ObjectBegin is never closed"]),
    Case("block-object-not-begun", world('@ObjectEnd'), ["ObjectEnd without ObjectBegin"]),
    Case("block-crossed", world('ObjectBegin "a"\n@AttributeEnd\nObjectEnd'),
         ["AttributeEnd", "ObjectBegin at scene.pbrt:3:1"]),
    Case("block-nested-objects", world('ObjectBegin "a"\n@ObjectBegin "b"\nObjectEnd'), ["do not nest"],
         errors=1),
    Case("block-instance-in-object",
         world('ObjectBegin "b" ObjectEnd\nObjectBegin "a"\n@ObjectInstance "b"\nObjectEnd'),
         ['inside of the definition of "a"']),
    Case("block-v3-scene",
         '@Film "image" "integer xresolution" 8\nWorldBegin\n@Material "matte" "rgb Kd" [.5 .5 .5]\n'
         'Shape "sphere"\n@WorldEnd', ["pbrt-v3 scene", '"rgb"', '"diffuse"', "WorldEnd"]),
    Case("block-v3-type", world('LightSource "point" @"point from" [0 0 0] @"color I" [1 1 1]'),
         ["pbrt-v3", '"point3"', '"rgb"']),
]

TRANSFORMS = [
    Case("transform-scale-zero", world('Scale 1 0 1\n@Shape "sphere"'), ["singular since scene.pbrt:3:1"]),
    Case("transform-singular-matrix", world('ConcatTransform [1 0 0 0  1 0 0 0  0 0 1 0  0 0 0 1]\n@LightSource "point"'),
         ["singular"]),
    Case("transform-singular-texture", world('Scale 0 1 1\n@Texture "t" "float" "fbm"'), ["singular"]),
    Case("transform-singular-medium", world('Scale 0 1 1\n@MakeNamedMedium "m" "string type" "cloud"'), ["singular"]),
    Case("transform-fifteen-numbers", world('Transform [1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 @]'),
         ["16 numbers", "15"]),
    Case("transform-seventeen-numbers", world('Transform [1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1 @1]'),
         ["expected ]"]),
    Case("transform-without-brackets", world('Transform @1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1'),
         ["expected ["]),
    Case("transform-overflow", world('Scale 1e30 1e30 1e30\nScale 1e30 1e30 1e30\n@Shape "sphere"'),
         ["range of floats"]),
    Case("transform-underflow", world('Scale 1e-30 1e-30 1e-30\nScale 1e-30 1e-30 1e-30\n@Shape "sphere"'),
         ["range of floats"]),
    Case("transform-zero-axis", world('Rotate 90 0 0 0\n@Shape "sphere"'), ["singular since scene.pbrt:3:1"]),
    Case("transform-look-at-itself", options('@LookAt 1 2 3  1 2 3  0 1 0'), ["must differ"]),
    Case("transform-look-along-up", options('@LookAt 0 0 0  0 5 0  0 1 0'), ["parallel"]),
    Case("transform-times-reversed", options('@TransformTimes 1 0'), ["start 1", "end 0"]),
    Case("transform-active-word", world('ActiveTransform @Both'), ["StartTime", "Both"]),
    Case("transform-moving-light",
         world('AreaLightSource "diffuse"\nActiveTransform EndTime Translate 1 0 0\n@Shape "sphere"'),
         ["moving shape cannot be an area light"]),
    Case("transform-huge-sphere", world('Scale 1e20 1e20 1e20\n@Shape "sphere" "float radius" 1e30'),
         ['"sphere"', "too large"]),
    Case("transform-huge-mesh",
         world('Scale 1e10 1e10 1e10\nShape "trianglemesh" @"point3 P" [0 0 0 1e38 0 0 0 1e38 0]'),
         ["too large"]),
]

SPECTRA = [
    Case("spectrum-odd-count", world('Material "diffuse" @"spectrum reflectance" [400 1 500]'),
         ["pairs", "3"]),
    Case("spectrum-unordered", world('Material "diffuse" @"spectrum reflectance" [500 1 400 1]'),
         ["increase", "400 follows 500"]),
    Case("spectrum-negative", world('Material "diffuse" @"spectrum reflectance" [400 1 500 -1]'),
         ["-1", "negative"]),
    Case("spectrum-negative-wavelength", world('Material "diffuse" @"spectrum reflectance" [-400 1 500 1]'),
         ["-400"]),
    Case("spectrum-unknown-name", world('Material "conductor" @"spectrum eta" "metal-Au-eat"'),
         ['"metal-Au-eat"', '"metal-Au-eta"']),
    Case("spectrum-two-names", world('Material "conductor" @"spectrum eta" ["metal-Au-eta" "metal-Au-k"]'),
         ["1 name", "has 2"]),
    Case("spectrum-rgb-above-one",
         world('Material "diffuse" @"rgb reflectance" [0.5 1.2 0.5]\nShape "sphere"'), ["1.2", "[0, 1]"]),
    Case("spectrum-rgb-negative", world('LightSource "point" @"rgb I" [1 -1 1]'), ["-1", "negative"]),
    Case("spectrum-rgb-of-two", world('Material "diffuse" @"rgb reflectance" [1 1]'), ["3 values", "has 2"]),
    Case("spectrum-cold-blackbody", world('LightSource "point" @"blackbody I" 0'), ["temperature"]),
    Case("spectrum-hot-blackbody", world('LightSource "point" @"blackbody I" 1e30'), ["temperature"]),
    Case("spectrum-float-for-spectrum", world('Material "diffuse" @"float reflectance" 0.5'),
         ['"float reflectance"', '"rgb reflectance"']),
]

RANGES = [
    Case("range-film-two-billion-wide", options('Film "rgb" @"integer xresolution" 2000000000'),
         ["xresolution", "2000000000"]),
    Case("range-film-four-gigapixels",
         options('Film "rgb" @"integer xresolution" 65536 "integer yresolution" 65536'), ["65536 x 65536"]),
    Case("range-film-no-pixels", options('Film "rgb" @"integer yresolution" 0'), ["yresolution", "0"]),
    Case("range-film-negative", options('Film "rgb" @"integer xresolution" -5'), ["xresolution", "-5"]),
    Case("range-film-empty-crop", options('Film "rgb" @"float cropwindow" [0.5 0.5 0 1]'),
         ["cropwindow", "no pixel"]),
    Case("range-film-crop-of-three", options('Film "rgb" @"float cropwindow" [0 1 0]'),
         ["cropwindow", "3", "four"]),
    Case("range-film-bounds-outside", options('Film "rgb" @"integer pixelbounds" [5000 5001 0 1]'),
         ["pixelbounds", "no pixel"]),
    Case("range-film-sensor-name", options('Film "rgb" @"string sensor" "nikon_d580"'),
         ['"nikon_d580"', 'did you mean "nikon_d8']),
    Case("range-film-sensor-balance", options('Film "rgb" "string sensor" "nikon_d850" @"float whitebalance" 1e6'),
         ["whitebalance", "25000"]),
    Case("range-film-spectral-low", options('Film "spectral" @"float lambdamin" 300'), ["lambdamin", "360"]),
    Case("range-film-spectral-high", options('Film "spectral" @"float lambdamax" 1e30'), ["lambdamax", "830"]),
    Case("range-film-spectral-order", options('Film "spectral" "float lambdamin" 600 @"float lambdamax" 500'),
         ["500", "600", "larger"]),
    Case("range-film-spectral-buckets", options('Film "spectral" @"integer nbuckets" 2000000000'), ["nbuckets", "512"]),
    Case("range-film-spectral-none", options('Film "spectral" @"integer nbuckets" 0'), ["nbuckets", "0"]),
    Case("range-film-spectral-memory",
         options('Film "spectral" "integer xresolution" 5000 "integer yresolution" 5000 @"integer nbuckets" 512'),
         ["crop windows"]),
    Case("range-film-spectral-png", options('Film "spectral" @"string filename" "a.png"'), ["a.png", "EXR"]),
    Case("range-film-maximum", options('Film "rgb" @"float maxcomponentvalue" -1'),
         ["maxcomponentvalue", "-1"]),
    Case("range-film-iso", options('Film "rgb" @"float iso" -100'), ["iso", "-100"]),
    Case("range-film-white-balance", options('Film "rgb" @"float whitebalance" 40'), ["whitebalance", "40"]),
    Case("range-filter-two-billion-wide", options('PixelFilter "box" @"float xradius" 2000000000'),
         ["xradius"]),
    Case("range-filter-negative", options('PixelFilter "gaussian" @"float yradius" -1'), ["yradius", "-1"]),
    Case("range-filter-zero-sigma", options('PixelFilter "gaussian" @"float sigma" 0'), ["sigma"]),
    Case("range-filter-sinc", options('PixelFilter "sinc" @"float tau" 1e30'), ["tau"]),
    Case("range-sampler-two-billion", options('Sampler "zsobol" @"integer pixelsamples" 2000000000'),
         ["pixelsamples", "2000000000"]),
    Case("range-sampler-pmj02bn", options('Sampler "pmj02bn" @"integer pixelsamples" 65537'),
         ["65537", "65536", "pmj02bn"]),
    Case("range-sampler-pmj02bn-randomization", options('Sampler "pmj02bn" @"string randomization" "owen"'),
         ['"string randomization"']),
    Case("range-sampler-none", options('Sampler "halton" @"integer pixelsamples" 0'), ["pixelsamples", "0"]),
    Case("range-sampler-strata",
         options('Sampler "stratified" @"integer xsamples" 65536 "integer ysamples" 65536'),
         ["xsamples times ysamples"]),
    Case("range-sampler-randomization", options('Sampler "sobol" @"string randomization" "own"'),
         ['"owen"', '"own"']),
    Case("range-camera-fov-zero", options('Camera "perspective" @"float fov" 0'), ["fov", "0"]),
    Case("range-camera-fov-huge", options('Camera "perspective" @"float fov" 1e30'), ["fov", "180"]),
    Case("range-camera-shutter",
         options('Camera "perspective" "float shutteropen" 2 @"float shutterclose" 1'), ["shutter"]),
    Case("range-camera-lens", options('Camera "perspective" @"float lensradius" -1'), ["lensradius", "-1"]),
    Case("range-camera-focus", options('Camera "perspective" "float lensradius" 1 @"float focaldistance" 0'), ["focaldistance"]),
    Case("range-camera-window", options('Camera "orthographic" @"float screenwindow" [0 1 0]'),
         ["screenwindow", "3", "four"]),
    Case("range-camera-aspect", options('Camera "perspective" @"float frameaspectratio" 0'),
         ["frameaspectratio"]),
    Case("range-integrator-depth", options('Integrator "path" @"integer maxdepth" -1'), ["maxdepth", "-1"]),
    Case("range-integrator-distance", options('Integrator "ambientocclusion" @"float maxdistance" 0'),
         ["maxdistance", "positive"]),
    Case("range-integrator-images", options('Integrator "bdpt" @"bool visualizeweights" true'),
         ["single strategies"]),
    Case("range-integrator-camera", 'Camera "orthographic"\n@Integrator "lightpath"\nWorldBegin\nShape "sphere"',
         ["lightpath", "perspective camera only"]),
    Case("range-integrator-mlt", options('Integrator "mlt" @"integer chain" 3'), ["chain"], warns=True),
    Case("range-integrator-lights", options('Integrator "path" @"string lightsampler" "spatial"'),
         ['"spatial"', '"bvh"']),
    Case("range-light-same-points", world('LightSource "spot" "point3 from" [1 1 1] @"point3 to" [1 1 1]'),
         ["differ"]),
    Case("range-light-scale", world('LightSource "point" @"float scale" -1'), ["scale", "-1"]),
    Case("range-light-cone", world('LightSource "spot" @"float coneangle" 1e9'), ["angle", "180"]),
    Case("range-light-portal", world('LightSource "infinite" @"point3 portal" [0 0 0 1 0 0 1 1 0]'),
         ["four corners", "3"]),
    Case("range-camera-mapping", options('Camera "spherical" @"string mapping" "equalrectangular"'),
         ['"equalrectangular"', 'did you mean "equirectangular"?']),
    Case("range-camera-spherical-fov", options('Camera "spherical" @"float fov" 90'), ['"float fov"']),
    Case("range-camera-spherical-shutter", options('Camera "spherical" @"float shutterclose" 0'), ["shutter"]),
    Case("number-too-large-roughness", world('Material "conductor" "float roughness" @1e39'), ["too large"]),
    Case("range-material-index", world('Material "dielectric" @"float eta" -1.5\nShape "sphere"'),
         ["eta", "-1.5"]),
    Case("range-material-distribution",
         world('Material "conductor" @"string distribution" "ggx"\nShape "sphere"'), ['"ggx"', '"beckmann"']),
    Case("range-subsurface-name", world('Material "subsurface" @"string name" "Skin"\nShape "sphere"'),
         ['"Skin"', 'did you mean "Skin1"?']),
    Case("range-subsurface-half", world('Material "subsurface" @"rgb sigma_s" [1 1 1]\nShape "sphere"'),
         ['without "sigma_a"', "both or neither"]),
    Case("range-subsurface-g", world('Material "subsurface" @"float g" 1.5\nShape "sphere"'), ['"float g"', "1.5"]),
    Case("range-subsurface-index", world('Material "subsurface" @"float eta" 3\nShape "sphere"'),
         ['"float eta"', "2.5"]),
    Case("range-subsurface-scale", world('Material "subsurface" @"float scale" -1\nShape "sphere"'),
         ['"float scale"', "-1"]),
    Case("range-subsurface-reflectance",
         world('Material "subsurface" @"rgb reflectance" [2 0 0]\nShape "sphere"'), ["reflectance"]),
    Case("range-conductor-both-forms",
         world('Material "conductor" @"rgb reflectance" [.9 .9 .9] "spectrum eta" "metal-Au-eta"'),
         ["either"]),
    Case("range-texture-dimension", world('Texture "a" "float" "checkerboard" @"integer dimension" 4'),
         ["dimension", "2 or 3"]),
    Case("range-texture-mapping", world('Texture "a" "float" "checkerboard" @"string mapping" "sphere"'),
         ['"spherical"']),
    Case("range-texture-octaves", world('Texture "a" "float" "fbm" @"integer octaves" -2'),
         ["octaves", "-2"]),
    Case("range-image-without-name", world('@Texture "a" "float" "imagemap"'), ['"string filename"']),
    Case("range-sphere-radius", world('Shape "sphere" @"float radius" -2'), ["radius", "-2"]),
    Case("range-sphere-empty", world('Shape "sphere" @"float zmin" 0.5 "float zmax" 0.5'),
         ["nothing is left"]),
    Case("range-disk-hole", world('Shape "disk" "float radius" 1 @"float innerradius" 2'), ["innerradius"]),
    Case("range-curve-without-points", world('@Shape "curve"'), ['"point3 P"']),
    Case("range-curve-five-points", world('Shape "curve" @"point3 P" [0 0 0 1 0 0 1 1 0 0 1 0 2 2 2]'),
         ["5 points", "degree 3", "4, 7, 10"]),
    Case("range-curve-three-spline-points",
         world('Shape "curve" "string basis" "bspline" @"point3 P" [0 0 0 1 0 0 1 1 0]'),
         ["3 points", "at least 4"]),
    Case("range-curve-point-of-two", world('Shape "curve" @"point3 P" [0 0 0 1 0 0 1 1 0 0 1]'),
         ["multiple of 3"]),
    Case("range-curve-degree", world('Shape "curve" @"integer degree" 4 "point3 P" [0 0 0 1 0 0 1 1 0 0 1 0]'),
         ["degree", "4", "[2, 3]"]),
    Case("range-curve-type",
         world('Shape "curve" @"string type" "cylindre" "point3 P" [0 0 0 1 0 0 1 1 0 0 1 0]'),
         ['"cylindre"', '"cylinder"']),
    Case("range-curve-basis",
         world('Shape "curve" @"string basis" "b-spline" "point3 P" [0 0 0 1 0 0 1 1 0 0 1 0]'),
         ['"b-spline"', '"bspline"']),
    Case("range-curve-width", world('Shape "curve" "point3 P" [0 0 0 1 0 0 1 1 0 0 1 0] @"float width1" -0.1'),
         ["width1", "-0.1", "at least 0"]),
    Case("range-curve-ribbon-without-normals",
         world('@Shape "curve" "string type" "ribbon" "point3 P" [0 0 0 1 0 0 1 1 0 0 1 0]'),
         ["0 normals", "has 2"]),
    Case("range-curve-ribbon-normal-count",
         world('Shape "curve" "string type" "ribbon" "point3 P" [0 0 0 1 0 0 1 1 0 0 1 0] '
               '@"normal N" [0 0 1]'), ["1 normals", "has 2"]),
    Case("range-curve-too-large",
         world('@Shape "curve" "point3 P" [0 0 0 1e20 0 0 1 1 0 0 1 0]'), ["too large"]),
    Case("range-curve-area-light",
         world('AreaLightSource "diffuse"\n@Shape "curve" "point3 P" [0 0 0 1 0 0 1 1 0 0 1 0]'),
         ["a curve cannot be an area light"]),
    Case("range-hair-displacement",
         world('Texture "d" "float" "constant"\nMaterial "hair" @"texture displacement" "d"\nShape "sphere"'),
         ["displacement"]),
    Case("range-hair-reflectance", world('Material "hair" @"rgb reflectance" [1.2 1 1]\nShape "sphere"'),
         ["1.2"]),
    Case("range-hair-sigma", world('Material "hair" @"rgb sigma_a" [-1 1 1]\nShape "sphere"'), ["-1"]),
    Case("range-hair-misspelt", world('Material "hair" @"float eumelanine" 1\nShape "sphere"'),
         ['"eumelanin"']),
    Case("range-mesh-without-points", world('@Shape "trianglemesh" "integer indices" [0 1 2]'),
         ['"point3 P"']),
    Case("range-mesh-index-too-large",
         world('Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0] @"integer indices" [0 1 3]'),
         ["element 2", "is 3", "[0, 2]"]),
    Case("range-mesh-index-negative",
         world('Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0] @"integer indices" [0 -1 2]'), ["is -1"]),
    Case("range-mesh-four-indices",
         world('Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0] @"integer indices" [0 1 2 0]'),
         ["multiple of 3"]),
    Case("range-mesh-normal-count",
         world('Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0] @"normal N" [0 0 1]'), ['"N"',
                                                                                            "3 vertices"]),
    Case("range-mesh-uv-count",
         world('Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0] @"point2 uv" [0 0 1 0]'), ['"uv"']),
    Case("range-mesh-point-of-four", world('Shape "trianglemesh" @"point3 P" [0 0 0 1 0 0 0 1 0 5]'),
         ["multiple of 3", "10"]),
    Case("range-loopsubdiv-edge-of-three", world('Shape "loopsubdiv" "point3 P" [0 0 0 1 0 0 0 1 0 0 -1 0 0 0 1]\n'
                                                 '@"integer indices" [0 1 2 1 0 3 0 1 4]'),
         ["3 triangles", "vertices 0 and 1", "at most two"]),
    Case("range-loopsubdiv-turned", world('Shape "loopsubdiv" "point3 P" [0 0 0 1 0 0 0 1 0 0 -1 0]\n'
                                          '@"integer indices" [0 1 2 0 1 3]'),
         ["from 0 to 1", "wound in the same sense"]),
    Case("range-loopsubdiv-index",
         world('Shape "loopsubdiv" "point3 P" [0 0 0 1 0 0 0 1 0] @"integer indices" [0 1 3]'),
         ["element 2", "is 3", "[0, 2]"]),
    Case("range-loopsubdiv-levels",
         world('Shape "loopsubdiv" "point3 P" [0 0 0 1 0 0 0 1 0] "integer indices" [0 1 2] @"integer levels" 20'),
         ["[0, 12]"]),
    Case("range-loopsubdiv-crowded",
         world('Shape "loopsubdiv" "point3 P" [0 0 0 ' + " ".join("%d 1 0" % i for i in range(33000)) +
               ']\n@"integer indices" [' + " ".join("0 %d %d" % (i, i + 1) for i in range(1, 33000)) + "]"),
         ["32999 triangles", "vertex 0", "at most 32767"]),
    Case("range-patch-five-points", world('@Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0 2 2 2]'),
         ["indices"]),
    Case("range-ply-without-name", world('@Shape "plymesh"'), ['"string filename"']),
]


def pfm(width, height, value=0.5, channels=3):
    return b"%s\n%d %d\n-1.0\n" % (b"PF" if channels == 3 else b"Pf", width, height) + struct.pack(
        "<f", value) * (width * height * channels)


def lamp(name, light, parameters, image, says, status=2):
    """A light with an image, i.pfm. @ in `parameters` or, if there is none, before the file's name."""
    mark = "" if "@" in parameters else "@"
    text = 'LightSource "%s" %s %s"string filename" "i.pfm"' % (light, parameters, mark)
    return Case("lamp-" + name, world(text), says, status, files={} if image is None else {"i.pfm": image})


LAMPS = [
    lamp(light + "-" + name, light, parameters, image, says, status)
    for light in ["goniometric", "projection"] for name, parameters, image, says, status in [
        ("missing", "", None, ["i.pfm", "there is no such file"], 3),
        ("text", "", b"this is no image", ["i.pfm", "not an image"], 2),
        ("truncated", "", pfm(4, 4)[:100], ["i.pfm", "damaged"], 2),
        ("nan", "", pfm(4, 4, float("nan")), ["pixel (0, 0) is not a finite number"], 2),
        ("infinite", "", pfm(4, 4, float("inf")), ["pixel (0, 0) is not a finite number"], 2),
        ("negative-scale", '@"float scale" -1', pfm(4, 4), ["scale", "-1"], 2),
        ("black", '@"float power" 5', pfm(4, 4, 0), ["the image is black"], 2),
        ("too-bright", '"float scale" 1e30', pfm(4, 4, 1e30), ["must be finite"], 2),
        ("misspelt", '@"float powr" 5', pfm(4, 4), ['"float powr"', '"power"'], 2),
        ("from", '@"point3 from" [0 1 0]', pfm(4, 4), ['"point3 from"', light], 2),
    ]
] + [
    lamp("goniometric-not-square", "goniometric", "", pfm(8, 4), ["i.pfm", "square", "8 x 4"]),
    lamp("goniometric-negative-colour", "goniometric", '@"rgb I" [1 -1 1]', pfm(4, 4), ["-1", "negative"]),
    lamp("projection-grey", "projection", "", pfm(4, 4, channels=1), ["i.pfm", "R, G and B"]),
    lamp("projection-fov-zero", "projection", '@"float fov" 0', pfm(4, 4), ["fov", "0 and 180"]),
    lamp("projection-fov-huge", "projection", '@"float fov" 1e30', pfm(4, 4), ["fov", "0 and 180"]),
    lamp("projection-intensity", "projection", '@"rgb I" [1 1 1]', pfm(4, 4), ['"rgb I"']),
    Case("lamp-goniometric-without-name", world('@LightSource "goniometric"'), ['"string filename"']),
    Case("lamp-projection-without-name", world('@LightSource "projection"'), ['"string filename"']),
    Case("lamp-goniometric-is-folder", world('LightSource "goniometric" @"string filename" "i.pfm"'),
         ["i.pfm", "not a regular file"], 3, files={"i.pfm": None}),
]


def sky(name, parameters, says):
    return Case("sky-" + name, world(f'LightSource "infinite" "string model" "sky"\n {parameters}'), says)


SKIES = [
    Case("sky-and-image", world('LightSource "infinite" "string model" "sky" @"string filename" "a.exr"'), ['"filename"', '"sky"']),
    Case("sky-and-colour", world('LightSource "infinite" "string model" "sky" @"rgb L" [1 2 3]'), ['"L"', '"sky"']),
    Case("mapping-of-nothing", world('LightSource "infinite" @"string mapping" "latlong"'), ['"mapping"', '"string filename"']),
    Case("sky-model", world('LightSource "infinite" @"string model" "hosek"'), ['"sky"', '"hosek"']),
    sky("turbidity", '@"float turbidity" 0.5', ["turbidity", "0.5"]),
    sky("sun-too-low", '@"float elevation" -30', ["elevation", "-30"]),
    sky("sun-twice", '"float elevation" 30 @"string time" "2026-06-21 12:00"', ["either", '"sundirection"']),
    sky("time", '@"string time" "noon" "float latitude" 50 "float longitude" 8', ['"noon"', "2026-06-21 15:30"]),
    sky("time-without-place", '"string time" "2026-06-21 12:00" "float longitude" 8', ['"float latitude"']),
    sky("latitude", '"string time" "2026-06-21 12:00" "float longitude" 8 @"float latitude" 95', ["latitude", "95"]),
    sky("night", '@"string time" "2026-12-21 23:00 Z" "float latitude" 50 "float longitude" 0', ["below the horizon"]),
    sky("no-direction", '@"vector3 sundirection" [0 0 0]', ["sundirection", "length"]),
    sky("misspelt", '@"float turbidty" 3', ['"float turbidty"', '"turbidity"']),
    sky("latitude-without-time", '@"float latitude" 50', ['"float latitude" goes with "string time"']),
    sky("misspelt-with-group", '"string group" "sun" @"float turbidty" 3', ['"float turbidty"', '"turbidity"']),
]

CASES = SKIES + WORDS + NUMBERS + PARAMETERS + PLUGINS + NAMES + BLOCKS + TRANSFORMS + SPECTRA + RANGES + LAMPS
