//! Closed choices: every word that a key may hold, once, with the value that it stands for.
//!
//! [`Section::choice`](super::section::Section::choice) gives the value. Whoever matches on it names every
//! word, so the compiler points at what a new one has not reached.

pub(super) use crate::echo::synth::doppler::Doppler;
pub(super) use crate::motion::errors::preset::Class;
pub(super) use crate::motion::errors::{Between, Recorded};
use crate::motion::gusts::LEVELS_MPS;
pub(super) use crate::nav::{FileFormat, MotionBounds};
pub(super) use crate::radar::clock::Oscillator;
pub(super) use crate::scene::radar::{
    AfterEnd, AimFrom, Constellation, Datatype, DvbTMode, Guard, Polarisation,
};
pub(super) use crate::scene::sea::{Averaging, Breaking, LightWinds, Permittivity, Phases, Splitting, Waves};
pub(super) use crate::scene::ship::UpAxis;
pub(super) use crate::scene::water::WindProfile;
pub(super) use crate::sinks::OnFailure;
pub(super) use crate::sinks::asterix::{Bits, CellValue};
pub(super) use crate::sinks::vita49::Profile;
pub(super) use crate::sinks::zmq::Messages;
pub(super) use crate::transport::{Pace, Policy};

/// A value that is written as one of some words.
pub(super) trait Choice: Copy + PartialEq + 'static {
    /// The words in the order of the manual.
    const WORDS: &'static [(&'static str, Self)];

    /// The value of a word.
    fn named(word: &str) -> Option<Self> {
        Self::WORDS.iter().find(|(known, _)| *known == word).map(|(_, value)| *value)
    }

    /// The word of a value.
    fn word(self) -> &'static str {
        Self::WORDS.iter().find(|(_, value)| *value == self).map_or("", |(word, _)| word)
    }
}

/// The words of a choice.
pub(super) fn words<C: Choice>() -> Vec<&'static str> {
    C::WORDS.iter().map(|(word, _)| *word).collect()
}

/// Words of types that stand elsewhere, or that hold more than a word.
macro_rules! words {
    ($($choice:ty { $($word:literal = $value:expr),+ })*) => {
        $(impl Choice for $choice {
            const WORDS: &'static [(&'static str, Self)] = &[$(($word, $value)),+];
        })*
    };
}

impl Choice for Datatype {
    const WORDS: &'static [(&'static str, Self)] = &Self::NAMED;
}

/// Choices that nothing but the reader of a scenario knows.
macro_rules! choices {
    ($($choice:ident { $($value:ident = $word:literal),+ })*) => {
        $(#[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(super) enum $choice { $($value),+ })*
        words! { $($choice { $($word = Self::$value),+ })* }
    };
}

/// Words that stand for a number, a flag or the like.
macro_rules! values {
    ($($choice:ident($of:ty) { $($word:literal = $value:expr),+ })*) => {
        $(#[derive(Clone, Copy, Debug, PartialEq)]
        pub(super) struct $choice(pub(super) $of);)*
        words! { $($choice { $($word = Self($value)),+ })* }
    };
}

choices! {
    Begin { Now = "now", Live = "live" }
    PatchKind { Fixed = "fixed", Follow = "follow" }
    AimKind { At = "at", Beside = "beside" }
    WaveformKind {
        Lfm = "lfm", Nlfm = "nlfm", Cw = "cw", PhaseCode = "phase-code", File = "file", Noise = "noise",
        DvbT = "dvb-t", Fm = "fm", GpsCa = "gps-l1-ca", IqFile = "iq-file", Stepped = "stepped", InTurn = "in-turn"
    }
    SweepKind { Up = "up", Down = "down", Triangular = "triangular" }
    TaperKind { Taylor = "taylor", Hamming = "hamming" }
    CodeKind {
        Barker = "barker", Frank = "frank", P3 = "p3", P4 = "p4", MSequence = "m-sequence", GolayA = "golay-a",
        GolayB = "golay-b"
    }
    GateKind { Windowed = "windowed", Continuous = "continuous" }
    TxKind { Simultaneous = "simultaneous", Alternating = "alternating" }
    SignalKind { Tone = "tone", Loopback = "loopback" }
    ApertureTaperKind { Uniform = "uniform", Cosine = "cosine", Hamming = "hamming", Taylor = "taylor" }
    PatternKind { Isotropic = "isotropic", Rectangle = "rectangle", Ellipse = "ellipse", Circle = "circle", File = "file" }
    DatumKind { Ellipsoid = "ellipsoid", MeanSeaLevel = "msl", Barometric = "barometric" }
    AttitudeKind { Recorded = "recorded", CoordinatedTurn = "coordinated_turn", Level = "level", Constant = "constant" }
    SmoothingKind { Off = "off", Rts = "rts" }
    SpectrumName {
        Elfouhaily = "elfouhaily", ElfouhailyFungLee = "elfouhaily-fung-lee", FungLee = "fung-lee",
        PiersonMoskowitz = "pierson-moskowitz", Jonswap = "jonswap", Measured = "measured"
    }
    SpreadingLaw { Mitsuyasu = "mitsuyasu", Elfouhaily = "elfouhaily", Constant = "constant" }
    BraggKind { Frozen = "frozen", Travelling = "travelling" }
    ModulationKind { Off = "off", Relaxation = "relaxation" }
    SpeckleKind { RandomPhase = "random-phase", Gaussian = "gaussian" }
    ShadowEdge { Soft = "soft", Sharp = "sharp" }
    SwellKind { Gaussian = "gaussian", Jonswap = "jonswap" }
    RideKind { Level = "level", Waves = "waves" }
    EchoKind { Reference = "reference", Fast = "fast" }
    SinkKind {
        Hdf5 = "hdf5", Plain = "plain", Crsd = "crsd", Vita49 = "vita49", Asterix = "asterix", Shm = "shm",
        Zmq = "zmq", Nav = "nav", Targets = "targets", Null = "null"
    }
    DetectionKind { Logarithmic = "log", Linear = "linear" }
    HeightsKind { Sea = "sea", Recorded = "recorded" }
    NavFormat { Nmea = "nmea", InspvaxAscii = "inspvaxa", InspvaxBinary = "inspvaxb" }
}

values! {
    Curved(bool) { "flat" = false, "curved" = true }
    Servo(PointingKind) {
        "fixed" = PointingKind::Fixed, "at" = PointingKind::At(AimKind::At),
        "beside" = PointingKind::At(AimKind::Beside), "scan" = PointingKind::Scan, "sector" = PointingKind::Sector,
        "steps" = PointingKind::Steps
    }
    // From which direction a pedestal counts, and by what it is kept level.
    ScanFrom(bool) { "nose" = false, "north" = true }
    Followed(AimKind) { "beside" = AimKind::Beside, "point" = AimKind::At }
    // Wind at 20 ft, m/s.
    GustLevel(f64) { "light" = LEVELS_MPS[0], "moderate" = LEVELS_MPS[1], "severe" = LEVELS_MPS[2] }
    // Whether short waves are joined to those of the file.
    WithTail(bool) { "elfouhaily" = true, "none" = false }
    // Gamma at 10 GHz, dB (Barton 1985).
    Terrain(f64) {
        "flat" = -20.0, "farmland" = -15.0, "rolling-hills" = -12.0, "wooded-hills" = -10.0, "urban" = -5.0,
        "mountains" = -5.0
    }
    // Sign of the received h against the forward-scatter alignment.
    Alignment(f64) { "fsa" = 1.0, "bsa" = -1.0 }
    // Whether the pacer goes ahead of all else.
    PacerAhead(bool) { "realtime" = true, "normal" = false }
}

/// How an antenna points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PointingKind {
    /// Bolted to the body.
    Fixed,
    At(AimKind),
    /// A pedestal that turns without end.
    Scan,
    /// One that goes to and fro.
    Sector,
    /// A beam that jumps.
    Steps,
}

/// Where a track comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TrackKind {
    Fixed,
    Straight,
    Recorded(FileFormat),
    Live,
}

/// Where the way of a target or a ship comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WayKind {
    Recorded(FileFormat),
    Waypoints,
}

words! {
    WayKind {
        "csv" = Self::Recorded(FileFormat::Csv), "nmea" = Self::Recorded(FileFormat::Nmea),
        "inspvax" = Self::Recorded(FileFormat::Inspvax), "sbet" = Self::Recorded(FileFormat::Sbet { gps_week: 0 }),
        "gpx" = Self::Recorded(FileFormat::Gpx), "kml" = Self::Recorded(FileFormat::Kml),
        "waypoints" = Self::Waypoints
    }
    TrackKind {
        "fixed" = Self::Fixed, "straight" = Self::Straight, "csv" = Self::Recorded(FileFormat::Csv),
        "nmea" = Self::Recorded(FileFormat::Nmea), "inspvax" = Self::Recorded(FileFormat::Inspvax),
        // The week is a key of its own.
        "sbet" = Self::Recorded(FileFormat::Sbet { gps_week: 0 }), "gpx" = Self::Recorded(FileFormat::Gpx),
        "kml" = Self::Recorded(FileFormat::Kml), "live" = Self::Live
    }
    AimFrom { "reported" = Self::Reported, "true" = Self::True }
    Polarisation { "H" = Self::H, "V" = Self::V, "R" = Self::R, "L" = Self::L }
    Oscillator { "ocxo" = Self::Ocxo, "tcxo" = Self::Tcxo, "gpsdo" = Self::Gpsdo, "rubidium" = Self::Rubidium }
    Class { "sps" = Self::Sps, "rtk" = Self::Rtk, "tactical" = Self::Tactical, "navigation" = Self::Navigation }
    Recorded { "truth" = Self::Truth, "reported" = Self::Reported }
    Between { "extrapolate" = Self::Extrapolate, "hold" = Self::Hold }
    MotionBounds {
        "ship" = Self::SHIP, "ground" = Self::GROUND, "aircraft" = Self::AIRCRAFT, "spacecraft" = Self::SPACECRAFT
    }
    AfterEnd { "repeat" = Self::Repeat, "silence" = Self::Silence }
    DvbTMode { "2k" = Self::K2, "8k" = Self::K8 }
    Guard { "1/4" = Self::Quarter, "1/8" = Self::Eighth, "1/16" = Self::Sixteenth, "1/32" = Self::Thirtysecond }
    Constellation { "qpsk" = Self::Qpsk, "16-qam" = Self::Qam16, "64-qam" = Self::Qam64 }
    WindProfile { "cardone" = Self::Cardone, "wu" = Self::Wu }
    Waves { "linear" = Self::Linear, "choppy" = Self::Choppy }
    Permittivity { "meissner-wentz" = Self::MeissnerWentz, "klein-swift" = Self::KleinSwift, "itu-r-p527" = Self::ItuRP527 }
    Averaging { "automatic" = Self::Automatic, "points" = Self::Points, "cells" = Self::Cells }
    Splitting { "consistent" = Self::Consistent, "mars2007" = Self::Mars2007 }
    Phases { "polcoherent" = Self::PolCoherent, "single" = Self::Single }
    LightWinds { "threshold" = Self::Threshold, "published" = Self::AsPublished }
    Breaking { "off" = Self::Off, "whitecaps" = Self::Whitecaps }
    UpAxis { "z" = Self::Z, "y" = Self::Y }
    Doppler { "mean" = Self::Mean, "shift" = Self::Shift, "taylor" = Self::Taylor, "shift-taylor" = Self::ShiftTaylor }
    Pace { "realtime" = Self::Realtime, "fast" = Self::Fast }
    Policy { "stop" = Self::Stop, "slip" = Self::Slip, "drop" = Self::Drop, "relax" = Self::Relax }
    Messages { "samples" = Self::Samples, "multipart" = Self::Multipart }
    Profile { "nereus" = Self::Nereus, "difi" = Self::Difi }
    CellValue { "peak" = Self::Peak, "mean" = Self::Mean }
    OnFailure { "stop" = Self::Stop, "continue" = Self::Continue }
}
