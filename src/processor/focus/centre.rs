//! The middle of an image that names none: where the radar looks.

use crate::recording::Recording;
use crate::scene::Scene;
use crate::scene::radar::{Aim, Gate, Pointing};
use crate::scene::sea::PatchPlace;

/// Where receive window or antennas of a channel look at a pulse in use, East and North, m: what the window
/// follows, else what the receiver aims at, else what the transmitter aims at, else the middle of a patch
/// that stays where it is, else the origin.
pub(super) fn centre_m(recording: &Recording, scene: &Scene, channel: usize, pulse: usize) -> [f64; 2] {
    let radar = &scene.radar;
    let window = match &radar.window.gate {
        Gate::Follow { aim, .. } => Some(aim),
        Gate::Fixed { .. } => None,
    };
    let antenna = |name: &String| match &radar.antenna(name)?.pointing {
        Pointing::At { aim, .. } => Some(aim),
        Pointing::Fixed { .. } => None,
    };
    let row = recording.header.channels.get(channel);
    let ends = row.into_iter().flat_map(|row| [&row.receiver, &row.transmitter]);
    let aims = window.into_iter().chain(ends.filter_map(antenna));
    let aimed = aims.filter_map(|aim| aim_point_m(aim, recording, scene, pulse)).next();
    let still = scene.sea.as_ref().filter(|sea| sea.place == PatchPlace::Fixed).map(|sea| &sea.patch);
    let middle = |axis: usize| {
        still
            .map_or(0.0, |patch| (patch.first[axis] + (patch.facets[axis] / 2) as i64) as f64 * patch.facet_m)
    };
    aimed.unwrap_or_else(|| [0, 1].map(middle))
}

/// A point of the scene, or one beside a platform; none beside one at rest.
fn aim_point_m(aim: &Aim, recording: &Recording, scene: &Scene, pulse: usize) -> Option<[f64; 2]> {
    match aim {
        Aim::Point { position, velocity } => {
            let since_s = scene.radar.emissions.interval_s(0, *recording.index.get(pulse)?);
            let ([x, y, _], [vx, vy, _]) = (position.to_array(), velocity.to_array());
            Some([x + vx * since_s, y + vy * since_s])
        }
        Aim::Beside { platform, along_m, across_m } => {
            let name = scene.platforms.get(*platform)?;
            let ([x, y, _], [vx, vy, _]) = recording.reported_state(name, pulse).ok()?;
            let speed = vx.hypot(vy);
            let (ahead_x, ahead_y) = (vx / speed, vy / speed);
            (speed >= 1e-3).then(|| {
                [x + ahead_x * along_m + ahead_y * across_m, y + ahead_y * along_m - ahead_x * across_m]
            })
        }
    }
}
