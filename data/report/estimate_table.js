// Parameters as a table.

const kWorstRhat = 1.05,
    kMinEss = 100;

// A bar as long as the share that the photograph tells.
function toldCell(path, parameter) {
    const {told, told_by: by} = parameter;
    if (!isNumber(told)) return element("td", {class: "number"}, kMissing);
    const width = 72,
        bar = svgElement(
            "svg",
            {width, height: 10, viewBox: `0 0 ${width} 10`, "aria-hidden": "true"},
            svgElement("rect", {class: "told-back", x: 0, y: 1, width, height: 8, rx: 2}),
            svgElement("rect", {class: `told-bar ${by}`, x: 0, y: 1, width: told * width, height: 8, rx: 2})
        );
    const text = told > 0 && told < 0.005 ? "<1 %" : `${Math.round(100 * told)} %`;
    const ratio = numberSpan(`${path}.sd_ratio`, parameter.sd_ratio, formatNumber(parameter.sd_ratio, 2));
    return element("td", {class: "number told"}, bar, text, element("small", {}, "sd / prior sd ", ratio));
}

function parameterRow(parameter, i, hasTruth) {
    const path = `parameters.${i}`;
    const cell = (key, text, isLoud = false) =>
        element("td", {class: isLoud ? "number loud" : "number"}, numberSpan(`${path}.${key}`, parameter[key], text));
    const value = key => cell(key, formatBy(parameter[key], parameter.sd));
    const isOutside = isNumber(parameter.truth) && (parameter.truth < parameter.q5 || parameter.truth > parameter.q95);
    const truth = hasTruth && value("truth");
    if (truth && isOutside) truth.append(element("small", {class: "outside"}, "outside of 5–95 %"));
    const isProduct = parameter.factors.length > 0;
    const small = [parameter.name !== labelOf(parameter) && parameter.name, parameter.unit, isProduct && "a product"].filter(Boolean);
    const chains = hasChains
        ? [
              cell("rhat", isNumber(parameter.rhat) ? parameter.rhat.toFixed(3) : kMissing, parameter.rhat > kWorstRhat),
              ...["ess_bulk", "ess_tail"].map(key =>
                  cell(key, isNumber(parameter[key]) ? parameter[key].toFixed(0) : kMissing, isNumber(parameter[key]) && parameter[key] < kMinEss)
              )
          ]
        : [];
    return element(
        "tr",
        {class: isProduct ? "product" : false},
        element("th", {scope: "row"}, labelOf(parameter), small.length > 0 && element("small", {}, small.join(", "))),
        value("map"),
        truth,
        ...(page.results.map_only
            ? [cell("prior_sd", formatNumber(parameter.prior_sd, 2))]
            : [
                  value("mean"),
                  cell("sd", formatNumber(parameter.sd, 2)),
                  value("q5"),
                  value("q50"),
                  value("q95"),
                  cell("prior_sd", formatNumber(parameter.prior_sd, 2)),
                  toldCell(path, parameter)
              ]),
        ...chains
    );
}

// What the columns 5 % and 95 % are worth.
function meaningOfColumns() {
    const {map_only: isMapOnly, converged, calibrated} = page.results;
    if (isMapOnly) return "The most probable values. How far the truth may be from them was not computed.";
    if (!converged) return "What the draws say so far. It is not reliable yet: no column has a probability.";
    return (
        "Between the columns 5 % and 95 % lies the true value with 90 % probability if the model is right" +
        `${calibrated ? "" : " and so is the error that was set by hand"}; the mean alone is not the answer.`
    );
}

function makeParameters(section) {
    const {parameters, map_only: isMapOnly} = page.results,
        hasTruth = parameters.some(p => isNumber(p.truth));
    const heads = [
        headCell("parameter", "name, unit"),
        headCell("most probable", "all together"),
        hasTruth && headCell("true"),
        ...(isMapOnly
            ? [headCell("prior sd")]
            : [
                  headCell("mean"),
                  headCell("sd"),
                  headCell("5 %"),
                  headCell("median"),
                  headCell("95 %"),
                  headCell("prior sd"),
                  headCell(said("the photograph"), "narrows by")
              ]),
        ...(hasChains ? [headCell("R-hat"), headCell("ESS", "bulk"), headCell("ESS", "tails")] : [])
    ].filter(Boolean);
    fill(
        section,
        element("h2", {}, "Parameters"),
        element(
            "p",
            {class: "lead"},
            meaningOfColumns()
        ),
        element(
            "div",
            {class: "scroll card", tabindex: 0, role: "region", "aria-label": "Table of parameters"},
            element(
                "table",
                {class: "numbers", id: "parameter-table"},
                element("thead", {}, element("tr", {}, ...heads)),
                element("tbody", {}, ...parameters.map((parameter, i) => parameterRow(parameter, i, hasTruth)))
            )
        )
    );
}
