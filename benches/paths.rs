//! Cost of scatterer paths: `cargo bench --bench paths`. The paper's first configuration: 512 x 512 facets of
//! 1 m, four channels, 45 degrees, moving sea, one core. Criterion's elements are facets (1000/Melem/s = ns
//! per facet).
//!
//! `pulse, exact`: everything from the sea's waves to the list of scatterer paths. `scattering`: the
//! facets' matrices alone.
#![allow(missing_docs, clippy::expect_used)]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use nereus::frames::{Earth, Point, Rotation, SceneFrame, Vector};
use nereus::motion::PlatformTracks;
use nereus::motion::track::Track;
use nereus::paths::PathGenerator;
use nereus::paths::list::ScattererPaths;
use nereus::pulse::Pulse;
use nereus::scattering::facets::Facets;
use nereus::scattering::water::{Sight, WaterScattering};
use nereus::scene::radar::*;
use nereus::scene::sea::*;
use nereus::scene::water::*;
use nereus::scene::{Patch, Radar, Scene, Sea};
use nereus::sea::facet_surface::FacetSurface;
use nereus::sea::realise::{Realised, realise};
use nereus::sea::surface::Selection;
use nereus::time::{PulseTimes, TimeTag};
use num_complex::Complex64;

const SIDE: usize = 512;

fn sea(facets: usize) -> Sea {
    let strength = WindStrength::FrictionVelocity { ustar_mps: 0.36 };
    let wind = WindGiven { strength, profile: WindProfile::Cardone, direction_rad: 30f64.to_radians() };
    let water = Water::new(wind, SpectrumKind::ElfouhailyFungLee { development: Development::default() });
    Sea {
        scattering: FacetScattering { tilt_average: false, ..FacetScattering::default() },
        shadow: Some(Shadowing::default()),
        ..Sea::new(water, Patch::new([facets as f64, facets as f64], 1.0, [0.0, 0.0]).expect("a patch"))
    }
}

fn scene(facets: usize) -> Scene {
    let antenna = AntennaMount {
        platform: 0,
        lever_arm: Vector::ZERO,
        of_array: Vector::ZERO,
        pattern: Pattern::Rectangle { width_m: 4.0, height_m: 0.05 },
        pointing: Pointing::At {
            aim: Aim::Beside { platform: 0, along_m: 0.0, across_m: -3000.0 },
            aim_from: AimFrom::True,
            lag_s: 0.0,
            bias_rad: [0.0; 2],
        },
        ports: nereus::scene::radar::PortErrors::default(),
    };
    let ports = [Polarisation::H, Polarisation::V];
    let channels = ports.into_iter().flat_map(|rx| ports.map(|tx| (rx, tx)));
    Scene {
        frame: SceneFrame::plain(Earth::Flat),
        start: TimeTag::default(),
        pulses: 500,
        seed: 1,
        platforms: vec!["aircraft".into()],
        radar: Radar {
            transmitters: vec![Transmitter { name: "tx".into(), power_w: 1.0, antenna: antenna.clone() }],
            receivers: vec![Receiver { name: "rx".into(), antenna, gate: None }],
            channels: channels
                .map(|(rx, tx)| Channel {
                    name: format!("{}{}", rx.letter(), tx.letter()),
                    transmitter: 0,
                    receiver: 0,
                    tx,
                    rx,
                })
                .collect(),
            ..Radar::new(
                10e9,
                100e6,
                Waveform::Lfm { bandwidth_hz: 60e6, duration_s: 0.333e-6, sweep: Sweep::Up },
                PulseTimes::uniform(222.0).expect("a rate"),
                Window { samples: 384, gate: Gate::Fixed { start_s: 26.8e-6 } },
            )
        },
        sea: Some(sea(facets)),
        ships: Vec::new(),
        targets: Vec::new(),
    }
}

fn pulses(c: &mut Criterion) {
    let scene = scene(SIDE);
    let start = Point::new(-250.0, -3000.0, 3000.0);
    let level = Rotation::from_yaw_pitch_roll(std::f64::consts::FRAC_PI_2, 0.0, 0.0);
    let track = Track::straight(start, scene.start, Vector::new(222.0, 0.0, 0.0), Some(level));
    let tracks = vec![PlatformTracks { truth: track.clone(), reported: track }];
    let generator = PathGenerator::new(&scene, 0.333e-6, tracks).expect("a scene");
    let mut work = generator.workspace();
    let mut paths = ScattererPaths::new(1, 4, SIDE * SIDE);
    let mut record = Pulse::new(&scene.radar.layout(1, 0));
    let mut group = c.benchmark_group("paths");
    group.throughput(Throughput::Elements((SIDE * SIDE) as u64));
    group.sample_size(10);
    let mut index = 0;
    group.bench_function("pulse, exact", |b| {
        b.iter(|| {
            index = (index + 1) % 500;
            generator.pulse(index, &mut work, &mut paths, &mut record).expect("a pulse");
            black_box(paths.len())
        });
    });
    println!("{} of {} facets return something", paths.len(), SIDE * SIDE);
    group.finish();
}

/// Facets of a small patch of the same sea with all that their scattering needs.
struct Batch {
    incident: [Vec<f64>; 3],
    slope: [Vec<f64>; 2],
    cover: Vec<f64>,
    phasors: Vec<Complex64>,
}

fn scattering(c: &mut Criterion) {
    const FACETS: usize = 64 * 64;
    let sea = sea(64);
    let Realised { wind, spectrum, surface, .. } = realise(&sea, 1).expect("a sea");
    let sight = Sight { carrier_hz: 10e9, seed: 1 };
    let water = WaterScattering::new(&sea, &wind, spectrum, &[], sight).expect("water");
    let mut sheet = FacetSurface::new(&surface, Selection { slopes: true, ..Selection::HEIGHT });
    let mut fields = sheet.fields(&sea.patch);
    sheet.evaluate(1.0, &sea.patch, &mut fields).expect("a time");
    let mut batch = Batch {
        incident: Default::default(),
        slope: fields.slope.clone(),
        cover: vec![0.0; FACETS],
        phasors: vec![Complex64::ZERO; FACETS * water.mechanisms()],
    };
    for (index, phasors) in batch.phasors.chunks_exact_mut(water.mechanisms()).enumerate() {
        let key = sea.patch.key(index);
        water.phasors(key, 0.0, phasors);
        let [x, y] = sea.patch.centre_m(key);
        let k = (DVec3::new(x, y, 0.0) - DVec3::new(0.0, -3000.0, 3000.0)).normalize();
        batch.incident.iter_mut().zip(k.to_array()).for_each(|(column, k)| column.push(k));
    }
    let back = batch.incident.each_ref().map(|column| column.iter().map(|k| -k).collect::<Vec<_>>());
    let facets = Facets {
        incident: batch.incident.each_ref().map(Vec::as_slice),
        scattered: back.each_ref().map(Vec::as_slice),
        slope_x: &batch.slope[0],
        slope_y: &batch.slope[1],
        cover: &batch.cover,
        phasors: &batch.phasors,
        modulation: &[],
        footprint_m2: 1.0,
    };
    let mut out = [(); 4].map(|()| vec![Complex64::ZERO; FACETS]);
    let mut group = c.benchmark_group("scattering");
    group.throughput(Throughput::Elements(FACETS as u64));
    group.bench_function("scattering", |b| {
        b.iter(|| {
            let [vv, vh, hv, hh] = &mut out;
            water.scatter(0, black_box(&facets), [vv, vh, hv, hh]).expect("a batch");
        });
    });
    group.finish();
}

criterion_group!(benches, pulses, scattering);
criterion_main!(benches);
