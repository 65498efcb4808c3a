//! What an image makes of a point.
//!
//! Near a point the image is the transform of what was measured in the space of wave numbers. On the image's
//! plane, `d` from the point,
//!
//! ```text
//! I(d) = a sinc(b_1 . d) sinc(b_2 . d),   b_1 = B grad tau,   b_2 = f0 (grad tau_last - grad tau_first) M/(M - 1)
//! ```
//!
//! `grad tau` the gradient of the bistatic delay along the plane (`(u_T + u_R)/c` projected), cycles per
//! metre; `M` pulses, those that the point takes with the Doppler weights of the aperture. `b_1` and `b_2`
//! need not be perpendicular. So the cut **in range** runs along the line of equal Doppler (across `b_2`),
//! the cut **in cross-range** along the line of equal delay (across `b_1`): each is one sinc. Half-power
//! width `0.8859 / |b . e|` along the cut `e` (of a taper: [`Taper::width`]), highest side lobe -13.26 dB, a
//! cell is `1 / |b . e|`.
//!
//! Limits: apertures and relative bandwidths small enough that the support is a parallelogram (its curvature
//! moves cells by `f0 B^-1 theta^2/8`, theta the angle that the aperture spans); gain equal over the
//! aperture.
//!
//! The image is not interpolated: the peak is sought on a fine grid, then both cuts are back-projected at 32
//! points per cell.
//!
//! | figure | what |
//! | --- | --- |
//! | width | between the half-power points of the cut, m |
//! | PSLR | highest side lobe within 10 cells over the peak, dB |
//! | ISLR | energy outside the nulls of the main lobe, within 10 cells, over that between them, dB |
//! | error | middle between the half-power points less place expected, cells along both cuts |
//! | phase | of the image at the place expected, rad |
//!
//! ```
//! use nereus::processor::point_target::measure_cut;
//! // Two sincs a tenth of a cell fine.
//! let cut: Vec<f64> = (-200..=200)
//!     .map(|i| f64::from(i) * 0.05 * std::f64::consts::PI)
//!     .map(|x| if x == 0.0 { 1.0 } else { (x.sin() / x).powi(2) })
//!     .collect();
//! let found = measure_cut(&cut).unwrap();
//! assert!((found.width * 0.05 - 0.8859).abs() < 1e-3 && (found.pslr_db + 13.26).abs() < 0.05);
//! ```

use glam::{DMat2, DVec2};
use num_complex::Complex32;

use super::backproject::{Aperture, PulseEcho, fast};
use super::multilook::percentile;
use super::taper::Taper;
use crate::geometry::phase_path::{PhasePath, delay_gradient, delay_s};
use crate::recording::ground::Ground;

/// Cells to either side of its place within which a point is sought.
pub const SEARCH_CELLS: usize = 6;
/// Points of the search in a cell.
const SEARCH_FINE: usize = 5;
/// Lengths of steps in cross-range, in cells by theory, that are tried one after the other.
const WIDENINGS: [f64; 3] = [1.0, 4.0, WIDEST];
/// The longest of them.
pub const WIDEST: f64 = 16.0;
/// A point is one when its peak is so far above the median of what is around it, dB.
const CLEAR_DB: f64 = 13.0;
/// Cells of a cut to either side, and points in a cell.
const CUT: [usize; 2] = [10, 32];

/// Extent of the measured wave numbers on the plane of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// `b_1`, cycles/m East and North.
    pub range: [f64; 2],
    /// `b_2`, cycles/m East and North.
    pub cross: [f64; 2],
}

impl Support {
    /// Of an aperture at a point; none without two pulses, or where range and cross-range are one direction.
    pub fn of(aperture: &Aperture, point_m: [f64; 3]) -> Option<Self> {
        let taken = (0..aperture.pulses.len()).filter(|place| aperture.takes(*place, point_m));
        let pulses: Vec<&PulseEcho> = taken.filter_map(|place| aperture.pulses.get(place)).collect();
        let (first, last) = (pulses.first()?, pulses.last()?);
        let gradient = |emission_s: f64| {
            let middle_s = emission_s + aperture.compressor.middle_s();
            delay_gradient(aperture.transmitter, aperture.receiver, middle_s, point_m)
        };
        let gradients = [first, &pulses[pulses.len() / 2], last].map(|pulse| gradient(pulse.emission_s));
        Self::spanned(gradients, pulses.len(), aperture.carrier_hz, aperture.compressor.bandwidth_hz())
    }

    /// Of the gradients of the delay (s/m) in the first, the middle and the last of so many pulses.
    pub(super) fn spanned(
        gradients: [[f64; 3]; 3],
        pulses: usize,
        carrier_hz: f64,
        bandwidth_hz: f64,
    ) -> Option<Self> {
        let [first, middle, last] = gradients.map(|[x, y, _]| DVec2::new(x, y));
        let share = pulses as f64 / (pulses as f64 - 1.0).max(1.0);
        let across = (last - first) * (carrier_hz * share);
        let along = middle * bandwidth_hz;
        let independent = along.perp_dot(across).abs() > 1e-9 * along.length() * across.length();
        independent.then(|| Self { range: along.to_array(), cross: across.to_array() })
    }

    /// Directions of the cuts in range and in cross-range (unit vectors, East and North), and the length of a
    /// cell along each, m.
    pub fn cuts(&self) -> [([f64; 2], f64); 2] {
        let (range, cross) = (DVec2::from(self.range), DVec2::from(self.cross));
        let cut = |along: DVec2, across: DVec2| {
            let e = across.perp().normalize_or_zero();
            let e = if e.dot(along) < 0.0 { -e } else { e };
            (e.to_array(), 1.0 / along.dot(e))
        };
        [cut(range, cross), cut(cross, range)]
    }

    /// Coarsest distance of pixels East and North that samples the amplitude of the image, m:
    /// `1 / (|b_1| + |b_2|)` along the axis where it is less.
    pub fn coarsest_pixel_m(&self) -> f64 {
        let extent = |axis: usize| self.range[axis].abs() + self.cross[axis].abs();
        1.0 / extent(0).max(extent(1))
    }

    /// A displacement in cells of range and cross-range.
    pub fn cells(&self, displacement_m: [f64; 2]) -> [f64; 2] {
        let d = DVec2::from(displacement_m);
        [DVec2::from(self.range).dot(d), DVec2::from(self.cross).dot(d)]
    }
}

/// What a cut of power through a point shows, in points of the cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredCut {
    /// Place of the main lobe: the middle between the half-power points, which a flat top has too.
    pub peak: f64,
    /// Half-power width.
    pub width: f64,
    /// Highest side lobe over the peak, dB.
    pub pslr_db: f64,
    /// Energy of the side lobes over that of the main lobe, dB.
    pub islr_db: f64,
}

/// Measures a cut of power; none where there is no main lobe with both its sides in it.
pub fn measure_cut(power: &[f64]) -> Option<MeasuredCut> {
    measure_lobe(power, (0..power.len()).max_by(|a, b| power[*a].total_cmp(&power[*b]))?)
}

/// The same with the lobe about a point of the cut as the main one, the highest or not.
pub(super) fn measure_lobe(power: &[f64], top: usize) -> Option<MeasuredCut> {
    if top == 0 || top + 1 >= power.len() || power[top] <= 0.0 || !power[top].is_finite() {
        return None;
    }
    let [before, at, after] = [power[top - 1], power[top], power[top + 1]];
    let bend = before - 2.0 * at + after;
    let shift = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    let height = at - 0.25 * (before - after) * shift;
    let half = 0.5 * height;
    let right = (top..power.len() - 1).find(|i| power[i + 1] < half)?;
    let left = (1..=top).rev().find(|i| power[i - 1] < half)?;
    let upper = right as f64 + (power[right] - half) / (power[right] - power[right + 1]);
    let lower = left as f64 - (power[left] - half) / (power[left] - power[left - 1]);
    let last = (right..power.len() - 1).find(|i| power[i + 1] > power[*i])?;
    let first = (1..=left).rev().find(|i| power[i - 1] > power[*i])?;
    let sides = || power[..first].iter().chain(&power[last + 1..]);
    let highest = sides().fold(0.0, |a: f64, b| a.max(*b));
    let main: f64 = power[first..=last].iter().sum();
    Some(MeasuredCut {
        peak: 0.5 * (upper + lower),
        width: upper - lower,
        pslr_db: 10.0 * (highest / height).log10(),
        islr_db: 10.0 * (sides().sum::<f64>() / main).log10(),
    })
}

/// One cut through a point.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Cut {
    /// East and North components of its direction.
    pub direction: [f64; 2],
    /// Half-power width, m.
    pub width_m: f64,
    /// The same by theory, m.
    pub theory_m: f64,
    /// Highest side lobe, dB.
    pub pslr_db: f64,
    /// Integrated side lobes, dB.
    pub islr_db: f64,
    /// Middle of the main lobe less expected place, in cells.
    pub error_cells: f64,
}

/// What an image makes of a point.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct PointTarget {
    /// Where it should be, ENU, m.
    pub expected_m: [f64; 3],
    /// Where it is, ENU, m.
    pub found_m: [f64; 3],
    /// Amplitude at the peak, sqrt(W).
    pub amplitude: f64,
    /// Phase at the place expected, rad.
    pub phase_rad: f64,
    /// Along the line of equal Doppler.
    pub range: Cut,
    /// Along the line of equal delay.
    pub cross_range: Cut,
}

/// A point that is sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sought {
    /// Where it should be, m: the error of its place is counted from here.
    pub expected_m: [f64; 3],
    /// About where it is sought, m: the same place, moved by what is known to be wrong with the navigation.
    pub about_m: [f64; 3],
}

impl From<[f64; 3]> for Sought {
    fn from(place_m: [f64; 3]) -> Self {
        Self { expected_m: place_m, about_m: place_m }
    }
}

/// Measures points about given places; none for those that show no main lobe within [`SEARCH_CELLS`] of
/// theirs, or none that stands out of noise and sea. `tapers` are those over the band and over the pulses.
///
/// A cell in cross-range is that of all pulses. Where a narrow beam passes over a point, few of them carry
/// its echo, and its main lobe is wider than what is searched. Points that are not found are sought again in
/// cross-range steps that are 4 and 16 times as long, for main lobes of at least as many cells: what is sharp
/// is not taken from further away.
pub fn analyse(aperture: &Aperture, sought: &[Sought], tapers: [Taper; 2]) -> Vec<Option<PointTarget>> {
    let supports: Vec<Option<Support>> =
        sought.iter().map(|point| Support::of(aperture, point.about_m)).collect();
    let mut found = vec![None; sought.len()];
    for widening in WIDENINGS {
        let left: Vec<usize> = (0..sought.len()).filter(|place| found[*place].is_none()).collect();
        let points: Vec<(Sought, Option<Support>)> =
            left.iter().map(|place| (sought[*place], supports[*place])).collect();
        for (place, point) in left.iter().zip(measure((aperture, sought), &points, tapers, widening)) {
            found[*place] = point;
        }
    }
    found
}

/// The same in cross-range steps so many times as long.
fn measure(
    (aperture, sought): (&Aperture, &[Sought]),
    points: &[(Sought, Option<Support>)],
    tapers: [Taper; 2],
    widening: f64,
) -> Vec<Option<PointTarget>> {
    let scaled = |step: [f64; 3], by: f64| step.map(|x| x * by);
    let scales = [1.0, widening];
    // An aperture without cross-range still gets a grid, of no use, so that places in the lists agree.
    let steps: Vec<[[f64; 3]; 2]> = points
        .iter()
        .map(|(_, support)| {
            support.map_or([[0.0; 3]; 2], |s| {
                let cuts = s.cuts();
                std::array::from_fn(|i| {
                    let ([x, y], cell) = cuts[i];
                    scaled([x, y, 0.0], cell * scales[i])
                })
            })
        })
        .collect();
    let (side, fine) = (SEARCH_CELLS * SEARCH_FINE, SEARCH_FINE);
    let chips: Vec<Ground> = points
        .iter()
        .zip(&steps)
        .map(|((point, _), step)| {
            let [x, y] = step.map(|s| scaled(s, 1.0 / fine as f64));
            let back = -(side as f64);
            Ground {
                first_m: std::array::from_fn(|k| point.about_m[k] + back * (x[k] + y[k])),
                step_x_m: x,
                step_y_m: y,
                pixels: [2 * side + 1; 2],
            }
        })
        .collect();
    let (peaks, clear): (Vec<[f64; 3]>, Vec<Option<bool>>) = fast(aperture, &chips, &|_| ())
        .iter()
        .zip(chips.iter().zip(points))
        .map(|(image, (chip, (point, _)))| {
            let mut power: Vec<f64> =
                image.iter().map(|z| f64::from(z.re).powi(2) + f64::from(z.im).powi(2)).collect();
            let all = power.clone();
            let crowded = leave_to_neighbours(&mut power, chip, point.about_m, sought);
            (brightest(&power, chip).0, stands_out(&power, &all).then_some(crowded))
        })
        .unzip();
    let [cells, dense] = CUT;
    let lines: Vec<Ground> = peaks
        .iter()
        .zip(&steps)
        .zip(points)
        .flat_map(|((peak, [range, cross]), (point, _))| {
            let line = |step: &[f64; 3]| {
                Ground::line(*peak, scaled(*step, 1.0 / dense as f64), 2 * cells * dense + 1)
            };
            [line(range), line(cross), Ground::line(point.expected_m, [0.0; 3], 1)]
        })
        .collect();
    let images = fast(aperture, &lines, &|_| ());
    points
        .iter()
        .zip(lines.chunks_exact(3).zip(images.chunks_exact(3)))
        .zip(clear)
        .map(|(((point, support), (lines, images)), clear)| {
            let found = judge((*support)?, (point.expected_m, clear?), lines, images, tapers, scales)?;
            let cells = found.cross_range.width_m / support.as_ref()?.cuts()[1].1;
            (widening == 1.0 || cells >= widening).then_some(found)
        })
        .collect()
}

fn judge(
    support: Support,
    (expected_m, crowded): ([f64; 3], bool),
    lines: &[Ground],
    images: &[Vec<Complex32>],
    tapers: [Taper; 2],
    scales: [f64; 2],
) -> Option<PointTarget> {
    let power = |image: &[Complex32]| -> Vec<f64> { image.iter().map(|z| f64::from(z.norm_sqr())).collect() };
    let powers = [power(&images[0]), power(&images[1])];
    // Beside a neighbour, which may be higher, within a cell of the middle, where the brightest pixel is.
    // What is higher elsewhere is what this is a side lobe of.
    let top = |power: &[f64]| {
        let (middle, reach) = (power.len() / 2, if crowded { CUT[1] } else { power.len() });
        let near = middle.saturating_sub(reach)..(middle + reach + 1).min(power.len());
        near.max_by(|a, b| power[*a].total_cmp(&power[*b]))
    };
    let tops = [top(&powers[0])?, top(&powers[1])?];
    let cuts = [measure_lobe(&powers[0], tops[0])?, measure_lobe(&powers[1], tops[1])?];
    let mut found_m = lines[0].centre_m();
    for (cut, line) in cuts.iter().zip(lines) {
        let off = cut.peak - 0.5 * (line.pixels[0] as f64 - 1.0);
        found_m = std::array::from_fn(|k| found_m[k] + off * line.step_x_m[k]);
    }
    let error = support.cells([found_m[0] - expected_m[0], found_m[1] - expected_m[1]]);
    let cut = |i: usize| {
        let (direction, cell_m) = support.cuts()[i];
        Cut {
            direction,
            width_m: cuts[i].width * cell_m * scales[i] / CUT[1] as f64,
            theory_m: tapers[i].width() * cell_m,
            pslr_db: cuts[i].pslr_db,
            islr_db: cuts[i].islr_db,
            error_cells: error[i],
        }
    };
    Some(PointTarget {
        expected_m,
        found_m,
        amplitude: powers[0][tops[0]].sqrt(),
        phase_rad: f64::from(images[2].first()?.arg()),
        range: cut(0),
        cross_range: cut(1),
    })
}

/// Whether the brightest pixel is [`CLEAR_DB`] above the median: a chip of noise or sea has some hundred
/// cells, of which the brightest is 8 dB above.
fn stands_out(power: &[f64], all: &[f64]) -> bool {
    let top = power.iter().copied().fold(0.0, f64::max);
    let median = percentile(all, 50.0).unwrap_or(0.0);
    top > 0.0 && top >= median * 10f64.powf(CLEAR_DB / 10.0)
}

/// Empties the pixels that lie nearer another point that is sought, in cells; whether one is that near.
fn leave_to_neighbours(power: &mut [f64], chip: &Ground, own_m: [f64; 3], sought: &[Sought]) -> bool {
    let steps = [chip.step_x_m, chip.step_y_m];
    let from = |to_m: [f64; 3], from_m: [f64; 3]| -> f64 {
        let along = |step: &[f64; 3]| {
            let dot: f64 = (0..3).map(|k| (to_m[k] - from_m[k]) * step[k]).sum();
            dot / step.iter().map(|x| x * x).sum::<f64>()
        };
        steps.iter().map(|step| along(step).powi(2)).sum()
    };
    // Those within twice the search: nearer a pixel than the point in the middle.
    let side = chip.pixels[0] as f64;
    let others = sought.iter().map(|other| other.about_m).filter(|other_m| *other_m != own_m);
    let near: Vec<[f64; 3]> = others.filter(|other_m| from(*other_m, own_m) < 2.0 * side * side).collect();
    if near.is_empty() {
        return false;
    }
    let columns = chip.pixels[0];
    for (n, power) in power.iter_mut().enumerate() {
        let pixel_m = chip.point_m((n % columns) as f64, (n / columns) as f64);
        let own = from(pixel_m, own_m);
        if near.iter().any(|other_m| from(pixel_m, *other_m) < own) {
            *power = 0.0;
        }
    }
    true
}

/// The brightest pixel's place, refined by a parabola along both sides of the grid, and whether it lies
/// within the grid's edge.
pub(super) fn brightest(power: &[f64], chip: &Ground) -> ([f64; 3], bool) {
    let [columns, rows] = chip.pixels;
    let at = |i: usize, j: usize| power[j * columns + i];
    let top = (0..power.len()).max_by(|a, b| power[*a].total_cmp(&power[*b]));
    let (i, j) = top.map_or((0, 0), |top| (top % columns, top / columns));
    let shift = |before: f64, at: f64, after: f64| {
        let bend = before - 2.0 * at + after;
        if bend < 0.0 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 }
    };
    if i == 0 || j == 0 || i + 1 >= columns || j + 1 >= rows {
        return (chip.point_m(i as f64, j as f64), false);
    }
    let x = i as f64 + shift(at(i - 1, j), at(i, j), at(i + 1, j));
    let y = j as f64 + shift(at(i, j - 1), at(i, j), at(i, j + 1));
    (chip.point_m(x, y), true)
}

/// Where on the plane of `start_m` a target appears whose delays are recorded: the point at rest whose delays
/// come nearest (least squares, Gauss and Newton). A high target lies over, a moving one is displaced, as in
/// the image. None where fewer than two delays are numbers or the delays do not determine a place.
pub fn locate(
    transmitter: &PhasePath,
    receiver: &PhasePath,
    emissions_s: &[f64],
    delays_s: &[f64],
    start_m: [f64; 3],
) -> Option<[f64; 3]> {
    let known: Vec<(f64, f64)> = emissions_s
        .iter()
        .zip(delays_s)
        .filter(|(_, tau)| tau.is_finite())
        .map(|(t, tau)| (*t, *tau))
        .collect();
    if known.len() < 2 {
        return None;
    }
    let mut point = start_m;
    for _ in 0..40 {
        let (mut normal, mut right) = (DMat2::ZERO, DVec2::ZERO);
        for (t, tau) in &known {
            let [x, y, _] = delay_gradient(transmitter, receiver, *t, point);
            let gradient = DVec2::new(x, y) * crate::units::SPEED_OF_LIGHT_MPS;
            let missed = (tau - delay_s(transmitter, receiver, *t, point)) * crate::units::SPEED_OF_LIGHT_MPS;
            normal += DMat2::from_cols(gradient * gradient.x, gradient * gradient.y);
            right += gradient * missed;
        }
        let scale = normal.x_axis.x + normal.y_axis.y;
        if normal.determinant().abs() <= 1e-13 * scale * scale {
            return None;
        }
        let step = normal.inverse() * right;
        if !step.is_finite() {
            return None;
        }
        // A step beyond the linear range would leave for the wrong side of the track.
        let step = step.clamp_length_max(2000.0);
        point[0] += step.x;
        point[1] += step.y;
        if step.length() < 1e-5 {
            return Some(point);
        }
    }
    None
}
