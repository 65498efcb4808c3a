//! What the page knows of a run before the first pulse.

use serde_json::{Value, json};

use super::footprint::Outline;
use super::ppi::Ppi;
use crate::pulse::PlatformRecord;
use crate::radar::antenna::Antenna;
use crate::recording::header::Header;
use crate::scene::radar::{Aim, AimFrom, AntennaMount};
use crate::scene::sea::{PatchPlace, SlickShape};
use crate::scene::{Scene, Target};
use crate::units::SPEED_OF_LIGHT_MPS;

/// Corners of a slick that is an ellipse.
const CORNERS: usize = 48;

/// What stands where in a scene, as far as its scenario is known.
#[derive(Clone, Debug, Default)]
pub struct Scenery {
    /// Name of the scenario or recording.
    pub title: String,
    /// A recording is shown, not a run.
    pub replayed: bool,
    antennas: Vec<Mount>,
    patch_m: Option<[f64; 2]>,
    place: Option<Place>,
    lengths_m: Vec<Option<f64>>,
    targets: Vec<Option<[[f64; 3]; 2]>>,
    slicks: Vec<(String, Vec<[f64; 2]>)>,
}

#[derive(Clone, Debug)]
struct Mount {
    name: String,
    platform: usize,
    outline: Outline,
}

#[derive(Clone, Debug)]
enum Place {
    At([f64; 2]),
    Aim(Aim, AimFrom),
}

impl Scenery {
    /// Of a scene.
    pub fn of(scene: &Scene, title: &str) -> Self {
        let radar = &scene.radar;
        let wavelength_m = radar.wavelength_m();
        let mount = |name: &String, mount: &AntennaMount| Mount {
            name: name.clone(),
            platform: mount.platform,
            outline: Antenna::open(&mount.pattern, wavelength_m)
                .map_or_else(|_| Outline::default(), |of| Outline::of(&of)),
        };
        let transmitters = radar.transmitters.iter().map(|end| mount(&end.name, &end.antenna));
        let receivers = radar.receivers.iter().map(|end| mount(&end.name, &end.antenna));
        let sea = scene.sea.as_ref();
        let place = sea.map(|sea| match &sea.place {
            PatchPlace::Fixed => {
                let size_m = sea.patch.size_m();
                let corner_m = sea.patch.centre_m(sea.patch.first);
                Place::At([0, 1].map(|axis| corner_m[axis] + 0.5 * (size_m[axis] - sea.patch.facet_m)))
            }
            PatchPlace::Follow { aim, aim_from } => Place::Aim(aim.clone(), *aim_from),
        });
        let slick = |shape: &SlickShape| match shape {
            SlickShape::Polygon { corners_m } => corners_m.clone(),
            SlickShape::Ellipse { centre_m, half_axes_m, direction_rad } => (0..CORNERS)
                .map(|corner| {
                    let (along, across) = (std::f64::consts::TAU * corner as f64 / CORNERS as f64).sin_cos();
                    let (sin, cos) = direction_rad.sin_cos();
                    let (x, y) = (half_axes_m[0] * across, half_axes_m[1] * along);
                    [centre_m[0] + x * cos - y * sin, centre_m[1] + x * sin + y * cos]
                })
                .collect(),
        };
        // The page carries targets straight on.
        let straight = |target: &Target| match target.trajectory {
            None => Some([target.position.to_array(), target.velocity.to_array()]),
            Some(_) => None,
        };
        Self {
            title: title.to_owned(),
            replayed: false,
            antennas: transmitters.chain(receivers).collect(),
            patch_m: sea.map(|sea| sea.patch.size_m()),
            place,
            lengths_m: scene.ships.iter().map(|ship| ship.length_m).collect(),
            targets: scene.targets.iter().map(straight).collect(),
            slicks: sea
                .iter()
                .flat_map(|sea| &sea.slicks)
                .map(|s| (s.name.clone(), slick(&s.shape)))
                .collect(),
        }
    }

    /// Of a recording, and its scene where its scenario is understood.
    pub fn of_recording(scene: Option<&Scene>, title: &str) -> Self {
        let scenery = scene.map_or_else(Self::default, |scene| Self::of(scene, title));
        Self { title: title.to_owned(), replayed: true, ..scenery }
    }

    /// Outline of the main lobe of an antenna.
    pub(super) fn outline(&self, antenna: usize) -> Option<&Outline> {
        self.antennas.get(antenna).map(|mount| &mount.outline)
    }

    /// Middle of the patch of sea, East and North, m.
    pub(super) fn patch_centre_m(
        &self,
        time_s: f64,
        truth: &[PlatformRecord],
        reported: &[PlatformRecord],
    ) -> Option<[f64; 2]> {
        match self.place.as_ref()? {
            Place::At(centre_m) => Some(*centre_m),
            Place::Aim(Aim::Point { position, velocity }, _) => {
                let ([x, y, _], [u, v, _]) = (position.to_array(), velocity.to_array());
                Some([x + u * time_s, y + v * time_s])
            }
            Place::Aim(Aim::Beside { platform, along_m, across_m }, from) => {
                let known = if *from == AimFrom::True { truth } else { reported };
                let record = known.get(*platform)?;
                let [u, v, _] = record.velocity_mps;
                let speed = u.hypot(v);
                // Starboard of the ground track is clockwise of it; a platform at rest looks North.
                let [e, n] = if speed > 0.0 { [u / speed, v / speed] } else { [0.0, 1.0] };
                let [x, y, _] = record.position_m;
                Some([x + along_m * e + across_m * n, y + along_m * n - across_m * e])
            }
        }
    }
}

/// What the page gets first. Without `ppi` it has no plan position panel.
pub fn about(
    header: &Header,
    scenery: &Scenery,
    columns: Option<usize>,
    ppi: Option<&Ppi>,
    control: bool,
) -> Value {
    let pair = |channel: &crate::recording::header::ChannelRow| {
        let same = |pair: &crate::recording::header::PairRow| {
            pair.transmitter == channel.transmitter && pair.receiver == channel.receiver
        };
        header.pairs.iter().position(same).filter(|_| channel.is_of_echoes())
    };
    let antennas = header.antennas().enumerate().map(|(place, name)| {
        let mount = scenery.antennas.iter().find(|mount| mount.name == name);
        let kind = if place < header.transmitters.len() { "transmitter" } else { "receiver" };
        json!({ "name": name, "kind": kind, "platform": mount.map(|mount| mount.platform) })
    });
    json!({
        "kind": "about",
        "software": header.software,
        "title": scenery.title,
        "replayed": scenery.replayed,
        "control": control,
        "truth": header.truth,
        "changeable": header.changes.is_some(),
        "total": header.pulses,
        "first": header.first_pulse,
        "prf_hz": header.prf_hz,
        "carrier_hz": header.carrier_hz,
        "bandwidth_hz": header.bandwidth_hz,
        "sample_rate_hz": header.sample_rate_hz,
        "wavelength_m": SPEED_OF_LIGHT_MPS / header.carrier_hz,
        "window_s": header.layout.samples as f64 / header.sample_rate_hz,
        "columns": columns,
        "ppi": ppi.map(|ppi| json!({
            "channel": ppi.radials().name(),
            "antenna": ppi.radials().antenna(),
            "spokes": ppi.spokes(),
            "beam_deg": ppi.beam_deg(),
            "period_s": ppi.period_s(),
        })),
        "channels": header.channels.iter().map(|channel| json!({ "name": channel.name, "pair": pair(channel) })).collect::<Vec<_>>(),
        "platforms": header.platforms,
        "antennas": antennas.collect::<Vec<_>>(),
        "targets": header.targets.iter().enumerate().map(|(place, name)| {
            let known = scenery.targets.get(place).copied().flatten();
            json!({ "name": name, "position_m": known.map(|known| known[0]), "velocity_mps": known.map(|known| known[1]) })
        }).collect::<Vec<_>>(),
        "ships": header.ships.iter().enumerate().map(|(place, name)| {
            json!({ "name": name, "length_m": scenery.lengths_m.get(place).copied().flatten() })
        }).collect::<Vec<_>>(),
        "patch_m": scenery.patch_m,
        "slicks": scenery.slicks.iter().map(|(name, outline_m)| json!({ "name": name, "outline_m": outline_m })).collect::<Vec<_>>(),
    })
}
