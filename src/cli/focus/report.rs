//! What `nereus focus` tells.

use std::io::Write;
use std::path::PathBuf;

use serde::Serialize;

use super::{
    CliError, FocusArgs, FocusNav, Focused, Ground, Recording, counted, interpolation_error_db, multilook,
    oversampling, percentile, say, speckle,
};
use crate::cli::escape;
use crate::cli::focus::error::FocusError;
use crate::cli::json;
use crate::cli::speckle::Speckle;
use crate::processor::point_target::PointTarget;
use crate::processor::point_target::{SEARCH_CELLS, WIDEST};

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
    recording: &Recording,
    ground: &Ground,
    focused: &[Focused],
    seconds: f64,
    out: Vec<PathBuf>,
) -> Result<Report, FocusError> {
    let header = &recording.header;
    let cells = oversampling(header.bandwidth_hz, header.sample_rate_hz, args.interpolation_db);
    let work: f64 = focused.iter().map(|f| f.pulses as f64 * ground.len() as f64).sum();
    Ok(Report {
        recording: args.recording.display().to_string(),
        nav: match args.nav {
            FocusNav::True => "true",
            FocusNav::Reported => "reported",
            FocusNav::Both => "both",
        },
        pulses: recording.pulses(),
        first_pulse: recording.index[0],
        last_pulse: recording.index[recording.index.len() - 1],
        centre_m: ground.centre_m(),
        pixels: ground.pixels,
        pixel_m: args.pixel_m,
        interpolation_db: interpolation_error_db(header.bandwidth_hz, header.sample_rate_hz * cells as f64),
        seconds,
        pulse_pixels_per_s: work / seconds.max(1e-9),
        channels: focused.iter().map(|f| channel(args, recording, ground, f)).collect::<Result<_, _>>()?,
        out: json::all_legible(&out),
    })
}

fn channel(
    args: &FocusArgs,
    recording: &Recording,
    ground: &Ground,
    focused: &Focused,
) -> Result<Channel, FocusError> {
    let power: Vec<f64> = focused.image.iter().map(|z| f64::from(z.norm_sqr())).collect();
    let (power, _) = multilook(&power, ground.pixels, args.looks);
    let mean = |order: i32| power.iter().map(|p| p.powi(order)).sum::<f64>() / power.len().max(1) as f64;
    let db = |p: f64| (p > 0.0).then(|| 10.0 * p.log10());
    // Powers of 1e-15 W squared are no numbers of f32, but of f64.
    let contrast = if mean(1) > 0.0 { mean(2) / mean(1).powi(2) } else { 0.0 };
    Ok(Channel {
        name: recording.header.channels[focused.channel].name.clone(),
        pulses: focused.pulses,
        doppler_hz: focused.doppler_hz,
        cell_m: focused.support.map(|s| s.cuts().map(|(_, cell)| cell)),
        mean_dbw: db(mean(1)),
        peak_dbw: db(power.iter().copied().fold(0.0, f64::max)),
        percentile_amplitude: percentile(&power, args.percentile.unwrap_or(98.0)).map(f64::sqrt),
        contrast,
        speckle: speckle::of(args, recording, ground, focused)?,
        targets: focused
            .targets
            .iter()
            .map(|(name, found)| Target { name: name.clone(), found: *found })
            .collect(),
    })
}

pub(super) fn print(args: &FocusArgs, report: &Report, out: &mut dyn Write) -> Result<(), CliError> {
    if args.json {
        return json::print(report, out);
    }
    tell(report, out).map_err(CliError::Output)?;
    for path in &report.out {
        say(format_args!("{}", escape::path(path)));
    }
    Ok(())
}

fn tell(report: &Report, out: &mut dyn Write) -> std::io::Result<()> {
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
            speckle::tell(found, out)?;
        }
        // What is sought about the place that the navigation in use says.
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
