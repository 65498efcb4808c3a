//! Measured antenna patterns.
//!
//! CSV with a header naming `az_deg`, `el_deg`, `gain_dbi` and, if the pattern has phases, `phase_deg`, in any order; `#` starts a
//! comment line. Azimuth `az = atan2(d.y_a, d.x_a)` is positive towards `y_a`, elevation `el = asin(d.z_a)` towards `z_a`. Rows may come in any
//! order but must fill a regular grid: every azimuth with every elevation once, steps equal to 1e-6 of a step.
//!
//! Between grid points the complex field `g = 10^(G/20) e^{j phase}` is interpolated by bicubic convolution (Keys 1981,
//! a = -1/2: exact for quadratics, C1), with linear continuation beyond the rim of the grid. Outside the grid the gain is
//! the floor.

use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex64;
use thiserror::Error;

use crate::units::Decibels;

/// Largest pattern file, bytes.
pub const LARGEST_FILE: u64 = 64 << 20;
/// Faults kept of one file.
const FAULTS_KEPT: usize = 20;
/// How far a grid line may be off, in steps.
const REGULAR: f64 = 1e-6;

/// Why a pattern file cannot be used.
#[derive(Debug, Error)]
pub enum PatternError {
    /// It cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is too large.
    #[error("{}: allowed: at most {allowed} bytes", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Bytes allowed.
        allowed: u64,
    },
    /// Its contents are wrong.
    #[error("{}: {}", path.display(), list(faults, *more))]
    Faults {
        /// The file.
        path: PathBuf,
        /// The first faults.
        faults: Vec<PatternFault>,
        /// How many more there are.
        more: usize,
    },
}

/// One fault of a pattern file.
#[derive(Clone, Debug, PartialEq)]
pub struct PatternFault {
    /// Line, from 1; 0 for the file as a whole.
    pub line: u64,
    /// What is wrong.
    pub kind: PatternFaultKind,
}

/// What is wrong with a pattern file.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PatternFaultKind {
    /// A column is unknown, missing or doubled.
    #[error("columns '{found}'; allowed: az_deg, el_deg, gain_dbi and perhaps phase_deg, each once")]
    Columns {
        /// The header.
        found: String,
    },
    /// A value is not a number in its range.
    #[error("{column} '{found}'; allowed: {allowed}")]
    Value {
        /// The column.
        column: &'static str,
        /// What is there.
        found: String,
        /// What may be there.
        allowed: &'static str,
    },
    /// A row has too few or too many values.
    #[error("{found} values; allowed: {expected}")]
    Width {
        /// Values found.
        found: usize,
        /// Values expected.
        expected: usize,
    },
    /// A grid line is off.
    #[error("{column} {found} is not on the grid from {from} in steps of {step} deg")]
    Irregular {
        /// The column.
        column: &'static str,
        /// The value.
        found: f64,
        /// First grid value.
        from: f64,
        /// Step.
        step: f64,
    },
    /// A direction comes twice.
    #[error("az {az_deg}, el {el_deg} deg comes twice; allowed: once")]
    Twice {
        /// Azimuth.
        az_deg: f64,
        /// Elevation.
        el_deg: f64,
    },
    /// Directions are missing.
    #[error("{missing} of {expected} directions of the grid are missing; allowed: none")]
    Holes {
        /// How many.
        missing: usize,
        /// Out of.
        expected: usize,
    },
    /// Too few grid lines.
    #[error("{az} azimuths and {el} elevations; allowed: at least 2 of each")]
    Small {
        /// Azimuths.
        az: usize,
        /// Elevations.
        el: usize,
    },
}

fn list(faults: &[PatternFault], more: usize) -> String {
    let mut text: Vec<String> = faults.iter().map(ToString::to_string).collect();
    if more > 0 {
        text.push(format!("and {more} more"));
    }
    text.join("; ")
}

impl fmt::Display for PatternFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.line > 0 {
            write!(f, "line {}: ", self.line)?;
        }
        write!(f, "{}", self.kind)
    }
}

/// One axis of the grid, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis {
    from: f64,
    step: f64,
    count: usize,
}

impl Axis {
    /// The regular axis through sorted values, without their repetitions.
    fn through(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let from = values.first().copied().unwrap_or(0.0);
        let to = values.last().copied().unwrap_or(0.0);
        // Repetitions may differ by rounding: a gap counts when it is a sensible part of the largest one.
        let widest = values.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
        let gaps = values.windows(2).filter(|w| w[1] - w[0] > 1e-3 * widest).count();
        Self { from, step: if gaps > 0 { (to - from) / gaps as f64 } else { 0.0 }, count: gaps + 1 }
    }

    /// The grid line of a value, if it is one.
    fn line(&self, value: f64) -> Option<usize> {
        let place = if self.step > 0.0 { (value - self.from) / self.step } else { 0.0 };
        ((place - place.round()).abs() <= REGULAR && place.round() >= 0.0)
            .then_some(place.round() as usize)
            .filter(|line| *line < self.count)
    }

    /// Cell and position in it, `None` outside.
    fn cell(&self, value: f64) -> Option<(usize, f64)> {
        let place = (value - self.from) / self.step;
        let last = (self.count - 1) as f64;
        if !(-REGULAR..=last + REGULAR).contains(&place) {
            return None;
        }
        let cell = place.floor().clamp(0.0, last - 1.0);
        Some((cell as usize, place - cell))
    }
}

/// A pattern on a grid of azimuth and elevation.
#[derive(Clone, Debug)]
pub struct MeasuredPattern {
    az: Axis,
    el: Axis,
    /// `[el + 1][az + 1]` with a rim of one continued point all around.
    field: Arc<[Complex64]>,
    floor: f64,
}

impl MeasuredPattern {
    /// Reads a file.
    pub fn load(path: &Path, floor_dbi: f64) -> Result<Self, PatternError> {
        let read = |source| PatternError::Read { path: path.to_owned(), source };
        let mut bytes = Vec::new();
        File::open(path).map_err(read)?.take(LARGEST_FILE + 1).read_to_end(&mut bytes).map_err(read)?;
        if bytes.len() as u64 > LARGEST_FILE {
            return Err(PatternError::TooLarge { path: path.to_owned(), allowed: LARGEST_FILE });
        }
        Self::parse(&bytes, floor_dbi).map_err(|(faults, more)| PatternError::Faults {
            path: path.to_owned(),
            faults,
            more,
        })
    }

    /// Reads a file's contents; on failure, its first faults and how many more there are.
    pub fn parse(bytes: &[u8], floor_dbi: f64) -> Result<Self, (Vec<PatternFault>, usize)> {
        let mut faults = Faults::default();
        let rows = rows(bytes, &mut faults);
        faults.check()?;
        let az = Axis::through(rows.iter().map(|row| row.az_deg).collect());
        let el = Axis::through(rows.iter().map(|row| row.el_deg).collect());
        if az.count < 2 || el.count < 2 {
            faults.push(0, PatternFaultKind::Small { az: az.count, el: el.count });
            return faults.check().map(|()| unreachable_pattern(floor_dbi));
        }
        // A sparse file of scattered directions must not ask for a huge grid.
        let cells = az.count.saturating_mul(el.count);
        let on_grid = |row: &Row| Some((az.line(row.az_deg)?, el.line(row.el_deg)?));
        let mut seen = vec![false; if cells <= 4 * rows.len() { cells } else { 0 }];
        let width = az.count + 2;
        let mut field = vec![Complex64::ZERO; if seen.is_empty() { 0 } else { width * (el.count + 2) }];
        let mut filled = 0;
        for row in &rows {
            match on_grid(row) {
                None => {
                    let (column, found, axis) = match az.line(row.az_deg) {
                        None => ("az_deg", row.az_deg, az),
                        Some(_) => ("el_deg", row.el_deg, el),
                    };
                    faults.push(
                        row.line,
                        PatternFaultKind::Irregular { column, found, from: axis.from, step: axis.step },
                    );
                }
                Some((i, j)) if !seen.is_empty() => {
                    if std::mem::replace(&mut seen[j * az.count + i], true) {
                        let (az_deg, el_deg) = (row.az_deg, row.el_deg);
                        faults.push(row.line, PatternFaultKind::Twice { az_deg, el_deg });
                    } else {
                        filled += 1;
                        field[(j + 1) * width + i + 1] = row.field;
                    }
                }
                Some(_) => filled += 1,
            }
        }
        if filled < cells && faults.kept.is_empty() {
            faults.push(0, PatternFaultKind::Holes { missing: cells - filled, expected: cells });
        }
        faults.check()?;
        continue_rim(&mut field, az.count, el.count);
        Ok(Self { az, el, field: field.into(), floor: Decibels(floor_dbi).amplitude_ratio() })
    }

    /// Complex field gain towards a unit direction in the antenna frame.
    pub fn field_gain(&self, direction: DVec3) -> Complex64 {
        let az_deg = direction.y.atan2(direction.x).to_degrees();
        let el_deg = direction.z.clamp(-1.0, 1.0).asin().to_degrees();
        let (Some((i, x)), Some((j, y))) = (self.az.cell(az_deg), self.el.cell(el_deg)) else {
            return self.floor.into();
        };
        let (wx, wy) = (keys(x), keys(y));
        let width = self.az.count + 2;
        let mut sum = Complex64::ZERO;
        for (row, wy) in wy.iter().enumerate() {
            let line = &self.field[(j + row) * width + i..][..4];
            sum += line.iter().zip(wx).map(|(g, wx)| g * wx).sum::<Complex64>() * wy;
        }
        sum
    }
}

/// Only reached when a fault list that was just written to is empty.
fn unreachable_pattern(floor_dbi: f64) -> MeasuredPattern {
    let axis = Axis { from: 0.0, step: 1.0, count: 2 };
    let floor = Decibels(floor_dbi).amplitude_ratio();
    MeasuredPattern { az: axis, el: axis, field: vec![floor.into(); 16].into(), floor }
}

/// Weights of the four points around position x in [0, 1] of a cell (Keys, a = -1/2).
fn keys(x: f64) -> [f64; 4] {
    let (x2, x3) = (x * x, x * x * x);
    [-0.5 * x3 + x2 - 0.5 * x, 1.5 * x3 - 2.5 * x2 + 1.0, -1.5 * x3 + 2.0 * x2 + 0.5 * x, 0.5 * x3 - 0.5 * x2]
}

/// Fills the rim around a grid by linear continuation.
fn continue_rim(field: &mut [Complex64], columns: usize, rows: usize) {
    let width = columns + 2;
    for row in 1..=rows {
        let line = &mut field[row * width..][..width];
        line[0] = line[1] * 2.0 - line[2];
        line[columns + 1] = line[columns] * 2.0 - line[columns - 1];
    }
    for column in 0..width {
        let at = |row: usize| row * width + column;
        field[at(0)] = field[at(1)] * 2.0 - field[at(2)];
        field[at(rows + 1)] = field[at(rows)] * 2.0 - field[at(rows - 1)];
    }
}

#[derive(Default)]
struct Faults {
    kept: Vec<PatternFault>,
    more: usize,
}

impl Faults {
    fn push(&mut self, line: u64, kind: PatternFaultKind) {
        if self.kept.len() < FAULTS_KEPT {
            self.kept.push(PatternFault { line, kind });
        } else {
            self.more += 1;
        }
    }

    fn check(&mut self) -> Result<(), (Vec<PatternFault>, usize)> {
        if self.kept.is_empty() { Ok(()) } else { Err((std::mem::take(&mut self.kept), self.more)) }
    }
}

struct Row {
    line: u64,
    az_deg: f64,
    el_deg: f64,
    field: Complex64,
}

const COLUMNS: [&str; 4] = ["az_deg", "el_deg", "gain_dbi", "phase_deg"];
const ALLOWED: [&str; 4] =
    ["-180 to 180 deg", "-90 to 90 deg", "-300 to 100 dBi", "a finite number of degrees"];
const RANGES: [(f64, f64); 4] = [(-180.0, 180.0), (-90.0, 90.0), (-300.0, 100.0), (-1e9, 1e9)];

fn rows(bytes: &[u8], faults: &mut Faults) -> Vec<Row> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .flexible(true)
        .trim(csv::Trim::All)
        .has_headers(false)
        .from_reader(bytes);
    let mut records = reader.byte_records();
    let header: Vec<String> = match records.next() {
        Some(Ok(record)) => record.iter().map(|name| String::from_utf8_lossy(name).into_owned()).collect(),
        _ => Vec::new(),
    };
    let places: Vec<Option<usize>> =
        header.iter().map(|name| COLUMNS.iter().position(|c| c == name)).collect();
    let once = |column: usize| places.iter().filter(|p| **p == Some(column)).count();
    let good = places.iter().all(Option::is_some) && (0..3).all(|c| once(c) == 1) && once(3) <= 1;
    if !good {
        let found = header.join(",").chars().take(200).collect();
        faults.push(1, PatternFaultKind::Columns { found });
        return Vec::new();
    }
    let mut rows = Vec::new();
    for record in records {
        let Ok(record) = record else { continue };
        let line = record.position().map_or(0, csv::Position::line);
        if record.len() != header.len() {
            faults.push(line, PatternFaultKind::Width { found: record.len(), expected: header.len() });
            continue;
        }
        let mut values = [0.0; 4];
        let mut whole = true;
        for (text, column) in record.iter().zip(places.iter().flatten()) {
            let text = String::from_utf8_lossy(text);
            match text.parse::<f64>() {
                Ok(x) if (RANGES[*column].0..=RANGES[*column].1).contains(&x) => values[*column] = x,
                _ => {
                    whole = false;
                    let found = text.chars().take(40).collect();
                    let (column, allowed) = (COLUMNS[*column], ALLOWED[*column]);
                    faults.push(line, PatternFaultKind::Value { column, found, allowed });
                }
            }
        }
        if whole {
            let [az_deg, el_deg, gain_dbi, phase_deg] = values;
            let field = Complex64::from_polar(Decibels(gain_dbi).amplitude_ratio(), phase_deg.to_radians());
            rows.push(Row { line, az_deg, el_deg, field });
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn direction(az_deg: f64, el_deg: f64) -> DVec3 {
        let (az, el) = (az_deg.to_radians(), el_deg.to_radians());
        DVec3::new(el.cos() * az.cos(), el.cos() * az.sin(), el.sin())
    }

    fn file(gain: impl Fn(f64, f64) -> (f64, f64)) -> String {
        let mut text = String::from("# measured\nel_deg,az_deg,gain_dbi,phase_deg\n");
        for el in -4..=4 {
            for az in -10..=10 {
                let (az, el) = (f64::from(az) * 0.5, f64::from(el));
                let (gain_dbi, phase_deg) = gain(az, el);
                text += &format!("{el},{az},{gain_dbi},{phase_deg}\n");
            }
        }
        text
    }

    #[test]
    fn grid_points_are_met_and_quadratics_are_exact() {
        let field = |az: f64, el: f64| Complex64::new(30.0 - az * az, 2.0 + 0.5 * el * az - 0.1 * el * el);
        let text = file(|az, el| {
            let g = field(az, el);
            (20.0 * g.norm().log10(), g.arg().to_degrees())
        });
        let pattern = MeasuredPattern::parse(text.as_bytes(), -60.0).unwrap();
        for (az, el) in [(0.5, -2.0), (0.25, 1.5), (-2.37, 2.99), (4.0, -3.0)] {
            let error = (pattern.field_gain(direction(az, el)) - field(az, el)).norm();
            // Text carries 15 digits of a field of 30.
            assert!(error < 1e-11, "{az} {el}: {error:e}");
        }
        assert!((pattern.field_gain(direction(5.1, 0.0)).norm() - 1e-3).abs() < 1e-15);
        assert!((pattern.field_gain(-DVec3::X).norm() - 1e-3).abs() < 1e-15);
    }

    #[test]
    fn faults_are_told_together() {
        let told = |text: &str| {
            let (faults, more) = MeasuredPattern::parse(text.as_bytes(), -60.0).unwrap_err();
            list(&faults, more)
        };
        insta::assert_snapshot!(told("az_deg,gain_dbi\n1,2\n"), @"line 1: columns 'az_deg,gain_dbi'; allowed: az_deg, el_deg, gain_dbi and perhaps phase_deg, each once");
        insta::assert_snapshot!(told("az_deg,el_deg,gain_dbi\n0,0,nan\n1,0\n1,91,3\n"), @"line 2: gain_dbi 'nan'; allowed: -300 to 100 dBi; line 3: 2 values; allowed: 3; line 4: el_deg '91'; allowed: -90 to 90 deg");
        insta::assert_snapshot!(told("az_deg,el_deg,gain_dbi\n0,0,1\n1,0,1\n2.2,0,1\n0,1,1\n1,1,1\n2.2,1,1\n0,0,1\n"), @"");
        insta::assert_snapshot!(told("az_deg,el_deg,gain_dbi\n0,0,1\n1,0,1\n0,1,1\n"), @"1 of 4 directions of the grid are missing; allowed: none");
        insta::assert_snapshot!(told("az_deg,el_deg,gain_dbi\n0,0,1\n"), @"1 azimuths and 1 elevations; allowed: at least 2 of each");
        insta::assert_snapshot!(told(""), @"line 1: columns ''; allowed: az_deg, el_deg, gain_dbi and perhaps phase_deg, each once");
    }
}
