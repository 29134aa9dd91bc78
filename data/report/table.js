// The table: every number of the experiment that a reader compares.

const kLoudBias = 3.5; // standard errors; chance alone goes beyond once in 2000 boxes

const isLoudBias = bias => Boolean(bias) && isNumber(bias.z) && Math.abs(bias.z) > kLoudBias;

const reductionName = () => (equalTime() ? "Time reduction" : "Sample reduction");

function tableHead() {
    const columns = [
        [headingNoun()],
        ["Samples", "per pixel"],
        ["Cost", "µs / sample"],
        ["RMSE", "95 % interval"],
        ["RMSE reduction", "95 % interval"],
        ["", ""],
        [reductionName(), "its square"],
        ["Relative MSE", "95 % interval"],
        ...(ofDenoisers()
            ? [
                  ["FLIP", "mean of the runs"],
                  ["Systematic", "the same in all runs"]
              ]
            : [["Bias", "standard errors"]]),
        ["Reference noise", "share of MSE"]
    ];
    return element(
        "thead",
        {},
        element(
            "tr",
            {},
            ...columns.map(([name, unit], i) =>
                element(
                    "th",
                    {scope: "col", class: i === 5 ? "whisker-column" : null},
                    name,
                    unit && element("small", {}, unit)
                )
            )
        )
    );
}

// The least and greatest reduction of a variant, 1 among them: the common axis of the whiskers.
function reductionRange(variant) {
    let low = 1,
        high = 1;
    for (const estimator of variant.estimators)
        for (const box of estimator.boxes)
            for (const v of Object.values(box.rmse_reduction || {}))
                if (isNumber(v) && v > 0) {
                    low = Math.min(low, v);
                    high = Math.max(high, v);
                }
    return {low: low / 1.08, high: high * 1.08};
}

// A dot with its interval on a logarithmic axis; the line is 1, the baseline.
function whisker(reduction, range, name) {
    const cell = element("td", {class: "whisker-column"});
    if (valueOf(reduction) === null || reduction.value <= 0) return cell;
    const width = 84,
        x = v => (width * Math.log(v / range.low)) / Math.log(range.high / range.low);
    const svg = svgElement("svg", {
        viewBox: `0 0 ${width} 20`,
        width,
        height: 20,
        role: "img",
        "aria-label": `RMSE reduction ${formatNumber(reduction.value)}`
    });
    svg.append(svgElement("line", {class: "one", x1: x(1), x2: x(1), y1: -14, y2: 34}));
    if (hasInterval(reduction) && reduction.low > 0)
        svg.append(
            svgElement("line", {
                class: "span",
                x1: x(reduction.low),
                x2: x(reduction.high),
                y1: 10,
                y2: 10,
                style: `stroke:${colorOf(name)}`
            })
        );
    svg.append(
        svgElement("circle", {cx: x(reduction.value), cy: 10, r: 3.25, style: `fill:${colorOf(name)}`})
    );
    cell.append(svg);
    return cell;
}

function biasCell(path, bias) {
    const z = bias && isNumber(bias.z) ? bias.z : null;
    const loud = isLoudBias(bias);
    const cell = element(
        "td",
        {class: loud ? "number loud" : "number"},
        numberSpan(`${path}.bias.z`, z, z === null ? kMissing : (z < 0 ? "−" : "+") + Math.abs(z).toFixed(2))
    );
    if (z !== null && isNumber(bias.relative))
        cell.append(
            element(
                "small",
                {},
                numberSpan(
                    `${path}.bias.relative`,
                    bias.relative,
                    (bias.relative < 0 ? "−" : "+") + formatPercent(Math.abs(bias.relative))
                )
            )
        );
    if (loud) cell.append(element("strong", {class: "flag"}, "biased?"));
    return cell;
}

// Of denoisers: a mean that is right says nothing about pixels, so what all runs share is told, and FLIP.
function systematicCell(path, box) {
    const share = box.systematic_share;
    return element(
        "td",
        {class: "number"},
        numberSpan(`${path}.systematic_share`, share, isNumber(share) ? formatPercent(share) : kMissing),
        element("small", {}, "of the squared error")
    );
}

function flipCell(path, box) {
    return element(
        "td",
        {class: "number"},
        numberSpan(`${path}.flip`, box.flip, isNumber(box.flip) ? formatNumber(box.flip) : kMissing)
    );
}

function referenceNoiseCell(path, box) {
    const share = box.reference_noise_share,
        corrected = box.rmse_corrected;
    const cell = element(
        "td",
        {class: "number"},
        numberSpan(`${path}.reference_noise_share`, share, formatPercent(share))
    );
    if (isNumber(corrected))
        cell.append(
            element(
                "small",
                {title: "RMSE without the noise of the reference"},
                "without: ",
                numberSpan(`${path}.rmse_corrected`, corrected, formatNumber(corrected))
            )
        );
    return cell;
}

// The badge of those who lead; "indistinguishable" where there are several.
function verdictBadge(leaders, name) {
    if (!leaders.includes(name)) return false;
    return element("span", {class: "badge"}, leaders.length > 1 ? "indistinguishable" : "least error");
}

function tableRow(variant, estimatorIndex, boxIndex, range, leaders) {
    const estimator = variant.estimators[estimatorIndex],
        box = estimator.boxes[boxIndex] || {};
    const path = `variants.${page.variant}.estimators.${estimatorIndex}`,
        boxPath = `${path}.boxes.${boxIndex}`;
    const isBaseline = estimator.name === page.results.baseline;
    return element(
        "tr",
        {class: leaders.includes(estimator.name) ? "best" : null},
        element(
            "th",
            {scope: "row"},
            estimatorName(estimator.name),
            verdictBadge(leaders, estimator.name),
            isBaseline && element("span", {class: "badge plain"}, "baseline"),
            estimator.approximate && element("span", {class: "badge plain"}, "approximation")
        ),
        element(
            "td",
            {class: "number"},
            numberSpan(
                `${path}.samples_per_pixel`,
                estimator.samples_per_pixel,
                formatNumber(estimator.samples_per_pixel)
            ),
            isNumber(estimator.seconds) &&
                element(
                    "small",
                    {},
                    "in ",
                    numberSpan(`${path}.seconds`, estimator.seconds, formatNumber(estimator.seconds)),
                    " s"
                )
        ),
        element(
            "td",
            {class: "number"},
            numberSpan(
                `${path}.microseconds_per_sample`,
                estimator.microseconds_per_sample,
                formatNumber(estimator.microseconds_per_sample)
            )
        ),
        intervalCell(`${boxPath}.rmse`, box.rmse),
        intervalCell(`${boxPath}.rmse_reduction`, box.rmse_reduction, formatRatio, " ×"),
        whisker(box.rmse_reduction, range, estimator.name),
        intervalCell(`${boxPath}.time_reduction`, box.time_reduction, formatRatio, " ×"),
        intervalCell(`${boxPath}.relative_mse`, box.relative_mse),
        ...(ofDenoisers()
            ? [flipCell(boxPath, box), systematicCell(boxPath, box)]
            : [biasCell(boxPath, box.bias)]),
        referenceNoiseCell(boxPath, box)
    );
}

const boxPlace = box => `x ${box.pixels[0]}–${box.pixels[1]}, y ${box.pixels[2]}–${box.pixels[3]}`;

function numbersTable(variant) {
    const table = element("table", {class: "numbers"}, tableHead()),
        range = reductionRange(variant);
    page.results.boxes.forEach((box, boxIndex) => {
        const leaders = leadersOf(variant, boxIndex);
        table.append(
            element(
                "tbody",
                {"data-box": box.name},
                element(
                    "tr",
                    {class: "group"},
                    element(
                        "th",
                        {scope: "rowgroup", colspan: ofDenoisers() ? 11 : 10},
                        element("span", {}, box.name),
                        element("small", {}, boxPlace(box))
                    )
                ),
                ...variant.estimators.map((_, i) =>
                    tableRow(variant, i, boxIndex, range, leaders)
                )
            )
        );
    });
    return table;
}

// What happened in each run, for those who doubt a mean.
function runsTable(variant) {
    const rows = [];
    variant.estimators.forEach((estimator, e) =>
        (estimator.runs || []).forEach((run, r) => {
            const path = `variants.${page.variant}.estimators.${e}.runs.${r}`;
            const cell = (field, format) =>
                element(
                    "td",
                    {class: "number"},
                    numberSpan(
                        `${path}.${field}`,
                        run[field],
                        isNumber(run[field]) ? format(run[field]) : kMissing
                    )
                );
            rows.push(
                element(
                    "tr",
                    {},
                    element("th", {scope: "row"}, estimatorName(estimator.name)),
                    element("td", {class: "number"}, String(r + 1)),
                    cell("seed", String),
                    cell("samples_per_pixel", v => formatNumber(v, 4)),
                    cell("samples_least", String),
                    cell("samples_most", String),
                    cell("seconds", v => formatNumber(v, 4)),
                    cell("load_seconds", v => formatNumber(v, 2)),
                    cell("bad_samples", String)
                )
            );
        })
    );
    const names = [
        headingNoun(),
        "Run",
        "Seed",
        "Samples per pixel",
        "Least",
        "Most",
        "Seconds",
        "Loading, not counted [s]",
        "Invalid samples"
    ];
    return element(
        "details",
        {class: "runs"},
        element("summary", {}, `Every run (${rows.length})`),
        element(
            "div",
            {class: "scroll"},
            element(
                "table",
                {class: "numbers plain"},
                element("thead", {}, element("tr", {}, ...names.map(n => element("th", {scope: "col"}, n)))),
                element("tbody", {}, ...rows)
            )
        )
    );
}

// With several variants: the reduction of each, box by box.
function variantsTable() {
    const {results} = page,
        first = results.variants[0].estimators;
    const head = element(
        "tr",
        {},
        element("th", {scope: "col"}, "RMSE reduction"),
        ...first.map(e => element("th", {scope: "col"}, e.name))
    );
    const table = element("table", {class: "numbers plain"}, element("thead", {}, head));
    results.boxes.forEach((box, b) => {
        const rows = results.variants.map((variant, v) =>
            element(
                "tr",
                {class: v === page.variant ? "shown" : null},
                element("th", {scope: "row"}, variant.label),
                ...first.map((_, e) =>
                    intervalCell(
                        `variants.${v}.estimators.${e}.boxes.${b}.rmse_reduction`,
                        ((variant.estimators[e] || {boxes: []}).boxes[b] || {}).rmse_reduction,
                        formatRatio,
                        " ×"
                    )
                )
            )
        );
        table.append(
            element(
                "tbody",
                {},
                element(
                    "tr",
                    {class: "group"},
                    element("th", {scope: "rowgroup", colspan: 1 + first.length}, box.name)
                ),
                ...rows
            )
        );
    });
    return element("div", {class: "scroll"}, table);
}

function makeNumbers(section) {
    const variant = variantShown();
    fill(
        section,
        element("h2", {}, "Numbers"),
        element(
            "p",
            {class: "lead"},
            "RMSE is the error of one run: in each pixel the root of the mean squared difference from the " +
                "reference over the runs, then the mean over the box; smaller is better. The reduction is the " +
                `baseline's RMSE divided by that of the ${noun()}; greater is better. Noise falls with the root of the ` +
                `work, so its square says how many times the ${equalTime() ? "time" : "samples"} the baseline ` +
                "would need. " +
                (ofDenoisers()
                    ? "A denoiser's error is the same in all runs in part, which more samples take away slowly and more " +
                      "runs never: such images are biased, whatever their mean."
                    : "A bias of a few standard errors is chance; beyond 3.5 it is marked.")
        ),
        element("div", {class: "scroll card"}, numbersTable(variant)),
        runsTable(variant),
        page.results.variants.length > 1 && element("h3", {}, "All variants"),
        page.results.variants.length > 1 && variantsTable()
    );
}
