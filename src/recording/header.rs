//! What holds for a whole recording: the radar, its channels, the names of what moves, the run.

use std::collections::BTreeSet;
use std::sync::Arc;

use num_complex::Complex32;
use serde::{Deserialize, Serialize};

use super::fault::RecordingError;
use super::instrument::{AntennaRow, EmitterRow, GateRow, Instrument, Look, PulseRow};
use super::shard::Shard;
use crate::pulse::log::Log;
use crate::pulse::{Layout, Pulse, SampleFormat, Samples};
use crate::scene::radar::{Band, Polarisation};
use crate::time::TimeTag;
use crate::units::in_turn;

/// Versions of the recordings' structure (HDF5 and plain), attribute `version`: the first, and what is added
/// to it where receivers have windows of their own, and where pulses leave in turn, so that readers that
/// would misplace the former or take the replicas of the latter for one refuse them.
pub const FORMAT_VERSION: u32 = 1;
const OF_WINDOWS: u32 = 1;
const OF_TURNS: u32 = 2;
/// The last of these.
pub const LAST_VERSION: u32 = FORMAT_VERSION + OF_WINDOWS + OF_TURNS;

/// Latest second of an instant: some 35,000 years.
const MOST_SECONDS: u64 = 1 << 40;
/// Most samples of a channel, and of a pulse.
const MOST_SAMPLES: usize = 1 << 24;
const MOST_IN_ALL: usize = 1 << 32;

/// A row of the channel table.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChannelRow {
    /// Name, such as `HV`.
    pub name: String,
    /// Name of the transmitter.
    pub transmitter: String,
    /// Name of the receiver.
    pub receiver: String,
    /// Receive letter, then transmit letter; of a calibration channel `tone` or `loopback`.
    pub polarisations: String,
    /// Polarisation basis of the transmitter ([`crate::scene::radar::PolarisationBasis::name`]); empty where
    /// it is not known, as in older recordings, and of calibration channels.
    #[serde(default)]
    pub transmit_basis: String,
    /// That of the receiver.
    #[serde(default)]
    pub receive_basis: String,
}

impl ChannelRow {
    /// Whether it carries echoes, not a signal of calibration.
    pub fn is_of_echoes(&self) -> bool {
        self.polarisations.chars().count() == 2
            && self.polarisations.chars().all(|letter| Polarisation::from_letter(letter).is_some())
    }
}

/// A transmitter-receiver pair of the truth record.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PairRow {
    /// Name of the transmitter.
    pub transmitter: String,
    /// Name of the receiver.
    pub receiver: String,
}

/// The origin of the ENU frame on the ellipsoid (WGS-84).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Origin {
    /// Geodetic latitude, degrees.
    pub lat_deg: f64,
    /// Longitude, degrees.
    pub lon_deg: f64,
    /// Height above the ellipsoid, metres.
    pub h_m: f64,
}

/// The converter whose codes are recorded.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AdcRow {
    /// Bits per component.
    pub bits: u32,
    /// sqrt(W) per code: sample = (code + 1/2) step for a mid-rise converter.
    pub step: f64,
}

/// What is known before the first pulse: every sink and every recording begins with it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Header {
    /// Name and version of the program.
    pub software: String,
    /// Carrier, Hz.
    pub carrier_hz: f64,
    /// Complex sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Bandwidth of the waveform, Hz.
    pub bandwidth_hz: f64,
    /// Length of the waveform, seconds.
    pub pulse_s: f64,
    /// Mean pulse repetition frequency, Hz.
    pub prf_hz: f64,
    /// Channels, in the order of the samples.
    pub channels: Vec<ChannelRow>,
    /// Transmitter-receiver pairs, in the order of the truth record.
    pub pairs: Vec<PairRow>,
    /// Origin of the ENU frame; none for a plain local frame.
    pub origin: Option<Origin>,
    /// Seed of every random stream.
    pub seed: u64,
    /// The scenario as written (TOML).
    pub config: String,
    /// Transmitted pulse after the receive filter, at the sample rate.
    pub replica: Vec<Complex32>,
    /// What else a processor needs to know of the radar; none in recordings of earlier versions, and in what
    /// came from a sender that does not describe it.
    pub instrument: Option<Instrument>,
    /// Platforms, in the order of the navigation record.
    pub platforms: Vec<String>,
    /// Transmitters: the first phase centres.
    pub transmitters: Vec<String>,
    /// Receivers: the phase centres after those of the transmitters.
    pub receivers: Vec<String>,
    /// Targets, in the order of the truth record.
    pub targets: Vec<String>,
    /// Ships, in the order of the truth record.
    pub ships: Vec<String>,
    /// Antennas whose clocks have errors, in the order of the truth record.
    pub clocks: Vec<String>,
    /// Sizes of every pulse.
    pub layout: Layout,
    /// The converter, when samples are its codes.
    pub adc: Option<AdcRow>,
    /// Emission time of pulse 0.
    pub start: TimeTag,
    /// First pulse of this run (not 0 for a shard).
    pub first_pulse: u64,
    /// Pulses of this run.
    pub pulses: u64,
    /// Which shard of the run this is, where it is made in shards.
    pub shard: Option<Shard>,
    /// Whether the true motion is recorded; what was received over the wire has the reported one only.
    pub truth: bool,
    /// What is changed while the run goes on; `None` where nothing may be.
    pub changes: Option<Arc<Log>>,
}

/// A value of the header that files keep as it is.
pub(super) enum Field<'a> {
    Text(&'a mut String),
    Real(&'a mut f64),
    Whole(&'a mut u64),
    Names(&'a mut Vec<String>),
}

impl Header {
    /// The values that both kinds of recordings keep under these names.
    pub(super) fn fields(&mut self) -> [(&'static str, Field<'_>); 13] {
        use Field::{Names, Real, Text, Whole};
        [
            ("software", Text(&mut self.software)),
            ("carrier_hz", Real(&mut self.carrier_hz)),
            ("sample_rate_hz", Real(&mut self.sample_rate_hz)),
            ("bandwidth_hz", Real(&mut self.bandwidth_hz)),
            ("pulse_s", Real(&mut self.pulse_s)),
            ("prf_hz", Real(&mut self.prf_hz)),
            ("seed", Whole(&mut self.seed)),
            ("config", Text(&mut self.config)),
            ("first_pulse", Whole(&mut self.first_pulse)),
            ("pulses", Whole(&mut self.pulses)),
            ("platforms", Names(&mut self.platforms)),
            ("transmitters", Names(&mut self.transmitters)),
            ("receivers", Names(&mut self.receivers)),
        ]
    }

    /// Names of what the truth is recorded of.
    pub(super) fn truth_names(&mut self) -> [(&'static str, &mut Vec<String>); 3] {
        [("targets", &mut self.targets), ("ships", &mut self.ships), ("clocks", &mut self.clocks)]
    }

    /// The version of a recording of it.
    pub(crate) fn version(&self) -> u32 {
        let more = |of: u32, there: bool| if there { of } else { 0 };
        FORMAT_VERSION + more(OF_WINDOWS, self.layout.windows > 0) + more(OF_TURNS, self.turns() > 1)
    }

    /// Pulses that leave in turn, which [`Self::replica`] holds one after the other, each as long as the
    /// longest; 1 where all are alike.
    pub fn turns(&self) -> usize {
        self.in_turn().len().max(1)
    }

    /// What is said of the pulses that leave in turn; nothing where all are alike.
    pub fn in_turn(&self) -> &[PulseRow] {
        self.instrument.as_ref().map_or(&[], |instrument| &instrument.waveform.pulses)
    }

    /// The band of all pulses about the carrier.
    pub fn band(&self) -> Band {
        let bands = self.in_turn().iter().map(PulseRow::band);
        bands.reduce(Band::with).unwrap_or(Band::about(0.0, self.bandwidth_hz))
    }

    /// That of the pulse of a number; of a block, which receives several, that of all.
    pub fn band_of(&self, number: u64) -> Band {
        let own = in_turn(self.in_turn(), number).filter(|_| !self.is_continuous());
        own.map_or_else(|| self.band(), PulseRow::band)
    }

    /// The receiver of a channel, by its place.
    pub fn receiver_of(&self, channel: usize) -> Option<usize> {
        let row = self.channels.get(channel)?;
        self.receivers.iter().position(|receiver| *receiver == row.receiver)
    }

    /// Sizes of every pulse: as many of each as have names; with a window of its own for each receiver by
    /// the version of the recording.
    pub(super) fn count(&mut self, version: u32, samples: usize, format: SampleFormat) {
        let own_windows = version.wrapping_sub(FORMAT_VERSION) & OF_WINDOWS != 0;
        self.layout = Layout {
            channels: self.channels.len(),
            samples,
            format,
            platforms: self.platforms.len(),
            antennas: self.transmitters.len() + self.receivers.len(),
            targets: self.targets.len(),
            pairs: self.pairs.len(),
            windows: if own_windows { self.receivers.len() } else { 0 },
            ships: self.ships.len(),
            clocks: self.clocks.len(),
        };
    }

    /// Whether a recording can hold this: sizes agree with names, names can be names of groups.
    ///
    /// # Errors
    /// The first part that cannot be recorded.
    pub fn check(&self) -> Result<(), RecordingError> {
        let refuse = |field, found: String, allowed| Err(RecordingError::Header { field, found, allowed });
        let sizes = [
            ("channels", self.channels.len(), self.layout.channels),
            ("platforms", self.platforms.len(), self.layout.platforms),
            (
                "transmitters and receivers",
                self.transmitters.len() + self.receivers.len(),
                self.layout.antennas,
            ),
            ("targets", self.targets.len(), self.layout.targets),
            ("pairs", self.pairs.len(), self.layout.pairs),
            ("ships", self.ships.len(), self.layout.ships),
            ("clocks", self.clocks.len(), self.layout.clocks),
        ];
        for (field, names, slots) in sizes {
            if names != slots {
                return refuse(field, format!("{names} names for {slots} in the layout"), "a name for each");
            }
        }
        if self.layout.channels == 0 || self.layout.samples == 0 {
            let found = format!("{} channels of {} samples", self.layout.channels, self.layout.samples);
            return refuse("layout", found, "at least 1 channel of 1 sample");
        }
        if (self.layout.format == SampleFormat::Ci16) != self.adc.is_some() {
            return refuse("adc", format!("{:?}", self.adc), "one if samples are codes, none otherwise");
        }
        self.check_values()?;
        if let Some(found) = self.instrument_fault() {
            let allowed = "the antennas of the recording in their order, on its platforms; finite numbers";
            return refuse("instrument", found, allowed);
        }
        if let Some(found) = self.emitters().iter().find_map(|emitter| emitter.fault(&self.receivers)) {
            let allowed = "figures of a radar, an interval of 1e-10 to 1e4 s for each that is announced, \
                           receivers of the recording";
            return refuse("emitters", found, allowed);
        }
        let antennas = || self.transmitters.iter().chain(&self.receivers);
        let emitters = self.emitters().iter().map(|emitter| &emitter.antenna.name);
        for (field, names) in [
            ("platforms", self.platforms.iter().collect::<Vec<_>>()),
            ("transmitters and receivers", antennas().collect()),
            ("emitters", emitters.chain(antennas()).collect()),
        ] {
            let mut seen = BTreeSet::new();
            for name in names {
                let dots = name == "." || name == "..";
                if name.is_empty() || name.len() > 200 || dots || name.contains(['/', '\\', '\0']) {
                    return refuse(
                        field,
                        format!("'{}'", name.escape_debug()),
                        "1 to 200 bytes without / \\ NUL, not . or ..",
                    );
                }
                if !seen.insert(name) {
                    return refuse(field, format!("'{}' twice", name.escape_debug()), "each name once");
                }
            }
        }
        let texts = [&self.config, &self.software]
            .into_iter()
            .chain(&self.targets)
            .chain(&self.ships)
            .chain(&self.clocks);
        for text in texts.chain(
            self.channels
                .iter()
                .flat_map(|c| [&c.name, &c.polarisations, &c.transmit_basis, &c.receive_basis]),
        ) {
            if text.contains('\0') {
                return refuse("texts", format!("'{}'", text.escape_debug()), "texts without NUL");
            }
        }
        Ok(())
    }

    /// Whether the figures are those of a radar, and sizes can be counted with.
    fn check_values(&self) -> Result<(), RecordingError> {
        let refuse = |field, found: String, allowed| Err(RecordingError::Header { field, found, allowed });
        let hertz = "a number above 0, at most 1e12 Hz";
        let seconds = "a number from 0 to 1e6 s";
        for (field, value, least, most, allowed) in [
            ("carrier_hz", self.carrier_hz, f64::MIN_POSITIVE, 1e12, hertz),
            ("sample_rate_hz", self.sample_rate_hz, f64::MIN_POSITIVE, 1e12, hertz),
            ("bandwidth_hz", self.bandwidth_hz, 0.0, 1e12, "a number from 0 to 1e12 Hz"),
            ("pulse_s", self.pulse_s, 0.0, 1e6, seconds),
            ("prf_hz", self.prf_hz, 1e-6, 1e9, "a number from 1e-6 to 1e9 Hz"),
        ] {
            if !(least..=most).contains(&value) {
                return refuse(field, value.to_string(), allowed);
            }
        }
        if let Some(Origin { lat_deg, lon_deg, h_m }) = self.origin
            && !(lat_deg.abs() <= 90.0 && lon_deg.abs() <= 360.0 && h_m.abs() <= 1e9)
        {
            let allowed = "latitude -90 to 90, longitude -360 to 360 degrees, height within 1e9 m";
            return refuse("origin", format!("{lat_deg}, {lon_deg} degrees, {h_m} m"), allowed);
        }
        if let Some(AdcRow { bits, step }) = self.adc
            && !((1..=64).contains(&bits) && step > 0.0 && step.is_finite())
        {
            return refuse("adc", format!("{bits} bits, step {step}"), "1 to 64 bits, a finite step above 0");
        }
        if self.start.seconds().unsigned_abs() > MOST_SECONDS
            || !(0.0..1.0).contains(&self.start.fraction_s())
        {
            let found = format!("{} s and {} s", self.start.seconds(), self.start.fraction_s());
            return refuse("start time", found, "within 2^40 s of 1970, the fraction from 0 to 1 s");
        }
        let Layout { channels, samples, .. } = self.layout;
        if samples > MOST_SAMPLES || channels.checked_mul(samples).is_none_or(|all| all > MOST_IN_ALL) {
            let found = format!("{channels} channels of {samples} samples");
            return refuse("layout", found, "at most 2^24 samples a channel and 2^32 in all channels");
        }
        Ok(())
    }

    /// What of the instrument does not agree with the rest, or cannot be calculated with.
    fn instrument_fault(&self) -> Option<String> {
        let instrument = self.instrument.as_ref()?;
        let names = || instrument.antennas.iter().map(|antenna| antenna.name.as_str());
        if !names().eq(self.antennas()) {
            return Some(format!("antennas {:?}", names().collect::<Vec<_>>()));
        }
        let emitters = instrument.emitters.iter().map(|emitter| &emitter.antenna);
        let antennas = instrument.antennas.iter().chain(emitters);
        let lost = antennas.clone().find(|antenna| !self.platforms.contains(&antenna.platform));
        if let Some(AntennaRow { name, platform, .. }) = lost {
            return Some(format!("antenna '{}' on '{}'", name.escape_debug(), platform.escape_debug()));
        }
        for look in antennas.clone().flat_map(AntennaRow::looks).chain(&instrument.window) {
            let numbers = look.numbers();
            if !numbers.iter().all(|number| number.is_finite()) {
                return Some(format!("a place to look at of {numbers:?}"));
            }
            if let Look::Beside { platform, .. } = look
                && !self.platforms.contains(platform)
            {
                return Some(format!("a place to look at beside '{}'", platform.escape_debug()));
            }
        }
        if let Some(found) = instrument.waveform.fault() {
            return Some(found);
        }
        if !self.replica.len().is_multiple_of(self.turns()) {
            return Some(format!("{} pulses in turn in a replica of {}", self.turns(), self.replica.len()));
        }
        let starts_s = antennas.clone().filter_map(|antenna| match antenna.window.as_ref()? {
            GateRow::Fixed { start_s: s } | GateRow::Follow { lead_s: s, .. } => Some(*s),
        });
        if let Some(s) = starts_s.into_iter().find(|s| !s.is_finite()) {
            return Some(format!("a window after {s} s"));
        }
        let lengths = antennas.flat_map(|antenna| antenna.lever_arm_m).chain(instrument.middle_m);
        lengths.into_iter().find(|m| !m.is_finite()).map(|m| format!("a length of {m} m"))
    }

    /// Whether what is called a pulse is a block of samples that begins where the one before ends.
    pub fn is_continuous(&self) -> bool {
        self.instrument.as_ref().is_some_and(|instrument| instrument.continuous)
    }

    /// What follows each other in its samples.
    pub(super) fn received(&self) -> &'static str {
        if self.is_continuous() { "blocks without a gap" } else { "receive windows" }
    }

    /// Whether a pulse has the samples and the states announced here.
    ///
    /// # Errors
    /// The first that has another size.
    pub(crate) fn check_pulse(&self, pulse: &Pulse) -> Result<(), RecordingError> {
        let layout = &self.layout;
        let samples = match (&pulse.samples, layout.format) {
            (Samples::Cf32(all), SampleFormat::Cf32) => all.len(),
            (Samples::Ci16(all), SampleFormat::Ci16) => all.len(),
            _ => 0,
        };
        for (column, found, expected) in [
            ("iq", samples, layout.channels * layout.samples),
            ("nav", pulse.nav_reported.len(), layout.platforms),
        ] {
            if found != expected {
                let column = column.to_owned();
                return Err(RecordingError::Pulse { index: pulse.index, column, found, expected });
            }
        }
        Ok(())
    }

    /// The first part in which two headers of one run differ; range of pulses aside.
    pub fn difference(&self, other: &Self) -> Option<&'static str> {
        [
            ("config", self.config == other.config),
            ("seed", self.seed == other.seed),
            ("software", self.software == other.software),
            ("carrier_hz", self.carrier_hz == other.carrier_hz),
            ("sample_rate_hz", self.sample_rate_hz == other.sample_rate_hz),
            ("bandwidth_hz", self.bandwidth_hz == other.bandwidth_hz),
            ("pulse_s", self.pulse_s == other.pulse_s),
            ("prf_hz", self.prf_hz == other.prf_hz),
            ("channel", self.channels == other.channels),
            ("truth/pairs", self.pairs == other.pairs),
            ("origin", self.origin == other.origin),
            ("replica", self.replica == other.replica),
            ("instrument", self.instrument == other.instrument),
            ("platforms", self.platforms == other.platforms),
            ("transmitters", self.transmitters == other.transmitters),
            ("receivers", self.receivers == other.receivers),
            ("truth/targets", self.targets == other.targets),
            ("truth/ships", self.ships == other.ships),
            ("truth/clocks", self.clocks == other.clocks),
            ("layout", self.layout == other.layout),
            ("adc", self.adc == other.adc),
            ("start time", self.start == other.start),
            ("number of shards", self.shard.map(Shard::of) == other.shard.map(Shard::of)),
            ("truth", self.truth == other.truth),
        ]
        .into_iter()
        .find_map(|(field, same)| (!same).then_some(field))
    }

    /// Whether echoes are dechirped: a sample then belongs to a time within the sweep, and a beat frequency
    /// to a delay.
    pub fn is_dechirped(&self) -> bool {
        self.instrument.as_ref().is_some_and(|instrument| instrument.dechirp_s.is_some())
    }

    /// Error of each class of pulses, dB; empty where there is one class.
    pub fn error_classes_db(&self) -> &[f64] {
        self.instrument.as_ref().map_or(&[], |instrument| &instrument.error_classes_db)
    }

    /// What radiates besides the radar.
    pub fn emitters(&self) -> &[EmitterRow] {
        self.instrument.as_ref().map_or(&[], |instrument| &instrument.emitters)
    }

    /// Antennas that scan, by their places among all, rising.
    pub fn scanning(&self) -> impl Iterator<Item = usize> {
        let antennas = self.instrument.iter().flat_map(|instrument| &instrument.antennas).enumerate();
        antennas.filter(|(_, row)| matches!(row.look, Look::Scan { .. })).map(|(place, _)| place)
    }

    /// Whether an antenna scans, so that an encoder is read at each pulse.
    pub(crate) fn scans(&self, antenna: usize) -> bool {
        self.scanning().any(|place| place == antenna)
    }

    /// Names of the antennas in the order of the phase centres.
    pub fn antennas(&self) -> impl Iterator<Item = &str> {
        self.transmitters.iter().chain(&self.receivers).map(String::as_str)
    }
}
