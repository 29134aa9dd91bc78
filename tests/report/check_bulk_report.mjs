// Opens a report of `lacquer bulk` in headless Chromium and checks it:
//   node check_bulk_report.mjs DIR/report.html SCREENSHOTS
// Last line: "N passed, M failed". Exit status 1 if any failed.
import assert from "node:assert";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import {checkLayouts, finish, launch, openReport, test} from "./browser.mjs";
import {painted} from "./shown.mjs";

const [file, shots] = process.argv.slice(2).map(argument => path.resolve(argument));
fs.mkdirSync(shots, {recursive: true});
const html = fs.readFileSync(file, "utf8");
const results = JSON.parse(html.match(/<script type="application\/json" id="results">(.*?)<\/script>/s)[1]);
const isOriented = Boolean(results.oriented);
const hasClusters = results.realisations !== undefined;

// A number as a reader sees it, and half of its last digit: "1.2·10⁻⁵", "−3", "4.0 %".
function numberOf(text) {
    const [, mantissa, power] = text.replaceAll("−", "-").match(/^(-?[\d.]+)(?:·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?/) || [, "NaN"];
    const exponent = [...(power || "⁰")].map(c => (c === "⁻" ? "-" : "⁰¹²³⁴⁵⁶⁷⁸⁹".indexOf(c))).join("");
    const unit = 10 ** Number(exponent) * (text.includes("%") ? 0.01 : 1),
        digits = (mantissa.split(".")[1] || "").length;
    return {value: Number(mantissa) * unit, half: 0.5 * 10 ** -digits * unit};
}

const valueAt = names => names.split(".").reduce((value, name) => value?.[name], results);

// Numbers of the page whose text is not what the results have at their place.
async function wrongNumbers(page) {
    const spans = await page.$$eval("[data-path]", all => all.map(s => ({path: s.dataset.path, text: s.textContent})));
    assert.ok(spans.length > 5 * results.wavelengths.length, `only ${spans.length} numbers`);
    return spans.filter(({path: place, text}) => {
        const expected = valueAt(place),
            {value, half} = numberOf(text);
        return !(Math.abs(value - expected) <= 1.001 * half) && text !== "–";
    });
}

async function checkSections(page) {
    await test("sections are there where there is something for them, and only then", async () => {
        const expected = {
            head: true,
            looks: results.thumbnails.length > 0 || Boolean(results.cluster),
            scattering: true,
            incidences: isOriented,
            spectra: results.wavelengths.length > 1,
            convergence: hasClusters && results.wavelengths[0].history.length > 1 && results.wavelengths.some(w => w.c_ext_error > 0),
            structure: Boolean(results.pairs),
            sizes: results.sizes.length > 0,
            numbers: true,
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
}

async function checkNumbersOfBulk(page) {
    await test("numbers are those of the results", async () => assert.deepStrictEqual(await wrongNumbers(page), []));
    await test("negative control: an altered number is found", async () => {
        await page.$eval("#table [data-path$='sigma_s']", span => {
            span.textContent = span.textContent.replace(/[1-8]/, d => Number(d) + 1);
        });
        assert.strictEqual((await wrongNumbers(page)).length, 1);
    });
}

async function checkPlots(page) {
    await test("every canvas has something on it", async () => {
        const canvases = await page.$$("canvas");
        assert.ok(canvases.length >= 1);
        for (const canvas of canvases) {
            const share = await painted(canvas),
                name = await canvas.getAttribute("aria-label");
            assert.ok(share > 0.005, `${name}: ${share}`);
        }
    });
    await test("the cluster has all its spheres' colours and turns", async () => {
        const canvas = await page.$("canvas.cluster");
        if (!results.cluster) return assert.strictEqual(canvas, null);
        await canvas.scrollIntoViewIfNeeded();
        const before = await canvas.evaluate(c => c.toDataURL()),
            box = await canvas.boundingBox();
        await page.mouse.move(box.x + 60, box.y + 60);
        await page.mouse.down();
        await page.mouse.move(box.x + 140, box.y + 90, {steps: 3});
        await page.mouse.up();
        const after = await canvas.evaluate(c => c.toDataURL());
        if (results.cluster.spheres.length > 1) assert.notStrictEqual(before, after);
        assert.ok((await painted(canvas)) > 0.02);
    });
    await test("renders are as bright as the page's pixels", async () => {
        for (const canvas of await page.$$("canvas.render")) {
            const mean = await canvas.evaluate(c => {
                const data = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
                return data.reduce((sum, v, i) => (i % 4 < 3 ? sum + v : sum), 0) / (0.75 * data.length);
            });
            assert.ok(mean > 15 && mean < 250, String(mean));
        }
    });
}

// Points of the polar curve, worked out from the results: the radius over that of the outer circle.
async function checkPolar(page) {
    await test("the polar plot is log10 of p at each angle", async () => {
        const w = Number(await page.$eval("#wavelength", s => s.value)),
            {phase, independent} = results.wavelengths[w],
            all = [...phase, ...independent.phase].filter(p => p > 0);
        const high = Math.ceil(Math.log10(Math.max(...all)) + 1e-9),
            low = Math.min(high - 2, Math.max(high - 6, Math.floor(Math.log10(Math.min(...all)))));
        const path = await page.$eval("#polar-curve", p => p.getAttribute("d")),
            points = path.slice(1, -1).split("L").map(point => point.split(",").map(Number));
        const outer = await page.$$eval(".polar circle.grid", all => Math.max(...all.map(c => Number(c.getAttribute("r")))));
        assert.strictEqual(points.length, 2 * phase.length);
        for (let i = 0; i < phase.length; i += 9) {
            const expected = Math.max(0, (Math.log10(phase[i]) - low) / (high - low)) * outer,
                [x, y] = points[i];
            assert.ok(Math.abs(Math.hypot(x, y) - expected) < 0.02, `${i}: ${Math.hypot(x, y)} for ${expected}`);
            if (expected > 1)
                assert.ok(Math.abs((Math.atan2(-y, x) * 180) / Math.PI - results.angles[i]) < 0.7, `${i}`);
        }
    });
    await test("another wavelength has other curves", async () => {
        const before = await page.$eval("#polar-curve", p => p.getAttribute("d"));
        if (results.wavelengths.length === 1) return;
        await page.selectOption("#wavelength", "0");
        assert.notStrictEqual(await page.$eval("#polar-curve", p => p.getAttribute("d")), before);
        assert.ok((await page.innerText("#scattering h2")).includes(`${results.wavelengths[0].wavelength} nm`));
        assert.deepStrictEqual(await wrongNumbers(page), []);
    });
    await test("angles on a logarithmic axis", async () => {
        await page.click("#scattering .segments [data-value=log]");
        assert.ok((await painted(await page.$("#scattering canvas"))) > 0.005);
    });
}

// Names are text, whatever they hold.
async function checkHostile(browser) {
    const name = "<img src=x onerror=\"window.hacked=1\">&amp;'\"</td>";
    const altered = structuredClone(results);
    altered.title = altered.summary = altered.verdict = altered.command = altered.input = altered.species[0].name = name;
    altered.warnings = [name];
    const text = JSON.stringify(altered).replaceAll("<", "\\u003c");
    const folder = fs.mkdtempSync(path.join(os.tmpdir(), "lacquer-bulk-report-")),
        copy = path.join(folder, "report.html");
    fs.writeFileSync(copy, html.replace(/(id="results">).*?(<\/script>)/s, (_, open, close) => open + text + close));
    await test("no text becomes markup", async () => {
        const {context, page, complaints} = await openReport(browser, copy);
        assert.strictEqual(await page.evaluate(() => window.hacked), undefined);
        assert.strictEqual(await page.innerText("#species tbody th"), name);
        assert.strictEqual(await page.innerText("#head h1"), name);
        assert.deepStrictEqual(complaints, []);
        await context.close();
    });
    fs.rmSync(folder, {recursive: true});
}

// Slices in the plane of the axis (up) and of the light: each point's direction and radius, from the results.
async function checkSlices(page) {
    await test("slices are log10 of p about the axis, with the light's arrow", async () => {
        const w = Number(await page.$eval("#wavelength", s => s.value)),
            {slices, independent} = results.wavelengths[w],
            all = [...slices.flatMap(s => s.p), ...independent.phase].filter(p => p > 0);
        const high = Math.ceil(Math.log10(Math.max(...all)) + 1e-9),
            low = Math.min(high - 2, Math.max(high - 6, Math.floor(Math.log10(Math.min(...all)))));
        const outer = await page.$$eval(".polar circle.grid", all => Math.max(...all.map(c => Number(c.getAttribute("r")))));
        assert.ok(slices.length >= 2 && slices[0].incidence === 0 && slices.at(-1).incidence === 90);
        for (const [index, slice] of slices.entries()) {
            const path = await page.$eval(`#slice-${index}`, p => p.getAttribute("d")),
                points = path.slice(1, -1).split("L").map(point => point.split(",").map(Number));
            assert.strictEqual(points.length, slice.p.length);
            points.forEach(([x, y], i) => {
                const expected = Math.max(0, (Math.log10(slice.p[i]) - low) / (high - low)) * outer,
                    degrees = ((Math.atan2(x, -y) * 180) / Math.PI + 360) % 360;
                assert.ok(Math.abs(Math.hypot(x, y) - expected) < 0.02, `${index} ${i}: ${x} ${y} for ${expected}`);
                if (expected > 5) assert.ok(Math.abs(((degrees - slice.angles[i] + 540) % 360) - 180) < 0.3, `${index} ${i}: ${degrees}`);
            });
            // Most of the light of such small clusters goes on as it came.
            const forward = slice.p[slice.angles.indexOf(slice.incidence)];
            assert.ok(forward > 0.3 * Math.max(...slice.p), `${index}: ${forward}`);
        }
        assert.strictEqual((await page.$$(".polar .arrow")).length, slices.length);
    });
    await test("another wavelength has other slices and other curves over the incidence", async () => {
        const before = await page.$eval("#slice-0", p => p.getAttribute("d"));
        await page.selectOption("#wavelength", "0");
        assert.notStrictEqual(await page.$eval("#slice-0", p => p.getAttribute("d")), before);
        for (const id of ["scattering", "incidences"])
            assert.ok((await page.innerText(`#${id} h2`)).includes(`${results.wavelengths[0].wavelength} nm`));
        assert.deepStrictEqual(await wrongNumbers(page), []);
    });
    await test("plots over the incidence have their bands", async () => {
        const drawn = await page.$$eval("#incidences canvas", all => all.map(c => Chart.getChart(c).data.datasets.map(d => d.data)));
        assert.strictEqual(drawn.length, 3);
        ["sigma_t", "albedo", "g"].forEach((key, i) => {
            const [, low, high, mean] = drawn[i];
            results.wavelengths[0].incidences.forEach((entry, k) => {
                assert.deepStrictEqual([mean[k].x, mean[k].y], [entry.angle, entry[key]]);
                assert.ok(Math.abs((high[k].y - low[k].y) / (4 * entry[`${key}_error`]) - 1) < 1e-6, `${key} ${k}`);
            });
        });
    });
}

const browser = await launch();
const {context, page, complaints} = await openReport(browser, file);
await checkSections(page);
await checkPlots(page);
await (isOriented ? checkSlices : checkPolar)(page);
await checkNumbersOfBulk(page);
await test("no error in the console, no error of a script, no request", () => assert.deepStrictEqual(complaints, []));
await context.close();
await checkHostile(browser);
await checkLayouts(browser, file, shots);
await browser.close();
finish();
