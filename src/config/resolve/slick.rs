//! Films on the water.

use super::Names;
use crate::config::error::{Problem, Warning};
use crate::config::keys;
use crate::config::section::Section;
use crate::scene::Patch;
use crate::scene::sea::{PatchPlace, SlickRegion, SlickShape};

/// `[[slick]]`.
pub(super) fn slicks(
    root: &Section<'_>,
    patch: Option<&Patch>,
    place: Option<&PatchPlace>,
) -> Option<Vec<SlickRegion>> {
    let mut names = Names::new("slick");
    let mut slicks = Vec::new();
    for (index, section) in root.sections(&keys::root::SLICK).into_iter().enumerate() {
        names.take_or(&section, &keys::slick::NAME, Some(format!("slick-{index}")));
        let slick = slick(section, names.last(), patch);
        if let (Some(slick), Some(patch), Some(PatchPlace::Fixed)) = (&slick, patch, place)
            && let Some(warning) = beyond(slick, patch)
        {
            root.reader().warn(warning);
        }
        slicks.push(slick);
    }
    slicks.into_iter().collect()
}

fn slick(section: Section<'_>, name: Option<String>, patch: Option<&Patch>) -> Option<SlickRegion> {
    use keys::slick::{CENTRE_M, CORNERS_M, COVER, DIRECTION_DEG, ELASTICITY_NPM, HALF_AXES_M, RIM_M};
    let written = section.exactly_one(&[&CENTRE_M, &CORNERS_M]);
    let centre_m = section.vector(&CENTRE_M);
    let corners_m = section.points(&CORNERS_M);
    if section.has(&CORNERS_M) && !section.has(&CENTRE_M) {
        section.idle(&[&HALF_AXES_M, &DIRECTION_DEG], "together with corners_m");
    }
    let shape = if section.has(&CENTRE_M) {
        let (half_axes_m, direction_deg) = (section.vector(&HALF_AXES_M), section.number(&DIRECTION_DEG));
        centre_m.zip(half_axes_m).zip(direction_deg).map(|((centre_m, half_axes_m), direction_deg)| {
            SlickShape::Ellipse { centre_m, half_axes_m, direction_rad: direction_deg.to_radians() }
        })
    } else {
        if let Some(corners_m) = &corners_m
            && on_a_line(corners_m)
        {
            section.fault(&CORNERS_M, Problem::NoArea);
        }
        corners_m.map(|corners_m| SlickShape::Polygon { corners_m })
    };
    let rim_m = section.number(&RIM_M);
    let rim_m = if section.has(&RIM_M) { rim_m } else { patch.map(|patch| patch.facet_m) };
    let (cover, elasticity_npm) = (section.number(&COVER), section.number(&ELASTICITY_NPM));
    section.finish();
    written?;
    Some(SlickRegion {
        name: name?,
        shape: shape?,
        rim_m: rim_m?,
        cover: cover?,
        elasticity_npm: elasticity_npm?,
    })
}

/// Whether all corners lie on one line, to 1e-12 of the square of their extent.
fn on_a_line(corners_m: &[[f64; 2]]) -> bool {
    let Some(&[x0, y0]) = corners_m.first() else { return true };
    let from_first = |&[x, y]: &[f64; 2]| [x - x0, y - y0];
    let length = |[x, y]: [f64; 2]| x.hypot(y);
    let offsets: Vec<[f64; 2]> = corners_m.iter().map(from_first).collect();
    let farthest = offsets.iter().copied().max_by(|a, b| length(*a).total_cmp(&length(*b)));
    let Some([fx, fy]) = farthest else { return true };
    let tolerance = 1e-12 * length([fx, fy]).powi(2);
    offsets.iter().all(|[x, y]| (x * fy - y * fx).abs() <= tolerance)
}

/// What is not modelled of a slick on a patch that stays.
fn beyond(slick: &SlickRegion, patch: &Patch) -> Option<Warning> {
    let half_m = 0.5 * slick.rim_m;
    let (mut outside, mut cut) = (false, false);
    for (axis, [low, high]) in slick.shape.bounds_m().into_iter().enumerate() {
        let (low, high) = (low - half_m, high + half_m);
        // Half a facet of grace: an outline along the edge of the patch is not cut.
        let edge = |key: i64| (key as f64 - 0.5) * patch.facet_m;
        let (first, end) = (edge(patch.first[axis]), edge(patch.first[axis] + patch.facets[axis] as i64));
        outside |= high <= first || low >= end;
        cut |= low < first - 0.5 * patch.facet_m || high > end + 0.5 * patch.facet_m;
    }
    let name = slick.name.clone();
    match (outside, cut) {
        (true, _) => Some(Warning::SlickOutside { name }),
        (false, true) => Some(Warning::SlickCut { name }),
        (false, false) => None,
    }
}
