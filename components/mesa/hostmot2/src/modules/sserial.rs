//! Smart serial: remotes with I/O of their own, and the ports that exchange data with them.
//!
//! At first a port's remotes are asked what they are (`talk`, `describe`), and their pins are created from that (`data`,
//! `settings`). Then each cycle has one exchange with all remotes of a port (`halves`, `port`).

mod data;
mod describe;
mod elements;
mod halves;
mod parts;
mod port;
mod settings;
mod talk;

pub(crate) use self::{
    describe::{BadRemote, Description, Element, Flow, Form},
    talk::{Addresses, BadPort, RemoteMemory, Talk},
};

use self::{
    halves::{Incoming, Incomings, Inputs, Ports},
    parts::{Exchanged, PortPins, Remote, Seen, Texts},
    port::{Port, PortState},
    talk::{Answered, CHANNELS},
};
use crate::{config::ChannelUse, making::Making, plan::ReadPlan};
use hal_component::{Error, lasting};
use hal_firmware::{Module, Tag};

/// Number of the first I/O pin of each sort, and the name of its form: the pins of a sort are numbered by channel.
const PINS: [(u8, &str); 3] = [(1, "tx"), (0x11, "txen"), (0x21, "ntxen")];

/// Most pins of a sort.
const MOST_PINS: u8 = 15;

/// Returns the channel of an I/O pin, and the name of its sort if it is an output.
pub(crate) fn channel(number: u8) -> Option<(u8, &'static str)> {
    PINS.iter().rev().find_map(|(first, sort)| {
        let channel = number.checked_sub(*first)?;
        (channel < MOST_PINS).then_some((channel, *sort))
    })
}

/// Remote whose pins were created.
#[derive(Clone, Debug)]
pub(crate) struct UsedRemote {
    pub(crate) port: u8,
    pub(crate) channel: u8,
    pub(crate) kind: String,
    pub(crate) elements: Vec<Element>,
}

/// Remote with its account.
struct FoundRemote {
    answered: Answered,
    mode: u8,
    description: Description,
    /// Values of the parameters.
    values: Vec<u32>,
}

/// Finds the remotes of all ports, and creates their pins.
pub(crate) fn make(m: &mut Making<'_, '_>) -> Result<(), Error> {
    let module = m.card.modules.iter().find(|module| module.kind() == Some(Tag::SmartSerial));
    let there = module.map_or(0, |module| module.instances);
    for port in m.config.ports().filter(|port| *port >= there) {
        let text = format!(
            "{}: config: 'sserial_port_{port}': the card's firmware has {there} of them; the entry has no \
             effect",
            m.name
        );
        m.b.messages().warn(lasting(text), &[]);
    }
    let Some(module) = module.copied() else { return Ok(()) };
    let (mut inputs, mut ports) = (Vec::new(), Vec::new());
    let most = m.config.limit("num_sserials").unwrap_or(u8::MAX);
    for port in 0..module.instances.min(most) {
        let found = find(m, &module, port)?;
        let channels = found.iter().fold(0, |all, found| all | 1 << found.answered.channel);
        m.channels.push(channels);
        if !found.is_empty() {
            let (reads, writes) = make_port(m, &module, port, &found)?;
            inputs.push(reads);
            ports.push(writes);
        }
    }
    if !ports.is_empty() {
        m.reads.push(Box::new(Incomings { ports: inputs }));
        m.writes.push(Box::new(Ports { ports }));
    }
    Ok(())
}

fn addresses(m: &Making<'_, '_>, module: &Module, port: u8) -> Result<Addresses, Error> {
    Addresses::new(module, &m.card.identification, port).ok_or_else(|| {
        Error::new(format!("{}: the card's firmware has no registers of sserial {port}", m.name))
    })
}

/// Asks the channels of a port for their remotes.
fn find(m: &Making<'_, '_>, module: &Module, port: u8) -> Result<Vec<FoundRemote>, Error> {
    let talk = Talk { device: m.device, at: addresses(m, module, port)? };
    let bad = |why: BadPort| Error::new(format!("{}: smart-serial port {port}: {why}", m.name));
    let (mut found, mut any_chosen) = (Vec::new(), false);
    for channel in 0..CHANNELS {
        let chosen = m.config.port(port).and_then(|port| port.get(channel));
        let channel = u8::try_from(channel).unwrap_or(u8::MAX);
        let (mode, was_chosen) = match chosen {
            Some(ChannelUse::Off) => continue,
            Some(ChannelUse::Mode(mode)) => (*mode, true),
            None => (0, false),
        };
        if !m.has_pin(Tag::SmartSerial, port, channel + 1) {
            continue;
        }
        any_chosen |= was_chosen;
        talk.stop().map_err(bad)?;
        let Some(answered) = talk.start(channel, mode).map_err(bad)? else { continue };
        let name = kind(answered.name);
        if was_chosen && !answered.has_mode {
            return Err(Error::new(format!(
                "{}: config: 'sserial_port_{port}': the remote {name} at channel {channel} has no mode \
                 {mode}; 0 is its usual one",
                m.name
            )));
        }
        match account(&talk, &answered).map_err(bad)? {
            Ok((description, values)) => {
                let text = format!(
                    "{}: smart-serial port {port}, channel {channel}: the remote {name} has answered (unit \
                     {:08x}, mode {mode})",
                    m.name, answered.unit
                );
                m.b.messages().info(lasting(text), &[]);
                found.push(FoundRemote { answered, mode, description, values });
            }
            Err(why) => m.b.messages().warn(
                lasting(format!(
                    "{}: smart-serial port {port}, channel {channel}: the remote {name} is not used: {why}",
                    m.name
                )),
                &[],
            ),
        }
    }
    talk.stop().map_err(bad)?;
    if found.is_empty() && any_chosen {
        let text = format!(
            "{}: smart-serial port {port}: no remote answers, and its pins are not there: check its cable and \
             its power, and load the driver again",
            m.name
        );
        m.b.messages().warn(lasting(text), &[]);
    }
    Ok(found)
}

/// Account of a remote, with the values of its parameters.
type Account = Result<(Description, Vec<u32>), BadRemote>;

/// Asks a remote for its account.
fn account(talk: &Talk<'_>, answered: &Answered) -> Result<Account, BadPort> {
    let channel = answered.channel;
    let mut memory = RemoteMemory { talk, channel, fault: None };
    let described = Description::read(&mut memory, answered.data, answered.parameters);
    if let Some(fault) = memory.fault {
        return Err(fault);
    }
    let mut description = match described {
        Ok(description) => description,
        Err(why) => return Ok(Err(why)),
    };
    description.forget_doubles();
    let mut values = Vec::new();
    for setting in &description.settings {
        let bytes = settings::bytes(setting.bits);
        match talk.value(channel, setting.at, bytes, setting.lasts)? {
            Some(value) => values.push(value),
            None => return Ok(Err(BadRemote::Silent(setting.at))),
        }
    }
    Ok(Ok((description, values)))
}

/// Returns the kind of a remote for names: `7i76`. The second letter is small, as in LinuxCNC.
fn kind(name: [u8; 4]) -> String {
    let [first, second, third, fourth] = name;
    let letters = [first, second.to_ascii_lowercase(), third, fourth];
    let letter = |byte: u8| if byte.is_ascii_alphanumeric() { char::from(byte) } else { '_' };
    letters.map(letter).iter().collect()
}

fn make_port(
    m: &mut Making<'_, '_>,
    module: &Module,
    port: u8,
    found: &[FoundRemote],
) -> Result<(Inputs, Port), Error> {
    let at = addresses(m, module, port)?;
    let name = m.at(&format!("sserial.port-{port}"));
    let pins = PortPins::make(m.b, &name)?;
    let about = "Exchanges with the remotes of this port; goes round";
    let exchanges = m.b.item(&m.at(&format!("{port}.debug")), about, 0)?;
    let (mut incoming, mut remotes, mut settings) = (Vec::new(), Vec::new(), Vec::new());
    for found in found {
        let channel = usize::from(found.answered.channel);
        let remote = m.at(&format!("{}.{port}.{channel}", kind(found.answered.name)));
        let (taken, given) = elements::make(m, &remote, &found.description.elements)?;
        for (setting, value) in found.description.settings.iter().zip(&found.values) {
            settings.push(elements::make_setting(m, &remote, channel, setting, *value)?);
        }
        m.remotes.push(UsedRemote {
            port,
            channel: found.answered.channel,
            kind: kind(found.answered.name),
            elements: found.description.elements.clone(),
        });
        let about = "TRUE while the exchange with the remote of this channel fails";
        let fault = m.b.item(&format!("{name}.channel-{channel}.fault"), about, false)?;
        let registers = |flow| found.description.bits(flow).div_ceil(32) as usize;
        remotes.push(Remote {
            channel,
            mode: found.mode,
            given,
            registers: registers(Flow::Out),
            fault,
            texts: texts(&remote, &name, found.answered.unit),
            reported: false,
        });
        let none = ReadPlan::none();
        let words = vec![none; registers(Flow::In)];
        incoming.push(Incoming { channel, status: none, words, taken });
    }
    // Neighbouring registers are read by one command.
    let command = m.plan.read(at.command);
    let data = m.plan.read(at.data);
    for remote in &mut incoming {
        remote.status = m.plan.read(at.status.get(remote.channel).copied().unwrap_or(0));
    }
    for (n, user) in at.user.iter().enumerate() {
        for remote in &mut incoming {
            if let Some(place) = remote.words.get_mut(n) {
                *place = m.plan.read(user.get(remote.channel).copied().unwrap_or(0));
            }
        }
    }
    let (seen, sees) = m.b.shared(Seen::default());
    let (exchanged, exchanges_seen) = m.b.shared(Exchanged::new(0));
    let inputs =
        Inputs { command, data, remotes: incoming, seen, exchanged: exchanges_seen, start: 0 };
    let writes = Port {
        pins,
        remotes,
        settings,
        seen: sees,
        exchanged,
        hardware: m.b.hardware(),
        messages: m.b.messages(),
        exchanges,
        at,
        unfinished: lasting(format!(
            "{name}: command {{}} is not finished: the port is stopped; when the cause is known, set {name}.run to 0 \
             and 1 to begin again"
        )),
        state: PortState::new(),
    };
    Ok((inputs, writes))
}

fn texts(remote: &str, port: &str, unit: u32) -> Texts {
    let texts = |text: &str| lasting(format!("{remote} (unit {unit:08x}): {text}"));
    Texts {
        silent: texts(
            "no exchange: the remote does not answer (status {}): check its cable and its power",
        ),
        bitten: texts(
            "no exchange: the remote's watchdog has bitten, and its outputs are off (status {})",
        ),
        fault: texts("no exchange: the remote reports a fault (status {})"),
        stopped: texts(&format!(
            "{port} is stopped because this remote fails: all remotes of the port switch their outputs \
             off, and their inputs keep their values; when the cause is known, set {port}.run to 0 and 1 \
             to begin again"
        )),
        setting: texts("the remote does not take the value of a parameter"),
    }
}
