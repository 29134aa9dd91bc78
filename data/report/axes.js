// Axes of plots in the colours of the page.

const cssColor = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function useFontOfPage() {
    Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
    Chart.defaults.font.size = 12.5;
}

const axisColors = title => ({
    title: {display: true, text: title, color: cssColor("--soft")},
    grid: {color: cssColor("--line"), borderColor: cssColor("--line"), tickColor: "transparent"}
});

// Limits a little beyond the data: whole decades would leave most of the plot empty.
function logAxis(title, values) {
    const min = Math.min(...values) / 1.12,
        max = Math.max(...values) * 1.12,
        leads = max / min > 1000 ? [1] : [1, 2, 5],
        every = Math.ceil(Math.log10(max / min) / 10); // powers of ten apart, where there are many
    return {
        type: "logarithmic",
        min,
        max,
        ...axisColors(title),
        ticks: {
            color: cssColor("--soft"),
            maxRotation: 0,
            autoSkip: false,
            callback: value => {
                const [lead, power] = value.toExponential().split("e").map(Number);
                return leads.includes(Math.round(lead * 1000) / 1000) && power % every === 0
                    ? tickText(value)
                    : null;
            }
        }
    };
}

// Limits at the data, unless others are given.
function linearAxis(title, limits = {}) {
    return {
        type: "linear",
        ...limits,
        ...axisColors(title),
        ticks: {color: cssColor("--soft"), maxRotation: 0, callback: value => tickText(value)}
    };
}
