//! Fixes of a file, and what all formats share in reading them.

use super::alternation::Alternation;
use super::completion::{Completer, Reported};
use super::epoch::Epoch;
use super::faults::{FaultKind, Faults, NavError};
use super::load_report::LoadReport;
use super::{FileSource, Fix, Smoothing, VerticalDatum, stretches};

/// The most fixes that are read of a file (11 h at 100 Hz).
pub const MAX_FIXES: usize = 4_000_000;

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Fixes, times strictly increasing.
    pub fixes: Vec<Fix>,
    /// What was read, skipped and filled in.
    pub report: LoadReport,
}

/// Fixes that alternate between places so far apart, m, in words.
#[derive(Clone, Copy, Debug)]
pub struct Alternating(pub f64);

impl std::fmt::Display for Alternating {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "positions alternate between two places {:.1} m apart: two antennas or receivers; give one of them",
            self.0
        )
    }
}

/// Fixes that a source needs at least: two points make a line, the smoother needs one more than its
/// three states to have a residual.
pub(super) fn fixes_needed(source: &FileSource) -> usize {
    match source.smoothing {
        Smoothing::Off => 2,
        Smoothing::Rts { .. } => 4,
    }
}

/// Height above the ellipsoid from a height of the file.
pub(super) fn ellipsoidal_height_m(height_m: f64, source: &FileSource) -> f64 {
    match source.datum {
        VerticalDatum::Ellipsoid => height_m,
        VerticalDatum::MeanSeaLevel => height_m + source.undulation_m,
        VerticalDatum::Barometric { offset_m } => height_m + offset_m + source.undulation_m,
    }
}

/// Notes what is wrong between a fix and the one before it; false if the fix cannot be kept.
pub(super) fn follows(
    fixes: &[Fix],
    next: &Fix,
    line: u64,
    source: &FileSource,
    faults: &mut Faults,
) -> bool {
    let Some(before) = fixes.last() else { return true };
    let gap_s = next.time.since(before.time);
    if gap_s <= 0.0 {
        faults.push(line, FaultKind::TimeOrder { time: next.time, before: before.time });
        return false;
    }
    if gap_s > source.max_gap_s {
        faults.push(line, FaultKind::gap(next.time, gap_s, source.max_gap_s));
    }
    true
}

/// Fixes of epochs that have a date and a place: in order, complete, without what lies beyond steps of the
/// clock.
pub(super) fn of_epochs(
    mut epochs: Vec<Epoch>,
    mut report: LoadReport,
    mut faults: Faults,
    datum: VerticalDatum,
    source: &FileSource,
) -> Result<Recording, NavError> {
    if epochs.len() > MAX_FIXES {
        faults.push(report.lines, FaultKind::TooManyFixes { allowed: MAX_FIXES });
    }
    let left = stretches::keep(&mut epochs);
    report.hints.extend(left.steps);
    let mut completer = Completer::for_file(datum, source.undulation_m);
    let mut fixes = Vec::new();
    let mut see = |reported| match reported {
        Reported::Fix(fix) => fixes.push(fix),
        Reported::Follows { line, time, before } => {
            let gap_s = time.since(before);
            if gap_s > source.max_gap_s {
                faults.push(line, FaultKind::gap(time, gap_s, source.max_gap_s));
            }
        }
        // Counted.
        Reported::StepsBack { .. } => {}
    };
    for epoch in epochs {
        completer.push(epoch, &mut see);
    }
    completer.finish(&mut see);
    let counts = completer.counts();
    report.out_of_order = counts.out_of_order;
    report.clock_steps = left.fixes + counts.clock_steps;
    report.heights_filled = counts.heights_filled;
    report.headings_filled = counts.headings_filled;
    finish(fixes, report, faults, source)
}

/// Completes the report and wraps up, unless there are faults.
pub(super) fn finish(
    fixes: Vec<Fix>,
    mut report: LoadReport,
    mut faults: Faults,
    source: &FileSource,
) -> Result<Recording, NavError> {
    let needed = fixes_needed(source);
    if fixes.len() < needed && faults.is_empty() {
        faults.push(report.lines, FaultKind::TooFewFixes { found: fixes.len(), needed });
    }
    faults.into_result(&source.path)?;
    report.fixes = fixes.len();
    if let (Some(first), Some(last)) = (fixes.first(), fixes.last()) {
        report.span_s = last.time.since(first.time);
    }
    let mut alternation = Alternation::default();
    fixes.iter().for_each(|fix| alternation.push(fix));
    if let Some(apart_m) = alternation.apart_m() {
        report.hints.push(format!("{}", Alternating(apart_m)));
    }
    report.longest_gap_s = fixes.windows(2).map(|w| w[1].time.since(w[0].time)).fold(0.0, f64::max);
    Ok(Recording { fixes, report })
}
