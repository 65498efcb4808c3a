//! Every key of a scenario, once: name, unit, range, default, meaning.
//!
//! The reader checks values against this list, faults quote it, and `docs/scenario.md` is written from
//! it ([`super::manual`]), so none of the three can say something else.

/// One table of a scenario.
#[derive(Debug)]
pub struct Table {
    /// As written, with brackets: `[radar.window]`.
    pub heading: &'static str,
    /// What it describes.
    pub about: &'static str,
    /// Its keys.
    pub keys: &'static [&'static Key],
}

/// One key.
#[derive(Debug)]
pub struct Key {
    /// As written, the unit at its end.
    pub name: &'static str,
    /// What its value may be.
    pub kind: Kind,
    /// What its absence means.
    pub absent: Absent,
    /// What it means.
    pub about: &'static str,
}

/// What a value may be.
#[derive(Debug)]
pub enum Kind {
    /// A finite number, both ends of the range included unless `above`.
    Number {
        /// Unit; empty for a plain number.
        unit: &'static str,
        /// Smallest value.
        min: f64,
        /// Greatest value.
        max: f64,
        /// Whether the smallest value itself is excluded.
        above: bool,
    },
    /// A list of numbers.
    Numbers {
        /// Unit; empty for plain numbers.
        unit: &'static str,
        /// Fewest entries.
        least: usize,
        /// Most entries.
        most: usize,
        /// Smallest value of an entry.
        min: f64,
        /// Greatest value of an entry.
        max: f64,
    },
    /// A list of points, each a pair of numbers.
    Points {
        /// Unit.
        unit: &'static str,
        /// Fewest points.
        least: usize,
        /// Most points.
        most: usize,
        /// Greatest coordinate either way.
        limit: f64,
    },
    /// A whole number.
    Count {
        /// Smallest value.
        min: u64,
        /// Greatest value.
        max: u64,
    },
    /// `true` or `false`.
    Flag,
    /// One of some words.
    Choice(&'static [&'static str]),
    /// A list of words.
    Words {
        /// Fewest entries.
        least: usize,
        /// Most entries.
        most: usize,
        /// What an entry may be.
        entry: &'static str,
    },
    /// Polarisation pair, receive then transmit.
    PolarisationPair,
    /// A line of text.
    Line,
    /// A name: letters, digits, `_`, `-`, `.`, at most 64 of them.
    Name,
    /// An instant, UTC.
    Time,
    /// An instant, UTC, or one word.
    TimeOr(&'static str),
    /// A file that exists, relative to the scenario file.
    File,
    /// A file or folder to be made, relative to the working directory.
    Output,
    /// Where live navigation comes from: a port, an address, a file relative to the scenario file.
    Origin,
    /// Host and port of the network.
    Address,
    /// A file that exists, or one word.
    FileOr(&'static str),
    /// A table of its own.
    Section(&'static Table),
    /// A table of its own, or whether there is one.
    Switched(&'static Table),
    /// An array of tables.
    Sections(&'static Table),
}

/// What the absence of a key means.
#[derive(Debug)]
pub enum Absent {
    /// A fault.
    Required,
    /// This number.
    Number(f64),
    /// This whole number.
    Count(u64),
    /// This flag.
    Flag(bool),
    /// This word.
    Word(&'static str),
    /// A list of zeros.
    Zeros,
    /// Something that is not a value, in words.
    Means(&'static str),
}

use Absent::{Count, Flag, Means, Required, Word, Zeros};
use Kind::{
    Choice, File, FileOr, Name, Output, PolarisationPair, Section, Sections, Switched, Time, TimeOr, Words,
};

const fn number(unit: &'static str, min: f64, max: f64) -> Kind {
    Kind::Number { unit, min, max, above: false }
}
const fn above(unit: &'static str, min: f64, max: f64) -> Kind {
    Kind::Number { unit, min, max, above: true }
}
const fn vector(unit: &'static str, entries: usize, limit: f64) -> Kind {
    Kind::Numbers { unit, least: entries, most: entries, min: -limit, max: limit }
}
const fn sizes(unit: &'static str, limit: f64) -> Kind {
    Kind::Numbers { unit, least: 3, most: 3, min: 0.0, max: limit }
}
const fn count(min: u64, max: u64) -> Kind {
    Kind::Count { min, max }
}
const fn default(value: f64) -> Absent {
    Absent::Number(value)
}

/// Farthest coordinate, m: beyond geostationary orbit.
const FAR_M: f64 = 1e8;
/// Greatest speed, m/s: above escape velocity.
const FAST_MPS: f64 = 2e4;
/// Most pulse repetition intervals in a sequence.
const MOST_PRI: usize = 65_536;
/// Most targets of a scene.
pub(super) const MOST_TARGETS: u64 = 100_000;
/// Most ships of a scene.
pub(super) const MOST_SHIPS: u64 = 1000;

/// Most facets of a patch of sea.
pub(super) const MOST_FACETS: u64 = 1 << 26;

/// Where a model of the permittivity holds.
#[derive(Clone, Copy)]
pub(super) struct ModelRange {
    /// As written.
    pub(super) model: &'static str,
    pub(super) carrier_hz: [f64; 2],
    pub(super) temperature_c: [f64; 2],
    pub(super) salinity_psu: [f64; 2],
}

pub(super) const MEISSNER_WENTZ: ModelRange = ModelRange {
    model: "meissner-wentz",
    carrier_hz: [1e9, 90e9],
    temperature_c: [-2.0, 34.0],
    salinity_psu: [0.0, 40.0],
};
pub(super) const KLEIN_SWIFT: ModelRange = ModelRange {
    model: "klein-swift",
    carrier_hz: [1e9, 10e9],
    temperature_c: [0.0, 30.0],
    salinity_psu: [4.0, 35.0],
};

macro_rules! tables {
    ($($module:ident $heading:literal $about_table:literal {
        $($key:ident $name:literal, $kind:expr, $absent:expr, $about:literal;)*
    })*) => {
        $(
            #[doc = concat!("Keys of `", $heading, "`.")]
            #[allow(unused_imports)]
            pub mod $module {
                use super::*;
                $(
                    #[doc = concat!("The key `", $name, "`.")]
                    pub static $key: Key = Key { name: $name, kind: $kind, absent: $absent, about: $about };
                )*
                /// The table.
                pub static TABLE: Table = Table { heading: $heading, about: $about_table, keys: &[$(&$key),*] };
            }
        )*
        /// Every table, in the order of the manual.
        pub static TABLES: &[&Table] = &[$(&$module::TABLE),*];
    };
}

tables! {
    root "(top level)" "The tables of a scenario." {
        SCENE "scene", Section(&scene::TABLE), Required, "Where and when.";
        RADAR "radar", Section(&radar::TABLE), Required, "The instrument.";
        PLATFORM "platform", Sections(&platform::TABLE), Required, "What moves; at least one.";
        TRANSMITTER "transmitter", Sections(&transmitter::TABLE), Required, "Transmitters; at least one.";
        RECEIVER "receiver", Sections(&receiver::TABLE), Required, "Receivers; at least one.";
        SEA "sea", Section(&sea::TABLE), Means("no sea: targets alone"), "The sea, on the patch of [scene].";
        SWELL "swell", Sections(&swell::TABLE), Means("none"), "Swell trains, with [sea].";
        SLICK "slick", Sections(&slick::TABLE), Means("none"), "Films on the water, with [sea].";
        SHIP "ship", Sections(&ship::TABLE), Means("none"), "Ships under way, with [sea].";
        AIS "ais", Sections(&ais::TABLE), Means("none"), "Ships of a recorded AIS log, with [sea].";
        TARGET "target", Sections(&target::TABLE), Means("none"), "Point targets.";
        TARGET_GRID "target_grid", Sections(&target_grid::TABLE), Means("none"), "Fields of equal point targets.";
        EVENT "event", Sections(&event::TABLE), Means("none"), "Changes of what platforms report, each from a pulse on.";
        FIDELITY "fidelity", Section(&fidelity::TABLE), Means("all defaults"), "Speed against accuracy.";
        STREAM "stream", Section(&stream::TABLE), Means("all defaults"), "How pulses are released.";
        SINK "sink", Sections(&sink::TABLE), Means("pulses are counted and forgotten"), "Where pulses go.";
    }
    scene "[scene]" "Where and when. The scene frame is East, North, up at the origin, a point of mean sea level." {
        ORIGIN_LAT_DEG "origin_lat_deg", number("deg", -90.0, 90.0), Means("a plain local frame that lies nowhere on Earth"), "Latitude of the origin, WGS-84. The three origin keys stand together or not at all.";
        ORIGIN_LON_DEG "origin_lon_deg", number("deg", -180.0, 360.0), Means("see origin_lat_deg"), "Longitude of the origin, East positive.";
        ORIGIN_H_M "origin_h_m", number("m", -500.0, 10_000.0), Means("see origin_lat_deg"), "Height of mean sea level above the WGS-84 ellipsoid at the origin (the geoid undulation). It converts every height above sea level of the scenario.";
        EARTH "earth", Choice(&["flat", "curved"]), Means("\"curved\" with an origin, \"flat\" without"), "Shape of the mean sea surface.";
        EARTH_RADIUS_FACTOR "earth_radius_factor", number("", 0.1, 100.0), default(1.0), "Curved earth: effective radius over 6371 km; 4/3 is standard refraction.";
        HORIZON "horizon", Kind::Flag, Means("true on a curved earth"), "Curved earth: whether it hides the sea, targets and the direct path beyond the horizon of an antenna. Without diffraction.";
        START_UTC "start_utc", TimeOr("live"), Means("2000-01-01T00:00:00Z; required with recorded tracks and live navigation"), "Emission of pulse 0. live: the first whole second that live navigation covers.";
        DURATION_S "duration_s", above("s", 0.0, 1e7), Required, "Pulses leave from start_utc until just before this much later.";
        SEED "seed", count(0, u64::MAX), Count(0), "Seed of every random stream.";
        PATCH "patch", Choice(&["fixed", "follow"]), Word("fixed"), "With [sea]: whether the patch of sea that is modelled stays, or follows a point as the platforms fly on.";
        PATCH_SIZE_M "patch_size_m", Kind::Numbers { unit: "m", least: 2, most: 2, min: 1e-4, max: FAR_M }, Means("required with [sea]"), "Length of the patch along East and North, whole facets. The waves repeat after it.";
        FACET_M "facet_m", number("m", 1e-4, 1e5), Means("required with [sea]"), "Side of a facet of the sea.";
        PATCH_CENTRE_M "patch_centre_m", vector("m", 2, FAR_M), Zeros, "fixed: centre of the patch, East and North, to the nearest facet.";
        PATCH_FOLLOW "patch_follow", Section(&patch_follow::TABLE), Means("the point at which the first receiver aims; required where it aims at none"), "follow: the point that the patch stays around.";
    }
    patch_follow "[scene.patch_follow]" "The point that the patch of sea stays around." {
        KIND "kind", Choice(&["beside", "point"]), Required, "A point of the sea beside a platform, or one on a straight course.";
        POSITION_M "position_m", vector("m", 3, FAR_M), Means("lat_deg and lon_deg are given"), "point: East, North, height above the sea, at pulse 0.";
        LAT_DEG "lat_deg", number("deg", -90.0, 90.0), Means("position_m is given"), "point: latitude; the point lies on the sea.";
        LON_DEG "lon_deg", number("deg", -180.0, 360.0), Means("position_m is given"), "point: longitude.";
        VELOCITY_MPS "velocity_mps", vector("m/s", 3, FAST_MPS), Zeros, "point: velocity East, North, up.";
        PLATFORM "platform", Name, Required, "beside: the platform.";
        ALONG_M "along_m", number("m", -FAR_M, FAR_M), default(0.0), "beside: metres ahead along the ground track.";
        ACROSS_M "across_m", number("m", -FAR_M, FAR_M), Required, "beside: metres to starboard of the ground track, negative to port.";
        AIM_FROM "aim_from", Choice(&["reported", "true"]), Word("reported"), "Which tracks the point is known from.";
    }
    radar "[radar]" "The instrument." {
        CARRIER_HZ "carrier_hz", number("Hz", 1e6, 1e12), Required, "Carrier frequency.";
        SAMPLE_RATE_HZ "sample_rate_hz", number("Hz", 1e3, 1e11), Required, "Complex sample rate; not below the bandwidth.";
        PRF_HZ "prf_hz", number("Hz", 0.001, 1e9), Means("pri_us is given"), "Pulse repetition frequency. Exactly one of prf_hz and pri_us. A pulse ends before the next one begins.";
        PRI_US "pri_us", Kind::Numbers { unit: "us", least: 1, most: MOST_PRI, min: 1e-3, max: 1e9 }, Means("prf_hz is given"), "Pulse repetition intervals, repeated in turn.";
        WAVEFORM "waveform", Section(&waveform::TABLE), Required, "What is radiated.";
        WINDOW "window", Section(&window::TABLE), Required, "When samples are taken.";
        TX_POLARISATION "tx_polarisation", Choice(&["simultaneous", "alternating"]), Word("simultaneous"), "Whether all transmit polarisations leave with every pulse, or one after the other.";
        TX_SEQUENCE "tx_sequence", Words { least: 1, most: 256, entry: "H, V, R or L" }, Means("the transmit polarisations of the channels, in order of first use"), "Alternating: transmit polarisation of pulse 0, 1, ..., repeated.";
        CHANNELS "channels", Words { least: 1, most: 16, entry: "receive then transmit polarisation, each H, V, R or L" }, Means("[[radar.channel]] is given"), "Polarisation pairs recorded for every transmitter and receiver, e.g. [\"HH\", \"HV\", \"VH\", \"VV\"]. Exactly one of channels and [[radar.channel]].";
        CHANNEL "channel", Sections(&channel::TABLE), Means("channels is given"), "Channels, row by row.";
        LOSSES_DB "losses_db", number("dB", 0.0, 300.0), default(0.0), "System losses; a gain belongs to the antennas.";
        ATMOSPHERE_DB_PER_KM "atmosphere_db_per_km", number("dB/km", 0.0, 1000.0), default(0.0), "Atmospheric attenuation, one way.";
        NOISE_FIGURE_DB "noise_figure_db", number("dB", 0.0, 100.0), Means("a noiseless receiver"), "Receiver noise figure at 290 K.";
        ADC "adc", Section(&adc::TABLE), Means("floating-point samples"), "Analogue-to-digital converter.";
        CALIBRATION "calibration", Sections(&calibration::TABLE), Means("none"), "Channels with signals known in closed form, behind all others.";
        DIRECT_PATH "direct_path", Kind::Flag, Flag(false), "Whether the direct path from transmitter to receiver is received.";
    }
    waveform "[radar.waveform]" "What is radiated, at unit amplitude." {
        KIND "kind", Choice(&["lfm", "file"]), Required, "Linear frequency modulation, or samples from a file.";
        BANDWIDTH_HZ "bandwidth_hz", above("Hz", 0.0, 1e11), Required, "lfm: swept bandwidth.";
        PULSE_S "pulse_s", above("s", 0.0, 10.0), Required, "lfm: pulse length.";
        SWEEP "sweep", Choice(&["up", "down"]), Word("up"), "lfm: direction of the sweep.";
        PATH "path", File, Required, "file: CSV lines re,im without a header.";
        RATE_HZ "rate_hz", number("Hz", 1e3, 1e11), Required, "file: sample rate of the file.";
    }
    window "[radar.window]" "The receive window. Exactly one of start_us and follow." {
        SAMPLES "samples", count(1, 1 << 24), Required, "Complex samples per channel; not shorter than the pulse.";
        START_US "start_us", number("us", 0.0, 1e7), Means("follow is given"), "Start after the emission, not rounded to the sample grid. May exceed the pulse interval.";
        FOLLOW "follow", Section(&follow::TABLE), Means("start_us is given"), "A window that follows the echo of an aim point.";
    }
    follow "[radar.window.follow]" "A window that follows the echo of an aim point." {
        KIND "kind", Choice(&["at", "beside"]), Required, "A point of the scene, or one beside a platform.";
        POSITION_M "position_m", vector("m", 3, FAR_M), Means("lat_deg and lon_deg are given"), "at: East, North, height above the sea, at pulse 0.";
        LAT_DEG "lat_deg", number("deg", -90.0, 90.0), Means("position_m is given"), "at: latitude; the point lies on the sea.";
        LON_DEG "lon_deg", number("deg", -180.0, 360.0), Means("position_m is given"), "at: longitude.";
        VELOCITY_MPS "velocity_mps", vector("m/s", 3, FAST_MPS), Zeros, "at: velocity East, North, up.";
        PLATFORM "platform", Name, Required, "beside: the platform.";
        ALONG_M "along_m", number("m", -FAR_M, FAR_M), default(0.0), "beside: metres ahead along the ground track.";
        ACROSS_M "across_m", number("m", -FAR_M, FAR_M), Required, "beside: metres to starboard of the ground track, negative to port.";
        LEAD_US "lead_us", number("us", 0.0, 1e6), Required, "How much earlier than the echo of the aim point the window opens.";
        AIM_FROM "aim_from", Choice(&["reported", "true"]), Word("reported"), "Which tracks steer the opening of the receive window.";
    }
    adc "[radar.adc]" "Analogue-to-digital converter: mid-rise, I and Q separately, saturating." {
        BITS "bits", count(1, 16), Required, "Bits.";
        FULL_SCALE_DBW "full_scale_dbw", number("dBW", -400.0, 200.0), Required, "Full scale of I and of Q: 20 log10 of the amplitude in sqrt(W).";
    }
    channel "[[radar.channel]]" "One recorded channel." {
        POLARISATION "polarisation", PolarisationPair, Required, "Receive then transmit polarisation, e.g. \"HV\".";
        TRANSMITTER "transmitter", Name, Means("the only transmitter"), "Its transmitter.";
        RECEIVER "receiver", Name, Means("the only receiver"), "Its receiver.";
        NAME "name", Name, Means("the polarisation pair, with the names of the antennas where there are several"), "Its name in recordings.";
    }
    calibration "[[radar.calibration]]" "A channel that carries a signal known in closed form in place of an echo (docs/calibration.md)." {
        NAME "name", Name, Required, "Its name in recordings, unique among channels.";
        KIND "kind", Choice(&["tone", "loopback"]), Required, "A continuous tone, or the transmitted pulse after the receive filter.";
        RECEIVER "receiver", Name, Means("the only receiver"), "The receiver that takes it, with its clock.";
        TRANSMITTER "transmitter", Name, Means("the only transmitter"), "loopback: the transmitter, with its clock.";
        POWER_DBW "power_dbw", number("dBW", -400.0, 200.0), Required, "Power of the signal; of a loopback, that of a pulse of unit amplitude.";
        PHASE_DEG "phase_deg", number("deg", -360.0, 360.0), default(0.0), "Its phase: of a tone at the emission of pulse 0.";
        OFFSET_HZ "offset_hz", number("Hz", -5e10, 5e10), Required, "tone: frequency above the carrier, at most half the sample rate either way.";
        DELAY_S "delay_s", number("s", 0.0, 100.0), Required, "loopback: from the first sample of every window to the begin of the pulse; the whole pulse must lie in the window.";
        NOISE "noise", Kind::Flag, Flag(false), "Whether the receiver's noise is added.";
    }
    platform "[[platform]]" "Something that carries antennas." {
        NAME "name", Name, Required, "Its name, unique among platforms.";
        TRACK "track", Section(&track::TABLE), Required, "Where it is: drives delays, phases and gains.";
        REPORTED "reported", Section(&track::TABLE), Means("the true track is reported"), "Where it reports to be, in the same form.";
        ERRORS "errors", Section(&errors::TABLE), Means("none"), "Errors of its reports.";
        TURBULENCE "turbulence", Section(&turbulence::TABLE), Means("still air"), "Gusts that it flies through: true motion beside its track.";
    }
    errors "[platform.errors]" "Known errors of what a platform reports: report minus truth. The same seed gives the same errors, in whole runs and in parts." {
        PRESET "preset", Choice(&["sps", "rtk", "tactical", "navigation"]), Means("no errors but those below"), "Class of navigation to start from: satellites, with carrier phase, aided tactical or navigation-grade inertial unit. The keys below stand above it.";
        RECORDED "recorded", Choice(&["truth", "reported"]), Word("truth"), "What the track is. truth: what happened, errors are added to the report. reported: what was reported, the true motion lies beside it; errors must then be smooth (bias, sinusoid, ramp, walk, Gauss-Markov of position and attitude).";
        RATE_HZ "rate_hz", number("Hz", 0.0, 1e5), Means("that of the preset, or 0: a report at every pulse"), "Reports per second from pulse 0 on.";
        LATENCY_S "latency_s", number("s", 0.0, 60.0), Means("that of the preset, or 0"), "From the epoch of a report to its arrival.";
        JITTER_S "jitter_s", number("s", 0.0, 10.0), default(0.0), "Standard deviation of the arrival (Gaussian). Time stamps are right.";
        BETWEEN "between", Choice(&["extrapolate", "hold"]), Word("extrapolate"), "Until the next report arrives: moved on with the reported velocity, or held.";
        DROPOUTS "dropouts", Section(&dropouts::TABLE), Means("none"), "Reports that are lost for a while.";
        LEVER_ARM_ERROR_M "lever_arm_error_m", vector("m", 3, 1e4), Zeros, "Error of the lever arm: forward, starboard, down.";
        POSITION "position", Section(&error_m::TABLE), Means("that of the preset, or none"), "Errors of the position.";
        VELOCITY "velocity", Section(&error_mps::TABLE), Means("that of the preset, or none"), "Errors of the velocity, beside the derivative of sinusoid and ramp of the position.";
        ATTITUDE "attitude", Section(&error_deg::TABLE), Means("that of the preset, or none"), "Errors of roll, pitch and heading.";
    }
    dropouts "[platform.errors.dropouts]" "Reports that are lost for a while: good reception and dropouts last for exponentially distributed times. Pulse 0 finds reception good." {
        PER_HOUR "per_hour", number("1/h", 0.0, 1e6), Required, "Dropouts per hour of good reception.";
        MEAN_S "mean_s", above("s", 0.0, 1e6), Required, "Mean length.";
        DURING "during", Choice(&["extrapolate", "hold"]), Word("extrapolate"), "What is reported meanwhile: the last report moved on with its velocity, or held.";
    }
    error_m "[platform.errors.position]" "Errors of the position: East, North, up." {
        BIAS_M "bias_m", vector("m", 3, FAR_M), Zeros, "Constant, exactly.";
        BIAS_SIGMA_M "bias_sigma_m", sizes("m", 1e6), Zeros, "Standard deviation of a constant that is drawn once.";
        WHITE_M "white_m", sizes("m", 1e6), Zeros, "Standard deviation of noise that is new in every report.";
        WALK_M_PER_ROOT_S "walk_m_per_root_s", sizes("m/sqrt(s)", 1e6), Zeros, "Random walk.";
        GM_SIGMA_M "gm_sigma_m", sizes("m", 1e6), Zeros, "Standard deviation of a first-order Gauss-Markov process.";
        GM_TAU_S "gm_tau_s", above("s", 0.0, 1e7), default(100.0), "Its correlation time.";
        SINUSOID_M "sinusoid_m", vector("m", 3, 1e6), Zeros, "Amplitude of a sinusoid.";
        SINUSOID_HZ "sinusoid_hz", number("Hz", 0.0, 1e4), default(0.1), "Its frequency.";
        SINUSOID_DEG "sinusoid_deg", number("deg", -360.0, 360.0), default(0.0), "Its phase at pulse 0.";
        STEP_M "step_m", vector("m", 3, FAR_M), Zeros, "Size of a step.";
        STEP_AT_S "step_at_s", number("s", -1e7, 1e7), default(0.0), "When, after pulse 0.";
        RAMP_MPS "ramp_mps", vector("m/s", 3, FAST_MPS), Zeros, "Growth from pulse 0 on.";
        QUANTISATION_M "quantisation_m", number("m", 0.0, 1e4), default(0.0), "What reported coordinates are whole multiples of; 0: nothing.";
    }
    error_mps "[platform.errors.velocity]" "Errors of the velocity: East, North, up." {
        BIAS_MPS "bias_mps", vector("m/s", 3, FAST_MPS), Zeros, "Constant, exactly.";
        BIAS_SIGMA_MPS "bias_sigma_mps", sizes("m/s", 1e4), Zeros, "Standard deviation of a constant that is drawn once.";
        WHITE_MPS "white_mps", sizes("m/s", 1e4), Zeros, "Standard deviation of noise that is new in every report.";
        WALK_MPS_PER_ROOT_S "walk_mps_per_root_s", sizes("m/s/sqrt(s)", 1e4), Zeros, "Random walk.";
        GM_SIGMA_MPS "gm_sigma_mps", sizes("m/s", 1e4), Zeros, "Standard deviation of a first-order Gauss-Markov process.";
        GM_TAU_S "gm_tau_s", above("s", 0.0, 1e7), default(100.0), "Its correlation time.";
        SINUSOID_MPS "sinusoid_mps", vector("m/s", 3, 1e4), Zeros, "Amplitude of a sinusoid.";
        SINUSOID_HZ "sinusoid_hz", number("Hz", 0.0, 1e4), default(0.1), "Its frequency.";
        SINUSOID_DEG "sinusoid_deg", number("deg", -360.0, 360.0), default(0.0), "Its phase at pulse 0.";
        STEP_MPS "step_mps", vector("m/s", 3, FAST_MPS), Zeros, "Size of a step.";
        STEP_AT_S "step_at_s", number("s", -1e7, 1e7), default(0.0), "When, after pulse 0.";
        RAMP_MPS2 "ramp_mps2", vector("m/s^2", 3, FAST_MPS), Zeros, "Growth from pulse 0 on.";
        QUANTISATION_MPS "quantisation_mps", number("m/s", 0.0, 1e3), default(0.0), "What reported components are whole multiples of; 0: nothing.";
    }
    error_deg "[platform.errors.attitude]" "Errors of the attitude: roll, pitch, heading (clockwise)." {
        BIAS_DEG "bias_deg", vector("deg", 3, 360.0), Zeros, "Constant, exactly.";
        BIAS_SIGMA_DEG "bias_sigma_deg", sizes("deg", 360.0), Zeros, "Standard deviation of a constant that is drawn once.";
        WHITE_DEG "white_deg", sizes("deg", 360.0), Zeros, "Standard deviation of noise that is new in every report.";
        WALK_DEG_PER_ROOT_S "walk_deg_per_root_s", sizes("deg/sqrt(s)", 360.0), Zeros, "Random walk.";
        GM_SIGMA_DEG "gm_sigma_deg", sizes("deg", 360.0), Zeros, "Standard deviation of a first-order Gauss-Markov process.";
        GM_TAU_S "gm_tau_s", above("s", 0.0, 1e7), default(100.0), "Its correlation time.";
        SINUSOID_AMPLITUDE_DEG "sinusoid_amplitude_deg", vector("deg", 3, 360.0), Zeros, "Amplitude of a sinusoid.";
        SINUSOID_HZ "sinusoid_hz", number("Hz", 0.0, 1e4), default(0.1), "Its frequency.";
        SINUSOID_DEG "sinusoid_deg", number("deg", -360.0, 360.0), default(0.0), "Its phase at pulse 0.";
        STEP_DEG "step_deg", vector("deg", 3, 360.0), Zeros, "Size of a step.";
        STEP_AT_S "step_at_s", number("s", -1e7, 1e7), default(0.0), "When, after pulse 0.";
        RAMP_DEGPS "ramp_degps", vector("deg/s", 3, 360.0), Zeros, "Growth from pulse 0 on.";
        QUANTISATION_DEG "quantisation_deg", number("deg", 0.0, 90.0), default(0.0), "What reported angles are whole multiples of; 0: nothing.";
    }
    turbulence "[platform.turbulence]" "Gusts of the Dryden model and an aircraft's answer. Exactly one of level and wind20_mps." {
        LEVEL "level", Choice(&["light", "moderate", "severe"]), Means("wind20_mps is given"), "A wind of 15, 30 or 45 knots at 20 ft.";
        WIND20_MPS "wind20_mps", number("m/s", 0.0, 100.0), Means("level is given"), "Wind at 20 ft (6.1 m) above the sea.";
        HEIGHT_M "height_m", number("m", 0.0, 1e5), Means("that of the platform at pulse 0"), "Height above the sea for which gusts are taken.";
        AIRSPEED_MPS "airspeed_mps", number("m/s", 5.0, 1e4), Means("the speed of the platform at pulse 0"), "Speed at which gusts are met.";
        CUTOFF_HZ "cutoff_hz", number("Hz", 0.05, 5.0), default(0.5), "Cut-off of the aircraft's answer: a low pass of second order.";
        VELOCITY_GAIN "velocity_gain", number("", 0.0, 10.0), default(1.0), "Velocity of the aircraft over that of slow gusts.";
        ATTITUDE_GAIN "attitude_gain", number("", 0.0, 10.0), default(1.0), "Angle by which the nose turns into slow gusts, over gust by airspeed.";
        TRACK_HOLD_S "track_hold_s", number("s", 0.0, 1e5), default(30.0), "Time in which it is steered back to its track; 0: it drifts.";
    }
    track "[platform.track] and [platform.reported]" "A trajectory." {
        KIND "kind", Choice(&["fixed", "straight", "csv", "nmea", "inspvax", "sbet", "live"]), Required, "Stays; straight line at constant speed; recorded track; what a receiver reports during the run (docs/navigation.md).";
        POSITION_M "position_m", vector("m", 3, FAR_M), Means("lat_deg, lon_deg and h_m are given"), "fixed, straight: East, North, up in the scene frame (tangent plane at the origin), at pulse 0.";
        LAT_DEG "lat_deg", number("deg", -90.0, 90.0), Means("position_m is given"), "fixed, straight: latitude, WGS-84.";
        LON_DEG "lon_deg", number("deg", -180.0, 360.0), Means("position_m is given"), "fixed, straight: longitude.";
        H_M "h_m", number("m", -11_000.0, FAR_M), Means("position_m is given"), "fixed, straight: height above the datum.";
        VELOCITY_MPS "velocity_mps", vector("m/s", 3, FAST_MPS), Required, "straight: velocity East, North, up.";
        YAW_DEG "yaw_deg", number("deg", -360.0, 360.0), Means("0; straight: along the velocity"), "Yaw clockwise from North. fixed, straight, and recordings with attitude = \"constant\".";
        PITCH_DEG "pitch_deg", number("deg", -90.0, 90.0), Means("0; straight: along the velocity"), "Pitch, nose up.";
        ROLL_DEG "roll_deg", number("deg", -180.0, 180.0), Means("0"), "Roll, right wing down.";
        PATH "path", File, Required, "Recordings: the file.";
        DATUM "datum", Choice(&["ellipsoid", "msl", "barometric"]), Means("required, but for position_m, for recordings of x_m, y_m, z_m in a scene without origin, and for inspvax and sbet, which say it; live: \"msl\""), "What heights are measured from: WGS-84 ellipsoid, mean sea level, or (recordings, live) standard pressure altitude. live: where the messages do not say.";
        BAROMETRIC_OFFSET_M "barometric_offset_m", number("m", -2000.0, 2000.0), default(0.0), "barometric: added to make a pressure altitude a height above mean sea level.";
        GPS_WEEK "gps_week", count(0, 8191), Required, "sbet: GPS week of the first record; the file has seconds of the week only. 2000 began on 2018-05-06.";
        MAX_GAP_S "max_gap_s", above("s", 0.0, 86_400.0), default(5.0), "Recordings, live: longest gap between fixes that is interpolated.";
        SMOOTHING "smoothing", Section(&smoothing::TABLE), Means("off"), "Recordings: how fixes become a smooth track.";
        ATTITUDE "attitude", Choice(&["recorded", "coordinated_turn", "level", "constant"]), Means("recorded where the fixes have it, otherwise coordinated_turn; `check` and `run` report which"), "Recordings, live: where the attitude comes from. coordinated_turn: derived from the motion, nose along the velocity, roll of a coordinated turn. level: the same with level wings. ADS-B and GGA carry none.";
        SOURCE "source", Kind::Origin, Required, "live: where its messages come from, NMEA 0183 and NovAtel INSPVAX: a serial port, somebody to connect to, an address to which a sender connects or sends datagrams, a file that is replayed in time.";
        BAUD "baud", count(50, 4_000_000), Count(115_200), "live, serial port: bits a second.";
        MAX_EXTRAPOLATION_S "max_extrapolation_s", above("s", 0.0, 86_400.0), default(1.0), "live: longest time after the last fix for which motion is extrapolated from it. Sentences come an epoch late: for a receiver of one epoch a second take 2.5.";
        TIMEOUT_S "timeout_s", number("s", 0.0, 86_400.0), default(30.0), "live: how long the begin of the run waits for navigation.";
        VEHICLE "vehicle", Choice(&["ship", "ground", "aircraft", "spacecraft"]), Word("aircraft"), "live: what carries the receiver. It sets the bounds of the plausibility gate: 40 m/s and 10 m/s^2 for a ship, 100 and 30 on the ground, 1000 and 100 in the air, 12000 and 100 in orbit.";
        MAX_SPEED_MPS "max_speed_mps", above("m/s", 0.0, FAST_MPS), Means("that of the vehicle"), "live: a fix that would need a higher speed is counted and refused.";
        MAX_ACCELERATION_MPS2 "max_acceleration_mps2", above("m/s^2", 0.0, 1e5), Means("that of the vehicle"), "live: a fix that would need a higher acceleration is counted and refused.";
        RESET_FIXES "reset_fixes", count(2, 1000), Count(5), "live: so many refused fixes in a row that agree with each other are believed after all.";
        NOMINAL "nominal", Section(&TABLE), Means("what needs the flight beforehand is left out"), "live: a track of another kind that stands for the flight in `check` and in `plan`.";
    }
    smoothing "[platform.track.smoothing]" "How fixes become a smooth track." {
        KIND "kind", Choice(&["off", "rts"]), Required, "Fixes are exact, or a Rauch-Tung-Striebel smoother.";
        HORIZONTAL_SIGMA_M "horizontal_sigma_m", number("m", 1e-4, 1e4), default(5.0), "rts: standard deviation of the horizontal position of a fix.";
        VERTICAL_SIGMA_M "vertical_sigma_m", number("m", 1e-4, 1e4), default(5.0), "rts: standard deviation of the height of a fix.";
        MAX_ACCELERATION_MPS2 "max_acceleration_mps2", number("m/s^2", 0.01, 1e3), default(3.0), "rts: bound on the acceleration of the track.";
    }
    transmitter "[[transmitter]]" "An antenna that radiates." {
        NAME "name", Name, Required, "Its name, unique among transmitters and receivers.";
        PLATFORM "platform", Name, Required, "The platform that carries it.";
        POWER_W "power_w", above("W", 0.0, 1e12), Required, "Peak power per polarisation.";
        LEVER_ARM_M "lever_arm_m", vector("m", 3, 1e4), Zeros, "Phase centre: forward, starboard, down from the platform's reference.";
        ANTENNA "antenna", Section(&antenna::TABLE), Required, "Gain pattern.";
        POINTING "pointing", Section(&pointing::TABLE), Means("fixed, all angles 0: along the nose"), "Where it points.";
        CROSS_POL_ISOLATION_DB "cross_pol_isolation_db", number("dB", 0.0, 200.0), Means("ideal ports"), "Leakage of the orthogonal port, dB below the wanted one.";
        CLOCK "clock", Section(&clock::TABLE), Means("a clock that is right"), "What is wrong with its clock.";
    }
    receiver "[[receiver]]" "An antenna that receives." {
        NAME "name", Name, Required, "Its name, unique among transmitters and receivers.";
        PLATFORM "platform", Name, Required, "The platform that carries it.";
        LEVER_ARM_M "lever_arm_m", vector("m", 3, 1e4), Zeros, "Phase centre: forward, starboard, down from the platform's reference.";
        ANTENNA "antenna", Section(&antenna::TABLE), Required, "Gain pattern.";
        POINTING "pointing", Section(&pointing::TABLE), Means("fixed, all angles 0: along the nose"), "Where it points.";
        CROSS_POL_ISOLATION_DB "cross_pol_isolation_db", number("dB", 0.0, 200.0), Means("ideal ports"), "Leakage of the orthogonal port, dB below the wanted one.";
        CLOCK "clock", Section(&clock::TABLE), Means("a clock that is right"), "What is wrong with its clock.";
    }
    antenna "antenna = { ... } of [[transmitter]] and [[receiver]]" "A gain pattern. Boresight +x, width along +y (horizontal), height along +z." {
        KIND "kind", Choice(&["isotropic", "rectangle", "ellipse", "circle", "file"]), Required, "Kind of aperture; apertures are uniformly illuminated. Ports H and V: of isotropic antennas level at the phase centre wherever they point, of all others Ludwig's third definition about the boresight (docs/polarisation.md).";
        GAIN_DBI "gain_dbi", number("dBi", -200.0, 200.0), default(0.0), "isotropic: gain in every direction.";
        WIDTH_M "width_m", above("m", 0.0, 1e4), Required, "rectangle, ellipse: full width.";
        HEIGHT_M "height_m", above("m", 0.0, 1e4), Required, "rectangle, ellipse: full height.";
        DIAMETER_M "diameter_m", above("m", 0.0, 1e4), Required, "circle: diameter.";
        PATH "path", File, Required, "file: CSV, columns az_deg,el_deg,gain_dbi[,phase_deg] on a regular grid.";
        FLOOR_DBI "floor_dbi", number("dBi", -400.0, 200.0), default(-60.0), "file: gain outside the grid.";
    }
    clock "[transmitter.clock] and [receiver.clock]" "A clock that is wrong: its reading minus the time of the run. Delays and phases are those of the difference of both ends." {
        SAME_AS "same_as", Name, Means("a clock of its own"), "The antenna, written above, whose clock it shares; other keys have no meaning then.";
        OFFSET_S "offset_s", number("s", -1.0, 1.0), default(0.0), "Reading minus time at pulse 0.";
        DRIFT "drift", number("", -1e-3, 1e-3), default(0.0), "Fractional frequency at pulse 0: 1e-9 gains a nanosecond a second.";
        AGEING_PER_DAY "ageing_per_day", number("1/day", -1e-3, 1e-3), default(0.0), "Growth of the fractional frequency in a day.";
        PRESET "preset", Choice(&["ocxo", "tcxo", "gpsdo", "rubidium"]), Means("no noise but that of noise_h"), "Noise of a kind of oscillator, Allan deviation at 1 s: 2e-12 and 1e-9 (flicker), 1e-11 and 2e-11 (white frequency).";
        NOISE_H "noise_h", Kind::Numbers { unit: "", least: 5, most: 5, min: 0.0, max: 1.0 }, Means("that of the preset, or none"), "h_-2, h_-1, h_0, h_1, h_2 of the one-sided spectrum of the fractional frequency, S_y(f) = sum of h_a f^a (1/Hz).";
        BANDWIDTH_HZ "bandwidth_hz", above("Hz", 0.0, 1e9), Means("half the pulse rate"), "Highest frequency of the phase noise of h_1 and h_2.";
    }
    pointing "pointing = { ... } of [[transmitter]] and [[receiver]]" "Where an antenna points." {
        KIND "kind", Choice(&["fixed", "at", "beside"]), Required, "Bolted to the body; servo on a point; servo on a point beside a platform.";
        YAW_DEG "yaw_deg", number("deg", -360.0, 360.0), default(0.0), "fixed: relative to the body, positive to starboard.";
        PITCH_DEG "pitch_deg", number("deg", -90.0, 90.0), default(0.0), "fixed: relative to the body, positive up.";
        ROLL_DEG "roll_deg", number("deg", -180.0, 180.0), default(0.0), "fixed: about the boresight.";
        POSITION_M "position_m", vector("m", 3, FAR_M), Means("lat_deg and lon_deg are given"), "at: East, North, height above the sea, at pulse 0.";
        LAT_DEG "lat_deg", number("deg", -90.0, 90.0), Means("position_m is given"), "at: latitude; the point lies on the sea.";
        LON_DEG "lon_deg", number("deg", -180.0, 360.0), Means("position_m is given"), "at: longitude.";
        VELOCITY_MPS "velocity_mps", vector("m/s", 3, FAST_MPS), Zeros, "at: velocity East, North, up.";
        PLATFORM "platform", Name, Required, "beside: the platform.";
        ALONG_M "along_m", number("m", -FAR_M, FAR_M), default(0.0), "beside: metres ahead along the ground track.";
        ACROSS_M "across_m", number("m", -FAR_M, FAR_M), Required, "beside: metres to starboard of the ground track, negative to port.";
        AIM_FROM "aim_from", Choice(&["reported", "true"]), Word("reported"), "at, beside: which tracks the servo knows.";
        LAG_S "lag_s", number("s", 0.0, 100.0), default(0.0), "at, beside: the servo acts on what was known this long ago.";
        BIAS_AZ_DEG "bias_az_deg", number("deg", -180.0, 180.0), default(0.0), "at, beside: constant misalignment about the antenna's z axis.";
        BIAS_EL_DEG "bias_el_deg", number("deg", -90.0, 90.0), default(0.0), "at, beside: constant misalignment about the antenna's y axis.";
    }
    sea "[sea]" "The sea on the patch of [scene]: wind, waves, water. Exactly one strength and one direction of the wind." {
        WIND_USTAR_MPS "wind_ustar_mps", number("m/s", 0.0, 3.0), Means("wind_mps is given"), "Strength of the wind as friction velocity in the profile.";
        WIND_MPS "wind_mps", number("m/s", 0.0, 40.0), Means("wind_ustar_mps is given"), "Strength of the wind as mean speed at wind_height_m. Below 0.3 m/s at 10 m the sea is flat.";
        WIND_HEIGHT_M "wind_height_m", number("m", 1.0, 100.0), default(10.0), "Height above the sea of wind_mps.";
        WIND_PROFILE "wind_profile", Choice(&["cardone", "wu"]), Word("cardone"), "Profile that carries the wind to other heights: Cardone 1969, or logarithmic with the drag of Wu 1982.";
        WIND_TOWARDS_DEG "wind_towards_deg", number("deg", -360.0, 360.0), Means("wind_from_deg is given"), "Direction in which the wind blows, counter-clockwise from East.";
        WIND_FROM_DEG "wind_from_deg", number("deg", -360.0, 360.0), Means("wind_towards_deg is given"), "Direction from which the wind blows, clockwise from North, as in a weather report.";
        SPECTRUM "spectrum", Choice(&["elfouhaily", "elfouhaily-fung-lee", "fung-lee", "pierson-moskowitz", "jonswap", "measured"]), Word("elfouhaily"), "Spectrum of the wind sea. elfouhaily-fung-lee: Elfouhaily's with the directions of Fung and Lee, as in the MaRS paper. measured: from a file, with the wind's waves beyond its last wave number.";
        INVERSE_WAVE_AGE "inverse_wave_age", number("", 0.84, 5.0), default(0.84), "elfouhaily, elfouhaily-fung-lee: 0.84 fully developed to 5 very young. At most one of inverse_wave_age and fetch_m.";
        FETCH_M "fetch_m", number("m", 100.0, 1e7), Means("inverse_wave_age decides; required with jonswap"), "elfouhaily, elfouhaily-fung-lee, jonswap: distance over which the wind has blown.";
        SPREADING "spreading", Choice(&["mitsuyasu", "elfouhaily", "constant"]), Word("mitsuyasu"), "pierson-moskowitz, jonswap: exponent s of the spreading cos^2s(phi/2) about the wind: Mitsuyasu's, that of Elfouhaily's upwind to crosswind ratio, or one for all waves.";
        SPREADING_EXPONENT "spreading_exponent", number("", 0.0, 1000.0), Required, "spreading = \"constant\": the exponent s.";
        SPECTRUM_PATH "spectrum_path", File, Required, "measured: CSV with the columns kx_rad_m,ky_rad_m,psi_m4 on a regular grid, K in the direction of travel.";
        SPECTRUM_TAIL "spectrum_tail", Choice(&["elfouhaily", "none"]), Word("elfouhaily"), "measured: the waves beyond the last wave number of the file: Elfouhaily's of this wind, joined to it, or none (a file without Bragg waves is then a sea without Bragg echo).";
        CAPILLARY "capillary", Kind::Flag, Flag(false), "Whether surface tension speeds up short waves.";
        DEPTH_M "depth_m", number("m", 0.1, 1e5), Means("deep water"), "Depth of the water, for the speed of the waves.";
        TEMPERATURE_C "temperature_c", number("C", -2.0, 34.0), default(20.0), "Temperature of the water; klein-swift holds from 0 to 30.";
        SALINITY_PSU "salinity_psu", number("psu", 0.0, 40.0), default(35.0), "Salinity, g/kg; klein-swift holds from 4 to 35.";
        PERMITTIVITY "permittivity", Choice(&["meissner-wentz", "klein-swift"]), Word("meissner-wentz"), "Model of the permittivity: Meissner and Wentz 2012 (1 to 90 GHz), Klein and Swift 1977 (1 to 10 GHz).";
        AVERAGING "averaging", Choice(&["automatic", "points", "cells"]), Word("automatic"), "How the spectrum is taken on the grid of wave numbers: at points, as means over cells, or means only where the grid is coarse for the spectrum.";
        STATE_PATH "state_path", File, Means("the waves are drawn from scene.seed"), "A saved sea of the same grid to start from.";
        SCATTERING "scattering", Section(&scattering::TABLE), Means("all defaults"), "How facets scatter.";
        SHADOW "shadow", Section(&shadow::TABLE), Means("all defaults"), "What waves hide.";
    }
    scattering "[sea.scattering]" "How facets scatter." {
        SPLITTING "splitting", Choice(&["consistent", "mars2007"]), Word("consistent"), "How waves are shared between specular points and Bragg scattering: each once, or all slopes and the whole spectrum on top of the tilts of the map, as in the MaRS paper.";
        PHASES "phases", Choice(&["polcoherent", "single"]), Word("polcoherent"), "Random phase of a facet: one for each mechanism, with the phases between polarisations kept, or a single one on the magnitudes.";
        CUT_RADPM "cut_radpm", above("rad/m", 0.0, 1e6), Means("that of the splitting"), "Wave number between the two mechanisms.";
        TILT_AVERAGE "tilt_average", Kind::Flag, Means("true; false for mars2007"), "consistent: whether the Bragg part averages over tilts within a facet, so that what the sea returns does not depend on the size of facets. Nine Bragg waves a facet instead of one.";
        LIGHT_WIND "light_wind", Choice(&["threshold", "published"]), Word("threshold"), "Bragg waves in light wind: none below the wind that sustains them against viscosity and never fewer in more wind, or those of the spectrum as published, of which a weak wind has more than a fresh one.";
        GRAM_CHARLIER "gram_charlier", Kind::Flag, Flag(false), "Whether slope densities have the skewness and peakedness of Cox and Munk.";
        DECORRELATION_MS "decorrelation_ms", above("ms", 0.0, 1e9), Means("never"), "Time in which a facet forgets its random phase.";
        DISPLACEMENT "displacement", Kind::Flag, Flag(true), "Whether facets follow the horizontal orbital motion of the waves; false: they move up and down only.";
    }
    shadow "[sea.shadow]" "What waves hide from a transmitter or a receiver." {
        ENABLED "enabled", Kind::Flag, Flag(true), "Whether anything is hidden.";
        EDGE "edge", Choice(&["soft", "sharp"]), Word("soft"), "Whether visibility falls smoothly at the edge of a shadow, or at once as in the MaRS paper.";
        WIDTH_RAD "width_rad", above("rad", 0.0, 1000.0), Means("half the rms change of slope over a facet, from the map"), "soft: angle above the horizon, as a tangent, over which a facet comes into full view.";
        RAYS_PER_FACET "rays_per_facet", count(1, 64), Count(2), "Rays per facet across the look direction.";
        UPDATE_MS "update_ms", number("ms", 0.1, 10_000.0), Means("the multiple of ten pulse intervals nearest to 20, at least ten"), "Time between updates; visibility is cross-faded in between.";
    }
    swell "[[swell]]" "A swell train. Exactly one direction." {
        SIGNIFICANT_HEIGHT_M "significant_height_m", number("m", 0.0, 30.0), Required, "Significant wave height.";
        PEAK_PERIOD_S "peak_period_s", number("s", 1.0, 40.0), Required, "Peak period.";
        TOWARDS_DEG "towards_deg", number("deg", -360.0, 360.0), Means("from_deg is given"), "Direction in which it travels, counter-clockwise from East.";
        FROM_DEG "from_deg", number("deg", -360.0, 360.0), Means("towards_deg is given"), "Direction from which it comes, clockwise from North.";
        SPREAD_DEG "spread_deg", number("deg", 3.0, 80.0), default(10.0), "Directional spread, circular standard deviation.";
        SHAPE "shape", Choice(&["gaussian", "jonswap"]), Word("gaussian"), "Shape in frequency.";
        RELATIVE_WIDTH "relative_width", number("", 0.01, 0.3), default(0.1), "gaussian: standard deviation over peak frequency.";
        PEAK_ENHANCEMENT "peak_enhancement", number("", 1.0, 50.0), Required, "jonswap: peak enhancement; swell has about 5 to 20.";
    }
    slick "[[slick]]" "A film on the water, at rest: an ellipse (centre_m, half_axes_m, direction_deg) or a polygon (corners_m)." {
        NAME "name", Name, Means("slick-<number>, counted from 0"), "Its name, unique among slicks.";
        CENTRE_M "centre_m", vector("m", 2, FAR_M), Means("corners_m is given"), "ellipse: centre, East and North.";
        HALF_AXES_M "half_axes_m", Kind::Numbers { unit: "m", least: 2, most: 2, min: 1e-3, max: FAR_M }, Required, "ellipse: half axes.";
        DIRECTION_DEG "direction_deg", number("deg", -360.0, 360.0), default(0.0), "ellipse: direction of the first axis, counter-clockwise from East.";
        CORNERS_M "corners_m", Kind::Points { unit: "m", least: 3, most: 1000, limit: FAR_M }, Means("centre_m is given"), "polygon: corners in turn, each [East, North].";
        RIM_M "rim_m", number("m", 0.0, 1e5), Means("one facet"), "Width over which the film thins out across its outline.";
        COVER "cover", number("", 0.0, 1.0), default(1.0), "Share of the water covered inside.";
        ELASTICITY_NPM "elasticity_npm", number("N/m", 0.0, 1.0), default(0.0255), "Dilational elasticity of the film; 0.0255 is oleyl alcohol.";
    }
    ship "[[ship]]" "A ship on a straight course at constant speed through water at rest: its waves, the water that it stirs. Exactly one direction." {
        NAME "name", Name, Means("ship-<number>, counted from 0"), "Its name, unique among ships.";
        HULL "hull", FileOr("wigley"), Required, "A description (.toml) or an offset table (.csv), see hulls/README.md; or the parabolic hull of Wigley.";
        LENGTH_M "length_m", number("m", 0.05, 1000.0), Means("that of the hull's file; required with \"wigley\""), "Length on the waterline to which the hull is scaled.";
        BEAM_M "beam_m", above("m", 0.0, 1000.0), Required, "wigley: beam, from a ten-thousandth of the length to the length.";
        DRAUGHT_M "draught_m", above("m", 0.0, 1000.0), Required, "wigley: draught, within the same bounds.";
        POSITION_M "position_m", vector("m", 2, FAR_M), Means("lat_deg and lon_deg are given"), "Midship at pulse 0, East and North.";
        LAT_DEG "lat_deg", number("deg", -90.0, 90.0), Means("position_m is given"), "Latitude of midship at pulse 0.";
        LON_DEG "lon_deg", number("deg", -180.0, 360.0), Means("position_m is given"), "Longitude.";
        HEADING_DEG "heading_deg", number("deg", -360.0, 360.0), Means("towards_deg is given"), "Direction in which it sails, clockwise from the North of the scene, as a compass has it.";
        TOWARDS_DEG "towards_deg", number("deg", -360.0, 360.0), Means("heading_deg is given"), "The same, counter-clockwise from East.";
        SPEED_MPS "speed_mps", number("m/s", 0.0, 100.0), Required, "Speed through the water.";
        WAKE "wake", Kind::Flag, Flag(true), "Whether it raises waves.";
        BAND_LIMIT_RADPM "band_limit_radpm", above("rad/m", 0.0, 1e6), Means("0.7 pi / facet_m"), "With wake: wave number above which its waves are left out.";
        WAKE_BRAGG "wake_bragg", Kind::Flag, Means("true below a carrier of 6 GHz"), "With wake: whether its waves above the band limit scatter by Bragg within facets, in a narrow V about its track.";
        TURBULENT "turbulent", Switched(&turbulent::TABLE), Flag(true), "Its turbulent wake, in which small waves are damped.";
        ECHO "echo", Kind::Flag, Flag(false), "Whether the scatterers of its hull's file return an echo.";
    }
    ais "[[ais]]" "Ships of a recorded AIS log, named mmsi-<number>: each sails straight on with the course and speed of its report nearest to the start. A log is a CSV with the columns Time (UTC), MMSI, Latitude_degrees, Longitude_degrees, COG_degrees, SOG_knots, and if it has them Length_metres, Beam_metres, Draught_metres. Needs an origin." {
        LOG "log", File, Required, "The log.";
        MMSI "mmsi", Kind::Numbers { unit: "", least: 1, most: 1000, min: 0.0, max: 999_999_999.0 }, Means("all vessels"), "Only these vessels; all of them must be in the log.";
        START_UTC "start_utc", Time, Means("scene.start_utc"), "Instant of the log at which pulse 0 is emitted.";
        HULL "hull", FileOr("wigley"), Means("\"wigley\""), "Hull of all of them, as in [[ship]].";
        LENGTH_M "length_m", number("m", 0.05, 1000.0), default(60.0), "Length of ships for which the log has none. Beam and draught of a Wigley hull are those of the log, or 0.134 and 0.043 of the length, as those of DTMB 5415.";
        MOST_AGE_S "most_age_s", number("s", 0.0, 1e6), default(180.0), "Vessels without a report so near to the start are left out.";
        LEAST_SPEED_MPS "least_speed_mps", number("m/s", 0.0, 100.0), default(0.5), "Slower vessels are left out: a ship at anchor raises no waves.";
        WITHIN_M "within_m", above("m", 0.0, FAR_M), default(20_000.0), "Vessels further from the origin at the start are left out.";
        WAKE "wake", Kind::Flag, Flag(true), "As in [[ship]].";
        WAKE_BRAGG "wake_bragg", Kind::Flag, Means("true below a carrier of 6 GHz"), "As in [[ship]].";
        TURBULENT "turbulent", Switched(&turbulent::TABLE), Flag(true), "As in [[ship]].";
    }
    turbulent "[ship.turbulent]" "The dark V behind a ship: width 4 B (x / 4 L)^(1/a) at a distance x from the stern, with length L and beam B." {
        SPREAD_EXPONENT "spread_exponent", number("", 4.0, 5.0), default(5.0), "Exponent a of the width.";
        DECAY_LENGTHS "decay_lengths", number("", 0.01, 1e4), default(20.0), "Distance over which the damping falls by a factor of e, in lengths of the ship.";
        WIND_RATIO "wind_ratio", number("", 0.0, 1.0), default(0.4), "Wind that raises the small waves in the middle of the wake, over the wind outside.";
    }
    target "[[target]]" "A point target on a straight course. Its strength is one of rcs_m2, rcs_dbsm, or a scattering matrix." {
        NAME "name", Name, Means("target-<number>, counted from 0"), "Its name, unique among targets.";
        POSITION_M "position_m", vector("m", 3, FAR_M), Means("lat_deg and lon_deg are given"), "East, North, height above the sea, at pulse 0.";
        LAT_DEG "lat_deg", number("deg", -90.0, 90.0), Means("position_m is given"), "Latitude.";
        LON_DEG "lon_deg", number("deg", -180.0, 360.0), Means("position_m is given"), "Longitude.";
        HEIGHT_M "height_m", number("m", -11_000.0, FAR_M), default(0.0), "With lat_deg and lon_deg: height above the sea.";
        VELOCITY_MPS "velocity_mps", vector("m/s", 3, FAST_MPS), Zeros, "Velocity East, North, up.";
        RCS_M2 "rcs_m2", number("m^2", 0.0, 1e12), Means("another strength is given"), "Radar cross section of a sphere or trihedral: HH and VV equal, no HV.";
        RCS_DBSM "rcs_dbsm", number("dBsm", -300.0, 120.0), Means("another strength is given"), "The same in dB over 1 m^2.";
        S_VV "s_vv", vector("m", 2, 1e6), Means("[0, 0]"), "Scattering matrix, [re, im], receive then transmit; |S|^2 is the radar cross section.";
        S_VH "s_vh", vector("m", 2, 1e6), Means("[0, 0]"), "Scattering matrix, received V, transmitted H.";
        S_HV "s_hv", vector("m", 2, 1e6), Means("[0, 0]"), "Scattering matrix, received H, transmitted V.";
        S_HH "s_hh", vector("m", 2, 1e6), Means("[0, 0]"), "Scattering matrix, HH.";
        CONVENTION "convention", Choice(&["fsa", "bsa"]), Word("fsa"), "Scattering matrix: forward-scatter alignment, or back-scatter alignment (the received basis seen from the antenna, a sphere is the unit matrix). S_fsa = diag(1, -1) S_bsa in the order v, h.";
    }
    target_grid "[[target_grid]]" "A field of equal point targets, named <name>-<east>-<north>." {
        NAME "name", Name, Means("grid-<number>, counted from 0"), "First part of the names.";
        POSITION_M "position_m", vector("m", 3, FAR_M), Means("lat_deg and lon_deg are given"), "Centre: East, North, height above the sea.";
        LAT_DEG "lat_deg", number("deg", -90.0, 90.0), Means("position_m is given"), "Latitude of the centre.";
        LON_DEG "lon_deg", number("deg", -180.0, 360.0), Means("position_m is given"), "Longitude of the centre.";
        HEIGHT_M "height_m", number("m", -11_000.0, FAR_M), default(0.0), "With lat_deg and lon_deg: height above the sea.";
        COUNT "count", Kind::Numbers { unit: "", least: 2, most: 2, min: 1.0, max: 1000.0 }, Required, "Targets eastward and northward, whole numbers.";
        SPACING_M "spacing_m", vector("m", 2, 1e6), Required, "Distance between neighbours, eastward and northward.";
        VELOCITY_MPS "velocity_mps", vector("m/s", 3, FAST_MPS), Zeros, "Velocity East, North, up.";
        RCS_M2 "rcs_m2", number("m^2", 0.0, 1e12), Means("rcs_dbsm is given"), "Radar cross section of each.";
        RCS_DBSM "rcs_dbsm", number("dBsm", -300.0, 120.0), Means("rcs_m2 is given"), "The same in dB over 1 m^2.";
    }
    event "[[event]]" "A change of what a platform reports, from a pulse on (docs/control.md). Exactly one of pulse and at_s." {
        PULSE "pulse", count(0, u64::MAX), Means("at_s is given"), "The first pulse that has it.";
        AT_S "at_s", number("s", 0.0, 1e7), Means("pulse is given"), "After pulse 0: the first pulse emitted then or later has it.";
        PLATFORM "platform", Name, Means("the only platform"), "Whose report.";
        CHANGE "change", Kind::Line, Required, "What changes, in the words of a control line: \"step position.up 5 m\", \"bias attitude.heading 0.3 deg\", \"ramp position.east 0.5 m/s\", \"dropout 2.5 s\", \"latency 250 ms\", \"clear\".";
    }
    fidelity "[fidelity]" "Speed against accuracy." {
        ECHO "echo", Choice(&["reference", "fast"]), Word("fast"), "reference: every pulse from its own scatterer paths, in f64. fast: blocks of pulses, paths at nodes and interpolated between them, in f32.";
        ERROR_DB "error_db", number("dB", -120.0, -20.0), default(-60.0), "fast: error allowed against the reference, worst pulse and channel. The keys below are chosen to keep it, but for those that are given.";
        NODE_PULSES "node_pulses", count(1, 21), Means("chosen for error_db"), "fast: pulses from one instant at which surface and paths are found to the next; 1: every pulse by itself, from exact paths.";
        SCATTER_PULSES "scatter_pulses", count(1, 21), Means("chosen for error_db"), "fast: pulses from one instant at which scattering is found to the next: node_pulses, or about half or a third of it.";
        GAIN_PULSES "gain_pulses", count(1, 21), Means("chosen for error_db"), "fast: pulses from one instant at which antenna gains are found to the next.";
        SIDELOBE_DB "sidelobe_db", number("dB", -400.0, 0.0), Means("chosen for error_db"), "fast: two-way gain below the peak of its antennas at which a tile of 16 x 16 facets is evaluated less often: paths and scattering at the ends of a block only (scattering in its middle, too, where facets turn away), gains at two thirds of the instants; -400: none is.";
        KERNEL_WIDTH "kernel_width", count(4, 8), Means("chosen for error_db"), "fast: cells over which a path is spread; about 20 dB a cell.";
        DOPPLER "doppler", Choice(&["mean", "shift", "taylor"]), Means("chosen for error_db"), "fast: Doppler within a pulse by its mean, by a shift of delay (linear sweeps), or to first order.";
    }
    stream "[stream]" "How pulses are released." {
        PACE "pace", Choice(&["realtime", "fast"]), Word("realtime"), "At their emission times plus the latency, or as soon as they are made.";
        POLICY "policy", Choice(&["stop", "slip", "drop"]), Word("stop"), "When generation cannot keep up: end with an error, stretch time, or drop pulses.";
        LATENCY_MS "latency_ms", number("ms", 1.0, 60_000.0), Means("500; with live navigation what its interpolation needs at the rate of its fixes, at least 500"), "Release minus emission time: how far ahead pulses are made.";
        PACER_PRIORITY "pacer_priority", Choice(&["realtime", "normal"]), Word("realtime"), "Whether the thread that releases pulses runs at real-time priority (SCHED_FIFO), where the system allows that; `nereus run` reports it.";
        PACER_CORE "pacer_core", count(0, 1023), Means("any"), "The core on which the thread that releases pulses asks to stay.";
        LOCK_MEMORY "lock_memory", Kind::Flag, Absent::Flag(false), "Whether the stream asks the system that its memory is never moved out (mlockall).";
        THREADS "threads", count(0, 1024), Count(0), "Threads that make pulses; 0: as many as the machine has.";
    }
    sink "[[sink]]" "A place where pulses go." {
        KIND "kind", Choice(&["hdf5", "plain", "vita49", "nav", "null"]), Required, "HDF5 recording; folder of plain files; VITA 49.2 over UDP (docs/wire.md); what a platform reports, on a port (docs/navigation.md); nowhere.";
        PATH "path", Output, Required, "hdf5: the file; plain: the folder.";
        SEGMENT_S "segment_s", number("s", 0.1, 1e7), Means("one file"), "hdf5: start a new file every so many seconds.";
        ADDRESS "address", Kind::Address, Word("127.0.0.1:4991"), "vita49: the receiver. Nothing leaves the machine unless this names another one.";
        BIND "bind", Kind::Address, Means("any free port"), "vita49: local address and port to send from.";
        MTU_BYTES "mtu_bytes", count(576, 65_535), Count(1500), "vita49: greatest IP packet; pulses are split to fit.";
        DEVICE "device", Output, Required, "nav: the path of a serial port or pseudo terminal, file:PATH, tcp://ADDRESS:PORT (somebody who listens there), or udp://ADDRESS:PORT.";
        BAUD "baud", count(50, 4_000_000), Count(115_200), "nav, serial port: bits a second.";
        PLATFORM "platform", Name, Means("the only platform"), "nav: the platform.";
        FORMAT "format", Choice(&["nmea", "inspvaxa", "inspvaxb"]), Word("nmea"), "nav: NMEA 0183; NovAtel INSPVAX, ASCII or binary.";
        SENTENCES "sentences", Words { least: 1, most: 7, entry: "GGA, RMC, VTG, HDT, ZDA, GST or PASHR" }, Means("[\"GGA\", \"RMC\"]"), "nav, nmea: sentences, in this order. Readers such as gpsd expect GGA, then RMC, and others behind.";
        RATE_HZ "rate_hz", above("Hz", 0.0, 1000.0), default(5.0), "nav: messages a second, one a pulse at most.";
        LATENCY_S "latency_s", number("s", 0.0, 10.0), default(0.0), "nav: how much later than its emission time a message leaves, in emission time.";
        QUEUE_PULSES "queue_pulses", count(1, 1 << 20), Means("two seconds of pulses, at least 64, at most 65536 or 256 MiB"), "Pulses that may wait for this sink.";
    }
}

impl Kind {
    /// What is allowed, in words.
    pub fn allowed(&self) -> String {
        let of = |unit: &str| if unit.is_empty() { String::new() } else { format!(" {unit}") };
        match self {
            Self::Number { unit, min, max, above } => {
                let (min, max) = (figure(*min), figure(*max));
                if *above {
                    format!("a number above {min}, up to {max}{}", of(unit))
                } else {
                    format!("a number from {min} to {max}{}", of(unit))
                }
            }
            Self::Numbers { unit, least, most, min, max } => {
                let entries = if least == most { format!("{least}") } else { format!("{least} to {most}") };
                format!("a list of {entries} numbers from {} to {}{}", figure(*min), figure(*max), of(unit))
            }
            Self::Points { unit, least, most, limit } => {
                let limit = figure(*limit);
                format!("a list of {least} to {most} pairs [x, y] from -{limit} to {limit}{}", of(unit))
            }
            Self::Count { min, max } if *max == u64::MAX => format!("a whole number from {min} to 2^64 - 1"),
            Self::Count { min, max } => format!("a whole number from {min} to {max}"),
            Self::Flag => "true or false".to_owned(),
            Self::Choice(words) => {
                let words: Vec<String> = words.iter().map(|w| format!("\"{w}\"")).collect();
                words.join(", ")
            }
            Self::Words { least, most, entry } => format!("a list of {least} to {most} texts, each {entry}"),
            Self::PolarisationPair => {
                "two letters, receive then transmit polarisation, each H, V, R or L".to_owned()
            }
            Self::Name => {
                "a name of 1 to 64 letters, digits, '_', '-', '.', not starting with '.'".to_owned()
            }
            Self::Line => "a text of one line".to_owned(),
            Self::Time => "a UTC time from 1970 to 2200 such as \"2018-05-30T20:15:00.5Z\"".to_owned(),
            Self::File => "a file that exists (relative to the scenario file)".to_owned(),
            Self::TimeOr(word) => {
                format!("\"{word}\", or a UTC time from 1970 to 2200 such as \"2018-05-30T20:15:00.5Z\"")
            }
            Self::Output => "a path (relative to the working directory)".to_owned(),
            Self::Origin => {
                "the path of a serial port, tcp://ADDRESS:PORT, tcp-listen://ADDRESS:PORT or udp://ADDRESS:PORT such as \
                 udp://127.0.0.1:5001, or file:PATH (relative to the scenario file)"
                    .to_owned()
            }
            Self::Address => {
                "host:port with a port from 1 to 65535, such as \"127.0.0.1:4991\" or \"[::1]:4991\""
                    .to_owned()
            }
            Self::FileOr(word) => {
                format!("\"{word}\", or a file that exists (relative to the scenario file)")
            }
            Self::Section(table) => format!("a table {}", table.heading),
            Self::Switched(table) => format!("a table {}, true or false", table.heading),
            Self::Sections(table) => format!("an array of tables {}", table.heading),
        }
    }

    /// The unit, where there is one.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Number { unit, .. } | Self::Numbers { unit, .. } | Self::Points { unit, .. } => unit,
            _ => "",
        }
    }
}

impl Absent {
    /// For the manual.
    pub fn text(&self) -> String {
        match self {
            Self::Required => "required".to_owned(),
            Self::Number(value) => figure(*value),
            Self::Count(value) => value.to_string(),
            Self::Flag(value) => value.to_string(),
            Self::Word(word) => format!("\"{word}\""),
            Self::Zeros => "zeros".to_owned(),
            Self::Means(words) => (*words).to_owned(),
        }
    }
}

/// A number as one would write it in a scenario.
pub(super) fn figure(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) { format!("{value:e}") } else { format!("{value}") }
}
