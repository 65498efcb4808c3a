//! The live page: `nereus run --monitor` and `nereus monitor`.

use std::path::PathBuf;

use clap::Args;

use super::error::CliError;
use super::values::{Unreadable, allowed};

/// `nereus monitor`
#[derive(Debug, Args)]
pub struct MonitorArgs {
    /// HDF5 file or folder
    pub recording: PathBuf,
    /// Address of the page; port 0: any that is free
    #[arg(long, value_name = "ADDR", default_value = "127.0.0.1:8080")]
    pub listen: String,
    /// Times the pace at which the pulses were emitted, 0.001 to 1000
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = speed)]
    pub speed: f64,
    /// End with the recording; otherwise its page stays until Ctrl-C
    #[arg(long)]
    pub once: bool,
}

fn speed(text: &str) -> Result<f64, Unreadable> {
    let speed = text.parse().ok().filter(|speed: &f64| (0.001..=1000.0).contains(speed));
    allowed(speed, "a number from 0.001 to 1000")
}

#[cfg(feature = "monitor")]
pub(super) mod page {
    use std::path::Path;
    use std::sync::atomic::Ordering;
    use std::thread;
    use std::time::Duration;

    use super::{CliError, MonitorArgs};
    use crate::cli::{counted, escape, say, stop_on_ctrl_c, warn};
    use crate::monitor::replay::Replay;
    use crate::monitor::{Endpoint, Monitor, Scenery, queue_pulses};
    use crate::pipeline::build::PulseStream;
    use crate::pipeline::control::Control;
    use crate::recording::examination::refuse_fatal;
    use crate::scene::Scene;
    use crate::transport::view::View;

    /// A page whose address is taken; nobody is answered yet.
    pub struct Page(Endpoint);

    /// A page that is served.
    pub struct Shown(Monitor);

    impl Page {
        /// At an address.
        pub fn at(address: &str) -> Result<Self, CliError> {
            Ok(Self(Endpoint::at(address)?))
        }

        /// Shows a stream. `control` lets who has the address change reports.
        pub fn show(
            self,
            stream: &PulseStream,
            scene: &Scene,
            config: &Path,
            control: Option<Control>,
        ) -> Result<(View, Shown), CliError> {
            let what = if control.is_some() { "see the run and change its reports" } else { "see the run" };
            announce((self.0.url(), self.0.is_open_to_others()), what);
            let title =
                config.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
            let (view, onlooker) = stream.view(queue_pulses(stream.header()));
            let scenery = Scenery::of(scene, &title);
            let monitor = Monitor::of_stream(self.0, stream.header(), &scenery, onlooker, control)?;
            Ok((view, Shown(monitor)))
        }
    }

    impl Shown {
        /// Lets browsers have the last of it.
        pub fn close(self) {
            self.0.close();
        }
    }

    /// Says where the page is, and what others can do there.
    fn announce((url, is_open_to_others): (String, bool), what: &str) {
        say(format_args!("monitor: {url}"));
        if is_open_to_others {
            warn([format!("other machines can reach the monitor: whoever has its address can {what}")]);
        }
    }

    /// Shows a recording.
    pub fn replay(args: &MonitorArgs) -> Result<(), CliError> {
        // What a damaged recording holds is shown as far as it goes.
        refuse_fatal(&args.recording)?;
        let endpoint = Endpoint::at(&args.listen)?;
        let announced = (endpoint.url(), endpoint.is_open_to_others());
        let mut replay = Replay::open(&args.recording, endpoint)?;
        announce(announced, "see the recording");
        let stop = stop_on_ctrl_c(false)?;
        let played = replay.play(args.speed, &stop);
        let name = escape::path(&args.recording);
        let pulses = counted(played.pulses, "pulse");
        match &played.fault {
            Some(fault) => warn([format!("{name}: {pulses} shown, and then it cannot be read: {fault}")]),
            None => say(format_args!("{name}: {pulses} shown")),
        }
        if !args.once && !stop.load(Ordering::Acquire) {
            say("the page stays until Ctrl-C");
            while !stop.load(Ordering::Acquire) {
                thread::sleep(Duration::from_millis(50));
            }
        }
        replay.close();
        Ok(())
    }
}

/// A build without the page.
#[cfg(not(feature = "monitor"))]
pub(super) mod page {
    use std::path::Path;

    use super::{CliError, MonitorArgs};
    use crate::cli::error::Refused;
    use crate::pipeline::build::PulseStream;
    use crate::pipeline::control::Control;
    use crate::scene::Scene;
    use crate::transport::view::View;

    /// There is none, nor one that is shown.
    pub enum Page {}

    impl Page {
        pub fn at(_: &str) -> Result<Self, CliError> {
            Err(Refused::NoMonitor.into())
        }

        pub fn show(
            self,
            _: &PulseStream,
            _: &Scene,
            _: &Path,
            _: Option<Control>,
        ) -> Result<(View, Self), CliError> {
            match self {}
        }

        pub fn close(self) {
            match self {}
        }
    }

    pub fn replay(_: &MonitorArgs) -> Result<(), CliError> {
        Err(Refused::NoMonitor.into())
    }
}
