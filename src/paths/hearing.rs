//! What windows receive of an emission, wherever they are.

use crate::radar::window::Window;

/// What windows receive of an emission, on its own time axis.
#[derive(Clone, Debug)]
pub(crate) struct Hearing {
    pub(super) window: Window,
    /// From the emission of a pulse that may receive it to its own, s; empty where its own pulse is the only
    /// one.
    pub(super) offsets_s: Vec<f64>,
}

impl Hearing {
    /// [`Window::share`] of an echo in the window that receives most of it.
    pub fn share(&self, delay_s: f64) -> f64 {
        if self.offsets_s.is_empty() {
            return self.window.share(delay_s);
        }
        self.offsets_s.iter().map(|offset_s| self.window.share(offset_s + delay_s)).fold(0.0, f64::max)
    }

    /// Start of the window that is first to receive it, s after the emission.
    pub fn opens_s(&self) -> f64 {
        let latest_s = self.offsets_s.iter().copied().reduce(f64::max).unwrap_or(0.0);
        self.window.open_s - latest_s
    }
}
