//! Profiles: TOML files with options of halrun that a user would otherwise give every time.
//!
//! An option takes precedence over its environment variable, and that over the profile.

use crate::{Error, ini::plain, language::hint::nearest};
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue};

/// Environment variable that names the profile.
pub const VARIABLE: &str = "HAL_PROFILE";

/// Form of a key's value.
#[derive(Clone, Copy, Debug)]
enum Form {
    /// `true` or `false`.
    Flag,
    /// Text.
    Text,
    /// A word from a list.
    Word(&'static [&'static str]),
    /// File name, relative to the profile's folder.
    File,
    /// List of folders, relative to the profile's folder.
    Folders,
}

/// A key of a profile.
#[derive(Debug)]
struct Key {
    name: &'static str,
    form: Form,
    /// Environment variable with the same effect.
    variable: &'static str,
    help: &'static str,
}

const KEYS: &[Key] = &[
    Key {
        name: "clock",
        form: Form::Word(&["real", "virtual"]),
        variable: "HAL_CLOCK",
        help: "the clock: `\"real\"` or `\"virtual\"`",
    },
    Key {
        name: "simulate",
        form: Form::Flag,
        variable: "HAL_SIMULATE",
        help: "simulate the hardware",
    },
    Key {
        name: "hold",
        form: Form::Flag,
        variable: "HAL_HOLD",
        help: "move the virtual clock only in `run TIME`",
    },
    Key {
        name: "for",
        form: Form::Text,
        variable: "HAL_FOR",
        help: "end after this much machine time, such as `\"2s\"`",
    },
    Key {
        name: "record",
        form: Form::File,
        variable: "HAL_RECORD",
        help: "record every pin to this file",
    },
    Key {
        name: "instance",
        form: Form::Text,
        variable: "HAL_INSTANCE",
        help: "the name of the instance",
    },
    Key {
        name: "rtmod-dir",
        form: Form::Folders,
        variable: "HAL_RTMOD_DIR",
        help: "folders with plugins and components in C, a list",
    },
    Key {
        name: "linuxcnc-modules",
        form: Form::Flag,
        variable: "HAL_LINUXCNC_MODULES",
        help: "find LinuxCNC's own components in C too",
    },
    Key {
        name: "cpu",
        form: Form::Text,
        variable: "HAL_CPU",
        help: "the processor of the threads, such as `\"3\"`",
    },
    Key {
        name: "dma-latency",
        form: Form::Text,
        variable: "HAL_DMA_LATENCY",
        help: "longest wake-up time of processors, in microseconds, or `\"off\"`",
    },
    Key {
        name: "stuck-time",
        form: Form::Text,
        variable: "HAL_STUCK_TIME",
        help: "stop the machine when a function does not return for this long, such as `\"5ms\"`",
    },
    Key {
        name: "max-gap",
        form: Form::Text,
        variable: "HAL_MAX_GAP",
        help: "switch motion off after the process stood still for this long, such as `\"500ms\"`",
    },
    Key {
        name: "compat",
        form: Form::Text,
        variable: "HAL_COMPAT",
        help: "`\"2.9\"` for the first values of LinuxCNC 2.9, where 2.10 has others",
    },
    Key {
        name: "log",
        form: Form::Text,
        variable: "HAL_LOG",
        help: "messages that are shown, such as `\"component=stepgen thread=servo\"`",
    },
];

/// Content of a profile.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Profile {
    /// Variables and their values.
    values: Vec<(&'static str, String)>,
}

impl Profile {
    /// Reads the profile that the environment names. Returns an empty profile if it names none.
    ///
    /// # Errors
    /// The profile cannot be read or is invalid.
    pub fn of_environment() -> Result<Self, Error> {
        let file = std::env::var(VARIABLE).unwrap_or_default();
        if file.is_empty() { Ok(Self::default()) } else { Self::read(Path::new(&file)) }
    }

    /// Reads a profile.
    ///
    /// # Errors
    /// The file cannot be read or is invalid. The error has file, line and remedy.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let refuse = |line: u32, why: String| Error::Profile {
            place: if line == 0 { shown(path) } else { format!("{}:{line}", shown(path)) }.into(),
            why: why.into(),
        };
        let text = std::fs::read_to_string(path).map_err(|e| refuse(0, plain(&e).into()))?;
        let line = |at: usize| {
            let before = text.get(..at).unwrap_or(&text);
            u32::try_from(before.matches('\n').count() + 1).unwrap_or(u32::MAX)
        };
        let table = DeTable::parse(&text).map_err(|e| {
            let at = e.span().map_or(0, |s| s.start);
            refuse(line(at), e.message().to_owned())
        })?;
        let folder = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let folder = folder.parent().unwrap_or(Path::new("/"));
        let mut values = Vec::new();
        for (name, value) in table.get_ref() {
            let at = line(name.span().start);
            let key = KEYS.iter().find(|k| k.name == name.get_ref().as_ref());
            let key = key.ok_or_else(|| refuse(at, unknown(name.get_ref())))?;
            let value = key.value(value.get_ref(), folder).map_err(|why| refuse(at, why))?;
            values.push((key.variable, value));
        }
        Ok(Self { values })
    }

    /// Returns the value of a variable from the environment, or else from the profile.
    pub fn value(
        &self,
        environment: &dyn Fn(&str) -> Option<String>,
        variable: &str,
    ) -> Option<String> {
        let said =
            || self.values.iter().find(|(v, _)| *v == variable).map(|(_, said)| said.clone());
        environment(variable).filter(|v| !v.is_empty()).or_else(said)
    }

    /// Returns the value of a variable from this process's environment, or else from the profile.
    pub fn system(&self, variable: &str) -> Option<String> {
        self.value(&|name| std::env::var(name).ok(), variable)
    }
}

impl Key {
    /// Converts a value to the form of the environment variable.
    fn value(&self, value: &DeValue<'_>, folder: &Path) -> Result<String, String> {
        let whole = |name: &str| folder.join(name).display().to_string();
        let wrong = |what: &str| Err(format!("'{}' is {what}", self.name));
        match (self.form, value) {
            (Form::Flag, DeValue::Boolean(on)) => Ok(u8::from(*on).to_string()),
            (Form::Text, DeValue::String(text)) => Ok(text.clone().into_owned()),
            (Form::File, DeValue::String(text)) => Ok(whole(text)),
            (Form::Word(words), DeValue::String(text)) if words.contains(&text.as_ref()) => {
                Ok(text.clone().into_owned())
            }
            (Form::Folders, DeValue::Array(list)) => {
                let folder = |item: &toml::Spanned<DeValue<'_>>| match item.get_ref() {
                    DeValue::String(text) if !text.contains(':') => Some(whole(text)),
                    _ => None,
                };
                let folders: Option<Vec<String>> = list.iter().map(folder).collect();
                folders.map_or_else(|| wrong(FOLDERS), |list| Ok(list.join(":")))
            }
            (Form::Flag, _) => wrong("true or false"),
            (Form::Text | Form::File, _) => wrong("a text in quotes"),
            (Form::Word(words), _) => wrong(&format!("\"{}\"", words.join("\" or \""))),
            (Form::Folders, _) => wrong(FOLDERS),
        }
    }
}

const FOLDERS: &str = "a list of folders, such as [\"modules\", \"/opt/machine\"]";

fn unknown(name: &str) -> String {
    let names = || KEYS.iter().map(|k| k.name);
    let near = nearest(name, names()).map(|near| format!("; did you mean '{near}'?"));
    let all: Vec<&str> = names().collect();
    format!("no key '{name}'{}", near.unwrap_or_else(|| format!("; there are {}", all.join(", "))))
}

fn shown(path: &Path) -> String {
    PathBuf::from(path).display().to_string()
}

/// Returns the table of keys for the README.
#[must_use]
pub fn markdown() -> String {
    let line = |k: &Key| format!("| `{}` | {} | `{}` |\n", k.name, k.help, k.variable);
    let lines: String = KEYS.iter().map(line).collect();
    format!("| key | what it says | variable |\n|---|---|---|\n{lines}")
}

#[cfg(test)]
mod tests {
    use super::{Profile, markdown};

    fn read(text: &str) -> Result<Profile, String> {
        let folder = std::env::temp_dir().join(format!("hal-profile-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join(format!(
            "{:x}.toml",
            text.bytes().fold(7_u64, |h, b| h * 31 % 0xFFFF_FFFF + u64::from(b))
        ));
        std::fs::write(&file, text).unwrap();
        let shown = format!("{}/", folder.display());
        Profile::read(&file).map_err(|e| {
            let text = e.whole().replace(&shown, "");
            text.split_once(".toml").map_or(text.clone(), |(_, rest)| rest.to_owned())
        })
    }

    #[test]
    fn the_environment_is_asked_first() {
        let profile = read(
            "clock = \"virtual\"\nhold = true\nsimulate = false\nfor = \"2s\"\n\
                            rtmod-dir = [\"mine\", \"/opt/x\"]\nlinuxcnc-modules = true\n",
        )
        .unwrap();
        let environment = |name: &str| (name == "HAL_FOR").then(|| "5s".to_owned());
        let value = |name| profile.value(&environment, name);
        assert_eq!(value("HAL_FOR").as_deref(), Some("5s"));
        assert_eq!(value("HAL_CLOCK").as_deref(), Some("virtual"));
        assert_eq!(value("HAL_HOLD").as_deref(), Some("1"));
        assert_eq!(value("HAL_SIMULATE").as_deref(), Some("0"));
        assert_eq!(value("HAL_LINUXCNC_MODULES").as_deref(), Some("1"));
        assert_eq!(value("HAL_INSTANCE"), None);
        let folders = value("HAL_RTMOD_DIR").unwrap();
        assert!(folders.starts_with('/') && folders.ends_with("/mine:/opt/x"), "{folders}");
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        for (text, said) in [
            (
                "clock = \"virtual\"\nsimulat = true\n",
                ":2: no key 'simulat'; did you mean 'simulate'?",
            ),
            (
                "x = 1\n",
                ":1: no key 'x'; there are clock, simulate, hold, for, record, instance, rtmod-dir, linuxcnc-modules, cpu, dma-latency, stuck-time, max-gap, compat, log",
            ),
            ("clock = \"fast\"\n", ":1: 'clock' is \"real\" or \"virtual\""),
            ("\nhold = 1\n", ":2: 'hold' is true or false"),
            ("for = 2\n", ":1: 'for' is a text in quotes"),
            (
                "rtmod-dir = \"x\"\n",
                ":1: 'rtmod-dir' is a list of folders, such as [\"modules\", \"/opt/machine\"]",
            ),
            ("hold = true\nhold = true\n", ":2: duplicate key"),
        ] {
            assert_eq!(read(text).unwrap_err(), said, "{text}");
        }
        let missing = Profile::read(std::path::Path::new("/none/x.toml")).unwrap_err().whole();
        assert_eq!(missing, "/none/x.toml: No such file or directory");
    }

    #[test]
    fn the_readme_has_the_keys() {
        let readme = include_str!("../../README.md");
        assert!(readme.contains(&markdown()), "halcmd/README.md should contain:\n{}", markdown());
    }
}
