// Puts the parts of a page of bulk scattering together.

function makeBulkMethod(section) {
    const terms = {
        "σₛ, σₐ":
            "Light that is scattered and absorbed per millimetre of way, as the file has it and scenes render it.",
        "p(θ)": "Where scattered light goes: the density over directions [1/sr], whose integral is 1. 0° is straight on.",
        g: "The mean cosine of the scattering angle; σₛ (1 − g) tells how opaque a thick layer is.",
        Independent:
            "Lorenz–Mie theory of each sphere, as if all others were far away: the dashed lines."
    };
    if (isOriented)
        Object.assign(terms, {
            "p(θ)": "Where scattered light goes: the density over directions [1/sr], whose integral is 1 for each incidence.",
            Incidence: "The angle between the axis and the flight of the light that comes in.",
            Reciprocity:
                "Light takes each way in both directions alike. Averages of few realisations do not quite: p is the mean of both, and this share of the light has changed by that. Slices have it; other numbers are from before."
        });
    if (wavelengthShown().parts?.coherent)
        terms["Total, coherent, incoherent"] =
            "The mean intensity of clusters; the intensity of their mean field, which depends on the shape of the cluster; and the difference, which is what a medium scatters.";
    if (hasClusters)
        Object.assign(terms, {
            "Standard error":
                "From how groups of realisations differ (the jackknife). Bands are two of them wide to each side. " +
                (isOriented
                    ? "Six groups do not know their own spread well: such bands hold the truth nine times out of ten (Student’s distribution), but for what the notices at the top say."
                    : "From 24 realisations on they hold the truth nineteen times out of twenty, after six of them nine times out of ten, and after three four times out of five (Student’s distribution), but for what the notices at the top say."),
            "Energy error": "Extinction less absorption and scattering, over extinction, the worst of all solutions: rounding, if all is well."
        });
    if (hasClusters && !isOriented)
        terms["τ of the ball"] = "Its diameter times σₛ + σₐ. Beyond 0.3 the particles in front shadow those behind.";
    if (page.results.pairs)
        terms["Percus–Yevick"] =
            "Hard spheres in equilibrium, all of one radius: that of the mean volume. Near q = 0 the ball’s own shape adds to what is measured.";
    fillMethod(
        section,
        terms,
        "Plots by Chart.js (© Chart.js Contributors, MIT licence), colours after Okabe and Ito."
    );
}

const part = id => document.getElementById(id);

// [section, its name in the strip, how it is made]; what there is nothing for is left out.
function sectionsOfBulk() {
    const {results} = page;
    const at = () => ` at ${formatWavelength(wavelengthShown())}`;
    const all = [
        [true, "head", "", makeBulkHead],
        [hasLooks, "looks", "Looks", makeLooks],
        [true, "scattering", "Scattering", isOriented ? makeSlices : makeScattering],
        [
            isOriented,
            "incidences",
            "Incidence",
            section =>
                makePlots(
                    section,
                    () => `Over the incidence${at()}`,
                    "Bands: two standard errors to each side.",
                    incidencePlots
                )
        ],
        [
            results.wavelengths.length > 1,
            "spectra",
            "Spectra",
            section =>
                makePlots(
                    section,
                    () => "Over the wavelength",
                    hasClusters ? "Bands: two standard errors to each side." : "Without noise.",
                    spectrumPlots
                )
        ],
        [
            hasClusters && results.wavelengths[0].history.length > 1 && results.wavelengths.some(w => w.c_ext_error > 0),
            "convergence",
            "Convergence",
            section =>
                makePlots(
                    section,
                    () => `Convergence${at()}`,
                    "What the means were after so many realisations, with two standard errors to each side.",
                    convergencePlots
                )
        ],
        [
            Boolean(results.pairs),
            "structure",
            "Structure",
            section =>
                makePlots(
                    section,
                    () => "How particles stand to each other",
                    "Measured from the realisations, beside hard spheres of one radius in equilibrium.",
                    structurePlots
                )
        ],
        [results.sizes.length > 0, "sizes", "Sizes", makeSizes],
        [true, "numbers", "Numbers", makeNumbersOfBulk],
        [true, "method", "Method", makeBulkMethod]
    ];
    for (const [isThere, id] of all) if (!isThere) part(id).remove();
    return all.filter(([isThere]) => isThere).map(([, ...rest]) => rest);
}

function startBulk() {
    const sections = sectionsOfBulk();
    useFontOfPage();
    const makeAll = () => sections.forEach(([id, , make]) => make(part(id)));
    const recolor = () => {
        useFontOfPage();
        makeBulkHead(part("head"));
        for (const [id] of sections) if (part(id).redraw) part(id).redraw();
    };
    makeBulkBar(
        part("bar"),
        Object.fromEntries(sections.filter(([, name]) => name).map(([id, name]) => [id, name])),
        index => {
            page.wavelength = index;
            recolor();
        }
    );
    makeAll();
    whenLooksChange(recolor);
    window.addEventListener("resize", () => part("looks")?.redraw());
    Promise.all(page.results.thumbnails.map(t => loadImage(t.file))).then(() => {
        document.documentElement.dataset.ready = "true";
    });
}

startBulk();
