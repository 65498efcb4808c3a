//! Statistics of a scenario's sea clutter over the azimuth of the wind: the echo of every pulse, focused into
//! images of which a pixel is a resolution cell, and the laws that fit them.

use std::path::PathBuf;

use crossbeam_channel::Sender;
use glam::DVec2;
use num_complex::Complex32;
use serde::Serialize;

use super::accuracy::noiseless;
use super::gather::gather;
use super::speed::SpeedError;
use crate::clutter::empirical::GRAZING_DEG;
use crate::clutter::fits::{Shape, Speckle, SpeckleSettings};
use crate::clutter::image::{self, Geometry, Image, ImageError, Place};
use crate::clutter::regression::{self, Cosine};
use crate::clutter::{Kind, SampleFault, sea_shape};
use crate::config::Run;
use crate::inputs::shown;
use crate::pipeline::build;
use crate::pipeline::fault::BuildErrors;
use crate::pipeline::memory::available_bytes;
use crate::pipeline::prepared::Prepared;
use crate::pulse::gathered::Gathered;
use crate::scene::Sea;
use crate::scene::radar::Polarisation;
use crate::scene::sea::PatchPlace;
use crate::transport::pacer::Status;

/// Why there are no statistics.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ClutterError {
    /// Pixels that hold sea in a part of the pulses only.
    #[error(
        "{}: scene.patch = \"follow\": its edges are sea in a part of the pulses only, which is no texture of the sea; allowed: \"fixed\"",
        shown(path)
    )]
    Follows {
        /// The scenario.
        path: PathBuf,
    },
    /// No image.
    #[error("{}: channel {channel}: {source}", shown(path))]
    Image {
        /// The scenario.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// What is wrong.
        source: ImageError,
    },
    /// A channel without echoes of the patch.
    #[error(
        "{}: channel {channel}: {source}; allowed: a window that covers the patch, antennas that illuminate it",
        shown(path)
    )]
    NoPower {
        /// The scenario.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// What is wrong.
        source: SampleFault,
    },
    /// Blocks of samples in place of pulses.
    #[error(
        "{}: an image takes a window for every pulse; allowed: radar.window.gate = \"windowed\"",
        shown(path)
    )]
    Continuous {
        /// The scenario.
        path: PathBuf,
    },
    /// Pulses that do not fit in memory.
    #[error(
        "{}: {pulses} pulses are {needed_mib} MiB of samples, {available_mib} MiB are free; allowed: a shorter scene.duration_s or fewer channels",
        shown(path)
    )]
    Memory {
        /// The scenario.
        path: PathBuf,
        /// Pulses of the run.
        pulses: u64,
        /// What they take.
        needed_mib: u64,
        /// What may be taken.
        available_mib: u64,
    },
    /// Tracks that cannot be loaded.
    #[error(transparent)]
    Build(#[from] BuildErrors),
    /// A run that fails.
    #[error(transparent)]
    Run(#[from] SpeedError),
}

impl ClutterError {
    /// Whether what was asked for is wrong, rather than the machine short of something.
    pub fn is_wrong_input(&self) -> bool {
        !matches!(self, Self::Run(SpeedError::Run(_)))
    }
}

/// One channel under one wind.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Azimuth {
    /// Its name.
    pub channel: String,
    /// Wind, from the look to where the wind blows: 0 downwind, 180 upwind.
    pub psi_deg: f64,
    /// Grazing angle at the near edge, in the middle, at the far edge.
    pub grazing_deg: [f64; 3],
    /// Resolution cell across the look and along it, m.
    pub cell_m: [f64; 2],
    /// Facets in such a cell.
    pub facets_per_cell: f64,
    /// Span of the mean power over range, which was divided out, dB.
    pub trend_db: Option<f64>,
    /// Ward, Baker and Watts, for HH and VV of one place within their grazing angles.
    pub empirical: Option<f64>,
    /// Laws that fit.
    #[serde(flatten)]
    pub speckle: Speckle,
}

/// `nu` over azimuth by one way to fit.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct OverAzimuth {
    /// The channel.
    pub channel: String,
    /// The way to fit: moments, likelihood or histogram.
    pub fit: &'static str,
    /// Mean of `a + b cos 2 psi`.
    pub a: f64,
    /// Its standard error.
    pub a_error: f64,
    /// Amplitude.
    pub b: f64,
    /// Its standard error.
    pub b_error: f64,
    /// Azimuths at which `nu` is finite.
    pub azimuths: usize,
}

/// What a way to fit found of a K law.
pub(super) type Found = fn(&Azimuth) -> Option<&Shape>;
/// The ways to fit.
pub(super) const WAYS: [(&str, Found); 3] = [
    ("moments", |azimuth| azimuth.speckle.law(Kind::K).map(|fits| &fits.moments)),
    ("likelihood", |azimuth| azimuth.speckle.law(Kind::K).map(|fits| &fits.likelihood)),
    ("histogram", |azimuth| azimuth.speckle.law(Kind::K).map(|fits| &fits.histogram)),
];

/// A scenario whose wind is turned about the look.
pub(crate) struct Winds {
    prepared: Prepared,
    sea: Sea,
    /// Direction in which the delay grows in the middle of the patch, counter-clockwise from East.
    look_rad: f64,
    place: Place,
}

/// The echo of one wind.
pub(crate) struct Echo {
    run: Run,
    sea: Sea,
    gathered: Gathered,
    replica: Vec<Complex32>,
}

impl Winds {
    /// Of a run and its sea, as one channel looks at them, in images of at most so many pixels across the
    /// look and along it. Noise and converter are left out.
    ///
    /// # Errors
    /// A patch that follows, tracks that cannot be loaded.
    pub fn new(run: &Run, sea: &Sea, channel: usize, most: [usize; 2]) -> Result<Self, ClutterError> {
        if sea.place != PatchPlace::Fixed {
            return Err(ClutterError::Follows { path: run.path.clone() });
        }
        if run.scene.radar.sent.is_some() {
            return Err(ClutterError::Continuous { path: run.path.clone() });
        }
        let mut run = noiseless(run);
        // Nothing waits to be released in time.
        run.stream.ring_slots = 1;
        let prepared = Prepared::of(&run)?;
        let middle_m = middle_m(sea);
        let look_rad = look_rad(&prepared, middle_m, channel);
        let place = Place { middle_m, patch_m: sea.patch.size_m(), most };
        Ok(Self { prepared, sea: sea.clone(), look_rad, place })
    }

    /// The echo of all pulses under a wind that blows `psi_rad` from the look: 0 downwind.
    ///
    /// # Errors
    /// Pulses that do not fit in memory, a run that fails.
    pub fn echo(&self, psi_rad: f64, status: Option<Sender<Status>>) -> Result<Echo, ClutterError> {
        let (mut run, mut sea) = (self.prepared.run().clone(), self.sea.clone());
        sea.water.wind.direction_rad = self.look_rad + psi_rad;
        run.scene.sea = Some(sea.clone());
        let total = run.scene.pulses;
        let stream = build::again(&self.prepared, &run, 0..total)?;
        let needed = (stream.factory().layout().slot_bytes() as u64).saturating_mul(total);
        if let Some(available) = available_bytes().filter(|available| needed > *available) {
            let path = run.path.clone();
            let (needed_mib, available_mib) = (needed >> 20, available >> 20);
            return Err(ClutterError::Memory { path, pulses: total, needed_mib, available_mib });
        }
        let replica = stream.factory().replica();
        Ok(Echo { gathered: gather(stream, status)?, run, sea, replica })
    }

    /// Statistics of a channel; `done` is called with the pulses that are focused, and all of them.
    ///
    /// # Errors
    /// No image, or no power in it.
    pub fn azimuth(
        &self,
        echo: &Echo,
        channel: usize,
        settings: &SpeckleSettings,
        done: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Azimuth, ClutterError> {
        let Echo { run, sea, gathered, replica } = echo;
        let radar = &run.scene.radar;
        let at = || (run.path.clone(), radar.channels[channel].name.clone());
        let image = image::image(radar, gathered, replica, channel, self.place, done).map_err(|source| {
            let (path, channel) = at();
            ClutterError::Image { path, channel, source }
        })?;
        let Image { powers, pixels, trend_db, geometry } = image;
        let speckle = Speckle::of(&powers, pixels, [1, 1], settings).map_err(|source| {
            let (path, channel) = at();
            ClutterError::NoPower { path, channel, source }
        })?;
        Ok(Azimuth::new(run, sea, geometry, trend_db, speckle))
    }
}

/// Middle of a patch that stays, East and North, m.
fn middle_m(sea: &Sea) -> [f64; 2] {
    let patch = sea.patch;
    let [low, high] = [0, patch.len() - 1].map(|place| patch.centre_m(patch.key(place)));
    [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])]
}

/// Direction in which the delay grows in the middle of the patch, counter-clockwise from East: where the
/// platforms are, lever arms left out.
fn look_rad(prepared: &Prepared, middle_m: [f64; 2], channel: usize) -> f64 {
    let (scene, radar) = (prepared.scene(), &prepared.scene().radar);
    let time = radar.emissions.emission(scene.start, scene.pulses / 2);
    let row = &radar.channels[channel];
    let platforms = [
        radar.transmitters[row.transmitter].antenna.platform,
        radar.receivers[row.receiver].antenna.platform,
    ];
    let mut along = DVec2::ZERO;
    for platform in platforms {
        if let Ok(state) = prepared.tracks()[platform].truth.state(time) {
            let [x, y, _] = state.position.to_array();
            along += (DVec2::from(middle_m) - DVec2::new(x, y)).normalize_or_zero();
        }
    }
    along.to_angle()
}

impl Azimuth {
    fn new(run: &Run, sea: &Sea, geometry: Geometry, trend_db: Option<f64>, speckle: Speckle) -> Self {
        let row = &run.scene.radar.channels[geometry.channel];
        // From just below 0, so that downwind is not 360.
        let psi_deg =
            ((sea.water.wind.direction_rad - geometry.look_rad).to_degrees() + 1.0).rem_euclid(360.0) - 1.0;
        let [_, grazing_deg, _] = geometry.grazing_deg;
        let vertical = match (row.rx, row.tx) {
            (Polarisation::V, Polarisation::V) => Some(true),
            (Polarisation::H, Polarisation::H) => Some(false),
            _ => None,
        };
        let holds = geometry.monostatic && (GRAZING_DEG[0]..=GRAZING_DEG[1]).contains(&grazing_deg);
        let empirical = vertical
            .filter(|_| holds)
            .map(|vertical| sea_shape(grazing_deg, geometry.cell_m, psi_deg.to_radians(), vertical));
        Self {
            channel: row.name.clone(),
            // The look is known to 1e-3 degrees: the radar moves on while the echo returns.
            psi_deg: (1e2 * psi_deg).round() / 1e2 + 0.0,
            grazing_deg: geometry.grazing_deg,
            cell_m: geometry.cell_m,
            facets_per_cell: geometry.cell_m[0] * geometry.cell_m[1] / sea.patch.facet_m.powi(2),
            trend_db,
            empirical,
            speckle,
        }
    }
}

/// The cosine through the shapes of every channel, by every way to fit.
pub(crate) fn over_azimuth(azimuths: &[Azimuth], channels: &[String]) -> Vec<OverAzimuth> {
    let one = |channel: &String, fit, way| {
        let Cosine { mean: a, mean_error: a_error, amplitude: b, amplitude_error: b_error, points } =
            cosine(azimuths, channel, way)?;
        Some(OverAzimuth { channel: channel.clone(), fit, a, a_error, b, b_error, azimuths: points })
    };
    channels
        .iter()
        .flat_map(|channel| WAYS.iter().filter_map(move |(fit, way)| one(channel, fit, *way)))
        .collect()
}

pub(super) fn cosine(azimuths: &[Azimuth], channel: &str, way: Found) -> Option<Cosine> {
    let own = azimuths.iter().filter(|azimuth| azimuth.channel == channel);
    let (psi_rad, shapes): (Vec<f64>, Vec<f64>) = own
        .map(|azimuth| {
            (azimuth.psi_deg.to_radians(), way(azimuth).and_then(|shape| shape.shape).unwrap_or(f64::NAN))
        })
        .unzip();
    regression::cosine(&psi_rad, &shapes)
}
