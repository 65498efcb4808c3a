//! The table of `nereus focus --nav both`.

use std::f64::consts::TAU;

use crate::cli::report::Report;
use crate::cli::{counted, escape};
use crate::processor::comparison::{ChannelComparison, Figures, Target};

/// Lines of a channel.
pub(super) fn add_channel(report: &mut Report, channel: &ChannelComparison) {
    let cells = match channel.cell_m {
        Some([range, cross]) => format!("cells of {range:.2} m by {cross:.3} m"),
        None => "no cross-range".to_owned(),
    };
    let (name, pulses) = (escape::name(&channel.name), counted(channel.pulses, "pulse"));
    report.line(format!("{name:<11} {pulses}, {cells}"));
    let pixels = &channel.pixels;
    if let (Some(loss), Some([right, wrong]), Some(coherence)) =
        (pixels.mean_loss_db, pixels.contrast, pixels.coherence)
    {
        report.line(format!(
            "  {} pixels without points: mean power {:+.2} dB, contrast {right:.2} becomes {wrong:.2}, coherence {coherence:.3}",
            pixels.count, -loss
        ));
    }
    if !channel.targets.is_empty() {
        for [loss, range, range_m, cross, cross_m, width, width_cross, lobe, lobe_db, phase] in [
            ["loss", "range", "", "cross", "", "width", "", "lobe", "", "phase"],
            ["dB", "cells", "m", "cells", "m", "range", "cross", "cells", "dB", "rad"],
        ] {
            report.line(format!(
                "  {:<16} {:<9} {loss:>7} {range:>8} {range_m:>8} {cross:>8} {cross_m:>8} {width:>6} {width_cross:>6} {lobe:>7} {lobe_db:>7} {phase:>7}",
                "", ""
            ));
        }
    }
    channel.targets.iter().for_each(|target| add_target(report, target));
}

fn add_target(report: &mut Report, target: &Target) {
    // Two paired echoes are equally high: the same one in both rows.
    let side = target.predicted.as_ref().map_or(0, Figures::highest_side);
    // A measured phase within half a turn of the predicted one.
    let about_rad = target.predicted.as_ref().map_or(0.0, |predicted| predicted.phase_rad);
    let near = |phase_rad: f64| phase_rad + TAU * ((about_rad - phase_rad) / TAU).round();
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
                near(f.phase_rad)
            )
        }
    };
    report.line(row(&escape::name(&target.name), "predicted", target.predicted.as_ref()));
    report.line(row("", "measured", target.measured.as_ref()));
    if let Some(terms) = &target.terms {
        report.line(format!(
            "  {:<16} path error: constant {:+.3} cells of range, linear {:+.3} cells of cross-range, quadratic {:+.3} rad at the ends, residual {:.3} rad rms",
            "", terms.mean_cells, terms.linear_cells, terms.quadratic_rad, terms.rest_rad
        ));
    }
    if let Some(loss_db) = target.aim_loss_db {
        report.line(format!("  {:<16} scenario  aim: {loss_db:.3} dB of gain lost, both ways", ""));
    }
    for law in &target.laws {
        report.line(format!("  {:<16} scenario  {law}", ""));
    }
}
