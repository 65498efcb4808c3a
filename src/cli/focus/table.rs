//! The table of `nereus focus --nav both`.

use std::io::Write;
use std::path::PathBuf;

use serde::Serialize;

use super::{CliError, FocusArgs};
use crate::cli::{counted, escape, json, say};
use crate::processor::comparison::{ChannelComparison, Figures, Target};

/// What `--json` prints.
#[derive(Debug, Serialize)]
pub(super) struct Comparison {
    pub recording: String,
    pub against: Option<String>,
    pub nav: &'static str,
    pub pulses: usize,
    pub first_pulse: u64,
    pub last_pulse: u64,
    pub centre_m: [f64; 3],
    pub pixels: [usize; 2],
    pub pixel_m: f64,
    pub channels: Vec<ChannelComparison>,
    pub out: Vec<PathBuf>,
}

pub(super) fn print(args: &FocusArgs, comparison: &Comparison, out: &mut dyn Write) -> Result<(), CliError> {
    if args.json {
        return json::print(comparison, out);
    }
    write(comparison, out).map_err(CliError::Output)?;
    for path in &comparison.out {
        say(format_args!("{}", escape::path(path)));
    }
    Ok(())
}

fn write(of: &Comparison, out: &mut dyn Write) -> std::io::Result<()> {
    let [x, y, z] = of.centre_m;
    writeln!(
        out,
        "images      {} x {} pixels of {} m about {x:.1} m East, {y:.1} m North, {z:.1} m up",
        of.pixels[0], of.pixels[1], of.pixel_m
    )?;
    writeln!(
        out,
        "pulses      {} ({} to {}); reported navigation beside true{}",
        of.pulses,
        of.first_pulse,
        of.last_pulse,
        of.against.as_ref().map_or(String::new(), |path| format!(" navigation of {}", escape::name(path)))
    )?;
    for channel in &of.channels {
        write_channel(channel, out)?;
    }
    Ok(())
}

fn write_channel(channel: &ChannelComparison, out: &mut dyn Write) -> std::io::Result<()> {
    let cells = match channel.cell_m {
        Some([range, cross]) => format!("cells of {range:.2} m by {cross:.3} m"),
        None => "no cross-range".to_owned(),
    };
    writeln!(out, "{:<11} {}, {cells}", escape::name(&channel.name), counted(channel.pulses, "pulse"))?;
    let pixels = &channel.pixels;
    if let (Some(loss), Some([right, wrong]), Some(coherence)) =
        (pixels.mean_loss_db, pixels.contrast, pixels.coherence)
    {
        writeln!(
            out,
            "  {} pixels without points: mean power lost {loss:.2} dB, contrast {right:.2} becomes {wrong:.2}, coherence {coherence:.3}",
            pixels.count
        )?;
    }
    if !channel.targets.is_empty() {
        writeln!(
            out,
            "  {:<16} {:<9} {:>7} {:>8} {:>8} {:>8} {:>8} {:>6} {:>6} {:>7} {:>7} {:>7}",
            "", "", "loss", "range", "", "cross", "", "width", "", "lobe", "", "phase"
        )?;
        writeln!(
            out,
            "  {:<16} {:<9} {:>7} {:>8} {:>8} {:>8} {:>8} {:>6} {:>6} {:>7} {:>7} {:>7}",
            "", "", "dB", "cells", "m", "cells", "m", "range", "cross", "cells", "dB", "rad"
        )?;
    }
    for target in &channel.targets {
        write_target(target, out)?;
    }
    Ok(())
}

fn write_target(target: &Target, out: &mut dyn Write) -> std::io::Result<()> {
    // Two paired echoes are equally high: the same one in both rows.
    let side = target.predicted.as_ref().map_or(0, Figures::highest_side);
    let row = |name: &str, kind: &str, figures: Option<&Figures>| match figures {
        None => format!("  {name:<16} {kind:<9} not found"),
        Some(f) => {
            let lobe = f.cross_range_lobes[side].map_or(format!("{:>7} {:>7}", "-", "-"), |lobe| {
                format!("{:>+7.3} {:>7.2}", lobe.cells, lobe.level_db)
            });
            format!(
                "  {name:<16} {kind:<9} {:>7.3} {:>+8.3} {:>+8.3} {:>+8.3} {:>+8.3} {:>6.3} {:>6.3} {lobe} {:>+7.3}",
                f.loss_db,
                f.shift_cells[0],
                f.shift_m[0],
                f.shift_cells[1],
                f.shift_m[1],
                f.width_ratio[0],
                f.width_ratio[1],
                f.phase_rad
            )
        }
    };
    writeln!(out, "{}", row(&escape::name(&target.name), "predicted", target.predicted.as_ref()))?;
    writeln!(out, "{}", row("", "measured", target.measured.as_ref()))?;
    if let Some(terms) = &target.terms {
        writeln!(
            out,
            "  {:<16} path error: constant {:+.3} cells of range, linear {:+.3} cells of cross-range, quadratic {:+.3} rad at the ends, residual {:.3} rad rms",
            "", terms.mean_cells, terms.linear_cells, terms.quadratic_rad, terms.rest_rad
        )?;
    }
    if let Some(loss_db) = target.aim_loss_db {
        writeln!(out, "  {:<16} scenario  aim: {loss_db:.3} dB of gain lost, both ways", "")?;
    }
    for law in &target.laws {
        writeln!(out, "  {:<16} scenario  {}", "", law)?;
    }
    Ok(())
}
