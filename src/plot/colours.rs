//! Colour maps of even steps, and colours for curves.
//!
//! Anchors stand in Oklab (B. Ottosson, "A perceptual color space for image processing", 2020: lightness L,
//! green to red a, blue to yellow b) and are joined by straight lines there, so equal steps of a value look
//! like equal steps of colour. The anchors are this project's own: [`ColourMap::Deep`] climbs in lightness
//! alone in even steps, from violet to yellow; [`ColourMap::Swell`] falls in lightness from a pale middle, to
//! blue below and to red above.
//!
//! Oklab to linear sRGB, with `l = (L + 0.396 a + 0.216 b)^3` and so on: matrices of the same source; then
//! the transfer curve of IEC 61966-2-1. [`CURVES`] are the eight colours of M. Okabe and K. Ito ("Color
//! universal design", 2008), distinct to any eye, in an order that begins with the dark ones.
//!
//! ```
//! use nereus::plot::colours::ColourMap;
//! let [low, high] = [0.0, 1.0].map(|share| ColourMap::Deep.colour(share));
//! assert!(low.iter().map(|c| u32::from(*c)).sum::<u32>() < high.iter().map(|c| u32::from(*c)).sum());
//! assert_eq!(ColourMap::Deep.colour(f64::NAN), ColourMap::Deep.colour(0.0));
//! ```

/// Red, green, blue in sRGB.
pub type Colour = [u8; 3];

/// White.
pub const WHITE: Colour = [255, 255, 255];
/// Letters and frames.
pub const INK: Colour = [30, 30, 34];
/// Lines behind curves.
pub const FAINT: Colour = [224, 224, 228];
/// Pixels without a value.
pub const MASKED: Colour = [150, 150, 150];

/// Colours of curves.
pub const CURVES: [Colour; 8] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [0, 0, 0],
    [86, 180, 233],
    [230, 159, 0],
    [240, 228, 66],
];

const DEEP: [[f64; 3]; 9] = [
    [0.260, 0.054, -0.116],
    [0.345, 0.003, -0.140],
    [0.430, -0.039, -0.095],
    [0.515, -0.063, -0.060],
    [0.600, -0.086, -0.031],
    [0.685, -0.115, 0.008],
    [0.770, -0.124, 0.065],
    [0.855, -0.088, 0.109],
    [0.940, -0.036, 0.135],
];

const SWELL: [[f64; 3]; 9] = [
    [0.380, -0.030, -0.111],
    [0.525, -0.039, -0.145],
    [0.670, -0.026, -0.097],
    [0.815, -0.013, -0.048],
    [0.960, 0.000, 0.000],
    [0.815, 0.043, 0.025],
    [0.670, 0.087, 0.050],
    [0.525, 0.130, 0.075],
    [0.380, 0.121, 0.070],
];

/// A colour map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ColourMap {
    /// Dark violet over green to light yellow, for amounts.
    #[default]
    Deep,
    /// Blue, nearly white in the middle, red: for what has two signs. Limits are put evenly about zero.
    Swell,
}

impl ColourMap {
    /// Whether its middle stands for zero.
    pub fn is_diverging(self) -> bool {
        self == Self::Swell
    }

    /// Colour at a share of the range, 0 to 1; beyond, and for what is no number, the nearest end (the lower
    /// one).
    pub fn colour(self, share: f64) -> Colour {
        let anchors: &[[f64; 3]] = match self {
            Self::Deep => &DEEP,
            Self::Swell => &SWELL,
        };
        let last = anchors.len() - 1;
        let at = if share > 0.0 { share.min(1.0) * last as f64 } else { 0.0 };
        let below = (at as usize).min(last - 1);
        let part = at - below as f64;
        let [low, high] = [anchors[below], anchors[below + 1]];
        srgb([0, 1, 2].map(|i| low[i] + part * (high[i] - low[i])))
    }
}

/// Oklab to sRGB.
fn srgb([lightness, a, b]: [f64; 3]) -> Colour {
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ]
    .map(|linear| {
        let linear = linear.clamp(0.0, 1.0);
        let curved =
            if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
        (255.0 * curved).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE 1976 L*, a*, b* under D65: another judge of evenness than the space the anchors stand in.
    fn cielab(colour: Colour) -> [f64; 3] {
        let [r, g, b] = colour.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        let [x, y, z] = [
            (0.412_456 * r + 0.357_576 * g + 0.180_437 * b) / 0.950_47,
            0.212_673 * r + 0.715_152 * g + 0.072_175 * b,
            (0.019_334 * r + 0.119_192 * g + 0.950_304 * b) / 1.088_83,
        ]
        .map(|t| if t > 216.0 / 24389.0 { t.cbrt() } else { (24389.0 / 27.0 * t + 16.0) / 116.0 });
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    #[test]
    fn lightness_climbs_evenly() {
        let lightness: Vec<f64> =
            (0..=16).map(|i| cielab(ColourMap::Deep.colour(f64::from(i) / 16.0))[0]).collect();
        let mean = (lightness[16] - lightness[0]) / 16.0;
        for (i, pair) in lightness.windows(2).enumerate() {
            // Oklab's L and CIE's L* differ in their curves (cube root of cone responses or of luminance): a
            // fifth over the range used here. A flat or falling stretch would be -100 %.
            assert!(((pair[1] - pair[0]) / mean - 1.0).abs() < 0.2, "step {i}: {lightness:?}");
        }
    }

    #[test]
    fn both_signs_weigh_the_same() {
        let middle = cielab(ColourMap::Swell.colour(0.5));
        assert!(middle[0] > 94.0 && middle[1].hypot(middle[2]) < 1.0, "{middle:?}");
        for i in 1..=8 {
            let share = f64::from(i) / 16.0;
            let [below, above] = [0.5 - share, 0.5 + share].map(|s| cielab(ColourMap::Swell.colour(s)));
            // 256 levels of sRGB and the two scales of lightness: within 5 of 100.
            assert!((below[0] - above[0]).abs() < 5.0, "{below:?} {above:?}");
            assert!(below[2] < 0.0 && above[1] > 0.0);
        }
    }

    #[test]
    fn curves_differ() {
        for (i, a) in CURVES.iter().enumerate() {
            for b in &CURVES[..i] {
                let [a, b] = [cielab(*a), cielab(*b)];
                assert!((0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt() > 20.0);
            }
        }
    }
}
