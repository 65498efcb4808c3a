//! Where the antennas of a channel point by the scenario of a recording, and what that gains towards a point.

use super::focus::Described;
use crate::frames::{Enu, Point, Vector};
use crate::motion::PlatformTracks;
use crate::motion::pointing::{PhaseCentre, Surroundings};
use crate::radar::antenna::Antenna;
use crate::recording::Recording;
use crate::scene::Scene;
use crate::scene::radar::AntennaMount;

/// The antennas of a channel.
pub struct TwoWayGain<'a> {
    scene: &'a Scene,
    tracks: &'a [PlatformTracks],
    ends: [(&'a AntennaMount, Antenna); 2],
    /// Time zero of the recording's paths after the emission of pulse 0, s.
    zero_s: f64,
}

impl<'a> TwoWayGain<'a> {
    /// From what the scenario in a recording describes and the tracks of its platforms; none where an antenna
    /// is not in it, or is a file that is not there.
    pub fn of(
        recording: &Recording,
        Described { scene, .. }: Described<'a>,
        tracks: &'a [PlatformTracks],
        channel: usize,
    ) -> Option<Self> {
        let row = recording.header.channels.get(channel)?;
        let open = |name: &str| {
            let mount = scene.radar.antenna(name)?;
            Some((mount, Antenna::open(&mount.pattern, scene.radar.wavelength_m()).ok()?))
        };
        let ends = [open(&row.transmitter)?, open(&row.receiver)?];
        Some(Self { scene, tracks, ends, zero_s: -pulse_zero_s(recording, scene)? })
    }

    /// Mean over pulses (times of the recording's paths) of the product of both field gains towards a point,
    /// ENU, m; none where a track does not reach so far. Both directions at the emission: the receiver turns
    /// by next to nothing in the time that an echo takes.
    pub fn mean(&self, times_s: &[f64], point_m: [f64; 3]) -> Option<f64> {
        let surroundings =
            Surroundings { tracks: self.tracks, frame: &self.scene.frame, start: self.scene.start };
        let [x, y, z] = point_m;
        let target: Point<Enu> = Point::new(x, y, z);
        let mut sum = 0.0;
        for time_s in times_s {
            let t = self.scene.start.plus(self.zero_s + time_s);
            let mut both = 1.0;
            for (mount, antenna) in &self.ends {
                let state = self.tracks.get(mount.platform)?.truth.state(t).ok()?;
                let frame = surroundings.antenna_frame(mount, state.attitude, [t; 2]).ok()?;
                let from = PhaseCentre::of(&state, mount.lever_arm).position;
                let away = (target.raw() - from.raw()).normalize_or_zero().to_array();
                let direction = frame.inverse() * Vector::new(away[0], away[1], away[2]);
                both *= antenna.field_gain(direction).norm();
            }
            sum += both;
        }
        Some(sum / times_s.len().max(1) as f64)
    }
}

/// Emission of pulse 0 on the clock of a recording's paths, s.
pub(super) fn pulse_zero_s(recording: &Recording, scene: &Scene) -> Option<f64> {
    let (first, at_s) = (recording.index.first()?, recording.emission_s.first()?);
    Some(at_s - scene.radar.emissions.interval_s(0, *first))
}
