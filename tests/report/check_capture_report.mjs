// Opens a report of `lacquer capture` in headless Chromium and checks it:
//   node check_capture_report.mjs DIR/report.html SCREENSHOTS
// Last line: "N passed, M failed". Exit status 1 if any failed.
import assert from "node:assert";
import fs from "node:fs";
import path from "node:path";
import {checkLayouts, finish, launch, openReport, test} from "./browser.mjs";
import {numberOf, painted} from "./shown.mjs";

const [file, shots] = process.argv.slice(2).map(argument => path.resolve(argument));
fs.mkdirSync(shots, {recursive: true});
const html = fs.readFileSync(file, "utf8");
const results = JSON.parse(html.match(/<script type="application\/json" id="results">(.*?)<\/script>/s)[1]);
const valueAt = names => names.split(".").reduce((value, name) => value?.[name], results);

// Numbers of the page whose text is not what the results have at their place.
async function wrongNumbers(page) {
    const spans = await page.$$eval("[data-path]", all => all.map(s => ({path: s.dataset.path, text: s.textContent})));
    assert.ok(spans.length >= 5 * results.views.length, `only ${spans.length} numbers`);
    return spans.filter(({path: place, text}) => {
        const {value, half} = numberOf(text);
        return !(Math.abs(value - valueAt(place)) <= 1.001 * half);
    });
}

async function checkText(page) {
    await test("sections are there, have something in them, and links", async () => {
        const expected = ["head", "views", "maps", "relit", "cameras", "fit", "method"];
        const found = await page.$$eval("main > section", all => all.map(s => s.id));
        assert.deepStrictEqual(found, expected);
        const empty = await page.$$eval("main > section", all => all.filter(s => s.innerText.trim() === "").map(s => s.id));
        assert.deepStrictEqual(empty, []);
        const links = await page.$$eval("nav a", all => all.map(a => a.getAttribute("href").slice(1)));
        assert.deepStrictEqual(links, expected.slice(1));
    });
    await test("verdict, findings and warnings are those of the results", async () => {
        assert.strictEqual(await page.$eval("#verdict", e => e.textContent), results.verdict);
        const texts = selector => page.$$eval(selector, all => all.map(e => e.textContent));
        assert.deepStrictEqual(await texts(".notices li"), results.warnings);
        assert.deepStrictEqual(await texts(".findings li"), results.findings.map(({label, text}) => label + text));
        assert.ok(/\.$/.test(results.verdict) && !/NaN|undefined|null|\{\}/.test(await page.innerText("main")));
        const hasTests = results.views.some(view => view.use === "test");
        assert.strictEqual(/held out, so nothing tells/.test(results.verdict), !hasTests);
    });
    await test("numbers are those of the results", async () => assert.deepStrictEqual(await wrongNumbers(page), []));
    await test("negative control: an altered number is found", async () => {
        const place = await page.$eval("#camera-table [data-path$='camera.2']", span => {
            span.dataset.was = span.textContent;
            span.textContent = span.textContent.replace(/[1-8]/, d => Number(d) + 1);
            return span.dataset.path;
        });
        assert.deepStrictEqual((await wrongNumbers(page)).map(w => w.path), [place]);
        await page.$eval("[data-was]", span => (span.textContent = span.dataset.was));
    });
}

async function checkPictures(page) {
    await test("every picture has something on it, and its pixels", async () => {
        const files = await page.$$eval("canvas[data-file]", all => all.map(c => c.dataset.file));
        assert.strictEqual(files.length, 3 * results.views.length + results.maps.length + 1);
        for (const name of files) assert.ok(await page.evaluate(async f => (await loadImage(f)) !== null, name), name);
        for (const canvas of await page.$$("#views canvas[data-file^=photo], #views canvas[data-file^=model], #relit canvas"))
            assert.ok((await painted(canvas)) > 0.05, await canvas.getAttribute("data-file"));
    });
    await test("a photograph and its model differ by what the difference shows", async () => {
        const worst = await page.evaluate(async views => {
            let worst = 0;
            for (const view of views) {
                const [photo, model, difference] = await Promise.all([view.photo, view.model, view.difference].map(loadImage));
                const plane = photo.width * photo.height;
                for (let i = 0; i < plane; ++i) {
                    let largest = 0;
                    for (let c = 0; c < 3; ++c)
                        largest = Math.max(largest, Math.abs(kHalfValues[photo.halves[c * plane + i]] - kHalfValues[model.halves[c * plane + i]]));
                    worst = Math.max(worst, Math.abs(largest - kHalfValues[difference.halves[i]]));
                }
            }
            return worst;
        }, results.views);
        assert.ok(worst < 2e-3, `${worst}`); // pages keep 11 bits
    });
    await test("the light turns by the slider", async () => {
        const shown = () => page.$eval("#relit canvas", c => c.dataset.file);
        assert.strictEqual(await shown(), results.relit.frames[0].file);
        await page.focus("#relit-frame");
        await page.keyboard.press("ArrowRight");
        assert.strictEqual(await shown(), results.relit.frames[1].file);
    });
    await test("cameras stand in the plan where the results have them", async () => {
        const marks = await page.$$eval(".plan .camera", all => all.map(c => [Number(c.getAttribute("cx")), Number(c.getAttribute("cy"))]));
        assert.strictEqual(marks.length, results.views.length);
        const scale = results.views.map((view, i) => [marks[i][0] - 230, 230 - marks[i][1], view.camera]).find(([, , c]) => Math.abs(c[0]) > 1);
        if (!scale) return;
        const factor = scale[0] / scale[2][0];
        results.views.forEach(({camera}, i) => {
            assert.ok(Math.abs(marks[i][0] - 230 - factor * camera[0]) < 0.5 && Math.abs(230 - marks[i][1] - factor * camera[1]) < 0.5, `${i}`);
        });
    });
}

const browser = await launch();
const {context, page, complaints} = await openReport(browser, file);
await checkText(page);
await checkPictures(page);
await test("the page complains of nothing and asks for nothing", () => assert.deepStrictEqual(complaints, []));
await context.close();
await checkLayouts(browser, file, shots);
await browser.close();
finish();
