//! Realtime. Conversion of numbers to fields of characters, and the queue of characters to send.

/// Maximum width of a field.
pub(super) const MAX_LEN: usize = 20;

/// 2 to the power of 64.
const TOO_LARGE: f64 = (1_u128 << 64) as f64;

/// Format of a value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Field {
    /// Width in characters; 0 for as many as needed.
    pub(super) width: usize,
    /// True if the field is padded with zeros.
    pub(super) zeros: bool,
    /// True if positive values have a sign as well.
    pub(super) plus: bool,
    /// Number of decimals of a float.
    pub(super) decimals: usize,
}

/// Characters waiting to be sent.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Line {
    bytes: [u8; MAX_LEN],
    len: usize,
    sent: usize,
}

impl Line {
    /// Makes a line of these characters, up to the first 0; a 0 at the start is sent.
    pub(super) fn of(text: &[u8]) -> Self {
        let mut line = Self::default();
        for (to, from) in line.bytes.iter_mut().zip(text) {
            if *from == 0 && line.len > 0 {
                break;
            }
            *to = *from;
            line.len += 1;
        }
        line
    }

    /// Makes a line of one character, repeated.
    pub(super) fn repeated(byte: u8, times: usize) -> Self {
        Self { bytes: [byte; MAX_LEN], len: times.min(MAX_LEN), sent: 0 }
    }

    /// Takes the next character.
    pub(super) fn next(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(..self.len)?.get(self.sent)?;
        self.sent += 1;
        Some(byte)
    }
}

impl Field {
    /// Formats a float; halves are rounded away from zero.
    pub(super) fn float(self, value: f64, separator: u8) -> Line {
        let power = (0..self.decimals).fold(1.0, |power, _| power * 10.0);
        let scaled = value.abs() * power + 0.5;
        // Values above 64 bits, and NaN, convert as on x86.
        let digits = if scaled.is_nan() {
            1 << 63
        } else if scaled < TOO_LARGE {
            whole(scaled)
        } else {
            0
        };
        let separator = Some(separator).filter(|_| self.decimals > 0);
        self.number(value < 0.0, digits, 10, separator, true)
    }

    /// Formats a signed integer.
    pub(super) fn signed(self, value: i32) -> Line {
        self.number(value < 0, u64::from(value.unsigned_abs()), 10, None, false)
    }

    /// Formats an unsigned integer, in base 8, 10 or 16.
    pub(super) fn unsigned(self, value: u32, base: u64) -> Line {
        Self { plus: false, ..self }.number(false, u64::from(value), base, None, false)
    }

    /// Writes from the right: decimals, separator, digits, then zeros, the sign, and blanks. A value that does not fit
    /// is shown as asterisks after the sign; for a float, the asterisks follow the leftmost digit that fits.
    fn number(
        self,
        negative: bool,
        mut digits: u64,
        base: u64,
        separator: Option<u8>,
        is_float: bool,
    ) -> Line {
        let sign = if negative { Some(b'-') } else { Some(b'+').filter(|_| self.plus) };
        let room = if self.width == 0 { MAX_LEN } else { self.width.min(MAX_LEN) };
        let mut field = [b' '; MAX_LEN];
        // Leftmost character written so far, and the leftmost position of a digit.
        let (mut at, first) = (room, usize::from(sign.is_some()).min(room));
        let mut put = |byte: u8| {
            let fits = at > first;
            if let Some(to) = at.checked_sub(1).and_then(|at| field.get_mut(at)).filter(|_| fits) {
                *to = byte;
                at -= 1;
            }
            fits
        };
        if let Some(separator) = separator {
            for _ in 0..self.decimals {
                put(digit(digits % base));
                digits /= base;
            }
            put(separator);
        }
        let mut any = false;
        while (digits > 0 || !any) && put(digit(digits % base)) {
            digits /= base;
            any = true;
        }
        let fits = digits == 0;
        while self.zeros && self.width > 0 && put(b'0') {}
        if let Some(sign) = sign {
            at = at.saturating_sub(1);
            if let Some(to) = field.get_mut(at) {
                *to = sign;
            }
        }
        if !fits {
            let kept = usize::from(sign.is_some() || is_float);
            field.iter_mut().skip(kept).for_each(|byte| *byte = b'*');
        }
        let from = if self.width == 0 && fits { at } else { 0 };
        Line::of(field.get(from..room).unwrap_or_default())
    }
}

fn digit(n: u64) -> u8 {
    u32::try_from(n)
        .ok()
        .and_then(|n| char::from_digit(n, 16))
        .map_or(b'?', |c| u8::try_from(c.to_ascii_uppercase()).unwrap_or(b'?'))
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked before")]
const fn whole(x: f64) -> u64 {
    x as u64
}

#[cfg(test)]
mod tests {
    use super::{Field, Line};

    fn text(mut line: Line) -> String {
        core::iter::from_fn(|| line.next().map(char::from)).collect()
    }

    fn field(width: usize, decimals: usize, flags: &str) -> Field {
        Field { width, decimals, zeros: flags.contains('0'), plus: flags.contains('+') }
    }

    /// Widths, decimals and flags, with the output of LinuxCNC's component.
    #[test]
    fn floats() {
        for (width, decimals, flags, shown) in [
            (0, 4, "", "0.0000 1.5000 -1.5000 0.0500 123.4560 -123.4560 1.0000 99999.5000 -0.0010"),
            (
                8,
                2,
                "",
                "    0.00     1.50    -1.50     0.05   123.46  -123.46     1.00 99999.50    -0.00",
            ),
            (
                8,
                2,
                "0",
                "00000.00 00001.50 -0001.50 00000.05 00123.46 -0123.46 00001.00 99999.50 -0000.00",
            ),
            (
                8,
                2,
                "+",
                "   +0.00    +1.50    -1.50    +0.05  +123.46  -123.46    +1.00 +*******    -0.00",
            ),
            (
                9,
                3,
                "+0",
                "+0000.000 +0001.500 -0001.500 +0000.050 +0123.456 -0123.456 +0001.000 +******** -0000.001",
            ),
            (5, 1, "", "  0.0   1.5  -1.5   0.1 123.5 -****   1.0 9****  -0.0"),
            (4, 0, "", "   0    2   -2    0  123 -123    1 0***   -0"),
            (
                12,
                10,
                "",
                "0.0000000000 1.5000000000 -*********** 0.0500000000 3*********** -*********** 0.9999990000 9*********** -.0010000000",
            ),
            (3, 2, "", ".00 .** -** .05 .** -** .** .** -00"),
        ] {
            let field = field(width, decimals, flags);
            let values = [0.0, 1.5, -1.5, 0.05, 123.456, -123.456, 0.999_999, 99999.5, -0.001];
            let all: Vec<_> = values.map(|v| text(field.float(v, b'.'))).to_vec();
            assert_eq!(all.join(" "), shown, "%{flags}{width}.{decimals}f");
        }
        assert_eq!(text(field(0, 1, "").float(f64::NAN, b'.')), "922337203685477580.8");
        assert_eq!(text(field(0, 4, "").float(1e15, b'.')).matches('*').count(), 19);
        assert_eq!(text(field(0, 1, "").float(f64::INFINITY, b'.')), "0.0");
        assert_eq!(text(field(0, 2, "").float(1.5, b',')), "1,50");
        assert_eq!(text(field(0, 2, "").float(1.5, 0)), "1");
    }

    #[test]
    fn integers() {
        for (width, flags, shown) in [
            (0, "", "0 5 -5 123 -123 1234 99999 2147483647 -2147483648"),
            (4, "", "   0    5   -5  123 -123 1234 **** **** -***"),
            (4, "0", "0000 0005 -005 0123 -123 1234 **** **** -***"),
            (4, "+", "  +0   +5   -5 +123 -123 +*** +*** +*** -***"),
            (4, "+0", "+000 +005 -005 +123 -123 +*** +*** +*** -***"),
            (1, "", "0 5 - * - * * * -"),
            (2, "", " 0  5 -5 ** -* ** ** ** -*"),
        ] {
            let field = field(width, 4, flags);
            let values = [0, 5, -5, 123, -123, 1234, 99999, i32::MAX, i32::MIN];
            let all: Vec<_> = values.map(|v| text(field.signed(v))).to_vec();
            assert_eq!(all.join(" "), shown, "%{flags}{width}i");
        }
        for (width, flags, base, shown) in [
            (0, "+", 10, "0 7 1234 4294967295"),
            (5, "0", 10, "00000 00007 01234 *****"),
            (4, "", 16, "   0    7  4D2 ****"),
            (0, "", 16, "0 7 4D2 FFFFFFFF"),
            (0, "", 8, "0 7 2322 37777777777"),
        ] {
            let field = field(width, 4, flags);
            let all: Vec<_> =
                [0, 7, 1234, u32::MAX].map(|v| text(field.unsigned(v, base))).to_vec();
            assert_eq!(all.join(" "), shown);
        }
    }
}
