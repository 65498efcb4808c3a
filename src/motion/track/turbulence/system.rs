//! One axis of gust and answer as a linear system, stepped exactly.

use rand_distr::{Distribution, StandardNormal};

use crate::rng::{Room, stream};

/// Most states of an axis: two of the gust, two of the answer, one of the position.
const MOST: usize = 5;
/// Damping of the answer.
const DAMPING: f64 = 0.7;
/// Terms of the exponential of a matrix of norm below 1/2: (1/2)^20/20! is 4e-25.
const TERMS: usize = 20;

type Matrix = [[f64; 2 * MOST]; 2 * MOST];

/// A gust along one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Along the track (first order), or across (second order).
    pub along: bool,
    /// Standard deviation, m/s.
    pub sigma_mps: f64,
    /// Length over airspeed, s.
    pub time_s: f64,
}

/// Gust and answer at a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Answer {
    /// The gust, m/s.
    pub gust_mps: f64,
    /// The gust as followed, with first and second derivative.
    pub followed: [f64; 3],
    /// Displacement, m.
    pub position_m: f64,
    /// Its derivative, m/s.
    pub velocity_mps: f64,
    /// Its second derivative, m/s^2.
    pub acceleration_mps2: f64,
}

/// Noise to gust to answer to displacement, in steps.
#[derive(Clone, Debug)]
pub struct Chain {
    gusts: usize,
    order: usize,
    /// From states to the gust.
    output: [f64; 2],
    cutoff: f64,
    hold_s: Option<f64>,
    step: Matrix,
    /// Root of the covariance of a step, and of the first state (its rows below the position's).
    fresh: Matrix,
    begin: Matrix,
}

impl Chain {
    /// The system of an axis, with the angular cut-off (rad/s) of the answer and steps of `step_s`.
    pub fn new(axis: Axis, cutoff: f64, hold_s: Option<f64>, step_s: f64) -> Self {
        let t = axis.time_s;
        let gusts = if axis.along { 1 } else { 2 };
        let order = gusts + 3;
        let (mut a, mut b) = ([[0.0; 2 * MOST]; 2 * MOST], [0.0; MOST]);
        let output = if axis.along {
            a[0][0] = -1.0 / t;
            b[0] = axis.sigma_mps * (2.0 / t).sqrt();
            [1.0, 0.0]
        } else {
            // In time and amplitude of order one: x0 = z, x1 = T z'.
            a[0][1] = 1.0 / t;
            a[1][0] = -1.0 / t;
            a[1][1] = -2.0 / t;
            b[1] = axis.sigma_mps / t.sqrt();
            [1.0, 3f64.sqrt()]
        };
        // y, y'/w_c: the same.
        let (y, rate, place) = (gusts, gusts + 1, gusts + 2);
        a[y][rate] = cutoff;
        a[rate][y] = -cutoff;
        a[rate][rate] = -2.0 * DAMPING * cutoff;
        for (state, weight) in output.into_iter().enumerate().take(gusts) {
            a[rate][state] = cutoff * weight;
        }
        a[place][y] = match hold_s {
            Some(hold_s) => {
                a[place][place] = -1.0 / hold_s;
                1.0 / hold_s
            }
            None => 1.0,
        };
        let stable = if hold_s.is_some() { order } else { order - 1 };
        let step = exponential(&scaled(&a, step_s, order), order);
        let covariance = of_step(&a, &b, step_s, order, &step);
        let begin = root(&stationary(&step, &covariance, stable), stable);
        Self { gusts, order, output, cutoff, hold_s, step, fresh: root(&covariance, order), begin }
    }

    /// Steps `first ..`, of the streams of a key.
    pub fn run(&self, seed: u64, key: u64, first: i64, steps: usize) -> Vec<Answer> {
        let mut state = [0.0; MOST];
        (0..steps)
            .map(|k| {
                let mut numbers = stream(seed, Room::Turbulence, key, (first + k as i64) as u64);
                let x: [f64; MOST] = std::array::from_fn(|_| StandardNormal.sample(&mut numbers));
                let mut next = [0.0; MOST];
                for (row, value) in next.iter_mut().enumerate().take(self.order) {
                    let root = if k == 0 { &self.begin } else { &self.fresh };
                    for column in 0..self.order {
                        *value += root[row][column] * x[column];
                        if k > 0 {
                            *value += self.step[row][column] * state[column];
                        }
                    }
                }
                state = next;
                self.answer(&state)
            })
            .collect()
    }

    fn answer(&self, state: &[f64; MOST]) -> Answer {
        let gust = state.iter().zip(self.output).take(self.gusts).map(|(x, c)| x * c).sum::<f64>();
        let (y, rate, place) = (state[self.gusts], state[self.gusts + 1], state[self.gusts + 2]);
        let w = self.cutoff;
        let followed = [y, w * rate, w * w * (gust - y - 2.0 * DAMPING * rate)];
        match self.hold_s {
            Some(hold_s) => Answer {
                gust_mps: gust,
                followed,
                position_m: hold_s * place,
                velocity_mps: y - place,
                acceleration_mps2: followed[1] - (y - place) / hold_s,
            },
            None => Answer {
                gust_mps: gust,
                followed,
                position_m: place,
                velocity_mps: y,
                acceleration_mps2: followed[1],
            },
        }
    }
}

fn scaled(a: &Matrix, by: f64, order: usize) -> Matrix {
    let mut out = [[0.0; 2 * MOST]; 2 * MOST];
    for (to, from) in out.iter_mut().zip(a).take(order) {
        for (to, from) in to.iter_mut().zip(from).take(order) {
            *to = from * by;
        }
    }
    out
}

fn product(a: &Matrix, b: &Matrix, order: usize) -> Matrix {
    let mut out = [[0.0; 2 * MOST]; 2 * MOST];
    for i in 0..order {
        for k in 0..order {
            for j in 0..order {
                out[i][j] += a[i][k] * b[k][j];
            }
        }
    }
    out
}

fn transposed(a: &Matrix, order: usize) -> Matrix {
    let mut out = [[0.0; 2 * MOST]; 2 * MOST];
    for i in 0..order {
        for j in 0..order {
            out[j][i] = a[i][j];
        }
    }
    out
}

/// e^A by scaling and squaring.
fn exponential(a: &Matrix, order: usize) -> Matrix {
    let norm = a.iter().take(order).map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
    let halvings = (norm / 0.5).log2().ceil().clamp(0.0, 60.0) as i32;
    let small = scaled(a, 0.5f64.powi(halvings), order);
    let mut sum = [[0.0; 2 * MOST]; 2 * MOST];
    (0..order).for_each(|i| sum[i][i] = 1.0);
    let mut term = sum;
    for n in 1..=TERMS {
        term = scaled(&product(&term, &small, order), 1.0 / n as f64, order);
        for i in 0..order {
            for j in 0..order {
                sum[i][j] += term[i][j];
            }
        }
    }
    for _ in 0..halvings {
        sum = product(&sum, &sum, order);
    }
    sum
}

/// Covariance of what a step adds, by the exponential of `[[-A, b b^T], [0, A^T]]`: its upper right block is
/// `e^(-A dt)` times it.
fn of_step(a: &Matrix, b: &[f64; MOST], step_s: f64, order: usize, step: &Matrix) -> Matrix {
    let mut both = [[0.0; 2 * MOST]; 2 * MOST];
    for i in 0..order {
        for j in 0..order {
            both[i][j] = -a[i][j] * step_s;
            both[i][order + j] = b[i] * b[j] * step_s;
            both[order + i][order + j] = a[j][i] * step_s;
        }
    }
    let grown = exponential(&both, 2 * order);
    let mut upper = [[0.0; 2 * MOST]; 2 * MOST];
    for i in 0..order {
        upper[i][..order].copy_from_slice(&grown[i][order..2 * order]);
    }
    product(step, &upper, order)
}

/// `P = F P F^T + Q` by doubling.
fn stationary(step: &Matrix, covariance: &Matrix, order: usize) -> Matrix {
    let (mut p, mut f) = (*covariance, *step);
    for _ in 0..60 {
        let more = product(&product(&f, &p, order), &transposed(&f, order), order);
        for i in 0..order {
            for j in 0..order {
                p[i][j] += more[i][j];
            }
        }
        f = product(&f, &f, order);
    }
    p
}

/// Lower triangle whose square is a covariance; directions without variance get none.
fn root(covariance: &Matrix, order: usize) -> Matrix {
    let mut out = [[0.0; 2 * MOST]; 2 * MOST];
    for i in 0..order {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| out[i][k] * out[j][k]).sum();
            // The upper and lower half differ by rounding.
            let rest = 0.5 * (covariance[i][j] + covariance[j][i]) - known;
            out[i][j] = if i == j {
                rest.max(0.0).sqrt()
            } else if out[j][j] > 0.0 {
                rest / out[j][j]
            } else {
                0.0
            };
        }
    }
    out
}
