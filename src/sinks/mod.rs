//! Where pulses go.
//!
//! A sink implements [`sink::Sink`] and runs in a thread of its own ([`sink::drain`]). [`preflight`]
//! reports everything that is wrong with the outputs asked for before anything is made.
//!
//! ```
//! use nereus::sinks::{Kind, Settings, preflight};
//! let plain = |path: &str| Settings::new(Kind::Plain { path: path.into(), force: false }, 64);
//! // A folder that is there already, and one whose parent is missing.
//! let faults = preflight(&[plain("src"), plain("no/such/folder/recording")]);
//! assert_eq!(faults.len(), 2);
//! assert!(faults[0].to_string().starts_with("src: exists already"));
//! ```

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use crate::files;
use crate::recording::output::recognise_crsd;
use crate::recording::plain::recognise;
use crate::transport::fanout::Role;
use sink::SinkError;

pub(crate) mod description;
mod fault;
pub mod sink;
#[doc(hidden)]
pub mod port;
#[doc(hidden)]
pub mod nav;
#[doc(hidden)]
pub mod null;
#[doc(hidden)]
pub mod plain;
pub(crate) mod redirection;
#[doc(hidden)]
pub mod crsd;
#[doc(hidden)]
pub mod vita49;
#[doc(hidden)]
pub mod zmq;
#[doc(hidden)]
pub mod asterix;
pub(crate) mod link;
#[doc(hidden)]
pub mod shm;
#[cfg(feature = "hdf5")]
#[doc(hidden)]
pub mod hdf5;

/// A place where pulses go.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// What kind of sink.
    pub kind: Kind,
    /// Pulses that may wait for this sink before they are dropped (in real time) or hold up the run.
    pub queue_pulses: usize,
    /// What becomes of the run when this sink fails.
    pub on_failure: OnFailure,
}

impl Settings {
    /// A sink without which the run ends.
    pub fn new(kind: Kind, queue_pulses: usize) -> Self {
        Self { kind, queue_pulses, on_failure: OnFailure::Stop }
    }

    /// What it is to the stream.
    pub(crate) fn role(&self) -> Role {
        Role { lossless: true, may_fail: self.on_failure == OnFailure::Continue }
    }
}

/// What becomes of a run when one of its sinks fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum OnFailure {
    /// It ends, and the other sinks close.
    Stop,
    /// It goes on for the other sinks, and fails at its end.
    Continue,
}

/// Kinds of sinks.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Kind {
    /// HDF5 recording.
    Hdf5 {
        /// The file.
        path: PathBuf,
        /// Start a new file every so many seconds of emission time.
        segment_s: Option<f64>,
        /// Overwrite an existing file.
        force: bool,
    },
    /// A folder of plain binary and text files; needs no system library.
    Plain {
        /// The folder.
        path: PathBuf,
        /// Overwrite an existing folder.
        force: bool,
    },
    /// CRSD 1.0.
    Crsd {
        /// The file.
        path: PathBuf,
        /// Overwrite an existing file.
        force: bool,
    },
    /// VITA 49.2 over UDP.
    Vita49(vita49::Settings),
    /// Shared memory (iceoryx2).
    Shm(shm::Settings),
    /// A ZeroMQ PUB socket.
    Zmq(zmq::Settings),
    /// ASTERIX radar video over UDP.
    Asterix(asterix::Settings),
    /// What a platform reports, on a port.
    Nav(nav::NavSettings),
    /// What a radar and AIS report of targets, on a port.
    Targets(nav::TargetSettings),
    /// Counts pulses and forgets them.
    Null,
}

impl Kind {
    /// A recording at a path: HDF5 or CRSD by the end of its name, or else a folder of plain files.
    pub fn recording_at(path: &Path, force: bool) -> Self {
        let owned = path.to_owned();
        match (names_hdf5(path), names_crsd(path)) {
            (true, _) => Self::Hdf5 { path: owned, segment_s: None, force },
            (_, true) => Self::Crsd { path: owned, force },
            _ => Self::Plain { path: owned, force },
        }
    }

    /// The format of a recording whose name says another one; `None` where it fits.
    pub fn misnamed(&self) -> Option<(&Path, &'static str)> {
        let (path, kind, fits) = match self {
            Self::Hdf5 { path, .. } => (path, "hdf5", names_hdf5(path)),
            Self::Plain { path, .. } => (path, "plain", path.extension().is_some_and(|end| end == "plain")),
            Self::Crsd { path, .. } => (path, "crsd", names_crsd(path)),
            Self::Vita49(_)
            | Self::Shm(_)
            | Self::Zmq(_)
            | Self::Asterix(_)
            | Self::Nav(_)
            | Self::Targets(_)
            | Self::Null => return None,
        };
        let ends = ["h5", "hdf5", "crsd", "plain", "sigmf", "sigmf-meta", "sigmf-data", "zarr"];
        let names = path.extension().is_some_and(|end| ends.iter().any(|known| end == *known));
        (names && !fits).then_some((path, kind))
    }

    /// Where it records pulses; none of what sends, or records something else.
    pub fn recording_path(&mut self) -> Option<&mut PathBuf> {
        match self {
            Self::Hdf5 { path, .. } | Self::Plain { path, .. } | Self::Crsd { path, .. } => Some(path),
            Self::Vita49(_)
            | Self::Shm(_)
            | Self::Zmq(_)
            | Self::Asterix(_)
            | Self::Nav(_)
            | Self::Targets(_)
            | Self::Null => None,
        }
    }

    /// Lets it replace a file of nereus that is there.
    pub fn overwrite(&mut self) {
        match self {
            Self::Hdf5 { force, .. } | Self::Plain { force, .. } | Self::Crsd { force, .. } => *force = true,
            Self::Nav(settings) => settings.force = true,
            Self::Targets(settings) => settings.force = true,
            Self::Vita49(_) | Self::Shm(_) | Self::Zmq(_) | Self::Asterix(_) | Self::Null => {}
        }
    }
}

/// Whether a name is that of an HDF5 file.
pub fn names_hdf5(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "h5" || extension == "hdf5")
}

/// Whether a name is that of a CRSD file.
pub fn names_crsd(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "crsd")
}

/// All that stands in the way of these sinks: outputs that exist (without force) or are no recordings (with
/// it), outputs named twice, folders that are missing. Nothing is made or changed.
pub fn preflight(sinks: &[Settings]) -> Vec<SinkError> {
    let mut faults = Vec::new();
    let mut seen: Vec<Claim> = Vec::new();
    let mut sent_to = Vec::new();
    let mut listens = Vec::new();
    let mut services = Vec::new();
    let mut devices: Vec<&port::Device> = Vec::new();
    for settings in sinks {
        let (path, segmented, result) = match &settings.kind {
            Kind::Null => continue,
            Kind::Vita49(settings) => {
                faults.extend(vita49::preflight(settings).err());
                claim_address(&settings.address, None, &mut sent_to, &mut faults);
                continue;
            }
            Kind::Asterix(settings) => {
                faults.extend(asterix::preflight(settings).err());
                claim_address(&settings.address, Some(settings.source), &mut sent_to, &mut faults);
                continue;
            }
            Kind::Shm(settings) => {
                if services.contains(&&settings.service) {
                    faults.push(SinkError::Twice { path: (&settings.service).into() });
                }
                services.push(&settings.service);
                faults.extend(shm::preflight(settings).err());
                continue;
            }
            Kind::Zmq(settings) => {
                match zmq::preflight(settings) {
                    Ok(addresses) => {
                        let twice = addresses.iter().find(|address| listens.contains(*address));
                        faults.extend(
                            twice.map(|address| SinkError::Twice { path: address.to_string().into() }),
                        );
                        listens.extend(addresses);
                    }
                    Err(fault) => faults.push(fault),
                }
                continue;
            }
            Kind::Nav(nav::NavSettings { device, force, .. })
            | Kind::Targets(nav::TargetSettings { device, force, .. }) => match device.file() {
                Some(path) => (path, false, port::preflight(path, *force).map_err(SinkError::from)),
                None if !devices.contains(&device) => {
                    devices.push(device);
                    continue;
                }
                None => {
                    faults.push(SinkError::Twice { path: device.to_string().into() });
                    continue;
                }
            },
            Kind::Plain { path, force } => {
                (path.as_path(), false, files::preflight(path, *force, &recognise).map_err(SinkError::from))
            }
            Kind::Crsd { path, force } => {
                let free = files::preflight(path, *force, &recognise_crsd);
                (path.as_path(), false, free.map_err(SinkError::from))
            }
            Kind::Hdf5 { path, segment_s, force } => {
                (path.as_path(), segment_s.is_some(), hdf5_preflight(path, *segment_s, *force))
            }
        };
        let claim = Claim::of(path, segmented);
        if seen.iter().any(|other| other.meets(&claim)) {
            faults.push(SinkError::Twice { path: path.to_owned() });
        }
        seen.push(claim);
        faults.extend(result.err());
    }
    faults
}

/// An address to which a sink sends, and by what its datagrams are told from those of other sinks.
type Sent = (SocketAddr, Option<asterix::Source>);

/// Faults an address to which another sink sends, unless both say from which source.
fn claim_address(
    address: &str,
    source: Option<asterix::Source>,
    sent_to: &mut Vec<Sent>,
    faults: &mut Vec<SinkError>,
) {
    let Ok(to) = link::resolve(address) else { return };
    let is_same =
        |other: &Sent| other.0 == to && (source.is_none() || other.1.is_none() || other.1 == source);
    if sent_to.iter().any(is_same) {
        faults.push(SinkError::SameAddress { address: address.to_owned() });
    }
    sent_to.push((to, source));
}

/// A complete output that replaces older ones of its kind without one of its own in their places, too: they
/// are removed when it has been put in its place.
pub fn with_surplus(mut closed: sink::Closed, older: Vec<PathBuf>) -> sink::Closed {
    closed.surplus.extend(older);
    closed
}

/// The names that an output takes.
struct Claim {
    /// As written, and where links lead; of segments those that are there already, too.
    names: Vec<PathBuf>,
    /// What segments are called after.
    segments_of: Option<PathBuf>,
}

impl Claim {
    fn of(path: &Path, segmented: bool) -> Self {
        let beside = files::spelling(files::folder(path)).join(path.file_name().unwrap_or_default());
        let mut names = vec![beside.clone()];
        if segmented {
            names.extend(segments(path).map(|segment| files::spelling(&segment)));
        } else {
            names.push(files::spelling(path));
        }
        Self { names, segments_of: segmented.then_some(beside) }
    }

    /// Whether two outputs are one, or one is a segment of the other.
    fn meets(&self, other: &Self) -> bool {
        let segment_of = |whole: &Path, part: &Path| {
            let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            whole.parent() == part.parent()
                && stem(part)
                    .strip_prefix(&format!("{}_", stem(whole)))
                    .is_some_and(|number| !number.is_empty() && number.bytes().all(|c| c.is_ascii_digit()))
        };
        let has_segment = |whole: &Self, part: &Self| {
            whole.segments_of.iter().any(|whole| part.names.iter().any(|part| segment_of(whole, part)))
        };
        self.names.iter().any(|name| other.names.contains(name))
            || has_segment(self, other)
            || has_segment(other, self)
    }
}

#[cfg(feature = "hdf5")]
fn segments(path: &Path) -> impl Iterator<Item = PathBuf> {
    hdf5::named_as_segments(path).into_iter().map(|(_, path)| path)
}

#[cfg(not(feature = "hdf5"))]
fn segments(_: &Path) -> impl Iterator<Item = PathBuf> {
    std::iter::empty()
}

#[cfg(feature = "hdf5")]
fn hdf5_preflight(path: &Path, segment_s: Option<f64>, force: bool) -> Result<(), SinkError> {
    hdf5::preflight(path, segment_s, force)
}

#[cfg(not(feature = "hdf5"))]
fn hdf5_preflight(path: &Path, _: Option<f64>, _: bool) -> Result<(), SinkError> {
    Err(SinkError::NoHdf5 { path: path.to_owned() })
}
