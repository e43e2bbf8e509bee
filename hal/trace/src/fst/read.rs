//! Reader for FST files of Ferrule and of other programs.

use super::{
    Notes,
    block::{Block, Event, Sizes},
    bytes::{Bytes, gzip, lz4, zlib},
    hierarchy::{Size, Var, hierarchy},
};
use crate::{Flaw, Position, Reading, TimeBase, Trace};
use hal_protocol::{Type, Value};

/// Length of the header block, with which every file begins.
const HEAD: u64 = 329;

/// Reads a file. Strings and values wider than 64 bits are left out with a note.
#[must_use]
pub fn read(bytes: &[u8]) -> Reading {
    let mut reading = Reading::default();
    if bytes.is_empty() {
        reading.flaw = Some((Position::File, Flaw::Empty));
        return reading;
    }
    let mut file = File::default();
    reading.flaw = file.blocks(bytes).err();
    let is_fst = file.is_fst;
    if let Err(stop) = file.settle(&mut reading) {
        reading.flaw = reading.flaw.or(Some(stop));
    }
    if !is_fst && !matches!(reading.flaw, Some((_, Flaw::Empty))) {
        reading.flaw = Some((Position::File, Flaw::Foreign { wanted: "FST" }));
    }
    reading
}

type Stop = (Position, Flaw);

/// A block of the file: kind, position, contents.
#[derive(Debug)]
struct Piece {
    kind: u8,
    at: u64,
    bytes: Vec<u8>,
}

#[derive(Debug, Default)]
struct File {
    is_fst: bool,
    base: TimeBase,
    is_big_endian: bool,
    pieces: Vec<Piece>,
}

impl File {
    /// Finds all blocks.
    fn blocks(&mut self, bytes: &[u8]) -> Result<(), Stop> {
        let mut input = Bytes::new(bytes);
        while !input.is_empty() {
            let at = (bytes.len() - input.rest().len()) as u64;
            let stop = |flaw| (Position::Byte(at), flaw);
            let kind = input.byte().map_err(stop)?;
            let length = input.number().map_err(stop)?;
            if kind == 0 && length == HEAD {
                self.is_fst = true;
            }
            if kind == 255 && length == 0 {
                // The program that wrote the file did not finish this block.
                return Err(stop(Flaw::Truncated));
            }
            let length = length.checked_sub(8).ok_or(Flaw::Truncated).map_err(stop)?;
            let held = input.take(length).map_err(stop)?;
            match kind {
                0 => self.head(held).map_err(stop)?,
                // The whole file is compressed as one block.
                254 if at == 0 => {
                    let mut held = Bytes::new(held);
                    let length = held.number().map_err(stop)?;
                    let file = gzip(held.rest(), length).map_err(stop)?;
                    return if file.first() == Some(&254) {
                        Err(stop(Flaw::Unreadable("a packed file in a packed file".into())))
                    } else {
                        self.blocks(&file)
                    };
                }
                _ => self.pieces.push(Piece { kind, at, bytes: held.to_owned() }),
            }
        }
        Ok(())
    }

    fn head(&mut self, bytes: &[u8]) -> Result<(), Flaw> {
        let mut input = Bytes::new(bytes);
        input.take(16)?;
        let e = input.array()?;
        self.is_big_endian = f64::from_be_bytes(e) == std::f64::consts::E;
        input.take(40)?;
        let exponent = i8::from_be_bytes([input.byte()?]);
        let base = TimeBase::power(exponent);
        self.base =
            base.ok_or_else(|| Flaw::Unreadable(format!("a time unit of 10^{exponent} s").into()))?;
        Ok(())
    }

    /// Builds a trace from the blocks.
    fn settle(mut self, reading: &mut Reading) -> Result<(), Stop> {
        let pieces = std::mem::take(&mut self.pieces);
        let mut sizes = None;
        let mut names = None;
        let mut at_last = 0;
        for piece in &pieces {
            let stop = |flaw| (Position::Byte(piece.at), flaw);
            at_last = piece.at;
            match piece.kind {
                3 => sizes = Some(geometry(&piece.bytes).map_err(stop)?),
                4 | 6 | 7 => {
                    let bytes = names_of(piece.kind, &piece.bytes).map_err(stop)?;
                    names = Some(hierarchy(&bytes).map_err(stop)?);
                }
                _ => {}
            }
        }
        let (Some(sizes), Some((vars, notes))) = (sizes, names) else {
            return Err((Position::Byte(at_last), Flaw::Truncated));
        };
        let sizes = Sizes { sizes, is_big_endian: self.is_big_endian };
        let notes_of_ours = notes.as_ref();
        let channels = channels(reading, &sizes, &vars, notes_of_ours, self.base);
        let ours = notes_of_ours.map(|n| (n.first == Some(0), n.samples));
        let mut filler = Filler { channels, is_first: true, ours };
        for piece in &pieces {
            let stop = |flaw| (Position::Byte(piece.at), flaw);
            let is_second = match piece.kind {
                8 => true,
                1 | 5 => false,
                _ => continue,
            };
            let block = sizes.block(&piece.bytes, is_second).map_err(stop)?;
            filler.fill(&mut reading.trace, &block).map_err(stop)?;
        }
        if let Some(notes) = notes {
            let got = reading.trace.len() as u64;
            for (sample, lost) in notes.gaps.into_iter().filter(|g| u64::from(g.0) <= got) {
                reading.trace.lost_before(sample as usize, lost);
            }
            for (at, text) in notes.markers {
                reading.trace.mark(at, &text);
            }
            if got != notes.samples {
                let flaw = Flaw::Short { got, said: notes.samples };
                return Err((Position::Byte(at_last), flaw));
            }
        }
        Ok(())
    }
}

fn geometry(bytes: &[u8]) -> Result<Vec<Size>, Flaw> {
    let mut input = Bytes::new(bytes);
    let (length, count) = (input.number()?, input.number()?);
    let bytes = zlib(input.rest(), length, true)?;
    let mut input = Bytes::new(&bytes);
    let mut sizes = Vec::new();
    for _ in 0..count {
        sizes.push(match input.groups()? {
            0 => Size::Real,
            0xffff_ffff => Size::Text,
            n => Size::Bits(u32::try_from(n).unwrap_or(u32::MAX)),
        });
    }
    Ok(sizes)
}

fn names_of(kind: u8, bytes: &[u8]) -> Result<Vec<u8>, Flaw> {
    let mut input = Bytes::new(bytes);
    let length = input.number()?;
    match kind {
        4 => gzip(input.rest(), length),
        6 => lz4(input.rest(), length),
        _ => {
            let once = input.groups()?;
            lz4(&lz4(input.rest(), once)?, length)
        }
    }
}

/// Adds a channel for each variable. Returns the channel of each handle.
fn channels(
    reading: &mut Reading,
    sizes: &Sizes,
    vars: &[Var],
    notes: Option<&Notes>,
    base: TimeBase,
) -> Vec<Option<(usize, Type, u32)>> {
    let mut trace = Trace::new(base);
    let mut channels = vec![None; sizes.sizes.len()];
    let index = |handle: u64| handle.checked_sub(1).and_then(|n| usize::try_from(n).ok());
    let mut order: Vec<&Var> = vars.iter().collect();
    if let Some(notes) = notes {
        // Files of Ferrule contain the original order of the channels.
        let place = |v: &&Var| {
            let place = notes.handles.iter().position(|h| u64::from(*h) == v.handle);
            place.unwrap_or(usize::MAX)
        };
        order.sort_by_cached_key(place);
    }
    for var in order {
        let Some(n) = index(var.handle) else { continue };
        let (Some(size), Some(channel)) = (sizes.sizes.get(n), channels.get_mut(n)) else {
            continue;
        };
        match (var.ty(*size), channel.as_ref()) {
            (_, Some((n, _, _))) => trace.also(*n, &var.name),
            (Some(ty), None) => {
                let width = if let Size::Bits(n) = size { *n } else { 64 };
                *channel = Some((trace.add(&var.name, ty), ty, width));
            }
            (None, None) => {
                let is_wide = matches!(size, Size::Bits(65..));
                let why = if is_wide { "wider than 64 bits" } else { "not a number" };
                reading.notes.push(format!("'{}' is {why} and left out", var.name));
            }
        }
    }
    reading.trace = trace;
    channels
}

/// Adds the samples of blocks to a trace.
struct Filler {
    channels: Vec<Option<(usize, Type, u32)>>,
    is_first: bool,
    /// For a file of Ferrule: whether the frame is a sample, and the number of samples.
    ours: Option<(bool, u64)>,
}

impl Filler {
    fn fill(&mut self, trace: &mut Trace, block: &Block) -> Result<(), Flaw> {
        let is_first = std::mem::take(&mut self.is_first);
        // The frame is a sample of its own if no change has the same time.
        let before = block.times.first().is_none_or(|t| *t > block.start);
        let is_sample = self.ours.map_or(before, |(at_zero, _)| at_zero);
        if is_first && is_sample {
            trace.sample(time(block.start)?).map_err(Flaw::Refused)?;
            for event in &block.frame {
                self.set(trace, *event)?;
            }
        }
        let mut events = block.events.iter().peekable();
        for (n, at) in block.times.iter().enumerate() {
            let at = time(*at)?;
            if self.ours.is_some_and(|(_, samples)| trace.len() as u64 >= samples) {
                break;
            }
            // Some programs repeat the last time of a block in the next block.
            if trace.times().last() != Some(at) {
                trace.sample(at).map_err(Flaw::Refused)?;
            }
            while let Some(event) = events.next_if(|e| e.0 == n) {
                self.set(trace, *event)?;
            }
        }
        Ok(())
    }

    fn set(&self, trace: &mut Trace, (_, handle, value): Event) -> Result<(), Flaw> {
        let Some(Some((n, ty, width))) = self.channels.get(handle) else { return Ok(()) };
        let bits = value.map(|bits| {
            let is_signed = matches!(ty, Type::S32 | Type::S64);
            let is_negative = is_signed && *width < 64 && bits >> (width - 1) & 1 == 1;
            let bits = if is_negative { bits | u64::MAX << width } else { bits };
            Value::from_bits(*ty, bits).bits()
        });
        trace.set_bits(*n, bits).map_err(Flaw::Refused)
    }
}

fn time(t: u64) -> Result<i64, Flaw> {
    i64::try_from(t).map_err(|_| Flaw::Unreadable("a time that is too large".into()))
}
