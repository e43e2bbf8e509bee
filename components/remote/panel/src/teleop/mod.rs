//! Teleoperation: the server of the line protocol (`../../teleop/PROTOCOL.md`), which clients speak over TCP.

mod check;
mod connection;
mod job;
mod service;
mod settings;
mod sign_in;

use crate::server::Panel;
use service::Service;
pub(crate) use settings::Settings;
use std::{
    io::Write as _,
    net::{IpAddr, Ipv4Addr, SocketAddr},
    sync::{Arc, atomic::Ordering::Relaxed},
    time::Duration,
};
use tokio::{
    net::TcpListener,
    sync::watch,
    task::JoinHandle,
    time::{sleep, timeout},
};

/// Address where nothing states another: the document's port, on this computer alone.
pub(crate) const ADDRESS: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 2000);
/// Time between two looks at the pins.
const LOOK: Duration = Duration::from_millis(20);
/// Longest time until a server has stopped: a job brakes first.
const STOP_TIME: Duration = Duration::from_secs(30);

/// The server, which starts and stops as the pin `teleop.serve` says.
#[derive(Debug)]
pub(crate) struct Teleop {
    ends: watch::Sender<bool>,
    work: JoinHandle<()>,
}

impl Teleop {
    /// Begins to look at the pin.
    pub(crate) fn start(panel: &Arc<Panel>, settings: Settings) -> Self {
        let (ends, end) = watch::channel(false);
        let work = tokio::spawn(supervise(panel.clone(), settings, end));
        Self { ends, work }
    }

    /// Stops the server: cancels the job of a client, and informs every client.
    pub(crate) async fn stop(self) {
        self.ends.send_replace(true);
        drop(timeout(STOP_TIME, self.work).await);
    }
}

/// Starts and stops the server until this program ends.
async fn supervise(panel: Arc<Panel>, settings: Settings, end: watch::Receiver<bool>) {
    let address = settings.address.unwrap_or(ADDRESS);
    let pins = &panel.heart.teleop;
    let mut refused = false;
    while !*end.borrow() {
        let wanted = pins.serve.load(Relaxed);
        if !wanted {
            refused = false;
        } else if !refused {
            match listen(&panel, address).await {
                Ok(listener) => {
                    let is_network = !address.ip().is_loopback();
                    Service::new(&panel, is_network, settings.clone()).run(&listener, &end).await;
                }
                Err(why) => {
                    refused = true;
                    pins.refused.store(true, Relaxed);
                    // Without standard error there is nowhere else to say it.
                    drop(writeln!(std::io::stderr(), "halpanel: teleoperation: {why}"));
                }
            }
        }
        sleep(LOOK).await;
    }
}

/// Listens at the address, and the port of the pin `teleop.port`.
async fn listen(panel: &Panel, mut address: SocketAddr) -> Result<TcpListener, String> {
    let port = panel.heart.teleop.port.load(Relaxed);
    let port = u16::try_from(port)
        .map_err(|_| format!("teleop.port is {port}, must be 0 to {}", u16::MAX))?;
    address.set_port(port);
    let why = |e: std::io::Error| format!("{address}: {}", hal_output::reason(&e));
    let listener = TcpListener::bind(address).await.map_err(why)?;
    let local = listener.local_addr().map_err(why)?;
    panel.heart.teleop.listening.store(local.port().into(), Relaxed);
    hal_output::print(&format!("teleoperation listens at {local}\n")).map_err(|e| e.to_string())?;
    Ok(listener)
}
