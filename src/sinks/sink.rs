//! What every sink is, and what it is reported before the first pulse.

use super::vita49::WireReport;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use num_complex::Complex32;
use serde::Serialize;

use super::port::PortCounts;
use super::shard::Shard;
use crate::files::{self, Draft, FileFault, Holding};
use crate::pulse::log::Log;
use crate::pulse::{Layout, Pulse, SampleFormat};
use crate::scene::radar::Polarisation;
use crate::time::TimeTag;
use crate::transport::fanout::{Fed, Feed};

pub use super::fault::SinkError;

/// Version of the recordings' structure (HDF5 and plain), attribute `version`.
pub const FORMAT_VERSION: u32 = 1;

/// What a reader may count on after a kill: everything older than this was handed to the system.
/// Recordings flush when a pulse finds the last flush older than this, or when none came for as long.
pub const FLUSH_INTERVAL: Duration = Duration::from_millis(500);

/// Latest second of an instant: some 35,000 years.
const MOST_SECONDS: u64 = 1 << 40;
/// Most samples of a channel, and of a pulse.
const MOST_SAMPLES: usize = 1 << 24;
const MOST_IN_ALL: usize = 1 << 32;

/// A place where pulses go. A sink runs in a thread of its own and may wait; see [`drain`].
pub trait Sink: Send {
    /// Short name for counters and messages (`hdf5`).
    fn name(&self) -> &'static str;
    /// One line for people: what goes where.
    fn describe(&self) -> String;
    /// Takes a pulse.
    fn write(&mut self, pulse: &Pulse) -> Result<(), SinkError>;
    /// Makes everything taken so far visible to readers.
    fn flush(&mut self) -> Result<(), SinkError>;
    /// Completes and closes the output. It is not yet put in the place of an older one: see [`Closed`].
    fn close(&mut self) -> Result<Closed, SinkError>;
    /// After a failure: gives up what cannot be completed, and counts the pulses that a reader of the output
    /// finds. `None` of a sink that keeps nothing.
    fn readable(&mut self) -> Option<u64> {
        None
    }
    /// Removes what this sink has made: a run that could not begin leaves nothing.
    fn abandon(&mut self) {}
    /// Completes and closes the output of a whole run and puts it in its place.
    fn finish(mut self: Box<Self>) -> Result<SinkReport, SinkError> {
        self.close()?.place(true).map_err(|unplaced| unplaced.error)
    }
}

/// An output that is complete and closed.
///
/// A recording that is to replace an older one still has the name of its process, so that a run that fails in
/// another of its sinks leaves the older one as it was.
#[derive(Debug, Default)]
pub struct Closed {
    /// What the sink did; the files as they will be named.
    pub report: SinkReport,
    pub(super) drafts: Vec<Draft>,
    /// Whether older recordings are replaced.
    pub(super) force: bool,
    /// Older parts beyond those of this run: segments, recordings of further runs.
    pub(super) surplus: Vec<PathBuf>,
    pub(super) recognise: Option<fn(&Path) -> Option<Holding>>,
}

impl Closed {
    /// Of an output that has no place to be put in.
    pub fn of(report: SinkReport) -> Self {
        Self { report, ..Self::default() }
    }

    /// Puts everything in its place, hands it to the disk, and removes what it replaces. What holds nothing
    /// replaces nothing, and older segments beyond those of this run go only when it was `whole`: it was
    /// asked for all pulses and has come to its end.
    ///
    /// # Errors
    /// The first fault, after all has been tried; the report says where everything is.
    pub fn place(self, whole: bool) -> Result<SinkReport, Box<Unplaced>> {
        let Self { mut report, drafts, force, surplus, recognise } = self;
        let recognise = |path: &Path| recognise.and_then(|recognise| recognise(path));
        let mut names =
            if drafts.is_empty() { Vec::new() } else { std::mem::take(&mut report.files) }.into_iter();
        let mut error = None;
        for draft in drafts {
            let name = names.next().unwrap_or_else(|| draft.target().to_owned());
            if report.bytes == 0 && !draft.is_in_place() && draft.target().exists() {
                draft.abandon();
                report.kept.push(name);
                report.kept_because = Some(Keeping::Empty);
                continue;
            }
            let target = draft.target().to_owned();
            match draft.finish(force, &recognise) {
                Ok(Some(at)) => report.files.push(if at == target { name } else { at }),
                Ok(None) => report.gone.push(name),
                Err(fault) => {
                    report.files.extend(match &fault {
                        FileFault::Kept { at, .. } => Some(at.clone()),
                        FileFault::Moved { now, .. } => now.clone(),
                        FileFault::Removed { .. } => None,
                        _ => Some(name),
                    });
                    error.get_or_insert(fault);
                }
            }
        }
        let why = match error {
            _ if report.bytes == 0 => Some(Keeping::Empty),
            Some(_) => Some(Keeping::Unplaced),
            None => (!whole).then_some(Keeping::Part),
        };
        for path in surplus {
            // Somebody has put a link there: what it points to is not beside the output.
            let is_link = std::fs::symlink_metadata(&path).is_ok_and(|data| data.is_symlink());
            if let Some(why) = why.or(is_link.then_some(Keeping::Link)) {
                report.kept.push(path);
                report.kept_because = Some(why);
                continue;
            }
            match files::remove_recognised(&path, &recognise) {
                Ok(()) => report.removed.push(path),
                Err(fault) => error = error.or(Some(fault)),
            }
        }
        match error {
            None => Ok(report),
            Some(fault) => Err(Box::new(Unplaced { report, error: fault.into() })),
        }
    }

    /// Lets others move on what is complete, and holds no file of it open.
    pub(crate) fn hand_on(&mut self) {
        self.drafts.iter_mut().for_each(Draft::hand_on);
    }

    /// Leaves everything where it is, and says where that is: what a failed run has recorded is not lost, nor
    /// does it replace anything.
    pub fn keep(mut self) -> SinkReport {
        if self.drafts.is_empty() {
            return self.report;
        }
        let mut names = std::mem::take(&mut self.report.files).into_iter();
        for draft in &self.drafts {
            let name = names.next().unwrap_or_else(|| draft.target().to_owned());
            match draft.present() {
                Ok(_) if draft.is_gone() => self.report.gone.push(name),
                Ok(at) | Err(FileFault::Moved { now: Some(at), .. }) => self.report.files.push(at),
                Err(_) => self.report.gone.push(name),
            }
        }
        self.report
    }
}

/// Why older outputs stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keeping {
    /// Nothing was written.
    Empty,
    /// The run was stopped, or was a part of its pulses.
    Part,
    /// A new output could not be put in its place.
    Unplaced,
    /// They are links.
    Link,
}

impl Keeping {
    /// For people.
    fn words(self) -> &'static str {
        match self {
            Self::Empty => "not overwritten, because this run has written nothing",
            Self::Part => "older, not removed, because the run was stopped or was a part of its pulses",
            Self::Unplaced => "older, not removed, because not all new outputs could be put in place",
            Self::Link => "older, not removed, because it is a link",
        }
    }
}

/// An output that could not be put in its place, or not all of it.
#[derive(Debug)]
pub struct Unplaced {
    /// What the sink did; the files where they are.
    pub report: SinkReport,
    /// Why.
    pub error: SinkError,
}

/// What a sink did.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SinkReport {
    /// The sink's name.
    pub name: String,
    /// Pulses taken.
    pub pulses: u64,
    /// Bytes of per-pulse data written.
    pub bytes: u64,
    /// What was written, in order.
    pub files: Vec<PathBuf>,
    /// Older outputs that stay although they were to be replaced.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub kept: Vec<PathBuf>,
    /// Why they stay.
    #[serde(skip)]
    pub kept_because: Option<Keeping>,
    /// Older parts that were removed, because this run has none in their places.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub removed: Vec<PathBuf>,
    /// Outputs that another program has moved on or removed after they were complete.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gone: Vec<PathBuf>,
    /// Of a sink that sends: what became of its datagrams.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wire: Option<WireReport>,
    /// What became of the messages, where the output is a port.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub port: Option<PortCounts>,
}

impl SinkReport {
    /// What the user should know of older outputs, and of files that are no longer there.
    pub fn notes(&self) -> Vec<String> {
        let kept = self.kept_because.map_or("older, not removed", Keeping::words);
        let of = |files: &[PathBuf], what: &str| match files {
            [] => None,
            [file] => Some(format!("{}: {what}", file.display())),
            [first, more @ ..] => Some(format!("{} and {} more: {what}", first.display(), more.len())),
        };
        let gone = "moved or removed by another program after it was complete";
        let removed = "older, removed, because this run has no such part";
        let all = [of(&self.kept, kept), of(&self.removed, removed), of(&self.gone, gone)];
        all.into_iter().flatten().collect()
    }
}

/// A row of the channel table.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
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
    pub transmit_basis: String,
    /// That of the receiver.
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
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
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

/// Everything that a sink is reported before the first pulse.
#[derive(Clone, Debug, PartialEq)]
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
    /// Antennas whose clocks are wrong, in the order of the truth record.
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

impl Header {
    /// Whether a recording can hold this: sizes agree with names, names can be names of groups.
    pub fn check(&self) -> Result<(), SinkError> {
        let refuse = |field, found: String, allowed| Err(SinkError::Header { field, found, allowed });
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
        let antennas = || self.transmitters.iter().chain(&self.receivers);
        for (field, names) in [
            ("platforms", self.platforms.iter().collect::<Vec<_>>()),
            ("transmitters and receivers", antennas().collect()),
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
    fn check_values(&self) -> Result<(), SinkError> {
        let refuse = |field, found: String, allowed| Err(SinkError::Header { field, found, allowed });
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
            ("platforms", self.platforms == other.platforms),
            ("transmitters", self.transmitters == other.transmitters),
            ("receivers", self.receivers == other.receivers),
            ("truth/targets", self.targets == other.targets),
            ("truth/ships", self.ships == other.ships),
            ("truth/clocks", self.clocks == other.clocks),
            ("layout", self.layout == other.layout),
            ("adc", self.adc == other.adc),
            ("start time", self.start == other.start),
            ("truth", self.truth == other.truth),
            ("number of shards", self.shard.map(Shard::of) == other.shard.map(Shard::of)),
        ]
        .into_iter()
        .find_map(|(field, same)| (!same).then_some(field))
    }

    /// Names of the antennas in the order of the phase centres.
    pub fn antennas(&self) -> impl Iterator<Item = &str> {
        self.transmitters.iter().chain(&self.receivers).map(String::as_str)
    }
}

/// The body of a sink's thread: takes pulses until the stream ends, then closes.
///
/// When something fails, the pulses that the feed counts as written become those that a reader finds.
pub fn drain(mut sink: Box<dyn Sink>, mut feed: Feed) -> Result<Closed, SinkError> {
    let done = take_all(sink.as_mut(), &mut feed);
    if done.is_err()
        && let Some(pulses) = sink.readable()
    {
        feed.wrote_in_all(pulses);
    }
    done
}

fn take_all(sink: &mut dyn Sink, feed: &mut Feed) -> Result<Closed, SinkError> {
    loop {
        match feed.next(FLUSH_INTERVAL, |pulse| sink.write(pulse))? {
            Fed::Pulse(()) => {}
            Fed::Idle => sink.flush()?,
            Fed::Ended => return sink.close(),
        }
    }
}
