// Images: the medium as it renders, and one cluster.

const speciesColor = index => (isDark() ? kColorsOnDark : kColors)[index % kColors.length];

function renderFigure(thumbnail) {
    const canvas = element("canvas", {class: "render", role: "img", "aria-label": thumbnail.caption});
    loadImage(thumbnail.file).then(image => {
        if (image) paintImage(canvas, image, wholeOf(image), 0);
        canvas.dataset.ready = "true";
    });
    return element("figure", {class: "view card"}, canvas, element("figcaption", {}, thumbnail.caption));
}

// A round length of about a third of the given one.
function scaleLength(length) {
    const power = 10 ** Math.floor(Math.log10(length / 3));
    return [5, 2, 1].map(lead => lead * power).find(each => each <= length / 2.5);
}

// Spheres from the back to the front, lit from the upper left, paler with the distance.
function drawCluster(canvas, turn) {
    const {spheres} = page.results.cluster;
    const size = canvas.clientWidth || 300,
        ratio = window.devicePixelRatio || 1;
    canvas.width = canvas.height = Math.round(size * ratio);
    const context = canvas.getContext("2d");
    context.scale(ratio, ratio);
    const middle = [0, 1, 2].map(axis => spheres.reduce((sum, s) => sum + s[axis], 0) / spheres.length);
    const reach = Math.max(...spheres.map(s => Math.hypot(...middle.map((m, axis) => s[axis] - m)) + s[3]));
    const unit = (0.46 * size) / reach;
    const [cosY, sinY, cosX, sinX] = [Math.cos(turn.y), Math.sin(turn.y), Math.cos(turn.x), Math.sin(turn.x)];
    const seen = spheres.map(([sx, sy, sz, r, species]) => {
        const [x, y, z] = [sx - middle[0], sy - middle[1], sz - middle[2]];
        const u = cosY * x + sinY * z,
            v = cosY * z - sinY * x;
        return {x: u, y: cosX * y - sinX * v, z: sinX * y + cosX * v, r, species};
    });
    seen.sort((a, b) => b.z - a.z);
    const paper = isDark() ? [27, 30, 35] : [255, 255, 255];
    for (const s of seen) {
        const base = speciesColor(s.species).match(/[0-9a-f]{2}/g).map(h => parseInt(h, 16));
        const far = 0.45 * Math.min(1, Math.max(0, (s.z + reach) / (2 * reach)));
        const shade = amount =>
            `rgb(${base.map((c, i) => {
                const lit = amount > 0 ? c + (255 - c) * amount : c * (1 + amount);
                return Math.round(lit + (paper[i] - lit) * far);
            })})`;
        const [cx, cy, r] = [size / 2 + unit * s.x, size / 2 - unit * s.y, unit * s.r];
        const gradient = context.createRadialGradient(cx - 0.35 * r, cy - 0.4 * r, 0.05 * r, cx, cy, r);
        gradient.addColorStop(0, shade(0.6));
        gradient.addColorStop(0.5, shade(0));
        gradient.addColorStop(1, shade(-0.5));
        context.fillStyle = gradient;
        context.beginPath();
        context.arc(cx, cy, Math.max(r, 0.5), 0, 2 * Math.PI);
        context.fill();
    }
    const bar = scaleLength(2 * reach);
    context.strokeStyle = context.fillStyle = cssColor("--ink");
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(10, size - 10);
    context.lineTo(10 + unit * bar, size - 10);
    context.stroke();
    context.font = `12px ${getComputedStyle(document.body).fontFamily}`;
    context.fillText(bar < 0.1 ? `${tickText(1000 * bar)} nm` : `${tickText(bar)} µm`, 10, size - 17);
}

function clusterFigure() {
    const {cluster, species} = page.results,
        turn = {x: 0.35, y: 0.5};
    const canvas = element("canvas", {class: "cluster", role: "img", "aria-label": "One cluster of spheres"});
    canvas.addEventListener("pointerdown", event => {
        canvas.setPointerCapture(event.pointerId);
        canvas.last = event;
    });
    canvas.addEventListener("pointermove", event => {
        if (!canvas.last || !event.buttons) return;
        turn.y -= 0.01 * (event.clientX - canvas.last.clientX);
        turn.x += 0.01 * (event.clientY - canvas.last.clientY);
        canvas.last = event;
        canvas.redraw();
    });
    canvas.redraw = () => drawCluster(canvas, turn);
    const seen = cluster.spheres.length,
        count = `${cluster.count} sphere${cluster.count === 1 ? "" : "s"}`;
    const names = species.map((s, i) =>
        element("span", {}, element("i", {class: "swatch", style: `background:${speciesColor(i)}`}), s.name)
    );
    return element(
        "figure",
        {class: "view card"},
        canvas,
        element(
            "figcaption",
            {},
            element("div", {class: "species"}, ...names),
            `The first realisation: ${count}${seen < cluster.count ? `, ${seen} of them shown` : ""}. ` +
                (seen > 1 ? "Drag to turn it." : "")
        )
    );
}

const hasLooks = page.results.thumbnails.length > 0 || Boolean(page.results.cluster);

function makeLooks(section) {
    fill(
        section,
        element("h2", {}, "How it looks"),
        element(
            "p",
            {class: "lead"},
            page.results.thumbnails.length > 0
                ? "Rendered as scenes render it, without a surface about it; white is the white of the lamp. Sizes are chosen to let some light through."
                : ""
        ),
        element(
            "div",
            {class: "gallery"},
            ...page.results.thumbnails.map(renderFigure),
            page.results.cluster && clusterFigure()
        )
    );
    section.redraw = () => {
        for (const canvas of section.querySelectorAll("canvas.cluster")) canvas.redraw();
    };
    section.redraw();
}
