// Panel 5: inject errors of navigation (docs/control.md), and the log of changes.

import { csv, whole } from "./format.js";
import { timeOf } from "./errors.js";

const id = (name) => document.getElementById(name);
const AXES = { position: ["east", "north", "up"], velocity: ["east", "north", "up"], attitude: ["roll", "pitch", "heading"] };
const UNITS = { position: ["m", "m/s"], velocity: ["m/s", "m/s^2"], attitude: ["deg", "deg/s"] };
const KINDS = [["step", "step: add"], ["bias", "bias: set"], ["ramp", "ramp: grow"], ["dropout", "dropout: silence"],
  ["latency", "latency: late"], ["clear", "clear: undo all"]];

function options(select, all) {
  select.replaceChildren(...all.map(([value, text]) => Object.assign(document.createElement("option"), { value, textContent: text ?? value })));
}

/** The line that the form stands for. */
function line() {
  const [kind, axis, value] = ["i-kind", "i-axis", "i-value"].map((name) => id(name).value);
  const on = ` on ${id("i-platform").value}`;
  const unit = id("i-unit").textContent;
  if (kind === "clear") return kind + on;
  if (kind === "dropout" || kind === "latency") return `${kind} ${value} ${unit}${on}`;
  return `${kind} ${axis} ${value} ${unit}${on}`;
}

function changed() {
  const kind = id("i-kind").value;
  const ofAxis = ["step", "bias", "ramp"].includes(kind);
  const [quantity] = id("i-axis").value.split(".");
  id("l-axis").hidden = !ofAxis;
  id("l-value").hidden = kind === "clear";
  id("i-unit").textContent = ofAxis ? UNITS[quantity][kind === "ramp" ? 1 : 0] : kind === "dropout" ? "s" : "ms";
  id("i-line").textContent = line();
  id("i-send").disabled = kind !== "clear" && (id("i-value").value === "" || !id("i-value").checkValidity());
}

/** Fills the form; `send` takes a change. */
export function init(model, send) {
  id("inject").hidden = !model.about.control;
  options(id("i-platform"), model.about.platforms.map((name) => [name]));
  id("i-platform").selectedIndex = model.about.platforms.length - 1;
  options(id("i-kind"), KINDS);
  options(id("i-axis"), Object.entries(AXES).flatMap(([quantity, axes]) => axes.map((axis) => [`${quantity}.${axis}`])));
  id("i-axis").value = "position.up";
  if (!model.about.control) {
    answer(model.about.replayed ? "A recording cannot be changed; its log is below."
      : "Start the run with --monitor-control to inject errors from here.");
  }
  const form = id("inject");
  form.oninput = changed;
  form.onsubmit = (event) => {
    event.preventDefault();
    answer("asked …");
    send(line());
  };
  changed();
}

/** Shows what the run answers. */
export function answer(text) {
  const box = id("answer");
  const taken = /^ok pulse (\d+) (.*)$/.exec(text);
  box.className = taken ? "note good" : text.startsWith("error") ? "note bad" : "note";
  box.textContent = taken ? `Taken: ${taken[2]}, from pulse ${whole(Number(taken[1]))} on` : text.replace(/^error /, "Refused: ");
}

/** The log, the latest change first. */
export function draw(model) {
  if (!model.about) return;
  const now = model.now?.pulse ?? -1;
  const key = JSON.stringify([model.changes.length, model.changes.filter((one) => one.pulse > now).length]);
  if (draw.key === key) return;
  draw.key = key;
  id("log-empty").hidden = model.changes.length > 0;
  id("log").hidden = model.changes.length === 0;
  id("log").tBodies[0].replaceChildren(...model.changes.toReversed().map((one) => {
    const row = document.createElement("tr");
    const cells = [`${whole(one.pulse)} (${timeOf(model, one).toFixed(2)} s)`, one.platform, one.text, one.source === "control" ? "hand" : "scenario"];
    row.append(...cells.map((text) => Object.assign(document.createElement("td"), { textContent: text, className: one.pulse > now ? "future" : "" })));
    return row;
  }));
}

export const canvases = () => [];

export const lines = (model) => model.changes.map((one) => `from pulse ${whole(one.pulse)}: ${one.text} on ${one.platform} (${one.source})`);

export const table = (model) => csv([["pulse", "time_ns", "platform", "change", "source"],
  ...model.changes.map((one) => [one.pulse, one.time_ns, one.platform, one.text, one.source])]);
