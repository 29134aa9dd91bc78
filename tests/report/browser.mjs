// What checks of pages share: Chromium, pages without a network, and the count of what passed.
import assert from "node:assert";
import path from "node:path";
import {execFileSync} from "node:child_process";
import {pathToFileURL} from "node:url";
import {chromium} from "playwright-core";

let passed = 0,
    failed = 0;
export async function test(name, body) {
    try {
        await body();
        ++passed;
        console.log(`ok    ${name}`);
    } catch (error) {
        ++failed;
        console.log(
            `FAIL  ${name}\n      ${String(error.message).split("\n").slice(0, 12).join("\n      ")}`
        );
    }
}

// Prints the last line; the exit status is 1 if any failed.
export function finish() {
    console.log(`${passed} passed, ${failed} failed`);
    process.exit(failed > 0 ? 1 : 0);
}

function findChromium() {
    for (const name of ["chromium", "chromium-browser", "google-chrome"])
        try {
            return execFileSync("which", [name]).toString().trim();
        } catch {
            /* the next */
        }
    throw new Error("no Chromium in PATH");
}

export const launch = () => chromium.launch({executablePath: findChromium(), args: ["--no-sandbox"]});

// A page without a network; what it complains of, and what it asks for, ends in `complaints`.
export async function openReport(browser, report, options) {
    const context = await browser.newContext({viewport: {width: 1200, height: 900}, ...options});
    await context.setOffline(true);
    const page = await context.newPage(),
        complaints = [],
        url = pathToFileURL(report).href;
    page.on("console", message => {
        // Chromium advises on reading canvases: these checks do that, not the page.
        if (["error", "warning"].includes(message.type()) && !message.text().includes("willReadFrequently"))
            complaints.push(message.text());
    });
    page.on("pageerror", error => complaints.push(String(error)));
    page.on("request", request => {
        if (request.url() !== url && !request.url().startsWith("blob:"))
            complaints.push(`asks for ${request.url()}`);
    });
    await page.goto(url, {timeout: 120000}); // the first page waits for the browser, on a busy machine for long
    await page.waitForFunction(() => document.documentElement.dataset.ready === "true", null, {
        timeout: 60000
    });
    return {context, page, complaints};
}

// Screenshots of the page in four looks, and as it prints, end in a folder.
export async function checkLayouts(browser, file, shots) {
    const looks = {
        "desktop-light": {},
        "desktop-dark": {colorScheme: "dark"},
        "phone-light": {
            viewport: {width: 390, height: 844},
            deviceScaleFactor: 2,
            isMobile: true,
            hasTouch: true
        },
        "phone-dark": {
            viewport: {width: 390, height: 844},
            deviceScaleFactor: 2,
            isMobile: true,
            hasTouch: true,
            colorScheme: "dark"
        }
    };
    for (const [name, options] of Object.entries(looks))
        await test(`${name}: no complaint, and nothing wider than the window`, async () => {
            const {context, page, complaints} = await openReport(browser, file, options);
            await page.waitForTimeout(300);
            await page.screenshot({path: path.join(shots, `${name}.png`), fullPage: true});
            assert.deepStrictEqual(complaints, []);
            const [content, window] = await page.evaluate(() => [
                document.documentElement.scrollWidth,
                document.documentElement.clientWidth
            ]);
            assert.ok(content <= window, `${content} of ${window} pixels`);
            await context.close();
        });
    await test("it prints", async () => {
        const {context, page} = await openReport(browser, file, {colorScheme: "dark"});
        await page.pdf({
            path: path.join(shots, "print.pdf"),
            format: "A4",
            margin: {top: "14mm", bottom: "14mm", left: "14mm", right: "14mm"}
        });
        await context.close();
    });
}
