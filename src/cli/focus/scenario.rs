//! What focusing needs of the scenario in a recording: where to look.
//!
//! Only these keys are read, so that files which the scenario names (tracks, hulls) may be missing.

use toml::{Table, Value};

use crate::frames::{Earth, Geodetic, SceneFrame};
use crate::recording::Recording;

/// The scenario of a recording; empty where it holds none.
pub(super) struct Scenario {
    table: Table,
    /// Emission of pulse 0 on the clock of the recording's paths, s.
    pub pulse_zero_s: f64,
}

pub(super) fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64))
}

pub(super) fn numbers<const N: usize>(table: &Table, key: &str) -> Option<[f64; N]> {
    let list: Vec<f64> = table.get(key)?.as_array()?.iter().map(number).collect::<Option<_>>()?;
    list.try_into().ok()
}

impl Scenario {
    pub fn of(recording: &Recording) -> Self {
        // Intervals of a staggered sequence are not known here: the mean is.
        let first_s = recording.emission_s.first().copied().unwrap_or(0.0);
        let since_s = recording.index.first().map_or(0.0, |index| *index as f64 / recording.header.prf_hz);
        let table = recording.header.config.parse().unwrap_or_default();
        Self { table, pulse_zero_s: first_s - since_s }
    }

    fn antenna(&self, kind: &str, name: &str) -> Option<&Table> {
        let all = self.table.get(kind)?.as_array()?;
        all.iter().filter_map(Value::as_table).find(|t| t.get("name").and_then(Value::as_str) == Some(name))
    }

    /// Platform that carries an antenna (`kind`: `transmitter` or `receiver`).
    pub fn platform(&self, kind: &str, name: &str) -> Option<&str> {
        self.antenna(kind, name)?.get("platform")?.as_str()
    }

    /// Whether an antenna radiates alike in all directions, so that its boresight says nothing.
    pub fn is_isotropic(&self, kind: &str, name: &str) -> bool {
        let aperture =
            self.antenna(kind, name).and_then(|t| t.get("antenna")?.as_table()?.get("kind")?.as_str());
        aperture == Some("isotropic")
    }

    /// `[platform.errors]` of a platform, where it has some.
    pub fn errors(&self, platform: &str) -> Option<&Table> {
        let all = self.table.get("platform")?.as_array()?;
        let named = |t: &&Table| t.get("name").and_then(Value::as_str) == Some(platform);
        all.iter().filter_map(Value::as_table).find(named)?.get("errors")?.as_table()
    }

    /// Where receive window or antennas of a channel look at a pulse in use, East and North, m: what the
    /// window follows, else what the receiver aims at, else what the transmitter aims at, else the middle of
    /// the patch, else the origin.
    pub fn aim(&self, recording: &Recording, channel: usize, pulse: usize) -> [f64; 2] {
        let row = recording.header.channels.get(channel);
        let table = |path: &[&str]| -> Option<&Table> {
            path.iter().try_fold(&self.table, |table, key| table.get(*key)?.as_table())
        };
        let pointing = |kind: &str, name: &str| self.antenna(kind, name)?.get("pointing")?.as_table();
        let aims = [
            table(&["radar", "window", "follow"]),
            row.and_then(|c| pointing("receiver", &c.receiver)),
            row.and_then(|c| pointing("transmitter", &c.transmitter)),
        ];
        aims.into_iter()
            .flatten()
            .find_map(|aim| aim_point(aim, recording, pulse))
            .or_else(|| numbers(table(&["scene"])?, "patch_centre_m"))
            .unwrap_or([0.0; 2])
    }
}

/// East and North of a point given as such, or by latitude and longitude at the height of the origin, as the
/// scenario is read.
fn place(aim: &Table, recording: &Recording) -> Option<[f64; 2]> {
    if let Some([x, y, _]) = numbers(aim, "position_m") {
        return Some([x, y]);
    }
    let key = |name: &str| aim.get(name).and_then(number);
    let origin = recording.header.origin?;
    let frame = SceneFrame::at(Geodetic::from_deg(origin.lat_deg, origin.lon_deg, origin.h_m), Earth::Flat);
    let point = Geodetic::from_deg(key("lat_deg")?, key("lon_deg")?, origin.h_m);
    let [x, y, _] = frame.from_geodetic(point)?.to_array();
    Some([x, y])
}

/// A point of the scene, or one beside a platform.
fn aim_point(aim: &Table, recording: &Recording, pulse: usize) -> Option<[f64; 2]> {
    let key = |name: &str| aim.get(name).and_then(number).unwrap_or(0.0);
    match aim.get("kind")?.as_str()? {
        "at" => {
            let [x, y] = place(aim, recording)?;
            let [vx, vy, _] = numbers(aim, "velocity_mps").unwrap_or([0.0; 3]);
            let since_s = recording.index[pulse] as f64 / recording.header.prf_hz;
            Some([x + vx * since_s, y + vy * since_s])
        }
        "beside" => {
            let platform = aim.get("platform")?.as_str()?;
            let (position, velocity) = recording.reported_state(platform, pulse).ok()?;
            let speed = velocity[0].hypot(velocity[1]);
            if speed < 1e-3 {
                return None;
            }
            let [ahead_x, ahead_y] = [velocity[0] / speed, velocity[1] / speed];
            let (along, across) = (key("along_m"), key("across_m"));
            Some([
                position[0] + ahead_x * along + ahead_y * across,
                position[1] + ahead_y * along - ahead_x * across,
            ])
        }
        _ => None,
    }
}
