// Correlations as a table of colours, and what the posterior predicts beside what the photograph has.

// Two digits without the zero before the point: "−.93".
const formatCorrelation = value =>
    isNumber(value) ? value.toFixed(2).replace("-", "−").replace(/^(−?)0\./, "$1.").replace(/^−\.00$/, ".00") : kMissing;

function heatCell(value, path, names, isSame) {
    if (isSame) return element("td", {class: "same"}, "");
    if (!isNumber(value)) return element("td", {}, kMissing);
    const [positive, negative] = chainColors(),
        strength = Math.min(1, Math.abs(value));
    const back = withAlpha(value < 0 ? negative : positive, 0.9 * strength);
    const ink = strength > 0.6 ? (isDark() ? "#15171b" : "#ffffff") : "inherit";
    return element(
        "td",
        {style: `background:${back};color:${ink}`, title: names.join(" and ")},
        numberSpan(path, value, formatCorrelation(value))
    );
}

function heatTable() {
    const {names, values} = page.results.correlations;
    const row = (name, a) =>
        element(
            "tr",
            {},
            element("th", {scope: "row"}, name),
            ...names.map((other, b) => heatCell(values[a][b], `correlations.values.${a}.${b}`, [name, other], a === b))
        );
    return element(
        "div",
        {class: "scroll card", tabindex: 0, role: "region", "aria-label": "Table of correlations"},
        element(
            "table",
            {class: "heat", id: "correlation-table"},
            element("thead", {}, element("tr", {}, element("td", {}), ...names.map(name => element("th", {scope: "col"}, element("span", {}, name))))),
            element("tbody", {}, ...names.map(row))
        )
    );
}

function makeCorrelations(section) {
    const plots = element("div", {}),
        table = element("div", {});
    fill(section, plots, element("h3", {}, "Correlations"), table);
    makeSmallPlots(
        plots,
        "What goes together",
        said(
            "The most correlated pairs, draw by draw. A narrow slanted cloud means that the photograph knows a combination of the two better than either: more of one with less of the other looks the same."
        ),
        false,
        () => page.results.pairs.map(pairPlot)
    );
    section.redraw = () => {
        plots.redraw();
        fill(table, heatTable());
    };
    fill(table, heatTable());
}

// A place on [0,1] for each summary; near the ends the photograph is unlike what is predicted.
function stripOf({shares, names}) {
    const width = 240,
        at = share => 6 + share * (width - 12);
    const strip = svgElement(
        "svg",
        {width, height: 22, viewBox: `0 0 ${width} 22`, role: "img", "aria-label": said("Place of the photograph among predictions")},
        svgElement("rect", {class: "strip-middle", x: at(0.05), y: 1, width: at(0.95) - at(0.05), height: 20, rx: 3})
    );
    shares.forEach((share, i) => {
        if (!isNumber(share)) return;
        const isOutside = share <= 0 || share >= 1;
        const dot = svgElement("circle", {class: isOutside ? "dot outside" : "dot", cx: at(share), cy: 11, r: isOutside ? 4 : 2.5});
        dot.append(svgElement("title", {}, `${names[i] || i}: ${formatPercent(share)}`));
        strip.append(dot);
    });
    return strip;
}

// Twice the smaller tail; of n predictions none can be below 2 / (n + 1).
const pValueOf = share => Math.max(2 * Math.min(share, 1 - share), 2 / (page.results.predicted + 1));

function checkRow(check, i) {
    const known = check.shares.map((share, k) => ({share, name: check.names[k] || String(k)})).filter(({share}) => isNumber(share));
    const outside = known.filter(({share}) => share <= 0 || share >= 1).length,
        expected = (2 * known.length) / (page.results.predicted + 1);
    const worst = [...known].sort((a, b) => pValueOf(a.share) - pValueOf(b.share)).slice(0, 3);
    const worstText = ({share, name}) => {
        const isLeast = share <= 0 || share >= 1;
        return element("li", {}, `${name} (${isLeast ? "p ≤" : "p ="} ${formatNumber(pValueOf(share), 2)})`);
    };
    return element(
        "tr",
        {},
        element("th", {scope: "row"}, check.family, check.held_out && element("span", {class: "badge"}, "not used")),
        element("td", {class: "number"}, String(known.length)),
        element("td", {class: outside > 3 + 3 * expected ? "number loud" : "number", "data-outside": i}, String(outside)),
        element("td", {class: "number"}, formatNumber(expected, 2)),
        element("td", {class: "strip"}, stripOf(check)),
        element("td", {class: "names"}, element("ul", {}, ...worst.map(worstText)))
    );
}

function checksTable() {
    const {checks, predicted} = page.results;
    const heads = [
        headCell("summaries of"),
        headCell("number"),
        headCell("outside", `of all ${predicted}`),
        headCell("outside", "by chance"),
        headCell(said("the photograph’s place"), "below … above all predictions"),
        headCell("farthest")
    ];
    return element(
        "div",
        {class: "scroll card", tabindex: 0, role: "region", "aria-label": "Table of predictions"},
        element(
            "table",
            {class: "numbers", id: "check-table"},
            element("thead", {}, element("tr", {}, ...heads)),
            element("tbody", {}, ...checks.map(checkRow))
        )
    );
}

function residualList() {
    const {residuals} = page.results,
        most = Math.max(...residuals.map(r => Math.abs(r.deviation)), 3);
    const bar = ({deviation}) => {
        const length = (60 * Math.abs(deviation)) / most,
            isLoud = Math.abs(deviation) > 3;
        return svgElement(
            "svg",
            {width: 130, height: 14, viewBox: "0 0 130 14", "aria-hidden": "true"},
            svgElement("line", {class: "zero", x1: 65, x2: 65, y1: 0, y2: 14}),
            svgElement("rect", {class: isLoud ? "residual loud" : "residual", x: deviation < 0 ? 65 - length : 65, y: 2, width: length, height: 10})
        );
    };
    return element(
        "ul",
        {class: "residuals", id: "residuals"},
        ...residuals.map((residual, i) =>
            element(
                "li",
                {},
                bar(residual),
                element("b", {class: "number"}, numberSpan(`residuals.${i}.deviation`, residual.deviation, formatNumber(residual.deviation, 2))),
                element("span", {}, residual.text)
            )
        )
    );
}

function makeChecks(section) {
    const {checks, residuals} = page.results;
    fill(
        section,
        element("h2", {}, said("Does the model look like the photograph?")),
        element(
            "p",
            {class: "lead"},
            isOfPhotograph
                ? "Numbers that describe a picture, of the photograph beside those of pictures that the posterior predicts. Dots should be spread evenly; dots that crowd at the ends are what the model gets wrong."
                : "Measured values beside those that the posterior predicts, noise included. Dots should be spread evenly; dots that crowd at the ends are what the model gets wrong."
        ),
        checks.length > 0 && checksTable(),
        residuals.length > 0 && element("h3", {}, "Largest differences", element("small", {}, "in standard deviations; chance stays mostly within 3")),
        residuals.length > 0 && residualList()
    );
}
