//! All fields of several wakes on a rectangle of facets.
//!
//! The waves of each ship are summed by [`nonuniform`](super::nonuniform) FFT. Four pairs are summed, and in
//! deep water all else follows from them facet by facet (u the horizontal velocity, s the slope, q its rate,
//! D the displacement, f ahead, V the speed):
//!
//! | field | from |
//! | --- | --- |
//! | height | `V f.u/g` |
//! | vertical velocity | `-V f.s` |
//! | vertical acceleration | `-V f.q` |
//! | horizontal acceleration | `-g s` |
//!
//! Only what the caller's fields ask for is summed. The window of [`upstream`](super::upstream) is applied
//! last. Fields are **added to**, in the order of the patch, `[iy][ix]`: those of the sea can be
//! passed on. Memory is taken at construction only. The error is relative to the root sum square of the
//! waves' amplitudes, which is the level of the wake over the reach: ahead of the ship and outside the cone,
//! where waves cancel, it is as large as inside. A test holds the largest error of every field against its
//! largest value.
//!
//! Why an FFT: rows of facets by phasors, turned from facet to facet, are as exact, but cost waves times
//! facets; `benches/wake_map.rs` has both side by side.
//!
//! A ship all of whose facets lie ahead of its window adds nothing. An example is at [`super`].

use num_complex::{Complex, Complex64};

use super::course::{Pose, corners_m};
use super::free_waves::Wake;
use super::leg::LegWindow;
use super::nonuniform::NonUniform;
use super::upstream::{Moving, Part, Window};
use crate::cpu::{Task, Variant};
use crate::scene::Patch;
use crate::sea::GRAVITY_MPS2;
use crate::sea::surface::fields::Real;
use crate::sea::surface::{Fields, Grid, SurfaceError};
use crate::sea::wake::fault::WakeError;

/// Evaluates wakes on a rectangle of facets, in f32 or f64.
#[derive(Clone)]
pub struct Map<T: Real> {
    wakes: Vec<Wake>,
    grid: Grid,
    sum: NonUniform<T>,
    steps_rad: Vec<[f64; 2]>,
    /// Per wave: its value at the middle facet, m.
    waves_m: Vec<Complex64>,
    amplitudes: Vec<[Complex<T>; 2]>,
    planes: [Vec<Complex<T>>; 4],
    edges: Edges,
}

/// Tangent of the angle astern beyond which a wake with an end has no waves: the cusps lie at 0.354.
pub(in crate::sea) const SIDE: f64 = 0.8;

/// A pair of fields that is summed, by its plane.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Pair {
    Velocity,
    Slope,
    SlopeRate,
    Displacement,
}

impl Pair {
    const ALL: [Self; 4] = [Self::Velocity, Self::Slope, Self::SlopeRate, Self::Displacement];
}

impl<T: Real> Map<T> {
    /// For wakes on the facets of a patch (any patch of that many facets of that side), with an error in dB.
    ///
    /// # Errors
    /// A wake for facets of another side than those of the patch, or an error that no transform keeps.
    pub fn new(wakes: Vec<Wake>, patch: &Patch, error_db: f64) -> Result<Self, WakeError> {
        let [nx, ny] = patch.facets;
        let grid = Grid::new(nx, ny, patch.facet_m)?;
        if let Some(wake) = wakes.iter().find(|wake| wake.facet_m() != patch.facet_m) {
            return Err(WakeError::FacetsDiffer { wake_m: wake.facet_m(), map_m: patch.facet_m });
        }
        let most = wakes.iter().map(|wake| wake.nodes().len()).max().unwrap_or(0);
        let zero = Complex::new(T::default(), T::default());
        let plane = || vec![zero; grid.len()];
        Ok(Self {
            wakes,
            grid,
            sum: NonUniform::new(patch.facets, most, error_db)?,
            steps_rad: Vec::with_capacity(most),
            waves_m: Vec::with_capacity(most),
            amplitudes: Vec::with_capacity(most),
            planes: [plane(), plane(), plane(), plane()],
            edges: Edges::with_room(nx),
        })
    }

    /// Adds all wakes at a time, s, to every field that is not empty, in the order of the patch, `[iy][ix]`
    /// from its first facet; `first` is the global key of that.
    ///
    /// # Errors
    /// Fields of another size, or a patch beyond the reach of a wake; nothing is added then.
    pub fn add(&mut self, first: [i64; 2], time_s: f64, fields: &mut Fields<T>) -> Result<(), WakeError> {
        check_sizes(fields, self.grid.len())?;
        let patch = Patch { facets: [self.grid.nx(), self.grid.ny()], facet_m: self.grid.facet_m(), first };
        for wake in &self.wakes {
            let pose = wake.pose(time_s)?;
            if touches(wake, (&pose, time_s), &patch) {
                for corner_m in corners_m(&patch) {
                    wake.check_reach(pose.astern_starboard_m(corner_m))?;
                }
            }
        }
        for place in 0..self.wakes.len() {
            self.add_one(place, &patch, time_s, fields)?;
        }
        Ok(())
    }

    fn add_one(
        &mut self,
        place: usize,
        patch: &Patch,
        time_s: f64,
        fields: &mut Fields<T>,
    ) -> Result<(), WakeError> {
        let pose = self.wakes[place].pose(time_s)?;
        if !touches(&self.wakes[place], (&pose, time_s), patch) {
            return Ok(());
        }
        self.turn_to(place, &pose, patch);
        let wanted = Wanted::of(fields);
        let edge = edge_crosses(&self.wakes[place], &pose, patch);
        for (plane, pair) in Pair::ALL.into_iter().enumerate() {
            if wanted.needs(pair, edge) {
                self.weigh(place, &pose, pair);
                self.sum.run(&self.amplitudes, &mut self.planes[plane]);
            }
        }
        let mut edges = std::mem::take(&mut self.edges);
        for iy in 0..patch.facets[1] {
            self.collect_row(place, (&pose, time_s, patch), iy, &mut edges, fields);
        }
        self.edges = edges;
        Ok(())
    }

    /// Phase steps of the waves, and their values at the middle facet.
    fn turn_to(&mut self, place: usize, pose: &Pose, patch: &Patch) {
        let middle = [0, 1].map(|i| patch.first[i] + (patch.facets[i] / 2) as i64);
        let [astern_m, starboard_m] = pose.astern_starboard_m(patch.centre_m(middle));
        self.steps_rad.clear();
        self.waves_m.clear();
        for node in self.wakes[place].nodes() {
            let k = wave_vector(node.ahead_rad_m, node.port_rad_m, pose);
            self.steps_rad.push(k.map(|k| k * patch.facet_m));
            let phase = -(node.ahead_rad_m * astern_m + node.port_rad_m * starboard_m);
            self.waves_m.push(node.amplitude_m * Complex64::cis(phase));
        }
        self.sum.place(&self.steps_rad);
    }

    /// Amplitudes of a pair: `K r Re e` along x and y gives `(Kx + j Ky) r e/2` and the same of the conjugate
    /// of e; `-K r Im e` is `K r Re(j e)`.
    fn weigh(&mut self, place: usize, pose: &Pose, pair: Pair) {
        self.amplitudes.clear();
        for (node, &wave) in self.wakes[place].nodes().iter().zip(&self.waves_m) {
            let turned = Complex64::new(-wave.im, wave.re);
            let (factor, wave) = match pair {
                Pair::Velocity => (node.omega_rad_s / node.k_rad_m, wave),
                Pair::Slope => (1.0, turned),
                Pair::SlopeRate => (node.omega_rad_s, wave),
                Pair::Displacement => (1.0 / node.k_rad_m, turned),
            };
            let [kx, ky] = wave_vector(node.ahead_rad_m, node.port_rad_m, pose);
            let vector = Complex64::new(kx, ky) * (0.5 * factor);
            let round = |value: Complex64| Complex::new(T::round_from(value.re), T::round_from(value.im));
            self.amplitudes.push([round(vector * wave), round(vector * wave.conj())]);
        }
    }

    /// A row of facets from the planes to the fields: pieces where the window is open, and under its edge.
    fn collect_row(
        &self,
        place: usize,
        (pose, time_s, patch): (&Pose, f64, &Patch),
        iy: usize,
        edges: &mut Edges,
        fields: &mut Fields<T>,
    ) {
        let wake = &self.wakes[place];
        let (window, speed_mps, ahead) = (wake.window(), wake.course().speed_mps, pose.ahead);
        let nx = patch.facets[0];
        let key_y = patch.first[1] + iy as i64;
        let astern_m = |ix: usize| {
            let place_m = patch.centre_m([patch.first[0] + ix as i64, key_y]);
            pose.astern_starboard_m(place_m)[0]
        };
        let leg = wake.leg();
        let range_m = leg.map(|leg| leg.range_m(time_s, speed_mps));
        let part_of = |ix: usize| match (range_m, astern_m(ix)) {
            (Some([from_m, _]), astern_m) if astern_m <= from_m => Part::Ahead,
            (Some([_, to_m]), astern_m) if astern_m >= to_m => Part::Astern,
            (_, astern_m) => window.part(astern_m),
        };
        let planes = &self.planes;
        let mut ix = 0;
        while ix < nx {
            let part = part_of(ix);
            // Along a row the distance astern rises or falls, so that each part is in one piece.
            let (mut len, mut beyond) = (1, nx - ix);
            while len < beyond {
                let middle = len + (beyond - len) / 2;
                if part_of(ix + middle) == part { len = middle + 1 } else { beyond = middle }
            }
            let from = iy * nx + ix;
            match part {
                Part::Ahead | Part::Astern => {}
                Part::Open if leg.is_none() => {
                    Variant::fastest().run(Piece { planes, from, len, speed_mps, ahead, fields })
                }
                Part::Open | Part::Bow | Part::End => {
                    edges.astern_m.clear();
                    edges.astern_m.extend((ix..ix + len).map(astern_m));
                    // Planes that were not summed hold old values, which go nowhere.
                    let pairs = planes.each_ref().map(|plane| &plane[from..from + len]);
                    let under = Under { pairs, edges, speed_mps, ahead };
                    let leg = leg.map(|leg| (leg, time_s));
                    Variant::fastest().run(Faded { part, window, leg, under, from, fields });
                }
            }
            ix += len;
        }
    }
}

/// The window of facets side by side under its edge.
#[derive(Clone, Default)]
struct Edges {
    astern_m: Vec<f64>,
    value: Vec<f64>,
    rate_per_m: Vec<f64>,
    rate_per_s: Vec<f64>,
    bend_per_m_s: Vec<f64>,
    bend_per_s2: Vec<f64>,
}

impl Edges {
    fn with_room(facets: usize) -> Self {
        let room = || Vec::with_capacity(facets);
        Self {
            astern_m: room(),
            value: room(),
            rate_per_m: room(),
            rate_per_s: room(),
            bend_per_m_s: room(),
            bend_per_s2: room(),
        }
    }

    #[inline(always)]
    fn find(&mut self, of: impl Fn(f64) -> Moving) {
        let len = self.astern_m.len();
        let Self { astern_m, value, rate_per_m, rate_per_s, bend_per_m_s, bend_per_s2 } = self;
        for row in [&mut *value, rate_per_m, rate_per_s, bend_per_m_s, bend_per_s2] {
            row.resize(len, 0.0);
        }
        let (per_m, per_s) = (&mut rate_per_m[..len], &mut rate_per_s[..len]);
        let (per_m_s, per_s2) = (&mut bend_per_m_s[..len], &mut bend_per_s2[..len]);
        for (i, (value, astern_m)) in value.iter_mut().zip(&*astern_m).enumerate() {
            let edge = of(*astern_m);
            (*value, per_m[i], per_s[i]) = (edge.value, edge.rate_per_m, edge.rate_per_s);
            (per_m_s[i], per_s2[i]) = (edge.bend_per_m_s, edge.bend_per_s2);
        }
    }
}

/// Facets side by side from the planes to the fields, away from the window's edge.
struct Piece<'a, T: Real> {
    planes: &'a [Vec<Complex<T>>; 4],
    from: usize,
    len: usize,
    speed_mps: f64,
    ahead: [f64; 2],
    fields: &'a mut Fields<T>,
}

impl<T: Real> Task for Piece<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { planes, from, len, speed_mps, ahead, fields } = self;
        let [u, s, q, d] = planes.each_ref().map(|plane| &plane[from..from + len]);
        let real = T::round_from;
        let along = ahead.map(|f| real(speed_mps * f));
        let lift = ahead.map(|f| real(speed_mps * f / GRAVITY_MPS2));
        let gravity = real(GRAVITY_MPS2);
        sum(&mut fields.height_m, from, u, |u| lift[0] * u.re + lift[1] * u.im);
        let [vx, vy, vz] = &mut fields.velocity_mps;
        sum(vx, from, u, |u| u.re);
        sum(vy, from, u, |u| u.im);
        sum(vz, from, s, |s| -(along[0] * s.re + along[1] * s.im));
        let [sx, sy] = &mut fields.slope;
        sum(sx, from, s, |s| s.re);
        sum(sy, from, s, |s| s.im);
        let [ax, ay, az] = &mut fields.acceleration_mps2;
        sum(ax, from, s, |s| -(gravity * s.re));
        sum(ay, from, s, |s| -(gravity * s.im));
        sum(az, from, q, |q| -(along[0] * q.re + along[1] * q.im));
        let [dx, dy] = &mut fields.displacement_m;
        sum(dx, from, d, |d| d.re);
        sum(dy, from, d, |d| d.im);
        let [rx, ry] = &mut fields.slope_rate_per_s;
        sum(rx, from, q, |q| q.re);
        sum(ry, from, q, |q| q.im);
    }
}

/// Adds to a field, if it is wanted.
#[inline(always)]
fn sum<T: Real>(field: &mut [T], from: usize, plane: &[Complex<T>], of: impl Fn(&Complex<T>) -> T) {
    let Some(field) = field.get_mut(from..from + plane.len()) else { return };
    for (field, value) in field.iter_mut().zip(plane) {
        *field = *field + of(value);
    }
}

/// The same under the edge of the window, as [`Edge::apply`] has them.
struct Faded<'a, T: Real> {
    part: Part,
    window: Window,
    leg: Option<(LegWindow, f64)>,
    under: Under<'a, T>,
    from: usize,
    fields: &'a mut Fields<T>,
}

/// Facets under the edge.
struct Under<'a, T: Real> {
    pairs: [&'a [Complex<T>]; 4],
    edges: &'a mut Edges,
    speed_mps: f64,
    ahead: [f64; 2],
}

impl<T: Real> Under<'_, T> {
    #[inline(always)]
    fn pair(&self, pair: Pair, i: usize) -> [f64; 2] {
        let value = self.pairs[pair as usize][i];
        [value.re.widen(), value.im.widen()]
    }

    #[inline(always)]
    fn along(&self, pair: Pair, i: usize) -> f64 {
        let [x, y] = self.pair(pair, i);
        self.speed_mps * (self.ahead[0] * x + self.ahead[1] * y)
    }

    #[inline(always)]
    fn height_m(&self, i: usize) -> f64 {
        self.along(Pair::Velocity, i) / GRAVITY_MPS2
    }

    #[inline(always)]
    fn velocity_mps(&self, i: usize, own: f64, path_m: f64) -> f64 {
        self.edges.value[i] * own + self.edges.rate_per_s[i] * path_m
    }

    #[inline(always)]
    fn acceleration_mps2(&self, i: usize, own: f64, velocity_mps: f64, path_m: f64) -> f64 {
        let Edges { value, rate_per_s, bend_per_s2, .. } = &*self.edges;
        value[i] * own + 2.0 * rate_per_s[i] * velocity_mps + bend_per_s2[i] * path_m
    }

    #[inline(always)]
    fn slope(&self, i: usize, axis: usize) -> f64 {
        let f = self.ahead[axis];
        self.edges.value[i] * self.pair(Pair::Slope, i)[axis]
            - f * self.edges.rate_per_m[i] * self.height_m(i)
    }

    #[inline(always)]
    fn slope_rate_per_s(&self, i: usize, axis: usize) -> f64 {
        let Edges { value, rate_per_m, rate_per_s, bend_per_m_s, .. } = &*self.edges;
        let (rate, bend) = (rate_per_s[i], bend_per_m_s[i]);
        let bent = rate_per_m[i] * -self.along(Pair::Slope, i) + bend * self.height_m(i);
        value[i] * self.pair(Pair::SlopeRate, i)[axis] + rate * self.pair(Pair::Slope, i)[axis]
            - self.ahead[axis] * bent
    }
}

impl<T: Real> Task for Faded<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { part, window, leg, under, from, fields } = self;
        let speed_mps = under.speed_mps;
        let len = under.edges.astern_m.len();
        match (leg, part) {
            (Some((leg, time_s)), _) => under
                .edges
                .find(|astern_m| leg.under(&window.rounded_at::<T>(astern_m), time_s, astern_m, speed_mps)),
            (None, Part::Bow) => under.edges.find(|astern_m| window.bow::<T>(astern_m).moving(speed_mps)),
            (None, _) => under.edges.find(|astern_m| window.end::<T>(astern_m).moving(speed_mps)),
        }
        let of = &under;
        put(&mut fields.height_m, from, len, |i| of.edges.value[i] * of.height_m(i));
        let [vx, vy, vz] = &mut fields.velocity_mps;
        let [ax, ay, az] = &mut fields.acceleration_mps2;
        for (axis, (v, a)) in [(vx, ax), (vy, ay)].into_iter().enumerate() {
            put(v, from, len, |i| {
                of.velocity_mps(i, of.pair(Pair::Velocity, i)[axis], of.pair(Pair::Displacement, i)[axis])
            });
            put(a, from, len, |i| {
                let (own, u) =
                    (-GRAVITY_MPS2 * of.pair(Pair::Slope, i)[axis], of.pair(Pair::Velocity, i)[axis]);
                of.acceleration_mps2(i, own, u, of.pair(Pair::Displacement, i)[axis])
            });
        }
        put(vz, from, len, |i| of.velocity_mps(i, -of.along(Pair::Slope, i), of.height_m(i)));
        put(az, from, len, |i| {
            let (own, up) = (-of.along(Pair::SlopeRate, i), -of.along(Pair::Slope, i));
            of.acceleration_mps2(i, own, up, of.height_m(i))
        });
        for (axis, field) in fields.displacement_m.iter_mut().enumerate() {
            put(field, from, len, |i| of.edges.value[i] * of.pair(Pair::Displacement, i)[axis]);
        }
        for (axis, field) in fields.slope.iter_mut().enumerate() {
            put(field, from, len, |i| of.slope(i, axis));
        }
        for (axis, field) in fields.slope_rate_per_s.iter_mut().enumerate() {
            put(field, from, len, |i| of.slope_rate_per_s(i, axis));
        }
    }
}

/// Adds to a field, if it is wanted.
#[inline(always)]
fn put<T: Real>(field: &mut [T], from: usize, len: usize, of: impl Fn(usize) -> f64) {
    let Some(field) = field.get_mut(from..from + len) else { return };
    for (i, field) in field.iter_mut().enumerate() {
        *field = *field + T::round_from(of(i));
    }
}

fn wave_vector(ahead_rad_m: f64, port_rad_m: f64, pose: &Pose) -> [f64; 2] {
    let [cos, sin] = pose.ahead;
    [ahead_rad_m * cos - port_rad_m * sin, ahead_rad_m * sin + port_rad_m * cos]
}

/// Distances astern of the patch's corners: least and largest, m.
fn astern_range_m(pose: &Pose, patch: &Patch) -> [f64; 2] {
    let astern_m = corners_m(patch).map(|corner_m| pose.astern_starboard_m(corner_m)[0]);
    [
        astern_m.iter().copied().fold(f64::INFINITY, f64::min),
        astern_m.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    ]
}

/// Whether some facet may have waves.
fn touches(wake: &Wake, (pose, time_s): (&Pose, f64), patch: &Patch) -> bool {
    let window = wake.window();
    let half_m = window.half_m();
    let [nearest_m, furthest_m] = astern_range_m(pose, patch);
    let before_the_end = window.fade_m().is_none_or(|[_, end_m]| {
        // Beyond twice the Kelvin angle to the side there is nothing either.
        let side_m = corners_m(patch).map(|corner_m| pose.astern_starboard_m(corner_m)[1]);
        let aside_m = SIDE * end_m + half_m.max(0.0);
        nearest_m < end_m
            && side_m.iter().any(|side| *side > -aside_m)
            && side_m.iter().any(|side| *side < aside_m)
    });
    let on_leg = wake.leg().is_none_or(|leg| {
        let [from_m, to_m] = leg.range_m(time_s, wake.course().speed_mps);
        furthest_m > from_m && nearest_m < to_m && to_m > -half_m
    });
    !wake.nodes().is_empty() && on_leg && (half_m < 0.0 || furthest_m > -half_m) && before_the_end
}

/// Whether some facet may be under the edge of the window, or ahead of it.
fn edge_crosses(wake: &Wake, pose: &Pose, patch: &Patch) -> bool {
    let [nearest_m, furthest_m] = astern_range_m(pose, patch);
    let window = wake.window();
    wake.leg().is_some()
        || nearest_m < window.half_m()
        || window.fade_m().is_some_and(|[from_m, _]| furthest_m > from_m)
}

/// Which of the caller's fields are there.
#[derive(Clone, Copy)]
struct Wanted {
    height: bool,
    slope: [bool; 2],
    velocity: [bool; 3],
    acceleration: [bool; 3],
    displacement: [bool; 2],
    slope_rate: [bool; 2],
}

impl Wanted {
    fn of<T: Real>(fields: &Fields<T>) -> Self {
        let there = |field: &Vec<T>| !field.is_empty();
        Self {
            height: there(&fields.height_m),
            slope: fields.slope.each_ref().map(there),
            velocity: fields.velocity_mps.each_ref().map(there),
            acceleration: fields.acceleration_mps2.each_ref().map(there),
            displacement: fields.displacement_m.each_ref().map(there),
            slope_rate: fields.slope_rate_per_s.each_ref().map(there),
        }
    }

    /// Whether a pair must be summed; under the edge of the window the product rule needs more.
    fn needs(&self, pair: Pair, edge: bool) -> bool {
        let some = |wanted: &[bool]| wanted.contains(&true);
        let level = |wanted: &[bool; 3]| some(&wanted[..2]);
        let (slope, rate) = (some(&self.slope), some(&self.slope_rate));
        let (uz, az) = (self.velocity[2], self.acceleration[2]);
        match pair {
            Pair::Velocity => {
                self.height
                    || level(&self.velocity)
                    || edge && (slope || rate || uz || az || level(&self.acceleration))
            }
            Pair::Slope => slope || uz || level(&self.acceleration) || edge && (rate || az),
            Pair::SlopeRate => rate || az,
            Pair::Displacement => {
                some(&self.displacement) || edge && (level(&self.velocity) || level(&self.acceleration))
            }
        }
    }
}

fn check_sizes<T: Real>(fields: &Fields<T>, needed: usize) -> Result<(), SurfaceError> {
    match fields.columns().map(<[T]>::len).into_iter().find(|&found| found != 0 && found != needed) {
        Some(found) => Err(SurfaceError::FieldSize { found, needed }),
        None => Ok(()),
    }
}
