//! What a CRSD file needs to know of a whole run: its radar, its transmit sequences, its channels.
//!
//! A **sequence** is what one transmitter radiates in one polarisation: with alternating polarisations every
//! so many pulses, with simultaneous ones every pulse, in as many sequences as there are polarisations. A
//! CRSD channel is a channel of echoes, with a vector for each pulse of its sequence.

use super::covariance;
use super::fault::CrsdError;
use super::pattern::GainArray;
use crate::frames::SceneFrame;
use crate::motion::PlatformNav;
use crate::pulse::SampleFormat;
use crate::radar::antenna::Antenna;
use crate::radar::rain::Attenuation;
use crate::radar::receiver::thermal_noise_w;
use crate::recording::header::Header;
use crate::scene::clock::Clocks;
use crate::scene::radar::{AntennaMount, Pattern, Pointing, Polarisation, Sweep, TxPolarisation, Waveform};
use crate::scene::sea::PatchPlace;
use crate::scene::{Radar, Scene};
use crate::units::Decibels;

/// Part of the sample rate within which the receive filter is flat.
pub(super) const FLAT: f64 = 0.8;
/// Noise bandwidth of the receive filter, parts of the sample rate.
pub(super) const NOISE: f64 = 0.875;

/// What is described: a recording or a run.
#[derive(Clone, Copy, Debug)]
pub struct Described<'a> {
    /// What is recorded.
    pub header: &'a Header,
    /// What there is.
    pub scene: &'a Scene,
    /// Where platforms go, and what is wrong with their reports.
    pub nav: &'a [PlatformNav],
    /// What is wrong with clocks.
    pub clocks: &'a Clocks,
}

/// One antenna of the file.
#[derive(Clone, Debug)]
pub(super) struct End {
    /// Its name.
    pub name: String,
    /// Its platform: name and place in the header.
    pub platform: String,
    pub carrier: usize,
    /// Its place among the antennas of a pulse.
    pub place: usize,
    /// Whether it radiates alike in all directions, H and V level.
    pub is_isotropic: bool,
    /// Power gain along the boresight.
    pub gain: f64,
    /// Gains about it.
    pub array: GainArray,
    /// Covariance of reported position and velocity, Earth-centred.
    pub covariance: covariance::Matrix6,
    /// Mean squares of its clock: reading (s^2) and rate.
    pub clock: [f64; 2],
}

/// What one transmitter radiates in one polarisation.
#[derive(Clone, Debug)]
pub(super) struct Sequence {
    /// Its identifier.
    pub id: String,
    /// Its antenna, by its place in [`Description::ends`].
    pub end: usize,
    pub polarisation: Polarisation,
    /// Radiant intensity along the boresight, dBW/sr.
    pub intensity_dbw: f64,
}

/// One channel.
#[derive(Clone, Debug)]
pub(super) struct Channel {
    /// Its identifier.
    pub id: String,
    /// Its place in a pulse.
    pub place: usize,
    /// Its sequence, by its place.
    pub sequence: usize,
    /// Its antenna, by its place in [`Description::ends`].
    pub end: usize,
    pub polarisation: Polarisation,
    /// Irradiance along the boresight for a sample of 1 sqrt(W), dBW/m^2.
    pub irradiance_dbw: f64,
}

/// How samples are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Signal {
    /// Two f32.
    Cf8,
    /// `2 code + 1`, two i16.
    Ci4,
    /// `2 code + 1`, two i8.
    Ci2,
}

impl Signal {
    pub fn name(self) -> &'static str {
        match self {
            Self::Cf8 => "CF8",
            Self::Ci4 => "CI4",
            Self::Ci2 => "CI2",
        }
    }

    pub fn bytes(self) -> usize {
        match self {
            Self::Cf8 => 8,
            Self::Ci4 => 4,
            Self::Ci2 => 2,
        }
    }
}

/// What a CRSD file needs to know of a whole run.
#[derive(Clone, Debug)]
pub struct Description {
    pub(super) header: Header,
    pub(super) frame: SceneFrame,
    pub(super) ends: Vec<End>,
    pub(super) sequences: Vec<Sequence>,
    pub(super) channels: Vec<Channel>,
    pub(super) signal: Signal,
    /// What a sample is multiplied by, sqrt(W).
    pub(super) scale: f64,
    /// Rate of the sweep, Hz/s.
    pub(super) sweep_hz_s: f64,
    /// Noise power of a sample, W.
    pub(super) noise_w: f64,
    pub(super) mode: &'static str,
    /// One-way losses in the air, dB/km: of every polarisation, and of rain in addition.
    pub(super) air_db_per_km: f64,
    pub(super) rain: Attenuation,
    /// Middle (East, North) and sides of the patch; no middle where it follows something.
    pub(super) patch: Option<(Option<[f64; 2]>, [f64; 2])>,
    /// Targets, East and North, m.
    pub(super) targets_m: Vec<[f64; 2]>,
}

impl Description {
    /// Of the channels of echoes with these names, or all.
    ///
    /// # Errors
    /// What CRSD cannot express, or a scenario that does not describe the recording.
    pub fn new(of: Described, names: &[String]) -> Result<Self, CrsdError> {
        let Described { header, scene, .. } = of;
        if !header.truth {
            return Err(CrsdError::Received);
        }
        if header.is_continuous() {
            return Err(CrsdError::Continuous);
        }
        if header.is_dechirped() {
            return Err(CrsdError::Dechirped);
        }
        let radar = &scene.radar;
        let frame = scene.frame;
        if frame.origin().is_none() {
            return Err(CrsdError::NoOrigin);
        }
        let Waveform::Lfm { bandwidth_hz, duration_s, sweep } = radar.waveform else {
            let droops = matches!(radar.waveform, Waveform::Drooping { .. });
            return Err(CrsdError::Waveform { kind: radar.waveform.kind(), droops });
        };
        let is_whole = header.replica.iter().all(|z| z.re.is_finite() && z.im.is_finite());
        if header.replica.is_empty() || !is_whole {
            return Err(CrsdError::Replica);
        }
        let mut description = Self {
            header: header.clone(),
            frame,
            ends: Vec::new(),
            sequences: Vec::new(),
            channels: Vec::new(),
            signal: match (header.layout.format, header.adc) {
                (SampleFormat::Ci16, Some(adc)) if adc.bits <= 7 => Signal::Ci2,
                (SampleFormat::Ci16, Some(adc)) if adc.bits <= 15 => Signal::Ci4,
                _ => Signal::Cf8,
            },
            scale: header.adc.map_or(1.0, |adc| if adc.bits <= 15 { 0.5 * adc.step } else { adc.step }),
            sweep_hz_s: bandwidth_hz / duration_s * if sweep == Sweep::Up { 1.0 } else { -1.0 },
            noise_w: radar
                .noise_figure_db
                .map_or(0.0, |figure| thermal_noise_w(NOISE * radar.sample_rate_hz, Decibels(figure))),
            mode: "STRIPMAP",
            air_db_per_km: radar.atmosphere_db_per_km,
            rain: Attenuation::new(radar.carrier_hz, radar.rain_mmph),
            patch: scene.sea.as_ref().map(|sea| {
                let patch = &sea.patch;
                let side = patch.size_m();
                let middle =
                    |axis: usize| (patch.first[axis] as f64 - 0.5) * patch.facet_m + 0.5 * side[axis];
                ((sea.place == PatchPlace::Fixed).then(|| [middle(0), middle(1)]), side)
            }),
            targets_m: Vec::new(),
        };
        description.targets_m =
            scene.targets.iter().map(|target| target.position.to_array()).map(|[x, y, _]| [x, y]).collect();
        let echoes: Vec<usize> =
            (0..header.channels.len()).filter(|place| header.channels[*place].is_of_echoes()).collect();
        if echoes.is_empty() {
            return Err(CrsdError::NoEchoes);
        }
        if let Some(name) =
            names.iter().find(|name| echoes.iter().all(|e| header.channels[*e].name != **name))
        {
            let allowed: Vec<&str> = echoes.iter().map(|e| header.channels[*e].name.as_str()).collect();
            return Err(CrsdError::Channel { name: name.clone(), allowed: allowed.join(", ") });
        }
        for place in echoes {
            if names.is_empty() || names.contains(&header.channels[place].name) {
                description.add(of, place)?;
            }
        }
        description.one_platform("transmitt", description.sequences.iter().map(|s| s.end).collect())?;
        description.one_platform("receiv", description.channels.iter().map(|c| c.end).collect())?;
        description.one_window(radar)?;
        let receiver = &description.ends[description.channels[0].end];
        description.mode = match radar.antenna(&receiver.name).map(|mount| &mount.pointing) {
            Some(Pointing::At { aim: crate::scene::radar::Aim::Point { velocity, .. }, .. }) => {
                if velocity.norm() == 0.0 { "SPOTLIGHT" } else { "DYNAMIC STRIPMAP" }
            }
            _ => "STRIPMAP",
        };
        Ok(description)
    }

    fn one_platform(&self, end: &'static str, ends: Vec<usize>) -> Result<(), CrsdError> {
        let mut names: Vec<&str> = ends.iter().map(|end| self.ends[*end].platform.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        if names.len() > 1 { Err(CrsdError::Platforms { end, platforms: names.join(", ") }) } else { Ok(()) }
    }

    /// All channels are recorded in the same window: receivers of one platform are, unless they have
    /// windows of their own.
    fn one_window(&self, radar: &Radar) -> Result<(), CrsdError> {
        let leads = radar.window_leads();
        let window = |channel: &Channel| {
            let name = &self.header.channels[channel.place].receiver;
            let receiver = radar.receivers.iter().position(|end| end.name == *name)?;
            leads.get(Radar::window_of(receiver, leads.len()))
        };
        let first = &self.channels[0];
        match self.channels.iter().find(|channel| window(channel) != window(first)) {
            Some(other) => Err(CrsdError::Windows { channels: [first.id.clone(), other.id.clone()] }),
            None => Ok(()),
        }
    }

    /// The receiver whose windows are written, by its place in the header.
    pub(super) fn receiver(&self) -> usize {
        self.header.receiver_of(self.channels[0].place).unwrap_or(0)
    }

    /// Takes in a channel, with its sequence and its antennas.
    fn add(&mut self, of: Described, place: usize) -> Result<(), CrsdError> {
        let row = &of.header.channels[place];
        let mut letters = row.polarisations.chars().filter_map(Polarisation::from_letter);
        let (Some(rx), Some(tx)) = (letters.next(), letters.next()) else { return Ok(()) };
        let radar = &of.scene.radar;
        let missing = |what, name: &str| CrsdError::Undescribed { what, name: name.to_owned() };
        let power_w = radar.transmitters.iter().find(|t| t.name == row.transmitter).map(|t| t.power_w);
        let power_w = power_w.ok_or_else(|| missing("transmitter", &row.transmitter))?;
        let (transmitter, receiver) = (self.end(of, &row.transmitter)?, self.end(of, &row.receiver)?);
        let decibels = |ratio: f64| 10.0 * ratio.log10();
        let sphere = 4.0 * std::f64::consts::PI;
        let id = format!("{}-{}", row.transmitter, tx.letter());
        let sequence = self.sequences.iter().position(|known| known.id == id).unwrap_or_else(|| {
            let intensity_dbw = decibels(power_w * self.ends[transmitter].gain / sphere);
            self.sequences.push(Sequence { id, end: transmitter, polarisation: tx, intensity_dbw });
            self.sequences.len() - 1
        });
        let area_m2 = radar.wavelength_m().powi(2) * self.ends[receiver].gain / sphere;
        let irradiance_dbw = radar.losses_db - decibels(area_m2);
        let id = row.name.clone();
        self.channels.push(Channel { id, place, sequence, end: receiver, polarisation: rx, irradiance_dbw });
        Ok(())
    }

    /// The place of an antenna; taken in where it is new.
    fn end(&mut self, of: Described, name: &str) -> Result<usize, CrsdError> {
        if let Some(place) = self.ends.iter().position(|end| end.name == name) {
            return Ok(place);
        }
        let missing = || CrsdError::Undescribed { what: "antenna", name: name.to_owned() };
        let mount: &AntennaMount = of.scene.radar.antenna(name).ok_or_else(missing)?;
        let platform = of.scene.platforms.get(mount.platform).ok_or_else(missing)?.clone();
        let carrier = of.header.platforms.iter().position(|known| *known == platform).ok_or_else(missing)?;
        let place = of.header.antennas().position(|known| known == name).ok_or_else(missing)?;
        let antenna = Antenna::open(&mount.pattern, of.scene.radar.wavelength_m())?;
        let array = GainArray::of(&antenna, &mount.pattern, of.scene.radar.wavelength_m());
        let at_s = |pulse: u64| pulse as f64 / of.header.prf_hz;
        let first = of.header.first_pulse;
        let time_s = at_s(first)..at_s(first.saturating_add(of.header.pulses));
        let errors = of.nav.get(mount.platform).and_then(|nav| nav.errors.as_ref());
        self.ends.push(End {
            name: name.to_owned(),
            platform,
            carrier,
            place,
            is_isotropic: matches!(mount.pattern, Pattern::Isotropic { .. }),
            gain: array.peak,
            array,
            covariance: covariance::of_report(errors, &of.scene.frame, &time_s),
            clock: covariance::of_clock(of.clocks, &of.scene.radar, name, &time_s),
        });
        Ok(self.ends.len() - 1)
    }

    /// Whether one platform carries both ends.
    pub(super) fn is_monostatic(&self) -> bool {
        let (sequence, channel) = (&self.sequences[0], &self.channels[0]);
        self.ends[sequence.end].carrier == self.ends[channel.end].carrier
    }

    /// Pulses of each sequence among those of a run.
    pub fn planned(&self, of: &TxPolarisation, first: u64, count: u64) -> Vec<u64> {
        let in_all = |sequence: &Sequence| match of {
            TxPolarisation::Simultaneous => count,
            TxPolarisation::Alternating(turns) => {
                let length = turns.len() as u64;
                let upto = |end: u64| {
                    let whole = turns.iter().filter(|p| **p == sequence.polarisation).count() as u64;
                    let rest = &turns[..(end % length) as usize];
                    end / length * whole + rest.iter().filter(|p| **p == sequence.polarisation).count() as u64
                };
                upto(first + count) - upto(first)
            }
        };
        self.sequences.iter().map(in_all).collect()
    }

    /// Whether every channel has pulses enough for a file.
    ///
    /// # Errors
    /// The first that has fewer than two.
    pub fn check_planned(&self, planned: &[u64]) -> Result<(), CrsdError> {
        let of = |channel: &Channel| planned.get(channel.sequence).copied().unwrap_or(0);
        match self.channels.iter().find(|channel| of(channel) < 2) {
            Some(short) => Err(CrsdError::FewPulses { channel: short.id.clone(), pulses: of(short) }),
            None => Ok(()),
        }
    }

    /// Whether a pulse with this code belongs to a sequence.
    pub(super) fn is_in(&self, tx_pol: u8, sequence: usize) -> bool {
        tx_pol == 0 || self.sequences[sequence].polarisation.code() == tx_pol
    }
}

impl Description {
    /// A point that an antenna without a boresight is taken to look at: the middle of a patch that stays, of
    /// the targets, or the origin.
    pub(super) fn nominal_point_m(&self) -> glam::DVec3 {
        let middle = match (&self.patch, self.targets_m.len()) {
            (Some((Some(middle), _)), _) => *middle,
            (_, 0) => [0.0; 2],
            (_, count) => [0, 1].map(|i| self.targets_m.iter().map(|t| t[i]).sum::<f64>() / count as f64),
        };
        self.frame.above_sea(middle[0], middle[1], 0.0).raw()
    }
}

impl Description {
    /// Names of the channels.
    pub fn channels(&self) -> impl Iterator<Item = &str> {
        self.channels.iter().map(|channel| channel.id.as_str())
    }
}
