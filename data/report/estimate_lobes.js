// Measured reflectances beside what is predicted, and what to measure next.

// Colours of channels by their names, others in turn.
function channelColor(name, i) {
    const own = {r: ["#c0392b", "#ff7a6b"], g: ["#1e8449", "#58d68d"], b: ["#2460b0", "#7fb3ff"]}[name];
    return own ? own[isDark() ? 1 : 0] : chainColors()[i % chainColors().length];
}

// Channels that never differ by more than this are drawn as one.
const kSameChannels = 1e-3;
function channelsOf(lobe) {
    const [first, ...others] = lobe.channels;
    const isSame = other => other.median.every((y, i) => Math.abs(y / first.median[i] - 1) < kSameChannels);
    return others.length > 0 && others.every(isSame) ? [first] : lobe.channels;
}

// A band between two curves.
const bandBetween = (xs, low, high, color) =>
    [low, high].map((ys, i) => ({
        label: "",
        data: xs.map((x, k) => ({x, y: ys[k]})),
        showLine: true,
        borderWidth: 0,
        pointRadius: 0,
        pointHitRadius: 0,
        backgroundColor: withAlpha(color, 0.3),
        fill: i === 1 ? "-1" : false,
        isEdge: true
    }));

function lobePlot(lobe) {
    const xs = lobe.places,
        channels = channelsOf(lobe);
    const datasets = channels.flatMap(({name, measured, low, median, high}, i) => {
        const color = channelColor(channels.length === 1 && lobe.channels.length > 1 ? "" : name, i),
            label = channels.length === 1 ? "" : `${name}, `;
        return [
            ...bandBetween(xs, low, high, color),
            lineDataset(
                `${label}predicted`,
                xs.map((x, k) => ({x, y: median[k]})),
                color,
                {borderWidth: 1.5}
            ),
            lineDataset(
                `${label}measured`,
                xs.map((x, k) => ({x, y: measured[k]})),
                color,
                {showLine: false, pointRadius: 3}
            )
        ];
    });
    const all = channels.flatMap(({measured, low, high}) => [...measured, ...low, ...high]).filter(y => y > 0);
    const margin = 0.03 * (xs[xs.length - 1] - xs[0]) || 1;
    const x = linearAxis(lobe.unit, {min: xs[0] - margin, max: xs[xs.length - 1] + margin});
    x.ticks.maxTicksLimit = 7;
    return [lobe.title, datasets, x, logAxis("f [1/sr]", all), false];
}

function makeLobes(section) {
    makeSmallPlots(
        section,
        "Measured and predicted",
        "Dots are what was measured, lines what the material predicts, and bands where it lies with 90 % probability. Angles of view are positive on the far side of the light, where it is mirrored. Noise of the measurement is not part of the bands: dots lie beside them by as much.",
        false,
        () => page.results.lobes.map(lobePlot)
    );
}

function makeNext(section) {
    const {next, next_text: text} = page.results;
    const row = (direction, i) =>
        element(
            "tr",
            {},
            element("th", {scope: "row"}, String(i + 1)),
            ...["theta_i", "phi_i", "theta_o", "phi_o"].map(key =>
                element("td", {class: "number"}, numberSpan(`next.${i}.${key}`, direction[key], formatNumber(direction[key], 4)))
            ),
            element("td", {class: "number"}, numberSpan(`next.${i}.deviation`, direction.deviation, formatNumber(direction.deviation, 2))),
            element("td", {class: "number"}, numberSpan(`next.${i}.ratio`, direction.ratio, formatNumber(direction.ratio, 2)))
        );
    const heads = [
        headCell("rank"),
        headCell("light", "from the normal [degrees]"),
        headCell("light", "around it"),
        headCell("view", "from the normal"),
        headCell("view", "around it"),
        headCell("predictions differ by", "sd, relative"),
        headCell("variance", "over that of the noise")
    ];
    fill(
        section,
        element("h2", {}, "What to measure next"),
        element("p", {class: "lead"}, text),
        element(
            "div",
            {class: "scroll card", tabindex: 0, role: "region", "aria-label": "Table of directions"},
            element(
                "table",
                {class: "numbers", id: "next-table"},
                element("thead", {}, element("tr", {}, ...heads)),
                element("tbody", {}, ...next.map(row))
            )
        )
    );
}
