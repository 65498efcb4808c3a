//! The report of `nereus focus`.

use std::path::PathBuf;

use serde::Serialize;

use super::{FocusArgs, NAVS};
use crate::cli::error::{CliError, Refused};
use crate::cli::report::Report;
use crate::cli::values::word_of;
use crate::cli::{counted, escape};
use crate::clutter::fits::{Speckle, SpeckleSettings};
use crate::processor::focus::{Focuser, Image, ImageFigures};
use crate::processor::point_target::{PointTarget, SEARCH_CELLS, WIDEST};

/// Samples drawn from a law, and most pixels of a test.
const RESAMPLES: usize = 99;
const TEST_PIXELS: usize = 10_000;

/// Side lobes above this, dB, make it doubtful whether a main lobe is that of the point.
const UNCLEAR_PSLR_DB: f64 = -6.0;

/// A point of the truth record by its name; nothing where no main lobe is found.
type Target = (String, Option<PointTarget>);

#[derive(Debug, Serialize)]
struct Channel {
    #[serde(flatten)]
    image: ImageFigures,
    /// Laws fitted to single pixels; none unless asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    speckle: Option<Speckle>,
    targets: Vec<NamedTarget>,
}

#[derive(Debug, Serialize)]
struct NamedTarget {
    name: String,
    #[serde(flatten)]
    found: Option<PointTarget>,
}

/// Begins a report with what all images have in common: `images` is what they are, `how` how they are made.
pub(super) fn begun(args: &FocusArgs, focuser: &Focuser, images: &str, how: &str) -> Report {
    let (recording, ground) = (focuser.recording(), focuser.ground());
    let ([x, y, z], [columns, rows]) = (ground.centre_m(), ground.pixels);
    let (pulses, first) = (recording.pulses(), recording.index[0]);
    let last = recording.index[recording.index.len() - 1];
    let mut report = Report::default();
    report.line(format!(
        "{images:<12}{columns} x {rows} pixels of {} m about {x:.1} m East, {y:.1} m North, {z:.1} m up",
        args.pixel_m
    ));
    report.line(format!("pulses      {pulses} ({first} to {last}){how}"));
    report.value("recording", args.recording.display().to_string());
    if args.nav().is_none() {
        report.value("against", args.against.as_ref().map(|path| path.display().to_string()));
    }
    report.value("nav", word_of(&NAVS, &args.nav())).value("pulses", pulses);
    report.value("first_pulse", first).value("last_pulse", last).value("centre_m", [x, y, z]);
    report.value("pixels", [columns, rows]).value("pixel_m", args.pixel_m);
    report
}

/// Of images and the points on each, made in so many seconds; `out` are the files made of them.
pub(super) fn report(
    args: &FocusArgs,
    focuser: &Focuser,
    (images, targets): (&[Image], &[Vec<Target>]),
    seconds: f64,
    out: &[PathBuf],
) -> Result<Report, CliError> {
    let work: f64 = images.iter().map(|image| image.pulses as f64 * focuser.ground().len() as f64).sum();
    let per_s = work / seconds.max(1e-9);
    let nav = word_of(&NAVS, &args.nav());
    let how = format!(", {nav} navigation; {seconds:.1} s, {:.1} M pulse-pixels/s", per_s * 1e-6);
    let mut report = begun(args, focuser, "image", &how);
    // Predicted error of interpolation between cells of a compressed pulse, dB.
    report.value("interpolation_db", focuser.interpolation_error_db());
    report.value("seconds", seconds).value("pulse_pixels_per_s", per_s);
    let seed = focuser.recording().header.seed;
    let settings = SpeckleSettings { resamples: RESAMPLES, test_pixels: TEST_PIXELS, seed };
    let mut channels = Vec::with_capacity(images.len());
    for (image, targets) in images.iter().zip(targets) {
        let figures = image.figures(args.looks, args.percentile.unwrap_or(98.0));
        let tapers = [args.window, args.aperture];
        let speckle = args.speckle.then(|| Speckle::of_image(image, tapers, &settings)).transpose();
        let speckle =
            speckle.map_err(|source| Refused::Speckle { channel: image.channel.clone(), source })?;
        add_image(&mut report, &figures);
        if let Some(speckle) = &speckle {
            add_speckle(&mut report, speckle);
        }
        targets.iter().for_each(|target| add_target(&mut report, target, figures.cell_m));
        let named = |(name, found): &Target| NamedTarget { name: name.clone(), found: *found };
        channels.push(Channel { image: figures, speckle, targets: targets.iter().map(named).collect() });
    }
    report.value("channels", channels).paths("out", out);
    Ok(report)
}

fn add_image(report: &mut Report, figures: &ImageFigures) {
    let cells = match figures.cell_m {
        Some([range, cross]) => format!("cells of {range:.2} m by {cross:.2} m"),
        None => "no cross-range".to_owned(),
    };
    let power = match (figures.mean_dbw, figures.peak_dbw) {
        (Some(mean), Some(peak)) => {
            format!("mean {mean:.1} dBW, peak {peak:.1} dBW, contrast {:.2}", figures.contrast)
        }
        _ => "no power".to_owned(),
    };
    let band = figures.doppler_hz.map_or(String::new(), |hz| format!(" in a band of {hz:.1} Hz"));
    let (name, pulses) = (escape::name(&figures.name), counted(figures.pulses, "pulse"));
    report.line(format!("{name:<11} {power}; {pulses}{band}, {cells}"));
}

fn add_speckle(report: &mut Report, speckle: &Speckle) {
    let [x, y] = speckle.step;
    report.line(format!(
        "  speckle          {} pixels, every {x} to the East and {y} to the North; contrast {:.3} +- {:.3}; the test takes {} of them",
        speckle.pixels, speckle.contrast, speckle.contrast_error, speckle.test_pixels
    ));
    for fits in &speckle.laws {
        let shape = if fits.law == "rayleigh" {
            String::new()
        } else {
            let [a, b, c] = [&fits.moments, &fits.likelihood, &fits.histogram].map(ToString::to_string);
            format!("shape by moments {a}, by likelihood {b}, by histogram {c}; ")
        };
        let p = fits.probability.map_or(String::new(), |p| format!(", p = {p:.2}"));
        report.line(format!("    {:<14} {shape}Kolmogorov-Smirnov {:.4}{p}", fits.law, fits.distance));
    }
}

fn add_target(report: &mut Report, (name, found): &Target, cell_m: Option<[f64; 2]>) {
    let name = escape::name(name);
    let Some(p) = found else {
        // About the place where the navigation in use puts the point.
        let searched = cell_m.map_or(String::new(), |cells| {
            let [range, cross] = cells.map(|cell_m| SEARCH_CELLS as f64 * cell_m);
            format!(
                " within {range:.1} m in range and {cross:.1} m in cross-range (a wide one within {:.1} m)",
                WIDEST * cross
            )
        });
        report.line(format!("  {name:<16} not found: no main lobe{searched}, or none that stands out"));
        return;
    };
    let highest_db = p.range.pslr_db.max(p.cross_range.pslr_db);
    let doubt = if highest_db > UNCLEAR_PSLR_DB { "; doubtful: no clear main lobe" } else { "" };
    report.line(format!(
        "  {name:<16} range {:.3} m ({:.3}), PSLR {:.1} dB, position error {:+.3} cells; cross-range {:.3} m ({:.3}), PSLR {:.1} dB, position error {:+.3} cells; phase {:+.3} rad{doubt}",
        p.range.width_m,
        p.range.theory_m,
        p.range.pslr_db,
        p.range.error_cells,
        p.cross_range.width_m,
        p.cross_range.theory_m,
        p.cross_range.pslr_db,
        p.cross_range.error_cells,
        p.phase_rad
    ));
}
