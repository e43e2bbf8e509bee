//! A Modbus slave with its four tables.

use crate::Device;
use hal_modbus::{is_whole, push_crc};

const UNKNOWN_FUNCTION: u8 = 1;
const NO_ADDRESS: u8 = 2;
const BAD_VALUE: u8 = 3;
const REFUSED: u8 = 0x80;

/// Slave on a line.
#[derive(Clone, Debug)]
pub struct Slave {
    /// Number of the device.
    pub unit: u8,
    /// Silence: nothing is answered.
    pub is_silent: bool,
    /// Outputs of one bit.
    pub coils: Vec<bool>,
    /// Inputs of one bit.
    pub discretes: Vec<bool>,
    /// Registers that can be written.
    pub holding: Vec<u16>,
    /// Registers that can only be read.
    pub inputs: Vec<u16>,
    /// Functions of the requests so far, the latest last.
    pub heard: Vec<u8>,
}

/// Largest number of requests that are kept.
const MAX_HEARD: usize = 100_000;

impl Slave {
    /// Returns a slave with so many elements in each table, all 0.
    #[must_use]
    pub fn new(unit: u8, elements: usize) -> Self {
        Self {
            unit,
            is_silent: false,
            coils: vec![false; elements],
            discretes: vec![false; elements],
            holding: vec![0; elements],
            inputs: vec![0; elements],
            heard: Vec::new(),
        }
    }

    /// Returns the answer to a frame over TCP, or nothing for bytes that are none.
    pub fn hear_tcp(&mut self, frame: &[u8]) -> Option<Vec<u8>> {
        let (header, data) = frame.split_at_checked(7)?;
        let answer = self.serve(data)?;
        let [t0, t1, _, _, _, _, unit] = *header else { return None };
        let length = u16::try_from(answer.len() + 1).ok()?;
        let [high, low] = length.to_be_bytes();
        let mut out = vec![t0, t1, 0, 0, high, low, unit];
        out.extend(answer);
        Some(out)
    }

    /// Returns function and data of the answer to function and data.
    fn serve(&mut self, data: &[u8]) -> Option<Vec<u8>> {
        let (function, data) = data.split_first()?;
        if self.heard.len() < MAX_HEARD {
            self.heard.push(*function);
        }
        if self.is_silent {
            return None;
        }
        Some(match self.answer(*function, data) {
            Ok(answer) => {
                let mut out = vec![*function];
                out.extend(answer);
                out
            }
            Err(code) => vec![function | REFUSED, code],
        })
    }

    fn answer(&mut self, function: u8, data: &[u8]) -> Result<Vec<u8>, u8> {
        let (head, rest) = data.split_first_chunk::<4>().ok_or(BAD_VALUE)?;
        let [a, b, c, d] = *head;
        let (first, second) = (u16::from_be_bytes([a, b]), u16::from_be_bytes([c, d]));
        let (at, count) = (usize::from(first), usize::from(second));
        match function {
            1 => bits(&self.coils, at, count),
            2 => bits(&self.discretes, at, count),
            3 => words(&self.holding, at, count),
            4 => words(&self.inputs, at, count),
            5 => {
                let coil = self.coils.get_mut(at).ok_or(NO_ADDRESS)?;
                *coil = match second {
                    0xFF00 => true,
                    0 => false,
                    _ => return Err(BAD_VALUE),
                };
                Ok(head.to_vec())
            }
            6 => {
                *self.holding.get_mut(at).ok_or(NO_ADDRESS)? = second;
                Ok(head.to_vec())
            }
            15 => {
                let bytes = written(rest, count.div_ceil(8), count, 1968)?;
                let coils = self.coils.get_mut(at..at + count).ok_or(NO_ADDRESS)?;
                let bits = bytes.iter().flat_map(|byte| (0..8).map(move |n| byte >> n & 1 == 1));
                coils.iter_mut().zip(bits).for_each(|(coil, bit)| *coil = bit);
                Ok(head.to_vec())
            }
            16 => {
                let bytes = written(rest, count * 2, count, 123)?;
                let registers = self.holding.get_mut(at..at + count).ok_or(NO_ADDRESS)?;
                let (pairs, _) = bytes.as_chunks::<2>();
                registers
                    .iter_mut()
                    .zip(pairs)
                    .for_each(|(to, pair)| *to = u16::from_be_bytes(*pair));
                Ok(head.to_vec())
            }
            _ => Err(UNKNOWN_FUNCTION),
        }
    }
}

/// Returns the data of a write behind their length.
fn written(rest: &[u8], bytes: usize, count: usize, most: usize) -> Result<&[u8], u8> {
    match rest.split_first() {
        Some((length, data))
            if (1..=most).contains(&count)
                && usize::from(*length) == bytes
                && data.len() == bytes =>
        {
            Ok(data)
        }
        _ => Err(BAD_VALUE),
    }
}

/// Returns length and bytes of bits that are read.
fn bits(table: &[bool], at: usize, count: usize) -> Result<Vec<u8>, u8> {
    let bits = part(table, at, count, 2000)?;
    let mut out = vec![u8::try_from(count.div_ceil(8)).unwrap_or(u8::MAX)];
    out.extend(
        bits.chunks(8).map(|bits| {
            bits.iter().enumerate().fold(0_u8, |byte, (n, on)| byte | u8::from(*on) << n)
        }),
    );
    Ok(out)
}

/// Returns length and bytes of registers that are read.
fn words(table: &[u16], at: usize, count: usize) -> Result<Vec<u8>, u8> {
    let words = part(table, at, count, 125)?;
    let mut out = vec![u8::try_from(count * 2).unwrap_or(u8::MAX)];
    out.extend(words.iter().flat_map(|word| word.to_be_bytes()));
    Ok(out)
}

fn part<T>(table: &[T], at: usize, count: usize, most: usize) -> Result<&[T], u8> {
    if !(1..=most).contains(&count) {
        return Err(BAD_VALUE);
    }
    table.get(at..at + count).ok_or(NO_ADDRESS)
}

impl Device for Slave {
    fn advance(&mut self, _: i64) {}

    fn hear(&mut self, frame: &[u8], _: i64, answer: &mut Vec<u8>) -> bool {
        let own = |frame: &&[u8]| is_whole(frame) && frame.first() == Some(&self.unit);
        let data = Some(frame).filter(own).and_then(|frame| frame.get(1..frame.len() - 2));
        let Some(data) = data.and_then(|data| self.serve(data)) else { return false };
        answer.push(self.unit);
        answer.extend(data);
        push_crc(answer);
        true
    }
}
