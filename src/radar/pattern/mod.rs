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
//! Files that end in `.msi`, `.pln` or `.pla` are those of Planet, `.cut` those of GRASP: both
//! become such a grid.
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

mod axis;
mod columns;
mod fault;
mod grasp;
mod planet;
mod table;

use std::ffi::OsStr;
use std::path::Path;

use num_complex::Complex64;

use crate::inputs;
use crate::units::Decibels;
use axis::{Axis, Gridded, OFF_GRID_STEPS};
pub use columns::{Column, Quantity};
pub use fault::{PatternError, PatternFault};

const MOST_BYTES: u64 = 64 << 20;

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
        let extension = path.extension().and_then(OsStr::to_str).map(str::to_ascii_lowercase);
        let read = match (quantity, extension.as_deref()) {
            (Quantity::Gain, Some("msi" | "pln" | "pla")) => planet::read,
            (Quantity::Gain, Some("cut")) => grasp::read,
            (Quantity::Gain, _) => |bytes: &[u8]| table::read(Quantity::Gain, bytes),
            (Quantity::CrossSection, _) => |bytes: &[u8]| table::read(Quantity::CrossSection, bytes),
        };
        let found = read(&bytes).map(|found| Self::of(found, floor_db));
        found.map_err(|faults| PatternError::Faults { quantity, path: path.to_owned(), faults })
    }

    fn of(found: Gridded, floor_db: f64) -> Self {
        let Gridded { azimuth, elevation, field } = found;
        let span_deg = azimuth.step_deg * azimuth.len.saturating_sub(1) as f64;
        let closed = (span_deg + azimuth.step_deg - 360.0).abs() <= OFF_GRID_STEPS * azimuth.step_deg;
        let floor = Decibels(floor_db).amplitude_ratio();
        let field = field.into_iter().map(|field| field.unwrap_or(floor.into())).collect();
        Self { azimuth, elevation, closed, field, floor }
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
        table::read(quantity, bytes).map(|found| Self::of(found, floor_db))
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Four values a cut: right is weaker than left, below weaker than above.
    const PLANET: &str =
        "GAIN 0 dBi\nHORIZONTAL 4\n0 0\n90 10\n180 20\n270 6\nVERTICAL 4\n0 0\n90 12\n180 20\n270 8\n";

    #[test]
    fn endings_choose_the_format() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("antenna.MSI");
        std::fs::write(&path, PLANET).unwrap();
        let pattern = GridPattern::open(&path, -60.0).unwrap();
        let db =
            |az: f64, el: f64| 20.0 * pattern.field_gain(az.to_radians(), el.to_radians()).norm().log10();
        for (az, el, wanted) in [(0.0, 0.0, 0.0), (90.0, 0.0, -6.0), (-90.0, 0.0, -10.0), (180.0, 0.0, -20.0)]
        {
            assert!((db(az, el) - wanted).abs() < 1e-9, "{az} {el}: {}", db(az, el));
        }
        assert!((db(0.0, 90.0) + 8.0).abs() < 1e-9 && (db(0.0, -90.0) + 12.0).abs() < 1e-9);
        // The same as CSV is none, and as a cut neither.
        let other = folder.path().join("antenna.cut");
        std::fs::write(&other, PLANET).unwrap();
        let error = GridPattern::open(&other, -60.0).unwrap_err().to_string();
        assert!(error.contains("V_INI"), "{error}");
    }
}
