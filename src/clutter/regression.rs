//! A quantity over azimuth: `y = a + b cos 2 psi`, by least squares.
//!
//! Errors are those of the residuals, which are taken as independent and of one size:
//! `s^2 = sum r^2/(n - 2)`.
//!
//! ```
//! use nereus::clutter::regression::cosine;
//! let psi_rad: Vec<f64> = (0..12).map(|i| f64::from(i) * std::f64::consts::PI / 6.0).collect();
//! let values: Vec<f64> = psi_rad.iter().map(|psi| 2.0 - 0.5 * (2.0 * psi).cos()).collect();
//! let fit = cosine(&psi_rad, &values).unwrap();
//! assert!((fit.mean - 2.0).abs() < 1e-12 && (fit.amplitude + 0.5).abs() < 1e-12);
//! ```

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cosine {
    /// `a`.
    pub mean: f64,
    /// Its standard error.
    pub mean_error: f64,
    /// `b`.
    pub amplitude: f64,
    /// Its standard error.
    pub amplitude_error: f64,
    /// Points.
    pub points: usize,
}

impl Cosine {
    /// `a + b cos 2 psi`.
    pub fn at(&self, psi_rad: f64) -> f64 {
        self.mean + self.amplitude * (2.0 * psi_rad).cos()
    }
}

/// Fits points of which both numbers are finite; none with fewer than 3, or where `cos 2 psi` is one and the
/// same.
pub fn cosine(psi_rad: &[f64], values: &[f64]) -> Option<Cosine> {
    let points: Vec<[f64; 2]> = psi_rad
        .iter()
        .zip(values)
        .filter(|(psi, value)| psi.is_finite() && value.is_finite())
        .map(|(psi, value)| [(2.0 * psi).cos(), *value])
        .collect();
    let n = points.len() as f64;
    if points.len() < 3 {
        return None;
    }
    let mean = |axis: usize| points.iter().map(|p| p[axis]).sum::<f64>() / n;
    let [x, y] = [mean(0), mean(1)];
    let spread: f64 = points.iter().map(|p| (p[0] - x) * (p[0] - x)).sum();
    if spread < 1e-12 * n {
        return None;
    }
    let amplitude = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>() / spread;
    let left: f64 = points.iter().map(|p| (p[1] - y - amplitude * (p[0] - x)).powi(2)).sum();
    let variance = left / (n - 2.0);
    Some(Cosine {
        mean: y - amplitude * x,
        mean_error: (variance * (1.0 / n + x * x / spread)).sqrt(),
        amplitude,
        amplitude_error: (variance / spread).sqrt(),
        points: points.len(),
    })
}
