"use strict";
// Text, numbers and elements. Text always enters the page as text nodes, never as markup.

// What the page shows, and what more than one part of it follows; comparisons add the reader's choices.
const page = {
    results: JSON.parse(document.getElementById("results").textContent),
    printing: false
};

// element("td", {class: "number"}, "12", child): null and false children are left out.
function element(tag, attributes, ...children) {
    const node = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes || {})) {
        if (value === null || value === undefined || value === false) continue;
        if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
        else node.setAttribute(name, value === true ? "" : value);
    }
    node.append(...children.flat().filter(child => child !== null && child !== undefined && child !== false));
    return node;
}

// Puts children in place of what a node holds.
function fill(node, ...children) {
    node.replaceChildren();
    node.append(...children.flat().filter(child => child !== null && child !== undefined && child !== false));
}

function svgElement(tag, attributes, ...children) {
    const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [name, value] of Object.entries(attributes || {})) node.setAttribute(name, value);
    node.append(...children);
    return node;
}

const kMissing = "–";
const isNumber = value => typeof value === "number" && Number.isFinite(value);

const superscript = integer => String(integer).replace(/[-0-9]/g, c => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[+c]));

// So many significant digits; powers of ten where plain digits would be long.
function formatNumber(value, digits = 3) {
    if (!isNumber(value)) return kMissing;
    if (value === 0) return "0";
    const magnitude = Math.abs(value);
    const sign = value < 0 ? "−" : "";
    if (magnitude >= 1e-4 && magnitude < 1e5) {
        const exponent = Math.floor(Math.log10(Number(magnitude.toPrecision(digits))));
        return sign + magnitude.toFixed(Math.max(0, digits - 1 - exponent));
    }
    const [mantissa, exponent] = magnitude.toExponential(digits - 1).split("e");
    return `${sign}${mantissa}·10${superscript(Number(exponent))}`;
}

// A number of an axis or a scale, as short as it can be.
const tickText = tick =>
    tick === 0
        ? "0"
        : Math.abs(tick) >= 1e-4
          ? String(Number(tick.toPrecision(2))).replace("-", "−")
          : formatNumber(tick, 1);

// Factors near 1: two digits behind the point.
const formatRatio = value =>
    isNumber(value) && value >= 0.1 && value < 10 ? value.toFixed(2) : formatNumber(value);

function formatSeconds(seconds) {
    if (!isNumber(seconds)) return kMissing;
    return seconds < 600 ? `${formatNumber(seconds, 3)} s` : `${formatNumber(seconds / 60, 3)} min`;
}

const formatPercent = share => (isNumber(share) ? `${formatNumber(100 * share, 2)} %` : kMissing);

// A number with the data attribute by which tests find it: the path names its place in results.json.
function numberSpan(path, value, text) {
    return element("span", {"data-path": path, "data-value": isNumber(value) ? String(value) : "null"}, text);
}

// Lines break between words only, never at the hyphens of an option.
const commandWords = command =>
    command.split(/(\s+)/).map(word => (/^\s*$/.test(word) ? word : element("span", {class: "word"}, word)));

// Okabe and Ito 2008: told apart under the common colour deficiencies.
const kColors = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
const kColorsOnDark = ["#4aa3dc", "#f0803c", "#2cc79a", "#dd95bb", "#f0b429", "#7cc8f2"];

const prefersDark = window.matchMedia("(prefers-color-scheme: dark)");
// `redraw` where colours of plots and canvases may have to change: by night and by day, on paper and off it.
function whenLooksChange(redraw) {
    prefersDark.addEventListener("change", redraw);
    for (const [event, printing] of [
        ["beforeprint", true],
        ["afterprint", false]
    ])
        window.addEventListener(event, () => {
            page.printing = printing;
            document.documentElement.classList.toggle("printing", printing);
            redraw();
        });
}
const isDark = () => prefersDark.matches && !page.printing;

function button(label, title, action, attributes = {}) {
    return element("button", {type: "button", title, onclick: action, ...attributes}, label);
}

// Buttons of which one is pressed: choices {value: label}; says the chosen value.
function segments(name, choices, chosen, action) {
    const group = element("div", {class: "segments", role: "group", "aria-label": name});
    const mark = value => {
        for (const b of group.children) b.setAttribute("aria-pressed", String(b.dataset.value === value));
    };
    for (const [value, label] of Object.entries(choices))
        group.append(
            button(
                label,
                name,
                () => {
                    mark(value);
                    action(value);
                },
                {"data-value": value}
            )
        );
    mark(chosen);
    group.choose = mark;
    return group;
}

// The end of a page: what its terms mean, by their names, and whom it owes thanks.
function fillMethod(section, terms, thanks) {
    const list = element("dl", {class: "terms"});
    for (const [term, text] of Object.entries(terms))
        list.append(element("dt", {}, term), element("dd", {}, text));
    fill(
        section,
        element("h2", {}, "How to read this"),
        list,
        element("footer", {}, `Made by Lacquer ${page.results.version || ""}. `, thanks)
    );
}
