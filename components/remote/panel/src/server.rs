//! The server: what it needs before it listens, and its connections.

mod places;
mod wire;

use crate::{
    accounts,
    audit::Audit,
    commands::LOSSES,
    engine::Engine,
    epoch::Epochs,
    folders::Folders,
    heart::{self, Heart},
    http::{self, pictures::Pictures},
    info,
    lease::Clients,
    limits::Peer,
    options::Options,
    pool::{MAX_SEATS, Pool},
    private, scope,
    security::Security,
    session::{Sessions, secret},
    status,
    teleop::{self, Teleop},
};
use axum::Router;
use hal_ini::Ini;
use hal_protocol::{Place, Reply, Request as HalRequest};
use hyper::{
    Request,
    body::Incoming,
    server::conn::http1,
    service::{Service as _, service_fn},
};
use hyper_util::{
    rt::{TokioIo, TokioTimer},
    service::TowerToHyperService,
};
use places::Places;
use serde_json::{Map, Value as Json};
use std::{
    io,
    net::SocketAddr,
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering::Relaxed},
    },
    time::Duration,
};
use tokio::{
    io::{AsyncRead, AsyncWrite},
    net::TcpListener,
    runtime,
    signal::unix::{Signal, SignalKind, signal},
    sync::{Mutex, Semaphore, watch},
    task::{block_in_place, spawn_blocking},
    time::timeout,
};
use tokio_rustls::TlsAcceptor;
use wire::Wire;

pub(crate) use wire::SendBuffer;

/// Number of connections; more wait until one ends.
const MAX_CONNECTIONS: usize = 1024;
/// Longest time that a client may take for the head of a request.
pub(crate) const HEAD_TIME: Duration = Duration::from_secs(10);
/// Longest head of a request in bytes.
const MAX_HEAD: usize = 32 << 10;
/// Number of threads for work that waits: one for each seat, and some for files and tables of the system. Each leaves memory
/// behind, and goes when it has nothing to do for a while.
const MAX_THREADS: usize = MAX_SEATS + 16;
const IDLE_THREAD: Duration = Duration::from_secs(2);
/// Wait after the system has refused a connection.
const REFUSED: Duration = Duration::from_millis(100);

/// Everything that requests share.
#[derive(Debug)]
pub(crate) struct Panel {
    /// Address of the server.
    pub(crate) address: SocketAddr,
    /// Accounts, certificate and names of the server.
    pub(crate) security: Security,
    /// Options of the program.
    pub(crate) options: Options,
    /// Instance of the engine.
    pub(crate) place: Place,
    /// The way to the engine for all who have signed in.
    pub(crate) engine: Engine,
    /// The way to it for links that this program makes by itself.
    pub(crate) wiring: Engine,
    /// The stop epoch of motion.
    pub(crate) epochs: Epochs,
    /// Place in [`LOSSES`] of what becomes of the job in progress, or of the next one, when its lease is lost.
    pub(crate) on_loss: AtomicUsize,
    /// State of the machine.
    pub(crate) machine: watch::Receiver<Arc<status::Machine>>,
    /// Sessions of all who have signed in.
    pub(crate) sessions: Sessions,
    /// Clients of the socket, and the lease.
    pub(crate) clients: Clients,
    /// Pulses and beats.
    pub(crate) heart: Arc<Heart>,
    /// Log of what has been done.
    pub(crate) audit: Audit,
    /// Folders of programs, uploads and output.
    pub(crate) folders: Folders,
    /// Work for those who look.
    pub(crate) pool: Pool,
    /// Places of scopes.
    pub(crate) scopes: Arc<Semaphore>,
    /// Kept while a tool change is answered: the button is linked for one answer.
    pub(crate) pressing: Mutex<()>,
    /// Pictures and state of the component align.
    pub(crate) pictures: Pictures,
    /// True if the machine's unit of length is the inch.
    pub(crate) is_inch: bool,
    /// Description of the machine.
    pub(crate) info: Map<String, Json>,
    /// File with the address and the one-time token.
    pub(crate) address_file: PathBuf,
}

impl Panel {
    /// Notes what the plugin `remote` says it will do with the job that begins, when its lease is lost.
    pub(crate) fn note_loss(&self, lines: &[String]) {
        if let Some(loss) = loss_of(lines) {
            self.on_loss.store(loss, Relaxed);
        }
    }

    /// Writes a new one-time token into the file with the address.
    pub(crate) fn renew_token(&self) -> Result<(), String> {
        let token = secret()?;
        let text = format!("{}/#token={token}\n", self.security.origin(self.address));
        // The token in the file is always one that is accepted.
        self.sessions.set_token(token);
        let written =
            block_in_place(|| hal_output::install(&self.address_file, text.as_bytes(), 0o600));
        let file = self.address_file.display();
        written.map_err(|e| format!("{file}: {}", hal_output::reason(&e)))
    }
}

/// Serves the instance until it ends or a signal comes.
///
/// # Errors
/// An instance, a file or the address is missing or unusable.
pub fn run(options: &Options) -> Result<(), String> {
    let ini = options.ini_file.as_deref().map(read_ini).transpose()?;
    if options.prepare {
        let place = Place::find(options.instance.as_deref())?;
        let loaded = hal_lease::load(&place, ini.as_ref(), "halpanel");
        return loaded.map_err(|why| why.to_string());
    }
    let folders = Folders::find(options, ini.as_ref())?;
    let options = &private::placed(options, &folders)?;
    if let (Some(account), Some(file)) = (&options.add_account, &options.accounts) {
        return accounts::add(file, account, &mut io::stdin().lock());
    }
    let security = Security::open(options)?;
    let settings = teleop::Settings::read(options, ini.as_ref())?;
    let teleop = settings.address;
    Security::check_needs(teleop.unwrap_or(teleop::ADDRESS), options)?;
    let place = Place::find(options.instance.as_deref())?;
    let is_inch = ini.as_ref().is_some_and(|ini| ini.is_inch().unwrap_or(false));
    let mut info = info::info(place.name(), ini.as_ref(), is_inch);
    let runtime = runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .max_blocking_threads(MAX_THREADS)
        .thread_keep_alive(IDLE_THREAD)
        .enable_all()
        .build();
    let runtime = runtime.map_err(|e| hal_output::reason(&e))?;
    runtime.block_on(async {
        // Before anybody learns that the panel is there.
        let signals = Signals::new().map_err(|e| hal_output::reason(&e))?;
        let listener = TcpListener::bind(options.listen).await;
        let listener =
            listener.map_err(|e| format!("{}: {}", options.listen, hal_output::reason(&e)))?;
        let address = listener.local_addr().map_err(|e| hal_output::reason(&e))?;
        let beside = |kind: &str| place.folder().join(format!("panel-{}.{kind}", place.name()));
        let audit = options.audit.clone().unwrap_or_else(|| beside("audit"));
        let audit = Audit::open(&audit)?;
        let teleop_port = teleop.unwrap_or(teleop::ADDRESS).port();
        hal_lease::load(&place, ini.as_ref(), "halpanel").map_err(|why| why.to_string())?;
        let engine = Engine::join(&place).map_err(|why| why.to_string())?;
        let on_loss = on_loss(&engine).await;
        info.insert("on_loss".to_owned(), Json::from(LOSSES.get(on_loss).copied()));
        let address_file = options.address_file.clone().unwrap_or_else(|| beside("url"));
        let panel = Arc::new(Panel {
            address,
            security,
            options: options.clone(),
            engine,
            wiring: Engine::join_for_wiring(&place).map_err(|why| why.to_string())?,
            epochs: Epochs::open(&place),
            on_loss: on_loss.into(),
            machine: status::observe(&place)?,
            sessions: Sessions::default(),
            clients: Clients::default(),
            heart: heart::start(&place, (teleop.is_some(), teleop_port))?,
            audit,
            folders,
            pool: Pool::default(),
            scopes: Arc::new(Semaphore::new(scope::MAX_SCOPES)),
            pressing: Mutex::default(),
            pictures: Pictures::default(),
            place,
            is_inch,
            info,
            address_file,
        });
        panel.renew_token()?;
        // A picture of another run is none of now.
        drop(std::fs::remove_file(panel.view_file()));
        let file = panel.address_file.display();
        let fingerprint = panel.security.tls.as_ref().map(|tls| {
            format!("the certificate has the SHA-256 fingerprint {}\n", tls.fingerprint)
        });
        let fingerprint = fingerprint.unwrap_or_default();
        hal_output::print(&format!(
            "listening at {address}; the address to open is in {file}\n{fingerprint}"
        ))
        .map_err(|e| e.to_string())?;
        let router = http::router(&panel);
        let tls = panel.security.tls.as_ref().map(|tls| tls.acceptor.clone());
        let teleop = Teleop::start(&panel, settings);
        let served = serve(&listener, &router, tls.as_ref(), signals).await;
        teleop.stop().await;
        // Without the file nobody opens an address that is gone.
        drop(std::fs::remove_file(&panel.address_file));
        drop(std::fs::remove_file(panel.view_file()));
        served
    })
}

/// Returns the place in [`LOSSES`] of what the plugin `remote` does with a job whose start says nothing.
async fn on_loss(engine: &Engine) -> usize {
    let status = HalRequest::Command { name: "remote.status".to_owned(), args: Vec::new() };
    match engine.call(status).await {
        Ok(Reply::Answer(answer)) => loss_of(&answer.lines).unwrap_or(0),
        _ => 0,
    }
}

/// Returns the place in [`LOSSES`] of what the plugin `remote` says it does with a job.
fn loss_of(lines: &[String]) -> Option<usize> {
    let words = lines.iter().flat_map(|line| line.split(' '));
    let said = words.filter_map(|word| word.strip_prefix("on-loss=")).next();
    LOSSES.iter().position(|loss| Some(*loss) == said)
}

fn read_ini(path: &Path) -> Result<Ini, String> {
    Ini::read(path).map_err(|e| e.to_string())
}

/// Signals that end the program.
struct Signals {
    end: Signal,
    interrupt: Signal,
}

impl Signals {
    /// Takes the signals from now on.
    fn new() -> io::Result<Self> {
        Ok(Self {
            end: signal(SignalKind::terminate())?,
            interrupt: signal(SignalKind::interrupt())?,
        })
    }
}

/// Accepts connections until a signal ends the program.
async fn serve(
    listener: &TcpListener,
    router: &Router,
    tls: Option<&TlsAcceptor>,
    mut signals: Signals,
) -> Result<(), String> {
    let address = listener.local_addr().map_err(|e| hal_output::reason(&e))?;
    let (room, places) = (Arc::new(Semaphore::new(MAX_CONNECTIONS)), Places::default());
    loop {
        let next = async {
            let permit = room.clone().acquire_owned().await;
            (permit, listener.accept().await)
        };
        tokio::select! {
            (permit, accepted) = next => match accepted {
                Ok((stream, theirs)) => {
                    let (router, tls) = (router.clone(), tls.cloned());
                    let ours = stream.local_addr().unwrap_or(address);
                    let peer = Peer { theirs, ours };
                    let places = places.clone();
                    tokio::spawn(async move {
                        // Tables of the system are read beside the threads that serve requests.
                        let Ok(source) = spawn_blocking(move || peer.source()).await else { return };
                        let Some(place) = places.take(source) else { return };
                        // Without it, small messages wait for the answer to the one before.
                        drop(stream.set_nodelay(true));
                        let (wire, send_buffer) = Wire::new(stream);
                        match tls {
                            None => connection(wire, send_buffer, peer, router).await,
                            Some(tls) => {
                                if let Ok(Ok(wire)) = timeout(HEAD_TIME, tls.accept(wire)).await {
                                    connection(wire, send_buffer, peer, router).await;
                                }
                            }
                        }
                        drop((permit, place));
                    });
                }
                // Too many open files, or a client that has gone meanwhile.
                Err(_) => tokio::time::sleep(REFUSED).await,
            },
            _ = signals.end.recv() => return Ok(()),
            _ = signals.interrupt.recv() => return Ok(()),
        }
    }
}

async fn connection<S>(stream: S, send_buffer: SendBuffer, peer: Peer, router: Router)
where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let router = TowerToHyperService::new(router);
    let service = service_fn(move |mut request: Request<Incoming>| {
        request.extensions_mut().insert(send_buffer.clone());
        request.extensions_mut().insert(peer);
        router.call(request)
    });
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(HEAD_TIME).max_buf_size(MAX_HEAD);
    let served = http.serve_connection(TokioIo::new(stream), service).with_upgrades().await;
    // A client that has gone needs no answer.
    drop(served);
}

#[cfg(test)]
mod tests;
