// Puts the parts of a page of an estimate together.

function makeEstimateMethod(section) {
    const terms = {
        "Most probable":
            "The one point at which all parameters together are most probable. It is what the maps and the material have. Where a distribution is wide, many other points are nearly as good.",
        "5 %, 95 %":
            "The true value is below the first with 5 % probability and above the second with 5 %, if the photograph is one that the model can make, and if what was assumed beforehand was reasonable.",
        "The photograph narrows by":
            "1 − sd / prior sd. 0 %: after the photograph no more is known than before; 83 %: what is possible has shrunk to a sixth. Above 50 % this page says that the photograph tells a parameter, below 10 % that it says hardly anything.",
        Prior: "What was assumed before the photograph: a normal distribution, cut at limits. It is a choice, and can be made with --prior.",
        "A product":
            "Some parameters cannot be told apart: twice the light on half the albedo is the same picture. Their product can be well known where neither of them is."
    };
    if (hasChains)
        Object.assign(terms, {
            "R-hat": "Compares the chains with each other: 1 if they agree. Above 1.05 the result is not to be used, up to 1.01 is good.",
            ESS: "How many independent draws the chains are worth, in the middle (bulk) and for the 5 % and 95 % values (tails). Below 100 the result is not to be used, above 400 is enough."
        });
    Object.assign(terms, {
        "χ²/p":
            "The squared differences between photograph and model over what chance makes, on average over p summaries. About 1 is as it should be. Above 1.5 the model does not fit, and intervals are widened.",
        "Not used":
            "Summaries that the estimate never saw. If the model predicts them as well, it has understood more than it was told."
    });
    if (!page.results.calibrated)
        terms["Not calibrated"] =
            "The error of the summaries was set by hand and not found from simulations: the widths of all intervals are a choice, too.";
    // Terms of pictures are for photographs alone.
    if (!isOfPhotograph) ["A product", "Not used", "χ²/p"].forEach(term => delete terms[term]);
    for (const term of Object.keys(terms))
        if (said(term) !== term || said(terms[term]) !== terms[term]) {
            const text = terms[term];
            delete terms[term];
            terms[said(term)] = said(text);
        }
    fillMethod(section, terms, "Plots by Chart.js (© Chart.js Contributors, MIT licence), colours after Okabe and Ito.");
}

// As startPage() takes them.
function sectionsOfEstimate() {
    const {results} = page;
    return [
        [true, "head", "", makeEstimateHead],
        [results.parameters.length > 0, "parameters", "Parameters", makeParameters],
        [results.lobes.length > 0, "lobes", "Lobes", makeLobes],
        [results.next.length > 0, "next", "Measure next", makeNext],
        [hasChains, "marginals", "Distributions", makeMarginals],
        [Boolean(results.correlations), "correlations", "Correlations", makeCorrelations],
        [results.checks.length + results.residuals.length > 0, "checks", "Checks", makeChecks],
        [hasChains || results.waves.length > 0, "chains", "Chains", makeChains],
        [results.maps.length > 0, "maps", "Maps", makeMaps],
        [true, "method", "Method", makeEstimateMethod]
    ];
}

startPage(sectionsOfEstimate());
