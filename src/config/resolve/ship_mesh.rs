//! The mesh by which a ship echoes, and how it rides the sea.

use crate::config::choices::RideKind;
use crate::config::keys::{self, Key};
use crate::config::section::Section;
use crate::scene::ship::{ShipMesh, ShipMotion};

/// The mesh by which a ship echoes.
///
/// The keys are those of `[[ship]]` by name; `panel_m` is its table's own, and its absence the default of a
/// mesh.
pub(super) fn mesh(section: &Section<'_>, echo: Option<bool>, panel_m: &'static Key) -> Option<ShipMesh> {
    use keys::ship::{FREEBOARD_M, MESH, MOTION, ROLL_PERIOD_S, SUPERSTRUCTURE, UP};
    let written = section.has(&MESH);
    let used = if written { section.flag(&MESH) } else { None };
    let of_mesh = [&SUPERSTRUCTURE, &UP, &FREEBOARD_M, panel_m, &MOTION, &ROLL_PERIOD_S];
    if echo == Some(false) {
        section.idle(&[&MESH], "echo = false");
        section.idle(&of_mesh, "echo = false");
    } else if used == Some(false) {
        section.idle(&of_mesh, "mesh = false");
    }
    let superstructure =
        if section.has(&SUPERSTRUCTURE) { section.file_or(&SUPERSTRUCTURE) } else { Some(None) };
    if superstructure == Some(None) && echo != Some(false) && used != Some(false) {
        section.idle(&[&UP], "superstructure = \"none\"");
    }
    let up = section.choice(&UP);
    let freeboard_m = section.number(&FREEBOARD_M);
    let sound = freeboard_m.is_some() || !section.has(&FREEBOARD_M);
    let panel_m = match section.number(panel_m) {
        None if !section.has(panel_m) => Some(ShipMesh::default().panel_m),
        found => found,
    };
    let motion = motion(section, echo == Some(false) || used == Some(false));
    (sound && (used.is_some() || !written)).then_some(())?;
    Some(ShipMesh {
        used,
        superstructure: superstructure?,
        up: up?,
        freeboard_m,
        panel_m: panel_m?,
        motion: motion?,
    })
}

/// How it rides the sea; `refused`: this is a fault that has been reported.
fn motion(section: &Section<'_>, refused: bool) -> Option<ShipMotion> {
    use keys::ship::{MOTION, ROLL_PERIOD_S};
    let motion = section.choice(&MOTION)?;
    if motion == RideKind::Level && !refused {
        section.idle(&[&ROLL_PERIOD_S], "motion = \"level\"");
    }
    let roll_period_s = section.number(&ROLL_PERIOD_S);
    if roll_period_s.is_none() && section.has(&ROLL_PERIOD_S) {
        return None;
    }
    Some(match motion {
        RideKind::Waves => ShipMotion::Waves { roll_period_s, form: None },
        RideKind::Level => ShipMotion::Level,
    })
}
