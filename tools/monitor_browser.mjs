// Tests of the live page in Chromium; tools/monitor_browser starts it.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";

const [chromiumPath, programPath, modules, option, ...rest] = process.argv.slice(2);
const { chromium } = createRequire(resolve(modules, "node_modules") + "/")("playwright-core");
const program = resolve(programPath);
const LIMIT_MS = 120_000;
const children = new Set();
// Nothing that was started here goes on, however this ends.
process.on("exit", () => children.forEach((child) => child.kill("SIGKILL")));
for (const signal of ["SIGINT", "SIGTERM", "SIGHUP"]) process.on(signal, () => process.exit(1));

/** A program that serves a page: its address, and how it ends. */
async function served(args) {
  const folder = mkdtempSync(join(tmpdir(), "nereus-browser-"));
  const child = spawn(program, args, { cwd: folder });
  children.add(child);
  child.on("close", () => children.delete(child));
  let [stderr, out] = ["", ""];
  child.stdout.on("data", (bytes) => { out += bytes; });
  const ended = new Promise((done) => child.on("close", done));
  const address = await new Promise((found, failed) => {
    child.stderr.on("data", (bytes) => {
      stderr += bytes;
      const match = /monitor: (http:\S+)/.exec(stderr);
      if (match) found(match[1]);
    });
    child.on("close", () => failed(new Error(`no page: ${stderr}`)));
  });
  return {
    address, folder, child,
    async end() {
      child.kill("SIGINT");
      assert.equal(await ended, 0, stderr);
      return out;
    },
    clean: () => rmSync(folder, { recursive: true, force: true }),
  };
}

const scenario = (name) => resolve("configs", `${name}.toml`);

/** Few facets, and no plan of the fast echo: what makes a sea quick to begin in any build. */
const SMALL_SEA = ["--set", "scene.patch_size_m=[32,32]", "--set", "fidelity.echo=reference", "--set", 'sink=[{kind="null"}]'];
/** A run of a scenario; machines that are too slow for it stretch time rather than end. */
const run = (name, ...more) => served(["run", scenario(name), "--monitor", "127.0.0.1:0", "--monitor-control", "--json",
  "--set", 'stream.policy="slip"', ...more]);

async function opened(browser, address, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, acceptDownloads: true, ...options });
  const page = await context.newPage();
  page.faults = [];
  page.on("pageerror", (error) => page.faults.push(String(error)));
  page.on("console", (message) => { if (message.type() === "error") page.faults.push(message.text()); });
  page.on("request", (request) => {
    if (new URL(request.url()).host !== new URL(address).host && !request.url().startsWith("blob:")) page.faults.push(`asks ${request.url()}`);
  });
  page.setDefaultTimeout(LIMIT_MS);
  await page.goto(address);
  return page;
}

const value = (page, expression) => page.evaluate(`(() => { const { model, peak, truthAt, strongest, places } = window.nereus; return ${expression}; })()`);

/** Waits until an expression of the model is true; asked from here, since the page's policy forbids to evaluate text. */
async function until(page, expression) {
  const begun = Date.now();
  while (!await value(page, `(() => { try { return Boolean(${expression}); } catch { return false; } })()`)) {
    assert.ok(Date.now() - begun < LIMIT_MS, `not within a minute: ${expression}`);
    await page.waitForTimeout(50);
  }
}

/** Share of a canvas that is not its most frequent colour. */
const drawn = (page, id) => page.evaluate((name) => {
  const canvas = document.getElementById(name);
  const pixels = new Uint32Array(canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.buffer);
  const counts = new Map();
  for (const pixel of pixels) counts.set(pixel, (counts.get(pixel) ?? 0) + 1);
  return 1 - Math.max(...counts.values()) / pixels.length;
}, id);

const tests = {
  /** The page of the running quickstart shows pulses, and they move. */
  async smoke(browser) {
    const shown = await run("quickstart", "--duration-s", "60", ...SMALL_SEA);
    const page = await opened(browser, shown.address);
    await until(page, "model.lines.length > 3 && model.history.length > 3 && model.status.released > 0");
    const first = await value(page, "[model.now.pulse, model.lines.length]");
    await until(page, `model.now.pulse > ${first[0]} && model.lines.at(-1).pulse > ${first[0]}`);
    await page.waitForFunction(() => document.getElementById("fact-pulse").textContent !== "–");
    assert.equal(await page.textContent("#state"), "live");
    for (const [canvas, least] of [["c-waterfall", 0.2], ["c-line", 0.02], ["c-plan", 0.02], ["c-errors", 0.01]]) {
      assert.ok(await drawn(page, canvas) > least, `${canvas} is empty`);
    }
    assert.equal(await value(page, "model.about.channels.length"), 4);
    assert.deepEqual(page.faults, []);
    await shown.end();
    await page.waitForFunction(() => document.getElementById("state").textContent === "run has ended");
    shown.clean();
  },

  /** A strong target's peak lies at its true delay to a cell, and the marker beside it. */
  async peak(browser) {
    const shown = await run("quickstart", "--duration-s", "60", ...SMALL_SEA, "--set", "target.1.rcs_m2=1e7");
    const page = await opened(browser, shown.address);
    await until(page, "model.lines.length > 3 && model.delays.length > 3");
    // Of the pulses of lines and of delays, two that are next to one another in time.
    const [off, step, apart] = await value(page, `(() => {
      const mast = model.about.targets.findIndex((target) => target.name === "mast");
      let best = null;
      for (const line of model.lines) for (const one of model.delays) {
        const apart = Math.abs(line.timeS - one.timeS);
        if (!best || apart < best[2]) best = [peak(line).delayUs - one.delays_s[mast] * 1e6, model.columnS * 1e6, apart];
      }
      return best;
    })()`);
    assert.ok(apart < 0.1, `lines and delays are ${apart} s apart`);
    // A column, and what an aircraft of 60 m/s moves meanwhile: 0.4 ns in a millisecond at most.
    assert.ok(Math.abs(off) <= step + apart * 0.4, `${off} us beside the true delay, columns of ${step} us`);
    await shown.end();
    shown.clean();
  },

  /** A step that is injected by the form appears in the plot of errors, in the log and in the recording. */
  async change(browser) {
    const shown = await run("errors", "--duration-s", "300", "--out", "run.plain", "--set", "platform.1.errors={}",
      "--set", "platform.1.turbulence.level=\"light\"");
    const page = await opened(browser, shown.address);
    await until(page, "model.status.released > 20");
    await page.selectOption("#i-platform", "aircraft");
    await page.selectOption("#i-axis", "position.north");
    await page.fill("#i-value", "-4");
    assert.equal(await page.textContent("#i-line"), "step position.north -4 m on aircraft");
    await page.click("#i-send");
    await page.waitForFunction(() => document.getElementById("answer").textContent.startsWith("Taken"));
    const pulse = await value(page, "model.changes.length ? model.changes[0].pulse : null")
      ?? (await until(page, "model.changes.length === 1"), await value(page, "model.changes[0].pulse"));
    await until(page, `model.history.at(-1)[0] > ${pulse + 30}`);
    const wrong = await value(page, `model.history.filter((row) => Math.abs(row[2 + 16 + 7] - (row[0] >= ${pulse} ? -4 : 0)) > 1e-3).length`);
    assert.equal(wrong, 0, "the step is not where the log has it");
    await page.waitForFunction(() => document.getElementById("misreports").textContent.includes("too far south"));
    const banner = await page.textContent("#misreports");
    assert.ok(banner.includes("aircraft misreports its position: 4.00 m too far south") && banner.includes(pulse.toLocaleString("en-US")), banner);
    assert.ok((await page.textContent("#log tbody")).includes("step position.north -4 m"));
    await page.fill("#i-value", "1e300");
    await page.click("#i-send");
    await page.waitForFunction(() => document.getElementById("answer").textContent.startsWith("Refused"));
    // Pictures and tables by a click: each on a page of its own, since Chromium takes ten downloads from one and no more.
    const saved = async (on, panel, place) => {
      const [file] = await Promise.all([on.waitForEvent("download"), on.click(`.save[data-panel=${panel}] button:${place}`)]);
      return readFileSync(await file.path());
    };
    const tables = await opened(browser, shown.address);
    await until(tables, "model.history.length > 3 && model.lines.length > 3 && model.status && model.changes.length > 0");
    for (const panel of ["health", "ranges", "plan", "control", "doppler", "errors"]) {
      const bytes = await saved(page, panel, "first-child");
      assert.ok(bytes.subarray(1, 4).toString() === "PNG" && bytes.length > 2000, `${panel}: ${bytes.length} bytes`);
      const text = (await saved(tables, panel, "last-child")).toString();
      if (panel === "control") assert.ok(/^pulse,.*\n\d+,\d+,aircraft,step position.north -4 m,control\n$/.test(text), text);
      else if (panel !== "doppler") assert.ok(text.split("\n").length > 2, `${panel}: ${text}`);
    }
    await tables.close();
    const report = JSON.parse((await shown.end()).trim().split("\n").at(-1));
    assert.equal(report.changes[0].pulse, pulse);
    const row = JSON.parse(readFileSync(join(shown.folder, "run.plain/truth/changes.jsonl"), "utf8").split("\n")[0]);
    assert.deepEqual([row.pulse, row.text, row.source], [pulse, "step position.north -4 m", "control"]);
    assert.deepEqual(page.faults, []);
    shown.clean();
  },

  /** By keyboard alone, in the dark, on a narrow screen, and with the display held. */
  async keys(browser) {
    const shown = await run("errors", "--duration-s", "300", "--set", 'sink=[{kind="null"}]');
    const page = await opened(browser, shown.address, { colorScheme: "dark" });
    await until(page, "model.lines.length > 3");
    assert.equal(await page.getAttribute("html", "data-theme"), "dark");
    await page.keyboard.press("t");
    assert.equal(await page.getAttribute("html", "data-theme"), "light");
    await page.keyboard.press("c");
    assert.equal(await value(page, "model.channel"), 1);
    await until(page, "model.lines.length > 0 && model.lines.at(-1).levels.length > 0");
    await page.keyboard.press("3");
    assert.equal(await page.evaluate(() => document.activeElement.id), "p-plan");
    await page.keyboard.press("f");
    assert.equal(await page.isVisible("#p-health"), false);
    await page.keyboard.press("Escape");
    assert.equal(await page.isVisible("#p-health"), true);
    await page.keyboard.press("p");
    const held = await value(page, "model.status.released");
    await page.waitForTimeout(1500);
    assert.equal(await value(page, "model.status.released"), held);
    await page.keyboard.press("p");
    await until(page, `model.status.released > ${held}`);
    await page.keyboard.press("?");
    assert.equal(await page.isVisible("#keys"), true);
    await page.keyboard.press("Escape");
    // Nothing without a name, and nothing cut off on a narrow screen.
    const nameless = await page.evaluate(() => [...document.querySelectorAll("button, select, input, canvas")]
      .filter((one) => !(one.textContent.trim() || one.getAttribute("aria-label") || one.closest("label") || one.title)).map((one) => one.outerHTML));
    assert.deepEqual(nameless, []);
    // A laptop and a wall: nothing of the health panel cut off, no bar of two lines, all of the page in view.
    for (const [width, height] of [[1280, 800], [1440, 900], [1600, 1000], [1920, 1080], [2560, 1440]]) {
      await page.setViewportSize({ width, height });
      await page.waitForTimeout(300);
      const cut = await page.evaluate(() => {
        document.getElementById("t-released").textContent = "1,234,567";
        const wide = [...document.querySelectorAll(".tile b, .tile span, .bar select, .bar input[type=number], h2")]
          .filter((one) => one.scrollWidth > one.clientWidth + 1).map((one) => one.id || one.textContent);
        const high = [...document.querySelectorAll(".bar")].filter((one) => one.clientHeight > 1.5 * one.querySelector("h2").clientHeight + 20).map((one) => one.textContent);
        return [...wide, ...high, ...(document.documentElement.scrollHeight > window.innerHeight + 1 ? ["the page is higher than the screen"] : [])];
      });
      assert.deepEqual(cut, [], `${width} x ${height}`);
    }
    await page.setViewportSize({ width: 600, height: 900 });
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth + 1), "wider than the screen");
    assert.deepEqual(page.faults, []);
    await shown.end();
    shown.clean();
  },

  /** A range-Doppler map comes, and the target's circle lies on its peak. */
  async doppler(browser) {
    const shown = await run("errors", "--duration-s", "300", "--set", 'sink=[{kind="null"}]', "--set", "target.0.rcs_m2=1e5",
      "--set", 'platform.1.turbulence.level="light"', "--set", "transmitter.0.clock={offset_s=0}", "--set", "receiver.0.clock={offset_s=0}");
    const page = await opened(browser, shown.address);
    await until(page, "model.map !== null && model.delays.length > 3");
    const [offUs, offHz, binHz, columnUs] = await value(page, `(() => {
      const { map } = model;
      let best = 0;
      map.levels.forEach((level, place) => { if (level > map.levels[best]) best = place; });
      const [row, column] = [Math.floor(best / map.columns), best % map.columns];
      const [now] = truthAt(map.timeS - 0.5 * (map.rows - 1) / map.spanHz);
      const fold = (hz) => hz - map.spanHz * Math.round(hz / map.spanHz);
      return [(map.startS + (column + 0.5) * map.columnS - now.delayS) * 1e6,
        fold((row / map.rows - 0.5) * map.spanHz - now.dopplerHz), map.spanHz / map.rows, map.columnS * 1e6];
    })()`);
    assert.ok(Math.abs(offUs) < 2 * columnUs, `${offUs} us beside the target`);
    assert.ok(Math.abs(offHz) < 3 * binHz, `${offHz} Hz beside the target, rows of ${binHz} Hz`);
    await shown.end();
    shown.clean();
  },

  /** The panel of a scanning antenna: its strongest cell is the boat, which has its name there; without a scan there is none. */
  async ppi(browser) {
    const shown = await run("station", "--duration-s", "120", "--set", 'sink=[{kind="null"}]', "--set", "target.1.rcs_m2=1e4");
    const page = await opened(browser, shown.address);
    await until(page, "strongest() && strongest().dbw > -80");
    const [best, boat] = await value(page, `[strongest(), places().find((mark) => mark.name === "boat")]`);
    assert.ok(Math.abs(best.rangeM - boat.rangeM) < 12 + 20, `${best.rangeM} m, the boat at ${boat.rangeM} m`);
    assert.ok(Math.abs(best.bearingDeg - boat.bearingDeg) < 0.7, `${best.bearingDeg} degrees, the boat at ${boat.bearingDeg}`);
    assert.equal(await value(page, "places().length"), 4);
    assert.ok(await drawn(page, "c-ppi") > 0.2, "c-ppi is empty");
    await page.keyboard.press("h");
    assert.equal(await page.inputValue("#ppi-up"), "head");
    await page.keyboard.press("7");
    assert.equal(await page.evaluate(() => document.activeElement.id), "p-ppi");
    const [file] = await Promise.all([page.waitForEvent("download"), page.click(".save[data-panel=ppi] button:last-child")]);
    assert.ok(readFileSync(await file.path()).toString().startsWith("azimuth_deg,heading_deg,pulse"));
    for (const [width, height] of [[1280, 800], [1440, 900], [1920, 1080], [600, 900]]) {
      await page.setViewportSize({ width, height });
      await page.waitForTimeout(300);
      const [wide, high] = await page.evaluate(() => [document.documentElement.scrollWidth - window.innerWidth, document.getElementById("c-ppi").clientHeight]);
      assert.ok(wide <= 1 && high > 300 && high < 1000, `${width} x ${height}: ${wide}, ${high}`);
    }
    assert.deepEqual(page.faults, []);
    await shown.end();
    shown.clean();
    const still = await run("errors", "--duration-s", "300", "--set", 'sink=[{kind="null"}]');
    const other = await opened(browser, still.address);
    await until(other, "model.lines.length > 3");
    assert.equal(await other.isVisible("#p-ppi"), false);
    assert.deepEqual(other.faults, []);
    await still.end();
    still.clean();
  },

  /** A recording through the same page. */
  async replay(browser) {
    const made = await run("errors", "--duration-s", "2", "--pace", "fast", "--out", "made.plain", "--set", 'event=[{pulse=100,platform="aircraft",change="step position.up 9 m"}]');
    await new Promise((done) => made.child.on("close", done));
    const shown = await served(["monitor", join(made.folder, "made.plain"), "--listen", "127.0.0.1:0"]);
    const page = await opened(browser, shown.address);
    await page.waitForFunction(() => document.getElementById("misreports").textContent.includes("step position.up 9 m"));
    assert.ok((await page.textContent("#title")).includes("recording made.plain"));
    assert.equal(await page.isVisible("#inject"), false);
    assert.deepEqual(page.faults, []);
    await shown.end();
    made.clean();
    shown.clean();
  },

  /** What came over the wire has no truth: the other panels are drawn, and those that lack it say so. */
  async wire(browser) {
    const port = 20000 + process.pid % 20000;
    const folder = mkdtempSync(join(tmpdir(), "nereus-browser-"));
    const receiver = spawn(program, ["receive", "--listen", `127.0.0.1:${port}`, "--idle-s", "2", "--out", join(folder, "wire.plain")]);
    children.add(receiver);
    const received = new Promise((done) => receiver.on("close", done));
    await new Promise((open) => receiver.stderr.once("data", open));
    const sender = spawn(program, ["run", scenario("errors"), "--set", `sink=[{kind="vita49",address="127.0.0.1:${port}"}]`,
      "--set", 'stream.policy="slip"'], { cwd: folder });
    children.add(sender);
    assert.equal(await received, 0);
    const shown = await served(["monitor", join(folder, "wire.plain"), "--listen", "127.0.0.1:0"]);
    const page = await opened(browser, shown.address);
    await until(page, "model.lines.length > 3 && model.map && model.history.length > 3");
    await page.waitForTimeout(500);
    for (const canvas of ["c-waterfall", "c-plan", "c-doppler", "c-errors"]) assert.ok(await drawn(page, canvas) > 0.002, `${canvas} is empty`);
    const off = await page.evaluate(() => [...document.querySelectorAll("#ages tbody td:last-child")].map((cell) => cell.textContent));
    assert.deepEqual(off, ["–", "–"], "nothing is known of errors");
    assert.deepEqual(page.faults, []);
    await shown.end();
    shown.clean();
    rmSync(folder, { recursive: true, force: true });
  },
};

/** The pictures of the documentation: the aircraft of the quickstart after a step of its reported height. */
async function pictures(browser) {
  const shown = await served(["run", scenario("quickstart"), "--monitor", "127.0.0.1:0", "--monitor-control", "--duration-s", "60",
    "--set", 'sink=[{kind="null"}]', "--set", 'stream.policy="drop"', ...rest]);
  const page = await opened(browser, shown.address, { viewport: { width: 1600, height: 1000 } });
  await until(page, "model.now && model.now.time_s > 6");
  await page.selectOption("#i-platform", "aircraft");
  await page.fill("#i-value", "12");
  await page.click("#i-send");
  await until(page, "model.changes.length === 1 && model.now.time_s > model.changes[0].pulse / model.about.prf_hz + 7 && model.map");
  await page.mouse.move(0, 0);
  await page.evaluate(() => document.activeElement.blur());
  for (const [name, theme] of [["monitor", "light"], ["monitor-dark", "dark"]]) {
    await page.emulateMedia({ colorScheme: theme });
    await page.waitForTimeout(400);
    await page.screenshot({ path: `docs/${name}.png` });
  }
  await shown.end();
  shown.clean();
}

const browser = await chromium.launch({ executablePath: chromiumPath, args: process.getuid?.() === 0 ? ["--no-sandbox"] : [] });
let failed = 0;
if (option === "--pictures") await pictures(browser);
else {
  for (const [name, test] of Object.entries(tests)) {
    if (option === "--smoke" && name !== "smoke") continue;
    const begun = Date.now();
    try {
      await test(browser);
      console.log(`ok     ${name} (${((Date.now() - begun) / 1000).toFixed(1)} s)`);
    } catch (error) {
      failed++;
      children.forEach((child) => child.kill("SIGKILL"));
      console.log(`FAILED ${name}: ${error.stack}`);
    }
  }
}
await browser.close();
process.exit(failed ? 1 : 0);
