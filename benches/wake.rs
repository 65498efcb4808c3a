//! Cost of a ship's waves, one core: `cargo bench --bench wake`.
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use nereus::cpu::Variant;
use nereus::scene::Hull;
use nereus::sea::wake::kochin::{Kochin, Transom};
use nereus::sea::wake::{Course, Reach, Settings, ShortWaveNodes, ShortWaves};

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

fn short_waves(c: &mut Criterion) {
    let mut group = c.benchmark_group("short waves, L band, facets of 1 m");
    group.sample_size(20);
    let path = format!("{}/hulls/dtmb5415.toml", env!("CARGO_MANIFEST_DIR"));
    let hull = Hull::load(Path::new(&path)).unwrap().scaled_to_length(100.0).unwrap();
    let kochin = Kochin::new(&hull, 9.0, Transom::Open).unwrap();
    let settings = Settings::new(1.0, Reach::disc(0.0));
    let course = Course::straight([0.0, 0.0], 0.0, 9.0);
    let make = || ShortWaves::new(course, 100.0, &settings, 54.5, |t| kochin.amplitude_m(t)).unwrap();
    group.bench_function("made", |b| b.iter(make));
    let waves = make();
    // 256 x 256 facets from 100 to 356 m astern, for a radar abeam: 38.5 rad/m to port.
    group.bench_function("65536 facets", |b| {
        b.iter(|| {
            let place = |i: u32| [100.0 + f64::from(i % 256), f64::from(i / 256) - 128.0];
            (0..65_536).map(|i| waves.psi_m4(black_box(place(i)), [0.0, 38.5])).sum::<f64>()
        });
    });
    group.bench_function("nodes made", |b| b.iter(|| ShortWaveNodes::new(waves.clone())));
    let nodes = ShortWaveNodes::new(waves.clone());
    group.bench_function("65536 facets on nodes", |b| {
        let (variant, wedge) = (Variant::fastest(), nodes.wedge(38.5));
        b.iter(|| {
            let places = (0..65_536u32).map(|i| [100.0 + f64::from(i % 256), f64::from(i / 256) - 128.0]);
            let near = places.filter(|place| wedge.holds(*place));
            near.map(|place| nodes.psi_m4(variant, black_box(place), [0.0, 38.5])).sum::<f64>()
        });
    });
}

criterion_group!(benches, hull, short_waves);
criterion_main!(benches);
