//! The output of `show`, with exact columns.

pub(crate) mod flight;
pub mod list;
pub(crate) mod meter;
pub(crate) mod published;
pub mod save;
pub(crate) mod status;
pub(crate) mod watch;

use hal_protocol::{
    AliasInfo, CommandInfo, ComponentInfo, ComponentState, Direction, FunctInfo, ItemInfo, Reply,
    SignalInfo, StreamInfo, ThreadInfo, Value,
};

/// Width of a value in columns.
pub const VALUE: usize = 20;
/// Width of a name in columns.
pub const NAME: usize = 55;

/// Writes a section with its header and a blank line at the end; in script mode without header and
/// padding. `title` distinguishes sections of the same form.
#[must_use]
pub fn section(reply: &Reply, title: &str, script: bool) -> String {
    let mut text = String::new();
    if !script {
        text.push_str(title);
        text.push('\n');
    }
    match reply {
        Reply::Components(list) => components(&mut text, list, script),
        Reply::Items(list) => items(&mut text, list, script),
        Reply::Signals(list) => signals(&mut text, list, script),
        Reply::Aliases(list) => aliases(&mut text, list, script),
        Reply::Functs(list) => functs(&mut text, list, script),
        Reply::Threads(list) => threads(&mut text, list, script),
        Reply::Commands(list) => commands(&mut text, list, script),
        Reply::Streams(list) => streams(&mut text, list, script),
        Reply::Workers(list) => published::workers(&mut text, list, script),
        Reply::Snapshots(list) => published::snapshots(&mut text, list, script),
        _ => {}
    }
    text.push('\n');
    text
}

/// Writes a value as `show` and `save` do: unsigned integers in hexadecimal.
#[must_use]
pub fn value(value: &Value) -> String {
    match value {
        Value::U32(u) => format!("0x{u:08X}"),
        Value::U64(u) => format!("0x{u:016X}"),
        other => other.to_string(),
    }
}

/// Returns the arrow of a link, seen from the signal.
#[must_use]
pub const fn from_signal(direction: Direction) -> &'static str {
    match direction {
        Direction::Out => "<==",
        Direction::Io => "<=>",
        _ => "==>",
    }
}

/// Returns the arrow of a link, seen from the pin.
#[must_use]
pub const fn from_pin(direction: Direction) -> &'static str {
    match direction {
        Direction::Out => "==>",
        Direction::Io => "<=>",
        _ => "<==",
    }
}

fn components(text: &mut String, list: &[ComponentInfo], script: bool) {
    if !script {
        text.push_str(&format!("{:<8}{:<6}{:<NAME$} {:<5} State\n", "ID", "Type", "Name", "PID"));
    }
    for c in list {
        let ty = if c.realtime { "RT" } else { "User" };
        let pid = c.pid.filter(|_| !c.realtime).map(|p| p.to_string()).unwrap_or_default();
        let state = match c.state {
            ComponentState::Ready => "ready",
            ComponentState::Initializing => "initializing",
        };
        text.push_str(&format!("{:>6}  {ty:<4}  {:<NAME$} {pid:>5} {state}\n", c.id, c.name));
    }
    // Only for people, below the rows, because programs parse the columns.
    for (c, f) in list.iter().filter(|_| !script).filter_map(|c| Some((c, c.foreign.as_ref()?))) {
        text.push_str(&format!(
            "# {} is a {}, whose reads and writes are not known: {}, {} bytes of memory\n",
            c.name, f.kind, f.file, f.memory
        ));
    }
}

fn items(text: &mut String, list: &[ItemInfo], script: bool) {
    if !script {
        text.push_str(&format!("Owner   Type  Dir  {:>VALUE$}  Name\n", "Value"));
    }
    for item in list {
        let (ty, direction) = (item.value.ty().name(), item.direction.name());
        if script {
            text.push_str(&format!(
                "{} {ty:<5} {direction} {} {}",
                item.owner_name, item.value, item.name
            ));
        } else {
            text.push_str(&format!(
                "{:>6}  {ty:<5} {direction:<3}  {:>VALUE$}  {}",
                item.owner,
                value(&item.value),
                item.name
            ));
        }
        if let Some(signal) = &item.signal {
            text.push_str(&format!(" {} {signal}", from_pin(item.direction)));
        }
        text.push('\n');
    }
}

fn signals(text: &mut String, list: &[SignalInfo], script: bool) {
    if !script {
        text.push_str(&format!("Type   {:>VALUE$}  Name     (linked to)\n", "Value"));
    }
    for signal in list {
        let ty = signal.value.ty().name();
        if script {
            text.push_str(&format!("{ty:<5}  {}  {}", signal.value, signal.name));
            for (direction, pin) in &signal.pins {
                text.push_str(&format!(" {} {pin}", from_signal(*direction)));
            }
            text.push('\n');
        } else {
            let shown = value(&signal.value);
            text.push_str(&format!("{ty:<5}  {shown:>VALUE$}  {}\n", signal.name));
            for (direction, pin) in &signal.pins {
                text.push_str(&format!("{:33}{} {pin}\n", "", from_signal(*direction)));
            }
        }
    }
}

fn aliases(text: &mut String, list: &[AliasInfo], script: bool) {
    if !script {
        text.push_str(&format!(" {:<NAME$}  Original Name\n", "Alias"));
    }
    for a in list {
        if script {
            text.push_str(&format!(" {}  {}\n", a.alias, a.original));
        } else {
            text.push_str(&format!(" {:<NAME$}  {}\n", a.alias, a.original));
        }
    }
}

/// Returns the entry of the column FP.
const fn yes(fp: bool) -> &'static str {
    if fp { "YES" } else { "NO " }
}

fn functs(text: &mut String, list: &[FunctInfo], script: bool) {
    if !script {
        text.push_str("Owner   CodeAddr      Arg           FP   Users   Name\n");
    }
    for f in list {
        let (owner, code, arg, users, name) = (f.owner, f.code, f.arg, f.users, &f.name);
        let fp = yes(f.fp);
        if script {
            let owner = &f.owner_name;
            text.push_str(&format!("{owner} {code:08x} {arg:08x} {fp} {users:>3} {name}\n"));
        } else {
            text.push_str(&format!(
                " {owner:05}  {code:08x}  {arg:08x}  {fp}  {users:>5}   {name}\n"
            ));
        }
    }
}

fn threads(text: &mut String, list: &[ThreadInfo], script: bool) {
    if !script {
        text.push_str("     Period  FP     Name               (     Time, Max-Time )\n");
    }
    for t in list {
        let fp = yes(t.fp);
        if script {
            text.push_str(&format!("{} {fp} {} {:>8} {}\n", t.period, t.name, t.time, t.tmax));
        } else {
            text.push_str(&format!(
                "{:>11}  {fp}  {:>20} ( {:>8}, {:>8} )\n",
                t.period, t.name, t.time, t.tmax
            ));
        }
        for (i, funct) in t.functs.iter().enumerate() {
            if script {
                text.push_str(&format!(" {funct}\n"));
            } else {
                text.push_str(&format!("{:>19} {funct}\n", i + 1));
            }
        }
    }
}

fn commands(text: &mut String, list: &[CommandInfo], script: bool) {
    for c in list {
        text.push_str(&c.name);
        for arg in &c.args {
            let value = arg.ty.to_uppercase();
            if arg.required {
                text.push_str(&format!(" {}={value}", arg.name));
            } else {
                text.push_str(&format!(" [{}={value}]", arg.name));
            }
        }
        text.push('\n');
        if script {
            continue;
        }
        indented(text, 4, &c.doc);
        for arg in &c.args {
            let default = arg.default.as_ref().map(|d| format!(" [{d}]")).unwrap_or_default();
            let range = arg.range();
            let range = if range.is_empty() { range } else { format!(" ({range})") };
            text.push_str(&format!("    {}{range}{default}\n", arg.name));
            indented(text, 8, &arg.doc);
        }
    }
}

/// Appends a doc comment with each line indented.
fn indented(text: &mut String, by: usize, doc: &str) {
    for line in doc.lines() {
        text.push_str(format!("{:by$}{line}", "").trim_end());
        text.push('\n');
    }
}

/// Lists the names of commands with the first line of their documentation.
#[must_use]
pub fn summaries(list: &[CommandInfo]) -> String {
    let width = list.iter().map(|c| c.name.len()).max().unwrap_or(0);
    let line = |c: &CommandInfo| {
        let first = c.doc.lines().next().unwrap_or_default();
        format!("{:<width$}  {first}", c.name).trim_end().to_owned() + "\n"
    };
    list.iter().map(line).collect()
}

fn streams(text: &mut String, list: &[StreamInfo], script: bool) {
    if !script {
        text.push_str("Depth     Types                  Name\n");
    }
    for s in list {
        let types: Vec<&str> = s.types.iter().map(|t| t.name()).collect();
        let taken = if s.attached { " (attached)" } else { "" };
        text.push_str(&format!("{:<8}  {:<21}  {}{taken}\n", s.depth, types.join(","), s.name));
    }
}

#[cfg(test)]
pub(crate) mod samples {
    //! A machine in replies, for the tests of what is printed.

    use hal_protocol::{
        AliasInfo, ComponentInfo, ComponentState, Direction, FunctInfo, ItemInfo, Reply,
        SignalInfo, ThreadInfo, Value,
    };

    fn component(id: u32, name: &str, pid: Option<i32>, args: Option<&str>) -> ComponentInfo {
        ComponentInfo {
            id,
            name: name.to_owned(),
            realtime: pid.is_none(),
            pid,
            state: ComponentState::Ready,
            args: args.map(str::to_owned),
            foreign: None,
        }
    }

    pub(crate) fn components() -> Reply {
        Reply::Components(vec![
            component(29, "pwmgen", None, Some("output_type=1")),
            component(28, "halcmd20", Some(20), None),
            component(8, "not", None, Some("")),
            component(7, "__fast", None, None),
            component(6, "threads", None, Some("name1=fast period1=1000000")),
        ])
    }

    pub(crate) fn item(
        owner: (u32, &str),
        name: &str,
        direction: Direction,
        value: Value,
    ) -> ItemInfo {
        ItemInfo {
            owner: owner.0,
            owner_name: owner.1.to_owned(),
            direction,
            value,
            name: name.to_owned(),
            original: None,
            signal: None,
            doc: String::new(),
        }
    }

    pub(crate) fn pins() -> Reply {
        let linked =
            |item: ItemInfo, signal: &str| ItemInfo { signal: Some(signal.to_owned()), ..item };
        let and2 = (11, "and2");
        Reply::Items(vec![
            item(and2, "and2.0.in0", Direction::In, Value::Bit(true)),
            linked(item(and2, "and2.0.out", Direction::Out, Value::Bit(false)), "b1"),
            linked(item(and2, "and2.1.in0", Direction::In, Value::Bit(false)), "b1"),
            linked(
                item((23, "encoder"), "encoder.0.position-scale", Direction::Io, Value::Float(1.0)),
                "iosig",
            ),
            item((30, "x"), "x.s64", Direction::Out, Value::S64(i64::MIN)),
            item((30, "x"), "x.u64", Direction::Io, Value::U64(0)),
        ])
    }

    pub(crate) fn params() -> Reply {
        let stepgen = (20, "stepgen");
        Reply::Items(vec![
            item(stepgen, "stepgen.0.dirhold", Direction::Rw, Value::U32(1)),
            item(stepgen, "stepgen.0.frequency", Direction::Ro, Value::Float(0.0)),
        ])
    }

    pub(crate) fn signals() -> Reply {
        let signal = |name: &str, value, pins: &[(Direction, &str)]| SignalInfo {
            value,
            name: name.to_owned(),
            pins: pins.iter().map(|(d, p)| (*d, (*p).to_owned())).collect(),
        };
        let (r#in, out, io) = (Direction::In, Direction::Out, Direction::Io);
        Reply::Signals(vec![
            signal(
                "b1",
                Value::Bit(false),
                &[(out, "and2.0.out"), (r#in, "and2.1.in0"), (r#in, "and2.1.in1")],
            ),
            signal(
                "iosig",
                Value::Float(1.0),
                &[(r#in, "adder.in1"), (io, "encoder.0.position-scale"), (io, "pwmgen.0.scale")],
            ),
            signal("lonely", Value::Float(0.0), &[]),
            signal("readers", Value::Bit(false), &[(r#in, "and2.0.in0"), (r#in, "and2.2.in0")]),
        ])
    }

    pub(crate) fn aliases() -> Reply {
        let (alias, original) = ("my-alias".to_owned(), "and2.0.in1".to_owned());
        Reply::Aliases(vec![AliasInfo { alias, original }])
    }

    pub(crate) fn functs() -> Reply {
        Reply::Functs(vec![FunctInfo {
            owner: 11,
            owner_name: "and2".to_owned(),
            code: 0x7efe_87e1_c190,
            arg: 0x7efe_8700_b180,
            users: 1,
            name: "and2.0".to_owned(),
            foreign: false,
            doc: String::new(),
            fast: false,
            fp: true,
        }])
    }

    pub(crate) fn thread(name: &str, period: i64, functs: &[&str]) -> ThreadInfo {
        ThreadInfo {
            period,
            name: name.to_owned(),
            fp: true,
            functs: functs.iter().map(|f| (*f).to_owned()).collect(),
            ..ThreadInfo::default()
        }
    }

    pub(crate) fn threads() -> Reply {
        Reply::Threads(vec![
            thread("slow", 10_000_000, &["and2.0"]),
            ThreadInfo {
                time: 521,
                tmax: 2210,
                ..thread("fast", 1_000_000, &["siggen.0.update", "adder"])
            },
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::{samples, section, summaries};
    use hal_protocol::{ArgInfo, CommandInfo, Reply};

    #[test]
    fn columns_for_people() {
        for (reply, title, want) in [
            (
                samples::components(),
                "Loaded HAL Components:",
                "Loaded HAL Components:\n\
                 ID      Type  Name                                                    PID   State\n\
                 \x20   29  RT    pwmgen                                                        ready\n\
                 \x20   28  User  halcmd20                                                   20 ready\n\
                 \x20    8  RT    not                                                           ready\n\
                 \x20    7  RT    __fast                                                        ready\n\
                 \x20    6  RT    threads                                                       ready\n\n",
            ),
            (
                samples::pins(),
                "Component Pins:",
                "Component Pins:\n\
                 Owner   Type  Dir                 Value  Name\n\
                 \x20   11  bit   IN                   TRUE  and2.0.in0\n\
                 \x20   11  bit   OUT                 FALSE  and2.0.out ==> b1\n\
                 \x20   11  bit   IN                  FALSE  and2.1.in0 <== b1\n\
                 \x20   23  float I/O                     1  encoder.0.position-scale <=> iosig\n\
                 \x20   30  s64   OUT  -9223372036854775808  x.s64\n\
                 \x20   30  u64   I/O    0x0000000000000000  x.u64\n\n",
            ),
            (
                samples::params(),
                "Parameters:",
                "Parameters:\n\
                 Owner   Type  Dir                 Value  Name\n\
                 \x20   20  u32   RW             0x00000001  stepgen.0.dirhold\n\
                 \x20   20  float RO                      0  stepgen.0.frequency\n\n",
            ),
            (
                samples::signals(),
                "Signals:",
                "Signals:\n\
                 Type                  Value  Name     (linked to)\n\
                 bit                   FALSE  b1\n\
                 \x20                                <== and2.0.out\n\
                 \x20                                ==> and2.1.in0\n\
                 \x20                                ==> and2.1.in1\n\
                 float                     1  iosig\n\
                 \x20                                ==> adder.in1\n\
                 \x20                                <=> encoder.0.position-scale\n\
                 \x20                                <=> pwmgen.0.scale\n\
                 float                     0  lonely\n\
                 bit                   FALSE  readers\n\
                 \x20                                ==> and2.0.in0\n\
                 \x20                                ==> and2.2.in0\n\n",
            ),
            (
                samples::aliases(),
                "Pin Aliases:",
                "Pin Aliases:\n\
                 \x20Alias                                                    Original Name\n\
                 \x20my-alias                                                 and2.0.in1\n\n",
            ),
            (
                samples::functs(),
                "Exported Functions:",
                "Exported Functions:\n\
                 Owner   CodeAddr      Arg           FP   Users   Name\n\
                 \x2000011  7efe87e1c190  7efe8700b180  YES      1   and2.0\n\n",
            ),
            (
                samples::threads(),
                "Realtime Threads:",
                "Realtime Threads:\n\
                 \x20    Period  FP     Name               (     Time, Max-Time )\n\
                 \x20  10000000  YES                  slow (        0,        0 )\n\
                 \x20                 1 and2.0\n\
                 \x20   1000000  YES                  fast (      521,     2210 )\n\
                 \x20                 1 siggen.0.update\n\
                 \x20                 2 adder\n\n",
            ),
        ] {
            assert_eq!(section(&reply, title, false), want);
        }
    }

    #[test]
    fn commands_with_their_arguments() {
        let arg = |name: &str, required, default: Option<&str>| ArgInfo {
            name: name.to_owned(),
            ty: "float".to_owned(),
            doc: format!("What {name} is."),
            required,
            default: default.map(str::to_owned),
            bounds: hal_protocol::Bounds { low: Some(0.0), above: true, ..Default::default() },
            unit: "units/s".to_owned(),
        };
        let list = vec![
            CommandInfo {
                name: "motion.jog".to_owned(),
                doc: "Moves.\n\nMore of it.".to_owned(),
                args: vec![arg("velocity", true, None), arg("distance", false, Some("1"))],
            },
            CommandInfo { name: "x.y".to_owned(), doc: "Does.".to_owned(), args: vec![] },
        ];
        assert_eq!(summaries(&list), "motion.jog  Moves.\nx.y         Does.\n");
        let want = "Commands:\nmotion.jog velocity=FLOAT [distance=FLOAT]\n    Moves.\n\n    \
                    More of it.\n    velocity (above 0 units/s)\n        What velocity is.\n    \
                    distance (above 0 units/s) [1]\n        What distance is.\nx.y\n    Does.\n\n";
        assert_eq!(section(&Reply::Commands(list), "Commands:", false), want);
    }

    #[test]
    fn fields_for_programs() {
        for (reply, want) in [
            (
                samples::pins(),
                "and2 bit   IN TRUE and2.0.in0\n\
                 and2 bit   OUT FALSE and2.0.out ==> b1\n\
                 and2 bit   IN FALSE and2.1.in0 <== b1\n\
                 encoder float I/O 1 encoder.0.position-scale <=> iosig\n\
                 x s64   OUT -9223372036854775808 x.s64\n\
                 x u64   I/O 0 x.u64\n\n",
            ),
            (
                samples::params(),
                "stepgen u32   RW 1 stepgen.0.dirhold\n\
                 stepgen float RO 0 stepgen.0.frequency\n\n",
            ),
            (
                samples::signals(),
                "bit    FALSE  b1 <== and2.0.out ==> and2.1.in0 ==> and2.1.in1\n\
                 float  1  iosig ==> adder.in1 <=> encoder.0.position-scale <=> pwmgen.0.scale\n\
                 float  0  lonely\n\
                 bit    FALSE  readers ==> and2.0.in0 ==> and2.2.in0\n\n",
            ),
            (samples::aliases(), " my-alias  and2.0.in1\n\n"),
            (samples::functs(), "and2 7efe87e1c190 7efe8700b180 YES   1 and2.0\n\n"),
            (
                samples::threads(),
                "10000000 YES slow        0 0\n and2.0\n\
                 1000000 YES fast      521 2210\n siggen.0.update\n adder\n\n",
            ),
        ] {
            assert_eq!(section(&reply, "a title", true), want);
        }
        let same = section(&samples::components(), "", true);
        assert!(same.starts_with("    29  RT    pwmgen  "), "{same}");
    }
}
