//! Positions.

use super::{Ground, plausible};
use crate::config::choices::DatumKind;
use crate::config::error::Problem;
use crate::config::hint::names;
use crate::config::keys::{self, Key};
use crate::config::section::Section;
use crate::frames::{Enu, Geodetic, Point};
use crate::nav::Place;

/// The keys of a point on or above the sea.
pub(super) struct SurfaceKeys {
    pub(super) position_m: &'static Key,
    pub(super) lat_deg: &'static Key,
    pub(super) lon_deg: &'static Key,
    /// Height above the sea beside latitude and longitude; `None`: on the sea.
    pub(super) height_m: Option<&'static Key>,
}

/// A point given as `position_m` (East, North, height above the sea) or by latitude and longitude.
pub(super) fn above_sea(section: &Section<'_>, keys: &SurfaceKeys, ground: &Ground) -> Option<Point<Enu>> {
    if is_geodetic(section, keys.position_m, &[keys.lat_deg, keys.lon_deg])? {
        let lat_deg = section.number(keys.lat_deg);
        let lon_deg = section.number(keys.lon_deg);
        let height_m = keys.height_m.map_or(Some(0.0), |key| section.number(key));
        together(section, &[keys.lat_deg, keys.lon_deg]);
        needs_origin(section, keys.lat_deg, ground)?;
        let sea_m = ground.origin_h_m?;
        let place = Geodetic::from_deg(lat_deg?, lon_deg?, sea_m);
        plausible::swap(section, keys.lat_deg, place, ground);
        let on_earth = ground.frame.from_geodetic(place)?;
        let [x_m, y_m, _] = on_earth.to_array();
        Some(ground.frame.above_sea(x_m, y_m, height_m?))
    } else {
        let [x_m, y_m, height_m] = section.vector(keys.position_m)?;
        Some(ground.frame.above_sea(x_m, y_m, height_m))
    }
}

/// A point of the sea given as East and North, or by latitude and longitude.
pub(super) fn on_sea(
    section: &Section<'_>,
    [position_m, lat_deg, lon_deg]: [&'static Key; 3],
    ground: &Ground,
) -> Option<[f64; 2]> {
    if section.has(position_m) && !section.has(lat_deg) && !section.has(lon_deg) {
        return section.vector(position_m);
    }
    let keys = SurfaceKeys { position_m, lat_deg, lon_deg, height_m: None };
    let [x_m, y_m, _] = above_sea(section, &keys, ground)?.to_array();
    Some([x_m, y_m])
}

/// Place of a platform that is fixed or starts a straight line.
pub(super) fn platform(section: &Section<'_>, ground: &Ground) -> Option<Place> {
    use keys::track::{DATUM, H_M, LAT_DEG, LON_DEG, POSITION_M};
    if !is_geodetic(section, &POSITION_M, &[&LAT_DEG, &LON_DEG, &H_M])? {
        let [x_m, y_m, z_m] = section.vector(&POSITION_M)?;
        return Some(Place::Local(Point::new(x_m, y_m, z_m)));
    }
    let [lat_deg, lon_deg, h_m] = [&LAT_DEG, &LON_DEG, &H_M].map(|key| section.number(key));
    together(section, &[&LAT_DEG, &LON_DEG, &H_M]);
    let datum = section.choice(&DATUM);
    if !section.has(&DATUM) {
        section.fault(&DATUM, Problem::Missing { allowed: "\"ellipsoid\", \"msl\"".to_owned() });
    }
    if datum == Some(DatumKind::Barometric) {
        let allowed = "\"ellipsoid\", \"msl\" (barometric heights belong to recordings)".to_owned();
        section.fault(&DATUM, Problem::Type { found: "\"barometric\"".to_owned(), allowed });
    }
    needs_origin(section, &LAT_DEG, ground)?;
    let above_ellipsoid_m = match datum? {
        DatumKind::Ellipsoid => h_m?,
        DatumKind::MeanSeaLevel | DatumKind::Barometric => h_m? + ground.origin_h_m?,
    };
    let place = Geodetic::from_deg(lat_deg?, lon_deg?, above_ellipsoid_m);
    plausible::swap(section, &LAT_DEG, place, ground);
    Some(Place::Geodetic(place))
}

/// Whether the geodetic keys are written, faulting both forms and none.
fn is_geodetic(section: &Section<'_>, local: &'static Key, geodetic: &[&'static Key]) -> Option<bool> {
    let on_earth = geodetic.iter().any(|key| section.has(key));
    if on_earth == section.has(local) {
        // Both or none: read all, so that none of them is reported as idle.
        section.numbers(local);
        for key in geodetic {
            section.number(key);
        }
        let keys = format!("{} and ({})", local.name, names(geodetic));
        match on_earth {
            true => section.fault(local, Problem::Several { keys }),
            false => section.fault_here(Problem::NoneOf { keys: keys.replace(" and ", ", ") }),
        }
        return None;
    }
    Some(on_earth)
}

fn together(section: &Section<'_>, keys: &[&'static Key]) {
    if let Some(missing) = keys.iter().find(|key| !section.has(key)) {
        section.fault(missing, Problem::Missing { allowed: missing.kind.allowed() });
    }
}

fn needs_origin(section: &Section<'_>, key: &'static Key, ground: &Ground) -> Option<()> {
    if !ground.geodetic_allowed() {
        section.fault(key, Problem::NeedsOrigin);
        return None;
    }
    Some(())
}
