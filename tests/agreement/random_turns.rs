//! Targets and ships of random scenes that turn.

use std::fmt::Write as _;

use super::random_scene::{Draw, Geometry, line};

/// A way round a place, turning about the middle of the run.
fn way_round(draw: &mut Draw, at_m: [f64; 2], speed_mps: f64, radius_m: f64, lasts_s: f64) -> String {
    let (bearing, turn) = (draw.angle(), draw.between(0.3, 2.0) * draw.one(&[-1.0, 1.0]));
    let leg_m = 5.0 * radius_m;
    let place =
        |along_m: f64, bearing: f64| [at_m[0] + along_m * bearing.cos(), at_m[1] + along_m * bearing.sin()];
    let points = [place(-leg_m, bearing), at_m, place(leg_m, bearing + turn)];
    let begin_s = 0.5 * lasts_s - leg_m / speed_mps;
    format!(
        "track = {{ kind = \"waypoints\", waypoints_m = {points:?}, speed_mps = {speed_mps:?}, turn_radius_m = \
         {radius_m:?}, begin_s = {begin_s:?} }}"
    )
}

/// A target, and a ship, that turn.
pub(super) fn turning(draw: &mut Draw, geometry: &Geometry, out: &mut String) {
    let Geometry { size_m, lasts_s, .. } = geometry;
    let somewhere = |draw: &mut Draw| size_m.map(|side_m| draw.between(-0.4, 0.4) * side_m);
    if draw.chance(0.2) {
        let (at_m, speed_mps) = (somewhere(draw), draw.log(1.0, 30.0));
        // No more than three times gravity.
        let radius_m = (speed_mps * lasts_s * draw.log(0.3, 3.0)).max(speed_mps * speed_mps / 30.0);
        let way = way_round(draw, at_m, speed_mps, radius_m, *lasts_s);
        let (height_m, rcs_dbsm) = (draw.between(0.0, 2.0), draw.between(-30.0, 20.0));
        line!(out, "[[target]]\nname = \"turning\"\nheight_m = {height_m:?}\nrcs_dbsm = {rcs_dbsm:?}\n{way}");
    }
    if draw.chance(0.08) {
        let length_m = draw.log(4.0, 60.0).min(size_m[0]).max(0.05);
        let (at_m, speed_mps) = (somewhere(draw), (0.35 * (9.81 * length_m).sqrt()).min(12.0));
        let radius_m = draw.between(2.0, 5.0) * length_m;
        let way = way_round(draw, at_m, speed_mps, radius_m, *lasts_s);
        let (beam_m, draught_m) = (0.13 * length_m, 0.05 * length_m);
        line!(
            out,
            "[[ship]]\nname = \"turning\"\nhull = \"wigley\"\nlength_m = {length_m:?}\nbeam_m = {beam_m:?}\ndraught_m = {draught_m:?}\n{way}"
        );
        if draw.chance(0.5) {
            line!(out, "echo = true\npanel_m = {:?}", (length_m / 8.0).max(0.06));
        }
    }
}
