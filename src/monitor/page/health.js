// Panel 1: is it on time, is anything lost?

import { begin, empty, font } from "./plot.js";
import { theme } from "./colours.js";
import { csv, digits, sentences, span, whole } from "./format.js";

const id = (name) => document.getElementById(name);
const SHORT = ["1 µs", "10 µs", "100 µs", "1 ms", "10 ms", "100 ms", "1 s", "10 s"];

function rows(table, lines) {
  const body = id(table).tBodies[0];
  body.replaceChildren(...lines.map((cells) => {
    const row = document.createElement("tr");
    row.append(...cells.map((cell) => {
      const data = document.createElement("td");
      data.textContent = cell.text ?? cell;
      if (cell.kind) data.className = cell.kind;
      return data;
    }));
    return row;
  }));
}

function banner(name, lines) {
  const box = id(name);
  box.hidden = lines.length === 0;
  const text = lines.join("\n");
  if (box.dataset.text === text) return;
  box.dataset.text = text;
  box.replaceChildren(...lines.map((line) => Object.assign(document.createElement("p"), { textContent: line })));
}

const lost = (loss) => `Lost: ${whole(loss.pulses)} ${loss.pulses === 1 ? "pulse" : "pulses"}, ${loss.what}: `
  + `since pulse ${whole(loss.since_pulse)}, ${span(loss.since_s)} after the begin`
  + (loss.last_s > loss.since_s ? `, most recently at ${span(loss.last_s)}` : "");

/** Everything of the status that is text. */
export function report(model) {
  const { status, about, errors } = model;
  if (!status || !about) return;
  id("t-released").textContent = whole(status.released);
  id("t-late").textContent = whole(status.late);
  id("tile-late").className = status.late > 0 ? "tile warn" : "tile";
  id("t-dropped").textContent = whole(status.dropped);
  id("tile-dropped").className = status.dropped > 0 ? "tile bad" : "tile";
  id("t-speed").textContent = about.replayed ? "–" : digits(status.real_time_factor, status.real_time_factor < 1 ? 2 : 3);
  const done = status.released + status.dropped;
  id("m-run").value = about.total ? done / about.total : 0;
  id("o-run").textContent = about.total ? `${(100 * done / about.total).toFixed(0)} %` : "";
  id("m-ring").value = status.ring.slots ? status.ring.filled / status.ring.slots : 0;
  id("o-ring").textContent = status.ring.slots ? `${status.ring.filled} of ${status.ring.slots}` : "–";
  rows("sinks", status.sinks.map((sink) => [sink.name, whole(sink.written), `${sink.queue} of ${sink.queue_slots}`,
    { text: whole(sink.dropped), kind: sink.dropped ? "bad" : "" }]));
  id("sinks").hidden = status.sinks.length === 0;
  rows("ages", status.navigation.map((of, place) => {
    const error = errors?.[place];
    const wrong = status.misreported.some((one) => one.platform === of.platform && one.quantity === "position");
    const off = error === undefined || !Number.isFinite(error) ? "–" : `${digits(error)} m`;
    return [of.platform, of.report_age_s === null ? "–" : span(of.report_age_s), { text: off, kind: wrong ? "warn" : "" }];
  }));
  const notes = [];
  if (status.monitor.not_shown) notes.push(`${whole(status.monitor.not_shown)} pulses not shown here: the monitor took none of the stream's time for them`);
  if (status.extrapolated) notes.push(`navigation extrapolated for ${whole(status.extrapolated)} pulses, stale for ${whole(status.stale)}`);
  if (status.by_class?.length) notes.push(`now at ${digits(status.error_db)} dB; ${status.by_class.map((of) => `${whole(of.pulses)} pulses at ${digits(of.error_db)} dB`).join(", ")}`);
  if (status.slipped_s > 0) notes.push(`schedule moved by ${span(status.slipped_s)}`);
  id("not-shown").textContent = notes.join("; ");
  banner("losses", status.losses.map(lost));
  banner("misreports", sentences(status.misreported, status.changes));
}

/** Share of releases by lateness. */
export function draw(model) {
  const canvas = id("c-lateness");
  const view = begin(canvas);
  if (!view || !model.status) return;
  const { ctx, width, height } = view;
  const colours = theme();
  const { pulses, bounds_ns: bounds } = model.status.lateness;
  const total = pulses.reduce((sum, count) => sum + count, 0);
  if (total === 0) return empty(view, model.about?.replayed ? "a recording has no lateness" : "no deadlines: pulses are released as they are made");
  font(ctx, 11.5);
  const box = { x: 32, y: 20, w: width - 36, h: height - 36 };
  const each = box.w / pulses.length;
  // Late is what is released more than one PRI after its deadline.
  const pri = 1e9 / model.about.prf_hz;
  // Logarithmic: one late pulse in a million is seen.
  const most = Math.log10(total + 1);
  ctx.textAlign = "right";
  ctx.textBaseline = "middle";
  for (let power = Math.floor(most); power >= 0; power -= Math.max(1, Math.ceil(most / (box.h / 15)))) {
    const y = Math.round(box.y + box.h * (1 - Math.log10(10 ** power + 1) / most)) + 0.5;
    ctx.fillStyle = colours.grid;
    ctx.fillRect(box.x, y, box.w, 1);
    ctx.fillStyle = colours.muted;
    ctx.fillText(power < 3 ? 10 ** power : power < 6 ? `${10 ** (power - 3)}k` : `${10 ** (power - 6)}M`, box.x - 4, y);
  }
  pulses.forEach((count, bucket) => {
    if (count === 0) return;
    const tall = Math.max(2, box.h * Math.log10(count + 1) / most);
    ctx.fillStyle = (bounds[bucket - 1] ?? 0) < pri ? colours.accent : colours.reported;
    ctx.fillRect(box.x + bucket * each + 1, box.y + box.h - tall, Math.max(1, each - 2), tall);
  });
  ctx.fillStyle = colours.line;
  ctx.fillRect(box.x, box.y + box.h, box.w, 1);
  ctx.fillStyle = colours.muted;
  ctx.textBaseline = "top";
  ctx.textAlign = "center";
  SHORT.forEach((text, decade) => {
    const x = box.x + (3 * decade + 1) * each;
    if (decade % 2 === 1 || each * 3 > 52) ctx.fillText(text, Math.min(x, width - 18), box.y + box.h + 3);
  });
  const [half, most99] = [0.5, 0.99].map((part) => quantile(pulses, bounds, total, part));
  ctx.fillStyle = colours.text;
  ctx.textAlign = "left";
  ctx.textBaseline = "alphabetic";
  const text = `lateness of pulses: half ≤ ${round(half)}, 99 % ≤ ${round(most99)}`;
  ctx.fillText(text, 4, 12);
  line(ctx, box, each, bounds, pri);
  canvas.setAttribute("aria-label", `${text}, of ${whole(total)} releases`);
}

/** Where lateness begins to count as late. */
function line(ctx, box, each, bounds, pri) {
  const bucket = bounds.findIndex((bound) => bound >= pri);
  if (bucket < 1) return;
  const share = Math.log(pri / bounds[bucket - 1]) / Math.log(bounds[bucket] / bounds[bucket - 1]);
  const x = Math.round(box.x + (bucket + share) * each) + 0.5;
  ctx.strokeStyle = ctx.fillStyle = theme().reported;
  ctx.setLineDash([3, 3]);
  ctx.beginPath();
  ctx.moveTo(x, box.y);
  ctx.lineTo(x, box.y + box.h);
  ctx.stroke();
  ctx.setLineDash([]);
  ctx.fillText("late", x + 4, box.y + 10);
}

/** A bound: 1, 2 or 5 of a decade. */
const round = (seconds) => span(seconds).replace(/\.0+(?= )/, "");

function quantile(pulses, bounds, total, part) {
  let sum = 0;
  for (let bucket = 0; bucket < pulses.length; bucket++) {
    sum += pulses[bucket];
    if (sum >= part * total) return bucket < bounds.length ? bounds[bucket] * 1e-9 : Infinity;
  }
  return Infinity;
}

export const canvases = () => [id("c-lateness")];

/** The figures as lines, for the picture. */
export function lines({ status }) {
  if (!status) return [];
  return [`released ${whole(status.released)}, late ${whole(status.late)}, dropped ${whole(status.dropped)}`,
    `computed at ${digits(status.real_time_factor)} times real time; ready ${status.ring.filled} of ${status.ring.slots}`,
    ...status.sinks.map((sink) => `sink ${sink.name}: taken ${whole(sink.written)}, queue ${sink.queue} of ${sink.queue_slots}, lost ${whole(sink.dropped)}`),
    ...sentences(status.misreported, status.changes)];
}

export function table({ status }) {
  if (!status) return "";
  const { bounds_ns: bounds, pulses } = status.lateness;
  const single = ["released", "late", "dropped", "made", "real_time_factor", "extrapolated", "stale", "slipped_s"];
  return csv([["quantity", "of", "value"], ...single.map((name) => [name, "", status[name]]),
    ["ring_filled", "", status.ring.filled], ["ring_slots", "", status.ring.slots],
    ...status.sinks.flatMap((sink) => ["written", "dropped", "queue"].map((name) => [`sink_${name}`, sink.name, sink[name]])),
    ...status.navigation.map((of) => ["report_age_s", of.platform, of.report_age_s]),
    ...(status.by_class ?? []).map((of) => ["released_at_error_db", of.error_db, of.pulses]),
    ...pulses.map((count, bucket) => ["released_within_ns", bounds[bucket] ?? "more", count])]);
}
