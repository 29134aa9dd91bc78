// Images of the page as figures.

// Values after the tone curve become bytes as they are; linear ones pass through the sRGB curve.
const bytesOf = isLinear => value => Math.round(255 * Math.min(1, Math.max(0, isLinear ? toSRGB(value) : value)));

// Three channels as colours, one as grey between two values.
function paintPlain(canvas, image, toByte) {
    const {channels, halves} = image,
        plane = image.width * image.height;
    paint(canvas, image.width, wholeOf(image), (i, rgb) => {
        for (let c = 0; c < 3; ++c) {
            const bits = halves[(c % channels) * plane + i];
            if (!isFiniteHalf(bits)) return false;
            rgb[c] = toByte(kHalfValues[bits]);
        }
        return true;
    });
}

// What waits for its pixels: the page is ready when all have them.
const painting = [];

function pictureCanvas(file, label, toByte) {
    const canvas = element("canvas", {role: "img", "aria-label": label, class: "picture", "data-file": file, width: 8, height: 8});
    painting.push(loadImage(file).then(image => image && paintPlain(canvas, image, toByte)));
    return canvas;
}

const picture = (file, caption, toByte) =>
    element("figure", {class: "shot"}, pictureCanvas(file, caption, toByte), element("figcaption", {}, caption));
