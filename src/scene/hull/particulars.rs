//! Particulars: what a naval architect asks first.

use super::panel::{self, Panel};
use super::{Hull, What};

/// Names of the particulars, in the order of [`Particulars::values`] and [`Stated::values`].
pub const QUANTITIES: [&str; 9] = [
    "length_m",
    "beam_m",
    "draught_m",
    "volume_m3",
    "wetted_surface_m2",
    "block",
    "midship",
    "waterplane",
    "lcb_percent",
];

/// Particulars of a hull, from its table.
///
/// | symbol | from |
/// | --- | --- |
/// | volume | `2 int int Y dz dx`, exact for the piecewise quadratic `Y` |
/// | wetted surface | triangles over the nodes of the table, and the flat bottom; a transom's face is not wet |
/// | CB, CM, CWP | `volume/(L B T)`, largest section over `B T`, waterplane over `L B` |
/// | LCB | centre of the volume, percent of L forward of midship |
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particulars {
    /// First to last station, m.
    pub length_m: f64,
    /// Twice the largest half-breadth, m.
    pub beam_m: f64,
    /// Draught, m.
    pub draught_m: f64,
    /// Displaced volume, m^3.
    pub volume_m3: f64,
    /// Wetted surface, m^2.
    pub wetted_surface_m2: f64,
    /// Block coefficient.
    pub block: f64,
    /// Coefficient of the largest section.
    pub midship: f64,
    /// Waterplane coefficient.
    pub waterplane: f64,
    /// Centre of buoyancy, percent of the length forward of midship.
    pub lcb_percent: f64,
}

impl Particulars {
    /// Those of a hull.
    pub fn of(hull: &Hull) -> Self {
        let along = Panel::all(hull.stations_m());
        let sections_m2 = hull.section_areas_m2();
        let volume_m3 = panel::integral(&along, &sections_m2);
        let moment_m4: f64 = along
            .iter()
            .enumerate()
            .map(|(i, panel)| panel.first_moment(&sections_m2[2 * i..2 * i + 3]))
            .sum();
        let largest_m2 = sections_m2.iter().copied().fold(0.0, f64::max);
        let top = hull.waterlines_m().len() - 1;
        let waterline_m: Vec<f64> =
            (0..hull.stations_m().len()).map(|i| 2.0 * hull.half_breadths_m(i)[top]).collect();
        let (length_m, beam_m, draught_m) = (hull.length_m(), hull.beam_m(), hull.draught_m());
        Self {
            length_m,
            beam_m,
            draught_m,
            volume_m3,
            wetted_surface_m2: wetted_surface_m2(hull),
            block: volume_m3 / (length_m * beam_m * draught_m),
            midship: largest_m2 / (beam_m * draught_m),
            waterplane: panel::integral(&along, &waterline_m) / (length_m * beam_m),
            // Stations count astern.
            lcb_percent: -100.0 * moment_m4 / (volume_m3 * length_m),
        }
    }

    /// Computed minus stated, percent of what is stated; what is a percentage itself is subtracted as it is.
    pub fn difference_percent(quantity: &str, computed: f64, stated: f64) -> f64 {
        if quantity.ends_with("percent") { computed - stated } else { 100.0 * (computed / stated - 1.0) }
    }

    /// In the order of [`QUANTITIES`].
    pub fn values(&self) -> [f64; 9] {
        [
            self.length_m,
            self.beam_m,
            self.draught_m,
            self.volume_m3,
            self.wetted_surface_m2,
            self.block,
            self.midship,
            self.waterplane,
            self.lcb_percent,
        ]
    }
}

impl Hull {
    /// Immersed area of every station, both sides, m^2.
    pub fn section_areas_m2(&self) -> Vec<f64> {
        let up = Panel::all(self.waterlines_m());
        let area_m2 = |i| 2.0 * panel::integral(&up, self.half_breadths_m(i));
        (0..self.stations_m().len()).map(area_m2).collect()
    }
}

/// Triangles over the nodes, both sides, and the flat of the bottom. Those on the centre plane are no skin.
fn wetted_surface_m2(hull: &Hull) -> f64 {
    let (x, z) = (hull.stations_m(), hull.waterlines_m());
    let mut side_m2 = 0.0;
    for i in 1..x.len() {
        let (fore, aft) = (hull.half_breadths_m(i - 1), hull.half_breadths_m(i));
        for j in 1..z.len() {
            let corners = [
                glam::DVec3::new(x[i - 1], fore[j - 1], z[j - 1]),
                glam::DVec3::new(x[i], aft[j - 1], z[j - 1]),
                glam::DVec3::new(x[i], aft[j], z[j]),
                glam::DVec3::new(x[i - 1], fore[j], z[j]),
            ];
            // Both diagonals, half each: no direction is preferred.
            for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3]] {
                let [a, b, c] = [corners[a], corners[b], corners[c]];
                if a.y > 0.0 || b.y > 0.0 || c.y > 0.0 {
                    side_m2 += 0.25 * (b - a).cross(c - a).length();
                }
            }
        }
    }
    let bottom_m: Vec<f64> = (0..x.len()).map(|i| hull.half_breadths_m(i)[0]).collect();
    2.0 * (side_m2 + panel::integral(&Panel::all(x), &bottom_m))
}

/// Particulars as published, to be compared with those of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stated {
    /// In the order of [`QUANTITIES`].
    pub values: [Option<f64>; 9],
    /// How far the table may be from them, percent (for the centre of buoyancy: percent of the length).
    pub tolerance_percent: f64,
}

impl Default for Stated {
    fn default() -> Self {
        Self { values: [None; 9], tolerance_percent: Self::USUAL_TOLERANCE_PERCENT }
    }
}

impl Stated {
    /// Tolerance of a file that gives none, percent: offset tables lifted from drawings or surfaces are that
    /// good.
    pub const USUAL_TOLERANCE_PERCENT: f64 = 1.0;

    /// What disagrees with the table: index of the quantity, and the fault.
    pub fn disagreements(&self, found: &Particulars) -> Vec<(usize, What)> {
        let rows = QUANTITIES.into_iter().zip(found.values()).zip(self.values).enumerate();
        let disagree =
            |(index, ((quantity, computed), stated)): (usize, ((&'static str, f64), Option<f64>))| {
                let stated = stated?;
                let off_percent = Particulars::difference_percent(quantity, computed, stated).abs();
                let tolerance_percent = self.tolerance_percent;
                let what = What::Differs { quantity, stated, computed, tolerance_percent };
                (off_percent.is_nan() || off_percent > tolerance_percent).then_some((index, what))
            };
        rows.filter_map(disagree).collect()
    }

    /// Those of the same form at another length.
    pub(super) fn scaled(&self, ratio: f64) -> Self {
        let powers = [1, 1, 1, 3, 2, 0, 0, 0, 0];
        let mut scaled = *self;
        for (value, power) in scaled.values.iter_mut().zip(powers) {
            *value = value.map(|value| value * ratio.powi(power));
        }
        scaled
    }
}
