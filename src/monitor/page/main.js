// The page: what has come, and which panel shows it.

import { Connection } from "./socket.js";
import { forget } from "./colours.js";
import { clock, utc, whole } from "./format.js";
import * as health from "./health.js";
import * as ranges from "./ranges.js";
import * as doppler from "./doppler.js";
import * as plan from "./plan.js";
import * as ppi from "./ppi.js";
import * as errors from "./errors.js";
import * as control from "./control.js";
import * as save from "./save.js";
import * as keys from "./keys.js";

const id = (name) => document.getElementById(name);
const MOST_DELAYS = 600;
const FRAME_MS = 100;

const panels = { health, ranges, plan, control, doppler, errors, ppi };
const model = {
  about: null, status: null, now: null, map: null, epoch: null,
  history: [], changes: [], lines: [], delays: [], errors: [],
  channel: 0, columnS: 0, auto: true, low: -140, high: -80, markers: true, doppler: true,
  errorPlatform: 0, errorSpan: 0, chosen: false,
};
let paused = false;
let dirty = true;
let held = [];
let past = [];
/** Radials that came while the display was held: those of a turn. */
let missedRadials = null;
let link = "connecting";

const takers = {
  about(message) {
    model.about = message;
    Object.assign(model, { lines: [], history: [], delays: [], map: null, epoch: null });
    id("title").textContent = message.replayed ? `recording ${message.title}` : message.title;
    document.title = `${message.title} – nereus monitor`;
    id("fact-radar").textContent = `${(message.carrier_hz / 1e9).toFixed(2)} GHz, ${(message.bandwidth_hz / 1e6).toFixed(0)} MHz, ${message.prf_hz.toFixed(0)} Hz`;
    fill(id("channel"), message.channels.map((channel) => channel.name), model.channel);
    // Who moves is looked at first: usually the receiver.
    model.errorPlatform = Math.max(0, message.platforms.length - 1);
    fill(id("e-platform"), message.platforms, model.errorPlatform);
    connection.show({ ppi: ppi.about(model) });
    control.init(model, (change) => connection.send({ change }));
  },
  status(message) {
    model.status = message;
    model.changes = message.changes;
    // Who misreports is shown, until somebody chooses.
    const wrong = message.misreported.map((one) => model.about.platforms.indexOf(one.platform));
    if (!model.chosen && wrong.length && !wrong.includes(model.errorPlatform)) {
      id("e-platform").value = model.errorPlatform = wrong[0];
    }
    state();
  },
  now(message) {
    model.now = message;
    model.delays.push({ timeS: message.time_s, delays_s: message.delays_s, dopplers_hz: message.dopplers_hz });
    model.delays.splice(0, Math.max(0, model.delays.length - MOST_DELAYS));
  },
  history(message) {
    if (message.epoch !== model.epoch) model.history = [];
    model.epoch = message.epoch;
    model.history.length = Math.min(model.history.length, message.first);
    model.history.push(...message.points);
    model.errors = errors.distances(model);
  },
  lines: (message) => ranges.take(model, message),
  radials: (message) => ppi.take(message),
  map: (message) => { model.map = message; },
  answer: (message) => control.answer(message.text),
};

function fill(select, names, chosen) {
  select.replaceChildren(...names.map((name, place) => Object.assign(document.createElement("option"), { value: place, textContent: name })));
  select.value = chosen;
}

function take(message) {
  if (paused && message.kind !== "answer" && message.kind !== "about") {
    hold(message);
    return;
  }
  takers[message.kind]?.(message);
  dirty = true;
}

/** Keeps a message for later, in bounded memory: all of the history since it was last thinned, the latest of the rest. */
function hold(message) {
  if (message.kind === "history") {
    if (message.first === 0) past = [];
    past.push(message);
    return;
  }
  if (message.kind === "radials") {
    const all = [...(missedRadials?.radials ?? []), ...message.radials];
    missedRadials = { ...message, radials: all.slice(-(model.about?.ppi?.spokes ?? 0)) };
    return;
  }
  held.push(message);
  if (held.length > 3000) held = held.slice(-2000);
}

function state() {
  const chip = id("state");
  const lost = model.status?.losses?.length > 0;
  const ended = model.status?.ended || link === "closed";
  const text = paused ? "held" : link === "lost" ? "connection lost" : ended ? (model.about?.replayed ? "recording has ended" : "run has ended")
    : link === "connecting" ? "connecting" : model.about?.replayed ? "replay" : "live";
  if (chip.textContent !== text) chip.textContent = text;
  chip.className = `chip ${lost || link === "lost" ? "lost" : ended ? "ended" : link === "live" ? "live" : ""}`;
}

function facts() {
  const { status, now } = model;
  if (!status) return;
  const pulse = now?.pulse ?? status.pulse;
  id("fact-pulse").textContent = pulse === null ? "–" : whole(pulse);
  id("fact-time").textContent = now ? clock(now.time_s) : "–";
  id("fact-utc").textContent = utc(status.unix_ns);
}

let drawn = 0;
function frame(at) {
  requestAnimationFrame(frame);
  if (!dirty || at - drawn < FRAME_MS) return;
  drawn = at;
  dirty = false;
  facts();
  health.report(model);
  for (const panel of Object.values(panels)) {
    // What one panel cannot draw keeps no other from being drawn.
    try { panel.draw(model); } catch (error) { console.error(error); }
  }
}

const connection = new Connection(take, (now) => {
  link = now;
  state();
  dirty = true;
});
connection.show({ channel: 0, doppler: true });

function show(channel) {
  model.channel = channel;
  id("channel").value = channel;
  Object.assign(model, { lines: [], map: null, scaled: 0 });
  connection.show({ channel });
  dirty = true;
}

function pause() {
  paused = !paused;
  id("pause").setAttribute("aria-pressed", paused);
  id("pause").textContent = paused ? "Go on" : "Pause";
  if (!paused) {
    const missed = [...past, ...held, ...(missedRadials ? [missedRadials] : [])];
    [held, past, missedRadials] = [[], [], null];
    missed.forEach(take);
  }
  state();
}

function dress(name) {
  document.documentElement.dataset.theme = name;
  id("theme").textContent = name === "dark" ? "Light" : "Dark";
  forget();
  dirty = true;
}

const dark = matchMedia("(prefers-color-scheme: dark)");
const turn = () => dress(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
dress(dark.matches ? "dark" : "light");
dark.onchange = () => dress(dark.matches ? "dark" : "light");
id("theme").onclick = turn;
id("pause").onclick = pause;
id("channel").onchange = () => show(Number(id("channel").value));
id("db-auto").onchange = () => { model.auto = id("db-auto").checked; model.scaled = 0; dirty = true; };
for (const [name, key] of [["db-low", "low"], ["db-high", "high"]]) {
  id(name).oninput = () => {
    if (!Number.isFinite(id(name).valueAsNumber)) return;
    model[key] = id(name).valueAsNumber;
    model.auto = id("db-auto").checked = false;
    dirty = true;
  };
}
const marks = () => { model.markers = id("markers").checked; dirty = true; };
id("markers").onchange = marks;
id("doppler-on").onchange = () => {
  model.doppler = id("doppler-on").checked;
  connection.show({ doppler: model.doppler });
  dirty = true;
};
id("e-platform").onchange = () => { Object.assign(model, { errorPlatform: Number(id("e-platform").value), chosen: true }); dirty = true; };
id("e-span").onchange = () => { model.errorSpan = Number(id("e-span").value); dirty = true; };
plan.init(() => { dirty = true; });
ppi.init(() => { dirty = true; });
save.init(panels, model);
keys.init([
  ["p", "hold the display, and go on", pause],
  ["t", "light or dark", turn],
  ["c", "next channel", () => model.about && show((model.channel + 1) % model.about.channels.length)],
  ["h", "plan position: North or head up", ppi.turnOver],
  ["m", "targets on or off", () => { id("markers").checked = !model.markers; marks(); }],
]);
new ResizeObserver(() => { dirty = true; }).observe(id("panels"));
requestAnimationFrame(frame);
// For tests of the page: what it shows, and how.
window.nereus = { model, peak: (line) => ranges.peak(model, line), truthAt: (timeS) => ranges.truthAt(model, timeS),
  strongest: ppi.strongest, places: () => ppi.places(model) };
