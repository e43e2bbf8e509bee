//! Reader for CSV files of Ferrule and of other programs.

use crate::{Flaw, Position, Reading, TimeBase, Trace};
use ::csv::{ByteRecord, ErrorKind, ReaderBuilder};
use hal_protocol::{Type, Value};

/// Reads a file.
#[must_use]
pub fn read(bytes: &[u8]) -> Reading {
    let mut reading = Reading::default();
    if bytes.iter().all(u8::is_ascii_whitespace) {
        reading.flaw = Some((Position::File, Flaw::Empty));
        return reading;
    }
    let mut table = Table::of(bytes);
    reading.flaw = table.read(&mut reading.trace).err();
    reading
}

/// Role of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    Channel(Type),
    Lost,
    Marker,
}

/// Rows of a file, after the comments before its header.
#[derive(Debug)]
struct Table<'a> {
    bytes: &'a [u8],
    /// Number of lines skipped before the header.
    skipped: u64,
    /// Channel names from a comment, as sigrok writes them.
    named: Vec<&'a str>,
    delimiter: u8,
    is_ours: bool,
    columns: Vec<Column>,
    /// Nanoseconds per unit of time in a table of another program. Its times are converted to
    /// nanoseconds.
    unit: f64,
}

type Stop = (Position, Flaw);

impl<'a> Table<'a> {
    fn of(bytes: &'a [u8]) -> Self {
        let mut rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let (mut skipped, mut named) = (0, Vec::new());
        while rest.starts_with(b";")
            || rest.starts_with(b"#")
            || rest.starts_with(b"\n")
            || rest.starts_with(b"\r\n")
        {
            let Some(end) = rest.iter().position(|b| *b == b'\n') else { break };
            let line = rest.get(..end).and_then(|line| core::str::from_utf8(line).ok());
            if let Some((_, names)) = line
                .and_then(|line| line.strip_prefix("; Channels ("))
                .and_then(|line| line.split_once("): "))
            {
                named = names.trim_end().split(", ").collect();
            }
            rest = rest.get(end + 1..).unwrap_or_default();
            skipped += 1;
        }
        let head = rest.split(|b| *b == b'\n').next().unwrap_or_default();
        let count = |d: u8| head.iter().filter(|b| **b == d).count();
        let delimiter = *b",;\t".iter().rev().max_by_key(|d| count(**d)).unwrap_or(&b',');
        Self {
            bytes: rest,
            skipped,
            named,
            delimiter,
            is_ours: false,
            columns: Vec::new(),
            unit: 1e9,
        }
    }

    /// Calls `each` for every row. The first row is the header.
    fn rows(&self, mut each: impl FnMut(&ByteRecord) -> Result<(), Flaw>) -> Result<(), Stop> {
        let mut reader = ReaderBuilder::new()
            .delimiter(self.delimiter)
            .has_headers(false)
            .flexible(true)
            .from_reader(self.bytes);
        let mut row = ByteRecord::new();
        loop {
            let line = Position::Line(reader.position().line() + self.skipped);
            match reader.read_byte_record(&mut row) {
                Ok(false) => return Ok(()),
                Ok(true) => each(&row).map_err(|flaw| (line, flaw))?,
                Err(e) => {
                    let what = match e.kind() {
                        ErrorKind::Utf8 { .. } => "this is not text".to_owned(),
                        _ => e.to_string(),
                    };
                    return Err((line, Flaw::Unreadable(what.into())));
                }
            }
        }
    }

    fn read(&mut self, trace: &mut Trace) -> Result<(), Stop> {
        let mut head = ByteRecord::new();
        let mut is_first = true;
        self.rows(|row| {
            if std::mem::take(&mut is_first) {
                head = row.clone();
            }
            Ok(())
        })?;
        let at = Position::Line(1 + self.skipped);
        let names = head.iter().map(|cell| core::str::from_utf8(cell).map(str::trim));
        let names: Result<Vec<&str>, _> = names.collect();
        let no_csv = |_| (Position::File, Flaw::Foreign { wanted: "CSV" });
        let names = names.map_err(no_csv)?;
        let Some((time, names)) = names.split_first() else { return Ok(()) };
        if names.is_empty() && self.bytes.contains(&0) {
            return Err((Position::File, Flaw::Foreign { wanted: "CSV" }));
        }
        let unit = unit(time);
        let Some(unit) = unit else {
            let what =
                format!("the first column is '{time}'; a time is expected, as in 'time [ns]'");
            let short: String = what.chars().take(200).collect();
            return Err((at, Flaw::Unreadable(short.into())));
        };
        let ours = time.strip_prefix("time [").and_then(|t| TimeBase::parse(t.strip_suffix(']')?));
        let typed =
            names.iter().filter(|n| **n != "lost" && **n != "marker").all(|n| kind(n).is_some());
        self.is_ours = ours.is_some() && typed;
        if let Some(base) = ours.filter(|_| self.is_ours) {
            trace.set_base(base);
            self.ours(trace, names);
        } else {
            self.unit = unit;
            self.others(trace, names)?;
        }
        let mut is_first = true;
        self.rows(|row| if std::mem::take(&mut is_first) { Ok(()) } else { self.row(trace, row) })?;
        if self.is_ours && !self.bytes.ends_with(b"\n") {
            let lines = self.bytes.split(|b| *b == b'\n').count() as u64;
            if let Some(last) = trace.times().last() {
                // The last value may be incomplete.
                *trace = trace.between(i64::MIN, last);
            }
            return Err((Position::Line(lines + self.skipped), Flaw::Truncated));
        }
        Ok(())
    }

    /// Adds the channels of a header that gives their types.
    fn ours(&mut self, trace: &mut Trace, names: &[&str]) {
        for name in names {
            self.columns.push(match kind(name) {
                Some((names, ty)) => {
                    let mut names = names.split(" = ");
                    let n = trace.add(names.next().unwrap_or_default(), ty);
                    names.for_each(|name| trace.also(n, name));
                    Column::Channel(ty)
                }
                None if *name == "lost" => Column::Lost,
                None => Column::Marker,
            });
        }
    }

    /// Adds the channels of a header without types. The values determine the types.
    fn others(&mut self, trace: &mut Trace, names: &[&str]) -> Result<(), Stop> {
        let types = [Type::Bit, Type::S64, Type::U64, Type::Float];
        let mut found = vec![0_usize; names.len()];
        let mut is_first = true;
        self.rows(|row| {
            if std::mem::take(&mut is_first) {
                return Ok(());
            }
            for (n, cell) in found.iter_mut().zip(row.iter().skip(1)) {
                let Some(text) = self.cell(cell).filter(|t| !t.is_empty()) else { continue };
                while types.get(*n).is_some_and(|ty| value(*ty, &text).is_none()) {
                    *n += 1;
                }
            }
            Ok(())
        })?;
        // sigrok uses the quantity as the column title, not the name.
        let names = if self.named.len() == names.len() { &self.named } else { names };
        for (name, n) in names.iter().zip(found) {
            let ty = types.get(n).copied().unwrap_or(Type::Float);
            trace.add(name, ty);
            self.columns.push(Column::Channel(ty));
        }
        Ok(())
    }

    /// Returns the text of a cell. Converts a decimal comma to a point if the comma is not the
    /// separator.
    fn cell(&self, cell: &[u8]) -> Option<String> {
        let text = core::str::from_utf8(cell).ok()?.trim();
        if !self.is_ours && self.delimiter != b',' {
            return Some(text.replace(',', "."));
        }
        Some(text.to_owned())
    }

    fn row(&self, trace: &mut Trace, row: &ByteRecord) -> Result<(), Flaw> {
        let wanted = self.columns.len() + 1;
        if row.len() != wanted {
            let what = format!("{} cells, where the head has {wanted}", row.len());
            return Err(Flaw::Unreadable(what.into()));
        }
        let cells = self.columns.iter().zip(row.iter().skip(1));
        let texts = cells.map(|(column, cell)| {
            // The text of a marker is kept unchanged.
            let text = if *column == Column::Marker {
                core::str::from_utf8(cell).ok().map(str::to_owned)
            } else {
                self.cell(cell)
            };
            text.ok_or_else(|| Flaw::Unreadable("this is not text".into()))
        });
        let texts: Vec<String> = texts.collect::<Result<_, _>>()?;
        let time = row.get(0).and_then(|cell| self.cell(cell)).unwrap_or_default();
        let mut lost = None;
        for (column, text) in self.columns.iter().zip(&texts) {
            match column {
                Column::Lost if !text.is_empty() => {
                    let wrong =
                        |_| Flaw::Value { channel: "lost".into(), value: text.as_str().into() };
                    lost = Some(text.parse().map_err(wrong)?);
                }
                Column::Marker if !text.is_empty() => {
                    trace.mark(self.time(&time)?, text);
                    return Ok(());
                }
                Column::Channel(_) | Column::Lost | Column::Marker => {}
            }
        }
        if let Some(lost) = lost {
            trace.lose(lost);
            if time.is_empty() {
                return Ok(());
            }
        }
        trace.sample(self.time(&time)?).map_err(Flaw::Refused)?;
        let mut n = 0;
        for (column, text) in self.columns.iter().zip(&texts) {
            let Column::Channel(ty) = column else { continue };
            let bits = if text.is_empty() {
                None
            } else {
                let Some(value) = value(*ty, text) else {
                    let channel = trace.channels().get(n).map_or("", |c| c.name()).into();
                    return Err(Flaw::Value { channel, value: text.as_str().into() });
                };
                Some(value.bits())
            };
            trace.set_bits(n, bits).map_err(Flaw::Refused)?;
            n += 1;
        }
        Ok(())
    }

    /// Parses a time and returns it in ticks.
    fn time(&self, text: &str) -> Result<i64, Flaw> {
        let wrong = || Flaw::Value { channel: "time".into(), value: text.into() };
        if self.is_ours {
            return text.parse().map_err(|_| wrong());
        }
        let ticks = (text.parse::<f64>().map_err(|_| wrong())? * self.unit).round();
        #[expect(clippy::cast_possible_truncation, reason = "it is seen to fit")]
        if ticks.abs() < 9e18 { Ok(ticks as i64) } else { Err(wrong()) }
    }
}

/// Splits `joint.0.pos (float)` into name and type.
fn kind(head: &str) -> Option<(&str, Type)> {
    let (name, ty) = head.strip_suffix(')')?.rsplit_once(" (")?;
    Some((name, Type::parse(ty)?))
}

/// Returns the number of nanoseconds per unit in the title of a time column: `time`, `t`,
/// `Time [us]`, `Time (s)`.
fn unit(head: &str) -> Option<f64> {
    let head = head.trim_matches('"').to_ascii_lowercase();
    let words = [
        ("seconds", "s"),
        ("sec", "s"),
        ("milliseconds", "ms"),
        ("microseconds", "us"),
        ("µs", "us"),
        ("nanoseconds", "ns"),
    ];
    let short = |unit: &str| words.iter().find(|(w, _)| *w == unit).map(|(_, u)| *u);
    if let Some(unit) = short(&head) {
        // sigrok uses the unit alone as the title of the time column.
        return TimeBase::parse(unit).map(|b| 10_f64.powi(i32::from(b.exponent()) + 9));
    }
    let (name, unit) = match head.split_once(['[', '(']) {
        Some((name, unit)) => (name.trim(), unit.trim_end_matches([']', ')']).trim()),
        None => (head.as_str(), "s"),
    };
    if !["time", "t", "timestamp", "x-axis"].contains(&name) {
        return None;
    }
    let unit = short(unit).unwrap_or(unit);
    Some(10_f64.powi(i32::from(TimeBase::parse(unit)?.exponent()) + 9))
}

/// Parses a value of a type.
fn value(ty: Type, text: &str) -> Option<Value> {
    match ty {
        // Rust parses every float that it formats back to the same bits.
        Type::Float => text.parse().ok().map(Value::Float),
        Type::Bit | Type::S32 | Type::U32 | Type::S64 | Type::U64 => {
            // Octal notation is not supported: `010` is ten.
            let is_octal = text.trim_start_matches(['-', '+']).starts_with("0") && text.len() > 1;
            let text = if is_octal { text.trim_start_matches('0') } else { text };
            Value::parse(ty, text).ok()
        }
        Type::Port => text.parse().ok().map(Value::Port),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Channel;

    fn all(trace: &Trace, name: &str) -> Vec<String> {
        let n = trace.find(name).unwrap();
        let one = |s| trace.value(n, s).map_or("?".to_owned(), |v| v.to_string());
        (0..trace.len()).map(one).collect()
    }

    #[test]
    fn tables_of_other_programs() {
        let text = "\u{feff}; made elsewhere\n# at noon\nTime [us];a;b;c;d\n0;0;1,5;;-1\n0,5;1;2;8;007\n1e1;0;x;9;3";
        let got = read(text.as_bytes());
        let (place, flaw) = got.flaw.unwrap();
        assert_eq!((place, flaw.to_string()), (Position::Line(6), "'b' cannot be 'x'".to_owned()));
        let t = got.trace;
        assert_eq!(t.times().iter().collect::<Vec<_>>(), [0, 500, 10_000]);
        let got = read(text.replace('x', "nan").as_bytes());
        assert_eq!(got.flaw, None);
        let t = got.trace;
        assert_eq!(
            t.channels().iter().map(Channel::ty).collect::<Vec<_>>(),
            [Type::Bit, Type::Float, Type::S64, Type::S64]
        );
        assert_eq!(all(&t, "b"), ["1.5", "2", "nan"]);
        assert_eq!(all(&t, "c"), ["?", "8", "9"]);
        assert_eq!(all(&t, "d"), ["-1", "7", "3"]);
    }

    #[test]
    fn a_table_of_sigrok() {
        let text = "; CSV generated by libsigrok 0.5.2\n; Channels (2/8): D0, D1\n; Samplerate: 1 MHz\n\
                    microseconds,logic,logic\n5,1,0\n10,0,1\n";
        let t = read(text.as_bytes()).whole().unwrap();
        assert_eq!(t.times().iter().collect::<Vec<_>>(), [5000, 10_000]);
        assert_eq!(
            (all(&t, "D0"), all(&t, "D1")),
            (
                vec!["TRUE".to_owned(), "FALSE".to_owned()],
                vec!["FALSE".to_owned(), "TRUE".to_owned()]
            )
        );
    }

    #[test]
    fn what_is_wrong_has_a_line() {
        for (text, want) in [
            (&b""[..], "the file is empty"),
            (b"\x7fELF\x02\x01\x01\0\0\0\xff\xfe", "this is not a CSV file"),
            (
                b"$date today $end\n",
                "1: the first column is '$date today $end'; a time is expected, as in 'time [ns]'",
            ),
            (b"time [ns],x (bit)\n5,0\n5,1\n", "3: time goes from 5 to 5"),
            (b"time [ns],x (bit)\n5,2\n", "2: 'x' cannot be '2'"),
            (b"time [ns],x (s32)\n5,2147483648\n", "2: 'x' cannot be '2147483648'"),
            (b"time [ns],x (bit)\n5,0,1\n", "2: 3 cells, where the head has 2"),
            (b"time [ns],x (bit)\n1.5,0\n", "2: 'time' cannot be '1.5'"),
            (b"time [ns],x (bit)\n1,0\n2,1", "3: the file ends too early"),
            (b"time [ns],x (bit)\n1,0\n2,\"1\n2,0\n", "3: 'x' cannot be '1"),
            (b"t,x\n1,\xff\n", "2: this is not text"),
            (b"t,x\ninf,1\n", "2: 'time' cannot be 'inf'"),
        ] {
            let (place, flaw) = read(text).flaw.unwrap();
            let line = if let Position::Line(n) = place { format!("{n}: ") } else { String::new() };
            let got = format!("{line}{flaw}");
            assert!(got.starts_with(want), "{got}");
        }
    }
}
