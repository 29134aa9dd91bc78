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

const powerText = power => (power === 0 ? "1" : power === 1 ? "10" : `10${superscript(power)}`);

// Limits a little beyond the data: whole decades would leave most of the plot empty. Many decades have powers
// of ten only, and of very many some.
function logAxis(title, values) {
    const min = Math.min(...values) / 1.12,
        max = Math.max(...values) * 1.12,
        decades = Math.log10(max / min),
        leads = decades > 3 ? [1] : [1, 2, 5],
        every = Math.ceil(decades / 10);
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
                if (!leads.includes(Math.round(lead * 1000) / 1000) || power % every !== 0) return null;
                return decades > 3 ? powerText(power) : tickText(value);
            }
        }
    };
}

// Digits behind the point that tell multiples of a step apart.
function digitsOfStep(step) {
    let digits = 0;
    while (digits < 10 && Math.abs(step * 10 ** digits - Math.round(step * 10 ** digits)) > 1e-6) ++digits;
    return digits;
}

// Limits at the data, unless others are given; numbers at round places.
function linearAxis(title, limits = {}) {
    const callback = (value, index, ticks) => {
        if (ticks.length === 1) return tickText(value);
        const digits = digitsOfStep(ticks[1].value - ticks[0].value);
        return (digits > 5 ? formatNumber(value, 3) : value.toFixed(digits)).replace("-", "−");
    };
    return {
        type: "linear",
        ...limits,
        ...axisColors(title),
        ticks: {color: cssColor("--soft"), maxRotation: 0, includeBounds: false, callback}
    };
}
