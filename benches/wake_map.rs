//! Cost of a wake map, 512 x 512 facets of 1 m, ship of 100 m: the whole way from hull to fields, a time
//! step, and what the plain sums would cost. One core.
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use nereus::scene::Patch;
use nereus::sea::surface::fields::Real;
use nereus::sea::surface::{Fields, Grid, Selection};
use nereus::sea::wake::{Course, Map, Reach, Settings, Wake, Wigley};

const SHIP: Wigley = Wigley { length_m: 100.0, beam_m: 13.0, draught_m: 4.3 };

fn wake(speed_mps: f64, patch: &Patch) -> Wake {
    let course = Course::straight([150.0, 40.0], 0.3, speed_mps);
    let settings = Settings::new(patch.facet_m, Reach::of(patch, &course, [0.0, 10.0]).unwrap());
    Wake::new(course, SHIP.length_m, &settings, |t| SHIP.amplitude_m(speed_mps, t)).unwrap()
}

fn step<T: Real>(c: &mut Criterion, name: &str, speed_mps: f64, selection: Selection, error_db: f64) {
    let patch = Patch::new([512.0, 512.0], 1.0, [0.0, 0.0]).unwrap();
    let grid = Grid::new(512, 512, 1.0).unwrap();
    let mut fields = Fields::<T>::new(&grid, selection);
    let mut map = Map::<T>::new(vec![wake(speed_mps, &patch)], &patch, error_db).unwrap();
    let mut time_s = 0.0;
    c.bench_function(&format!("wake 512x512, {speed_mps} m/s: {name}"), |b| {
        b.iter(|| {
            time_s = (time_s + 0.036) % 10.0;
            map.add(patch.first, time_s, black_box(&mut fields)).unwrap();
        });
    });
}

/// Heights row by row, each wave turned from facet to facet by its phasor, eight waves at a time: the
/// separable rival.
fn rows_by_phasors(wake: &Wake, rows: usize) -> f64 {
    let mut line = vec![0.0; 512];
    let mut total = 0.0;
    for row in 0..rows {
        line.fill(0.0);
        for nodes in wake.nodes().chunks(8) {
            let (mut re, mut im, mut cos, mut sin) = ([0.0; 8], [0.0; 8], [1.0; 8], [0.0; 8]);
            for (lane, node) in nodes.iter().enumerate() {
                let start = node.amplitude_m * num_complex::Complex64::cis(node.port_rad_m * row as f64);
                (re[lane], im[lane]) = (start.re, start.im);
                (sin[lane], cos[lane]) = node.ahead_rad_m.sin_cos();
            }
            for value in &mut line {
                *value += re.iter().sum::<f64>();
                for lane in 0..8 {
                    let turned = re[lane] * cos[lane] - im[lane] * sin[lane];
                    im[lane] = re[lane] * sin[lane] + im[lane] * cos[lane];
                    re[lane] = turned;
                }
            }
        }
        total += line[7];
    }
    total
}

fn wakes(c: &mut Criterion) {
    let patch = Patch::new([512.0, 512.0], 1.0, [0.0, 0.0]).unwrap();
    let grid = Grid::new(512, 512, 1.0).unwrap();
    for speed_mps in [4.5, 9.0] {
        for error_db in [-80.0, -100.0] {
            let name =
                format!("wake 512x512, {speed_mps} m/s: hull, nodes, memory, all fields f64, {error_db} dB");
            c.bench_function(&name, |b| {
                b.iter(|| {
                    let mut map = Map::<f64>::new(vec![wake(speed_mps, &patch)], &patch, error_db).unwrap();
                    let mut fields = Fields::<f64>::new(&grid, Selection::ALL);
                    map.add(patch.first, 0.0, &mut fields).unwrap();
                    black_box(fields.height_m[0])
                });
            });
            step::<f64>(
                c,
                &format!("time step, all fields f64, {error_db} dB"),
                speed_mps,
                Selection::ALL,
                error_db,
            );
        }
        step::<f32>(c, "time step, all fields f32, -80 dB", speed_mps, Selection::ALL, -80.0);
        step::<f32>(c, "time step, height f32, -80 dB", speed_mps, Selection::HEIGHT, -80.0);
        let wake = wake(speed_mps, &patch);
        c.bench_function(
            &format!("wake, {speed_mps} m/s: direct sum of all fields at 64 facets of 262144"),
            |b| {
                b.iter(|| {
                    (0..64)
                        .map(|i| wake.at(patch.centre_m([4 * i - 256, -3 * i]), 0.0).unwrap().height_m)
                        .sum::<f64>()
                });
            },
        );
        c.bench_function(&format!("wake, {speed_mps} m/s: height by phasors, 4 rows of 512"), |b| {
            b.iter(|| rows_by_phasors(black_box(&wake), 4));
        });
    }
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = wakes }
criterion_main!(benches);
