// The photograph beside what the model makes of it, and the material's maps.

// The photograph, the picture that the reader has chosen, and all there are to choose from.
function photoAndModel() {
    const {results} = page,
        toByte = bytesOf(results.linear);
    const choices = [
        ...(results.best ? [[results.best, "Most probable"]] : []),
        ...results.draws.map((file, i) => [file, `Draw ${i + 1}`])
    ];
    if (!results.photo && choices.length === 0) return [];
    const chosen = element("figure", {class: "shot", id: "chosen"});
    const thumbnails = element("div", {class: "thumbnails", role: "group", "aria-label": "The picture beside the photograph"});
    const captions = {best: "The most probable parameters, with another random pattern"};
    const choose = (file, label) => {
        const caption = captions[file] || `${label} of the posterior: as probable as the data say, with a pattern of its own`;
        fill(chosen, pictureCanvas(file, caption, toByte), element("figcaption", {}, caption));
        for (const b of thumbnails.children) b.setAttribute("aria-pressed", String(b.dataset.file === file));
    };
    for (const [file, label] of choices)
        thumbnails.append(
            element(
                "button",
                {type: "button", "data-file": file, onclick: () => choose(file, label)},
                pictureCanvas(file, "", toByte),
                element("span", {}, label)
            )
        );
    if (choices.length > 0) choose(...choices[0]);
    return [
        element(
            "div",
            {class: "beside"},
            results.photo && picture(results.photo, "The photograph", toByte),
            choices.length > 0 && chosen
        ),
        choices.length > 1 && thumbnails
    ];
}

const withUnit = (text, unit) => (unit ? `${text} ${unit}` : text);

function makeMaps(section) {
    const shots = page.results.maps.map(map => {
        if (!isNumber(map.least)) return picture(map.file, map.name, bytesOf(map.color));
        const range = map.most - map.least || 1,
            text = value => withUnit(formatNumber(value, 3), map.unit);
        const caption =
            map.most > map.least
                ? `${map.name}: black is ${text(map.least)}, white ${text(map.most)}`
                : `${map.name}: ${text(map.least)} everywhere`;
        return picture(map.file, caption, value => Math.round((255 * (value - map.least)) / range));
    });
    fill(
        section,
        element("h2", {}, "Maps"),
        element(
            "p",
            {class: "lead"},
            "Of the most probable parameters, as they were written for scenes. They have a random pattern of their own: where a crease lies is not estimated, what creases are like is."
        ),
        element("div", {class: "gallery"}, ...shots)
    );
}
