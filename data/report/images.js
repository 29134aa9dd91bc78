// Images: from text in the page to 16-bit floats, and from these to colours on a canvas.

const kNotFinite = [0, 255, 0]; // magma does not have this colour, and hardly a render does

// Values of all 16-bit floats.
const kHalfValues = (() => {
    const values = new Float32Array(65536);
    for (let bits = 0; bits < 65536; ++bits) {
        const exponent = (bits >> 10) & 31,
            mantissa = bits & 1023;
        const magnitude =
            exponent === 0
                ? mantissa * 2 ** -24
                : exponent < 31
                  ? (1024 + mantissa) * 2 ** (exponent - 25)
                  : mantissa
                    ? NaN
                    : Infinity;
        values[bits] = bits & 0x8000 ? -magnitude : magnitude;
    }
    return values;
})();

async function inflate(base64) {
    const text = atob(base64);
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
}

// {file, width, height, x, y: of the first pixel in the frame, channels, halves: channel after channel,
// numNotFinite}, or null if the page lacks the file.
async function decodeImage(file) {
    const source = [...document.querySelectorAll("script.image")].find(s => s.dataset.file === file);
    if (!source) return null;
    const width = Number(source.dataset.width),
        height = Number(source.dataset.height);
    const channels = Number(source.dataset.channels),
        count = width * height * channels;
    const bytes = await inflate(source.textContent);
    const halves = new Uint16Array(count);
    for (let i = 0; i < count; ++i) halves[i] = (bytes[i] << 8) | bytes[count + i];
    const numNotFinite = countNotFinite(halves, width * height);
    const x = Number(source.dataset.x),
        y = Number(source.dataset.y);
    return {file, width, height, x, y, channels, halves, numNotFinite};
}

const isFiniteHalf = bits => (bits & 0x7c00) !== 0x7c00;

// Pixels of which some channel is NaN or infinite.
function countNotFinite(halves, numPixels) {
    const pixels = new Set();
    for (let i = 0; i < halves.length; ++i) if (!isFiniteHalf(halves[i])) pixels.add(i % numPixels);
    return pixels.size;
}

// Each image is decoded once, when it is first asked for.
const imageStore = new Map();
function loadImage(file) {
    if (!file) return Promise.resolve(null);
    if (!imageStore.has(file)) imageStore.set(file, decodeImage(file));
    return imageStore.get(file);
}

function pixelOf(image, index) {
    const plane = image.width * image.height,
        values = [];
    for (let c = 0; c < image.channels; ++c) values.push(kHalfValues[image.halves[c * plane + index]]);
    return values;
}

const toSRGB = v => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);

// Bytes of the sRGB curve for all 16-bit floats at an exposure, so that an image is developed by looking up.
const toneTables = new Map();
function toneTable(stops) {
    if (!toneTables.has(stops)) {
        if (toneTables.size > 8) toneTables.clear();
        const scale = 2 ** stops,
            table = new Uint8Array(65536);
        for (let bits = 0; bits < 65536; ++bits) {
            const v = kHalfValues[bits] * scale;
            table[bits] = v > 0 ? Math.round(255 * toSRGB(Math.min(1, v))) : 0;
        }
        toneTables.set(stops, table);
    }
    return toneTables.get(stops);
}

// Writes a colour image of a region {x0, x1, y0, y1} to a canvas of its size. `color` fills `out` (RGB) for a
// pixel's index, or returns false where the value is not finite.
function paint(canvas, width, region, color) {
    canvas.width = region.x1 - region.x0;
    canvas.height = region.y1 - region.y0;
    const context = canvas.getContext("2d");
    const data = context.createImageData(canvas.width, canvas.height),
        out = data.data,
        rgb = [0, 0, 0];
    let k = 0;
    for (let y = region.y0; y < region.y1; ++y)
        for (let x = region.x0; x < region.x1; ++x, k += 4) {
            const [r, g, b] = color(y * width + x, rgb) ? rgb : kNotFinite;
            out[k] = r;
            out[k + 1] = g;
            out[k + 2] = b;
            out[k + 3] = 255;
        }
    context.putImageData(data, 0, 0);
}

// An RGB image at an exposure, or a map of errors on a scale.
function paintImage(canvas, image, region, stops, scale) {
    const halves = image.halves;
    if (image.channels === 1) {
        const colors = new Map();
        paint(canvas, image.width, region, (i, rgb) => {
            const bits = halves[i];
            if (!isFiniteHalf(bits)) return false;
            if (!colors.has(bits)) colors.set(bits, magmaColor(scalePosition(scale, kHalfValues[bits])));
            [rgb[0], rgb[1], rgb[2]] = colors.get(bits);
            return true;
        });
        return;
    }
    const table = toneTable(stops),
        plane = image.width * image.height;
    paint(canvas, image.width, region, (i, rgb) => {
        for (let c = 0; c < 3; ++c) {
            const bits = halves[c * plane + i];
            if (!isFiniteHalf(bits)) return false;
            rgb[c] = table[bits];
        }
        return true;
    });
}

const wholeOf = image => ({x0: 0, x1: image.width, y0: 0, y1: image.height});
