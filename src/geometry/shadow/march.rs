//! A march from the antenna outward: the running horizon of a fan of rays, and the clearance of each facet
//! above it.

use crate::cpu::Task;
use crate::sea::surface::fields::Real;

/// `| |dx| - |dy| | / (|dx| + |dy|)` below which the marches along x and y are blended.
const BLEND: f64 = 1.0 / 16.0;
/// Largest |lateral / forward| of a march: the far side of the blend.
pub(super) const STEEPEST: f64 = (1.0 + BLEND) / (1.0 - BLEND);
/// Rows nearer to the antenna than this, in facets, are taken to be under it.
pub(super) const UNDER: f64 = 1e-9;
/// Slack for points on the border of the map, in facets.
const BORDER: f64 = 1e-9;

/// One sector of a march.
pub(super) struct March<'a, T, W> {
    pub sector: &'a Sector,
    pub heights_m: &'a [T],
    pub height_m: f64,
    pub rays: usize,
    pub horizon: &'a mut [f64],
    pub out: &'a mut [T],
    pub weigh: &'a W,
}

impl<T: Real, W: Fn(f64) -> f64> Task for March<'_, T, W> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { sector, heights_m, height_m, rays, horizon, out, weigh } = self;
        sector.march(heights_m, height_m, rays, horizon, out, weigh);
    }
}

/// The part of a map on one side of the antenna along one axis ("rows", from the antenna outward), as far
/// as that axis is dominant. Lengths in facets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sector {
    columns: usize,
    rows: usize,
    /// Whether the first row of the map is the nearest, or the last.
    inward_first: bool,
    /// Nearest row, counted from the inner side.
    nearest: usize,
    /// Column of the antenna.
    column: f64,
    /// Row of the antenna, counted from the map's first.
    row: f64,
}

impl Sector {
    /// `None` where the map has nothing of it.
    pub fn new(columns: usize, rows: usize, [column, row]: [f64; 2], inward_first: bool) -> Option<Self> {
        let under = if inward_first { row } else { (rows - 1) as f64 - row };
        // One less than the row under the antenna, whichever way it was rounded; then the first one past it.
        let from = under.max(1.0) as usize - 1;
        let mut sector = Self { columns, rows, inward_first, nearest: from, column, row };
        sector.nearest = (from..rows).find(|&row| sector.forward(row) > UNDER)?;
        let reach = STEEPEST * sector.last();
        let meets = column + reach >= 0.0 && column - reach <= sector.last_column();
        meets.then_some(sector)
    }

    /// Most rays that a march over a map of this size can have.
    pub fn most_rays(columns: usize, rows: usize, rays_per_facet: usize) -> usize {
        let widest = columns as f64 + 2.0 * STEEPEST * rows as f64;
        (widest * rays_per_facet as f64) as usize + 8
    }

    fn last_column(&self) -> f64 {
        (self.columns - 1) as f64
    }

    /// Distance from the antenna along the axis.
    fn forward(&self, row: usize) -> f64 {
        if self.inward_first { row as f64 - self.row } else { self.row - (self.rows - 1 - row) as f64 }
    }

    pub fn last(&self) -> f64 {
        self.forward(self.rows - 1)
    }

    /// Bounds of lateral over forward distance.
    pub fn lateral_range(&self) -> (f64, f64) {
        let (near, last) = (self.forward(self.nearest), self.last());
        let [left, right] = [-self.column, self.last_column() - self.column];
        let least = (left / near).min(left / last);
        let most = (right / near).max(right / last);
        (least.max(-STEEPEST), most.min(STEEPEST))
    }

    /// Share of this axis in a facet seen in a direction near the diagonal; the other axis has the rest.
    fn share(forward: f64, lateral: f64) -> f64 {
        let lateral = lateral.abs();
        let share = |more: f64, less: f64| smoothstep(0.5 + 0.5 / BLEND * (more - less) / (more + less));
        // Both axes see the same two lengths, so that their shares make exactly 1.
        if forward >= lateral { share(forward, lateral) } else { 1.0 - share(lateral, forward) }
    }

    /// From the antenna outward: facets of a row take the horizon of the rows before, then the rays of
    /// the fan take in this row. Adds results to `out`.
    #[inline(always)]
    fn march<T: Real>(
        &self,
        heights_m: &[T],
        height_m: f64,
        rays_per_facet: usize,
        horizon: &mut [f64],
        out: &mut [T],
        weigh: &impl Fn(f64) -> f64,
    ) {
        let density = rays_per_facet as f64;
        let (last, last_column) = (self.last(), self.last_column());
        let span = STEEPEST * (last - self.forward(self.nearest));
        // Rays are numbered by where they meet the last row, `density` to a column.
        let fan = [self.column - STEEPEST * last, self.column + STEEPEST * last];
        let first_ray = (density * fan[0].max(-span)).floor() - 1.0;
        let final_ray = (density * fan[1].min(last_column + span)).ceil() + 1.0;
        let count = ((final_ray - first_ray + 1.0).max(0.0) as usize).min(horizon.len());
        let horizon = &mut horizon[..count];
        horizon.fill(f64::NEG_INFINITY);
        let fan_rays = fan.map(|column| density * column - first_ray);
        // Rays that were on the map in the row before.
        let mut met = 0..0;
        for row in self.nearest..self.rows {
            let forward = self.forward(row);
            let to_last = (self.rows - 1 - row) as f64;
            // Column of a ray in this row: shift + narrowing * (its column in the last row).
            let shift = self.column / last * to_last;
            let narrowing = 1.0 - to_last / last;
            let place = if self.inward_first { row } else { self.rows - 1 - row };
            let cells = place * self.columns..(place + 1) * self.columns;
            let (heights_m, out) = (&heights_m[cells.clone()], &mut out[cells]);
            let line = Line {
                heights_m,
                inverse: 1.0 / forward,
                offset: height_m * (to_last / (last * forward)),
                forward,
                column: self.column,
            };

            let in_sector = line.columns([-STEEPEST * forward, STEEPEST * forward].map(|x| x + self.column));
            let shaded = if met.is_empty() {
                in_sector.start..in_sector.start
            } else {
                // Facets whose line to the antenna crosses the row before on the map.
                let before = forward - 1.0;
                let left = -self.column / before - BORDER;
                let right = last_column + (last_column - self.column) / before + BORDER;
                let shaded = line.columns([left, right]);
                let start = shaded.start.clamp(in_sector.start, in_sector.end);
                start..shaded.end.clamp(start, in_sector.end)
            };
            for column in (in_sector.start..shaded.start).chain(shaded.end..in_sector.end) {
                line.put(column, &mut out[column], weigh(f64::INFINITY));
            }
            if !shaded.is_empty() {
                let per_column = density / narrowing;
                let first = -shift * per_column - first_ray;
                line.interpolate([first, per_column], &horizon[met.clone()], met.start, shaded, out, weigh);
            }

            let on_map = |column: f64| density * ((column - shift) / narrowing) - first_ray;
            let low = (on_map(0.0) - BORDER).ceil().max(fan_rays[0].floor()).max(0.0) as usize;
            let high = (on_map(last_column) + BORDER).floor().min(fan_rays[1].ceil());
            // A negative end becomes an empty range.
            let high = ((high + 1.0).max(0.0) as usize).min(count);
            met = low.min(high)..high;
            let step = narrowing / density;
            let first = shift + step * (first_ray + met.start as f64);
            line.take_in([first, step], &mut horizon[met.clone()]);
        }
    }
}

/// One row of a march.
struct Line<'a, T> {
    heights_m: &'a [T],
    /// One over the distance from the antenna.
    inverse: f64,
    /// `z_T (1/u - 1/u_last)`, m per facet.
    offset: f64,
    /// Distance from the antenna along the axis.
    forward: f64,
    /// Column of the antenna.
    column: f64,
}

impl<T: Real> Line<'_, T> {
    /// The columns between two places.
    #[inline(always)]
    fn columns(&self, [left, right]: [f64; 2]) -> std::ops::Range<usize> {
        let end = ((right.floor() + 1.0).max(0.0) as usize).min(self.heights_m.len());
        (left.ceil().max(0.0) as usize).min(end)..end
    }

    #[inline(always)]
    fn put(&self, column: usize, out: &mut T, value: f64) {
        let lateral = column as f64 - self.column;
        let share = Sector::share(self.forward, lateral);
        if share > 0.0 {
            *out = *out + T::round_from(share * value);
        }
    }

    /// Results of the facets `columns` from the horizon of the rays from number `first_ray` on; facet `j`
    /// is on ray `ray[0] + ray[1] j`.
    #[inline(always)]
    fn interpolate(
        &self,
        ray: [f64; 2],
        horizon: &[f64],
        first_ray: usize,
        columns: std::ops::Range<usize>,
        out: &mut [T],
        weigh: &impl Fn(f64) -> f64,
    ) {
        let first = ray[0] - first_ray as f64;
        let value = |column: usize| {
            let elevation = between(horizon, first + ray[1] * column as f64, |z| *z);
            let own = self.heights_m[column].widen() * self.inverse - self.offset;
            weigh(self.forward * (own - elevation))
        };
        // Beyond it a facet belongs to the blend of two marches.
        let core = self.forward / STEEPEST;
        let core = self.columns([self.column - core, self.column + core]);
        let start = core.start.clamp(columns.start, columns.end);
        let core = start..core.end.clamp(start, columns.end);
        for column in (columns.start..core.start).chain(core.end..columns.end) {
            self.put(column, &mut out[column], value(column));
        }
        // Heights and results side by side: so they become vectors.
        let (heights_m, out) = (&self.heights_m[core.clone()], &mut out[core.clone()]);
        for (i, (height_m, out)) in heights_m.iter().zip(out).enumerate() {
            let elevation = between(horizon, first + ray[1] * (core.start + i) as f64, |z| *z);
            let own = height_m.widen() * self.inverse - self.offset;
            *out = T::round_from(weigh(self.forward * (own - elevation)));
        }
    }

    /// Raises the horizon of rays, the i-th of which is in column `ray[0] + ray[1] i`, to this row.
    #[inline(always)]
    fn take_in(&self, ray: [f64; 2], horizon: &mut [f64]) {
        for (i, horizon) in horizon.iter_mut().enumerate() {
            let height_m = between(self.heights_m, ray[0] + ray[1] * i as f64, |z| z.widen());
            let elevation = height_m * self.inverse - self.offset;
            *horizon = if elevation > *horizon { elevation } else { *horizon };
        }
    }
}

/// Rises from 0 at 0 to 1 at 1 with level ends; 0 for NaN.
#[inline(always)]
pub(super) fn smoothstep(s: f64) -> f64 {
    let s = if s > 0.0 { s.min(1.0) } else { 0.0 };
    s * s * (3.0 - 2.0 * s)
}

/// Linear interpolation at a (finite) place between entries, the first or the last one beyond them.
#[inline(always)]
fn between<T>(entries: &[T], place: f64, value: impl Fn(&T) -> f64) -> f64 {
    /// Ones have the weight of the last bit: adding it rounds to an integer that stands in the low bits.
    const INTEGERS: f64 = (3_u64 << 51) as f64;
    let last = (entries.len() - 1) as f64;
    let place = if place > 0.0 { place } else { 0.0 };
    let place = if place < last { place } else { last };
    // At a tie it may be the entry itself or the one before; the result is the same.
    let rounded = (place - 0.5) + INTEGERS;
    // Bounded again for the compiler, which then knows it and can put places side by side.
    let left = ((rounded.to_bits() & u64::from(u32::MAX)) as usize).min(entries.len() - 1);
    let right = (left + 1).min(entries.len() - 1);
    let (a, b) = (value(&entries[left]), value(&entries[right]));
    a + (b - a) * (place - (rounded - INTEGERS))
}
