//! Tapers of apertures: illumination that falls towards the edges trades beamwidth and gain for side lobes.
//!
//! Over `x` from -1/2 to 1/2 across a side of `a`, with `t = a u / lambda` and `u` a direction cosine, the
//! field pattern is the transform of the illumination `w`, over its value ahead:
//!
//! | taper | `w(x)` | `F(t)` | highest side lobe |
//! | --- | --- | --- | --- |
//! | uniform | 1 | `sinc t` | -13.26 dB |
//! | cosine | `cos(pi x)` | `cos(pi t) / (1 - 4 t^2)` | -23.0 dB |
//! | Hamming | `0.54 + 0.46 cos(2 pi x)` | as below, `F_1 = 0.23/0.54` | -42.7 dB |
//! | Taylor | `1 + 2 sum F_m cos(2 pi m x)` | `sinc t (1 + 2 sum F_m (-1)^m t^2 / (t^2 - m^2))` | as asked |
//!
//! `sinc t = sin(pi t)/(pi t)`. The gain ahead is `4 pi a b / lambda^2` times the efficiencies of both sides,
//! `(int w)^2 / int w^2`. Source: T. T. Taylor, IRE Trans. Antennas Propag. 3, 16 (1955).
//!
//! ```
//! use nereus::radar::taper::SideTaper;
//! use nereus::scene::radar::ApertureTaper;
//! let cosine = SideTaper::of(ApertureTaper::Cosine);
//! assert!((cosine.field(0.5) - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
//! assert!((cosine.efficiency() - 8.0 / std::f64::consts::PI.powi(2)).abs() < 1e-12);
//! ```

use std::f64::consts::PI;

use crate::scene::radar::ApertureTaper;

/// Most cosines of a taper: those of Taylor's for 50 dB.
pub const TERMS: usize = 8;
/// Distance from a pole within which its limit is taken.
const AT_POLE: f64 = 1e-7;

/// A taper along a side, ready to be evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideTaper {
    /// `2 F_m (-1)^m`, zeros behind; `None` of the cosine, whose pattern is another.
    terms: Option<[f64; TERMS]>,
    efficiency: f64,
    null: f64,
}

impl SideTaper {
    /// That of a description.
    pub fn of(taper: ApertureTaper) -> Self {
        let sum = |of: &[f64], null: f64| {
            let mut terms = [0.0; TERMS];
            for (n, (term, of)) in terms.iter_mut().zip(of).enumerate() {
                *term = if n % 2 == 0 { -2.0 * of } else { 2.0 * of };
            }
            let squares: f64 = of.iter().map(|of| of * of).sum();
            Self { terms: Some(terms), efficiency: 1.0 / (1.0 + 2.0 * squares), null }
        };
        match taper {
            ApertureTaper::Uniform => sum(&[], 1.0),
            ApertureTaper::Cosine => Self { terms: None, efficiency: 8.0 / (PI * PI), null: 1.5 },
            ApertureTaper::Hamming => sum(&[0.23 / 0.54], 2.0),
            ApertureTaper::Taylor { sidelobe_db } => {
                let (dilated, squared) = taylor_null(sidelobe_db);
                sum(&taylor(sidelobe_db), (dilated * (squared + 0.25)).sqrt())
            }
        }
    }

    /// Field over that ahead, at `t = a u / lambda`.
    pub fn field(&self, t: f64) -> f64 {
        let t = t.abs();
        // sin(pi q)/(pi q) of a pole at distance q.
        let near = |q: f64, sine: f64| if q.abs() < AT_POLE { 1.0 } else { sine / (PI * q) };
        let Some(terms) = &self.terms else {
            let q = 0.5 - t;
            return PI / 2.0 * near(q, (PI * q).sin()) / (1.0 + 2.0 * t);
        };
        let sine = (PI * t).sin();
        let mut sum = near(t, sine);
        for (m, term) in (1..).zip(terms).take_while(|(_, term)| **term != 0.0) {
            let own = f64::from(m);
            // At t = m the sine is that of q with the sign of (-1)^m.
            let sign = if m % 2 == 0 { 1.0 } else { -1.0 };
            let q = t - own;
            sum += term * t / (t + own) * sign * near(q, sign * sine);
        }
        sum
    }

    /// Gain over that of a uniform side.
    pub fn efficiency(&self) -> f64 {
        self.efficiency
    }

    /// `t` of the first null.
    pub fn null(&self) -> f64 {
        self.null
    }

    /// `2 F_m (-1)^m`, zeros behind; `None` of the cosine.
    pub fn terms(&self) -> Option<&[f64; TERMS]> {
        self.terms.as_ref()
    }
}

/// `sigma^2` and `A^2` of Taylor's taper.
fn taylor_null(sidelobe_db: f64) -> (f64, f64) {
    let squared = (10f64.powf(sidelobe_db / 20.0).acosh() / PI).powi(2);
    let order = (2.0 * squared + 0.5).ceil().max(2.0);
    (order * order / (squared + (order - 0.5).powi(2)), squared)
}

/// `F_m` of Taylor's taper with side lobes so far below the peak, dB; of the least order with which they are
/// even.
pub fn taylor(sidelobe_db: f64) -> Vec<f64> {
    let (dilated, squared) = taylor_null(sidelobe_db);
    let count = (2.0 * squared + 0.5).ceil().max(2.0) as u32 - 1;
    let term = |m: f64| {
        let (mut above, mut below) = (1.0, 1.0);
        for n in (1..=count).map(f64::from) {
            above *= 1.0 - m * m / (dilated * (squared + (n - 0.5).powi(2)));
            if n != m {
                below *= 1.0 - m * m / (n * n);
            }
        }
        let sign = if m % 2.0 == 0.0 { -0.5 } else { 0.5 };
        sign * above / below
    };
    (1..=count).map(f64::from).map(term).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [(ApertureTaper, f64); 5] = [
        (ApertureTaper::Uniform, -13.26),
        (ApertureTaper::Cosine, -23.0),
        (ApertureTaper::Hamming, -42.67),
        (ApertureTaper::Taylor { sidelobe_db: 25.0 }, -25.0),
        (ApertureTaper::Taylor { sidelobe_db: 50.0 }, -50.0),
    ];

    /// Illumination at `x`, written down anew.
    fn illumination(taper: ApertureTaper, x: f64) -> f64 {
        match taper {
            ApertureTaper::Uniform => 1.0,
            ApertureTaper::Cosine => (PI * x).cos(),
            ApertureTaper::Hamming => 0.54 + 0.46 * (2.0 * PI * x).cos(),
            ApertureTaper::Taylor { sidelobe_db } => {
                let terms = taylor(sidelobe_db);
                let sum: f64 = (1..).zip(&terms).map(|(m, f)| f * (2.0 * PI * f64::from(m) * x).cos()).sum();
                1.0 + 2.0 * sum
            }
        }
    }

    #[test]
    fn patterns_are_transforms_of_the_illumination() {
        for (taper, _) in ALL {
            let own = SideTaper::of(taper);
            // The midpoint rule: smooth to the edges, so within some 1/N^2.
            let points = 20_000;
            let x = |n: i32| (f64::from(n) + 0.5) / f64::from(points) - 0.5;
            let mean = |f: &dyn Fn(f64) -> f64| (0..points).map(|n| f(x(n))).sum::<f64>() / f64::from(points);
            let ahead = mean(&|x| illumination(taper, x));
            let power = mean(&|x| illumination(taper, x).powi(2));
            assert!((own.efficiency() - ahead * ahead / power).abs() < 1e-6, "{taper:?}");
            for t in [0.0, 0.3, 0.5, 0.500_000_01, 1.0, 1.5, 2.0, 2.000_001, 3.7, 8.0, 17.25, 100.0] {
                let found = mean(&|x| illumination(taper, x) * (2.0 * PI * t * x).cos()) / ahead;
                assert!((own.field(t) - found).abs() < 2e-5, "{taper:?} at {t}: {} {found}", own.field(t));
                assert_eq!(own.field(t), own.field(-t));
            }
        }
    }

    #[test]
    fn side_lobes_are_as_low_as_said_and_nulls_where_said() {
        for (taper, highest_db) in ALL {
            let own = SideTaper::of(taper);
            assert!(own.field(own.null()).abs() < 1e-9, "{taper:?}");
            let beyond = (0..40_000).map(|n| own.field(own.null() + f64::from(n) * 1e-3).abs());
            let found_db = 20.0 * beyond.fold(0.0, f64::max).log10();
            // Taylor's side lobes are even only in the limit of many terms.
            assert!((found_db - highest_db).abs() < 0.5, "{taper:?}: {found_db}");
        }
    }
}
