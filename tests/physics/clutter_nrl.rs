//! The NRL sea clutter model beside what others computed with it, and beside the measurements it was fitted
//! to.

use nereus::scattering::clutter_nrl::{GRAZING_DEG, SeaState, sigma0};
use proptest::prelude::*;

/// A measured value of Nathanson's tables.
struct Measured {
    grazing_deg: f64,
    sea_state: f64,
    carrier_ghz: f64,
    horizontal: bool,
    sigma0_db: f64,
}

impl Measured {
    /// What the model has there, less what was measured, dB.
    fn deviation_db(&self) -> f64 {
        let sea = SeaState::new(self.sea_state).unwrap();
        let model = sigma0(self.carrier_ghz * 1e9, self.grazing_deg.to_radians(), sea).unwrap();
        db(if self.horizontal { model.hh } else { model.vv }) - self.sigma0_db
    }
}

fn db(ratio: f64) -> f64 {
    10.0 * ratio.log10()
}

fn nathanson() -> Vec<Measured> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/clutter/nathanson.csv");
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("grazing_deg,sea_state,carrier_ghz,channel,sigma0_db"));
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let number = |i: usize| cells[i].parse::<f64>().unwrap();
            assert!(["hh", "vv"].contains(&cells[3]), "{line}");
            Measured {
                grazing_deg: number(0),
                sea_state: number(1),
                carrier_ghz: number(2),
                horizontal: cells[3] == "hh",
                sigma0_db: number(4),
            }
        })
        .collect()
}

fn mean(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().sum::<f64>() / values.count() as f64
}

#[test]
fn the_worked_example_of_another_program() {
    // MathWorks, Radar Toolbox, page of `seareflectivity`: scale 2, grazing 10, 30e9 Hz gives 2.1555e-04.
    let found = sigma0(30e9, 10f64.to_radians(), SeaState::new(2.0).unwrap()).unwrap().hh;
    // Its fifth digit, cut or rounded. (The coefficients as rounded in Table 1 of the report give 2.1559e-4.)
    assert!((2.15545e-4..2.1556e-4).contains(&found), "{found:e}");
}

#[test]
fn deviations_from_nathanson_are_those_of_the_report() {
    let tables = nathanson();
    // How many values were fitted: page 6 of the report.
    for (horizontal, count) in [(true, 267), (false, 286)] {
        assert_eq!(tables.iter().filter(|value| value.horizontal == horizontal).count(), count);
    }
    // Mean absolute deviations, dB: to 10 degrees from its Table 2, to half the last digit; to 60 degrees
    // from the heading of its listing of SigmaSea_vs_Freq.m, likewise. (Table 3 has 2.6 for both.)
    for (horizontal, most_deg, printed, tolerance) in [
        (true, 10.0, 2.3, 0.05),
        (false, 10.0, 2.2, 0.05),
        (true, 60.0, 2.64, 0.005),
        (false, 60.0, 2.54, 0.005),
    ] {
        let such = tables.iter().filter(|v| v.horizontal == horizontal && v.grazing_deg <= most_deg);
        let found = mean(such.map(|value| value.deviation_db().abs()));
        let name = if horizontal { "HH" } else { "VV" };
        println!("{name} to {most_deg} deg: mean deviation {found:.3} dB, printed {printed}");
        assert!((found - printed).abs() <= tolerance, "{name} to {most_deg} deg: {found}, printed {printed}");
    }
}

#[test]
fn x_band_is_near_what_was_measured() {
    let tables = nathanson();
    for horizontal in [true, false] {
        let x = tables.iter().filter(|v| v.carrier_ghz == 9.3 && v.horizontal == horizontal);
        let (count, absolute) = (x.clone().count(), mean(x.clone().map(|v| v.deviation_db().abs())));
        let offset = mean(x.clone().map(Measured::deviation_db));
        println!(
            "X band, {}: {count} values, mean {offset:.2} dB, absolute {absolute:.2} dB",
            if horizontal { "HH" } else { "VV" }
        );
        // 2.6 dB is the mean absolute deviation over all bands; that of a Laplace law with this mean spreads
        // by as much, so a mean of 46 lies within 3 * 2.6/sqrt(46) = 1.2 dB of it, and the offset, of spread
        // 2.6 sqrt 2, within 1.7.
        assert!(count >= 46 && absolute < 2.6 + 1.2 && offset.abs() < 1.7);
    }
}

#[test]
fn winds_and_sea_states_are_those_of_the_report() {
    // Sea state 0 is a wind below 4 knots (page 2 of the report): 2.06 m/s; its fit has 3.85 knots.
    let calm = SeaState::new(0.0).unwrap();
    assert!((3.5..4.0).contains(&(calm.wind_mps() / 0.514_444)), "{}", calm.wind_mps());
    // The other fit of the report, in its listing of the GIT model: 2.15 s^1.04 m/s. They are two fits of one
    // table whose steps are 2 m/s wide: half a step, and a tenth.
    for number in 1..=6 {
        let sea = SeaState::new(f64::from(number)).unwrap();
        let other_mps = 2.15 * f64::from(number).powf(1.04);
        println!(
            "sea state {number}: {:.2} m, {:.2} m/s, {other_mps:.2} m/s",
            sea.wave_height_m(),
            sea.wind_mps()
        );
        assert!((sea.wind_mps() - other_mps).abs() < 1.0 + 0.1 * other_mps);
    }
    // A fully risen sea has 4 sigma_h = 0.0213 U^2 (Pierson and Moskowitz) where the two laws cross, near 10
    // m/s; their powers are 2 and 2.5: from 5 to 12.9 m/s they part by (12.9/5)^0.5, a factor 1.6 in all.
    for wind_mps in [5.0f64, 10.0, 12.9] {
        let height_m = SeaState::of_wind(wind_mps).unwrap().wave_height_m();
        let ratio = height_m / (0.0213 * wind_mps * wind_mps);
        assert!((1.0 / 1.6..1.6).contains(&ratio), "{wind_mps} m/s: {height_m} m");
    }
}

#[test]
fn outside_the_measurements_is_an_error_in_words() {
    let sea = SeaState::new(3.0).unwrap();
    let message = |carrier_hz, grazing_deg: f64| {
        sigma0(carrier_hz, grazing_deg.to_radians(), sea).unwrap_err().to_string()
    };
    assert_eq!(message(0.4e9, 1.0), "NRL sea clutter model: carrier is 0.4 GHz, allowed 0.5 to 35 GHz");
    assert!(message(10e9, 60.1).contains("grazing angle is 60.1"));
    assert!(message(10e9, 0.09).contains("allowed 0.1 to 60 degrees"));
    assert!(
        message(f64::NAN, 1.0).contains("carrier is NaN") && message(10e9, f64::NAN).contains("angle is NaN")
    );
    assert_eq!(
        SeaState::new(7.0).unwrap_err().to_string(),
        "NRL sea clutter model: sea state is 7, allowed 0 to 6"
    );
    assert!(SeaState::new(-0.1).is_err() && SeaState::new(f64::NAN).is_err());
    assert!(
        SeaState::of_wind(15.0).unwrap_err().to_string().starts_with("NRL sea clutter model: wind is 15 m/s")
    );
    assert!(SeaState::of_wind(1.9).is_err() && SeaState::of_wind(f64::NAN).is_err());
    for end in GRAZING_DEG {
        assert!(sigma0(0.5e9, end.to_radians(), sea).is_ok() && sigma0(35e9, end.to_radians(), sea).is_ok());
    }
}

proptest! {
    #![proptest_config(crate::cases::proptests(256))]

    #[test]
    fn every_legal_sea_is_finite_and_rougher_is_brighter(
        carrier_hz in 0.5e9..=35e9f64,
        grazing_deg in 0.1..=60.0f64,
        number in 0.0..=6.0f64,
        step in 0.0..=1.0f64,
    ) {
        let grazing_rad = grazing_deg.to_radians().clamp(0.1f64.to_radians(), 60f64.to_radians());
        let sea = SeaState::new(number).unwrap();
        let found = sigma0(carrier_hz, grazing_rad, sea).unwrap();
        // The dimmest corner (0.5 GHz, 0.1 degrees, sea state 0) is -112.5 dB; Nathanson's brightest value is
        // -4 dB, and the fit is nowhere more than 12 dB above a value.
        for level in [db(found.hh), db(found.vv)] {
            prop_assert!((-112.5..=8.0).contains(&level), "{}", level);
        }
        let rougher = SeaState::new((number + step).min(6.0)).unwrap();
        let more = sigma0(carrier_hz, grazing_rad, rougher).unwrap();
        // The wind comes back: a power and its root, some roundings of 1e-16 times the powers 2.5 and 2.1,
        // the difference h - 0.04 of a calm losing digits.
        let again = SeaState::of_wind(sea.wind_mps()).unwrap();
        prop_assert!((again.wind_mps() - sea.wind_mps()).abs() < 1e-14 * 13.0, "{:?} {:?}", again, sea);
        prop_assert!(rougher.wind_mps() >= sea.wind_mps());
        // (1 + s)^(1/(2 + a + b s)) grows with s as long as ln(1 + s) < (2 + a + b s)/(b (1 + s)): here for
        // all s to 6.
        prop_assert!(more.hh >= found.hh * (1.0 - 1e-12) && more.vv >= found.vv * (1.0 - 1e-12));
    }
}
