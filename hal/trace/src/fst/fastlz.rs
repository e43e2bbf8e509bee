//! `FastLZ` decompression, which some programs use for value changes.

/// Largest distance in the short form.
const NEAR: usize = 8191;

/// Decompresses `bytes` to exactly `length` bytes. Returns `None` if they are invalid or have
/// another length.
pub(super) fn unpack(bytes: &[u8], length: usize) -> Option<Vec<u8>> {
    let mut input = bytes.iter().copied();
    let mut out = Vec::with_capacity(length);
    let first = input.next()?;
    let is_second = match first >> 5 {
        0 => false,
        1 => true,
        _ => return None,
    };
    let mut code = first & 0x1f;
    loop {
        if code < 32 {
            for _ in 0..=code {
                out.push(input.next()?);
            }
        } else {
            let mut run = usize::from(code >> 5) + 2;
            if run == 9 {
                loop {
                    let more = input.next()?;
                    run += usize::from(more);
                    if !is_second || more != 255 {
                        break;
                    }
                }
            }
            let low = input.next()?;
            let mut distance = usize::from(code & 0x1f) << 8 | usize::from(low);
            if is_second && distance == NEAR {
                distance += usize::from(input.next()?) << 8;
                distance += usize::from(input.next()?);
            }
            let start = out.len().checked_sub(distance + 1)?;
            if out.len() + run > length {
                return None;
            }
            for at in start..start + run {
                out.push(*out.get(at)?);
            }
        }
        if out.len() > length {
            return None;
        }
        match input.next() {
            Some(next) => code = next,
            None => return (out.len() == length).then_some(out),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::unpack;

    #[test]
    fn runs_and_matches() {
        assert_eq!(unpack(&[2, b'a', b'b', b'c', 0x20, 2], 6).unwrap(), b"abcabc");
        assert_eq!(unpack(&[0x20, b'x', 0xe0, 3, 0], 13).unwrap(), [b'x'; 13]);
        for bad in [&[][..], &[0x40], &[2, b'a'], &[0, b'a', 0x20, 9], &[0, b'a', 0x20, 0]] {
            assert_eq!(unpack(bad, 100), None);
        }
    }
}
