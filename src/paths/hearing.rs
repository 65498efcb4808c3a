//! What windows receive of an emission, wherever they are.

use crate::radar::window::Window;

/// What windows receive of an emission, on its own time axis.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hearing {
    pub(super) windows: Vec<Window>,
    /// Window of each pair.
    pub(super) of_pairs: Vec<usize>,
    /// From the emission of a pulse that may receive it to its own, s; empty where its own pulse is the only
    /// one.
    pub(super) offsets_s: Vec<f64>,
}

impl Hearing {
    /// [`Window::share`] of an echo over a pair in the window that receives most of it.
    pub fn share(&self, pair: usize, delay_s: f64) -> f64 {
        let own = self.of_pairs.get(pair).and_then(|window| self.windows.get(*window));
        let Some(window) = own else { return 0.0 };
        if self.offsets_s.is_empty() {
            return window.share(delay_s);
        }
        self.offsets_s.iter().map(|offset_s| window.share(offset_s + delay_s)).fold(0.0, f64::max)
    }

    /// Start of the window that is first to receive it, s after the emission.
    pub fn opens_s(&self) -> f64 {
        let latest_s = self.offsets_s.iter().copied().reduce(f64::max).unwrap_or(0.0);
        Window::hull(self.windows.iter().copied()).open_s - latest_s
    }
}
