// Error over time, on logarithmic axes: one line an estimator, and the slope that independent samples have.

// RMSE of independent samples falls with the root of their number: a line through the baseline's middle point.
function expectedSlope(points, from, to) {
    if (points.length === 0) return [];
    const middle = points[Math.floor(points.length / 2)],
        at = x => ({x, y: middle.y * Math.sqrt(middle.x / x)});
    return [at(from), at(to)];
}

function curvePoints(box, axis) {
    return ((box || {}).convergence || [])
        .map(p => ({x: p[axis], y: p.rmse}))
        .filter(p => isNumber(p.x) && isNumber(p.y) && p.x > 0 && p.y > 0);
}

function plotData(variant, boxIndex, axis) {
    const curves = variant.estimators.map(e => ({
        name: e.name,
        points: curvePoints(e.boxes[boxIndex], axis)
    }));
    const times = curves.flatMap(c => c.points.map(p => p.x));
    const baseline = curves.find(c => c.name === page.results.baseline) || curves[0];
    const datasets = curves
        .filter(c => c.points.length > 0)
        .map(c => ({
            label: c.name,
            data: c.points,
            showLine: true,
            borderColor: colorOf(c.name),
            backgroundColor: colorOf(c.name),
            borderWidth: 2,
            pointRadius: 4,
            pointHoverRadius: 6,
            pointBorderWidth: 1.5,
            pointStyle: markOf(c.name),
            tension: 0
        }));
    if (times.length > 0)
        datasets.push({
            label: "slope −1/2",
            data: expectedSlope(baseline.points, Math.min(...times), Math.max(...times)),
            showLine: true,
            borderColor: cssColor("--soft"),
            backgroundColor: cssColor("--soft"),
            borderWidth: 1.25,
            borderDash: [5, 4],
            pointRadius: 0,
            pointHitRadius: 0,
            pointStyle: "line"
        });
    return {datasets};
}

const kAxisTitles = {seconds: "seconds of rendering", samples_per_pixel: "samples per pixel"};

function plotOptions(axis, boxName, data) {
    const points = data.datasets.flatMap(d => d.data);
    const tip = item =>
        ` ${item.dataset.label}: RMSE ${formatNumber(item.parsed.y)} at ${formatNumber(item.parsed.x)} ` +
        (axis === "seconds" ? "s" : "samples per pixel");
    return {
        animation: false,
        responsive: true,
        maintainAspectRatio: false,
        locale: "en",
        interaction: {mode: "nearest", intersect: false},
        scales: {
            x: logAxis(
                kAxisTitles[axis],
                points.map(p => p.x)
            ),
            y: logAxis(
                `RMSE, ${boxName}`,
                points.map(p => p.y)
            )
        },
        plugins: {
            legend: {
                position: "bottom",
                labels: {usePointStyle: true, color: cssColor("--ink"), padding: 16}
            },
            tooltip: {callbacks: {title: () => "", label: tip}, displayColors: false}
        }
    };
}

let plots = [];
let plotAxis = "seconds";

function drawPlots(holder) {
    plots.forEach(plot => plot.destroy());
    plots = [];
    const variant = variantShown();
    fill(holder);
    useFontOfPage();
    page.results.boxes.forEach((box, b) => {
        const data = plotData(variant, b, plotAxis);
        const canvas = element("canvas", {
            role: "img",
            "aria-label": `RMSE over ${kAxisTitles[plotAxis]}, ${box.name}`
        });
        const figure = element(
            "figure",
            {class: "plot card"},
            element("figcaption", {}, box.name),
            data.datasets.length > 0
                ? element("div", {class: "plot-area"}, canvas)
                : element("p", {class: "absent"}, "No measurements over time.")
        );
        holder.append(figure);
        if (data.datasets.length > 0)
            plots.push(
                new Chart(canvas, {type: "scatter", data, options: plotOptions(plotAxis, box.name, data)})
            );
    });
}

function makeConvergence(section) {
    const holder = element("div", {class: "plots"});
    fill(
        section,
        element("h2", {}, "Convergence"),
        element(
            "p",
            {class: "lead"},
            "RMSE as the render goes on. Independent samples of finite variance follow the dashed " +
                "slope of −1/2. A curve that flattens has met a bias, or the noise of the reference."
        ),
        element(
            "div",
            {class: "tools"},
            element("span", {}, "Horizontal axis"),
            segments("Horizontal axis", {seconds: "time", samples_per_pixel: "samples"}, plotAxis, axis => {
                plotAxis = axis;
                drawPlots(holder);
            })
        ),
        holder
    );
    drawPlots(holder);
    section.redraw = () => drawPlots(holder);
}
