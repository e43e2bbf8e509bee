//! Answers of Modbus devices, found in the bytes that have come.

use crate::{Call, Exception, Miss, ModbusRequest, is_whole, request::count};

/// Bytes of a frame over TCP before the number of the device.
const HEADER: usize = 6;
/// Mark of a refusal in the number of the function.
const REFUSED: u8 = 0x80;

/// Answer of a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ModbusAnswer {
    /// Bits that were read.
    Bits(Vec<bool>),
    /// Registers that were read.
    Words(Vec<u16>),
    /// The values are written.
    Written,
    /// The device refuses.
    Refused(Exception),
}

/// Finds the answer to a request in the bytes that have come on a serial line since. Bytes before and after it are
/// noise, or frames of other devices.
#[must_use]
pub fn find_rtu(request: &ModbusRequest, bytes: &[u8]) -> Option<ModbusAnswer> {
    (0..bytes.len()).find_map(|at| at_rtu(request, bytes.get(at..)?))
}

/// Reads the answer that begins with the first byte.
fn at_rtu(request: &ModbusRequest, bytes: &[u8]) -> Option<ModbusAnswer> {
    let [unit, function, ..] = *bytes else { return None };
    if unit != request.unit {
        return None;
    }
    let length = if function == request.function() | REFUSED {
        5
    } else if function == request.function() {
        request.answer_len()
    } else {
        return None;
    };
    let frame = bytes.get(..length).filter(|frame| is_whole(frame))?;
    read(request, frame.get(1..length.checked_sub(2)?)?)
}

/// Finds the answer to a request in the bytes that have come over TCP. Answers to earlier requests are passed over.
///
/// # Errors
/// The bytes are no frames, or the answer is another one than the request wants: the connection is of no more use.
pub fn find_tcp(
    request: &ModbusRequest,
    transaction: u16,
    bytes: &[u8],
) -> Result<Option<ModbusAnswer>, Miss> {
    let mut rest = bytes;
    while let Some((header, body)) = rest.split_first_chunk::<HEADER>() {
        let [t0, t1, p0, p1, l0, l1] = *header;
        let length = usize::from(u16::from_be_bytes([l0, l1]));
        if [p0, p1] != [0, 0] || !(3..=254).contains(&length) {
            return Err(Miss::Noise);
        }
        let Some((frame, after)) = body.split_at_checked(length) else { break };
        rest = after;
        if u16::from_be_bytes([t0, t1]) != transaction {
            continue;
        }
        let Some((unit, data)) = frame.split_first() else { continue };
        if *unit != request.unit {
            return Err(Miss::Other(*unit));
        }
        return read(request, data).map(Some).ok_or(Miss::Wrong);
    }
    Ok(None)
}

/// Returns the number of bytes of an answer that follow the number of the function.
pub(crate) fn body(request: &ModbusRequest) -> usize {
    match &request.call {
        Call::Read { table, count, .. } if table.is_bits() => 1 + usize::from(*count).div_ceil(8),
        Call::Read { count, .. } => 1 + 2 * usize::from(*count),
        Call::WriteCoil { .. }
        | Call::WriteRegister { .. }
        | Call::WriteCoils { .. }
        | Call::WriteRegisters { .. } => 4,
    }
}

/// Reads function and data of an answer. Returns nothing if they do not fit the request.
fn read(request: &ModbusRequest, data: &[u8]) -> Option<ModbusAnswer> {
    let (function, data) = data.split_first()?;
    if *function == request.function() | REFUSED {
        let [code] = *data else { return None };
        return Some(ModbusAnswer::Refused(Exception(code)));
    }
    if *function != request.function() || data.len() != body(request) {
        return None;
    }
    let words = |data: &[u8]| -> Vec<u16> {
        let (pairs, _) = data.as_chunks::<2>();
        pairs.iter().map(|pair| u16::from_be_bytes(*pair)).collect()
    };
    let echoes =
        |first: u16, second: u16| (words(data) == [first, second]).then_some(ModbusAnswer::Written);
    match &request.call {
        Call::Read { table, count, .. } => {
            let (length, values) = data.split_first()?;
            if usize::from(*length) != values.len() {
                return None;
            }
            if !table.is_bits() {
                return Some(ModbusAnswer::Words(words(values)));
            }
            let bits = values.iter().flat_map(|byte| (0..8).map(move |n| byte >> n & 1 == 1));
            Some(ModbusAnswer::Bits(bits.take(usize::from(*count)).collect()))
        }
        Call::WriteCoil { at, on } => echoes(*at, if *on { 0xFF00 } else { 0 }),
        Call::WriteRegister { at, value } => echoes(*at, *value),
        Call::WriteCoils { first, on } => echoes(*first, count(on.len())),
        Call::WriteRegisters { first, values } => echoes(*first, count(values.len())),
    }
}
