//! Cost of the sea: drawing a map, and one time step with all fields. One core.
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use nereus::scene::water::{Development, Dispersion, WindProfile};
use nereus::sea::spectrum::{Elfouhaily, Mix};
use nereus::sea::surface::{Averaging, Evaluator, Fields, Grid, Selection, Surface};
use nereus::sea::wind::Wind;

fn sea(c: &mut Criterion) {
    let wind = Wind::from_friction_velocity(0.36, WindProfile::Cardone, 0.52).unwrap();
    let grid = Grid::new(512, 512, 1.0).unwrap();
    let deep = Dispersion::default();
    let mut group = c.benchmark_group("sea 512x512");
    group.sample_size(20);

    group.bench_function("map (spectrum, amplitudes, first height)", |b| {
        b.iter(|| {
            let spectrum = Mix::new(&wind, Development::default()).unwrap();
            let surface = Surface::synthesise(grid, &spectrum, deep, 1, Averaging::Automatic).unwrap();
            let mut fields = Fields::<f32>::new(&grid, Selection::HEIGHT);
            Evaluator::new(&surface).evaluate(0.0, &mut fields).unwrap();
            black_box(fields.height_m[0])
        });
    });

    let spectrum = Elfouhaily::new(&wind, Development::default()).unwrap();
    let mut step = |name: &str, dispersion: Dispersion, selection: Selection, wide: bool| {
        let surface = Surface::synthesise(grid, &spectrum, dispersion, 1, Averaging::Automatic).unwrap();
        let mut time_s = 0.0;
        let mut next = || {
            time_s += 0.036;
            time_s
        };
        if wide {
            let mut fields = Fields::<f64>::new(&grid, selection);
            let mut evaluator = Evaluator::new(&surface);
            group.bench_function(name, |b| {
                b.iter(|| evaluator.evaluate(next(), black_box(&mut fields)).unwrap());
            });
        } else {
            let mut fields = Fields::<f32>::new(&grid, selection);
            let mut evaluator = Evaluator::new(&surface);
            group.bench_function(name, |b| {
                b.iter(|| evaluator.evaluate(next(), black_box(&mut fields)).unwrap());
            });
        }
    };
    step("time step, all fields, f32", deep, Selection::ALL, false);
    let tension = Dispersion { capillary: true, depth_m: None };
    step("time step, all fields, surface tension, f32", tension, Selection::ALL, false);
    step("time step, height alone, f32", deep, Selection::HEIGHT, false);
    step("time step, all fields, f64", deep, Selection::ALL, true);
}

criterion_group!(benches, sea);
criterion_main!(benches);
