//! `nereus nav play`

use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;

use super::convert::format_of;
use super::error::NavToolError;
use super::{RewriteArgs, Target, solutions};
use crate::cli::error::CliError;
use crate::cli::say;
use crate::nav::encode::{EncodeError, Format};
use crate::sinks::port::{Device, Port, PortFault};

/// How long the last bytes may take.
const LAST_BYTES: Duration = Duration::from_secs(2);

/// `nereus nav play`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct NavPlayArgs {
    /// The recording
    pub file: PathBuf,
    /// Path of a serial port or pseudo terminal, file:PATH, tcp://ADDRESS:PORT, or udp://ADDRESS:PORT
    pub device: String,
    /// How much faster than it was recorded
    #[arg(long, value_name = "X", default_value_t = 1.0)]
    pub rate: f64,
    /// Bits a second of a serial port
    #[arg(long, default_value_t = 115_200)]
    pub baud: u32,
    /// How it is read and sent
    #[command(flatten)]
    pub rewrite: RewriteArgs,
}

/// Sends a recording, every message at its time.
pub(super) fn play(args: &NavPlayArgs) -> Result<(), CliError> {
    if !(1e-3..=1e6).contains(&args.rate) {
        return Err(NavToolError::Range { key: "rate", value: args.rate, allowed: "0.001 to 1e6" }.into());
    }
    let device = Device::of(&args.device, args.baud).map_err(NavToolError::from)?;
    let solutions = solutions(&args.file, &args.rewrite.source)?;
    let target = args.rewrite.target.to.unwrap_or(Target::Nmea);
    let format = format_of(target, &args.rewrite.target)
        .unwrap_or_else(|| Format::Nmea(args.rewrite.target.sentences.clone()));
    let Some(first) = solutions.first() else { return Ok(()) };
    let mut message = Vec::new();
    // What cannot be reported is known before the port is opened.
    for (number, solution) in (1..).zip(&solutions) {
        message.clear();
        format.write(solution, &mut message).map_err(|source: EncodeError| NavToolError::Encode {
            number,
            time: solution.time.to_string(),
            source,
        })?;
    }
    let fault = |fault| match fault {
        PortFault::System(source) => NavToolError::Port { device: device.to_string(), source },
        PortFault::File(fault) => NavToolError::Output(fault),
    };
    let mut port = Port::open(device.clone(), args.rewrite.overwrite.force).map_err(fault)?;
    let begun = Instant::now();
    for solution in &solutions {
        let due = Duration::from_secs_f64(solution.time.since(first.time).max(0.0) / args.rate);
        thread::sleep(due.saturating_sub(begun.elapsed()));
        message.clear();
        if format.write(solution, &mut message).is_ok() {
            port.send(&message);
        }
        if port.failed() {
            break;
        }
    }
    let failed = port.fault();
    let counts = match failed {
        Some(source) => return Err(NavToolError::Unwritten { device: device.to_string(), source }.into()),
        None => port.finish(LAST_BYTES).map_err(fault)?,
    };
    say(format_args!(
        "{device}: {} messages of {} sent in {:.1} s, {} lost; vanished {} times",
        counts.messages,
        solutions.len(),
        begun.elapsed().as_secs_f64(),
        counts.lost_messages,
        counts.vanished
    ));
    Ok(())
}
