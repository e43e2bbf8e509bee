//! A block of value changes of an FST file.

use super::{
    UNKNOWN,
    bytes::{Bytes, fastlz, lz4, zlib},
    hierarchy::Size,
};
use crate::Flaw;
use std::ops::Range;

/// A change: index of its time in the block, index of its variable, new value.
pub(super) type Event = (usize, usize, Option<u64>);

/// Contents of a block.
#[derive(Debug, Default)]
pub(super) struct Block {
    pub(super) start: u64,
    pub(super) times: Vec<u64>,
    /// Values at the start of the block.
    pub(super) frame: Vec<Event>,
    /// Changes in order of time.
    pub(super) events: Vec<Event>,
}

/// Properties of the file that are known before the blocks are read.
#[derive(Debug)]
pub(super) struct Sizes {
    pub(super) sizes: Vec<Size>,
    pub(super) is_big_endian: bool,
}

impl Sizes {
    /// Parses a value that is stored as one character per bit, or as a float.
    fn letters(&self, size: Size, letters: &[u8]) -> Option<u64> {
        match size {
            Size::Text => None,
            Size::Real => {
                let bytes: [u8; 8] = letters.try_into().ok()?;
                let bits = if self.is_big_endian {
                    u64::from_be_bytes(bytes)
                } else {
                    u64::from_le_bytes(bytes)
                };
                (bits != UNKNOWN).then_some(bits)
            }
            Size::Bits(_) => letters.iter().try_fold(0_u64, |n, c| match c {
                b'0' | b'1' => Some(n << 1 | u64::from(c & 1)),
                _ => None,
            }),
        }
    }

    const fn letters_of(size: Size) -> u64 {
        match size {
            Size::Real => 8,
            Size::Bits(n) => n as u64,
            Size::Text => 0,
        }
    }

    /// Reads a block. `is_second` selects the second of the two forms of its table.
    pub(super) fn block(&self, bytes: &[u8], is_second: bool) -> Result<Block, Flaw> {
        let mut input = Bytes::new(bytes);
        let mut block = Block { start: input.number()?, ..Block::default() };
        let (_end, _memory) = (input.number()?, input.number()?);

        let mut tail = Bytes::new(input.take_end(24)?);
        let (length, packed, count) = (tail.number()?, tail.number()?, tail.number()?);
        let times = zlib(input.take_end(packed)?, length, true)?;
        let mut times = Bytes::new(&times);
        let mut time = 0_u64;
        for _ in 0..count {
            let too_late = || Flaw::Unreadable("a time that is too large".into());
            time = time.checked_add(times.groups()?).ok_or_else(too_late)?;
            block.times.push(time);
        }

        let (length, packed, handles) = (input.groups()?, input.groups()?, input.groups()?);
        let frame = zlib(input.take(packed)?, length, true)?;
        let mut frame = Bytes::new(&frame);
        let handles = usize::try_from(handles).ok().filter(|n| *n <= self.sizes.len());
        let handles =
            handles.ok_or_else(|| Flaw::Unreadable("more values than variables".into()))?;
        for (n, size) in self.sizes.iter().enumerate().take(handles) {
            let letters = frame.take(Self::letters_of(*size))?;
            block.frame.push((0, n, self.letters(*size, letters)));
        }

        input.groups()?;
        let length = Bytes::new(input.take_end(8)?).number()?;
        let table = input.take_end(length)?;
        let chains = input.rest();
        let pack = input.byte()?;
        let places = if is_second {
            second_table(table, chains.len(), self.sizes.len())?
        } else {
            first_table(table, chains.len(), self.sizes.len())?
        };
        for (n, place) in places.into_iter().enumerate() {
            let Some(place) = place else { continue };
            let Some(size) = self.sizes.get(n) else { continue };
            let chain = chains.get(place).ok_or(Flaw::Truncated)?;
            self.chain(n, *size, pack, chain, &mut block)?;
        }
        block.events.sort_by_key(|e| e.0);
        Ok(block)
    }

    /// Reads the changes of one variable.
    fn chain(
        &self,
        n: usize,
        size: Size,
        pack: u8,
        chain: &[u8],
        block: &mut Block,
    ) -> Result<(), Flaw> {
        if size == Size::Text {
            return Ok(());
        }
        let mut input = Bytes::new(chain);
        let length = input.groups()?;
        let unpacked = match (length, pack) {
            (0, _) => input.rest().to_owned(),
            (_, b'4') => lz4(input.rest(), length)?,
            (_, b'F') => fastlz(input.rest(), length)?,
            (_, _) => zlib(input.rest(), length, false)?,
        };
        let mut input = Bytes::new(&unpacked);
        let mut at = 0_usize;
        while !input.is_empty() {
            let head = input.groups()?;
            let (steps, value) = if size == Size::Bits(1) {
                if head & 1 == 0 { (head >> 2, Some(head >> 1 & 1)) } else { (head >> 4, None) }
            } else if head & 1 == 1 {
                let letters = input.take(Self::letters_of(size))?;
                (head >> 1, self.letters(size, letters))
            } else {
                let letters = Self::letters_of(size);
                let bytes = input.take(letters.div_ceil(8))?;
                let bits = bytes.iter().flat_map(|b| (0..8).rev().map(move |i| b'0' | b >> i & 1));
                let letters: Vec<u8> =
                    bits.take(usize::try_from(letters).unwrap_or(usize::MAX)).collect();
                (head >> 1, self.letters(size, &letters))
            };
            let steps = usize::try_from(steps).unwrap_or(usize::MAX);
            at = at.saturating_add(steps);
            if at >= block.times.len() {
                return Err(Flaw::Unreadable("a change at no time".into()));
            }
            block.events.push((at, n, value));
        }
        Ok(())
    }
}

type Places = Vec<Option<Range<usize>>>;

/// Builder of the table of chains: where each chain begins, and which variables share one.
struct Table {
    places: Places,
    end: usize,
    last: Option<(usize, usize)>,
}

impl Table {
    fn begin(&mut self, start: usize) {
        self.finish(start);
        self.last = Some((self.places.len(), start));
        self.places.push(None);
    }

    /// Completes the range of the last chain, which ends here.
    fn finish(&mut self, end: usize) {
        if let Some((n, start)) = self.last
            && let Some(place) = self.places.get_mut(n)
            && start <= end
        {
            *place = Some(start..end);
        }
    }

    fn alias(&mut self, of: Option<usize>, aliases: &mut Vec<(usize, usize)>) {
        if let Some(of) = of {
            aliases.push((self.places.len(), of));
        }
        self.places.push(None);
    }

    fn done(mut self, aliases: Vec<(usize, usize)>) -> Places {
        self.finish(self.end);
        for (n, of) in aliases {
            let place = self.places.get(of).cloned().flatten();
            if let Some(own) = self.places.get_mut(n) {
                *own = place;
            }
        }
        self.places
    }

    fn skip(&mut self, n: u64, most: usize) -> Result<(), Flaw> {
        let n = usize::try_from(n).unwrap_or(usize::MAX);
        self.check(n, most)?;
        self.places.resize(self.places.len() + n, None);
        Ok(())
    }

    fn check(&self, more: usize, most: usize) -> Result<(), Flaw> {
        if self.places.len().saturating_add(more) > most {
            return Err(Flaw::Unreadable("more changes than variables".into()));
        }
        Ok(())
    }
}

fn second_table(bytes: &[u8], end: usize, most: usize) -> Result<Places, Flaw> {
    let mut input = Bytes::new(bytes);
    let mut table = Table { places: Vec::new(), end, last: None };
    let (mut start, mut alias, mut aliases) = (0_i64, None, Vec::new());
    while let Some(first) = input.rest().first() {
        if first & 1 == 0 {
            table.skip(input.groups()? >> 1, most)?;
            continue;
        }
        table.check(1, most)?;
        let step = input.signed_groups()? >> 1;
        if step > 0 {
            start = start.saturating_add(step);
            table.begin(usize::try_from(start).unwrap_or(usize::MAX));
        } else {
            if step < 0 {
                alias = step.checked_neg().and_then(|n| usize::try_from(n - 1).ok());
            }
            table.alias(alias, &mut aliases);
        }
    }
    Ok(table.done(aliases))
}

fn first_table(bytes: &[u8], end: usize, most: usize) -> Result<Places, Flaw> {
    let mut input = Bytes::new(bytes);
    let mut table = Table { places: Vec::new(), end, last: None };
    let (mut start, mut aliases) = (0_usize, Vec::new());
    while !input.is_empty() {
        let entry = input.groups()?;
        if entry == 0 {
            table.check(1, most)?;
            let of = input.groups()?.checked_sub(1).and_then(|n| usize::try_from(n).ok());
            table.alias(of, &mut aliases);
        } else if entry & 1 == 1 {
            table.check(1, most)?;
            let step = usize::try_from(entry >> 1).unwrap_or(usize::MAX);
            start = start.saturating_add(step);
            table.begin(start);
        } else {
            table.skip(entry >> 1, most)?;
        }
    }
    Ok(table.done(aliases))
}
