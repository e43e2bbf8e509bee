//! Writer for FST files.

use super::{Notes, SCOPE, UNKNOWN};
use crate::{Trace, vcd::path};
use fst_writer::{
    FstBodyWriter, FstFileType, FstHeaderWriter, FstInfo, FstScopeType, FstSignalId, FstSignalType,
    FstVarDirection, FstVarType, FstWriteError,
};
use hal_protocol::{Type, Value};
use std::io::{Cursor, Error, ErrorKind, Result, Write};

/// Size in bytes at which a block is written.
const BLOCK: usize = 1 << 22;
/// Maximum length in bytes of a name and of a piece of notes.
const MAX_LEN: usize = 512;

/// Writes a trace.
///
/// # Errors
/// An error of the output, a time before zero, or a name of more than 512 bytes.
pub fn write<W: Write>(mut out: W, trace: &Trace) -> Result<()> {
    if trace.times().first().is_some_and(|t| t < 0) {
        return Err(refused("FST has no times before zero; CSV and JSON have"));
    }
    let bytes = packed(trace).map_err(|e| match e {
        FstWriteError::Io(e) => e,
        other => refused(&other.to_string()),
    })??;
    out.write_all(&bytes)?;
    out.flush()
}

fn refused(why: &str) -> Error {
    Error::new(ErrorKind::InvalidInput, why)
}

type Body = FstBodyWriter<Cursor<Vec<u8>>>;

fn packed(trace: &Trace) -> core::result::Result<Result<Vec<u8>>, FstWriteError> {
    let info = FstInfo {
        start_time: 0,
        timescale_exponent: trace.base().exponent(),
        version: "Ferrule".to_owned(),
        date: String::new(),
        file_type: FstFileType::Verilog,
    };
    let mut head = FstHeaderWriter::write_to_mem(&info)?;
    let mut vars: Vec<(Vec<String>, usize)> = Vec::new();
    for (n, c) in trace.channels().iter().enumerate() {
        vars.extend(c.names().iter().map(|name| (path(name), n)));
    }
    if let Some((long, _)) = vars.iter().find(|(p, _)| p.iter().any(|n| n.len() > MAX_LEN)) {
        let start: String = long.concat().chars().take(20).collect();
        return Ok(Err(refused(&format!("FST has no names as long as '{start}…'"))));
    }
    vars.sort();
    notes(&mut head, trace, &vars)?;
    let mut ids: Vec<Option<FstSignalId>> = vec![None; trace.channels().len()];
    let mut open: Vec<&str> = Vec::new();
    for (path, n) in &vars {
        let (Some(channel), Some(id)) = (trace.channels().get(*n), ids.get_mut(*n)) else {
            continue;
        };
        let Some((leaf, scopes)) = path.split_last() else { continue };
        let same = open.iter().zip(scopes).take_while(|(a, b)| a == b).count();
        for _ in same..open.len() {
            head.up_scope()?;
        }
        open.truncate(same);
        for scope in scopes.iter().skip(same) {
            head.scope(scope, "", FstScopeType::Module)?;
            open.push(scope);
        }
        let (signal, kind) = match channel.ty() {
            Type::Bit => (FstSignalType::bit_vec(1), FstVarType::Wire),
            Type::Float => (FstSignalType::real(), FstVarType::Real),
            Type::S32 => (FstSignalType::bit_vec(32), FstVarType::Integer),
            Type::U32 => (FstSignalType::bit_vec(32), FstVarType::Wire),
            Type::S64 => (FstSignalType::bit_vec(64), FstVarType::Integer),
            Type::U64 | Type::Port => (FstSignalType::bit_vec(64), FstVarType::Wire),
        };
        *id = Some(head.var(leaf, signal, kind, FstVarDirection::Implicit, *id)?);
    }
    for _ in &open {
        head.up_scope()?;
    }
    let mut body = head.finish()?;
    body.set_deduplicate(false);
    values(&mut body, trace, &ids)?;
    if trace.len() == 1 && trace.times().first() == Some(0) {
        // The writer drops the values at time zero unless another time follows.
        body.time_change(1)?;
    }
    body.finish().map(|out| Ok(out.into_inner()))
}

/// Writes the data that FST cannot express, in pieces.
fn notes(
    head: &mut FstHeaderWriter<Cursor<Vec<u8>>>,
    trace: &Trace,
    vars: &[(Vec<String>, usize)],
) -> core::result::Result<(), FstWriteError> {
    // Handles are counted from 1, in the order in which channels first appear.
    let mut handles = vec![0; trace.channels().len()];
    let mut last = 0;
    for (_, n) in vars {
        if let Some(handle) = handles.get_mut(*n).filter(|h| **h == 0) {
            last += 1;
            *handle = last;
        }
    }
    let gaps = trace.gaps().iter();
    let notes = Notes {
        samples: trace.len() as u64,
        first: trace.times().first(),
        handles,
        gaps: gaps.map(|g| (u32::try_from(g.sample).unwrap_or(u32::MAX), g.lost)).collect(),
        markers: trace.markers().iter().map(|m| (m.at, m.text.clone())).collect(),
    };
    let text = serde_json::to_string(&notes).map_err(Error::from)?;
    let mut piece = String::new();
    for c in text.chars().map(Some).chain([None]) {
        piece.extend(c);
        if c.is_none() || piece.len() > MAX_LEN - 4 {
            head.scope(SCOPE, &piece, FstScopeType::Begin)?;
            head.up_scope()?;
            piece.clear();
        }
    }
    Ok(())
}

fn values(
    body: &mut Body,
    trace: &Trace,
    ids: &[Option<FstSignalId>],
) -> core::result::Result<(), FstWriteError> {
    let mut next = vec![0_usize; ids.len()];
    for (sample, time) in trace.times().iter().enumerate() {
        if body.size() > BLOCK {
            body.flush()?;
        }
        body.time_change(time.unsigned_abs())?;
        for ((n, channel), id) in next.iter_mut().zip(trace.channels()).zip(ids) {
            let change = channel.change(*n).filter(|c| c.sample == sample);
            let value = match change {
                Some(c) => c.value,
                // FST floats start as NaN, so an unknown float must be written explicitly.
                None if sample == 0 => None,
                None => continue,
            };
            *n += usize::from(change.is_some());
            let Some(id) = *id else { continue };
            let width = match channel.ty() {
                Type::Bit => 1,
                Type::S32 | Type::U32 => 32,
                Type::Float | Type::S64 | Type::U64 | Type::Port => 64,
            };
            match (channel.ty(), value) {
                (Type::Float, value) => {
                    let bits = value.map_or(UNKNOWN, |v| v.bits());
                    body.signal_change(id, &bits.to_le_bytes())?;
                }
                (_, Some(Value::Bit(b))) => body.signal_change(id, if b { b"1" } else { b"0" })?,
                (_, Some(v)) => {
                    let text = format!("{:0width$b}", v.bits());
                    body.signal_change(id, text.as_bytes())?;
                }
                (_, None) => body.signal_change(id, "x".repeat(width).as_bytes())?,
            }
        }
    }
    Ok(())
}
