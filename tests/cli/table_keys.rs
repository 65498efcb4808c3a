//! Keys of `nereus table`: sweeps, spacing, limits, what is refused, names of columns.

use crate::program::{nereus, package};
use crate::table_golden::printed;

#[test]
fn any_angle_is_swept() {
    for (angle, rows) in [("incidence", 17), ("scattering", 17), ("azimuth", 37), ("aspect", 37)] {
        let usual = printed(&format!("sigma0 --untilted --vary {angle}"));
        assert_eq!(usual.rows().len(), rows, "{angle}");
        let asked = printed(&format!(
            "sigma0 --untilted --vary {angle} --from-deg 10 --to-deg 40 --points 3 --facet-m 1"
        ));
        let column = format!("{angle}_deg");
        assert_eq!(asked.rows().map(|row| row.get(&column)).collect::<Vec<_>>(), [10.0, 25.0, 40.0]);
        if angle != "incidence" {
            assert!(asked.rows().all(|row| row.get("incidence_deg") == 45.0));
        }
    }
    // Rows are all combinations of the lists, in order.
    let found =
        printed("sigma0 --splitting mars2007 --ustar-mps 0.2,0.36 --aspect-deg -90,0 --incidence-deg 30,60");
    let order: Vec<[f64; 2]> =
        found.rows().map(|row| [row.get("aspect_deg"), row.get("incidence_deg")]).collect();
    let once = [[-90.0, 30.0], [-90.0, 60.0], [0.0, 30.0], [0.0, 60.0]];
    assert_eq!(order, [once, once].concat());
    let negative = printed("slope-pdf --vary crosswind --from-slope -0.1 --to-slope 0.1 --step-slope 0.1");
    assert_eq!(negative.rows().map(|row| row.get("crosswind_slope")).collect::<Vec<_>>(), [-0.1, 0.0, 0.1]);
}

#[test]
fn spacing_is_linear_or_in_ratios() {
    let column =
        |keys: &str, name: &str| -> Vec<f64> { printed(keys).rows().map(|row| row.get(name)).collect() };
    let decades = column("spectrum --from-rad-m 0.01 --to-rad-m 100 --points 5", "k_rad_m");
    for (k, expected) in decades.iter().zip([0.01, 0.1, 1.0, 10.0, 100.0]) {
        assert!((k / expected - 1.0).abs() < 1e-14, "{k}");
    }
    assert_eq!(
        column("spectrum --from-rad-m 1 --to-rad-m 3 --points 3 --spacing linear", "k_rad_m"),
        [1.0, 2.0, 3.0]
    );
    let carriers = column("permittivity --from-hz 9e9 --to-hz 10e9 --step-hz 0.25e9", "carrier_hz");
    assert_eq!(carriers, [9e9, 9.25e9, 9.5e9, 9.75e9, 10e9]);
    // What is not given is the table's: carriers over the range of the model.
    let carriers = column("permittivity --model ks77", "carrier_hz");
    assert_eq!((carriers.len(), carriers[0], carriers[39]), (40, 1e9, 10e9));
    assert_eq!(
        column("wind --from-mps 5 --to-mps 15 --step-mps 5 --wind-height-m 19.5", "u19p5_mps"),
        [5.0, 10.0, 15.0]
    );
}

/// Weakest, weak and strongest wind, in every spectrum: numbers everywhere (decibels of nothing are -inf).
#[test]
fn extremes_give_numbers() {
    let spectra = [
        "elfouhaily --inverse-wave-age 5",
        "fung-lee",
        "elfouhaily-fung-lee --fetch-m 1e7",
        "pierson-moskowitz --spreading 1000",
        "jonswap --fetch-m 100 --spreading elfouhaily",
    ];
    for spectrum in spectra {
        for table in [
            "spectrum --k-rad-m 1e-9,1e-3,4,400,1e8",
            "spreading --k-rad-m 1e-9,1e8",
            "moments",
            "kpeak-lmin",
        ] {
            let keys = format!("{table} --kind {spectrum} --wind-mps 0,0.1,0.3,40");
            for row in printed(&keys).rows() {
                assert!(row.all(f64::is_finite), "{keys}, line {}", row.line);
            }
        }
        let keys = format!(
            "sigma0 --kind {spectrum} --wind-mps 0,40 --carrier-hz 1e9,90e9 --incidence-deg 0,45,90 \
             --azimuth-deg 0,90,180 --gram-charlier --surface slick"
        );
        for row in printed(&keys).rows() {
            assert!(row.all(|x| x.is_finite() || x == f64::NEG_INFINITY), "{keys}, line {}", row.line);
        }
    }
    for keys in [
        "wind --ustar-mps 0,0.001,0.004,0.02",
        "wind --profile wu --wind-mps 0,40",
        "facet-density --wind-mps 0.3,40 --carrier-hz 1e8,1e12 --incidence-deg 0,89.999",
        "slope-pdf --wind-mps 0,40 --downwind-slope=-10,0,10 --gram-charlier",
        "fresnel --incidence-deg 0,89.999,90 --salinity-psu 0,40 --temperature-c -2,34",
    ] {
        for row in printed(keys).rows() {
            assert!(row.all(f64::is_finite), "{keys}, line {}", row.line);
        }
    }
}

/// Standard error of a table that is refused; nothing is printed.
pub fn refused(keys: &str) -> String {
    let words: Vec<&str> = ["table"].into_iter().chain(keys.split_whitespace()).collect();
    let ended = nereus(package(), &words);
    assert_eq!(ended.code, 2, "{keys}: {}", ended.stderr);
    assert!(ended.stdout.is_empty(), "{keys}");
    ended.stderr
}

#[test]
fn bad_keys_are_refused_in_words() {
    for (keys, words) in [
        ("permittivity --carrier-hz 0.5e9", "frequency is 0.5 GHz, allowed 1 to 90 GHz"),
        (
            "permittivity --model ks77 --carrier-hz 10e9 --salinity-psu 3",
            "salinity is 3 psu, allowed 4 to 35",
        ),
        ("permittivity --temperature-c -3", "temperature is -3 degrees Celsius, allowed -2 to 34"),
        ("permittivity --temperature-c nan", "allowed -2 to 34"),
        ("permittivity --carrier-hz ten", "ten"),
        ("permittivity --carrier-hz 1e10 --to-hz 2e10", "--carrier-hz and --to-hz both say"),
        ("permittivity --carrier-hz 1e10,inf", "allowed 1 to 90 GHz"),
        ("fresnel --incidence-deg 91", "--incidence-deg 91 is not allowed; allowed: 0 to 90"),
        ("fresnel --from-deg -5 --to-deg 5", "--incidence-deg -5 is not allowed; allowed: 0 to 90"),
        ("fresnel --from-deg 30 --to-deg 20", "--from-deg 30 --to-deg 20 --step-deg 5: allowed"),
        ("fresnel --step-deg 1 --points 4", "cannot be used with"),
        ("fresnel --spacing log", "--points"),
        ("wind --wind-mps 41", "wind of 41 m/s: allowed are 0 to 40 m/s"),
        ("wind --wind-mps=-1", "wind of -1 m/s: allowed are 0 to 40 m/s"),
        ("wind --wind-mps 10 --wind-height-m 0.5", "wind given at 0.5 m: allowed are 1 to 100 m"),
        ("wind --wind-height-m 19.5", "--wind-height-m is the height of a wind speed"),
        ("wind --ustar-mps 0.3 --wind-mps 10", "cannot be used with"),
        ("wind --ustar-mps 0.3 --from-mps 3", "--ustar-mps and --from-mps both say"),
        ("wind --ustar-mps 4", "friction velocity of 4 m/s: allowed are 0 to 3 m/s"),
        ("spectrum --k-rad-m 0", "--k-rad-m 0 is not allowed"),
        ("spectrum --from-rad-m 0", "above 0 in log spacing"),
        ("spectrum --kind phillips", "elfouhaily-fung-lee"),
        (
            "spectrum --kind jonswap --inverse-wave-age 1",
            "--inverse-wave-age means nothing to --kind jonswap",
        ),
        ("spectrum --kind fung-lee --fetch-m 1e5", "allowed with elfouhaily, elfouhaily-fung-lee, jonswap"),
        ("spectrum --spreading mitsuyasu", "--spreading means nothing to --kind elfouhaily-fung-lee"),
        ("spectrum --kind jonswap --spreading narrow", "allowed: mitsuyasu, elfouhaily, or the exponent"),
        ("spectrum --kind jonswap --spreading=-1", "spreading exponent of -1: allowed are 0 to 1000"),
        ("spectrum --kind jonswap --fetch-m 1", "fetch of 1 m: allowed are 100"),
        ("spectrum --kind elfouhaily --inverse-wave-age 6", "allowed are 0.84 (fully developed) to 5"),
        ("spectrum --kind measured", "--kind measured needs --spectrum-path FILE"),
        ("spectrum --kind measured --spectrum-path no/such.csv", "no/such.csv"),
        ("spectrum --spectrum-path x.csv", "--spectrum-path means nothing"),
        ("spreading --azimuth-deg 400", "--azimuth-deg 400 is not allowed; allowed: -360 to 360"),
        ("moments --low-rad-m 10 --high-rad-m 1", "--high-rad-m 1 is not allowed; allowed: 10 to"),
        ("sigma0 --incidence-deg 95", "--incidence-deg 95 is not allowed; allowed: 0 to 90"),
        ("sigma0 --modulated --splitting mars2007", "allowed: --splitting consistent"),
        ("sigma0 --vary azimuth --incidence-deg 95", "--incidence-deg 95"),
        ("sigma0 --incidence-deg 30 --from-deg 10", "--incidence-deg and --from-deg both say"),
        ("sigma0 --facet-m 0", "--facet-m 0 is not allowed"),
        ("sigma0 --cut-rad-m nan", "--cut-rad-m NaN is not allowed"),
        ("sigma0 --slope-x 11", "--slope-x 11 is not allowed; allowed: -10 to 10"),
        ("sigma0 --splitting half", "consistent"),
        ("sigma0 --carrier-hz 100e9", "frequency is 100 GHz"),
        ("sigma0-nrl --grazing-deg 70", "--grazing-deg 70 is not allowed; allowed: 0.1 to 60"),
        ("sigma0-nrl --from-deg 0 --to-deg 10 --step-deg 1", "--grazing-deg 0 is not allowed"),
        ("sigma0-nrl --grazing-deg 1 --from-deg 2", "--grazing-deg and --from-deg both say"),
        ("sigma0-nrl --sea-state 7", "sea state is 7, allowed 0 to 6"),
        ("sigma0-nrl --wind-mps 15", "wind is 15 m/s, allowed 1.99 to 12.92 m/s"),
        ("sigma0-nrl --wind-mps nan", "wind is NaN m/s"),
        ("sigma0-nrl --wind-mps 5 --sea-state 3", "cannot be used with"),
        ("sigma0-nrl --carrier-hz 10e9,40e9", "carrier is 40 GHz, allowed 0.5 to 35 GHz"),
        ("slope-pdf --from-slope nan", "--from-slope NaN"),
        ("slope-pdf --downwind-slope 11", "--downwind-slope 11"),
        ("facet-density --wind-mps 0.2", "raises no waves; allowed: at least 0.3 m/s"),
        ("facet-density --incidence-deg 90", "--incidence-deg 90 is not allowed"),
        ("facet-density --carrier-hz 1", "--carrier-hz 1 is not allowed"),
        ("kpeak-lmin --band-step 0", "--band-step 0 is not allowed; allowed: 0.001 to 1"),
        ("antenna --shape circle --width-m 1 --carrier-hz 1e10 --from-deg -91", "allowed: -90 to 90"),
        ("depth", "unrecognized subcommand"),
    ] {
        let stderr = refused(keys);
        assert!(stderr.contains(words), "{keys}: {stderr}");
    }
}

#[test]
fn tables_have_an_end() {
    for (keys, words) in [
        ("permittivity --from-hz 1e9 --to-hz 2e9 --step-hz 1", "at most 1000000 rows"),
        ("spectrum --points 1000001", "1 to 1000000 points"),
        ("spectrum --points 0", "1 to 1000000 points"),
        ("spreading --points 400000", "a table of 1600000 rows; allowed: at most 1000000"),
        ("sigma0 --points 1000000 --azimuth-deg 0,180 --aspect-deg 0", "a table of 2000000 rows"),
        ("sigma0 --vary aspect --points 10001", "10001 different seas"),
        ("sigma0-nrl --points 200000", "a table of 1400000 rows"),
        ("moments --points 10001", "10001 different seas"),
    ] {
        let stderr = refused(keys);
        assert!(stderr.contains(words), "{keys}: {stderr}");
    }
    let most = printed("wind --from-mps 1 --to-mps 25 --points 20000");
    assert_eq!(most.rows().len(), 20_000);
}

#[test]
fn names_of_columns_bear_units() {
    for table in [
        "permittivity",
        "fresnel",
        "wind",
        "spectrum",
        "spreading",
        "moments",
        "sigma0 --incidence-deg 45",
        "sigma0-nrl",
        "slope-pdf",
        "facet-density",
        "kpeak-lmin",
        "wake-resistance --speed-mps 5",
    ] {
        let found = printed(table);
        for name in found.columns() {
            let unit = name.rsplit('_').next().unwrap();
            let units = ["hz", "c", "psu", "deg", "mps", "m", "m2", "m3", "m4", "rad", "db", "n"];
            // Numbers without a unit.
            let bare = [
                "permittivity_re",
                "permittivity_im",
                "rv_re",
                "rv_im",
                "rh_re",
                "rh_im",
                "power_v",
                "power_h",
            ];
            let pure = [
                "sea_state",
                "b",
                "density",
                "band_step",
                "downwind_slope",
                "crosswind_slope",
                "facets_per_m",
                "froude",
                "cw",
            ];
            let slopes = name.starts_with("mss") || name.starts_with("cox_munk");
            assert!(
                units.contains(&unit)
                    || bare.contains(&name.as_str())
                    || pure.contains(&name.as_str())
                    || slopes,
                "{table}: {name}"
            );
        }
    }
}
