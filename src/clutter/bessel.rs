//! The Bessel function of the K law with its derivatives, and the derivative of the logarithm of the gamma
//! function.

/// Logarithm of `K_nu(x)` and its derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct LnBesselK {
    /// `ln K_nu(x)`.
    pub ln: f64,
    /// Over the order.
    pub by_order: f64,
    /// Over `ln x`.
    pub by_ln_x: f64,
}

/// `ln K_nu(x)`, `x` above 0 and finite, by the trapezoidal rule on `int_0^inf exp(-x cosh t) cosh(nu t) dt`:
/// the integrand is analytic for `|Im t| < pi/2`, so steps of `h` err by `e^{-pi^2/h}`, 1e-17 for 1/4, and
/// less where the peak is 5/2 steps wide.
pub(super) fn ln_bessel_k(order: f64, x: f64) -> LnBesselK {
    let sign = if order < 0.0 { -1.0 } else { 1.0 };
    let order = order.abs();
    // The integrand peaks where x sinh t = nu; there x cosh t is the hypotenuse, and so is the curvature of
    // its logarithm.
    let hypotenuse = order.hypot(x);
    let ratio = order / x;
    let peak = if ratio < 1.0 { ratio.asinh() } else { (order + hypotenuse).ln() - x.ln() };
    let width = hypotenuse.sqrt().recip();
    // Fall of the logarithm at a distance from the peak, without differences of large numbers.
    let fall = |away: f64| {
        if away > -1.0 {
            hypotenuse * (2.0 * (0.5 * away).sinh().powi(2)) + order * (away.sinh() - away)
        } else {
            let (t, ln_x) = (peak + away, x.ln());
            0.5 * ((ln_x + t).exp() + (ln_x - t).exp()) - hypotenuse - order * away
        }
    };
    // Gone where it has fallen by e^-45. To the left it may fall as slowly as e^(nu t), to the right as e^(-x
    // cosh t).
    let reach = |step: f64, most: f64| {
        let mut away = step;
        while away.abs() < most && fall(away) < 45.0 {
            away += step;
        }
        away
    };
    let begin = reach(-width, peak).max(-peak);
    let end = reach(width.min(0.5), f64::INFINITY);
    let steps = ((end - begin) / (0.4 * width).min(0.25)).ceil().clamp(8.0, 4096.0) as i32;
    let h = (end - begin) / f64::from(steps);
    let (mut sum, mut by_order, mut cosh) = (0.0, 0.0, 0.0);
    for i in 0..=steps {
        let away = begin + h * f64::from(i);
        let t = peak + away;
        // cosh(nu t) = e^{nu t} (1 + e^{-2 nu t})/2
        let back = (-2.0 * order * t).exp();
        // Half of the first: the integrand is even about zero, or gone where the sum begins.
        let weight = if i == 0 { 0.5 } else { 1.0 } * (-fall(away)).exp() * 0.5;
        sum += weight * (1.0 + back);
        by_order += weight * (1.0 - back) * t;
        // x cosh t over that at the peak less 1: x cosh(peak + a) = hypotenuse cosh a + nu sinh a.
        cosh +=
            weight * (1.0 + back) * (hypotenuse * (2.0 * (0.5 * away).sinh().powi(2)) + order * away.sinh());
    }
    LnBesselK {
        ln: order * peak - hypotenuse + (h * sum).ln(),
        by_order: sign * by_order / sum,
        by_ln_x: -hypotenuse - cosh / sum,
    }
}

/// Derivative of `ln G(x)`, `x` above 0: the recurrence up to 10, then the asymptotic series to `x^-12`,
/// 1e-15 there.
pub(super) fn digamma(x: f64) -> f64 {
    let (mut x, mut below) = (x, 0.0);
    while x < 10.0 {
        below += 1.0 / x;
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    let series = y
        * (1.0 / 12.0
            - y * (1.0 / 120.0
                - y * (1.0 / 252.0
                    - y * (1.0 / 240.0 - y * (1.0 / 132.0 - y * (691.0 / 32760.0 - y / 12.0))))));
    x.ln() - 0.5 / x - series - below
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_derivatives_are_those_of_closed_forms() {
        // K_{1/2}(x) = sqrt(pi/2x) e^-x, K_{3/2} = K_{1/2} (1 + 1/x).
        for x in [1e-6, 0.01, 0.7, 3.0, 40.0, 2e4] {
            let half = 0.5 * (std::f64::consts::FRAC_PI_2 / x).ln() - x;
            let (a, b) = (ln_bessel_k(0.5, x), ln_bessel_k(-1.5, x));
            assert!((a.ln - half).abs() < 1e-13 * (1.0 + half.abs()), "{x}: {} {half}", a.ln);
            let wanted = half + (1.0 / x).ln_1p();
            assert!((b.ln - wanted).abs() < 1e-13 * (1.0 + wanted.abs()), "{x}: {} {wanted}", b.ln);
            assert!((a.by_ln_x + 0.5 + x).abs() < 1e-12 * (1.0 + x), "{x}: {a:?}");
        }
        for (order, x) in [(0.3, 0.2), (-0.9, 1e-8), (3.0, 5.0), (80.0, 30.0), (2000.0, 1500.0), (0.0, 1e-12)]
        {
            let at = ln_bessel_k(order, x);
            let h = 1e-4;
            let differences = [
                (ln_bessel_k(order + h, x).ln - ln_bessel_k(order - h, x).ln) / (2.0 * h),
                (ln_bessel_k(order, x * f64::exp(h)).ln - ln_bessel_k(order, x * f64::exp(-h)).ln)
                    / (2.0 * h),
            ];
            // Third derivatives times h^2/6, and rounding of logarithms of up to 1e4 over h.
            for (found, wanted) in [at.by_order, at.by_ln_x].into_iter().zip(differences) {
                assert!(
                    (found - wanted).abs() < 1e-6 * (1.0 + wanted.abs()),
                    "{order} {x}: {found} {wanted}"
                );
            }
        }
    }

    #[test]
    fn the_digamma_function_has_its_known_values() {
        let euler = 0.577_215_664_901_532_9;
        for (x, wanted) in [(1.0, -euler), (0.5, -euler - 2.0 * std::f64::consts::LN_2), (2.0, 1.0 - euler)] {
            assert!((digamma(x) - wanted).abs() < 1e-14, "{x}");
        }
        let h = 1e-5;
        for x in [0.01, 0.3, 4.0, 9.9, 300.0] {
            let slope = (libm::lgamma(x + h) - libm::lgamma(x - h)) / (2.0 * h);
            assert!(
                (digamma(x) - slope).abs() < 1e-3 * (1.0 + slope.abs()) * if x < 0.1 { 1.0 } else { 1e-4 },
                "{x}"
            );
        }
    }
}
