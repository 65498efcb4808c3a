//! `nereus focus`: an image of a recording.

pub mod error;
mod figures;
mod aim;
mod compare;
mod forecast;
mod gating;
mod report;
mod scenario;
mod speckle;
mod table;

use error::FocusError;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use num_complex::Complex32;

use super::error::CliError;
use super::progress;
use super::sea::SeaError;
use super::{counted, say, warn};
use crate::cli::outputs::save_canvas;
use crate::cli::values::{PulseRange, distinct};
use crate::geometry::phase_path::PhasePath;
use crate::inputs::one_line;
use crate::pipeline::memory::available_bytes;
use crate::plot::canvas::Canvas;
use crate::plot::picture::{Axis, Limits, Picture, Reduction};
use crate::processor::backproject::{Aperture, PulseEcho, fast};
use crate::processor::multilook::{multilook, percentile};
use crate::processor::point_target::Sought;
use crate::processor::point_target::{PointTarget, Support, analyse, locate};
use crate::processor::range_compress::{
    Compressor, PulseShape, RangeFilter, interpolation_error_db, oversampling,
};
use crate::processor::taper::Taper;
use crate::recording::field_file::Attribute;
use crate::recording::ground::Ground;
use crate::recording::header::Header;
use crate::recording::image_file::ImageFile;
use crate::recording::output::{FileKind, Output};
use crate::recording::{Recording, RecordingError};
use crate::transport::pacer::Status;
pub use gating::DopplerBand;
use scenario::Scenario;

/// Which navigation the processor believes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FocusNav {
    /// True phase centres
    True,
    /// Phase centres as the platforms report them
    Reported,
    /// Both, side by side: what the errors of the reports do, predicted and measured
    Both,
}

/// Tapers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FocusTaper {
    /// All weights are 1
    None,
    /// Raised cosine
    Hann,
    /// Side lobes of -35 dB
    Taylor,
    /// Kaiser, beta 6
    Kaiser,
}

/// What becomes of the spectrum of the pulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FocusFilter {
    /// Matched filter
    Matched,
    /// Spectrum of the pulse divided out within its band
    Flat,
}

impl FocusTaper {
    fn taper(self) -> Taper {
        match self {
            Self::None => Taper::Uniform,
            Self::Hann => Taper::Hann,
            Self::Taylor => Taper::Taylor,
            Self::Kaiser => Taper::Kaiser,
        }
    }
}

/// `nereus focus`
#[derive(Clone, Debug, Args)]
pub struct FocusArgs {
    /// Recording: an HDF5 file or a plain folder
    pub recording: PathBuf,
    /// Which navigation the processor believes
    #[arg(long, value_enum, default_value_t = FocusNav::True)]
    pub nav: FocusNav,
    /// Image to make: a picture of each channel (.png), complex values of all (.h5); may be given twice
    #[arg(long, value_name = "PATH")]
    pub out: Vec<PathBuf>,
    /// Channels to focus [default: all channels of echoes]
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub channel: Vec<String>,
    /// Use only these pulses, the last one excluded
    #[arg(long, value_name = "A..B")]
    pub pulses: Option<PulseRange>,
    /// Middle of the image, East and North [default: where the radar looks at the middle pulse]
    #[arg(long, value_name = "X,Y", value_delimiter = ',', num_args = 1, allow_hyphen_values = true)]
    pub centre_m: Vec<f64>,
    /// Sides of the image, East and North, or both
    #[arg(long, value_name = "X,Y", value_delimiter = ',', num_args = 1, default_value = "512")]
    pub size_m: Vec<f64>,
    /// Distance of pixels
    #[arg(long, value_name = "M", default_value_t = 1.0)]
    pub pixel_m: f64,
    /// Height of the plane in the frame of the scene
    #[arg(long, value_name = "M", default_value_t = 0.0, allow_hyphen_values = true)]
    pub height_m: f64,
    /// Taper over the band
    #[arg(long, value_enum, default_value_t = FocusTaper::None)]
    pub window: FocusTaper,
    /// Doppler band about the aim of the antennas from which a pixel takes its pulses: Hz, or `all` for all
    /// pulses [default: the pulse rate, where the image reaches beyond it]
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub doppler_hz: Option<DopplerBand>,
    /// Taper over the pulses, or over the Doppler band
    #[arg(long, value_enum, default_value_t = FocusTaper::None)]
    pub aperture: FocusTaper,
    /// Filter of the range compression
    #[arg(long, value_enum, default_value_t = FocusFilter::Matched)]
    pub filter: FocusFilter,
    /// Error of the interpolation between cells of a compressed pulse
    #[arg(long, value_name = "DB", default_value_t = -60.0, allow_negative_numbers = true)]
    pub interpolation_db: f64,
    /// Means of power over so many pixels along both sides, in pictures and statistics
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub looks: usize,
    /// Picture of amplitudes instead of decibels, up to the amplitude that such a percentage of the pixels do
    /// not exceed
    #[arg(long, value_name = "P", conflicts_with = "dynamic_db")]
    pub percentile: Option<f64>,
    /// Span of the decibels below the brightest pixel
    #[arg(long, value_name = "DB", default_value_t = 50.0)]
    pub dynamic_db: f64,
    /// All channels in one picture, side by side
    #[arg(long)]
    pub panels: bool,
    /// With --nav both: a recording of the same scenario without what is wrong, whose image by true
    /// navigation is the measure [default: this one]
    #[arg(long, value_name = "FILE")]
    pub against: Option<PathBuf>,
    /// With --nav both: picture of a point's cut in cross-range, predicted and measured (the first one on the
    /// image), one a channel
    #[arg(long, value_name = "PNG")]
    pub cuts: Option<PathBuf>,
    /// Fit K, Weibull and Rayleigh laws to pixels a resolution cell apart (docs/speckle.md)
    #[arg(long)]
    pub speckle: bool,
    /// Overwrite files that exist
    #[arg(long)]
    pub force: bool,
    /// Print a summary as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// What is made of one channel.
struct Focused {
    channel: usize,
    pulses: usize,
    /// Processed Doppler bandwidth; none: every pixel takes every pulse.
    doppler_hz: Option<f64>,
    image: Vec<Complex32>,
    support: Option<Support>,
    targets: Vec<(String, Option<PointTarget>)>,
}

/// Where the outputs go.
struct Outputs {
    pictures: Vec<Output>,
    values: Option<Output>,
}

/// Focuses.
pub(super) fn focus(args: &FocusArgs, out: &mut dyn Write) -> Result<(), CliError> {
    check(args)?;
    let range = args.pulses.map(|p| p.first..p.end);
    let choose = |header: &Header| channels(args, header);
    for path in [Some(&args.recording), args.against.as_ref()].into_iter().flatten() {
        super::examine::examine(path)?;
    }
    let recording = Recording::open_channels(&args.recording, range, available_bytes(), choose)?;
    if let (Some(asked), [.., last]) = (args.pulses, &recording.index[..])
        && asked.end - 1 > *last
    {
        warn([format!("--pulses {}..{}: the recording ends with pulse {last}", asked.first, asked.end)]);
    }
    let scenario = Scenario::of(&recording);
    let channels = recording.channels().to_vec();
    let names: Vec<String> = channels.iter().map(|c| recording.header.channels[*c].name.clone()).collect();
    if args.nav == FocusNav::Both {
        return compare::compare(args, &recording, &scenario, &names, out);
    }
    let outputs = outputs(args, &names)?;
    let ground = ground(args, &recording, &scenario, channels[0])?;
    let compressor = compressor(args, &recording)?;
    let begun = Instant::now();
    let mut focused = Vec::with_capacity(channels.len());
    for channel in &channels {
        focused.push(one(args, &recording, &scenario, &compressor, &ground, *channel)?);
    }
    let seconds = begun.elapsed().as_secs_f64();
    let mut made = Vec::new();
    draw(args, &recording, &ground, &focused, outputs.pictures, |_| args.nav, &mut made)?;
    if let Some(output) = outputs.values {
        made.push(output.path().to_owned());
        values(args, &recording, &ground, &names, &focused, output)?;
    }
    let report = report::report(args, &recording, &ground, &focused, seconds, made)?;
    report::print(args, &report, out)
}

/// Draws images into their files, or all into one; `nav` tells by which navigation each was made.
fn draw(
    args: &FocusArgs,
    recording: &Recording,
    ground: &Ground,
    focused: &[Focused],
    outputs: Vec<Output>,
    nav: impl Fn(usize) -> FocusNav,
    made: &mut Vec<PathBuf>,
) -> Result<(), CliError> {
    let drawn = |(place, focused)| {
        picture(&FocusArgs { nav: nav(place), ..args.clone() }, recording, ground, focused)
    };
    if args.panels {
        for output in outputs {
            let canvases: Vec<Canvas> = focused.iter().enumerate().map(drawn).collect::<Result<_, _>>()?;
            made.push(output.path().to_owned());
            save_canvas(output, &Canvas::tiled(&canvases, canvases.len().isqrt(), [255; 3]))?;
        }
        return Ok(());
    }
    for (output, focused) in outputs.into_iter().zip(focused.iter().enumerate()) {
        made.push(output.path().to_owned());
        save_canvas(output, &drawn(focused)?)?;
    }
    Ok(())
}

fn check(args: &FocusArgs) -> Result<(), FocusError> {
    compare::check(args)?;
    let bad = |key, found: String, allowed| Err(FocusError::Value { key, found, allowed });
    if !(args.centre_m.is_empty() || args.centre_m.len() == 2) {
        return bad("centre-m", format!("{:?}", args.centre_m), "two numbers X,Y");
    }
    if !(1..=2).contains(&args.size_m.len()) {
        return bad("size-m", format!("{:?}", args.size_m), "one or two numbers above 0");
    }
    if let Some(percentile) = args.percentile.filter(|percent| !(*percent > 0.0 && *percent <= 100.0)) {
        return bad("percentile", percentile.to_string(), "a number above 0, up to 100");
    }
    if !(args.dynamic_db > 0.0 && args.dynamic_db <= 300.0) {
        return bad("dynamic-db", args.dynamic_db.to_string(), "a number above 0, up to 300");
    }
    if !(1..=4096).contains(&args.looks) {
        return bad("looks", args.looks.to_string(), "a whole number from 1 to 4096");
    }
    if !(-100.0..0.0).contains(&args.interpolation_db) {
        return bad("interpolation-db", args.interpolation_db.to_string(), "a number from -100 to below 0");
    }
    Ok(())
}

/// Channels asked for, or all of echoes. Those of calibration bear a word in place of two polarisations.
fn channels(args: &FocusArgs, header: &Header) -> Result<Vec<usize>, FocusError> {
    let all = &header.channels;
    let echoes: Vec<usize> = (0..all.len()).filter(|place| all[*place].is_of_echoes()).collect();
    if echoes.is_empty() {
        return Err(FocusError::NoEchoes { path: args.recording.clone() });
    }
    if args.channel.is_empty() {
        return Ok(echoes);
    }
    let allowed = || echoes.iter().map(|place| one_line(&all[*place].name)).collect::<Vec<_>>().join(", ");
    let place = |name: &String| match all.iter().position(|channel| channel.name == *name) {
        None => Err(FocusError::Channel { name: name.clone(), allowed: allowed() }),
        Some(place) if !echoes.contains(&place) => Err(FocusError::Calibration {
            name: name.clone(),
            kind: all[place].polarisations.clone(),
            allowed: allowed(),
        }),
        Some(place) => Ok(place),
    };
    Ok(distinct(args.channel.iter().map(place).collect::<Result<_, _>>()?))
}

/// Where images of such names go.
fn outputs(args: &FocusArgs, names: &[String]) -> Result<Outputs, FocusError> {
    let mut made = Outputs { pictures: Vec::new(), values: None };
    for path in &args.out {
        match path.extension().and_then(|e| e.to_str()) {
            Some("png") if made.pictures.is_empty() => {
                let all = if args.panels { vec![path.clone()] } else { pictures(path, names) };
                for path in all {
                    made.pictures.push(Output::plan(&path, FileKind::Png, args.force)?);
                }
            }
            Some("h5") if made.values.is_none() => {
                made.values = Some(Output::plan(path, FileKind::Hdf5, args.force)?);
            }
            Some("png" | "h5") => return Err(FocusError::Several { path: path.clone() }),
            _ => return Err(FocusError::Kind { path: path.clone() }),
        }
    }
    Ok(made)
}

/// Several pictures bear the names of what they show.
fn pictures(path: &Path, names: &[String]) -> Vec<PathBuf> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let named = |name: &String| {
        // A recording of unknown origin may hold any name.
        let name = name.replace(|c: char| !(c.is_alphanumeric() || "-_.".contains(c)), "_");
        match names.len() {
            1 => path.to_owned(),
            _ => path.with_file_name(format!("{stem}_{name}.png")),
        }
    };
    names.iter().map(named).collect()
}

fn ground(
    args: &FocusArgs,
    recording: &Recording,
    scenario: &Scenario,
    channel: usize,
) -> Result<Ground, FocusError> {
    let [x, y] = match args.centre_m[..] {
        [x, y] => [x, y],
        // A round number of metres is easier to give again.
        _ => scenario.aim(recording, channel, recording.pulses() / 2).map(f64::round),
    };
    let width = args.size_m[0];
    let height = args.size_m.get(1).copied().unwrap_or(width);
    let ground = Ground::map([x, y, args.height_m], [width, height], args.pixel_m)?;
    if args.looks > ground.pixels[0].min(ground.pixels[1]) {
        let [columns, rows] = ground.pixels;
        return Err(FocusError::Looks { looks: args.looks, columns, rows });
    }
    Ok(ground)
}

fn compressor(args: &FocusArgs, recording: &Recording) -> Result<Compressor, FocusError> {
    let header = &recording.header;
    if header.replica.is_empty() {
        return Err(FocusError::Wire { path: args.recording.clone() });
    }
    let cells = oversampling(header.bandwidth_hz, header.sample_rate_hz, args.interpolation_db);
    let filter = match args.filter {
        FocusFilter::Matched => RangeFilter::Matched,
        FocusFilter::Flat => RangeFilter::Flat,
    };
    let shape = PulseShape {
        replica: &header.replica,
        sample_rate_hz: header.sample_rate_hz,
        bandwidth_hz: header.bandwidth_hz,
        pulse_s: header.pulse_s,
    };
    Compressor::new(shape, header.layout.samples, filter, args.window.taper(), cells)
        .map_err(|source| FocusError::Compress { path: args.recording.clone(), source })
}

/// Paths of the phase centres of a channel, transmitter and receiver, as the navigation in use tells them.
fn paths(nav: FocusNav, recording: &Recording, channel: usize) -> Result<[PhasePath; 2], RecordingError> {
    let row = &recording.header.channels[channel];
    let path = |name: &str| match nav {
        FocusNav::True | FocusNav::Both => recording.true_path(name),
        FocusNav::Reported => recording.reported_path(name),
    };
    Ok([path(&row.transmitter)?, path(&row.receiver)?])
}

/// The pulses of a channel, seen from such paths.
fn aperture<'a>(
    args: &FocusArgs,
    recording: &'a Recording,
    scenario: &Scenario,
    compressor: &'a Compressor,
    ground: &Ground,
    [transmitter, receiver]: [&'a PhasePath; 2],
    channel: usize,
) -> Result<Aperture<'a>, FocusError> {
    let illuminated: Vec<usize> =
        (0..recording.pulses()).filter(|p| recording.is_illuminated(*p, channel)).collect();
    if illuminated.is_empty() {
        return Err(FocusError::Dark { channel: recording.header.channels[channel].name.clone() });
    }
    let taper = args.aperture.taper();
    let weight = |place: usize| taper.weight((place as f64 + 0.5) / illuminated.len() as f64 - 0.5);
    let echo = |(place, pulse): (usize, &usize)| PulseEcho {
        emission_s: recording.emission_s[*pulse],
        window_start_s: recording.window_start_s[*pulse],
        weight: weight(place),
        samples: recording.window(*pulse, channel),
    };
    let mut aperture = Aperture {
        carrier_hz: recording.header.carrier_hz,
        compressor,
        transmitter,
        receiver,
        pulses: illuminated.iter().enumerate().map(echo).collect(),
        centre_m: ground.centre_m(),
        gate: None,
    };
    aperture.gate = gating::gate(args, recording, scenario, &aperture, ground, channel, &illuminated)?;
    if aperture.gate.is_some() {
        // The taper runs over the band then.
        aperture.pulses.iter_mut().for_each(|pulse| pulse.weight = 1.0);
    }
    Ok(aperture)
}

/// The image of an aperture, with its progress shown.
pub(in crate::cli) fn watched(aperture: &Aperture, ground: &Ground) -> Vec<Complex32> {
    let total = aperture.pulses.len() as u64;
    let (status, watcher) = progress::watch_of(total, "pulses focused");
    let images = fast(aperture, std::slice::from_ref(ground), &|done| {
        let _ = status.try_send(Status { passed: done as u64, total, late: 0, dropped: 0 });
    });
    drop(status);
    watcher.finish();
    images.into_iter().next().unwrap_or_default()
}

/// Focuses one channel.
fn one(
    args: &FocusArgs,
    recording: &Recording,
    scenario: &Scenario,
    compressor: &Compressor,
    ground: &Ground,
    channel: usize,
) -> Result<Focused, FocusError> {
    let [transmitter, receiver] = paths(args.nav, recording, channel)?;
    let ends = [&transmitter, &receiver];
    let aperture = aperture(args, recording, scenario, compressor, ground, ends, channel)?;
    let image = watched(&aperture, ground);
    if image.iter().all(|z| *z == Complex32::ZERO) {
        let name = one_line(&recording.header.channels[channel].name);
        match &aperture.gate {
            Some(gate) => say(format_args!(
                "channel {name}: no power on the image; does it lie within {} Hz of Doppler about the aim (--doppler-hz all), and in the receive windows?",
                gate.bandwidth_hz
            )),
            None => say(format_args!(
                "channel {name}: no power on the image; does it lie in the receive windows?"
            )),
        }
    }
    Ok(Focused {
        channel,
        pulses: aperture.pulses.len(),
        doppler_hz: aperture.gate.as_ref().map(|gate| gate.bandwidth_hz),
        image,
        support: Support::of(&aperture, ground.centre_m()),
        targets: targets(args, recording, &aperture, ground, channel)?,
    })
}

/// Targets of the truth record that lie on the image, and what they look like.
fn targets(
    args: &FocusArgs,
    recording: &Recording,
    aperture: &Aperture,
    ground: &Ground,
    channel: usize,
) -> Result<Vec<(String, Option<PointTarget>)>, FocusError> {
    let used = (args.nav == FocusNav::Reported).then_some([aperture.transmitter, aperture.receiver]);
    let (names, places): (Vec<_>, Vec<_>) = sought(recording, ground, channel, used).into_iter().unzip();
    let found = analyse(aperture, &places, [args.window.taper(), args.aperture.taper()]);
    Ok(names.into_iter().zip(found).collect())
}

/// Targets of the truth record, and where they should be on the image.
fn expected(recording: &Recording, ground: &Ground, channel: usize) -> Vec<(String, [f64; 3])> {
    sought(recording, ground, channel, None)
        .into_iter()
        .map(|(name, point)| (name, point.expected_m))
        .collect()
}

/// The same, and where the paths in use put them, if these are others.
fn sought(
    recording: &Recording,
    ground: &Ground,
    channel: usize,
    used: Option<[&PhasePath; 2]>,
) -> Vec<(String, Sought)> {
    let row = &recording.header.channels[channel];
    // Delays are true: where they belong is reported by the true paths, whatever the processor believes.
    let (Ok(transmitter), Ok(receiver)) =
        (recording.true_path(&row.transmitter), recording.true_path(&row.receiver))
    else {
        return Vec::new();
    };
    let inside = |point: &[f64; 3]| {
        (0..2).all(|axis| {
            let [low, high] = ground.edges_m(axis);
            (low..=high).contains(&point[axis])
        })
    };
    let place = |(place, name): (usize, &String)| {
        let delays_s = recording.delays_s(&row.transmitter, &row.receiver, place)?;
        let by = |[transmitter, receiver]: [&PhasePath; 2]| {
            locate(transmitter, receiver, &recording.emission_s, &delays_s, ground.centre_m())
        };
        let expected_m = by([&transmitter, &receiver]).filter(inside)?;
        // Errors of the navigation are known here; a point is sought where they move it.
        let about_m = used.and_then(by).unwrap_or(expected_m);
        Some((name.clone(), Sought { expected_m, about_m }))
    };
    recording.header.targets.iter().enumerate().filter_map(place).collect()
}

fn picture(
    args: &FocusArgs,
    recording: &Recording,
    ground: &Ground,
    focused: &Focused,
) -> Result<Canvas, CliError> {
    let power: Vec<f64> = focused.image.iter().map(|z| f64::from(z.norm_sqr())).collect();
    let (power, cells) = multilook(&power, ground.pixels, args.looks);
    let (values, quantity, limits) = match args.percentile {
        None => {
            let values: Vec<f64> = power.iter().map(|p| 10.0 * p.log10()).collect();
            (values, "dBW", Limits::Below { percent: 100.0, span: args.dynamic_db })
        }
        Some(percent) => {
            let values: Vec<f64> = power.iter().map(|p| p.sqrt()).collect();
            let top = percentile(&values, percent).unwrap_or(0.0);
            (values, "amplitude, sqrt(W)", Limits::Fixed([0.0, top.max(f64::MIN_POSITIVE * 1e20)]))
        }
    };
    let name = &recording.header.channels[focused.channel].name;
    let nav = match args.nav {
        FocusNav::True => "true",
        FocusNav::Reported => "reported",
        FocusNav::Both => "true and reported",
    };
    let title = format!("{name}, {}, {nav} navigation", counted(focused.pulses, "pulse"));
    let step = args.pixel_m * args.looks as f64;
    let edge = |axis: usize| {
        let [low, _] = ground.edges_m(axis);
        [low, low + cells[axis] as f64 * step]
    };
    let ([left, right], [lower, upper]) = (edge(0), edge(1));
    let picture = Picture {
        title: &title,
        x: Axis { label: "East, m", from: left, to: right },
        y: Axis { label: "North, m", from: lower, to: upper },
        quantity,
        limits,
        reduction: if args.percentile.is_none() { Reduction::MeanPower } else { Reduction::Mean },
        scale_bar: Some("m"),
        size_px: if args.panels { 512 } else { 768 },
        ..Picture::new(&values, cells).map_err(SeaError::from)?
    };
    Ok(picture.draw().map_err(SeaError::from)?)
}

fn values(
    args: &FocusArgs,
    recording: &Recording,
    ground: &Ground,
    names: &[String],
    focused: &[Focused],
    output: Output,
) -> Result<(), CliError> {
    let images: Vec<Vec<Complex32>> = focused.iter().map(|f| f.image.clone()).collect();
    let named = |value: Option<clap::builder::PossibleValue>| {
        value.map_or(String::new(), |value| value.get_name().to_owned())
    };
    let [nav, window, aperture, filter] = [
        named(args.nav.to_possible_value()),
        named(args.window.to_possible_value()),
        named(args.aperture.to_possible_value()),
        named(args.filter.to_possible_value()),
    ];
    let (first, last) = (recording.index[0], recording.index[recording.index.len() - 1]);
    // Not a number: all pulses.
    let doppler_hz: Vec<f64> = focused.iter().map(|f| f.doppler_hz.unwrap_or(f64::NAN)).collect();
    let attributes = [
        ("recording", Attribute::Text(&args.recording.display().to_string())),
        ("nav", Attribute::Text(&nav)),
        ("window", Attribute::Text(&window)),
        ("aperture", Attribute::Text(&aperture)),
        ("filter", Attribute::Text(&filter)),
        ("first_pulse", Attribute::Whole(first)),
        ("end_pulse", Attribute::Whole(last + 1)),
        ("height_m", Attribute::Real(args.height_m)),
        ("doppler_hz", Attribute::Reals(&doppler_hz)),
        ("carrier_hz", Attribute::Real(recording.header.carrier_hz)),
    ];
    let file = ImageFile { attributes: &attributes, channels: names, ground, images: &images };
    Ok(output.write(|partial| file.write(partial).map_err(FocusError::from))?)
}
