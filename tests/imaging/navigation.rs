//! Images by reported navigation.

use nereus::geometry::phase_path::PhasePath;
use nereus::processor::backproject::{difference_db, fast};
use nereus::processor::range_compress::RangeFilter;
use nereus::processor::taper::Taper;
use nereus::recording::ground::Ground;
use num_complex::Complex64;

use crate::geometries::{GEOMETRIES, TARGET_M, aperture, compressor};

#[test]
fn reports_without_errors_give_the_same_image() {
    let arms = [[2.0, -1.0, 1.5], [-3.0, 0.5, 4.0]];
    for geometry in [&GEOMETRIES[2], &GEOMETRIES[4]] {
        let recording = geometry.record("", arms);
        let truth = [recording.true_path("t").unwrap(), recording.true_path("r").unwrap()];
        let report = [recording.reported_path("t").unwrap(), recording.reported_path("r").unwrap()];
        let compressor = compressor(&recording, RangeFilter::Matched, Taper::Uniform);
        let ground = Ground::map(TARGET_M, [32.0, 32.0], 1.0).unwrap();
        let [a, b] = [&truth, &report].map(|paths| {
            let aperture = aperture(&recording, &compressor, [&paths[0], &paths[1]], 3);
            fast(&aperture, &[ground], &|_| ()).remove(0)
        });
        assert_eq!(a, b, "{}", geometry.name);
        let b: Vec<Complex64> = b.iter().map(|z| Complex64::new(z.re.into(), z.im.into())).collect();
        // An arm left out is not forgiven.
        let of_body = (0..recording.pulses()).map(|pulse| recording.reported_state("a", pulse).unwrap().0);
        let wrong =
            [PhasePath::new(recording.emission_s.clone(), of_body.collect()).unwrap(), truth[1].clone()];
        let aperture = aperture(&recording, &compressor, [&wrong[0], &wrong[1]], 3);
        assert!(difference_db(&fast(&aperture, &[ground], &|_| ())[0], &b) > -20.0);
    }
}
