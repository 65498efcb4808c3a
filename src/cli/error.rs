//! Why a command ends early.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::escape::{name as one_line, path as shown};
use crate::bench::clutter::ClutterError;
use crate::bench::speed::SpeedError;
use crate::pipeline::sea_map::SeaMapError;
use crate::plot::canvas::PictureFileError;
use crate::processor::focus::FocusError;
use crate::processor::ppi::PpiError;
use crate::recording::field_file::FieldFileError;

/// What was asked for, and cannot be: exit 2.
#[derive(Debug, Error)]
pub enum Refused {
    /// A value that an option does not take.
    #[error("{key} {value} is not allowed; allowed: {allowed}")]
    NotAllowed { key: &'static str, value: String, allowed: String },
    /// Options that do not go together, or not with what they are about.
    #[error("{asked}: allowed: {allowed}")]
    Value { asked: String, allowed: String },
    /// A scene of another program that cannot be read.
    #[error("{}:{}", shown(path), below(faults))]
    Import { path: PathBuf, faults: Vec<String> },
    /// Shards without a pulse.
    #[error("--shard {shard}: the run has {pulses} pulses; allowed: at most as many shards")]
    MoreShardsThanPulses { shard: crate::recording::shard::Shard, pulses: u64 },
    /// A map asked of a build without HDF5.
    #[error(
        "this build has no HDF5 (feature `hdf5`): {} cannot be made; allowed: --png, --save-state",
        shown(.0)
    )]
    NoHdf5Map(PathBuf),
    /// Joining asked of a build without HDF5.
    #[cfg(not(feature = "hdf5"))]
    #[error("`nereus merge` joins HDF5 recordings, and this build has no HDF5 (feature `hdf5`)")]
    MergeNeedsHdf5,
    /// A live page asked of a build without it.
    #[cfg(not(feature = "monitor"))]
    #[error(
        "this build has no monitor (feature `monitor`): --monitor, stream.monitor and `nereus monitor` need it"
    )]
    NoMonitor,
    /// Control by a page that there is not.
    #[error(
        "--monitor-control has no page to act through; allowed: together with --monitor ADDR or stream.monitor"
    )]
    ControlWithoutMonitor,
    /// Something that the scenario does not have.
    #[error("{}: the scenario has no {what}", shown(path))]
    Without { path: PathBuf, what: &'static str },
    /// A channel that the scenario does not have.
    #[error("no channel '{name}'; allowed: {known}")]
    NoChannel { name: String, known: String },
    /// A pulse that the run does not have.
    #[error("pulse {pulse} is not part of the run; allowed: 0 to {}", pulses.saturating_sub(1))]
    NoPulse { pulse: u64, pulses: u64 },
    /// A channel that is not in the recording.
    #[error("channel {} is not in the recording; allowed: {allowed}", one_line(name))]
    Channel { name: String, allowed: String },
    /// A channel that carries no echo.
    #[error(
        "channel {} is a calibration channel ({}) and carries no echo; allowed: {allowed}",
        one_line(name),
        one_line(kind)
    )]
    Calibration { name: String, kind: String, allowed: String },
    /// A recording to compare with that is of something else.
    #[error(
        "--against {}: its {what} differ; allowed: a recording of the same radar, pulses and targets",
        shown(path)
    )]
    Against { path: PathBuf, what: &'static str },
    /// Pixels that no law of speckle can be fitted to.
    #[error("--speckle, channel {}: {source}", one_line(channel))]
    Speckle { channel: String, source: crate::clutter::fits::SpeckleError },
    /// Modulation that nothing in the table would show.
    #[error(
        "--modulated has no effect with --splitting mars2007, which tilts nothing within a facet; allowed: --splitting consistent"
    )]
    Unmodulated,
    /// More rows than a table may have.
    #[error("these keys make a table of {rows} rows; allowed: at most {most}")]
    Rows { rows: usize, most: usize },
    /// More seas than a table may prepare.
    #[error("these keys ask for {seas} different seas, each with its integrals; allowed: at most {most}")]
    Seas { seas: usize, most: usize },
    /// A list and a sweep of the same key.
    #[error("{key} and {sweep_key} both say which values to take; allowed: one of them")]
    Both { key: &'static str, sweep_key: &'static str },
    /// A height without the speed that holds there.
    #[error("--wind-height-m is the height of a wind speed; allowed with --wind-mps or a sweep of it")]
    HeightAlone,
    /// A key that means nothing to the chosen kind of spectrum.
    #[error("{key} means nothing to --kind {kind}; allowed with {allowed}")]
    Foreign { key: &'static str, kind: &'static str, allowed: &'static str },
    /// A measured spectrum without its file.
    #[error("--kind measured needs --spectrum-path FILE")]
    NoFile,
    /// A wind too weak for the law asked.
    #[error("a wind of {u10_mps} m/s at 10 m raises no waves; allowed: at least {least_mps} m/s")]
    Calm { u10_mps: f64, least_mps: f64 },
    /// Navigation that is not georeferenced.
    #[error(
        "{}: positions are in the frame of a scene (x_m, y_m, z_m); allowed: lat_deg, lon_deg, height_m",
        shown(.0)
    )]
    Local(PathBuf),
    /// A name without a known format of navigation.
    #[error("{}: its name gives no format; allowed: .csv, .kml, .nmea, .inspvax, or --to", shown(.0))]
    Target(PathBuf),
}

impl Refused {
    /// A value of an option, without its dashes.
    pub(super) fn value(key: &str, found: impl std::fmt::Display, allowed: impl Into<String>) -> Self {
        Self::Value { asked: format!("--{key} {found}"), allowed: allowed.into() }
    }
}

/// Faults, a line each.
fn below(faults: &[String]) -> String {
    faults.iter().map(|fault| format!("\n  {}", one_line(fault))).collect()
}

/// The recording that a fault is about, where it does not bear its name.
fn named(path: &Path, bears_its_name: bool) -> String {
    if bears_its_name { String::new() } else { format!("{}: ", shown(path)) }
}

/// The error of commands: their own, and those of the library, each with whether the input is wrong.
macro_rules! causes {
    ($($(#[$when:meta])? $name:ident($source:ty): $about:literal, $is_wrong_input:expr;)*) => {
        /// Why a command ends early. [`Self::Config`], [`Self::Build`] and [`Self::exit_code`] are interface;
        /// the other variants, and what they hold, may change.
        #[derive(Debug, Error)]
        #[non_exhaustive]
        pub enum CliError {
            /// Standard output cannot be written.
            #[error("cannot write to standard output: {0}")]
            Output(#[source] io::Error),
            /// The run failed.
            #[error("{0}")]
            Run(Box<crate::pipeline::build::RunFailure>),
            /// No handler for Ctrl-C.
            #[error("cannot listen for Ctrl-C: {0}")]
            Signal(#[source] ctrlc::Error),
            /// A recording that is not whole.
            #[error("{}: not whole: {faults} {}", shown(path), if *faults == 1 { "fault" } else { "faults" })]
            NotWhole {
                /// The recording.
                path: PathBuf,
                /// Faults found.
                faults: u64,
            },
            /// A recording that lacks pulses of its run.
            #[error(
                "{}: not complete: {missing} of the {asked} pulses of the run {} missing",
                shown(path), if *missing == 1 { "is" } else { "are" }
            )]
            NotComplete {
                /// The recording.
                path: PathBuf,
                /// Pulses that it lacks.
                missing: u64,
                /// Pulses of the run.
                asked: u64,
            },
            /// A scenario that no change makes fit into real time.
            #[error(
                "{}: nothing that was tried makes it run at {margin} times real time on this machine; \
                 allowed: a lower --margin, a smaller scene, a lower radar.prf_hz, a faster machine",
                shown(path)
            )]
            NoFit {
                /// The scenario.
                path: PathBuf,
                /// Times real time that were wanted.
                margin: f64,
            },
            /// A recording of navigation without a track.
            #[error("{}: no track", shown(.0))]
            NoTrack(PathBuf),
            /// A recording that cannot be focused; what cannot be read bears its name.
            #[error("{}{source}", named(path, matches!(source, FocusError::Recording(_))))]
            Focus {
                /// The recording.
                path: PathBuf,
                /// Why.
                source: FocusError,
            },
            /// A recording without a plan position picture; what cannot be read bears its name.
            #[error("{}{source}", named(path, matches!(source, PpiError::Recording(_))))]
            Ppi {
                /// The recording.
                path: PathBuf,
                /// Why.
                source: PpiError,
            },
            $($(#[$when])? #[doc = $about] #[error(transparent)] $name(#[from] $source),)*
        }

        impl CliError {
            /// Exit code: 2 when the input is wrong, 1 otherwise.
            pub fn exit_code(&self) -> u8 {
                let is_wrong_input = match self {
                    Self::Output(_) | Self::Run(_) | Self::Signal(_) => false,
                    Self::NotWhole { .. } | Self::NotComplete { .. } | Self::NoTrack(_) => false,
                    Self::NoFit { .. } => false,
                    Self::Focus { .. } | Self::Ppi { .. } => true,
                    $($(#[$when])? Self::$name(error) => {
                        let is_wrong_input: fn(&$source) -> bool = $is_wrong_input;
                        is_wrong_input(error)
                    })*
                };
                if is_wrong_input { 2 } else { 1 }
            }
        }
    };
}

causes! {
    Refused(Refused): "What was asked for cannot be done.", |_| true;
    Config(crate::config::ConfigError): "The scenario is wrong.", |_| true;
    Build(crate::pipeline::fault::BuildErrors): "The run cannot be built.", |e| e.is_wrong_input();
    Redirection(crate::sinks::redirection::RedirectionError): "`--out` cannot take the recording.", |_| true;
    #[cfg(feature = "hdf5")]
    Merge(crate::recording::merge::MergeError): "Recordings cannot be joined.", |e| e.is_wrong_input();
    Examination(crate::recording::examination::ExaminationError): "A recording is damaged or forged and is not read.", |_| true;
    // What the HDF5 library refuses to read is a damaged file; what it fails to write is not (Merge).
    Recording(crate::recording::RecordingError): "A recording cannot be read.", |error| match error {
        crate::recording::RecordingError::File(fault) => fault.is_wrong_input(),
        _ => true,
    };
    Pattern(crate::radar::pattern::PatternError): "An antenna pattern cannot be used.", |_| true;
    Control(crate::pipeline::control_lines::ControlFault): "The control socket cannot be made.", |_| true;
    Line(crate::pipeline::control_lines::LineError): "A run does not answer, or refuses a line.", |e| e.is_wrong_input();
    #[cfg(feature = "monitor")]
    Monitor(crate::monitor::MonitorFault): "The live page cannot be served.", |_| true;
    Export(crate::recording::crsd::ExportError): "A recording is not exported.", |e| e.is_wrong_input();
    Receive(crate::receive::ReceiveError): "Nothing can be received.", |e| e.is_wrong_input();
    Speed(SpeedError): "A run cannot be measured.", |e| e.is_wrong_input();
    Clutter(ClutterError): "Statistics of clutter cannot be measured.", |e| e.is_wrong_input();
    Wind(crate::sea::wind::WindError): "A wind is out of range.", |_| true;
    Spectrum(crate::sea::spectrum::SpectrumError): "A spectrum cannot be used.", |_| true;
    Hull(crate::scene::hull::HullError): "A hull cannot be used.", |_| true;
    Kochin(crate::sea::wake::kochin::KochinError): "The waves of a ship cannot be computed.", |_| true;
    Permittivity(crate::scattering::permittivity::PermittivityError): "Water is out of range.", |_| true;
    Measured(crate::scattering::clutter_nrl::ClutterError): "A model of measured clutter does not hold.", |_| true;
    Realise(crate::sea::realise::RealiseError): "A sea cannot be made: wind, spectrum, grid or saved state.", |_| true;
    Surface(crate::sea::wake::WakeError): "A time is out of range of the sea.", |_| true;
    SeaFile(crate::pipeline::sea_map::SeaMapFileError): "A map or state of the sea cannot be written.", |e| e.is_wrong_input();
    File(crate::recording::output::OutputError): "A file cannot be made.", |e| e.is_wrong_input();
    Fields(FieldFileError): "A map or image cannot be written.", |e| e.is_wrong_input();
    Picture(crate::plot::picture::PictureError): "A picture cannot be drawn.", |_| true;
    Plot(crate::plot::chart::PlotError): "A plot cannot be drawn.", |_| true;
    PictureFile(PictureFileError): "A picture cannot be written.", |e| e.is_wrong_input();
    Inspection(crate::nav::inspection::InspectionError): "Recorded navigation cannot be read.", |_| true;
    Playback(crate::pipeline::playback::PlaybackError): "Navigation is not sent on.", |e| e.is_wrong_input();
    Trial(crate::bench::lateness::TrialError): "Lateness cannot be tried.", |_| false;
    Device(crate::sinks::port::NotADevice): "A word names no device.", |_| true;
}

impl From<SeaMapError> for CliError {
    fn from(error: SeaMapError) -> Self {
        match error {
            SeaMapError::Realise(error) => error.into(),
            SeaMapError::Build(error) => error.into(),
            SeaMapError::Surface(error) => error.into(),
        }
    }
}

#[cfg(feature = "monitor")]
impl From<crate::monitor::replay::ReplayError> for CliError {
    fn from(error: crate::monitor::replay::ReplayError) -> Self {
        match error {
            crate::monitor::replay::ReplayError::Recording(error) => error.into(),
            crate::monitor::replay::ReplayError::Monitor(fault) => fault.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::FileFault;
    use crate::pipeline::control_lines::LineError;
    use crate::pipeline::playback::PlaybackError;
    use crate::pipeline::sea_map::SeaMapFileError;
    use crate::plot::canvas::PngError;
    use crate::receive::ReceiveError;
    use crate::recording::RecordingError;
    use crate::sea::surface::StateError;

    /// Exit 1: the machine fell short; 2: the input is wrong.
    #[test]
    fn exit_codes_tell_wrong_input_from_a_failure() {
        let io = || io::Error::from(io::ErrorKind::StorageFull);
        let file = || FileFault::io("a.h5".as_ref(), "writing")(io());
        let (path, text, action) = (|| PathBuf::from("a"), String::new, "writing");
        let hdf5 = || RecordingError::Hdf5 { path: path(), action, detail: text() };
        let cases: [(u8, CliError); 17] = [
            (1, CliError::Output(io())),
            (1, CliError::NotWhole { path: path(), faults: 1 }),
            (1, CliError::NoFit { path: path(), margin: 1.15 }),
            (2, Refused::value("drop", 2, "0 to 1").into()),
            (1, RecordingError::File(file()).into()),
            (2, RecordingError::File(FileFault::Exists { path: path() }).into()),
            // A file that the library cannot read is damaged.
            (2, hdf5().into()),
            (1, ReceiveError::Socket { address: text(), source: io() }.into()),
            (1, FieldFileError::Hdf5 { path: path(), detail: text() }.into()),
            (1, FieldFileError::Facets { layer: text(), values: 1, facets: 2 }.into()),
            (2, FieldFileError::NoHdf5 { path: path() }.into()),
            (1, SeaMapFileError::State(StateError::Io(io())).into()),
            (2, crate::recording::output::OutputError::Twice { path: path() }.into()),
            (1, PictureFileError::Png(PngError::from(png::EncodingError::from(io()))).into()),
            (1, LineError::Silent { path: path(), source: io() }.into()),
            (2, LineError::Line { bytes: 1 }.into()),
            (1, PlaybackError::Port { device: text(), action, source: io() }.into()),
        ];
        for (code, error) in cases {
            assert_eq!(error.exit_code(), code, "{error:?}");
        }
        #[cfg(feature = "hdf5")]
        for error in [hdf5(), RecordingError::File(file())] {
            assert_eq!(CliError::from(crate::recording::merge::MergeError::from(error)).exit_code(), 1);
        }
    }
}
