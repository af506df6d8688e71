//! `dragnet relay`: emulates a slow link.

use std::net::SocketAddr;
use std::time::Duration;

use dragnet_runtime::relay::{self, Forward, Quality};

use super::Failure;

/// Relay TCP connections with a delay and a limited rate, to emulate a bad radio link.
///
/// Robots connect to the relay instead of to each other. Runs until it is stopped.
#[derive(clap::Args)]
#[command(after_help = "\
Example: delay the messages between robot 2 and robot 1, which listens at 10.0.0.11, by 0.2 s in each direction
  dragnet relay 10.0.0.9:7140=10.0.0.11:7140 --delay 0.2 --rate 20000")]
pub(crate) struct Arguments {
    /// Addresses IP:PORT to listen at, and to connect to for each accepted connection
    #[arg(required = true, value_name = "LISTEN=TO", value_parser = parse_forward)]
    forwards: Vec<Forward>,
    /// Delay in each direction, seconds, 0 to 3600
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = parse_delay)]
    delay: f64,
    /// Maximum rate of each connection in each direction, bytes per second, 1 to 1e12 [default: unlimited]
    #[arg(long, value_name = "BYTES", value_parser = parse_rate)]
    rate: Option<f64>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let delay = Duration::from_secs_f64(arguments.delay);
    Ok(relay::run(&arguments.forwards, Quality { delay, bytes_per_second: arguments.rate })?)
}

fn parse_forward(text: &str) -> Result<Forward, String> {
    let (listen, to) =
        text.split_once('=').ok_or("allowed are two addresses, as 10.0.0.9:7140=10.0.0.11:7140")?;
    let address = |text: &str| {
        text.parse::<SocketAddr>()
            .map_err(|_| format!("{text:?} is no address; allowed are those like 10.0.0.9:7140"))
    };
    Ok(Forward { listen: address(listen)?, to: address(to)? })
}

fn parse_delay(text: &str) -> Result<f64, String> {
    number(text)
        .filter(|delay| (0.0..=3600.0).contains(delay))
        .ok_or("allowed are 0 to 3600 seconds".to_owned())
}

fn parse_rate(text: &str) -> Result<f64, String> {
    number(text)
        .filter(|rate| (1.0..=1e12).contains(rate))
        .ok_or("allowed are 1 to 1e12 bytes a second".to_owned())
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok()
}
