//! Radar video: ASTERIX category 240, edition 1.3, over UDP.
//!
//! A **radial** (the cells of one pulse, or of a few together, and the azimuths between which they lie) is a
//! video message, or as many as `mtu_bytes` asks for: each then has a part of the ranges. Before the first
//! one, and once every second of emission time, a summary is sent. All items are in `docs/asterix.md`.
//!
//! **Range.** Cell `k` is at `k T c/2`, `T` its duration (items 040, 041): the item's formula with `k =
//! START_RG + NU_CELL - 1`. Cells of all messages are those of one grid.
//!
//! **Azimuth.** The edges of a radial, clockwise, in 1/65536 of a turn.
//!
//! **Loss** shows in the number of the message (item 020). Datagrams that the system refuses are counted
//! ([`WireReport`](super::vita49::WireReport)), and messages of pulses that never came leave their numbers
//! out.
//!
//! Sending waits as the sink of VITA 49.2 does, and no longer. [`Video`] makes radials of pulses: this module
//! knows no waveform.
//!
//! Source: EUROCONTROL-SPEC-0149-240, edition 1.3 (2015). Cells of 16 bits are sent with the most significant
//! octet first, as all numbers of ASTERIX.

mod codes;
mod message;
mod report;

use std::net::{IpAddr, Ipv4Addr, SocketAddr};

use super::link::{Link, Multicast, payload_bytes, resolve};
use super::sink::{Closed, Sink, SinkError, SinkReport};
use super::vita49::MTU_BYTES;
use crate::pulse::Pulse;
use crate::time::TimeTag;
use codes::Coder;
use message::{Cells, Writer};

pub use report::VideoReport;

/// Emission time between two summaries, s.
const SUMMARY_S: f64 = 1.0;

/// What is sent, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Receiver or group, host and port.
    pub address: String,
    /// Address of the interface by which datagrams for a group leave.
    pub interface: Ipv4Addr,
    /// Routers that datagrams for a group may pass, plus 1.
    pub ttl: u32,
    /// Greatest IP packet, bytes.
    pub mtu_bytes: usize,
    /// Data source identifier.
    pub source: Source,
    /// Channel of which the video is; `None`: the first of echoes whose receiver scans.
    pub channel: Option<String>,
    /// Length of a cell, m; `None`: that of a sample.
    pub cell_m: Option<f64>,
    /// What is in a cell.
    pub cell: CellValue,
    /// Pulses in a radial.
    pub radial_pulses: u64,
    /// Bits of a cell.
    pub bits: Bits,
    /// How a power becomes a code.
    pub detection: Detection,
    /// Level of the greatest code, dBW; `None`: by the noise of the receiver.
    pub full_dbw: Option<f64>,
}

/// The port of ASTERIX on this machine.
pub const ADDRESS: &str = "127.0.0.1:8600";

impl Default for Settings {
    /// A message for every pulse, a cell for every sample, 8 bits over 80 dB; to this machine.
    fn default() -> Self {
        Self {
            address: ADDRESS.to_owned(),
            interface: Ipv4Addr::LOCALHOST,
            ttl: 1,
            mtu_bytes: 1500,
            source: Source::default(),
            channel: None,
            cell_m: None,
            cell: CellValue::Peak,
            radial_pulses: 1,
            bits: Bits::Eight,
            detection: Detection::Logarithmic { dynamic_db: 80.0 },
            full_dbw: None,
        }
    }
}

/// Item 010.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Source {
    /// System area code.
    pub sac: u8,
    /// System identification code.
    pub sic: u8,
}

/// What is in a cell that holds several samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellValue {
    /// The greatest power.
    Peak,
    /// The mean power.
    Mean,
}

/// Bits of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bits {
    /// High resolution.
    Eight,
    /// Very high resolution.
    Sixteen,
}

impl Bits {
    /// Those that there are.
    pub const ALLOWED: [u64; 2] = [8, 16];

    /// Of so many bits.
    pub fn of(bits: u64) -> Option<Self> {
        match bits {
            8 => Some(Self::Eight),
            16 => Some(Self::Sixteen),
            _ => None,
        }
    }

    /// How many they are.
    pub fn count(self) -> u32 {
        8 * self.octets() as u32
    }

    fn octets(self) -> usize {
        match self {
            Self::Eight => 1,
            Self::Sixteen => 2,
        }
    }

    /// The word of item 048.
    fn resolution(self) -> u8 {
        match self {
            Self::Eight => 4,
            Self::Sixteen => 5,
        }
    }

    /// The greatest code.
    fn most(self) -> u16 {
        match self {
            Self::Eight => 255,
            Self::Sixteen => u16::MAX,
        }
    }
}

/// How a power becomes a code.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Detection {
    /// By its logarithm.
    Logarithmic {
        /// Level of the greatest code over that of code 0, dB.
        dynamic_db: f64,
    },
    /// By its root: the envelope.
    Linear,
}

/// Duration of a cell, there and back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellTime {
    /// ns, item 040.
    Nano(u32),
    /// fs, item 041.
    Femto(u32),
}

impl CellTime {
    /// The nearest to a time, s: in fs where these fit into the item.
    pub fn nearest(time_s: f64) -> Self {
        match (time_s * 1e15).round() {
            fs if fs <= f64::from(u32::MAX) => Self::Femto((fs as u32).max(1)),
            _ => Self::Nano((time_s * 1e9).round() as u32),
        }
    }

    /// As sent, s.
    pub fn seconds(self) -> f64 {
        match self {
            Self::Nano(ns) => f64::from(ns) * 1e-9,
            Self::Femto(fs) => f64::from(fs) * 1e-15,
        }
    }
}

/// The cells between two azimuths.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Radial {
    /// Emission of its first pulse.
    pub time: TimeTag,
    /// Azimuths of its edges, clockwise, degrees.
    pub azimuths_deg: [f64; 2],
    /// Range of its first cell, in cells.
    pub first: u32,
    /// Power of each cell, W.
    pub powers_w: Vec<f32>,
    /// Radials before it of which no pulse came.
    pub missed: u64,
}

/// Makes radials of pulses.
pub trait Video: Send {
    /// Name of the channel.
    fn channel(&self) -> &str;
    /// Duration of its cells.
    fn cell_time(&self) -> CellTime;
    /// Cells of a radial, at most.
    fn cells(&self) -> usize;
    /// Takes a pulse, and gives the radials that are complete.
    fn take(&mut self, pulse: &Pulse, done: &mut dyn FnMut(&Radial));
    /// Gives the radial that is begun.
    fn finish(&mut self, done: &mut dyn FnMut(&Radial));
}

/// What is wrong with the address of a group, or with one beside which an interface is named.
pub(super) fn preflight(settings: &Settings) -> Result<SocketAddr, SinkError> {
    let to = resolve(&settings.address)?;
    check_group(to.ip())
        .map_err(|allowed| SinkError::Group { address: settings.address.clone(), allowed })?;
    Ok(to)
}

/// Whether datagrams may go there.
///
/// # Errors
/// What is allowed instead.
pub fn check_group(address: IpAddr) -> Result<(), &'static str> {
    match address {
        IpAddr::V4(v4) if v4.is_multicast() && v4.octets()[..3] == [224, 0, 0] => {
            Err("a group from 224.0.1.0 to 239.255.255.255: those below are of routers")
        }
        IpAddr::V4(v4) if v4.octets()[0] >= 240 => {
            Err("the address of a machine, or a group from 224.0.1.0 to 239.255.255.255")
        }
        IpAddr::V6(v6) if v6.is_multicast() => Err("a group of IPv4, from 224.0.1.0 to 239.255.255.255"),
        _ => Ok(()),
    }
}

/// Sends video.
pub struct AsterixSink {
    link: Link,
    video: Box<dyn Video>,
    sender: Sender,
}

/// Everything of the sink but what makes radials.
struct Sender {
    writer: Writer,
    coder: Coder,
    codes: Vec<u16>,
    /// Cells of a message, at most, and messages of a radial.
    piece: usize,
    pieces: u32,
    /// Number of the next message.
    index: u32,
    text: String,
    due: Option<TimeTag>,
    pulses: u64,
    bytes: u64,
    report: VideoReport,
}

impl AsterixSink {
    /// Binds a socket and allocates everything; nothing is sent yet. `full_dbw` is the level of the greatest
    /// code.
    ///
    /// # Errors
    /// An address that cannot be reached, and a size of datagrams that cannot be sent.
    pub fn open(settings: &Settings, video: Box<dyn Video>, full_dbw: f64) -> Result<Self, SinkError> {
        let to = preflight(settings)?;
        let Settings { mtu_bytes, bits, detection, .. } = *settings;
        let [least, most] = MTU_BYTES.map(|bytes| bytes as usize);
        if !(least..=most).contains(&mtu_bytes) {
            return Err(SinkError::Mtu { mtu_bytes });
        }
        let multicast =
            to.ip().is_multicast().then_some(Multicast { interface: settings.interface, ttl: settings.ttl });
        let room = payload_bytes(mtu_bytes, &to);
        let piece = message::most_octets(room) / bits.octets();
        let text = summary(settings, video.channel(), full_dbw);
        Ok(Self {
            link: Link::open(to, None, multicast)?,
            sender: Sender {
                writer: Writer::new(settings.source, bits, video.cell_time(), room),
                coder: Coder::new(detection, bits, full_dbw),
                codes: Vec::with_capacity(video.cells()),
                piece,
                pieces: video.cells().div_ceil(piece) as u32,
                index: 0,
                text,
                due: None,
                pulses: 0,
                bytes: 0,
                report: VideoReport::default(),
            },
            video,
        })
    }
}

/// The text of the summary.
fn summary(settings: &Settings, channel: &str, full_dbw: f64) -> String {
    let bits = settings.bits.count();
    let levels = match settings.detection {
        Detection::Logarithmic { dynamic_db } => {
            format!("logarithmic; {:.1} to {full_dbw:.1} dBW", full_dbw - dynamic_db)
        }
        Detection::Linear => format!("linear; up to {full_dbw:.1} dBW"),
    };
    format!("nereus {}; channel {channel}; {bits} bits, {levels}", env!("CARGO_PKG_VERSION"))
}

impl Sender {
    fn send_summary(&mut self, link: &mut Link, time: TimeTag) {
        if self.due.is_some_and(|due| time.since(due) < 0.0) {
            return;
        }
        self.due = Some(time.plus(SUMMARY_S));
        let message = self.writer.summary(&self.text, time);
        self.bytes += message.len() as u64;
        link.send(message);
    }

    fn send(&mut self, link: &mut Link, radial: &Radial) {
        self.send_summary(link, radial.time);
        let Self { writer, coder, codes, piece, report, .. } = self;
        codes.clear();
        for power_w in &radial.powers_w {
            let (code, is_clipped) = coder.code(*power_w);
            codes.push(code);
            report.clipped += u64::from(is_clipped);
        }
        report.radials += 1;
        report.missed += radial.missed;
        report.cells += codes.len() as u64;
        self.index = self.index.wrapping_add((radial.missed as u32).wrapping_mul(self.pieces));
        for (place, codes) in codes.chunks((*piece).max(1)).enumerate() {
            let message = writer.video(&Cells {
                index: self.index,
                time: radial.time,
                azimuths_deg: radial.azimuths_deg,
                first: radial.first + (place * *piece) as u32,
                codes,
            });
            self.bytes += message.len() as u64;
            link.send(message);
            self.index = self.index.wrapping_add(1);
        }
    }
}

impl Sink for AsterixSink {
    fn name(&self) -> &'static str {
        "asterix"
    }

    fn describe(&self) -> String {
        format!("radar video over UDP to {}", self.link.address())
    }

    fn write(&mut self, pulse: &Pulse) -> Result<(), SinkError> {
        let Self { link, video, sender } = self;
        sender.pulses += 1;
        video.take(pulse, &mut |radial| sender.send(link, radial));
        Ok(())
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    fn close(&mut self) -> Result<Closed, SinkError> {
        let Self { link, video, sender } = self;
        video.finish(&mut |radial| sender.send(link, radial));
        Ok(Closed::of(SinkReport {
            name: "asterix".to_owned(),
            pulses: sender.pulses,
            bytes: sender.bytes,
            wire: Some(link.finish()),
            video: Some(sender.report.clone()),
            ..SinkReport::default()
        }))
    }
}
