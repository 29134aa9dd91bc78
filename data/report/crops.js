// Each box side by side: the reference and every estimator at one exposure, and below them their errors on one
// scale.

const kLeastTile = 200,
    kLeastLargeTile = 260,
    kTileGap = 12,
    kLeastCaption = 150; // CSS pixels; report.css has the same gap

// Enlarged so that every pixel of the render covers the same number of the screen's, and not beyond comfort.
function sizeCrop(canvas, available) {
    const zoom = available / canvas.width;
    const shown = zoom >= 1 ? Math.floor(zoom * devicePixelRatio) / devicePixelRatio : zoom;
    const width = canvas.width * shown;
    canvas.style.width = `${width}px`;
    canvas.classList.toggle("reduced", zoom < 1);
    return width;
}

const notFiniteNote = image =>
    image &&
    image.numNotFinite > 0 &&
    element("p", {class: "loud"}, `${image.numNotFinite} pixels of the image are not finite (green)`);

function cropCanvas(image, box, kind, name, onOpen) {
    if (!image) return element("p", {class: "absent"}, "not in this report");
    const region = regionOf(box, image);
    if (region.x1 <= region.x0 || region.y1 <= region.y0)
        return element("p", {class: "absent"}, "outside of the image");
    const canvas = element("canvas", {
        class: `crop ${kind}`,
        role: "img",
        "data-file": image.file,
        "aria-label": `${box.name}, ${name}`,
        title: "Open in the viewer",
        tabindex: 0,
        onclick: onOpen,
        onkeydown: event => {
            if (event.key === "Enter") onOpen();
        }
    });
    canvas.repaint = () => paintImage(canvas, image, region, page.stops, page.errorScale);
    canvas.repaint();
    return canvas;
}

function reductionCaption(estimator, estimatorIndex, box, boxIndex) {
    const path = `variants.${page.variant}.estimators.${estimatorIndex}.boxes.${boxIndex}`,
        reduction = box.rmse_reduction;
    if (estimator.name === page.results.baseline) return element("p", {class: "reduction plain"}, "baseline");
    if (valueOf(reduction) === null) return element("p", {class: "reduction plain"}, kMissing);
    return element(
        "p",
        {class: "reduction"},
        element(
            "strong",
            {},
            numberSpan(`${path}.rmse_reduction.value`, reduction.value, `${formatRatio(reduction.value)} ×`)
        ),
        hasInterval(reduction) &&
            element("small", {}, `${formatRatio(reduction.low)} – ${formatRatio(reduction.high)}`)
    );
}

function estimatorTile(images, variant, e, box, b, open) {
    const estimator = variant.estimators[e],
        numbers = (estimator.boxes || [])[b] || {},
        rmse = valueOf(numbers.rmse);
    const files = estimator.images || {},
        run = images.get(files.run),
        error = images.get(files.error);
    return element(
        "figure",
        {class: "tile"},
        element("figcaption", {}, estimatorName(estimator.name)),
        cropCanvas(run, box, "render", estimator.name, () => open("reference", `${e}.run`, box)),
        reductionCaption(estimator, e, numbers, b),
        cropCanvas(error, box, "error", `error of ${estimator.name}`, () =>
            open(`${e}.run`, `${e}.error`, box)
        ),
        element(
            "p",
            {class: "under"},
            "RMSE ",
            numberSpan(
                `variants.${page.variant}.estimators.${e}.boxes.${b}.rmse.value`,
                rmse,
                formatNumber(rmse)
            )
        ),
        notFiniteNote(run),
        notFiniteNote(error)
    );
}

// The reference has no error: the legend of the others' stands in its place.
function referenceTile(images, variant, box, open) {
    const image = images.get((variant.reference || {}).image);
    return element(
        "figure",
        {class: "tile reference"},
        element("figcaption", {}, "reference"),
        cropCanvas(image, box, "render", "reference", () => open("reference", "reference", box)),
        element("p", {class: "reduction plain"}, "RMSE reduction ▸"),
        element(
            "div",
            {class: "legend-place"},
            element("p", {}, "RMSE of a pixel over the runs"),
            scaleLegend(page.errorScale, magmaColor, true)
        ),
        notFiniteNote(image)
    );
}

function boxCrops(images, variant, box, b, open) {
    const grid = element(
        "div",
        {class: "tiles"},
        referenceTile(images, variant, box, open),
        ...variant.estimators.map((_, e) => estimatorTile(images, variant, e, box, b, open))
    );
    const resize = () => {
        const space = grid.clientWidth,
            wanted = 1 + variant.estimators.length;
        if (space === 0) return;
        // A large box wants more room, to lose less of its pixels.
        const least = box.pixels[1] - box.pixels[0] > kLeastLargeTile ? kLeastLargeTile : kLeastTile;
        const fitting = Math.max(2, Math.floor((space + kTileGap) / (least + kTileGap)));
        // Rows of equal length: six tiles where five fit become three and three.
        const columns = Math.ceil(wanted / Math.ceil(wanted / Math.min(wanted, fitting)));
        const tile = Math.min(360, Math.floor((space - (columns - 1) * kTileGap) / columns));
        const widths = [...grid.querySelectorAll("canvas")].map(canvas => sizeCrop(canvas, tile));
        grid.style.gridTemplateColumns = `repeat(${columns}, ${Math.max(Math.min(kLeastCaption, tile), ...widths)}px)`;
        const error = grid.querySelector("canvas.error"),
            place = grid.querySelector(".legend-place");
        if (error) place.style.height = `${error.clientHeight}px`;
    };
    new ResizeObserver(resize).observe(grid);
    return element(
        "article",
        {class: "box", "data-box": box.name},
        element("h3", {}, box.name, element("small", {}, boxPlace(box))),
        grid
    );
}

// `open(a, b, box)` shows two images in the viewer.
function makeCrops(section, images, open) {
    const variant = variantShown(),
        {boxes} = page.results;
    const maps = variant.estimators.map(e => images.get((e.images || {}).error)).filter(Boolean);
    page.errorScale = errorScale(maps, boxes, page.errorLog);
    const rescale = log => {
        page.errorLog = log === "log";
        makeCrops(section, images, open);
        section.dispatchEvent(new CustomEvent("scalechange"));
    };
    fill(
        section,
        element("h2", {}, "Crops"),
        element(
            "p",
            {class: "lead"},
            `Above: the first run of each ${noun()} at one exposure, every pixel of the render enlarged as a square. ` +
                "Below: the error of each pixel over all runs, on one scale for all. A click opens the viewer there."
        ),
        element(
            "div",
            {class: "tools"},
            element("span", {}, "Scale of errors"),
            segments(
                "Scale of errors",
                {log: "logarithmic", linear: "linear"},
                page.errorLog ? "log" : "linear",
                rescale
            )
        ),
        ...boxes.map((box, b) => boxCrops(images, variant, box, b, open))
    );
}

function repaintCrops(section) {
    for (const canvas of section.querySelectorAll("canvas.render")) if (canvas.repaint) canvas.repaint();
}
