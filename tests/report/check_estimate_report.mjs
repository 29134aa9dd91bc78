// Opens a report of `lacquer estimate` in headless Chromium and checks it:
//   node check_estimate_report.mjs DIR/report.html SCREENSHOTS
// Last line: "N passed, M failed". Exit status 1 if any failed.
import assert from "node:assert";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import {checkLayouts, finish, launch, openReport, test} from "./browser.mjs";
import {numberOf, painted} from "./shown.mjs";

const [file, shots] = process.argv.slice(2).map(argument => path.resolve(argument));
fs.mkdirSync(shots, {recursive: true});
const html = fs.readFileSync(file, "utf8");
const results = JSON.parse(html.match(/<script type="application\/json" id="results">(.*?)<\/script>/s)[1]);
const hasChains = !results.map_only && results.parameters.some(p => p.histogram);

const valueAt = names => names.split(".").reduce((value, name) => value?.[name], results);

// Numbers of the page whose text is not what the results have at their place.
async function wrongNumbers(page) {
    const spans = await page.$$eval("[data-path]", all => all.map(s => ({path: s.dataset.path, text: s.textContent})));
    assert.ok(spans.length >= 2 * results.parameters.length, `only ${spans.length} numbers`);
    return spans.filter(({path: place, text}) => {
        const expected = valueAt(place);
        assert.notStrictEqual(expected, undefined, place);
        if (expected === null) return text !== "–";
        const {value, half} = numberOf(text);
        return !(Math.abs(value - expected) <= 1.001 * half);
    });
}

async function checkSections(page) {
    await test("sections are there where there is something for them, and only then", async () => {
        const expected = {
            head: true,
            parameters: results.parameters.length > 0,
            lobes: results.lobes.length > 0,
            next: results.next.length > 0,
            marginals: hasChains,
            correlations: Boolean(results.correlations),
            checks: results.checks.length + results.residuals.length > 0,
            chains: hasChains || results.waves.length > 0,
            maps: results.maps.length > 0,
            method: true
        };
        const found = await page.$$eval("main > section", all => all.map(s => s.id));
        assert.deepStrictEqual(found, Object.keys(expected).filter(id => expected[id]));
        const empty = await page.$$eval("main > section", all => all.filter(s => s.innerText.trim() === "").map(s => s.id));
        assert.deepStrictEqual(empty, []);
        const links = await page.$$eval("nav a", all => all.map(a => a.getAttribute("href")));
        for (const link of links) assert.ok(found.includes(link.slice(1)), link);
        assert.strictEqual(links.length, found.length - 1);
    });
    await test("verdict, findings and warnings are those of the results", async () => {
        assert.strictEqual(await page.$eval("#verdict", e => e.textContent), results.verdict);
        const texts = selector => page.$$eval(selector, all => all.map(e => e.textContent));
        assert.deepStrictEqual(await texts(".notices li"), results.warnings);
        assert.deepStrictEqual(
            await texts(".findings li"),
            results.findings.map(({label, text}) => label + text)
        );
        assert.ok(/\.$/.test(results.verdict) && !/NaN|undefined|null|\{\}/.test(await page.innerText("main")));
    });
}

async function checkNumbersOfEstimate(page) {
    await test("numbers are those of the results", async () => assert.deepStrictEqual(await wrongNumbers(page), []));
    await test("negative control: an altered number is found", async () => {
        const places = await page.$$eval("#parameter-table [data-path$='.map']", all => {
            const span = all.find(s => /[1-8]/.test(s.textContent));
            span.dataset.was = span.textContent;
            span.textContent = span.textContent.replace(/[1-8]/, d => Number(d) + 1);
            return span.dataset.path;
        });
        assert.deepStrictEqual((await wrongNumbers(page)).map(w => w.path), [places]);
        await page.$eval("[data-was]", span => (span.textContent = span.dataset.was));
    });
    await test("columns are what their heads say", async () => {
        const hasTruth = results.parameters.some(p => p.truth !== null);
        const columns = [
            ["most probable", "map"],
            hasTruth && ["true", "truth"],
            ...(results.map_only
                ? [["prior sd", "prior_sd"]]
                : [["mean", "mean"], ["sd", "sd"], ["5 %", "q5"], ["median", "q50"], ["95 %", "q95"], ["prior sd", "prior_sd"], [`the ${results.subject}`, "sd_ratio"]]),
            ...(hasChains ? [["R-hat", "rhat"], ["ESS", "ess_bulk"], ["ESS", "ess_tail"]] : [])
        ].filter(Boolean);
        const heads = await page.$$eval("#parameter-table thead th", all => all.map(th => th.firstChild.textContent));
        assert.deepStrictEqual(heads.slice(1), columns.map(([head]) => head));
        const rows = await page.$$eval("#parameter-table tbody tr", all =>
            all.map(row => [...row.querySelectorAll("td")].map(td => td.querySelector("[data-path]")?.dataset.path.split(".").pop()))
        );
        // A share that is not known has no number.
        for (const [i, row] of rows.entries())
            assert.deepStrictEqual(row, columns.map(([, key]) => (key === "sd_ratio" && results.parameters[i].told === null ? undefined : key)));
    });
    await test("the bars are as long as the share that the photograph tells", async () => {
        const rows = await page.$$eval("#parameter-table tbody tr", all =>
            all.map(row => {
                const width = selector => Number(row.querySelector(selector)?.getAttribute("width"));
                return {share: width(".told-bar") / width(".told-back"), text: row.querySelector(".told")?.textContent};
            })
        );
        assert.strictEqual(rows.length, results.parameters.length);
        let count = 0;
        rows.forEach(({share, text}, i) => {
            const {told, sd, prior_sd: prior} = results.parameters[i];
            if (told === null) return assert.strictEqual(text, undefined);
            ++count;
            assert.ok(Math.abs(share - Math.max(0, 1 - sd / prior)) < 1e-4, `${i}: ${share}`);
            assert.ok(told < 0.005 || text.startsWith(`${Math.round(100 * told)} %`), text);
        });
        assert.ok(results.map_only || count > 0);
    });
    await test("probabilities are said only of what has converged", async () => {
        const text = await page.innerText("#parameters");
        assert.strictEqual(text.includes("90 % probability"), results.converged);
    });
    await test("what has not converged is marked, and nothing else", async () => {
        const isLoud = ({rhat, ess_bulk: bulk, ess_tail: tail}) =>
            [rhat !== null && rhat > 1.05, bulk !== null && bulk < 100, tail !== null && tail < 100].filter(Boolean).length;
        const rows = await page.$$eval("#parameter-table tbody tr", all => all.map(row => row.querySelectorAll(".loud").length));
        assert.deepStrictEqual(rows, results.parameters.map(p => (hasChains ? isLoud(p) : 0)));
    });
}

async function checkPictures(page) {
    await test("every plot and picture has something on it", async () => {
        const flat = new Set(results.maps.filter(m => m.least === m.most && m.least !== undefined).map(m => m.file));
        for (const canvas of await page.$$("canvas")) {
            const share = await painted(canvas),
                name = (await canvas.getAttribute("data-file")) || (await canvas.getAttribute("aria-label"));
            if (flat.has(name)) assert.strictEqual(share, 0, name);
            else assert.ok(share > 0.004, `${name}: ${share}`);
        }
    });
    await test("there is a plot for all that has draws", async () => {
        const count = id => page.$$eval(`#${id} .plot canvas`, all => all.length);
        assert.strictEqual(await count("marginals"), results.parameters.filter(p => p.histogram && hasChains).length);
        assert.strictEqual(await count("chains"), results.parameters.filter(p => p.traces && !p.factors.length && hasChains).length);
        assert.strictEqual(await count("correlations"), results.pairs.length);
    });
    await test("the photograph has the bytes that it had", async () => {
        if (!results.photo) return;
        const mean = await page.$eval("canvas[data-file=photo]", c => {
            const data = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
            return data.reduce((sum, v, i) => (i % 4 < 3 ? sum + v : sum), 0) / (0.75 * data.length);
        });
        const own = await page.evaluate(async isLinear => {
            const image = await loadImage("photo");
            let sum = 0;
            for (const bits of image.halves) {
                const v = Math.min(1, Math.max(0, kHalfValues[bits]));
                sum += 255 * (isLinear ? (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055) : v);
            }
            return sum / image.halves.length;
        }, results.linear);
        assert.ok(Math.abs(mean - own) < 0.2, `${mean} for ${own}`);
        // Control: the other curve would be another picture.
        assert.ok(Math.abs(255 * (own / 255) ** (1 / 2.2) - mean) > 5);
    });
    await test("another picture beside the photograph, by mouse and by keyboard", async () => {
        const buttons = await page.$$(".thumbnails button");
        assert.strictEqual(buttons.length > 0, results.draws.length + Boolean(results.best) > 1);
        if (buttons.length === 0) return;
        const shown = async () => page.$eval("#chosen canvas", c => c.dataset.file);
        assert.strictEqual(await shown(), results.best);
        await buttons[2].click();
        assert.strictEqual(await shown(), results.draws[1]);
        await buttons[3].focus();
        await page.keyboard.press("Enter");
        assert.strictEqual(await shown(), results.draws[2]);
        assert.deepStrictEqual(
            await page.$$eval(".thumbnails [aria-pressed=true]", all => all.map(b => b.dataset.file)),
            [results.draws[2]]
        );
        await page.waitForTimeout(100);
        assert.ok((await painted(await page.$("#chosen canvas"))) > 0.5);
        await buttons[0].click();
    });
}

// Shapes as the plots draw them, from the results.
async function checkPlots(page) {
    const datasetsOf = (section, index) =>
        page.$$eval(
            `#${section} .plot canvas`,
            (all, i) => Chart.getChart(all[i]).data.datasets.map(d => ({label: d.label, data: d.data})),
            index
        );
    await test("distributions are the results', with the most probable and the true value in them", async () => {
        const shown = results.parameters.filter(p => p.histogram && hasChains);
        for (const [i, parameter] of shown.entries()) {
            const sets = Object.fromEntries((await datasetsOf("marginals", i)).map(d => [d.label, d.data]));
            const {from, step, densities} = parameter.histogram;
            assert.strictEqual(sets.posterior.length, 2 * densities.length + 2);
            densities.forEach((y, k) => {
                assert.strictEqual(sets.posterior[2 * k + 1].y, y);
                assert.ok(Math.abs(sets.posterior[2 * k + 1].x - (from + k * step)) < 1e-9 * Math.abs(from + k * step) + 1e-12);
            });
            assert.strictEqual(sets["most probable"]?.[0].x, parameter.map ?? undefined);
            assert.strictEqual(sets.true?.[0].x, parameter.truth ?? undefined);
            assert.strictEqual(sets.prior.length > 0, Boolean(parameter.prior_curve));
        }
    });
    await test("close up, the posterior fills its plot", async () => {
        if (!hasChains) return;
        const widths = () =>
            page.$$eval("#marginals canvas", all =>
                all.map(c => {
                    const {min, max} = Chart.getChart(c).scales.x;
                    return max - min;
                })
            );
        const before = await widths();
        await page.click("#marginals [data-value=posterior]");
        const after = await widths();
        results.parameters.filter(p => p.histogram).forEach(({histogram: {from, step, densities}, map, truth}, i) => {
            const xs = [from, from + step * densities.length, map, truth].filter(x => x !== null),
                expected = 1.08 * (Math.max(...xs) - Math.min(...xs));
            assert.ok(Math.abs(after[i] / expected - 1) < 1e-3, `${after[i]} for ${expected}`);
            assert.ok(after[i] <= before[i] * 1.0001);
        });
        await page.click("#marginals [data-value=prior]");
    });
    await test("the colours of the correlations are their signs and sizes", async () => {
        if (!results.correlations) return;
        const cells = await page.$$eval("#correlation-table tbody tr", all =>
            all.map(row => [...row.querySelectorAll("td")].map(td => getComputedStyle(td).backgroundColor))
        );
        const {values} = results.correlations;
        const alpha = color => Number((color.match(/rgba\(.*, ([\d.]+)\)/) || [, 1])[1]);
        values.forEach((row, a) =>
            row.forEach((r, b) => {
                if (a === b || r === null) return;
                assert.ok(Math.abs(alpha(cells[a][b]) - 0.9 * Math.abs(r)) < 0.01, cells[a][b]);
                const [red, , blue] = cells[a][b].match(/\d+/g).map(Number);
                assert.strictEqual(blue > red, r >= 0, `${r}: ${cells[a][b]}`);
            })
        );
    });
    await test("lobes are what was measured, beside what is predicted", async () => {
        const count = await page.$$eval("#lobes .plot canvas", all => all.length);
        assert.strictEqual(count, results.lobes.length);
        for (const [i, lobe] of results.lobes.entries()) {
            const sets = (await datasetsOf("lobes", i)).filter(d => d.label.endsWith("measured"));
            assert.ok(sets.length === 1 || sets.length === lobe.channels.length);
            sets.forEach((set, c) => assert.deepStrictEqual(set.data, lobe.places.map((x, k) => ({x, y: lobe.channels[c].measured[k]}))));
            for (const {low, median, high} of lobe.channels) median.forEach((y, k) => assert.ok(low[k] <= y && y <= high[k]));
        }
        const rows = await page.$$eval("#next-table tbody tr", all => all.length);
        assert.strictEqual(rows, results.next.length);
        results.next.forEach(({ratio}, i) => assert.ok(i === 0 || ratio <= results.next[i - 1].ratio));
        assert.ok(results.subject === "photograph" || !/photograph|picture/.test(await page.innerText("main")));
    });
    await test("the photograph's places among predictions", async () => {
        if (results.checks.length === 0) return;
        const rows = await page.$$eval("#check-table tbody tr", all =>
            all.map(row => ({
                dots: [...row.querySelectorAll(".dot")].map(d => Number(d.getAttribute("cx"))),
                outside: row.querySelectorAll(".dot.outside").length,
                text: row.querySelector("[data-outside]").textContent,
                isHeldOut: Boolean(row.querySelector(".badge"))
            }))
        );
        results.checks.forEach(({shares, held_out: isHeldOut}, i) => {
            const known = shares.filter(s => s !== null);
            assert.strictEqual(rows[i].dots.length, known.length);
            known.forEach((share, k) => assert.ok(Math.abs((rows[i].dots[k] - 6) / 228 - share) < 1e-6));
            const outside = known.filter(s => s <= 0 || s >= 1).length;
            assert.strictEqual(rows[i].outside, outside);
            assert.strictEqual(rows[i].text, String(outside));
            assert.strictEqual(rows[i].isHeldOut, isHeldOut);
        });
    });
}

// Texts are text, whatever they hold.
async function checkHostile(browser) {
    const text = "<img src=x onerror=\"window.hacked=1\">&amp;'\"</td>";
    const altered = structuredClone(results);
    for (const key of ["title", "model", "command", "verdict"]) altered[key] = text;
    altered.warnings = [text];
    altered.findings = [{label: text, text}];
    altered.settings = [{name: text, value: text}];
    for (const key of ["meaning", "unit"]) altered.parameters[0][key] = text;
    for (const check of altered.checks) [check.family, check.names] = [text, check.names.map(() => text)];
    for (const residual of altered.residuals) residual.text = text;
    for (const map of altered.maps) map.unit = text;
    const json = JSON.stringify(altered).replaceAll("<", "\\u003c");
    const folder = fs.mkdtempSync(path.join(os.tmpdir(), "lacquer-estimate-report-")),
        copy = path.join(folder, "report.html");
    fs.writeFileSync(copy, html.replace(/(id="results">).*?(<\/script>)/s, (_, open, close) => open + json + close));
    await test("no text becomes markup", async () => {
        const {context, page, complaints} = await openReport(browser, copy);
        assert.strictEqual(await page.evaluate(() => window.hacked), undefined);
        assert.strictEqual(await page.innerText("#head h1"), text);
        assert.strictEqual(await page.innerText("#verdict"), text);
        assert.ok((await page.$eval("#parameter-table tbody th", e => e.textContent)).startsWith(text));
        assert.strictEqual(await page.$$eval("main img", all => all.length), 0);
        assert.deepStrictEqual(complaints, []);
        await context.close();
    });
    fs.rmSync(folder, {recursive: true});
}

const browser = await launch();
const {context, page, complaints} = await openReport(browser, file);
await checkSections(page);
await checkPictures(page);
await checkPlots(page);
await checkNumbersOfEstimate(page);
await test("no error in the console, no error of a script, no request", () => assert.deepStrictEqual(complaints, []));
await context.close();
await checkHostile(browser);
await checkLayouts(browser, file, shots);
await browser.close();
finish();
