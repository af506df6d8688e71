//! `--live`: the page of a mission in a browser.

use std::io::{self, IsTerminal, Write};
use std::net::{IpAddr, SocketAddr};
use std::path::Path;
use std::process::{Command, Stdio};

use dragnet_live::page::{Page, PageError, Settings};
use dragnet_runtime::stop::{self, Bond};
use tempfile::NamedTempFile;

use super::{Failure, complain};

/// The default address of a page: this computer, any port.
pub(super) const ANYWHERE: &str = "127.0.0.1:0";

impl From<PageError> for Failure {
    fn from(error: PageError) -> Self {
        Self::input(error)
    }
}

/// An address and a port, or one of the two.
pub(super) fn parse_address(text: &str) -> Result<SocketAddr, String> {
    let address = text.parse::<SocketAddr>().ok();
    let ip = || text.parse::<IpAddr>().ok().map(|ip| SocketAddr::from((ip, 0)));
    let port = || text.parse::<u16>().ok().map(|port| SocketAddr::from(([127, 0, 0, 1], port)));
    address.or_else(ip).or_else(port).ok_or_else(|| {
        format!(
            "{text:?} is no address; allowed are such as 127.0.0.1:8080, 0.0.0.0:8080, [::1]:8080 and 8080"
        )
    })
}

/// Settings of a page at an address.
pub(super) fn settings(listen: SocketAddr, basemap: Option<&Path>) -> Settings {
    Settings { listen, token_file: None, basemap: basemap.map(Path::to_owned) }
}

/// A page whose address has been printed.
pub(super) struct Announced {
    page: Page,
    /// The file that leads a browser to the page; kept while the browser may read it.
    _door: Option<NamedTempFile>,
}

/// What the address of a mission's page is printed with.
pub(super) const LIVE_PAGE: &str = "live page";

/// Prints the page's address, and opens it in a browser if stdout is a terminal.
pub(super) fn announce(page: Page, what: &str) -> Announced {
    // If stderr is closed the address is not printed.
    let _ = writeln!(io::stderr(), "{what}: {}", page.address());
    let door = if io::stderr().is_terminal() { open(page.address()) } else { None };
    Announced { page, _door: door }
}

impl Announced {
    /// Serves the page until Ctrl-C, or until nobody reads what this program prints.
    pub(super) fn stay(self) {
        let _ = writeln!(io::stderr(), "the page stays at {} until Ctrl-C", self.page.address());
        self.page.serve_until(until_asked);
    }
}

/// Ready once the program is asked to stop, or nothing reads what it prints.
pub(super) async fn until_asked() {
    match stop::asked(Bond::Output) {
        Ok(asked) => asked.await,
        Err(error) => complain("error", &error.to_string()),
    }
}

/// The token must not be an argument, which every process of the computer can read: a browser is led to it by a file
/// that only this user can read.
fn open(address: &str) -> Option<NamedTempFile> {
    let mut door = NamedTempFile::with_suffix(".html").ok()?;
    let page = format!("<!doctype html><meta http-equiv=\"refresh\" content=\"0; url={address}\">");
    door.write_all(page.as_bytes()).ok()?;
    let mut command = Command::new("xdg-open");
    command.arg(door.path()).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().ok().map(|_| door)
}
