//! The string `config=` of a card, as users write it.

use core::num::IntErrorKind;
use hal_firmware::Tag;

/// Choices for one card.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct CardConfig {
    /// Largest number of instances by the entry's name; absent for all.
    limits: Vec<(&'static str, u8)>,
    /// I/O pins of each step generator.
    pub(crate) step_width: Option<u8>,
    /// Modes of the smart-serial channels by port; absent for all in mode 0.
    ports: Vec<(u8, Vec<ChannelUse>)>,
    /// True for pins that read and write any register.
    pub(crate) raw: bool,
}

/// Choice for a channel of smart serial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ChannelUse {
    /// Used, in this mode.
    Mode(u8),
    /// Not used: its I/O pins are free.
    Off,
}

/// Error in the string.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct BadConfig<'t> {
    word: &'t str,
    what: Wrong,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wrong {
    Unknown,
    Number,
    Large(u8),
    Port,
    Firmware,
    Missing,
    Width,
}

impl core::fmt::Display for BadConfig<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "config: '{}': ", self.word.escape_debug())?;
        match self.what {
            Wrong::Unknown => {
                f.write_str("no such entry: expected one of ")?;
                for Limit { name, .. } in LIMITS {
                    write!(f, "{name}=N, ")?;
                }
                f.write_str("stepgen_width=N, sserial_port_N=MODES and enable_raw")
            }
            Wrong::Number => f.write_str("expected a whole number from -1 on behind '='"),
            Wrong::Large(most) => write!(f, "at most {most}"),
            Wrong::Width => f.write_str("expected 1 to 8 I/O pins, or -1"),
            Wrong::Port => f.write_str(
                "expected up to eight letters: 0 to 9 for the mode of each channel, x for one that \
                 is not used",
            ),
            Wrong::Firmware => f.write_str(
                "expected no firmware: cards over Ethernet keep theirs, which mesaflash loads",
            ),
            Wrong::Missing => f.write_str(
                "expected 0 or -1: this kind of module is not driven yet, and its I/O pins are free",
            ),
        }
    }
}

impl core::error::Error for BadConfig<'_> {}

/// Entry that limits the number of instances.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limit {
    pub(crate) name: &'static str,
    /// Kinds of modules that it limits.
    pub(crate) tags: &'static [Tag],
}

const LIMITS: &[Limit] = &[
    Limit { name: "num_encoders", tags: &[Tag::Encoder, Tag::MuxedEncoder] },
    Limit { name: "num_pwmgens", tags: &[Tag::Pwm] },
    Limit { name: "num_stepgens", tags: &[Tag::StepGenerator] },
    Limit { name: "num_dplls", tags: &[Tag::Dpll] },
    Limit { name: "num_ssrs", tags: &[Tag::Ssr] },
    Limit { name: "num_inms", tags: &[Tag::Inputs] },
    Limit { name: "num_inmuxs", tags: &[Tag::InputMux] },
    Limit { name: "num_outms", tags: &[Tag::Outputs] },
    Limit { name: "num_leds", tags: &[Tag::Led] },
    // The ports are counted where they are asked for their remotes.
    Limit { name: "num_sserials", tags: &[] },
];

/// Entries for modules without a driver here: they accept only 0 and -1.
const ABSENT: &[&str] = &[
    "num_resolvers",
    "num_3pwmgens",
    "num_rcpwmgens",
    "num_oneshots",
    "num_periodms",
    "num_bspis",
    "num_uarts",
    "num_pktuarts",
    "num_xy2mods",
    "num_bisss",
    "num_fanucs",
    "num_ssis",
    "num_absencs",
    "num_tp_pwmgens",
];

/// Beginnings of entries for channels without a driver here.
const ABSENT_CHANNELS: &[&str] = &["ssi_chan_", "biss_chan_", "fanuc_chan_"];

impl CardConfig {
    /// Reads the string. Quotation marks around it are ignored.
    pub(crate) fn parse(text: &str) -> Result<Self, BadConfig<'_>> {
        let mut config = Self::default();
        for word in text.split(|c: char| c.is_whitespace() || c == '"').filter(|w| !w.is_empty()) {
            let bad = |what| BadConfig { word, what };
            match word.split_once('=') {
                None if word == "enable_raw" => config.raw = true,
                None => return Err(bad(Wrong::Unknown)),
                Some(("firmware", _)) => return Err(bad(Wrong::Firmware)),
                Some((name, value)) => config.entry(name, value).map_err(bad)?,
            }
        }
        Ok(config)
    }

    fn entry(&mut self, name: &str, value: &str) -> Result<(), Wrong> {
        if let Some(limit) = LIMITS.iter().find(|limit| limit.name == name) {
            if let Some(n) = number(value, u8::MAX)? {
                self.limits.push((limit.name, n));
            }
            return Ok(());
        }
        if name == "stepgen_width" {
            self.step_width = number(value, u8::MAX)?;
            return if matches!(self.step_width, Some(0 | 9..)) {
                Err(Wrong::Width)
            } else {
                Ok(())
            };
        }
        if let Some(port) = name.strip_prefix("sserial_port_") {
            let port = port.parse().ok().filter(|port| *port < 8).ok_or(Wrong::Unknown)?;
            self.ports.push((port, channels(value)?));
            return Ok(());
        }
        if ABSENT.contains(&name) {
            return if matches!(number(value, u8::MAX)?, None | Some(0)) {
                Ok(())
            } else {
                Err(Wrong::Missing)
            };
        }
        if ABSENT_CHANNELS.iter().any(|begins| name.starts_with(begins)) {
            return Err(Wrong::Missing);
        }
        Err(Wrong::Unknown)
    }

    /// Returns the entries that limit instances.
    pub(crate) fn entries() -> impl Iterator<Item = &'static Limit> {
        LIMITS.iter()
    }

    /// Returns the limit of an entry, if it was given.
    pub(crate) fn limit(&self, name: &str) -> Option<u8> {
        self.limits.iter().rev().find(|row| row.0 == name).map(|row| row.1)
    }

    /// Returns the smart-serial ports for which there are choices.
    pub(crate) fn ports(&self) -> impl Iterator<Item = u8> {
        self.ports.iter().map(|row| row.0)
    }

    /// Returns the choices for the channels of a smart-serial port; `None` if all are used in mode 0.
    pub(crate) fn port(&self, port: u8) -> Option<&[ChannelUse]> {
        self.ports.iter().rev().find(|row| row.0 == port).map(|row| row.1.as_slice())
    }
}

/// Reads a number, where -1 stands for all.
fn number(text: &str, most: u8) -> Result<Option<u8>, Wrong> {
    if text == "-1" {
        return Ok(None);
    }
    match text.parse::<u8>() {
        Ok(n) if n <= most => Ok(Some(n)),
        Ok(_) => Err(Wrong::Large(most)),
        Err(error) if *error.kind() == IntErrorKind::PosOverflow => Err(Wrong::Large(most)),
        Err(_) => Err(Wrong::Number),
    }
}

fn channels(text: &str) -> Result<Vec<ChannelUse>, Wrong> {
    if text.is_empty() || text.len() > 8 {
        return Err(Wrong::Port);
    }
    let channel = |byte| match byte {
        b'0'..=b'9' => Ok(ChannelUse::Mode(byte - b'0')),
        b'x' | b'X' => Ok(ChannelUse::Off),
        _ => Err(Wrong::Port),
    };
    text.bytes().map(channel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_limit_instances() {
        let text = "num_encoders=1 num_stepgens=-1 sserial_port_0=20xX num_pwmgens=0 enable_raw";
        let config = CardConfig::parse(text).unwrap();
        let limits = ["num_encoders", "num_stepgens", "num_pwmgens"].map(|name| config.limit(name));
        assert_eq!(limits, [Some(1), None, Some(0)]);
        let port = [ChannelUse::Mode(2), ChannelUse::Mode(0), ChannelUse::Off, ChannelUse::Off];
        assert_eq!(config.port(0), Some(&port[..]));
        assert_eq!(config.port(1), None);
        assert!(config.raw);
        assert_eq!(CardConfig::parse("\"num_leds=0\"").unwrap().limit("num_leds"), Some(0));
        assert_eq!(CardConfig::parse("").unwrap(), CardConfig::default());
    }

    #[test]
    fn what_cannot_be_had_is_refused_with_what_can() {
        let rows = [
            ("num_encoder=1", "no such entry: expected one of num_encoders=N"),
            ("num_encoders=two", "a whole number from -1 on"),
            ("num_encoders=-2", "a whole number from -1 on"),
            ("num_encoders=256", "at most 255"),
            ("stepgen_width=9", "expected 1 to 8 I/O pins, or -1"),
            ("stepgen_width=0", "expected 1 to 8 I/O pins, or -1"),
            ("sserial_port_8=0", "no such entry"),
            ("sserial_port_0=000000000", "expected up to eight letters"),
            ("sserial_port_0=0y", "expected up to eight letters"),
            ("sserial_port_0=", "expected up to eight letters"),
            ("firmware=hm2/5i25/7i76.bit", "which mesaflash loads"),
            ("num_resolvers=1", "not driven yet"),
            ("ssi_chan_0=a%24g", "not driven yet"),
            ("num_encoders", "no such entry"),
        ];
        for (text, says) in rows {
            let error = CardConfig::parse(text).unwrap_err().to_string();
            assert!(error.starts_with(&format!("config: '{text}': ")), "{error}");
            assert!(error.contains(says), "{text}: {error}");
        }
        assert!(CardConfig::parse("num_resolvers=0 num_uarts=-1").is_ok());
    }
}
