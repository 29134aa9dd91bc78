// Puts sections into the page, and a strip with links to them.

const part = id => document.getElementById(id);

// The strip that stays.
function makeLinkBar(bar, sections) {
    const links = sections.filter(([, name]) => name).map(([id, name]) => element("a", {href: `#${id}`}, name));
    fill(bar, element("div", {class: "bar-inner"}, element("nav", {"aria-label": "Parts of the page"}, ...links)));
}

// all: [whether there is something for it, section, its name in the strip, how it is made]; the others are left out.
function startPage(all) {
    for (const [isThere, id] of all) if (!isThere) part(id).remove();
    const sections = all.filter(([isThere]) => isThere).map(([, ...rest]) => rest);
    useFontOfPage();
    const recolor = () => {
        useFontOfPage();
        for (const [id] of sections) if (part(id).redraw) part(id).redraw();
    };
    makeLinkBar(part("bar"), sections);
    sections.forEach(([id, , make]) => make(part(id)));
    whenLooksChange(recolor);
    Promise.all(painting).then(() => {
        document.documentElement.dataset.ready = "true";
    });
}
