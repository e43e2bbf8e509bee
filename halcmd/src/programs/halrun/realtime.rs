//! Settings of realtime threads: options of halrun, and the machine's INI file.

use crate::{Error, ini::Ini, language::units::nanoseconds};
use core::ops::RangeInclusive;
use hal_engine::{MAX_GAP_NS, RealtimeOptions, STUCK_NS};

/// Parses the options: the number of a processor, microseconds or `off`, and two times.
pub(super) fn options(
    cpu: Option<String>,
    idle: Option<String>,
    (stuck, gap): (Option<String>, Option<String>),
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
        let ns = STUCK.read(&text).ok_or_else(|| refuse("--stuck-time", &text, STUCK.expects))?;
        found.stuck_ns = Some(ns);
    }
    if let Some(text) = gap {
        let ns = GAP.read(&text).ok_or_else(|| refuse("--max-gap", &text, GAP.expects))?;
        found.max_gap_ns = Some(ns);
    }
    Ok(found)
}

/// Times of a machine's INI file, in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Times {
    /// `[HAL]STUCK_TIME`.
    pub(crate) stuck_ns: Option<u64>,
    /// `[HAL]MAX_GAP`.
    pub(crate) max_gap_ns: Option<u64>,
}

/// Reads `[HAL]STUCK_TIME` and `[HAL]MAX_GAP`.
pub(crate) fn of_ini(ini: &Ini) -> Result<Times, Error> {
    Ok(Times { stuck_ns: STUCK.of_ini(ini)?, max_gap_ns: GAP.of_ini(ini)? })
}

/// A time within a range.
struct Time {
    key: &'static str,
    range: RangeInclusive<u64>,
    expects: &'static str,
}

const STUCK: Time = Time {
    key: "STUCK_TIME",
    range: STUCK_NS,
    expects: "it is a number and us, ms or s, from 1ms to 3600s, such as 5ms",
};
const GAP: Time = Time {
    key: "MAX_GAP",
    range: MAX_GAP_NS,
    expects: "it is a number and us, ms or s, from 10ms to 3600s, such as 500ms",
};

impl Time {
    fn read(&self, text: &str) -> Option<u64> {
        nanoseconds(text).ok().filter(|ns| self.range.contains(ns))
    }

    fn of_ini(&self, ini: &Ini) -> Result<Option<u64>, Error> {
        let Some(entry) = ini.all("HAL", self.key).next() else { return Ok(None) };
        let wrong = || Error::Profile {
            place: format!("{}:{}", entry.file, entry.line).into(),
            why: format!("[HAL]{} '{}': {}", self.key, entry.value, self.expects).into(),
        };
        self.read(&entry.value).map(Some).ok_or_else(wrong)
    }
}

fn refuse(option: &str, value: &str, why: &str) -> Error {
    let (option, value, why) = (option.into(), value.into(), why.into());
    Error::OptionValue { program: "halrun", option, value, why }
}

#[cfg(test)]
mod tests {
    use super::{Times, of_ini, options};
    use crate::ini::Ini;
    use hal_engine::RealtimeOptions;

    fn check(words: [&str; 4], want: Result<RealtimeOptions, &str>) {
        let [cpu, idle, stuck, gap] = words.map(|w| (!w.is_empty()).then(|| w.to_owned()));
        let got = options(cpu, idle, (stuck, gap)).map_err(|e| e.whole());
        assert_eq!(got, want.map_err(|e| format!("halrun: {e}")), "{words:?}");
    }

    #[test]
    fn options_and_what_is_wrong_with_them() {
        let usual =
            RealtimeOptions { cpu: None, idle_us: Some(0), stuck_ns: None, max_gap_ns: None };
        check(["", "", "", ""], Ok(usual));
        check(
            ["3", "20", "5ms", "2s"],
            Ok(RealtimeOptions {
                cpu: Some(3),
                idle_us: Some(20),
                stuck_ns: Some(5_000_000),
                max_gap_ns: Some(2_000_000_000),
            }),
        );
        check(["", "off", "", ""], Ok(RealtimeOptions { idle_us: None, ..usual }));
        check(["x", "", "", ""], Err("--cpu 'x': it is the number of a processor, such as 3"));
        for idle in ["-1", "3000000000", "never"] {
            let why = format!("--dma-latency '{idle}': it is a number of microseconds, or off");
            check(["", idle, "", ""], Err(&why));
        }
        for stuck in ["5", "0ms", "999us", "3601s", "off", "-5ms", "1e3ms"] {
            let why = format!(
                "--stuck-time '{stuck}': it is a number and us, ms or s, from 1ms to 3600s, such \
                 as 5ms"
            );
            check(["", "", stuck, ""], Err(&why));
        }
        for gap in ["1", "9ms", "3601s", "off"] {
            let why = format!(
                "--max-gap '{gap}': it is a number and us, ms or s, from 10ms to 3600s, such as \
                 500ms"
            );
            check(["", "", "", gap], Err(&why));
        }
    }

    #[test]
    fn the_ini_file_says_it_with_its_place() {
        let read = |text: &str| {
            let ini = Ini::parse("m.ini", text.as_bytes()).unwrap();
            of_ini(&ini).map_err(|e| e.whole())
        };
        assert_eq!(read("[HAL]\nHALFILE = a.hal\n"), Ok(Times::default()));
        let both = Times { stuck_ns: Some(1_500_000), max_gap_ns: Some(1_000_000_000) };
        assert_eq!(read("[HAL]\nSTUCK_TIME = 1.5 ms\nMAX_GAP = 1s\n"), Ok(both));
        for value in ["", "5", "0s", "2h"] {
            let want = format!(
                "m.ini:2: [HAL]STUCK_TIME '{value}': it is a number and us, ms or s, from 1ms to \
                 3600s, such as 5ms"
            );
            assert_eq!(read(&format!("[HAL]\nSTUCK_TIME = {value}\n")), Err(want));
        }
        let want = "m.ini:2: [HAL]MAX_GAP '5': it is a number and us, ms or s, from 10ms to 3600s, \
                    such as 500ms";
        assert_eq!(read("[HAL]\nMAX_GAP = 5\n"), Err(want.to_owned()));
    }
}
