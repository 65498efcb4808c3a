//! What is legal about a scenario, and should be known.

use std::path::PathBuf;

use thiserror::Error;

use crate::nav::ais::PassedOver;

impl Warning {
    /// Whether it is of where pulses go, and nothing to who records none.
    pub fn is_of_sinks(&self) -> bool {
        matches!(self, Self::NoSink | Self::NoHdf5 { .. })
    }
}

/// Something legal that the user should know.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// No sink at all.
    #[error("no [[sink]]: pulses are counted and forgotten")]
    NoSink,
    /// HDF5 asked of a build without it.
    #[error(
        "this build has no HDF5 (feature `hdf5`): {} is recorded as the plain folder {}{}",
        asked.display(), taken.display(), if *segmented { ", in one piece" } else { "" }
    )]
    NoHdf5 {
        /// The file asked for.
        asked: PathBuf,
        /// The folder taken.
        taken: PathBuf,
        /// Whether segments were asked for.
        segmented: bool,
    },
    /// A recording whose name says another format.
    #[error(
        "{} becomes a recording of kind = \"{kind}\", whatever its name says: one that ends in .h5 or .crsd chooses that format, \
         any other keeps the sink's",
        path.display()
    )]
    Misnamed {
        /// The recording.
        path: PathBuf,
        /// Its format.
        kind: &'static str,
    },
    /// An antenna that no channel uses.
    #[error("no channel uses the {what} \"{name}\"")]
    Unused {
        /// Transmitter or receiver.
        what: &'static str,
        /// Its name.
        name: String,
    },
    /// Ports that transmit together and are no pair.
    #[error(
        "\"{transmitter}\" transmits in {ports} with every pulse, which are not orthogonal: no receiver could tell their echoes \
         apart; channels of H and V, or of R and L, or tx_polarisation = \"alternating\""
    )]
    NotOrthogonal {
        /// The transmitter.
        transmitter: String,
        /// Its transmit polarisations.
        ports: String,
    },
    /// A slick that no facet has.
    #[error("slick \"{name}\" lies outside the patch of sea: no facet has it")]
    SlickOutside {
        /// Its name.
        name: String,
    },
    /// A slick that is cut.
    #[error("slick \"{name}\" reaches beyond the patch of sea: only what lies inside is modelled")]
    SlickCut {
        /// Its name.
        name: String,
    },
    /// Settings of the fast echo together with the reference.
    #[error("without effect on the reference echo: {keys}; fidelity.echo = \"fast\" heeds them")]
    IdleSettings {
        /// The keys.
        keys: String,
    },
    /// Receive windows that overlap.
    #[error(
        "windows of {window_us} us are longer than the shortest pulse interval of {pri_us} us: they overlap, and a receiver \
         would have to take the same instants twice"
    )]
    OverlappingWindows {
        /// Length of the window, us.
        window_us: f64,
        /// The shortest interval, us.
        pri_us: f64,
    },
    /// Swell that breaks long before it is so high.
    #[error(
        "{key}: {height_m} m in waves of {length_m:.1} m: water breaks at a seventh of the length, and no sea has a significant \
         height of more than {allowed_m:.2} m there"
    )]
    SteepSwell {
        /// The key.
        key: String,
        /// Significant height, m.
        height_m: f64,
        /// Length of the waves at the peak, m.
        length_m: f64,
        /// What seas reach, m.
        allowed_m: f64,
    },
    /// A band that no chirp has.
    #[error(
        "a band of {bandwidth_hz} Hz in a pulse of {pulse_us} us is less than one cycle: the pulse is not compressed, and \
         resolves {cell_m:.0} m; is bandwidth_hz in Hz?"
    )]
    NarrowBand {
        /// Bandwidth, Hz.
        bandwidth_hz: f64,
        /// Length of the pulse, us.
        pulse_us: f64,
        /// What it resolves in range, m.
        cell_m: f64,
    },
    /// A place that would be near with its coordinates exchanged.
    #[error(
        "{key}: {lat_deg} deg, {lon_deg} deg lies far from the origin of the scene, and near it with latitude and longitude swapped"
    )]
    Swapped {
        /// The key of the latitude.
        key: String,
        /// Latitude, degrees.
        lat_deg: f64,
        /// Longitude, degrees.
        lon_deg: f64,
    },
    /// Rows of an AIS log that say less than a report.
    #[error("{log}: {reports} position reports; passed over: {passed_over}")]
    AisPassedOver {
        /// The log.
        log: String,
        /// Its reports.
        reports: usize,
        /// What is none, or says too little.
        passed_over: PassedOver,
    },
    /// Vessels that follow their reports.
    #[error(
        "{log}: {refused} reports left out for which vessels would have to turn or run faster than they can \
         (max_turn_degps); {stopping} vessels left out that stop on their way, {silent} whose reports leave more than most_age_s \
         of the run open"
    )]
    AisFollowed {
        /// The log.
        log: String,
        /// Reports that no vessel can have made.
        refused: usize,
        /// Vessels that stop.
        stopping: usize,
        /// Vessels whose reports do not cover the run.
        silent: usize,
    },
    /// A recording of the track of a ship or a target that was not taken as it is.
    #[error("{key}: {report}")]
    TrackNoted {
        /// The key of its path.
        key: String,
        /// What became of it.
        report: String,
    },
    /// An aperture that is none.
    #[error(
        "the aperture of \"{antenna}\", {width_m} m x {height_m} m, is smaller than half a wavelength ({half_m:.4} m): the gain \
         of a uniform aperture, 4 pi A / lambda^2, does not hold; use an isotropic antenna or a measured pattern"
    )]
    SmallAperture {
        /// The transmitter or receiver.
        antenna: String,
        /// Width, m.
        width_m: f64,
        /// Height, m.
        height_m: f64,
        /// Half a wavelength, m.
        half_m: f64,
    },
    /// A target that moves into the water.
    #[error(
        "target \"{target}\" moves on a straight line below the sea: {depth_m:.3} m deep {time_s:.3} s after pulse 0"
    )]
    Submerges {
        /// The target.
        target: String,
        /// Its greatest depth, m.
        depth_m: f64,
        /// When, s after pulse 0.
        time_s: f64,
    },
    /// The ring cannot hold the latency.
    #[error(
        "the latency needs {wanted} buffered pulses; {slots} fit in {mebibytes} MiB: pulses are made {slots} ahead"
    )]
    ShortRing {
        /// Slots for the whole latency.
        wanted: u64,
        /// Slots taken.
        slots: usize,
        /// Memory they take, MiB.
        mebibytes: u64,
    },
}
