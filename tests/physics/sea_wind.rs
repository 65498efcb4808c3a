//! The wind record against golden values, and its range.

use nereus::scene::water::{WindGiven, WindProfile, WindStrength};
use nereus::sea::wind::{self, Wind, WindError};
use proptest::prelude::*;

use crate::sea_golden::{Judge, rows};

#[test]
fn every_row_of_wind() {
    let mut judge = Judge::new("wind.csv", 1e-9);
    for row in rows("wind.csv") {
        let ustar_mps = row.get("ustar_m_s");
        let wind = Wind::from_friction_velocity(ustar_mps, WindProfile::Cardone, 0.0).unwrap();
        judge.compare(&row, "z0_m", wind::cardone_roughness_m(ustar_mps));
        judge.compare(&row, "U10_m_s", wind.u10_mps);
        judge.compare(&row, "U12p5_m_s", wind.u12_5_mps);
        judge.compare(&row, "U19p5_m_s", wind.u19_5_mps);
    }
    judge.verdict();
}

#[test]
fn every_row_of_wind_inverse() {
    let mut judge = Judge::new("wind_inverse.csv", 1e-9);
    for row in rows("wind_inverse.csv") {
        let speed_mps = row.get("U19p5_m_s");
        let wind = Wind::from_speed(speed_mps, 19.5, WindProfile::Cardone, 0.0).unwrap();
        judge.compare(&row, "ustar_cardone_m_s", wind.ustar_cardone_mps);
        judge.compare(&row, "U10_m_s", wind.u10_mps);
        judge.compare(&row, "ustar_wu_of_U10_m_s", wind.ustar_wu_mps);
    }
    judge.verdict();
}

#[test]
fn printed_figures_of_the_paper() {
    // docs/physics.md section 5: u* = 36 cm/s is 9.368, 9.569, 9.969 m/s at 10, 12.5, 19.5 m; half a last
    // digit.
    let wind = Wind::from_friction_velocity(0.36, WindProfile::Cardone, 0.0).unwrap();
    assert!((wind.u10_mps - 9.368).abs() < 5e-4);
    assert!((wind.u12_5_mps - 9.569).abs() < 5e-4);
    assert!((wind.u19_5_mps - 9.969).abs() < 5e-4);
    // U10 = 9.37 gives 0.352 by Wu's drag.
    assert!((wind::wu_friction_velocity_mps(9.37) - 0.352).abs() < 5e-4);
}

#[test]
fn out_of_range_is_refused_in_words() {
    let cardone = WindProfile::Cardone;
    let refused = [
        (Wind::from_speed(-0.1, 10.0, cardone, 0.0), "wind of -0.1 m/s: allowed are 0 to 40 m/s"),
        (Wind::from_speed(40.1, 10.0, cardone, 0.0), "wind of 40.1 m/s: allowed are 0 to 40 m/s"),
        (Wind::from_speed(f64::NAN, 10.0, cardone, 0.0), "wind of NaN m/s: allowed are 0 to 40 m/s"),
        (Wind::from_speed(10.0, 0.5, cardone, 0.0), "wind given at 0.5 m: allowed are 1 to 100 m"),
        (
            Wind::from_speed(35.0, 2.0, cardone, 0.0),
            "this wind means 41.8 m/s or more at 10 m: allowed are 0 to 40 m/s",
        ),
        (
            Wind::from_friction_velocity(-1.0, cardone, 0.0),
            "friction velocity of -1 m/s: allowed are 0 to 3 m/s",
        ),
        (Wind::from_speed(5.0, 10.0, cardone, f64::INFINITY), "wind direction of inf rad: it must be finite"),
    ];
    for (result, words) in refused {
        assert_eq!(result.unwrap_err().to_string(), words);
    }
    assert!(matches!(
        Wind::from_speed(38.0, 2.0, WindProfile::Wu, 0.0),
        Err(WindError::SpeedAt10m { u10_mps }) if u10_mps > 40.0
    ));
}

proptest! {
    #![proptest_config(crate::cases::proptests(256))]

    /// Any legal wind has a finite record that rises with height, and both ways in agree.
    #[test]
    fn any_legal_wind(speed in 0.0..=40.0f64, height in 1.0..100.0f64, wu in any::<bool>(), direction in -7.0..7.0f64) {
        let profile = if wu { WindProfile::Wu } else { WindProfile::Cardone };
        let strength = WindStrength::Speed { speed_mps: speed, height_m: height };
        let given = WindGiven { strength, profile, direction_rad: direction };
        let wind = match Wind::resolve(&given) {
            Ok(wind) => wind,
            // Only a wind given low over the sea can be too strong at 10 m.
            Err(WindError::SpeedAt10m { u10_mps }) => {
                prop_assert!(u10_mps > 40.0 && height < 10.0);
                return Ok(());
            }
            Err(other) => return Err(TestCaseError::fail(other.to_string())),
        };
        let Wind { ustar_cardone_mps, ustar_wu_mps, u10_mps, u12_5_mps, u19_5_mps, .. } = wind;
        for value in [ustar_cardone_mps, ustar_wu_mps, u10_mps, u12_5_mps, u19_5_mps] {
            prop_assert!(value.is_finite() && value >= 0.0);
        }
        prop_assert!(u10_mps <= u12_5_mps && u12_5_mps <= u19_5_mps);
        let ustar_mps = if wu { ustar_wu_mps } else { ustar_cardone_mps };
        let again = Wind::from_friction_velocity(ustar_mps, profile, direction).unwrap();
        // The profile's derivative with respect to u* is below 40, u* is exact to a few parts in 2^52.
        prop_assert!((again.u10_mps - u10_mps).abs() < 1e-11 * (1.0 + u10_mps));
        prop_assert!((again.u19_5_mps - u19_5_mps).abs() < 1e-11 * (1.0 + u19_5_mps));
    }
}
