//! `nereus focus`: an image of a recording.

mod both;
mod images;
mod report;
mod table;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use num_complex::Complex32;

use super::error::{CliError, Refused};
use super::report::Report;
use super::values::{PulseRange, Unreadable, Word, allowed, distinct, one_of};
use super::{escape, progress, say, warn};
use crate::inputs::one_line;
use crate::pipeline::memory::available_bytes;
use crate::pipeline::scenario::Scenario;
use crate::processor::focus::{DopplerBand, FocusError, Focuser, Image, Navigation, Settings};
use crate::processor::range_compress::RangeFilter;
use crate::processor::taper::Taper;
use crate::recording::Recording;
use crate::recording::examination::examine;
use crate::recording::header::Header;
use crate::units::digits;
use images::Outputs;

/// Which navigation the processor takes; `None`: both.
type Nav = Option<Navigation>;

const NAVS: [Word<Nav>; 3] = [
    ("true", "True phase centres", Some(Navigation::True)),
    ("reported", "Phase centres as the platforms report them", Some(Navigation::Reported)),
    ("both", "Both, side by side: what the errors of the reports do, predicted and measured", None),
];
pub(super) const TAPERS: [Word<Taper>; 4] = [
    ("none", "All weights are 1", Taper::Uniform),
    ("hann", "Raised cosine", Taper::Hann),
    ("taylor", "Side lobes of -35 dB", Taper::Taylor),
    ("kaiser", "Kaiser, beta 6", Taper::Kaiser),
];
/// What becomes of the spectrum of the pulse.
const FILTERS: [Word<RangeFilter>; 2] = [
    ("matched", "Matched filter", RangeFilter::Matched),
    ("flat", "Spectrum of the pulse divided out within its band", RangeFilter::Flat),
];

/// `nereus focus`
#[derive(Clone, Debug, Args)]
pub struct FocusArgs {
    /// Recording: an HDF5 file or a plain folder
    pub recording: PathBuf,
    /// Which navigation the processor takes [default: true; of what was received over the wire, reported]
    #[arg(long, value_parser = one_of(NAVS))]
    pub nav: Option<Nav>,
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
    #[arg(
        long,
        value_name = "X,Y",
        value_delimiter = ',',
        num_args = 1,
        default_value = "512",
        allow_negative_numbers = true
    )]
    pub size_m: Vec<f64>,
    /// Distance of pixels
    #[arg(long, value_name = "M", default_value_t = 1.0)]
    pub pixel_m: f64,
    /// Height of the plane in the frame of the scene
    #[arg(long, value_name = "M", default_value_t = 0.0, allow_hyphen_values = true)]
    pub height_m: f64,
    /// Taper over the band
    #[arg(long, value_parser = one_of(TAPERS), default_value = "none")]
    pub window: Taper,
    /// Doppler band about the aim of the antennas from which a pixel takes its pulses: Hz, or `all` for all
    /// pulses [default: the pulse rate, where the image reaches beyond it]
    #[arg(long, value_name = "HZ", allow_negative_numbers = true, value_parser = doppler_band)]
    pub doppler_hz: Option<DopplerBand>,
    /// Taper over the pulses, or over the Doppler band
    #[arg(long, value_parser = one_of(TAPERS), default_value = "none")]
    pub aperture: Taper,
    /// Filter of the range compression
    #[arg(long, value_parser = one_of(FILTERS), default_value = "matched")]
    pub filter: RangeFilter,
    /// Error of the interpolation between cells of a compressed pulse
    #[arg(long, value_name = "DB", default_value_t = -60.0, allow_negative_numbers = true)]
    pub interpolation_db: f64,
    /// Multilook: average power over N x N pixels, in pictures and statistics
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
    /// image), one per channel
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

impl FocusArgs {
    /// The navigation asked for; the true one unless [`Self::of`] has found none.
    fn nav(&self) -> Nav {
        self.nav.unwrap_or(Some(Navigation::True))
    }

    /// With the navigation that a recording has.
    fn of(&self, header: &Header) -> Self {
        let own = if header.truth { Navigation::True } else { Navigation::Reported };
        Self { nav: Some(self.nav.unwrap_or(Some(own))), ..self.clone() }
    }

    fn settings(&self) -> Settings {
        Settings {
            nav: self.nav().unwrap_or(Navigation::Reported),
            centre_m: <[f64; 2]>::try_from(self.centre_m.as_slice()).ok(),
            size_m: [self.size_m[0], self.size_m[self.size_m.len() - 1]],
            pixel_m: self.pixel_m,
            height_m: self.height_m,
            window: self.window,
            aperture: self.aperture,
            doppler: self.doppler_hz.unwrap_or_default(),
            filter: self.filter,
            interpolation_db: self.interpolation_db,
        }
    }
}

fn doppler_band(text: &str) -> Result<DopplerBand, Unreadable> {
    let band = match (text, text.parse::<f64>()) {
        ("all", _) => Some(DopplerBand::All),
        (_, Ok(hz)) if hz > 0.0 && hz.is_finite() => Some(DopplerBand::Hz(hz)),
        _ => None,
    };
    allowed(band, "a number of Hz above 0, or all")
}

/// Why a recording cannot be focused.
fn at(path: &Path) -> impl Fn(FocusError) -> CliError {
    move |source| CliError::Focus { path: path.to_owned(), source }
}

/// Focuses.
pub(super) fn focus(args: &FocusArgs, out: &mut dyn Write) -> Result<(), CliError> {
    check(args)?;
    let path = &args.recording;
    for path in [Some(path), args.against.as_ref()].into_iter().flatten() {
        examine(path)?;
    }
    let (recording, scenario) = open(args, path)?;
    let args = &args.of(&recording.header);
    if let (Some(asked), [.., last]) = (args.pulses, &recording.index[..])
        && asked.end - 1 > *last
    {
        warn([format!("--pulses {}..{}: the recording ends with pulse {last}", asked.first, asked.end)]);
    }
    let (held, of_run) = (recording.index.len() as u64, recording.header.pulses);
    if args.pulses.is_none() && held < of_run {
        warn([format!("{}: holds {held} of the {of_run} pulses of its run", path.display())]);
    }
    let described = scenario.as_ref().map(Scenario::described);
    let focuser = Focuser::new(&recording, described, &args.settings()).map_err(at(path))?;
    let [columns, rows] = focuser.ground().pixels;
    if args.looks > columns.min(rows) {
        let allowed = format!("up to the shorter side of the image, which has {columns} x {rows} pixels");
        return Err(Refused::value("looks", args.looks, allowed).into());
    }
    if args.nav().is_none() {
        return both::compare(args, &focuser, scenario.as_ref(), out);
    }
    let channels = focuser.channels();
    let names = names(&recording, &channels);
    let outputs = Outputs::plan(args, &names)?;
    let begun = Instant::now();
    let (mut images, mut targets) = (Vec::new(), Vec::new());
    for channel in channels {
        images.push(image(&focuser, channel).map_err(at(path))?);
        targets.push(focuser.targets(channel).map_err(at(path))?);
    }
    let seconds = begun.elapsed().as_secs_f64();
    let shown: Vec<(&Image, Nav)> = images.iter().map(|image| (image, args.nav())).collect();
    let made = outputs.write(args, &recording, &shown, &names)?;
    let report = report::report(args, &focuser, (&images, &targets), seconds, &made)?;
    print(args, report, &made, out)
}

/// Prints a report; files that were made are said of beside its text.
fn print(args: &FocusArgs, report: Report, made: &[PathBuf], out: &mut dyn Write) -> Result<(), CliError> {
    report.print(args.json, out)?;
    if !args.json {
        made.iter().for_each(|path| say(escape::path(path)));
    }
    Ok(())
}

/// Names of the channels at such places.
fn names(recording: &Recording, channels: &[usize]) -> Vec<String> {
    channels.iter().map(|channel| recording.header.channels[*channel].name.clone()).collect()
}

/// A recording's samples as asked for, and the scenario that it holds, where that can be read.
fn open(args: &FocusArgs, path: &Path) -> Result<(Recording, Option<Scenario>), CliError> {
    let choose = |header: &Header| channels(args, path, header);
    let opened = Recording::open_channels(path, args.pulses.map(Into::into), available_bytes(), choose);
    // Wrong input (exit 2) whatever the fault: nothing is written here, so what cannot be read was named
    // wrongly or is damaged.
    let recording = opened.map_err(|error| match error {
        CliError::Recording(source) => at(path)(source.into()),
        error => error,
    })?;
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
fn image(focuser: &Focuser, channel: usize) -> Result<Image, FocusError> {
    let image = progress::counting("pulses focused", |done| focuser.image(channel, done))?;
    let name = one_line(&image.channel);
    if image.values.iter().all(|z| *z == Complex32::ZERO) {
        let band = image.doppler_hz.map_or(String::new(), |hz| {
            format!("within {hz} Hz of Doppler about the aim (--doppler-hz all), and ")
        });
        warn([format!("channel {name}: no power on the image; does it lie {band}in the receive windows?")]);
    }
    let pixel_m = focuser.settings().pixel_m;
    // Said once: channels see the image from the same side.
    if let Some(coarsest_m) = image.support.map(|support| support.coarsest_pixel_m())
        && pixel_m > coarsest_m
        && focuser.channels().first() == Some(&channel)
    {
        // Half of it: a peak between four pixels loses 0.9 dB along each side.
        warn([format!(
            "pixels of {pixel_m} m undersample the image: peaks and contrast are lower than they are; \
             --pixel-m {} keeps a peak within 1 dB along each side",
            digits(0.5 * coarsest_m)
        )]);
    }
    Ok(image)
}

fn check(args: &FocusArgs) -> Result<(), Refused> {
    both::check(args)?;
    let FocusArgs { centre_m, size_m, dynamic_db, looks, interpolation_db, .. } = args;
    let refused = if !matches!(centre_m[..], [] | [_, _]) {
        Refused::value("centre-m", format!("{centre_m:?}"), "two numbers X,Y")
    } else if !(1..=2).contains(&size_m.len()) {
        Refused::value("size-m", format!("{size_m:?}"), "one or two numbers above 0")
    } else if let Some(percentile) = args.percentile.filter(|percent| !(*percent > 0.0 && *percent <= 100.0))
    {
        Refused::value("percentile", percentile, "a number above 0, up to 100")
    } else if !(*dynamic_db > 0.0 && *dynamic_db <= 300.0) {
        Refused::value("dynamic-db", dynamic_db, "a number above 0, up to 300")
    } else if !(1..=4096).contains(looks) {
        Refused::value("looks", looks, "a whole number from 1 to 4096")
    } else if !(-100.0..0.0).contains(interpolation_db) {
        Refused::value("interpolation-db", interpolation_db, "a number from -100 to below 0")
    } else {
        return Ok(());
    };
    Err(refused)
}

/// Channels asked for, or all of echoes. Those of calibration bear a word in place of two polarisations.
fn channels(args: &FocusArgs, path: &Path, header: &Header) -> Result<Vec<usize>, CliError> {
    let all = &header.channels;
    let echoes: Vec<usize> = (0..all.len()).filter(|place| all[*place].is_of_echoes()).collect();
    if echoes.is_empty() {
        return Err(at(path)(FocusError::NoEchoes));
    }
    if args.channel.is_empty() {
        return Ok(echoes);
    }
    let allowed = || echoes.iter().map(|place| one_line(&all[*place].name)).collect::<Vec<_>>().join(", ");
    let place = |name: &String| match all.iter().position(|channel| channel.name == *name) {
        None => Err(Refused::Channel { name: name.clone(), allowed: allowed() }),
        Some(place) if !echoes.contains(&place) => Err(Refused::Calibration {
            name: name.clone(),
            kind: all[place].polarisations.clone(),
            allowed: allowed(),
        }),
        Some(place) => Ok(place),
    };
    Ok(distinct(args.channel.iter().map(place).collect::<Result<_, _>>()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::values::word_of;

    /// The words go into files. A new variant must be named here to compile.
    #[test]
    fn every_choice_has_a_word() {
        for taper in [Taper::Uniform, Taper::Hann, Taper::Taylor, Taper::Kaiser] {
            let (Taper::Uniform | Taper::Hann | Taper::Taylor | Taper::Kaiser) = taper;
            assert_ne!(word_of(&TAPERS, &taper), "", "{taper:?}");
        }
        for filter in [RangeFilter::Matched, RangeFilter::Flat] {
            let (RangeFilter::Matched | RangeFilter::Flat) = filter;
            assert_ne!(word_of(&FILTERS, &filter), "", "{filter:?}");
        }
        for nav in [None, Some(Navigation::True), Some(Navigation::Reported)] {
            let (None | Some(Navigation::True | Navigation::Reported)) = nav;
            assert_ne!(word_of(&NAVS, &nav), "", "{nav:?}");
        }
    }
}
