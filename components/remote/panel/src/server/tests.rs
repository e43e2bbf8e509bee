//! A panel for tests, without a server.

use super::{
    Arc, Audit, Clients, Engine, Epochs, Map, Mutex, Options, Panel, Pictures, Place, Pool,
    Security, Semaphore, Sessions, accounts, watch,
};
use clap::Parser as _;
use std::sync::OnceLock;

impl Panel {
    /// Returns a panel without a server, in a folder of its own, with the account ana and the engine's way.
    pub(crate) fn that(engine: Engine, name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("halpanel-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let people = folder.join("people");
        // The hash of a password takes its time: it is made once.
        static ANA: OnceLock<Vec<u8>> = OnceLock::new();
        let ana = ANA.get_or_init(|| {
            accounts::add(&people, "ana=operator", &mut &b"correct horse\n"[..]).unwrap();
            std::fs::read(&people).unwrap()
        });
        hal_output::install(&people, ana, 0o600).unwrap();
        let words =
            ["halpanel", "--role", "integrator", "--accounts"].map(std::ffi::OsString::from);
        let options = Options::parse_from(words.into_iter().chain([people.into_os_string()]));
        Self {
            address: options.listen,
            security: Security::open(&options).unwrap(),
            options,
            wiring: engine.clone(),
            engine,
            epochs: Epochs::default(),
            on_loss: 0.into(),
            machine: watch::channel(Arc::default()).1,
            sessions: Sessions::default(),
            clients: Clients::default(),
            heart: Arc::default(),
            audit: Audit::open(&folder.join("audit")).unwrap(),
            folders: super::Folders::default(),
            pool: Pool::default(),
            scopes: Arc::new(Semaphore::new(1)),
            pressing: Mutex::default(),
            pictures: Pictures::default(),
            place: Place::at(&folder, "test").unwrap(),
            is_inch: false,
            info: Map::new(),
            address_file: folder.join("address"),
        }
    }
}
