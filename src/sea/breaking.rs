//! Breaking waves: how much of the surface they cover, how fast they run, how large they are and how long
//! they last.
//!
//! - **Coverage** `W = 3.84e-6 U10^3.41`, Monahan and O'Muircheartaigh 1980 (whitecaps, `U10` in m/s). Their
//!   data end at some 17 m/s; above [`MOST_WIND_MPS`] it is held.
//! - **Speeds**: Phillips' crest length per area and speed `L(c) ~ c^-6` (1985) times what a crest sweeps in
//!   its life, `w = c T/4 ~ c^2`: the coverage is spread over speeds as `c^-4`, from `c_0` to `c_1`:
//!   `c_1 = min(0.8 c_p, 6 m/s)`, at least 1.3 (`c_p = 1.2 U10`, a fully risen sea),
//!   `c_0 = min(c_1/2, 2 m/s)`.
//! - **Lives** are a quarter of the period `T = 2 pi c/g` of a wave as fast: 0.1 to 1 s.
//! - **Areas** are exponential, as lengths of crests are, about `lambda^2/8`: `lambda/4` wide and in the mean
//!   half a wave `lambda = c T` long.
//! - **Directions** are Gaussian about the wind, 30 degrees rms.
//! - **Scatterers**: what breaks of a wave is many square metres of rough water. Each wave is cut into equal
//!   parts of at most one square metre, at random places in what breaks of it and with random phases of their
//!   own; they run, live and die together. One point a wave would return ten times the fourth moment.
//!
//! - **Where**: six times as many points as break are scattered over water and time at random, in cells of
//!   32 m and slots of half a second that are drawn from the seed and their numbers alone; those break under
//!   which the resolved surface accelerates downwards by more than its standard deviation in the middle of
//!   the slot. Of a Gaussian sea that is 0.159 of all, whatever the size of facets, so that the mean is kept.
//!
//! A breaker runs straight on at its speed `c`, at the height of the crest that it was found on, with an
//! amplitude `sqrt(8/3) sin^2(pi s)` over its life `0 <= s <= 1`.
//!
//! `c_0`, the fastest breaker, the life's and the area's fractions of a wave and the spread are choices; the
//! mean echo depends on the coverage and the spread alone.

use std::f64::consts::{PI, TAU};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Exp1, Poisson, StandardNormal};

use super::GRAVITY_MPS2;
use crate::rng::{Room, stream};

/// Wind at 10 m above which the coverage is held, m/s.
pub const MOST_WIND_MPS: f64 = 20.0;
/// Rms direction in which breakers run, about the wind, rad.
pub const SPREAD_RAD: f64 = TAU / 12.0;

/// Share of the surface that breaks in a wind at 10 m, m/s.
///
/// ```
/// use nereus::sea::breaking::coverage;
/// assert!((coverage(10.0) - 0.00987).abs() < 1e-5);
/// ```
pub fn coverage(u10_mps: f64) -> f64 {
    3.84e-6 * u10_mps.clamp(0.0, MOST_WIND_MPS).powf(3.41)
}

/// Directions from the wind and their weights: three nodes of the mean over the spread.
pub const DIRECTIONS: [(f64, f64); 3] =
    [(0.0, 2.0 / 3.0), (-SQRT_3 * SPREAD_RAD, 1.0 / 6.0), (SQRT_3 * SPREAD_RAD, 1.0 / 6.0)];
const SQRT_3: f64 = 1.732_050_807_568_877_2;

/// Acceleration downwards, in deviations of it, from which a wave may break.
pub const STEEPEST_SIGMA: f64 = 1.0;
/// Chance that a Gaussian exceeds it.
const STEEP_SHARE: f64 = 0.158_655_253_931_457_05;
/// Speeds of breakers, m/s: the slowest and the fastest in any wind, and the slowest in a fresh one.
const SLOWEST_MPS: f64 = 0.65;
const FASTEST_MPS: f64 = 6.0;
const LEAST_MPS: f64 = 2.0;
/// Speed of the dominant waves of a fully risen sea over the wind, and of the fastest breakers over them.
const PEAK_OVER_WIND: f64 = 1.2;
const FASTEST_SHARE: f64 = 0.8;
/// Share of a period for which a wave breaks.
const LIFE_SHARE: f64 = 0.25;
/// Largest part of a wave that scatters as a point, m^2.
const LARGEST_M2: f64 = 1.0;
/// What breaks of a wave along its travel, over its length, and at most along its crest to either side.
const WIDTH_SHARE: f64 = 0.25;
const HALF_CREST_SHARE: f64 = 1.0;
/// Side of the cells in which breakers are drawn, m, and length of the slots of time in which they are born,
/// s.
pub const CELL_M: f64 = 32.0;
pub const SLOT_S: f64 = 0.5;

/// Where a wave may break.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// East and North, m: there the surface decides.
    pub place_m: [f64; 2],
    /// Uniform, 0 to 1: decides where there are no waves.
    lot: f64,
    slot: i64,
    /// Of the wave and its scatterers.
    seed: u64,
}

/// A scatterer of a wave that breaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breaker {
    /// Where it is in the middle of its slot, East and North, m.
    pub place_m: [f64; 2],
    /// Middle of the slot, s after pulse 0.
    pub middle_s: f64,
    /// Begin, s after pulse 0.
    pub born_s: f64,
    /// Length of its life, s.
    pub life_s: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Unit vector along its travel, East and North.
    pub travel: [f64; 2],
    /// Its part of the area that breaks, mean over its life, m^2.
    pub area_m2: f64,
    /// Phases of the like-polarised echo and of the cross-polarised one, rad.
    pub phases_rad: [f64; 2],
}

impl Candidate {
    /// Whether it breaks in waves with a downward acceleration, in deviations of it; `None` where there are
    /// no waves.
    pub fn breaks(&self, downwards_sigma: Option<f64>) -> bool {
        downwards_sigma.map_or(self.lot < STEEP_SHARE, |own| own > STEEPEST_SIGMA)
    }
}

impl Breaker {
    /// Where it is at a time, East and North, m.
    pub fn at_m(&self, elapsed_s: f64) -> [f64; 2] {
        let run_m = self.speed_mps * (elapsed_s - self.middle_s);
        [0, 1].map(|i| self.place_m[i] + run_m * self.travel[i])
    }

    /// Whether it is alive at any instant between two times.
    pub fn lives(&self, from_s: f64, to_s: f64) -> bool {
        self.born_s <= to_s && from_s <= self.born_s + self.life_s
    }

    /// Amplitude at a time over its root mean square over the life: `sqrt(8/3) sin^2`, smooth at both ends.
    pub fn envelope(&self, elapsed_s: f64) -> f64 {
        let share = (elapsed_s - self.born_s) / self.life_s;
        if !(0.0..=1.0).contains(&share) {
            return 0.0;
        }
        let sin = (PI * share).sin();
        (8.0f64 / 3.0).sqrt() * sin * sin
    }
}

/// What breaks in a wind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    downwind_rad: f64,
    speeds_mps: [f64; 2],
    coverage: f64,
    /// Scatterers, mean: births per area and time, 1/(m^2 s), and alive per area, 1/m^2.
    births_per_m2_s: f64,
    alive_per_m2: f64,
    seed: u64,
}

impl Law {
    /// Of a wind at 10 m, m/s, that blows towards an angle from East, rad; `None` where nothing breaks.
    pub fn new(u10_mps: f64, downwind_rad: f64, seed: u64) -> Option<Self> {
        let coverage = coverage(u10_mps);
        let dominant_mps = FASTEST_SHARE * PEAK_OVER_WIND * u10_mps;
        let fastest_mps = dominant_mps.clamp(2.0 * SLOWEST_MPS, FASTEST_MPS);
        let speeds_mps = [(0.5 * fastest_mps).min(LEAST_MPS), fastest_mps];
        let [births_per_m2_s, alive_per_m2] = scatterers(speeds_mps).map(|of| coverage * of);
        (coverage > 0.0).then_some(Self {
            downwind_rad,
            speeds_mps,
            coverage,
            births_per_m2_s,
            alive_per_m2,
            seed,
        })
    }

    /// Share of the surface that breaks, mean.
    pub fn coverage(&self) -> f64 {
        self.coverage
    }

    /// Births of waves per area and time, 1/(m^2 s): the integral of `W f(c)/(A(c) T(c)/4)`, `f ~ c^-4` of
    /// integral 1.
    pub fn waves_per_m2_s(&self) -> f64 {
        let of = |power: i32| self.speeds_mps[0].powi(-power) - self.speeds_mps[1].powi(-power);
        // Area and life over c^4 and c.
        let (area, life) = (area_m2(1.0), life_s(1.0));
        self.coverage * 3.0 / of(3) * of(8) / (8.0 * area * life)
    }

    /// Births of scatterers per area and time, mean, 1/(m^2 s).
    pub fn births_per_m2_s(&self) -> f64 {
        self.births_per_m2_s
    }

    /// Scatterers that are alive per area, mean, 1/m^2.
    pub fn alive_per_m2(&self) -> f64 {
        self.alive_per_m2
    }

    /// Longest life, s, and how far a scatterer may be from where its wave is found, m.
    pub fn reach(&self) -> (f64, f64) {
        let fastest_mps = self.speeds_mps[1];
        let (life_s, length_m) = (life_s(fastest_mps), length_m(fastest_mps));
        let off_m = length_m * HALF_CREST_SHARE.hypot(0.5 * WIDTH_SHARE);
        (life_s, off_m + fastest_mps * (life_s + 0.5 * SLOT_S))
    }

    /// Hands over all places of a cell and a slot where a wave may break: more than break, by what the
    /// surface leaves of them.
    pub fn candidates(&self, cell: [i64; 2], slot: i64, mut each: impl FnMut(&Candidate)) {
        let mean = self.waves_per_m2_s() / STEEP_SHARE * CELL_M * CELL_M * SLOT_S;
        let Ok(law) = Poisson::new(mean) else { return };
        // Cells as many as there are in 1e11 m are told apart.
        let address = (cell[0] as u32 as u64) << 32 | u64::from(cell[1] as u32);
        let mut rng = stream(self.seed, Room::Breaker, address, slot as u64);
        let count = rng.sample(law) as u64;
        for _ in 0..count {
            let [x, y, lot] = [(); 3].map(|()| rng.random::<f64>());
            let place_m = [(cell[0] as f64 + x) * CELL_M, (cell[1] as f64 + y) * CELL_M];
            each(&Candidate { place_m, lot, slot, seed: rng.random() });
        }
    }

    /// Hands over the scatterers of the wave that breaks at a candidate's place.
    pub fn scatterers(&self, of: &Candidate, mut each: impl FnMut(Breaker)) {
        let mut rng = ChaCha8Rng::seed_from_u64(of.seed);
        let [born, speed] = [(); 2].map(|()| rng.random::<f64>());
        let (off, area): (f64, f64) = (rng.sample(StandardNormal), rng.sample(Exp1));
        let [slow, fast] = self.speeds_mps.map(|c| c.powi(-8));
        let speed_mps = (slow + speed * (fast - slow)).powf(-0.125);
        let begin_s = of.slot as f64 * SLOT_S;
        let (sin, cos) = (self.downwind_rad + SPREAD_RAD * off).sin_cos();
        let (length_m, area_m2) = (length_m(speed_mps), area * area_m2(speed_mps));
        let width_m = WIDTH_SHARE * length_m;
        let crest_m = (area_m2 / width_m).min(2.0 * HALF_CREST_SHARE * length_m);
        let parts = (area_m2 / LARGEST_M2).ceil().max(1.0);
        for _ in 0..parts as u64 {
            let [along, across] = [width_m, crest_m].map(|side_m| side_m * (rng.random::<f64>() - 0.5));
            let [east, north] = of.place_m;
            each(Breaker {
                place_m: [east + along * cos - across * sin, north + along * sin + across * cos],
                middle_s: begin_s + 0.5 * SLOT_S,
                born_s: begin_s + born * SLOT_S,
                life_s: life_s(speed_mps),
                speed_mps,
                travel: [cos, sin],
                area_m2: area_m2 / parts,
                phases_rad: [(); 2].map(|()| TAU * rng.random::<f64>()),
            });
        }
    }
}

/// Scatterers between two speeds for a coverage of 1: births, 1/(m^2 s), and alive, 1/m^2. Parts of at most
/// `LARGEST_M2` of areas that are exponential about `a` are `1/(1 - exp(-LARGEST_M2/a))` in the mean.
fn scatterers([slow, fast]: [f64; 2]) -> [f64; 2] {
    const STEPS: usize = 512;
    let step = (fast - slow) / STEPS as f64;
    let level = 3.0 / (slow.powi(-3) - fast.powi(-3));
    let mut sums = [0.0; 2];
    for n in 0..STEPS {
        let speed = slow + (n as f64 + 0.5) * step;
        let area = area_m2(speed);
        let alive = level * speed.powi(-4) / (area * -(-LARGEST_M2 / area).exp_m1()) * step;
        sums[0] += alive / life_s(speed);
        sums[1] += alive;
    }
    sums
}

fn length_m(speed_mps: f64) -> f64 {
    TAU * speed_mps * speed_mps / GRAVITY_MPS2
}

fn life_s(speed_mps: f64) -> f64 {
    LIFE_SHARE * TAU * speed_mps / GRAVITY_MPS2
}

/// Mean area of breakers of a speed: an eighth of the square of the wave's length.
fn area_m2(speed_mps: f64) -> f64 {
    0.5 * WIDTH_SHARE * length_m(speed_mps) * length_m(speed_mps)
}
