//! Body plan of a hull: its sections seen from ahead and from astern in one frame.
//!
//! The stern half stands to the left of the centre line and the bow half to the right, as on a drawing board.
//! Every curve is a station of the offset table, with straight lines between its waterlines; one metre is as
//! long upward as across.

use super::canvas::Canvas;
use super::chart::{Curve, Mark, Plot, PlotAxis, PlotError, SIZE_RANGE_PX, Spacing};
use crate::scene::Hull;

/// Sections of either half, about.
const SECTIONS: usize = 10;
/// Width of the frame, pixels.
const WIDTH_PX: usize = 640;
/// Room about the hull, parts of its size.
const ROOM: f64 = 0.06;

/// Draws it.
///
/// # Errors
/// Figures that cannot be drawn.
pub fn draw(hull: &Hull) -> Result<Canvas, PlotError> {
    let stations = hull.stations_m().len();
    let middle = stations / 2;
    let step = (middle / SECTIONS).max(1);
    // The ends are drawn whatever the step.
    let bow: Vec<usize> = (0..middle).step_by(step).chain([middle]).collect();
    let mut stern: Vec<usize> = (middle..stations).step_by(step).collect();
    if stern.last() != Some(&(stations - 1)) {
        stern.push(stations - 1);
    }
    let [left, right] = [curve(hull, &stern, -1.0), curve(hull, &bow, 1.0)];
    let half_m = (0.5 + ROOM) * hull.beam_m();
    let depth_m = -hull.waterlines_m()[0];
    let limits = [[-half_m, half_m], [-(1.0 + ROOM) * depth_m, ROOM * depth_m]];
    let [across_m, up_m] = limits.map(|[low, high]| high - low);
    let height_px = (up_m / across_m * WIDTH_PX as f64).round();
    // A very flat or very deep hull keeps its shape as far as the sides of a picture allow.
    let height_px = height_px.clamp(SIZE_RANGE_PX[0] as f64, SIZE_RANGE_PX[1] as f64) as usize;
    let [x, y] = limits.map(Some);
    let title = format!("Body plan of {}, {:.1} m long", hull.name(), hull.length_m());
    Plot {
        title: &title,
        x: PlotAxis { label: "stern half, bow half, m", spacing: Spacing::Linear, limits: x },
        y: PlotAxis { label: "above the waterline, m", spacing: Spacing::Linear, limits: y },
        curves: &[
            Curve { name: "stern", points: &left, mark: Mark::Line },
            Curve { name: "bow", points: &right, mark: Mark::Line },
        ],
        size_px: [WIDTH_PX, height_px],
    }
    .draw()
}

/// Sections of some stations, broken between them.
fn curve(hull: &Hull, stations: &[usize], side: f64) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    for &station in stations {
        let half_breadths_m = hull.half_breadths_m(station);
        let Some(lowest) = half_breadths_m.iter().position(|y| *y > 0.0) else { continue };
        // From the centre line, where the section begins.
        let keel = lowest.saturating_sub(1);
        points.push([0.0, hull.waterlines_m()[keel]]);
        let rows = half_breadths_m.iter().zip(hull.waterlines_m()).skip(keel);
        points.extend(rows.map(|(y_m, z_m)| [side * y_m, *z_m]));
        points.push([f64::NAN; 2]);
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_begin_at_the_keel_and_end_at_the_waterline() {
        let hull = Hull::wigley(100.0, 10.0, 6.25).unwrap();
        let points = curve(&hull, &[0, 25, 50], -1.0);
        // The ends of the hull have no breadth: the middle section alone is left.
        assert_eq!(points.first(), Some(&[0.0, -6.25]));
        assert_eq!(points[points.len() - 2], [-5.0, 0.0]);
        assert!(points.iter().filter(|point| point[0].is_nan()).count() == 1);
        assert!(points.iter().all(|point| point[0].is_nan() || (-5.0..=0.0).contains(&point[0])));
    }

    #[test]
    fn hulls_of_any_shape_are_drawn() {
        for [beam_m, draught_m] in [[10.0, 6.25], [0.01, 100.0], [100.0, 0.01]] {
            let hull = Hull::wigley(100.0, beam_m, draught_m).unwrap();
            let canvas = draw(&hull).unwrap();
            assert!(canvas.width() > 600 && canvas.height() < 9000, "{beam_m} {draught_m}");
        }
    }
}
