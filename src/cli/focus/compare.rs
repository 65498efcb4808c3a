//! `nereus focus --nav both`: what errors of the reports do to the image, predicted and measured.
//!
//! Predictions come from the recorded paths ([`crate::processor::degradation`]), measurements from the images
//! by true and by reported navigation. What the scenario alone tells stands beside them ([`super::forecast`],
//! [`super::aim`]).

use super::figures::{Channel, Comparison, Figures, Pixels, Target};
use std::io::Write;

use num_complex::{Complex32, Complex64};

use super::aim::Aim;
use super::forecast::laws;
use super::{
    CliError, FocusArgs, FocusNav, FocusTaper, Focused, Header, Scenario, aperture, channels, compressor,
    expected, ground, one, outputs, paths, pictures, table, values,
};
use crate::cli::focus::error::FocusError;
use crate::cli::json;
use crate::cli::outputs::save_canvas;
use crate::cli::sea::SeaError;
use crate::pipeline::memory::available_bytes;
use crate::plot::chart::{Curve, Mark, Plot, PlotAxis, Spacing};
use crate::processor::backproject::{Aperture, fast};
use crate::processor::degradation::{CUT, Look, Prediction, Response, respond};
use crate::processor::point_target::Support;
use crate::processor::range_compress::Compressor;
use crate::recording::Recording;
use crate::recording::ground::Ground;
use crate::recording::output::{FileKind, Output};

/// Cells about a point that are no sea.
const POINT_CELLS: f64 = 10.0;
/// Points of a cut to a dot of the prediction.
const DOTS: usize = 8;
/// Lowest level of a picture of cuts, dB.
const FLOOR_DB: f64 = -60.0;

/// An image that is taken as right.
struct Measure<'a> {
    recording: &'a Recording,
    scenario: &'a Scenario,
    compressor: &'a Compressor,
}

/// Refuses what belongs to other ways to look.
pub(super) fn check(args: &FocusArgs) -> Result<(), FocusError> {
    if args.nav == FocusNav::Both {
        let allowed = "with --nav true or --nav reported";
        let refused = FocusError::Value { key: "speckle", found: "with --nav both".to_owned(), allowed };
        return if args.speckle { Err(refused) } else { Ok(()) };
    }
    for (key, found) in [("against", &args.against), ("cuts", &args.cuts)] {
        if let Some(found) = found {
            let found = found.display().to_string();
            return Err(FocusError::Value { key, found, allowed: "with --nav both only" });
        }
    }
    Ok(())
}

/// Focuses twice and compares.
pub(super) fn compare(
    args: &FocusArgs,
    recording: &Recording,
    scenario: &Scenario,
    names: &[String],
    out: &mut dyn Write,
) -> Result<(), CliError> {
    let places = recording.channels().to_vec();
    let doubled: Vec<String> =
        names.iter().flat_map(|name| [format!("{name}_true"), format!("{name}_reported")]).collect();
    if let Some(path) = args.cuts.as_ref().filter(|_| recording.header.targets.is_empty()) {
        let found = path.display().to_string();
        return Err(FocusError::Value { key: "cuts", found, allowed: "for a recording of targets" }.into());
    }
    let outputs = outputs(args, &doubled)?;
    let mut cuts = Vec::new();
    for path in args.cuts.iter().flat_map(|path| pictures(path, names)) {
        cuts.push(Output::plan(&path, FileKind::Png, args.force).map_err(FocusError::from)?);
    }
    let ground = ground(args, recording, scenario, places[0])?;
    let compressor = compressor(args, recording)?;
    let other = match &args.against {
        Some(path) => Some(reference(args, path, recording)?),
        None => None,
    };
    let measure = match &other {
        Some((recording, scenario, compressor)) => Measure { recording, scenario, compressor },
        None => Measure { recording, scenario, compressor: &compressor },
    };
    let mut told = Vec::with_capacity(places.len());
    let mut images = Vec::with_capacity(2 * places.len());
    for (place, channel) in places.iter().enumerate() {
        let right_place = measure.recording.channels()[place];
        let both =
            Both { args, recording, scenario, compressor: &compressor, ground: &ground, measure: &measure };
        let (channel, [right, wrong]) = both.channel(*channel, right_place)?;
        told.push(channel);
        images.extend([right, wrong]);
    }
    let mut made = Vec::new();
    let nav = |place: usize| [FocusNav::True, FocusNav::Reported][place % 2];
    super::draw(args, recording, &ground, &images, outputs.pictures, nav, &mut made)?;
    for (output, channel) in cuts.into_iter().zip(&told) {
        made.push(output.path().to_owned());
        draw_cuts(channel, output)?;
    }
    if let Some(output) = outputs.values {
        made.push(output.path().to_owned());
        values(args, recording, &ground, &doubled, &images, output)?;
    }
    let comparison = Comparison {
        recording: args.recording.display().to_string(),
        against: args.against.as_ref().map(|path| path.display().to_string()),
        nav: "both",
        pulses: recording.pulses(),
        first_pulse: recording.index[0],
        last_pulse: recording.index[recording.index.len() - 1],
        centre_m: ground.centre_m(),
        pixels: ground.pixels,
        pixel_m: args.pixel_m,
        channels: told,
        out: json::all_legible(&made),
    };
    table::print(args, &comparison, out)
}

/// The recording that is the measure: as many pulses of the same radar, with the same channels.
fn reference(
    args: &FocusArgs,
    path: &std::path::Path,
    like: &Recording,
) -> Result<(Recording, Scenario, Compressor), FocusError> {
    let range = args.pulses.map(|p| p.first..p.end);
    let named = FocusArgs { recording: path.to_owned(), ..args.clone() };
    let choose = |header: &Header| channels(&named, header);
    let right = Recording::open_channels(path, range, available_bytes(), choose)?;
    let (a, b) = (&right.header, &like.header);
    let channels = |of: &Recording| -> Vec<String> {
        of.channels().iter().map(|place| of.header.channels[*place].name.clone()).collect()
    };
    let differs = [
        ("carrier_hz", a.carrier_hz != b.carrier_hz),
        ("bandwidth_hz", a.bandwidth_hz != b.bandwidth_hz),
        ("prf_hz", a.prf_hz != b.prf_hz),
        ("pulses", right.index != like.index),
        ("channels", channels(&right) != channels(like)),
        ("targets", a.targets != b.targets),
    ];
    if let Some((what, _)) = differs.iter().find(|(_, differs)| *differs) {
        return Err(FocusError::Against { path: path.to_owned(), what });
    }
    let scenario = Scenario::of(&right);
    let compressor = compressor(&named, &right)?;
    Ok((right, scenario, compressor))
}

/// What both images are made of.
struct Both<'a> {
    args: &'a FocusArgs,
    recording: &'a Recording,
    scenario: &'a Scenario,
    compressor: &'a Compressor,
    ground: &'a Ground,
    measure: &'a Measure<'a>,
}

impl Both<'_> {
    fn channel(&self, channel: usize, right_channel: usize) -> Result<(Channel, [Focused; 2]), FocusError> {
        let (args, recording, ground) = (self.args, self.recording, self.ground);
        let by = |nav| FocusArgs { nav, ..args.clone() };
        let right = one(
            &by(FocusNav::True),
            self.measure.recording,
            self.measure.scenario,
            self.measure.compressor,
            ground,
            right_channel,
        )?;
        let wrong = one(&by(FocusNav::Reported), recording, self.scenario, self.compressor, ground, channel)?;
        let row = &recording.header.channels[channel];
        let truth = paths(FocusNav::True, recording, channel)?;
        let reported = paths(FocusNav::Reported, recording, channel)?;
        let right_paths = paths(FocusNav::True, self.measure.recording, right_channel)?;
        let believed = aperture(
            args,
            recording,
            self.scenario,
            self.compressor,
            ground,
            [&reported[0], &reported[1]],
            channel,
        )?;
        let known = aperture(
            args,
            self.measure.recording,
            self.measure.scenario,
            self.measure.compressor,
            ground,
            [&right_paths[0], &right_paths[1]],
            right_channel,
        )?;
        let rights = expected(self.measure.recording, ground, right_channel);
        let aim = args.against.as_ref().map(|_| {
            [(recording, channel), (self.measure.recording, right_channel)]
                .map(|(of, channel)| Aim::of(of, channel))
        });
        let mut targets = Vec::new();
        for (name, point_m) in expected(recording, ground, channel) {
            // Pulses that the point takes through the gate, and what they weigh there.
            let pulses = believed.pulses.iter().enumerate();
            let (times_s, weights): (Vec<f64>, Vec<f64>) = pulses
                .filter(|(place, _)| believed.takes(*place, point_m))
                .map(|(place, pulse)| {
                    let middle_s = pulse.emission_s + self.compressor.middle_s();
                    (middle_s, believed.weight(place, pulse, point_m))
                })
                .unzip();
            let look = Look {
                carrier_hz: recording.header.carrier_hz,
                bandwidth_hz: recording.header.bandwidth_hz,
                taper: args.window.taper(),
                times_s: &times_s,
                weights: &weights,
                truth: [&truth[0], &truth[1]],
                reported: [&reported[0], &reported[1]],
            };
            let right_m =
                rights.iter().find(|(other, _)| *other == name).map_or(point_m, |(_, place)| *place);
            let aim_loss_db = match &aim {
                Some([Some(wrong), Some(right)]) => wrong
                    .gain(&times_s, point_m)
                    .zip(right.gain(&times_s, right_m))
                    .map(|(wrong, right)| 20.0 * (right / wrong).log10()),
                _ => None,
            }
            .filter(|loss| loss.is_finite());
            let prediction = look.predict(point_m);
            let measured =
                prediction.as_ref().and_then(|p| measured(&look, p, [&known, &believed], [right_m, point_m]));
            let curves = [
                measured.as_ref().map(|(right, _, _)| curve(right, right.amplitude, 1)),
                measured.as_ref().map(|(right, wrong, _)| curve(wrong, right.amplitude, 1)),
                prediction.as_ref().map(|p| curve(&p.response, 1.0, DOTS)),
            ]
            .map(Option::unwrap_or_default);
            targets.push(Target {
                name,
                expected_m: point_m,
                laws: laws(self.scenario, row, &look, point_m, args.aperture == FocusTaper::None),
                terms: prediction.as_ref().map(|p| p.terms),
                aim_loss_db,
                predicted: prediction.as_ref().map(|p| predicted(p, aim_loss_db.unwrap_or(0.0))),
                measured: measured.map(|(_, _, figures)| figures),
                curves,
            });
        }
        let pixels = pixels([&right, &wrong], ground, wrong.support.as_ref(), &targets);
        let channel = Channel {
            name: row.name.clone(),
            pulses: wrong.pulses,
            cell_m: right.support.map(|s| s.cuts().map(|(_, cell)| cell)),
            directions: right.support.map(|s| s.cuts().map(|(direction, _)| direction)),
            pixels,
            targets,
        };
        Ok((channel, [right, wrong]))
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

/// The point in the image by true and in that by reported navigation, where the prediction says that it is.
fn measured(
    look: &Look,
    prediction: &Prediction,
    [known, believed]: [&Aperture; 2],
    [right_m, point_m]: [[f64; 3]; 2],
) -> Option<(Response, Response, Figures)> {
    let cells = Support::of(known, right_m)?;
    let right = respond(&|grounds| images(known, grounds), &cells, right_m)?;
    let support = look.support(look.reported, prediction.fitted_m)?;
    let wrong = respond(&|grounds| images(believed, grounds), &support, prediction.fitted_m)?;
    let at = |aperture: &Aperture, place_m: [f64; 3]| {
        let image = images(aperture, &[Ground::line(place_m, [0.0; 3], 1)]);
        image.first().and_then(|image| image.first().copied())
    };
    let turned = at(believed, prediction.response.place_m)? * at(known, right_m)?.conj();
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
fn pixels(
    [right, wrong]: [&Focused; 2],
    ground: &Ground,
    support: Option<&Support>,
    targets: &[Target],
) -> Pixels {
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
    let [columns, _] = ground.pixels;
    let far = |pixel: usize| {
        let [x, y, _] = ground.point_m((pixel % columns) as f64, (pixel / columns) as f64);
        points
            .iter()
            .all(|[px, py]| support.cells([x - px, y - py]).iter().any(|cells| cells.abs() > POINT_CELLS))
    };
    let wide = |z: Complex32| Complex64::new(z.re.into(), z.im.into());
    let (mut count, mut sums, mut squares, mut cross) = (0, [0.0; 2], [0.0; 2], Complex64::ZERO);
    let both = right.image.iter().zip(&wrong.image).enumerate();
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

/// The cut in cross-range of the first point that has one.
fn draw_cuts(channel: &Channel, output: Output) -> Result<(), CliError> {
    let shown = channel.targets.iter().find(|target| target.curves.iter().all(|curve| !curve.is_empty()));
    let none = [Vec::new(), Vec::new(), Vec::new()];
    let [right, measured, predicted] = shown.map_or(&none, |target| &target.curves);
    let point = shown.map_or("no point on the image", |target| target.name.as_str());
    let limits = [10f64.powf(0.1 * FLOOR_DB), 10f64.powf(0.3)];
    let canvas = Plot {
        title: &format!("{}, {point}: reported navigation", channel.name),
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
    .map_err(SeaError::from)?;
    Ok(save_canvas(output, &canvas)?)
}
