//! `ferrule start`: an instance, and the panel beside it, for as long as the instance runs.

use crate::{beside, failure::Failure, options::Start, restore};
use hal_ini::Ini;
use hal_protocol::{Client, Link as _, Place, Reply, Request};
use rustix::{
    event::{Timespec, poll},
    process::{Pid, Signal, kill_process},
};
use signal_hook::{consts, flag};
use std::{
    fs,
    io::{self, Write as _},
    net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener},
    os::unix::process::CommandExt as _,
    path::{Path, PathBuf},
    process::{Child, Command, ExitCode, ExitStatus, Stdio},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
};

/// Time between two looks at the programs.
const LOOK: Timespec = Timespec { tv_sec: 0, tv_nsec: 20_000_000 };
/// Address of the panel where nothing else is said, as halpanel has it.
const USUAL: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 7776);

/// Program that starts the panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Panel {
    /// This program.
    Ours,
    /// The instance, since its INI file names the panel as its interface.
    OfIni,
}

/// Starts the machine, and returns when it has ended.
pub(crate) fn start(given: &Start) -> Result<ExitCode, Failure> {
    if !given.machine.is_file() {
        return Err(Failure::NoMachine { path: given.machine.clone() });
    }
    let place =
        Place::find(given.instance.as_deref()).map_err(|why| Failure::Instance(why.into()))?;
    if Client::connect(&place, "").is_ok() {
        return Err(Failure::Runs { name: place.name().into() });
    }
    let is_ini = given.machine.extension().is_some_and(|e| e == "ini");
    let ini = is_ini.then(|| Ini::read(&given.machine)).transpose()?;
    let shown = ini.as_ref().filter(|_| !given.is_virtual).and_then(interface);
    let panel = if shown.as_deref() == Some("halpanel") { Panel::OfIni } else { Panel::Ours };
    if panel == Panel::OfIni {
        let option = [
            ("--role", given.role.is_some()),
            ("--listen", given.listen.is_some()),
            ("--accounts", given.accounts.is_some()),
            ("--certificate", given.certificate.is_some()),
            ("--name", !given.name.is_empty()),
            ("--programs", given.programs.is_some()),
        ];
        if let Some((option, _)) = option.into_iter().find(|(_, is_given)| *is_given) {
            return Err(Failure::PanelOfIni { option });
        }
    }
    for failure in restore::keep_description(&given.machine) {
        // Without standard error there is nowhere to say it.
        drop(writeln!(
            io::stderr(),
            "ferrule: the state of the machine's files cannot be kept: {failure}"
        ));
    }
    let ending = ending()?;
    let address_file = place.folder().join(format!("panel-{}.url", place.name()));
    // An address that a killed panel has left behind is not this one's.
    drop(fs::remove_file(&address_file));
    let mut instance =
        Running::begin("halrun", &mut instance_command(given, shown.as_deref(), panel)?)?;
    if !come_up(&place, &mut instance, &ending)? {
        return instance.stop();
    }
    let mut own = match panel {
        Panel::OfIni => None,
        Panel::Ours => Some(Running::begin("halpanel", &mut panel_command(given, is_ini)?)?),
    };
    let mut told = false;
    loop {
        if instance.ended()?.is_some() || ending.load(Relaxed) {
            if let Some(panel) = own {
                panel.stop()?;
            }
            return instance.stop();
        }
        if let Some(panel) = &mut own
            && let Some(status) = panel.ended()?
        {
            instance.stop()?;
            return Err(Failure::Ended { name: "halpanel", status: status.to_string().into() });
        }
        if !told && address_file.is_file() {
            tell(given, &address_file)?;
            told = true;
        }
        wait();
    }
}

/// Returns the program that the INI file names as its interface, without its folder.
fn interface(ini: &Ini) -> Option<String> {
    let entry = ini.all("DISPLAY", "DISPLAY").find(|entry| !entry.value.is_empty())?;
    let program = entry.value.split_whitespace().next()?;
    Some(Path::new(program).file_name()?.to_string_lossy().into_owned())
}

fn instance_command(given: &Start, shown: Option<&str>, panel: Panel) -> Result<Command, Failure> {
    let mut command = beside::command("halrun")?;
    if given.is_virtual {
        command.args(["--virtual", "--pace", "1", "--healthy"]);
    }
    if given.simulate {
        command.arg("--simulate");
    }
    if let Some(names) = &given.stub {
        command.arg("--stub").arg(names);
    }
    // The panel is the screen: files that wire the pins of another one would fail.
    if shown.is_some() && panel == Panel::Ours {
        command.arg("--headless");
    }
    if let Some(name) = &given.instance {
        command.arg("--instance").arg(name);
    }
    command.arg("--").arg(&given.machine);
    Ok(command)
}

fn panel_command(given: &Start, is_ini: bool) -> Result<Command, Failure> {
    let mut command = beside::command("halpanel")?;
    let listen = given.listen.unwrap_or_else(|| free(USUAL));
    command.arg("--listen").arg(listen.to_string());
    if let Some(name) = &given.instance {
        command.arg("--instance").arg(name);
    }
    if is_ini {
        command.arg("--ini-file").arg(&given.machine);
    }
    let files = [
        ("--accounts", &given.accounts),
        ("--certificate", &given.certificate),
        ("--programs", &given.programs),
    ];
    for (option, file) in files {
        if let Some(file) = file {
            command.arg(option).arg(file);
        }
    }
    if let Some(role) = &given.role {
        command.arg("--role").arg(role);
    }
    for name in &given.name {
        command.arg("--name").arg(name);
    }
    // What it says to a person is said below; what goes wrong comes on standard error.
    if given.listen.is_none() {
        command.stdout(Stdio::null());
    }
    Ok(command)
}

/// Returns the address, or one with a free port where another panel has it.
fn free(usual: SocketAddr) -> SocketAddr {
    let is_free = TcpListener::bind(usual).is_ok();
    if is_free { usual } else { SocketAddr::new(usual.ip(), 0) }
}

/// Takes the signals that end a program: the flag says that one has come.
pub(crate) fn ending() -> Result<Arc<AtomicBool>, Failure> {
    let ending = Arc::new(AtomicBool::new(false));
    for signal in [consts::SIGINT, consts::SIGTERM, consts::SIGHUP] {
        flag::register(signal, Arc::clone(&ending))
            .map_err(|error| Failure::Signals(hal_output::reason(&error).into()))?;
    }
    Ok(ending)
}

/// Waits until the machine's script is done. Returns false if the instance has ended, or is to end, before that.
pub(crate) fn come_up(
    place: &Place,
    instance: &mut Running,
    ending: &AtomicBool,
) -> Result<bool, Failure> {
    let mut client = None;
    loop {
        if instance.ended()?.is_some() || ending.load(Relaxed) {
            return Ok(false);
        }
        client = client.or_else(|| Client::connect(place, "ferrule").ok());
        let status = client.as_mut().and_then(|client| client.call(Request::Status).ok());
        match status {
            Some(Reply::Status(status)) if !status.starting => return Ok(true),
            Some(_) => {}
            None => client = None,
        }
        wait();
    }
}

/// Waits for the next look at the programs, or for a signal.
pub(crate) fn wait() {
    poll(&mut [], Some(&LOOK)).unwrap_or_default();
}

/// Says where the panel is. The token is for the person at the terminal: a log gets the name of the file that has it.
fn tell(given: &Start, address_file: &Path) -> Result<(), Failure> {
    let address = fs::read_to_string(address_file).map_err(|e| Failure::file(address_file, &e))?;
    let address = address.trim();
    let is_person = rustix::termios::isatty(io::stdout());
    let shown = if is_person {
        address.to_owned()
    } else {
        format!("its address is in {}", address_file.display())
    };
    hal_output::print(&format!(
        "ferrule: the panel: {shown}\nferrule: Ctrl-C, or 'ferrule stop', ends the machine\n"
    ))?;
    let is_network = given.listen.is_some_and(|listen| !listen.ip().is_loopback());
    if is_person && is_network {
        // Who comes from elsewhere signs in with an account: the picture needs no token.
        let place = address.split("/#").next().unwrap_or(address);
        if let Some(picture) = picture(place) {
            hal_output::print(&picture)?;
        }
    }
    if is_person && !is_network && !given.no_browser {
        open(address);
    }
    Ok(())
}

/// Returns an address as a picture for a telephone's camera.
pub(crate) fn picture(address: &str) -> Option<String> {
    let code = qrcode::QrCode::new(address).ok()?;
    Some(format!("{}\n", code.render::<qrcode::render::unicode::Dense1x2>().build()))
}

/// Opens the user's browser where there is a desktop. A browser that does not come is opened by hand.
pub(crate) fn open(address: &str) {
    let is_desktop = ["DISPLAY", "WAYLAND_DISPLAY"]
        .iter()
        .any(|name| std::env::var_os(name).is_some_and(|v| !v.is_empty()));
    if is_desktop {
        let mut command = Command::new("xdg-open");
        command.arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        drop(command.spawn());
    }
}

/// A program that was started. A signal of the terminal does not reach it: this program ends first the panel, then the machine.
pub(crate) struct Running {
    name: &'static str,
    child: Child,
}

impl Running {
    pub(crate) fn begin(name: &'static str, command: &mut Command) -> Result<Self, Failure> {
        let started = command.stdin(Stdio::null()).process_group(0).spawn();
        let child = started.map_err(|e| failed(name, &e))?;
        Ok(Self { name, child })
    }

    /// Returns its status, if it has ended.
    pub(crate) fn ended(&mut self) -> Result<Option<ExitStatus>, Failure> {
        self.child.try_wait().map_err(|e| failed(self.name, &e))
    }

    /// Asks the program to end if it has not, and returns its status.
    pub(crate) fn stop(mut self) -> Result<ExitCode, Failure> {
        if self.ended()?.is_none()
            && let Some(pid) = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw)
        {
            // It may have ended meanwhile.
            let _ = kill_process(pid, Signal::TERM);
        }
        let status = self.child.wait().map_err(|e| failed(self.name, &e))?;
        let code = status.code().and_then(|code| u8::try_from(code).ok());
        Ok(code.map_or(ExitCode::FAILURE, ExitCode::from))
    }
}

fn failed(name: &'static str, error: &io::Error) -> Failure {
    Failure::NotStarted { name, why: hal_output::reason(error).into() }
}

/// Returns the options of a start of a machine in a folder, on the virtual clock.
pub(crate) fn virtual_of(machine: PathBuf, programs: PathBuf, no_browser: bool) -> Start {
    Start {
        machine,
        is_virtual: true,
        stub: None,
        simulate: false,
        instance: None,
        role: None,
        listen: None,
        accounts: None,
        certificate: None,
        name: Vec::new(),
        programs: Some(programs),
        no_browser,
    }
}
