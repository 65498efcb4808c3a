//! What the scattering tests measure against: the golden tables, and a spectrum written here from its source.

use std::f64::consts::PI;
use std::path::PathBuf;

/// A golden table: every row as numbers, columns by name.
pub struct Golden {
    names: Vec<String>,
    pub rows: Vec<Vec<f64>>,
}

impl Golden {
    pub fn read(file: &str) -> Self {
        let folder = std::env::var_os("NEREUS_GOLDEN").map_or_else(
            || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/golden"),
            PathBuf::from,
        );
        let path = folder.join(file);
        let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mut lines = text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
        let names: Vec<String> =
            lines.next().unwrap().split(',').map(|name| name.trim().to_owned()).collect();
        let rows: Vec<Vec<f64>> =
            lines.map(|line| line.split(',').map(|cell| cell.trim().parse().unwrap()).collect()).collect();
        assert!(!rows.is_empty(), "{} has no rows", path.display());
        Self { names, rows }
    }

    pub fn column(&self, name: &str) -> usize {
        self.names
            .iter()
            .position(|n| n == name)
            .unwrap_or_else(|| panic!("no column {name} in {:?}", self.names))
    }
}

/// Elfouhaily et al. 1997, fully developed, symmetrised: S(K) (1 + Delta cos 2phi) / (2 pi K), phi from the
/// wind.
#[derive(Clone, Copy)]
pub struct Elfouhaily {
    pub wind_10_mps: f64,
    pub downwind_rad: f64,
}

impl Elfouhaily {
    const KM: f64 = 370.0;
    const CM: f64 = 0.23;
    const G: f64 = 9.81;

    /// Psi as a function, whose type is the same wherever it is asked for.
    pub fn as_psi(self) -> impl Fn(f64, f64) -> f64 + Copy {
        move |kx, ky| self.psi(kx, ky)
    }

    fn speed(k: f64) -> f64 {
        (Self::G / k * (1.0 + (k / Self::KM).powi(2))).sqrt()
    }

    /// S(K), m^3, and Delta(K).
    pub fn omnidirectional(&self, k: f64) -> (f64, f64) {
        let u = self.wind_10_mps;
        let age: f64 = 0.84;
        let friction = u * ((0.8 + 0.065 * u) * 1e-3).sqrt();
        let kp = Self::G / (u * u) * age * age;
        let (c, cp) = (Self::speed(k), Self::speed(kp));
        let omega = u / cp;
        let s = 0.08 * (1.0 + 4.0 * age.powi(-3));
        let root = (k / kp).sqrt() - 1.0;
        let l = (-1.25 * (kp / k).powi(2)).exp();
        let j = 1.7f64.powf((-root * root / (2.0 * s * s)).exp());
        let fp = l * j * (-omega / 10f64.sqrt() * root).exp();
        let bl = 0.5 * 6e-3 * omega.sqrt() * (cp / c) * fp;
        let log = (friction / Self::CM).ln();
        let am = 0.01 * if friction < Self::CM { 1.0 + log } else { 1.0 + 3.0 * log };
        let fm = l * (-0.25 * (k / Self::KM - 1.0).powi(2)).exp();
        let bh = 0.5 * am.max(0.0) * (Self::CM / c) * fm;
        let delta = (2f64.ln() / 4.0
            + 4.0 * (c / cp).powf(2.5)
            + 0.13 * (friction / Self::CM) * (Self::CM / c).powf(2.5))
        .tanh();
        ((bl + bh) / k.powi(3), delta)
    }

    pub fn psi(&self, kx: f64, ky: f64) -> f64 {
        let k = kx.hypot(ky);
        if k < 1e-9 {
            return 0.0;
        }
        let (s, delta) = self.omnidirectional(k);
        let phi = ky.atan2(kx) - self.downwind_rad;
        s / k * (1.0 + delta * (2.0 * phi).cos()) / (2.0 * PI)
    }
}
