// Crops and viewer: colours on the page's canvases against images decoded and developed here.
import assert from "node:assert";
import {setTimeout as sleep} from "node:timers/promises";

// Rounding of the page's tables and of ours may differ by one step of 255.
const isSame = (color, expected) => expected.every((v, c) => Math.abs(v - color[c]) <= 1);

const settle = page =>
    page.evaluate(() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))));

// Colours of a canvas at points in its own pixels.
const canvasColors = (canvas, points) =>
    canvas.evaluate((node, places) => {
        const context = node.getContext("2d");
        return places.map(([x, y]) => [...context.getImageData(x, y, 1, 1).data].slice(0, 3));
    }, points);

// Points spread over a rectangle, by the additive recurrence of the plastic number.
function spread(count, width, height) {
    const points = [];
    for (let i = 1; i <= count; ++i)
        points.push([
            Math.floor(((i * 0.7548776662466927) % 1) * width),
            Math.floor(((i * 0.5698402909980532) % 1) * height)
        ]);
    return points;
}

export async function checkCrops(test, page, report, stops) {
    const {results, pictures} = report,
        variant = results.variants[0];
    const expectedRenders = [variant.reference.image, ...variant.estimators.map(e => e.images.run)].filter(
        f => pictures.has(f)
    );
    await test(`every crop of a render shows its pixels at ${stops} stops`, async () => {
        for (let b = 0; b < results.boxes.length; ++b) {
            const article = page.locator("#crops article").nth(b),
                [x0, x1, y0, y1] = report.boxes[b];
            const canvases = await article.locator("canvas.render").all();
            const files = await Promise.all(canvases.map(c => c.getAttribute("data-file")));
            assert.deepStrictEqual(files, expectedRenders);
            for (const canvas of canvases) {
                const picture = pictures.get(await canvas.getAttribute("data-file"));
                const points = spread(200, x1 - x0, y1 - y0),
                    colors = await canvasColors(canvas, points);
                points.forEach(([x, y], i) =>
                    assert.ok(
                        isSame(colors[i], picture.colorAt(x0 + x, y0 + y, stops)),
                        `${picture} at ${x0 + x}, ${y0 + y}: ${colors[i]}, not ${picture.colorAt(x0 + x, y0 + y, stops)}`
                    )
                );
            }
        }
    });
}

// Magma grows in luminance with the value: on one scale a greater error is never darker, whoever's it is.
export async function checkErrorMaps(test, page, report) {
    const {results, pictures} = report;
    for (const choice of ["linear", "log"])
        await test(`maps of errors share one scale (${choice})`, async () => {
            await page.click(`#crops .segments button[data-value="${choice}"]`);
            const seen = [];
            for (let b = 0; b < results.boxes.length; ++b)
                for (const canvas of await page
                    .locator("#crops article")
                    .nth(b)
                    .locator("canvas.error")
                    .all()) {
                    const picture = pictures.get(await canvas.getAttribute("data-file")),
                        [x0, x1, y0, y1] = report.boxes[b];
                    const points = spread(150, x1 - x0, y1 - y0),
                        colors = await canvasColors(canvas, points);
                    points.forEach(([x, y], i) => {
                        const [r, g, b2] = colors[i].map(v => (v / 255) ** 2.2);
                        seen.push({
                            value: picture.at(x0 + x, y0 + y)[0],
                            luminance: 0.2126 * r + 0.7152 * g + 0.0722 * b2
                        });
                    });
                }
            seen.sort((p, q) => p.value - q.value);
            for (let i = 1; i < seen.length; ++i)
                assert.ok(
                    seen[i].luminance >= seen[i - 1].luminance - 2e-3,
                    `error ${seen[i].value} is darker than ${seen[i - 1].value}`
                );
            assert.ok(seen.at(-1).luminance > seen[0].luminance + 0.2, "the maps have no contrast");
        });
}

async function stageState(page) {
    await settle(page);
    const data = await page.$eval("#stage", stage => ({...stage.dataset}));
    return {
        ...data,
        scale: +data.scale,
        split: +data.split,
        stops: +data.stops,
        panes: JSON.parse(data.panes),
        center: {x: +data.centerX, y: +data.centerY}
    };
}

// Points of images in a pane's part [left, right) with what the canvas shows there.
async function samplePane(page, pane, left, right) {
    const state = await stageState(page),
        ratio = await page.evaluate(() => devicePixelRatio);
    const samples = spread(600, right - left, pane.height)
        .map(([dx, dy]) => {
            const x = Math.floor(state.center.x + (left + dx - pane.x - pane.width / 2) / state.scale);
            const y = Math.floor(state.center.y + (dy - pane.height / 2) / state.scale);
            // To the middle of the image's pixel, where no rounding can lead to its neighbour.
            const sx = pane.x + pane.width / 2 + (x + 0.5 - state.center.x) * state.scale;
            const sy = pane.y + pane.height / 2 + (y + 0.5 - state.center.y) * state.scale;
            return {x, y, sx, sy};
        })
        .filter(s => s.sx >= left && s.sx < right && s.sy >= pane.y && s.sy < pane.y + pane.height);
    const colors = await canvasColors(
        page.locator("#stage-canvas"),
        samples.map(s => [Math.floor(s.sx * ratio), Math.floor(s.sy * ratio)])
    );
    return samples.map((s, i) => ({...s, color: colors[i]}));
}

// Counts how many samples show `expected`, and how many of these tell it from `other`.
function agreement(samples, expected, other, stops) {
    const inside = samples.filter(s => s.x >= 0 && s.y >= 0 && s.x < expected.width && s.y < expected.height);
    const right = inside.filter(s => isSame(s.color, expected.colorAt(s.x, s.y, stops)));
    const telling = right.filter(s => !isSame(s.color, other.colorAt(s.x, s.y, stops)));
    return {all: inside.length, right: right.length, telling: telling.length};
}

function assertShows(samples, expected, other, stops, what) {
    const {all, right, telling} = agreement(samples, expected, other, stops);
    assert.ok(
        all > 30 && right === all && telling > all / 4,
        `${what}: ${right} of ${all} pixels, ${telling} telling`
    );
}

async function stageBox(page) {
    await page.locator("#stage").scrollIntoViewIfNeeded();
    return page.locator("#stage").boundingBox();
}

const pressOnStage = async (page, key) => {
    await page.focus("#stage");
    await page.keyboard.press(key);
};

// Drags from and to places that are shares of the stage.
async function drag(page, from, to) {
    const box = await stageBox(page);
    await page.mouse.move(box.x + from.x * box.width, box.y + from.y * box.height);
    await page.mouse.down();
    await page.mouse.move(
        box.x + ((from.x + to.x) / 2) * box.width,
        box.y + ((from.y + to.y) / 2) * box.height
    );
    await page.mouse.move(box.x + to.x * box.width, box.y + to.y * box.height);
    await page.mouse.up();
    await settle(page);
}

// With Ctrl, which makes the wheel zoom.
async function wheel(page, at, deltaY) {
    const box = await stageBox(page);
    await page.mouse.move(box.x + at.x * box.width, box.y + at.y * box.height);
    await page.keyboard.down("Control");
    await page.mouse.wheel(0, deltaY);
    await page.keyboard.up("Control");
    await sleep(100);
    await settle(page);
}

export async function checkViewer(test, page, report, shot) {
    const {results, pictures} = report,
        runs = results.variants[0].estimators
            .map((e, i) => [i, e.images.run])
            .filter(([, file]) => pictures.has(file));
    const files =
        runs.length > 1 ? [runs[0], runs[1]] : [runs[0], ["reference", results.variants[0].reference.image]];
    const [a, b] = files.map(([, file]) => pictures.get(file));
    await page.uncheck("#outlines");
    await page.selectOption("#picture-a", `${files[0][0]}.run`);
    await page.selectOption("#picture-b", runs.length > 1 ? `${files[1][0]}.run` : "reference");

    await test("the wheel alone scrolls the page, and zooms after a click until the pointer leaves", async () => {
        await page.click("#zoom-fit");
        const box = await stageBox(page),
            scale = async () => (await stageState(page)).scale,
            top = () => page.evaluate(() => window.scrollY);
        const turn = async () => {
            await page.mouse.wheel(0, -40);
            await sleep(200);
            await settle(page);
        };
        await page.mouse.move(box.x + 0.42 * box.width, box.y + 0.4 * box.height);
        const before = await scale(),
            place = await top();
        await turn();
        assert.strictEqual(await scale(), before);
        const scrolled = await top();
        assert.ok(scrolled < place, "the page did not scroll");
        await page.mouse.down();
        await page.mouse.up();
        await turn();
        const zoomed = await scale();
        assert.ok(zoomed > 1.05 * before, "a click does not give the wheel to the viewer");
        assert.strictEqual(await top(), scrolled);
        await page.mouse.move(2, 2);
        await page.mouse.move(box.x + 0.42 * box.width, box.y + 0.4 * box.height);
        await turn();
        assert.strictEqual(await scale(), zoomed);
        await page.click("#zoom-fit");
    });
    await test("Ctrl and the wheel zoom and keep the point under the pointer", async () => {
        await page.click("#zoom-fit");
        const before = await stageState(page),
            at = {x: 0.42, y: 0.4};
        await wheel(page, at, -240);
        await wheel(page, at, -240);
        const after = await stageState(page),
            pane = after.panes[0];
        const under = s => ({
            x: s.center.x + ((at.x - 0.5) * pane.width) / s.scale,
            y: s.center.y + ((at.y - 0.5) * pane.height) / s.scale
        });
        assert.ok(after.scale > 2 * before.scale, `${before.scale} to ${after.scale}`);
        // Events carry whole CSS pixels.
        const slack = 1.5 / before.scale;
        assert.ok(Math.abs(under(before).x - under(after).x) < slack, "x");
        assert.ok(Math.abs(under(before).y - under(after).y) < slack, "y");
    });
    await test("dragging pans by what the pointer moves", async () => {
        const before = await stageState(page);
        await drag(page, {x: 0.3, y: 0.3}, {x: 0.4, y: 0.35});
        const after = await stageState(page),
            pane = after.panes[0];
        assert.ok(Math.abs((before.center.x - after.center.x) * after.scale - 0.1 * pane.width) < 2, "x");
        assert.ok(Math.abs((before.center.y - after.center.y) * after.scale - 0.05 * pane.height) < 2, "y");
    });
    await test("the wipe is dragged, and shows A left and B right of its bar", async () => {
        await drag(page, {x: 0.5, y: 0.7}, {x: 0.35, y: 0.6});
        const state = await stageState(page),
            pane = state.panes[0],
            bar = state.split * pane.width;
        assert.ok(Math.abs(state.split - 0.35) < 0.01, `the bar stands at ${state.split}`);
        assertShows(await samplePane(page, pane, 0, bar - 2), a, b, 0, "left");
        assertShows(await samplePane(page, pane, bar + 2, pane.width), b, a, 0, "right");
    });
    await test("negative control: with A for B the check of the wipe fails", async () => {
        const state = await stageState(page),
            pane = state.panes[0];
        const samples = await samplePane(page, pane, 0, state.split * pane.width - 2);
        assert.throws(() => assertShows(samples, b, a, 0, "left"));
    });
    await test("keys move the wipe", async () => {
        const before = await stageState(page);
        await page.focus("#divider");
        await page.keyboard.press("ArrowRight");
        assert.ok((await stageState(page)).split > before.split);
    });
    await shot("viewer-wipe");
    await test("Space flips between A and B", async () => {
        await pressOnStage(page, "2");
        for (const [shown, hidden] of [
            [a, b],
            [b, a],
            [a, b]
        ]) {
            const {
                panes: [pane]
            } = await stageState(page);
            assertShows(await samplePane(page, pane, 0, pane.width), shown, hidden, 0, "flip");
            await pressOnStage(page, " ");
        }
        await pressOnStage(page, " ");
    });
    await test("side by side shows both under one zoom and pan", async () => {
        await pressOnStage(page, "3");
        await pressOnStage(page, "ArrowLeft");
        const {
            panes: [left, right]
        } = await stageState(page);
        assertShows(await samplePane(page, left, left.x, left.x + left.width), a, b, 0, "left");
        assertShows(await samplePane(page, right, right.x, right.x + right.width), b, a, 0, "right");
    });
    await shot("viewer-side-by-side");
    await test("the pixel under the pointer is read out", async () => {
        await pressOnStage(page, "1");
        await wheel(page, {x: 0.45, y: 0.55}, -240);
        const data = await page.$eval("#readout", table => ({...table.dataset}));
        const texts = await page.$$eval("#readout tbody tr", rows =>
            rows.map(row => [...row.querySelectorAll("td")].map(c => c.textContent))
        );
        const values = [a.at(+data.x, +data.y), b.at(+data.x, +data.y)];
        values.push(values[0].map((v, c) => v - values[1][c]));
        texts.forEach((row, r) =>
            row.forEach((text, c) => {
                const shown = Number(text.replace("−", "-").replace(/·10.*/, ""));
                if (!text.includes("·") && Number.isFinite(values[r][c]))
                    assert.ok(
                        Math.abs(shown - values[r][c]) <= 6e-4 * Math.abs(values[r][c]),
                        `${text} for ${values[r][c]}`
                    );
            })
        );
        assert.strictEqual(texts.length, 3);
    });
    await test("exposure develops the viewer anew", async () => {
        await page.fill("#exposure", "1.5");
        const state = await stageState(page),
            pane = state.panes[0];
        assert.strictEqual(state.stops, 1.5);
        assertShows(await samplePane(page, pane, 0, state.split * pane.width - 2), a, b, 1.5, "left");
    });
    await checkCrops(test, page, report, 1.5);
    await page.click(".exposure button");
    await checkCrops(test, page, report, 0);
    await test("the difference with its sign is orange where A is greater and blue where B is", async () => {
        await pressOnStage(page, "4");
        const {
            panes: [pane]
        } = await stageState(page);
        let telling = 0;
        for (const s of await samplePane(page, pane, 0, pane.width)) {
            if (s.x < 0 || s.y < 0 || s.x >= a.width || s.y >= a.height) continue;
            const mean = p => p.at(s.x, s.y).reduce((sum, v) => sum + v, 0) / 3,
                d = mean(a) - mean(b);
            if (!(Math.abs(d) > 0.02 * mean(a))) continue;
            assert.ok(d > 0 ? s.color[0] > s.color[2] : s.color[2] > s.color[0], `${d}: ${s.color}`);
            ++telling;
        }
        assert.ok(telling > 20, `${telling} telling pixels`);
    });
    await shot("viewer-difference");
    await test("the absolute difference is another image", async () => {
        const {
                panes: [pane]
            } = await stageState(page),
            signed = await samplePane(page, pane, 0, pane.width);
        await pressOnStage(page, "s");
        const absolute = await samplePane(page, pane, 0, pane.width);
        assert.ok(signed.some((s, i) => !isSame(s.color, absolute[i].color)));
        await pressOnStage(page, "s");
    });
    await pressOnStage(page, "1");
    await pressOnStage(page, "0");
    await page.check("#outlines");
    await test("a click on a crop opens the reference and that run, at its box", async () => {
        const crop = page.locator("#crops article").first().locator("canvas.render").nth(1);
        await crop.click();
        const state = await stageState(page),
            [x0, x1, y0, y1] = report.boxes[0];
        assert.strictEqual(state.a, results.variants[0].reference.image);
        assert.strictEqual(state.b, results.variants[0].estimators[0].images.run);
        assert.ok(
            Math.abs(state.center.x - (x0 + x1) / 2) < 1 && Math.abs(state.center.y - (y0 + y1) / 2) < 1
        );
        await pressOnStage(page, "0");
    });
    await test("two fingers zoom", async () => {
        const before = await stageState(page),
            box = await stageBox(page);
        const fingers = reach =>
            [-1, 1].map((side, id) => ({
                x: box.x + box.width / 4 + side * reach,
                y: box.y + box.height / 2,
                id
            }));
        const session = await page.context().newCDPSession(page);
        const touch = (type, reach) =>
            session.send("Input.dispatchTouchEvent", {
                type,
                touchPoints: reach === null ? [] : fingers(reach)
            });
        await touch("touchStart", 30);
        for (const reach of [40, 50, 60]) await touch("touchMove", reach);
        await touch("touchEnd", null);
        const after = await stageState(page);
        // Moves may come in any number of steps, the first of them late.
        assert.ok(
            after.scale > 1.3 * before.scale && after.scale < 2.1 * before.scale,
            `${before.scale} to ${after.scale}`
        );
        await pressOnStage(page, "0");
    });
    await test("outlines of boxes change the image", async () => {
        const {
                panes: [pane]
            } = await stageState(page),
            whole = () => page.$eval("#stage-canvas", c => c.toDataURL());
        const before = await whole();
        await pressOnStage(page, "o");
        await settle(page);
        assert.notStrictEqual(await whole(), before);
        await pressOnStage(page, "o");
    });
}
