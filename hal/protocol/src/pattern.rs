//! Name patterns, as `show` and `list` use them.

/// A list of patterns. A name matches a pattern that is a prefix of it or, as a shell glob, matches
/// all of it.
#[derive(Clone, Debug, Default)]
pub struct Patterns(Vec<String>);

impl Patterns {
    /// Returns the patterns in the words of a command. An empty list matches everything.
    #[must_use]
    pub fn new(words: &[String]) -> Self {
        Self(words.to_vec())
    }

    /// Returns whether the list is empty.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns whether `name` matches a pattern, or the list is empty.
    #[must_use]
    pub fn matches(&self, name: &str) -> bool {
        self.0.is_empty() || self.names(name)
    }

    /// Returns whether a pattern that contains `part` literally matches `name`. Simulated registers
    /// (`.sim`) are listed only if a pattern spells them out.
    #[must_use]
    pub fn spell(&self, part: &str, name: &str) -> bool {
        let spelling: Vec<String> = self.0.iter().filter(|p| p.contains(part)).cloned().collect();
        Self(spelling).names(name)
    }

    /// Returns whether one of the patterns is exactly `name`.
    #[must_use]
    pub fn is_one(&self, name: &str) -> bool {
        self.0.iter().any(|p| p == name)
    }

    /// Returns whether a pattern matches `name`. Returns false if the list is empty.
    #[must_use]
    pub fn names(&self, name: &str) -> bool {
        self.0.iter().any(|p| name.starts_with(p.as_str()) || glob(p.as_bytes(), name.as_bytes()))
    }
}

/// Matches a shell glob against the whole name: `*`, `?`, `[a-z]`, `[!a-z]`, `\` before a literal.
fn glob(pattern: &[u8], name: &[u8]) -> bool {
    let (mut p, mut n) = (0, 0);
    let mut star: Option<(usize, usize)> = None;
    loop {
        let step = match (pattern.get(p), name.get(n)) {
            (None, None) => return true,
            (Some(b'*'), _) => {
                star = Some((p + 1, n));
                p += 1;
                continue;
            }
            (Some(b'?'), Some(_)) => Some(1),
            (Some(b'['), Some(c)) => set(pattern.get(p + 1..).unwrap_or(&[]), *c)
                .map_or_else(|| (*c == b'[').then_some(1), |(hit, len)| hit.then_some(len + 1)),
            (Some(b'\\'), Some(c)) => (pattern.get(p + 1) == Some(c)).then_some(2),
            (Some(l), Some(c)) => (l == c).then_some(1),
            (None, Some(_)) | (Some(_), None) => None,
        };
        if let Some(len) = step {
            p += len;
            n += 1;
            continue;
        }
        match star {
            Some((after, from)) if from < name.len() => {
                star = Some((after, from + 1));
                p = after;
                n = from + 1;
            }
            _ => return false,
        }
    }
}

/// Returns whether `c` is in the set after `[`, and the length of the set including its `]`.
fn set(text: &[u8], c: u8) -> Option<(bool, usize)> {
    let negated = matches!(text.first(), Some(b'!' | b'^'));
    let mut i = usize::from(negated);
    let mut hit = false;
    let mut first = true;
    loop {
        let low = *text.get(i)?;
        if low == b']' && !first {
            return Some((hit != negated, i + 1));
        }
        first = false;
        if text.get(i + 1) == Some(&b'-') && text.get(i + 2).is_some_and(|e| *e != b']') {
            let high = *text.get(i + 2)?;
            hit |= low <= c && c <= high;
            i += 3;
        } else {
            hit |= low == c;
            i += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Patterns;

    #[test]
    fn a_pattern_is_a_beginning_or_a_glob() {
        for (pattern, name, want) in [
            ("stepgen.0", "stepgen.0.step", true),
            ("*.out", "and2.0.out", true),
            ("*.out", "and2.0.out-not", false),
            ("and?.0.in[01]", "and2.0.in1", true),
            ("and2.0.in[!0]", "and2.0.in0", false),
            ("*a*b*", "xxaxxbxx", true),
            ("[", "[x", true),
            ("", "anything", true),
            ("*", "", true),
            ("[a-c]x", "bx", true),
        ] {
            assert_eq!(
                Patterns::new(&[pattern.to_owned()]).matches(name),
                want,
                "{pattern} {name}"
            );
        }
    }

    #[test]
    fn simulated_registers_are_only_given_when_spelled_out() {
        let spell = |p: &str| Patterns::new(&[p.to_owned()]).spell(".sim", "viagpio.sim.reg-4d");
        assert!(spell("viagpio.sim") && spell("*.sim.*"));
        assert!(!spell("viagpio") && !spell("*"));
    }
}
