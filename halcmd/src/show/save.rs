//! The output of `save`: commands that rebuild a state.

use crate::{
    language::command::SaveKind,
    show::{self, VALUE},
};
use hal_protocol::{
    AliasInfo, ComponentInfo, Direction, ItemInfo, Kind, Reply, Request, SignalInfo, ThreadInfo,
};

/// Returns the output of a kind of `save`. `ask` answers requests for lists.
///
/// # Errors
/// The error of `ask`.
pub(crate) fn write<E>(
    kind: SaveKind,
    ask: &mut dyn FnMut(Request) -> Result<Reply, E>,
) -> Result<String, E> {
    let mut text = String::new();
    for part in parts(kind) {
        match part {
            SaveKind::Components => components(&mut text, &ask(list(Kind::Components))?),
            SaveKind::Aliases => {
                aliases(&mut text, "pin", &ask(list(Kind::PinAliases))?);
                aliases(&mut text, "param", &ask(list(Kind::ParamAliases))?);
            }
            SaveKind::Links(arrows) => links(&mut text, &ask(list(Kind::Pins))?, *arrows),
            SaveKind::Params => params(&mut text, &ask(list(Kind::Params))?),
            SaveKind::LonePins => lone_pins(&mut text, &ask(list(Kind::Pins))?),
            SaveKind::Threads => threads(&mut text, &ask(list(Kind::Threads))?),
            signal_part => signals(&mut text, &ask(list(Kind::Signals))?, *signal_part),
        }
    }
    Ok(text)
}

const fn parts(kind: SaveKind) -> &'static [SaveKind] {
    use SaveKind as S;
    const BASE: [SaveKind; 7] = [
        S::Components,
        S::Aliases,
        S::LoneSignals,
        S::NetLines(true),
        S::Params,
        S::LonePins,
        S::Threads,
    ];
    const WITHOUT_PINS: [SaveKind; 6] =
        [S::Components, S::Aliases, S::LoneSignals, S::NetLines(true), S::Params, S::Threads];
    match kind {
        S::All => &WITHOUT_PINS,
        S::AllWithPins => &BASE,
        S::Components => &[S::Components],
        S::Aliases => &[S::Aliases],
        S::Signals => &[S::Signals],
        S::LoneSignals => &[S::LoneSignals],
        S::Links(false) => &[S::Links(false)],
        S::Links(true) => &[S::Links(true)],
        S::Nets(false) => &[S::Nets(false)],
        S::Nets(true) => &[S::Nets(true)],
        S::NetLines(false) => &[S::NetLines(false)],
        S::NetLines(true) => &[S::NetLines(true)],
        S::Params => &[S::Params],
        S::LonePins => &[S::LonePins],
        S::Threads => &[S::Threads],
    }
}

const fn list(kind: Kind) -> Request {
    Request::List { kind, patterns: Vec::new(), ty: None }
}

/// Oldest component first.
fn components(text: &mut String, reply: &Reply) {
    let list: &[ComponentInfo] = if let Reply::Components(list) = reply { list } else { &[] };
    text.push_str("# components\n");
    for c in list.iter().rev().filter(|c| c.realtime) {
        match &c.args {
            // The second load of a module is component MODULE:2.
            Some(args) => {
                let module = c.name.split_once(':').map_or(c.name.as_str(), |(module, _)| module);
                text.push_str(&format!("loadrt {module} {args}\n"));
            }
            None => text
                .push_str(&format!("#loadrt {}  (not loaded by loadrt, no args saved)\n", c.name)),
        }
    }
}

fn aliases(text: &mut String, kind: &str, reply: &Reply) {
    let list: &[AliasInfo] = if let Reply::Aliases(list) = reply { list } else { &[] };
    text.push_str(&format!("# {kind} aliases\n"));
    for a in list {
        text.push_str(&format!("alias {kind} {} {}\n", a.original, a.alias));
    }
}

fn signals(text: &mut String, reply: &Reply, part: SaveKind) {
    let list: &[SignalInfo] = if let Reply::Signals(list) = reply { list } else { &[] };
    let lines = matches!(part, SaveKind::Signals | SaveKind::LoneSignals);
    text.push_str(if lines { "# signals\n" } else { "# nets\n" });
    for signal in list {
        let name = &signal.name;
        let declaration = format!("newsig {name} {:<5}\n", signal.value.ty().name());
        match part {
            SaveKind::Signals => text.push_str(&declaration),
            SaveKind::LoneSignals if signal.pins.is_empty() => text.push_str(&declaration),
            SaveKind::Nets(arrows) => {
                text.push_str(&declaration);
                for (direction, pin) in &signal.pins {
                    let arrow = if arrows { show::from_signal(*direction) } else { "" };
                    text.push_str(&format!("linksp {name} {arrow} {pin}\n"));
                }
            }
            SaveKind::NetLines(arrows) if !signal.pins.is_empty() => {
                text.push_str(&format!("net {name}{}\n", net_pins(signal, arrows)));
            }
            _ => {}
        }
    }
}

/// Writes the output pin, `=>` and the inputs; or bidirectional pins joined by `<=>`, then the
/// inputs.
fn net_pins(signal: &SignalInfo, arrows: bool) -> String {
    let of = |wanted: Direction| {
        signal.pins.iter().filter(move |(d, _)| *d == wanted).map(|(_, pin)| pin.as_str())
    };
    if !arrows {
        return signal.pins.iter().map(|(_, pin)| format!(" {pin}")).collect();
    }
    let mut text = String::new();
    for pin in of(Direction::Out) {
        text.push_str(&format!(" {pin}"));
    }
    for pin in of(Direction::Io) {
        text.push_str(if text.is_empty() { " " } else { " <=> " });
        text.push_str(pin);
    }
    let mut first = !text.is_empty();
    for pin in of(Direction::In) {
        text.push_str(if first { " => " } else { " " });
        text.push_str(pin);
        first = false;
    }
    text
}

fn links(text: &mut String, reply: &Reply, arrows: bool) {
    text.push_str("# links\n");
    for pin in items(reply) {
        if let Some(signal) = &pin.signal {
            let arrow = if arrows { show::from_pin(pin.direction) } else { "" };
            text.push_str(&format!("linkps {} {arrow} {signal}\n", pin.name));
        }
    }
}

fn params(text: &mut String, reply: &Reply) {
    text.push_str("# parameter values\n");
    for param in items(reply).iter().filter(|p| p.direction == Direction::Rw) {
        setp(text, param);
    }
}

fn lone_pins(text: &mut String, reply: &Reply) {
    text.push_str("# unconnected pin values\n");
    for pin in items(reply) {
        let input = matches!(pin.direction, Direction::In | Direction::Io);
        let settable = pin.value.ty() != hal_protocol::Type::Port;
        if input && settable && pin.signal.is_none() {
            setp(text, pin);
        }
    }
}

fn setp(text: &mut String, item: &ItemInfo) {
    text.push_str(&format!("setp {} {:>VALUE$}\n", item.name, show::value(&item.value)));
}

fn threads(text: &mut String, reply: &Reply) {
    let list: &[ThreadInfo] = if let Reply::Threads(list) = reply { list } else { &[] };
    text.push_str("# realtime thread/function links\n");
    for thread in list {
        for funct in &thread.functs {
            text.push_str(&format!("addf {funct} {}\n", thread.name));
        }
    }
}

fn items(reply: &Reply) -> &[ItemInfo] {
    if let Reply::Items(list) = reply { list } else { &[] }
}

#[cfg(test)]
mod tests {
    use super::{SaveKind, write};
    use crate::show::samples;
    use hal_protocol::{Kind, Reply, Request};

    fn saved(kind: SaveKind) -> String {
        let mut ask = |request: Request| match request {
            Request::List { kind: Kind::Components, .. } => Ok(samples::components()),
            Request::List { kind: Kind::Pins, .. } => Ok(samples::pins()),
            Request::List { kind: Kind::Params, .. } => Ok(samples::params()),
            Request::List { kind: Kind::Signals, .. } => Ok(samples::signals()),
            Request::List { kind: Kind::Threads, .. } => Ok(samples::threads()),
            Request::List { kind: Kind::PinAliases, .. } => Ok(samples::aliases()),
            Request::List { .. } => Ok(Reply::Aliases(Vec::new())),
            other => Err(other),
        };
        write(kind, &mut ask).unwrap()
    }

    const COMP: &str = "# components\n\
        loadrt threads name1=fast period1=1000000\n\
        #loadrt __fast  (not loaded by loadrt, no args saved)\n\
        loadrt not \n\
        loadrt pwmgen output_type=1\n";
    const ALIAS: &str = "# pin aliases\nalias pin and2.0.in1 my-alias\n# param aliases\n";
    const SIGU: &str = "# signals\nnewsig lonely float\n";
    const NETLA: &str = "# nets\n\
        net b1 and2.0.out => and2.1.in0 and2.1.in1\n\
        net iosig encoder.0.position-scale <=> pwmgen.0.scale => adder.in1\n\
        net readers and2.0.in0 and2.2.in0\n";
    const PARAM: &str = "# parameter values\nsetp stepgen.0.dirhold           0x00000001\n";
    const PINS: &str = "# unconnected pin values\n\
        setp and2.0.in0                 TRUE\n\
        setp x.u64   0x0000000000000000\n";
    const THREAD: &str = "# realtime thread/function links\n\
        addf and2.0 slow\naddf siggen.0.update fast\naddf adder fast\n";

    #[test]
    fn every_kind() {
        for (kind, want) in [
            (SaveKind::Components, COMP),
            (SaveKind::Aliases, ALIAS),
            (SaveKind::LoneSignals, SIGU),
            (SaveKind::NetLines(true), NETLA),
            (SaveKind::Params, PARAM),
            (SaveKind::LonePins, PINS),
            (SaveKind::Threads, THREAD),
            (
                SaveKind::Signals,
                "# signals\nnewsig b1 bit  \nnewsig iosig float\nnewsig lonely float\n\
                 newsig readers bit  \n",
            ),
            (
                SaveKind::NetLines(false),
                "# nets\nnet b1 and2.0.out and2.1.in0 and2.1.in1\n\
                 net iosig adder.in1 encoder.0.position-scale pwmgen.0.scale\n\
                 net readers and2.0.in0 and2.2.in0\n",
            ),
            (
                SaveKind::Links(false),
                "# links\nlinkps and2.0.out  b1\nlinkps and2.1.in0  b1\n\
                 linkps encoder.0.position-scale  iosig\n",
            ),
            (
                SaveKind::Links(true),
                "# links\nlinkps and2.0.out ==> b1\nlinkps and2.1.in0 <== b1\n\
                 linkps encoder.0.position-scale <=> iosig\n",
            ),
        ] {
            assert_eq!(saved(kind), want);
        }
        let nets = saved(SaveKind::Nets(true));
        assert!(nets.starts_with("# nets\nnewsig b1 bit  \nlinksp b1 <== and2.0.out\n"), "{nets}");
        let nets = saved(SaveKind::Nets(false));
        assert!(nets.starts_with("# nets\nnewsig b1 bit  \nlinksp b1  and2.0.out\n"), "{nets}");
    }

    #[test]
    fn all_is_what_rebuilds_the_state() {
        assert_eq!(saved(SaveKind::All), [COMP, ALIAS, SIGU, NETLA, PARAM, THREAD].concat());
        let with_pins = [COMP, ALIAS, SIGU, NETLA, PARAM, PINS, THREAD].concat();
        assert_eq!(saved(SaveKind::AllWithPins), with_pins);
    }
}
