//! Antennas that scan, and tapered apertures.

use super::*;
use crate::scene::radar::{ApertureTaper, Encoder, Scan, ScanLaw};

/// Of every key.
pub(super) fn variants() -> Vec<(&'static str, Vec<(&'static str, &'static str)>)> {
    [
        "{ kind = 'scan', rpm = 20, about = 'north' }",
        "{ kind = 'sector', from_deg = -10, to_deg = 10, rate_degps = 5, elevations_deg = [0], encoder_bits = 12 }",
        "{ kind = 'steps', azimuths_deg = [-10, 10], dwell_pulses = 9 }",
    ]
    .map(|pointing| vec![("transmitter.0.pointing", pointing)])
    .into_iter()
    .chain([vec![("transmitter.0.antenna", TAPERED)]])
    .map(|settings| (COASTAL, settings))
    .collect()
}

const TAPERED: &str =
    "{ kind = 'rectangle', width_m = 4.0, height_m = 0.05, taper = 'taylor', sidelobe_db = 35.0 }";

/// The transmitter of coastal.toml with another pointing and another antenna.
fn with(pointing: &str, antenna: &str) -> Result<Run, ConfigError> {
    coastal_with(&[("transmitter.0.pointing", pointing), ("transmitter.0.antenna", antenna)])
}

const PLAIN: &str = "{ kind = 'rectangle', width_m = 4.0, height_m = 0.05 }";

#[test]
fn scans_arrive() {
    let run = with("{ kind = 'scan', rpm = -30.0, start_deg = 90.0, elevation_deg = -1.0 }", PLAIN).unwrap();
    let Pointing::Scan(scan) = &run.scene.radar.transmitters[0].antenna.pointing else { panic!() };
    let law = ScanLaw::Rotation {
        rate_rad_per_s: -std::f64::consts::PI,
        start_rad: 90f64.to_radians(),
        elevation_rad: (-1f64).to_radians(),
    };
    assert_eq!(*scan, Scan { law, level_by: None, encoder: Encoder::default() });
    let sector = "{ kind = 'sector', from_deg = -10.0, to_deg = 20.0, rate_degps = 60.0, about = 'north', \
                  elevations_deg = [0.0, 3.0], encoder_bits = 12, encoder_bias_deg = 0.5 }";
    let run = with(sector, PLAIN).unwrap();
    let Pointing::Scan(scan) = &run.scene.radar.transmitters[0].antenna.pointing else { panic!() };
    assert_eq!(scan.level_by, Some(AimFrom::Reported));
    assert_eq!((scan.encoder.bits, scan.encoder.bias_rad), (Some(12), 0.5f64.to_radians()));
    let ScanLaw::Sector { turn_s, elevations_rad, .. } = &scan.law else { panic!() };
    assert_eq!((*turn_s, elevations_rad.len()), (0.1, 2));
}

#[test]
fn beams_that_jump_arrive() {
    let steps = "{ kind = 'steps', azimuths_deg = [0, 90], elevations_deg = [-1.0], dwell_pulses = 8 }";
    let run = with(steps, PLAIN).unwrap();
    let Pointing::Scan(scan) = &run.scene.radar.transmitters[0].antenna.pointing else { panic!() };
    let ScanLaw::Steps { directions_rad, dwell_pulses, dwell_s } = &scan.law else { panic!() };
    let down_rad = (-1f64).to_radians();
    assert_eq!(*directions_rad, [[0.0, down_rad], [90f64.to_radians(), down_rad]]);
    assert_eq!(*dwell_pulses, 8);
    assert!((dwell_s - 8.0 * run.scene.radar.emissions.mean_pri_s()).abs() < 1e-15);
    for (more, said) in [
        (
            ("transmitter.0.pointing.elevations_deg", "[1, 2, 3]"),
            "pointing.elevations_deg: 3 elevations is not allowed; allowed: 2, one for each azimuth, or one for all",
        ),
        (
            ("radar.window", "{ gate = 'continuous', samples = 4000 }"),
            "a beam that jumps (pointing.kind = \"steps\") beside gate = \"continuous\"",
        ),
    ] {
        let found = coastal_with(&[("transmitter.0.pointing", steps), more]).unwrap_err().to_string();
        assert!(found.contains(said), "{found}");
    }
}

#[test]
fn tapers_arrive() {
    let run = with("{ kind = 'fixed' }", TAPERED).unwrap();
    let tapers = [ApertureTaper::Taylor { sidelobe_db: 35.0 }, ApertureTaper::Uniform];
    let tapered = Pattern::Tapered { width_m: 4.0, height_m: 0.05, tapers };
    assert_eq!(run.scene.radar.transmitters[0].antenna.pattern, tapered);
}

#[test]
fn what_makes_no_sense_is_named() {
    let refused = |pointing: &str, antenna: &str| with(pointing, antenna).unwrap_err().to_string();
    for (pointing, said) in [
        (
            "{ kind = 'scan' }",
            "transmitter.0.pointing.rpm: is missing; required: a number from -600 to 600 1/min",
        ),
        (
            "{ kind = 'scan', rpm = 700.0 }",
            "pointing.rpm: 700.0 is out of range; allowed: a number from -600 to 600",
        ),
        (
            "{ kind = 'sector', from_deg = 5.0, to_deg = 5.0, rate_degps = 10.0 }",
            "pointing.to_deg: 5.0 is out of range; allowed: an azimuth other than from_deg",
        ),
        ("{ kind = 'scan', rpm = 20.0, about = 'stern' }", "allowed: \"nose\", \"north\""),
        ("{ kind = 'scan', rpm = 20.0, rate_degps = 3.0 }", "pointing.rate_degps"),
        ("{ kind = 'scan', rpm = 20.0, encoder_bits = 40 }", "allowed: a whole number from 4 to 30"),
        ("{ kind = 'scan', rpm = 20.0, aim_from = 'true' }", "pointing.aim_from"),
    ] {
        let found = refused(pointing, PLAIN);
        assert!(found.contains(said), "{pointing}: {found}");
    }
    let antenna =
        "{ kind = 'rectangle', width_m = 4.0, height_m = 0.05, taper = 'cosine', sidelobe_db = 30.0 }";
    let found = refused("{ kind = 'fixed' }", antenna);
    assert!(found.contains("antenna.sidelobe_db: not allowed here (neither taper is \"taylor\")"), "{found}");
}
