//! Coordinates of rasters: geographic, or a zone of UTM.
//!
//! UTM is Krueger's series in the third flattening `n` to `n^4` (Karney 2011, eqs. 7 to 12 and 35): within a
//! zone the error is far below a millimetre. WGS-84 and ETRS89 are taken as one datum (they differ by less
//! than a metre).
//!
//! ```
//! use nereus::sea::land::projection::Crs;
//! // The CN Tower: zone 17, 630084 m East, 4833438 m North.
//! let [east_m, north_m] = Crs::of_projected(32617).unwrap().of([43.642_567f64, -79.387_139].map(f64::to_radians));
//! assert!((east_m - 630_084.0).abs() < 1.0 && (north_m - 4_833_438.0).abs() < 1.0);
//! ```

/// Semi-major axis, m, and flattening of WGS-84.
const A_M: f64 = 6_378_137.0;
const F: f64 = 1.0 / 298.257_223_563;
/// Scale on the central meridian of a zone, and false coordinates, m.
const SCALE: f64 = 0.9996;
const FALSE_EAST_M: f64 = 500_000.0;
const FALSE_NORTH_SOUTH_M: f64 = 10_000_000.0;

/// What the coordinates of a raster mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crs {
    /// Longitude and latitude, degrees.
    Geographic,
    /// East and North of a zone of UTM, m.
    Utm {
        /// 1 to 60.
        zone: u8,
        /// Whether it is that of the southern hemisphere.
        south: bool,
    },
}

impl Crs {
    /// Geographic systems by their EPSG code.
    pub fn of_geographic(code: u16) -> Option<Self> {
        matches!(code, 4326 | 4258 | 4979).then_some(Self::Geographic)
    }

    /// Projected systems by their EPSG code.
    pub fn of_projected(code: u16) -> Option<Self> {
        let (zone, south) = match code {
            32601..=32660 => (code - 32600, false),
            32701..=32760 => (code - 32700, true),
            25828..=25838 => (code - 25800, false),
            _ => return None,
        };
        Some(Self::Utm { zone: zone as u8, south })
    }

    /// First and second coordinate of a latitude and longitude, rad.
    pub fn of(self, [lat_rad, lon_rad]: [f64; 2]) -> [f64; 2] {
        let Self::Utm { zone, south } = self else { return [lon_rad.to_degrees(), lat_rad.to_degrees()] };
        let n = F / (2.0 - F);
        let (n2, n3, n4) = (n * n, n * n * n, n * n * n * n);
        let radius_m = A_M / (1.0 + n) * (1.0 + n2 / 4.0 + n4 / 64.0);
        let alpha = [
            n / 2.0 - 2.0 / 3.0 * n2 + 5.0 / 16.0 * n3 + 41.0 / 180.0 * n4,
            13.0 / 48.0 * n2 - 3.0 / 5.0 * n3 + 557.0 / 1440.0 * n4,
            61.0 / 240.0 * n3 - 103.0 / 140.0 * n4,
            49_561.0 / 161_280.0 * n4,
        ];
        let central_rad = f64::from(6 * i32::from(zone) - 183).to_radians();
        let away_rad = (lon_rad - central_rad + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
            - std::f64::consts::PI;
        let sine = lat_rad.sin();
        let eccentricity = 2.0 * n.sqrt() / (1.0 + n);
        let t = (sine.atanh() - eccentricity * (eccentricity * sine).atanh()).sinh();
        let (up, aside) = (t.atan2(away_rad.cos()), (away_rad.sin() / (1.0 + t * t).sqrt()).atanh());
        let (mut xi, mut eta) = (up, aside);
        for (term, weight) in (1..).zip(alpha) {
            let turns = 2.0 * f64::from(term);
            xi += weight * (turns * up).sin() * (turns * aside).cosh();
            eta += weight * (turns * up).cos() * (turns * aside).sinh();
        }
        let false_north_m = if south { FALSE_NORTH_SOUTH_M } else { 0.0 };
        [FALSE_EAST_M + SCALE * radius_m * eta, false_north_m + SCALE * radius_m * xi]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Along the central meridian the northing is 0.9996 of the length of the meridian: 4 984 944.378 m from
    /// the equator to 45 degrees on WGS-84 (a published figure of the ellipsoid).
    #[test]
    fn the_central_meridian_has_its_length() {
        let [east_m, north_m] = Crs::Utm { zone: 31, south: false }.of([45f64, 3.0].map(f64::to_radians));
        assert!((east_m - 500_000.0).abs() < 1e-6);
        assert!((north_m / 0.9996 - 4_984_944.378).abs() < 1e-3, "{north_m}");
        let [_, south_m] = Crs::Utm { zone: 31, south: true }.of([-45f64, 3.0].map(f64::to_radians));
        assert!((south_m + north_m - 10_000_000.0).abs() < 1e-6);
    }

    #[test]
    fn only_known_systems_are_taken() {
        assert_eq!(Crs::of_projected(32760), Some(Crs::Utm { zone: 60, south: true }));
        for code in [3857, 32600, 32661, 32700, 27700, 2154] {
            assert_eq!(Crs::of_projected(code), None, "{code}");
        }
        assert_eq!((Crs::of_geographic(4326), Crs::of_geographic(4269)), (Some(Crs::Geographic), None));
    }
}
