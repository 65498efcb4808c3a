//! Pixels that take only the pulses in whose beam they lie.

use num_complex::Complex32;

use nereus::processor::backproject::{Gate, difference_db, fast, reference};
use nereus::processor::point_target::analyse;
use nereus::processor::range_compress::{RangeFilter, interpolation_error_db};
use nereus::processor::taper::Taper;
use nereus::recording::ground::Ground;

use crate::geometries::{BAND_HZ, C_MPS, CARRIER_HZ, GEOMETRIES, TARGET_M, aperture, compressor, record};

/// Strip map: an antenna of 4 m looks abeam; a pulse a metre, so that the beam fills the pulse rate.
fn strip_map() -> String {
    let scenario = GEOMETRIES[0].scenario("", [[0.0; 3]; 2]);
    let beam = "antenna = { kind = \"rectangle\", width_m = 4.0, height_m = 0.05 }\n\
                pointing = { kind = \"beside\", platform = \"a\", across_m = -3000.0 }";
    scenario
        .replace("antenna = { kind = \"isotropic\" }", beam)
        .replace("prf_hz = 500.0", "prf_hz = 222.0")
        .replace("duration_s = 0.239", "duration_s = 0.895")
        .replace("[-27.0, -3000.0, 3000.0]", "[-80.0, -3000.0, 3000.0]")
}

#[test]
fn ghosts_of_a_strip_map_are_gone() {
    let recording = record(&strip_map());
    assert_eq!(recording.pulses(), 199);
    let paths = [recording.true_path("t").unwrap(), recording.true_path("r").unwrap()];
    let compressor = compressor(&recording, RangeFilter::Matched, Taper::Uniform);
    let mut aperture = aperture(&recording, &compressor, [&paths[0], &paths[1]], 3);
    // lambda R / 2 to each metre of track.
    let range_m = (3000.0f64 + TARGET_M[1]).hypot(3000.0);
    let ghost_m = C_MPS / CARRIER_HZ * range_m / 2.0;
    let places = [-ghost_m, 0.0, ghost_m].map(|off| [TARGET_M[0] + off, TARGET_M[1], 0.0]);
    let lines = places.map(|place| Ground::line(place, [0.1, 0.0, 0.0], 61));
    let peaks = |aperture: &_| {
        let images = fast(aperture, &lines, &|_| ());
        images.iter().map(|i| i.iter().map(|z| f64::from(z.norm())).fold(0.0, f64::max)).collect::<Vec<f64>>()
    };
    let all = peaks(&aperture);
    let boresights = [recording.boresights("t").unwrap(), recording.boresights("r").unwrap()];
    let aim =
        |place: usize| aperture.aim_hz(&aperture.pulses[place], [boresights[0][place], boresights[1][place]]);
    let aim_hz: Vec<f64> = (0..aperture.pulses.len()).map(aim).collect();
    // Abeam, less what the aircraft flies while the pulse is on its way: v^2 tau / (lambda R) < 0.01 Hz.
    assert!(aim_hz.iter().all(|hz| hz.abs() < 0.02), "{aim_hz:?}");
    aperture.gate = Some(Gate { bandwidth_hz: 222.0, taper: Taper::Uniform, aim_hz });
    let gated = peaks(&aperture);
    let db = |peaks: &[f64], i: usize| 20.0 * (peaks[i] / peaks[1]).log10();
    println!(
        "ghosts {:.1}, {:.1} dB; by beam {:.1}, {:.1} dB",
        db(&all, 0),
        db(&all, 2),
        db(&gated, 0),
        db(&gated, 2)
    );
    for i in [0, 2] {
        // Without a gate the ghost is the point again, spread by the third order of the range.
        assert!(db(&all, i) > -3.0);
        // With it: the pulses beyond the first nulls, side lobes of both ends: -26.5 dB below the axis at
        // most, of either sign.
        assert!(db(&gated, i) < -26.5);
    }
    // The pixel is divided by its own pulses: 64 of 199 in the band. What it leaves out are the side lobes of
    // both ends, all positive: a tenth of the integral of sinc^2, less where the track ends.
    let share = gated[1] / all[1] / (199.0 / 64.0);
    assert!((0.90..0.97).contains(&share), "{share}");
}

#[test]
fn the_band_sets_width_side_lobes_place_and_phase() {
    // Ten cells from the point the band lies 78 Hz off: twice the track, so that it is full there too.
    let mut geometry = GEOMETRIES[0];
    geometry.pulses = 240;
    for end in [&mut geometry.transmitter, &mut geometry.receiver] {
        end.position_m[0] = -54.0;
    }
    let recording = geometry.record("", [[0.0; 3]; 2]);
    let paths = [recording.true_path("t").unwrap(), recording.true_path("r").unwrap()];
    let compressor = compressor(&recording, RangeFilter::Flat, Taper::Uniform);
    let mut aperture = aperture(&recording, &compressor, [&paths[0], &paths[1]], 0);
    let aim_hz = vec![37.0; aperture.pulses.len()];
    // The echo as each pulse alone shows it: the axes of these antennas turn under the line of sight, which
    // changes it by 6 % of its size.
    let all = aperture.pulses.clone();
    let mut alone = |place: usize| {
        aperture.pulses = vec![all[place]];
        fast(&aperture, &[Ground::line(TARGET_M, [0.0; 3], 1)], &|_| ())[0][0]
    };
    let singles: Vec<Complex32> = (0..all.len()).map(&mut alone).collect();
    aperture.pulses = all;
    for (taper, pslr_db) in [(Taper::Uniform, -13.26), (Taper::Hann, -31.5)] {
        aperture.gate = Some(Gate { bandwidth_hz: 100.0, taper, aim_hz: aim_hz.clone() });
        let found = analyse(&aperture, &[TARGET_M.into()], [Taper::Uniform, taper])[0].unwrap();
        println!("{taper:?}: {found:?}");
        let cut = found.cross_range;
        // v/B: 2.22 m. Some 65 pulses, so that the edges of the band are met to half a pulse: 1 %.
        assert!((cut.width_m / (taper.width() * 222.0 / 100.0) - 1.0).abs() < 0.02, "{cut:?}");
        assert!((cut.width_m / cut.theory_m - 1.0).abs() < 0.02, "{cut:?}");
        assert!((cut.pslr_db - pslr_db).abs() < 0.5, "{cut:?}");
        assert!(cut.error_cells.abs() < 0.02);
        let gate = aperture.gate.as_ref().unwrap();
        let weights: Vec<f32> = (0..singles.len())
            .map(|place| gate.weight(place, aperture.doppler_hz(&aperture.pulses[place], TARGET_M)) as f32)
            .collect();
        let mean =
            singles.iter().zip(&weights).map(|(z, w)| z * w).sum::<Complex32>() / weights.iter().sum::<f32>();
        // Every pixel is divided by its own weights.
        assert!((found.amplitude / f64::from(mean.norm()) - 1.0).abs() < 0.003, "{found:?} {mean}");
        assert!((found.phase_rad - f64::from(mean.arg())).abs() < 0.003, "{found:?} {mean}");
    }
}

#[test]
fn the_fast_way_through_a_gate_is_the_reference() {
    for geometry in &GEOMETRIES {
        let recording = geometry.record("", [[0.0; 3]; 2]);
        let paths = [recording.true_path("t").unwrap(), recording.true_path("r").unwrap()];
        let compressor = compressor(&recording, RangeFilter::Matched, Taper::Uniform);
        let mut aperture = aperture(&recording, &compressor, [&paths[0], &paths[1]], 1);
        aperture.pulses = aperture.pulses.iter().copied().step_by(4).collect();
        let ground = Ground::map([TARGET_M[0] + 9.0, TARGET_M[1] - 7.0, 0.0], [45.0, 33.0], 1.0).unwrap();
        // A band that cuts the middle half of what the point's Doppler goes through.
        let doppler = |place: usize| aperture.doppler_hz(&aperture.pulses[place], TARGET_M);
        let last = aperture.pulses.len() - 1;
        let (first_hz, last_hz) = (doppler(0), doppler(last));
        let aim_hz = vec![0.5 * (first_hz + last_hz); last + 1];
        for taper in [Taper::Uniform, Taper::Taylor] {
            let bandwidth_hz = 0.5 * (last_hz - first_hz).abs();
            aperture.gate = Some(Gate { bandwidth_hz, taper, aim_hz: aim_hz.clone() });
            let found = fast(&aperture, &[ground], &|_| ()).remove(0);
            let found_db = difference_db(&found, &reference(&aperture, &ground));
            let predicted_db = interpolation_error_db(BAND_HZ, 16.0 * recording.header.sample_rate_hz);
            println!("{}, {taper:?}: {found_db:.1} dB, interpolation {predicted_db:.1} dB", geometry.name);
            assert!(found_db < predicted_db + 2.0, "{}: {found_db}", geometry.name);
        }
    }
}

#[test]
fn a_pixel_in_no_band_is_dark_and_a_gate_without_aims_takes_nothing() {
    let geometry = &GEOMETRIES[3];
    let recording = geometry.record("", [[0.0; 3]; 2]);
    let paths = [recording.true_path("t").unwrap(), recording.true_path("r").unwrap()];
    let compressor = compressor(&recording, RangeFilter::Matched, Taper::Uniform);
    let mut aperture = aperture(&recording, &compressor, [&paths[0], &paths[1]], 0);
    let ground = Ground::map(TARGET_M, [20.0, 20.0], 1.0).unwrap();
    for aim_hz in [vec![1e5; aperture.pulses.len()], vec![f64::NAN; aperture.pulses.len()], Vec::new()] {
        aperture.gate = Some(Gate { bandwidth_hz: 50.0, taper: Taper::Uniform, aim_hz });
        assert!(fast(&aperture, &[ground], &|_| ())[0].iter().all(|z| z.norm() == 0.0));
        assert!(reference(&aperture, &ground).iter().all(|z| z.norm() == 0.0));
        assert!(analyse(&aperture, &[TARGET_M.into()], [Taper::Uniform; 2])[0].is_none());
    }
}
