//! Panels: pieces of three nodes with a quadratic through them.

/// A panel `[middle - half, middle + half]` with a node at each end and one between.
///
/// In `s = (u - middle)/half`, from -1 to 1, a function is `c0 + c1 s + c2 s^2`.
///
/// ```
/// use nereus::scene::hull::Panel;
/// let panel = Panel::all(&[0.0, 1.0, 4.0])[0];
/// // u^2 through its nodes, integrated: 64/3.
/// assert!((panel.integral(&[0.0, 1.0, 16.0]) - 64.0 / 3.0).abs() < 1e-14);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Panel {
    /// Middle of the panel.
    pub middle: f64,
    /// Half its length.
    pub half: f64,
    /// Where the node between the ends lies, in s.
    pub node: f64,
}

impl Panel {
    /// The panels of an odd number of nodes.
    pub fn all(nodes: &[f64]) -> Vec<Self> {
        let panel = |nodes: &[f64]| {
            let (middle, half) = (0.5 * (nodes[0] + nodes[2]), 0.5 * (nodes[2] - nodes[0]));
            Self { middle, half, node: (nodes[1] - middle) / half }
        };
        nodes.windows(3).step_by(2).map(panel).collect()
    }

    /// The quadratic through three values.
    pub fn quadratic(&self, values: &[f64]) -> [f64; 3] {
        let (mean, slope) = (0.5 * (values[0] + values[2]), 0.5 * (values[2] - values[0]));
        let bend = (mean + slope * self.node - values[1]) / (1.0 - self.node * self.node);
        [mean - bend, slope, bend]
    }

    /// Weights of three values in `int f w du`, from the moments `int_-1^1 s^n w ds`, n = 0, 1, 2.
    pub fn weights(&self, moments: [f64; 3]) -> [f64; 3] {
        let bend = (moments[2] - moments[0]) / (1.0 - self.node * self.node);
        let (even, odd) = (moments[0] + bend, moments[1] + bend * self.node);
        [0.5 * self.half * (even - odd), -self.half * bend, 0.5 * self.half * (even + odd)]
    }

    /// Integral of the quadratic through three values.
    pub fn integral(&self, values: &[f64]) -> f64 {
        let [c0, _, c2] = self.quadratic(values);
        2.0 * self.half * (c0 + c2 / 3.0)
    }

    /// Integral of u times the quadratic.
    pub fn first_moment(&self, values: &[f64]) -> f64 {
        self.middle * self.integral(values) + self.half * self.half * 2.0 / 3.0 * self.quadratic(values)[1]
    }
}

/// Integral over all panels of the function with the given values at the nodes.
pub(super) fn integral(panels: &[Panel], values: &[f64]) -> f64 {
    panels.iter().enumerate().map(|(i, panel)| panel.integral(&values[2 * i..2 * i + 3])).sum()
}
