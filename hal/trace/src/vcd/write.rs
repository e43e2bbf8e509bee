//! Writer for VCD: a header, then changes in order of time.

use crate::{TimeBase, Trace};
use hal_protocol::{Type, Value};
use std::io::{Error, ErrorKind, Result, Write};

/// Type and names of one written value.
#[derive(Clone, Debug)]
pub struct Column {
    /// Type of the value.
    pub ty: Type,
    /// Names of the value.
    pub names: Vec<String>,
}

/// A file that is being written.
#[derive(Debug)]
pub struct Writer<W> {
    out: W,
    columns: Vec<(Type, String)>,
    at: Option<i64>,
}

impl<W: Write> Writer<W> {
    /// Writes the header. If the number of samples is known, a reader can detect that the file was
    /// cut off.
    ///
    /// # Errors
    /// An error of the output.
    pub fn new(
        mut out: W,
        base: TimeBase,
        columns: &[Column],
        samples: Option<usize>,
    ) -> Result<Self> {
        writeln!(out, "$version Ferrule $end\n$timescale {} $end", unit(base)?)?;
        if let Some(n) = samples {
            writeln!(out, "$comment samples {n} $end")?;
        }
        head(&mut out, columns)?;
        let columns = columns.iter().enumerate().map(|(i, c)| (c.ty, code(i))).collect();
        Ok(Self { out, columns, at: None })
    }

    /// Writes a sample with all known values.
    ///
    /// # Errors
    /// An error of the output.
    pub fn all(&mut self, time: i64, record: &[Option<u64>]) -> Result<()> {
        self.time(time)?;
        writeln!(self.out, "$dumpvars")?;
        for (n, bits) in record.iter().enumerate() {
            if let Some(bits) = bits {
                self.change(n, Some(*bits))?;
            }
        }
        writeln!(self.out, "$end")
    }

    /// Writes the time of a sample, unless it is the same as in the last call.
    ///
    /// # Errors
    /// An error of the output.
    pub fn time(&mut self, time: i64) -> Result<()> {
        if self.at != Some(time) {
            writeln!(self.out, "#{time}")?;
            self.at = Some(time);
        }
        Ok(())
    }

    /// Writes the new value of a column at the last sample.
    ///
    /// # Errors
    /// An error of the output.
    pub fn change(&mut self, column: usize, bits: Option<u64>) -> Result<()> {
        let Some((ty, code)) = self.columns.get(column) else { return Ok(()) };
        let out = &mut self.out;
        let Some(bits) = bits else {
            return match ty {
                Type::Bit => writeln!(out, "x{code}"),
                Type::Float => writeln!(out, "$comment unknown {code} $end"),
                Type::S32 | Type::U32 | Type::S64 | Type::U64 | Type::Port => {
                    writeln!(out, "bx {code}")
                }
            };
        };
        match Value::from_bits(*ty, bits) {
            Value::Bit(b) => writeln!(out, "{}{code}", u8::from(b)),
            Value::Float(x) if x.is_finite() => writeln!(out, "r{x:e} {code}"),
            Value::Float(x) if x.is_nan() => writeln!(out, "rnan {code}"),
            Value::Float(x) => writeln!(out, "r{}inf {code}", if x < 0.0 { "-" } else { "" }),
            Value::S32(_) | Value::U32(_) => writeln!(out, "b{:b} {code}", bits & 0xffff_ffff),
            Value::S64(_) | Value::U64(_) | Value::Port(_) => writeln!(out, "b{bits:b} {code}"),
        }
    }

    /// Writes that `lost` samples are missing before the next one.
    ///
    /// # Errors
    /// An error of the output.
    pub fn lose(&mut self, lost: u64) -> Result<()> {
        writeln!(self.out, "$comment lost {lost} $end")
    }

    /// Writes a marker.
    ///
    /// # Errors
    /// An error of the output.
    pub fn mark(&mut self, at: i64, text: &str) -> Result<()> {
        // The text must not contain `$end`.
        let text = serde_json::Value::from(text).to_string().replace('$', "\\u0024");
        writeln!(self.out, "$comment marker {at} {text} $end")
    }

    /// Returns the time of the last sample.
    #[must_use]
    pub const fn at(&self) -> Option<i64> {
        self.at
    }

    /// Returns the output, so that the caller can note the ends of records between two calls.
    pub const fn out(&mut self) -> &mut W {
        &mut self.out
    }

    /// Flushes and returns the output.
    ///
    /// # Errors
    /// An error of the output.
    pub fn finish(mut self) -> Result<W> {
        self.out.flush()?;
        Ok(self.out)
    }
}

/// Writes a whole trace.
///
/// # Errors
/// An error of the output, or a time before zero, which VCD cannot express.
pub fn write<W: Write>(out: W, trace: &Trace) -> Result<W> {
    if trace.times().first().is_some_and(|t| t < 0) {
        let why = "VCD has no times before zero; CSV and JSON have";
        return Err(Error::new(ErrorKind::InvalidInput, why));
    }
    let channels = trace.channels();
    let columns = channels.iter().map(|c| Column { ty: c.ty(), names: c.names().to_vec() });
    let columns: Vec<Column> = columns.collect();
    let mut out = Writer::new(out, trace.base(), &columns, Some(trace.len()))?;
    let mut gaps = trace.gaps().iter().peekable();
    let mut markers = trace.markers().iter().peekable();
    // Index and sample of each channel's next change.
    let mut next: Vec<(usize, Option<usize>)> = Vec::with_capacity(channels.len());
    next.extend(channels.iter().map(|c| (0, c.change(0).map(|c| c.sample))));
    for (sample, time) in trace.times().iter().enumerate() {
        while let Some(marker) = markers.next_if(|m| m.at <= time) {
            out.mark(marker.at, &marker.text)?;
        }
        while let Some(gap) = gaps.next_if(|g| g.sample == sample) {
            out.lose(gap.lost)?;
        }
        out.time(time)?;
        if sample == 0 {
            writeln!(out.out, "$dumpvars")?;
        }
        for (n, (number, at)) in next.iter_mut().enumerate().filter(|(_, n)| n.1 == Some(sample)) {
            let Some(channel) = channels.get(n) else { continue };
            let value = channel.change(*number).and_then(|c| c.value);
            out.change(n, value.map(|v| v.bits()))?;
            *number += 1;
            *at = channel.change(*number).map(|c| c.sample);
        }
        if sample == 0 {
            writeln!(out.out, "$end")?;
        }
    }
    for gap in gaps {
        out.lose(gap.lost)?;
    }
    for marker in markers {
        out.mark(marker.at, &marker.text)?;
    }
    writeln!(out.out, "$comment end $end")?;
    out.finish()
}

/// Returns the unit of time for the header: `1 ns`, `100 us`.
fn unit(base: TimeBase) -> Result<String> {
    let name = base.name();
    if base.exponent() < -15 {
        let why = format!("VCD has no unit of time as short as {name}");
        return Err(Error::new(ErrorKind::InvalidInput, why));
    }
    Ok(if name.contains(' ') { name } else { format!("1 {name}") })
}

/// Returns the short printable code of column `i`.
fn code(mut i: usize) -> String {
    let mut out = String::new();
    loop {
        out.push(char::from(b'!' + u8::try_from(i % 94).unwrap_or(0)));
        i /= 94;
        if i == 0 {
            return out;
        }
    }
}

/// Writes the header. Dots in names become scopes.
fn head(out: &mut impl Write, columns: &[Column]) -> Result<()> {
    let mut vars: Vec<(Vec<String>, Type, String)> = Vec::new();
    for (i, column) in columns.iter().enumerate() {
        for name in &column.names {
            vars.push((path(name), column.ty, code(i)));
        }
    }
    vars.sort();
    let mut open: Vec<&str> = Vec::new();
    for (path, ty, code) in &vars {
        let Some((leaf, scopes)) = path.split_last() else { continue };
        let same = open.iter().zip(scopes).take_while(|(a, b)| a == b).count();
        for _ in same..open.len() {
            writeln!(out, "$upscope $end")?;
        }
        open.truncate(same);
        for scope in scopes.iter().skip(same) {
            writeln!(out, "$scope module {scope} $end")?;
            open.push(scope);
        }
        let kind = match ty {
            Type::Bit => "wire 1",
            Type::Float => "real 64",
            Type::S32 => "integer 32",
            Type::U32 => "wire 32",
            Type::S64 => "integer 64",
            Type::U64 | Type::Port => "wire 64",
        };
        writeln!(out, "$var {kind} {code} {leaf} $end")?;
    }
    for _ in &open {
        writeln!(out, "$upscope $end")?;
    }
    writeln!(out, "$enddefinitions $end")
}

/// Splits a name into scopes and a last part. Returns one part if a scope would have an empty name.
pub(crate) fn path(name: &str) -> Vec<String> {
    let clean = |c: char| if c.is_whitespace() || c.is_control() { '_' } else { c };
    let name: String = if name.is_empty() { "_".into() } else { name.chars().map(clean).collect() };
    let parts: Vec<String> = name.split('.').map(str::to_owned).collect();
    if parts.iter().any(String::is_empty) { vec![name] } else { parts }
}
