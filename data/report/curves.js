// Plots of curves with bands: what pages other than those of comparisons draw.

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

// A key of a plot: a line or a mark as it is drawn, and its name.
function lineKey({label, borderColor, borderDash, borderWidth = 2, pointRadius = 0, pointStyle, showLine = true}) {
    const drawing = svgElement("svg", {viewBox: "0 0 26 10", "aria-hidden": "true"}),
        stroke = {stroke: borderColor, "stroke-width": borderWidth};
    if (showLine) {
        const line = svgElement("line", {x1: 0, y1: 5, x2: 26, y2: 5, ...stroke});
        if (borderDash) line.setAttribute("stroke-dasharray", borderDash.join(" "));
        drawing.append(line);
    }
    if (pointStyle === "crossRot") drawing.append(svgElement("path", {d: "M9,1L17,9M17,1L9,9", ...stroke}));
    else if (pointStyle === "rectRot") drawing.append(svgElement("path", {d: "M13,0L18,5L13,10L8,5Z", fill: borderColor}));
    else drawing.append(svgElement("circle", {cx: 13, cy: 5, r: pointRadius, fill: borderColor}));
    return element("span", {}, drawing, label);
}

// {figure, show(): to be called when the figure is in the page, plot: from then on}
function plotFigure(title, datasets, x, y, hasKeys = true) {
    const canvas = element("canvas", {role: "img", "aria-label": title});
    const figure = element(
        "figure",
        {class: "plot card"},
        element("figcaption", {}, title),
        element("div", {class: "plot-area"}, canvas),
        hasKeys && element("div", {class: "keys-line"}, ...datasets.filter(d => !d.isEdge).map(lineKey))
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
