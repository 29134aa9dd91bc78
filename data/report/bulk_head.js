// The top of the page: what was computed, how accurate it is, and from what.

page.wavelength = Math.floor(page.results.wavelengths.length / 2); // index; what the reader has chosen
const wavelengthShown = () => page.results.wavelengths[page.wavelength];
const hasClusters = page.results.realisations !== undefined;

const formatWavelength = entry => `${Number(entry.wavelength.toPrecision(6))} nm`;

function factsOfBulk() {
    const {results} = page,
        first = results.wavelengths[0],
        last = results.wavelengths[results.wavelengths.length - 1];
    const range = (key, format) =>
        [...new Set([last, first].map(entry => format(entry[key])))].join(" – ");
    const facts = {
        Mode: results.mode,
        "Host index": formatNumber(results.host_index, 4),
        "Size parameter": `${range("largest_size_parameter", x => formatNumber(x, 3))}, the largest sphere`,
        Degree: `${range("degree", String)} of its waves`
    };
    if (hasClusters) {
        if (results.oriented) {
            const {incidences, angles, azimuths} = results.oriented;
            facts.Directions = `${incidences} incidences, ${angles} angles, ${azimuths} azimuths`;
        }
        if (results.ball_radius > 0) facts["Ball"] = `${formatNumber(results.ball_radius, 3)} µm radius`;
        facts.Realisations = String(results.realisations);
        if (results.refused > 0) facts.Refused = `${results.refused} solutions`;
        facts["Energy error"] = `${formatNumber(results.worst_energy_error, 2)} of the extinction, the worst`;
    }
    facts.Version = `Lacquer ${results.version}`;
    const list = element("dl", {class: "facts"});
    for (const [name, text] of Object.entries(facts))
        list.append(element("dt", {}, name), element("dd", {}, text));
    return list;
}

function speciesTable() {
    const {results} = page;
    const row = (species, i) => {
        const path = `species.${i}`,
            number = (key, format = formatNumber) =>
                element("td", {}, numberSpan(`${path}.${key}`, species[key], format(species[key]))),
            w = page.wavelength;
        return element(
            "tr",
            {},
            element("th", {scope: "row"}, species.name),
            number("mean_radius"),
            number("largest_radius"),
            number("volume_fraction", formatPercent),
            element("td", {}, formatNumber(species.n[w], 4)),
            element("td", {}, formatNumber(species.k[w], 2))
        );
    };
    const heads = ["species", ["mean radius", "µm, by number"], ["largest", "µm"], ["share", "by volume"], "n", "k"];
    return element(
        "div",
        {class: "scroll card"},
        element(
            "table",
            {class: "numbers", id: "species"},
            element(
                "thead",
                {},
                element(
                    "tr",
                    {},
                    ...heads.map(head =>
                        Array.isArray(head)
                            ? element("th", {scope: "col"}, head[0], element("small", {}, head[1]))
                            : element("th", {scope: "col"}, head)
                    )
                )
            ),
            element("tbody", {}, ...results.species.map(row))
        )
    );
}

// JSON for people: lists of numbers on one line. Text that is none stays what it is.
function indented(text) {
    try {
        return JSON.stringify(JSON.parse(text), null, 2).replace(/\[\s+([-+\d.eE,\s]+?)\s+\]/g, (_, list) => `[${list.replace(/\s+/g, " ")}]`);
    } catch {
        return text;
    }
}

function makeBulkHead(section) {
    const {results} = page;
    const kind = {
        independent: "Bulk scattering: independent spheres",
        structure: "Bulk scattering: independent spheres times structure factor"
    };
    fill(
        section,
        element("p", {class: "kicker"}, kind[results.mode] || `Bulk scattering: ${results.mode}${results.oriented ? ", oriented" : ""}`),
        element("h1", {}, results.title),
        element("p", {class: "summary"}, results.summary),
        element("p", {class: "verdict", id: "verdict"}, results.verdict),
        results.warnings.length > 0 &&
            element("ul", {class: "notices"}, ...results.warnings.map(text => element("li", {}, text))),
        element(
            "div",
            {class: "columns"},
            element("div", {}, factsOfBulk()),
            element(
                "div",
                {},
                results.command ? textBlock("The command", results.command, "command") : [],
                results.input ? textBlock("The input", indented(results.input), "input") : [],
                downloadResults("bulk-report.json")
            )
        ),
        element("h3", {}, "Particles ", element("small", {}, `indices at ${formatWavelength(wavelengthShown())}`)),
        speciesTable()
    );
}

// The strip that stays: the way around those sections that the page has, and the wavelength.
function makeBulkBar(bar, sections, onWavelength) {
    const nav = element(
        "nav",
        {"aria-label": "Parts of the page"},
        ...Object.entries(sections).map(([id, name]) => element("a", {href: `#${id}`}, name))
    );
    const select = element(
        "select",
        {id: "wavelength", onchange: () => onWavelength(Number(select.value))},
        ...page.results.wavelengths.map((entry, i) =>
            element("option", {value: i, selected: i === page.wavelength}, formatWavelength(entry))
        )
    );
    fill(
        bar,
        element(
            "div",
            {class: "bar-inner"},
            nav,
            element("label", {class: "control"}, element("span", {}, "Wavelength"), select)
        )
    );
}
