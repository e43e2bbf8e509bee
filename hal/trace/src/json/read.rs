//! Reader for JSON traces. Samples are added one by one, so that those before a flaw are kept.

use super::FORMAT;
use crate::{Flaw, Position, Reading, TimeBase, Trace};
use hal_protocol::{Type, Value};
use serde::{
    Deserialize,
    de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor},
};

/// Reads a file.
#[must_use]
pub fn read(bytes: &[u8]) -> Reading {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        let flaw = Some((Position::File, Flaw::Empty));
        return Reading { flaw, ..Reading::default() };
    }
    let mut file = File::default();
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let done = file.deserialize(&mut json).and_then(|()| json.end());
    let flaw = done.err().map(|e| {
        let line = Position::Line(u64::try_from(e.line()).unwrap_or(0).max(1));
        if !file.is_ours {
            return (Position::File, Flaw::Foreign { wanted: "JSON trace" });
        }
        if e.is_eof() {
            return (line, Flaw::Truncated);
        }
        let text = e.to_string();
        // The caller reports the line together with the file name.
        let text = text.split(" at line ").next().unwrap_or(&text);
        (line, Flaw::Unreadable(text.into()))
    });
    Reading { trace: file.trace, notes: Vec::new(), flaw }
}

#[derive(Debug, Default)]
struct File {
    trace: Trace,
    is_ours: bool,
}

#[derive(Deserialize)]
struct ChannelRow {
    names: Vec<String>,
    r#type: String,
}

#[derive(Deserialize)]
struct GapRow {
    sample: u32,
    lost: u64,
}

#[derive(Deserialize)]
struct MarkerRow {
    at: i64,
    text: String,
}

impl<'de> DeserializeSeed<'de> for &mut File {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, d: D) -> Result<(), D::Error> {
        d.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for &mut File {
    type Value = ();

    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("a trace")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let mut has_samples = false;
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "format" => self.is_ours = map.next_value::<String>()? == FORMAT,
                "version" => {
                    let version: u64 = map.next_value()?;
                    if version != 1 {
                        return Err(A::Error::custom(format!("version {version}; 1 is known")));
                    }
                }
                "tick" => {
                    let tick: String = map.next_value()?;
                    let base = TimeBase::parse(&tick);
                    let wrong = || A::Error::custom(format!("'{tick}' is not a unit of time"));
                    self.trace.set_base(base.ok_or_else(wrong)?);
                }
                "channels" => {
                    for row in map.next_value::<Vec<ChannelRow>>()? {
                        let ty = Type::parse(&row.r#type).ok_or_else(|| {
                            A::Error::custom(format!("'{}' is not a type", row.r#type))
                        })?;
                        let mut names = row.names.iter();
                        let n = self.trace.add(names.next().map_or("", String::as_str), ty);
                        names.for_each(|name| self.trace.also(n, name));
                    }
                }
                "gaps" => {
                    for row in map.next_value::<Vec<GapRow>>()? {
                        self.trace.lost_before(row.sample as usize, row.lost);
                    }
                }
                "markers" => {
                    for row in map.next_value::<Vec<MarkerRow>>()? {
                        self.trace.mark(row.at, &row.text);
                    }
                }
                "samples" => {
                    has_samples = true;
                    map.next_value_seed(Samples(&mut self.trace))?;
                }
                _ => drop(map.next_value::<IgnoredAny>()?),
            }
        }
        if has_samples { Ok(()) } else { Err(A::Error::custom("there are no 'samples'")) }
    }
}

/// Deserializer of all samples.
struct Samples<'a>(&'a mut Trace);

impl<'de> DeserializeSeed<'de> for Samples<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, d: D) -> Result<(), D::Error> {
        d.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for Samples<'_> {
    type Value = ();

    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("samples")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut rows: A) -> Result<(), A::Error> {
        let mut record = Vec::new();
        while let Some(time) = rows.next_element_seed(Sample(self.0, &mut record))? {
            self.0.sample(time).map_err(A::Error::custom)?;
            for (n, bits) in record.iter().enumerate() {
                self.0.set_bits(n, *bits).map_err(A::Error::custom)?;
            }
        }
        Ok(())
    }
}

/// Deserializer of one sample. Returns the time and puts the values into the record.
struct Sample<'a>(&'a Trace, &'a mut Vec<Option<u64>>);

impl<'de> DeserializeSeed<'de> for Sample<'_> {
    type Value = i64;

    fn deserialize<D: Deserializer<'de>>(self, d: D) -> Result<i64, D::Error> {
        d.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for Sample<'_> {
    type Value = i64;

    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("a time and values")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut row: A) -> Result<i64, A::Error> {
        let Self(trace, record) = self;
        record.clear();
        let time = row.next_element::<i64>()?;
        let time = time.ok_or_else(|| A::Error::custom("a sample without a time"))?;
        for channel in trace.channels() {
            let cell: Option<serde_json::Value> = row.next_element()?;
            let wrong =
                |text: String| A::Error::custom(format!("'{}' cannot be '{text}'", channel.name()));
            let cell = cell.ok_or_else(|| {
                A::Error::custom(format!("a sample without a value for '{}'", channel.name()))
            })?;
            let value = match &cell {
                serde_json::Value::Null => None,
                serde_json::Value::Bool(b) if channel.ty() == Type::Bit => Some(Value::Bit(*b)),
                serde_json::Value::Number(n) if channel.ty() == Type::Float => {
                    Some(Value::Float(n.as_f64().ok_or_else(|| wrong(n.to_string()))?))
                }
                serde_json::Value::Number(n) => {
                    Some(number(channel.ty(), &n.to_string()).ok_or_else(|| wrong(n.to_string()))?)
                }
                serde_json::Value::String(s) => {
                    Some(number(channel.ty(), s).ok_or_else(|| wrong(s.clone()))?)
                }
                other => return Err(wrong(other.to_string())),
            };
            record.push(value.map(|v| v.bits()));
        }
        if row.next_element::<IgnoredAny>()?.is_some() {
            return Err(A::Error::custom("a sample with more values than channels"));
        }
        Ok(time)
    }
}

/// Parses a value in JSON notation.
fn number(ty: Type, text: &str) -> Option<Value> {
    match ty {
        Type::Float => text.parse().ok().map(Value::Float),
        Type::Port => text.parse().ok().map(Value::Port),
        Type::Bit | Type::S32 | Type::U32 | Type::S64 | Type::U64 => Value::parse(ty, text).ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::json::write;

    #[test]
    fn what_is_wrong_has_a_line() {
        let head = "{\"format\": \"ferrule trace\",\n\"channels\": [{\"names\": [\"x\"], \"type\": \"s32\"}],\n";
        for (text, want) in [
            ("", "the file is empty"),
            ("{\"a\": 1}", "this is not a JSON trace file"),
            ("\u{1}\u{2}", "this is not a JSON trace file"),
            ("[1, 2]", "this is not a JSON trace file"),
            ("HEAD\"samples\": [[1, 2],\n[2", "4: the file ends too early"),
            ("HEAD\"samples\": [[1, 2],\n[1, 3]]}", "4: time goes from 1 to 1"),
            ("HEAD\"samples\": [[1, 2.5]]}", "3: 'x' cannot be '2.5'"),
            ("HEAD\"samples\": [[1, \"y\"]]}", "3: 'x' cannot be 'y'"),
            ("HEAD\"samples\": [[1]]}", "3: a sample without a value for 'x'"),
            ("HEAD\"samples\": [[1, 2, 3]]}", "3: a sample with more values than channels"),
            ("HEAD\"tick\": \"week\", \"samples\": []}", "3: 'week' is not a unit of time"),
            ("HEAD\"version\": 2}", "3: version 2; 1 is known"),
            ("HEAD\"gaps\": []}", "3: there are no 'samples'"),
        ] {
            let (place, flaw) = read(text.replace("HEAD", head).as_bytes()).flaw.unwrap();
            let line = if let Position::Line(n) = place { format!("{n}: ") } else { String::new() };
            assert_eq!(format!("{line}{flaw}"), want, "{text}");
        }
    }

    #[test]
    fn what_came_before_a_cut_is_kept() {
        let mut t = Trace::default();
        t.add("x", Type::Float);
        for i in 0..20_u8 {
            t.push(i64::from(i), &[f64::from(i).to_bits()]).unwrap();
        }
        let bytes = write(Vec::new(), &t).unwrap();
        assert_eq!(read(&bytes), Reading { trace: t, ..Reading::default() });
        for end in 0..bytes.len() - 1 {
            let got = read(&bytes[..end]);
            assert!(got.flaw.is_some(), "cut at {end}");
            for (sample, time) in got.trace.times().iter().enumerate() {
                let want = Some(Value::Float(sample as f64));
                assert_eq!((usize::try_from(time), got.trace.value(0, sample)), (Ok(sample), want));
            }
        }
    }
}
