//! Land on the patch.

use crate::config::choices::Terrain;
use crate::config::keys;
use crate::config::section::Section;
use crate::scene::Land;

/// Frequency at which the gamma of a terrain is given, Hz, and its rise with the decade, dB.
const GAMMA_AT_HZ: f64 = 10e9;
const GAMMA_DB_A_DECADE: f64 = 5.0;

/// Gamma of a terrain at 10 GHz, dB (Barton 1985).
fn gamma_of(terrain: Terrain) -> f64 {
    match terrain {
        Terrain::Flat => -20.0,
        Terrain::Farmland => -15.0,
        Terrain::RollingHills => -12.0,
        Terrain::WoodedHills => -10.0,
        Terrain::Urban | Terrain::Mountains => -5.0,
    }
}

/// `[land]`: `Some(None)` without one, `None` where something is faulty.
pub(super) fn land(root: &Section<'_>, carrier_hz: Option<f64>) -> Option<Option<Land>> {
    use keys::land::{CROSS_OVER_VV_DB, DEM, GAMMA_DB, HH_OVER_VV_DB, SEA_LEVEL_M, TERRAIN};
    let has_land = root.has(&keys::root::LAND);
    let section = root.section(&keys::root::LAND);
    if !root.has(&keys::root::SEA) {
        root.idle(&[&keys::root::LAND], "there is no [sea]");
        return Some(None);
    }
    if !has_land {
        return Some(None);
    }
    let section = section?;
    let dem = section.file(&DEM);
    let terrain = section.choice(&TERRAIN);
    let gamma_db = section.number(&GAMMA_DB);
    if section.has(&GAMMA_DB) {
        section.idle(&[&TERRAIN], "together with gamma_db");
    }
    let sea_level_m = section.number(&SEA_LEVEL_M);
    let [hh_db, cross_db] = [&HH_OVER_VV_DB, &CROSS_OVER_VV_DB].map(|key| section.number(key));
    let gamma_db = if section.has(&GAMMA_DB) {
        gamma_db
    } else {
        let decades = carrier_hz.map(|carrier_hz| (carrier_hz / GAMMA_AT_HZ).log10());
        terrain.zip(decades).map(|(terrain, decades)| gamma_of(terrain) + GAMMA_DB_A_DECADE * decades)
    };
    section.finish();
    let ratio = |db: f64| 10f64.powf(db / 10.0);
    Some(Some(Land {
        dem: dem?,
        sea_level_m: sea_level_m?,
        gamma: ratio(gamma_db?),
        hh_over_vv: ratio(hh_db?),
        cross_over_vv: ratio(cross_db?),
    }))
}
