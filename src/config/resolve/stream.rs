//! How pulses are released, and where they go.

use std::path::PathBuf;

use super::{Ground, Names, address_or, nav_out, video};
use crate::config::choices::{EchoKind, PacerAhead, SinkKind};
use crate::config::error::{Problem, Warning};
use crate::config::keys::{self, Kind, figure};
use crate::config::section::Section;
use crate::echo::{Asked, Fidelity};
use crate::scene::Radar;
use crate::sinks;
use crate::sinks::zmq::Messages;
use crate::transport::{self, Pace, Policy};

/// Memory of the ring between generation and release.
const RING_BYTES: u64 = 512 << 20;
/// Rungs above the error that is asked, where none are written, dB.
const RUNGS_DB: [f64; 2] = [15.0, 30.0];
/// Memory of a sink's queue.
const QUEUE_BYTES: u64 = 256 << 20;
/// Fewest and most slots of the ring: two blocks of pulses, and what one second at 65 kHz takes.
const RING_SLOTS: [u64; 2] = [32, 65_536];
/// Fewest and most pulses of a sink's queue.
const QUEUE_PULSES: [u64; 2] = [64, 65_536];
/// Time that a sink may be held up, s.
const QUEUE_S: f64 = 2.0;
/// Memory and time of what waits for a subscriber.
const BUFFER_BYTES: u64 = 32 << 20;
const BUFFER_S: f64 = 1.0;

/// What a pulse takes in memory.
fn slot_bytes(radar: &Radar, platforms: usize, targets: usize) -> u64 {
    radar.layout(platforms, targets).slot_bytes() as u64
}

/// `[stream]`, and where its live page is served.
pub(super) fn stream(
    root: &Section<'_>,
    radar: Option<&Radar>,
    (platforms, targets): (usize, usize),
    live: bool,
    fidelity: Option<&Fidelity>,
) -> Option<(transport::Settings, Vec<f64>, Option<String>)> {
    use keys::stream::{LATENCY_MS, LOCK_MEMORY, MONITOR, PACE, PACER_CORE, PACER_PRIORITY, POLICY, THREADS};
    let section = root.section_or_empty(&keys::root::STREAM)?;
    let pace = section.choice(&PACE);
    let policy = section.choice(&POLICY);
    if live {
        let place = "beside live navigation";
        if pace == Some(Pace::Fast) {
            section.fault(&PACE, Problem::Live { found: "\"fast\"", place, allowed: "\"realtime\"" });
        }
        if policy == Some(Policy::Slip) {
            section.fault(
                &POLICY,
                Problem::Live { found: "\"slip\"", place, allowed: "\"stop\", \"drop\", \"relax\"" },
            );
        }
    }
    let relax_db = relax_db(&section, policy, fidelity);
    let latency_given = section.has(&LATENCY_MS);
    let asked_ms = section.number(&LATENCY_MS);
    let latency_ms = if latency_given { asked_ms } else { Some(transport::DEFAULT_LATENCY_S * 1e3) };
    let threads = section.count(&THREADS);
    let ahead = section.choice(&PACER_PRIORITY).map(|PacerAhead(ahead)| ahead);
    let pacer_core = match section.has(&PACER_CORE) {
        true => section.count(&PACER_CORE).and_then(|core| usize::try_from(core).ok()).map(Some),
        false => Some(None),
    };
    let lock_memory = section.flag(&LOCK_MEMORY);
    let monitor = section.address(&MONITOR);
    section.finish();
    let latency_s = latency_ms? / 1e3;
    let radar = radar?;
    let wanted = (latency_s * radar.emissions.mean_prf_hz()).ceil() as u64 + 1;
    let fit = (RING_BYTES / slot_bytes(radar, platforms, targets).max(1)).max(2);
    let slots = wanted.clamp(RING_SLOTS[0], RING_SLOTS[1]).min(fit) as usize;
    if (slots as u64) < wanted {
        let mebibytes = (slots as u64 * slot_bytes(radar, platforms, targets)) >> 20;
        root.reader().warn(Warning::ShortRing { wanted, slots, mebibytes });
    }
    let threads = usize::try_from(threads?).ok()?;
    let settings = transport::Settings {
        pace: pace?,
        policy: policy?,
        latency_s,
        latency_given,
        ring_slots: slots,
        // A block is what its echo makes of it.
        batch_pulses: 1,
        threads,
        pacer_ahead: ahead?,
        pacer_core: pacer_core?,
        lock_memory: lock_memory?,
    };
    Some((settings, relax_db?, monitor))
}

/// Errors of the rungs below the one that is asked, dB.
fn relax_db(section: &Section<'_>, policy: Option<Policy>, fidelity: Option<&Fidelity>) -> Option<Vec<f64>> {
    use keys::fidelity::ERROR_DB;
    use keys::stream::{POLICY, RELAX_DB};
    let written = section.numbers(&RELAX_DB);
    let is_written = section.has(&RELAX_DB);
    if policy != Some(Policy::Relax) {
        if is_written && policy.is_some() {
            section.fault(&RELAX_DB, Problem::Idle { when: "policy is not \"relax\"".to_owned() });
        }
        return Some(Vec::new());
    }
    let Fidelity::Fast(Asked { error_db, .. }) = fidelity? else {
        let (place, allowed) = ("beside fidelity.echo = \"reference\"", "\"stop\", \"slip\", \"drop\"");
        section.fault(&POLICY, Problem::Live { found: "\"relax\"", place, allowed });
        return None;
    };
    let Kind::Number { max, .. } = ERROR_DB.kind else { return None };
    if !is_written {
        return Some(RUNGS_DB.map(|above| error_db + above).into_iter().filter(|db| *db <= max).collect());
    }
    let written = written?;
    let finer = std::iter::once(error_db).chain(&written);
    if let Some((place, finer)) = finer.enumerate().take(written.len()).find(|(n, db)| written[*n] <= **db) {
        let [found, finer] = [written[place], *finer].map(figure);
        let (found, allowed) =
            (format!("entry {place}, {found},"), format!("above {finer} dB, the one before"));
        section.fault(&RELAX_DB, Problem::Range { found, allowed });
        return None;
    }
    Some(written)
}

/// `[fidelity]`.
pub(super) fn fidelity(root: &Section<'_>) -> Option<Fidelity> {
    use keys::fidelity::{
        CUTOFF_DB, DOPPLER, ECHO, ERROR_DB, GAIN_PULSES, KERNEL_WIDTH, NODE_PULSES, PANEL_PULSES,
        SCATTER_PULSES, SIDELOBE_DB,
    };
    let section = root.section_or_empty(&keys::root::FIDELITY)?;
    let echo = section.choice(&ECHO);
    let error_db = section.number(&ERROR_DB);
    let width = section.count(&KERNEL_WIDTH);
    let doppler = section.choice(&DOPPLER);
    let asked = Asked {
        node_pulses: section.count(&NODE_PULSES),
        scatter_pulses: section.count(&SCATTER_PULSES),
        gain_pulses: section.count(&GAIN_PULSES),
        panel_pulses: section.count(&PANEL_PULSES),
        sidelobe_db: section.number(&SIDELOBE_DB),
        cutoff_db: section.number(&CUTOFF_DB),
        kernel_width: width.and_then(|width| usize::try_from(width).ok()),
        doppler,
        ..Asked::default()
    };
    // Settings of the fast echo may stand beside "reference", so that one key switches a scenario; they do
    // nothing there.
    let written = keys::fidelity::TABLE.keys.iter().filter(|key| key.name != ECHO.name && section.has(key));
    let written: Vec<String> = written.map(|key| format!("fidelity.{}", key.name)).collect();
    section.finish();
    // A wrong word has been reported; as the default it makes no further fault.
    match echo {
        Some(EchoKind::Reference) => {
            if !written.is_empty() {
                root.reader().warn(Warning::IdleSettings { keys: written.join(", ") });
            }
            Some(Fidelity::Reference)
        }
        Some(EchoKind::Fast) | None => Some(Fidelity::Fast(Asked { error_db: error_db?, ..asked })),
    }
}

/// `[[sink]]`; `known` channels of calibration stand behind those of the radar.
pub(super) fn sinks(
    root: &Section<'_>,
    radar: Option<&Radar>,
    ground: &Ground,
    platforms: &Names,
    targets: usize,
    known: usize,
) -> Option<Vec<sinks::Settings>> {
    let defaults = radar.map(|radar| {
        let slot_bytes = slot_bytes(radar, platforms.names.len(), targets).max(1);
        let pulses = |seconds: f64, bytes: u64| {
            let wanted = (seconds * radar.emissions.mean_prf_hz()).ceil() as u64;
            wanted.clamp(QUEUE_PULSES[0], QUEUE_PULSES[1]).min((bytes / slot_bytes).max(2))
        };
        let channels = radar.channels.len() + known;
        Defaults { queue: pulses(QUEUE_S, QUEUE_BYTES), buffer: pulses(BUFFER_S, BUFFER_BYTES), channels }
    });
    let sections = root.sections(&keys::root::SINK);
    if !root.has(&keys::root::SINK) || sections.is_empty() {
        root.reader().warn(Warning::NoSink);
        return Some(vec![sinks::Settings::new(sinks::Kind::Null, usize::try_from(defaults?.queue).ok()?)]);
    }
    let mut taken = Vec::new();
    let sinks: Vec<Option<sinks::Settings>> = sections
        .into_iter()
        .map(|section| sink(section, radar, ground, platforms, defaults, &mut taken))
        .collect();
    sinks.into_iter().collect()
}

/// What follows from the radar.
#[derive(Clone, Copy)]
struct Defaults {
    /// Pulses that may wait for a sink.
    queue: u64,
    /// Pulses that may wait for a subscriber.
    buffer: u64,
    channels: usize,
}

fn sink(
    section: Section<'_>,
    radar: Option<&Radar>,
    ground: &Ground,
    platforms: &Names,
    defaults: Option<Defaults>,
    taken: &mut Vec<PathBuf>,
) -> Option<sinks::Settings> {
    use keys::sink::{BIND, KIND, MTU_BYTES, ON_FAILURE, PATH, PROFILE, QUEUE_PULSES as QUEUE, SEGMENT_S};
    let kind = match section.choice(&KIND) {
        Some(SinkKind::Hdf5) => {
            let has_segments = section.has(&SEGMENT_S);
            let segment_s = section.number(&SEGMENT_S);
            let path = output(&section, taken);
            path.filter(|_| !has_segments || segment_s.is_some()).map(|path| hdf5(&section, path, segment_s))
        }
        Some(SinkKind::Nav) => nav_out::nav(&section, ground, platforms).map(sinks::Kind::Nav),
        Some(SinkKind::Targets) => nav_out::targets(&section, ground, platforms).map(sinks::Kind::Targets),
        Some(SinkKind::Crsd) => output(&section, taken).map(|path| sinks::Kind::Crsd { path, force: false }),
        Some(SinkKind::Plain) => {
            output(&section, taken).map(|path| sinks::Kind::Plain { path, force: false })
        }
        Some(SinkKind::Vita49) => {
            let (address, mtu_bytes) = (address_or(&section, "127.0.0.1:4991"), section.count(&MTU_BYTES));
            let bind = section.address(&BIND);
            let fine = bind.is_some() || !section.has(&BIND);
            let profile = section.choice(&PROFILE);
            address.zip(mtu_bytes).filter(|_| fine).and_then(|(address, mtu_bytes)| {
                let mtu_bytes = usize::try_from(mtu_bytes).ok()?;
                let profile = profile?;
                Some(sinks::Kind::Vita49(sinks::vita49::Settings { address, bind, mtu_bytes, profile }))
            })
        }
        Some(SinkKind::Asterix) => video::asterix(&section, radar, platforms).map(sinks::Kind::Asterix),
        Some(SinkKind::Shm) => shm(&section, defaults).map(sinks::Kind::Shm),
        Some(SinkKind::Zmq) => zmq(&section, defaults).map(sinks::Kind::Zmq),
        Some(SinkKind::Null) => Some(sinks::Kind::Null),
        None => None,
    };
    let asked_queue = section.count(&QUEUE);
    let queue = if section.has(&QUEUE) { asked_queue } else { defaults.map(|of| of.queue) };
    let on_failure = section.choice(&ON_FAILURE);
    section.finish();
    let queue_pulses = usize::try_from(queue?).ok()?;
    return Some(sinks::Settings { kind: kind?, queue_pulses, on_failure: on_failure? });

    fn output(section: &Section<'_>, taken: &mut Vec<PathBuf>) -> Option<PathBuf> {
        let path = section.output(&PATH)?;
        if taken.contains(&path) {
            let problem = Problem::Duplicate { name: path.display().to_string(), what: "sink" };
            section.fault(&PATH, problem);
        }
        taken.push(path.clone());
        Some(path)
    }
}

/// The keys of `kind = "shm"`.
fn shm(section: &Section<'_>, defaults: Option<Defaults>) -> Option<sinks::shm::Settings> {
    use keys::sink::{SERVICE, SUBSCRIBERS};
    let (asked, subscribers) = (section.name(&SERVICE), section.count(&SUBSCRIBERS));
    let service = if section.has(&SERVICE) { asked } else { Some("nereus".to_owned()) };
    let buffer_pulses = buffer(section, defaults);
    let subscribers = usize::try_from(subscribers?).ok()?;
    Some(sinks::shm::Settings { service: service?, subscribers, buffer_pulses: buffer_pulses? })
}

/// The keys of `kind = "zmq"`.
fn zmq(section: &Section<'_>, defaults: Option<Defaults>) -> Option<sinks::zmq::Settings> {
    use keys::sink::{BIND, MESSAGES};
    let asked = section.address(&BIND);
    let bind = if section.has(&BIND) { asked } else { Some("127.0.0.1:5555".to_owned()) };
    let messages = section.choice(&MESSAGES);
    let buffer_pulses = buffer(section, defaults);
    let (bind, messages) = (bind?, messages?);
    let ports = if messages == Messages::Samples { defaults?.channels } else { 1 };
    let ports = u16::try_from(ports).ok()?;
    let first: u16 = bind.rsplit_once(':')?.1.parse().ok()?;
    if first.checked_add(ports - 1).is_none() {
        section.fault(&BIND, Problem::Ports { bind: bind.clone(), ports });
    }
    Some(sinks::zmq::Settings { bind, ports, messages, buffer_pulses: buffer_pulses? })
}

/// Pulses that may wait for a subscriber.
fn buffer(section: &Section<'_>, defaults: Option<Defaults>) -> Option<usize> {
    use keys::sink::BUFFER_PULSES;
    let asked = section.count(&BUFFER_PULSES);
    let pulses = if section.has(&BUFFER_PULSES) { asked } else { defaults.map(|of| of.buffer) };
    usize::try_from(pulses?).ok()
}

/// An HDF5 recording, or the plain folder that stands for it in a build without HDF5.
fn hdf5(section: &Section<'_>, path: PathBuf, segment_s: Option<f64>) -> sinks::Kind {
    if cfg!(feature = "hdf5") {
        return sinks::Kind::Hdf5 { path, segment_s, force: false };
    }
    let taken =
        if path.extension().is_some() { path.with_extension("") } else { path.with_extension("plain") };
    let warning = Warning::NoHdf5 { asked: path, taken: taken.clone(), segmented: segment_s.is_some() };
    section.reader().warn(warning);
    sinks::Kind::Plain { path: taken, force: false }
}
