// The page's numbers against results.json.
import assert from "node:assert";
import {lookUp, shownNumber} from "./report_data.mjs";

const kBoxFields = [
    "rmse.value",
    "rmse.low",
    "rmse.high",
    "rmse_reduction.value",
    "rmse_reduction.low",
    "rmse_reduction.high",
    "time_reduction.value",
    "time_reduction.low",
    "time_reduction.high",
    "relative_mse.value",
    "relative_mse.low",
    "relative_mse.high",
    "bias.z",
    "reference_noise_share",
    "rmse_corrected"
];
const kDenoiserFields = ["flip", "systematic_share"];
const kEstimatorFields = ["samples_per_pixel", "seconds", "microseconds_per_sample"];

// What is wrong with the numbers that the page shows of a variant; empty if all are right.
export async function wrongNumbers(page, results, variant) {
    const spans = await page.$$eval("[data-path]", nodes =>
        nodes.map(node => ({
            place: node.dataset.path,
            value: node.dataset.value,
            text: node.textContent,
            inTable: Boolean(node.closest("table.numbers"))
        }))
    );
    const wrong = [],
        inTable = new Set(spans.filter(s => s.inTable).map(s => s.place));
    for (const {place, value, text} of spans) {
        const expected = lookUp(results, place);
        if (typeof expected !== "number") {
            if (value !== "null" || text !== "–")
                wrong.push(`${place}: shows "${text}" where there is no number`);
            continue;
        }
        if (Number(value) !== expected) wrong.push(`${place}: has ${value}, results.json ${expected}`);
        const shown = shownNumber(text);
        if (!shown || Math.abs(shown.value - expected) > shown.tolerance)
            wrong.push(`${place}: shows "${text}" for ${expected}`);
    }
    // Nothing that was measured may be left out.
    const boxFields = kBoxFields
        .filter(f => f !== "bias.z" || results.compared !== "denoiser")
        .concat(results.compared === "denoiser" ? kDenoiserFields : []);
    results.variants[variant].estimators.forEach((estimator, e) => {
        const at = `variants.${variant}.estimators.${e}`;
        const places = [
            ...kEstimatorFields.map(f => `${at}.${f}`),
            ...results.boxes.flatMap((_, b) => boxFields.map(f => `${at}.boxes.${b}.${f}`))
        ];
        for (const place of places)
            if (typeof lookUp(results, place) === "number" && !inTable.has(place))
                wrong.push(`${place}: not in the table`);
    });
    return wrong;
}

export async function checkNumbers(test, page, report) {
    const {results} = report;
    await test("the embedded results equal results.json", () =>
        assert.deepStrictEqual(report.embedded, results));
    for (let v = 0; v < results.variants.length; ++v) {
        if (results.variants.length > 1) await selectVariant(page, v);
        await test(`every number of variant ${v} is that of results.json`, async () =>
            assert.deepStrictEqual(await wrongNumbers(page, results, v), []));
        await test(`the best estimator of each box of variant ${v} is marked`, () =>
            checkBest(page, results, v));
        await test(`a bias beyond 3.5 standard errors is marked, and no other, in variant ${v}`, () =>
            checkBias(page, results, v));
        await test(`the plots of variant ${v} draw the convergence of results.json`, () =>
            checkPlots(page, results, v));
    }
    if (results.variants.length > 1) await selectVariant(page, 0);
    await test("the notice of a stopped experiment is there if and only if it stopped early", async () =>
        assert.strictEqual(await page.locator("#incomplete").count(), results.complete === false ? 1 : 0));
    await test("the page calls what is compared by its name, and nothing else", async () => {
        const text = await page.evaluate(() => document.body.innerText);
        for (const noun of ["estimator", "integrator", "light sampler"])
            if (noun !== results.compared)
                assert.ok(!text.replace(results.command, "").toLowerCase().includes(noun), noun);
        assert.ok(text.includes(`for each ${results.compared}, interleaved`));
    });
    await test("the command is shown as typed", async () =>
        assert.strictEqual(await page.textContent("#command"), results.command));
    await test("the download is results.json", async () => {
        const [download] = await Promise.all([page.waitForEvent("download"), page.click("#download")]);
        const chunks = [];
        for await (const chunk of await download.createReadStream()) chunks.push(chunk);
        assert.deepStrictEqual(JSON.parse(Buffer.concat(chunks).toString("utf8")), results);
    });
}

export async function selectVariant(page, index) {
    await page.selectOption("#variant", String(index));
    await page.waitForFunction(() => document.documentElement.dataset.ready === "true");
}

async function checkBest(page, results, variant) {
    const shown = await page.$$eval("#numbers tbody[data-box]", bodies =>
        bodies.map(body =>
            [...body.querySelectorAll("tr:not(.group)")].map(row => [
                row.classList.contains("best"),
                row.querySelector(".badge:not(.plain)")?.textContent ?? null
            ])
        )
    );
    const sentences = await page.$$eval(".findings li", items => items.map(item => item.textContent));
    results.boxes.forEach((_, b) => {
        const {estimators} = results.variants[variant];
        const verdicts = estimators.map(e => e.boxes[b].verdict);
        const leads = verdicts.map(v => v === "best" || v === "indistinguishable");
        const isTie = leads.filter(Boolean).length > 1;
        const badge = isTie ? "indistinguishable" : "least error";
        assert.deepStrictEqual(
            shown[b],
            leads.map(isLeader => [isLeader, isLeader ? badge : null])
        );
        // Who leads alone has the least error of all; nobody is called best in a tie.
        if (estimators.length > 1) assert.strictEqual(/are indistinguishable/.test(sentences[b]), isTie);
        if (isTie) {
            assert.ok(!/is best|least error/.test(sentences[b]), sentences[b]);
            estimators.forEach((e, i) => leads[i] && assert.ok(sentences[b].includes(e.name), e.name));
        }
        if (results.budget.kind === "samples") {
            const errors = estimators.map(e => e.boxes[b].rmse_corrected);
            // One whose error could not be measured may have the least.
            const best = errors.includes(null) ? -1 : errors.indexOf(Math.min(...errors));
            assert.strictEqual(verdicts.indexOf("best"), best);
            if (best < 0 && estimators.length > 1) assert.match(sentences[b], /cannot be told/);
        }
    });
}

async function checkBias(page, results, variant) {
    const cells = await page.$$eval("#numbers table [data-path$='bias.z']", spans =>
        spans.map(span => ({place: span.dataset.path, loud: span.closest("td").classList.contains("loud")}))
    );
    // Denoised images have no such check, and their comparisons no such column.
    const expected = results.boxes.length * results.variants[variant].estimators.length;
    assert.strictEqual(cells.length, results.compared === "denoiser" ? 0 : expected);
    for (const {place, loud} of cells)
        assert.strictEqual(loud, Math.abs(lookUp(results, place) ?? 0) > 3.5, place);
}

async function checkPlots(page, results, variant) {
    // The page's `plots`: one chart for each box that has measurements.
    const drawn = await page.evaluate(() =>
        plots.map(plot => plot.data.datasets.map(d => ({label: d.label, data: d.data})))
    );
    const expected = results.boxes
        .map((_, b) =>
            results.variants[variant].estimators
                .map(e => ({
                    label: e.name,
                    data: (lookUp(e, `boxes.${b}.convergence`) || [])
                        .filter(p => p.rmse !== null)
                        .map(p => ({x: p.seconds, y: p.rmse}))
                }))
                .filter(d => d.data.length > 0)
        )
        .filter(datasets => datasets.length > 0);
    assert.strictEqual(drawn.length, expected.length);
    drawn.forEach((datasets, k) => {
        const slope = datasets.pop().data;
        assert.deepStrictEqual(datasets, expected[k]);
        const measured = Math.log(slope[1].y / slope[0].y) / Math.log(slope[1].x / slope[0].x);
        assert.ok(
            Math.abs(measured + 0.5) < 1e-9 || slope[0].x === slope[1].x,
            `expected slope is ${measured}`
        );
    });
    const painted = await page.$$eval(".plot canvas", canvases =>
        canvases.map(canvas =>
            canvas
                .getContext("2d")
                .getImageData(0, 0, canvas.width, canvas.height)
                .data.some(v => v > 0)
        )
    );
    assert.ok(painted.every(Boolean), "a plot is empty");
}
