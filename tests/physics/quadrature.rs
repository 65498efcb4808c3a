//! Composite Gauss-Legendre quadrature, the judge of closed forms.

use num_complex::Complex64;

/// 8-point Gauss-Legendre nodes and weights on [-1, 1] (Abramowitz & Stegun 25.4).
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// `int_0^1 g(y) dy` on equal panels.
pub fn unit_interval(panels: usize, g: impl Fn(f64) -> Complex64) -> Complex64 {
    let h = 1.0 / panels as f64;
    let mut sum = Complex64::ZERO;
    for i in 0..panels {
        let middle = (i as f64 + 0.5) * h;
        for (x, w) in GAUSS {
            sum += (g(middle - 0.5 * h * x) + g(middle + 0.5 * h * x)) * w;
        }
    }
    sum * 0.5 * h
}
