//! Where receive window and antennas look by the recording's description of the radar: the middle of an image
//! that names none, and boresights where the true ones are not recorded.

use glam::{DQuat, DVec3};

use crate::frames::{Earth, Rotation, SceneFrame, Vector};
use crate::geometry::phase_path::PhasePath;
use crate::motion::pointing::{fixed_mount, ground_track};
use crate::recording::instrument::{Instrument, Look};
use crate::recording::{Recording, RecordingError};

/// Where receive window or antennas of a channel look at a pulse in use, East and North, m: what the window
/// follows, else what the receiver aims at, else what the transmitter aims at, else the middle of the scene.
pub(super) fn centre_m(
    recording: &Recording,
    instrument: &Instrument,
    channel: usize,
    pulse: usize,
) -> [f64; 2] {
    let row = recording.header.channels.get(channel);
    let ends = row.into_iter().flat_map(|row| [&row.receiver, &row.transmitter]);
    let antennas = ends.filter_map(|name| Some(&instrument.antenna(name)?.look));
    let aimed = instrument.window.iter().chain(antennas).find_map(|look| aim_m(look, recording, pulse));
    aimed.unwrap_or(instrument.middle_m)
}

/// A point of the scene, or one beside a platform; none beside one at rest.
fn aim_m(look: &Look, recording: &Recording, pulse: usize) -> Option<[f64; 2]> {
    match look {
        Look::Body { .. } | Look::Scan { .. } => None,
        Look::Point { position_m: [x, y, _], velocity_mps: [vx, vy, _] } => {
            let since_s = recording.since_start_s(pulse);
            Some([x + vx * since_s, y + vy * since_s])
        }
        Look::Beside { platform, along_m, across_m } => {
            let ([x, y, _], [vx, vy, _]) = recording.reported_state(platform, pulse).ok()?;
            let speed = vx.hypot(vy);
            let (ahead_x, ahead_y) = (vx / speed, vy / speed);
            (speed >= 1e-3).then(|| {
                [x + ahead_x * along_m + ahead_y * across_m, y + ahead_y * along_m - ahead_x * across_m]
            })
        }
    }
}

/// Boresight of an antenna in each pulse in use by what platforms report, unit vectors, ENU; none of an
/// antenna that is not described. What a servo lags or is misaligned by is not in it.
pub(super) fn boresights(
    recording: &Recording,
    instrument: &Instrument,
    (name, path): (&str, &PhasePath),
) -> Result<Option<Vec<[f64; 3]>>, RecordingError> {
    let Some(antenna) = instrument.antenna(name) else { return Ok(None) };
    let frame = SceneFrame::plain(Earth::of_radius_factor(instrument.earth_radius_factor));
    let attitude = |platform: &str, pulse: usize| {
        let [w, x, y, z] = recording.reported_attitude(platform, pulse)?;
        Ok::<_, RecordingError>(Rotation::from_raw(DQuat::from_xyzw(x, y, z, w)))
    };
    let ahead = |pulse: usize| -> Result<DVec3, RecordingError> {
        let target = match &antenna.look {
            Look::Body { yaw_rad, pitch_rad, roll_rad } => {
                let axes = fixed_mount(*yaw_rad, *pitch_rad, *roll_rad);
                return Ok(axes.then(attitude(&antenna.platform, pulse)?).raw() * DVec3::X);
            }
            Look::Scan { level, .. } => {
                let [az, el] = recording.encoder_rad(name, pulse)?;
                let pedestal = fixed_mount(az, el, 0.0);
                let stands = if *level {
                    Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0)
                } else {
                    attitude(&antenna.platform, pulse)?
                };
                return Ok(pedestal.then(stands).raw() * DVec3::X);
            }
            Look::Point { position_m, velocity_mps } => {
                DVec3::from(*position_m) + DVec3::from(*velocity_mps) * recording.since_start_s(pulse)
            }
            Look::Beside { platform, along_m, across_m } => {
                let (position_m, velocity_mps) = recording.reported_state(platform, pulse)?;
                let velocity = Vector::from_raw(DVec3::from(velocity_mps));
                let along = ground_track(velocity, attitude(platform, pulse)?);
                let starboard = DVec3::new(along.y, -along.x, 0.0);
                let p = DVec3::from(position_m) + along * *along_m + starboard * *across_m;
                frame.above_sea(p.x, p.y, 0.0).raw()
            }
        };
        let from = DVec3::from(path.at(recording.emission_s[pulse]));
        Ok((target - from).try_normalize().unwrap_or(DVec3::NAN))
    };
    let all = (0..recording.pulses()).map(|pulse| ahead(pulse).map(|ahead| ahead.to_array()));
    all.collect::<Result<_, _>>().map(Some)
}
