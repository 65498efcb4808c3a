//! A spectrum tabulated where facets ask for it: the cheap path of the Bragg part.
//!
//! Of a facet's cost the spectrum is the largest part (exponentials and powers); all the rest is a few dozen
//! products. On a grid uniform in `ln K` the table holds the harmonics of the symmetrised spectrum,
//!
//! `K^4 Psi(K, phi) = c_0(K) + sum_n [c_n(K) cos 2n phi + s_n(K) sin 2n phi]`
//!
//! (odd multiples vanish by symmetry), each interpolated by a cubic through four nodes. Harmonics that
//! nowhere reach [`HARMONIC_FLOOR`] of `c_0` are left out: a `1 + Delta cos 2 phi` sea keeps one. The factor
//! `K^4` takes the steepness out of the spectrum.
//!
//! [`SpectrumTable::worst_relative_error`] is measured against the spectrum itself when the table is made:
//! between nodes, at azimuths that turn from node to node so that no narrow beam or cusp hides between them,
//! and on some circles at [`DENSE_AZIMUTHS`]; whoever chooses the path compares it with the error budget and
//! keeps the exact spectrum where it does not fit. (A relative error `e` of `Psi` is `e/2` of an amplitude.)
//! Outside its range the table asks the spectrum itself; [`SpectrumTable::for_bragg`] chooses the range so
//! that this is rare.
//!
//! ```
//! use nereus::scattering::spectrum_table::SpectrumTable;
//! let psi = |kx: f64, ky: f64| {
//!     let k2 = kx * kx + ky * ky;
//!     1e-3 / (k2 * k2) * (1.0 + 0.4 * (kx * kx - ky * ky) / k2)
//! };
//! let table = SpectrumTable::for_bragg(psi, 209.6, Some(70.0));
//! assert!(table.worst_relative_error() < 1e-9 && table.harmonics() == 1);
//! assert!((table.psi(120.0, 90.0) / psi(120.0, 90.0) - 1.0).abs() < 1e-9);
//! ```

use std::f64::consts::{PI, SQRT_2};

/// Share of `c_0` below which a harmonic is left out.
pub const HARMONIC_FLOOR: f64 = 1e-9;
/// Azimuths sampled over half a turn.
pub(super) const AZIMUTHS: usize = 32;
/// Coefficients on a circle: the mean, and cosine and sine of each harmonic.
pub(super) const COEFFICIENTS: usize = 1 + 2 * (AZIMUTHS / 2 - 1);
/// Azimuths over half a turn at which some circles are probed: 0.35 degrees apart, where the narrowest
/// spreading of a sea (`s = 1000`) is 5 degrees wide.
pub const DENSE_AZIMUTHS: usize = 512;
/// Every so many circles one is probed at all of these.
const DENSE_EVERY: usize = 64;
/// Share of the largest density on a circle below which errors count relative to that share: amplitudes of
/// -60 dB.
const LEAST_SHARE: f64 = 1e-6;
/// Nodes per factor e in wave number.
const NODES_PER_E: f64 = 100.0;
/// Most nodes of a table: bounds its memory whatever range is asked.
const MOST_NODES: usize = 8192;

/// A tabulated spectrum.
#[derive(Clone, Debug)]
pub struct SpectrumTable<F> {
    exact: F,
    log_from: f64,
    nodes_per_unit: f64,
    nodes: usize,
    harmonics: usize,
    /// Per node: `c_0`, then `c_n, s_n`.
    rows: Vec<f64>,
    worst_relative_error: f64,
}

impl<F: Fn(f64, f64) -> f64> SpectrumTable<F> {
    /// Tabulates what facets can ask of a Bragg spectrum: from half an octave below the cutoff (without one,
    /// from `k/1000`) to `2k`, `k` the radar wave number, rad/m.
    pub fn for_bragg(psi: F, wavenumber_radpm: f64, cut_radpm: Option<f64>) -> Self {
        let to = 2.0 * wavenumber_radpm;
        let from = cut_radpm.map_or(1e-3 * wavenumber_radpm, |cut| cut / SQRT_2);
        Self::new(psi, from.clamp(1e-6 * to, 0.9 * to), to)
    }

    /// Tabulates `psi(kx, ky)`, m^4, for `from <= K <= to`, rad/m, `0 < from < to`.
    pub fn new(psi: F, from_radpm: f64, to_radpm: f64) -> Self {
        let log_from = from_radpm.ln();
        let span = (to_radpm.ln() - log_from).max(1e-6);
        let cells = ((span * NODES_PER_E).ceil().max(4.0) as usize).min(MOST_NODES);
        let nodes_per_unit = cells as f64 / span;
        // One node more on either side for the cubic.
        let nodes = cells + 3;
        let width = COEFFICIENTS;
        let mut full = Vec::with_capacity(nodes * width);
        for node in 0..nodes {
            let k = (log_from + (node as f64 - 1.0) / nodes_per_unit).exp();
            full.extend_from_slice(&harmonics_at(&psi, k));
        }
        let harmonics = harmonics_above(HARMONIC_FLOOR, &full);
        let rows =
            full.chunks_exact(width).flat_map(|row| row[..1 + 2 * harmonics].iter().copied()).collect();
        let mut table =
            Self { exact: psi, log_from, nodes_per_unit, nodes, harmonics, rows, worst_relative_error: 0.0 };
        table.worst_relative_error = table.measure(cells);
        table
    }

    /// Harmonics kept in addition to the mean.
    pub fn harmonics(&self) -> usize {
        self.harmonics
    }

    /// Largest `|table - psi|/psi` over points between nodes (where `psi` is below 1e-6 of the largest on its
    /// circle: relative to that share).
    pub fn worst_relative_error(&self) -> f64 {
        self.worst_relative_error
    }

    /// Spectrum at a wave vector, m^4.
    #[inline]
    pub fn psi(&self, kx: f64, ky: f64) -> f64 {
        let k2 = kx * kx + ky * ky;
        let position = (0.5 * k2.ln() - self.log_from) * self.nodes_per_unit;
        // Half a cell of grace: the ends themselves are inside whatever the rounding.
        if !(position >= -0.5 && position <= (self.nodes - 3) as f64 + 0.5) {
            return (self.exact)(kx, ky);
        }
        let cell = (position.max(0.0) as usize).min(self.nodes - 4);
        let x = position - cell as f64;
        let (m, p, q) = (x + 1.0, x - 1.0, x - 2.0);
        let weights = [-x * p * q / 6.0, m * p * q / 2.0, -m * x * q / 2.0, m * x * p / 6.0];
        let width = 1 + 2 * self.harmonics;
        let rows = &self.rows[cell * width..(cell + 4) * width];
        let at = |column: usize| {
            weights[0] * rows[column]
                + weights[1] * rows[width + column]
                + weights[2] * rows[2 * width + column]
                + weights[3] * rows[3 * width + column]
        };
        let inverse = 1.0 / k2;
        let (cos2, sin2) = ((kx * kx - ky * ky) * inverse, 2.0 * kx * ky * inverse);
        let (mut cos, mut sin) = (cos2, sin2);
        let mut sum = at(0);
        for n in 1..=self.harmonics {
            sum += at(2 * n - 1) * cos + at(2 * n) * sin;
            (cos, sin) = (cos * cos2 - sin * sin2, sin * cos2 + cos * sin2);
        }
        sum.max(0.0) * inverse * inverse
    }

    fn measure(&self, cells: usize) -> f64 {
        let mut worst: f64 = 0.0;
        for cell in 0..cells {
            let k = (self.log_from + (cell as f64 + 0.5) / self.nodes_per_unit).exp();
            let of_azimuth = |azimuth: f64| {
                let (sin, cos) = azimuth.sin_cos();
                let exact = (self.exact)(k * cos, k * sin).max(0.0);
                [exact, exact, self.psi(k * cos, k * sin)]
            };
            let values: Vec<[f64; 3]> = probe_azimuths(cell).into_iter().map(of_azimuth).collect();
            worst = worst.max(relative_error(&values, f64::MIN_POSITIVE));
        }
        worst
    }
}

/// Azimuths over half a turn at which the circle of a number is probed.
pub(super) fn probe_azimuths(circle: usize) -> Vec<f64> {
    /// Fraction of the golden section: multiples of it leave no gap.
    const TURN: f64 = 0.618_033_988_749_894_9;
    let count = if circle.is_multiple_of(DENSE_EVERY) { DENSE_AZIMUTHS } else { AZIMUTHS };
    let turned = (circle as f64 * TURN).fract();
    (0..count).map(|j| PI * (j as f64 + turned) / count as f64).collect()
}

/// Largest relative error on a circle of `[whole, exact, found]`: relative to the whole density, nowhere to
/// less than [`LEAST_SHARE`] of the largest; 0 where there is nothing above `least`.
pub(super) fn relative_error(values: &[[f64; 3]], least: f64) -> f64 {
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
pub(super) fn harmonics_above(floor: f64, rows: &[f64]) -> usize {
    let exceeds = |row: &[f64], n: usize| row[2 * n - 1].abs().max(row[2 * n].abs()) > floor * row[0].abs();
    let somewhere = |n: &usize| rows.chunks_exact(COEFFICIENTS).any(|row| exceeds(row, *n));
    (1..AZIMUTHS / 2).rev().find(somewhere).unwrap_or(0)
}

/// `c_0`, then `c_n, s_n`, of `K^4 Psi` on the circle of radius `k`.
pub(super) fn harmonics_at(psi: impl Fn(f64, f64) -> f64, k: f64) -> [f64; COEFFICIENTS] {
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
