// The viewer's controls, labels and read-out.

const kKeys = [
    ["1 2 3 4", "wipe, flip, side by side, difference"],
    ["Space", "flip between A and B"],
    ["X", "exchange A and B"],
    ["+ − 0", "zoom in, out, fit"],
    ["Arrows", "pan"],
    ["[ ]", "exposure"],
    ["O", "outlines of boxes"],
    ["S", "difference with sign or without"]
];

const formatPixel = values => values.map(v => (Number.isFinite(v) ? formatNumber(v, 4) : String(v)));

function pictureSelect(side) {
    const select = element("select", {
        id: `picture-${side}`,
        onchange: () => {
            viewer[side] = select.value;
            drawViewer();
        }
    });
    return select;
}

function fillPictureSelects() {
    for (const side of ["a", "b"])
        fill(
            document.getElementById(`picture-${side}`),
            [...viewer.pictures.values()].map(({key, label}) =>
                element("option", {value: key, selected: key === viewer[side]}, label)
            )
        );
}

// x, y and the values of A, of B, and their difference under the pointer, else in the middle of the view.
function updateReadout(readout) {
    const {image} = pictureA(),
        other = pictureB().image;
    const p = viewer.cursor || {
        x: Math.min(image.width - 1, Math.floor(viewer.center.x)),
        y: Math.min(image.height - 1, Math.floor(viewer.center.y))
    };
    const index = p.y * image.width + p.x;
    const a = pixelOf(image, index),
        b = pixelOf(other, Math.min(index, other.width * other.height - 1));
    const row = (name, values) =>
        element(
            "tr",
            {"data-row": name},
            element("th", {scope: "row"}, name),
            ...formatPixel(values).map(v => element("td", {class: "number"}, v)),
            values.length < b.length || values.length < a.length
                ? element("td", {colspan: 2}, "(RMSE)")
                : null
        );
    const names = Math.max(a.length, b.length) === 3 ? ["R", "G", "B"] : ["RMSE"];
    fill(
        readout.querySelector("thead"),
        element("tr", {}, element("td", {}), ...names.map(n => element("th", {scope: "col"}, n)))
    );
    fill(
        readout.querySelector("tbody"),
        row("A", a),
        row("B", b),
        canSubtract() &&
            row(
                "A − B",
                a.map((v, c) => v - b[c])
            )
    );
    readout.querySelector("caption").textContent =
        `${viewer.cursor ? "Pixel" : "Middle pixel"} x ${p.x + page.origin.x}, y ${p.y + page.origin.y}`;
    readout.dataset.x = p.x;
    readout.dataset.y = p.y;
}

// What tests and style look at.
function publishState(stage) {
    Object.assign(stage.dataset, {
        mode: viewer.mode,
        a: pictureA().image.file,
        b: pictureB().image.file,
        scale: viewer.scale,
        centerX: viewer.center.x,
        centerY: viewer.center.y,
        split: viewer.split,
        flipped: viewer.flipped,
        signed: viewer.signed,
        stops: page.stops,
        panes: JSON.stringify(viewerPanes())
    });
}

function updateLabels(panel) {
    const single = viewer.mode === "flip" || viewer.mode === "difference";
    panel.labelA.textContent =
        viewer.mode === "difference"
            ? `A − B: ${pictureA().label} − ${pictureB().label}`
            : viewer.mode === "flip"
              ? viewer.flipped
                  ? `B: ${pictureB().label}`
                  : `A: ${pictureA().label}`
              : `A: ${pictureA().label}`;
    panel.labelB.textContent = `B: ${pictureB().label}`;
    panel.labelB.hidden = single;
    const second = viewerPanes()[1];
    panel.labelB.classList.toggle("below", viewer.mode === "side" && second.y > 0);
    panel.labelB.style.top = viewer.mode === "side" && second.y > 0 ? `${second.y + 10}px` : "";
}

function updateDivider(divider) {
    divider.hidden = viewer.mode !== "wipe";
    divider.style.left = `${100 * viewer.split}%`;
    divider.setAttribute("aria-valuenow", Math.round(100 * viewer.split));
}

function updateLegend(holder) {
    const scale = page.errorScale,
        shown = viewerPanes().map(p => p.key);
    if (viewer.mode === "difference") {
        if (!canSubtract()) return fill(holder, "A difference needs two renders or two maps of errors.");
        const difference = developedDifference();
        return fill(
            holder,
            element("span", {}, viewer.signed ? "mean of RGB, A − B" : "mean of RGB, |A − B|"),
            scaleLegend(difference.scale, difference.color, false)
        );
    }
    const hasMap = shown.some(key => viewer.pictures.get(key).image.channels === 1);
    fill(
        holder,
        hasMap && element("span", {}, "RMSE of a pixel"),
        hasMap && scaleLegend(scale, magmaColor, false)
    );
}

function viewerActions(controls, onExposure) {
    return {
        mode: mode => {
            viewer.mode = mode;
            controls.modes.choose(mode);
            controls.sign.hidden = mode !== "difference";
            drawViewer();
        },
        flip: () => {
            if (viewer.mode !== "flip") controls.actions.mode("flip");
            viewer.flipped = !viewer.flipped;
            drawViewer();
        },
        swap: () => {
            [viewer.a, viewer.b] = [viewer.b, viewer.a];
            fillPictureSelects();
            drawViewer();
        },
        sign: () => {
            viewer.signed = !viewer.signed;
            controls.sign.choose(viewer.signed ? "signed" : "absolute");
            drawViewer();
        },
        outlines: () => {
            viewer.boxes = !viewer.boxes;
            controls.outlines.checked = viewer.boxes;
            drawViewer();
        },
        expose: stops => onExposure(page.stops + stops)
    };
}

function makeStage() {
    const canvas = element("canvas", {id: "stage-canvas"});
    const divider = element(
        "div",
        {
            class: "divider",
            id: "divider",
            role: "slider",
            tabindex: 0,
            "aria-label": "Place of the wipe",
            "aria-valuemin": 0,
            "aria-valuemax": 100
        },
        element("i", {})
    );
    const labelA = element("span", {class: "stage-label a"}),
        labelB = element("span", {class: "stage-label b"});
    const stage = element(
        "div",
        {
            class: "stage",
            id: "stage",
            tabindex: 0,
            role: "application",
            "aria-label": "Viewer of two images; keys are listed below"
        },
        canvas,
        labelA,
        labelB,
        divider
    );
    return {stage, canvas, divider, labelA, labelB};
}

function makeTools(controls) {
    controls.modes = segments("Way of comparing", kModes, viewer.mode, mode => controls.actions.mode(mode));
    controls.sign = segments(
        "Sign of the difference",
        {signed: "A − B", absolute: "|A − B|"},
        "signed",
        value => {
            viewer.signed = value === "signed";
            drawViewer();
        }
    );
    controls.sign.hidden = true;
    controls.outlines = element("input", {
        type: "checkbox",
        id: "outlines",
        checked: true,
        onchange: () => controls.actions.outlines()
    });
    const middle = () => {
        const {width, height} = stageSize();
        return [width / 2, height / 2];
    };
    return element(
        "div",
        {class: "tools viewer-tools"},
        element("label", {class: "control"}, element("span", {}, "A"), pictureSelect("a")),
        button("⇄", "Exchange A and B (X)", () => controls.actions.swap(), {class: "quiet"}),
        element("label", {class: "control"}, element("span", {}, "B"), pictureSelect("b")),
        controls.modes,
        controls.sign,
        element(
            "div",
            {class: "segments", role: "group", "aria-label": "Zoom"},
            button("−", "Zoom out (−)", () => zoomAt(0.8, ...middle()), {id: "zoom-out"}),
            button("Fit", "The whole image (0)", fitView, {id: "zoom-fit"}),
            button(
                "1:1",
                "One pixel of the image on one of the page",
                () => zoomAt(1 / viewer.scale, ...middle()),
                {id: "zoom-one"}
            ),
            button("+", "Zoom in (+)", () => zoomAt(1.25, ...middle()), {id: "zoom-in"})
        ),
        element("label", {class: "control"}, controls.outlines, element("span", {}, "Boxes"))
    );
}

function makeViewer(section, onExposure) {
    const controls = {},
        panel = makeStage();
    controls.actions = viewerActions(controls, onExposure);
    const readout = element(
        "table",
        {class: "readout", id: "readout"},
        element("caption", {}),
        element("thead", {}),
        element("tbody", {})
    );
    const legend = element("div", {class: "stage-legend"});
    Object.assign(viewer, {stage: panel.stage, canvas: panel.canvas});
    fill(
        section,
        element("h2", {}, "Viewer"),
        element(
            "p",
            {class: "lead"},
            "Any two images under one zoom and pan. Ctrl and the wheel zoom, and so does the wheel alone after a " +
                "click into the image, or two fingers; dragging pans, and the bar of the wipe is dragged too."
        ),
        makeTools(controls),
        panel.stage,
        element("div", {class: "under-stage"}, readout, legend),
        element(
            "details",
            {class: "keys"},
            element("summary", {}, "Keys"),
            element(
                "dl",
                {},
                ...kKeys.flatMap(([key, what]) => [element("dt", {}, key), element("dd", {}, what)])
            )
        )
    );
    viewer.onDraw = () => {
        updateLabels(panel);
        updateDivider(panel.divider);
        updateLegend(legend);
        updateReadout(readout);
        publishState(panel.stage);
        panel.canvas.style.touchAction = viewer.scale <= fitScale() * 1.001 ? "pan-y" : "none";
    };
    listenToPointers(panel.canvas);
    listenToWheel(panel.canvas);
    listenToDivider(panel.divider);
    listenToKeys(panel.stage, controls.actions);
    new ResizeObserver(drawViewer).observe(panel.stage);
}

// New images, the same view; at first the baseline against the best.
function showPictures(variant, images) {
    viewer.pictures = viewerPictures(variant, images);
    const keys = [...viewer.pictures.keys()],
        runs = keys.filter(key => key.endsWith(".run"));
    const baseline = `${variant.estimators.findIndex(e => e.name === page.results.baseline)}.run`,
        best = bestOf(variant, 0);
    if (!viewer.pictures.has(viewer.a)) viewer.a = runs.includes(baseline) ? baseline : keys[0];
    if (!viewer.pictures.has(viewer.b))
        viewer.b =
            best && runs.includes(`${best.index}.run`) && `${best.index}.run` !== viewer.a
                ? `${best.index}.run`
                : keys[0];
    document.getElementById("viewer").hidden = keys.length === 0;
    if (keys.length === 0) return;
    fillPictureSelects();
    drawViewer();
}
