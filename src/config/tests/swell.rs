//! Ranges of swells.

use crate::config::keys;
use crate::scene::water::{Dispersion, Swell, SwellShape};
use crate::sea::spectrum::SwellTrain;

#[test]
fn every_corner_of_the_ranges_of_a_swell_is_a_swell() {
    let ends = |key: &'static keys::Key| match key.kind {
        keys::Kind::Number { min, max, .. } => [min, max],
        _ => panic!("{}", key.name),
    };
    use keys::swell as k;
    for corner in 0..64 {
        let at = |key, bit: u32| ends(key)[(corner >> bit) & 1];
        let shape = if corner & 1 == 0 {
            SwellShape::Gaussian { relative_width: at(&k::RELATIVE_WIDTH, 5) }
        } else {
            SwellShape::Jonswap { peak_enhancement: at(&k::PEAK_ENHANCEMENT, 5) }
        };
        let swell = Swell {
            significant_height_m: at(&k::SIGNIFICANT_HEIGHT_M, 1),
            peak_period_s: at(&k::PEAK_PERIOD_S, 2),
            direction_rad: at(&k::TOWARDS_DEG, 3).to_radians(),
            spread_rad: at(&k::SPREAD_DEG, 4).to_radians(),
            shape,
        };
        assert!(SwellTrain::new(&swell, Dispersion::default()).is_ok(), "{swell:?}");
    }
}
