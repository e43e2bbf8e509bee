//! Connections of a driver: to a controller over TCP, and to the simulated one.

use crate::{Controller, Driver, Faults, Output, Volume, Zero};
use std::{
    io::{ErrorKind, Read as _, Write as _},
    net::{Shutdown, TcpStream, ToSocketAddrs as _},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        mpsc::{Receiver, SendError, TryRecvError, channel},
    },
    time::Duration,
};

/// Longest time for bytes to leave.
const WRITE: Duration = Duration::from_secs(1);
/// Largest number of events of the simulation in one step.
const MAX_EVENTS: u32 = 100_000;

/// Checks that a text is `HOST:PORT`, without looking the host up.
///
/// # Errors
/// The text is something else.
pub fn check_address(text: &str) -> Result<(), String> {
    let is_host = |host: &str| {
        let is_usual = |c: char| c.is_ascii_alphanumeric() || ".-_:[]".contains(c);
        (1..=253).contains(&host.len()) && host.chars().all(is_usual)
    };
    let parts = text.rsplit_once(':').filter(|(host, _)| is_host(host));
    match parts.and_then(|(_, port)| port.parse::<u16>().ok()) {
        Some(port) if port != 0 => Ok(()),
        _ => Err("must be HOST:PORT, such as 192.168.47.5:55000".to_owned()),
    }
}

/// Connects to `HOST:PORT`, which takes at most `longest`.
///
/// # Errors
/// There is no such address, or nobody accepts there; the text names the address.
pub fn connect(to: &str, longest: Duration) -> Result<TcpStream, String> {
    let refused = |e: std::io::Error| format!("{to}: {}", hal_output::reason(&e));
    let address = to.to_socket_addrs().map_err(refused)?.next();
    let address = address.ok_or_else(|| format!("{to}: no such address"))?;
    let stream = TcpStream::connect_timeout(&address, longest).map_err(refused)?;
    stream.set_nodelay(true).map_err(refused)?;
    Ok(stream)
}

/// Connection that a thread makes. Aborted, it ends with EXIT, whenever it comes: a controller that accepts it would move the
/// robot.
#[derive(Debug)]
pub struct TcpOpening {
    is_given_up: Arc<Mutex<bool>>,
    opened: Receiver<Result<TcpLink, String>>,
}

impl TcpOpening {
    /// Begins to connect as [`TcpLink::connect`] does.
    ///
    /// # Errors
    /// The operating system has no thread.
    pub fn begin(to: &str, longest: Duration, tick: Duration) -> Result<Self, String> {
        let (send, opened) = channel();
        let is_given_up = Arc::new(Mutex::new(false));
        let (to, flag) = (to.to_owned(), is_given_up.clone());
        let connect = move || {
            let link = TcpLink::connect(&to, longest, tick);
            // Either the flag is seen here, or who sets it finds the connection.
            let is_given_up = lock(&flag);
            match link {
                Ok(link) if *is_given_up => link.exit(),
                link => {
                    if let Err(SendError(Ok(link))) = send.send(link) {
                        link.exit();
                    }
                }
            }
        };
        std::thread::Builder::new()
            .name("robot".to_owned())
            .spawn(connect)
            .map_err(|e| hal_output::reason(&e))?;
        Ok(Self { is_given_up, opened })
    }

    /// Returns the connection once it is made, or why there is none. Aborted, it returns nothing: the caller that has set
    /// the [`flag`](Self::flag) knows the reason.
    pub fn poll(&self) -> Option<Result<TcpLink, String>> {
        match self.opened.try_recv() {
            Ok(end) => Some(end),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) if *lock(&self.is_given_up) => None,
            Err(TryRecvError::Disconnected) => {
                Some(Err("the thread that connects has ended".to_owned()))
            }
        }
    }

    /// Returns the flag that gives the connection up; its thread lets it go when it ends.
    #[must_use]
    pub const fn flag(&self) -> &Arc<Mutex<bool>> {
        &self.is_given_up
    }
}

impl Drop for TcpOpening {
    fn drop(&mut self) {
        *lock(&self.is_given_up) = true;
        if let Ok(Ok(link)) = self.opened.try_recv() {
            link.exit();
        }
    }
}

/// Returns what a mutex holds, whatever happened to another holder.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Connection over TCP.
#[derive(Debug)]
pub struct TcpLink {
    stream: Arc<TcpStream>,
}

impl TcpLink {
    /// Connects as [`connect`] does. An exchange then waits at most `tick`.
    ///
    /// # Errors
    /// Those of [`connect`].
    pub fn connect(to: &str, longest: Duration, tick: Duration) -> Result<Self, String> {
        let refused = |e: std::io::Error| format!("{to}: {}", hal_output::reason(&e));
        let stream = connect(to, longest)?;
        stream.set_read_timeout(Some(tick)).map_err(refused)?;
        stream.set_write_timeout(Some(WRITE)).map_err(refused)?;
        Ok(Self { stream: Arc::new(stream) })
    }

    /// Ends the connection: the robot stops at once.
    pub fn exit(self) {
        // A controller that does not read has lost its client.
        drop((&*self.stream).write_all(b"EXIT\r\n"));
    }

    /// Returns the socket.
    #[must_use]
    pub const fn stream(&self) -> &Arc<TcpStream> {
        &self.stream
    }

    /// Sends what the driver has to send, waits at most a tick for bytes, and passes them to the driver. Returns whether
    /// bytes came.
    pub fn exchange(&mut self, driver: &mut Driver, now: impl Fn() -> f64) -> bool {
        self.send(driver);
        let mut buffer = [0; 256];
        let mut came = false;
        match (&*self.stream).read(&mut buffer) {
            Ok(0) => driver.disconnected(),
            Ok(count) => {
                came = true;
                driver.receive(buffer.get(..count).unwrap_or_default(), now());
            }
            Err(e) if is_patient(&e) => {}
            Err(_) => driver.disconnected(),
        }
        driver.poll(now());
        self.send(driver);
        came
    }

    /// Sends what the driver has to send.
    pub fn send(&mut self, driver: &mut Driver) {
        let bytes = driver.output();
        if !bytes.is_empty() && (&*self.stream).write_all(&bytes).is_err() {
            driver.disconnected();
        }
    }
}

impl Drop for TcpLink {
    fn drop(&mut self) {
        // What was sent before arrives; a socket that is closed already makes no difference.
        drop(self.stream.shutdown(Shutdown::Write));
    }
}

/// Returns whether an error of a read says that there are no bytes yet.
#[must_use]
pub(crate) fn is_patient(e: &std::io::Error) -> bool {
    matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}

/// Connection to a simulated controller. Times are in seconds and never decrease.
#[derive(Debug)]
pub struct SimulatedLink {
    controller: Controller,
    is_up: bool,
    now: f64,
}

impl SimulatedLink {
    /// Returns a controller without a client, whose tool touches the part zero.
    #[must_use]
    pub fn new(volume: Volume, zero: Zero, seed: u64) -> Self {
        let faults = Faults { seed, ..Faults::default() };
        Self { controller: Controller::new(volume, zero, faults), is_up: false, now: 0.0 }
    }

    /// Returns the controller.
    #[must_use]
    pub const fn controller(&self) -> &Controller {
        &self.controller
    }

    /// Returns the controller, to teach a part zero and to set faults.
    pub const fn controller_mut(&mut self) -> &mut Controller {
        &mut self.controller
    }

    /// Connects the driver.
    pub fn connect(&mut self, driver: &mut Driver, now: f64) {
        if self.is_up || self.controller.connect(now).is_some() {
            return;
        }
        driver.connected(now);
        (self.is_up, self.now) = (true, now);
    }

    /// Ends the connection: the robot stops, and the driver notes it.
    pub fn cut(&mut self, driver: &mut Driver, now: f64) {
        if self.is_up {
            self.is_up = false;
            self.controller.disconnect(now);
            driver.disconnected();
        }
    }

    /// Advances both ends to a time, event by event.
    pub fn exchange(&mut self, driver: &mut Driver, now: f64) {
        for _ in 0..MAX_EVENTS {
            self.send(driver);
            let due = [self.controller.next(), driver.next()].into_iter().flatten();
            let Some(due) = due.reduce(f64::min).filter(|due| *due <= now) else { break };
            self.now = f64::max(self.now, due);
            self.poll(driver);
        }
        self.now = f64::max(self.now, now);
        self.send(driver);
    }

    /// Sends what the driver has to send, at the time of the last exchange.
    pub fn send(&mut self, driver: &mut Driver) {
        let bytes = driver.output();
        if self.is_up && !bytes.is_empty() {
            self.controller.receive(&bytes, self.now);
        }
    }

    /// Sends what the driver has to send at a time, and lets the controller act on it: after EXIT it waits for a client.
    pub fn end(&mut self, driver: &mut Driver, now: f64) {
        self.now = f64::max(self.now, now);
        self.exchange(driver, self.now);
    }

    fn poll(&mut self, driver: &mut Driver) {
        for output in self.controller.poll(self.now) {
            match output {
                Output::Bytes(bytes) if self.is_up => driver.receive(&bytes, self.now),
                Output::Bytes(_) => {}
                Output::Close => {
                    self.is_up = false;
                    driver.disconnected();
                }
            }
        }
        driver.poll(self.now);
    }
}
