// Opens an HTML page from disk in headless Chromium and looks whether it is what a reader should see:
//
//   node check_page.mjs PAGE --charts N [--out FOLDER] [--within MILLISECONDS] [--largest BYTES] [--then SCRIPT]
//
//   - it opens within the time, is not larger, and asks for nothing beyond itself;
//   - nothing is said on the console: no error, no exception;
//   - it has N charts; each has as many traces as its data, and points in colour in every panel that has any;
//   - they are drawn when they come into sight, and all of them before printing; the PDF has their lines;
//   - nothing is wider than the page at 1400, 800 and 390 px.
//
// Screenshots and the PDF go to FOLDER: NAME-1400.png, NAME-800.png, NAME-390.png, NAME.pdf. SCRIPT is a file whose
// text is run in the page at the end; its value is a list of faults. Exit code: 0 no fault; 1 faults, which are
// printed; 2 wrong usage; 77 Chromium is not there.

import { mkdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { basename, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { parseArgs } from "node:util";
import { inflateSync } from "node:zlib";
import { Chromium, findChromium } from "./chromium.mjs";

const WIDTHS = [1400, 800, 390];
const PAPER = 680.4;       // A4 between margins of 15 mm [px]
const TALLEST = 4000;      // window for a screenshot [px]
const LEAST_COLOUR = 20;  // pixels of a panel with points: fewer than any line or handful of marks has

/** What a page says of itself while it is used. */
class Complaints {
  constructor(browser) {
    this.faults = [];
    browser.listen((method, params) => this.#hear(method, params));
  }

  #hear(method, params) {
    if (method === "Runtime.exceptionThrown") {
      const { exception, text } = params.exceptionDetails;
      this.faults.push(`exception: ${(exception?.description ?? text).split("\n").slice(0, 3).join(" ")}`);
    } else if (method === "Runtime.consoleAPICalled" && ["error", "assert", "warning"].includes(params.type)) {
      this.faults.push(`console: ${params.args.map((one) => one.value ?? one.description).join(" ")}`);
    } else if (method === "Log.entryAdded" && ["error", "warning"].includes(params.entry.level)) {
      this.faults.push(`log: ${params.entry.text} ${params.entry.url ?? ""}`);
    } else if (method === "Network.requestWillBeSent" && !/^(data|blob|about):/.test(params.request.url)) {
      if (params.type !== "Document" || !params.request.url.startsWith("file:"))
        this.faults.push(`asks for ${params.request.url}`);
    }
  }
}

function setWidth(browser, width, height = 900) {
  return browser.send("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: false });
}

/** Opens the page; milliseconds from the start until it is loaded and the charts in sight are drawn. */
async function open(browser, url) {
  const loaded = new Promise((done) => browser.listen((method) => method === "Page.loadEventFired" && done()));
  await browser.send("Page.navigate", { url });
  await loaded;
  return browser.evaluate(`new Promise((done) => {
    const look = () => {
      const missing = [...document.querySelectorAll("figure.chart .plot")].some((plot) => {
        const box = plot.getBoundingClientRect();
        return box.top < innerHeight && box.bottom > 0 && !plot.dataset.drawn;
      });
      if (missing && performance.now() < 20000) requestAnimationFrame(look);
      else requestAnimationFrame(() => setTimeout(() => done(performance.now())));
    };
    look();
  })`);
}

const COUNT_DRAWN = `document.querySelectorAll("figure.chart .plot[data-drawn]").length`;

/** Of each chart: its id, how many traces were drawn and were given. */
const DESCRIBE = `uiclink.charts.map(({ id, plot, spec }) => (
  { id, drawn: plot.querySelectorAll(".scatterlayer > .trace").length, given: spec.data.length }))`;

/** In the page: brings a chart into sight; its rectangle in the page, and, in that, those of its panels with how many
    traces with points each of them has. */
const SHOW = `(index) => {
  const { plot, spec } = uiclink.charts[index], full = plot._fullLayout;
  plot.scrollIntoView({ block: "start", behavior: "instant" });
  const box = plot.getBoundingClientRect();
  const shows = (trace) => trace.x.some((x, i) => Number.isFinite(x) && Number.isFinite(trace.y[i]));
  const panels = spec.grid.panels.map((panel) => {
    const x = full[panel.x], y = full[panel.y];
    return { traces: plot._fullData.filter((trace) => trace.xaxis === x._id && shows(trace)).length,
             x: x._offset, y: y._offset, width: x._length, height: y._length };
  });
  const clip = { x: box.left + scrollX, y: box.top + scrollY, width: box.width, height: box.height, scale: 1 };
  return { clip, panels };
}`;

/** In the page: pixels of a picture in each rectangle that are neither grey nor white, or that are black. */
const COUNT_COLOURS = `async (png, rectangles) => {
  const picture = await createImageBitmap(await (await fetch("data:image/png;base64," + png)).blob());
  const canvas = new OffscreenCanvas(picture.width, picture.height);
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(picture, 0, 0);
  return rectangles.map(({ x, y, width, height }) => {
    const { data } = context.getImageData(x + 2, y + 2, Math.max(width - 4, 1), Math.max(height - 4, 1));
    let count = 0;
    for (let i = 0; i < data.length; i += 4) {
      const most = Math.max(data[i], data[i + 1], data[i + 2]), least = Math.min(data[i], data[i + 1], data[i + 2]);
      if (most - least > 48 || most < 16) ++count;
    }
    return count;
  });
}`;

async function checkCharts(browser, expected, faults) {
  await setWidth(browser, WIDTHS[0], 2400);  // no chart is taller
  await browser.evaluate("uiclink.drawAll().then(() => 0)");
  const charts = await browser.evaluate(DESCRIBE);
  if (charts.length !== expected) faults.push(`${charts.length} charts, expected ${expected}`);
  for (const [index, { id, drawn, given }] of charts.entries()) {
    if (drawn !== given) faults.push(`chart ${id}: ${drawn} of ${given} traces are drawn`);
    const { clip, panels } = await browser.evaluate(`(${SHOW})(${index})`);
    const { data } = await browser.send("Page.captureScreenshot", { clip });
    const counts = await browser.evaluate(`(${COUNT_COLOURS})(${JSON.stringify(data)}, ${JSON.stringify(panels)})`);
    panels.forEach(({ traces }, p) => {
      if (traces > 0 && counts[p] < LEAST_COLOUR)
        faults.push(`chart ${id}, panel ${p + 1}: empty, ${counts[p]} pixels in colour`);
    });
  }
}

/** In the page: whether the charts in sight have been drawn for the width that it has. */
const IN_SIGHT = `[...(window.uiclink?.charts ?? [])].every((chart) => {
  const box = chart.plot.getBoundingClientRect(), seen = box.top < innerHeight && box.bottom > 0;
  return !seen || (chart.plot.dataset.drawn && chart.drawnWidth === chart.width());
})`;

async function checkWidth(browser, width, faults, file) {
  await browser.evaluate("scrollTo(0, 0)");
  await setWidth(browser, width, TALLEST);
  const drawn = await browser.evaluate(`new Promise((done) => {
    const begin = performance.now();
    const look = () => {
      const ready = performance.now() > begin + 200 && ${IN_SIGHT};
      if (ready || performance.now() > begin + 20000) done(ready);
      else setTimeout(look, 50);
    };
    look();
  })`);
  if (!drawn) faults.push(`at ${width} px not all charts in sight are drawn at that width`);
  const wide = await browser.evaluate("document.documentElement.scrollWidth");
  if (wide > width) faults.push(`at ${width} px the page is ${wide} px wide`);
  if (file === undefined) return;
  const height = Math.min(await browser.evaluate("document.documentElement.scrollHeight"), TALLEST);
  const { data } = await browser.send("Page.captureScreenshot", { clip: { x: 0, y: 0, width, height, scale: 1 } });
  writeFileSync(file, Buffer.from(data, "base64"));
}

/** How often the pages of a PDF set a colour, neither black, white nor grey, to draw a line or fill with. */
function countColours(pdf) {
  let count = 0;
  for (let at = pdf.indexOf("stream\n"); at >= 0; at = pdf.indexOf("stream\n", at + 7)) {
    const end = pdf.indexOf("endstream", at);
    let text;
    try {
      text = inflateSync(pdf.subarray(at + 7, end)).toString("latin1");
    } catch {
      continue;  // the "stream" of "endstream", or one that is not compressed
    }
    for (const [, red, green, blue] of text.matchAll(/([\d.]+) ([\d.]+) ([\d.]+) (?:RG|rg)\b/g)) {
      const levels = [red, green, blue].map(Number);
      if (Math.max(...levels) - Math.min(...levels) > 0.2) ++count;
    }
  }
  return count;
}

/** In the page: keeps how wide the drawing of each chart is on paper, 0 where there is none. The page's own listeners
    have been called before. */
const WATCH_PRINT = `addEventListener("beforeprint", () => {
  window.widthsOnPaper = uiclink.charts.map(
    ({ plot }) => plot.querySelector(".main-svg")?.getBoundingClientRect().width ?? 0);
})`;

/** Printed as it was opened: most charts have not been in sight. */
async function checkPrint(browser, expected, faults, file) {
  if (expected > 0) await browser.evaluate(WATCH_PRINT);
  const { data } = await browser.send("Page.printToPDF", { preferCSSPageSize: true, printBackground: false });
  const pdf = Buffer.from(data, "base64");
  if (file !== undefined) writeFileSync(file, pdf);
  if (expected === 0) return;
  const widths = await browser.evaluate("widthsOnPaper");
  widths.forEach((width, index) => {
    if (width < 0.6 * PAPER || width > PAPER) faults.push(`printing: chart ${index + 1} is ${width} px wide`);
  });
  const traces = await browser.evaluate("uiclink.charts.reduce((sum, chart) => sum + chart.spec.data.length, 0)");
  const colours = countColours(pdf);
  if (colours < traces) faults.push(`printing: colours are set ${colours} times in the PDF for ${traces} traces`);
}

async function look(browser, page, options, faults) {
  const named = (ending) => options.out && join(options.out, basename(page).replace(/\.html$/, "") + ending);
  await setWidth(browser, WIDTHS[0]);
  const opened = await open(browser, pathToFileURL(page).href);
  if (opened > options.within) faults.push(`opens in ${opened.toFixed(0)} ms, expected ${options.within}`);
  const early = await browser.evaluate(COUNT_DRAWN);
  const size = statSync(page).size;
  if (size > options.largest) faults.push(`${size} bytes, expected ${options.largest} at most`);
  console.log(`${basename(page)}: ${options.charts} charts, ${early} drawn when it opened ` +
              `in ${opened.toFixed(0)} ms, ${size} bytes`);
  await checkPrint(browser, options.charts, faults, named(".pdf"));
  if (options.charts > 0) await checkCharts(browser, options.charts, faults);
  for (const width of WIDTHS) await checkWidth(browser, width, faults, named(`-${width}.png`));
  if (options.then !== undefined) faults.push(...(await browser.evaluate(readFileSync(options.then, "utf8"))));
}

/** All faults of a page. Where a page is so broken that looking at it fails, its own complaints say why. */
async function check(browser, page, options) {
  const { faults } = new Complaints(browser);
  await look(browser, page, options, faults).catch((error) => faults.push(`the check ended early: ${error.message}`));
  return faults;
}

function readOptions() {
  const text = { type: "string" };
  const { values, positionals } = parseArgs({
    allowPositionals: true,
    options: { charts: text, out: text, within: text, largest: text, then: text },
  });
  const charts = Number(values.charts);
  if (positionals.length !== 1 || !Number.isInteger(charts)) throw new Error("expected: PAGE --charts N");
  return { page: resolve(positionals[0]), ...values, charts, within: Number(values.within ?? 10000),
           largest: Number(values.largest ?? Infinity) };
}

async function main() {
  const options = readOptions();
  const program = findChromium();
  if (program === undefined) {
    console.log("skipped: Chromium was not found (Debian package chromium)");
    return 77;
  }
  if (options.out !== undefined) mkdirSync(options.out, { recursive: true });
  const browser = new Chromium(program);
  try {
    await browser.start();
    const faults = await check(browser, options.page, options);
    for (const fault of new Set(faults)) console.log(`${basename(options.page)}: ${fault}`);
    return faults.length > 0 ? 1 : 0;
  } finally {
    await browser.close();
  }
}

main().then((code) => (process.exitCode = code), (error) => {
  console.error(String(error.stack ?? error));
  process.exitCode = 2;
});
