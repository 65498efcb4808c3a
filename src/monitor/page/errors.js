// Panel 4: reported minus true position, velocity and attitude over time.

import { axes, begin, empty, font, label, ticks } from "./plot.js";
import { theme } from "./colours.js";
import { csv, digits, whole } from "./format.js";

const id = (name) => document.getElementById(name);
const SET = 16;
const PLOTS = [
  { title: "position", unit: "m", at: 6, least: 0.5, names: ["East", "North", "up"] },
  { title: "velocity", unit: "m/s", at: 9, least: 0.05, names: ["East", "North", "up"] },
  { title: "attitude", unit: "°", at: 12, least: 0.05, names: ["roll", "pitch", "heading"] },
];

/** Distance between reported and true position of every platform, m. */
export function distances(model) {
  const last = model.history.at(-1);
  return last ? model.about.platforms.map((_, place) => Math.hypot(...last.slice(2 + SET * place + 6, 2 + SET * place + 9).map((part) => part ?? NaN))) : [];
}

export function draw(model) {
  const canvas = id("c-errors");
  const view = begin(canvas);
  if (!view || !model.about) return;
  if (!model.about.truth) return empty(view, "the recording has no truth to compare with");
  if (model.history.length < 2) return empty(view, "waiting for the first pulses");
  const { ctx, width, height, size } = view;
  const place = model.errorPlatform;
  const latest = model.history.at(-1)[1];
  const since = model.errorSpan ? Math.max(model.history[0][1], latest - model.errorSpan) : model.history[0][1];
  const points = model.history.filter((row) => row[1] >= since);
  const x = { min: since, max: Math.max(latest, since + 0.1), label: "time in the run, s" };
  const top = 21;
  const bottom = size + 24;
  const each = (height - top - bottom) / 3;
  const colours = theme();
  const inks = [colours.true, colours.reported, colours.third];
  const changes = model.changes.filter((one) => one.platform === model.about.platforms[place]);
  PLOTS.forEach((plot, row) => {
    const box = { x: 46, y: top + row * each, w: width - 46 - 112, h: each - (row < 2 ? size + 9 : 0) };
    const values = plot.names.map((_, axis) => points.map((point) => point[2 + SET * place + plot.at + axis]));
    const known = values.flat().filter(Number.isFinite);
    const low = Math.min(...known, -plot.least / 4);
    const high = Math.max(...known, plot.least / 4);
    const room = 0.12 * (high - low);
    const y = { min: low - room, max: high + room, ticks: ticks(low - room, high + room, box.h / 19) };
    const { X, Y } = axes(ctx, box, row === 2 ? x : { ...x, label: "", text: false }, y, size);
    ctx.save();
    ctx.beginPath();
    ctx.rect(box.x, box.y, box.w, box.h);
    ctx.clip();
    mark(ctx, changes, model, X, box);
    values.forEach((series, axis) => {
      ctx.beginPath();
      series.forEach((value, k) => { if (Number.isFinite(value)) ctx.lineTo(X(points[k][1]), Y(value)); });
      ctx.strokeStyle = inks[axis];
      ctx.lineWidth = 1.8;
      ctx.stroke();
    });
    ctx.restore();
    // Above, at the left: three upright ones hide one another on a low screen.
    const title = `${plot.title}, ${plot.unit}`;
    ctx.textAlign = "left";
    ctx.textBaseline = "alphabetic";
    ctx.fillStyle = colours.text;
    ctx.fillText(title, box.x, box.y - 5);
    const from = box.x + ctx.measureText(title).width + 10;
    font(ctx, size, 600);
    values.forEach((series, axis) => {
      const value = series.at(-1);
      const line = box.y + box.h / 2 + (axis - 1) * Math.min(size + 5, (each - 2) / 3);
      ctx.fillStyle = inks[axis];
      ctx.textAlign = "left";
      ctx.textBaseline = "middle";
      ctx.fillText(`${plot.names[axis]} ${Number.isFinite(value) ? digits(value, Math.abs(value) < 0.01 ? 1 : 3).replace("-", "−") : "–"}`, box.x + box.w + 8, line);
    });
    if (row === 0) names(ctx, changes, model, X, box, size, from);
  });
  canvas.setAttribute("aria-label", `Reported minus true of ${model.about.platforms[place]}: position ${digits(distances(model)[place])} m off`);
}

/** Time at which a change has effect, from the rate of pulses. */
export function timeOf(model, change) {
  const rows = model.history;
  const after = rows.findIndex((row) => row[0] >= change.pulse);
  const last = rows.at(-1);
  if (after < 0) return last ? last[1] + (change.pulse - last[0]) / model.about.prf_hz : change.pulse / model.about.prf_hz;
  return rows[after][1] - (rows[after][0] - change.pulse) / model.about.prf_hz;
}

function mark(ctx, changes, model, X, box) {
  ctx.strokeStyle = theme().muted;
  ctx.lineWidth = 1.2;
  ctx.setLineDash([4, 3]);
  ctx.beginPath();
  for (const change of changes) {
    const x = X(timeOf(model, change));
    ctx.moveTo(x, box.y);
    ctx.lineTo(x, box.y + box.h);
  }
  ctx.stroke();
  ctx.setLineDash([]);
}

function names(ctx, changes, model, X, box, size, from) {
  font(ctx, size);
  let end = from;
  for (const change of changes.slice(-12)) {
    const x = X(timeOf(model, change));
    if (x < box.x || x > box.x + box.w + 1) continue;
    // As much of it as has room; the log has all.
    const place = (text) => ({ text, at: Math.max(end, Math.min(x - 4, box.x + box.w - ctx.measureText(text).width)) });
    const fits = ({ text, at }) => at - x < 60 && at + ctx.measureText(text).width <= box.x + box.w + 1;
    const found = [`pulse ${whole(change.pulse)}: ${change.text}`, `pulse ${whole(change.pulse)}`].map(place).find(fits);
    if (!found) continue;
    ({ right: end } = label(ctx, found.text, found.at, 10));
    end += 8;
  }
}

export const canvases = () => [id("c-errors")];

export function table(model) {
  const names = model.about.platforms.flatMap((name) => PLOTS.flatMap((plot) => plot.names.map((axis) => `${name}_${plot.title}_${axis.toLowerCase()}_${{ m: "m", "m/s": "mps", "°": "deg" }[plot.unit]}`)));
  return csv([["pulse", "time_s", ...names], ...model.history.map((row) => [row[0], row[1],
    ...model.about.platforms.flatMap((_, place) => row.slice(2 + SET * place + 6, 2 + SET * place + 15))])]);
}
