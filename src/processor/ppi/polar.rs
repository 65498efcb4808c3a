//! Powers over range and bearing, and the plan that they make.

use std::f64::consts::TAU;

use super::scans::wrapped;

/// Spokes of a turn: 0.044 degrees each.
pub const SPOKES: usize = 8192;
/// Most cells along a spoke.
const MOST_CELLS: usize = 4096;
/// Most peaks that are looked through.
const MOST_PEAKS: usize = 1 << 14;
/// Peaks so far below another may be its side lobes: 20 dB.
const LOBE_RATIO: f32 = 0.01;

/// Powers of a scan over range and bearing. Pulses within a spoke, and samples within a cell, leave the
/// strongest; so memory stays below 134 MB whatever there is in a scan.
#[derive(Clone, Debug)]
pub struct Polar {
    near_m: f64,
    cell_m: f64,
    cells: usize,
    spokes: Vec<Spoke>,
}

#[derive(Clone, Debug, Default)]
struct Spoke {
    /// Bearings of its pulses after its begin, summed, rad.
    within_rad: f64,
    pulses: u32,
    /// Not a number where no pulse was received.
    power_w: Vec<f32>,
}

/// A place on the plan, and what there is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Range, m.
    pub range_m: f64,
    /// Bearing, rad, from 0 to a turn.
    pub bearing_rad: f64,
    /// Power, W.
    pub power_w: f64,
}

/// How far an echo of a point reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Half-power beamwidth, rad.
    pub beam_rad: f64,
    /// Resolution in range, m.
    pub resolution_m: f64,
    /// Half the length of the pulse, in range: how far its side lobes reach, m.
    pub lobes_m: f64,
}

impl Polar {
    /// Of ranges between two, m, in cells of so many metres or, where these would be too many, wider ones.
    pub fn new([near_m, far_m]: [f64; 2], cell_m: f64) -> Self {
        let span_m = (far_m - near_m).max(0.0);
        let cell_m = cell_m.max(span_m / (MOST_CELLS - 1) as f64).max(f64::MIN_POSITIVE);
        let cells = (span_m / cell_m).round() as usize + 1;
        Self { near_m, cell_m, cells: cells.min(MOST_CELLS), spokes: vec![Spoke::default(); SPOKES] }
    }

    /// Width of a cell, m.
    pub fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// Adds the powers of a pulse, W, at ranges from `first_m` in steps of `step_m`.
    pub fn add(&mut self, bearing_rad: f64, first_m: f64, step_m: f64, power_w: impl Iterator<Item = f32>) {
        let turn = bearing_rad.rem_euclid(TAU) / TAU * SPOKES as f64;
        if !turn.is_finite() {
            return;
        }
        let place = (turn as usize).min(SPOKES - 1);
        let spoke = &mut self.spokes[place];
        if spoke.pulses == 0 {
            spoke.power_w = vec![f32::NAN; self.cells];
        }
        spoke.pulses += 1;
        spoke.within_rad += (turn - place as f64) * TAU / SPOKES as f64;
        // Steps are no longer than cells: none stays empty between two.
        let (first, ratio) = ((first_m - self.near_m) / self.cell_m, step_m / self.cell_m);
        for (sample, power_w) in power_w.enumerate() {
            let at = first.round() as i64 + (sample as f64 * ratio + 1e-9).floor() as i64;
            if let Some(cell) = usize::try_from(at).ok().and_then(|at| spoke.power_w.get_mut(at)) {
                *cell = cell.max(power_w);
            }
        }
    }

    /// Mean bearing of the pulses in a spoke, rad; none without any.
    fn bearing_rad(&self, spoke: usize) -> Option<f64> {
        let Spoke { within_rad, pulses, .. } = self.spokes[spoke];
        (pulses > 0).then(|| spoke as f64 * TAU / SPOKES as f64 + within_rad / f64::from(pulses))
    }

    fn range_m(&self, cell: usize) -> f64 {
        self.near_m + cell as f64 * self.cell_m
    }

    /// For every spoke the one nearest to it that has pulses within so many rad.
    fn nearest(&self, reach_rad: f64) -> Vec<Option<usize>> {
        let filled: Vec<usize> = (0..SPOKES).filter(|spoke| self.spokes[*spoke].pulses > 0).collect();
        let near = |spoke: usize| {
            let middle = (spoke as f64 + 0.5) * TAU / SPOKES as f64;
            let after = filled.partition_point(|other| *other < spoke);
            let count = filled.len().max(1);
            let sides = [after % count, (after + count - 1) % count];
            let candidates = sides.into_iter().filter_map(|side| filled.get(side).copied());
            let away = |other: usize| {
                self.bearing_rad(other).map_or(f64::INFINITY, |bearing| wrapped(bearing - middle).abs())
            };
            let best = candidates.min_by(|a, b| away(*a).total_cmp(&away(*b)))?;
            (self.spokes[spoke].pulses > 0 || away(best) <= reach_rad).then_some(best)
        };
        (0..SPOKES).map(near).collect()
    }

    /// The plan out to a range: `side` by `side` pixels, row by row from the North (or ahead), each from the
    /// West. A pixel has the strongest of the cells within it, else that of the nearest spoke within
    /// `reach_rad`; not a number where there is neither.
    pub fn plan(&self, radius_m: f64, side: usize, reach_rad: f64) -> Vec<f32> {
        let nearest = self.nearest(reach_rad);
        let pixel_m = 2.0 * radius_m / side.max(1) as f64;
        let middle = 0.5 * (side as f64 - 1.0);
        let mut plan = Vec::with_capacity(side * side);
        for row in 0..side {
            for column in 0..side {
                let east_m = (column as f64 - middle) * pixel_m;
                let north_m = (middle - row as f64) * pixel_m;
                let range_m = east_m.hypot(north_m);
                plan.push(if range_m > radius_m {
                    f32::NAN
                } else {
                    self.pixel(range_m, east_m.atan2(north_m).rem_euclid(TAU), 0.5 * pixel_m, &nearest)
                });
            }
        }
        plan
    }

    fn pixel(&self, range_m: f64, bearing_rad: f64, half_m: f64, nearest: &[Option<usize>]) -> f32 {
        let at = (range_m - self.near_m) / self.cell_m;
        let half = half_m / self.cell_m;
        let [mut low, mut high] = [(at - half).ceil(), (at + half).floor()];
        if low > high {
            (low, high) = (at.round(), at.round());
        }
        if high < 0.0 || low >= self.cells as f64 {
            return f32::NAN;
        }
        let cells = low.max(0.0) as usize..=(high as usize).min(self.cells - 1);
        let strongest = |spoke: usize| {
            self.spokes[spoke]
                .power_w
                .get(cells.clone())
                .unwrap_or_default()
                .iter()
                .copied()
                .fold(f32::NAN, f32::max)
        };
        let width_rad = if range_m > half_m { (half_m / range_m).atan() } else { TAU };
        let per_rad = SPOKES as f64 / TAU;
        let first = ((bearing_rad - width_rad) * per_rad).floor() as i64;
        let last = (((bearing_rad + width_rad) * per_rad).floor() as i64).min(first + SPOKES as i64 - 1);
        let mut most = f32::NAN;
        for spoke in (first..=last).map(|spoke| spoke.rem_euclid(SPOKES as i64) as usize) {
            let within = |at: f64| wrapped(at - bearing_rad).abs() <= width_rad;
            if self.bearing_rad(spoke).is_some_and(within) {
                most = most.max(strongest(spoke));
            }
        }
        if most.is_nan() {
            let spoke = ((bearing_rad * per_rad) as usize).min(SPOKES - 1);
            most = nearest[spoke].map_or(f32::NAN, strongest);
        }
        most
    }

    /// The strongest peaks, at most so many, within so many metres. Bearings are means over the cells beside
    /// the peak with at least half its power, weighted by power. What is 20 dB weaker than a peak, and lies
    /// where its side lobes do, is left out: at its range within four beams, or in its beam within the pulse.
    pub fn strongest(&self, count: usize, radius_m: f64, extent: Extent) -> Vec<Peak> {
        let filled: Vec<usize> = (0..SPOKES).filter(|spoke| self.spokes[*spoke].pulses > 0).collect();
        let cells = self.cells.min(((radius_m - self.near_m) / self.cell_m + 1.0).max(0.0) as usize);
        let power = |place: usize, cell: usize| {
            let spoke = filled[place % filled.len()];
            self.spokes[spoke].power_w.get(cell).copied().unwrap_or(f32::NAN)
        };
        let mut peaks = Vec::new();
        for place in 0..filled.len() {
            for cell in 0..cells {
                let own = power(place, cell);
                let beside =
                    |other: usize| (cell.saturating_sub(1)..=cell + 1).any(|cell| power(other, cell) > own);
                if own > 0.0 && ![place, place + 1, place + filled.len() - 1].into_iter().any(beside) {
                    peaks.push((own, place, cell));
                }
            }
        }
        let descending = |a: &(f32, usize, usize), b: &(f32, usize, usize)| {
            b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2)))
        };
        if peaks.len() > MOST_PEAKS {
            peaks.select_nth_unstable_by(MOST_PEAKS, descending);
            peaks.truncate(MOST_PEAKS);
        }
        peaks.sort_unstable_by(descending);
        let mut found: Vec<Peak> = Vec::new();
        for (own, place, cell) in peaks {
            let range_m = self.range_m(cell);
            let bearing_rad = self.centroid_rad(&filled, place, cell, extent.beam_rad);
            let hidden = |peak: &Peak| {
                let along_m = (peak.range_m - range_m).abs();
                let across = wrapped(peak.bearing_rad - bearing_rad).abs() / extent.beam_rad;
                let is_weak = f64::from(own) < f64::from(LOBE_RATIO) * peak.power_w;
                let [at_range, in_beam] = [along_m < 2.0 * extent.resolution_m, across < 1.0];
                at_range && (in_beam || is_weak && across < 4.0)
                    || is_weak && in_beam && along_m < extent.lobes_m + 2.0 * extent.resolution_m
            };
            if !found.iter().any(hidden) {
                found.push(Peak { range_m, bearing_rad, power_w: own.into() });
                if found.len() >= count {
                    break;
                }
            }
        }
        found
    }

    /// Mean bearing of the spokes beside a place that have at least half its power in a cell.
    fn centroid_rad(&self, filled: &[usize], place: usize, cell: usize, beam_rad: f64) -> f64 {
        let own = |place: usize| f64::from(self.spokes[filled[place]].power_w[cell]);
        let bearing = |place: usize| self.bearing_rad(filled[place]).unwrap_or(0.0);
        let (peak, middle) = (own(place), bearing(place));
        let (mut weight, mut sum) = (peak, 0.0);
        for step in [1, filled.len() - 1] {
            let mut other = (place + step) % filled.len();
            while other != place {
                let away = wrapped(bearing(other) - middle);
                // Not a number neither.
                if !(own(other) >= 0.5 * peak && away.abs() <= beam_rad) {
                    break;
                }
                weight += own(other);
                sum += own(other) * away;
                other = (other + step) % filled.len();
            }
        }
        (middle + sum / weight).rem_euclid(TAU)
    }

    /// The strongest cell about a place, W; none where nothing was received.
    pub fn level_at(&self, range_m: f64, bearing_rad: f64, extent: Extent) -> Option<f64> {
        let half = (extent.resolution_m / self.cell_m).ceil();
        let at = ((range_m - self.near_m) / self.cell_m).round();
        let low = (at - half).max(0.0) as usize;
        let high = usize::try_from((at + half) as i64).ok()?.min(self.cells - 1);
        let near = (0..SPOKES).filter(|spoke| {
            let within = |at: f64| wrapped(at - bearing_rad).abs() <= 0.5 * extent.beam_rad;
            self.bearing_rad(*spoke).is_some_and(within)
        });
        let powers = near.filter_map(|spoke| self.spokes[spoke].power_w.get(low..=high)).flatten();
        let most = powers.copied().fold(f32::NAN, f32::max);
        (!most.is_nan()).then(|| most.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXTENT: Extent = Extent { beam_rad: 0.02, resolution_m: 7.5, lobes_m: 150.0 };

    /// A scan of a point: a beam of Gaussian shape, cells of 6 m from 300 m, floor 1e-6.
    fn of_a_point(bearings_rad: &[f64], range_m: f64, bearing_rad: f64) -> Polar {
        let mut polar = Polar::new([300.0, 2700.0], 6.0);
        for at in bearings_rad {
            let away = wrapped(at - bearing_rad) / EXTENT.beam_rad;
            let gain = (-4.0 * std::f64::consts::LN_2 * away * away).exp();
            let cell = |i: usize| {
                let off = (300.0 + 6.0 * i as f64 - range_m) / 6.0;
                (1e-6 + gain * (-off * off).exp()) as f32
            };
            polar.add(*at, 300.0, 6.0, (0..401).map(cell));
        }
        polar
    }

    fn round(count: usize, sign: f64) -> Vec<f64> {
        (0..count).map(|i| 1.0 + sign * TAU * i as f64 / count as f64).collect()
    }

    #[test]
    fn a_point_lands_in_its_cell_whichever_way_the_antenna_turns() {
        let sector: Vec<f64> = (0..200).map(|i| -0.5 + 0.005 * f64::from(i)).collect();
        let back: Vec<f64> = sector.iter().rev().copied().collect();
        for bearings in [&round(3000, 1.0), &round(3000, -1.0), &sector, &back] {
            // 359.9 and 0.1 degrees are on either side of North.
            for bearing_rad in [0.3, 359.9f64.to_radians(), 0.1f64.to_radians()] {
                let polar = of_a_point(bearings, 1502.0, bearing_rad);
                let [found] = polar.strongest(1, 2700.0, EXTENT)[..] else { panic!("no peak") };
                assert!((found.range_m - 1502.0).abs() <= 3.0, "{found:?}");
                // Symmetric about the point to half a pulse of 0.005 rad.
                assert!(wrapped(found.bearing_rad - bearing_rad).abs() < 2.6e-3, "{found:?}");
                assert!(found.power_w > 0.8, "{found:?}");
                let level = polar.level_at(1502.0, bearing_rad, EXTENT).unwrap();
                assert!((level - found.power_w).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn the_plan_has_it_where_it_lies() {
        for (bearing_deg, column, row) in
            [(0.0, 100, 50), (90.0, 150, 100), (180.0, 100, 150), (270.0, 50, 100)]
        {
            let polar = of_a_point(&round(3000, 1.0), 1350.0, f64::to_radians(bearing_deg));
            // 27 m a pixel, the middle of the plan between two.
            let plan = polar.plan(2700.0, 201, 0.01);
            let most =
                (0..plan.len()).filter(|i| !plan[*i].is_nan()).max_by(|a, b| plan[*a].total_cmp(&plan[*b]));
            let [x, y] = most.map(|i| [i % 201, i / 201]).unwrap();
            assert!(x.abs_diff(column) <= 1 && y.abs_diff(row) <= 1, "{bearing_deg}: {x} {y}");
            // Corners are beyond the range, the middle before the first sample.
            assert!(plan[0].is_nan() && plan[100 * 201 + 100].is_nan());
            assert_eq!(plan.iter().filter(|p| !p.is_nan()).count() / 1000, 31);
        }
    }

    #[test]
    fn only_what_was_seen_is_on_the_plan_and_gaps_within_half_a_beam_are_filled() {
        let sector: Vec<f64> = (0..50).map(|i| 0.02 * f64::from(i)).collect();
        let polar = of_a_point(&sector, 1350.0, 0.3);
        let [sparse, full] = [0.001, 0.011].map(|reach| {
            let plan = polar.plan(2700.0, 401, reach);
            let seen = |bearing: f64| {
                let (sin, cos) = bearing.sin_cos();
                let at = |x: f64| (200.0 + x).round() as usize;
                !plan[at(-180.0 * cos) * 401 + at(180.0 * sin)].is_nan()
            };
            (0..98).filter(|i| seen(0.01 * f64::from(*i))).count()
        });
        assert!(full == 98 && sparse < 70, "{sparse} {full}");
        let plan = polar.plan(2700.0, 401, 0.01);
        // West and South were not looked at.
        assert!(plan[200 * 401 + 50].is_nan() && plan[350 * 401 + 200].is_nan());
    }

    #[test]
    fn side_lobes_are_no_peaks() {
        let mut polar = of_a_point(&round(3000, 1.0), 1500.0, 2.0);
        for (range_m, bearing_rad, power_w) in
            [(1500.0, 2.05, 1e-3), (1560.0, 2.0, 1e-3), (1800.0, 2.0, 5e-4)]
        {
            polar.add(bearing_rad, range_m, 6.0, std::iter::once(power_w));
        }
        let found = polar.strongest(2, 2700.0, EXTENT);
        assert!(
            (found[0].range_m - 1500.0).abs() < 1.0 && (found[1].range_m - 1800.0).abs() < 1.0,
            "{found:?}"
        );
    }

    #[test]
    fn fine_samples_leave_the_strongest_in_a_cell() {
        let mut polar = Polar::new([0.0, 60_000.0], 1.5);
        assert_eq!(polar.cells, MOST_CELLS);
        polar.add(0.0, 0.0, 1.5, (0..40_001).map(|i| if i == 20_000 { 2.0 } else { 1.0 }));
        assert!(polar.spokes[0].power_w.iter().all(|power| *power >= 1.0));
        let [found] = polar.strongest(1, 60_000.0, EXTENT)[..] else { panic!("no peak") };
        assert!((found.range_m - 30_000.0).abs() <= polar.cell_m(), "{found:?}");
    }
}
