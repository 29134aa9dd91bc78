// Opens a report of `lacquer compare` in headless Chromium and checks it:
//   node check_report.mjs DIR/report.html SCREENSHOTS
// Last line: "N passed, M failed". Exit status 1 if any failed.
import assert from "node:assert";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import {checkLayouts, finish, launch, openReport, test} from "./browser.mjs";
import {checkNumbers, wrongNumbers} from "./check_numbers.mjs";
import {checkCrops, checkErrorMaps, checkViewer} from "./check_pictures.mjs";
import {readReport} from "./report_data.mjs";

const [file, shots] = process.argv.slice(2).map(argument => path.resolve(argument));
fs.mkdirSync(shots, {recursive: true});

// The same page, in a folder of its own, with one number of its embedded results off by a thousandth.
function alteredReport(report, folder) {
    const altered = structuredClone(report.embedded),
        rmse = altered.variants[0].estimators[0].boxes[0].rmse;
    rmse.value *= 1.001;
    const text = JSON.stringify(altered)
        .replaceAll("<", "\\u003c")
        .replaceAll(">", "\\u003e")
        .replaceAll("&", "\\u0026");
    const html = report.html.replace(
        /(<script type="application\/json" id="results">).*?(<\/script>)/s,
        (_, open, close) => open + text + close
    );
    fs.writeFileSync(path.join(folder, "report.html"), html);
    return path.join(folder, "report.html");
}

async function checkControls(browser, report) {
    const folder = fs.mkdtempSync(path.join(os.tmpdir(), "lacquer-report-"));
    await test("negative control: an altered number in the page's data is found", async () => {
        const {context, page} = await openReport(browser, alteredReport(report, folder));
        const wrong = await wrongNumbers(page, report.results, 0);
        assert.ok(
            wrong.some(w => w.startsWith("variants.0.estimators.0.boxes.0.rmse.value")),
            wrong.join("; ")
        );
        await context.close();
    });
    await test("negative control: an altered number in the table's text is found", async () => {
        const {context, page} = await openReport(browser, file);
        await page.$eval("table [data-path$='rmse.value']", span => {
            span.textContent = span.textContent.replace(/[1-8]/, d => Number(d) + 1);
        });
        assert.strictEqual((await wrongNumbers(page, report.results, 0)).length, 1);
        await context.close();
    });
    fs.rmSync(folder, {recursive: true});
}

const report = readReport(file);
const browser = await launch();
const {context, page, complaints} = await openReport(browser, file);
const shot = async name => {
    await page.locator("#viewer").scrollIntoViewIfNeeded();
    await page.locator("#viewer").screenshot({path: path.join(shots, `${name}.png`)});
};
await test("every image of results.json is in the page", () => {
    const named = report.results.variants.flatMap(v => [
        v.reference.image,
        ...v.estimators.flatMap(e => Object.values(e.images))
    ]);
    // A report may say that it lacks one; then its tile says so too.
    const absent = named.filter(name => name && !report.pictures.has(name));
    if (absent.length > 0) console.log(`      absent: ${absent.join(", ")}`);
    assert.ok(absent.length < named.length / 4);
});
await checkNumbers(test, page, report);
await checkCrops(test, page, report, 0);
await checkErrorMaps(test, page, report);
await checkViewer(test, page, report, shot);
await test("no text became markup", async () =>
    assert.strictEqual(await page.evaluate(() => window.hacked), undefined));
await test("no error in the console, no error of a script, no request", () =>
    assert.deepStrictEqual(complaints, []));
await context.close();
await checkControls(browser, report);
await checkLayouts(browser, file, shots);
await browser.close();
finish();
