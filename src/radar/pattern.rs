//! Measured antenna patterns, and radar cross sections over the aspect.
//!
//! A pattern file is CSV with a header line, `az_deg,el_deg,gain_dbi` or
//! `az_deg,el_deg,gain_dbi,phase_deg`, one row per point of a regular grid, in any order; lines that
//! begin with `#` are remarks. Azimuth is `atan2(d.y_a, d.x_a)`, elevation `asin(d.z_a)` of the direction
//! `d` in the antenna frame. The field is `10^(gain/20) exp(j phase)`: without a phase column sidelobes
//! do not change sign.
//!
//! Between the points each of real and imaginary part is interpolated by Catmull-Rom cubics in both
//! angles (continuous slope, error `O(step^3)`); at the rim the missing neighbour is extrapolated from
//! the three nearest points. A grid that goes once round in azimuth is closed. Outside the grid the gain
//! is the floor, with phase 0.
//!
//! A file of radar cross sections is the same with the header `az_deg,el_deg,rcs_dbsm`; its field is
//! `sqrt(sigma)`, m.
//!
//! All faults of a file are reported together, each with its line. Bounds: 64 MiB, 4 million points.
//!
//! ```
//! use nereus::radar::pattern::GridPattern;
//! let text = "az_deg,el_deg,gain_dbi\n-1,-1,0\n-1,1,0\n1,-1,20\n1,1,20\n";
//! let pattern = GridPattern::parse(text.as_bytes(), -60.0).unwrap();
//! // Half-way between field gains 1 and 10.
//! assert!((pattern.field_gain(0.0, 0.0).re - 5.5).abs() < 1e-12);
//! assert!((pattern.field_gain(1.0, 0.0).re - 1e-3).abs() < 1e-15);
//! ```

use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};

use num_complex::Complex64;
use thiserror::Error;

use crate::inputs;
use crate::units::Decibels;

/// What the file gives of every direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Gain of an antenna, dBi, and phase where there is a column for it.
    Gain,
    /// Radar cross section, dBsm.
    CrossSection,
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Gain => "pattern file",
            Self::CrossSection => "file of cross sections",
        })
    }
}

impl Quantity {
    /// Columns of the longest header, and how many of them may be left out.
    fn columns(self) -> (&'static [Column], usize) {
        match self {
            Self::Gain => (&[Column::Azimuth, Column::Elevation, Column::Gain, Column::Phase], 1),
            Self::CrossSection => (&[Column::Azimuth, Column::Elevation, Column::CrossSection], 0),
        }
    }

    fn headers(self) -> &'static str {
        match self {
            Self::Gain => "az_deg,el_deg,gain_dbi or az_deg,el_deg,gain_dbi,phase_deg",
            Self::CrossSection => "az_deg,el_deg,rcs_dbsm",
        }
    }
}

const MOST_BYTES: u64 = 64 << 20;
const MOST_POINTS: usize = 4_000_000;
const MOST_FAULTS: usize = 20;
/// How far a coordinate may lie off the regular grid, in steps: files round to a few decimals.
const OFF_GRID_STEPS: f64 = 0.01;
const GAIN_DBI: std::ops::RangeInclusive<f64> = -300.0..=100.0;
const RCS_DBSM: std::ops::RangeInclusive<f64> = -300.0..=120.0;

/// Why a pattern file cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PatternError {
    /// It cannot be read.
    #[error("{quantity} {}: {source}", path.display())]
    Read {
        /// What it should hold.
        quantity: Quantity,
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is too large.
    #[error("{quantity} {}: more than 64 MiB", path.display())]
    TooLarge {
        /// What it should hold.
        quantity: Quantity,
        /// The file.
        path: PathBuf,
    },
    /// Its content is wrong.
    #[error("{quantity} {}:{}", path.display(), listed(faults))]
    Faults {
        /// What it should hold.
        quantity: Quantity,
        /// The file.
        path: PathBuf,
        /// Everything that is wrong with it.
        faults: Vec<PatternFault>,
    },
}

fn listed(faults: &[PatternFault]) -> String {
    faults.iter().map(|fault| format!("\n  {fault}")).collect()
}

/// One fault of a pattern file.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PatternFault {
    /// The header is none of those allowed.
    #[error("line {line}: header '{found}': {wanted} wanted")]
    Header {
        /// Line, from 1.
        line: u64,
        /// What stands there.
        found: String,
        /// What is allowed.
        wanted: &'static str,
    },
    /// Not text, or a row with too few or too many fields.
    #[error("line {line}: {found} fields, {wanted} wanted")]
    Fields {
        /// Line, from 1.
        line: u64,
        /// Fields found.
        found: usize,
        /// Fields that the header announces.
        wanted: usize,
    },
    /// Not CSV at all (bytes that are not UTF-8, an open quote).
    #[error("{what}")]
    Csv {
        /// The CSV reader's error.
        what: String,
    },
    /// A value that is no number or out of range.
    #[error("line {line}: {column} '{found}': {allowed} wanted")]
    Value {
        /// Line, from 1.
        line: u64,
        /// Column.
        column: Column,
        /// What stands there.
        found: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A point off the regular grid.
    #[error("line {line}: {column} {value} is not on the regular grid from {first} in steps of {step}")]
    OffGrid {
        /// Line, from 1.
        line: u64,
        /// Column.
        column: Column,
        /// The value, degrees.
        value: f64,
        /// Start of the grid, degrees.
        first: f64,
        /// Step of the grid, degrees.
        step: f64,
    },
    /// The same point twice.
    #[error("line {line}: az {az_deg} el {el_deg} is given already in line {before}")]
    Twice {
        /// Line, from 1.
        line: u64,
        /// Line of the first.
        before: u64,
        /// Azimuth, degrees.
        az_deg: f64,
        /// Elevation, degrees.
        el_deg: f64,
    },
    /// Points of the grid that no line gives.
    #[error("{missing} of {wanted} grid points are missing, the first at az {az_deg} el {el_deg}")]
    Holes {
        /// How many.
        missing: usize,
        /// Points of the grid.
        wanted: usize,
        /// Azimuth of the first, degrees.
        az_deg: f64,
        /// Elevation of the first, degrees.
        el_deg: f64,
    },
    /// An axis with fewer than two values.
    #[error("{column}: {found} value(s), at least 2 wanted")]
    TooFew {
        /// Column.
        column: Column,
        /// Values found.
        found: usize,
    },
    /// More points than allowed.
    #[error("more than {MOST_POINTS} grid points")]
    TooMany,
    /// The azimuths go more than once round.
    #[error("az_deg spans {span_deg} degrees: at most 360 wanted")]
    Span {
        /// From the first to the last azimuth, degrees.
        span_deg: f64,
    },
    /// Further faults, not listed.
    #[error("and {0} more faults")]
    More(usize),
}

/// A column of a pattern file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// `az_deg`
    Azimuth,
    /// `el_deg`
    Elevation,
    /// `gain_dbi`
    Gain,
    /// `phase_deg`
    Phase,
    /// `rcs_dbsm`
    CrossSection,
}

impl fmt::Display for Column {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Azimuth => "az_deg",
            Self::Elevation => "el_deg",
            Self::Gain => "gain_dbi",
            Self::Phase => "phase_deg",
            Self::CrossSection => "rcs_dbsm",
        })
    }
}

impl Column {
    fn read(self, text: &str) -> Result<f64, &'static str> {
        let (range, allowed) = match self {
            Self::Azimuth => (-360.0..=360.0, "degrees from -360 to 360"),
            Self::Elevation => (-90.0..=90.0, "degrees from -90 to 90"),
            Self::Gain => (GAIN_DBI, "dBi from -300 to 100"),
            Self::Phase => (-1e6..=1e6, "degrees"),
            Self::CrossSection => (RCS_DBSM, "dBsm from -300 to 120"),
        };
        text.parse().ok().filter(|value| range.contains(value)).ok_or(allowed)
    }
}

/// A regular axis, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis {
    first_deg: f64,
    step_deg: f64,
    len: usize,
}

impl Axis {
    /// The axis through the distinct values (within 1e-6 degrees, far below any measured step).
    fn through(values: impl Iterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.collect();
        sorted.sort_by(f64::total_cmp);
        sorted.dedup_by(|later, earlier| *later - *earlier < 1e-6);
        let len = sorted.len();
        let first_deg = sorted.first().copied().unwrap_or(0.0);
        // From the median step, made finer by every value that fits: neither the rounding of a file's
        // decimals nor a stray value corrupts it.
        let mut steps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        let Some(&median) = steps.get(steps.len() / 2) else {
            return Self { first_deg, step_deg: 0.0, len };
        };
        let (mut step_deg, mut last) = (median, 1);
        for value in sorted {
            let place = ((value - first_deg) / step_deg).round();
            let off = (value - first_deg - place * step_deg).abs();
            if place >= 1.0 && off <= OFF_GRID_STEPS * step_deg {
                step_deg = (value - first_deg) / place;
                last = place as usize;
            }
        }
        Self { first_deg, step_deg, len: last.saturating_add(1) }
    }

    /// Place of a value on the axis, `None` off the grid.
    fn place(&self, value_deg: f64) -> Option<usize> {
        let x = (value_deg - self.first_deg) / self.step_deg;
        let place = x.round() as usize;
        ((x - x.round()).abs() <= OFF_GRID_STEPS && place < self.len).then_some(place)
    }

    fn value_deg(&self, place: usize) -> f64 {
        self.first_deg + place as f64 * self.step_deg
    }
}

struct Row {
    line: u64,
    az_deg: f64,
    el_deg: f64,
    field: Complex64,
}

/// A measured pattern on a regular grid of azimuth and elevation.
#[derive(Clone, Debug, PartialEq)]
pub struct GridPattern {
    azimuth: Axis,
    elevation: Axis,
    /// Whether the first azimuth follows the last.
    closed: bool,
    /// `[elevation][azimuth]`
    field: Vec<Complex64>,
    floor: f64,
}

impl GridPattern {
    /// Reads a pattern file; `floor_dbi` is the gain outside its grid.
    ///
    /// # Errors
    /// A file that cannot be read, or its faults.
    pub fn open(path: &Path, floor_dbi: f64) -> Result<Self, PatternError> {
        Self::open_as(Quantity::Gain, path, floor_dbi)
    }

    /// Reads a file of gains, or of radar cross sections; `floor_db` is what holds outside its grid.
    ///
    /// # Errors
    /// A file that cannot be read, or its faults.
    pub fn open_as(quantity: Quantity, path: &Path, floor_db: f64) -> Result<Self, PatternError> {
        let read = |source| PatternError::Read { quantity, path: path.to_owned(), source };
        let bytes = inputs::read(path, MOST_BYTES).map_err(read)?;
        if bytes.len() as u64 > MOST_BYTES {
            return Err(PatternError::TooLarge { quantity, path: path.to_owned() });
        }
        Self::parse_as(quantity, &bytes, floor_db).map_err(|faults| PatternError::Faults {
            quantity,
            path: path.to_owned(),
            faults,
        })
    }

    /// Reads the text of a pattern file.
    ///
    /// # Errors
    /// All faults of the text, each with its line.
    pub fn parse(bytes: &[u8], floor_dbi: f64) -> Result<Self, Vec<PatternFault>> {
        Self::parse_as(Quantity::Gain, bytes, floor_dbi)
    }

    /// Reads the text of a file of gains, or of radar cross sections.
    ///
    /// # Errors
    /// All faults of the text, each with its line.
    pub fn parse_as(quantity: Quantity, bytes: &[u8], floor_db: f64) -> Result<Self, Vec<PatternFault>> {
        let mut faults = Faults::default();
        let rows = read_rows(quantity, bytes, &mut faults);
        if rows.is_empty() && !faults.list.is_empty() {
            return Err(faults.finish());
        }
        let pattern = Self::on_grid(&rows, floor_db, &mut faults);
        match pattern {
            Some(pattern) if faults.list.is_empty() => Ok(pattern),
            _ => Err(faults.finish()),
        }
    }

    fn on_grid(rows: &[Row], floor_dbi: f64, faults: &mut Faults) -> Option<Self> {
        let azimuth = Axis::through(rows.iter().map(|row| row.az_deg));
        let elevation = Axis::through(rows.iter().map(|row| row.el_deg));
        let mut whole = true;
        for (column, axis) in [(Column::Azimuth, &azimuth), (Column::Elevation, &elevation)] {
            if axis.len < 2 {
                whole = false;
                faults.push(PatternFault::TooFew { column, found: axis.len });
            }
        }
        let span_deg = azimuth.step_deg * azimuth.len.saturating_sub(1) as f64;
        if span_deg > 360.0 + OFF_GRID_STEPS * azimuth.step_deg {
            whole = false;
            faults.push(PatternFault::Span { span_deg });
        }
        let points = azimuth.len.saturating_mul(elevation.len);
        if points > MOST_POINTS {
            whole = false;
            faults.push(PatternFault::TooMany);
        }
        if !whole {
            return None;
        }
        let mut field = vec![None; points];
        let mut lines = HashMap::with_capacity(rows.len());
        for row in rows {
            let line = row.line;
            let mut places = [0; 2];
            let axes = [(Column::Azimuth, &azimuth, row.az_deg), (Column::Elevation, &elevation, row.el_deg)];
            let mut on = true;
            for (place, (column, axis, value)) in places.iter_mut().zip(axes) {
                match axis.place(value) {
                    Some(at) => *place = at,
                    None => {
                        on = false;
                        let (first, step) = (axis.first_deg, axis.step_deg);
                        faults.push(PatternFault::OffGrid { line, column, value, first, step });
                    }
                }
            }
            let cell = places[1] * azimuth.len + places[0];
            if !on {
                continue;
            }
            if let Some(before) = lines.insert(cell, line) {
                let (az_deg, el_deg) = (row.az_deg, row.el_deg);
                faults.push(PatternFault::Twice { line, before, az_deg, el_deg });
            }
            field[cell] = Some(row.field);
        }
        let missing = field.iter().filter(|point| point.is_none()).count();
        if let Some(hole) = field.iter().position(Option::is_none) {
            faults.push(PatternFault::Holes {
                missing,
                wanted: points,
                az_deg: azimuth.value_deg(hole % azimuth.len),
                el_deg: elevation.value_deg(hole / azimuth.len),
            });
        }
        let closed = (span_deg + azimuth.step_deg - 360.0).abs() <= OFF_GRID_STEPS * azimuth.step_deg;
        let field: Vec<Complex64> = field.into_iter().flatten().collect();
        let floor = Decibels(floor_dbi).amplitude_ratio();
        Some(Self { azimuth, elevation, closed, field, floor })
    }

    /// Mean of the squared field over the points of the grid.
    pub fn mean_power(&self) -> f64 {
        self.field.iter().map(Complex64::norm_sqr).sum::<f64>() / self.field.len().max(1) as f64
    }

    /// Azimuth and elevation of its points, rad, and power gain; and gain outside of the grid.
    pub fn points(&self) -> (impl Iterator<Item = ([f64; 2], f64)>, f64) {
        let of = |(n, field): (usize, &Complex64)| {
            let (row, column) = (n / self.azimuth.len, n % self.azimuth.len);
            let at = [self.azimuth.value_deg(column), self.elevation.value_deg(row)];
            (at.map(f64::to_radians), field.norm_sqr())
        };
        (self.field.iter().enumerate().map(of), self.floor * self.floor)
    }

    /// Field gain towards azimuth and elevation in the antenna frame, radians.
    pub fn field_gain(&self, az_rad: f64, el_rad: f64) -> Complex64 {
        // The turn of the azimuth that lies on the grid, if any.
        let from_first = (az_rad.to_degrees() - self.azimuth.first_deg).rem_euclid(360.0);
        let (x, y) = (
            from_first / self.azimuth.step_deg,
            (el_rad.to_degrees() - self.elevation.first_deg) / self.elevation.step_deg,
        );
        let (columns, rows) = (self.azimuth.len, self.elevation.len);
        // Rounding of degrees must not push a direction off the rim.
        let rim = 1e-9;
        let x = if x > 360.0 / self.azimuth.step_deg - rim { 0.0 } else { x };
        let last_x = if self.closed { columns as f64 } else { (columns - 1) as f64 };
        let last_y = (rows - 1) as f64;
        if !(x <= last_x + rim && (-rim..=last_y + rim).contains(&y)) {
            return self.floor.into();
        }
        let cells = if self.closed { columns } else { columns - 1 };
        let (i, s) = cell(x, cells);
        let (j, t) = cell(y, rows - 1);
        let along = |row: usize| {
            let line = &self.field[row * columns..(row + 1) * columns];
            if self.closed {
                let at = |k: usize| line[k % columns];
                catmull_rom([at(i + columns - 1), at(i), at(i + 1), at(i + 2)], s)
            } else {
                catmull_rom(stencil(i, columns, |k| line[k]), s)
            }
        };
        catmull_rom(stencil(j, rows, along), t)
    }
}

/// Cell and place within it, in [0, 1].
fn cell(x: f64, cells: usize) -> (usize, f64) {
    let i = (x.max(0.0) as usize).min(cells - 1);
    (i, (x - i as f64).clamp(0.0, 1.0))
}

/// The four values about the cell between `i` and `i + 1`; at the rim the outer one is extrapolated.
fn stencil(i: usize, len: usize, value: impl Fn(usize) -> Complex64) -> [Complex64; 4] {
    let (b, c) = (value(i), value(i + 1));
    let before = (i > 0).then(|| value(i - 1));
    let after = (i + 2 < len).then(|| value(i + 2));
    let beyond = |near: Complex64, far: Complex64, further: Option<Complex64>| match further {
        // The quadratic through three points, one step on.
        Some(further) => (near - far) * 3.0 + further,
        None => near * 2.0 - far,
    };
    [before.unwrap_or_else(|| beyond(b, c, after)), b, c, after.unwrap_or_else(|| beyond(c, b, before))]
}

/// The Catmull-Rom cubic between `p[1]` (s = 0) and `p[2]` (s = 1).
fn catmull_rom(p: [Complex64; 4], s: f64) -> Complex64 {
    let slope = [(p[2] - p[0]) * 0.5, (p[3] - p[1]) * 0.5];
    let rise = p[2] - p[1];
    p[1] + (slope[0] + (rise * 3.0 - slope[0] * 2.0 - slope[1] + (slope[0] + slope[1] - rise * 2.0) * s) * s)
        * s
}

/// Faults, the first few kept and the others counted.
#[derive(Default)]
struct Faults {
    list: Vec<PatternFault>,
    more: usize,
}

impl Faults {
    fn push(&mut self, fault: PatternFault) {
        if self.list.len() < MOST_FAULTS {
            self.list.push(fault);
        } else {
            self.more += 1;
        }
    }

    fn finish(mut self) -> Vec<PatternFault> {
        if self.more > 0 {
            self.list.push(PatternFault::More(self.more));
        }
        self.list
    }
}

fn read_rows(quantity: Quantity, bytes: &[u8], faults: &mut Faults) -> Vec<Row> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(bytes);
    let mut rows = Vec::new();
    let (columns, optional) = quantity.columns();
    let mut wanted = 0;
    for record in reader.records() {
        let record = match record {
            Ok(record) => record,
            Err(error) => {
                faults.push(PatternFault::Csv { what: error.to_string() });
                continue;
            }
        };
        let line = record.position().map_or(0, csv::Position::line);
        if wanted == 0 {
            let header: Vec<&str> = record.iter().map(|name| name.trim_start_matches('\u{feff}')).collect();
            let names: Vec<String> = columns.iter().map(Column::to_string).collect();
            if header == names || header == names[..names.len() - optional] {
                wanted = header.len();
                continue;
            }
            let found = header.join(",").chars().take(80).collect();
            faults.push(PatternFault::Header { line, found, wanted: quantity.headers() });
            return rows;
        }
        if record.len() != wanted {
            faults.push(PatternFault::Fields { line, found: record.len(), wanted });
            continue;
        }
        if rows.len() >= MOST_POINTS {
            faults.push(PatternFault::TooMany);
            return rows;
        }
        let mut values = [0.0; 4];
        let mut good = true;
        for ((value, column), text) in values.iter_mut().zip(columns).zip(&record) {
            match column.read(text) {
                Ok(number) => *value = number,
                Err(allowed) => {
                    good = false;
                    let found = text.chars().take(40).collect();
                    faults.push(PatternFault::Value { line, column: *column, found, allowed });
                }
            }
        }
        if good {
            let [az_deg, el_deg, level_db, phase_deg] = values;
            let field = Complex64::from_polar(Decibels(level_db).amplitude_ratio(), phase_deg.to_radians());
            rows.push(Row { line, az_deg, el_deg, field });
        }
    }
    rows
}
