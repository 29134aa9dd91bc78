// Blocks that pages other than those of comparisons share.

const headCell = (name, unit) =>
    element("th", {scope: "col"}, name, unit ? element("small", {}, unit) : false);

// A link that saves what the page was made from.
function downloadResults(name) {
    const blob = new Blob([JSON.stringify(page.results, null, 1) + "\n"], {type: "application/json"});
    return element(
        "a",
        {id: "download", href: URL.createObjectURL(blob), download: name},
        "Download all numbers of this page"
    );
}

function textBlock(title, text, id) {
    return [
        element("h2", {class: "small"}, title),
        element(
            "div",
            {class: "command"},
            element("pre", {tabindex: 0, class: "input", id}, element("code", {}, ...commandWords(text)))
        )
    ];
}

// Terms and what they are: [{name, value}].
function listOf(entries, attributes) {
    const list = element("dl", attributes);
    for (const {name, value} of entries) list.append(element("dt", {}, name), element("dd", {}, value));
    return list;
}

const findingItem = ({label, text}) => element("li", {}, element("span", {class: "box-name"}, label), element("span", {}, text));

// What the page is of: settings and version, the command, and its numbers as a file of that name.
function settingsAndCommand(file) {
    const {settings, version, command} = page.results;
    return element(
        "div",
        {class: "columns"},
        listOf([...settings, {name: "Version", value: `Lacquer ${version}`}], {class: "facts"}),
        element("div", {}, command ? textBlock("The command", command, "command") : [], downloadResults(file))
    );
}
