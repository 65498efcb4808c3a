//! The inner loop: scatterer paths of a block onto the grids of its pulses.
//!
//! For `CHUNK` scatterer paths at a time and every pulse of the share: (1) phase, phasor, first cell and
//! kernel weights of all of them, lane by lane; (2) some pulses by turns, each scatterer path's `C` lanes:
//! their amplitude at the pulse, turned by its phasor, onto its `W` cells. The chunk stays in the nearest
//! cache for all pulses, and a scatterer path's polynomials in registers for the pulses at hand. Everything
//! is safe code over slices; what CPU it is compiled for is decided by its callers.

use std::ops::Range;

use super::kernel::{MAX_TERMS, terms};
use super::scalar::Scalar;
use crate::cpu::{Instructions, Task};

/// Scatterer paths that stay in the cache for all pulses of a share.
pub(super) const CHUNK: usize = 64;
/// Pulses that are spread by turns.
const TOGETHER: usize = 4;

/// Ticks of an interval where intervals differ.
pub(super) const TICKS: f64 = 256.0;

/// Phases and places on the grid of the scatterer paths of one pair over a block: polynomials in mean
/// intervals from the middle.
#[derive(Debug, Default)]
pub struct DelayPolynomials<T: Scalar> {
    /// Phase, turns: constant, first and second power. Where intervals differ the first is that of a tick,
    /// and the second is in `uneven`.
    pub phase: [Vec<T::Turns>; 3],
    /// Phase, turns: third power.
    pub phase_cubic: Vec<T>,
    /// Phase, turns, where intervals differ: first and second power. Empty where they do not.
    pub uneven: [Vec<T>; 2],
    /// First cell in the middle of the block, whole cells; the rest is in `place`.
    pub base: Vec<i32>,
    /// First cell, before rounding up, less `base` and plus 1/2: powers 0 to 3, cells.
    pub place: [Vec<T>; 4],
}

impl<T: Scalar> DelayPolynomials<T> {
    pub fn reserve(&mut self, paths: usize) {
        self.phase.iter_mut().for_each(|column| column.reserve(paths));
        self.phase_cubic.reserve(paths);
        self.uneven.iter_mut().for_each(|column| column.reserve(paths));
        self.base.reserve(paths);
        self.place.iter_mut().for_each(|column| column.reserve(paths));
    }
}

/// An emission as a pulse receives it: when it is, and where the window of the pulse.
#[derive(Clone, Copy, Debug)]
pub struct Emitted<T: Scalar> {
    /// Shift of all places: whole cells and the rest.
    pub shift: (i32, T),
    /// From the middle of the block: whole intervals, or ticks where they differ, and what is left,
    /// intervals.
    pub ticks: i32,
    pub rest: T,
    /// The same as one number, intervals.
    pub time: T,
    /// The same for the amplitudes, whose powers may count from another instant.
    pub amplitude_time: T,
    /// By how much its carrier turns it, where intervals differ.
    pub turns: T::Turns,
    /// Place of its factors.
    pub row: usize,
    /// Pulse whose grids it goes to.
    pub grid: usize,
}

impl<T: Scalar> Emitted<T> {
    /// An emission so many intervals from the instants from which phases and amplitudes count, on the grids
    /// of a pulse whose window is shifted; `uneven`: where intervals differ.
    pub fn new(
        shift: (i32, T),
        [time, amplitude_time]: [f64; 2],
        (row, grid): (usize, usize),
        uneven: bool,
    ) -> Self {
        let ticks = if uneven { (time * TICKS).round() } else { time };
        let rest = if uneven { time - ticks / TICKS } else { 0.0 };
        Self {
            shift,
            ticks: ticks as i32,
            rest: T::round_from(rest),
            time: T::round_from(time),
            amplitude_time: T::round_from(amplitude_time),
            turns: T::Turns::default(),
            row,
            grid,
        }
    }
}

/// One layer of one share to be filled.
pub struct Job<'a, T: Scalar> {
    pub polynomials: &'a DelayPolynomials<T>,
    /// `[power][path][lane]`.
    pub amplitude: &'a [&'a [T]],
    /// What fills the layer, in an order in which neighbours have grids of their own.
    pub pulses: &'a [Emitted<T>],
    /// Pulse whose grids are the first at hand.
    pub first: usize,
    /// What multiplies the amplitudes, `[row][path]`; empty where nothing does.
    pub factors: &'a [T],
    /// Numbers from the factors of one pulse to the next.
    pub factor_stride: usize,
    /// What turns the amplitudes, `[row][real, imaginary][path]`; empty where nothing does.
    pub turned: &'a [T],
    /// Numbers from real to imaginary parts, and from these to the next pulse.
    pub turned_stride: usize,
    /// Kernel coefficients, `[tap][part][term]`.
    pub coefficients: &'a [[[T; MAX_TERMS]; 2]],
    /// Last first cell that is in reach of the window.
    pub last_cell: i32,
    /// Where the limits of reach are kept to a fraction of a cell: the least `beyond` at the last one.
    pub exact: Option<T>,
    /// First cell of those that are not read.
    pub outside: i32,
    /// Numbers from one pulse to the next, and before this layer.
    pub stride: usize,
    pub offset: usize,
}

/// Steps between the passes.
struct Passes<T, const W: usize> {
    cell: [i32; CHUNK],
    cos: [T; CHUNK],
    sin: [T; CHUNK],
    /// From the middle of the first tap back to its place, cells: the `z` of the kernel.
    beyond: [T; CHUNK],
    weight: [[T; CHUNK]; W],
}

impl<T: Scalar, const W: usize> Passes<T, W> {
    fn new() -> Self {
        let zero = T::default();
        Self {
            cell: [0; CHUNK],
            cos: [zero; CHUNK],
            sin: [zero; CHUNK],
            beyond: [zero; CHUNK],
            weight: [[zero; CHUNK]; W],
        }
    }
}

/// Adds the job's scatterer paths to `grids`.
///
/// The two steps are compiled apart, each a [`Task`] of its own: in one function they share the registers,
/// and the sums wait for constants of the other step that are loaded again for every scatterer path (a tenth
/// of the time).
pub(super) fn spread<T: Scalar, I: Instructions, const FUSED: bool, const W: usize, const C: usize>(
    instructions: I,
    job: &Job<'_, T>,
    grids: &mut [T],
) {
    let of_paths = |power: usize| job.amplitude[power].as_chunks::<C>().0;
    match job.amplitude.len() {
        2 => spread_powers::<T, I, FUSED, W, C, 2>(instructions, job, std::array::from_fn(of_paths), grids),
        4 => spread_powers::<T, I, FUSED, W, C, 4>(instructions, job, std::array::from_fn(of_paths), grids),
        // The block keeps two powers or four.
        _ => {}
    }
}

/// The same with `P` powers of the amplitudes, `[power][path][lane]`.
fn spread_powers<
    T: Scalar,
    I: Instructions,
    const FUSED: bool,
    const W: usize,
    const C: usize,
    const P: usize,
>(
    instructions: I,
    job: &Job<'_, T>,
    amplitude: [&[[T; C]]; P],
    grids: &mut [T],
) {
    let mut passes: [Passes<T, W>; TOGETHER] = std::array::from_fn(|_| Passes::new());
    let paths = job.polynomials.base.len();
    let mut from = 0;
    while from < paths {
        let part = from..paths.min(from + CHUNK);
        let amplitude = amplitude.map(|power| &power[part.clone()]);
        for pulses in job.pulses.chunks(TOGETHER) {
            let (part, passes) = (part.clone(), &mut passes);
            match (job.turned.is_empty(), job.polynomials.uneven[0].is_empty()) {
                (true, true) => {
                    instructions.run(Place::<T, FUSED, W, false, false> { job, part, pulses, passes });
                }
                (false, true) => {
                    instructions.run(Place::<T, FUSED, W, true, false> { job, part, pulses, passes });
                }
                (true, false) => {
                    instructions.run(Place::<T, FUSED, W, false, true> { job, part, pulses, passes });
                }
                (false, false) => {
                    instructions.run(Place::<T, FUSED, W, true, true> { job, part, pulses, passes });
                }
            }
            let (passes, grids) = (&passes[..pulses.len()], &mut *grids);
            instructions.run(Scatter::<T, FUSED, W, C, P> { job, passes, amplitude, pulses, grids });
        }
        from = part.end;
    }
}

/// Phasors, first cells and weights of a chunk at some pulses; what turns amplitudes is compiled apart, and
/// so are intervals that differ, for the loops of those that nothing turns are slower beside it.
struct Place<'a, 'j, T: Scalar, const FUSED: bool, const W: usize, const TURNED: bool, const UNEVEN: bool> {
    job: &'a Job<'j, T>,
    part: Range<usize>,
    pulses: &'a [Emitted<T>],
    passes: &'a mut [Passes<T, W>; TOGETHER],
}

impl<T: Scalar, const FUSED: bool, const W: usize, const TURNED: bool, const UNEVEN: bool> Task
    for Place<'_, '_, T, FUSED, W, TURNED, UNEVEN>
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { job, part, pulses, passes } = self;
        let (from, count) = (part.start, part.len());
        for (pulse, passes) in pulses.iter().zip(passes) {
            place::<T, FUSED, W, UNEVEN>(job, from, count, pulse, passes);
            let turned = |part: usize| job.turned.get((2 * pulse.row + part) * job.turned_stride + from..);
            let (cos, sin) = (&mut passes.cos[..count], &mut passes.sin[..count]);
            let factors = job.factors.get(pulse.row * job.factor_stride + from..);
            if !TURNED {
                if let Some(factors) = factors {
                    weigh(factors, cos, sin);
                    leave_out(factors, &mut passes.cell[..count]);
                }
            } else if let (Some(re), Some(im), Some(factors)) = (turned(0), turned(1), factors) {
                turn(re, im, factors, cos, sin);
                leave_out(factors, &mut passes.cell[..count]);
            }
        }
    }
}

/// The chunk onto the cells of these pulses.
struct Scatter<'a, 'j, T: Scalar, const FUSED: bool, const W: usize, const C: usize, const P: usize> {
    job: &'a Job<'j, T>,
    passes: &'a [Passes<T, W>],
    amplitude: [&'a [[T; C]]; P],
    pulses: &'a [Emitted<T>],
    grids: &'a mut [T],
}

impl<T: Scalar, const FUSED: bool, const W: usize, const C: usize, const P: usize> Task
    for Scatter<'_, '_, T, FUSED, W, C, P>
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { job, passes, amplitude, pulses, grids } = self;
        let of = |pulse: &Emitted<T>| {
            let from = pulse.grid.wrapping_sub(job.first).wrapping_mul(job.stride);
            from.wrapping_add(job.offset)..from.wrapping_add(job.stride)
        };
        if let Ok(own) = <&[_; TOGETHER]>::try_from(pulses)
            && let Ok(parts) = grids.get_disjoint_mut(own.each_ref().map(of))
        {
            let cells = parts.map(|part| part.as_chunks_mut::<C>().0);
            scatter::<T, FUSED, W, C, P, TOGETHER>(passes, amplitude, pulses, cells);
            return;
        }
        for (passes, pulse) in passes.chunks(1).zip(pulses.chunks(1)) {
            let Some(part) = pulse.first().and_then(|own| grids.get_mut(of(own))) else { continue };
            scatter::<T, FUSED, W, C, P, 1>(passes, amplitude, pulse, [part.as_chunks_mut::<C>().0]);
        }
    }
}

/// Phasors times the factors of their scatterer paths.
#[inline(always)]
fn weigh<T: Scalar>(factors: &[T], cos: &mut [T], sin: &mut [T]) {
    for ((factor, cos), sin) in factors.iter().zip(cos).zip(sin) {
        (*cos, *sin) = (*cos * *factor, *sin * *factor);
    }
}

/// Takes what nothing is left of beyond all cells, where it is passed over.
#[inline(always)]
fn leave_out<T: Scalar>(factors: &[T], cell: &mut [i32]) {
    for (factor, cell) in factors.iter().zip(cell) {
        *cell = if *factor == T::default() { i32::MAX } else { *cell };
    }
}

/// Phasors times those of their scatterer paths and their factors.
#[inline(always)]
fn turn<T: Scalar>(re: &[T], im: &[T], factors: &[T], cos: &mut [T], sin: &mut [T]) {
    let n = cos.len().min(re.len()).min(im.len()).min(factors.len()).min(sin.len());
    let (re, im, factors, cos, sin) = (&re[..n], &im[..n], &factors[..n], &mut cos[..n], &mut sin[..n]);
    for i in 0..n {
        let (c, s) = (cos[i] * factors[i], sin[i] * factors[i]);
        (cos[i], sin[i]) = (c * re[i] - s * im[i], c * im[i] + s * re[i]);
    }
}

/// Phasor, first cell and weights of a chunk.
#[inline(always)]
fn place<T: Scalar, const FUSED: bool, const W: usize, const UNEVEN: bool>(
    job: &Job<'_, T>,
    from: usize,
    count: usize,
    pulse: &Emitted<T>,
    passes: &mut Passes<T, W>,
) {
    let part = from..from + count;
    let polynomials = job.polynomials;
    if UNEVEN {
        uneven_phasors::<T, FUSED>(
            pulse,
            &polynomials.phase[0][part.clone()],
            &polynomials.phase[1][part.clone()],
            &polynomials.uneven[0][part.clone()],
            &polynomials.uneven[1][part.clone()],
            &polynomials.phase_cubic[part.clone()],
            &mut passes.cos[..count],
            &mut passes.sin[..count],
        );
    } else {
        phasors::<T, FUSED>(
            pulse.ticks,
            &polynomials.phase[0][part.clone()],
            &polynomials.phase[1][part.clone()],
            &polynomials.phase[2][part.clone()],
            &polynomials.phase_cubic[part.clone()],
            &mut passes.cos[..count],
            &mut passes.sin[..count],
        );
    }
    first_cells::<T, FUSED>(
        pulse.time,
        pulse.shift,
        [job.last_cell, job.outside],
        &polynomials.base[part.clone()],
        &polynomials.place[0][part.clone()],
        &polynomials.place[1][part.clone()],
        &polynomials.place[2][part.clone()],
        &polynomials.place[3][part],
        &mut passes.cell[..count],
        &mut passes.beyond[..count],
    );
    if let Some(least) = job.exact {
        cut_off(job, least, &passes.beyond[..count], &mut passes.cell[..count]);
    }
    weights::<T, FUSED, W>(job.coefficients, &passes.beyond[..count], &mut passes.weight);
}

// The passes below take every slice as an argument of its own: only so does the compiler know that they do
// not overlap.

/// Cosine and sine of the phase.
#[inline(always)]
fn phasors<T: Scalar, const FUSED: bool>(
    m: i32,
    p0: &[T::Turns],
    p1: &[T::Turns],
    p2: &[T::Turns],
    p3: &[T],
    cos: &mut [T],
    sin: &mut [T],
) {
    let lanes = p0.iter().zip(p1).zip(p2).zip(p3).zip(cos.iter_mut().zip(sin));
    for ((((p0, p1), p2), p3), (cos, sin)) in lanes {
        (*cos, *sin) = T::phasor::<FUSED>(T::phase([*p0, *p1, *p2], *p3, m));
    }
}

/// The same where intervals differ.
#[inline(always)]
fn uneven_phasors<T: Scalar, const FUSED: bool>(
    pulse: &Emitted<T>,
    p0: &[T::Turns],
    p1: &[T::Turns],
    linear: &[T],
    square: &[T],
    p3: &[T],
    cos: &mut [T],
    sin: &mut [T],
) {
    let Emitted { ticks, rest, time, turns, .. } = *pulse;
    let lanes = p0.iter().zip(p1).zip(linear).zip(square).zip(p3).zip(cos.iter_mut().zip(sin));
    for (((((p0, p1), linear), square), p3), (cos, sin)) in lanes {
        let high = time * time * T::fma::<FUSED>(*p3, time, *square);
        let high = T::fma::<FUSED>(*linear, rest, high);
        (*cos, *sin) = T::phasor::<FUSED>(T::uneven_phase(T::sum(*p0, turns), *p1, ticks, high));
    }
}

/// First cell, and how far its middle lies beyond the place of the first tap.
#[inline(always)]
fn first_cells<T: Scalar, const FUSED: bool>(
    s: T,
    shift: (i32, T),
    [last_cell, outside]: [i32; 2],
    base: &[i32],
    c0: &[T],
    c1: &[T],
    c2: &[T],
    c3: &[T],
    cell: &mut [i32],
    beyond: &mut [T],
) {
    let lanes = base.iter().zip(c0).zip(c1).zip(c2).zip(c3).zip(cell.iter_mut().zip(beyond));
    for (((((base, c0), c1), c2), c3), (cell, beyond)) in lanes {
        let high = T::fma::<FUSED>(T::fma::<FUSED>(*c3, s, *c2), s, *c1);
        let place = T::fma::<FUSED>(high, s, *c0) + shift.1;
        let (whole, nearest) = T::nearest(place);
        let first = base.wrapping_add(shift.0).wrapping_add(whole);
        *cell = if (first as u32) <= (last_cell as u32) { first } else { outside };
        *beyond = nearest - place;
    }
}

/// Leaves out what lies less than a cell beyond the limits of reach: rounded up, it is within.
#[inline(always)]
fn cut_off<T: Scalar>(job: &Job<'_, T>, least: T, beyond: &[T], cell: &mut [i32]) {
    for (cell, beyond) in cell.iter_mut().zip(beyond) {
        let past = (*cell == 0) | ((*cell == job.last_cell) & (*beyond < least));
        *cell = if past { job.outside } else { *cell };
    }
}

/// Weights of all taps.
#[inline(always)]
fn weights<T: Scalar, const FUSED: bool, const W: usize>(
    coefficients: &[[[T; MAX_TERMS]; 2]],
    beyond: &[T],
    weight: &mut [[T; CHUNK]; W],
) {
    for (tap, [even, odd]) in coefficients.iter().enumerate().take(W.div_ceil(2)) {
        let mut mirrored = [T::default(); CHUNK];
        weight_pair::<T, FUSED, W>(even, odd, beyond, &mut weight[tap], &mut mirrored);
        if 2 * tap + 1 != W {
            weight[W - 1 - tap] = mirrored;
        }
    }
}

/// Weights of a tap and of the one opposite.
#[inline(always)]
fn weight_pair<T: Scalar, const FUSED: bool, const W: usize>(
    even: &[T; MAX_TERMS],
    odd: &[T; MAX_TERMS],
    beyond: &[T],
    near: &mut [T; CHUNK],
    far: &mut [T; CHUNK],
) {
    let n = terms(W);
    for (z, (near, far)) in beyond.iter().zip(near.iter_mut().zip(far)) {
        let zz = *z * *z;
        let (mut e, mut o) = (even[n - 1], odd[n - 1]);
        for k in (0..n - 1).rev() {
            e = T::fma::<FUSED>(e, zz, even[k]);
            o = T::fma::<FUSED>(o, zz, odd[k]);
        }
        *near = T::fma::<FUSED>(o, *z, e);
        *far = T::fma::<FUSED>(-o, *z, e);
    }
}

/// One scatterer path, its amplitude turned by its phasor, onto its cells.
#[inline(always)]
fn add<T: Scalar, const FUSED: bool, const W: usize, const C: usize>(
    passes: &Passes<T, W>,
    i: usize,
    level: [T; C],
    cells: &mut [[T; C]],
) {
    let at = passes.cell[i] as usize;
    let Some(taps) = cells.get_mut(at..).and_then(<[[T; C]]>::first_chunk_mut::<W>) else { return };
    let (cos, sin) = (passes.cos[i], passes.sin[i]);
    let mut a = [T::default(); C];
    for k in 0..C {
        let across = if k % 2 == 0 { -sin } else { sin };
        a[k] = T::fma::<FUSED>(level[k], cos, level[k ^ 1] * across);
    }
    // By index, so that all taps are unrolled: half as fast with iterators.
    #[allow(clippy::needless_range_loop)]
    for tap in 0..W {
        let weight = passes.weight[tap][i];
        for k in 0..C {
            taps[tap][k] = T::fma::<FUSED>(weight, a[k], taps[tap][k]);
        }
    }
}

/// Scatterer paths onto the cells of some pulses by turns: neighbours often share cells, and would wait for
/// each other's sums.
#[inline(always)]
#[allow(clippy::needless_range_loop)]
fn scatter<T: Scalar, const FUSED: bool, const W: usize, const C: usize, const P: usize, const N: usize>(
    passes: &[Passes<T, W>],
    amplitude: [&[[T; C]]; P],
    pulses: &[Emitted<T>],
    cells: [&mut [[T; C]]; N],
) {
    // By index, and without `map`: what is not inlined has not these instructions.
    let mut at = [T::default(); N];
    for n in 0..N {
        at[n] = pulses[n].amplitude_time;
    }
    for i in 0..amplitude[0].len() {
        let mut powers = [[T::default(); C]; P];
        for p in 0..P {
            powers[p] = amplitude[p][i];
        }
        for n in 0..N {
            let mut level = powers[P - 1];
            for power in powers[..P - 1].iter().rev() {
                for k in 0..C {
                    level[k] = T::fma::<FUSED>(level[k], at[n], power[k]);
                }
            }
            add::<T, FUSED, W, C>(&passes[n], i, level, cells[n]);
        }
    }
}
