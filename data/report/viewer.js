// The viewer's state and its drawing: two images A and B under one transform, in one of four ways.
//
// A point of the image (x, y), in pixels from its top left corner, lies at (x - center.x) * scale from the middle
// of its pane, in CSS pixels; all panes share center and scale, so that zoom and pan are synchronised.

const kModes = {wipe: "Wipe", flip: "Flip", side: "Side by side", difference: "Difference"};
const kGreatestScale = 64; // CSS pixels a pixel of the image
const kStackBelow = 560; // CSS pixels: narrower stages put two panes above each other

const viewer = {
    pictures: new Map(), // key ("reference", "0.run", "0.error") -> {key, label, image}
    // Keys of the two.
    a: null,
    b: null,
    mode: "wipe",
    split: 0.5, // the wipe's place, share of the width
    flipped: false, // flip shows B
    signed: true, // of the difference
    boxes: true, // outlines
    scale: 0, // 0: not yet fitted
    center: {x: 0, y: 0},
    cursor: null, // pixel under the pointer, or null
    // Set by viewer_panel.js.
    stage: null,
    canvas: null,
    onDraw: () => {}
};

const pictureA = () => viewer.pictures.get(viewer.a);
const pictureB = () => viewer.pictures.get(viewer.b);

// The images of a variant that the page has, in the order of the choice.
function viewerPictures(variant, images) {
    const list = [{key: "reference", label: "reference", file: (variant.reference || {}).image}];
    variant.estimators.forEach((estimator, e) => {
        const files = estimator.images || {};
        list.push(
            {key: `${e}.run`, label: `${estimator.name}, first run`, file: files.run},
            {key: `${e}.error`, label: `${estimator.name}, error`, file: files.error}
        );
    });
    return new Map(list.filter(p => images.get(p.file)).map(p => [p.key, {...p, image: images.get(p.file)}]));
}

const stageSize = () => ({width: viewer.canvas.clientWidth, height: viewer.canvas.clientHeight});

// Where images are drawn: {x, y, width, height, key}; key "difference" for that of A and B.
function viewerPanes() {
    const {width, height} = stageSize(),
        {mode, a, b} = viewer,
        whole = {x: 0, y: 0, width, height};
    if (mode === "flip") return [{...whole, key: viewer.flipped ? b : a}];
    if (mode === "difference") return [{...whole, key: "difference"}];
    if (mode === "wipe")
        return [
            {...whole, key: a, right: width * viewer.split},
            {...whole, key: b, left: width * viewer.split}
        ];
    const gap = 2;
    if (width < kStackBelow) {
        const half = (height - gap) / 2;
        return [
            {...whole, height: half, key: a},
            {...whole, y: half + gap, height: half, key: b}
        ];
    }
    const half = (width - gap) / 2;
    return [
        {...whole, width: half, key: a},
        {...whole, x: half + gap, width: half, key: b}
    ];
}

const paneAt = (x, y) =>
    viewerPanes().find(
        p => x >= (p.left ?? p.x) && x < (p.right ?? p.x + p.width) && y >= p.y && y < p.y + p.height
    );

// The image's point under a place of the stage.
function toPicture(pane, x, y) {
    return {
        x: viewer.center.x + (x - pane.x - pane.width / 2) / viewer.scale,
        y: viewer.center.y + (y - pane.y - pane.height / 2) / viewer.scale
    };
}

function fitScale() {
    const image = pictureA().image,
        pane = viewerPanes()[0];
    return Math.min(pane.width / image.width, pane.height / image.height);
}

function clampView() {
    const image = pictureA().image,
        clamp = (v, high) => Math.min(high, Math.max(0, v));
    viewer.scale = Math.min(kGreatestScale, Math.max(Math.min(1, fitScale()) / 2, viewer.scale));
    viewer.center = {x: clamp(viewer.center.x, image.width), y: clamp(viewer.center.y, image.height)};
}

function fitView() {
    const image = pictureA().image;
    viewer.scale = fitScale();
    viewer.center = {x: image.width / 2, y: image.height / 2};
    drawViewer();
}

// Shows a box of results.json with some room around.
function fitBox(box) {
    const [x0, x1, y0, y1] = localPixels(box),
        pane = viewerPanes()[0];
    viewer.scale = 0.9 * Math.min(pane.width / (x1 - x0), pane.height / (y1 - y0));
    viewer.center = {x: (x0 + x1) / 2, y: (y0 + y1) / 2};
    clampView();
    drawViewer();
}

// Scales by a factor and keeps the point of the image under (x, y) of the stage where it is.
function zoomAt(factor, x, y) {
    const pane = paneAt(x, y) || viewerPanes()[0],
        fixed = toPicture(pane, x, y);
    viewer.scale *= factor;
    clampView();
    viewer.center = {
        x: fixed.x - (x - pane.x - pane.width / 2) / viewer.scale,
        y: fixed.y - (y - pane.y - pane.height / 2) / viewer.scale
    };
    clampView();
    drawViewer();
}

function panBy(dx, dy) {
    viewer.center = {x: viewer.center.x - dx / viewer.scale, y: viewer.center.y - dy / viewer.scale};
    clampView();
    drawViewer();
}

// Maps of errors and renders have no common difference.
const canSubtract = () =>
    pictureA().image.channels === pictureB().image.channels &&
    pictureA().image.halves.length === pictureB().image.halves.length;

// A - B in a pixel: the mean over the channels, with its sign or without.
function differenceAt(a, b, index) {
    const plane = a.width * a.height;
    let sum = 0;
    for (let c = 0; c < a.channels; ++c) {
        const d = kHalfValues[a.halves[c * plane + index]] - kHalfValues[b.halves[c * plane + index]];
        sum += viewer.signed ? d : Math.abs(d);
    }
    return sum / a.channels;
}

// Developed images, by what they depend on; the oldest goes first.
const developed = new Map();
function developedOnce(key, make) {
    if (!developed.has(key)) {
        if (developed.size >= 8) developed.delete(developed.keys().next().value);
        developed.set(key, make(document.createElement("canvas")));
    }
    return developed.get(key);
}

function developedPicture({image}) {
    const scale = page.errorScale,
        look = image.channels === 1 ? `${scale.log}${scale.high}` : page.stops;
    return developedOnce(`${image.file} ${look}`, canvas => {
        paintImage(canvas, image, wholeOf(image), page.stops, scale);
        return {canvas};
    });
}

// Its scale ends at the 99 % quantile of the magnitudes.
function developedDifference() {
    const a = pictureA().image,
        b = pictureB().image;
    return developedOnce(`${a.file} ${b.file} ${viewer.signed} ${isDark()}`, canvas => {
        const differences = new Float32Array(a.width * a.height);
        for (let i = 0; i < differences.length; ++i) differences[i] = differenceAt(a, b, i);
        const magnitudes = differences.map(Math.abs).filter(Number.isFinite).sort();
        const scale = {log: false, signed: viewer.signed, low: 0, high: quantile(magnitudes, 0.99) || 1e-6};
        const color = viewer.signed ? divergingColor : magmaColor;
        paint(canvas, a.width, wholeOf(a), (i, rgb) => {
            if (!Number.isFinite(differences[i])) return false;
            [rgb[0], rgb[1], rgb[2]] = color(scalePosition(scale, differences[i]));
            return true;
        });
        return {canvas, scale, color};
    });
}

function drawPane(context, pane) {
    const {scale, center} = viewer;
    const source =
        pane.key === "difference"
            ? canSubtract()
                ? developedDifference()
                : null
            : developedPicture(viewer.pictures.get(pane.key));
    const left = pane.left ?? pane.x,
        right = pane.right ?? pane.x + pane.width;
    context.save();
    context.beginPath();
    context.rect(left, pane.y, right - left, pane.height);
    context.clip();
    context.translate(
        pane.x + pane.width / 2 - center.x * scale,
        pane.y + pane.height / 2 - center.y * scale
    );
    context.imageSmoothingEnabled = scale * devicePixelRatio < 1;
    if (source)
        context.drawImage(source.canvas, 0, 0, source.canvas.width * scale, source.canvas.height * scale);
    if (viewer.boxes) page.results.boxes.forEach((box, index) => drawOutline(context, box, index, scale));
    context.restore();
}

// Names stand at the bottom left and the top left in turn, as boxes like to share a corner.
function drawOutline(context, box, index, scale) {
    const [x0, x1, y0, y1] = localPixels(box).map(v => v * scale);
    for (const [color, width] of [
        ["rgba(0,0,0,.55)", 3],
        ["#fff", 1.25]
    ]) {
        context.strokeStyle = color;
        context.lineWidth = width;
        context.strokeRect(x0, y0, x1 - x0, y1 - y0);
    }
    context.font = "600 12px system-ui, sans-serif";
    context.strokeStyle = "rgba(0,0,0,.6)";
    context.lineWidth = 3;
    context.lineJoin = "round";
    const y = index % 2 === 0 ? y1 - 7 : y0 + 16;
    context.strokeText(box.name, x0 + 6, y);
    context.fillStyle = "#fff";
    context.fillText(box.name, x0 + 6, y);
}

let drawAsked = false;
function drawViewer() {
    if (drawAsked) return;
    drawAsked = true;
    requestAnimationFrame(() => {
        drawAsked = false;
        drawViewerNow();
    });
}

function drawViewerNow() {
    const {canvas} = viewer,
        {width, height} = stageSize(),
        ratio = devicePixelRatio;
    if (!pictureA() || !pictureB() || width === 0) return;
    if (viewer.scale === 0) {
        fitView();
        return;
    }
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
        canvas.width = Math.round(width * ratio);
        canvas.height = Math.round(height * ratio);
    }
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.fillStyle = cssColor("--stage");
    context.fillRect(0, 0, width, height);
    for (const pane of viewerPanes()) drawPane(context, pane);
    viewer.onDraw();
}
