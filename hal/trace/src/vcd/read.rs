//! Reader for VCD files of Ferrule and of other programs.

use super::kinds::known;
use crate::{Flaw, Position, Reading, TimeBase, Trace};
use hal_protocol::{Type, Value};
use std::collections::BTreeMap;
use vcd::{Command, IdCode, ParseError, ParseErrorKind, Parser, TimescaleUnit, VarType};

/// Reads a file. Non-numeric variables (strings, events) and values wider than 64 bits are left out
/// with a note.
#[must_use]
pub fn read(bytes: &[u8]) -> Reading {
    let mut reader = Reader::default();
    if bytes.iter().all(u8::is_ascii_whitespace) {
        let flaw = Some((Position::File, Flaw::Empty));
        return Reading { flaw, ..Reading::default() };
    }
    let (skipped, bytes) = after_preamble(bytes);
    // Other programs may omit the newline at the end of the file. Ferrule always writes it, so
    // without it the file was cut off.
    let ours = bytes.starts_with(b"$version Ferrule $end");
    let end: &[u8] = if ours || bytes.ends_with(b"\n") { b"" } else { b"\n" };
    let lines = skipped + bytes.trim_ascii_end().split(|b| *b == b'\n').count() as u64;
    let (head, body) = known(bytes);
    let values = std::io::Read::chain(body, end);
    let mut parser = Parser::new(std::io::Read::chain(&*head, values));
    let flaw = reader.all(&mut parser).err().map(|flaw| {
        let begun = reader.is_vcd;
        let flaw = if begun { flaw } else { Flaw::Foreign { wanted: "VCD" } };
        let line = Position::Line((skipped + parser.line()).min(lines));
        let place = if begun { line } else { Position::File };
        (place, flaw)
    });
    let mut trace = reader.trace;
    if let (Some((_, Flaw::Truncated | Flaw::Short { .. })), Some(last)) =
        (&flaw, trace.times().last())
    {
        // The last sample may be incomplete.
        trace = trace.between(i64::MIN, last);
    }
    Reading { trace, notes: reader.notes, flaw }
}

/// Meaning of a code.
#[derive(Clone, Copy, Debug)]
enum Var {
    /// A channel, and its width in bits.
    Channel(usize, u32),
    /// A variable that is left out.
    Nothing,
}

#[derive(Debug, Default)]
struct Reader {
    trace: Trace,
    notes: Vec<String>,
    /// True once something was read that occurs only in VCD.
    is_vcd: bool,
    /// Declarations, until the header ends.
    head: Vec<Declared>,
    scopes: Vec<String>,
    vars: BTreeMap<IdCode, Var>,
    /// Number of samples that a file of Ferrule declares. Such a file also has an end mark.
    samples: Option<u64>,
    is_open: bool,
    has_ended: bool,
}

#[derive(Debug)]
struct Declared {
    code: IdCode,
    name: String,
    ty: Option<Type>,
    width: u32,
}

impl Reader {
    fn all<R: std::io::BufRead>(&mut self, parser: &mut Parser<R>) -> Result<(), Flaw> {
        while let Some(command) = parser.next() {
            match command {
                Ok(command) => self.command(command)?,
                Err(e) => {
                    let kind = e.get_ref().and_then(|e| e.downcast_ref::<ParseError>());
                    let kind = kind.map(|e| e.kind().clone());
                    match kind {
                        // Skip `$timezero`, `$attrbegin` and other commands that the parser does
                        // not know.
                        Some(ParseErrorKind::UnknownCommand) if self.is_vcd => skip(parser)?,
                        Some(kind) => return Err(Flaw::Unreadable(kind.to_string().into())),
                        None => return Err(Flaw::Truncated),
                    }
                }
            }
        }
        let got = self.trace.len() as u64;
        match self.samples {
            _ if !self.is_open => Err(Flaw::Truncated),
            Some(said) if got != said => Err(Flaw::Short { got, said }),
            Some(_) if !self.has_ended => Err(Flaw::Truncated),
            _ => Ok(()),
        }
    }

    fn command(&mut self, command: Command) -> Result<(), Flaw> {
        match command {
            Command::Version(_) | Command::Date(_) => self.is_vcd = true,
            Command::Timescale(number, unit) => {
                self.is_vcd = true;
                let base = base(number, unit).ok_or_else(|| {
                    Flaw::Unreadable(format!("a time unit of {number} {unit}").into())
                })?;
                self.trace.set_base(base);
            }
            Command::ScopeDef(_, name) => {
                self.is_vcd = true;
                self.scopes.push(name);
            }
            Command::Upscope => drop(self.scopes.pop()),
            Command::VarDef(kind, width, code, name, index) => {
                self.is_vcd = true;
                // The index `[7:0]` of a whole vector carries no information; `[3]` of a single bit
                // does.
                let index = index.map(|i| i.to_string()).filter(|_| width == 1);
                let name = format!("{name}{}", index.unwrap_or_default());
                let path: Vec<&str> =
                    self.scopes.iter().map(String::as_str).chain([&*name]).collect();
                let ty = kind_of(kind, width);
                self.head.push(Declared { code, name: path.join("."), ty, width });
            }
            Command::Enddefinitions => self.open(),
            Command::Comment(text) => self.comment(&text)?,
            Command::Timestamp(time) => {
                self.must_be_open()?;
                let time = i64::try_from(time)
                    .map_err(|_| Flaw::Unreadable("a time that is too large".into()))?;
                // Some programs repeat a time.
                if self.trace.times().last() != Some(time) {
                    self.trace.sample(time).map_err(Flaw::Refused)?;
                }
            }
            Command::ChangeScalar(code, value) => {
                let bits = match value {
                    vcd::Value::V0 => Some(0),
                    vcd::Value::V1 => Some(1),
                    vcd::Value::X | vcd::Value::Z => None,
                };
                self.change(code, |ty, _| match bits {
                    Some(_) if ty == Type::Float => Err(value.to_string()),
                    _ => Ok(bits),
                })?;
            }
            Command::ChangeVector(code, vector) => {
                self.change(code, |ty, width| bits_of(ty, width, &vector))?;
            }
            Command::ChangeReal(code, x) => self.change(code, |ty, _| {
                if ty == Type::Float { Ok(Some(x.to_bits())) } else { Err(x.to_string()) }
            })?,
            Command::ChangeString(code, _) => drop(self.found(code)?),
            _ => {}
        }
        Ok(())
    }

    fn must_be_open(&self) -> Result<(), Flaw> {
        if self.is_open { Ok(()) } else { Err(Flaw::Unreadable("a value in the head".into())) }
    }

    /// Ends the header. Its declarations become channels, in the order of their codes.
    fn open(&mut self) {
        self.is_open = true;
        let mut head = std::mem::take(&mut self.head);
        head.sort_by_key(|d| number(d.code));
        for d in head {
            match (self.vars.get(&d.code), d.ty) {
                (Some(Var::Channel(n, _)), _) => self.trace.also(*n, &d.name),
                (None, Some(ty)) => {
                    let n = self.trace.add(&d.name, ty);
                    self.vars.insert(d.code, Var::Channel(n, d.width));
                }
                _ => {
                    let why = if d.width > 64 { "wider than 64 bits" } else { "not a number" };
                    self.notes.push(format!("'{}' is {why} and left out", d.name));
                    self.vars.insert(d.code, Var::Nothing);
                }
            }
        }
    }

    fn found(&self, code: IdCode) -> Result<Var, Flaw> {
        self.must_be_open()?;
        let var = self.vars.get(&code).copied();
        var.ok_or_else(|| Flaw::Undeclared(code.to_string().into()))
    }

    /// Sets the value of a code. `bits` computes it from the type and width, or returns the text of
    /// an invalid value.
    fn change(
        &mut self,
        code: IdCode,
        bits: impl FnOnce(Type, u32) -> Result<Option<u64>, String>,
    ) -> Result<(), Flaw> {
        let Var::Channel(n, width) = self.found(code)? else { return Ok(()) };
        let Some(channel) = self.trace.channels().get(n) else { return Ok(()) };
        let bits = bits(channel.ty(), width)
            .map_err(|value| Flaw::Value { channel: channel.name().into(), value: value.into() })?;
        if self.trace.is_empty() {
            // Values before the first time are valid from zero on.
            self.trace.sample(0).map_err(Flaw::Refused)?;
        }
        self.trace.set_bits(n, bits).map_err(Flaw::Refused)
    }

    /// Processes a comment of a Ferrule file. Comments of other programs are ignored.
    fn comment(&mut self, text: &str) -> Result<(), Flaw> {
        let (word, rest) = text.split_once(' ').unwrap_or((text, ""));
        match word {
            "end" => self.has_ended = true,
            "samples" => self.samples = rest.parse().ok(),
            "lost" => {
                if let Ok(lost) = rest.parse() {
                    self.trace.lose(lost);
                }
            }
            "marker" => {
                let found = rest.split_once(' ').and_then(|(at, text)| {
                    Some((at.parse().ok()?, serde_json::from_str::<String>(text).ok()?))
                });
                if let Some((at, text)) = found {
                    self.trace.mark(at, &text);
                }
            }
            "unknown" => {
                if let Ok(code) = rest.parse() {
                    // Ignore comments that only look like ours.
                    drop(self.change(code, |_, _| Ok(None)));
                }
            }
            _ => {}
        }
        Ok(())
    }
}

/// Returns the number of lines that some programs write before the header, and the rest of the
/// file.
fn after_preamble(bytes: &[u8]) -> (u64, &[u8]) {
    let mut rest = bytes;
    for skipped in 0..4 {
        if rest.trim_ascii_start().starts_with(b"$") {
            return (skipped, rest);
        }
        let Some(end) = rest.iter().position(|b| *b == b'\n') else { break };
        rest = rest.get(end + 1..).unwrap_or_default();
    }
    (0, bytes)
}

/// Skips an unknown command up to its `$end`.
fn skip<R: std::io::BufRead>(parser: &mut Parser<R>) -> Result<(), Flaw> {
    let mut last = [0; 4];
    for byte in std::io::Read::bytes(parser.reader()) {
        let byte = byte.map_err(|_| Flaw::Truncated)?;
        last.rotate_left(1);
        last[3] = byte;
        if &last == b"$end" {
            return Ok(());
        }
    }
    Err(Flaw::Truncated)
}

/// Returns the position of a code in the order in which codes are assigned.
fn number(code: IdCode) -> u64 {
    let digits = code.to_string();
    digits
        .bytes()
        .rev()
        .fold(0, |n: u64, b| n.saturating_mul(94).saturating_add(u64::from(b.saturating_sub(b'!'))))
}

fn base(number: u32, unit: TimescaleUnit) -> Option<TimeBase> {
    let more = match number {
        1 => 0,
        10 => 1,
        100 => 2,
        _ => return None,
    };
    let exponent = match unit {
        TimescaleUnit::S => 0,
        TimescaleUnit::MS => -3,
        TimescaleUnit::US => -6,
        TimescaleUnit::NS => -9,
        TimescaleUnit::PS => -12,
        TimescaleUnit::FS => -15,
    };
    TimeBase::power(exponent + more)
}

fn kind_of(kind: VarType, width: u32) -> Option<Type> {
    match (kind, width) {
        (VarType::Real, _) => Some(Type::Float),
        (VarType::String | VarType::Event, _) | (_, 0 | 65..) => None,
        (VarType::Integer, 1..=32) => Some(Type::S32),
        (VarType::Integer, _) => Some(Type::S64),
        (_, 1) => Some(Type::Bit),
        (_, 2..=32) => Some(Type::U32),
        (_, _) => Some(Type::U64),
    }
}

/// Returns the bits of a vector, or `None` if one of them is unknown.
fn bits_of(ty: Type, width: u32, vector: &vcd::Vector) -> Result<Option<u64>, String> {
    let wrong = || vector.to_string();
    if vector.len() > 64 || ty == Type::Float {
        return Err(wrong());
    }
    let mut bits = 0_u64;
    for v in vector {
        let bit = match v {
            vcd::Value::V0 => 0,
            vcd::Value::V1 => 1,
            vcd::Value::X | vcd::Value::Z => return Ok(None),
        };
        bits = bits << 1 | bit;
    }
    if width < 64 && bits >> width != 0 {
        return Err(wrong());
    }
    // Sign-extend an integer that is shorter than its HAL type.
    let is_signed = matches!(ty, Type::S32 | Type::S64);
    let is_negative = is_signed && width < 64 && bits >> (width.saturating_sub(1)) == 1;
    let bits = if is_negative { bits | u64::MAX << width } else { bits };
    Ok(Some(Value::from_bits(ty, bits).bits()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vcd::write;

    #[test]
    fn what_stands_before_the_head_is_passed_over() {
        let text = "META samplerate: 1000\n$var wire 1 ! x $end\n$enddefinitions $end\n#1 1!\n#0\n";
        let got = read(text.as_bytes());
        assert_eq!(got.trace.find("x"), Some(0));
        let (place, flaw) = got.flaw.unwrap();
        assert_eq!(
            (place, flaw.to_string()),
            (Position::Line(5), "time goes from 1 to 0".to_owned())
        );
    }

    #[test]
    fn what_other_programs_write() {
        let text = "$date today $end\r\n$version other $end\r\n$timescale 10us $end\r\n$timezero 0 $end\n\
            $scope module top $end\n$var reg 8 # bus [7:0] $end\n$var wire 1 a bus [3] $end\n\
            $var string 1 s why $end\n$var wire 65 w wide $end\n$var integer 16 i n $end\n\
            $upscope $end\n$enddefinitions $end\nx# x\nbx0 #\n1a\nshello s\nb101 w\n\
            #5\nb1010 #\nza\nb1111111111111110 i\n#5\nB11 i\n$comment lost count $end\n#7";
        let got = read(text.replace("x# x\n", "").as_bytes());
        assert_eq!(got.flaw, None);
        assert_eq!(
            got.notes,
            [
                "'top.why' is not a number and left out",
                "'top.wide' is wider than 64 bits and left out"
            ]
        );
        let t = got.trace;
        assert_eq!(t.base(), TimeBase::power(-5).unwrap());
        assert_eq!(t.times().iter().collect::<Vec<_>>(), [0, 5, 7]);
        let all = |name| {
            let n = t.find(name).unwrap();
            (0..3).map(|s| t.value(n, s).map(|v| v.to_string())).collect::<Vec<_>>()
        };
        assert_eq!(all("top.bus"), [None, Some("10".to_owned()), Some("10".to_owned())]);
        assert_eq!(all("top.bus[3]"), [Some("TRUE".to_owned()), None, None]);
        assert_eq!(all("top.n"), [None, Some("3".to_owned()), Some("3".to_owned())]);
    }

    #[test]
    fn what_is_wrong_has_a_line() {
        let head = "$var real 64 ! x $end\n$var wire 2 \" y $end\n$enddefinitions $end\n";
        for (text, want) in [
            ("", "the file is empty"),
            ("\n \n", "the file is empty"),
            ("\u{7f}ELF\0\u{1}", "this is not a VCD file"),
            ("time,x\n1,2\n", "this is not a VCD file"),
            ("$version Ferrule $end\n", "line 1: the file ends too early"),
            ("HEAD#5\nr1 !\n#4\n", "line 6: time goes from 5 to 4"),
            ("HEAD#5\nr1 %\n", "line 5: a value for '%', which is not declared"),
            ("HEAD#5\nrred !\n", "line 5: invalid float literal"),
            ("HEAD#5\n1!\n", "line 5: 'x' cannot be '1'"),
            ("HEAD#5\nb101 \"\n", "line 5: 'y' cannot be '101'"),
            ("HEAD#5\n\u{fe}\n", "line 5: unexpected character at start of command"),
            ("HEAD#5\n#99999999999999999999\n", "line 5: number too large to fit in target type"),
            (
                "$comment samples 3 $end\nHEAD#5\n#6\n",
                "line 6: the file ends too early: 2 samples of 3",
            ),
        ] {
            let (place, flaw) = read(text.replace("HEAD", head).as_bytes()).flaw.unwrap();
            let got = match place {
                Position::Line(line) => format!("line {line}: {flaw}"),
                Position::File | Position::Byte(_) => flaw.to_string(),
            };
            assert_eq!(got, want, "{text}");
        }
    }

    #[test]
    fn what_is_cut_off_is_said_and_what_came_before_is_kept() {
        let mut t = Trace::default();
        let (x, n) = (t.add("a.x", Type::Float), t.add("n", Type::S64));
        for i in 0..40_u8 {
            t.sample(i64::from(i) * 1000).unwrap();
            t.set(x, Value::Float(f64::from(i / 3) / 7.0)).unwrap();
            t.set(n, Value::S64(i64::from(i) - 20)).unwrap();
        }
        t.mark(15_000, "$end of \"it\"\n");
        let bytes = write(Vec::new(), &t).unwrap();
        assert_eq!(read(&bytes), Reading { trace: t.clone(), ..Reading::default() });
        for end in 0..bytes.len() - 1 {
            let got = read(&bytes[..end]);
            assert!(got.flaw.is_some(), "cut at {end}");
            for (sample, time) in got.trace.times().iter().enumerate() {
                assert_eq!(t.times().get(sample), Some(time));
                assert_eq!(
                    (got.trace.value(x, sample), got.trace.value(n, sample)),
                    (t.value(x, sample), t.value(n, sample))
                );
            }
        }
    }
}
