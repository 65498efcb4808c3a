//! Images of one grid by true and by reported navigation: what errors of the reports do, predicted and
//! measured.
//!
//! Predictions come from the recorded paths ([`super::degradation`]), measurements from the images. What
//! follows from the scenario alone stands beside them: [`super::degradation::scenario`], and the loss by an
//! aim that is wrong ([`super::two_way_gain`]).

use num_complex::{Complex32, Complex64};
use serde::Serialize;

use super::backproject::{Aperture, fast};
use super::degradation::scenario::{Law, laws};
use super::degradation::{CUT, Degradation, Lobe, PhaseTerms, Prediction, Response, respond};
use super::focus::{FocusError, Focuser, Image, Navigation};
use super::point_target::Support;
use super::two_way_gain::{TwoWayGain, pulse_zero_s};
use crate::geometry::phase_path::PhasePath;
use crate::plot::canvas::Canvas;
use crate::plot::chart::{Curve, Mark, Plot, PlotAxis, PlotError, Spacing};
use crate::recording::Recording;
use crate::recording::ground::Ground;

/// Cells about a point that are no sea.
const POINT_CELLS: f64 = 10.0;
/// Lowest level of a picture of cuts, dB.
const FLOOR_DB: f64 = -60.0;
/// Points of a cut to a dot of the prediction.
const DOTS: usize = 8;

/// One channel.
#[derive(Debug, Serialize)]
pub struct ChannelComparison {
    /// Its name.
    pub name: String,
    /// Pulses of the image by reported navigation.
    pub pulses: usize,
    /// Length of a cell in range and in cross-range in the middle of the image, m, by theory.
    pub cell_m: Option<[f64; 2]>,
    /// Directions in which shifts in range and in cross-range count, East and North, in the middle of the
    /// image.
    pub directions: Option<[[f64; 2]; 2]>,
    /// Pixels without points.
    pub pixels: Pixels,
    /// Points of the truth record on the image.
    pub targets: Vec<Target>,
}

/// Both images, pixel by pixel, points left out.
#[derive(Debug, Default, PartialEq, Serialize)]
pub struct Pixels {
    /// How many.
    pub count: usize,
    /// Mean power by true over mean power by reported navigation, dB.
    pub mean_loss_db: Option<f64>,
    /// `<I^2>/<I>^2` by true and by reported navigation.
    pub contrast: Option<[f64; 2]>,
    /// `|<I_r I_t*>| / sqrt(<|I_r|^2> <|I_t|^2>)`.
    pub coherence: Option<f64>,
}

/// A point.
#[derive(Debug, Serialize)]
pub struct Target {
    /// Its name.
    pub name: String,
    /// Where it should be, ENU, m.
    pub expected_m: [f64; 3],
    /// Errors of the scenario, in closed form.
    pub laws: Vec<Law>,
    /// The error of the path over the aperture.
    pub terms: Option<PhaseTerms>,
    /// Loss by aim that differs from that of the recording compared with, two-way, dB; part of the loss
    /// predicted.
    pub aim_loss_db: Option<f64>,
    /// From the paths.
    pub predicted: Option<Figures>,
    /// From the images.
    pub measured: Option<Figures>,
    /// Cuts in cross-range by true navigation, by reported navigation and as predicted: power over the peak
    /// without error.
    #[serde(skip)]
    pub curves: [Vec<[f64; 2]>; 3],
}

/// How a point looks by reported navigation compared with true navigation.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    /// Loss of the peak, dB.
    pub loss_db: f64,
    /// Shift in range and cross-range, cells.
    pub shift_cells: [f64; 2],
    /// The same, m along the cuts.
    pub shift_m: [f64; 2],
    /// Half-power widths over those by true navigation.
    pub width_ratio: [f64; 2],
    /// Highest lobes before and behind, of the cut in range.
    pub range_lobes: [Option<Lobe>; 2],
    /// The same of the cut in cross-range: side lobes or paired echoes.
    pub cross_range_lobes: [Option<Lobe>; 2],
    /// Phase at the place predicted, less that by true navigation at the place expected, rad.
    pub phase_rad: f64,
}

impl ChannelComparison {
    /// A picture of the cut in cross-range of the first point that has one.
    ///
    /// # Errors
    /// Figures that cannot be drawn.
    pub fn cuts(&self) -> Result<Canvas, PlotError> {
        let shown = self.targets.iter().find(|target| target.curves.iter().all(|curve| !curve.is_empty()));
        let none = [Vec::new(), Vec::new(), Vec::new()];
        let [right, measured, predicted] = shown.map_or(&none, |target| &target.curves);
        let point = shown.map_or("no point on the image", |target| target.name.as_str());
        let limits = [10f64.powf(0.1 * FLOOR_DB), 10f64.powf(0.3)];
        Plot {
            title: &format!("{}, {point}: reported navigation", self.name),
            x: PlotAxis { label: "cross-range, cells from the peak", spacing: Spacing::Linear, limits: None },
            y: PlotAxis {
                label: "over the peak without error, dB",
                spacing: Spacing::Decibels,
                limits: Some(limits),
            },
            curves: &[
                Curve { name: "true navigation", points: right, mark: Mark::Line },
                Curve { name: "measured", points: measured, mark: Mark::Line },
                Curve { name: "predicted", points: predicted, mark: Mark::Dots },
            ],
            size_px: [720, 400],
        }
        .draw()
    }
}

/// What two recordings must share to be compared, and do not: as many pulses of the same radar, with the same
/// channels and targets.
pub fn difference(recording: &Recording, other: &Recording) -> Option<&'static str> {
    let (a, b) = (&recording.header, &other.header);
    let channels = |of: &Recording| -> Vec<String> {
        of.channels().iter().map(|place| of.header.channels[*place].name.clone()).collect()
    };
    [
        ("carrier_hz", a.carrier_hz != b.carrier_hz),
        ("bandwidth_hz", a.bandwidth_hz != b.bandwidth_hz),
        ("prf_hz", a.prf_hz != b.prf_hz),
        ("pulses", recording.index != other.index),
        ("channels", channels(recording) != channels(other)),
        ("targets", a.targets != b.targets),
    ]
    .into_iter()
    .find_map(|(what, differs)| differs.then_some(what))
}

impl Figures {
    /// The side (before or behind the peak in cross-range) on which the highest lobe stands.
    pub fn highest_side(&self) -> usize {
        let level = |lobe: &Option<Lobe>| lobe.map_or(f64::NEG_INFINITY, |lobe| lobe.level_db);
        let [before, behind] = &self.cross_range_lobes;
        usize::from(level(behind) > level(before))
    }
}

/// An image, and what it was made from.
pub struct Side<'a> {
    /// Makes it.
    pub focuser: &'a Focuser<'a>,
    /// Place of its channel in the recording.
    pub channel: usize,
    /// The image.
    pub image: &'a Image,
    /// Gains of the antennas, where the two sides may differ in their aim.
    pub gain: Option<TwoWayGain<'a>>,
}

/// Compares the image by reported navigation (`wrong`) with one of the same grid by true navigation
/// (`right`), of the same recording or of one without what is wrong.
///
/// # Errors
/// Phase centres that a recording lacks, and all else that keeps it from being focused.
pub fn compare(right: &Side, wrong: &Side) -> Result<ChannelComparison, FocusError> {
    let paths = |side: &Side, nav| side.focuser.paths(nav, side.channel);
    let truth = paths(wrong, Navigation::True)?;
    let reported = paths(wrong, Navigation::Reported)?;
    let targets = right.focuser.with_aperture(right.channel, |right_aperture| {
        wrong.focuser.with_aperture(wrong.channel, |wrong_aperture| {
            let both =
                Both { right, wrong, right_aperture, wrong_aperture, truth: &truth, reported: &reported };
            both.targets()
        })
    })??;
    let support = right.image.support;
    Ok(ChannelComparison {
        name: wrong.image.channel.clone(),
        pulses: wrong.image.pulses,
        cell_m: support.map(|s| s.cuts().map(|(_, cell)| cell)),
        directions: support.map(|s| s.cuts().map(|(direction, _)| direction)),
        pixels: pixels([right.image, wrong.image], wrong.image.support.as_ref(), &targets),
        targets,
    })
}

/// Both sides with their apertures, and the paths of the one that is compared.
struct Both<'a> {
    right: &'a Side<'a>,
    wrong: &'a Side<'a>,
    right_aperture: &'a Aperture<'a>,
    wrong_aperture: &'a Aperture<'a>,
    truth: &'a [PhasePath; 2],
    reported: &'a [PhasePath; 2],
}

impl Both<'_> {
    fn targets(&self) -> Vec<Target> {
        let rights = self.right.focuser.expected(self.right.channel);
        let place = |name: &String| rights.iter().find(|(other, _)| other == name).map(|(_, place)| *place);
        let all = self.wrong.focuser.expected(self.wrong.channel);
        let target = |(name, point_m)| {
            let right_m = place(&name).unwrap_or(point_m);
            self.target(name, [right_m, point_m])
        };
        all.into_iter().map(target).collect()
    }

    /// A point, where it is by the right and by the wrong recording.
    fn target(&self, name: String, [right_m, point_m]: [[f64; 3]; 2]) -> Target {
        let (focuser, wrong_aperture) = (self.wrong.focuser, self.wrong_aperture);
        let header = &focuser.recording().header;
        // Pulses that the point takes through the gate, and what they weigh there.
        let pulses = wrong_aperture.pulses.iter().enumerate();
        let (times_s, weights): (Vec<f64>, Vec<f64>) = pulses
            .filter(|(place, _)| wrong_aperture.takes(*place, point_m))
            .map(|(place, pulse)| {
                (pulse.emission_s + focuser.middle_s(), wrong_aperture.weight(place, pulse, point_m))
            })
            .unzip();
        let degradation = Degradation {
            carrier_hz: header.carrier_hz,
            bandwidth_hz: header.bandwidth_hz,
            taper: focuser.settings().window,
            times_s: &times_s,
            weights: &weights,
            truth: self.truth.each_ref(),
            reported: self.reported.each_ref(),
        };
        let gain = |side: &Side, at_m| side.gain.as_ref()?.mean(&times_s, at_m);
        let gains = gain(self.wrong, point_m).zip(gain(self.right, right_m));
        let aim_loss_db =
            gains.map(|(wrong, right)| 20.0 * (right / wrong).log10()).filter(|db| db.is_finite());
        let prediction = degradation.predict(point_m);
        let found = prediction.as_ref().and_then(|p| {
            measured(&degradation, p, [self.right_aperture, wrong_aperture], [right_m, point_m])
        });
        let curves = [
            found.as_ref().map(|(right, _, _)| curve(right, right.amplitude, 1)),
            found.as_ref().map(|(right, wrong, _)| curve(wrong, right.amplitude, 1)),
            prediction.as_ref().map(|p| curve(&p.response, 1.0, DOTS)),
        ];
        let laws = focuser.scenario().and_then(|described| {
            let zero_s = pulse_zero_s(focuser.recording(), described.scene)?;
            let row = &header.channels[self.wrong.channel];
            Some(laws(described, row, &degradation, point_m, zero_s, focuser.settings().aperture))
        });
        Target {
            name,
            expected_m: point_m,
            laws: laws.unwrap_or_default(),
            terms: prediction.as_ref().map(|p| p.terms),
            aim_loss_db,
            predicted: prediction.as_ref().map(|p| predicted(p, aim_loss_db.unwrap_or(0.0))),
            measured: found.map(|(_, _, figures)| figures),
            curves: curves.map(Option::unwrap_or_default),
        }
    }
}

fn predicted(of: &Prediction, aim_loss_db: f64) -> Figures {
    Figures {
        loss_db: of.loss_db + aim_loss_db,
        shift_cells: of.shift_cells,
        shift_m: of.shift_m,
        width_ratio: of.width_ratio,
        range_lobes: of.response.cuts[0].lobes,
        cross_range_lobes: of.response.cuts[1].lobes,
        phase_rad: of.phase_rad,
    }
}

/// The point in the image by true and in that by reported navigation, where it is by the prediction.
fn measured(
    degradation: &Degradation,
    prediction: &Prediction,
    [right_aperture, wrong_aperture]: [&Aperture; 2],
    [right_m, point_m]: [[f64; 3]; 2],
) -> Option<(Response, Response, Figures)> {
    let cells = Support::of(right_aperture, right_m)?;
    let right = respond(&|grounds| images(right_aperture, grounds), &cells, right_m)?;
    let support = degradation.support(degradation.reported, prediction.fitted_m)?;
    let wrong = respond(&|grounds| images(wrong_aperture, grounds), &support, prediction.fitted_m)?;
    let at = |aperture: &Aperture, place_m: [f64; 3]| {
        let image = images(aperture, &[Ground::line(place_m, [0.0; 3], 1)]);
        image.first().and_then(|image| image.first().copied())
    };
    let turned = at(wrong_aperture, prediction.response.place_m)? * at(right_aperture, right_m)?.conj();
    let off = |found: [f64; 3], place: [f64; 3]| [found[0] - place[0], found[1] - place[1]];
    // What the image by true navigation is off by is no error of the reports.
    let (a, b) = (cells.cells(off(wrong.place_m, point_m)), cells.cells(off(right.place_m, right_m)));
    let shift_cells: [f64; 2] = std::array::from_fn(|i| a[i] - b[i]);
    let figures = Figures {
        loss_db: -20.0 * (wrong.amplitude / right.amplitude).log10(),
        shift_cells,
        shift_m: std::array::from_fn(|i| shift_cells[i] * cells.cuts()[i].1),
        width_ratio: std::array::from_fn(|i| wrong.cuts[i].width_m / right.cuts[i].width_m),
        range_lobes: wrong.cuts[0].lobes,
        cross_range_lobes: wrong.cuts[1].lobes,
        phase_rad: turned.arg(),
    };
    Some((right, wrong, figures))
}

fn images(aperture: &Aperture, grounds: &[Ground]) -> Vec<Vec<Complex64>> {
    let wide = |z: Complex32| Complex64::new(z.re.into(), z.im.into());
    fast(aperture, grounds, &|_| ()).into_iter().map(|image| image.into_iter().map(wide).collect()).collect()
}

/// A cut in cross-range: cells from the peak, power over that of a peak; every so many points.
fn curve(response: &Response, amplitude: f64, every: usize) -> Vec<[f64; 2]> {
    let [cells, dense] = CUT;
    let place = |i: usize| i as f64 / dense as f64 - cells as f64;
    let power = response.cuts[1].power.iter().enumerate();
    power.map(|(i, p)| [place(i), p / (amplitude * amplitude)]).step_by(every).collect()
}

/// Both images where there are no points.
fn pixels([right, wrong]: [&Image; 2], support: Option<&Support>, targets: &[Target]) -> Pixels {
    let Some(support) = support else { return Pixels::default() };
    let moved = |target: &Target| {
        let found = target.predicted.as_ref().map(|p| {
            let cuts = support.cuts();
            std::array::from_fn::<f64, 2, _>(|k| {
                target.expected_m[k] + (0..2).map(|i| p.shift_m[i] * cuts[i].0[k]).sum::<f64>()
            })
        });
        [[target.expected_m[0], target.expected_m[1]]].into_iter().chain(found)
    };
    let points: Vec<[f64; 2]> = targets.iter().flat_map(moved).collect();
    let ground = &right.ground;
    let [columns, _] = ground.pixels;
    let far = |pixel: usize| {
        let [x, y, _] = ground.point_m((pixel % columns) as f64, (pixel / columns) as f64);
        points
            .iter()
            .all(|[px, py]| support.cells([x - px, y - py]).iter().any(|cells| cells.abs() > POINT_CELLS))
    };
    let wide = |z: Complex32| Complex64::new(z.re.into(), z.im.into());
    let (mut count, mut sums, mut squares, mut cross) = (0, [0.0; 2], [0.0; 2], Complex64::ZERO);
    let both = right.values.iter().zip(&wrong.values).enumerate();
    for (_, (a, b)) in both.filter(|(pixel, _)| far(*pixel)) {
        let (a, b) = (wide(*a), wide(*b));
        count += 1;
        for (i, power) in [a.norm_sqr(), b.norm_sqr()].into_iter().enumerate() {
            sums[i] += power;
            squares[i] += power * power;
        }
        cross += b * a.conj();
    }
    if !sums.iter().all(|sum| *sum > 0.0) {
        return Pixels { count, ..Pixels::default() };
    }
    let n = count as f64;
    Pixels {
        count,
        mean_loss_db: Some(10.0 * (sums[0] / sums[1]).log10()),
        contrast: Some(std::array::from_fn(|i| n * squares[i] / (sums[i] * sums[i]))),
        coherence: Some(cross.norm() / (sums[0] * sums[1]).sqrt()),
    }
}
