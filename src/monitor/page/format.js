// Numbers and times as people read them.

/** 12,345 */
export const whole = (value) => (value ?? 0).toLocaleString("en-US");

/** A number to so many digits, without trailing noise. */
export function digits(value, count = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const places = Math.max(0, Math.min(6, count - 1 - Math.floor(Math.log10(Math.abs(value)))));
  return value.toFixed(places);
}

/** A duration: 350 us, 12.3 ms, 4.2 s, 3:05 min, 1:02:03 h. */
export function span(seconds) {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return "–";
  const size = Math.abs(seconds);
  if (size === 0) return "0 s";
  if (size < 1e-3) return `${digits(seconds * 1e6)} µs`;
  if (size < 1) return `${digits(seconds * 1e3)} ms`;
  if (size < 60) return `${digits(seconds)} s`;
  return clock(seconds);
}

/** 12.345 s, 3:05.2, 1:02:03. */
export function clock(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  if (Math.abs(seconds) < 60) return `${seconds.toFixed(2)} s`;
  const minutes = Math.floor(seconds / 60);
  const rest = (seconds - 60 * minutes).toFixed(1).padStart(4, "0");
  if (minutes < 60) return `${minutes}:${rest} min`;
  return `${Math.floor(minutes / 60)}:${String(minutes % 60).padStart(2, "0")}:${rest} h`;
}

/** Time of day in UTC of nanoseconds since 1970. */
export function utc(ns) {
  if (!Number.isFinite(ns)) return "–";
  const when = new Date(ns / 1e6);
  return Number.isFinite(when.getTime()) ? when.toISOString().slice(0, 21).replace("T", " ") : "–";
}

/** Rows of cells as CSV. */
export function csv(rows) {
  const cell = (value) => {
    const text = value === null || value === undefined ? "" : String(value);
    return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  return rows.map((row) => row.map(cell).join(",")).join("\n") + "\n";
}

/** What a platform misreports, in a line each. */
export function sentences(misreported, changes) {
  const platforms = [...new Set(misreported.map((one) => one.platform))];
  return platforms.map((platform) => {
    const parts = misreported.filter((one) => one.platform === platform).map((one) => part(one, changes));
    return `${platform} misreports ${parts.join("; ")}`;
  });
}

function part(one, changes) {
  const size = `${digits(one.error)} ${one.unit}`;
  const where = one.direction ? ` ${one.direction}` : " off";
  const since = one.since_pulse === null
    ? "since the start"
    : `since pulse ${whole(one.since_pulse)} (${clock(one.since_s)} into the run)`;
  const cause = one.cause ? `, by “${one.cause}”` : "";
  const later = changes.findLast((change) => change.platform === one.platform
    && change.text.includes(` ${one.quantity}.`) && change.pulse > (one.since_pulse ?? -1));
  const again = later ? `, changed at pulse ${whole(later.pulse)} by “${later.text}”` : "";
  return `its ${one.quantity}: ${size}${where}, ${since}${cause}${again}`;
}
