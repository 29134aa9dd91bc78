// Photographs beside what the maps give at the same camera and light.

// Bytes are the file's own values: both sides are encoded by the response of the photographs.
const encodedByte = value => Math.round(255 * Math.min(1, Math.max(0, value)));
// Differences from here on are all of the brightest colour: some times the errors that there are, as a round number.
const brightestDifference = [0.02, 0.05, 0.1, 0.25].find(limit => page.results.views.every(view => 6 * view.rmse <= limit)) || 0.5;
const differenceColor = value => magmaColor(Math.min(1, value / brightestDifference));

function differencePicture(file, caption) {
    const canvas = element("canvas", {role: "img", "aria-label": caption, class: "picture", "data-file": file, width: 8, height: 8});
    painting.push(
        loadImage(file).then(
            image =>
                image &&
                paint(canvas, image.width, wholeOf(image), (i, rgb) => {
                    const bits = image.halves[i];
                    if (!isFiniteHalf(bits)) return false;
                    [rgb[0], rgb[1], rgb[2]] = differenceColor(kHalfValues[bits]);
                    return true;
                })
        )
    );
    return element("figure", {class: "shot"}, canvas, element("figcaption", {}, caption));
}

function differenceScale() {
    const canvas = element("canvas", {width: 220, height: 1, "aria-hidden": "true"});
    paint(canvas, 220, {x0: 0, x1: 220, y0: 0, y1: 1}, (i, rgb) => {
        [rgb[0], rgb[1], rgb[2]] = magmaColor(i / 219);
        return true;
    });
    return element("div", {class: "scale-line"}, "Difference of encoded values: 0", canvas, `${brightestDifference} or more`);
}

const kUses = {fit: "fitted", test: "held out of the fit"};

function viewRow(view, i) {
    const rmse = element("small", {}, `${kUses[view.use]}, RMSE `, element("span", {"data-path": `views.${i}.rmse`}, formatNumber(view.rmse, 3)));
    return element(
        "div",
        {class: "view-row"},
        element("h3", {}, view.name, rmse),
        picture(view.photo, "The photograph, rectified", encodedByte),
        picture(view.model, "The maps under its light", encodedByte),
        differencePicture(view.difference, "The difference, of the channel that differs most")
    );
}

function makeViews(section) {
    const {views} = page.results,
        tests = views.filter(view => view.use === "test").length;
    fill(
        section,
        element("h2", {}, "Photographs and fit"),
        element(
            "p",
            {class: "lead"},
            tests > 0
                ? "Photographs that were held out tell whether the maps are right where nobody looked: their errors are what to judge by."
                : "All photographs were fitted: that they are matched does not tell how the sample looks under other light. --hold-out keeps some back."
        ),
        differenceScale(),
        ...views.map(viewRow)
    );
}
