//! Where antennas point by the scenario of a recording, and what that gains towards a point.

use crate::config;
use crate::frames::{Enu, Point, Vector};
use crate::motion::PlatformTracks;
use crate::motion::pointing::{PhaseCentre, Surroundings};
use crate::pipeline::build;
use crate::radar::antenna::Antenna;
use crate::recording::Recording;
use crate::scene::Scene;
use crate::scene::radar::AntennaMount;

/// The antennas of a channel.
pub(super) struct Aim {
    scene: Scene,
    tracks: Vec<PlatformTracks>,
    ends: [(AntennaMount, Antenna); 2],
    /// Time zero of the recording's paths after the emission of pulse 0, s.
    zero_s: f64,
}

impl Aim {
    /// From the scenario in a recording; none where that is not there or names files that are not.
    pub fn of(recording: &Recording, channel: usize) -> Option<Self> {
        let run = config::parse(&recording.header.config, "scenario".as_ref(), &[]).ok()?;
        let tracks = build::tracks(&run.nav, &run.scene).ok()?.0;
        let row = recording.header.channels.get(channel)?;
        let radar = &run.scene.radar;
        let transmitter = radar.transmitters.iter().find(|t| t.name == row.transmitter)?.antenna.clone();
        let receiver = radar.receivers.iter().find(|r| r.name == row.receiver)?.antenna.clone();
        let open = |mount: AntennaMount| {
            let antenna = Antenna::open(&mount.pattern, radar.wavelength_m()).ok()?;
            Some((mount, antenna))
        };
        let ends = [open(transmitter)?, open(receiver)?];
        let (first, at_s) = (recording.index.first()?, recording.emission_s.first()?);
        let zero_s = radar.emissions.interval_s(0, *first) - at_s;
        Some(Self { scene: run.scene, tracks, ends, zero_s })
    }

    /// Mean over pulses (times of the recording's paths) of the product of both field gains towards a point,
    /// ENU, m; none where a track does not reach so far. Both directions at the emission: the receiver turns
    /// by next to nothing in the time that an echo takes.
    pub fn gain(&self, times_s: &[f64], point_m: [f64; 3]) -> Option<f64> {
        let surroundings =
            Surroundings { tracks: &self.tracks, frame: &self.scene.frame, start: self.scene.start };
        let [x, y, z] = point_m;
        let target: Point<Enu> = Point::new(x, y, z);
        let mut sum = 0.0;
        for time_s in times_s {
            let t = self.scene.start.plus(self.zero_s + time_s);
            let mut both = 1.0;
            for (mount, antenna) in &self.ends {
                let state = self.tracks.get(mount.platform)?.truth.state(t).ok()?;
                let frame = surroundings.antenna_frame(mount, state.attitude, t).ok()?;
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
