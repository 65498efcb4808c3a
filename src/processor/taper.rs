//! Tapers: weights over a band or an aperture that trade width for side lobes.
//!
//! | taper | `w(x)`, `x` from -1/2 to 1/2 across the band | highest side lobe |
//! | --- | --- | --- |
//! | none | 1 | -13.26 dB |
//! | Hann | `cos^2(pi x)` | -31.5 dB |
//! | Taylor | `1 + 2 sum_{m<6} F_m cos(2 pi m x)`, `F_m` for -35 dB and n = 6 | -35 dB |
//! | Kaiser | `I0(beta sqrt(1 - 4 x^2)) / I0(beta)`, beta = 6 | -44 dB |
//!
//! Zero beyond the band. Sources: T. T. Taylor, IRE Trans. Antennas Propag. 3, 16 (1955), with `F_m` as in W.
//! G. Carrara, R. S. Goodman, R. M. Majewski, *Spotlight Synthetic Aperture Radar* (1995), appendix D; J. F.
//! Kaiser, R. W. Schafer, IEEE Trans. ASSP 28, 105 (1980).
//!
//! ```
//! use nereus::processor::taper::Taper;
//! assert_eq!(Taper::Hann.weight(0.25), 0.5000000000000001);
//! assert_eq!(Taper::Uniform.weight(0.51), 0.0);
//! ```

use std::f64::consts::PI;

/// Terms of the Taylor taper that are near the main lobe.
const TAYLOR_TERMS: usize = 6;
/// Its side lobes, dB.
const TAYLOR_DB: f64 = 35.0;
/// Shape of the Kaiser taper.
const KAISER_BETA: f64 = 6.0;

/// A taper.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Taper {
    /// All weights are 1.
    #[default]
    Uniform,
    /// Raised cosine.
    Hann,
    /// Even side lobes of -35 dB.
    Taylor,
    /// Kaiser, beta = 6.
    Kaiser,
}

impl Taper {
    /// Weight at `x`, -1/2 to 1/2 across the band; zero beyond, and where `x` is no number.
    pub fn weight(self, x: f64) -> f64 {
        if x.is_nan() || x.abs() > 0.5 {
            return 0.0;
        }
        match self {
            Self::Uniform => 1.0,
            Self::Hann => (PI * x).cos().powi(2),
            Self::Taylor => {
                let sum: f64 =
                    (1..TAYLOR_TERMS).map(|m| taylor_coefficient(m) * (2.0 * PI * m as f64 * x).cos()).sum();
                1.0 + 2.0 * sum
            }
            Self::Kaiser => {
                let inside = (1.0 - 4.0 * x * x).max(0.0).sqrt();
                bessel_i0(KAISER_BETA * inside) / bessel_i0(KAISER_BETA)
            }
        }
    }
}

impl Taper {
    /// Half-power width of the response to a point, in units of one over the band: 0.8859 without a taper.
    pub fn width(self) -> f64 {
        // Midpoint rule; the transform falls steadily over the main lobe, which no taper here makes wider
        // than 4.
        let cells = 512;
        let weights: Vec<[f64; 2]> = (0..cells)
            .map(|i| (f64::from(i) + 0.5) / f64::from(cells) - 0.5)
            .map(|x| [x, self.weight(x)])
            .collect();
        let at = |u: f64| weights.iter().map(|[x, w]| w * (2.0 * PI * u * x).cos()).sum::<f64>();
        let level = at(0.0) * 0.5f64.sqrt();
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if at(middle) > level { low = middle } else { high = middle }
        }
        2.0 * low
    }
}

fn taylor_coefficient(m: usize) -> f64 {
    let a = 10f64.powf(TAYLOR_DB / 20.0).acosh() / PI;
    let n = TAYLOR_TERMS as f64;
    let dilation = n * n / (a * a + (n - 0.5).powi(2));
    let m2 = (m * m) as f64;
    let zeros: f64 =
        (1..TAYLOR_TERMS).map(|i| 1.0 - m2 / dilation / (a * a + (i as f64 - 0.5).powi(2))).product();
    let poles: f64 = (1..TAYLOR_TERMS).filter(|i| *i != m).map(|i| 1.0 - m2 / (i * i) as f64).product();
    let sign = if m % 2 == 1 { 1.0 } else { -1.0 };
    0.5 * sign * zeros / poles
}

/// Modified Bessel function of order zero by its series; all terms are positive.
fn bessel_i0(x: f64) -> f64 {
    let quarter = x * x / 4.0;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..200 {
        term *= quarter / f64::from(k * k);
        sum += term;
        if term < 1e-17 * sum {
            break;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Highest side lobe of the transform of a taper, dB below the peak.
    fn side_lobe_db(taper: Taper) -> f64 {
        let cells = 400;
        let weights: Vec<[f64; 2]> = (0..cells)
            .map(|i| (f64::from(i) + 0.5) / f64::from(cells) - 0.5)
            .map(|x| [x, taper.weight(x)])
            .collect();
        let at = |u: f64| weights.iter().map(|[x, w]| w * (2.0 * PI * u * x).cos()).sum::<f64>().abs();
        let values: Vec<f64> = (0..1200).map(|i| at(f64::from(i) / 100.0)).collect();
        let null = (1..values.len()).find(|i| values[*i] > values[i - 1]).unwrap();
        20.0 * (values[null..].iter().fold(0.0, |a: f64, b| a.max(*b)) / values[0]).log10()
    }

    #[test]
    fn widths_are_those_of_the_books() {
        // Half-power widths of F. J. Harris, Proc. IEEE 66 (1978), table 1: 0.89 and 1.44 bins.
        assert!((Taper::Uniform.width() - 0.8859).abs() < 1e-4);
        assert!((Taper::Hann.width() - 1.44).abs() < 5e-3);
        assert!(Taper::Kaiser.width() > Taper::Taylor.width());
    }

    #[test]
    fn side_lobes_are_those_of_the_books() {
        // sinc: sin x/x at tan x = x; Hann: -31.47 (F. J. Harris, Proc. IEEE 66, 1978, table 1). A grid of
        // 0.01 in u misses a lobe's top by less than 0.01 dB, 400 cells the integral by 1e-5.
        for (taper, expected, within) in
            [(Taper::Uniform, -13.26, 0.02), (Taper::Hann, -31.47, 0.02), (Taper::Taylor, -35.0, 0.35)]
        {
            // Taylor: the lobes are held at the design level near the main lobe only to the order of 1/n.
            let found = side_lobe_db(taper);
            println!("{taper:?} {found:.3} dB");
            assert!((found - expected).abs() < within, "{taper:?}: {found}");
        }
        // Kaiser's own rule: beta = 0.76609 (A - 13.26)^0.4 + 0.09834 (A - 13.26), 13.26 < A < 60.
        let found = -side_lobe_db(Taper::Kaiser);
        let beta = 0.76609 * (found - 13.26f64).powf(0.4) + 0.09834 * (found - 13.26);
        println!("Kaiser -{found:.3} dB, rule {beta:.3}");
        assert!((beta - KAISER_BETA).abs() < 0.05, "{beta}");
    }
}
