//! Names of a declaration, as HAL shows it and as C code writes it.

/// Returns the name in C: a block of `#` is removed with the separator before it, and any other character becomes `_`.
#[must_use]
pub(crate) fn c_name(written: &str) -> String {
    let mut out = String::new();
    for c in written.chars() {
        if c == '#' {
            while out.ends_with('_') {
                out.pop();
            }
        } else {
            let c = if matches!(c, '.' | '-') { '_' } else { c };
            if c != '_' || !out.ends_with('_') {
                out.push(c);
            }
        }
    }
    out
}

/// Returns the part of the name after the instance's as a `printf` format, with `%0Nd` for the index.
#[must_use]
pub(crate) fn hal_format(written: &str) -> String {
    let (before, width, after) = pieces(written);
    let number = match width {
        0 => String::new(),
        1 => "%d".to_owned(),
        n => format!("%0{n}d"),
    };
    trimmed(&format!("{before}{number}{after}"))
}

/// Returns the name as people read it and as `#[hal(name = …)]` takes it: the index stays `#`.
#[must_use]
pub(crate) fn hal_name(written: &str) -> String {
    trimmed(&written.replace('_', "-"))
}

/// Returns the number of blocks of `#` in a name.
#[must_use]
pub(crate) fn hashes(written: &str) -> usize {
    written.split(|c| c != '#').filter(|block| !block.is_empty()).count()
}

/// Returns the part before the instance number: without `hal_`, and with `-` for `_`.
#[must_use]
pub(crate) fn prefix(component: &str) -> String {
    component.strip_prefix("hal_").unwrap_or(component).replace('_', "-")
}

/// Returns whether a name is a keyword of C, or is used by the generated text itself.
#[must_use]
pub(crate) fn is_c_keyword(name: &str) -> bool {
    const WORDS: &[&str] = &[
        "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else",
        "enum", "extern", "float", "for", "goto", "if", "inline", "int", "long", "register",
        "restrict", "return", "short", "signed", "sizeof", "static", "struct", "switch", "typedef",
        "union", "unsigned", "void", "volatile", "while",
    ];
    WORDS.contains(&name)
}

fn pieces(written: &str) -> (String, usize, String) {
    let hal = written.replace('_', "-");
    let Some(start) = hal.find('#') else { return (hal, 0, String::new()) };
    let (before, rest) = hal.split_at(start);
    let after = rest.trim_start_matches('#');
    (before.to_owned(), rest.len() - after.len(), after.to_owned())
}

fn trimmed(name: &str) -> String {
    name.trim_end_matches(['-', '.']).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_both_kinds() {
        let all = |n: &str| (c_name(n), hal_format(n), hal_name(n));
        let of = |c: &str, f: &str, h: &str| (c.to_owned(), f.to_owned(), h.to_owned());
        assert_eq!(all("in_"), of("in_", "in", "in"));
        assert_eq!(all("_"), of("_", "", ""));
        assert_eq!(all("in-##"), of("in", "in-%02d", "in-##"));
        assert_eq!(all("s.##.q"), of("s_q", "s.%02d.q", "s.##.q"));
        assert_eq!(all("a.-b__c"), of("a_b_c", "a.-b--c", "a.-b--c"));
        assert_eq!(all("#.out"), of("_out", "%d.out", "#.out"));
        assert_eq!((prefix("hal_port_x"), prefix("or_2")), ("port-x".into(), "or-2".into()));
        assert_eq!((hashes("a-##.#"), hashes("a"), hashes("##")), (2, 0, 1));
    }
}
