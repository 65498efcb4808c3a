//! Plan position: power over range and reported bearing, from the pulses of a scanning antenna.
//!
//! | quantity | how |
//! | --- | --- |
//! | range | `c/2 (t_w + i/fs)`: `t_w` start of the window after the emission, `i` sample; slant range, m |
//! | bearing | what the encoder reads, plus the heading that the platform reports where it counts from the nose |
//! | power | `|C|^2` of the pulse compressed with the recorded replica ([`range_compress`]), W |
//! | half a beam | half of the two-way half-power beamwidth |
//!
//! The beamwidth of a uniform aperture is `0.886 lambda / D` of a rectangle and `1.029 lambda / D` of an
//! ellipse (C. A. Balanis, "Antenna Theory", chapter 12); those of both antennas, where both scan, combine as
//! those of Gaussian beams, `1/b^2 = 1/b_T^2 + 1/b_R^2`. Tapers are not recorded and make beams wider.
//! Roll and pitch of the platform are left out of the bearing, as on a radar that adds its heading alone, and
//! so is its way during a scan: the middle of the plan goes with it.
//!
//! Pulses are read in blocks. [`Polar`] keeps the strongest of what falls into its cells, so memory has a
//! bound whatever there is in a scan.
//!
//! ```no_run
//! use nereus::processor::ppi::{Ppi, Settings};
//! let ppi = Ppi::open("scan.h5".as_ref(), &Settings::default())?;
//! let polar = ppi.polar(ppi.last_whole(), None, &|_, _| {})?;
//! for peak in polar.strongest(5, ppi.far_m(), ppi.extent()) {
//!     println!("{:.0} m at {:.2} degrees", peak.range_m, peak.bearing_rad.to_degrees());
//! }
//! # Ok::<(), nereus::processor::ppi::PpiError>(())
//! ```
//!
//! [`range_compress`]: super::range_compress

mod error;
mod polar;
mod scans;
mod sight;

use std::path::{Path, PathBuf};

use glam::DQuat;
use rayon::prelude::*;

pub use error::PpiError;
pub use polar::{Extent, Peak, Polar, SPOKES};
pub use scans::{Motion, Scan, scans};
pub(crate) use sight::Sight;

use super::range_compress::{Compressor, PulseShape, RangeFilter};
use super::taper::Taper;
use crate::frames::Rotation;
use crate::recording::{Recording, RecordingError};
use crate::units::SPEED_OF_LIGHT_MPS;

/// Cells of a compressed pulse in a sample: a peak between two cells loses at most 0.6 dB at `B = 0.8 fs`.
const OVERSAMPLING: usize = 2;
/// Samples that are read at a time, bytes in memory.
const BLOCK_BYTES: usize = 8 << 20;
/// Beamwidth where the aperture is not known: 1 degree.
const USUAL_BEAM_RAD: f64 = std::f64::consts::PI / 180.0;

/// How a plan is made.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Settings {
    /// The channel; none: the first of echoes whose receiver scans, on the platform of its transmitter.
    pub channel: Option<String>,
    /// Whether bearings count from the reported heading instead of North.
    pub head_up: bool,
    /// Taper over the band.
    pub window: Taper,
    /// Two-way half-power beamwidth, degrees; none: by the apertures, or 1.
    pub beam_deg: Option<f64>,
}

/// A recording of a scanning antenna.
pub struct Ppi {
    path: PathBuf,
    /// Everything but samples.
    recording: Recording,
    channel: usize,
    compressor: Compressor,
    /// Places of the pulses that left in the polarisation of the channel.
    pulses: Vec<usize>,
    /// Bearing of each of these, rad.
    bearings_rad: Vec<f64>,
    /// What bearings count from, clockwise from North, rad.
    headings_rad: Vec<f64>,
    scans: Vec<Scan>,
    extent: Extent,
    ranges_m: [f64; 2],
}

impl Ppi {
    /// Reads everything but the samples of a recording, and finds its scans.
    ///
    /// # Errors
    /// What cannot be read, a channel that there is not, one that is bistatic or does not scan, no replica.
    pub fn open(path: &Path, settings: &Settings) -> Result<Self, PpiError> {
        let recording = Recording::open_channels(path, None, None, |_| Ok::<_, RecordingError>(Vec::new()))?;
        let header = &recording.header;
        let (channel, sight) = Sight::of(header, settings.channel.as_deref())?;
        let shape = PulseShape::of(header);
        let samples = header.layout.samples;
        let compressor =
            Compressor::new(shape, samples, RangeFilter::Matched, settings.window, OVERSAMPLING)?;
        let row = &header.channels[channel];
        let pulses: Vec<usize> =
            (0..recording.pulses()).filter(|pulse| recording.is_illuminated(*pulse, channel)).collect();
        if pulses.is_empty() {
            return Err(PpiError::NotIlluminated { channel: row.name.clone() });
        }
        let mut readings_rad = Vec::with_capacity(pulses.len());
        let mut noses_rad = Vec::with_capacity(pulses.len());
        for pulse in &pulses {
            readings_rad.push(recording.encoder_rad(&row.receiver, *pulse)?[0]);
            let is_needed = settings.head_up || !sight.is_level;
            noses_rad.push(if is_needed { heading_rad(&recording, &sight.platform, *pulse)? } else { 0.0 });
        }
        let beam_rad = match settings.beam_deg {
            Some(deg) if deg > 0.0 && deg <= 180.0 => deg.to_radians(),
            Some(asked_deg) => return Err(PpiError::Beam { asked_deg }),
            None => sight.beam_rad.unwrap_or(USUAL_BEAM_RAD),
        };
        let times_s: Vec<f64> = pulses.iter().map(|pulse| recording.emission_s[*pulse]).collect();
        let scans = scans(sight.motion, &readings_rad, &times_s, 0.5 * beam_rad);
        let zero = |place: usize| if settings.head_up { noses_rad[place] } else { 0.0 };
        let headings_rad: Vec<f64> = (0..pulses.len()).map(zero).collect();
        let bearing = |place: usize| {
            let from_north = if sight.is_level { 0.0 } else { noses_rad[place] };
            readings_rad[place] + from_north - headings_rad[place]
        };
        let half_c = 0.5 * SPEED_OF_LIGHT_MPS;
        let widths_hz = header.in_turn().iter().map(|row| row.bandwidth_hz);
        let narrowest_hz = widths_hz.reduce(f64::min).unwrap_or(header.bandwidth_hz);
        let starts = || pulses.iter().map(|pulse| half_c * recording.window_start_of(*pulse, channel));
        let near_m = starts().fold(f64::INFINITY, f64::min).max(0.0);
        let length_m = half_c * (samples - 1) as f64 / header.sample_rate_hz;
        let far_m = starts().fold(f64::NEG_INFINITY, f64::max) + length_m;
        Ok(Self {
            bearings_rad: (0..pulses.len()).map(bearing).collect(),
            extent: Extent {
                beam_rad,
                resolution_m: half_c / narrowest_hz,
                lobes_m: half_c * header.pulse_s,
            },
            ranges_m: [near_m, far_m.max(near_m)],
            path: path.to_owned(),
            recording,
            channel,
            compressor,
            pulses,
            headings_rad,
            scans,
        })
    }

    /// The recording, without samples.
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    /// Name of the channel.
    pub fn channel(&self) -> &str {
        &self.recording.header.channels[self.channel].name
    }

    /// Turns or sweeps, in their order; places are those of [`Self::number`].
    pub fn scans(&self) -> &[Scan] {
        &self.scans
    }

    /// The last scan that goes all the way; of none, the longest.
    pub fn last_whole(&self) -> usize {
        let longest = || (0..self.scans.len()).max_by_key(|scan| self.scans[*scan].pulses.len());
        self.scans.iter().rposition(|scan| scan.is_whole).or_else(longest).unwrap_or(0)
    }

    /// Number of a pulse.
    pub fn number(&self, place: usize) -> u64 {
        self.recording.index[self.pulses[place]]
    }

    /// Mean time from scan to scan, s; of one, how long it is.
    pub fn period_s(&self) -> f64 {
        let at = |place: usize| self.recording.emission_s[self.pulses[place]];
        match &self.scans[..] {
            [first, .., last] => {
                (at(last.pulses.start) - at(first.pulses.start)) / (self.scans.len() - 1) as f64
            }
            [one] => at(one.pulses.end - 1) - at(one.pulses.start),
            [] => 0.0,
        }
    }

    /// Mean angle from pulse to pulse of a scan, rad.
    pub fn step_rad(&self, scan: usize) -> Option<f64> {
        let places = self.scans.get(scan)?.pulses.clone();
        let bearings = self.bearings_rad.get(places)?;
        let turned: f64 = bearings.windows(2).map(|pair| scans::wrapped(pair[1] - pair[0])).sum();
        (bearings.len() > 1).then(|| turned.abs() / (bearings.len() - 1) as f64)
    }

    /// How far the echo of a point reaches.
    pub fn extent(&self) -> Extent {
        self.extent
    }

    /// Range of the first sample, m.
    pub fn near_m(&self) -> f64 {
        self.ranges_m[0]
    }

    /// Range of the last sample, m.
    pub fn far_m(&self) -> f64 {
        self.ranges_m[1]
    }

    /// The powers of a scan, out to a range, m, or to the last sample; `done` is called with the pulses that
    /// were compressed, and those of the scan.
    ///
    /// # Errors
    /// A scan that there is not, a range before the first sample, what cannot be read.
    pub fn polar(
        &self,
        scan: usize,
        radius_m: Option<f64>,
        done: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Polar, PpiError> {
        let last = self.scans.len().saturating_sub(1);
        let Scan { pulses: places, .. } = self.scans.get(scan).ok_or(PpiError::Scan { asked: scan, last })?;
        let [near_m, far_m] = self.ranges_m;
        let far_m = match radius_m {
            Some(asked_m) if !(asked_m > near_m && asked_m.is_finite()) => {
                return Err(PpiError::Range { asked_m, near_m });
            }
            Some(asked_m) => asked_m.min(far_m),
            None => far_m,
        };
        let step_m = 0.5 * SPEED_OF_LIGHT_MPS / self.compressor.cell_rate_hz();
        let mut polar = Polar::new([near_m, far_m], step_m);
        let samples = self.compressor.samples();
        let block = (BLOCK_BYTES / (8 * samples)).max(1);
        for first in places.clone().step_by(block) {
            let end = (first + block).min(places.end);
            let numbers = self.number(first)..self.number(end - 1) + 1;
            let read = Recording::open_channels(&self.path, Some(numbers), None, |_| {
                Ok::<_, RecordingError>(vec![self.channel])
            })?;
            let compressed: Vec<_> = (first..end)
                .into_par_iter()
                .filter_map(|place| {
                    let row = read.index.binary_search(&self.number(place)).ok()?;
                    let samples = read.window(row, self.channel);
                    let window = self.compressor.compress(samples, self.number(place), 0.0);
                    Some((place, read.window_start_of(row, self.channel), window))
                })
                .collect();
            for (place, start_s, window) in compressed {
                let powers = window.iter().map(|z| z.norm_sqr());
                let first_m = 0.5 * SPEED_OF_LIGHT_MPS * start_s;
                polar.add(self.bearings_rad[place], first_m, step_m, powers);
            }
            done(end - places.start, places.len());
        }
        Ok(polar)
    }

    /// Where a target truly is on the plan when the beam passes it: range by its recorded delay, bearing by
    /// its position so many s after pulse 0, ENU, m. None without recorded truth, beyond the windows, or
    /// where the beam does not come by within half its width.
    pub fn target(
        &self,
        scan: usize,
        target: usize,
        position_m: &dyn Fn(f64) -> [f64; 3],
    ) -> Option<[f64; 2]> {
        let row = self.recording.header.channels.get(self.channel)?;
        let delays_s = self.recording.delays_s(&row.transmitter, &row.receiver, target)?;
        let path = self.recording.true_path(&row.receiver).ok()?;
        let seen = |place: usize| {
            let pulse = self.pulses[place];
            let from = path.at(self.recording.emission_s[pulse]);
            let to = position_m(self.recording.since_start_s(pulse));
            let bearing_rad = (to[0] - from[0]).atan2(to[1] - from[1]) - self.headings_rad[place];
            let away = scans::wrapped(self.bearings_rad[place] - bearing_rad).abs();
            (away, [0.5 * SPEED_OF_LIGHT_MPS * delays_s[pulse], bearing_rad])
        };
        let all = self.scans.get(scan)?.pulses.clone().map(seen);
        let (away, place) = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let in_window = (self.ranges_m[0]..=self.ranges_m[1]).contains(&place[0]);
        (away <= 0.5 * self.extent.beam_rad && in_window).then_some(place)
    }
}

/// Heading that a platform reports at a pulse, clockwise from North, rad.
fn heading_rad(recording: &Recording, platform: &str, pulse: usize) -> Result<f64, RecordingError> {
    let [w, x, y, z] = recording.reported_attitude(platform, pulse)?;
    Ok(Rotation::from_raw(DQuat::from_xyzw(x, y, z, w)).to_yaw_pitch_roll()[0])
}
