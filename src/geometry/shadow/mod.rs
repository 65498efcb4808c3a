//! Visibility of facets from an antenna: who stands behind a wave.
//!
//! **Map.** Heights `z` (m, scene frame ENU) at facet centres of a regular grid, row by row, `[iy][ix]`. On a
//! curved Earth the heights must already contain the drop of the mean surface; rays are straight. Water that
//! is not on the map hides nothing: whether a far antenna has risen above the sea's horizon is for the
//! caller to know, and facets at the map's edge towards the antenna have nothing before them.
//!
//! **Clearance.** Let T be the antenna, P a facet centre, and Q the points in which the line P - T, seen
//! from above, crosses the grid lines across its dominant axis, on the map and before P; heights at Q are
//! interpolated linearly between the two centres of that grid line. With `u` the distance from T along the
//! dominant axis,
//!
//! `c = (z_P - z_T) - u_P max_Q (z_Q - z_T)/u_Q` (m; infinite where no Q is)
//!
//! is the height of P above the ray that grazes the horizon: the distance between their elevations seen
//! from T, turned into a length at P. The facet is lifted by [`LIFT`] of its side against rounding.
//!
//! **Weight**, on the amplitude, one-way, 0 to 1, continuous with its first derivative in `c`:
//!
//! `v = smoothstep(c / (w dx))`, `smoothstep(s) = 3 s^2 - 2 s^3` on 0..1, or ([`Settings::SHARP`]) `v = 1`
//! for `c > 0`, else 0.
//!
//! `c / dx` is the clearance as an angle seen across one facet, `w` the width of the edge in the same measure
//! (a tangent, as slopes are). For a horizon one step away `c / dx` is the local grazing angle, and a facet
//! whose slope changes by `d` from edge to edge hides a part of itself where that is less than `d/2`. Hence
//! the default,
//! [`half_slope_change_rad`]: half the rms change of slope over `dx`. It should be taken once for a
//! scene, for a width that changes in time moves all weights.
//!
//! `c` is continuous in time and in the place of both; its rate jumps where the horizon passes from one point
//! to another (so does that of any horizon), the weight adds no jump of its own. Both ends of a path must see
//! a facet: multiply their weights.
//!
//! **How.** From T outward, row by row along the dominant axis, over a fan of rays through `1/n` of the
//! facets' spacing in the last row (`n` = [`Settings::rays_per_facet`]); each ray keeps the running maximum
//! of `z/u - z_T (1/u - 1/u_last)` (the elevation less a constant, so that a satellite loses no digits), and
//! a facet takes the horizon between its two rays. Against one ray per facet, `c` is off by at most
//! `(D/4 + g)/n`, `D` the largest second difference and `g` the largest step of the heights across the rays.
//! (Not for rays that enter the map at its side, where one of the two may meet a row more than the other.)
//! Where |dx| and |dy| differ by less than an eighth of their mean, marches along both axes are blended, so
//! that a facet does not jump when the antenna passes its diagonal. Cost `O(n)` per facet; no memory is
//! taken; the result depends on nothing but the arguments.
//!
//! **Limits.** No diffraction, no refraction other than by an Earth's radius put into the heights. Facets
//! that face away from the antenna return nothing by their scattering, not here. Heights that are not finite
//! give weights of 0 and hide nothing or all, but never NaN.
//!
//! Source: `docs/physics.md` section 11.1 (binary rule of the MaRS paper, with a width).
//!
//! ```
//! use nereus::frames::Point;
//! use nereus::geometry::shadow::{Map, Relief, Settings, Shadow};
//! // A wall of 1 m across the way of a radar at 0.1 m per m of grazing: ten metres of shadow.
//! let mut heights_m = vec![0.0; 64 * 32];
//! heights_m[20 * 64..21 * 64].fill(1.0);
//! let map = Map::new(&heights_m, [64, 32], 1.0, [0.0, 0.0])?;
//! let radar = Point::new(31.5, -99_980.0, 10_000.0);
//! assert!(!Relief::of(&map).cannot_shadow(&map, radar, Settings::SHARP));
//! let mut shadow = Shadow::new([64, 32], Settings::SHARP)?;
//! let mut weights = vec![0.0; 64 * 32];
//! shadow.weights(&map, radar, &mut weights)?;
//! let column: Vec<_> = (0..32).filter(|iy| weights[iy * 64 + 5] == 0.0).collect();
//! assert_eq!(column, (21..30).collect::<Vec<_>>());
//! # Ok::<(), nereus::geometry::shadow::ShadowError>(())
//! ```

mod march;
pub mod smith;

use self::march::{March, Sector, UNDER, smoothstep};
use crate::cpu::{Task, Variant};
use crate::frames::{Enu, Point};
use crate::scene::patch::MAX_SIDE;
use crate::sea::surface::fields::Real;

/// Height by which facet centres are raised before they are compared with the horizon, in facet sides.
pub const LIFT: f64 = 1e-3;
/// Most facets of a map.
pub const MAX_FACETS: usize = 1 << 28;
/// Most rays per facet.
pub const MAX_RAYS: usize = 64;
/// Widest edge, rad (as a tangent).
pub const WIDEST_RAD: f64 = 1e3;
/// Largest coordinate of an antenna, m.
pub const FARTHEST_M: f64 = 1e12;

/// Side of the tiles in which maps are transposed.
const TILE: usize = 16;

/// What is wrong with a map, an antenna or the settings.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShadowError {
    /// Too few or too many facets.
    #[error("height map of {nx} x {ny} facets: allowed are 1 to {MAX_SIDE} a side, {MAX_FACETS} in all")]
    Facets {
        /// Along x.
        nx: usize,
        /// Along y.
        ny: usize,
    },
    /// An array that does not have one entry per facet.
    #[error("{array} of a height map of {expected} facets: {found} entries")]
    Length {
        /// Which array.
        array: &'static str,
        /// Its entries.
        found: usize,
        /// Facets of the map.
        expected: usize,
    },
    /// A map of another size than the workspace was made for.
    #[error("height map of {found:?} facets, the workspace was made for {expected:?}")]
    Workspace {
        /// Facets of the map along x and y.
        found: [usize; 2],
        /// Those of the workspace.
        expected: [usize; 2],
    },
    /// Facet size out of range.
    #[error("facet of {facet_m} m in a height map: it must be a length from 1e-6 to 1e9 m")]
    FacetSize {
        /// The size given, m.
        facet_m: f64,
    },
    /// Not a place.
    #[error("{what} at {position_m} m along {axis}: it must be within {FARTHEST_M:e} m of the origin")]
    Place {
        /// `terminal` or `first facet`.
        what: &'static str,
        /// `x`, `y` or `z`.
        axis: char,
        /// The coordinate given, m.
        position_m: f64,
    },
    /// Not a width.
    #[error("shadow edge of {width_rad} rad: allowed are 0 to {WIDEST_RAD}")]
    Width {
        /// The width given, rad.
        width_rad: f64,
    },
    /// Too few or too many rays.
    #[error("{rays} shadow rays per facet: allowed are 1 to {MAX_RAYS}")]
    Rays {
        /// The number given.
        rays: usize,
    },
}

/// Weight of a clearance, m, over facets of a side, for a [`Settings::width_rad`].
pub fn visible(clearance_m: f64, width_rad: f64, facet_m: f64) -> f64 {
    if width_rad > 0.0 {
        smoothstep(clearance_m / (width_rad * facet_m))
    } else {
        f64::from(u8::from(clearance_m > 0.0))
    }
}

/// How visibility is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Clearance, over the side of a facet, at which the weight reaches 1, rad. Zero: at once, as in the
    /// paper: illuminated if and only if nothing stands above the ray.
    pub width_rad: f64,
    /// Rays per facet across the line of sight; the error goes with its inverse square on smooth seas.
    pub rays_per_facet: usize,
}

impl Settings {
    /// The paper's binary rule, two rays per facet.
    pub const SHARP: Self = Self { width_rad: 0.0, rays_per_facet: 2 };

    /// The default: a soft edge as wide as half the slope change of a map ([`half_slope_change_rad`]), two
    /// rays per facet.
    pub fn for_map<T: Real>(map: &Map<T>) -> Self {
        Self { width_rad: half_slope_change_rad(map), ..Self::SHARP }
    }

    fn check(self) -> Result<Self, ShadowError> {
        if !(1..=MAX_RAYS).contains(&self.rays_per_facet) {
            return Err(ShadowError::Rays { rays: self.rays_per_facet });
        }
        if !(0.0..=WIDEST_RAD).contains(&self.width_rad) {
            return Err(ShadowError::Width { width_rad: self.width_rad });
        }
        Ok(self)
    }
}

fn check_sides([nx, ny]: [usize; 2]) -> Result<(), ShadowError> {
    let sides = 1..=MAX_SIDE;
    if sides.contains(&nx) && sides.contains(&ny) && nx * ny <= MAX_FACETS {
        Ok(())
    } else {
        Err(ShadowError::Facets { nx, ny })
    }
}

fn check_place(what: &'static str, position_m: &[f64]) -> Result<(), ShadowError> {
    let mut axes = ['x', 'y', 'z'].into_iter().zip(position_m);
    match axes.find(|(_, x)| !(-FARTHEST_M..=FARTHEST_M).contains(*x)) {
        Some((axis, &position_m)) => Err(ShadowError::Place { what, axis, position_m }),
        None => Ok(()),
    }
}

/// Heights of facet centres.
#[derive(Clone, Copy, Debug)]
pub struct Map<'a, T> {
    heights_m: &'a [T],
    facets: [usize; 2],
    facet_m: f64,
    first_m: [f64; 2],
}

impl<'a, T: Real> Map<'a, T> {
    /// Heights `[iy][ix]`, m, of `facets` along x and y of side `facet_m`; the centre of the first one is at
    /// `first_m`.
    ///
    /// # Errors
    /// Sides out of range, heights that are not as many as facets, a facet or an origin out of range.
    pub fn new(
        heights_m: &'a [T],
        facets: [usize; 2],
        facet_m: f64,
        first_m: [f64; 2],
    ) -> Result<Self, ShadowError> {
        check_sides(facets)?;
        let expected = facets[0] * facets[1];
        if heights_m.len() != expected {
            return Err(ShadowError::Length { array: "heights", found: heights_m.len(), expected });
        }
        if !(1e-6..=1e9).contains(&facet_m) {
            return Err(ShadowError::FacetSize { facet_m });
        }
        check_place("first facet", &first_m)?;
        Ok(Self { heights_m, facets, facet_m, first_m })
    }

    /// Horizontal place in facets from the first one.
    fn place(&self, terminal: Point<Enu>) -> [f64; 2] {
        let [x, y, _] = terminal.to_array();
        [(x - self.first_m[0]) / self.facet_m, (y - self.first_m[1]) / self.facet_m]
    }

    fn rows(&self) -> std::slice::ChunksExact<'a, T> {
        self.heights_m.chunks_exact(self.facets[0])
    }
}

/// Half the rms change of slope over one facet, rad (as a tangent), over both axes: with the second
/// difference `D` of neighbouring heights, `rms(D) / (2 dx)`. Zero for a plane, and for maps of less than
/// three facets a side.
pub fn half_slope_change_rad<T: Real>(map: &Map<T>) -> f64 {
    let (mut sum, mut count) = (0.0, 0_usize);
    let mut add = |before: T, here: T, after: T| {
        let second = before.widen() - 2.0 * here.widen() + after.widen();
        sum += second * second;
        count += 1;
    };
    for row in map.rows() {
        row.windows(3).for_each(|z| add(z[0], z[1], z[2]));
    }
    for ((before, here), after) in map.rows().zip(map.rows().skip(1)).zip(map.rows().skip(2)) {
        for ((before, here), after) in before.iter().zip(here).zip(after) {
            add(*before, *here, *after);
        }
    }
    if count == 0 { 0.0 } else { (sum / count as f64).sqrt() / (2.0 * map.facet_m) }
}

/// The few figures of a map that decide whether it can cast a shadow at all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relief {
    /// Largest height, m.
    pub highest_m: f64,
    /// Steepest rise towards +x and +y between neighbours, as a tangent, not below 0.
    pub rise: [f64; 2],
    /// Steepest fall towards +x and +y between neighbours, as a tangent, not below 0.
    pub fall: [f64; 2],
}

impl Relief {
    /// One pass over the map.
    pub fn of<T: Real>(map: &Map<T>) -> Self {
        Variant::fastest().run(Survey(map))
    }

    /// Whether every weight of such a map is certainly 1: the line of sight is nowhere flatter than the
    /// steepest slope that falls away from the antenna, plus the width of the edge and what interpolation
    /// between rays may take. Of the map only the outline is read. Never true when a weight would be less
    /// than 1; where it is false, there may still be no shadow.
    ///
    /// With `F` and `R` the falls outward along and either way across the dominant axis, `m` the range of
    /// lateral over forward distance, `n` rays per facet:
    /// `(z_T - z_max)/u_max - F - max(m R) - max(R)/n >= w`.
    pub fn cannot_shadow<T: Real>(&self, map: &Map<T>, terminal: Point<Enu>, settings: Settings) -> bool {
        let [x, y] = map.place(terminal);
        let above_m = terminal.to_array()[2] - self.highest_m;
        let enough = |cross: usize, along: usize, inward_first: bool, place: [f64; 2]| {
            let [columns, rows] = [map.facets[cross], map.facets[along]];
            let Some(sector) = Sector::new(columns, rows, place, inward_first) else {
                return true;
            };
            let down = if inward_first { self.fall[along] } else { self.rise[along] };
            let (least, most) = sector.lateral_range();
            let across = (most * self.fall[cross]).max(-least * self.rise[cross]).max(0.0);
            let between = self.rise[cross].max(self.fall[cross]) / settings.rays_per_facet.max(1) as f64;
            above_m / (sector.last() * map.facet_m) >= down + across + between + settings.width_rad
        };
        above_m > 0.0
            && [true, false]
                .into_iter()
                .all(|first| enough(0, 1, first, [x, y]) && enough(1, 0, first, [y, x]))
    }
}

/// The relief of a map.
struct Survey<'a, T>(&'a Map<'a, T>);

impl<T: Real> Task for Survey<'_, T> {
    type Output = Relief;

    #[inline(always)]
    fn run(self) -> Relief {
        let Self(map) = self;
        let mut highest = Extremes::new(f64::NEG_INFINITY);
        let mut steps = [Extremes::new(0.0), Extremes::new(0.0)];
        let mut before: &[T] = &[];
        for row in map.rows() {
            highest.take_in(row, row, |z, _| z);
            steps[0].take_in(row, &row[1..], |west, east| east - west);
            steps[1].take_in(before, row, |south, north| north - south);
            before = row;
        }
        let [highest_m, _] = highest.largest();
        let [[east, west], [north, south]] = steps.map(|axis| axis.largest());
        let [rise, fall] = [[east, north], [west, south]].map(|steps| steps.map(|step| step / map.facet_m));
        Relief { highest_m, rise, fall }
    }
}

/// Largest values of a quantity and of its negative, in lanes that a compiler can put side by side.
struct Extremes {
    most: [f64; Self::LANES],
    most_negative: [f64; Self::LANES],
}

impl Extremes {
    const LANES: usize = 16;

    #[inline(always)]
    fn new(least: f64) -> Self {
        Self { most: [least; Self::LANES], most_negative: [least; Self::LANES] }
    }

    /// The quantity of each pair of neighbours, as long as both slices have one.
    #[inline(always)]
    fn take_in<T: Real>(&mut self, a: &[T], b: &[T], quantity: impl Fn(f64, f64) -> f64) {
        let count = a.len().min(b.len());
        let (whole_a, rest_a) = a[..count].as_chunks::<{ Self::LANES }>();
        let (whole_b, rest_b) = b[..count].as_chunks::<{ Self::LANES }>();
        let mut raise = |lane: usize, value: f64| {
            let (most, negative) = (&mut self.most[lane], &mut self.most_negative[lane]);
            *most = if value > *most { value } else { *most };
            *negative = if -value > *negative { -value } else { *negative };
        };
        for (a, b) in whole_a.iter().zip(whole_b) {
            for lane in 0..Self::LANES {
                raise(lane, quantity(a[lane].widen(), b[lane].widen()));
            }
        }
        for (lane, (a, b)) in rest_a.iter().zip(rest_b).enumerate() {
            raise(lane, quantity(a.widen(), b.widen()));
        }
    }

    #[inline(always)]
    fn largest(&self) -> [f64; 2] {
        [self.most, self.most_negative].map(|lanes| lanes.into_iter().fold(f64::NEG_INFINITY, f64::max))
    }
}

/// Workspace for the visibility of one map size.
#[derive(Clone, Debug)]
pub struct Shadow<T> {
    facets: [usize; 2],
    settings: Settings,
    /// `[ray]`: running maximum.
    horizon: Vec<f64>,
    /// `[ix][iy]`: heights, m.
    turned_heights_m: Vec<T>,
    /// `[ix][iy]`: results of the marches along x.
    turned: Vec<T>,
}

impl<T: Real> Shadow<T> {
    /// For maps of `facets` along x and y. All memory is taken here.
    ///
    /// # Errors
    /// Sides or settings out of range.
    pub fn new(facets: [usize; 2], settings: Settings) -> Result<Self, ShadowError> {
        check_sides(facets)?;
        let settings = settings.check()?;
        let [nx, ny] = facets;
        let rays = Sector::most_rays(nx, ny, settings.rays_per_facet).max(Sector::most_rays(
            ny,
            nx,
            settings.rays_per_facet,
        ));
        Ok(Self {
            facets,
            settings,
            horizon: vec![f64::NEG_INFINITY; rays],
            turned_heights_m: vec![T::default(); nx * ny],
            turned: vec![T::default(); nx * ny],
        })
    }

    /// Visibility weights of all facets from an antenna, `[iy][ix]`, 0 to 1, into `out`.
    ///
    /// # Errors
    /// A map or an output of another size, an antenna out of range.
    pub fn weights(&mut self, map: &Map<T>, terminal: Point<Enu>, out: &mut [T]) -> Result<(), ShadowError> {
        let lift_m = LIFT * map.facet_m;
        let width_m = self.settings.width_rad * map.facet_m;
        if width_m > 0.0 {
            self.march(map, terminal, out, |clearance_m| smoothstep((clearance_m + lift_m) / width_m))
        } else {
            let illuminated = |clearance_m: f64| if clearance_m + lift_m > 0.0 { 1.0 } else { 0.0 };
            self.march(map, terminal, out, illuminated)?;
            // Where two marches are blended and differ, the nearer axis decides.
            for weight in out {
                *weight = if weight.widen() >= 0.5 { T::one() } else { T::zero() };
            }
            Ok(())
        }
    }

    /// Clearances `c` of all facets, m, `[iy][ix]`, without the lift; infinite where nothing is between facet
    /// and antenna. Where marches along both axes are blended, the blend of both clearances.
    ///
    /// # Errors
    /// As [`Self::weights`].
    pub fn clearances_m(
        &mut self,
        map: &Map<T>,
        terminal: Point<Enu>,
        out: &mut [T],
    ) -> Result<(), ShadowError> {
        self.march(map, terminal, out, |clearance_m| clearance_m)
    }

    fn march(
        &mut self,
        map: &Map<T>,
        terminal: Point<Enu>,
        out: &mut [T],
        weigh: impl Fn(f64) -> f64,
    ) -> Result<(), ShadowError> {
        if map.facets != self.facets {
            return Err(ShadowError::Workspace { found: map.facets, expected: self.facets });
        }
        let expected = map.heights_m.len();
        if out.len() != expected {
            return Err(ShadowError::Length { array: "output", found: out.len(), expected });
        }
        let terminal_m = terminal.to_array();
        check_place("terminal", &terminal_m)?;
        let [nx, ny] = self.facets;
        let [x, y] = map.place(terminal);
        let (height_m, rays, variant) = (terminal_m[2], self.settings.rays_per_facet, Variant::fastest());
        let sectors = |columns, rows, place| {
            [true, false].map(|inward_first| Sector::new(columns, rows, place, inward_first))
        };
        out.fill(T::zero());
        for sector in sectors(nx, ny, [x, y]).iter().flatten() {
            let horizon = &mut self.horizon;
            let (heights_m, out, weigh) = (map.heights_m, &mut *out, &weigh);
            variant.run(March { sector, heights_m, height_m, rays, horizon, out, weigh });
        }
        let along_x = sectors(ny, nx, [y, x]);
        if along_x.iter().any(Option::is_some) {
            transpose(map.heights_m, [nx, ny], &mut self.turned_heights_m, |to, from| *to = from);
            self.turned.fill(T::zero());
            for sector in along_x.iter().flatten() {
                let (heights_m, horizon) = (&self.turned_heights_m[..], &mut self.horizon);
                let (out, weigh) = (&mut self.turned[..], &weigh);
                variant.run(March { sector, heights_m, height_m, rays, horizon, out, weigh });
            }
            transpose(&self.turned, [ny, nx], out, |to, from| *to = *to + from);
        }
        // The facet under the antenna belongs to no march.
        if let (Some(ix), Some(iy)) = (under(x, nx), under(y, ny)) {
            out[iy * nx + ix] = T::round_from(weigh(f64::INFINITY));
        }
        Ok(())
    }
}

/// The facet that a place along one axis falls on, if it does.
fn under(place: f64, facets: usize) -> Option<usize> {
    let nearest = place.round();
    ((place - nearest).abs() <= UNDER && (0.0..facets as f64).contains(&nearest)).then_some(nearest as usize)
}

/// Combines `from` (rows of `columns`) into `to` (columns of it side by side), tile by tile.
fn transpose<T: Copy>(from: &[T], [columns, rows]: [usize; 2], to: &mut [T], combine: impl Fn(&mut T, T)) {
    for first_row in (0..rows).step_by(TILE) {
        let last_row = (first_row + TILE).min(rows);
        for first_column in (0..columns).step_by(TILE) {
            for column in first_column..(first_column + TILE).min(columns) {
                for (to, row) in
                    to[column * rows + first_row..column * rows + last_row].iter_mut().zip(first_row..)
                {
                    combine(to, from[row * columns + column]);
                }
            }
        }
    }
}
