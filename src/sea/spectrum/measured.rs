//! A measured 2-D spectrum from a CSV file.
//!
//! Header `kx_rad_m,ky_rad_m,psi_m4`, then one row for every node of a rectangular grid of even steps, in any
//! order: K in the direction of travel, scene axes, rad/m; `Psi >= 0`, m^4, wave convention (for an image
//! spectrum give half the density at K and at -K). Blank lines and lines that begin with `#` are skipped.
//! Between nodes Psi is bilinear, outside the grid zero: [`tail`](super::tail) has what the wind adds beyond
//! the file. All faults of a file are reported at once, with their lines.
//!
//! Limits: 2 x 2 to 4 194 304 nodes; 512 MiB.
//!
//! ```
//! use nereus::sea::spectrum::{Measured, Spectrum, WaveVector};
//! let sea = Measured::parse(b"kx_rad_m,ky_rad_m,psi_m4\n0,0,0\n0,1,0\n1,0,4\n1,1,2\n")?;
//! assert_eq!(sea.wave_m4(WaveVector::new(1.0, 0.5)), 3.0);
//! let error = Measured::parse(b"kx_rad_m,ky_rad_m,psi_m4\n0,0,-1\n").unwrap_err();
//! assert!(error.to_string().contains("line 2"));
//! # Ok::<(), nereus::sea::spectrum::measured::MeasuredError>(())
//! ```

use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};

use super::{Spectrum, WaveVector, cells, in_range};
use crate::inputs;

/// Most nodes of a grid.
pub const MAX_NODES: usize = 1 << 22;
/// Longest file that is read, bytes.
pub const MAX_BYTES: u64 = 512 << 20;
/// Faults that are listed; the rest are counted.
const LISTED: usize = 50;
/// Largest density, m^4: far beyond any sea, and far from overflow.
const MAX_PSI_M4: f64 = 1e12;
const HEADER: &str = "kx_rad_m,ky_rad_m,psi_m4";

/// Why a measured spectrum cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeasuredError {
    /// The file cannot be read.
    #[error("measured spectrum {}: cannot be read: {}", path.display(), inputs::reason(*kind))]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        kind: std::io::ErrorKind,
    },
    /// The file has faults.
    #[error("measured spectrum {}: {faults}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        faults: Faults,
    },
    /// The text has faults.
    #[error("measured spectrum: {0}")]
    Text(Faults),
}

/// The faults of a file, in the order of lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Faults {
    /// The first faults.
    pub listed: Vec<Fault>,
    /// Faults in all.
    pub count: usize,
}

impl Faults {
    fn push(&mut self, line: usize, what: What) {
        self.count += 1;
        if self.listed.len() < LISTED {
            self.listed.push(Fault { line, what });
        }
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, fault) in self.listed.iter().enumerate() {
            let comma = if i == 0 { "" } else { "; " };
            write!(f, "{comma}line {}: {}", fault.line, fault.what)?;
        }
        match self.count - self.listed.len() {
            0 => Ok(()),
            more => write!(f, "; and {more} more"),
        }
    }
}

/// One fault.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Line, from 1 (the last one for what is missing).
    pub line: usize,
    /// What is wrong there.
    pub what: What,
}

/// What may be wrong in a file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum What {
    /// Longer than allowed.
    #[error("more than {MAX_BYTES} bytes")]
    Long,
    /// Not text.
    #[error("not UTF-8 text")]
    Encoding,
    /// No or another header.
    #[error("the header must be `{HEADER}`")]
    Header,
    /// Too few or too many fields.
    #[error("{found} fields where 3 are needed")]
    Fields {
        /// Fields found.
        found: usize,
    },
    /// Not a finite number.
    #[error("{column} is not a finite number")]
    Number {
        /// The column.
        column: &'static str,
    },
    /// Psi below zero.
    #[error("psi_m4 is {value}: it must not be negative")]
    Negative {
        /// The value.
        value: f64,
    },
    /// A wave number or a density too large.
    #[error("{column} is {value}: at most {largest} is allowed")]
    Range {
        /// The column.
        column: &'static str,
        /// The value.
        value: f64,
        /// Largest allowed.
        largest: f64,
    },
    /// Too many rows.
    #[error("more than {MAX_NODES} nodes")]
    TooMany,
    /// The node was already given.
    #[error("the node ({kx}, {ky}) is already on line {first}")]
    Twice {
        /// Its Kx, rad/m.
        kx: f64,
        /// Its Ky, rad/m.
        ky: f64,
        /// Where it was given first.
        first: usize,
    },
    /// Fewer than two values along an axis.
    #[error("{column} has {found} values: a grid needs 2 or more")]
    Flat {
        /// The column.
        column: &'static str,
        /// Distinct values found.
        found: usize,
    },
    /// Steps along an axis differ.
    #[error("{column} = {value} is not on the even steps of {step} that the grid has elsewhere")]
    Uneven {
        /// The column.
        column: &'static str,
        /// The value that is off.
        value: f64,
        /// The step, rad/m.
        step: f64,
    },
    /// A node is missing.
    #[error("the node ({kx}, {ky}) is missing")]
    Missing {
        /// Its Kx, rad/m.
        kx: f64,
        /// Its Ky, rad/m.
        ky: f64,
    },
}

/// One axis of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis {
    first: f64,
    step: f64,
    count: usize,
}

impl Axis {
    /// Its end farther from zero, rad/m.
    fn furthest(self) -> f64 {
        self.first.abs().max((self.first + (self.count - 1) as f64 * self.step).abs())
    }

    /// Node below a value, and how far to the next, 0 to 1.
    fn locate(self, value: f64) -> Option<(usize, f64)> {
        let position = (value - self.first) / self.step;
        let last = (self.count - 1) as f64;
        if !(0.0..=last).contains(&position) {
            return None;
        }
        let node = position.floor().min(last - 1.0);
        Some((node as usize, position - node))
    }
}

/// A measured spectrum.
#[derive(Clone, Debug)]
pub struct Measured {
    axes: [Axis; 2],
    /// `[kx][ky]`, m^4.
    psi_m4: Vec<f64>,
    peak_rad_m: f64,
}

struct Row {
    line: usize,
    at: [f64; 2],
    psi: f64,
}

impl Measured {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read, and all faults of its text.
    pub fn load(path: &Path) -> Result<Self, MeasuredError> {
        let unreadable =
            |error: std::io::Error| MeasuredError::Read { path: path.to_path_buf(), kind: error.kind() };
        let bytes = inputs::read(path, MAX_BYTES).map_err(unreadable)?;
        Self::read(&bytes).map_err(|faults| MeasuredError::File { path: path.to_path_buf(), faults })
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// All faults of the text.
    pub fn parse(bytes: &[u8]) -> Result<Self, MeasuredError> {
        Self::read(bytes).map_err(MeasuredError::Text)
    }

    fn read(bytes: &[u8]) -> Result<Self, Faults> {
        let mut faults = Faults { listed: Vec::new(), count: 0 };
        if bytes.len() as u64 > MAX_BYTES {
            faults.push(1, What::Long);
            return Err(faults);
        }
        let text = std::str::from_utf8(bytes).map_err(|error| {
            let before = &bytes[..error.valid_up_to()];
            faults.push(1 + before.iter().filter(|byte| **byte == b'\n').count(), What::Encoding);
            faults.clone()
        })?;
        // Spreadsheets put a mark before the text.
        let rows = rows(text.strip_prefix('\u{feff}').unwrap_or(text), &mut faults);
        if rows.is_empty() && faults.count > 0 {
            return Err(faults);
        }
        let last_line = text.lines().count().max(1);
        let [x, y] = [0, 1].map(|i| axis(&rows, i, last_line, &mut faults));
        let (Some(x), Some(y), 0) = (x, y, faults.count) else {
            return Err(faults);
        };
        if x.count.saturating_mul(y.count) > MAX_NODES {
            faults.push(last_line, What::TooMany);
            return Err(faults);
        }
        let mut psi_m4 = vec![f64::NAN; x.count * y.count];
        for row in &rows {
            let [i, j] = [(x, 0), (y, 1)].map(|(axis, c)| ((row.at[c] - axis.first) / axis.step).round());
            psi_m4[i as usize * y.count + j as usize] = row.psi;
        }
        for (node, _) in psi_m4.iter().enumerate().filter(|(_, psi)| psi.is_nan()) {
            let [kx, ky] =
                [(x, node / y.count), (y, node % y.count)].map(|(axis, n)| axis.first + n as f64 * axis.step);
            faults.push(last_line, What::Missing { kx, ky });
        }
        if faults.count > 0 {
            return Err(faults);
        }
        let mut spectrum = Self { axes: [x, y], psi_m4, peak_rad_m: 0.0 };
        spectrum.peak_rad_m = spectrum.find_peak();
        Ok(spectrum)
    }

    fn find_peak(&self) -> f64 {
        let furthest =
            self.axes.iter().map(|a| a.first.abs().max((a.first + (a.count - 1) as f64 * a.step).abs()));
        let (largest, step) = (furthest.fold(0.0, f64::hypot), self.finest_step());
        // Steps of the grid, or 4096 over its extent where it lies far from the origin.
        let step = step.max(largest / 4096.0);
        let mut best = [0.0, 0.0];
        for i in 1..=(largest / step) as usize + 1 {
            let k = i as f64 * step;
            let s = self.omnidirectional_m3(k);
            if s > best[1] {
                best = [k, s];
            }
        }
        best[0]
    }

    /// Last wave number with energy that the grid has all around, rad/m.
    pub(super) fn last_rad_m(&self) -> f64 {
        let [x, y] = self.axes;
        let all_around = x.furthest().min(y.furthest());
        let of_node = |node: usize| {
            let [kx, ky] =
                [(x, node / y.count), (y, node % y.count)].map(|(axis, n)| axis.first + n as f64 * axis.step);
            kx.hypot(ky)
        };
        let illuminated = self.psi_m4.iter().enumerate().filter(|(_, psi)| **psi > 0.0);
        illuminated.map(|(node, _)| of_node(node)).fold(0.0, f64::max).min(all_around)
    }

    /// `K` times the integral of a density over the circle, two points per step of the grid, m^3.
    pub(super) fn circle_m3(&self, k_rad_m: f64, density_m4: impl Fn(WaveVector) -> f64) -> f64 {
        if !in_range(k_rad_m) {
            return 0.0;
        }
        let around = std::f64::consts::TAU * k_rad_m / self.finest_step();
        let points = (2.0 * around).clamp(64.0, 4096.0) as usize;
        let step = std::f64::consts::TAU / points as f64;
        let at = |i: usize| density_m4(WaveVector::polar(k_rad_m, (i as f64 + 0.5) * step));
        k_rad_m * (0..points).map(at).sum::<f64>() * step
    }

    /// Parts of the side of a cell over which a mean is taken.
    pub(super) fn cell_divisions(&self, dk_rad_m: [f64; 2]) -> usize {
        (dk_rad_m[0].max(dk_rad_m[1]) / self.finest_step()).ceil().clamp(1.0, 32.0) as usize
    }

    fn finest_step(&self) -> f64 {
        self.axes[0].step.min(self.axes[1].step)
    }
}

/// The rows of a text; faults are noted.
fn rows(text: &str, faults: &mut Faults) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut seen: HashMap<[u64; 2], usize> = HashMap::new();
    let mut header = false;
    let mut end = 1;
    for (line, content) in text.lines().enumerate().map(|(i, content)| (i + 1, content.trim())) {
        end = line;
        if content.is_empty() || content.starts_with('#') {
            continue;
        }
        if !header {
            header = true;
            if content.split(',').map(str::trim).ne(HEADER.split(',')) {
                faults.push(line, What::Header);
                return rows;
            }
            continue;
        }
        let found = content.split(',').count();
        if found != 3 {
            faults.push(line, What::Fields { found });
            continue;
        }
        let mut values = [0.0; 3];
        let mut good = true;
        for ((value, field), column) in values.iter_mut().zip(content.split(',')).zip(HEADER.split(',')) {
            match field.trim().parse::<f64>() {
                Ok(number) if number.is_finite() => *value = number,
                _ => {
                    faults.push(line, What::Number { column });
                    good = false;
                }
            }
        }
        if !good {
            continue;
        }
        let [kx, ky, psi] = values;
        let largest = [super::MAX_WAVE_NUMBER_RAD_M, super::MAX_WAVE_NUMBER_RAD_M, MAX_PSI_M4];
        for ((value, column), largest) in values.into_iter().zip(HEADER.split(',')).zip(largest) {
            if value.abs() > largest {
                faults.push(line, What::Range { column, value, largest });
                good = false;
            }
        }
        if psi < 0.0 {
            faults.push(line, What::Negative { value: psi });
        }
        if rows.len() == MAX_NODES {
            faults.push(line, What::TooMany);
            return rows;
        }
        // -0 and 0 are the same node.
        let key = [kx + 0.0, ky + 0.0].map(f64::to_bits);
        if let Some(first) = seen.get(&key) {
            faults.push(line, What::Twice { kx, ky, first: *first });
        } else if good {
            seen.insert(key, line);
            rows.push(Row { line, at: [kx, ky], psi });
        }
    }
    if !header {
        faults.push(end, What::Header);
    }
    rows
}

/// The even steps along one axis; faults are noted.
fn axis(rows: &[Row], component: usize, last_line: usize, faults: &mut Faults) -> Option<Axis> {
    let column = ["kx_rad_m", "ky_rad_m"][component];
    let mut values: Vec<(f64, usize)> = rows.iter().map(|row| (row.at[component], row.line)).collect();
    values.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    values.dedup_by(|a, b| a.0 == b.0);
    let count = values.len();
    if count < 2 {
        faults.push(last_line, What::Flat { column, found: count });
        return None;
    }
    // The median step is that of the grid even when some values are off it.
    let mut steps: Vec<f64> = values.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    steps.sort_by(f64::total_cmp);
    let step = steps[steps.len() / 2];
    let mut even = true;
    for pair in values.windows(2) {
        // 1e-3 of a step: room for decimals printed with few digits.
        if ((pair[1].0 - pair[0].0) / step - 1.0).abs() > 1e-3 {
            faults.push(pair[1].1, What::Uneven { column, value: pair[1].0, step });
            even = false;
        }
    }
    let (first, last) = (values[0].0, values[count - 1].0);
    // Mean step: rounded decimals do not add up over a long axis.
    even.then(|| Axis { first, step: (last - first) / (count - 1) as f64, count })
}

impl Spectrum for Measured {
    fn omnidirectional_m3(&self, k_rad_m: f64) -> f64 {
        self.circle_m3(k_rad_m, |k| self.wave_m4(k))
    }

    fn spreading_per_rad(&self, k: WaveVector) -> f64 {
        let magnitude = k.magnitude();
        let s = self.omnidirectional_m3(magnitude);
        if s > 0.0 { self.wave_m4(k) * magnitude / s } else { 0.5 / std::f64::consts::PI }
    }

    fn peak_rad_m(&self) -> f64 {
        self.peak_rad_m
    }

    fn second_harmonic(&self, k_rad_m: f64) -> [f64; 2] {
        let points = 720;
        let step = std::f64::consts::TAU / points as f64;
        let mut sums = [0.0; 3];
        for i in 0..points {
            let azimuth = (i as f64 + 0.5) * step;
            let psi = self.wave_m4(WaveVector::polar(k_rad_m, azimuth));
            sums[0] += psi;
            sums[1] += psi * (2.0 * azimuth).cos();
            sums[2] += psi * (2.0 * azimuth).sin();
        }
        if sums[0] > 0.0 { [sums[1] / sums[0], sums[2] / sums[0]] } else { [0.0; 2] }
    }

    fn wave_m4(&self, k: WaveVector) -> f64 {
        let [x, y] = self.axes;
        let (Some((i, u)), Some((j, v))) = (x.locate(k.x_rad_m), y.locate(k.y_rad_m)) else {
            return 0.0;
        };
        let at = |i: usize, j: usize| self.psi_m4[i * y.count + j];
        (1.0 - u) * ((1.0 - v) * at(i, j) + v * at(i, j + 1))
            + u * ((1.0 - v) * at(i + 1, j) + v * at(i + 1, j + 1))
    }

    fn symmetric_m4(&self, k: WaveVector) -> f64 {
        0.5 * (self.wave_m4(k) + self.wave_m4(-k))
    }

    fn cell_mean_m4(&self, k: WaveVector, dk_rad_m: [f64; 2]) -> f64 {
        cells::cell_mean(|k| self.wave_m4(k), k, dk_rad_m, self.cell_divisions(dk_rad_m))
    }

    fn smooth_from_rad_m(&self) -> f64 {
        let [x, y] = self.axes.map(Axis::furthest);
        x.hypot(y)
    }

    fn needs_cell_means(&self, dk_rad_m: f64) -> bool {
        dk_rad_m > self.finest_step()
    }
}
