//! The instance as a service of systemd: messages to the socket that the service manager names, and its watchdog.
//!
//! The protocol is that of `sd_notify`: one datagram with lines `NAME=VALUE`. The watchdog is fed in a pass of the control
//! side, so that a control side that is held up feeds nothing, and only if the threads are [alive](Watch::is_alive).

use hal_engine::Engine;
use hal_protocol::{Kind, Link, Reply, Request, StatusInfo, ThreadInfo};
use rustix::time::{ClockId, clock_gettime};
use std::{
    collections::BTreeMap,
    ffi::{OsStr, OsString},
    os::{
        linux::net::SocketAddrExt,
        unix::{
            ffi::OsStrExt,
            net::{SocketAddr, UnixDatagram},
        },
    },
    path::Path,
};

/// Feedings within the time after which the service manager takes the service for dead.
const FEEDINGS: u64 = 4;

/// The connection to the service manager.
pub(super) struct Notifier {
    socket: UnixDatagram,
    address: SocketAddr,
    /// Nanoseconds between two feedings of the watchdog, if there is one.
    interval_ns: Option<u64>,
    next_ns: u64,
    watch: Watch,
    status: String,
}

impl Notifier {
    /// Returns the service manager that has started this process: `NOTIFY_SOCKET`, `WATCHDOG_USEC` and `WATCHDOG_PID` name it.
    pub(super) fn of_environment() -> Option<Self> {
        Self::of(&|name| std::env::var_os(name), std::process::id())
    }

    fn of(variable: &dyn Fn(&str) -> Option<OsString>, own: u32) -> Option<Self> {
        let address = address(&variable("NOTIFY_SOCKET")?)?;
        let socket = UnixDatagram::unbound().ok()?;
        // A manager that does not read holds up no control side.
        socket.set_nonblocking(true).ok()?;
        let number = |name: &str| variable(name)?.to_str()?.parse::<u64>().ok();
        let is_own = number("WATCHDOG_PID").is_none_or(|pid| pid == u64::from(own));
        let interval = number("WATCHDOG_USEC").filter(|usec| is_own && *usec > 0);
        let interval_ns = interval.map(|usec| (usec.saturating_mul(1000) / FEEDINGS).max(1));
        let (next_ns, watch, status) = (0, Watch::default(), String::new());
        Some(Self { socket, address, interval_ns, next_ns, watch, status })
    }

    /// Tells that the start is complete.
    pub(super) fn ready(&mut self, engine: &mut Engine, instance: &str) {
        self.status = format!("the machine runs as instance '{instance}'");
        self.send(&format!("READY=1\nSTATUS={}\n", self.status));
        self.pass(engine);
    }

    /// Tells that the instance ends.
    pub(super) fn stopping(&self) {
        self.send("STOPPING=1\nSTATUS=the instance ends\n");
    }

    /// Feeds the watchdog when it is time to, if all that the watchdog watches is alive.
    pub(super) fn pass(&mut self, engine: &mut Engine) {
        let Some(interval) = self.interval_ns else { return };
        let now = monotonic_ns();
        if now < self.next_ns {
            return;
        }
        self.next_ns = now.saturating_add(interval);
        let Ok(Reply::Status(status)) = engine.call(Request::Status) else { return };
        let threads = Request::List { kind: Kind::Threads, patterns: Vec::new(), ty: None };
        let Ok(Reply::Threads(threads)) = engine.call(threads) else { return };
        match self.watch.is_alive(now, &status, &threads) {
            Ok(()) => self.send("WATCHDOG=1\n"),
            Err(why) => {
                let said = format!("not fed: {why}");
                if said != self.status {
                    self.send(&format!("STATUS={said}\n"));
                    self.status = said;
                }
            }
        }
    }

    fn send(&self, text: &str) {
        // Without a manager that listens there is nobody to tell.
        drop(self.socket.send_to_addr(text.as_bytes(), &self.address));
    }
}

/// Returns the address of a socket: a path, or an abstract name behind `@`.
fn address(name: &OsStr) -> Option<SocketAddr> {
    match name.as_bytes().split_first()? {
        (b'@', rest) => SocketAddr::from_abstract_name(rest).ok(),
        (b'/', _) => SocketAddr::from_pathname(Path::new(name)).ok(),
        _ => None,
    }
}

fn monotonic_ns() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    let (s, ns) = (u64::try_from(now.tv_sec), u64::try_from(now.tv_nsec));
    s.unwrap_or(0).saturating_mul(1_000_000_000).saturating_add(ns.unwrap_or(0))
}

/// Reason why the watchdog is not fed.
#[derive(Debug, PartialEq, Eq)]
enum Dead {
    Failed { funct: Box<str>, cause: Box<str> },
    Stuck { funct: Box<str> },
    Idle { thread: Box<str> },
}

impl core::fmt::Display for Dead {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Failed { funct, cause } => write!(f, "function '{funct}' failed: {cause}"),
            Self::Stuck { funct } => write!(f, "function '{funct}' does not return"),
            Self::Idle { thread } => write!(f, "thread '{thread}' runs no cycle"),
        }
    }
}

impl core::error::Error for Dead {}

/// The last cycles of the threads.
#[derive(Debug, Default)]
struct Watch {
    /// Number of cycles of a thread, and the time at which it was first seen.
    cycles: BTreeMap<String, (u64, u64)>,
}

impl Watch {
    /// Returns whether the threads are alive: none has failed, none is stuck in a function, and on the real clock, while
    /// threads run their functions, each has run a cycle within two of its periods or since the last look, whichever is
    /// longer. Threads that were stopped on request, and a virtual clock that is held, are alive.
    fn is_alive(
        &mut self,
        now: u64,
        status: &StatusInfo,
        threads: &[ThreadInfo],
    ) -> Result<(), Dead> {
        if let Some(fault) = &status.fault {
            let (funct, cause) = (fault.funct.as_str().into(), fault.cause.as_str().into());
            return Err(Dead::Failed { funct, cause });
        }
        if let Some(stuck) = &status.stuck {
            return Err(Dead::Stuck { funct: stuck.funct.as_str().into() });
        }
        let is_due = status.running && status.clock == "real";
        let before = std::mem::take(&mut self.cycles);
        let mut result = Ok(());
        for thread in threads {
            let seen = before.get(&thread.name).filter(|(cycles, _)| *cycles == thread.cycles);
            let (_, since) = seen.copied().filter(|_| is_due).unwrap_or((thread.cycles, now));
            let patience = u64::try_from(thread.period).unwrap_or(0).saturating_mul(2);
            if since < now && now - since > patience {
                result = Err(Dead::Idle { thread: thread.name.as_str().into() });
            }
            self.cycles.insert(thread.name.clone(), (thread.cycles, since));
        }
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_engine::{ClockKind, Options};
    use hal_protocol::{FaultInfo, Place};

    fn parts() -> (StatusInfo, ThreadInfo) {
        let place = Place::at(std::env::temp_dir(), "service").unwrap();
        let mut engine =
            Engine::without_socket(Options::simulated(place, ClockKind::Virtual)).unwrap();
        let Ok(Reply::Status(mut status)) = engine.call(Request::Status) else { panic!() };
        (status.clock, status.running) = ("real".to_owned(), true);
        let thread = ThreadInfo {
            period: 1_000_000,
            name: "servo".to_owned(),
            fp: true,
            functs: Vec::new(),
            time: 0,
            tmax: 0,
            cycles: 5,
            overruns: 0,
            missed: 0,
            overrun_by: None,
            latency_max: 0,
            latency: Vec::new(),
        };
        (*status, thread)
    }

    #[test]
    fn only_what_is_alive_feeds() {
        let (mut status, mut thread) = parts();
        let mut watch = Watch::default();
        let second = 1_000_000_000;
        let mut look = |at: u64, status: &StatusInfo, thread: &ThreadInfo| {
            let looked = watch.is_alive(at, status, std::slice::from_ref(thread));
            looked.map_err(|why| why.to_string())
        };
        assert_eq!(look(second, &status, &thread), Ok(()));
        thread.cycles = 6;
        assert_eq!(look(2 * second, &status, &thread), Ok(()));
        // No cycle in a second; then cycles again.
        let none = Err("thread 'servo' runs no cycle".to_owned());
        assert_eq!(look(3 * second, &status, &thread), none);
        assert_eq!(look(4 * second, &status, &thread), none);
        thread.cycles = 7;
        assert_eq!(look(5 * second, &status, &thread), Ok(()));
        // A slow thread has two of its periods.
        thread.period = second.cast_signed();
        assert_eq!(look(7 * second, &status, &thread), Ok(()));
        assert_eq!(look(7 * second + 1, &status, &thread), none);
        // Stopped on request, or on the virtual clock.
        status.running = false;
        assert_eq!(look(20 * second, &status, &thread), Ok(()));
        status.running = true;
        assert_eq!(look(21 * second, &status, &thread), Ok(()));
        assert_eq!(look(23 * second + 1, &status, &thread), none);
        status.clock = "virtual".to_owned();
        assert_eq!(look(30 * second, &status, &thread), Ok(()));
        let fault = FaultInfo {
            component: "pid".to_owned(),
            funct: "pid.0".to_owned(),
            thread: "servo".to_owned(),
            cause: "it panicked".to_owned(),
        };
        status.stuck = Some(fault.clone());
        let said = Err("function 'pid.0' does not return".to_owned());
        assert_eq!(look(31 * second, &status, &thread), said);
        status.fault = Some(fault);
        let said = Err("function 'pid.0' failed: it panicked".to_owned());
        assert_eq!(look(32 * second, &status, &thread), said);
    }

    #[test]
    fn the_manager_hears_of_start_life_and_end() {
        let folder = std::env::temp_dir().join(format!("ferrule-notify-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("socket");
        let manager = UnixDatagram::bind(&path).unwrap();
        manager.set_nonblocking(true).unwrap();
        let hear = || {
            let mut bytes = [0; 1024];
            manager.recv(&mut bytes).map_or_else(
                |_| String::new(),
                |n| String::from_utf8_lossy(bytes.get(..n).unwrap()).into_owned(),
            )
        };
        let place = Place::at(&folder, "service").unwrap();
        let mut engine =
            Engine::without_socket(Options::simulated(place, ClockKind::Virtual)).unwrap();
        let service = |usec: &str, pid: &str| {
            let set = [
                ("NOTIFY_SOCKET", path.to_str().unwrap()),
                ("WATCHDOG_USEC", usec),
                ("WATCHDOG_PID", pid),
            ];
            let variable = |name: &str| {
                let found = set.iter().find(|(n, value)| *n == name && !value.is_empty());
                found.map(|(_, value)| OsString::from(value))
            };
            Notifier::of(&variable, 7)
        };
        let ready = "READY=1\nSTATUS=the machine runs as instance 'mill'\n";
        for (usec, pid, feeds) in
            [("1", "7", true), ("1", "", true), ("1", "8", false), ("", "7", false)]
        {
            let mut service = service(usec, pid).unwrap();
            service.ready(&mut engine, "mill");
            assert_eq!(hear(), ready);
            assert_eq!(hear(), if feeds { "WATCHDOG=1\n" } else { "" }, "{usec} {pid}");
            service.stopping();
            assert_eq!(hear(), "STOPPING=1\nSTATUS=the instance ends\n");
        }
        // Within the interval it is fed once.
        let mut service = service("60000000", "7").unwrap();
        service.ready(&mut engine, "mill");
        service.pass(&mut engine);
        assert_eq!(
            (hear(), hear(), hear()),
            (ready.to_owned(), "WATCHDOG=1\n".to_owned(), String::new())
        );
        // Names that are no addresses, and nobody at one.
        for name in ["", "relative", "@"] {
            let variable = |n: &str| (n == "NOTIFY_SOCKET").then(|| OsString::from(name));
            assert!(Notifier::of(&variable, 7).is_none_or(|_| name == "@"), "{name}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
        service.stopping();
        engine.close();
    }
}
