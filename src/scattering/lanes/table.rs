//! The spectrum that scatters, as a table for facets side by side.
//!
//! On the circle of radius `K` the symmetrised spectrum is
//! `K^-4 [c_0 + sum_n (c_n cos 2 n psi + s_n sin 2 n psi)]`. The coefficients, with the high pass of the
//! two-scale cutoff in them, stand in [`ROWS`] rows at `K = K_end (i/ROWS)^2`, `K_end = 2.02 k`: steps `2
//! K/i`, relative to `K` the finer the shorter the wave. Between rows they are linear: the error is `(1/8)
//! (2/i)^2 K^2 c''/c`, 1e-6 to 1e-5 about the cutoff (`i` near 1600), where the high pass bends, and less
//! beyond; [`BraggTable::worst_relative_error`] is measured, between rows and at azimuths that no row was
//! made from.
//!
//! **What no table holds**: a beam of waves narrower than the azimuths of a circle, a null, a cusp, a
//! spectrum from a file. Where the measured error exceeds [`MOST_RELATIVE_ERROR`] the caller gives the table
//! the spectrum itself ([`BraggTable::with_spectrum`]), and every facet asks that, in f64: slower by its
//! cost, and right.

use std::f64::consts::PI;
use std::fmt;
use std::sync::Arc;

use crate::geometry::lanes::{LANES, Row};

/// Rows of a table.
pub const ROWS: usize = 4096;
/// Share of the mean below which a harmonic is nothing.
const HARMONIC_FLOOR: f64 = 1e-7;
/// Azimuths sampled over half a turn.
const AZIMUTHS: usize = 32;
/// Coefficients on a circle: the mean, and cosine and sine of each harmonic.
const COEFFICIENTS: usize = 1 + 2 * (AZIMUTHS / 2 - 1);
/// Azimuths over half a turn at which some circles are probed: 0.35 degrees apart, where the narrowest
/// spreading of a sea (`s = 1000`) is 5 degrees wide.
const DENSE_AZIMUTHS: usize = 512;
/// Every so many circles one is probed at all of these.
const DENSE_EVERY: usize = 64;
/// Share of the largest density on a circle below which errors count relative to that share: amplitudes of
/// -60 dB.
const LEAST_SHARE: f64 = 1e-6;
/// Longest Bragg vector over twice the radar's wave number, with some grace for rounding.
const GRACE: f64 = 1.01;

/// Largest relative error of the density that facets may have from a table: half of it in amplitude, -100 dB.
pub const MOST_RELATIVE_ERROR: f64 = 2e-5;

/// Density at a wave vector on the local axes, m^4.
pub type Density = Arc<dyn Fn(f64, f64) -> f64 + Send + Sync>;

/// Coefficients by wave number.
#[derive(Clone)]
pub struct BraggTable {
    /// `ROWS / sqrt(K_end)`.
    rows_per_root: f32,
    end_radpm: f64,
    width: usize,
    rows: Vec<f32>,
    worst_relative_error: f64,
    /// The spectrum itself, high pass included, where rows do not hold it.
    spectrum: Option<Density>,
}

impl fmt::Debug for BraggTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { end_radpm, width, worst_relative_error, spectrum, .. } = self;
        let tabulated = spectrum.is_none();
        write!(
            f,
            "BraggTable {{ to {end_radpm} rad/m, {width} wide, error {worst_relative_error:e}, tabulated {tabulated} }}"
        )
    }
}

/// Factor of a kind on the spectrum, by wave number.
#[derive(Clone, Debug)]
pub struct Damping {
    rows: Vec<f32>,
}

/// Wave number of a row.
fn row_radpm(end_radpm: f64, row: f64) -> f64 {
    end_radpm * (row / ROWS as f64).powi(2)
}

impl BraggTable {
    /// Tabulates `psi(kx, ky)`, m^4, times `pass(K)` for a radar wave number.
    pub fn new(psi: impl Fn(f64, f64) -> f64, pass: impl Fn(f64) -> f64, wavenumber_radpm: f64) -> Self {
        let end_radpm = 2.0 * GRACE * wavenumber_radpm;
        let mut all = vec![0.0; (ROWS + 2) * COEFFICIENTS];
        // At K = 0 nothing scatters.
        for (row, out) in all.chunks_exact_mut(COEFFICIENTS).enumerate().skip(1) {
            let k = row_radpm(end_radpm, row as f64);
            let passed = pass(k);
            if passed > 0.0 {
                out.copy_from_slice(&harmonics_at(|x, y| psi(x, y) * passed, k));
            }
        }
        let kept = harmonics_above(HARMONIC_FLOOR, &all);
        let width = 1 + 2 * kept;
        let rows =
            all.chunks_exact(COEFFICIENTS).flat_map(|row| row[..width].iter().map(|c| *c as f32)).collect();
        let rows_per_root = (ROWS as f64 / end_radpm.sqrt()) as f32;
        let mut table =
            Self { rows_per_root, end_radpm, width, rows, worst_relative_error: 0.0, spectrum: None };
        table.worst_relative_error = table.measure(&psi, &pass);
        table
    }

    /// The table with a spectrum, high pass included, that is asked instead of the rows.
    pub fn with_spectrum(self, spectrum: Density) -> Self {
        Self { spectrum: Some(spectrum), worst_relative_error: f64::from(f32::EPSILON), ..self }
    }

    /// Whether the rows are asked, and not the spectrum itself.
    pub fn is_tabulated(&self) -> bool {
        self.spectrum.is_none()
    }

    /// A factor on the spectrum in the rows of this table.
    pub fn damping(&self, factor: impl Fn(f64) -> f64) -> Damping {
        let rows = (0..ROWS + 2).map(|row| factor(row_radpm(self.end_radpm, row.max(1) as f64)) as f32);
        Damping { rows: rows.collect() }
    }

    /// A factor at a wave number.
    pub fn damping_at(&self, damping: &Damping, wavenumber_radpm: f64) -> f64 {
        let place = (wavenumber_radpm.max(0.0).sqrt() * f64::from(self.rows_per_root)).min(ROWS as f64);
        let row = place as usize;
        let (low, high) = (f64::from(damping.rows[row]), f64::from(damping.rows[row + 1]));
        low + (place - row as f64) * (high - low)
    }

    /// Largest error between rows and azimuths, relative to the density without the high pass at the same
    /// wave vector (or to 1e-6 of the largest on its circle, where that is more).
    pub fn worst_relative_error(&self) -> f64 {
        self.worst_relative_error
    }

    /// Densities at the wave vectors of the first lanes, on facets covered to `cover`, m^4.
    #[inline(always)]
    pub fn densities(
        &self,
        lanes: usize,
        damping: Option<&Damping>,
        bragg: &[Row; 2],
        cover: &Row,
        out: &mut Row,
    ) {
        let lanes = lanes.min(LANES);
        if let Some(spectrum) = &self.spectrum {
            return self.ask(spectrum, lanes, damping, bragg, cover, out);
        }
        let mut place = [0.0; LANES];
        let mut inverse = [0.0; LANES];
        for i in 0..lanes {
            let square = bragg[0][i] * bragg[0][i] + bragg[1][i] * bragg[1][i];
            let position = square.sqrt().sqrt() * self.rows_per_root;
            place[i] = if position < (ROWS as f32) { position } else { ROWS as f32 };
            inverse[i] = 1.0 / square.max(1e-12);
        }
        let width = self.width;
        for i in 0..lanes {
            let row = place[i] as usize;
            let share = place[i] - row as f32;
            let Some(rows) = self.rows.get(row * width..(row + 2) * width) else { continue };
            let (low, high) = rows.split_at(width);
            let at = |column: usize| low[column] + share * (high[column] - low[column]);
            let (x, y) = (bragg[0][i], bragg[1][i]);
            let (cos2, sin2) = ((x * x - y * y) * inverse[i], 2.0 * x * y * inverse[i]);
            let (mut cos, mut sin) = (cos2, sin2);
            let mut sum = at(0);
            for n in 1..=width / 2 {
                sum += at(2 * n - 1) * cos + at(2 * n) * sin;
                (cos, sin) = (cos * cos2 - sin * sin2, sin * cos2 + cos * sin2);
            }
            if let Some(damping) = damping {
                let (low, high) = (damping.rows[row], damping.rows[row + 1]);
                sum *= 1.0 + cover[i] * (low + share * (high - low) - 1.0);
            }
            out[i] = sum.max(0.0) * inverse[i] * inverse[i];
        }
    }

    /// Densities from the spectrum itself.
    fn ask(
        &self,
        spectrum: &Density,
        lanes: usize,
        damping: Option<&Damping>,
        bragg: &[Row; 2],
        cover: &Row,
        out: &mut Row,
    ) {
        for i in 0..lanes {
            let (x, y) = (f64::from(bragg[0][i]), f64::from(bragg[1][i]));
            let damped = damping.map_or(1.0, |damping| {
                1.0 + f64::from(cover[i]) * (self.damping_at(damping, x.hypot(y)) - 1.0)
            });
            out[i] = (spectrum(x, y).max(0.0) * damped) as f32;
        }
    }

    fn measure(&self, psi: impl Fn(f64, f64) -> f64, pass: impl Fn(f64) -> f64) -> f64 {
        let mut worst = 0.0f64;
        // Below a tenth of the first row of any use the spectrum of sea has no Bragg waves for a radar.
        for row in ROWS / 32..ROWS {
            let k = row_radpm(self.end_radpm, row as f64 + 0.5);
            let passed = pass(k);
            if passed <= 0.0 {
                continue;
            }
            let of_circle = |azimuths: &[f64]| {
                let mut bragg = [[0.0; LANES]; 2];
                for (i, azimuth) in azimuths.iter().enumerate() {
                    let (sin, cos) = azimuth.sin_cos();
                    (bragg[0][i], bragg[1][i]) = ((k * cos) as f32, (k * sin) as f32);
                }
                let mut out = [0.0; LANES];
                self.densities(azimuths.len(), None, &bragg, &[0.0; LANES], &mut out);
                let values = (0..azimuths.len()).map(|i| {
                    let (x, y) = (f64::from(bragg[0][i]), f64::from(bragg[1][i]));
                    let whole = psi(x, y).max(0.0);
                    // The high pass at the rounded vector itself: it is steep.
                    [whole, whole * pass(x.hypot(y)), f64::from(out[i])]
                });
                values.collect::<Vec<_>>()
            };
            let azimuths = probe_azimuths(row);
            let values: Vec<[f64; 3]> = azimuths.chunks(LANES).flat_map(of_circle).collect();
            worst = worst.max(relative_error(&values, f64::from(f32::MIN_POSITIVE)));
        }
        worst
    }
}

/// Azimuths over half a turn at which the circle of a number is probed.
fn probe_azimuths(circle: usize) -> Vec<f64> {
    /// Fraction of the golden section: multiples of it leave no gap.
    const TURN: f64 = 0.618_033_988_749_894_9;
    let count = if circle.is_multiple_of(DENSE_EVERY) { DENSE_AZIMUTHS } else { AZIMUTHS };
    let turned = (circle as f64 * TURN).fract();
    (0..count).map(|j| PI * (j as f64 + turned) / count as f64).collect()
}

/// Largest relative error on a circle of `[whole, exact, found]`: relative to the whole density, nowhere to
/// less than [`LEAST_SHARE`] of the largest; 0 where there is nothing above `least`.
fn relative_error(values: &[[f64; 3]], least: f64) -> f64 {
    let largest =
        values.iter().fold(0.0f64, |most, [whole, exact, found]| most.max(*whole).max(*exact).max(*found));
    if largest <= least {
        return 0.0;
    }
    let errors =
        values.iter().map(|[whole, exact, found]| (found - exact).abs() / whole.max(LEAST_SHARE * largest));
    errors.fold(0.0, f64::max)
}

/// Highest harmonic that somewhere exceeds a share of the mean, in rows of [`COEFFICIENTS`].
fn harmonics_above(floor: f64, rows: &[f64]) -> usize {
    let exceeds = |row: &[f64], n: usize| row[2 * n - 1].abs().max(row[2 * n].abs()) > floor * row[0].abs();
    let somewhere = |n: &usize| rows.chunks_exact(COEFFICIENTS).any(|row| exceeds(row, *n));
    (1..AZIMUTHS / 2).rev().find(somewhere).unwrap_or(0)
}

/// `c_0`, then `c_n, s_n`, of `K^4 Psi` on the circle of radius `k`.
fn harmonics_at(psi: impl Fn(f64, f64) -> f64, k: f64) -> [f64; COEFFICIENTS] {
    let mut row = [0.0; COEFFICIENTS];
    let scale = k * k * k * k / AZIMUTHS as f64;
    for j in 0..AZIMUTHS {
        let azimuth = PI * j as f64 / AZIMUTHS as f64;
        let (sin, cos) = azimuth.sin_cos();
        let value = psi(k * cos, k * sin).max(0.0) * scale;
        row[0] += value;
        for n in 1..AZIMUTHS / 2 {
            let (sin, cos) = (2.0 * n as f64 * azimuth).sin_cos();
            row[2 * n - 1] += 2.0 * value * cos;
            row[2 * n] += 2.0 * value * sin;
        }
    }
    row
}
