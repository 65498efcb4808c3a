//! What a run takes of memory, from the sizes of its parts.
//!
//! | part | bytes |
//! | --- | --- |
//! | the program and its libraries | [`PROGRAM_BYTES`] |
//! | the sea that all workers share | [`SHARED_FACET_BYTES`] a facet |
//! | the sea of a worker: its surface, nodes, shadows, phases | [`WORKER_FACET_BYTES`] a facet |
//! | the same of pulses one by one, shared and of a worker | `SINGLE_FACET_BYTES` a facet more |
//! | the surface in f64, of a worker | `FINE_FACET_BYTES` a facet |
//! | choppy waves, of a worker | [`CHOPPY_FACET_BYTES`] a facet |
//! | facets that forget their phases, of a worker of the fast echo | [`FORGETTING_BYTES`] a facet, up to [`FORGETTING_ROOM_BYTES`] |
//! | shadows of a patch that follows, and of choppy waves, of a worker of the fast echo | [`FOLLOW_FACET_BYTES`] a facet |
//! | ships that echo by their mesh, shared | [`SHARED_PATH_BYTES`] a panel or double bounce |
//! | the same of a worker | nodes and factors of a block, `path_bytes` each |
//! | scatterers of breaking waves | the same, and those that are kept for all workers |
//! | the far sea | cells that are kept for all workers, and lists of a stretch of each |
//! | grids of a worker | pulses of a block x cells x 2 floats per channel |
//! | ring | its pulses x bytes of a pulse |
//! | queues | distinct pulses that sinks hold x bytes of a pulse; see [`Slots`] |
//!
//! Bytes a facet are those of the buffers as they are, found from the resident memory of seas of 256 x 256
//! and 512 x 512 facets with one and two workers; of pulses one by one, which have lists of exact scatterer
//! paths and of those in single precision, from 64 x 64 to 256 x 256.
//!
//! Left out: what the dry run takes before the first pulse and gives back, up to 120 MiB. A small patch at a
//! fine error has its peak there.

use crate::echo::Fidelity;
use crate::fidelity::budget::may_have_fine_surface;
use crate::paths::block::{FORGETTING_BYTES, FORGETTING_ROOM_BYTES};
use crate::scattering::two_scale::TILTS;
use crate::scene::Scene;
use crate::scene::sea::{BraggWaves, PatchPlace, Sea, Speckle, Waves};
use crate::sinks;
use crate::transport::{self, fanout};
use std::fs;

/// The program, its libraries, stacks, tables.
pub const PROGRAM_BYTES: u64 = 32 << 20;
/// Shared, a facet: the reference's, the fast echo's.
pub const SHARED_FACET_BYTES: [u64; 2] = [330, 60];
/// Of each worker, a facet: the reference's, the fast echo's.
pub const WORKER_FACET_BYTES: [u64; 2] = [700, 430];
/// More, a facet, where the fast echo makes pulses one by one: shared, of each worker.
const SINGLE_FACET_BYTES: [u64; 2] = [320, 900];
/// More of each worker, a facet, where waves are choppy: four fields, of every node in the fast echo.
pub const CHOPPY_FACET_BYTES: [u64; 2] = [32, 64];
/// More of each worker of the fast echo, a facet, where the surface at nodes is found in f64.
const FINE_FACET_BYTES: u64 = 200;
/// Of each worker of the fast echo, a facet, where the patch follows or waves are choppy: a surface of its
/// own for the shadows, and updates that blocks share.
pub const FOLLOW_FACET_BYTES: u64 = 250;

/// Of a slot that no pulse was in yet: its records, and the pages at both ends of its samples.
pub const UNUSED_SLOT_BYTES: u64 = 8 << 10;

/// Slots for pulses of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slots {
    /// Between generation and release.
    pub ring: usize,
    /// For what sinks hold of released pulses when all their queues are full. Memory is taken as they fill:
    /// while sinks keep up each takes [`UNUSED_SLOT_BYTES`] or less.
    pub held: usize,
}

impl Slots {
    /// Of a stream with these sinks.
    pub fn of(settings: &transport::Settings, sinks: &[sinks::Settings]) -> Self {
        let roles = sinks.iter().map(|sink| (sink.queue_pulses, sink.role()));
        // And one of each sink, for the pulse after a gap.
        Self { ring: settings.ring_slots, held: fanout::held_at_most(settings, roles) + sinks.len() }
    }
}

/// What a run takes of memory, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Predicted {
    /// While sinks keep up.
    pub kept_up: u64,
    /// With every queue full.
    pub at_most: u64,
}

/// About what the sea of a scene takes, bytes.
pub(crate) fn sea_bytes(scene: &Scene, fidelity: &Fidelity, threads: usize) -> u64 {
    // Each emitter that it returns has it once more.
    let seas = 1 + scene.radar.emitters.iter().filter(|emitter| emitter.echo).count() as u64;
    let facets = scene.sea.as_ref().map_or(0, |sea| sea.patch.len() as u64).saturating_mul(seas);
    let n = match fidelity {
        Fidelity::Reference => 0,
        Fidelity::Fast(_) => 1,
    };
    let fine = matches!(fidelity, Fidelity::Fast(asked) if may_have_fine_surface(asked));
    let follows = scene.sea.as_ref().is_some_and(|sea| sea.place != PatchPlace::Fixed);
    let choppy = scene.sea.as_ref().is_some_and(|sea| sea.waves == Waves::Choppy);
    let apart = (follows || choppy) && n == 1;
    let worker = WORKER_FACET_BYTES[n] + if apart { FOLLOW_FACET_BYTES } else { 0 };
    let worker = worker + if choppy { CHOPPY_FACET_BYTES[n] } else { 0 };
    let worker = worker + if fine { FINE_FACET_BYTES } else { 0 };
    let held = match (&scene.sea, n) {
        (Some(sea), 1) => forgetting_held(sea, facets),
        _ => 0,
    };
    let worker = worker + held * FORGETTING_BYTES as u64;
    let each = SHARED_FACET_BYTES[n].saturating_add(worker.saturating_mul(threads as u64));
    facets.saturating_mul(each)
}

/// Processes of facets that forget their phases of which a worker holds the waves.
fn forgetting_held(sea: &Sea, facets: u64) -> u64 {
    let scattering = &sea.scattering;
    if scattering.bragg != BraggWaves::Frozen || scattering.decorrelation_s.is_none() {
        return 0;
    }
    let tilts = match scattering.speckle {
        Speckle::RandomPhase => {
            if scattering.tilt_average {
                TILTS
            } else {
                1
            }
        }
        Speckle::Gaussian { tilt_modes } => tilt_modes,
    };
    let room = FORGETTING_ROOM_BYTES as u64 / facets.saturating_mul(FORGETTING_BYTES as u64).max(1);
    room.min(1 + tilts as u64)
}

/// What pulses that the fast echo makes one by one take more than those of a block, bytes.
pub(crate) fn single_bytes(facets: usize, threads: usize) -> u64 {
    let [shared, worker] = SINGLE_FACET_BYTES;
    (facets as u64).saturating_mul(shared.saturating_add(worker.saturating_mul(threads as u64)))
}

/// Shared, a path of a ship's mesh: its panel, the tree of its triangles, what is seen at the time samples
/// that are kept, and what the plan of the run follows of it.
pub const SHARED_PATH_BYTES: u64 = 1500;

/// Of a worker, a path of a ship's mesh or a scatterer of a breaking wave, bytes: in lists of a delay, a rate
/// and an amplitude, and its factors in some pulses, in double and single precision.
pub(crate) fn path_bytes([pairs, channels]: [usize; 2], lists: usize, pulses: usize) -> u64 {
    (lists * (8 + 16 * pairs + 16 * channels) + 12 * pairs * pulses) as u64
}

/// Memory that the system says it can give, bytes; `None` where it does not say.
pub(crate) fn available_bytes() -> Option<u64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
}
