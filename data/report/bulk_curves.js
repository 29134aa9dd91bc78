// Plots over the wavelength, the number of realisations, and distances.

// Over the wavelengths: what the file has, and dashed what independent particles do.
function spectrumPlots() {
    const {wavelengths, mode} = page.results,
        color = ownColor();
    const kinds = {
        sigma_s: ["Scattering coefficient σₛ", "σₛ [1/mm]"],
        sigma_a: ["Absorption coefficient σₐ", "σₐ [1/mm]"],
        g: ["Mean cosine g", "g"]
    };
    return Object.entries(kinds)
        .filter(([key]) => key !== "sigma_a" || wavelengths.some(w => w.sigma_a > 0 || w.independent.sigma_a > 0))
        .map(([key, [title, axis]]) => {
            const own = wavelengths.map(w => ({x: w.wavelength, y: w[key], error: w[`${key}_error`] || 0}));
            const alone = wavelengths.map(w => ({x: w.wavelength, y: w.independent[key]}));
            const marks = wavelengths.length < 30 ? kDots : {};
            const datasets = [
                ...(mode === "independent"
                    ? []
                    : [lineDataset("independent", alone, cssColor("--soft"), kDashed)]),
                ...bandDatasets(mode === "independent" ? "independent (Lorenz–Mie)" : "this file", own, color, false, marks)
            ];
            const limits = {min: wavelengths[0].wavelength, max: wavelengths[wavelengths.length - 1].wavelength};
            return [title, datasets, linearAxis("wavelength in vacuum [nm]", limits), linearAxis(axis, key === "g" ? {} : {beginAtZero: true})];
        });
}

const kCrossSections = {
    c_ext: ["Extinction", "cross section of a particle [µm²]"],
    c_sca: ["Scattering", "cross section of a particle [µm²]"],
    g: ["Mean cosine", "g"]
};

function convergencePlots() {
    const {history, independent} = wavelengthShown(),
        color = ownColor();
    return Object.entries(kCrossSections).map(([key, [title, axis]]) => {
        const points = history.map(r => ({x: r.realisations, y: r[key], error: r[`${key}_error`]}));
        const [first, last] = [points[0].x, points[points.length - 1].x];
        const alone = [first, last].map(x => ({x, y: independent[key]}));
        // Errors of the first few realisations would be all that the plot shows.
        const later = points.filter(p => p.x >= Math.min(6, last)),
            edges = [...later.flatMap(p => [p.y - 2 * p.error, p.y + 2 * p.error]), independent[key]];
        const [low, high] = [Math.min(...edges), Math.max(...edges)],
            margin = 0.08 * (high - low || Math.abs(high) || 1);
        return [
            title,
            [
                lineDataset("independent", alone, cssColor("--soft"), kDashed),
                ...bandDatasets("mean ± 2 standard errors", points, color, false, kDots)
            ],
            linearAxis("realisations", {min: first, max: last}),
            linearAxis(axis, {min: low - margin, max: high + margin})
        ];
    });
}

function structurePlots() {
    const {pairs} = page.results,
        color = ownColor();
    const points = (x, y) => x.map((each, i) => ({x: each, y: y[i]}));
    const plot = (title, x, own, other, xTitle, yTitle) => [
        title,
        [
            lineDataset("Percus–Yevick", points(x, other), cssColor("--soft"), kDashed),
            lineDataset(`${pairs.realisations} realisations`, points(x, own), color, {...kDots, borderWidth: 1})
        ],
        linearAxis(xTitle, {min: 0, max: x[x.length - 1]}),
        linearAxis(yTitle, {beginAtZero: true})
    ];
    return [
        plot("Structure factor", pairs.q_diameter, pairs.s, pairs.s_percus_yevick, "q times the mean diameter", "S(q)"),
        plot("Pair distribution", pairs.distance, pairs.g, pairs.g_percus_yevick, "distance over the mean diameter", "g(r)")
    ];
}
