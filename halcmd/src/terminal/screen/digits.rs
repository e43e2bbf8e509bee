//! Large characters, five lines high.

/// Height of a large character in lines.
pub(super) const HEIGHT: usize = 5;

/// The characters of which values consist.
const GLYPHS: &[(char, [&str; HEIGHT])] = &[
    ('0', ["█████", "█   █", "█   █", "█   █", "█████"]),
    ('1', ["  █  ", " ██  ", "  █  ", "  █  ", " ███ "]),
    ('2', ["█████", "    █", "█████", "█    ", "█████"]),
    ('3', ["█████", "    █", " ████", "    █", "█████"]),
    ('4', ["█   █", "█   █", "█████", "    █", "    █"]),
    ('5', ["█████", "█    ", "█████", "    █", "█████"]),
    ('6', ["█████", "█    ", "█████", "█   █", "█████"]),
    ('7', ["█████", "    █", "   █ ", "  █  ", "  █  "]),
    ('8', ["█████", "█   █", "█████", "█   █", "█████"]),
    ('9', ["█████", "█   █", "█████", "    █", "█████"]),
    ('-', ["    ", "    ", "████", "    ", "    "]),
    ('+', ["     ", "  █  ", "█████", "  █  ", "     "]),
    ('.', ["  ", "  ", "  ", "  ", "██"]),
    ('e', ["     ", "█████", "█████", "█    ", "█████"]),
    ('x', ["     ", "█   █", " ███ ", " ███ ", "█   █"]),
    ('n', ["     ", "████ ", "█   █", "█   █", "█   █"]),
    ('a', ["     ", "████ ", "  ██ ", "█ ██ ", "█████"]),
    ('i', ["█", " ", "█", "█", "█"]),
    ('f', [" ███", "█   ", "███ ", "█   ", "█   "]),
    ('T', ["█████", "  █  ", "  █  ", "  █  ", "  █  "]),
    ('R', ["████ ", "█   █", "████ ", "█  █ ", "█   █"]),
    ('U', ["█   █", "█   █", "█   █", "█   █", "█████"]),
    ('E', ["█████", "█    ", "████ ", "█    ", "█████"]),
    ('F', ["█████", "█    ", "████ ", "█    ", "█    "]),
    ('A', [" ███ ", "█   █", "█████", "█   █", "█   █"]),
    ('L', ["█    ", "█    ", "█    ", "█    ", "█████"]),
    ('S', ["█████", "█    ", "█████", "    █", "█████"]),
];

/// Writes a text in large characters. Returns `None` for an unknown character or a text wider than
/// `width`.
pub(super) fn big(text: &str, width: usize) -> Option<[String; HEIGHT]> {
    let mut lines: [String; HEIGHT] = core::array::from_fn(|_| String::new());
    for c in text.chars() {
        let (_, glyph) = GLYPHS.iter().find(|(known, _)| *known == c)?;
        for (line, part) in lines.iter_mut().zip(glyph) {
            line.push_str(part);
            line.push_str("  ");
        }
    }
    let wide = lines.iter().any(|line| line.chars().count() > width);
    (!wide).then_some(lines)
}

#[cfg(test)]
mod tests {
    use super::{GLYPHS, big};
    use hal_protocol::Value;

    #[test]
    fn every_value_has_big_characters() {
        for (c, glyph) in GLYPHS {
            let width = glyph[0].chars().count();
            assert!(glyph.iter().all(|line| line.chars().count() == width), "{c}");
        }
        for value in [
            Value::Bit(true),
            Value::Bit(false),
            Value::Float(-1.5e-9),
            Value::Float(f64::NAN),
            Value::Float(f64::NEG_INFINITY),
            Value::Float(1e30),
            Value::S32(i32::MIN),
            Value::U64(u64::MAX),
        ] {
            assert!(big(&value.to_string(), 500).is_some(), "{value}");
        }
        assert_eq!(big("1?", 500), None);
        assert_eq!(big("123", 5), None);
    }
}
