// What a report should show, worked out from its files without the page's own scripts.
import fs from "node:fs";
import path from "node:path";
import zlib from "node:zlib";

const unescapeHtml = text =>
    text.replace(
        /&(amp|lt|gt|quot|#39);/g,
        (_, name) => ({amp: "&", lt: "<", gt: ">", quot: '"', "#39": "'"})[name]
    );

function halfToFloat(bits) {
    const sign = bits & 0x8000 ? -1 : 1,
        exponent = (bits >> 10) & 0x1f,
        fraction = bits & 0x3ff;
    if (exponent === 0x1f) return fraction ? NaN : sign * Infinity;
    return exponent === 0 ? sign * fraction * 2 ** -24 : sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
}

// An image of the page: at(x, y) gives its channels.
class Picture {
    constructor(width, height, channels, base64) {
        Object.assign(this, {width, height, channels});
        this.bytes = zlib.inflateSync(Buffer.from(base64, "base64"));
    }
    at(x, y) {
        const plane = this.width * this.height,
            count = plane * this.channels,
            values = [];
        for (let c = 0; c < this.channels; ++c) {
            const i = c * plane + y * this.width + x;
            values.push(halfToFloat((this.bytes[i] << 8) | this.bytes[count + i]));
        }
        return values;
    }
    // 8-bit colour of an RGB image at an exposure, by the definition of sRGB (IEC 61966-2-1); pure green where
    // a value is not finite.
    colorAt(x, y, stops = 0) {
        const values = this.at(x, y);
        if (!values.every(Number.isFinite)) return [0, 255, 0];
        return values.map(value => {
            const v = Math.min(1, Math.max(0, value * 2 ** stops));
            return Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
        });
    }
}

// {html, embedded: the page's results, results: those of results.json beside it, images by file,
// boxes: [x0, x1, y0, y1] in pixels of the images}
export function readReport(file) {
    const html = fs.readFileSync(file, "utf8");
    const embedded = JSON.parse(
        html.match(/<script type="application\/json" id="results">(.*?)<\/script>/s)[1]
    );
    const results = JSON.parse(fs.readFileSync(path.join(path.dirname(file), "results.json"), "utf8"));
    const pictures = new Map();
    const element =
        /<script type="text\/plain" class="image" data-file="([^"]*)" data-width="(\d+)" data-height="(\d+)" data-channels="(\d)" data-x="(-?\d+)" data-y="(-?\d+)">([^<]*)</g;
    let origin = [0, 0];
    for (const [, name, width, height, channels, x, y, base64] of html.matchAll(element)) {
        pictures.set(unescapeHtml(name), new Picture(+width, +height, +channels, base64));
        if (+x !== 0 || +y !== 0) origin = [+x, +y];
    }
    // Boxes count pixels of the frame, of which the images may be a part.
    const boxes = results.boxes.map(({pixels: [x0, x1, y0, y1]}) => [
        x0 - origin[0],
        x1 - origin[0],
        y0 - origin[1],
        y1 - origin[1]
    ]);
    return {html, embedded, results, pictures, boxes};
}

// The value that a text of the page states, and how far from it the exact one may be: half of its last digit.
export function shownNumber(text) {
    const plain = text.trim().replace("−", "-").replace("+", "");
    const digits = "⁰¹²³⁴⁵⁶⁷⁸⁹";
    const match = plain.match(/^(-?[0-9]+(?:\.([0-9]+))?)(?:·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?\s*(%|×|)$/);
    if (!match) return null;
    const exponent = match[3]
        ? Number([...match[3]].map(c => (c === "⁻" ? "-" : digits.indexOf(c))).join(""))
        : 0;
    const scale = 10 ** exponent * (match[4] === "%" ? 0.01 : 1);
    return {
        value: Number(match[1]) * scale,
        tolerance: (0.5 * 10 ** -(match[2] || "").length + 1e-9) * scale
    };
}

// "variants.0.estimators.1.boxes.0.rmse.value" in results.json; undefined where it leads nowhere.
export const lookUp = (results, place) =>
    place
        .split(".")
        .reduce((node, key) => (node === null || node === undefined ? undefined : node[key]), results);
