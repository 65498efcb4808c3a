//! A scenario as written, then as meant.
//!
//! A scenario is a TOML file; its keys bear their units, angles are in degrees **here only**. It becomes
//! a [`Run`]: plain descriptions for the other modules, in SI units and radians. Nothing is built, no track
//! or pattern is opened (that they exist is checked), no physics is called.
//!
//! * Every key is listed once, in [`keys`]: the reader, the faults and the manual
//!   (`docs/scenario.md`, see [`manual`]) follow that list.
//! * All faults are reported in one go, each with line, column, key, value and what is allowed.
//!   Unknown keys are faults.
//! * Paths of files to be read are relative to the scenario file, so that a scenario can be run from
//!   anywhere. Paths of files to be made are relative to the working directory, so that recordings
//!   land where the user is.
//! * Heights: `position_m` of a platform is East, North, up in the scene frame (the tangent plane at the
//!   origin); `position_m` of a target or an aim point is East, North, height above the sea, which on a
//!   curved earth lies [`Earth::drop_m`](crate::frames::Earth::drop_m) lower. Heights above mean sea
//!   level become ellipsoidal heights by adding `scene.origin_h_m`, one undulation for the whole scene.
//! * Scattering matrices given in back-scatter alignment (BSA) are converted: the received basis of the
//!   forward-scatter alignment (FSA) is that of the propagating wave, and `h(-k) = -h(k)`,
//!   `v(-k) = v(k)`, so `S_fsa = diag(1, -1) S_bsa` in the order (v, h), rows received.
//!
//! ```
//! use std::path::Path;
//! let text = r#"
//!     [scene]
//!     duration_s = 1.0
//!     [radar]
//!     carrier_hz = 10e9
//!     sample_rate_hz = 100e6
//!     prf_hz = 222.0
//!     channels = ["VV"]
//!     waveform = { kind = "lfm", bandwidth_hz = 60e6, pulse_s = 0.333e-6 }
//!     window = { samples = 512, start_us = 26.5 }
//!     [[platform]]
//!     name = "mast"
//!     track = { kind = "fixed", position_m = [0, 0, 15] }
//!     [[transmitter]]
//!     name = "tx"
//!     platform = "mast"
//!     power_w = 1.0
//!     antenna = { kind = "isotropic" }
//!     [[receiver]]
//!     name = "rx"
//!     platform = "mast"
//!     antenna = { kind = "isotropic" }
//! "#;
//! let run = nereus::config::parse(text, Path::new("mast.toml"), &[]).unwrap();
//! assert_eq!(run.scene.pulses, 222);
//!
//! let error = nereus::config::parse("[scene]\nduration = 1", Path::new("bad.toml"), &[]).unwrap_err();
//! assert!(error.to_string().contains("did you mean duration_s, in s?"));
//! ```

mod choices;
mod document;
pub mod error;
pub mod keys;
pub mod manual;
mod hint;
mod resolve;
mod scalars;
mod section;
mod warning;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::echo::Fidelity;
use crate::inputs;
use crate::motion::PlatformNav;
use crate::motion::changes::Event;
use crate::recording::shard::Shard;
use crate::scene::Scene;
use crate::scene::calibration::Calibration;
use crate::scene::clock::Clocks;
use crate::time::TimeTag;
use crate::{sinks, transport};

use error::{At, Problem};
pub use error::{ConfigError, Fault, Warning};
use section::Files;

/// From the reading of a scenario to its first pulse, where that waits for the clock, s: what making it ready
/// may take.
const READY_S: f64 = 3.0;

/// Largest scenario file, bytes.
pub const LARGEST_FILE: u64 = 4 << 20;

/// A scenario as meant: everything `pipeline` needs to build a running stream.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// What there is.
    pub scene: Scene,
    /// Whether pulse 0 leaves at the first whole second that live navigation covers; `scene.start` only
    /// stands for it.
    pub start_live: bool,
    /// Whether pulse 0 leaves when the clock of the machine has reached `scene.start` (`start_utc = "now"`,
    /// for which `text` has the time).
    pub start_now: bool,
    /// Where platforms go; `nav[i]` belongs to `scene.platforms[i]`.
    pub nav: Vec<PlatformNav>,
    /// Clocks that are wrong.
    pub clocks: Clocks,
    /// Channels with signals known in closed form, behind those of the radar.
    pub calibration: Vec<Calibration>,
    /// Changes of reports.
    pub events: Vec<Event>,
    /// Whether more of them may come while the run goes on; not a setting of the scenario.
    pub control: bool,
    /// Which shard of it is made; not a setting of the scenario.
    pub shard: Option<Shard>,
    /// How echoes are made.
    pub fidelity: Fidelity,
    /// How pulses are released.
    pub stream: transport::Settings,
    /// Errors at which pulses may be made while generation falls behind (policy `relax`), dB, from fine to
    /// coarse.
    pub relax_db: Vec<f64>,
    /// Address of the live page.
    pub monitor: Option<String>,
    /// Where pulses go.
    pub sinks: Vec<sinks::Settings>,
    /// The scenario as TOML text, for the record: the file itself, or, with overrides, a scenario
    /// that reads as the same run (its comments are lost).
    pub text: String,
    /// The scenario file.
    pub path: PathBuf,
    /// What is legal but worth knowing.
    pub warnings: Vec<Warning>,
}

/// Reads a scenario file. Overrides are (`key`, `value`): dotted path of the key, entries of arrays by number
/// from 0 (`target.0.rcs_m2`), by name (`target.buoy.rcs_m2`) or `+` for a new one (`sink.+`), and the value
/// as TOML, or as plain text where it is not TOML.
///
/// # Errors
/// A file that cannot be read or is no text, and all faults of the scenario, each with its place.
pub fn load(path: &Path, overrides: &[(String, String)]) -> Result<Run, ConfigError> {
    let read_error = |source| ConfigError::Read { path: path.to_owned(), source };
    let bytes = inputs::read(path, LARGEST_FILE).map_err(read_error)?;
    let size = bytes.len() as u64;
    if size > LARGEST_FILE {
        let bytes = std::fs::metadata(path).map_or(size, |data| data.len().max(size));
        return Err(ConfigError::TooLarge { path: path.to_owned(), bytes, allowed: LARGEST_FILE });
    }
    let text = String::from_utf8(bytes).map_err(|error| ConfigError::NotText {
        path: path.to_owned(),
        offset: error.utf8_error().valid_up_to(),
    })?;
    parse(&text, path, overrides)
}

/// Reads a scenario from memory; `path` names it in faults, and files are looked for beside it.
///
/// # Errors
/// All faults of the scenario, each with its place.
pub fn parse(text: &str, path: &Path, overrides: &[(String, String)]) -> Result<Run, ConfigError> {
    let run = finished(read(text, path, overrides, Files::Required), path)?;
    if run.start_now { starting(text, path, overrides, READY_S) } else { Ok(run) }
}

/// The same with the first whole second as start that is so many seconds ahead, by the clock of the machine.
fn starting(
    text: &str,
    path: &Path,
    overrides: &[(String, String)],
    ahead_s: f64,
) -> Result<Run, ConfigError> {
    let start = TimeTag::new(TimeTag::now().plus(ahead_s).seconds() + 1, 0.0);
    let mut overrides = overrides.to_vec();
    overrides.push(("scene.start_utc".to_owned(), start.to_string()));
    let run = finished(read(text, path, &overrides, Files::Required), path)?;
    Ok(Run { start_now: true, ..run })
}

impl Run {
    /// The same run, with a start so many seconds ahead ([`Self::start_now`]).
    ///
    /// # Errors
    /// Files of the scenario that have changed since it was read.
    pub(crate) fn starting_later(&self, ahead_s: f64) -> Result<Self, ConfigError> {
        let later = starting(&self.text, &self.path, &[], ahead_s)?;
        Ok(Self {
            scene: later.scene,
            nav: later.nav,
            events: later.events,
            text: later.text,
            ..self.clone()
        })
    }
}

/// Reads the scenario that stands inside a recording. Files that it names (tracks, hulls, patterns) are left
/// aside: they need not be where the recording is read, and ships of an AIS log that is not there are none.
///
/// # Errors
/// All faults of the text: one that an older version wrote may have keys that this version does not know.
pub fn recorded(text: &str) -> Result<Run, ConfigError> {
    let path = Path::new("scenario in the recording");
    finished(read(text, path, &[], Files::Optional), path)
}

fn finished(read: Outcome, path: &Path) -> Result<Run, ConfigError> {
    match read.run {
        Some(run) if read.faults.is_empty() => Ok(run),
        _ => Err(ConfigError::Faults { path: path.to_owned(), faults: read.faults }),
    }
}

/// A scenario read to the end, whatever its faults.
struct Outcome {
    run: Option<Run>,
    faults: Vec<Fault>,
    /// Keys asked for, for the test of the manual.
    #[cfg_attr(not(test), allow(dead_code))]
    asked: BTreeSet<(&'static str, &'static str)>,
}

fn read(text: &str, path: &Path, overrides: &[(String, String)], files: Files) -> Outcome {
    let (mut root, syntax) = document::read(text);
    let lost = document::put(&mut root, overrides);
    let folder = path.parent().unwrap_or(Path::new(""));
    let reader = section::Reader::new(folder, files, lost);
    let run = resolve::resolve(section::Section::root(&reader, &root));
    let (mut faults, warnings, asked) = reader.finish();
    if !syntax.is_empty() {
        // What the parser could not read may look missing or misplaced: keep faults that cannot be
        // echoes of it.
        let line = |at: At| match at {
            At::File { line, .. } => Some(line),
            At::Override => None,
        };
        let unread: BTreeSet<usize> = syntax.iter().filter_map(|fault| line(fault.at)).collect();
        faults.retain(|fault| {
            let echo = matches!(fault.problem, Problem::Missing { .. } | Problem::NoneOf { .. });
            !echo && line(fault.at).is_none_or(|line| !unread.contains(&line))
        });
        faults.splice(0..0, syntax);
    }
    faults.sort_by_key(|fault| fault.at);
    let text = if overrides.is_empty() { text.to_owned() } else { with_overrides(&root, overrides) };
    let run = run.map(|parts| Run {
        scene: parts.scene,
        start_live: parts.start_live,
        start_now: parts.start_now,
        nav: parts.nav,
        clocks: parts.clocks,
        calibration: parts.calibration,
        events: parts.events,
        control: false,
        shard: None,
        fidelity: parts.fidelity,
        stream: parts.stream,
        relax_db: parts.relax_db,
        monitor: parts.monitor,
        sinks: parts.sinks,
        text,
        path: path.to_owned(),
        warnings,
    });
    Outcome { run, faults, asked }
}

fn with_overrides(root: &document::Node, overrides: &[(String, String)]) -> String {
    let mut text = String::new();
    for (key, value) in overrides {
        let line: String =
            format!("{key}={value}").chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        text.push_str(&format!("# --set {line}\n"));
    }
    text + &document::write(root)
}

#[cfg(test)]
mod tests;
