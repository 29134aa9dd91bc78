// What a page shows, read back.

// A number as a reader sees it, and half of its last digit: "1.2·10⁻⁵", "−.93", "4.0 %".
export function numberOf(text) {
    const [, mantissa, power] = text.replaceAll("−", "-").match(/^(-?(?:\d+\.?\d*|\.\d+))(?:·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?/) || [, "NaN"];
    const exponent = [...(power || "⁰")].map(c => (c === "⁻" ? "-" : "⁰¹²³⁴⁵⁶⁷⁸⁹".indexOf(c))).join("");
    const unit = 10 ** Number(exponent),
        digits = (mantissa.split(".")[1] || "").length;
    return {value: Number(mantissa) * unit, half: 0.5 * 10 ** -digits * unit};
}

// Share of a canvas that differs from its corner.
export const painted = canvas =>
    canvas.evaluate(c => {
        const data = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
        let count = 0;
        for (let i = 0; i < data.length; i += 4) if ([0, 1, 2, 3].some(k => data[i + k] !== data[k])) ++count;
        return (4 * count) / data.length;
    });
