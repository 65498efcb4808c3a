//! `nereus focus`: an image of a recording.

pub mod error;
mod both;
mod images;
mod report;
mod speckle;
mod table;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use num_complex::Complex32;

use super::error::CliError;
use super::values::{PulseRange, distinct};
use super::{progress, say, warn};
use crate::inputs::one_line;
use crate::pipeline::memory::available_bytes;
use crate::pipeline::scenario::Scenario;
use crate::processor::focus::{self, DopplerBand, Focuser, Image, Navigation, Settings};
use crate::processor::point_target::PointTarget;
use crate::processor::range_compress::RangeFilter;
use crate::processor::taper::Taper;
use crate::recording::Recording;
use crate::recording::header::Header;
use error::FocusError;
use images::Outputs;

/// Which navigation the processor takes.
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

impl FocusNav {
    fn name(self) -> &'static str {
        match self {
            Self::True => "true",
            Self::Reported => "reported",
            Self::Both => "both",
        }
    }
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
    /// Which navigation the processor takes [default: true; of what was received over the wire, reported]
    #[arg(long, value_enum)]
    pub nav: Option<FocusNav>,
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
    #[arg(long, value_name = "HZ", allow_negative_numbers = true, value_parser = doppler_band)]
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
    image: Image,
    targets: Vec<(String, Option<PointTarget>)>,
}

impl FocusArgs {
    /// The navigation asked for; the true one unless [`Self::of`] has found none.
    fn nav(&self) -> FocusNav {
        self.nav.unwrap_or(FocusNav::True)
    }

    /// With the navigation that a recording has.
    fn of(&self, header: &Header) -> Self {
        let own = if header.truth { FocusNav::True } else { FocusNav::Reported };
        Self { nav: Some(self.nav.unwrap_or(own)), ..self.clone() }
    }

    fn settings(&self) -> Settings {
        Settings {
            nav: if self.nav() == FocusNav::True { Navigation::True } else { Navigation::Reported },
            centre_m: <[f64; 2]>::try_from(self.centre_m.as_slice()).ok(),
            size_m: [self.size_m[0], self.size_m[self.size_m.len() - 1]],
            pixel_m: self.pixel_m,
            height_m: self.height_m,
            window: self.window.taper(),
            aperture: self.aperture.taper(),
            doppler: self.doppler_hz.unwrap_or_default(),
            filter: match self.filter {
                FocusFilter::Matched => RangeFilter::Matched,
                FocusFilter::Flat => RangeFilter::Flat,
            },
            interpolation_db: self.interpolation_db,
        }
    }
}

fn doppler_band(text: &str) -> Result<DopplerBand, String> {
    match (text, text.parse::<f64>()) {
        ("all", _) => Ok(DopplerBand::All),
        (_, Ok(hz)) if hz > 0.0 && hz.is_finite() => Ok(DopplerBand::Hz(hz)),
        _ => Err("allowed: a number of Hz above 0, or all".to_owned()),
    }
}

/// Focuses.
pub(super) fn focus(args: &FocusArgs, out: &mut dyn Write) -> Result<(), CliError> {
    check(args)?;
    let path = &args.recording;
    for path in [Some(path), args.against.as_ref()].into_iter().flatten() {
        super::examine::examine(path)?;
    }
    let (recording, scenario) = open(args, path)?;
    let args = &args.of(&recording.header);
    if let (Some(asked), [.., last]) = (args.pulses, &recording.index[..])
        && asked.end - 1 > *last
    {
        warn([format!("--pulses {}..{}: the recording ends with pulse {last}", asked.first, asked.end)]);
    }
    let described = scenario.as_ref().map(Scenario::described);
    let focuser = Focuser::new(&recording, described, &args.settings()).map_err(FocusError::at(path))?;
    let [columns, rows] = focuser.ground().pixels;
    if args.looks > columns.min(rows) {
        return Err(FocusError::Looks { looks: args.looks, columns, rows }.into());
    }
    if args.nav() == FocusNav::Both {
        return both::compare(args, &focuser, scenario.as_ref(), out);
    }
    let channels = focuser.channels();
    let names: Vec<String> =
        channels.iter().map(|channel| recording.header.channels[*channel].name.clone()).collect();
    let outputs = Outputs::plan(args, &names)?;
    let begun = Instant::now();
    let focused: Vec<Focused> = channels
        .iter()
        .map(|channel| {
            let image = image(&focuser, *channel)?;
            Ok(Focused { image, targets: focuser.targets(*channel)? })
        })
        .collect::<Result<_, _>>()
        .map_err(FocusError::at(path))?;
    let seconds = begun.elapsed().as_secs_f64();
    let shown: Vec<(&Image, FocusNav)> = focused.iter().map(|f| (&f.image, args.nav())).collect();
    let made = outputs.write(args, &recording, &shown, &names)?;
    let report = report::report(args, &focuser, &focused, seconds, made)?;
    report::print(args, &report, out)
}

/// A recording's samples as asked for, and the scenario that it holds, where that can be read.
fn open(args: &FocusArgs, path: &Path) -> Result<(Recording, Option<Scenario>), FocusError> {
    let range = args.pulses.map(|p| p.first..p.end);
    let choose = |header: &Header| channels(args, path, header);
    let recording = Recording::open_channels(path, range, available_bytes(), choose)?;
    let scenario = Scenario::of(&recording);
    let Header { config, instrument, truth, .. } = &recording.header;
    // What was received over the wire has none.
    if let (Err(error), false) = (&scenario, config.is_empty() || !truth) {
        let aims = if instrument.is_some() { "" } else { "antennas count as having an aim, and " };
        let without = format!("{aims}no closed forms are shown");
        warn([format!("the scenario in the recording cannot be read: {without}:\n{error}")]);
    }
    Ok((recording, scenario.ok()))
}

/// The image of a channel, with its progress shown.
fn image(focuser: &Focuser, channel: usize) -> Result<Image, focus::FocusError> {
    let image = progress::focusing(|done| focuser.image(channel, done))?;
    if image.values.iter().all(|z| *z == Complex32::ZERO) {
        let name = one_line(&image.channel);
        let band = image.doppler_hz.map_or(String::new(), |hz| {
            format!("within {hz} Hz of Doppler about the aim (--doppler-hz all), and ")
        });
        say(format_args!("channel {name}: no power on the image; does it lie {band}in the receive windows?"));
    }
    Ok(image)
}

fn check(args: &FocusArgs) -> Result<(), FocusError> {
    both::check(args)?;
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
fn channels(args: &FocusArgs, path: &Path, header: &Header) -> Result<Vec<usize>, FocusError> {
    let all = &header.channels;
    let echoes: Vec<usize> = (0..all.len()).filter(|place| all[*place].is_of_echoes()).collect();
    if echoes.is_empty() {
        return Err(FocusError::at(path)(focus::FocusError::NoEchoes));
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
