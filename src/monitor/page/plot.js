// Axes on a canvas.

import { theme, colour } from "./colours.js";

const SANS = 'system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif';

/** Pixels of the page in a unit of a drawing: drawings grow with the type of the page. */
export const zoom = () => Number.parseFloat(getComputedStyle(document.documentElement).fontSize) / 14;

/** A canvas of the size that it has on the page, sharp, cleared; `null` while it is not seen. */
export function begin(canvas) {
  const unit = zoom();
  const [width, height] = [canvas.clientWidth / unit, canvas.clientHeight / unit];
  if (width < 40 || height < 30) return null;
  const scale = unit * (window.devicePixelRatio || 1);
  if (canvas.width !== Math.round(width * scale) || canvas.height !== Math.round(height * scale)) {
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
  }
  const ctx = canvas.getContext("2d");
  ctx.setTransform(scale, 0, 0, scale, 0, 0);
  ctx.fillStyle = theme().panel;
  ctx.fillRect(0, 0, width, height);
  const size = width > 900 ? 13.5 : 12;
  font(ctx, size);
  return { ctx, width, height, size };
}

export function font(ctx, size, weight = 400) {
  ctx.font = `${weight} ${size}px ${SANS}`;
}

/** Round numbers within a range, about so many of them. */
export function ticks(min, max, count) {
  const range = max - min;
  if (!(range > 0) || !Number.isFinite(range)) return [];
  const raw = range / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((part) => part * power).find((size) => size >= raw * 0.999);
  const first = Math.ceil(min / step - 1e-9);
  const found = [];
  for (let k = first; k * step <= max + 1e-9 * range; k++) found.push(k * step);
  return found;
}

/** A tick as text, to the decimals that its neighbours need. */
export function tick(value, all) {
  const step = all.length > 1 ? Math.abs(all[1] - all[0]) : Math.abs(value) || 1;
  const places = Math.max(0, Math.min(6, -Math.floor(Math.log10(step) + 1e-9)));
  return (Math.abs(value) < step * 1e-6 ? 0 : value).toFixed(places).replace("-", "−");
}

/** Axes within a box: grid, ticks, labels. Gives the places of values. */
export function axes(ctx, box, x, y, size = 12) {
  const colours = theme();
  const X = (value) => box.x + (value - x.min) / (x.max - x.min) * box.w;
  const Y = (value) => box.y + box.h - (value - y.min) / (y.max - y.min) * box.h;
  font(ctx, size);
  ctx.lineWidth = 1;
  const xs = x.ticks ?? ticks(x.min, x.max, box.w / 70);
  const ys = y.ticks ?? ticks(y.min, y.max, box.h / 34);
  ctx.strokeStyle = colours.grid;
  ctx.beginPath();
  if (x.grid !== false) for (const value of xs) line(ctx, Math.round(X(value)) + 0.5, box.y, 0, box.h);
  if (y.grid !== false) for (const value of ys) line(ctx, box.x, Math.round(Y(value)) + 0.5, box.w, 0);
  ctx.stroke();
  ctx.fillStyle = colours.muted;
  if (x.text !== false) {
    ctx.textAlign = "center";
    ctx.textBaseline = "top";
    for (const value of xs) ctx.fillText((x.format ?? tick)(value, xs), X(value), box.y + box.h + 4);
  }
  ctx.textAlign = "right";
  ctx.textBaseline = "middle";
  if (y.text !== false) for (const value of ys) ctx.fillText((y.format ?? tick)(value, ys), box.x - 6, Y(value));
  ctx.strokeStyle = colours.line;
  ctx.strokeRect(box.x + 0.5, box.y + 0.5, box.w, box.h);
  ctx.fillStyle = colours.text;
  if (x.label) {
    ctx.textAlign = "center";
    ctx.textBaseline = "alphabetic";
    ctx.fillText(x.label, box.x + box.w / 2, box.y + box.h + size + 19);
  }
  if (y.label) upright(ctx, y.label, box.x - (y.room ?? 44), box.y + box.h / 2);
  return { X, Y };
}

function line(ctx, x, y, dx, dy) {
  ctx.moveTo(x, y);
  ctx.lineTo(x + dx, y + dy);
}

/** Text that reads upwards. */
export function upright(ctx, text, x, y) {
  ctx.save();
  ctx.translate(x, y);
  ctx.rotate(-Math.PI / 2);
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  ctx.fillText(text, 0, 0);
  ctx.restore();
}

/** Text on a ground of its own, legible over anything. */
export function label(ctx, text, x, y, { ink, align = "left", back = theme().panel } = {}) {
  const size = Number(/([\d.]+)px/.exec(ctx.font)[1]);
  const wide = ctx.measureText(text).width;
  const left = align === "left" ? x : align === "right" ? x - wide : x - wide / 2;
  ctx.globalAlpha = 0.85;
  ctx.fillStyle = back;
  ctx.fillRect(left - 3, y - size / 2 - 3, wide + 6, size + 6);
  ctx.globalAlpha = 1;
  ctx.fillStyle = ink ?? theme().text;
  ctx.textAlign = "left";
  ctx.textBaseline = "middle";
  ctx.fillText(text, left, y);
  return { left: left - 3, right: left + wide + 3 };
}

/** The colours of levels from low to high, beside a box. */
export function bar(ctx, box, low, high, size) {
  const [x, w] = [box.x + box.w + (box.gap ?? 10), 11];
  for (let row = 0; row < box.h; row++) {
    ctx.fillStyle = colour(1 - row / Math.max(1, box.h - 1));
    ctx.fillRect(x, box.y + row, w, 1.5);
  }
  const all = ticks(low, high, box.h / 34);
  font(ctx, size);
  ctx.fillStyle = theme().muted;
  ctx.textAlign = "left";
  ctx.textBaseline = "middle";
  for (const value of all) ctx.fillText(tick(value, all), x + w + 4, box.y + box.h * (high - value) / (high - low));
  ctx.fillStyle = theme().text;
  upright(ctx, "dBW", x + w + 49, box.y + box.h / 2);
}

/** A word where there is nothing to show yet. */
export function empty(view, text) {
  view.ctx.fillStyle = theme().muted;
  view.ctx.textAlign = "center";
  view.ctx.textBaseline = "middle";
  // In as many lines as it needs.
  const lines = [""];
  for (const word of text.split(" ")) {
    const longer = `${lines.at(-1)} ${word}`.trim();
    if (view.ctx.measureText(longer).width > view.width - 12) lines.push(word);
    else lines[lines.length - 1] = longer;
  }
  lines.forEach((line, row) => view.ctx.fillText(line, view.width / 2, view.height / 2 + 17 * (row - (lines.length - 1) / 2)));
}
