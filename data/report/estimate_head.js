// The top of the page: the verdict in words, what weakens it, photograph and model.

const hasChains = !page.results.map_only && page.results.parameters.some(p => p.histogram);
const isOfPhotograph = page.results.subject === "photograph";
// The page's own sentences are written for photographs.
const said = text => (isOfPhotograph ? text : text.replaceAll("photograph", page.results.subject));
const labelOf = parameter => parameter.meaning || parameter.name;
const parameterNamed = name => page.results.parameters.find(p => p.name === name);

// As many digits as the standard deviation leaves: two of its own.
function formatBy(value, sd) {
    if (!isNumber(value)) return kMissing;
    const digits = isNumber(sd) && sd > 0 ? 1 - Math.floor(Math.log10(sd)) : NaN;
    if (!(digits <= 6) || Math.abs(value) >= 1e6) return formatNumber(value, 4);
    const text = value.toFixed(Math.max(0, digits));
    return Number(text) === 0 ? "0" : text.replace("-", "−");
}

function makeEstimateHead(section) {
    const {results} = page;
    const isGood = results.map_only ? "plain" : results.converged ? "good" : "bad";
    fill(
        section,
        element("p", {class: "kicker"}, `Estimate: ${results.model}`),
        element("h1", {}, results.title),
        element("p", {class: `verdict ${isGood}`, id: "verdict"}, results.verdict),
        results.warnings.length > 0 &&
            element("ul", {class: "notices"}, ...results.warnings.map(text => element("li", {}, text))),
        photoAndModel(),
        results.findings.length > 0 && element("ul", {class: "findings"}, ...results.findings.map(findingItem)),
        settingsAndCommand("estimate-report.json")
    );
}
