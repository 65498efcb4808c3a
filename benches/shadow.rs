//! Cost of visibility, one terminal, one core: `cargo bench --bench shadow`.
//! Criterion's elements are facets, so its throughput is facets per second (1000/Melem/s = ns per facet).
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nereus::frames::{Enu, Point};
use nereus::geometry::shadow::{Map, Relief, Settings, Shadow};

const SIDE: usize = 512;

/// From `range_m` at `grazing_deg` over the middle of the map, in the direction `azimuth_deg` from north.
fn terminal(range_m: f64, azimuth_deg: f64, grazing_deg: f64) -> Point<Enu> {
    let (sin, cos) = azimuth_deg.to_radians().sin_cos();
    Point::new(255.5 + range_m * sin, 255.5 + range_m * cos, range_m * grazing_deg.to_radians().tan())
}

fn shadow(c: &mut Criterion) {
    let heights_m: Vec<f32> = (0..SIDE * SIDE)
        .map(|i| {
            let (x, y) = ((i % SIDE) as f32, (i / SIDE) as f32);
            0.6 * (0.11 * x + 0.05 * y).sin() + 0.2 * (0.7 * x - 0.4 * y).sin() + 0.1 * (0.9 * y).cos()
        })
        .collect();
    let map = Map::new(&heights_m, [SIDE, SIDE], 1.0, [0.0, 0.0]).unwrap();
    let soft = Settings::for_map(&map);
    let mut weights = vec![0.0_f32; SIDE * SIDE];
    let mut group = c.benchmark_group("shadow 512x512");
    group.throughput(Throughput::Elements((SIDE * SIDE) as u64));
    let sharp = Settings { width_rad: 0.0, ..soft };
    let four = Settings { rays_per_facet: 4, ..soft };
    for (name, settings, terminal) in [
        ("far, along y", soft, terminal(20e3, 10.0, 1.0)),
        ("far, along x", soft, terminal(20e3, 100.0, 1.0)),
        ("far, diagonal", soft, terminal(20e3, 45.0, 1.0)),
        ("near, 300 m", soft, terminal(300.0, 10.0, 3.0)),
        ("above the map", soft, Point::new(200.3, 300.7, 20.0)),
        ("far, along y, sharp", sharp, terminal(20e3, 10.0, 1.0)),
        ("far, along y, four rays", four, terminal(20e3, 10.0, 1.0)),
    ] {
        let mut shadow = Shadow::new([SIDE, SIDE], settings).unwrap();
        group.bench_function(name, |b| {
            b.iter(|| shadow.weights(&map, black_box(terminal), &mut weights).unwrap());
        });
    }
    let high = terminal(4e3, 10.0, 60.0);
    group.bench_function("relief and test that nothing shadows", |b| {
        b.iter(|| Relief::of(black_box(&map)).cannot_shadow(&map, high, soft));
    });
    group.finish();
}

criterion_group!(benches, shadow);
criterion_main!(benches);
