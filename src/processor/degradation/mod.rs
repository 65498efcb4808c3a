//! What navigation errors do to a point: predicted from the paths alone, without samples, and measured.
//!
//! A point whose echo comes by the true paths after `tau_m`, focused by the reported ones, is on the plane of
//! the image
//!
//! ```text
//! I(x) = sum_m w_m chi(B delta_m(x)) e^{j 2 pi f0 delta_m(x)} / sum_m w_m,   delta_m(x) = tau'_m(x) - tau_m
//! ```
//!
//! `tau'` the delay by the reported paths, `chi` the response of the range compression to a point (the
//! transform of the taper over the band). About the place where the point appears `delta_m` is taken as
//! linear in `x`, with the gradient of each pulse.
//!
//! * The place to look at is where the reported delays fit the true ones best ([`locate`]): errors of many
//!   cells are no different from small ones.
//! * Prediction and measurement go through one way ([`respond`]): the peak is sought within 6 cells of that
//!   place, cuts run along the lines of equal Doppler and of equal delay, 32 points per cell, 10 cells to
//!   either side. Where the image is so broken that another lobe is as high, the two may choose differently.
//! * [`PhaseTerms`] are the error over the aperture: its mean moves the point in range, the
//!   slope in cross-range, the bend widens it.
//! * [`laws`] has closed forms of errors that are known.
//!
//! Limits: gain equal over the aperture; what the point itself does to its Doppler is not in it; compression
//! is done with the Doppler of the reported paths, which leaves `delta f_D Tc/B` of range.
//!
//! ```
//! use nereus::processor::degradation::{Degradation, Prediction};
//! use nereus::geometry::phase_path::PhasePath;
//! use nereus::processor::taper::Taper;
//! // 10 GHz at 100 m/s, 4.2 km away; a climb of 10 mm/s is reported that was none.
//! let times_s: Vec<f64> = (0..400).map(|i| f64::from(i) * 5e-3).collect();
//! let fly = |climb_mps: f64| {
//!     let at = |t: &f64| [100.0 * (t - 1.0), -3000.0, 3000.0 + climb_mps * t];
//!     PhasePath::new(times_s.clone(), times_s.iter().map(at).collect())
//! };
//! let (truth, reported) = (fly(0.0)?, fly(0.01)?);
//! let degradation = Degradation {
//!     carrier_hz: 10e9,
//!     bandwidth_hz: 60e6,
//!     taper: Taper::Uniform,
//!     times_s: &times_s,
//!     weights: &[1.0; 400],
//!     truth: [&truth; 2],
//!     reported: [&reported; 2],
//! };
//! let point: Prediction = degradation.predict([0.0; 3]).unwrap();
//! // 10 mm/s along 45 degrees, both ways, 2 s, 30 mm: 0.943 cells.
//! assert!((point.terms.linear_cells + 0.943).abs() < 2e-3 && (point.shift_cells[1] + 0.943).abs() < 2e-3);
//! assert!(point.loss_db.abs() < 1e-3);
//! # Ok::<(), nereus::geometry::phase_path::PhasePathError>(())
//! ```

pub mod laws;
pub(crate) mod scenario;

use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use num_complex::Complex64;

use super::point_target::{Support, brightest, locate, measure_lobe};
use super::taper::Taper;
use crate::geometry::phase_path::{PhasePath, delay_gradient, delay_s};
use crate::recording::ground::Ground;

/// Points of the search to either side, and in a cell.
const SEARCH: [usize; 2] = [30, 5];
/// Cells of a cut to either side, and points in a cell.
pub const CUT: [usize; 2] = [10, 32];
/// Range cells over which the response of the compression is tabled, and points in a cell.
const TABLE: [usize; 2] = [32, 256];

/// A side lobe, or one of two paired echoes.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Lobe {
    /// From the peak, cells.
    pub cells: f64,
    /// Over the peak, dB.
    pub level_db: f64,
}

/// A cut through the peak.
#[derive(Clone, Debug, PartialEq)]
pub struct CutShape {
    /// Half-power width, m.
    pub width_m: f64,
    /// Length of a cell along the cut, m.
    pub cell_m: f64,
    /// Highest lobes within 10 cells before and behind the main one.
    pub lobes: [Option<Lobe>; 2],
    /// Power, 32 points per cell, 10 cells to either side of the peak.
    pub power: Vec<f64>,
}

impl CutShape {
    /// The higher one of the highest lobes of both sides.
    pub fn highest(&self) -> Option<Lobe> {
        self.lobes.iter().flatten().copied().max_by(|a, b| a.level_db.total_cmp(&b.level_db))
    }
}

/// How a point looks in an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// Where it is: the middle between the half-power points along both cuts, ENU, m.
    pub place_m: [f64; 3],
    /// Amplitude at the peak.
    pub amplitude: f64,
    /// Cuts in range and in cross-range.
    pub cuts: [CutShape; 2],
}

/// How a point near `start_m` looks in an image that `evaluate` gives at any points; none where there is no
/// main lobe within 6 cells.
pub fn respond(
    evaluate: &dyn Fn(&[Ground]) -> Vec<Vec<Complex64>>,
    support: &Support,
    start_m: [f64; 3],
) -> Option<Response> {
    let steps = support.cuts().map(|([x, y], cell_m)| [x * cell_m, y * cell_m, 0.0]);
    let scaled = |step: [f64; 3], by: f64| step.map(|x| x * by);
    let [side, fine] = SEARCH;
    let [x, y] = steps.map(|step| scaled(step, 1.0 / fine as f64));
    let back = -(side as f64);
    let chip = Ground {
        first_m: std::array::from_fn(|k| start_m[k] + back * (x[k] + y[k])),
        step_x_m: x,
        step_y_m: y,
        pixels: [2 * side + 1; 2],
    };
    let image = evaluate(std::slice::from_ref(&chip)).into_iter().next()?;
    let power: Vec<f64> = image.iter().map(Complex64::norm_sqr).collect();
    let (mut peak_m, inside) = brightest(&power, &chip);
    if !inside {
        return None;
    }
    let [cells, dense] = CUT;
    let cut = |peak_m: [f64; 3]| {
        let lines =
            steps.map(|step| Ground::line(peak_m, scaled(step, 1.0 / dense as f64), 2 * cells * dense + 1));
        let images = evaluate(&lines);
        let power = images.iter().map(|image| image.iter().map(Complex64::norm_sqr).collect::<Vec<f64>>());
        (lines, power.collect::<Vec<_>>())
    };
    let middle = (cells * dense) as f64;
    // The first cuts give the peak finer than the chip.
    let (lines, power) = cut(peak_m);
    for (line, power) in lines.iter().zip(&power) {
        let (top, _) = summit(power)?;
        peak_m = std::array::from_fn(|k| peak_m[k] + (top - middle) * line.step_x_m[k]);
    }
    let (lines, power) = cut(peak_m);
    let mut place_m = peak_m;
    let mut highest = 0.0f64;
    let mut shapes = Vec::with_capacity(2);
    for (i, power) in power.into_iter().enumerate() {
        let (top, height) = summit(&power)?;
        let measured = measure_lobe(&power, top.round() as usize)?;
        highest = highest.max(height);
        place_m = std::array::from_fn(|k| place_m[k] + (measured.peak - middle) * lines[i].step_x_m[k]);
        let cell_m = support.cuts()[i].1;
        let lobes = lobes(&power, top, height, dense as f64);
        shapes.push(CutShape { width_m: measured.width * cell_m / dense as f64, cell_m, lobes, power });
    }
    let cuts: [CutShape; 2] = shapes.try_into().ok()?;
    Some(Response { place_m, amplitude: highest.sqrt(), cuts })
}

/// The highest point of a cut within a cell of its middle and its height, by a parabola; none at an end of
/// that or of nothing. What lies further off, a neighbour or an echo that is higher than the main lobe, is
/// another's.
fn summit(power: &[f64]) -> Option<(f64, f64)> {
    let (middle, cell) = (power.len() / 2, CUT[1]);
    let near = middle.saturating_sub(cell)..(middle + cell + 1).min(power.len());
    let top = near.clone().max_by(|a, b| power[*a].total_cmp(&power[*b]))?;
    if top == near.start || top + 1 == near.end || !(power[top] > 0.0 && power[top].is_finite()) {
        return None;
    }
    Some(refined(power, top))
}

fn refined(power: &[f64], top: usize) -> (f64, f64) {
    let [before, at, after] = [power[top - 1], power[top], power[top + 1]];
    let bend = before - 2.0 * at + after;
    let shift = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    (top as f64 + shift, at - 0.25 * (before - after) * shift)
}

/// The highest maxima beyond the nulls on both sides of the main lobe.
fn lobes(power: &[f64], top: f64, height: f64, cell: f64) -> [Option<Lobe>; 2] {
    let middle = (top.round() as usize).clamp(1, power.len() - 2);
    let first = (1..=middle).rev().find(|i| power[i - 1] > power[*i]).unwrap_or(0);
    let last = (middle..power.len() - 1).find(|i| power[i + 1] > power[*i]).unwrap_or(power.len());
    let highest = |range: std::ops::Range<usize>| {
        let tops = range.filter(|i| {
            *i > 0 && *i + 1 < power.len() && power[*i] > power[i - 1] && power[*i] >= power[i + 1]
        });
        let place = tops.max_by(|a, b| power[*a].total_cmp(&power[*b]))?;
        let (at, lobe) = refined(power, place);
        Some(Lobe { cells: (at - top) / cell, level_db: 10.0 * (lobe / height).log10() })
    };
    [highest(0..first), highest(last..power.len())]
}

/// What an error of the path looks like over the aperture, at the place where the point should be.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct PhaseTerms {
    /// By the mean, cells of range.
    pub mean_cells: f64,
    /// By the slope, cells of cross-range.
    pub linear_cells: f64,
    /// Quadratic phase at the ends against the middle, rad.
    pub quadratic_rad: f64,
    /// Rest, rms, rad.
    pub rest_rad: f64,
}

impl PhaseTerms {
    /// Of the error of the delay in every pulse (reported less true), s: least squares over pulses that count
    /// alike.
    pub fn of(delta_s: &[f64], carrier_hz: f64, bandwidth_hz: f64) -> Self {
        let count = delta_s.len() as f64;
        if delta_s.is_empty() {
            return Self::default();
        }
        let along = |i: usize| (i as f64 + 0.5) / count - 0.5;
        let mean_s = delta_s.iter().sum::<f64>() / count;
        // s and s^2 less its mean are orthogonal over such pulses, and to a constant.
        let bent = (1.0 - 1.0 / (count * count)) / 12.0;
        let share = |basis: &dyn Fn(usize) -> f64| {
            let norm: f64 = (0..delta_s.len()).map(|i| basis(i).powi(2)).sum();
            let sum: f64 = delta_s.iter().enumerate().map(|(i, d)| (d - mean_s) * basis(i)).sum();
            if norm > 0.0 { sum / norm } else { 0.0 }
        };
        let slope_s = share(&along);
        let square = |i: usize| along(i).powi(2) - bent;
        let bend_s = share(&square);
        let rest = |(i, d): (usize, &f64)| (d - mean_s - slope_s * along(i) - bend_s * square(i)).powi(2);
        let rest_s = (delta_s.iter().enumerate().map(rest).sum::<f64>() / count).sqrt();
        Self {
            mean_cells: -bandwidth_hz * mean_s,
            linear_cells: -carrier_hz * slope_s,
            quadratic_rad: TAU * carrier_hz * bend_s * 0.25,
            rest_rad: TAU * carrier_hz * rest_s,
        }
    }
}

/// True and reported paths of one aperture: all that a prediction needs.
#[derive(Clone, Copy, Debug)]
pub struct Degradation<'a> {
    /// Carrier, Hz.
    pub carrier_hz: f64,
    /// Bandwidth, Hz.
    pub bandwidth_hz: f64,
    /// Taper over the band.
    pub taper: Taper,
    /// When the middle of each pulse left, s on the clock of the paths.
    pub times_s: &'a [f64],
    /// Weight of each pulse.
    pub weights: &'a [f64],
    /// Transmitter and receiver as they were.
    pub truth: [&'a PhasePath; 2],
    /// As the processor takes them.
    pub reported: [&'a PhasePath; 2],
}

/// What becomes of a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// Where it should be, ENU, m.
    pub expected_m: [f64; 3],
    /// Where the reported delays fit the true ones best, ENU, m: where to look.
    pub fitted_m: [f64; 3],
    /// How it looks by the reported paths; a point without error has an amplitude of 1.
    pub response: Response,
    /// Loss of the peak, dB, positive when it is lower.
    pub loss_db: f64,
    /// Place found less place expected, cells of range and cross-range.
    pub shift_cells: [f64; 2],
    /// The same along the cuts, m.
    pub shift_m: [f64; 2],
    /// Widths over those without error.
    pub width_ratio: [f64; 2],
    /// Phase at the place found, rad: what the error adds.
    pub phase_rad: f64,
    /// Its error over the aperture.
    pub terms: PhaseTerms,
}

impl Degradation<'_> {
    /// Measured wave numbers at a point by the true or by the reported paths.
    pub fn support(&self, [transmitter, receiver]: [&PhasePath; 2], point_m: [f64; 3]) -> Option<Support> {
        let gradient = |time_s: f64| delay_gradient(transmitter, receiver, time_s, point_m);
        let count = self.times_s.len();
        let (first, last) = (*self.times_s.first()?, *self.times_s.last()?);
        let middle = *self.times_s.get(count / 2)?;
        Support::spanned(
            [gradient(first), gradient(middle), gradient(last)],
            count,
            self.carrier_hz,
            self.bandwidth_hz,
        )
    }

    /// What the image by reported paths has at `at_m`, of a point that by the true paths appears at `point_m`
    /// with an amplitude of 1: every delay iterated.
    pub fn amplitude(&self, point_m: [f64; 3], at_m: [f64; 3]) -> Complex64 {
        let [transmitter, receiver] = self.reported;
        let late = |t: &f64| {
            delay_s(transmitter, receiver, *t, at_m) - delay_s(self.truth[0], self.truth[1], *t, point_m)
        };
        let pulses =
            self.times_s.iter().zip(self.weights).map(|(t, weight)| ([0.0; 2], late(t), *weight)).collect();
        self.model(at_m, pulses).at(at_m)
    }

    fn model(&self, about_m: [f64; 3], pulses: Vec<([f64; 2], f64, f64)>) -> Model {
        let (carrier_hz, bandwidth_hz) = (self.carrier_hz, self.bandwidth_hz);
        Model { about_m, pulses, carrier_hz, bandwidth_hz, chi: Chi::of(self.taper) }
    }

    /// Delays of a point by true paths, s.
    fn true_delays_s(&self, point_m: [f64; 3]) -> Vec<f64> {
        self.times_s.iter().map(|t| delay_s(self.truth[0], self.truth[1], *t, point_m)).collect()
    }

    /// What becomes of a point that by the true paths appears at `point_m`; none without cross-range, where
    /// the reported delays fit no place, or where no main lobe is left.
    pub fn predict(&self, point_m: [f64; 3]) -> Option<Prediction> {
        let true_s = self.true_delays_s(point_m);
        let [transmitter, receiver] = self.reported;
        let error = |x: [f64; 3]| -> Vec<f64> {
            let late = |(t, tau): (&f64, &f64)| delay_s(transmitter, receiver, *t, x) - tau;
            self.times_s.iter().zip(&true_s).map(late).collect()
        };
        let fitted_m = locate(transmitter, receiver, self.times_s, &true_s, point_m)?;
        let model = |about_m: [f64; 3], ends: [&PhasePath; 2], delta_s: &[f64]| {
            let gradient = |t: &f64| {
                let [x, y, _] = delay_gradient(ends[0], ends[1], *t, about_m);
                [x, y]
            };
            let pulses = self.times_s.iter().zip(delta_s).zip(self.weights);
            self.model(about_m, pulses.map(|((t, delta), weight)| (gradient(t), *delta, *weight)).collect())
        };
        let seen = |model: &Model, support: &Support| {
            respond(&|grounds| model.images(grounds), support, model.about_m)
        };
        let still = model(point_m, self.truth, &vec![0.0; true_s.len()]);
        let cells = self.support(self.truth, point_m)?;
        let without = seen(&still, &cells)?;
        let wrong = model(fitted_m, self.reported, &error(fitted_m));
        let response = seen(&wrong, &self.support(self.reported, fitted_m)?)?;
        let moved: [f64; 2] = std::array::from_fn(|k| response.place_m[k] - without.place_m[k]);
        let shift_cells = cells.cells(moved);
        let lengths = cells.cuts();
        Some(Prediction {
            expected_m: point_m,
            fitted_m,
            loss_db: -20.0 * (response.amplitude / without.amplitude).log10(),
            shift_cells,
            shift_m: std::array::from_fn(|i| shift_cells[i] * lengths[i].1),
            width_ratio: std::array::from_fn(|i| response.cuts[i].width_m / without.cuts[i].width_m),
            phase_rad: wrong.at(response.place_m).arg(),
            terms: PhaseTerms::of(&error(point_m), self.carrier_hz, self.bandwidth_hz),
            response,
        })
    }
}

/// An image of one point by wrong paths.
struct Model {
    about_m: [f64; 3],
    /// Gradient of the delay (s/m), error of the delay (s), weight.
    pulses: Vec<([f64; 2], f64, f64)>,
    carrier_hz: f64,
    bandwidth_hz: f64,
    chi: Chi,
}

impl Model {
    fn at(&self, point_m: [f64; 3]) -> Complex64 {
        let [x, y] = [point_m[0] - self.about_m[0], point_m[1] - self.about_m[1]];
        let (mut sum, mut weights) = (Complex64::ZERO, 0.0);
        for ([gx, gy], delta_s, weight) in &self.pulses {
            let late_s = delta_s + gx * x + gy * y;
            let turns = self.carrier_hz * late_s;
            sum += Complex64::cis(TAU * (turns - turns.round()))
                * (weight * self.chi.at(self.bandwidth_hz * late_s));
            weights += weight;
        }
        if weights == 0.0 { Complex64::ZERO } else { sum / weights }
    }

    fn images(&self, grounds: &[Ground]) -> Vec<Vec<Complex64>> {
        let image = |ground: &Ground| {
            let [columns, rows] = ground.pixels;
            let all = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
            all.map(|(i, j)| self.at(ground.point_m(i as f64, j as f64))).collect()
        };
        grounds.iter().map(image).collect()
    }
}

/// Response of the range compression to a point: transform of the taper over the band, tabled.
struct Chi(&'static [f64]);

impl Chi {
    fn of(taper: Taper) -> Self {
        static TABLES: [OnceLock<Vec<f64>>; 4] = [const { OnceLock::new() }; 4];
        let table = match taper {
            Taper::Uniform => &TABLES[0],
            Taper::Hann => &TABLES[1],
            Taper::Taylor => &TABLES[2],
            Taper::Kaiser => &TABLES[3],
        };
        Self(table.get_or_init(|| transform(taper)))
    }

    /// At so many cells; nothing beyond the table.
    fn at(&self, cells: f64) -> f64 {
        let place = cells.abs() * TABLE[1] as f64;
        let before = place as usize;
        match (self.0.get(before), self.0.get(before.saturating_add(1))) {
            (Some(a), Some(b)) => a + (b - a) * (place - before as f64),
            _ => 0.0,
        }
    }
}

/// Transform of a taper, 1 at no distance.
fn transform(taper: Taper) -> Vec<f64> {
    let cells = 256;
    let weights: Vec<[f64; 2]> = (0..cells)
        .map(|i| (f64::from(i) + 0.5) / f64::from(cells) - 0.5)
        .map(|x| [x, taper.weight(x)])
        .collect();
    let sum: f64 = weights.iter().map(|[_, w]| w).sum();
    let at = |u: f64| weights.iter().map(|[x, w]| w * (2.0 * PI * u * x).cos()).sum::<f64>() / sum;
    (0..=TABLE[0] * TABLE[1]).map(|i| at(i as f64 / TABLE[1] as f64)).collect()
}
