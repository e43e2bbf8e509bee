//! Lines that start a program of LinuxCNC that drives a device, such as `loadusr -W hy_vfd -d /dev/ttyUSB0`: a component of
//! Ferrule does its work, and its pins have the same names. What the program's options say becomes arguments.

use crate::{
    Error,
    language::command::Launch,
    programs::options::{Opt, mixed},
};

/// Program with the component that replaces it.
pub(crate) struct Native {
    program: &'static str,
    component: &'static str,
    arguments: fn(&[String]) -> Result<Vec<String>, Error>,
}

const NATIVES: &[Native] = &[
    Native { program: "hal_input", component: "hal_input", arguments: |words| Ok(input(words)) },
    Native { program: "hy_vfd", component: "hy_vfd", arguments: inverter },
    Native { program: "mb2hal", component: "modbus", arguments: |words| Ok(modbus(words)) },
];

impl Native {
    /// Returns the component that replaces the program of a line.
    pub(crate) fn of(launch: &Launch) -> Option<&'static Self> {
        NATIVES.iter().find(|native| native.program == launch.name())
    }

    /// Returns the name of the program.
    pub(crate) const fn program(&self) -> &'static str {
        self.program
    }

    /// Returns the name of the component.
    pub(crate) const fn component(&self) -> &'static str {
        self.component
    }

    /// Returns the arguments of the component.
    ///
    /// # Errors
    /// The program has no such option.
    pub(crate) fn arguments(&self, launch: &Launch) -> Result<Vec<String>, Error> {
        (self.arguments)(launch.own_args())
    }
}

/// Returns the arguments of `hal_input`: letters of features are in front of the device that they are for. Its pins are set
/// in the background.
fn input(words: &[String]) -> Vec<String> {
    let (mut devices, mut letters) = (Vec::new(), None);
    for word in words {
        if word.starts_with('-') {
            letters = Some(word.as_str());
            continue;
        }
        // A comma separates devices; in a name any letter stands for it.
        let device = word.replace(',', "?");
        devices.push(match letters.take() {
            Some(letters) => format!("{letters} {device}"),
            None => device,
        });
    }
    // Without a device behind them, the component says what is missing.
    devices.extend(letters.map(str::to_owned));
    let mut args = vec!["task=1".to_owned()];
    if !devices.is_empty() {
        args.push(format!("devices={}", devices.join(",")));
    }
    args
}

/// Meaning of an option of `hy_vfd`.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Meaning {
    /// The argument of this name.
    Argument(&'static str),
    /// A word of a list, which may be shortened.
    Word(&'static str, &'static [&'static str]),
    /// A setting to write.
    Register,
    /// Nothing that this component has.
    Nothing,
}

const PARITIES: &[&str] = &["even", "odd", "none"];
const RATES: &[&str] =
    &["110", "300", "600", "1200", "2400", "4800", "9600", "19200", "38400", "57600", "115200"];

const fn with(
    id: Meaning,
    short: char,
    long: &'static str,
    value: Option<&'static str>,
) -> Opt<Meaning> {
    Opt { id, short: Some(short), long: Some(long), value, variable: None, help: "" }
}

const fn argument(name: &'static str, short: char, long: &'static str) -> Opt<Meaning> {
    with(Meaning::Argument(name), short, long, Some("VALUE"))
}

const INVERTER: &[Opt<Meaning>] = &[
    argument("bits", 'b', "bits"),
    argument("device", 'd', "device"),
    with(Meaning::Nothing, 'g', "debug", None),
    argument("name", 'n', "name"),
    with(Meaning::Word("parity", PARITIES), 'p', "parity", Some("PARITY")),
    with(Meaning::Word("rate", RATES), 'r', "rate", Some("RATE")),
    argument("stopbits", 's', "stopbits"),
    argument("target", 't', "target"),
    argument("max_frequency", 'F', "max-frequency"),
    argument("min_frequency", 'f', "min-frequency"),
    argument("base_frequency", 'B', "base-frequency"),
    argument("motor_voltage", 'V', "motor-voltage"),
    argument("motor_current", 'I', "motor-current"),
    argument("motor_speed", 'S', "motor-speed"),
    argument("motor_poles", 'P', "motor-poles"),
    with(Meaning::Register, 'x', "register", Some("PDnnn=VALUE")),
    with(Meaning::Nothing, 'y', "regdump", None),
];

/// Returns the arguments of `hy_vfd`. Its pins are set in the background, and its line has even parity where the options say none,
/// as with the program.
fn inverter(words: &[String]) -> Result<Vec<String>, Error> {
    let (given, _) = mixed("hy_vfd", INVERTER, words)?;
    let mut args = vec!["task=1".to_owned()];
    let mut registers = Vec::new();
    let mut has_parity = false;
    for (meaning, value) in given {
        let value = value.unwrap_or_default();
        match meaning {
            Meaning::Argument(name) => args.push(format!("{name}={value}")),
            Meaning::Word(name, words) => {
                has_parity |= name == "parity";
                // A beginning that only one word has stands for it; the component refuses all else.
                let mut full = words.iter().filter(|word| word.starts_with(value.as_str()));
                let word = match (full.next(), full.next()) {
                    _ if words.contains(&value.as_str()) => value.as_str(),
                    (Some(word), None) => word,
                    _ => value.as_str(),
                };
                args.push(format!("{name}={word}"));
            }
            Meaning::Register => registers.push(value),
            Meaning::Nothing => {}
        }
    }
    if !has_parity {
        args.push("parity=even".to_owned());
    }
    if !registers.is_empty() {
        args.push(format!("register={}", registers.join(",")));
    }
    Ok(args)
}

/// Returns the arguments of `modbus` for those of `mb2hal`, which has one: `config=FILE`.
fn modbus(words: &[String]) -> Vec<String> {
    let ini = |word: &String| word.strip_prefix("config=").map(|file| format!("ini={file}"));
    words.iter().map(|word| ini(word).unwrap_or_else(|| word.clone())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Command,
        language::{syntax::Statement, vars::Values},
    };

    /// Returns the component and the arguments for a line.
    fn of(line: &str) -> Result<(&'static str, Vec<String>), Error> {
        let values = Values { environment: &|_| None, ini: None };
        let statement = Statement::parse(&format!("loadusr {line}"), values).unwrap();
        let Ok(Command::Launch(launch)) = statement.command() else { panic!("{line}") };
        let native = Native::of(&launch).unwrap();
        Ok((native.component(), native.arguments(&launch)?))
    }

    #[test]
    fn options_become_arguments() {
        for (line, want) in [
            ("hy_vfd", "hy_vfd task=1 parity=even"),
            (
                "/usr/bin/hy_vfd -n vfd -d /dev/ttyUSB0 -p none -r 9600 -s 1 -b 8 -t 2",
                "hy_vfd task=1 name=vfd device=/dev/ttyUSB0 parity=none rate=9600 stopbits=1 bits=8 target=2",
            ),
            ("hy_vfd -pn --rate=5 -gy", "hy_vfd task=1 parity=none rate=57600"),
            // 1 begins several rates: the component says which there are.
            ("hy_vfd -r 1 --parity=odd", "hy_vfd task=1 rate=1 parity=odd"),
            (
                "hy_vfd --max-frequency 400 -S 24000 -x PD014=30 --register PD015=40",
                "hy_vfd task=1 max_frequency=400 motor_speed=24000 parity=even register=PD014=30,PD015=40",
            ),
            ("mb2hal config=mb2hal.ini", "modbus ini=mb2hal.ini"),
            ("mb2hal", "modbus"),
            ("hal_input -KRAL Gamepad", "hal_input task=1 devices=-KRAL Gamepad"),
            ("hal_input -KA Dual:1 -L +AT 3", "hal_input task=1 devices=-KA Dual:1,-L +AT,3"),
            ("hal_input -KRAL +Logitech Dual", "hal_input task=1 devices=-KRAL +Logitech,Dual"),
            ("hal_input Pads,Inc.", "hal_input task=1 devices=Pads?Inc."),
            ("hal_input -K +Pads,Inc.", "hal_input task=1 devices=-K +Pads?Inc."),
            ("hal_input Pads,Inc.:1", "hal_input task=1 devices=Pads?Inc.:1"),
            // The engine removes quotes.
            ("hal_input -KA \"X-Box 360\"", "hal_input task=1 devices=-KA \"X-Box 360\""),
            // Of two words of letters, the last one counts.
            ("hal_input -K -A X", "hal_input task=1 devices=-A X"),
            ("python3 -u /usr/bin/hal_input -K X", "hal_input task=1 devices=-K X"),
            ("sudo hal_input +X", "hal_input task=1 devices=+X"),
            ("/usr/bin/env hy_vfd -t 2", "hy_vfd task=1 target=2 parity=even"),
            ("hal_input -KRAL", "hal_input task=1 devices=-KRAL"),
            ("hal_input", "hal_input task=1"),
        ] {
            let (component, args) = of(line).unwrap();
            assert_eq!([&[component.to_owned()], &args[..]].concat().join(" "), want, "{line}");
        }
    }

    #[test]
    fn an_option_that_the_program_does_not_have_is_named() {
        for (line, want) in [
            ("hy_vfd -z", "hy_vfd: invalid option -- 'z'"),
            ("hy_vfd --devise x", "hy_vfd: unrecognized option '--devise'"),
            ("hy_vfd -d", "hy_vfd: option requires an argument -- 'd'"),
        ] {
            let said = of(line).unwrap_err().to_string();
            assert!(said.starts_with(want), "{line}: {said}");
        }
    }
}
