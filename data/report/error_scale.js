// Scales of errors: their range, colours and legends, and the parts of images that they are for.

const magma = JSON.parse(document.getElementById("magma").textContent); // 8-bit sRGB

// Where a value lies on a scale {low, high, log}, in [0,1].
function scalePosition(scale, value) {
    const t = scale.log
        ? Math.log(value / scale.low) / Math.log(scale.high / scale.low)
        : (value - (scale.signed ? -scale.high : 0)) / (scale.high * (scale.signed ? 2 : 1));
    return Math.min(1, Math.max(0, t));
}

const magmaColor = t => magma[Math.round(t * (magma.length - 1))];

// Blue below, orange above, neutral at 1/2: for differences with a sign.
function divergingColor(t) {
    const middle = isDark() ? [24, 26, 30] : [247, 247, 245],
        end = t < 0.5 ? [0, 114, 178] : [213, 94, 0];
    const amount = Math.sqrt(Math.abs(2 * t - 1));
    return middle.map((m, c) => Math.round(m + (end[c] - m) * amount));
}

// A box of results.json, which counts pixels of the frame, in those of the images.
function localPixels(box) {
    const [x0, x1, y0, y1] = box.pixels;
    const {x, y} = page.origin;
    return [x0 - x, x1 - x, y0 - y, y1 - y];
}

// The same as a region of an image, cut to it.
function regionOf(box, image) {
    const [x0, x1, y0, y1] = localPixels(box);
    const clamp = (v, high) => Math.min(high, Math.max(0, v));
    return {
        x0: clamp(x0, image.width),
        x1: clamp(x1, image.width),
        y0: clamp(y0, image.height),
        y1: clamp(y1, image.height)
    };
}

// The value below which a share of sorted numbers lies.
const quantile = (sorted, share) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];

// One scale for all maps of errors: its top is their 99.5 % quantile over the boxes, its foot 1/100 of that on a
// logarithmic axis.
function errorScale(maps, boxes, log) {
    const values = [];
    for (const map of maps)
        for (const box of boxes) {
            const {x0, x1, y0, y1} = regionOf(box, map),
                width = x1 - x0,
                numPixels = width * (y1 - y0);
            // A part of a large box does: some ten thousand values fix a quantile well enough for a scale.
            const step = Math.max(1, Math.floor(numPixels / 50000)) | 1;
            for (let i = 0; i < numPixels; i += step) {
                const v =
                    kHalfValues[map.halves[(y0 + Math.floor(i / width)) * map.width + x0 + (i % width)]];
                if (Number.isFinite(v)) values.push(v);
            }
        }
    const high = values.length ? quantile(Float32Array.from(values).sort(), 0.995) || 1e-6 : 1;
    return {log, low: high / 100, high};
}

// Round numbers within a scale, for its legend.
function scaleTicks(scale) {
    if (scale.log) {
        const ticks = [];
        for (let e = Math.floor(Math.log10(scale.low)); e <= Math.log10(scale.high); ++e)
            for (const m of [1, 3])
                if (m * 10 ** e >= scale.low && m * 10 ** e <= scale.high) ticks.push(m * 10 ** e);
        return ticks;
    }
    const range = scale.high * (scale.signed ? 2 : 1),
        rough = range / 4,
        power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].find(m => m * power >= rough) * power;
    const ticks = [];
    for (let k = scale.signed ? -Math.floor(scale.high / step) : 0; k * step <= scale.high * 1.0001; ++k)
        ticks.push(k * step);
    return ticks;
}

// A bar of colours with numbers.
function scaleLegend(scale, color, vertical) {
    const stops = [];
    for (let i = 0; i <= 16; ++i) stops.push(`rgb(${color(i / 16).join(",")}) ${i * 6.25}%`);
    const bar = element("div", {
        class: "legend-bar",
        style: `background:linear-gradient(${vertical ? "to top" : "to right"}, ${stops.join(",")})`
    });
    const labels = element("div", {class: "legend-labels"});
    for (const tick of scaleTicks(scale))
        labels.append(
            element(
                "span",
                {style: `${vertical ? "bottom" : "left"}:${100 * scalePosition(scale, tick)}%`},
                tickText(tick)
            )
        );
    return element("div", {class: vertical ? "legend vertical" : "legend"}, bar, labels);
}
