// Pointer and keys of the viewer.

const stagePoint = event => {
    const area = viewer.canvas.getBoundingClientRect();
    return {x: event.clientX - area.left, y: event.clientY - area.top};
};

function moveCursor(point) {
    const pane = point && paneAt(point.x, point.y);
    const p = pane && toPicture(pane, point.x, point.y),
        image = pictureA().image;
    const inside = p && p.x >= 0 && p.y >= 0 && p.x < image.width && p.y < image.height;
    viewer.cursor = inside ? {x: Math.floor(p.x), y: Math.floor(p.y)} : null;
    viewer.onDraw();
}

// One pointer pans, two pinch.
function listenToPointers(canvas) {
    const pointers = new Map();
    const spread = () => {
        const [p, q] = [...pointers.values()];
        return {distance: Math.hypot(p.x - q.x, p.y - q.y), x: (p.x + q.x) / 2, y: (p.y + q.y) / 2};
    };
    canvas.addEventListener("pointerdown", event => {
        canvas.setPointerCapture(event.pointerId);
        pointers.set(event.pointerId, stagePoint(event));
    });
    canvas.addEventListener("pointermove", event => {
        const point = stagePoint(event),
            last = pointers.get(event.pointerId);
        if (last && pointers.size === 1) panBy(point.x - last.x, point.y - last.y);
        if (last && pointers.size === 2) {
            const before = spread();
            pointers.set(event.pointerId, point);
            const after = spread();
            zoomAt(after.distance / Math.max(1, before.distance), after.x, after.y);
            panBy(after.x - before.x, after.y - before.y);
        }
        if (last) pointers.set(event.pointerId, point);
        moveCursor(point);
    });
    for (const end of ["pointerup", "pointercancel"])
        canvas.addEventListener(end, event => pointers.delete(event.pointerId));
    canvas.addEventListener("pointerleave", () => moveCursor(null));
}

// The wheel scrolls the page, as it does elsewhere. It zooms with Ctrl (which is also what a pinch on a touchpad
// sends), and after a click until the pointer leaves.
function listenToWheel(canvas) {
    let isTaken = false;
    canvas.addEventListener("pointerdown", () => (isTaken = true));
    canvas.addEventListener("pointerleave", () => (isTaken = false));
    canvas.addEventListener(
        "wheel",
        event => {
            const isAsked = event.ctrlKey || event.metaKey;
            if (!isAsked && !isTaken) return;
            // At its smallest the image lets the page scroll on.
            if (!isAsked && event.deltaY > 0 && viewer.scale <= fitScale() * 1.001) return;
            event.preventDefault();
            const {x, y} = stagePoint(event),
                pixels = event.deltaY * (event.deltaMode === 1 ? 30 : 1);
            zoomAt(2 ** (-Math.min(240, Math.max(-240, pixels)) / 240), x, y);
            moveCursor({x, y});
        },
        {passive: false}
    );
}

function listenToDivider(divider) {
    const moveTo = split => {
        viewer.split = Math.min(1, Math.max(0, split));
        drawViewer();
    };
    divider.addEventListener("pointerdown", event => {
        divider.setPointerCapture(event.pointerId);
        event.preventDefault();
        divider.focus();
    });
    divider.addEventListener("pointermove", event => {
        if (divider.hasPointerCapture(event.pointerId)) moveTo(stagePoint(event).x / stageSize().width);
    });
    divider.addEventListener("keydown", event => {
        const step = {ArrowLeft: -0.02, ArrowRight: 0.02, PageDown: -0.1, PageUp: 0.1, Home: -1, End: 1}[
            event.key
        ];
        if (!step) return;
        event.preventDefault();
        event.stopPropagation();
        moveTo(viewer.split + step);
    });
}

// `actions`: what other parts of the page do, see viewer_panel.js.
function listenToKeys(stage, actions) {
    const middle = () => {
        const {width, height} = stageSize();
        return [width / 2, height / 2];
    };
    const keys = {
        1: () => actions.mode("wipe"),
        2: () => actions.mode("flip"),
        3: () => actions.mode("side"),
        4: () => actions.mode("difference"),
        " ": actions.flip,
        f: actions.flip,
        x: actions.swap,
        s: actions.sign,
        o: actions.outlines,
        0: fitView,
        "+": () => zoomAt(1.25, ...middle()),
        "=": () => zoomAt(1.25, ...middle()),
        "-": () => zoomAt(0.8, ...middle()),
        "[": () => actions.expose(-0.5),
        "]": () => actions.expose(0.5),
        ArrowLeft: () => panBy(40, 0),
        ArrowRight: () => panBy(-40, 0),
        ArrowUp: () => panBy(0, 40),
        ArrowDown: () => panBy(0, -40)
    };
    stage.addEventListener("keydown", event => {
        if (event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
        event.preventDefault();
        keys[event.key]();
    });
}
