//! `nereus table`: what is printed, beside the golden values; what is refused.

use nereus::scattering::permittivity::{Model, SeaWater};

use crate::program::{nereus, package};
use crate::table_golden::{Judge, beside, golden, groups, list, printed};
use crate::table_keys::refused;

/// Tolerance of closed forms in the golden set. Thirteen printed digits add 5e-13.
const CLOSED_FORM: f64 = 1e-9;

#[test]
fn permittivity_is_the_golden_one() {
    let mut judge = Judge::new("permittivity");
    let table = golden("permittivity.csv");
    for row in table.rows() {
        let [carrier_hz, t, s] = ["f_hz", "T_c", "S_psu"].map(|column| row.get(column));
        let water = SeaWater { temperature_c: t, salinity_gpkg: s };
        for (name, model) in [("mw", Model::MeissnerWentz2012), ("ks", Model::KleinSwift1977)] {
            let key = if name == "mw" { "mw12" } else { "ks77" };
            let keys = format!(
                "permittivity --model {key} --carrier-hz {carrier_hz} --temperature-c={t} --salinity-psu {s}"
            );
            // The golden file goes beyond the ranges of the models; the program does not.
            if !model.faults(carrier_hz, water).is_empty() {
                assert!(refused(&keys).contains("allowed"), "{keys}");
                continue;
            }
            let found = printed(&keys);
            let found = found.single();
            judge.compare(row, &format!("{name}_re"), found.get("permittivity_re"), CLOSED_FORM, 0.0);
            judge.compare(row, &format!("{name}_im"), found.get("permittivity_im"), CLOSED_FORM, 0.0);
        }
    }
}

#[test]
fn fresnel_is_the_golden_one() {
    let mut judge = Judge::new("fresnel");
    let table = golden("fresnel.csv");
    for group in groups(&table, &["f_hz", "T_c", "S_psu"]) {
        let [carrier_hz, t, s] = ["f_hz", "T_c", "S_psu"].map(|column| group[0].get(column));
        let angles = list(&group, "theta_deg");
        let found = printed(&format!(
            "fresnel --carrier-hz {carrier_hz} --temperature-c={t} --salinity-psu {s} --incidence-deg {angles}"
        ));
        for (row, found) in beside(&group, &found) {
            assert_eq!(found.get("incidence_deg"), row.get("theta_deg"));
            for column in ["rv_re", "rv_im", "rh_re", "rh_im"] {
                judge.compare(row, column, found.get(column), CLOSED_FORM, 0.0);
            }
            let power = found.get("rv_re").powi(2) + found.get("rv_im").powi(2);
            assert!((found.get("power_v") - power).abs() < 1e-12);
        }
    }
}

#[test]
fn wind_is_the_golden_one() {
    let mut judge = Judge::new("wind");
    let table = golden("wind.csv");
    let rows: Vec<_> = table.rows().collect();
    let found = printed(&format!("wind --ustar-mps {}", list(&rows, "ustar_m_s")));
    for (row, found) in beside(&rows, &found) {
        for (column, name) in [
            ("ustar_m_s", "ustar_cardone_mps"),
            ("z0_m", "roughness_cardone_m"),
            ("U10_m_s", "u10_mps"),
            ("U12p5_m_s", "u12p5_mps"),
            ("U19p5_m_s", "u19p5_mps"),
        ] {
            judge.compare(row, column, found.get(name), CLOSED_FORM, 0.0);
        }
    }

    let table = golden("wind_inverse.csv");
    let rows: Vec<_> = table.rows().collect();
    let found = printed(&format!("wind --wind-mps {} --wind-height-m 19.5", list(&rows, "U19p5_m_s")));
    for (row, found) in beside(&rows, &found) {
        for (column, name) in [
            ("ustar_cardone_m_s", "ustar_cardone_mps"),
            ("U10_m_s", "u10_mps"),
            ("ustar_wu_of_U10_m_s", "ustar_wu_mps"),
        ] {
            judge.compare(row, column, found.get(name), CLOSED_FORM, 0.0);
        }
    }
}

#[test]
fn spectra_are_the_golden_ones() {
    let mut judge = Judge::new("spectrum");
    let table = golden("spectrum_elfouhaily.csv");
    for group in groups(&table, &["U10_m_s", "Omega_c"]) {
        let [u, age] = ["U10_m_s", "Omega_c"].map(|column| group[0].get(column));
        let k = list(&group, "K_rad_m");
        let found = printed(&format!(
            "spectrum --kind elfouhaily --wind-mps {u} --inverse-wave-age {age} --k-rad-m {k}"
        ));
        for (row, found) in beside(&group, &found) {
            assert_eq!(found.get("k_rad_m"), row.get("K_rad_m"));
            judge.compare(row, "S_m3", found.get("s_m3"), CLOSED_FORM, 0.0);
            let b = row.get("Bl") + row.get("Bh");
            assert!((found.get("b") - b).abs() <= CLOSED_FORM * b, "line {}", row.line);
            let down = row.get("Psi_down_m4");
            judge.compare(row, "Psi_down_m4", found.get("psi_symmetric_along_m4"), CLOSED_FORM, 0.0);
            // Crosswind is proportional to 1 - Delta; where Delta is 1 but for roundings of 1e-16 only they
            // are left.
            let roundings = 4.0 * f64::EPSILON * down;
            let across = found.get("psi_symmetric_across_m4");
            judge.compare(row, "Psi_cross_m4", across, CLOSED_FORM, roundings);
            // Waves travel downwind, none up; on the border half a wave goes either way.
            judge.compare(row, "Psi_down_m4", 0.5 * found.get("psi_downwind_m4"), CLOSED_FORM, 0.0);
            assert_eq!((found.get("psi_upwind_m4"), found.get("psi_crosswind_m4")), (0.0, across));
        }
    }

    let table = golden("spectrum_fung_lee_pm.csv");
    for group in groups(&table, &["U19p5_m_s"]) {
        let keys = format!(
            "--wind-mps {} --wind-height-m 19.5 --k-rad-m {}",
            group[0].get("U19p5_m_s"),
            list(&group, "K_rad_m")
        );
        let fung_lee = printed(&format!("spectrum --kind fung-lee {keys}"));
        let developed = printed(&format!("spectrum --kind pierson-moskowitz {keys}"));
        for ((row, fung_lee), developed) in beside(&group, &fung_lee).into_iter().zip(developed.rows()) {
            let branch = if row.get("K_rad_m") < 4.0 { "S_grav_m3" } else { "S_cap_m3" };
            judge.compare(row, branch, fung_lee.get("s_m3"), CLOSED_FORM, 0.0);
            judge.compare(row, "S_pm_m3", developed.get("s_m3"), CLOSED_FORM, 0.0);
        }
    }

    let table = golden("spectrum_jonswap.csv");
    for group in groups(&table, &["U10_m_s", "fetch_m"]) {
        let [u, fetch_m] = ["U10_m_s", "fetch_m"].map(|column| group[0].get(column));
        let k = list(&group, "K_rad_m");
        let found =
            printed(&format!("spectrum --kind jonswap --wind-mps {u} --fetch-m {fetch_m} --k-rad-m {k}"));
        for (row, found) in beside(&group, &found) {
            judge.compare(row, "S_m3", found.get("s_m3"), CLOSED_FORM, 0.0);
        }
    }
}

#[test]
fn spreading_is_the_golden_one() {
    let mut judge = Judge::new("spreading");
    let table = golden("spreading_fung_lee.csv");
    for group in groups(&table, &["U12p5_m_s", "K_rad_m"]) {
        let keys = format!(
            "--wind-mps {} --wind-height-m 12.5 --k-rad-m {} --azimuth-deg={}",
            group[0].get("U12p5_m_s"),
            group[0].get("K_rad_m"),
            list(&group, "phi_deg")
        );
        // The paper's mix has the same directional function.
        for kind in ["fung-lee", "elfouhaily-fung-lee"] {
            let found = printed(&format!("spreading --kind {kind} {keys}"));
            for (row, found) in beside(&group, &found) {
                // The tolerance of the golden file, whose D is integrated.
                judge.compare(row, "Phi", found.get("spreading_symmetric_per_rad"), 1e-4, 0.0);
            }
        }
    }
}

#[test]
fn moments_are_the_golden_ones() {
    let mut judge = Judge::new("moments");
    let table = golden("spectrum_moments.csv");
    for row in table.rows() {
        let [u, age, low, high] = ["U10_m_s", "Omega_c", "K_lo", "K_hi"].map(|column| row.get(column));
        let keys = format!(
            "moments --kind elfouhaily --inverse-wave-age {age} --low-rad-m {low} --high-rad-m {high} --wind-mps {u}"
        );
        let found = printed(&keys);
        let found = found.single();
        for (column, name) in [
            ("Hs_m", "significant_height_m"),
            ("mss_total", "mss"),
            ("mss_up", "mss_up"),
            ("mss_cross", "mss_cross"),
        ] {
            // The tolerance of the golden file.
            judge.compare(row, column, found.get(name), 1e-6, 0.0);
        }
        let found = printed(&format!("{keys} --wind-height-m 12.5"));
        let found = found.single();
        judge.compare(row, "coxmunk_up_atU12p5=U", found.get("cox_munk_up"), CLOSED_FORM, 0.0);
        judge.compare(row, "coxmunk_cross", found.get("cox_munk_cross"), CLOSED_FORM, 0.0);
    }
}

#[test]
fn patch_and_facets_are_the_golden_ones() {
    let mut judge = Judge::new("kpeak-lmin, facet-density");
    let table = golden("kpeak_lmin.csv");
    for group in groups(&table, &["U19p5_m_s"]) {
        let found = printed(&format!(
            "kpeak-lmin --kind pierson-moskowitz --wind-mps {} --wind-height-m 19.5 --band-step {}",
            group[0].get("U19p5_m_s"),
            list(&group, "alpha")
        ));
        for (row, found) in beside(&group, &found) {
            for (column, name) in [
                ("Kpeak", "k_peak_rad_m"),
                ("K3dB_1", "k_low_rad_m"),
                ("K3dB_2", "k_high_rad_m"),
                ("Lmin_m", "least_length_m"),
            ] {
                judge.compare(row, column, found.get(name), CLOSED_FORM, 0.0);
            }
        }
    }
    let table = golden("rayleigh_density.csv");
    for row in table.rows() {
        let found = printed(&format!(
            "facet-density --wind-mps {} --wind-height-m 19.5 --carrier-hz {} --incidence-deg {}",
            row.get("U19p5_m_s"),
            row.get("f_hz"),
            row.get("theta_deg")
        ));
        let found = found.single();
        for (column, name) in [
            ("ustar", "ustar_cardone_mps"),
            ("h_rayleigh_m", "rayleigh_height_m"),
            ("h_c_m", "joint_height_m"),
            ("K_rayleigh", "k_rayleigh_rad_m"),
            ("facets_per_m", "facets_per_m"),
        ] {
            // The tolerance of the golden file.
            judge.compare(row, column, found.get(name), 1e-8, 0.0);
        }
    }
}

#[test]
fn slope_density_is_the_golden_one() {
    let mut judge = Judge::new("slope-pdf");
    let table = golden("slope_pdf.csv");
    for group in groups(&table, &["U12p5", "slick", "skew", "zy_cross"]) {
        let flag = |column, word| if group[0].get(column) == 1.0 { word } else { "" };
        let found = printed(&format!(
            "slope-pdf --wind-mps {} --wind-height-m 12.5 {} {} --crosswind-slope={} --downwind-slope={}",
            group[0].get("U12p5"),
            flag("slick", "--surface slick"),
            flag("skew", "--gram-charlier"),
            group[0].get("zy_cross"),
            list(&group, "zx_downwind")
        ));
        for (row, found) in beside(&group, &found) {
            judge.compare(row, "pdf", found.get("density"), CLOSED_FORM, 0.0);
        }
    }
}

const CHANNELS: [&str; 4] = ["vv", "vh", "hv", "hh"];

#[test]
fn cross_sections_are_the_golden_ones() {
    let mut judge = Judge::new("sigma0");
    let table = golden("facet_scatter.csv");
    let fresnel = golden("fresnel.csv");
    // The water of a facet table is that of the Fresnel table of the same set.
    let water = fresnel.rows().next().unwrap();
    let same = ["f_hz", "U10_elf_U12p5_coxmunk", "phiw_deg", "thi_deg", "ths_deg", "dphi_deg"];
    for row in table.rows() {
        let [carrier_hz, u, aspect, incidence, scattering, azimuth] = same.map(|column| row.get(column));
        let keys = format!(
            "sigma0 --splitting mars2007 --light-wind published --kind elfouhaily --carrier-hz {carrier_hz} --wind-mps {u} \
             --aspect-deg={aspect} --incidence-deg {incidence} --scattering-deg {scattering} \
             --azimuth-deg={azimuth} --slope-x={} --slope-y={} --temperature-c={} --salinity-psu {}",
            row.get("slope_x"),
            row.get("slope_y"),
            water.get("T_c"),
            water.get("S_psu")
        );
        // One number is the wind at 10 m for the spectrum, at 12.5 m for the slopes.
        let bragg = printed(&keys);
        let specular = printed(&format!("{keys} --wind-height-m 12.5"));
        let (bragg, specular) = (bragg.single(), specular.single());
        let largest = |value: &dyn Fn(&str) -> f64| CHANNELS.map(value).into_iter().fold(0.0, f64::max);
        // Straight ahead the Bragg vector is a rounding residue and the spectrum at it means nothing.
        let straight = azimuth == 0.0 && (incidence - scattering).abs() < 1e-9;
        let expected =
            |pq: &str| row.get(&format!("spm_{pq}_re")).powi(2) + row.get(&format!("spm_{pq}_im")).powi(2);
        for pq in CHANNELS {
            if straight && row.get("slope_x") == 0.0 && row.get("slope_y") == 0.0 {
                break;
            }
            let found = ratio(bragg.get(&format!("spm_{pq}_db")));
            // 1e-8 of the set, twice for a power; nine decimals of dB are 1e-10; what vanishes by symmetry is
            // a residue of 1e-14 in amplitude of the row's largest.
            let error = (found - expected(pq)).abs();
            assert!(
                error <= 2e-8 * expected(pq) + 1e-28 * largest(&expected),
                "line {}, spm {pq}: {found:e}, golden {:e}",
                row.line,
                expected(pq)
            );
        }
        for pq in CHANNELS {
            let column = format!("go_sigma0_{pq}");
            // Below -240 dB the specular part is not evaluated: it is zero by definition (`two_scale`).
            let residue = 1e-24 + 1e-28 * largest(&|pq| row.get(&format!("go_sigma0_{pq}")));
            judge.compare(row, &column, ratio(specular.get(&format!("go_{pq}_db"))), 1e-8, residue);
            let sum = ratio(bragg.get(&format!("spm_{pq}_db"))) + ratio(bragg.get(&format!("go_{pq}_db")));
            let total = ratio(bragg.get(&format!("sigma0_{pq}_db")));
            // Three roundings to nine decimals of dB.
            assert!((total - sum).abs() <= 1e-9 * sum, "line {}", row.line);
        }
    }
}

fn ratio(decibels: f64) -> f64 {
    10f64.powf(decibels / 10.0)
}

/// The NRCS table of docs/physics.md section 10.6 at 45 degrees upwind (10 GHz, 10 m/s, whole sea, averaged
/// over tilts), where specular points hardly count: to half its last digit, 0.05 dB.
#[test]
fn the_default_is_the_whole_sea_seen_from_the_transmitter() {
    let found = printed("sigma0 --light-wind published --kind elfouhaily --wind-mps 10 --incidence-deg 45");
    let found = found.single();
    for (column, expected) in
        [("sigma0_vv_db", -13.6), ("sigma0_hh_db", -19.8), ("sigma0_vh_db", -34.6), ("sigma0_hv_db", -34.6)]
    {
        assert!((found.get(column) - expected).abs() <= 0.05, "{column}: {}", found.get(column));
    }
    assert_eq!((found.get("scattering_deg"), found.get("azimuth_deg")), (45.0, 180.0));
}

/// The worked example of another program (MathWorks, `seareflectivity`): 2.1555e-4, cut or rounded; all seven
/// sea states from 0.1 to 60 degrees unless asked otherwise.
#[test]
fn measured_clutter_is_that_of_another_program() {
    let found = printed("sigma0-nrl --carrier-hz 30e9 --sea-state 2 --grazing-deg 10");
    let found = found.single();
    assert!((2.15545e-4..2.1556e-4).contains(&ratio(found.get("sigma0_hh_db"))));
    assert_eq!(found.get("incidence_deg"), 80.0);
    let usual = printed("sigma0-nrl");
    let grazing = |i: usize| usual.rows().nth(i).unwrap().get("grazing_deg");
    assert_eq!((usual.rows().len(), grazing(0), grazing(27)), (7 * 28, 0.1, 60.0));
    // A wind is the sea it raises in time.
    let risen = printed("sigma0-nrl --wind-mps 10 --grazing-deg 1");
    let sea_state = risen.single().get("sea_state");
    let same = printed(&format!("sigma0-nrl --sea-state {sea_state} --grazing-deg 1"));
    assert_eq!(same.single().get("sigma0_vv_db"), risen.single().get("sigma0_vv_db"));
    assert!((same.single().get("u10_mps") - 10.0).abs() < 1e-12);
}

/// Before: Mitsuyasu's spreading had a cusp at the Bragg waves, and exactly upwind and downwind were 1.9 dB
/// lower than 10 degrees beside.
#[test]
fn sigma0_is_smooth_upwind_and_downwind() {
    for kind in ["jonswap", "pierson-moskowitz"] {
        let asked = [
            "table",
            "sigma0",
            "--kind",
            kind,
            "--vary",
            "aspect",
            "--wind-mps",
            "10",
            "--incidence-deg",
            "45",
        ];
        let ended = nereus(package(), &asked);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        let mut rows = csv::Reader::from_reader(ended.stdout.as_bytes());
        let column =
            |name: &str, headers: &csv::StringRecord| headers.iter().position(|own| own == name).unwrap();
        let headers = rows.headers().unwrap().clone();
        let (aspect, vv) = (column("aspect_deg", &headers), column("sigma0_vv_db", &headers));
        let rows: Vec<(f64, f64)> = rows
            .records()
            .map(|row| row.unwrap())
            .map(|row| (row[aspect].parse().unwrap(), row[vv].parse().unwrap()))
            .collect();
        assert!(rows.len() > 30 && rows.iter().any(|(aspect, _)| *aspect == 180.0));
        for pair in rows.windows(2) {
            assert!((pair[1].1 - pair[0].1).abs() < 0.8, "{kind}: {pair:?}");
        }
        let at = |wanted: f64| rows.iter().find(|(aspect, _)| *aspect == wanted).unwrap().1;
        assert!(at(180.0) > at(170.0) && at(180.0) > at(90.0) + 1.0, "{kind}");
    }
}
