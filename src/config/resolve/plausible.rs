//! What a scenario cannot mean, and what it hardly means.
//!
//! Impossible is a fault: pulses that overlap, a target in the water. Legal but suspicious is a warning:
//! windows that overlap, a chirp of less than a cycle, an aperture below half a wavelength, latitude and
//! longitude swapped, a target that its straight course leads below the sea. What needs trajectories is
//! evaluated where these are made (`pipeline::plausible`).

use super::Ground;
use crate::config::error::{Problem, Warning};
use crate::config::keys::{self, Key};
use crate::config::section::Section;
use crate::frames::{Enu, Geodetic, Point};
use crate::scene::Target;
use crate::scene::radar::{AntennaMount, Pattern, Waveform};
use crate::time::PulseTimes;
use crate::units::{SPEED_OF_LIGHT_MPS, neat};

/// Depth that is rounding, m: coordinates reach 1e8 m.
const ROUNDING_M: f64 = 1e-6;
/// Instants of a course at which its height is looked at.
const INSTANTS: u32 = 64;

/// Intervals between pulses against the pulse and the window.
pub(super) fn intervals(
    radar: &Section<'_>,
    emissions: Option<&PulseTimes>,
    pulse_s: Option<f64>,
    window_s: Option<f64>,
) {
    use keys::radar::{PRF_HZ, PRI_US};
    let Some(pri_s) = emissions.map(PulseTimes::shortest_pri_s) else { return };
    // A frequency is written in place of its period.
    let longer = |span_s: &f64| *span_s > pri_s * (1.0 + 1e-9);
    if let Some(pulse_s) = pulse_s.filter(longer) {
        let key = if radar.has(&PRI_US) { &PRI_US } else { &PRF_HZ };
        radar.fault(
            key,
            Problem::ShortInterval { pri_us: microseconds(pri_s), pulse_us: microseconds(pulse_s) },
        );
    } else if let Some(window_s) = window_s.filter(longer) {
        let (window_us, pri_us) = (microseconds(window_s), microseconds(pri_s));
        radar.reader().warn(Warning::OverlappingWindows { window_us, pri_us });
    }
}

/// A chirp against the length of its pulse.
pub(super) fn band(radar: &Section<'_>, waveform: Option<&Waveform>) {
    for pulse in waveform.map_or(&[][..], Waveform::pulses) {
        let &Waveform::Lfm { bandwidth_hz, duration_s, .. } = pulse.level() else { continue };
        if bandwidth_hz * duration_s >= 1.0 - 1e-9 {
            continue;
        }
        let cell_m = 0.5 * SPEED_OF_LIGHT_MPS * duration_s;
        radar.reader().warn(Warning::NarrowBand { bandwidth_hz, pulse_us: microseconds(duration_s), cell_m });
        // Once: many may be alike.
        return;
    }
}

/// Whether a place would be near the origin with latitude and longitude exchanged, and is not.
pub(super) fn swapped(ground: &Ground, place: Geodetic) -> bool {
    ground.frame.origin().is_some_and(|origin| place.looks_swapped(origin))
}

/// Warns of such a place, given by a key.
pub(super) fn swap(section: &Section<'_>, lat: &'static Key, place: Geodetic, ground: &Ground) {
    if swapped(ground, place) {
        let [lat_deg, lon_deg] = [place.lat_rad, place.lon_rad].map(|angle| neat(angle.to_degrees()));
        section.reader().warn(Warning::Swapped { key: section.path_of(lat.name), lat_deg, lon_deg });
    }
}

/// Microseconds without the digits that a division leaves.
fn microseconds(seconds: f64) -> f64 {
    (seconds * 1e12).round() / 1e6
}

/// Sides of apertures against the wavelength.
pub(super) fn apertures<'a>(
    root: &Section<'_>,
    carrier_hz: f64,
    antennas: impl Iterator<Item = (&'a String, &'a AntennaMount)>,
) {
    let half_m = 0.5 * SPEED_OF_LIGHT_MPS / carrier_hz;
    for (antenna, mount) in antennas {
        let (Pattern::Rectangle { width_m, height_m }
        | Pattern::Tapered { width_m, height_m, .. }
        | Pattern::Ellipse { width_m, height_m }) = mount.pattern
        else {
            continue;
        };
        if width_m < half_m || height_m < half_m {
            let antenna = antenna.clone();
            root.reader().warn(Warning::SmallAperture { antenna, width_m, height_m, half_m });
        }
    }
}

/// Height above the sea, m.
fn height_m(position: Point<Enu>, ground: &Ground) -> f64 {
    let [x_m, y_m, z_m] = position.to_array();
    z_m + ground.frame.earth().drop_m(x_m, y_m)
}

/// The place of a target at pulse 0, given by one of two keys.
pub(super) fn target(
    section: &Section<'_>,
    [local, geodetic]: [&'static Key; 2],
    position: Point<Enu>,
    ground: &Ground,
) {
    let depth_m = -height_m(position, ground);
    if depth_m > ROUNDING_M {
        let key = if section.has(local) { local } else { geodetic };
        section.fault(key, Problem::BelowSea { depth_m });
    }
}

/// The courses of all targets.
pub(super) fn targets(
    root: &Section<'_>,
    ground: &Ground,
    targets: Option<&[Target]>,
    duration_s: Option<f64>,
) {
    let (Some(targets), Some(duration_s)) = (targets, duration_s) else { return };
    for target in targets.iter().filter(|target| target.fastest_mps() > 0.0) {
        let at = |step: u32| {
            let time_s = duration_s * f64::from(step) / f64::from(INSTANTS);
            (-height_m(target.at(time_s).0, ground), time_s)
        };
        let deepest = (0..=INSTANTS).map(at).max_by(|a, b| a.0.total_cmp(&b.0));
        // A boat on a curved earth leaves the surface by millimetres.
        if let Some((depth_m, time_s)) = deepest.filter(|(depth_m, _)| *depth_m > 0.1) {
            root.reader().warn(Warning::Submerges { target: target.name.clone(), depth_m, time_s });
        }
    }
}
