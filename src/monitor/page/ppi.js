// Panel 7: plan position of a scanning antenna. Each spoke keeps what came back last, and fades until the beam is there again.

import { bar, begin, empty, font, label, ticks, zoom as unit } from "./plot.js";
import { PIXELS, theme } from "./colours.js";
import { csv, digits } from "./format.js";

const id = (name) => document.getElementById(name);
const HALF_C = 299792458 / 2;
const UNITS = { NM: 1852, km: 1000 };
const STEP_DB = 0.5;
const MOST_CODE = 255;
/** Colour of the ground, as red, green, blue. */
const GROUND = [10, 14, 20];
/** Brightness at which afterglow ends; 1 where the beam has just passed. */
const LEAST_GLOW = 0.25;
/** Turns after which a spoke that was not seen again is dark, and in which afterglow falls to 1/e. */
const [DARK, DECAY] = [1.6, 0.45];
const MOST_ZOOM = 32;
const SCALE_MS = 1000;
/** Least and greatest span of the colours that are chosen by themselves, dB. */
const SPANS_DB = [25, 80];

let scope = null;
let hover = null;
let zoom = 1;
let drawn = null;
let grid = null;
let picture = null;
const rad = (deg) => deg * Math.PI / 180;
const turn = (deg) => ((deg % 360) + 360) % 360;
const wrapped = (deg) => turn(deg + 180) - 180;

/** A new run: shows or hides the panel. */
export function about(model) {
  const has = model.about.ppi;
  id("p-ppi").hidden = !has;
  zoom = 1;
  id("panels").classList.toggle("scans", Boolean(has));
  scope = has ? { ...has, step: 360 / has.spokes, at: new Array(has.spokes).fill(null), last: null, low: -140, high: -80, scaled: 0 } : null;
  return Boolean(has);
}

/** Lets the panel be scaled and read by mouse and keys. */
export function init(redraw) {
  const canvas = id("c-ppi");
  for (const name of ["ppi-up", "ppi-unit", "ppi-glow"]) id(name).onchange = redraw;
  const scale = (by) => { zoom = Math.max(1, Math.min(MOST_ZOOM, zoom * by)); redraw(); };
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    scale(Math.exp(-event.deltaY / 400));
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    if (event.key === "+" || event.key === "=") scale(1.3);
    else if (event.key === "-") scale(1 / 1.3);
    else return;
    event.preventDefault();
  });
  canvas.addEventListener("pointermove", (event) => { hover = [event.offsetX / unit(), event.offsetY / unit()]; redraw(); });
  canvas.addEventListener("pointerleave", () => { hover = null; redraw(); });
}

/** North up, or head up. */
export function turnOver() {
  const choice = id("ppi-up");
  choice.value = choice.value === "north" ? "head" : "north";
  choice.onchange();
}

/** Takes radials. Bearings between two that are within a beam have the nearer one. */
export function take({ cellS, radials }) {
  if (!scope) return;
  scope.cellM = cellS * HALF_C;
  for (const radial of radials) {
    radial.startM = radial.startS * HALF_C;
    const last = scope.last;
    const apart = last ? wrapped(radial.azimuthDeg - last.azimuthDeg) : Infinity;
    if (Math.abs(apart) <= Math.max(scope.beam_deg, 1.5 * scope.step)) {
      fill(last.azimuthDeg, apart / 2, last);
      fill(radial.azimuthDeg, -apart / 2, radial);
      scope.at[spoke(last.azimuthDeg)] = last;
    }
    scope.at[spoke(radial.azimuthDeg)] = radial;
    scope.last = radial;
  }
}

const spoke = (deg) => Math.min(scope.spokes - 1, Math.floor(turn(deg) / scope.step));

function fill(from, by, radial) {
  const count = Math.ceil(Math.abs(by) / scope.step);
  for (let k = 0; k <= count; k++) scope.at[spoke(from + by * k / Math.max(1, count))] = radial;
}

/** Level at a range and a bearing from North, dBW; `null` where nothing was received. */
export function levelAt(rangeM, bearingDeg) {
  const radial = scope?.at[spoke(bearingDeg)];
  const code = radial?.codes[Math.floor((rangeM - radial.startM) / scope.cellM)];
  return code > 0 ? radial.peakDbw - (MOST_CODE - code) * STEP_DB : null;
}

/** Where the strongest cell is: for tests. */
export function strongest() {
  let best = null;
  for (const radial of scope?.at ?? []) {
    if (!radial || (best && radial.peakDbw <= best.dbw)) continue;
    best = { dbw: radial.peakDbw, bearingDeg: radial.azimuthDeg, rangeM: radial.startM + (radial.codes.indexOf(MOST_CODE) + 0.5) * scope.cellM };
  }
  return best;
}

const farM = () => scope.last.startM + scope.last.codes.length * scope.cellM;

/** Levels of the first and last colour: those of half, and of 99.9 % of what was received. */
function scaleColours(model) {
  if (!model.auto) return Object.assign(scope, { low: model.low, high: Math.max(model.high, model.low + 1), scaled: 0 });
  if (scope.scaled && performance.now() - scope.scaled < SCALE_MS) return scope;
  const counts = new Uint32Array(1200);
  let all = 0;
  for (let k = 0; k < scope.spokes; k += 3) {
    const radial = scope.at[k];
    if (!radial) continue;
    for (let cell = k % 4; cell < radial.codes.length; cell += 4) {
      if (!radial.codes[cell]) continue;
      const bin = Math.round((radial.peakDbw - (MOST_CODE - radial.codes[cell]) * STEP_DB + 400) / STEP_DB);
      if (bin >= 0 && bin < counts.length) { counts[bin]++; all++; }
    }
  }
  const below = (part) => {
    let sum = 0;
    return counts.findIndex((count) => (sum += count) >= part * all) * STEP_DB - 400;
  };
  if (all) {
    const high = below(0.999);
    const low = Math.max(below(0.5), high - SPANS_DB[1]);
    Object.assign(scope, { low, high: Math.max(high, low + SPANS_DB[0]), scaled: performance.now() });
  }
  return scope;
}

/** Where pixels lie: their distance from the middle in pixels, their spoke, and how many spokes beside it they cover. */
function gridOf(side) {
  if (grid?.side === side && grid.spokes === scope.spokes) return grid;
  const [away, spokes, beside] = [new Float32Array(side * side), new Int16Array(side * side).fill(-1), new Uint16Array(side * side)];
  const middle = (side - 1) / 2;
  for (let row = 0; row < side; row++) {
    for (let column = 0; column < side; column++) {
      const [x, y] = [column - middle, middle - row];
      const range = Math.hypot(x, y);
      if (range > side / 2) continue;
      const place = row * side + column;
      away[place] = range;
      spokes[place] = spoke(Math.atan2(x, y) * 180 / Math.PI);
      beside[place] = Math.min(scope.spokes / 2, Math.floor(0.5 / Math.max(range, 0.5) / rad(scope.step)));
    }
  }
  grid = { side, spokes: scope.spokes, at: spokes, away, beside };
  return grid;
}

/** The picture with North up: each pixel has the strongest of what lies within. */
function paint(side, radiusM, glows) {
  const { away, at, beside } = gridOf(side);
  const { low, high, cellM, spokes } = scope;
  const perPixel = 2 * radiusM / side / cellM;
  const half = perPixel > 1 ? perPixel / 2 : 0;
  if (picture?.canvas.width !== side) {
    const image = new ImageData(side, side);
    picture = { canvas: new OffscreenCanvas(side, side), image, out: new Uint32Array(image.data.buffer) };
  }
  const { out, image, canvas } = picture;
  const codes = scope.at.map((radial) => radial?.codes ?? null);
  const peaks = Float64Array.from(scope.at, (radial) => radial?.peakDbw ?? 0);
  const starts = Float64Array.from(scope.at, (radial) => radial ? radial.startM / cellM : 0);
  const scale = 255 / (high - low);
  const [red, green, blue] = GROUND;
  const ground = 255 << 24 | blue << 16 | green << 8 | red;
  for (let place = 0; place < at.length; place++) {
    if (at[place] < 0) continue;
    const range = away[place] * perPixel;
    let [best, glow] = [-1e9, 0];
    for (let by = -beside[place]; by <= beside[place]; by++) {
      const k = (at[place] + by + spokes) % spokes;
      if (glows[k] === 0) continue;
      const line = codes[k];
      const first = Math.max(0, Math.floor(range - half - starts[k]));
      const last = Math.min(line.length - 1, Math.floor(range + half - starts[k]));
      let most = 0;
      for (let cell = first; cell <= last; cell++) if (line[cell] > most) most = line[cell];
      const level = peaks[k] - (MOST_CODE - most) * STEP_DB;
      if (most && level > best) { best = level; glow = glows[k]; }
    }
    if (glow === 0) { out[place] = ground; continue; }
    const step = (best - low) * scale;
    const pixel = PIXELS[step <= 0 ? 0 : step >= 255 ? 255 : step | 0];
    out[place] = 255 << 24
      | blue + glow * ((pixel >> 16 & 255) - blue) << 16
      | green + glow * ((pixel >> 8 & 255) - green) << 8
      | red + glow * ((pixel & 255) - red);
  }
  canvas.getContext("2d").putImageData(image, 0, 0);
  return canvas;
}

/** How bright each spoke is. */
function glowing() {
  const fades = id("ppi-glow").checked;
  return Float32Array.from(scope.at, (radial) => {
    if (!radial) return 0;
    const age = (scope.last.timeS - radial.timeS) / scope.period_s;
    if (age > DARK) return 0;
    return fades ? LEAST_GLOW + (1 - LEAST_GLOW) * Math.exp(-Math.max(0, age) / DECAY) : 1;
  });
}

export function draw(model) {
  if (!scope) return;
  const view = begin(id("c-ppi"));
  if (!view) return;
  if (!scope.last) return empty(view, "waiting for the first radial");
  scaleColours(model);
  const { ctx, width, height, size } = view;
  const radius = Math.max(20, Math.min((width - 96) / 2, height / 2) - size - 12);
  const [x0, y0] = [(width - 66) / 2, height / 2];
  const headUp = id("ppi-up").value === "head";
  const heading = scope.last.headingDeg;
  const zero = headUp ? heading : 0;
  const radiusM = farM() / zoom;
  drawn = { x0, y0, radius, radiusM, zero };
  const side = Math.min(900, 2 * Math.round(radius * (ctx.getTransform().a)));
  ctx.save();
  ctx.translate(x0, y0);
  ctx.rotate(-rad(zero));
  ctx.drawImage(paint(side, radiusM, glowing()), -radius, -radius, 2 * radius, 2 * radius);
  ctx.restore();
  const at = (rangeM, bearingDeg) => {
    const [away, way] = [rangeM / radiusM * radius, rad(bearingDeg - zero)];
    return [x0 + away * Math.sin(way), y0 - away * Math.cos(way)];
  };
  rings(ctx, at, radiusM, size);
  bearings(ctx, headUp, size);
  ray(ctx, at(0, 0), at(radiusM, scope.last.azimuthDeg), "rgb(255 255 255 / 75%)", 1.6, []);
  if (headUp || Math.abs(wrapped(heading)) > 0.05) ray(ctx, at(0, 0), at(radiusM, heading), "rgb(255 255 255 / 45%)", 1, [7, 5]);
  const marks = model.markers ? places(model) : [];
  names(ctx, marks.filter((mark) => mark.rangeM <= radiusM), at);
  bar(ctx, { x: width - 72, y: 14, w: 0, h: height - 28 }, scope.low, scope.high, size);
  if (hover) point(ctx, view);
  id("c-ppi").setAttribute("aria-label", `Plan position, ${headUp ? "head" : "North"} up, to ${length(radiusM)}: beam at ${bearing(scope.last.azimuthDeg)}; `
    + marks.map((mark) => `${mark.name} at ${length(mark.rangeM)}, ${bearing(mark.bearingDeg)}`).join("; "));
}

const bearing = (deg) => `${(Math.round(turn(deg) * 10) % 3600 / 10).toFixed(1).padStart(5, "0")}°`;
const length = (metres) => `${digits(metres / UNITS[id("ppi-unit").value], 4)} ${id("ppi-unit").value}`;

function rings(ctx, at, radiusM, size) {
  const name = id("ppi-unit").value;
  const { x0, y0, radius } = drawn;
  const all = ticks(0, radiusM / UNITS[name], 5).filter((value) => value > 0);
  ctx.strokeStyle = "rgb(255 255 255 / 32%)";
  ctx.lineWidth = 1;
  for (const value of all) {
    ctx.beginPath();
    ctx.arc(x0, y0, value * UNITS[name] / radiusM * radius, 0, 2 * Math.PI);
    ctx.stroke();
  }
  ctx.strokeStyle = theme().muted;
  ctx.beginPath();
  ctx.arc(x0, y0, radius, 0, 2 * Math.PI);
  ctx.stroke();
  font(ctx, size - 1, 600);
  // Away from the marks of bearings.
  for (const value of all) {
    const [x, y] = at(value * UNITS[name], drawn.zero + 45);
    written(ctx, `${digits(value, 3).replace(/\.?0+$/, "")} ${name}`, x, y, "center");
  }
}

/** Marks every 30 degrees: from North, or from the heading where that is up. */
function bearings(ctx, headUp, size) {
  const { x0, y0, radius } = drawn;
  font(ctx, size);
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  for (let deg = 0; deg < 360; deg += 30) {
    const [x, y] = [Math.sin(rad(deg)), -Math.cos(rad(deg))];
    ray(ctx, [x0 + radius * x, y0 + radius * y], [x0 + (radius - 8) * x, y0 + (radius - 8) * y], "#ffffff", 1.4, []);
    ctx.fillStyle = theme().muted;
    ctx.fillText(String(deg).padStart(3, "0"), x0 + (radius + size + 2) * x, y0 + (radius + size) * y);
  }
  font(ctx, size, 650);
  ctx.fillStyle = theme().text;
  ctx.textAlign = "left";
  ctx.fillText(headUp ? "head up" : "North up", 6, size);
}

function ray(ctx, from, to, stroke, thick, dash) {
  ctx.beginPath();
  ctx.moveTo(...from);
  ctx.lineTo(...to);
  ctx.strokeStyle = stroke;
  ctx.lineWidth = thick;
  ctx.setLineDash(dash);
  ctx.stroke();
  ctx.setLineDash([]);
}

function written(ctx, text, x, y, align) {
  ctx.textAlign = align;
  ctx.textBaseline = "middle";
  ctx.strokeStyle = "rgb(0 0 0 / 70%)";
  ctx.lineWidth = 3;
  ctx.strokeText(text, x, y);
  ctx.fillStyle = "#ffffff";
  ctx.fillText(text, x, y);
}

/** Targets and ships: range and bearing of their true places from the true place of the antenna. */
export function places(model) {
  const from = model.now?.antennas[scope?.antenna]?.position_m;
  if (!from || !model.about.truth) return [];
  const targets = model.about.targets.filter((target) => target.position_m).map((target) => ({
    name: target.name, at: target.position_m.map((value, axis) => value + target.velocity_mps[axis] * model.now.time_s) }));
  const ships = model.now.ships.map((ship, place) => ({ name: model.about.ships[place].name, at: ship.position_m, ship: true }));
  return [...ships, ...targets].map(({ name, at, ship }) => {
    const [east, north, up] = [0, 1, 2].map((axis) => at[axis] - from[axis]);
    return { name, ship, rangeM: Math.hypot(east, north, up), bearingDeg: turn(Math.atan2(east, north) * 180 / Math.PI) };
  }).filter((mark) => Number.isFinite(mark.rangeM));
}

/** Names beside their places, a line apart where they would hide one another. */
function names(ctx, marks, at) {
  const taken = [];
  font(ctx, 11.5, 600);
  ctx.strokeStyle = "#ffffff";
  for (const { name, ship, rangeM, bearingDeg } of marks) {
    const [x, y] = at(rangeM, bearingDeg);
    ctx.lineWidth = 1.5;
    ctx.strokeStyle = "#ffffff";
    ctx.beginPath();
    if (ship) for (const [dx, dy] of [[0, -8], [7, 6], [-7, 6], [0, -8]]) ctx.lineTo(x + dx, y + dy);
    else ctx.arc(x, y, 7, 0, 2 * Math.PI);
    ctx.stroke();
    const wide = ctx.measureText(name).width;
    const left = x + 11 + wide > drawn.x0 + drawn.radius + 20 ? x - 11 - wide : x + 11;
    const free = (dy) => !taken.some((other) => Math.abs(other.y - y - dy) < 13 && left < other.left + other.wide && other.left < left + wide);
    const dy = [0, -13, 13, 26, -26].find(free);
    if (dy === undefined) continue;
    taken.push({ left, y: y + dy, wide });
    written(ctx, name, left, y + dy, "left");
  }
}

/** Range, bearing and level under the pointer. */
function point(ctx, { height, size }) {
  const { x0, y0, radius, radiusM, zero } = drawn;
  const [x, y] = [hover[0] - x0, y0 - hover[1]];
  const away = Math.hypot(x, y);
  if (away > radius) return;
  const relative = Math.atan2(x, y) * 180 / Math.PI;
  const [rangeM, deg] = [away / radius * radiusM, relative + zero];
  const level = levelAt(rangeM, deg);
  const ahead = id("ppi-up").value === "head" ? `, ${bearing(relative)} from ahead` : "";
  font(ctx, size + 1, 600);
  label(ctx, `${length(rangeM)}, ${bearing(deg)}${ahead}`, 8, height - 2 * size - 8);
  label(ctx, level === null ? "nothing received" : `${level.toFixed(1)} dBW`, 8, height - size);
}

export const canvases = () => [id("c-ppi")];

export const lines = (model) => scope?.last ? [`channel ${scope.channel}, ${id("ppi-up").value === "head" ? "head" : "North"} up, to ${length(farM() / zoom)}, ${scope.low.toFixed(0)} to ${scope.high.toFixed(0)} dBW`,
  ...places(model).map((mark) => `${mark.name}: ${length(mark.rangeM)}, ${bearing(mark.bearingDeg)}`)] : [];

export function table() {
  if (!scope?.last) return "";
  const all = [...new Set(scope.at)].filter(Boolean).sort((a, b) => a.azimuthDeg - b.azimuthDeg);
  const head = ["azimuth_deg", "heading_deg", "pulse", "time_s", "first_range_m", ...Array.from({ length: scope.last.codes.length }, (_, k) => `dbw_${(k * scope.cellM).toFixed(2)}_m_on`)];
  return csv([head, ...all.map((radial) => [radial.azimuthDeg.toFixed(3), radial.headingDeg.toFixed(3), radial.pulse, radial.timeS, (radial.startM + 0.5 * scope.cellM).toFixed(2),
    ...Array.from(radial.codes, (code) => code ? (radial.peakDbw - (MOST_CODE - code) * STEP_DB).toFixed(1) : "")])]);
}
