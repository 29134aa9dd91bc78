// Where light goes at one wavelength: a polar plot of p, and what each part scatters over the angle.

const curveColors = () => {
    const colors = isDark() ? kColorsOnDark : kColors;
    return {total: colors[0], coherent: colors[1], incoherent: colors[2], structure: colors[3]};
};
const kPartOfMode = {aggregate: "total", medium: "incoherent", chapter: "coherent"};
const kPartNames = {
    total: "total",
    coherent: "coherent (of the mean field)",
    incoherent: "incoherent (the rest)",
    structure: "Lorenz–Mie × Percus–Yevick",
    independent: "independent (Lorenz–Mie)"
};
const ownPart = () => kPartOfMode[page.results.mode];
const ownColor = () => (ownPart() ? curveColors()[ownPart()] : cssColor("--accent"));

const kPolarSize = 440,
    kPolarRadius = 175;

// A point of a curve: radius by the logarithm within the limits, in a direction [x, y] on the page.
function polarPoint(value, [x, y], limits) {
    const t = value > 0 ? (Math.log10(value) - limits.low) / (limits.high - limits.low) : 0,
        radius = kPolarRadius * Math.max(0, t);
    return `${(radius * x).toFixed(2)},${(radius * y).toFixed(2)}`;
}

// From the right, counterclockwise.
const fromForward = degrees => [Math.cos((degrees * Math.PI) / 180), -Math.sin((degrees * Math.PI) / 180)];

// A closed curve, both halves alike.
function polarPath(angles, values, limits) {
    const upper = angles.map((angle, i) => polarPoint(values[i], fromForward(angle), limits)),
        lower = angles.map((angle, i) => polarPoint(values[i], fromForward(-angle), limits)).reverse();
    return `M${[...upper, ...lower].join("L")}Z`;
}

// Powers of ten about the values, six at most: below there is hardly any light.
function polarLimits(...lists) {
    const values = lists.flat().filter(v => v > 0),
        high = Math.ceil(Math.log10(Math.max(...values)) + 1e-9);
    const low = Math.max(high - 6, Math.floor(Math.log10(Math.min(...values))));
    return {low: Math.min(low, high - 2), high};
}

// Circles at powers of ten, and rays every 30 degrees. @param place  direction on the page of an angle
function polarFrame(label, limits, place) {
    const svg = svgElement("svg", {
        viewBox: `${-kPolarSize / 2} ${-kPolarSize / 2 + 14} ${kPolarSize} ${kPolarSize - 28}`,
        role: "img",
        "aria-label": label
    });
    for (let degrees = 0; degrees < 360; degrees += 30) {
        const [c, s] = place(degrees);
        svg.append(svgElement("line", {class: "grid", x1: 0, y1: 0, x2: kPolarRadius * c, y2: kPolarRadius * s}));
        const label = svgElement(
            "text",
            {
                x: (kPolarRadius + 10) * c,
                y: (kPolarRadius + 10) * s + 4,
                "text-anchor": Math.abs(c) < 0.1 ? "middle" : c > 0 ? "start" : "end"
            },
            `${degrees > 180 ? 360 - degrees : degrees}°`
        );
        svg.append(label);
    }
    for (let power = limits.low; power <= limits.high; ++power)
        svg.append(
            svgElement("circle", {
                class: "grid",
                r: (kPolarRadius * (power - limits.low)) / (limits.high - limits.low)
            })
        );
    return svg;
}

// What the circles mean, over the curves.
function polarTicks(svg, limits) {
    const step = limits.high - limits.low > 4 ? 2 : 1;
    for (let power = limits.high; power > limits.low; power -= step) {
        const y = (kPolarRadius * (power - limits.low)) / (limits.high - limits.low);
        svg.append(
            svgElement("rect", {class: "tick-back", x: 2, y: y - 14, width: power === 0 ? 12 : 28, height: 13, rx: 2}),
            svgElement("text", {x: 4, y: y - 4}, powerText(power))
        );
    }
}

function polarPlot() {
    const entry = wavelengthShown(),
        {angles} = page.results,
        isAlone = page.results.mode === "independent";
    const limits = polarLimits(entry.phase, entry.independent.phase);
    const svg = polarFrame("Polar plot of log p", limits, fromForward);
    svg.append(
        svgElement("path", {class: "curve", id: "polar-curve", stroke: ownColor(), d: polarPath(angles, entry.phase, limits)})
    );
    if (!isAlone)
        svg.append(
            svgElement("path", {
                class: "curve dashed",
                stroke: cssColor("--soft"),
                d: polarPath(angles, entry.independent.phase, limits)
            })
        );
    polarTicks(svg, limits);
    return svg;
}

function polarFigure() {
    const isAlone = page.results.mode === "independent";
    return element(
        "figure",
        {class: "plot card polar"},
        element("figcaption", {}, "p(θ), logarithmic from the centre [1/sr]"),
        polarPlot(),
        element(
            "div",
            {class: "keys-line"},
            lineKey({label: isAlone ? "independent (Lorenz–Mie)" : `this file (${page.results.mode})`, borderColor: ownColor()}),
            !isAlone && lineKey({label: "independent", borderColor: cssColor("--soft"), ...kDashed})
        )
    );
}

let phaseAxis = "linear";

// Curves of parts over the angle; that of the file last, with its band. Estimates may be negative where there is
// hardly any light: gaps.
function partData() {
    const {parts} = wavelengthShown(),
        {angles} = page.results,
        colors = curveColors();
    const points = (values, errors = []) =>
        angles
            .map((x, i) => ({x, y: values[i] > 0 ? values[i] : NaN, error: errors[i] || 0}))
            .filter(p => phaseAxis === "linear" || p.x > 0);
    const own = page.results.mode === "structure" ? "structure" : ownPart() || "independent";
    const datasets = [];
    for (const name of ["independent", "structure", "total", "coherent", "incoherent"]) {
        if (!parts[name] || name === own) continue;
        const isTheory = name === "independent" || name === "structure";
        const color = isTheory ? cssColor("--soft") : colors[name],
            style = name === "independent" ? kDashed : name === "structure" ? kDotted : {borderWidth: 1.5};
        datasets.push(lineDataset(kPartNames[name], points(parts[name]), color, {part: name, ...style}));
    }
    const label = own === "independent" ? kPartNames[own] : `${kPartNames[own]}: this file`;
    datasets.push(...bandDatasets(label, points(parts[own], parts.error), ownColor(), true, {part: own}));
    return datasets;
}

function partFigure() {
    const datasets = partData();
    // The coherent part ends somewhere in the noise.
    const values = datasets.filter(d => d.part && d.part !== "coherent").flatMap(d => d.data.map(p => p.y)).filter(y => y > 0);
    const positive = page.results.angles.filter(angle => angle > 0),
        title = "scattering angle θ [degrees]";
    const x =
        phaseAxis === "log"
            ? {...logAxis(title, positive), min: positive[0], max: 180}
            : linearAxis(title, {min: 0, max: 180});
    if (phaseAxis === "linear") x.ticks.stepSize = 30;
    const y = logAxis("dC/dΩ of a particle [µm²/sr]", values);
    y.min /= 2;
    return plotFigure(hasClusters ? "Parts of the scattered light" : "Cross section over the angle", datasets, x, y);
}

function makeScattering(section) {
    const polar = element("div", {style: "min-width:0"}),
        holder = element("div", {class: "plots"}, polar),
        title = element("h2", {});
    let parts = null;
    const drawParts = () => {
        const next = partFigure();
        if (parts) {
            parts.plot.destroy();
            parts.figure.replaceWith(next.figure);
        } else holder.append(next.figure);
        next.show();
        parts = next;
    };
    const lead = hasClusters
        ? "Dashed is what the same particles would do far apart." +
          (wavelengthShown().parts.coherent
              ? " The coherent part is that of the mean field: what a probe of this shape refracts and diffracts."
              : "")
        : "Straight on is 0°, straight back 180°.";
    fill(
        section,
        title,
        element("p", {class: "lead"}, lead),
        element(
            "div",
            {class: "tools"},
            element("span", {}, "Angles"),
            segments("Angles", {linear: "linear", log: "logarithmic"}, phaseAxis, axis => {
                phaseAxis = axis;
                drawParts();
            })
        ),
        holder
    );
    section.redraw = () => {
        title.textContent = `Scattering at ${formatWavelength(wavelengthShown())}`;
        fill(polar, polarFigure());
        drawParts();
    };
    section.redraw();
}
