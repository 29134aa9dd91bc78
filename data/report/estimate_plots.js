// Distributions, chains and pairs of parameters.

const chainColors = () => (isDark() ? kColorsOnDark : kColors);
const axisTitle = parameter => (parameter.unit ? `${labelOf(parameter)} [${parameter.unit}]` : labelOf(parameter));
const kPlainAxis = {display: false, min: 0};

// Corners of a histogram's steps.
function stepsOf({from, step, densities}) {
    const points = [{x: from, y: 0}];
    densities.forEach((y, i) => points.push({x: from + i * step, y}, {x: from + (i + 1) * step, y}));
    return [...points, {x: from + densities.length * step, y: 0}];
}

const verticalLine = (label, x, top, color, more) =>
    isNumber(x)
        ? [
              lineDataset(
                  label,
                  [
                      {x, y: 0},
                      {x, y: top}
                  ],
                  color,
                  {borderWidth: 1.5, ...more}
              )
          ]
        : [];

let isCloseUp = false;

function marginalPlot(parameter) {
    const [own, other, third] = chainColors(),
        {histogram, prior_curve: prior} = parameter;
    const steps = stepsOf(histogram),
        top = Math.max(...histogram.densities);
    const low = steps[0].x,
        high = steps[steps.length - 1].x;
    const curve = prior ? prior.x.map((x, i) => ({x, y: prior.y[i]})) : [];
    const inside = [...verticalLine("most probable", parameter.map, top, other), ...verticalLine("true", parameter.truth, top, third, kDashed)];
    const xs = [low, high, ...inside.map(d => d.data[0].x), ...(isCloseUp ? [] : curve.map(p => p.x))];
    const margin = 0.04 * (Math.max(...xs) - Math.min(...xs));
    const limits = {min: Math.min(...xs) - margin, max: Math.max(...xs) + margin};
    // What is beyond the limits would be drawn outside of the plot's area.
    const visible = curve.filter(p => p.x >= limits.min && p.x <= limits.max);
    const datasets = [
        ...inside,
        lineDataset("prior", visible, cssColor("--soft"), kDashed),
        lineDataset("posterior", steps, own, {fill: "origin", backgroundColor: withAlpha(own, 0.3), borderWidth: 1.5})
    ];
    const axis = linearAxis(axisTitle(parameter), limits);
    axis.ticks.maxTicksLimit = 6;
    return [labelOf(parameter), datasets, axis, linearAxis("", {...kPlainAxis, max: 1.08 * Math.max(top, ...visible.map(p => p.y))}), false];
}

// A grid of small plots, with one legend for all of them.
function makeSmallPlots(section, title, lead, tools, list) {
    const holder = element("div", {class: "plots small-plots"}),
        keys = element("div", {class: "keys-line shared"});
    let plots = [];
    fill(section, element("h2", {}, title), element("p", {class: "lead"}, lead), tools, keys, holder);
    section.redraw = () => {
        plots.forEach(({plot}) => plot.destroy());
        const all = list(),
            named = new Map(all.flatMap(([, datasets]) => datasets.filter(d => d.label)).map(d => [d.label, d]));
        fill(keys, ...[...named.values()].map(lineKey));
        plots = all.map(each => plotFigure(...each));
        fill(holder, ...plots.map(({figure}) => figure));
        plots.forEach(({show}) => show());
    };
    section.redraw();
}

function makeMarginals(section) {
    const range = segments("Range of the plots", {prior: "all that was assumed", posterior: "close up"}, "prior", value => {
        isCloseUp = value === "posterior";
        section.redraw();
    });
    makeSmallPlots(
        section,
        "Distributions",
        said(
            "Where each parameter lies after the photograph (filled) and before it (dashed). A filled shape that is much narrower than the dashed line was found in the photograph; one that follows it was only assumed."
        ),
        element("div", {class: "tools"}, element("span", {}, "Range"), range),
        () => page.results.parameters.filter(p => p.histogram).map(marginalPlot)
    );
}

function tracePlot(parameter) {
    const {every, chains} = parameter.traces;
    const datasets = chains.map((values, c) =>
        lineDataset(
            `chain ${c + 1}`,
            values.map((y, i) => ({x: i * every, y})),
            chainColors()[c],
            {borderWidth: 1, pointHitRadius: 2}
        )
    );
    const y = linearAxis(parameter.unit);
    y.ticks.maxTicksLimit = 5;
    y.title.display = Boolean(parameter.unit);
    const last = every * (Math.max(...chains.map(values => values.length)) - 1);
    return [labelOf(parameter), datasets, linearAxis("draw", {min: 0, max: Math.max(1, last)}), y, false];
}

function wavesTable() {
    const {waves} = page.results;
    if (waves.length === 0) return [];
    const row = (wave, i) => {
        const cell = (key, digits) =>
            element("td", {class: "number"}, numberSpan(`waves.${i}.${key}`, wave[key], formatNumber(wave[key], digits)));
        return element(
            "tr",
            {},
            element("th", {scope: "row"}, String(i)),
            element("td", {class: "number"}, numberSpan(`waves.${i}.runs`, wave.runs, isNumber(wave.runs) ? String(wave.runs) : kMissing)),
            cell("shift", 2),
            cell("misfit", 3),
            cell("acceptance", 2),
            cell("rhat", 4)
        );
    };
    const heads = [
        headCell("wave"),
        headCell("simulations", "behind it"),
        headCell("means moved", "in sd, the largest"),
        headCell("χ²/p", "at the mean"),
        headCell("acceptance", "of the walks"),
        headCell("R-hat", "the largest")
    ];
    return [
        element("h3", {}, "Waves of simulations"),
        element(
            "p",
            {class: "lead"},
            "Each wave simulates the material where the one before found it. When the means move by less than a fifth of their standard deviation, another wave changes little."
        ),
        element(
            "div",
            {class: "scroll card"},
            element("table", {class: "numbers", id: "waves"}, element("thead", {}, element("tr", {}, ...heads)), element("tbody", {}, ...waves.map(row)))
        )
    ];
}

function makeChains(section) {
    const plots = element("div", {}),
        withTraces = page.results.parameters.filter(p => p.traces && p.factors.length === 0);
    fill(section, plots, ...wavesTable());
    if (withTraces.length === 0) return fill(plots, element("h2", {}, "Simulations"));
    makeSmallPlots(
        plots,
        "Chains",
        "Each line is one chain’s way through the values that are possible. Good chains lie over each other like static; chains that stay apart, or drift, have not converged.",
        false,
        () => withTraces.map(tracePlot)
    );
    section.redraw = plots.redraw;
}

function pairPlot({a, b, x, y, correlation}) {
    const [own, other, third] = chainColors(),
        [first, second] = [a, b].map(parameterNamed);
    const mark = (label, key, color, style) =>
        isNumber(first[key]) && isNumber(second[key])
            ? [lineDataset(label, [{x: first[key], y: second[key]}], color, {showLine: false, pointRadius: 7, pointStyle: style, borderWidth: 2.5})]
            : [];
    const draws = lineDataset("draws", x.map((value, i) => ({x: value, y: y[i]})), own, {
        showLine: false,
        pointRadius: 1.8,
        pointBorderWidth: 0,
        backgroundColor: withAlpha(own, 0.45)
    });
    const axes = [first, second].map(parameter => linearAxis(axisTitle(parameter)));
    axes.forEach(axis => (axis.ticks.maxTicksLimit = 6));
    return [
        `${labelOf(first)} and ${labelOf(second)}: ${formatCorrelation(correlation)}`,
        [...mark("most probable", "map", other, "crossRot"), ...mark("true", "truth", third, "rectRot"), draws],
        ...axes,
        false
    ];
}
