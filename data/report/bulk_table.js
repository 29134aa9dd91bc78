// The numbers as tables.

// Value and, smaller, its standard error.
function errorCell(path, key, entry, format = formatNumber) {
    const value = entry[key],
        error = entry[`${key}_error`];
    const cell = element("td", {class: "number"}, numberSpan(`${path}.${key}`, value, format(value)));
    if (error > 0)
        cell.append(element("small", {}, "± ", numberSpan(`${path}.${key}_error`, error, formatNumber(error, 2))));
    return cell;
}

function numbersTable() {
    const {wavelengths, mode} = page.results,
        hasBall = hasClusters && !isOriented,
        isAlone = mode === "independent";
    const number = (path, value, format = formatNumber) => element("td", {class: "number"}, numberSpan(path, value, format(value)));
    const row = (entry, i) => {
        const path = `wavelengths.${i}`;
        return element(
            "tr",
            {class: i === page.wavelength ? "shown" : false},
            element("th", {scope: "row"}, formatWavelength(entry)),
            errorCell(path, "sigma_s", entry),
            errorCell(path, "sigma_a", entry),
            errorCell(path, "g", entry, v => formatNumber(v, 3)),
            element("td", {class: "number"}, formatNumber(entry.sigma_s * (1 - entry.g))),
            hasClusters && errorCell(path, "c_ext", entry),
            hasClusters && number(`${path}.phase_error`, entry.phase_error, formatPercent),
            isOriented && errorCell(path, "albedo", entry, v => formatNumber(v, 4)),
            isOriented && number(`${path}.reciprocity_change`, entry.reciprocity_change, formatPercent),
            hasBall && number(`${path}.optical_depth`, entry.optical_depth, v => (v > 0 ? formatNumber(v, 2) : kMissing)),
            !isAlone && element("td", {class: "number"}, entry.independent.sigma_s > 0 ? formatRatio(entry.sigma_s / entry.independent.sigma_s) : kMissing),
            !isAlone && number(`${path}.independent.sigma_s`, entry.independent.sigma_s),
            !isAlone && number(`${path}.independent.sigma_a`, entry.independent.sigma_a),
            !isAlone && number(`${path}.independent.g`, entry.independent.g)
        );
    };
    const heads = [
        headCell("λ", "in vacuum"),
        headCell("σₛ", "1/mm"),
        headCell("σₐ", "1/mm"),
        headCell("g"),
        headCell("σₛ (1 − g)", "1/mm"),
        hasClusters && headCell("extinction", "µm², a particle"),
        hasClusters && headCell("p", "standard error"),
        isOriented && headCell("albedo"),
        isOriented && headCell("reciprocity", "changed, of the light"),
        hasBall && headCell("τ", "of the ball"),
        !isAlone && headCell("σₛ ratio", "to independent"),
        !isAlone && headCell("σₛ", "1/mm, independent"),
        !isAlone && headCell("σₐ", "1/mm, independent"),
        !isAlone && headCell("g", "independent")
    ];
    return element(
        "div",
        {class: "scroll card"},
        element(
            "table",
            {class: "numbers", id: "table"},
            element("thead", {}, element("tr", {}, ...heads.filter(Boolean))),
            element("tbody", {}, ...wavelengths.map(row))
        )
    );
}

// p at every fifth degree, of the wavelength that is shown.
function phaseTable() {
    const {angles} = page.results,
        entry = wavelengthShown(),
        isAlone = page.results.mode === "independent";
    const rows = angles
        .map((angle, i) => ({angle, i}))
        .filter(({angle}) => angle % 5 === 0)
        .map(({angle, i}) =>
            element(
                "tr",
                {},
                element("th", {scope: "row"}, `${angle}°`),
                element("td", {class: "number"}, numberSpan(`wavelengths.${page.wavelength}.phase.${i}`, entry.phase[i], formatNumber(entry.phase[i], 4))),
                !isAlone && element("td", {class: "number"}, formatNumber(entry.independent.phase[i], 4))
            )
        );
    const heads = [headCell("θ"), headCell("p", "1/sr"), !isAlone && headCell("p", "1/sr, independent")];
    return element(
        "details",
        {class: "bulk-details"},
        element("summary", {}, `p by angle at ${formatWavelength(entry)}`),
        element(
            "div",
            {class: "scroll card"},
            element(
                "table",
                {class: "numbers", id: "phase-table"},
                element("thead", {}, element("tr", {}, ...heads.filter(Boolean))),
                element("tbody", {}, ...rows)
            )
        )
    );
}

function makeNumbersOfBulk(section) {
    const draw = () => {
        const isOpen = section.querySelector("details")?.open;
        const details = isOriented ? incidenceTable() : phaseTable();
        details.open = Boolean(isOpen);
        fill(
            section,
            element("h2", {}, "Numbers"),
            element("p", {class: "lead"}, isOriented
                    ? "Means over all directions of incident light. Small: one standard error over the realisations."
                    : hasClusters
                      ? "Small: one standard error over the realisations."
                      : "Without noise."),
            numbersTable(),
            details
        );
    };
    section.redraw = draw;
    draw();
}

// Balls of several sizes at the wavelength that is shown, and what follows for an endless one.
function sizesTable() {
    const w = page.wavelength;
    const row = (size, i) => {
        const path = `sizes.${i}.wavelengths.${w}`,
            entry = size.wavelengths[w],
            isExtrapolated = size.count === 0;
        return element(
            "tr",
            {class: isExtrapolated ? "best" : false},
            element("th", {scope: "row"}, isExtrapolated ? "extrapolated" : `${size.count} particles`),
            element("td", {class: "number"}, isExtrapolated ? "∞" : numberSpan(`sizes.${i}.ball_radius`, size.ball_radius, formatNumber(size.ball_radius))),
            ...["sigma_s", "sigma_a", "g"].map(key => errorCell(path, key, entry))
        );
    };
    const heads = [headCell("size"), headCell("ball", "µm radius"), headCell("σₛ", "1/mm"), headCell("σₐ", "1/mm"), headCell("g")];
    return element(
        "div",
        {class: "scroll card"},
        element(
            "table",
            {class: "numbers", id: "size-table"},
            element("thead", {}, element("tr", {}, ...heads)),
            element("tbody", {}, ...page.results.sizes.map(row))
        )
    );
}

function makeSizes(section) {
    section.redraw = () =>
        fill(
            section,
            element("h2", {}, `Sizes of the ball at ${formatWavelength(wavelengthShown())}`),
            element(
                "p",
                {class: "lead"},
                "Particles at a ball’s surface have too few neighbours: a part that goes as one over its radius. The file has the extrapolated σₛ and σₐ, and p and g of the largest ball."
            ),
            sizesTable()
        );
    section.redraw();
}
