// The top of the page: what was compared, what came out, and how it was run.

const baseName = path =>
    String(path || "")
        .replace(/^.*\/(?=[^/]*\.pbrt)/, "")
        .replace(/\.pbrt(\.gz)?$/, "");

const equalTime = () => !page.results.budget || page.results.budget.kind !== "samples";

function budgetText() {
    const budget = page.results.budget || {};
    if (isNumber(budget.seconds)) return `${formatSeconds(budget.seconds)} of rendering a run`;
    if (isNumber(budget.samples_per_pixel)) return `${budget.samples_per_pixel} samples per pixel a run`;
    return kMissing;
}

const verdictOf = (estimator, boxIndex) => (estimator.boxes[boxIndex] || {}).verdict;

// {estimator, index} of the least error in a box, or null.
function bestOf(variant, boxIndex) {
    const index = variant.estimators.findIndex(e => verdictOf(e, boxIndex) === "best");
    return index < 0 ? null : {estimator: variant.estimators[index], index};
}

// The names of all that share the first place in a box, the least error first.
function leadersOf(variant, boxIndex) {
    const named = verdict =>
        variant.estimators.filter(e => verdictOf(e, boxIndex) === verdict).map(e => e.name);
    return [...named("best"), ...named("indistinguishable")];
}

// Nodes with commas, and "and" before the last.
function enumeration(names) {
    return names.flatMap((name, i) => [
        i === 0 ? "" : i === names.length - 1 ? " and " : ", ",
        estimatorName(name)
    ]);
}

// One sentence a box: who has the least error, how much more the baseline has, and whether to believe it.
function findingSentence(variant, boxIndex) {
    const best = bestOf(variant, boxIndex),
        baseline = page.results.baseline;
    if (!best)
        return ["Who has the least error cannot be told: most of what was measured of some is the reference's noise."];
    const name = best.estimator.name,
        leaders = leadersOf(variant, boxIndex);
    if (variant.estimators.length === 1) return ["Only ", estimatorName(name), " was measured."];
    const {rmse_reduction: reduction, time_reduction: time, bias} = best.estimator.boxes[boxIndex];
    const isTie = leaders.length > 1;
    if (isTie && leaders.includes(baseline))
        return [...enumeration(leaders), " are indistinguishable: none has shown less error than the baseline."];
    if (name === baseline) return [estimatorName(name), ", the baseline, has the least error."];
    if (valueOf(reduction) === null) return [estimatorName(name), " has the least error."];
    const path = `variants.${page.variant}.estimators.${best.index}.boxes.${boxIndex}`;
    const factor = (field, value) =>
        element("strong", {}, numberSpan(`${path}.${field}`, value, `${formatRatio(value)}\u00a0×`));
    const sentence = [
        ...enumeration(leaders),
        isTie ? " are indistinguishable. " : " is best. ",
        equalTime() ? "In equal time " : "At equal samples ",
        estimatorName(baseline),
        " has ",
        factor("rmse_reduction.value", reduction.value),
        ...(isTie ? [" the error of ", estimatorName(name)] : [" its error"])
    ];
    if (hasInterval(reduction))
        sentence.push(` (${formatRatio(reduction.low)}\u00a0–\u00a0${formatRatio(reduction.high)})`);
    if (valueOf(time) === null) sentence.push(".");
    else
        sentence.push(
            " and needs ",
            factor("time_reduction.value", time.value),
            ` the ${equalTime() ? "time" : "samples"} to match it.`
        );
    if (isLoudBias(bias))
        sentence.push(element("strong", {class: "loud"}, " But its mean differs from the reference."));
    const {systematic_share: share} = best.estimator.boxes[boxIndex];
    if (ofDenoisers() && best.estimator.approximate && isNumber(share))
        sentence.push(
            " Of its squared error ",
            numberSpan(`${path}.systematic_share`, share, formatPercent(share)),
            " is the same in all runs: a bias."
        );
    return sentence;
}

const estimatorName = name => element("span", {class: "estimator"}, swatch(name), name);

function factsList() {
    const {results} = page,
        machine = results.machine || {},
        reference = variantShown().reference || {};
    const referenceText =
        reference.source === "file"
            ? "read from a file"
            : [
                  reference.estimator,
                  isNumber(reference.samples_per_pixel) && `${formatNumber(reference.samples_per_pixel)} samples per pixel`
              ]
                  .filter(Boolean)
                  .join(", ") || kMissing;
    const noise = {
        measured: "measured from its parts",
        estimated: "estimated from how the runs agree with it"
    };
    const facts = {
        Budget: budgetText(),
        Runs: isNumber(results.runs)
            ? `${results.runs} for each ${noun()}, interleaved, each with its own seed`
            : kMissing,
        Image: (results.resolution || []).join(" × ") + " pixels",
        Reference: referenceText,
        "Its noise": noise[reference.noise] || kMissing,
        Machine:
            [machine.processor, isNumber(machine.threads) && `${machine.threads} threads`, machine.system]
                .filter(Boolean)
                .join(", ") || kMissing,
        Version: `Lacquer ${results.version || kMissing}`,
        Created: String(results.created || kMissing)
            .replace("T", " ")
            .replace("Z", " UTC")
    };
    const list = element("dl", {class: "facts"});
    for (const [name, text] of Object.entries(facts))
        list.append(element("dt", {}, name), element("dd", {}, text));
    return list;
}

function commandBlock() {
    const command = String(page.results.command || "");
    const copy = button(
        "Copy",
        "Copy the command",
        async () => {
            await navigator.clipboard
                .writeText(command)
                .then(
                    () => "Copied",
                    () => "Select and copy by hand"
                )
                .then(text => {
                    copy.textContent = text;
                });
            setTimeout(() => {
                copy.textContent = "Copy";
            }, 1500);
        },
        {class: "quiet"}
    );
    return element(
        "div",
        {class: "command"},
        element("pre", {tabindex: 0}, element("code", {id: "command"}, ...commandWords(command))),
        copy
    );
}

function downloadLink() {
    // The text as the page holds it: the same value as the file's.
    const blob = new Blob([JSON.stringify(page.results, null, 2) + "\n"], {type: "application/json"});
    return element(
        "a",
        {id: "download", href: URL.createObjectURL(blob), download: "results.json"},
        "Download results.json"
    );
}

function makeHead(section) {
    const {results} = page,
        variant = variantShown();
    const findings = element("ul", {class: "findings"});
    results.boxes.forEach((box, index) =>
        findings.append(
            element(
                "li",
                {},
                element("span", {class: "box-name"}, box.name),
                element("span", {}, ...findingSentence(variant, index))
            )
        )
    );
    fill(
        section,
        element("p", {class: "kicker"}, equalTime() ? "Equal-time comparison" : "Equal-sample comparison"),
        element("h1", {}, baseName(results.scene) || "Comparison"),
        element("p", {class: "path"}, String(results.scene || "")),
        results.complete === false &&
            element(
                "p",
                {class: "notice", role: "note", id: "incomplete"},
                element("strong", {}, "Stopped early. "),
                "The experiment did not reach all its runs; the numbers below are of those that finished."
            ),
        variant.label && element("p", {class: "variant-label"}, variant.label),
        findings,
        element(
            "div",
            {class: "columns"},
            factsList(),
            element(
                "div",
                {},
                element("h2", {class: "small"}, "The exact command"),
                commandBlock(),
                downloadLink()
            )
        )
    );
}

// The strip that stays: the way around, the variant, and the exposure of every image.
function makeBar(bar, onVariant, onExposure) {
    const {results} = page;
    const links = {
        Numbers: "numbers",
        Crops: "crops",
        Viewer: "viewer",
        Convergence: "convergence",
        Method: "method"
    };
    const nav = element(
        "nav",
        {"aria-label": "Parts of the page"},
        ...Object.entries(links).map(([name, id]) => element("a", {href: `#${id}`}, name))
    );
    const parts = [nav];
    if (results.variants.length > 1) {
        const select = element(
            "select",
            {id: "variant", onchange: () => onVariant(Number(select.value))},
            ...results.variants.map((variant, i) =>
                element("option", {value: i}, variant.label || `variant ${i + 1}`)
            )
        );
        parts.push(element("label", {class: "control"}, element("span", {}, "Variant"), select));
    }
    const stops = element("output", {id: "stops"}, "0 stops");
    const slider = element("input", {
        id: "exposure",
        type: "range",
        min: -10,
        max: 10,
        step: 0.25,
        value: 0,
        oninput: () => onExposure(Number(slider.value)),
        ondblclick: () => onExposure(0)
    });
    bar.showExposure = value => {
        slider.value = value;
        const sign = value > 0 ? "+" : value < 0 ? "−" : "";
        stops.textContent = `${sign}${Math.abs(value)} ${Math.abs(value) === 1 ? "stop" : "stops"}`;
    };
    parts.push(
        element(
            "div",
            {class: "control exposure"},
            element("label", {for: "exposure"}, "Exposure"),
            slider,
            stops,
            button("Reset", "Exposure as rendered", () => onExposure(0), {class: "quiet"})
        )
    );
    fill(bar, element("div", {class: "bar-inner"}, ...parts));
}
