//! Allocations of the whole process while a stream runs. The counted run has a process of its own, so
//! that no other test allocates meanwhile.

// SAFETY of the only unsafe code here: both calls are passed on to the system's allocator unchanged.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout as Memory, System};
use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use nereus::sinks::null::NullSink;
use nereus::sinks::sink::Sink;
use nereus::time::PulseTimes;
use nereus::transport::fanout::Fed;
use nereus::transport::schedule::Schedule;
use nereus::transport::stage::Stream;
use nereus::transport::view;
use nereus::transport::{Pace, Policy, Settings};

use crate::cases::{cases, sized};
use crate::stream_fixture::{LAYOUT, generate, in_a_process_of_its_own};

struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);
thread_local! {
    /// Of this thread alone: the one that waits for a test allocates when it begins to wait.
    static OWN_ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, memory: Memory) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        OWN_ALLOCATIONS.set(OWN_ALLOCATIONS.get() + 1);
        unsafe { System.alloc(memory) }
    }

    unsafe fn dealloc(&self, at: *mut u8, memory: Memory) {
        unsafe { System.dealloc(at, memory) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn steady_state_allocates_nothing() {
    in_a_process_of_its_own("stream_allocations::counted_run");
}

#[test]
#[ignore = "run by steady_state_allocates_nothing in a process of its own"]
fn counted_run() {
    for (pace, end, from, to) in [(Pace::Fast, 20_000, 1000, 19_000), (Pace::Realtime, 1500, 200, 1400)] {
        let settings = Settings {
            pace,
            policy: Policy::Drop,
            latency_s: 0.05,
            ring_slots: 64,
            threads: 1,
            ..Settings::default()
        };
        let schedule = Schedule { times: PulseTimes::uniform(2000.0).unwrap(), first: 0, count: end };
        let mut run = Stream::new(settings, schedule, LAYOUT, Arc::new(AtomicBool::new(false)));
        for name in ["a", "b"] {
            run.sink(name, 16, move |mut feed| {
                let mut sink = NullSink::new();
                let (mut before, mut after) = (None, None);
                loop {
                    let take = |pulse: &nereus::pulse::Pulse| sink.write(pulse).map(|()| pulse.index);
                    match feed.next(Duration::from_secs(1), take).map_err(|e| e.to_string())? {
                        Fed::Pulse(index) => {
                            // The nearest pulses that came: some may be dropped on a busy machine.
                            if index >= from && before.is_none() {
                                before = Some(ALLOCATIONS.load(Ordering::Relaxed));
                            }
                            if index <= to {
                                after = Some(ALLOCATIONS.load(Ordering::Relaxed));
                            }
                        }
                        Fed::Idle => {}
                        Fed::Ended => return Ok::<_, String>((before, after)),
                    }
                }
            })
            .unwrap();
        }
        let (sender, _receiver) = crossbeam_channel::bounded(4);
        run.status(sender);
        // Somebody looks on, as the live page does.
        let (view, mut onlooker) = view::view(16);
        run.view(view);
        let looking = std::thread::spawn(move || {
            while onlooker.poll(|_, _| {}) != view::Seen::Ended {
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        let outcome = run.run(|source| generate(source, 0, end, 8, Duration::ZERO));
        looking.join().unwrap();
        outcome.result.unwrap();
        for (name, (before, after)) in outcome.reports {
            let (before, after) = (before.unwrap(), after.unwrap());
            println!("{pace:?}, sink {name}: {} allocations between pulses {from} and {to}", after - before);
            assert_eq!(after - before, 0);
        }
        assert!(outcome.summary.health.pulses > end / 2);
    }
}

/// The whole way, generation included: the calibration scene and a sea on two workers, fast, then in real
/// time.
#[test]
fn making_pulses_allocates_nothing() {
    in_a_process_of_its_own("stream_allocations::counted_pipeline");
}

#[test]
#[ignore = "run by making_pulses_allocates_nothing in a process of its own"]
fn counted_pipeline() {
    let pulses = made();
    counted_at_both_paces("calibration.toml", &[], pulses, true);
    // A moving sea in blocks, slick and shadows included, long enough for many blocks.
    let set = |key: &str, value: &str| (key.to_owned(), value.to_owned());
    let small = [set("scene.patch_size_m", "[24, 24]")];
    counted_at_both_paces("sea.toml", &small, pulses, false);
    // Sidelobe tiles in some blocks only, while the beam passes.
    let sidelobe = [set("scene.patch_size_m", "[64, 64]"), set("fidelity.sidelobe_db", "-20")];
    counted_at_both_paces("mars-1.toml", &sidelobe, pulses.max(400), false);
    // Late and wrong reports, turbulence, clocks.
    counted_at_both_paces("errors.toml", &[], pulses, false);
}

/// No rain, which takes long to plan.
const DRY: [(&str, &str); 2] = [("radar.rain_mmph", "0"), ("radar.rain_clutter", "false")];

/// Pulses that are made as fast as they can be.
fn made() -> u64 {
    u64::from(cases(1200)).clamp(300, 1200)
}

/// What else a scene may have, on a patch that stays and on one that follows, in blocks and pulse by pulse.
#[test]
fn all_effects_allocate_nothing() {
    in_a_process_of_its_own("stream_allocations::counted_effects");
}

#[test]
#[ignore = "run by all_effects_allocate_nothing in a process of its own"]
fn counted_effects() {
    let set = |key: &str, value: &str| (key.to_owned(), value.to_owned());
    let ship = "[{ name = 'tug', hull = 'HULL', length_m = 12.0, position_m = [16.0, 8.0], speed_mps = 2.0, heading_deg = 30.0, \
                echo = true, panel_m = 2.0, motion = 'waves' }]";
    let hull = concat!(env!("CARGO_MANIFEST_DIR"), "/hulls/wigley.toml");
    let effects = [
        set("sea.scattering.breaking", "'whitecaps'"),
        set("sea.scattering.modulation", "'relaxation'"),
        set("sea.waves", "'choppy'"),
        set("ship", &ship.replace("HULL", hull)),
        set("radar.rain_mmph", "20"),
        set("radar.rain_clutter", "true"),
        set("target.0.multipath", "true"),
    ];
    let with = |own: &[(&str, &str)]| {
        let own: Vec<_> = own.iter().map(|(key, value)| set(key, value)).collect();
        [&effects[..], &own].concat()
    };
    let sea = [
        ("scene.patch_size_m", sized("[24, 24]", "[16, 16]")),
        ("radar.window.samples", "48"),
        ("radar.window.start_us", "28.05"),
    ];
    let along = [
        ("scene.patch", "'follow'"),
        ("scene.patch_follow", "{ kind = 'beside', platform = 'aircraft', across_m = 3000.0 }"),
    ];
    let (pulses, dry) = (made(), sized(&[][..], &DRY));
    let low = sized(&[][..], &[("radar.rain_top_m", "300")]);
    counted_at_both_paces("sea.toml", &with(&[&sea[..], low].concat()), pulses, true);
    let afloat = [("sea.waves", "'linear'"), ("target.0.floating", "true")];
    counted_at_both_paces("sea.toml", &with(&[&sea[..], &along, &afloat, dry].concat()), pulses, false);
    let reference = [("fidelity.echo", "'reference'")];
    counted_at_both_paces("sea.toml", &with(&[&sea[..], &reference, low].concat()), pulses, false);
    // Land, and what it hides.
    let coast = [
        ("scene.patch_size_m", "[128, 128]"),
        ("ship.0.position_m", "[470, 0]"),
        ("radar.window.samples", "64"),
        ("radar.window.start_us", "12.0"),
    ];
    counted_at_both_paces("coast.toml", &with(&[&coast[..], dry].concat()), pulses, false);
}

/// The wire: to a receiver that listens, and to none; descriptions once a second included.
#[test]
fn sending_pulses_allocates_nothing() {
    in_a_process_of_its_own("stream_allocations::counted_wire");
}

#[test]
#[ignore = "run by sending_pulses_allocates_nothing in a process of its own"]
fn counted_wire() {
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    let set = |key: &str, value: String| (key.to_owned(), value);
    let address = format!("\"{}\"", socket.local_addr().unwrap());
    let settings = [set("sink.0.address", address)];
    counted_scenario("live-wire.toml", &settings, 1200, &PACES, || true);
    drop(socket);
    counted_scenario("live-wire.toml", &settings, 1200, &PACES, || true);
}

fn is_free(mut address: std::net::SocketAddr, next: u16) -> bool {
    address.set_port(address.port() + next);
    std::net::TcpListener::bind(address).is_ok()
}

/// ZeroMQ in both forms, to a subscriber that reads.
#[test]
fn publishing_pulses_allocates_nothing() {
    in_a_process_of_its_own("stream_allocations::counted_publishers");
}

#[test]
#[ignore = "run by publishing_pulses_allocates_nothing in a process of its own"]
fn counted_publishers() {
    use std::io::{Read, Write};
    // Below the ports that connections are given: one that connects to a free one of those may meet itself.
    let free = (20_000..30_000).map(|port| std::net::SocketAddr::from(([127, 0, 0, 1], port)));
    let at = std::process::id() as usize % 9000;
    let port = free.skip(at).find(|to| (0..4).all(|next| is_free(*to, next))).unwrap();
    let set = |sink: &str| [("sink".to_owned(), format!("[{sink}]"))];
    // Subscribes to the first port whenever there is one, and reads what comes.
    static SUBSCRIBED: AtomicBool = AtomicBool::new(false);
    std::thread::spawn(move || {
        let mut greeting = [0; 64];
        (greeting[0], greeting[9], greeting[10]) = (0xff, 0x7f, 3);
        greeting[12..16].copy_from_slice(b"NULL");
        let mut buffer = [0; 1 << 16];
        loop {
            if let Ok(mut stream) = std::net::TcpStream::connect(port) {
                let hello = stream.write_all(&greeting).is_ok()
                    && stream.write_all(b"\x04\x1a\x05READY\x0bSocket-Type\0\0\0\x03SUB\0\x01\x01").is_ok();
                let mut read = 0;
                while hello && let Ok(length @ 1..) = stream.read(&mut buffer) {
                    read += length;
                    // Beyond the greeting and the handshake: pulses.
                    SUBSCRIBED.store(read > 1024, Ordering::Relaxed);
                }
                SUBSCRIBED.store(false, Ordering::Relaxed);
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    });
    for messages in ["samples", "multipart"] {
        let sink = format!("{{ kind = 'zmq', bind = '{port}', messages = '{messages}', buffer_pulses = 8 }}");
        counted_scenario("live-wire.toml", &set(&sink), 1200, &PACES, || SUBSCRIBED.load(Ordering::Relaxed));
    }
}

/// Threads of this process, where the system says.
fn threads() -> Option<usize> {
    std::fs::read_dir("/proc/self/task").ok().map(Iterator::count)
}

/// Waits until there are no more than so many, for ten seconds at most.
fn wait_for_threads(most: Option<usize>) {
    for _ in 0..1000 {
        if threads() <= most {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// A scenario at full speed, then in real time; where there are to be fewer cases the first of a test alone,
/// for the pace does not depend on what is made.
fn counted_at_both_paces(name: &str, settings: &[(String, String)], pulses: u64, first: bool) {
    let paces = if first { &PACES[..] } else { sized(&PACES[..], &PACES[..1]) };
    counted_scenario(name, settings, pulses, paces, || true);
}

const PACES: [Pace; 2] = [Pace::Fast, Pace::Realtime];

/// So many pulses as fast as they are made, or some in real time. Nothing is counted before it is `ready`,
/// or a second has passed.
fn counted_scenario(
    name: &str,
    settings: &[(String, String)],
    pulses: u64,
    paces: &[Pace],
    ready: impl Fn() -> bool + Sync,
) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("configs").join(name);
    let mut run = nereus::config::load(&path, settings).unwrap();
    // What sends stays.
    use nereus::sinks::Kind::{Vita49, Zmq};
    run.sinks.retain(|sink| matches!(sink.kind, Vita49(_) | Zmq(_)));
    run.stream.threads = 2;
    // A machine that is busy with other tests may be late, but has to make pulses.
    run.stream.policy = Policy::Slip;
    run.scene.pulses = pulses;
    let before_all = threads();
    // Both workers make blocks before it is counted, and meanwhile.
    let timed = pulses.min(400);
    for &pace in paces {
        let (end, from, to) = if pace == Pace::Fast {
            (pulses, (pulses / 6).max(150), pulses * 5 / 6)
        } else {
            (timed, 100, timed - 50)
        };
        // Workers of the run before may end late, and give back what they have.
        wait_for_threads(before_all);
        run.stream.pace = pace;
        let (mut before, mut after) = (None, None);
        let outcome = nereus::pipeline::build::stream(&run, 0..end)
            .unwrap()
            .tap(&Arc::new(AtomicBool::new(false)), |pulse| {
                if pace == Pace::Fast && pulse.index < from && !ready() {
                    std::thread::sleep(Duration::from_millis(5));
                }
                if pulse.index >= from && before.is_none() {
                    before = Some(ALLOCATIONS.load(Ordering::Relaxed));
                }
                if pulse.index <= to {
                    after = Some(ALLOCATIONS.load(Ordering::Relaxed));
                }
            })
            .unwrap();
        outcome.result.unwrap();
        let allocations = after.unwrap() - before.unwrap();
        println!("{name}, {pace:?}: {allocations} allocations between pulses {from} and {to}");
        assert_eq!(allocations, 0);
    }
}

/// The wake of a ship, added to the fields of a sea at many times.
#[test]
fn a_wake_map_allocates_nothing() {
    in_a_process_of_its_own("stream_allocations::counted_map");
}

#[test]
#[ignore = "run by a_wake_map_allocates_nothing in a process of its own"]
fn counted_map() {
    use nereus::scene::Patch;
    use nereus::sea::surface::{Fields, Grid, Selection};
    use nereus::sea::wake::{Course, Map, Reach, Settings, Wake, Wigley};
    let hull = Wigley { length_m: 100.0, beam_m: 13.0, draught_m: 4.3 };
    let patch = Patch::new([96.0, 80.0], 1.0, [-60.0, 0.0]).unwrap();
    let grid = Grid::new(96, 80, 1.0).unwrap();
    let wake = |speed_mps: f64, turn_rate_radps: f64| {
        let course = Course { turn_rate_radps, ..Course::straight([0.0, 0.0], 0.1, speed_mps) };
        let settings = Settings::new(1.0, Reach::of(&patch, &course, [0.0, 10.0]).unwrap());
        Wake::new(course, hull.length_m, &settings, |t| hull.amplitude_m(speed_mps, t)).unwrap()
    };
    let mut map = Map::<f32>::new(vec![wake(4.5, 0.0), wake(9.0, 1e-3)], &patch, -80.0).unwrap();
    let mut fields = Fields::new(&grid, Selection::ALL);
    let before = OWN_ALLOCATIONS.get();
    for step in 0..100 {
        map.add(patch.first, 0.1 * f64::from(step), &mut fields).unwrap();
    }
    let allocations = OWN_ALLOCATIONS.get() - before;
    println!("{allocations} allocations in 100 steps of two wakes");
    assert_eq!(allocations, 0);
    assert!(fields.height_m.iter().any(|z| *z != 0.0));
}
