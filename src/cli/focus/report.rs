//! The report of `nereus focus`.

use std::io::Write;
use std::path::PathBuf;

use serde::Serialize;

use super::{CliError, FocusArgs, Focused, speckle};
use crate::cli::focus::error::FocusError;
use crate::cli::{counted, escape, json, say};
use crate::clutter::fits::Speckle;
use crate::processor::focus::Focuser;
use crate::processor::multilook::{levels, percentile};
use crate::processor::point_target::{PointTarget, SEARCH_CELLS, WIDEST};

/// What `--json` prints.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    recording: String,
    nav: &'static str,
    pulses: usize,
    first_pulse: u64,
    last_pulse: u64,
    centre_m: [f64; 3],
    pixels: [usize; 2],
    pixel_m: f64,
    /// Predicted error of interpolation between cells of a compressed pulse, dB.
    interpolation_db: f64,
    seconds: f64,
    pulse_pixels_per_s: f64,
    channels: Vec<Channel>,
    out: Vec<PathBuf>,
}

#[derive(Debug, Serialize)]
struct Channel {
    name: String,
    pulses: usize,
    /// Doppler band about the aim from which a pixel takes its pulses, Hz; none: all pulses.
    doppler_hz: Option<f64>,
    /// Length of a cell in range and in cross-range in the middle of the image, m, by theory.
    cell_m: Option<[f64; 2]>,
    /// None where the image has no power.
    mean_dbw: Option<f64>,
    peak_dbw: Option<f64>,
    /// Amplitude that `--percentile` percent of the pixels do not exceed, 98 unless given, sqrt(W).
    percentile_amplitude: Option<f64>,
    /// `<I^2>/<I>^2` of the power: 2 for speckle.
    contrast: f64,
    /// Laws fitted to single pixels; none unless asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    speckle: Option<Speckle>,
    targets: Vec<Target>,
}

#[derive(Debug, Serialize)]
struct Target {
    name: String,
    /// None where no main lobe is found.
    #[serde(flatten)]
    found: Option<PointTarget>,
}

pub(super) fn report(
    args: &FocusArgs,
    focuser: &Focuser,
    focused: &[Focused],
    seconds: f64,
    out: Vec<PathBuf>,
) -> Result<Report, FocusError> {
    let (recording, ground) = (focuser.recording(), focuser.ground());
    let work: f64 = focused.iter().map(|f| f.image.pulses as f64 * ground.len() as f64).sum();
    Ok(Report {
        recording: args.recording.display().to_string(),
        nav: args.nav().name(),
        pulses: recording.pulses(),
        first_pulse: recording.index[0],
        last_pulse: recording.index[recording.index.len() - 1],
        centre_m: ground.centre_m(),
        pixels: ground.pixels,
        pixel_m: args.pixel_m,
        interpolation_db: focuser.interpolation_error_db(),
        seconds,
        pulse_pixels_per_s: work / seconds.max(1e-9),
        channels: focused
            .iter()
            .map(|f| channel(args, recording.header.seed, f))
            .collect::<Result<_, _>>()?,
        out: json::all_legible(&out),
    })
}

fn channel(args: &FocusArgs, seed: u64, Focused { image, targets }: &Focused) -> Result<Channel, FocusError> {
    let (power, _) = image.power(args.looks);
    let [mean, peak, contrast] = levels(&power);
    let db = |p: f64| (p > 0.0).then(|| 10.0 * p.log10());
    Ok(Channel {
        name: image.channel.clone(),
        pulses: image.pulses,
        doppler_hz: image.doppler_hz,
        cell_m: image.support.map(|s| s.cuts().map(|(_, cell)| cell)),
        mean_dbw: db(mean),
        peak_dbw: db(peak),
        percentile_amplitude: percentile(&power, args.percentile.unwrap_or(98.0)).map(f64::sqrt),
        contrast,
        speckle: args.speckle.then(|| speckle::of(args, seed, image)).transpose()?,
        targets: targets.iter().map(|(name, found)| Target { name: name.clone(), found: *found }).collect(),
    })
}

pub(super) fn print(args: &FocusArgs, report: &Report, out: &mut dyn Write) -> Result<(), CliError> {
    if args.json {
        return json::print(report, out);
    }
    write(report, out).map_err(CliError::Output)?;
    for path in &report.out {
        say(format_args!("{}", escape::path(path)));
    }
    Ok(())
}

fn write(report: &Report, out: &mut dyn Write) -> std::io::Result<()> {
    let [x, y, z] = report.centre_m;
    writeln!(
        out,
        "image       {} x {} pixels of {} m about {x:.1} m East, {y:.1} m North, {z:.1} m up",
        report.pixels[0], report.pixels[1], report.pixel_m
    )?;
    writeln!(
        out,
        "pulses      {} ({} to {}), {} navigation; {:.1} s, {:.1} M pulse-pixels/s",
        report.pulses,
        report.first_pulse,
        report.last_pulse,
        report.nav,
        report.seconds,
        report.pulse_pixels_per_s * 1e-6
    )?;
    for channel in &report.channels {
        let cells = match channel.cell_m {
            Some([range, cross]) => format!("cells of {range:.2} m by {cross:.2} m"),
            None => "no cross-range".to_owned(),
        };
        let power = match (channel.mean_dbw, channel.peak_dbw) {
            (Some(mean), Some(peak)) => {
                format!("mean {mean:.1} dBW, peak {peak:.1} dBW, contrast {:.2}", channel.contrast)
            }
            _ => "no power".to_owned(),
        };
        let band = channel.doppler_hz.map_or(String::new(), |hz| format!(" in a band of {hz:.1} Hz"));
        writeln!(
            out,
            "{:<11} {power}; {}{band}, {cells}",
            escape::name(&channel.name),
            counted(channel.pulses, "pulse")
        )?;
        if let Some(found) = &channel.speckle {
            speckle::write(found, out)?;
        }
        // About the place where the navigation in use puts the point.
        let searched = channel.cell_m.map_or(String::new(), |cells| {
            let [range, cross] = cells.map(|cell_m| SEARCH_CELLS as f64 * cell_m);
            format!(
                " within {range:.1} m in range and {cross:.1} m in cross-range (a wide one within {:.1} m)",
                WIDEST * cross
            )
        });
        for target in &channel.targets {
            match &target.found {
                None => writeln!(
                    out,
                    "  {:<16} not found: no main lobe{searched}, or none that stands out",
                    escape::name(&target.name)
                )?,
                Some(p) => writeln!(
                    out,
                    "  {:<16} range {:.3} m ({:.3}), PSLR {:.1} dB, position error {:+.3} cells; cross-range {:.3} m ({:.3}), PSLR {:.1} dB, position error {:+.3} cells; phase {:+.3} rad",
                    escape::name(&target.name),
                    p.range.width_m,
                    p.range.theory_m,
                    p.range.pslr_db,
                    p.range.error_cells,
                    p.cross_range.width_m,
                    p.cross_range.theory_m,
                    p.cross_range.pslr_db,
                    p.cross_range.error_cells,
                    p.phase_rad
                )?,
            }
        }
    }
    Ok(())
}
