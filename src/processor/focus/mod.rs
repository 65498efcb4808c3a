//! A recording to its images: grid, navigation, range compression, the pulses of each pixel,
//! [back-projection](super::backproject).
//!
//! `nereus::focus(&recording, &settings)` gives the images of all channels of echoes that the recording
//! holds, as `nereus focus` makes them:
//!
//! | | |
//! | --- | --- |
//! | grid | [`Ground`]: pixel `(i, j)` is `values[j * pixels[0] + i]`, `i` to the East, `j` to the North, both of [`Settings::pixel_m`], on a plane of one height in the frame of the scene (ENU, m) |
//! | value | complex; a point whose echo has the amplitude `a` gives `a` at its place, sqrt(W), whatever filter and tapers; its phase is that of the scatterer, without the carrier's `-2 pi f0 tau` |
//! | middle | where the radar looks at the middle pulse, to a metre: what the receive window follows, else the aim of the receiver, else that of the transmitter, else the middle of a patch that stays, else the origin |
//! | pulses | those that left in the channel's polarisation; a pixel takes those in whose Doppler band it lies ([`DopplerBand`]) |
//!
//! Neither gain nor range is taken out. Where antennas and window look, and whether an antenna has an aim,
//! follows from the [`Instrument`] that the recording describes, and of recordings of earlier versions from
//! their scenario: without both ([`Focuser::new`]) the middle has to be given, and every antenna counts as
//! one that has an aim.

mod error;
mod figures;
mod gating;
mod boresight;
pub mod picture;

use num_complex::Complex32;

pub use error::FocusError;
pub use figures::ImageFigures;

use super::backproject::{Aperture, PulseEcho, fast};
use super::multilook::multilook;
use super::point_target::{PointTarget, Sought, Support, analyse, locate};
use super::range_compress::{Compressor, PulseShape, RangeFilter, interpolation_error_db, oversampling};
use super::taper::Taper;
use crate::geometry::phase_path::PhasePath;
use crate::motion::PlatformNav;
use crate::recording::ground::Ground;
use crate::recording::instrument::Instrument;
use crate::recording::{Recording, RecordingError};
use crate::scene::Scene;

/// By which phase centres an image is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Navigation {
    /// The true ones.
    #[default]
    True,
    /// Those that the platforms report, with the lever arms as designed.
    Reported,
}

/// From which pulses a pixel is made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum DopplerBand {
    /// From a band as wide as the pulse rate about the aim of the antennas, where the image reaches beyond
    /// it in some pulse; from all pulses otherwise.
    #[default]
    WhereNeeded,
    /// From all pulses.
    All,
    /// From a band so wide about the aim of the antennas, Hz.
    Hz(f64),
}

/// How an image is made. The defaults are those of `nereus focus`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Settings {
    /// By which phase centres.
    pub nav: Navigation,
    /// Middle of the image, East and North, m; none: where the radar looks.
    pub centre_m: Option<[f64; 2]>,
    /// Sides of the image, East and North, m.
    pub size_m: [f64; 2],
    /// Distance of pixels, m.
    pub pixel_m: f64,
    /// Height of the plane in the frame of the scene, m.
    pub height_m: f64,
    /// Taper over the band.
    pub window: Taper,
    /// Taper over the pulses, or over the Doppler band.
    pub aperture: Taper,
    /// Pulses of a pixel.
    pub doppler: DopplerBand,
    /// Filter of the range compression.
    pub filter: RangeFilter,
    /// Error of the interpolation between cells of a compressed pulse, dB.
    pub interpolation_db: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            nav: Navigation::True,
            centre_m: None,
            size_m: [512.0; 2],
            pixel_m: 1.0,
            height_m: 0.0,
            window: Taper::Uniform,
            aperture: Taper::Uniform,
            doppler: DopplerBand::WhereNeeded,
            filter: RangeFilter::Matched,
            interpolation_db: -60.0,
        }
    }
}

/// The image of one channel.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Image {
    /// Name of the channel.
    pub channel: String,
    /// Points of the pixels, ENU, m.
    pub ground: Ground,
    /// Complex amplitudes, sqrt(W), row by row from the South, each from the West.
    pub values: Vec<Complex32>,
    /// Pulses in use.
    pub pulses: usize,
    /// Width of the Doppler band from which a pixel takes its pulses, Hz; none: every pixel takes every
    /// pulse.
    pub doppler_hz: Option<f64>,
    /// Resolution cells in the middle of the image, by theory; none without cross-range.
    pub support: Option<Support>,
}

impl Image {
    /// Means of power over `looks` by `looks` pixels, W, and how many there are to the East and to the North.
    pub fn power(&self, looks: usize) -> (Vec<f64>, [usize; 2]) {
        let power: Vec<f64> = self.values.iter().map(|z| f64::from(z.norm_sqr())).collect();
        multilook(&power, self.ground.pixels, looks)
    }
}

/// What the scenario in a recording describes.
#[derive(Clone, Copy, Debug)]
pub struct Described<'a> {
    /// What there is.
    pub scene: &'a Scene,
    /// Where the platforms of the scene go, and what is wrong with their reports.
    pub nav: &'a [PlatformNav],
}

/// A recording, ready to be focused onto one grid.
pub struct Focuser<'a> {
    recording: &'a Recording,
    scenario: Option<Described<'a>>,
    /// As the recording describes it, else as its scenario does.
    instrument: Option<Instrument>,
    settings: Settings,
    ground: Ground,
    compressor: Compressor,
}

impl<'a> Focuser<'a> {
    /// Of a recording and what its scenario describes; none where that is not known.
    ///
    /// # Errors
    /// No channel of echoes, no replica, no true navigation where that is asked, no middle, a grid that
    /// cannot be, settings out of range.
    pub fn new(
        recording: &'a Recording,
        scenario: Option<Described<'a>>,
        settings: &Settings,
    ) -> Result<Self, FocusError> {
        if recording.header.is_continuous() {
            return Err(FocusError::Continuous);
        }
        if recording.header.is_dechirped() {
            return Err(FocusError::Dechirped);
        }
        let compressor = compressor(recording, settings)?;
        let channel = *echoes(recording).first().ok_or(FocusError::NoEchoes)?;
        let instrument = instrument(recording, scenario);
        let middle = || {
            let instrument = instrument.as_ref().ok_or(FocusError::NoCentre)?;
            // A round number of metres is easier to give again.
            Ok(boresight::centre_m(recording, instrument, channel, recording.pulses() / 2).map(f64::round))
        };
        let [x, y] = settings.centre_m.map_or_else(middle, Ok::<_, FocusError>)?;
        let ground = Ground::map([x, y, settings.height_m], settings.size_m, settings.pixel_m)?;
        Ok(Self { recording, scenario, instrument, settings: settings.clone(), ground, compressor })
    }

    /// Another recording onto the same grid, by true navigation.
    ///
    /// # Errors
    /// No replica, no true navigation.
    pub fn by_truth<'b>(
        &self,
        recording: &'b Recording,
        scenario: Option<Described<'b>>,
    ) -> Result<Focuser<'b>, FocusError> {
        let settings = Settings { nav: Navigation::True, ..self.settings.clone() };
        let compressor = compressor(recording, &settings)?;
        let instrument = instrument(recording, scenario);
        Ok(Focuser { recording, scenario, instrument, settings, ground: self.ground, compressor })
    }

    /// The recording.
    pub fn recording(&self) -> &'a Recording {
        self.recording
    }

    /// What its scenario describes.
    pub(super) fn scenario(&self) -> Option<Described<'a>> {
        self.scenario
    }

    /// How images are made.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The points of the images.
    pub fn ground(&self) -> &Ground {
        &self.ground
    }

    /// Middle of the pulse after its emission, s.
    pub(super) fn middle_s(&self) -> f64 {
        self.compressor.middle_s()
    }

    /// Predicted error of the interpolation between cells of a compressed pulse, dB.
    pub fn interpolation_error_db(&self) -> f64 {
        interpolation_error_db(2.0 * self.recording.header.band().reach_hz(), self.compressor.cell_rate_hz())
    }

    /// Places of the channels of echoes whose samples the recording holds.
    pub fn channels(&self) -> Vec<usize> {
        echoes(self.recording)
    }

    /// The image of a channel; `done` is called with the pulses that are in it, and those of the channel.
    ///
    /// # Errors
    /// Phase centres that the recording lacks, a Doppler band without aim, no pulse of this polarisation.
    pub fn image(&self, channel: usize, done: &(dyn Fn(usize, usize) + Sync)) -> Result<Image, FocusError> {
        self.with_aperture(channel, |aperture| {
            let pulses = aperture.pulses.len();
            let images = fast(aperture, std::slice::from_ref(&self.ground), &|passed| done(passed, pulses));
            Image {
                channel: self.recording.header.channels[channel].name.clone(),
                ground: self.ground,
                values: images.into_iter().next().unwrap_or_default(),
                pulses,
                doppler_hz: aperture.gate.as_ref().map(|gate| gate.bandwidth_hz),
                support: Support::of(aperture, self.ground.centre_m()),
            }
        })
    }

    /// Targets of the truth record that lie on the image of a channel, and what they look like there; none
    /// where no main lobe is found.
    ///
    /// # Errors
    /// Those of [`Self::image`].
    pub fn targets(&self, channel: usize) -> Result<Vec<(String, Option<PointTarget>)>, FocusError> {
        self.with_aperture(channel, |aperture| {
            let reported = self.settings.nav == Navigation::Reported;
            let used = reported.then_some([aperture.transmitter, aperture.receiver]);
            let (names, places): (Vec<_>, Vec<_>) = self.sought(channel, used).into_iter().unzip();
            let found = analyse(aperture, &places, [self.settings.window, self.settings.aperture]);
            names.into_iter().zip(found).collect()
        })
    }

    /// Targets of the truth record, and where they should be on the image.
    pub(super) fn expected(&self, channel: usize) -> Vec<(String, [f64; 3])> {
        self.sought(channel, None).into_iter().map(|(name, point)| (name, point.expected_m)).collect()
    }

    /// The same, and where the paths in use put them, if these are others.
    fn sought(&self, channel: usize, used: Option<[&PhasePath; 2]>) -> Vec<(String, Sought)> {
        let (recording, ground) = (self.recording, &self.ground);
        let row = &recording.header.channels[channel];
        // Delays are true: where they belong follows from the true paths, whatever navigation is in use.
        let Ok([transmitter, receiver]) = self.paths(Navigation::True, channel) else { return Vec::new() };
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

    /// Paths of the phase centres of a channel, transmitter and receiver.
    pub(super) fn paths(&self, nav: Navigation, channel: usize) -> Result<[PhasePath; 2], RecordingError> {
        let row = &self.recording.header.channels[channel];
        let path = |name: &str| match nav {
            Navigation::True => self.recording.true_path(name),
            Navigation::Reported => self.recording.reported_path(name),
        };
        Ok([path(&row.transmitter)?, path(&row.receiver)?])
    }

    /// What follows from the pulses of a channel, seen from the paths of the navigation in use.
    pub(super) fn with_aperture<T>(
        &self,
        channel: usize,
        made: impl FnOnce(&Aperture) -> T,
    ) -> Result<T, FocusError> {
        let recording = self.recording;
        let [transmitter, receiver] = &self.paths(self.settings.nav, channel)?;
        let illuminated: Vec<usize> =
            (0..recording.pulses()).filter(|pulse| recording.is_illuminated(*pulse, channel)).collect();
        if illuminated.is_empty() {
            let channel = recording.header.channels[channel].name.clone();
            return Err(FocusError::NotIlluminated { channel });
        }
        let taper = self.settings.aperture;
        let weight = |place: usize| taper.weight((place as f64 + 0.5) / illuminated.len() as f64 - 0.5);
        let echo = |(place, pulse): (usize, &usize)| PulseEcho {
            number: recording.index[*pulse],
            emission_s: recording.emission_s[*pulse],
            window_start_s: recording.window_start_of(*pulse, channel),
            weight: weight(place),
            samples: recording.window(*pulse, channel),
        };
        let mut aperture = Aperture {
            carrier_hz: recording.header.carrier_hz,
            compressor: &self.compressor,
            transmitter,
            receiver,
            pulses: illuminated.iter().enumerate().map(echo).collect(),
            centre_m: self.ground.centre_m(),
            gate: None,
        };
        aperture.gate = self.gate(&aperture, channel, &illuminated)?;
        if aperture.gate.is_some() {
            // The taper runs over the band then.
            aperture.pulses.iter_mut().for_each(|pulse| pulse.weight = 1.0);
        }
        Ok(made(&aperture))
    }
}

/// Channels of echoes among those that are held. Those of calibration bear a word in place of two
/// polarisations.
fn echoes(recording: &Recording) -> Vec<usize> {
    let is_of_echoes = |channel: &usize| recording.header.channels[*channel].is_of_echoes();
    recording.channels().iter().copied().filter(is_of_echoes).collect()
}

/// What is known of the radar: by the recording itself, else by its scenario.
fn instrument(recording: &Recording, scenario: Option<Described>) -> Option<Instrument> {
    let described = || scenario.map(|scenario| Instrument::of(scenario.scene));
    recording.header.instrument.clone().or_else(described)
}

fn compressor(recording: &Recording, settings: &Settings) -> Result<Compressor, FocusError> {
    let header = &recording.header;
    if header.replica.is_empty() {
        return Err(FocusError::NoReplica);
    }
    if settings.nav == Navigation::True && !header.truth {
        return Err(FocusError::NoTruth);
    }
    let found_db = settings.interpolation_db;
    if !(-100.0..0.0).contains(&found_db) {
        return Err(FocusError::Interpolation { found_db });
    }
    let cells = oversampling(2.0 * header.band().reach_hz(), header.sample_rate_hz, found_db);
    let shape = PulseShape::of(header);
    Ok(Compressor::new(shape, header.layout.samples, settings.filter, settings.window, cells)?)
}
