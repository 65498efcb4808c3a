//! What every facet contributes to the echo of a pulse, as a map.

use std::path::Path;

use super::field_file::{Attribute, FieldFileError, SOFTWARE};
use super::map_file::{Layer, MapFile};
use crate::paths::snapshot::Snapshot;
use crate::scene::Scene;

/// Writes the contributions of all channels, delays, Doppler and heights; `config` is the scenario's text.
///
/// # Errors
/// What cannot be written.
pub fn write(path: &Path, scene: &Scene, config: &str, snapshot: &Snapshot) -> Result<(), FieldFileError> {
    let radar = &scene.radar;
    let pair_name = |pair: usize, what: &str| {
        if snapshot.delay_s.len() == 1 {
            return what.to_owned();
        }
        let pair = radar.pairs()[pair];
        let (tx, rx) = (&radar.transmitters[pair.transmitter].name, &radar.receivers[pair.receiver].name);
        format!("{what}_{tx}_{rx}")
    };
    let mut columns: Vec<(String, &str, String, Vec<f64>)> =
        vec![("height_m".into(), "m", "height above the mean surface".into(), snapshot.height_m.clone())];
    for (channel, name) in radar.channels.iter().map(|channel| &channel.name).enumerate() {
        let meaning = format!("elementary contribution in {name}; NaN where the facet is dark");
        columns.push((format!("contribution_dbw_{name}"), "dBW", meaning, snapshot.power_dbw(channel)));
    }
    for pair in 0..snapshot.delay_s.len() {
        let doppler_hz = snapshot.delay_rate[pair].iter().map(|rate| -rate * radar.carrier_hz).collect();
        let received =
            snapshot.received[pair].iter().map(|&received| f64::from(u8::from(received))).collect();
        let delay_us = snapshot.delay_s[pair].iter().map(|delay_s| delay_s * 1e6).collect();
        columns.push((pair_name(pair, "delay_us"), "us", "delay after the emission".into(), delay_us));
        columns.push((
            pair_name(pair, "doppler_hz"),
            "Hz",
            "Doppler, positive when closing".into(),
            doppler_hz,
        ));
        columns.push((
            pair_name(pair, "received"),
            "1",
            "1 where the window receives the facet".into(),
            received,
        ));
    }
    let layers: Vec<Layer> =
        columns.iter().map(|(name, unit, meaning, values)| Layer { name, unit, meaning, values }).collect();
    let attributes = [
        ("software", Attribute::Text(SOFTWARE)),
        ("config", Attribute::Text(config)),
        ("seed", Attribute::Whole(scene.seed)),
        ("pulse", Attribute::Whole(snapshot.index)),
        ("carrier_hz", Attribute::Real(radar.carrier_hz)),
        ("window_start_s", Attribute::Real(snapshot.window_start_s)),
        ("facet_m", Attribute::Real(snapshot.patch.facet_m)),
    ];
    let file = MapFile {
        format: "nereus-snapshot",
        attributes: &attributes,
        patch: &snapshot.patch,
        layers: &layers,
    };
    file.write(path)
}
