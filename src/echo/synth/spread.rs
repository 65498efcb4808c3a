//! The inner loop: contacts of a block onto the grids of its pulses.
//!
//! For `CHUNK` contacts at a time and every pulse of the share: (1) phase, phasor, first cell and kernel weights of all
//! of them, lane by lane; (2) amplitudes at this pulse, turned by the phasor; (3) each contact's `C` lanes onto its `W` cells. The
//! chunk stays in the nearest cache for all pulses. Everything is safe code over slices; what CPU it is compiled for is
//! decided by its callers.

use super::kernel::{MAX_TERMS, terms};
use super::scalar::Scalar;

/// Contacts that are kept close for all pulses of a share.
pub(super) const CHUNK: usize = 256;

/// Phases and places of the contacts of one pair over a block; polynomials in pulses from the middle.
#[derive(Debug, Default)]
pub(super) struct Courses<T: Scalar> {
    /// Phase, turns: constant, first and second power.
    pub phase: [Vec<T::Turns>; 3],
    /// Phase, turns: third power.
    pub phase_cubic: Vec<T>,
    /// First cell in the middle of the block, whole cells; the rest is in `place`.
    pub base: Vec<i32>,
    /// First cell, before rounding up, less `base` and plus 1/2: powers 0 to 3, cells.
    pub place: [Vec<T>; 4],
}

/// One layer of one share to be filled.
pub(super) struct Job<'a, T: Scalar> {
    pub courses: &'a Courses<T>,
    /// `[power][contact][lane]`.
    pub amplitude: &'a [&'a [T]],
    /// Shift of all places per pulse of the share: whole cells and the rest.
    pub shifts: &'a [(i32, T)],
    /// Pulses from the middle of the block to the first of the share.
    pub first: i32,
    /// Kernel coefficients, `[tap][part][term]`.
    pub coefficients: &'a [[[T; MAX_TERMS]; 2]],
    /// Last first cell that is in reach of the window.
    pub last_cell: i32,
    /// First cell of those that are not read.
    pub outside: i32,
    /// Numbers from one pulse to the next, and before this layer.
    pub stride: usize,
    pub offset: usize,
}

/// Steps between the passes.
struct Passes<T, const W: usize, const C: usize> {
    cell: [i32; CHUNK],
    cos: [T; CHUNK],
    sin: [T; CHUNK],
    weight: [[T; CHUNK]; W],
    turned: [[T; C]; CHUNK],
}

/// Adds the job's contacts to `grids`.
#[inline(always)]
pub(super) fn spread<T: Scalar, const FUSED: bool, const W: usize, const C: usize>(
    job: &Job<'_, T>,
    grids: &mut [T],
) {
    let zero = T::default();
    let mut passes = Passes::<T, W, C> {
        cell: [0; CHUNK],
        cos: [zero; CHUNK],
        sin: [zero; CHUNK],
        weight: [[zero; CHUNK]; W],
        turned: [[zero; C]; CHUNK],
    };
    let contacts = job.courses.base.len();
    let mut from = 0;
    while from < contacts {
        let count = CHUNK.min(contacts - from);
        for (pulse, (shift, grid)) in job.shifts.iter().zip(grids.chunks_exact_mut(job.stride)).enumerate() {
            let m = job.first + pulse as i32;
            place::<T, FUSED, W, C>(job, from, count, m, *shift, &mut passes);
            turn::<T, FUSED, W, C>(job, from, count, m, &mut passes);
            scatter::<T, FUSED, W, C>(&passes, count, &mut grid[job.offset..]);
        }
        from += count;
    }
}

/// Phasor, first cell and weights of a chunk.
#[inline(always)]
fn place<T: Scalar, const FUSED: bool, const W: usize, const C: usize>(
    job: &Job<'_, T>,
    from: usize,
    count: usize,
    m: i32,
    shift: (i32, T),
    passes: &mut Passes<T, W, C>,
) {
    let part = from..from + count;
    let courses = job.courses;
    let [p0, p1, p2] = [0, 1, 2].map(|k| &courses.phase[k][part.clone()]);
    let p3 = &courses.phase_cubic[part.clone()];
    let [c0, c1, c2, c3] = [0, 1, 2, 3].map(|k| &courses.place[k][part.clone()]);
    let base = &courses.base[part];
    let (cell, cos, sin) = (&mut passes.cell[..count], &mut passes.cos[..count], &mut passes.sin[..count]);
    let weight = passes.weight.each_mut().map(|w| &mut w[..count]);
    let s = T::from_int(m);
    for i in 0..count {
        let t = T::phase([p0[i], p1[i], p2[i]], p3[i], m);
        (cos[i], sin[i]) = T::phasor::<FUSED>(t);
        let high = T::fma::<FUSED>(T::fma::<FUSED>(c3[i], s, c2[i]), s, c1[i]);
        let place = T::fma::<FUSED>(high, s, c0[i]) + shift.1;
        let (whole, nearest) = T::nearest(place);
        let first = base[i].wrapping_add(shift.0).wrapping_add(whole);
        let seen = (first as u32) <= (job.last_cell as u32);
        cell[i] = if seen { first } else { job.outside };
        let z = nearest - place;
        let zz = z * z;
        for tap in 0..W.div_ceil(2) {
            let [even, odd] = &job.coefficients[tap];
            let n = terms(W);
            let mut e = even[n - 1];
            for k in (0..n - 1).rev() {
                e = T::fma::<FUSED>(e, zz, even[k]);
            }
            if 2 * tap + 1 == W {
                weight[tap][i] = e;
            } else {
                let mut o = odd[n - 1];
                for k in (0..n - 1).rev() {
                    o = T::fma::<FUSED>(o, zz, odd[k]);
                }
                o = o * z;
                weight[tap][i] = e + o;
                weight[W - 1 - tap][i] = e - o;
            }
        }
    }
}

/// Amplitudes at this pulse times the phasor.
#[inline(always)]
fn turn<T: Scalar, const FUSED: bool, const W: usize, const C: usize>(
    job: &Job<'_, T>,
    from: usize,
    count: usize,
    m: i32,
    passes: &mut Passes<T, W, C>,
) {
    let s = T::from_int(m);
    let part = from * C..(from + count) * C;
    let (cos, sin, turned) = (&passes.cos[..count], &passes.sin[..count], &mut passes.turned[..count]);
    let rotate = |a: &[T; C], i: usize| -> [T; C] {
        let mut out = [T::default(); C];
        for k in 0..C / 2 {
            let (re, im) = (a[2 * k], a[2 * k + 1]);
            out[2 * k] = T::fma::<FUSED>(re, cos[i], -(im * sin[i]));
            out[2 * k + 1] = T::fma::<FUSED>(im, cos[i], re * sin[i]);
        }
        out
    };
    match *job.amplitude {
        [a0, a1] => {
            let (a0, _) = a0[part.clone()].as_chunks::<C>();
            let (a1, _) = a1[part].as_chunks::<C>();
            for (i, (to, (a0, a1))) in turned.iter_mut().zip(a0.iter().zip(a1)).enumerate() {
                let mut a = [T::default(); C];
                for k in 0..C {
                    a[k] = T::fma::<FUSED>(a1[k], s, a0[k]);
                }
                *to = rotate(&a, i);
            }
        }
        [a0, a1, a2, a3] => {
            let [a0, a1, a2, a3] = [a0, a1, a2, a3].map(|a| a[part.clone()].as_chunks::<C>().0);
            for i in 0..turned.len().min(a0.len()).min(a1.len()).min(a2.len()).min(a3.len()) {
                let mut a = [T::default(); C];
                for k in 0..C {
                    let high = T::fma::<FUSED>(T::fma::<FUSED>(a3[i][k], s, a2[i][k]), s, a1[i][k]);
                    a[k] = T::fma::<FUSED>(high, s, a0[i][k]);
                }
                turned[i] = rotate(&a, i);
            }
        }
        // The block keeps two powers or four.
        _ => {}
    }
}

/// Contacts onto their cells.
#[inline(always)]
fn scatter<T: Scalar, const FUSED: bool, const W: usize, const C: usize>(
    passes: &Passes<T, W, C>,
    count: usize,
    grid: &mut [T],
) {
    let (cells, _) = grid.as_chunks_mut::<C>();
    for i in 0..count {
        let at = passes.cell[i] as usize;
        let Some(taps) = cells.get_mut(at..at + W) else { continue };
        let a = &passes.turned[i];
        for tap in 0..W {
            let weight = passes.weight[tap][i];
            for k in 0..C {
                taps[tap][k] = T::fma::<FUSED>(weight, a[k], taps[tap][k]);
            }
        }
    }
}
