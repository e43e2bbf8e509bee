//! Cleaning of a line: no spaces, lower case, comments as they are.

use crate::error::Problem;

/// Writes the cleaned form of `raw` into `out`: without white space, in lower case, with comments unchanged.
///
/// On error, returns the byte offset in `raw` with the problem.
pub fn clean(raw: &[u8], out: &mut Vec<u8>) -> Result<(), (usize, Problem)> {
    out.clear();
    let mut bytes = raw.iter().copied().enumerate();
    while let Some((at, byte)) = bytes.next() {
        match byte {
            b' ' | b'\t' | b'\r' | b'\n' | 0x0b | 0x0c => {}
            b';' => {
                out.push(byte);
                out.extend(bytes.by_ref().map(|(_, b)| b).filter(|b| *b != b'\r'));
            }
            b'(' => {
                out.push(byte);
                let mut closed = false;
                for (inner, b) in bytes.by_ref() {
                    if b == b'(' {
                        return Err((inner, Problem::NestedComment));
                    }
                    out.push(b);
                    if b == b')' {
                        closed = true;
                        break;
                    }
                }
                if !closed {
                    return Err((at, Problem::UnclosedComment));
                }
            }
            _ => out.push(byte.to_ascii_lowercase()),
        }
    }
    Ok(())
}

/// Returns the column in `raw`, counted from 1, of the byte at `offset` of its cleaned form.
pub fn column(raw: &[u8], offset: usize) -> u32 {
    let mut seen = 0usize;
    let mut quiet: Option<u8> = None;
    for (at, &byte) in raw.iter().enumerate() {
        let kept = match quiet {
            Some(b';') => byte != b'\r',
            Some(_) => {
                if byte == b')' {
                    quiet = None;
                }
                true
            }
            None => {
                if byte == b'(' || byte == b';' {
                    quiet = Some(byte);
                }
                !matches!(byte, b' ' | b'\t' | b'\r' | b'\n' | 0x0b | 0x0c)
            }
        };
        if kept {
            if seen == offset {
                return u32::try_from(at).unwrap_or(u32::MAX).saturating_add(1);
            }
            seen += 1;
        }
    }
    let end = raw.iter().rposition(|b| !b.is_ascii_whitespace()).map_or(0, |p| p + 1);
    u32::try_from(end).unwrap_or(u32::MAX).saturating_add(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cleaned(raw: &str) -> String {
        let mut out = Vec::new();
        clean(raw.as_bytes(), &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn spaces_go_and_comments_stay() {
        assert_eq!(cleaned(" G 0 X1 (Hello  You) Y2 ; The End"), "g0x1(Hello  You)y2; The End");
        assert_eq!(cleaned("G0 X1\r ; a\tb\r"), "g0x1; a\tb");
    }

    #[test]
    fn columns_are_those_of_the_raw_line() {
        let raw = b" G 0 (A b) X1";
        assert_eq!(column(raw, 0), 2);
        assert_eq!(column(raw, 1), 4);
        assert_eq!(column(raw, 7), 12);
        assert_eq!(column(raw, 99), 14);
    }

    #[test]
    fn open_and_nested_comments_are_refused() {
        let mut out = Vec::new();
        assert_eq!(clean(b"g0 (x", &mut out), Err((3, Problem::UnclosedComment)));
        assert_eq!(clean(b"g0 (x(", &mut out), Err((5, Problem::NestedComment)));
    }
}
