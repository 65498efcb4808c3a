// Colours of the theme, and those of levels (viridis: even steps for the eye, and legible without colour vision).

let cached = null;

/** The theme's colours by name. */
export function theme() {
  if (cached) return cached;
  const style = getComputedStyle(document.documentElement);
  const names = ["page", "panel", "text", "muted", "line", "grid", "true", "reported", "accent", "third", "good",
    "warn-line", "warn-text", "bad-back", "sea", "beam", "ship"];
  cached = Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
  return cached;
}

export function forget() {
  cached = null;
}

const VIRIDIS = [[68, 1, 84], [72, 36, 117], [65, 68, 135], [53, 95, 141], [42, 120, 142], [33, 145, 140],
  [34, 168, 132], [68, 191, 112], [122, 209, 81], [189, 223, 38], [253, 231, 37]];

/** 256 colours from low to high, as 32-bit pixels. */
export const PIXELS = Uint32Array.from({ length: 256 }, (_, step) => {
  const place = step / 255 * (VIRIDIS.length - 1);
  const low = Math.min(Math.floor(place), VIRIDIS.length - 2);
  const part = (of) => Math.round(VIRIDIS[low][of] + (place - low) * (VIRIDIS[low + 1][of] - VIRIDIS[low][of]));
  return (255 << 24 | part(2) << 16 | part(1) << 8 | part(0)) >>> 0;
});

/** The same as CSS colours. */
export const colour = (step) => {
  const pixel = PIXELS[Math.max(0, Math.min(255, Math.round(step * 255)))];
  return `rgb(${pixel & 255} ${pixel >> 8 & 255} ${pixel >> 16 & 255})`;
};

/** Rows of levels (0.01 dBW) as an image: `rows` gives levels and a shift in columns. */
export function image(columns, rows, low, high) {
  const pixels = new ImageData(columns, Math.max(1, rows.length));
  const out = new Uint32Array(pixels.data.buffer);
  const scale = 255 / (100 * (high - low));
  rows.forEach(({ levels, shift = 0 }, row) => {
    const at = row * columns;
    for (let column = 0; column < columns; column++) {
      const from = column - shift;
      if (from < 0 || from >= levels.length) continue;
      const step = (levels[from] - 100 * low) * scale;
      out[at + column] = PIXELS[step <= 0 ? 0 : step >= 255 ? 255 : step | 0];
    }
  });
  const canvas = new OffscreenCanvas(columns, pixels.height);
  canvas.getContext("2d").putImageData(pixels, 0, 0);
  return canvas;
}
