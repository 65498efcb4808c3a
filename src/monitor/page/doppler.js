// Panel 2, continued: range-Doppler map of the last pulses.

import { axes, bar, begin, empty, font, label, tick, ticks, upright } from "./plot.js";
import { image, theme } from "./colours.js";
import { truthAt } from "./ranges.js";
import { csv } from "./format.js";

const id = (name) => document.getElementById(name);

export function draw(model) {
  const canvas = id("c-doppler");
  const view = begin(canvas);
  if (!view || !model.about) return;
  const map = model.map;
  if (!model.doppler) return empty(view, "switched off");
  if (!map || map.channel !== model.channel) return empty(view, model.about.columns ? "gathering pulses" : "no replica: nothing can be compressed");
  const { ctx, width, height, size } = view;
  const colours = theme();
  const box = { x: 62, y: 8, w: width - 62 - 140, h: height - 8 - size - 27, gap: 62 };
  const high = 5 * Math.ceil((map.levels.reduce((a, b) => Math.max(a, b), -32767) * 0.01 + 1) / 5);
  const low = high - 50;
  const rows = [];
  for (let row = map.rows - 1; row >= 0; row--) rows.push({ levels: map.levels.subarray(row * map.columns, (row + 1) * map.columns) });
  ctx.imageSmoothingEnabled = false;
  ctx.drawImage(image(map.columns, rows, low, high), box.x, box.y, box.w, box.h);
  // A row holds the frequencies around its middle.
  const half = 0.5 * map.spanHz;
  const bin = map.spanHz / map.rows;
  const x = { min: map.startS * 1e6, max: (map.startS + map.columns * map.columnS) * 1e6, label: "bistatic delay, µs", grid: false };
  const y = { min: -half - bin / 2, max: half - bin / 2, label: "Doppler, Hz", grid: false, room: 50 };
  const { X, Y } = axes(ctx, box, x, y, size);
  const wavelength = model.about.wavelength_m;
  const speeds = ticks(y.min * wavelength, y.max * wavelength, box.h / 34);
  font(ctx, size);
  ctx.textAlign = "left";
  ctx.textBaseline = "middle";
  ctx.fillStyle = colours.muted;
  for (const speed of speeds) ctx.fillText(tick(speed, speeds), box.x + box.w + 6, Y(speed / wavelength));
  ctx.fillStyle = colours.text;
  upright(ctx, "closing speed of the path, m/s", box.x + box.w + 48, box.y + box.h / 2);
  bar(ctx, box, low, high, size);
  if (model.markers) marks(model, map, ctx, box, X, Y);
  id("doppler-note").textContent = `${map.rows} pulses, folds at ${map.spanHz.toFixed(0)} Hz`;
  canvas.setAttribute("aria-label", `Range-Doppler map of ${map.rows} pulses up to pulse ${map.pulse}`);
}

function marks(model, map, ctx, box, X, Y) {
  font(ctx, 11.5, 600);
  // A target that moves through cells meanwhile stands where it was in the middle.
  const middle = map.timeS - 0.5 * (map.rows - 1) / map.spanHz;
  const taken = [];
  truthAt(model, middle).forEach(({ name, delayS: delay, dopplerHz: doppler }) => {
    if (!Number.isFinite(delay) || !Number.isFinite(doppler)) return;
    const bin = map.spanHz / map.rows;
    const folded = doppler - map.spanHz * Math.floor((doppler + 0.5 * map.spanHz + 0.5 * bin) / map.spanHz);
    const [x, y] = [X(delay * 1e6), Y(folded)];
    if (x < box.x || x > box.x + box.w) return;
    ctx.strokeStyle = "#ffffff";
    ctx.lineWidth = 1.6;
    ctx.beginPath();
    ctx.arc(x, y, 7, 0, 2 * Math.PI);
    ctx.stroke();
    ctx.fillStyle = "#ffffff";
    // Names that would hide one another stand a line apart.
    const wide = ctx.measureText(name).width + 4;
    const free = (dy) => !taken.some((other) => Math.abs(other.y - y - dy) < 13 && x < other.x + other.wide && other.x < x + wide);
    const dy = [0, -13, 13, 26, -26].find(free);
    if (dy === undefined) return;
    taken.push({ x, y: y + dy, wide });
    ctx.textAlign = "left";
    ctx.textBaseline = "middle";
    ctx.strokeStyle = "rgb(0 0 0 / 65%)";
    ctx.lineWidth = 3;
    ctx.strokeText(name, x + 10, y + dy);
    ctx.fillText(name, x + 10, y + dy);
  });
}

export const canvases = () => [id("c-doppler")];

export function table({ map }) {
  if (!map) return "";
  const head = ["doppler_hz", ...Array.from({ length: map.columns }, (_, k) => ((map.startS + (k + 0.5) * map.columnS) * 1e6).toFixed(5))];
  const rows = Array.from({ length: map.rows }, (_, row) => [(row / map.rows - 0.5) * map.spanHz,
    ...Array.from(map.levels.subarray(row * map.columns, (row + 1) * map.columns), (level) => (level * 0.01).toFixed(2))]);
  return csv([head, ...rows]);
}
