//! Initial contents of simulated hardware, before a component's first line runs: the file `NAME.sim` beside `NAME.so`.
//!
//! A line is `port 0x0448 0x00`, `port 0x044c-0x0452 0xff` or `config 0x88 0x0401`: one or several ports and the byte
//! they hold, or a double word of PCI configuration. `#` begins a comment. Ports named in the file have pins even if
//! the component claims none.

use crate::registers::Registers;
use std::{io::ErrorKind, path::Path};

/// Line of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Line {
    Port { first: u16, last: u16, value: u8 },
    Config { register: u8, value: u32 },
}

/// Applies the file beside `module`, if there is one.
///
/// # Errors
/// The file cannot be read, or a line is invalid: the error names the file, the line, and the valid form.
pub(crate) fn prepare(module: &Path, registers: &Registers) -> Result<(), String> {
    let file = module.with_extension("sim");
    let text = match std::fs::read_to_string(&file) {
        Ok(text) => text,
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(()),
        Err(e) => return Err(format!("{}: {e}", file.display())),
    };
    let parsed = lines(&text).map_err(|(n, why)| format!("{}:{n}: {why}", file.display()))?;
    for line in parsed {
        match line {
            Line::Port { first, last, value } => {
                registers.claim_as(first, (last - first).saturating_add(1), value);
            }
            Line::Config { register, value } => registers.configure(register, value),
        }
    }
    Ok(())
}

/// Parses all lines. An error holds the number of the first invalid line, and the reason.
fn lines(text: &str) -> Result<Vec<Line>, (usize, String)> {
    let mut all = Vec::new();
    for (n, line) in (1..).zip(text.lines()) {
        let words = line.split('#').next().unwrap_or_default();
        let words: Vec<&str> = words.split_whitespace().collect();
        if !words.is_empty() {
            all.push(parsed(&words).map_err(|why| (n, why))?);
        }
    }
    Ok(all)
}

fn parsed(words: &[&str]) -> Result<Line, String> {
    match *words {
        ["port", ports, value] => {
            let (first, last) = ports.split_once('-').unwrap_or((ports, ports));
            let first = number(first, "a port, 0 to 0xffff")?;
            let last = number(last, "a port, 0 to 0xffff")?;
            if last < first {
                return Err(format!("'{ports}' ends before it begins"));
            }
            Ok(Line::Port { first, last, value: number(value, "a byte, 0 to 0xff")? })
        }
        ["config", register, value] => {
            let register: u8 = number(register, "a register, 0 to 0xfc")?;
            if !register.is_multiple_of(4) {
                return Err(format!("register {register:#04x} is not a multiple of 4"));
            }
            Ok(Line::Config { register, value: number(value, "a double word, 0 to 0xffffffff")? })
        }
        _ => Err(format!(
            "'{}': a line is 'port 0x0378 0xff', 'port 0x0378-0x037a 0', or 'config 0x88 0x0401'",
            words.join(" ")
        )),
    }
}

fn number<N: TryFrom<u64>>(word: &str, what: &str) -> Result<N, String> {
    let n = match word.strip_prefix("0x") {
        Some(hex) => u64::from_str_radix(hex, 16).ok(),
        None => word.parse().ok(),
    };
    n.and_then(|n| N::try_from(n).ok()).ok_or_else(|| format!("'{word}' is not {what}"))
}

#[cfg(test)]
mod tests {
    use super::{Line, lines};

    #[test]
    fn a_board_line_by_line() {
        let text = "# a board\n\nport 0x448 16 # input\nport 0x44c-0x452 0xff\nconfig 0x88 0x401\n";
        let port = |first, last, value| Line::Port { first, last, value };
        assert_eq!(
            lines(text),
            Ok(vec![
                port(0x448, 0x448, 16),
                port(0x44c, 0x452, 0xff),
                Line::Config { register: 0x88, value: 0x401 },
            ])
        );
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        for (line, said) in [
            ("port 0x448", "'port 0x448': a line is"),
            ("port 0x10000 0", "'0x10000' is not a port, 0 to 0xffff"),
            ("port 0x448 0x100", "'0x100' is not a byte, 0 to 0xff"),
            ("port 9-8 0", "'9-8' ends before it begins"),
            ("config 0x89 0", "register 0x89 is not a multiple of 4"),
            ("config 0x88 x", "'x' is not a double word"),
            ("pin 1 2", "'pin 1 2': a line is"),
        ] {
            let (n, why) = lines(&format!("# first\n{line}\n")).unwrap_err();
            assert_eq!(n, 2);
            assert!(why.starts_with(said), "{line}: {why}");
        }
    }
}
