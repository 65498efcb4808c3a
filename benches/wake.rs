//! Cost of a ship's waves, one core: `cargo bench --bench wake`.
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use nereus::scene::Hull;
use nereus::sea::wake::kochin::{Kochin, Transom};

fn hull(c: &mut Criterion) {
    let mut group = c.benchmark_group("hull at 4.5 m/s");
    group.sample_size(20);
    for file in ["dtmb5415", "dtmb5415_fine"] {
        let path = format!("{}/hulls/{file}.toml", env!("CARGO_MANIFEST_DIR"));
        let hull = Hull::load(Path::new(&path)).unwrap().scaled_to_length(100.0).unwrap();
        // From along the track to 70 degrees; the other half of the angles has the same amplitudes.
        let tangents: Vec<f64> = (0..300).map(|i| 2.75 * f64::from(i) / 299.0).collect();
        group.bench_function(format!("{file}, 300 angles of one half"), |b| {
            b.iter(|| {
                let ship = Kochin::new(black_box(&hull), 4.5, Transom::Open).unwrap();
                tangents.iter().map(|t| ship.amplitude_m(*t).norm_sqr()).sum::<f64>()
            });
        });
        let ship = Kochin::new(&hull, 4.5, Transom::Open).unwrap();
        group.bench_function(format!("{file}, wave resistance"), |b| {
            b.iter(|| ship.wave_resistance_n(black_box(1025.0)).unwrap());
        });
        group.bench_function(format!("{file}, read and checked"), |b| {
            b.iter(|| Hull::load(black_box(Path::new(&path))).unwrap());
        });
    }
}

criterion_group!(benches, hull);
criterion_main!(benches);
