// Oriented ensembles: where light goes that comes along several directions, and what depends on its direction.

const isOriented = Boolean(page.results.oriented);

// Of a direction in the plane of the axis, which points up, and the incident light: [x, y] on the page.
const fromAxis = degrees => [Math.sin((degrees * Math.PI) / 180), -Math.cos((degrees * Math.PI) / 180)];

const slicePath = (angles, values, limits) =>
    `M${angles.map((angle, i) => polarPoint(values[i], fromAxis(angle), limits)).join("L")}Z`;

// The incident light, from the rim towards the middle.
function incidentArrow(incidence) {
    const [x, y] = fromAxis(incidence),
        at = (along, aside) => `${(-along * x - aside * y).toFixed(1)},${(-along * y + aside * x).toFixed(1)}`;
    const tip = 0.72 * kPolarRadius;
    return svgElement("path", {
        class: "arrow",
        d: `M${at(kPolarRadius, 0)}L${at(tip, 0)}M${at(tip + 9, 5)}L${at(tip, 0)}L${at(tip + 9, -5)}`
    });
}

function sliceFigure(slice, index, limits) {
    const {independent} = wavelengthShown(),
        {angles} = page.results;
    const svg = polarFrame(`Polar plot of log p, incidence ${slice.incidence} degrees`, limits, fromAxis);
    const alone = [...angles.map(a => slice.incidence + a), ...angles.map(a => slice.incidence - a).reverse()];
    svg.append(
        svgElement("path", {
            class: "curve dashed",
            stroke: cssColor("--soft"),
            d: slicePath(alone, [...independent.phase, ...[...independent.phase].reverse()], limits)
        }),
        svgElement("path", {
            class: "curve",
            id: `slice-${index}`,
            stroke: ownColor(),
            d: slicePath(slice.angles, slice.p, limits)
        }),
        incidentArrow(slice.incidence)
    );
    polarTicks(svg, limits);
    return element(
        "figure",
        {class: "plot card polar"},
        element("figcaption", {}, `Light along ${formatNumber(slice.incidence, 3)}° to the axis`),
        svg,
        element(
            "div",
            {class: "keys-line"},
            lineKey({label: `this file (${page.results.mode})`, borderColor: ownColor()}),
            lineKey({label: "independent", borderColor: cssColor("--soft"), ...kDashed})
        )
    );
}

function makeSlices(section) {
    section.redraw = () => {
        const {slices, independent} = wavelengthShown();
        const limits = polarLimits(independent.phase, ...slices.map(slice => slice.p));
        fill(
            section,
            element("h2", {}, `Scattering at ${formatWavelength(wavelengthShown())}`),
            element(
                "p",
                {class: "lead"},
                "p in the plane of the axis, which points up, and the incident light, the arrow: logarithmic from the centre [1/sr]. Dashed is what the same particles would do far apart."
            ),
            element("div", {class: "plots"}, ...slices.map((slice, i) => sliceFigure(slice, i, limits)))
        );
    };
    section.redraw();
}

const kOfIncidences = {
    sigma_t: ["Extinction", "σₛ + σₐ [1/mm]", alone => alone.sigma_s + alone.sigma_a],
    albedo: ["Albedo", "σₛ / (σₛ + σₐ)", alone => alone.sigma_s / (alone.sigma_s + alone.sigma_a)],
    g: ["Mean cosine", "g", alone => alone.g]
};

function incidencePlots() {
    const {incidences, independent} = wavelengthShown();
    return Object.entries(kOfIncidences).map(([key, [title, axis, ofIndependent]]) => {
        const points = incidences.map(i => ({x: i.angle, y: i[key], error: i[`${key}_error`]}));
        const alone = [0, 90].map(x => ({x, y: ofIndependent(independent)}));
        const x = linearAxis("incidence [degrees to the axis]", {min: 0, max: 90});
        x.ticks.stepSize = 15;
        return [
            title,
            [
                lineDataset("independent", alone, cssColor("--soft"), kDashed),
                ...bandDatasets("mean ± 2 standard errors", points, ownColor(), false, points.length < 40 ? kDots : {})
            ],
            x,
            linearAxis(axis, key === "sigma_t" ? {beginAtZero: true} : {})
        ];
    });
}

function incidenceTable() {
    const w = page.wavelength,
        keys = {sigma_t: formatNumber, sigma_s: formatNumber, sigma_a: formatNumber, albedo: v => formatNumber(v, 4), g: v => formatNumber(v, 3)};
    const row = (entry, i) =>
        element(
            "tr",
            {},
            element("th", {scope: "row"}, `${formatNumber(entry.angle, 3)}°`),
            ...Object.entries(keys).map(([key, format]) => errorCell(`wavelengths.${w}.incidences.${i}`, key, entry, format))
        );
    const heads = [headCell("incidence"), headCell("extinction", "1/mm"), headCell("σₛ", "1/mm"), headCell("σₐ", "1/mm"), headCell("albedo"), headCell("g")];
    return element(
        "details",
        {class: "bulk-details"},
        element("summary", {}, `Numbers by incidence at ${formatWavelength(wavelengthShown())}`),
        element(
            "div",
            {class: "scroll card"},
            element(
                "table",
                {class: "numbers", id: "incidence-table"},
                element("thead", {}, element("tr", {}, ...heads)),
                element("tbody", {}, ...wavelengthShown().incidences.map(row))
            )
        )
    );
}
