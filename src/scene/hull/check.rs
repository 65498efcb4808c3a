//! Whether numbers are a hull.

use super::fault::{HullFault, Place, What};
use super::limits::{LENGTH_RANGE_M, MOST_STATIONS, MOST_WATERLINES};
use super::panel::{self, Panel};
use super::{Hull, Particulars};

/// Flattest beam and draught, as parts of the length.
const FLATTEST: f64 = 1e-4;

/// Values that are no numbers, and counts that do not fit.
pub(super) fn finite(stations_m: &[f64], waterlines_m: &[f64], half_breadths_m: &[f64]) -> Vec<HullFault> {
    let mut faults = Vec::new();
    let mut push = |place, what| faults.push(HullFault { place, what });
    for (i, &value) in stations_m.iter().enumerate().filter(|(_, x)| !x.is_finite()) {
        push(Place::Station(i), What::NotFinite { value });
    }
    for (j, &value) in waterlines_m.iter().enumerate().filter(|(_, z)| !z.is_finite()) {
        push(Place::Waterline(j), What::NotFinite { value });
    }
    let (found, needed) = (half_breadths_m.len(), stations_m.len().saturating_mul(waterlines_m.len()));
    if found != needed {
        push(Place::Whole, What::Count { found, needed });
        return faults;
    }
    for (n, &value) in half_breadths_m.iter().enumerate().filter(|(_, y)| !y.is_finite()) {
        push(Place::Station(n / waterlines_m.len()), What::NotFinite { value });
    }
    faults
}

/// What is wrong with offsets that are numbers; those that are not have been reported already.
pub(super) fn offsets(stations_m: &[f64], waterlines_m: &[f64], half_breadths_m: &[f64]) -> Vec<HullFault> {
    let mut faults = Vec::new();
    let mut push = |place, what| faults.push(HullFault { place, what });
    let top = waterlines_m.len().saturating_sub(1);
    for step in steps(waterlines_m) {
        let disorder = |value_m, before_m| What::WaterlineOrder { value_m, before_m };
        push(Place::Waterline(step.index), step.fault(disorder));
    }
    if let Some(&value_m) = waterlines_m.last().filter(|z| z.is_finite() && **z != 0.0) {
        push(Place::Waterline(top), What::TopWaterline { value_m });
    }
    if !(3..=MOST_WATERLINES).contains(&waterlines_m.len()) || waterlines_m.len().is_multiple_of(2) {
        push(Place::Waterline(top), What::Waterlines { found: waterlines_m.len() });
    }
    let rows = steps(stations_m);
    for i in 0..stations_m.len() {
        if let Some(step) = rows.iter().find(|step| step.index == i) {
            push(Place::Station(i), step.fault(|value_m, before_m| What::StationOrder { value_m, before_m }));
        }
        let row = &half_breadths_m[i * waterlines_m.len()..(i + 1) * waterlines_m.len()];
        for (&value_m, &waterline_m) in row.iter().zip(waterlines_m).filter(|(y, _)| **y < 0.0) {
            push(Place::Station(i), What::Negative { value_m, waterline_m });
        }
    }
    if !(3..=MOST_STATIONS).contains(&stations_m.len()) || stations_m.len().is_multiple_of(2) {
        push(Place::Whole, What::Stations { found: stations_m.len() });
    }
    if !faults.is_empty() {
        return faults;
    }
    let mut push = |place, what| faults.push(HullFault { place, what });
    // Only of a table in order is the size of the ends that of the hull.
    let length_m = stations_m[stations_m.len() - 1] - stations_m[0];
    let beam_m = 2.0 * half_breadths_m.iter().copied().fold(0.0, f64::max);
    let [least_m, most_m] = LENGTH_RANGE_M;
    if length_m.is_nan() || beam_m.is_nan() {
        return faults;
    }
    if !(least_m..=most_m).contains(&length_m) {
        push(Place::Whole, What::Size { what: "the length", value_m: length_m, least_m, most_m });
        return faults;
    }
    let (least_m, most_m) = (FLATTEST * length_m, length_m);
    let sizes = [("the beam", beam_m), ("the depth of the table", -waterlines_m[0])];
    // No beam at all is reported as no volume.
    for (what, value_m) in sizes.into_iter().filter(|(_, size_m)| *size_m != 0.0) {
        if !(least_m..=most_m).contains(&value_m) {
            push(Place::Whole, What::Size { what, value_m, least_m, most_m });
        }
    }
    // What Simpson's rule finds may be nothing, or less, for a table of isolated peaks.
    let (along, up) = (Panel::all(stations_m), Panel::all(waterlines_m));
    let sections_m2: Vec<f64> =
        half_breadths_m.chunks(waterlines_m.len()).map(|row| panel::integral(&up, row)).collect();
    let block = panel::integral(&along, &sections_m2) / (length_m * beam_m * -waterlines_m[0]);
    // Where offsets could not be read the volume is not known either.
    let known = half_breadths_m.iter().all(|y| y.is_finite());
    if known && (block.is_nan() || block <= FLATTEST) {
        push(Place::Whole, What::Empty);
    }
    faults
}

/// A node out of order (`to` is `None`) or out of the middle of its panel.
struct Step {
    index: usize,
    value: f64,
    from: f64,
    to: Option<f64>,
}

impl Step {
    fn fault(&self, disorder: impl Fn(f64, f64) -> What) -> What {
        match self.to {
            Some(to_m) => What::Uneven { value_m: self.value, from_m: self.from, to_m },
            None => disorder(self.value, self.from),
        }
    }
}

fn steps(nodes: &[f64]) -> Vec<Step> {
    let mut faults = Vec::new();
    let mut before = f64::NAN;
    for (index, &value) in nodes.iter().enumerate() {
        if value <= before {
            faults.push(Step { index, value, from: before, to: None });
        }
        if value.is_finite() {
            before = value;
        }
    }
    if faults.is_empty() {
        for (i, panel) in nodes.windows(3).enumerate().step_by(2) {
            let place = (panel[1] - panel[0]) / (panel[2] - panel[0]);
            if place.is_finite() && !(0.25..=0.75).contains(&place) {
                faults.push(Step { index: i + 1, value: panel[1], from: panel[0], to: Some(panel[2]) });
            }
        }
    }
    faults
}

/// What is wrong with the particulars of a hull in memory.
pub(super) fn facts(hull: &Hull) -> Vec<HullFault> {
    let whole = |what| HullFault { place: Place::Whole, what };
    if let Some(what) = draught(hull) {
        return vec![whole(what)];
    }
    hull.stated.disagreements(&Particulars::of(hull)).into_iter().map(|(_, what)| whole(what)).collect()
}

/// A draught of which the hull has nothing.
pub(super) fn draught(hull: &Hull) -> Option<What> {
    let (least_m, most_m) = (FLATTEST * hull.length_m(), -hull.waterlines_m[0] * (1.0 + 1e-12));
    let value_m = hull.draught_m;
    (!(least_m..=most_m).contains(&value_m)).then_some(What::Size {
        what: "draught_m",
        value_m,
        least_m,
        most_m,
    })
}
