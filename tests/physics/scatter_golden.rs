//! Every row of the golden tables of permittivity, Fresnel, SPM, slope densities and whole facets.

use glam::DVec3;
use nereus::scattering::fresnel::reflection;
use nereus::scattering::kirchhoff::Specular;
use nereus::scattering::permittivity::{Model, SeaWater};
use nereus::scattering::slope_pdf::{GramCharlier, MeanSquareSlope, SlopePdf};
use nereus::scattering::spm;
use nereus::scattering::tilt::{Path, Tangent};
use nereus::units::SPEED_OF_LIGHT_MPS;
use num_complex::Complex64;

use crate::scatter_laws::alphas;
use crate::scatter_oracle::{Elfouhaily, Golden};

/// The tables carry 13 digits (5e-13); f64 sums of some 20 terms add less. 1e-9 is the set's own figure.
const CLOSED_FORM: f64 = 1e-9;

fn relative(found: f64, expected: f64, scale: f64) -> f64 {
    (found - expected).abs() / scale.abs().max(f64::MIN_POSITIVE)
}

#[test]
fn permittivity_rows() {
    let table = Golden::read("permittivity.csv");
    let [f, t, s] = ["f_hz", "T_c", "S_psu"].map(|name| table.column(name));
    let columns = ["mw_re", "mw_im", "ks_re", "ks_im"].map(|name| table.column(name));
    let mut worst: f64 = 0.0;
    let mut inside = 0;
    for row in &table.rows {
        let water = SeaWater { temperature_c: row[t], salinity_gpkg: row[s] };
        for (model, [re, im]) in [
            (Model::MeissnerWentz2012, [columns[0], columns[1]]),
            (Model::KleinSwift1977, [columns[2], columns[3]]),
        ] {
            // Rows outside a model's range are extrapolations; inside it both functions give the same.
            let eps = model.extrapolated(row[f], water);
            if let Ok(checked) = model.permittivity(row[f], water) {
                assert_eq!(checked, eps);
                inside += 1;
            }
            for (found, expected) in [(eps.re, row[re]), (eps.im, row[im])] {
                let error = relative(found, expected, expected);
                assert!(error <= CLOSED_FORM, "{model} at {row:?}: {found} not {expected}");
                worst = worst.max(error);
            }
        }
    }
    println!("permittivity: {} rows, {inside} values in range, worst {worst:.1e}", table.rows.len());
}

#[test]
fn fresnel_rows() {
    let table = Golden::read("fresnel.csv");
    let [f, t, s, theta] = ["f_hz", "T_c", "S_psu", "theta_deg"].map(|name| table.column(name));
    let columns = ["rv_re", "rv_im", "rh_re", "rh_im"].map(|name| table.column(name));
    let mut worst: f64 = 0.0;
    for row in &table.rows {
        let water = SeaWater { temperature_c: row[t], salinity_gpkg: row[s] };
        let eps = Model::MeissnerWentz2012.extrapolated(row[f], water);
        let r = reflection(eps, row[theta].to_radians().cos());
        for (found, [re, im]) in [(r.v, [columns[0], columns[1]]), (r.h, [columns[2], columns[3]])] {
            let expected = Complex64::new(row[re], row[im]);
            let error = (found - expected).norm() / expected.norm();
            assert!(error <= CLOSED_FORM, "at {row:?}: {found} not {expected}");
            worst = worst.max(error);
        }
    }
    println!("fresnel: {} rows, worst {worst:.1e}", table.rows.len());
}

#[test]
fn spm_alpha_rows() {
    let table = Golden::read("spm_alpha.csv");
    let [er, ei, ti, ts, d] =
        ["eps_re", "eps_im", "thi_deg", "ths_deg", "dphi_deg"].map(|name| table.column(name));
    let columns =
        ["vv", "vh", "hv", "hh"].map(|pq| [format!("{pq}_re"), format!("{pq}_im")].map(|n| table.column(&n)));
    let mut worst: f64 = 0.0;
    for row in &table.rows {
        let eps = Complex64::new(row[er], row[ei]);
        let (sin, cos) = row[d].to_radians().sin_cos();
        let a = alphas(eps, row[ti].to_radians().cos(), row[ts].to_radians().cos(), (cos, sin));
        let expected = columns.map(|[re, im]| Complex64::new(row[re], row[im]));
        // Entries that vanish by symmetry are rounding residues: measured against the largest of the row.
        let largest = expected.iter().map(|e| e.norm()).fold(0.0, f64::max);
        for (found, expected) in [a[0][0], a[0][1], a[1][0], a[1][1]].into_iter().zip(expected) {
            let error = (found - expected).norm();
            assert!(
                error <= CLOSED_FORM * expected.norm() + 1e-15 * largest,
                "at {row:?}: {found} not {expected}"
            );
            worst = worst.max(error / largest);
        }
    }
    println!("spm_alpha: {} rows, worst {worst:.1e}", table.rows.len());
}

#[test]
fn slope_pdf_rows() {
    let table = Golden::read("slope_pdf.csv");
    let [u, slick, skew, zx, zy, p] =
        ["U12p5", "slick", "skew", "zx_downwind", "zy_cross", "pdf"].map(|name| table.column(name));
    let mut worst: f64 = 0.0;
    for row in &table.rows {
        let (slopes, series) = if row[slick] == 1.0 {
            (MeanSquareSlope::cox_munk_slick(row[u]), GramCharlier::cox_munk_slick())
        } else {
            (MeanSquareSlope::cox_munk_clean(row[u]), GramCharlier::cox_munk_clean(row[u]))
        };
        // The axes may lie anywhere as seen from the wind.
        for wind in [0.0f64, 1.1] {
            let pdf = SlopePdf::new(slopes, (row[skew] == 1.0).then_some(series), wind);
            let (sin, cos) = wind.sin_cos();
            let found = pdf.density(cos * row[zx] - sin * row[zy], sin * row[zx] + cos * row[zy]);
            let error = relative(found, row[p], row[p]);
            let clamped = row[p] == 0.0 && found == 0.0;
            assert!(clamped || error <= CLOSED_FORM, "wind {wind}, {row:?}: {found} not {}", row[p]);
            worst = worst.max(if clamped { 0.0 } else { error });
        }
    }
    println!("slope_pdf: {} rows, worst {worst:.1e}", table.rows.len());
}

#[test]
fn facet_scatter_rows() {
    let table = Golden::read("facet_scatter.csv");
    let [f, u, wind, ti, ts, d, zx, zy] =
        ["f_hz", "U10_elf_U12p5_coxmunk", "phiw_deg", "thi_deg", "ths_deg", "dphi_deg", "slope_x", "slope_y"]
            .map(|name| table.column(name));
    let names = ["vv", "vh", "hv", "hh"];
    let bragg = names.map(|pq| [format!("spm_{pq}_re"), format!("spm_{pq}_im")].map(|n| table.column(&n)));
    let specular = names.map(|pq| table.column(&format!("go_sigma0_{pq}")));
    // The water of a facet table is that of the Fresnel table of the same set.
    let fresnel = Golden::read("fresnel.csv");
    let water = SeaWater {
        temperature_c: fresnel.rows[0][fresnel.column("T_c")],
        salinity_gpkg: fresnel.rows[0][fresnel.column("S_psu")],
    };
    let (mut worst_bragg, mut worst_specular): (f64, f64) = (0.0, 0.0);
    for row in &table.rows {
        let eps = Model::MeissnerWentz2012.extrapolated(row[f], water);
        let k = std::f64::consts::TAU * row[f] / SPEED_OF_LIGHT_MPS;
        let (sin_i, cos_i) = row[ti].to_radians().sin_cos();
        let (sin_s, cos_s) = row[ts].to_radians().sin_cos();
        let (sin_d, cos_d) = row[d].to_radians().sin_cos();
        let path = Path::new(DVec3::new(sin_i, 0.0, -cos_i), DVec3::new(sin_s * cos_d, sin_s * sin_d, cos_s));
        let facet = Tangent::from_slopes(row[zx], row[zy], DVec3::X);
        let sea = Elfouhaily { wind_10_mps: row[u], downwind_rad: row[wind].to_radians() };

        let (kx, ky) = spm::bragg_vector(k, &facet, &path);
        // Straight ahead the Bragg vector is a rounding residue and the spectrum at it means nothing.
        if kx.hypot(ky) > 1e-6 {
            let a = spm::amplitude(eps, k, &facet, &path, |kx, ky| sea.psi(kx, ky));
            let expected = bragg.map(|[re, im]| Complex64::new(row[re], row[im]));
            let largest = expected.iter().map(|e| e.norm()).fold(0.0, f64::max);
            for (found, expected) in [a[0][0], a[0][1], a[1][0], a[1][1]].into_iter().zip(expected) {
                let error = (found - expected).norm();
                // 1e-8 of the set; entries that vanish by symmetry are residues of 1e-16 of the row's
                // largest.
                assert!(
                    error <= 1e-8 * expected.norm() + 1e-14 * largest,
                    "SPM at {row:?}: {found} not {expected}"
                );
                worst_bragg = worst_bragg.max(error / largest.max(f64::MIN_POSITIVE));
            }
        }

        let pdf = SlopePdf::new(MeanSquareSlope::cox_munk_clean(row[u]), None, row[wind].to_radians());
        let found = Specular::new(eps, &path).map_or([0.0; 4], |mirror| {
            let weight = mirror.weight(&facet, &path, &pdf);
            let s = mirror.reflection.map(|r| r.map(|rho| (rho * weight).norm_sqr()));
            [s[0][0], s[0][1], s[1][0], s[1][1]]
        });
        let expected = specular.map(|column| row[column]);
        let largest = expected.iter().copied().fold(0.0, f64::max);
        for (found, expected) in found.into_iter().zip(expected) {
            let error = (found - expected).abs();
            // Residues of 1e-16 in amplitude are 1e-32 in power; 1e-28 leaves two digits of amplitude.
            assert!(error <= 1e-8 * expected + 1e-28 * largest, "GO at {row:?}: {found} not {expected}");
            worst_specular = worst_specular.max(error / largest.max(f64::MIN_POSITIVE));
        }
    }
    println!(
        "facet_scatter: {} rows, worst SPM {worst_bragg:.1e}, GO {worst_specular:.1e}",
        table.rows.len()
    );
}
