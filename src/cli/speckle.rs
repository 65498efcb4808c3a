//! `nereus speckle`: the statistics of sea clutter over the azimuth of the wind.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use super::error::CliError;
use super::report::Report;
use super::scenario::{OutputArgs, ScenarioArgs, channel_of, sea_of, warn_of_scene};
use super::values::{Unreadable, allowed, counts, distinct, threads};
use super::{counted, escape, progress, say};
use crate::bench::clutter::{Azimuth, OverAzimuth, Winds, over_azimuth};
use crate::bench::clutter_files;
use crate::bench::table_and_picture::TableAndPicture;
use crate::clutter::Kind;
use crate::clutter::fits::SpeckleSettings;
use crate::config::Run;
use crate::recording::output::FileKind;

/// `nereus speckle`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct SpeckleArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// Wind azimuths, evenly spaced; the first is downwind
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = counts(1, 360))]
    pub winds: u64,
    /// Channels to analyse [default: all]
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub channel: Vec<String>,
    /// Most pixels of the image across the look and along it; each is a resolution cell, and all lie on the
    /// patch
    #[arg(long, value_name = "X,Y", default_value = "500,1500", value_parser = pixels)]
    pub pixels: Pixels,
    /// Samples drawn from a fitted law for the probability of its distance; 0: none
    #[arg(long, value_name = "N", default_value_t = 99, value_parser = counts(0, 100_000))]
    pub resamples: u64,
    /// Pixels at most, evenly over the image, whose distance from a law is tested
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = counts(2, u64::MAX))]
    pub test_pixels: u64,
    /// Folder for speckle.csv and speckle.png
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Threads that make pulses (instead of stream.threads); 0: as many as the machine has
    #[arg(long, value_name = "T", value_parser = threads())]
    pub threads: Option<u64>,
    /// What becomes of its output
    #[command(flatten)]
    pub output: OutputArgs,
}

/// `X,Y` of `--pixels`.
type Pixels = [usize; 2];

fn pixels(text: &str) -> Result<Pixels, Unreadable> {
    let number = |text: &str| text.trim().parse().ok();
    let numbers = text.split_once(',').and_then(|(x, y)| Some([number(x)?, number(y)?]));
    allowed(numbers, "two whole numbers X,Y such as 500,1500")
}

/// Makes the echo of every azimuth, focuses it, fits and prints.
pub(super) fn speckle(args: &SpeckleArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let run = args.scenario.load_to_measure(args.threads, &[])?;
    let sea = sea_of(&run, &run.path)?;
    let channels = channels(args, &run)?;
    let winds = Winds::new(&run, sea, channels[0], args.pixels)?;
    let force = args.output.overwrite.force;
    let plan = |folder: &PathBuf| TableAndPicture::plan(folder, "speckle", FileKind::Speckle, force);
    let files = args.out.as_ref().map(plan).transpose()?;
    warn_of_scene(&run);
    let settings = SpeckleSettings {
        resamples: usize::try_from(args.resamples).unwrap_or(usize::MAX),
        test_pixels: usize::try_from(args.test_pixels).unwrap_or(usize::MAX),
        seed: run.scene.seed,
    };
    let begun = Instant::now();
    let mut azimuths = Vec::new();
    for wind in 0..args.winds {
        let psi_rad = TAU * wind as f64 / args.winds as f64;
        let (degrees, number) = (psi_rad.to_degrees(), wind + 1);
        say(format_args!("wind {degrees:.1} degrees from the look ({number} of {}) ...", args.winds));
        let (status, watcher) = progress::watch();
        let echo = winds.echo(psi_rad, Some(status));
        watcher.finish();
        let echo = echo?;
        for channel in &channels {
            azimuths.push(progress::counting("pulses focused", |done| {
                winds.azimuth(&echo, *channel, &settings, done)
            })?);
        }
    }
    let names: Vec<String> =
        channels.iter().map(|channel| run.scene.radar.channels[*channel].name.clone()).collect();
    let cosines = over_azimuth(&azimuths, &names);
    let (scenario, seconds) = (args.scenario.config.display().to_string(), begun.elapsed().as_secs_f64());
    let [facets, pulses] = [counted(sea.patch.len(), "facet"), counted(run.scene.pulses, "pulse")];
    let mut report = Report::default();
    report.line(format!("{scenario}: {facets}, {pulses} for each wind; {seconds:.0} s"));
    report.value("scenario", scenario).value("pulses", run.scene.pulses).value("facets", sea.patch.len());
    report.value("seconds", seconds).value("azimuths", &azimuths).value("cosines", &cosines);
    add_azimuths(&mut report, &azimuths);
    add_cosines(&mut report, &cosines);
    let paths = files.iter().flat_map(|files| &files.paths);
    for path in paths.clone() {
        report.line(escape::path(path));
    }
    report.paths("out", paths);
    if let Some(mut files) = files {
        files.write_table(clutter_files::csv(&azimuths))?;
        clutter_files::picture(&azimuths, &names)?.save(files.picture)?;
    }
    report.print(args.output.format.json, out)
}

/// A line of the table for every azimuth and channel.
fn add_azimuths(report: &mut Report, azimuths: &[Azimuth]) {
    if let Some(first) = azimuths.first() {
        let [near, middle, far] = first.grazing_deg;
        report.line(format!(
            "{} pixels of {:.3} m across the look and {:.3} m along it, {:.2} facets each (N facets lower <I^2>/<I>^2 by 1/N); \
             grazing angle {middle:.3} degrees, {near:.3} to {far:.3}",
            first.speckle.pixels, first.cell_m[0], first.cell_m[1], first.facets_per_cell
        ));
    }
    report.line(
        "   psi channel    dBW  contrast  nu moments      nu likelihood   blocks   nu histogram    KS K      p     Weibull    p     Rayleigh   p     law",
    );
    for azimuth in azimuths {
        let speckle = &azimuth.speckle;
        let mut line = format!(
            "{:6.1} {:7} {:6.1} {:9.3}",
            azimuth.psi_deg, azimuth.channel, speckle.mean_power_dbw, speckle.contrast
        );
        if let Some(fits) = speckle.law(Kind::K) {
            let of_blocks = fits.likelihood.shape.zip(speckle.inverse_block_error);
            let blocks = of_blocks.map_or("-".to_owned(), |(nu, error)| format!("{:.3}", nu * nu * error));
            let (moments, likelihood, histogram) = (&fits.moments, &fits.likelihood, &fits.histogram);
            let _ = write!(line, "  {moments}  {likelihood}  {blocks:>7}  {histogram}");
        }
        for fits in &speckle.laws {
            let p = fits.probability.map_or("-".to_owned(), |p| format!("{p:.2}"));
            let _ = write!(line, "  {:.4}  {p:>4}", fits.distance);
        }
        let law = azimuth.empirical.map_or("-".to_owned(), |nu| format!("{nu:.4}"));
        report.line(format!("{line}  {law}"));
    }
}

/// A line for every channel and way to fit.
fn add_cosines(report: &mut Report, cosines: &[OverAzimuth]) {
    if !cosines.is_empty() {
        report.line("nu = a + b cos 2 psi");
    }
    for OverAzimuth { channel, fit, a, a_error, b, b_error, azimuths } in cosines {
        report.line(format!(
            "{channel:7} {fit:10}  a = {a:.4} +- {a_error:.4}, b = {b:+.4} +- {b_error:.4}  ({azimuths} azimuths)"
        ));
    }
}

fn channels(args: &SpeckleArgs, run: &Run) -> Result<Vec<usize>, CliError> {
    if args.channel.is_empty() {
        return Ok((0..run.scene.radar.channels.len()).collect());
    }
    // A channel named twice would count twice in what is fitted over the winds.
    Ok(distinct(args.channel.iter().map(|name| channel_of(run, name)).collect::<Result<_, _>>()?))
}
