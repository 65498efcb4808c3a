// Binary messages of the monitor, little-endian: range lines, range-Doppler maps and radials.
// Head: kind u8, 0, channel u16, columns u16, rows u16, delay from a column to the next f64 (s).

const HEAD = 16;

/** A message as an object; levels are hundredths of a dBW, codes steps of 0.5 dB, of which 255 is the peak of the radial. */
export function decode(buffer) {
  const view = new DataView(buffer);
  const kind = view.getUint8(0);
  const [channel, columns, rows] = [2, 4, 6].map((at) => view.getUint16(at, true));
  const columnS = view.getFloat64(8, true);
  const real = (at) => view.getFloat64(at, true);
  const levels = (at, count) => new Int16Array(buffer.slice(at, at + 2 * count));
  if (kind === 1) {
    const size = 24 + 2 * columns;
    const lines = Array.from({ length: rows }, (_, row) => {
      const at = HEAD + row * size;
      return { pulse: real(at), timeS: real(at + 8), startS: real(at + 16), levels: levels(at + 24, columns) };
    });
    return { kind: "lines", channel, columns, columnS, lines };
  }
  if (kind === 3) {
    const radials = Array.from({ length: rows }, (_, row) => {
      const at = HEAD + row * (48 + columns);
      const [pulse, timeS, startS, azimuthDeg, headingDeg, peakDbw] = [0, 8, 16, 24, 32, 40].map((by) => real(at + by));
      return { pulse, timeS, startS, azimuthDeg, headingDeg, peakDbw, codes: new Uint8Array(buffer.slice(at + 48, at + 48 + columns)) };
    });
    return { kind: "radials", columns, cellS: columnS, radials };
  }
  return {
    kind: "map", channel, columns, rows, columnS,
    pulse: real(16), timeS: real(24), startS: real(32), spanHz: real(40), levels: levels(48, columns * rows),
  };
}
