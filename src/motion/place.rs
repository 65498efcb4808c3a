//! Where fixes are in a scene.

use glam::{DMat3, DVec3};

use crate::frames::{Earth, Enu, SceneFrame, Vector};
use crate::nav::{Fix, Place};

/// Rotation from the scene's axes to East, North and up of a fix; the identity for a local fix.
pub(crate) fn to_local_axes(place: &Place, frame: &SceneFrame) -> DMat3 {
    let Place::Geodetic(geodetic) = place else { return DMat3::IDENTITY };
    let local = SceneFrame::at(*geodetic, Earth::Flat);
    let turned = |axis: DVec3| {
        let ecef = frame.vector_to_ecef(Vector::<Enu>::from_raw(axis))?;
        Some(local.vector_from_ecef(ecef)?.raw())
    };
    match (turned(DVec3::X), turned(DVec3::Y), turned(DVec3::Z)) {
        (Some(x), Some(y), Some(z)) => DMat3::from_cols(x, y, z),
        _ => DMat3::IDENTITY,
    }
}

/// Where a fix is in the scene; `None` if the scene is not georeferenced and the fix is.
pub(crate) fn position(fix: &Fix, frame: &SceneFrame) -> Option<DVec3> {
    match fix.place {
        Place::Local(point) => Some(point.raw()),
        Place::Geodetic(geodetic) => frame.from_geodetic(geodetic).map(|point| point.raw()),
    }
}
