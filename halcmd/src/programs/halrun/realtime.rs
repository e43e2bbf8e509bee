//! Settings of realtime threads: options of halrun, and the machine's INI file.

use crate::{Error, ini::Ini, language::units::nanoseconds};
use hal_engine::{RealtimeOptions, STUCK_NS};

/// Parses the options: the number of a processor, microseconds or `off`, and a time.
pub(super) fn options(
    cpu: Option<String>,
    idle: Option<String>,
    stuck: Option<String>,
) -> Result<RealtimeOptions, Error> {
    let mut found = RealtimeOptions::default();
    if let Some(text) = cpu {
        let cpu = text.parse().ok();
        let wrong = || refuse("--cpu", &text, "it is the number of a processor, such as 3");
        found.cpu = Some(cpu.ok_or_else(wrong)?);
    }
    match idle.as_deref() {
        None => {}
        Some("off") => found.idle_us = None,
        Some(text) => {
            let us = text.parse().ok().filter(|us: &u32| i32::try_from(*us).is_ok());
            let wrong = || refuse("--dma-latency", text, "it is a number of microseconds, or off");
            found.idle_us = Some(us.ok_or_else(wrong)?);
        }
    }
    if let Some(text) = stuck {
        let ns = stuck_ns(&text).ok_or_else(|| refuse("--stuck-time", &text, STUCK_TIME))?;
        found.stuck_ns = Some(ns);
    }
    Ok(found)
}

/// Reads `[HAL]STUCK_TIME`.
pub(crate) fn of_ini(ini: &Ini) -> Result<Option<u64>, Error> {
    let Some(entry) = ini.all("HAL", "STUCK_TIME").next() else { return Ok(None) };
    let wrong = || Error::Profile {
        place: format!("{}:{}", entry.file, entry.line).into(),
        why: format!("[HAL]STUCK_TIME '{}': {STUCK_TIME}", entry.value).into(),
    };
    stuck_ns(&entry.value).map(Some).ok_or_else(wrong)
}

const STUCK_TIME: &str = "it is a number and us, ms or s, from 1ms to 3600s, such as 5ms";

fn stuck_ns(text: &str) -> Option<u64> {
    nanoseconds(text).ok().filter(|ns| STUCK_NS.contains(ns))
}

fn refuse(option: &str, value: &str, why: &str) -> Error {
    let (option, value, why) = (option.into(), value.into(), why.into());
    Error::OptionValue { program: "halrun", option, value, why }
}

#[cfg(test)]
mod tests {
    use super::{of_ini, options};
    use crate::ini::Ini;
    use hal_engine::RealtimeOptions;

    fn check(words: [&str; 3], want: Result<RealtimeOptions, &str>) {
        let [cpu, idle, stuck] = words.map(|w| (!w.is_empty()).then(|| w.to_owned()));
        let got = options(cpu, idle, stuck).map_err(|e| e.whole());
        assert_eq!(got, want.map_err(|e| format!("halrun: {e}")), "{words:?}");
    }

    #[test]
    fn options_and_what_is_wrong_with_them() {
        let usual = RealtimeOptions { cpu: None, idle_us: Some(0), stuck_ns: None };
        check(["", "", ""], Ok(usual));
        check(
            ["3", "20", "5ms"],
            Ok(RealtimeOptions { cpu: Some(3), idle_us: Some(20), stuck_ns: Some(5_000_000) }),
        );
        check(["", "off", ""], Ok(RealtimeOptions { idle_us: None, ..usual }));
        check(["x", "", ""], Err("--cpu 'x': it is the number of a processor, such as 3"));
        for idle in ["-1", "3000000000", "never"] {
            let why = format!("--dma-latency '{idle}': it is a number of microseconds, or off");
            check(["", idle, ""], Err(&why));
        }
        for stuck in ["5", "0ms", "999us", "3601s", "off", "-5ms", "1e3ms"] {
            let why = format!(
                "--stuck-time '{stuck}': it is a number and us, ms or s, from 1ms to 3600s, such \
                 as 5ms"
            );
            check(["", "", stuck], Err(&why));
        }
    }

    #[test]
    fn the_ini_file_says_it_with_its_place() {
        let read = |text: &str| {
            let ini = Ini::parse("m.ini", text.as_bytes()).unwrap();
            of_ini(&ini).map_err(|e| e.whole())
        };
        assert_eq!(read("[HAL]\nHALFILE = a.hal\n"), Ok(None));
        assert_eq!(read("[HAL]\nSTUCK_TIME = 1.5 ms\n"), Ok(Some(1_500_000)));
        for value in ["", "5", "0s", "2h"] {
            let want = format!(
                "m.ini:2: [HAL]STUCK_TIME '{value}': it is a number and us, ms or s, from 1ms to \
                 3600s, such as 5ms"
            );
            assert_eq!(read(&format!("[HAL]\nSTUCK_TIME = {value}\n")), Err(want));
        }
    }
}
