// The parts of a page of a capture.

function makeCaptureHead(section) {
    const {results} = page;
    fill(
        section,
        element("p", {class: "kicker"}, "Capture"),
        element("h1", {}, results.title),
        element("p", {class: `verdict ${results.good ? "good" : "plain"}`, id: "verdict"}, results.verdict),
        results.warnings.length > 0 &&
            element("ul", {class: "notices"}, ...results.warnings.map(text => element("li", {}, text))),
        results.findings.length > 0 && element("ul", {class: "findings"}, ...results.findings.map(findingItem)),
        settingsAndCommand("capture-report.json")
    );
}

function makeCaptureMaps(section) {
    fill(
        section,
        element("h2", {}, "Maps"),
        element(
            "p",
            {class: "lead"},
            "What was written for scenes, shown as people look at maps: albedo and specular albedo as colours, the others as grey or as directions."
        ),
        element("div", {class: "gallery"}, ...page.results.maps.map(map => picture(map.file, map.caption, bytesOf(map.color))))
    );
}

// One light that goes around; the reader turns it.
function makeRelit(section) {
    const {frames, caption} = page.results.relit;
    const holder = element("div", {});
    const show = index => fill(holder, picture(frames[index].file, frames[index].caption, encodedByte));
    const slider = element("input", {
        type: "range",
        min: 0,
        max: frames.length - 1,
        value: 0,
        id: "relit-frame",
        oninput: event => show(Number(event.target.value))
    });
    show(0);
    fill(
        section,
        element("h2", {}, "Under another light"),
        element("p", {class: "lead"}, caption),
        element("div", {class: "relit"}, holder, slider, element("label", {for: "relit-frame"}, "Where the light stands"))
    );
}

const kPlanSize = 460;

// Cameras as seen from above, with the card and the sample to scale.
function cameraPlan() {
    const {views, size, card} = page.results;
    const reach = 1.15 * Math.max(card / 2 || 0, size / 2, ...views.map(v => Math.max(Math.abs(v.camera[0]), Math.abs(v.camera[1]))));
    const at = value => (kPlanSize / 2) * (1 + value / reach);
    const square = (edge, name) =>
        svgElement("rect", {class: name, x: at(-edge / 2), y: at(-edge / 2), width: at(edge / 2) - at(-edge / 2), height: at(edge / 2) - at(-edge / 2)});
    const marks = views.flatMap((v, i) => {
        const x = at(v.camera[0]),
            y = at(-v.camera[1]);
        const isLeft = x > 0.7 * kPlanSize;
        return [
            svgElement("circle", {class: `camera ${v.use}`, cx: x, cy: y, r: 5}),
            svgElement("text", {x: isLeft ? x - 9 : x + 9, y: y + 4, "text-anchor": isLeft ? "end" : "start"}, String(i + 1))
        ];
    });
    return svgElement(
        "svg",
        {class: "plan", viewBox: `0 0 ${kPlanSize} ${kPlanSize}`, role: "img", "aria-label": "Cameras from above"},
        ...(card ? [square(card, "card-edge")] : []),
        square(size, "sample"),
        ...marks
    );
}

function cameraTable() {
    const {views} = page.results,
        hasCard = views.some(view => isNumber(view.reprojection));
    const number = (view, i, key) =>
        element("td", {}, element("span", {"data-path": `views.${i}.${key}`}, formatNumber(key.split(".").reduce((v, k) => v?.[k], view), 3)));
    const rows = views.map((view, i) =>
        element(
            "tr",
            {},
            element("th", {scope: "row"}, `${i + 1}  ${view.name}`),
            element("td", {class: "names"}, kUses[view.use]),
            ...["camera.0", "camera.1", "camera.2"].map(key => number(view, i, key)),
            hasCard && number(view, i, "reprojection"),
            number(view, i, "rmse")
        )
    );
    return element(
        "div",
        {class: "scroll card"},
        element(
            "table",
            {class: "numbers", id: "camera-table"},
            element(
                "thead",
                {},
                element(
                    "tr",
                    {},
                    headCell("Photograph"),
                    headCell("Use"),
                    headCell("x", "cm"),
                    headCell("y", "cm"),
                    headCell("z", "cm"),
                    hasCard && headCell("Tags off by", "pixels"),
                    headCell("RMSE", "encoded")
                )
            ),
            element("tbody", {}, ...rows)
        )
    );
}

function makeCameras(section) {
    fill(
        section,
        element("h2", {}, "Cameras"),
        element(
            "p",
            {class: "lead"},
            "Where the photographs were taken from, seen from above; hollow marks were held out. The card's frame is the dashed square, what was captured the filled one."
        ),
        cameraPlan(),
        cameraTable()
    );
}

function makeFit(section) {
    const {history} = page.results;
    const pointsOf = key => history.filter(h => isNumber(h[key])).map(h => ({x: h.iteration, y: h[key]}));
    makePlots(
        section,
        () => "The fit",
        "Errors of the photographs as the maps were improved. Where held-out errors rise again, the maps follow noise.",
        () => {
            const colors = isDark() ? kColorsOnDark : kColors;
            const lines = [
                ["fitted", "fit_rmse", colors[0]],
                ["held out", "test_rmse", colors[1]]
            ]
                .map(([label, key, color]) => [label, pointsOf(key), color])
                .filter(([, points]) => points.length > 0)
                .map(([label, points, color]) => lineDataset(label, points, color));
            const values = lines.flatMap(line => line.data.map(point => point.y));
            return [["RMSE of encoded values", lines, linearAxis("iteration"), logAxis("RMSE", values)]];
        }
    );
}

function makeCaptureMethod(section) {
    const terms = {
        RMSE: "The root of the mean squared difference between photograph and maps, of values from 0 to 1 in the photograph's own encoding.",
        "Held out": "A photograph that the fit never saw. The maps are put under its light and seen from its camera.",
        Albedo: "Light that is scattered below the surface, for the part that the surface does not reflect.",
        "Specular albedo": "What the surface reflects along its normal.",
        Roughness: "Of the GGX distribution: α is its square.",
        "Total variation": "Neighbouring texels are drawn together, more so where photographs say little."
    };
    if (page.results.views.some(view => isNumber(view.reprojection)))
        terms["Tags off by"] =
            "The root of the mean squared distance between the corners of the tags in the photograph and where the camera would see them on a flat card.";
    fillMethod(section, terms, "Plots by Chart.js (© Chart.js Contributors, MIT licence), colours after Okabe and Ito.");
}

startPage([
    [true, "head", "", makeCaptureHead],
    [page.results.views.length > 0, "views", "Photographs", makeViews],
    [page.results.maps.length > 0, "maps", "Maps", makeCaptureMaps],
    [page.results.relit.frames.length > 0, "relit", "Other light", makeRelit],
    [page.results.views.length > 0, "cameras", "Cameras", makeCameras],
    [page.results.history.length > 1, "fit", "Fit", makeFit],
    [true, "method", "Method", makeCaptureMethod]
]);
