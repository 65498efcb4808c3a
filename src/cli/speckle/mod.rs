//! `nereus speckle`: the statistics of sea clutter over the azimuth of the wind.

pub mod error;
mod report;

use crate::cli::scenario::ScenarioArgs;
use error::SpeckleError;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use glam::DVec2;

use super::error::CliError;
use super::json;
use super::progress;
use super::sea::SeaError;
use super::{say, warn};
use crate::adequacy::patch_at;
use crate::bench::accuracy::noiseless;
use crate::bench::gather::gather;
use crate::cli::outputs::save_canvas;
use crate::cli::values::{counts, distinct, threads};
use crate::clutter::fits::{Speckle, SpeckleSettings};
use crate::clutter::image::{self, Image, Place};
use crate::config::Run;
use crate::pipeline::build;
use crate::pipeline::memory::available_bytes;
use crate::recording::output::{FileKind, Output, OutputError};
use crate::scene::Sea;
use crate::scene::sea::PatchPlace;
use report::{Azimuth, Report};

/// `nereus speckle`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct SpeckleArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// Azimuths of the wind, evenly over 360 degrees from 0: downwind
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = counts(1, 360))]
    pub winds: u64,
    /// Channels to analyse [default: all]
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub channel: Vec<String>,
    /// Most pixels of the image across the look and along it; each is a resolution cell, and all lie on the
    /// patch
    #[arg(long, value_name = "X,Y", value_delimiter = ',', num_args = 1, default_value = "500,1500")]
    pub pixels: Vec<usize>,
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
    /// Overwrite files that exist
    #[arg(long)]
    pub force: bool,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// Makes the echo of every azimuth, focuses it, fits and prints.
pub(super) fn speckle(args: &SpeckleArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let &[across, along] = args.pixels.as_slice() else {
        let found = format!("{:?}", args.pixels);
        return Err(SpeckleError::Value { key: "pixels", found, allowed: "two whole numbers X,Y" }.into());
    };
    let mut run = noiseless(&args.scenario.load_to_measure(args.threads, &[])?);
    // Nothing waits to be released in time.
    run.stream.ring_slots = 1;
    let path = run.path.clone();
    let Some(sea) = run.scene.sea.clone() else { return Err(SeaError::NoSea { path }.into()) };
    if sea.place != PatchPlace::Fixed {
        return Err(SpeckleError::Follows { path }.into());
    }
    let channels = channels(args, &run)?;
    let files = files(args)?;
    warn(run.warnings.iter().filter(|warning| !warning.is_of_sinks()));
    let settings = SpeckleSettings {
        resamples: usize::try_from(args.resamples).unwrap_or(usize::MAX),
        test_pixels: usize::try_from(args.test_pixels).unwrap_or(usize::MAX),
        seed: run.scene.seed,
    };
    let look_rad = look_rad(&run, &sea, channels[0])?;
    let begun = Instant::now();
    let mut azimuths = Vec::new();
    for wind in 0..args.winds {
        let psi_rad = std::f64::consts::TAU * wind as f64 / args.winds as f64;
        say(format_args!(
            "wind {:.1} degrees from the look ({} of {}) ...",
            psi_rad.to_degrees(),
            wind + 1,
            args.winds
        ));
        let mut turned = run.clone();
        if let Some(sea) = &mut turned.scene.sea {
            sea.water.wind.direction_rad = look_rad + psi_rad;
        }
        for image in images(&turned, &sea, &channels, [across, along])? {
            azimuths.push(azimuth(&turned, &sea, image, &settings)?);
        }
    }
    let report = Report::new(args, &run, &channels, azimuths, begun.elapsed().as_secs_f64(), &files);
    let text = if args.json { json::json(&report)? + "\n" } else { report.text() };
    if let Some(Files { table, picture, .. }) = files {
        let csv = report.csv();
        table.write(|partial| {
            fs::write(partial, csv).map_err(OutputError::io(partial, "writing")).map_err(SeaError::from)
        })?;
        save_canvas(picture, &report.draw().map_err(SeaError::from)?)?;
    }
    out.write_all(text.as_bytes()).map_err(CliError::Output)
}

fn channels(args: &SpeckleArgs, run: &Run) -> Result<Vec<usize>, SeaError> {
    let all = &run.scene.radar.channels;
    if args.channel.is_empty() {
        return Ok((0..all.len()).collect());
    }
    let place = |name: &String| {
        all.iter().position(|channel| channel.name == *name).ok_or_else(|| SeaError::NoChannel {
            name: name.clone(),
            known: all.iter().map(|channel| channel.name.as_str()).collect::<Vec<_>>().join(", "),
        })
    };
    // A channel named twice would count twice in what is fitted over the winds.
    Ok(distinct(args.channel.iter().map(place).collect::<Result<_, _>>()?))
}

/// Files of `--out`.
struct Files {
    table: Output,
    picture: Output,
    paths: [PathBuf; 2],
}

/// The files of `--out`, whose folder is made where it is not there.
fn files(args: &SpeckleArgs) -> Result<Option<Files>, SeaError> {
    let Some(folder) = &args.out else { return Ok(None) };
    fs::create_dir_all(folder).map_err(OutputError::io(folder, "making the folder"))?;
    let paths = ["speckle.csv", "speckle.png"].map(|name| folder.join(name));
    let plan = |path: &Path, kind| Output::plan(path, kind, args.force);
    let (table, picture) = (plan(&paths[0], FileKind::Speckle)?, plan(&paths[1], FileKind::Png)?);
    Ok(Some(Files { table, picture, paths }))
}

/// Middle of the patch when the middle pulse leaves, East and North, m.
fn middle_m(run: &Run, sea: &Sea) -> Result<[f64; 2], CliError> {
    let time_s = run.scene.radar.emissions.interval_s(0, run.scene.pulses / 2);
    let patch = patch_at(run, sea, time_s)?;
    let [low, high] = [0, patch.len() - 1].map(|place| patch.centre_m(patch.key(place)));
    Ok([0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])])
}

/// Direction in which the delay grows in the middle of the patch, counter-clockwise from East: where the
/// platforms are, lever arms left out.
fn look_rad(run: &Run, sea: &Sea, channel: usize) -> Result<f64, CliError> {
    let scene = &run.scene;
    let radar = &scene.radar;
    let middle = DVec2::from(middle_m(run, sea)?);
    let (tracks, _) = build::tracks(&run.nav, scene)?;
    let time = radar.emissions.emission(scene.start, scene.pulses / 2);
    let row = &radar.channels[channel];
    let platforms = [
        radar.transmitters[row.transmitter].antenna.platform,
        radar.receivers[row.receiver].antenna.platform,
    ];
    let mut along = DVec2::ZERO;
    for platform in platforms {
        if let Ok(state) = tracks[platform].truth.state(time) {
            let [x, y, _] = state.position.to_array();
            along += (middle - DVec2::new(x, y)).normalize_or_zero();
        }
    }
    Ok(along.to_angle())
}

/// The echo of all pulses, and its images.
fn images(run: &Run, sea: &Sea, channels: &[usize], most: [usize; 2]) -> Result<Vec<Image>, CliError> {
    let total = run.scene.pulses;
    let stream = build::on_nominal_tracks(run, 0..total)?;
    let layout = *stream.factory().layout();
    let needed = (layout.slot_bytes() as u64).saturating_mul(total);
    if let Some(available) = available_bytes().filter(|available| needed > *available) {
        let path = run.path.clone();
        let (needed_mib, available_mib) = (needed >> 20, available >> 20);
        return Err(SpeckleError::Memory { path, pulses: total, needed_mib, available_mib }.into());
    }
    let replica = stream.factory().replica();
    let (status, watcher) = progress::watch(total);
    let gathered = gather(stream, Some(status));
    watcher.finish();
    let gathered = gathered?;
    let place = Place { middle_m: middle_m(run, sea)?, patch_m: sea.patch.size_m(), most };
    let radar = &run.scene.radar;
    let one = |channel: &usize| {
        let made = progress::focusing(|done| image::image(radar, &gathered, &replica, *channel, place, done));
        made.map_err(|source| {
            let (path, channel) = (run.path.clone(), radar.channels[*channel].name.clone());
            SpeckleError::Image { path, channel, source }.into()
        })
    };
    channels.iter().map(one).collect()
}

fn azimuth(run: &Run, sea: &Sea, image: Image, settings: &SpeckleSettings) -> Result<Azimuth, SpeckleError> {
    let Image { powers, pixels, trend_db, geometry } = image;
    let row = &run.scene.radar.channels[geometry.channel];
    let fault = |source| SpeckleError::NoPower { path: run.path.clone(), channel: row.name.clone(), source };
    let speckle = Speckle::of(&powers, pixels, [1, 1], settings).map_err(fault)?;
    Ok(Azimuth::new(run, sea, geometry, trend_db, speckle))
}
