// Panel 2: range-compressed lines over slow time, and the latest one.

import { axes, bar, begin, empty, font, label, ticks } from "./plot.js";
import { image, theme } from "./colours.js";
import { clock, csv, whole } from "./format.js";

const id = (name) => document.getElementById(name);
const MOST_LINES = 400;
const ROOM = { left: 58, right: 78 };
const DECIBEL = 0.01;

/** Takes range lines of the channel shown. */
export function take(model, message) {
  if (message.channel !== model.channel) return;
  model.columnS = message.columnS;
  model.lines.push(...message.lines);
  model.lines.splice(0, Math.max(0, model.lines.length - MOST_LINES));
}

/** Low and high end of the colours, dBW. */
export function scale(model) {
  if (!model.auto) return [model.low, Math.max(model.low + 1, model.high)];
  // Of all that is in view, some sixty lines.
  const each = Math.ceil(model.lines.length / 60);
  const latest = model.lines.filter((_, place) => place % each === 0);
  const at = performance.now();
  if (latest.length && (!model.scaled || at - model.scaled > 1000)) {
    const all = latest.flatMap((line) => Array.from(line.levels).filter((_, k) => k % 3 === 0)).filter((v) => v > -30000);
    all.sort((a, b) => a - b);
    if (all.length) {
      const of = (part) => all[Math.floor(part * (all.length - 1))] * DECIBEL;
      model.high = 5 * Math.ceil((of(1) + 1) / 5);
      model.low = Math.min(5 * Math.floor(of(0.3) / 5), model.high - 20);
      model.scaled = at;
      if (document.activeElement !== id("db-low")) id("db-low").value = model.low;
      if (document.activeElement !== id("db-high")) id("db-high").value = model.high;
    }
  }
  return [model.low, model.high];
}

/** Delays and Doppler frequencies of the targets of the channel's pair. */
function truth(model, now) {
  const pair = model.about.channels[model.channel]?.pair;
  const count = model.about.targets.length;
  if (pair === null || pair === undefined) return [];
  return model.about.targets.map(({ name }, target) => ({
    name, delayS: now.delays_s[pair * count + target], dopplerHz: now.dopplers_hz[pair * count + target],
  }));
}

/** The same at an instant: from the pulses before and after it, or on from the nearest one by its Doppler. */
export function truthAt(model, timeS) {
  const after = model.delays.findIndex((one) => one.timeS >= timeS);
  const [a, b] = after < 0 ? [model.delays.at(-1), null] : [model.delays[after], model.delays[after - 1] ?? null];
  if (!a) return [];
  const [here, there] = [truth(model, a), b && truth(model, b)];
  return here.map((one, target) => {
    const ahead = timeS - a.timeS;
    if (!b || a.timeS === b.timeS) return { ...one, delayS: one.delayS - ahead * one.dopplerHz / model.about.carrier_hz };
    const part = ahead / (a.timeS - b.timeS);
    const between = (key) => one[key] + part * (one[key] - there[target][key]);
    return { name: one.name, delayS: between("delayS"), dopplerHz: between("dopplerHz") };
  });
}

export function draw(model) {
  const last = model.lines.at(-1);
  const views = [begin(id("c-waterfall")), begin(id("c-line"))];
  if (!views[0] || !views[1] || !model.about) return;
  if (!last) {
    const why = model.about.columns ? "waiting for the first pulse" : "no replica: what came over the wire cannot be compressed";
    return views.forEach((view) => empty(view, why));
  }
  const [low, high] = scale(model);
  const columns = last.levels.length;
  const x = { min: last.startS * 1e6, max: (last.startS + columns * model.columnS) * 1e6 };
  waterfall(model, views[0], x, [low, high], columns);
  rangeLine(model, views[1], x, [low, high], last);
}

function waterfall(model, view, x, [low, high], columns) {
  const { ctx, width, height, size } = view;
  const canvas = id("c-waterfall");
  const last = model.lines.at(-1);
  const box = { x: ROOM.left, y: 6, w: width - ROOM.left - ROOM.right, h: height - 12 };
  const since = Math.min(model.lines[0].timeS, last.timeS - 0.5);
  const rows = byTime(model, last, since, Math.min(400, Math.round(box.h)));
  ctx.fillStyle = theme().page;
  ctx.fillRect(box.x, box.y, box.w, box.h);
  ctx.imageSmoothingEnabled = false;
  // Slow time runs down: the latest line is the lowest, above the plot of it.
  ctx.drawImage(image(columns, rows, low, high), box.x, box.y, box.w, box.h);
  const y = { min: last.timeS, max: since, label: "time in the run, s", grid: false, room: 46 };
  // Axes turned over: later is lower.
  const { X, Y } = axes(ctx, box, { ...x, text: false, grid: false }, flipped(y), size);
  const at = (time) => Y(-time);
  if (model.markers) tracks(model, ctx, box, X, at, since);
  bar(ctx, box, low, high, size);
  canvas.setAttribute("aria-label", `Waterfall of ${model.lines.length} range lines of channel ${model.about.channels[model.channel].name}, latest pulse ${last.pulse}`);
}

/** Lines at even steps of time: each holds until the next, but no longer than three times as long as is usual. */
function byTime(model, last, since, count) {
  const none = new Int16Array(0);
  let place = -1;
  const steps = model.lines.slice(1).map((line, k) => line.timeS - model.lines[k].timeS).sort((a, b) => a - b);
  const longest = Math.max(1, 3 * (steps[Math.floor(steps.length / 2)] ?? 0), 3 * (last.timeS - since) / Math.max(1, model.lines.length));
  return Array.from({ length: count }, (_, row) => {
    const time = since + (row + 1) / count * (last.timeS - since);
    while (place + 1 < model.lines.length && model.lines[place + 1].timeS <= time + 1e-9) place++;
    const line = model.lines[place];
    if (!line || time - line.timeS > longest) return { levels: none };
    return { levels: line.levels, shift: Math.round((line.startS - last.startS) / model.columnS) };
  });
}

function flipped(y) {
  return { min: -y.min, max: -y.max, label: y.label, grid: y.grid, room: y.room, format: (value, all) => {
    const step = all.length > 1 ? Math.abs(all[1] - all[0]) : 1;
    return (-value).toFixed(step < 1 ? 1 : 0).replace("-0", "0");
  } };
}

/** Delays of targets over slow time. */
function tracks(model, ctx, box, X, at, since) {
  const seen = model.delays.filter((one) => one.timeS >= since && one.timeS <= model.lines.at(-1).timeS);
  if (!seen.length) return;
  ctx.save();
  ctx.beginPath();
  ctx.rect(box.x, box.y, box.w, box.h);
  ctx.clip();
  ctx.setLineDash([2, 7]);
  ctx.lineWidth = 1.4;
  ctx.strokeStyle = "#ffffff";
  model.about.targets.forEach((_, target) => {
    ctx.beginPath();
    for (const one of seen) {
      const delay = truth(model, one)[target]?.delayS;
      if (Number.isFinite(delay)) ctx.lineTo(X(delay * 1e6), at(one.timeS));
    }
    ctx.stroke();
  });
  ctx.restore();
}

function rangeLine(model, view, x, [low, high], last) {
  const { ctx, width, height, size } = view;
  const canvas = id("c-line");
  const colours = theme();
  const box = { x: ROOM.left, y: 18, w: width - ROOM.left - ROOM.right, h: height - 18 - size - 24 };
  const y = { min: low - 5, max: high + 5, label: "dBW", room: 46, ticks: ticks(low - 5, high + 5, box.h / 21) };
  const { X, Y } = axes(ctx, box, { ...x, label: "bistatic delay, µs" }, y, size);
  ctx.save();
  ctx.beginPath();
  ctx.rect(box.x, box.y, box.w, box.h);
  ctx.clip();
  ctx.beginPath();
  last.levels.forEach((level, column) => ctx.lineTo(X((last.startS + (column + 0.5) * model.columnS) * 1e6), Y(level * DECIBEL)));
  ctx.strokeStyle = colours.accent;
  ctx.lineWidth = 1.3;
  ctx.lineJoin = "round";
  ctx.stroke();
  ctx.restore();
  if (model.markers) marks(model, ctx, box, X, last);
  ctx.fillStyle = colours.muted;
  font(ctx, size);
  ctx.textAlign = "left";
  ctx.textBaseline = "alphabetic";
  ctx.fillText(`pulse ${whole(last.pulse)}, ${clock(last.timeS)}`, box.x + 2, 12);
  const { peakDb, delayUs } = peak(model, last);
  canvas.setAttribute("aria-label", `Range line of pulse ${last.pulse}: peak ${peakDb.toFixed(1)} dBW at ${delayUs.toFixed(3)} µs`);
}

/** The strongest column: level in dBW, delay in microseconds. */
export function peak(model, line) {
  let best = 0;
  line.levels.forEach((level, column) => { if (level > line.levels[best]) best = column; });
  return { peakDb: line.levels[best] * DECIBEL, delayUs: (line.startS + (best + 0.5) * model.columnS) * 1e6 };
}

function marks(model, ctx, box, X, last) {
  const colours = theme();
  const found = truthAt(model, last.timeS)
    .map(({ name, delayS }) => ({ x: X(delayS * 1e6), name }))
    .filter((one) => one.x >= box.x && one.x <= box.x + box.w)
    .sort((a, b) => a.x - b.x);
  ctx.strokeStyle = colours.reported;
  ctx.setLineDash([4, 3]);
  ctx.beginPath();
  for (const one of found) {
    ctx.moveTo(one.x, box.y);
    ctx.lineTo(one.x, box.y + box.h);
  }
  ctx.stroke();
  ctx.setLineDash([]);
  font(ctx, 11.5, 600);
  // Names in as many lines as they need to stay apart.
  const ends = [];
  for (const one of found) {
    const row = ends.findIndex((end) => end < one.x - 4);
    const place = row < 0 ? ends.length : row;
    if (15 * place + 16 > box.h) continue;
    const { right } = label(ctx, one.name, one.x + 4, box.y + 9 + 15 * place, { ink: colours.reported });
    ends[place] = right;
  }
}

export const canvases = () => [id("c-waterfall"), id("c-line")];

export function table(model) {
  const columns = model.lines.at(-1)?.levels.length ?? 0;
  const head = ["pulse", "time_s", "first_delay_s", "delay_step_s", ...Array.from({ length: columns }, (_, k) => `dbw_${k}`)];
  return csv([head, ...model.lines.map((line) => [line.pulse, line.timeS, line.startS + model.columnS / 2, model.columnS,
    ...Array.from(line.levels, (level) => (level * DECIBEL).toFixed(2))])]);
}
