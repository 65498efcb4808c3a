//! Visibility against closed forms, symmetries and a ray test written from the definition.

use nereus::frames::{Earth, Enu, Point};
use nereus::geometry::shadow::{LIFT, Map, Settings, Shadow, half_slope_change_rad};
use nereus::scene::water::{Development, Dispersion, WindProfile};
use nereus::sea::spectrum::Elfouhaily;
use nereus::sea::surface::{Averaging, Evaluator, Fields, Grid, Selection, Surface};
use nereus::sea::wind::Wind;

/// A map that owns its heights, with its first facet centre at `first_m`.
#[derive(Clone)]
pub struct Ground {
    pub heights_m: Vec<f64>,
    pub facets: [usize; 2],
    pub facet_m: f64,
    pub first_m: [f64; 2],
}

impl Ground {
    pub fn new(facets: [usize; 2], facet_m: f64, height: impl Fn(usize, usize) -> f64) -> Self {
        let heights_m = (0..facets[1]).flat_map(|iy| (0..facets[0]).map(move |ix| (ix, iy)));
        let heights_m = heights_m.map(|(ix, iy)| height(ix, iy)).collect();
        Self { heights_m, facets, facet_m, first_m: [-7.0, 11.0] }
    }

    pub fn map(&self) -> Map<'_, f64> {
        Map::new(&self.heights_m, self.facets, self.facet_m, self.first_m).unwrap()
    }

    pub fn z(&self, ix: usize, iy: usize) -> f64 {
        self.heights_m[iy * self.facets[0] + ix]
    }

    /// `range_m` from the middle of the map, in the direction `azimuth_deg` from x towards y.
    pub fn terminal(&self, range_m: f64, azimuth_deg: f64, grazing_deg: f64) -> Point<Enu> {
        let (sin, cos) = azimuth_deg.to_radians().sin_cos();
        let middle = |i: usize| self.first_m[i] + 0.5 * (self.facets[i] - 1) as f64 * self.facet_m;
        let height_m = range_m * grazing_deg.to_radians().tan();
        Point::new(middle(0) + range_m * cos, middle(1) + range_m * sin, height_m)
    }

    pub fn weights(&self, settings: Settings, terminal: Point<Enu>) -> Vec<f64> {
        let mut out = vec![f64::NAN; self.heights_m.len()];
        Shadow::new(self.facets, settings).unwrap().weights(&self.map(), terminal, &mut out).unwrap();
        out
    }

    fn clearances_m(&self, settings: Settings, terminal: Point<Enu>) -> Vec<f64> {
        let mut out = vec![f64::NAN; self.heights_m.len()];
        Shadow::new(self.facets, settings).unwrap().clearances_m(&self.map(), terminal, &mut out).unwrap();
        out
    }
}

/// An Elfouhaily sea at 8 m/s in facets of 1 m.
pub fn sea(side: usize, seed: u64, time_s: f64) -> Ground {
    let wind = Wind::from_speed(8.0, 10.0, WindProfile::Cardone, 0.4).unwrap();
    let spectrum = Elfouhaily::new(&wind, Development::default()).unwrap();
    let grid = Grid::new(side, side, 1.0).unwrap();
    let surface =
        Surface::synthesise(grid, &spectrum, Dispersion::default(), seed, Averaging::Automatic).unwrap();
    let mut fields = Fields::<f64>::new(&grid, Selection::HEIGHT);
    Evaluator::new(&surface).evaluate(time_s, &mut fields).unwrap();
    Ground::new([side, side], 1.0, |ix, iy| fields.height_m[iy * side + ix])
}

fn smoothstep(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

/// What the ray test finds along one axis.
struct Traced {
    clearance_m: f64,
    /// Whether the line comes onto the map across its edge, not its side.
    through_front: bool,
}

/// The definition, ray by ray: lines across `axis` (0: x, 1: y) between the terminal and the facet.
fn trace(ground: &Ground, terminal: Point<Enu>, facet: [usize; 2], axis: usize) -> Traced {
    let t = terminal.to_array();
    let other = 1 - axis;
    let place = |i: usize| (t[i] - ground.first_m[i]) / ground.facet_m;
    let (along, across) = (place(axis), place(other));
    let forward = facet[axis] as f64 - along;
    let own_m = ground.z(facet[0], facet[1]) - t[2];
    let mut traced = Traced { clearance_m: f64::INFINITY, through_front: true };
    for line in 0..ground.facets[axis] {
        let ratio = (line as f64 - along) / forward;
        if !(1e-9 / forward.abs()..1.0 - 1e-12).contains(&ratio) {
            continue;
        }
        let lateral = across + ratio * (facet[other] as f64 - across);
        let last = (ground.facets[other] - 1) as f64;
        if !(-1e-9..=last + 1e-9).contains(&lateral) {
            traced.through_front = false;
            continue;
        }
        let lateral = lateral.clamp(0.0, last);
        let cell = (lateral as usize).min(ground.facets[other].saturating_sub(2));
        let at = |i: usize| if axis == 0 { ground.z(line, i) } else { ground.z(i, line) };
        let (a, b) = (at(cell), at((cell + 1).min(ground.facets[other] - 1)));
        let height_m = a + (b - a) * (lateral - cell as f64);
        traced.clearance_m = traced.clearance_m.min(own_m - (height_m - t[2]) / ratio);
    }
    traced
}

/// Share of the march along y, as documented: equal parts on the diagonal, one alone an eighth off it.
fn share_of_y(ground: &Ground, terminal: Point<Enu>, facet: [usize; 2]) -> f64 {
    let t = terminal.to_array();
    let [dx, dy] = [0, 1].map(|i| ((t[i] - ground.first_m[i]) / ground.facet_m - facet[i] as f64).abs());
    smoothstep(0.5 + 8.0 * (dy - dx) / (dx + dy))
}

fn facets(ground: &Ground) -> impl Iterator<Item = [usize; 2]> + use<> {
    let [nx, ny] = ground.facets;
    (0..ny).flat_map(move |iy| (0..nx).map(move |ix| [ix, iy]))
}

/// A level plane: the line next before a facet is its horizon, one facet nearer along the dominant axis.
#[test]
fn a_plane_never_shadows_itself() {
    for facet_m in [0.1, 1.0, 30.0] {
        let level = Ground::new([33, 20], facet_m, |_, _| 0.0);
        assert_eq!(half_slope_change_rad(&level.map()), 0.0);
        let tilted = Ground::new([33, 20], facet_m, |ix, iy| facet_m * (0.02 * ix as f64 - 0.05 * iy as f64));
        for grazing_deg in [1e-9, 1e-6, 1e-3, 0.3, 5.0, 45.0, 89.0] {
            for azimuth_deg in (0..24).map(|i| 15.0 * f64::from(i) + 0.1) {
                for range_m in [3.0, 40.0, 3e3, 8e5] {
                    let terminal = level.terminal(range_m, azimuth_deg, grazing_deg);
                    for settings in [Settings::SHARP, Settings::for_map(&level.map())] {
                        let weights = level.weights(settings, terminal);
                        assert!(weights.iter().all(|&v| v == 1.0), "{facet_m} m, {terminal:?}");
                    }
                    // Above the plane of the tilted map by its largest slope and the same grazing angle.
                    let mut above = terminal.to_array();
                    above[2] = tilted.heights_m.iter().copied().fold(above[2], f64::max);
                    above[2] += 0.07 * (range_m + 40.0 * facet_m) + 1e-6 * range_m;
                    let terminal = Point::new(above[0], above[1], above[2]);
                    assert!(tilted.weights(Settings::SHARP, terminal).iter().all(|&v| v == 1.0));
                }
            }
        }
    }
}

/// With a width the plane's weight has a closed form in the local grazing angle.
#[test]
fn a_plane_under_a_soft_edge_follows_the_grazing_angle() {
    let ground = Ground::new([12, 15], 2.0, |_, _| 0.0);
    let settings = Settings { width_rad: 0.05, rays_per_facet: 2 };
    let mut worst = 0.0_f64;
    for tangent in [0.0, 1e-3, 0.01, 0.03, 0.06] {
        // Between two columns, far to the south.
        let terminal = Point::new(ground.first_m[0] + 11.0, ground.first_m[1] - 1e5, 1e5 * tangent);
        let weights = ground.weights(settings, terminal);
        for [ix, iy] in facets(&ground).filter(|&[_, iy]| iy > 0) {
            // u falls by one facet from P to Q: c = z_T dx / u_Q.
            let clearance_m = 1e5 * tangent * 2.0 / (1e5 + 2.0 * (iy as f64 - 1.0));
            let expected = smoothstep((clearance_m / 2.0 + LIFT) / 0.05);
            worst = worst.max((weights[iy * 12 + ix] - expected).abs());
        }
    }
    println!("plane under a soft edge: worst error {worst:.1e}");
    // c comes from heights of 1e5 m * 0.06, reduced by cancellation to 1e-13 m; 1.5/0.1 m times that.
    assert!(worst < 1e-11);
}

/// The shadow of a wall across the map, from all sides: h / tan(grazing) along the ray, within one facet.
#[test]
fn a_wall_casts_a_shadow_of_its_height_over_the_grazing_angle() {
    let (side, height_m) = (90, 1.3);
    let mut checked = 0;
    for across_x in [false, true] {
        let ground = Ground::new([side, side], 1.0, |ix, iy| {
            let line = if across_x { ix } else { iy };
            if line == 45 { height_m } else { 0.0 }
        });
        for turn in (0..36).map(|i| 10.0 * f64::from(i) + 3.0) {
            let terminal = ground.terminal(9e4, turn, 2.5);
            let weights = ground.weights(Settings::SHARP, terminal);
            let (sin, cos) = turn.to_radians().sin_cos();
            let (forward, lateral) = if across_x { (cos, sin) } else { (sin, cos) };
            if forward.abs() < 0.75 {
                continue;
            }
            // Along the axis, the shadow is shorter by the cosine of the obliquity.
            let length = (height_m - LIFT) / 2.5f64.to_radians().tan() * forward.abs();
            for column in 0..side {
                let hits = column as f64 + (length + 2.0) * lateral / forward * forward.signum();
                if !(1.0..(side - 2) as f64).contains(&hits) {
                    continue;
                }
                let dark = (0..side)
                    .filter(|&line| {
                        let (ix, iy) = if across_x { (line, column) } else { (column, line) };
                        weights[iy * side + ix] == 0.0
                    })
                    .collect::<Vec<_>>();
                // Away from the terminal, starting right behind the wall, without a gap.
                let behind = |k: usize| if forward > 0.0 { 44 - k } else { 46 + k };
                let mut expected: Vec<_> = (0..dark.len()).map(behind).collect();
                expected.sort_unstable();
                assert_eq!(dark, expected, "azimuth {turn}");
                assert!((dark.len() as f64 - length).abs() <= 1.0, "{} for {length}", dark.len());
                checked += 1;
            }
        }
    }
    println!("shadows of a wall: {checked} columns");
    assert!(checked > 1500);
}

/// A post: its shadow lies along the ray in every quadrant and ends where it should.
#[test]
fn a_post_casts_its_shadow_along_the_ray() {
    let (side, middle, height_m) = (101, 50_usize, 2.0);
    let ground =
        Ground::new([side, side], 1.0, |ix, iy| if (ix, iy) == (middle, middle) { height_m } else { 0.0 });
    let tangent = 4f64.to_radians().tan();
    for azimuth_deg in (0..48).map(|i| 7.5 * f64::from(i)) {
        let terminal = ground.terminal(1e5, azimuth_deg, 4.0);
        let weights = ground.weights(Settings::SHARP, terminal);
        let (sin, cos) = azimuth_deg.to_radians().sin_cos();
        let mut farthest = 0.0_f64;
        for [ix, iy] in facets(&ground).filter(|&[ix, iy]| weights[iy * side + ix] == 0.0) {
            let [x, y] = [ix, iy].map(|i| i as f64 - middle as f64);
            let (away, aside) = (-x * cos - y * sin, x * sin - y * cos);
            assert!(away > 0.0, "{azimuth_deg}: dark before the post at ({x}, {y})");
            // One cell each for the ramps of the post between grid points and between rays.
            assert!(aside.abs() <= 1.5, "{azimuth_deg}: dark at ({x}, {y})");
            farthest = farthest.max(away);
        }
        // Facet centres lie up to half a facet off the ray, where the ramp beside the post is half as high at
        // most times the cosine: only an upper bound is sharp, the lower one is half of it.
        let length = height_m / tangent;
        assert!(farthest <= length && farthest >= 0.5 * length - 1.0, "{azimuth_deg}: {farthest}");
    }
}

/// The eight symmetries of the square, applied to the map and the terminal together.
#[test]
fn turned_and_mirrored_scenes_have_turned_and_mirrored_weights() {
    let side = 48;
    let mut worst = 0.0_f64;
    for seed in 0..3 {
        let mut ground = sea(side, seed, 0.0);
        // Centred on the origin, so that a turned terminal is exactly that.
        ground.first_m = [-23.5, -23.5];
        let settings = Settings::for_map(&ground.map());
        for (range_m, azimuth_deg, grazing_deg) in [
            (8e5, 20.0, 25.0),
            (5e3, 45.0, 1.0),
            (5e3, 100.0, 0.3),
            (300.0, 222.0, 3.0),
            (30.0, 310.0, 4.0),
            (10.0, 77.0, 10.0),
            (0.5f64.sqrt(), 45.0, 60.0),
        ] {
            let terminal = ground.terminal(range_m, azimuth_deg, grazing_deg);
            let weights = ground.weights(settings, terminal);
            let sharp = ground.weights(Settings::SHARP, terminal);
            for symmetry in 0..8 {
                let turn = |[x, y]: [f64; 2]| {
                    let [x, y] = if symmetry & 1 == 0 { [x, y] } else { [y, x] };
                    let x = if symmetry & 2 == 0 { x } else { -x };
                    [x, if symmetry & 4 == 0 { y } else { -y }]
                };
                let cell = |[ix, iy]: [usize; 2]| {
                    let [x, y] = turn([ix as f64 - 23.5, iy as f64 - 23.5]);
                    (y + 23.5) as usize * side + (x + 23.5) as usize
                };
                let mut turned = ground.clone();
                for at in facets(&ground) {
                    turned.heights_m[cell(at)] = ground.z(at[0], at[1]);
                }
                let [x, y, z] = terminal.to_array();
                let [x, y] = turn([x, y]);
                let terminal = Point::new(x, y, z);
                let (soft, hard) =
                    (turned.weights(settings, terminal), turned.weights(Settings::SHARP, terminal));
                for at in facets(&ground) {
                    let here = at[1] * side + at[0];
                    worst = worst.max((weights[here] - soft[cell(at)]).abs());
                    assert_eq!(sharp[here], hard[cell(at)], "symmetry {symmetry} at {at:?}");
                }
            }
        }
    }
    println!("symmetries of the square: worst difference {worst:.1e}");
    assert!(worst <= 1e-12);
}

/// Against the ray test. Two rays a step apart that embrace a facet's own see heights that differ from it by
/// the kink of linear interpolation, at most D/4 times their distance (1/n of a facet), D the largest second
/// difference; and the maximum over points, taken ray by ray, exceeds the true one by at most the change of
/// a point's height between the rays, g/n. Perspective scales a point's error and the rays' distance there
/// by the same ratio. So |c - c_ray| <= (D/4 + g)/n.
#[test]
fn clearances_agree_with_the_ray_test() {
    let side = 64;
    for rays_per_facet in [1, 2, 8] {
        let (mut worst, mut squares, mut flips, mut count) = (0.0_f64, 0.0, 0, 0);
        let mut worst_weight = 0.0_f64;
        for seed in 0..3 {
            let ground = sea(side, seed, 0.0);
            let map = ground.map();
            let width_rad = half_slope_change_rad(&map);
            let settings = Settings { width_rad, rays_per_facet };
            let (mut kink_m, mut step_m) = (0.0_f64, 0.0_f64);
            for i in 0..side {
                for j in 1..side {
                    for at in [|i, j| [i, j], |i, j| [j, i]] {
                        let z = |j| ground.z(at(i, j)[0], at(i, j)[1]);
                        step_m = step_m.max((z(j) - z(j - 1)).abs());
                        if j + 1 < side {
                            kink_m = kink_m.max((z(j + 1) - 2.0 * z(j) + z(j - 1)).abs());
                        }
                    }
                }
            }
            let bound_m = (kink_m / 4.0 + step_m) / rays_per_facet as f64;
            for (range_m, azimuth_deg, grazing_deg) in [
                (2e4, 3.0, 0.3),
                (2e4, 71.0, 1.0),
                (8e5, 135.0, 3.0),
                (3e3, 200.0, 8.0),
                (100.0, 291.0, 5.0),
                (20.0, 33.0, 10.0),
                (0.3, 90.0, 80.0),
            ] {
                let terminal = ground.terminal(range_m, azimuth_deg, grazing_deg);
                let (clearances_m, weights) =
                    (ground.clearances_m(settings, terminal), ground.weights(settings, terminal));
                let sharp = ground.weights(Settings { width_rad: 0.0, ..settings }, terminal);
                for facet in facets(&ground) {
                    let here = facet[1] * side + facet[0];
                    let share = share_of_y(&ground, terminal, facet);
                    let (mut expected_m, mut expected, mut front) = (0.0, 0.0, true);
                    for (axis, share) in [(1, share), (0, 1.0 - share)] {
                        if share > 0.0 {
                            let traced = trace(&ground, terminal, facet, axis);
                            expected_m += share * traced.clearance_m;
                            expected += share * smoothstep((traced.clearance_m + LIFT) / width_rad);
                            front &= traced.through_front;
                        }
                    }
                    let error_m = clearances_m[here] - expected_m;
                    if expected_m == f64::INFINITY {
                        assert_eq!(clearances_m[here], f64::INFINITY, "{facet:?} from {terminal:?}");
                        assert!(expected < 1.0 || weights[here] == 1.0);
                    } else if front {
                        worst = worst.max(error_m.abs() / bound_m);
                        worst_weight = worst_weight.max((weights[here] - expected).abs());
                    }
                    squares += (weights[here] - expected).powi(2);
                    flips += usize::from((sharp[here] > 0.5) != (expected_m + LIFT > 0.0));
                    count += 1;
                }
            }
        }
        let rms = (squares / count as f64).sqrt();
        println!(
            "{rays_per_facet} rays per facet against the ray test: weight rms {rms:.4}, worst {worst_weight:.3}, \
             clearance {worst:.3} of its bound; sharp rule {:.2} % other",
            100.0 * f64::from(u32::try_from(flips).unwrap()) / count as f64
        );
        assert!(worst <= 1.0, "{worst}");
    }
}

/// f32 heights and weights are the f64 ones, rounded.
#[test]
fn f32_rounds_only_the_result() {
    let mut ground = sea(40, 5, 0.0);
    let narrow: Vec<f32> = ground.heights_m.iter().map(|&z| z as f32).collect();
    ground.heights_m = narrow.iter().map(|&z| f64::from(z)).collect();
    let settings = Settings::for_map(&ground.map());
    let map = Map::new(&narrow, [40, 40], 1.0, ground.first_m).unwrap();
    let mut shadow = Shadow::new([40, 40], settings).unwrap();
    let mut weights = vec![0.0_f32; 1600];
    for azimuth_deg in [10.0, 44.0, 181.0] {
        let terminal = ground.terminal(3e3, azimuth_deg, 2.0);
        shadow.weights(&map, terminal, &mut weights).unwrap();
        for (narrow, wide) in weights.iter().zip(ground.weights(settings, terminal)) {
            // Two blended parts and their sum: three roundings of at most half an ulp of 1.
            assert!((f64::from(*narrow) - wide).abs() <= 1.5 * f64::from(f32::EPSILON));
        }
    }
}

/// Heights that move linearly. Where the clearance moves linearly too (the horizon stays on its point), the
/// second difference of the weight is at most max |smoothstep''| (c'/w dt)^2 = 6 (dc/w)^2; a jump of the
/// first derivative would leave a term of first order in dc.
#[test]
fn weights_are_c1_in_time() {
    let side = 48;
    let (start, end) = (sea(side, 1, 0.0), sea(side, 1, 0.2));
    let settings = Settings::for_map(&start.map());
    let width_rad = settings.width_rad;
    for azimuth_deg in [20.0, 130.0, 200.0] {
        let terminal = start.terminal(2e4, azimuth_deg, 1.5);
        let step = 0.02;
        let (mut moving, mut turning, mut worst, mut largest) = (0, 0, 0.0_f64, 0.0_f64);
        let mut series: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
        for k in 0..=50 {
            let mut ground = start.clone();
            for (z, (a, b)) in ground.heights_m.iter_mut().zip(start.heights_m.iter().zip(&end.heights_m)) {
                *z = a + (b - a) * (step * f64::from(k));
            }
            series.push((ground.clearances_m(settings, terminal), ground.weights(settings, terminal)));
        }
        for window in series.windows(3) {
            for i in 0..side * side {
                let [c, v] = [0, 1]
                    .map(|part| [0, 1, 2].map(|k| if part == 0 { window[k].0[i] } else { window[k].1[i] }));
                // In a blend the weight is not the one of the blended clearance.
                let pure = [0.0, 1.0].contains(&share_of_y(&start, terminal, [i % side, i / side]));
                if !(pure && c[1].is_finite()) || v[0] == v[2] {
                    continue;
                }
                moving += 1;
                largest = largest.max((v[1] - v[0]).abs());
                let (first, second) = ((c[2] - c[0]).abs() / 2.0, (c[2] - 2.0 * c[1] + c[0]).abs());
                if second > 1e-11 {
                    turning += 1;
                    // A horizon that turns still leaves the weight continuous: Lipschitz constant 3/2.
                    assert!((v[1] - v[0]).abs() <= 1.5 * (c[1] - c[0]).abs() / width_rad + 1e-9);
                    continue;
                }
                let bend = (v[2] - 2.0 * v[1] + v[0]).abs();
                // Rounding of c (1e-13 m) over the width (0.01 rad or more), times 3/2, thrice.
                let bound = 6.0 * (first / width_rad).powi(2) + 1e-10;
                worst = worst.max(bend / bound);
            }
        }
        println!(
            "linear motion, azimuth {azimuth_deg}: {moving} changing weights, {turning} with a turning horizon, \
             largest step {largest:.3}, second difference {worst:.3} of its bound"
        );
        assert!(moving > 1000 && turning < moving / 2 && worst <= 1.0);
    }
}

/// A vanishing width is the paper's rule, away from the edge itself.
#[test]
fn the_sharp_rule_is_the_limit_of_the_soft_one() {
    let ground = sea(64, 3, 0.0);
    for azimuth_deg in [0.0, 37.0, 130.0] {
        let terminal = ground.terminal(1e4, azimuth_deg, 2.0);
        let sharp = ground.weights(Settings::SHARP, terminal);
        assert!(sharp.iter().all(|&v| v == 0.0 || v == 1.0));
        let none = Settings { width_rad: 0.0, ..Settings::SHARP };
        assert_eq!(ground.weights(none, terminal), sharp);
        let mut differing = [0, 0, 0];
        for (width_rad, differing) in [1e-1, 1e-3, 1e-12].into_iter().zip(&mut differing) {
            let settings = Settings { width_rad, ..Settings::SHARP };
            let weights = ground.weights(settings, terminal);
            *differing = facets(&ground)
                .filter(|&at| {
                    // In the blend two marches may disagree: both rules are checked outside of it.
                    let share = share_of_y(&ground, terminal, at);
                    let here = at[1] * 64 + at[0];
                    (share == 0.0 || share == 1.0) && weights[here] != sharp[here]
                })
                .count();
        }
        println!("facets other than sharp at widths 0.1, 1e-3, 1e-12: {differing:?}");
        assert!(differing[0] > differing[1] && differing[2] == 0);
    }
}

/// Sea beyond the horizon of a mast: heights hold the drop. With the lift e of a facet, it disappears
/// at sqrt(2 k R h) + sqrt(2 k R e).
#[test]
fn a_curved_sea_hides_what_is_beyond_the_horizon() {
    let earth = Earth::Curved { radius_factor: 4.0 / 3.0 };
    let facet_m = 50.0;
    let mut ground = Ground::new([3, 2000], facet_m, |_, iy| -earth.drop_m(0.0, facet_m * iy as f64));
    ground.first_m = [0.0, 0.0];
    for mast_m in [5.0, 20.0, 100.0] {
        let weights = ground.weights(Settings::SHARP, Point::new(50.0, -1e-3, mast_m));
        let illuminated = weights.iter().filter(|&&v| v == 1.0).count() as f64 / 3.0;
        let reach_m = |height_m: f64| (2.0 * 4.0 / 3.0 * 6_371_000.0 * height_m).sqrt();
        let expected = (reach_m(mast_m) + reach_m(LIFT * facet_m)) / facet_m;
        println!("mast of {mast_m} m: {illuminated} facets illuminated, {expected:.1} expected");
        // The facet at the mast's foot, and one for the horizon's own place among centres.
        assert!((illuminated - expected).abs() <= 2.0);
    }
}
