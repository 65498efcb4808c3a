// Panel 3: where everything is, from above. East to the right, North up.

import { begin, empty, font, label, ticks, zoom as unit } from "./plot.js";
import { theme } from "./colours.js";
import { csv, digits } from "./format.js";

const id = (name) => document.getElementById(name);
const view = { centre: [0, 0], scale: 1 };
let fit = "all";

/** Lets the plan be moved by mouse and keys. */
export function init(redraw) {
  const canvas = id("c-plan");
  const choice = id("plan-fit");
  choice.onchange = () => { fit = choice.value; redraw(); };
  const free = () => { fit = choice.value = "free"; redraw(); };
  const zoom = (by, x, y) => {
    const [dx, dy] = [(x - canvas.clientWidth / 2) / unit(), (canvas.clientHeight / 2 - y) / unit()];
    view.centre[0] += dx / view.scale * (1 - 1 / by);
    view.centre[1] += dy / view.scale * (1 - 1 / by);
    view.scale *= by;
    free();
  };
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / 400), event.offsetX, event.offsetY);
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (!(event.buttons & 1)) return;
    view.centre[0] -= event.movementX / unit() / view.scale;
    view.centre[1] += event.movementY / unit() / view.scale;
    free();
  });
  canvas.addEventListener("keydown", (event) => {
    const step = 60 / view.scale;
    const moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] };
    const middle = [canvas.clientWidth / 2, canvas.clientHeight / 2];
    if (moves[event.key]) {
      view.centre = view.centre.map((value, axis) => value + moves[event.key][axis]);
      free();
    } else if (event.key === "+" || event.key === "=") zoom(1.3, ...middle);
    else if (event.key === "-") zoom(1 / 1.3, ...middle);
    else return;
    event.preventDefault();
  });
}

const finite = (point) => point && Number.isFinite(point[0]) && Number.isFinite(point[1]);

/** Platforms' paths from the history: true and reported, East and North. */
function paths(model) {
  return model.about.platforms.map((_, place) => {
    const at = 2 + 16 * place;
    return ["true", "reported"].map((_, kind) => model.history.map((row) => [row[at + 3 * kind], row[at + 3 * kind + 1]]).filter(finite));
  });
}

function patch(model) {
  const [size, centre] = [model.about.patch_m, model.now?.patch_centre_m];
  if (!size || !finite(centre)) return null;
  return [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) => [centre[0] + x * size[0] / 2, centre[1] + y * size[1] / 2]);
}

const targets = (model) => model.about.targets
  .filter((target) => target.position_m)
  .map(({ name, position_m: at, velocity_mps: speed }) => ({ name, at: [0, 1].map((axis) => at[axis] + speed[axis] * model.now.time_s) }));

function frame(model, { width, height }) {
  if (fit === "free" && view.scale > 0) return;
  const now = model.now;
  const sea = [...(patch(model) ?? []), ...now.antennas.flatMap((antenna) => antenna.middle_m ? [antenna.middle_m] : []),
    ...now.ships.map((ship) => ship.position_m), ...targets(model).map((target) => target.at)].filter(finite);
  const all = [...sea, ...paths(model).flat(2), ...now.platforms.flatMap((one) => [one.true_m, one.reported_m])].filter(finite);
  const points = fit === "sea" && sea.length ? sea : all;
  if (!points.length) return;
  const range = [0, 1].map((axis) => points.reduce(([low, high], point) => [Math.min(low, point[axis]), Math.max(high, point[axis])], [Infinity, -Infinity]));
  view.centre = range.map(([low, high]) => (low + high) / 2);
  const size = range.map(([low, high]) => Math.max(high - low, 50));
  view.scale = Math.min((width - 130) / size[0], (height - 110) / size[1]);
}

export function draw(model) {
  const canvas = id("c-plan");
  const drawn = begin(canvas);
  if (!drawn || !model.about) return;
  if (!model.now) return empty(drawn, "waiting for the first pulse");
  frame(model, drawn);
  const { ctx, width, height } = drawn;
  const at = (point) => [width / 2 + (point[0] - view.centre[0]) * view.scale, height / 2 - (point[1] - view.centre[1]) * view.scale];
  const reach = [width, height].map((side, axis) => [view.centre[axis] - side / 2 / view.scale, view.centre[axis] + side / 2 / view.scale]);
  grid(ctx, reach, at, width, height);
  const colours = theme();
  const shape = (points, fill, stroke) => {
    ctx.beginPath();
    points.forEach((point) => ctx.lineTo(...at(point)));
    ctx.closePath();
    if (fill) { ctx.fillStyle = fill; ctx.fill(); }
    if (stroke) { ctx.strokeStyle = stroke; ctx.stroke(); }
  };
  const names = [];
  const sea = patch(model);
  ctx.lineWidth = 1.2;
  if (sea) {
    shape(sea, colours.sea, colours.accent);
    names.push({ text: "sea", at: at(sea[3]), ink: colours.muted, low: true });
  }
  for (const slick of model.about.slicks) shape(slick.outline_m, null, colours.muted);
  footprints(model, ctx, shape, at, names);
  for (const { name, at: place } of targets(model)) {
    const [x, y] = at(place);
    ctx.strokeStyle = colours.third;
    ctx.lineWidth = 1.8;
    ctx.beginPath();
    for (const [dx, dy] of [[5, 0], [0, 5]]) { ctx.moveTo(x - dx, y - dy); ctx.lineTo(x + dx, y + dy); }
    ctx.stroke();
    names.push({ text: name, at: [x, y], ink: colours.third });
  }
  ships(model, ctx, at, names);
  platforms(model, ctx, at, names);
  write(ctx, names, width, height);
  north(ctx, width);
  scaleBar(ctx, width, height);
  legend(ctx, height, model.about.truth);
  const misreported = model.status?.misreported ?? [];
  canvas.setAttribute("aria-label", `Plan view: ${model.now.platforms.map((one, place) => `${model.about.platforms[place]} at ${whereabouts(model, one)}`).join("; ")}${misreported.length ? `; ${misreported.map((one) => one.platform).join(", ")} misreport` : ""}`);
}

/** Where a platform is: truly, or as reported where the truth is not known. */
function whereabouts(model, one) {
  const [east, north] = model.about.truth ? one.true_m : one.reported_m;
  return `${digits(east, 1)} m East, ${digits(north, 1)} m North`;
}

function grid(ctx, reach, at, width, height) {
  const colours = theme();
  const kilometres = reach[0][1] - reach[0][0] > 8000;
  const unit = kilometres ? 1000 : 1;
  font(ctx, 11);
  ctx.strokeStyle = colours.grid;
  ctx.lineWidth = 1;
  ctx.beginPath();
  const rows = [0, 1].map((axis) => ticks(reach[axis][0] / unit, reach[axis][1] / unit, (axis ? height : width) / 105));
  for (const value of rows[0]) { const [x] = at([value * unit, 0]); ctx.moveTo(x, 0); ctx.lineTo(x, height); }
  for (const value of rows[1]) { const [, y] = at([0, value * unit]); ctx.moveTo(0, y); ctx.lineTo(width, y); }
  ctx.stroke();
  ctx.fillStyle = colours.muted;
  ctx.textBaseline = "bottom";
  ctx.textAlign = "left";
  const text = (value) => `${digits(value, 4).replace(/\.0+$/, "").replace("-", "−")}`;
  for (const value of rows[0]) { const [x] = at([value * unit, 0]); if (x > 70 && x < width - 70) ctx.fillText(text(value), x + 3, height - 2); }
  for (const value of rows[1]) { const [, y] = at([0, value * unit]); if (y > 40 && y < height - 62) ctx.fillText(text(value), 3, y - 1); }
  ctx.textAlign = "right";
  ctx.fillText(`East, ${kilometres ? "km" : "m"}`, width - 6, height - 2);
  ctx.textAlign = "left";
  ctx.textBaseline = "top";
  ctx.fillText(`North, ${kilometres ? "km" : "m"}`, 4, 4);
}

function footprints(model, ctx, shape, at, names) {
  const colours = theme();
  model.now.antennas.forEach((antenna, place) => {
    if (!antenna.outline_m.length) return;
    ctx.globalAlpha = 0.16;
    shape(antenna.outline_m, colours.beam, null);
    ctx.globalAlpha = 0.9;
    ctx.lineWidth = 1.2;
    ctx.setLineDash(model.about.antennas[place].kind === "transmitter" ? [] : [5, 3]);
    shape(antenna.outline_m, null, colours.beam);
    ctx.setLineDash([2, 5]);
    ctx.beginPath();
    ctx.moveTo(...at(antenna.position_m));
    ctx.lineTo(...at(antenna.middle_m));
    ctx.stroke();
    ctx.setLineDash([]);
    ctx.globalAlpha = 1;
    names.push({ text: `beam of ${model.about.antennas[place].name}`, at: at(antenna.middle_m), ink: colours.beam, low: true });
  });
}

function ships(model, ctx, at, names) {
  const colours = theme();
  model.now.ships.forEach((ship, place) => {
    const { name, length_m: length } = model.about.ships[place];
    const [x, y] = at(ship.position_m);
    const half = Math.max(9, (length ?? 0) * view.scale / 2);
    ctx.save();
    ctx.translate(x, y);
    ctx.rotate(ship.heading_deg * Math.PI / 180);
    ctx.beginPath();
    ctx.moveTo(0, -half);
    ctx.quadraticCurveTo(half * 0.24, -half * 0.55, half * 0.2, half);
    ctx.lineTo(-half * 0.2, half);
    ctx.quadraticCurveTo(-half * 0.24, -half * 0.55, 0, -half);
    ctx.fillStyle = colours.ship;
    ctx.fill();
    ctx.restore();
    names.push({ text: name, at: [x, y], ink: colours.ship });
  });
}

function platforms(model, ctx, at, names) {
  const colours = theme();
  const all = paths(model);
  const trace = (points, stroke, dash, thick) => {
    ctx.beginPath();
    points.forEach((point) => ctx.lineTo(...at(point)));
    ctx.strokeStyle = stroke;
    ctx.setLineDash(dash);
    ctx.lineWidth = thick;
    ctx.stroke();
    ctx.setLineDash([]);
  };
  model.now.platforms.forEach((one, place) => {
    const [truth, reported] = all[place];
    if (model.about.truth) trace(truth, colours.true, [], 3);
    trace(reported, colours.reported, [6, 5], 1.8);
    const wrong = (model.status?.misreported ?? []).find((of) => of.platform === model.about.platforms[place] && of.quantity === "position");
    const known = model.about.truth ? one.true_m : one.reported_m;
    if (!finite(known)) return;
    const [x, y] = at(known);
    if (finite(one.reported_m)) {
      const [rx, ry] = at(one.reported_m);
      trace([known, one.reported_m], colours.reported, [], 2);
      ctx.strokeStyle = colours.reported;
      ctx.lineWidth = 2;
      ctx.strokeRect(rx - 6.5, ry - 6.5, 13, 13);
    }
    if (model.about.truth) {
      ctx.beginPath();
      ctx.arc(x, y, 5, 0, 2 * Math.PI);
      ctx.fillStyle = colours.true;
      ctx.fill();
    }
    const [u, v] = one.velocity_mps;
    const speed = Math.hypot(u, v);
    if (speed > 0.5) {
      ctx.beginPath();
      ctx.moveTo(x + 9 * u / speed, y - 9 * v / speed);
      ctx.lineTo(x + 26 * u / speed, y - 26 * v / speed);
      ctx.strokeStyle = colours.true;
      ctx.lineWidth = 2.5;
      ctx.stroke();
    }
    const off = wrong ? `: reported ${digits(wrong.error)} m ${wrong.direction ?? "off"}` : "";
    names.push({ text: model.about.platforms[place] + off, at: [x, y], ink: wrong ? colours.reported : colours.true, bold: true });
  });
}

/** Names beside their places, without hiding one another where that can be. */
function write(ctx, names, width, height) {
  // Marks of platforms stay in sight, and so do those of targets from the names of others.
  const taken = names.filter((one) => one.bold || !one.low).map(({ at: [x, y], bold }) => bold ? { x: x - 8, y: y - 8, w: 16, h: 16 } : { x: x - 5, y: y - 5, w: 10, h: 10 });
  // And so do the arrow to the North, the legend and the scale.
  taken.push({ x: width - 46, y: 4, w: 44, h: 50 }, { x: 0, y: height - 56, w: 145, h: 38 }, { x: width - 165, y: height - 52, w: 165, h: 52 });
  const free = (box) => taken.every((other) => box.x > other.x + other.w || other.x > box.x + box.w || box.y > other.y + other.h || other.y > box.y + box.h);
  names.sort((a, b) => (b.bold ? 2 : b.low ? 0 : 1) - (a.bold ? 2 : a.low ? 0 : 1));
  for (const { text, at: [x, y], ink, bold } of names) {
    if (x < -20 || x > width + 20 || y < -20 || y > height + 20) continue;
    font(ctx, bold ? 13 : 12, bold ? 650 : 400);
    const wide = ctx.measureText(text).width;
    const places = [[11, 0], [11, -17], [11, 17], [-wide - 11, 0], [-wide / 2, -20], [-wide / 2, 21], [-wide / 2, -38], [-wide / 2, 39], [11, 34], [-wide - 11, 20], [-wide - 11, -20]];
    const boxes = places.map(([dx, dy]) => ({ x: Math.max(4, Math.min(width - wide - 4, x + dx)), y: y + dy - 8, w: wide + 6, h: 16 }));
    const box = boxes.find(free) ?? (bold ? boxes[5] : null);
    if (!box) continue;
    taken.push(box);
    label(ctx, text, box.x, box.y + 8, { ink });
  }
}

function north(ctx, width) {
  const colours = theme();
  const [x, y] = [width - 24, 40];
  ctx.fillStyle = colours.text;
  ctx.beginPath();
  ctx.moveTo(x, y - 16);
  ctx.lineTo(x + 7, y + 8);
  ctx.lineTo(x, y + 3);
  ctx.lineTo(x - 7, y + 8);
  ctx.fill();
  font(ctx, 13, 650);
  ctx.textAlign = "center";
  ctx.textBaseline = "alphabetic";
  ctx.fillText("N", x, y - 20);
}

function scaleBar(ctx, width, height) {
  const most = 130 / view.scale;
  const power = 10 ** Math.floor(Math.log10(most));
  const length = [5, 2, 1].map((part) => part * power).find((size) => size <= most);
  const wide = length * view.scale;
  const [x, y] = [width - 16 - wide, height - 26];
  ctx.strokeStyle = ctx.fillStyle = theme().text;
  ctx.lineWidth = 2;
  ctx.beginPath();
  for (const [dx, dy] of [[0, -5], [0, 0], [wide, 0], [wide, -5]]) ctx.lineTo(x + dx, y + dy);
  ctx.stroke();
  font(ctx, 12, 600);
  ctx.textAlign = "center";
  ctx.textBaseline = "bottom";
  ctx.fillText(length >= 1000 ? `${length / 1000} km` : `${length} m`, x + wide / 2, y - 4);
}

function legend(ctx, height, truth) {
  const colours = theme();
  font(ctx, 12);
  [["true path", colours.true, [], 3], ["reported path", colours.reported, [6, 5], 1.8]].slice(truth ? 0 : 1).forEach(([text, stroke, dash, thick], row) => {
    const y = height - 44 + 17 * row;
    ctx.strokeStyle = stroke;
    ctx.lineWidth = thick;
    ctx.setLineDash(dash);
    ctx.beginPath();
    ctx.moveTo(8, y);
    ctx.lineTo(34, y);
    ctx.stroke();
    ctx.setLineDash([]);
    label(ctx, text, 41, y);
  });
}

export const canvases = () => [id("c-plan")];

export function table(model) {
  const names = model.about.platforms.flatMap((name) => ["true", "reported"].flatMap((kind) => ["east", "north", "up"].map((axis) => `${name}_${kind}_${axis}_m`)));
  return csv([["pulse", "time_s", ...names], ...model.history.map((row) => [row[0], row[1],
    ...model.about.platforms.flatMap((_, place) => row.slice(2 + 16 * place, 8 + 16 * place))])]);
}
