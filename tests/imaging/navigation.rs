//! Images by reported navigation.

use nereus::imaging::backproject::{difference_db, fast};
use nereus::imaging::ground::Ground;
use nereus::imaging::range_compress::RangeFilter;
use nereus::imaging::taper::Taper;
use num_complex::Complex64;

use crate::geometries::{GEOMETRIES, TARGET_M, aperture, compressor};

#[test]
fn reports_without_errors_give_the_same_image() {
    let arms = [[2.0, -1.0, 1.5], [-3.0, 0.5, 4.0]];
    for geometry in [&GEOMETRIES[2], &GEOMETRIES[4]] {
        let recording = geometry.record("", arms);
        let truth = [recording.true_path("t").unwrap(), recording.true_path("r").unwrap()];
        let report =
            [recording.reported_path("a", arms[0]).unwrap(), recording.reported_path("b", arms[1]).unwrap()];
        let compressor = compressor(&recording, RangeFilter::Matched, Taper::Uniform);
        let ground = Ground::map(TARGET_M, [32.0, 32.0], 1.0).unwrap();
        let [a, b] = [&truth, &report].map(|paths| {
            let aperture = aperture(&recording, &compressor, [&paths[0], &paths[1]], 3);
            fast(&aperture, &[ground], &|_| ()).remove(0)
        });
        let b: Vec<Complex64> = b.iter().map(|z| Complex64::new(z.re.into(), z.im.into())).collect();
        let found_db = difference_db(&a, &b);
        println!("{}: {found_db:.1} dB", geometry.name);
        // Lever arms are turned by the same attitude in another order: 1.2e-10 m at 8e5 m, 15-fold beyond the last pulse, is
        // 2.5e-7 rad or -132 dB; samples in f32 are -150 dB.
        assert!(found_db < -120.0, "{found_db}");
        // An arm left out is not forgiven.
        let wrong = [recording.reported_path("a", [0.0; 3]).unwrap(), truth[1].clone()];
        let aperture = aperture(&recording, &compressor, [&wrong[0], &wrong[1]], 3);
        assert!(difference_db(&fast(&aperture, &[ground], &|_| ())[0], &b) > -20.0);
    }
}
