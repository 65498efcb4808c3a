// A picture or a table of any panel.

import { font, zoom } from "./plot.js";
import { theme } from "./colours.js";

function keep(blob, name) {
  const address = URL.createObjectURL(blob);
  const link = Object.assign(document.createElement("a"), { href: address, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

/** Title, lines of text and the panel's plots, one below the other. */
export function picture(title, lines, canvases) {
  const scale = zoom() * (window.devicePixelRatio || 1);
  const size = (canvas) => [canvas.width / scale, canvas.height / scale];
  const shown = canvases.filter((canvas) => canvas.clientWidth > 0);
  const width = Math.max(560, ...shown.map((canvas) => size(canvas)[0])) + 24;
  const head = 44 + 20 * lines.length;
  const height = head + shown.reduce((sum, canvas) => sum + size(canvas)[1] + 4, 0) + 12;
  const sheet = Object.assign(document.createElement("canvas"), { width: Math.round(width * scale), height: Math.round(height * scale) });
  const ctx = sheet.getContext("2d");
  ctx.scale(scale, scale);
  ctx.fillStyle = theme().panel;
  ctx.fillRect(0, 0, width, height);
  ctx.fillStyle = theme().text;
  font(ctx, 16, 650);
  ctx.fillText(title, 14, 27);
  font(ctx, 13);
  lines.forEach((text, row) => ctx.fillText(text, 14, 50 + 20 * row));
  let y = head;
  for (const canvas of shown) {
    ctx.drawImage(canvas, 12, y, ...size(canvas));
    y += size(canvas)[1] + 4;
  }
  return sheet;
}

/** Puts the two buttons into every panel. */
export function init(panels, model) {
  for (const place of document.querySelectorAll(".save")) {
    const name = place.dataset.panel;
    const panel = panels[name];
    const heading = document.querySelector(`#p-${name} h2`).textContent;
    const file = (end) => `nereus-${name}-${model.now?.pulse ?? 0}.${end}`;
    const button = (text, help, act) => {
      const made = Object.assign(document.createElement("button"), { type: "button", textContent: text, title: help, onclick: act });
      made.setAttribute("aria-label", `${heading}: ${help}`);
      return made;
    };
    place.append(
      button("PNG", "save a picture", () => {
        const title = `${heading}: ${model.about?.title ?? ""}, pulse ${model.now?.pulse ?? "–"}`;
        picture(title, panel.lines?.(model) ?? [], panel.canvases()).toBlob((blob) => keep(blob, file("png")));
      }),
      button("CSV", "save the values", () => keep(new Blob([panel.table(model)], { type: "text/csv" }), file("csv"))),
    );
  }
}
