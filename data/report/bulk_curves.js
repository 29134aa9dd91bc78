// Plots over the wavelength, the number of realisations, and distances.

const withAlpha = (color, alpha) => {
    const hex = color.startsWith("#") ? color : "#808080";
    return hex + Math.round(255 * alpha).toString(16).padStart(2, "0");
};

function lineDataset(label, data, color, more = {}) {
    return {
        label,
        data,
        showLine: true,
        borderColor: color,
        backgroundColor: color,
        borderWidth: 2,
        pointRadius: 0,
        pointHitRadius: 6,
        tension: 0,
        fill: false,
        ...more
    };
}

const kDashed = {borderDash: [5, 4], borderWidth: 1.5};
const kDotted = {borderDash: [1.5, 3], borderWidth: 1.5};
const kDots = {pointRadius: 2.5};

// A line with a band of two standard errors: {x, y, error}. On logarithmic axes the band ends above zero.
function bandDatasets(label, points, color, isLog = false, more = {}) {
    const edge = sign => ({
        label: "",
        data: points.map(p => ({x: p.x, y: isLog ? Math.max(p.y / 20, p.y + 2 * sign * p.error) : p.y + 2 * sign * p.error})),
        showLine: true,
        borderWidth: 0,
        pointRadius: 0,
        pointHitRadius: 0,
        backgroundColor: withAlpha(color, 0.22),
        fill: sign > 0 ? "-1" : false,
        isEdge: true
    });
    const hasErrors = points.some(p => p.error > 0);
    return [...(hasErrors ? [edge(-1), edge(1)] : []), lineDataset(label, points, color, more)];
}

// A key of a plot: a line as it is drawn, and its name.
function lineKey({label, borderColor, borderDash, borderWidth = 2, pointRadius = 0}) {
    const line = svgElement("line", {x1: 0, y1: 5, x2: 26, y2: 5, stroke: borderColor, "stroke-width": borderWidth});
    if (borderDash) line.setAttribute("stroke-dasharray", borderDash.join(" "));
    const dot = svgElement("circle", {cx: 13, cy: 5, r: pointRadius, fill: borderColor});
    return element("span", {}, svgElement("svg", {viewBox: "0 0 26 10", "aria-hidden": "true"}, line, dot), label);
}

// {figure, show(): to be called when the figure is in the page, plot: from then on}
function plotFigure(title, datasets, x, y) {
    const canvas = element("canvas", {role: "img", "aria-label": title});
    const figure = element(
        "figure",
        {class: "plot card"},
        element("figcaption", {}, title),
        element("div", {class: "plot-area"}, canvas),
        element("div", {class: "keys-line"}, ...datasets.filter(d => !d.isEdge).map(lineKey))
    );
    const tip = item =>
        ` ${item.dataset.label}: ${formatNumber(item.parsed.y)}` +
        (item.raw.error > 0 ? ` ± ${formatNumber(2 * item.raw.error, 2)}` : "") +
        ` at ${formatNumber(item.parsed.x)}`;
    const options = {
        animation: false,
        responsive: true,
        maintainAspectRatio: false,
        locale: "en",
        interaction: {mode: "nearest", intersect: false},
        scales: {x, y},
        plugins: {
            legend: {display: false},
            tooltip: {
                callbacks: {title: () => "", label: tip},
                displayColors: false,
                filter: item => !item.dataset.isEdge
            }
        }
    };
    const result = {figure};
    result.show = () => {
        result.plot = new Chart(canvas, {type: "scatter", data: {datasets}, options});
    };
    return result;
}

// A section of plots that can be drawn again: list() gives [title, datasets, x axis, y axis] of each.
function makePlots(section, title, lead, list) {
    const holder = element("div", {class: "plots"}),
        head = element("h2", {});
    let plots = [];
    fill(section, head, element("p", {class: "lead"}, lead), holder);
    section.redraw = () => {
        head.textContent = title();
        plots.forEach(({plot}) => plot.destroy());
        plots = list().map(each => plotFigure(...each));
        fill(holder, ...plots.map(({figure}) => figure));
        plots.forEach(({show}) => show());
    };
    section.redraw();
}

// Over the wavelengths: what the file has, and dashed what independent particles do.
function spectrumPlots() {
    const {wavelengths, mode} = page.results,
        color = ownColor();
    const kinds = {
        sigma_s: ["Scattering coefficient σₛ", "σₛ [1/mm]"],
        sigma_a: ["Absorption coefficient σₐ", "σₐ [1/mm]"],
        g: ["Mean cosine g", "g"]
    };
    return Object.entries(kinds)
        .filter(([key]) => key !== "sigma_a" || wavelengths.some(w => w.sigma_a > 0 || w.independent.sigma_a > 0))
        .map(([key, [title, axis]]) => {
            const own = wavelengths.map(w => ({x: w.wavelength, y: w[key], error: w[`${key}_error`] || 0}));
            const alone = wavelengths.map(w => ({x: w.wavelength, y: w.independent[key]}));
            const marks = wavelengths.length < 30 ? kDots : {};
            const datasets = [
                ...(mode === "independent"
                    ? []
                    : [lineDataset("independent", alone, cssColor("--soft"), kDashed)]),
                ...bandDatasets(mode === "independent" ? "independent (Lorenz–Mie)" : "this file", own, color, false, marks)
            ];
            const limits = {min: wavelengths[0].wavelength, max: wavelengths[wavelengths.length - 1].wavelength};
            return [title, datasets, linearAxis("wavelength in vacuum [nm]", limits), linearAxis(axis, key === "g" ? {} : {beginAtZero: true})];
        });
}

const kCrossSections = {
    c_ext: ["Extinction", "cross section of a particle [µm²]"],
    c_sca: ["Scattering", "cross section of a particle [µm²]"],
    g: ["Mean cosine", "g"]
};

function convergencePlots() {
    const {history, independent} = wavelengthShown(),
        color = ownColor();
    return Object.entries(kCrossSections).map(([key, [title, axis]]) => {
        const points = history.map(r => ({x: r.realisations, y: r[key], error: r[`${key}_error`]}));
        const [first, last] = [points[0].x, points[points.length - 1].x];
        const alone = [first, last].map(x => ({x, y: independent[key]}));
        // Errors of the first few realisations would be all that the plot shows.
        const later = points.filter(p => p.x >= Math.min(6, last)),
            edges = [...later.flatMap(p => [p.y - 2 * p.error, p.y + 2 * p.error]), independent[key]];
        const [low, high] = [Math.min(...edges), Math.max(...edges)],
            margin = 0.08 * (high - low || Math.abs(high) || 1);
        return [
            title,
            [
                lineDataset("independent", alone, cssColor("--soft"), kDashed),
                ...bandDatasets("mean ± 2 standard errors", points, color, false, kDots)
            ],
            linearAxis("realisations", {min: first, max: last}),
            linearAxis(axis, {min: low - margin, max: high + margin})
        ];
    });
}

function structurePlots() {
    const {pairs} = page.results,
        color = ownColor();
    const points = (x, y) => x.map((each, i) => ({x: each, y: y[i]}));
    const plot = (title, x, own, other, xTitle, yTitle) => [
        title,
        [
            lineDataset("Percus–Yevick", points(x, other), cssColor("--soft"), kDashed),
            lineDataset(`${pairs.realisations} realisations`, points(x, own), color, {...kDots, borderWidth: 1})
        ],
        linearAxis(xTitle, {min: 0, max: x[x.length - 1]}),
        linearAxis(yTitle, {beginAtZero: true})
    ];
    return [
        plot("Structure factor", pairs.q_diameter, pairs.s, pairs.s_percus_yevick, "q times the mean diameter", "S(q)"),
        plot("Pair distribution", pairs.distance, pairs.g, pairs.g_percus_yevick, "distance over the mean diameter", "g(r)")
    ];
}
