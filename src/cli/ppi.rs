//! `nereus ppi`: a plan position picture of a recording of a scanning antenna.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::error::{CliError, Refused};
use super::focus::TAPERS;
use super::report::Report;
use super::scenario::OutputArgs;
use super::values::{counts, one_of};
use super::{counted, escape, progress, say, warn};
use crate::pipeline::scenario::Scenario;
use crate::plot::canvas::Canvas;
use crate::plot::plan::{Mark, Plan};
use crate::processor::multilook::percentile;
use crate::processor::ppi::{Peak, Polar, Ppi, PpiError, Scan, Settings};
use crate::processor::taper::Taper;
use crate::recording::examination::examine;
use crate::recording::output::{FileKind, Output};

/// Pixels along a side of the plan.
const SIDE: usize = 800;
/// Where the colours begin and end, percent of the pixels.
const PERCENTILES: [f64; 2] = [50.0, 99.9];
/// Least and greatest span of the colours that are chosen by themselves, dB.
const SPANS_DB: [f64; 2] = [10.0, 80.0];
/// Scans that are listed for people.
const LISTED: usize = 12;

/// `nereus ppi`
#[derive(Debug, Args)]
pub struct PpiArgs {
    /// Recording: an HDF5 file or a plain folder
    pub recording: PathBuf,
    /// The channel [default: the first whose receiver scans on the platform of its transmitter]
    #[arg(long, value_name = "NAME")]
    pub channel: Option<String>,
    /// Which turn or sweep, from 0 [default: the last whole one]
    #[arg(long, value_name = "N", value_parser = counts(0, 1 << 40), conflicts_with = "scans")]
    pub scan: Option<u64>,
    /// All whole scans as an animation (APNG), as fast as they were recorded
    #[arg(long)]
    pub scans: bool,
    /// The reported heading up instead of North
    #[arg(long)]
    pub head_up: bool,
    /// Range at the rim [default: the end of the receive window]
    #[arg(long, value_name = "M")]
    pub range_m: Option<f64>,
    /// Levels of the first and last colour, dBW [default: of half and of 99.9 % of the pixels]
    #[arg(long, value_names = ["LOW", "HIGH"], num_args = 2, allow_negative_numbers = true)]
    pub db: Vec<f64>,
    /// Mark where the targets truly are, by the recorded delays and the scenario in the recording
    #[arg(long)]
    pub truth: bool,
    /// Taper over the band
    #[arg(long, value_parser = one_of(TAPERS), default_value = "taylor")]
    pub window: Taper,
    /// Two-way half-power beamwidth, within half of which bearings are filled from the nearest pulse
    /// [default: by the apertures, or 1]
    #[arg(long, value_name = "DEG")]
    pub beam_deg: Option<f64>,
    /// Strongest cells that are listed
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = counts(0, 1000))]
    pub strongest: u64,
    /// Picture to make [default: the recording's name with _ppi.png, beside it]
    #[arg(long, value_name = "PATH.png")]
    pub out: Option<PathBuf>,
    /// What becomes of its output
    #[command(flatten)]
    pub output: OutputArgs,
}

/// A turn or sweep that was found.
#[derive(Debug, Serialize)]
struct ScanRow {
    scan: usize,
    pulses: usize,
    first_pulse: u64,
    last_pulse: u64,
    whole: bool,
    clockwise: bool,
}

/// A cell of the plan.
#[derive(Debug, Serialize)]
struct CellRow {
    range_m: f64,
    bearing_deg: f64,
    level_dbw: f64,
}

/// A target of the truth record, and the level there.
#[derive(Debug, Serialize)]
struct TargetRow {
    name: String,
    range_m: f64,
    bearing_deg: f64,
    level_dbw: Option<f64>,
}

impl From<Peak> for CellRow {
    fn from(peak: Peak) -> Self {
        let bearing_deg = peak.bearing_rad.to_degrees();
        Self { range_m: peak.range_m, bearing_deg, level_dbw: 10.0 * peak.power_w.log10() }
    }
}

/// Makes the picture and reports what is on it.
pub(super) fn ppi(args: &PpiArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let path = &args.recording;
    examine(path)?;
    let at = |source: PpiError| CliError::Ppi { path: path.clone(), source };
    let limits = limits(args)?;
    let settings = settings(args);
    let ppi = Ppi::open(path, &settings).map_err(at)?;
    let made = args.out.clone().unwrap_or_else(|| beside(path));
    if made.extension().is_none_or(|extension| extension != "png") {
        return Err(Refused::value("out", escape::path(&made), "a name that ends in .png").into());
    }
    let output = Output::plan(&made, FileKind::Png, args.output.overwrite.force)?;
    let shown = shown(args, &ppi).map_err(at)?;
    let radius_m = args.range_m.unwrap_or_else(|| ppi.far_m());
    let scenario = scenario(args, &ppi);
    let mut sheet = Sheet { args, ppi: &ppi, scenario: scenario.as_ref(), radius_m, limits };
    let [.., last] = &shown[..] else { return Err(at(PpiError::NoEchoes)) };
    // Colours are those of the last scan.
    let polar = sheet.polar(*last).map_err(at)?;
    let levels = sheet.levels(&polar);
    sheet.limits = Some(sheet.limits.unwrap_or_else(|| chosen_limits(&levels)));
    let truth = sheet.targets(*last, &polar);
    let picture = sheet.draw(*last, &levels, &truth)?;
    if args.scans {
        Canvas::save_animation(output, shown.len() as u32, ppi.period_s(), |frame| {
            let scan = shown[frame as usize];
            if scan == *last {
                return Ok::<_, CliError>(picture.clone());
            }
            let polar = sheet.polar(scan).map_err(at)?;
            sheet.draw(scan, &sheet.levels(&polar), &sheet.targets(scan, &polar))
        })?;
    } else {
        picture.save(output)?;
    }
    let peaks = polar.strongest(args.strongest as usize, radius_m, ppi.extent());
    let mut report = Report::default();
    sheet.report(&mut report, &shown, &polar, percentile(&levels, 50.0));
    cells(&mut report, peaks.into_iter().map(CellRow::from).collect());
    targets(&mut report, truth);
    report.paths("out", [&made]);
    report.print(args.output.format.json, out)?;
    if !args.output.format.json {
        say(escape::path(&made));
    }
    Ok(())
}

fn settings(args: &PpiArgs) -> Settings {
    let mut settings = Settings::default();
    settings.channel.clone_from(&args.channel);
    settings.head_up = args.head_up;
    settings.window = args.window;
    settings.beam_deg = args.beam_deg;
    settings
}

/// Levels of the first and last colour, where they are asked for.
fn limits(args: &PpiArgs) -> Result<Option<[f64; 2]>, Refused> {
    match args.db[..] {
        [low, high] if low < high && low.abs() <= 1e4 && high.abs() <= 1e4 => Ok(Some([low, high])),
        [low, high] => {
            Err(Refused::value("db", format!("{low} {high}"), "two numbers within 1e4, the second larger"))
        }
        _ => Ok(None),
    }
}

/// From the level of most pixels to that of the strongest.
fn chosen_limits(levels: &[f64]) -> [f64; 2] {
    let [low, high] = PERCENTILES.map(|percent| percentile(levels, percent));
    let high = high.unwrap_or(0.0);
    let low = low.unwrap_or(high).clamp(high - SPANS_DB[1], high);
    [low, high.max(low + SPANS_DB[0])]
}

/// A picture's name beside a recording.
fn beside(recording: &Path) -> PathBuf {
    let mut name = recording.file_stem().unwrap_or_default().to_owned();
    name.push("_ppi.png");
    recording.with_file_name(name)
}

/// Scans to be drawn.
fn shown(args: &PpiArgs, ppi: &Ppi) -> Result<Vec<usize>, PpiError> {
    let scans = ppi.scans();
    let is_whole = |scan: &usize| scans.get(*scan).is_some_and(|scan| scan.is_whole);
    let last = ppi.last_whole();
    let found = match args.scan {
        Some(asked) if asked >= scans.len() as u64 => {
            return Err(PpiError::Scan { asked: asked as usize, last: scans.len().saturating_sub(1) });
        }
        Some(asked) => vec![asked as usize],
        None if args.scans && is_whole(&last) => (0..scans.len()).filter(is_whole).collect(),
        None => vec![last],
    };
    if args.scan.is_none() && !is_whole(&last) {
        warn(["the recording has no whole scan: the longest part of one is shown"]);
    }
    Ok(found)
}

/// The scenario in a recording, where positions of targets are needed.
fn scenario(args: &PpiArgs, ppi: &Ppi) -> Option<Scenario> {
    let header = &ppi.recording().header;
    if header.targets.is_empty() || !header.truth {
        if args.truth {
            warn(["--truth: the recording has no true targets"]);
        }
        return None;
    }
    let read = Scenario::of(ppi.recording());
    if let (Err(error), true) = (&read, args.truth) {
        warn([format!("--truth: the scenario in the recording cannot be read:\n{error}")]);
    }
    read.ok()
}

/// What pictures of one recording have in common.
struct Sheet<'a> {
    args: &'a PpiArgs,
    ppi: &'a Ppi,
    scenario: Option<&'a Scenario>,
    radius_m: f64,
    limits: Option<[f64; 2]>,
}

impl Sheet<'_> {
    fn polar(&self, scan: usize) -> Result<Polar, PpiError> {
        progress::counting("pulses compressed", |done| self.ppi.polar(scan, self.args.range_m, done))
    }

    /// Levels of the pixels, dBW.
    fn levels(&self, polar: &Polar) -> Vec<f64> {
        let plan = polar.plan(self.radius_m, SIDE, 0.5 * self.ppi.extent().beam_rad);
        plan.into_iter().map(|power_w| 10.0 * f64::from(power_w).log10()).collect()
    }

    /// Targets that the beam passes in a scan.
    fn targets(&self, scan: usize, polar: &Polar) -> Vec<TargetRow> {
        let Some(scenario) = self.scenario else { return Vec::new() };
        let header = &self.ppi.recording().header;
        let row = |(target, name): (usize, &String)| {
            let described = scenario.0.scene.targets.iter().find(|of| of.name == *name)?;
            let at = |t: f64| described.at(t).0.to_array();
            let [range_m, bearing_rad] = self.ppi.target(scan, target, &at)?;
            let level_w = polar.level_at(range_m, bearing_rad, self.ppi.extent());
            Some(TargetRow {
                name: name.clone(),
                range_m,
                bearing_deg: bearing_rad.to_degrees().rem_euclid(360.0),
                level_dbw: level_w.map(|power_w| 10.0 * power_w.log10()),
            })
        };
        let found = header.targets.iter().enumerate().filter_map(row);
        found.filter(|target| target.range_m <= self.radius_m).collect()
    }

    fn up(&self) -> &'static str {
        if self.args.head_up { "head up" } else { "North up" }
    }

    fn draw(&self, scan: usize, levels: &[f64], truth: &[TargetRow]) -> Result<Canvas, CliError> {
        let Scan { pulses, is_clockwise, .. } = &self.ppi.scans()[scan];
        let sense = if *is_clockwise { "" } else { " (counterclockwise)" };
        let name = escape::name(self.ppi.channel());
        let title = format!("{name}, scan {scan}{sense}, {}, {}", counted(pulses.len(), "pulse"), self.up());
        let mark = |target: &TargetRow| {
            (escape::name(&target.name).into_owned(), target.range_m, target.bearing_deg)
        };
        let places: Vec<_> = truth.iter().filter(|_| self.args.truth).map(mark).collect();
        let marks: Vec<Mark> = places
            .iter()
            .map(|(name, range_m, deg)| Mark { name, range_m: *range_m, bearing_rad: deg.to_radians() })
            .collect();
        let plan = Plan {
            title: &title,
            level: levels,
            side: SIDE,
            radius_m: self.radius_m,
            limits: self.limits.unwrap_or([0.0, 1.0]),
            quantity: "compressed power, dBW",
            marks: &marks,
        };
        Ok(plan.draw()?)
    }

    fn report(&self, report: &mut Report, shown: &[usize], polar: &Polar, median_dbw: Option<f64>) {
        let ppi = self.ppi;
        let row = |(scan, of): (usize, &Scan)| ScanRow {
            scan,
            pulses: of.pulses.len(),
            first_pulse: ppi.number(of.pulses.start),
            last_pulse: ppi.number(of.pulses.end - 1),
            whole: of.is_whole,
            clockwise: of.is_clockwise,
        };
        let scans: Vec<ScanRow> = ppi.scans().iter().enumerate().map(row).collect();
        report.line(format!(
            "{}: {} of channel {}, every {:.3} s",
            escape::path(&self.args.recording),
            counted(scans.len(), "scan"),
            escape::name(ppi.channel()),
            ppi.period_s()
        ));
        for scan in scans.iter().take(LISTED) {
            let is_whole = if scan.whole { "whole" } else { "part" };
            let sense = if scan.clockwise { "clockwise" } else { "counterclockwise" };
            let ScanRow { first_pulse, last_pulse, pulses, .. } = scan;
            let text =
                format!("{} ({first_pulse} to {last_pulse}), {is_whole}, {sense}", counted(*pulses, "pulse"));
            report.row(format!("  scan {}", scan.scan), text);
        }
        if scans.len() > LISTED {
            report.row(format!("  ... {}", scans.len() - 1), "");
        }
        let last = shown.last().copied().unwrap_or(0);
        let [beam_deg, step_deg] =
            [Some(ppi.extent().beam_rad), ppi.step_rad(last)].map(|rad| rad.map(f64::to_degrees));
        let (resolution_m, cell_m) = (ppi.extent().resolution_m, polar.cell_m());
        let [low, high] = self.limits.unwrap_or_default();
        report.row(
            "shown",
            format!(
                "scan {last}, {}; {:.1} to {:.1} m, resolution {resolution_m:.2} m, cells of {cell_m:.2} m",
                self.up(),
                ppi.near_m(),
                self.radius_m
            ),
        );
        report.row(
            "bearing",
            format!(
                "beam of {:.3} degrees, {:.4} degrees from pulse to pulse",
                beam_deg.unwrap_or(0.0),
                step_deg.unwrap_or(0.0)
            ),
        );
        report.row(
            "levels",
            format!(
                "colours from {low:.1} to {high:.1} dBW, median {:.1} dBW",
                median_dbw.unwrap_or(f64::NAN)
            ),
        );
        report.value("recording", self.args.recording.display().to_string());
        report.value("channel", ppi.channel()).value("scans", &scans).value("shown", shown);
        let places = ppi.scans().get(last).map(|scan| scan.pulses.clone()).unwrap_or_default();
        report.value("scan", last).value("pulses", places.len()).value("period_s", ppi.period_s());
        report.value("bearings_from", if self.args.head_up { "heading" } else { "north" });
        report.value("near_m", ppi.near_m()).value("radius_m", self.radius_m);
        report.value("range_resolution_m", resolution_m).value("range_cell_m", cell_m);
        report.value("bearing_resolution_deg", beam_deg).value("bearing_step_deg", step_deg);
        report.value("limits_dbw", [low, high]).value("median_dbw", median_dbw);
    }
}

fn cells(report: &mut Report, cells: Vec<CellRow>) {
    if !cells.is_empty() {
        report.title("strongest cells");
    }
    for (n, CellRow { range_m, bearing_deg, level_dbw }) in cells.iter().enumerate() {
        let text = format!("{range_m:9.1} m at {bearing_deg:7.2} degrees, {level_dbw:.1} dBW");
        report.row(format!("{}", n + 1), text);
    }
    report.value("strongest", cells);
}

fn targets(report: &mut Report, targets: Vec<TargetRow>) {
    if !targets.is_empty() {
        report.title("true targets");
    }
    for TargetRow { name, range_m, bearing_deg, level_dbw } in &targets {
        let level = level_dbw.map_or(String::new(), |level| format!(", {level:.1} dBW there"));
        report.row(escape::name(name), format!("{range_m:9.1} m at {bearing_deg:7.2} degrees{level}"));
    }
    report.value("targets", targets);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_begin_at_the_median_and_span_ten_decibels_at_least() {
        let levels: Vec<f64> = (0..1000).map(|i| if i < 900 { -100.0 } else { -40.0 }).collect();
        assert_eq!(chosen_limits(&levels), [-100.0, -40.0]);
        assert_eq!(chosen_limits(&[-100.0; 50]), [-100.0, -90.0]);
        assert_eq!(chosen_limits(&[f64::NAN, f64::NEG_INFINITY]), [0.0, 10.0]);
        // Most of the plan beyond what a converter resolves.
        let dark: Vec<f64> = (0..1000).map(|i| if i < 900 { -300.0 } else { -40.0 }).collect();
        assert_eq!(chosen_limits(&dark), [-120.0, -40.0]);
    }

    #[test]
    fn a_picture_is_named_for_its_recording() {
        assert_eq!(beside("a/scan.h5".as_ref()), Path::new("a/scan_ppi.png"));
        assert_eq!(beside("rec".as_ref()), Path::new("rec_ppi.png"));
    }
}
