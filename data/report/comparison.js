// What is special to a comparison: variants, estimators with their colours, numbers with intervals. What is compared
// is called an estimator in these files, whatever it is; for readers it has its own noun.

// The reader's choices that more than one part follows.
Object.assign(page, {
    variant: 0, // index into results.variants
    stops: 0, // exposure of renders
    errorLog: true, // axis of the maps of errors
    origin: {x: 0, y: 0} // of the images in the frame, where they are a part of it
});
const variantShown = () => page.results.variants[page.variant];

// Values with an interval are {value, low, high}; anything else counts as missing.
const valueOf = interval => (interval && isNumber(interval.value) ? interval.value : null);
const hasInterval = i => i && isNumber(i.low) && isNumber(i.high);

// Value and, smaller, its interval.
function intervalCell(path, interval, format = formatNumber, unit = "") {
    const value = valueOf(interval);
    const cell = element(
        "td",
        {class: "number"},
        numberSpan(`${path}.value`, value, value === null ? kMissing : format(value) + unit)
    );
    if (value !== null && hasInterval(interval))
        cell.append(
            element(
                "small",
                {class: "interval"},
                numberSpan(`${path}.low`, interval.low, format(interval.low)),
                " – ",
                numberSpan(`${path}.high`, interval.high, format(interval.high))
            )
        );
    return cell;
}

// "estimator", "light sampler"; with its article, and of several.
const noun = () => String(page.results.compared || "estimator");
const aNoun = () => (/^[aeiou]/.test(noun()) ? "an " : "a ") + noun();
const ofDenoisers = () => noun() === "denoiser";
const nouns = () => noun() + "s";
const headingNoun = () => noun().replace(/^./, c => c.toUpperCase());

// An estimator keeps its colour and mark.
const kMarks = ["circle", "rect", "triangle", "rectRot", "star", "crossRot"];

function colorOf(estimator) {
    const index = Math.max(0, page.results.estimators.indexOf(estimator));
    return (isDark() ? kColorsOnDark : kColors)[index % kColors.length];
}

const markOf = estimator => kMarks[Math.max(0, page.results.estimators.indexOf(estimator)) % kMarks.length];

const swatch = estimator =>
    element("i", {class: "swatch", "data-estimator": estimator, style: `background:${colorOf(estimator)}`});
