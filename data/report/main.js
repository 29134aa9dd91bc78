// Puts the parts together.

function makeMethod(section) {
    const terms = {
        RMSE:
            "In each pixel the root of the mean over the runs of the squared difference from the reference, " +
            "then the mean over the box. It is the measure of the papers, and that of one run: more runs tighten " +
            "its interval and do not make it smaller.",
        "RMSE reduction": `The baseline's RMSE divided by that of the ${noun()}, both without the noise of the reference. 2 means half the error.`,
        [reductionName()]:
            "The square of that: how many times the work the baseline would need for the same error, as errors of " +
            "independent samples fall with its root.",
        "Relative MSE":
            "Squared difference divided by the squared reference plus 0.01: dark parts count nearly as much as bright ones.",
        ...(ofDenoisers()
            ? {
                  FLIP:
                      "How different a person sees image and reference when flipping between them (HDR-FLIP), from 0 to 1; " +
                      "the mean over the box and the runs.",
                  Systematic:
                      "The part of the squared error that all runs have in common, from the products of errors of different " +
                      "runs, in which noise is zero in the mean. Of unbiased images it is 0 but for noise."
              }
            : {
                  Bias:
                      "The mean difference from the reference over all pixels of the box and all runs, in its own standard " +
                      `errors. If the mean of ${aNoun()} is right, it has a value between −2 and 2 nineteen times out of ` +
                      "twenty. The smaller number is relative to the reference."
              }),
        "Noise of the reference":
            `The share of the mean squared error that is not that of the ${noun()} but the reference's. Small is good; ` +
            "“without” is the RMSE when it is taken away.",
        Interval:
            "95 %, by bootstrap. Where the interval of a reduction includes 1, this experiment does not tell the " +
            "two apart.",
        Indistinguishable:
            "Not shown to differ from the least error: the probability of such a difference between equals, " +
            `corrected for all pairs of ${nouns()}, is 5 % or more.`,
        Images:
            "The page holds them as 16-bit floats in linear sRGB, about three digits; the EXR files beside it have " +
            "all. Renders pass through the sRGB curve after the exposure; maps of errors do not."
    };
    fillMethod(
        section,
        terms,
        `Plots by Chart.js (© Chart.js Contributors, MIT licence), colours of errors by magma, of ${nouns()} ` +
            "after Okabe and Ito."
    );
}

// Every image of a variant, by its file.
async function loadImages(variant) {
    const files = [
        (variant.reference || {}).image,
        ...variant.estimators.flatMap(e => [(e.images || {}).run, (e.images || {}).error])
    ].filter(Boolean);
    const images = await Promise.all(files.map(loadImage));
    return new Map(files.map((file, i) => [file, images[i]]));
}

// The images of a comparison are parts of one frame, all the same part; a reference from a file may not say so.
function originOf(images) {
    const first = [...images.values()].find(image => image && (image.x !== 0 || image.y !== 0));
    return first ? {x: first.x, y: first.y} : {x: 0, y: 0};
}

const part = id => document.getElementById(id);

function openInViewer(a, b, box) {
    if (viewer.pictures.has(a)) viewer.a = a;
    if (viewer.pictures.has(b)) viewer.b = b;
    fillPictureSelects();
    fitBox(box);
    part("viewer").scrollIntoView({block: "start"});
    viewer.stage.focus({preventScroll: true});
}

async function showVariant(index) {
    page.variant = index;
    document.documentElement.dataset.ready = "false";
    const variant = variantShown();
    makeHead(part("head"));
    makeNumbers(part("numbers"));
    makeConvergence(part("convergence"));
    const images = await loadImages(variant);
    if (page.variant !== index) return; // the reader was faster
    page.origin = originOf(images);
    makeCrops(part("crops"), images, openInViewer);
    showPictures(variant, images);
    document.documentElement.dataset.ready = "true";
}

function setExposure(stops) {
    page.stops = Math.min(10, Math.max(-10, stops));
    part("bar").showExposure(page.stops);
    repaintCrops(part("crops"));
    drawViewer();
}

// Colours that scripts have put in follow the reader's preference, and paper is white.
function recolor() {
    for (const mark of document.querySelectorAll(".swatch"))
        mark.style.background = colorOf(mark.dataset.estimator);
    makeNumbers(part("numbers"));
    part("convergence").redraw();
    drawViewer();
}

function start() {
    makeBar(part("bar"), showVariant, setExposure);
    makeViewer(part("viewer"), setExposure);
    makeMethod(part("method"));
    part("crops").addEventListener("scalechange", drawViewer);
    whenLooksChange(recolor);
    showVariant(0);
}

start();
