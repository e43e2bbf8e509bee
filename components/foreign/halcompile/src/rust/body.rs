//! C text, split into the parts of its functions.

use crate::{Component, name::c_name};

/// Parts of a component's C text.
pub(crate) struct Parts {
    /// Text of each function, in the order of the declarations.
    pub(crate) functions: Vec<String>,
    /// Everything else.
    pub(crate) rest: String,
}

/// Splits the text at each `FUNCTION(name)`, up to the closing brace.
pub(crate) fn parts(component: &Component) -> Parts {
    let names: Vec<String> = component.functions.iter().map(|f| c_name(&f.name.value)).collect();
    let mut functions = vec![String::new(); names.len()];
    if component.is_bare() {
        if let Some(first) = functions.first_mut() {
            first.push_str(component.body.text.trim_matches('\n'));
        }
        return Parts { functions, rest: String::new() };
    }
    let mut rest = String::new();
    let mut text = component.body.text.as_str();
    while let Some((at, name, body)) = next(text) {
        let index = names.iter().position(|n| n == name);
        let part = index.and_then(|i| functions.get_mut(i));
        let end = body + closing(text.get(body..).unwrap_or_default());
        let (before, after) =
            (text.get(..at).unwrap_or_default(), text.get(end..).unwrap_or_default());
        rest.push_str(before);
        let whole = text.get(at..end).unwrap_or_default();
        match part {
            Some(part) => part.push_str(inside(text.get(body..end).unwrap_or_default())),
            None => rest.push_str(whole),
        }
        text = after;
    }
    rest.push_str(text);
    Parts { functions, rest: rest.trim().to_owned() }
}

/// Returns the start of the next function, its name, and the start of its body.
fn next(text: &str) -> Option<(usize, &str, usize)> {
    let mut from = 0;
    loop {
        let at = from + text.get(from..)?.find("FUNCTION")?;
        from = at + "FUNCTION".len();
        let before = text.get(..at).and_then(|t| t.chars().next_back());
        if before.is_some_and(|c| c == '_' || c.is_alphanumeric()) {
            continue;
        }
        let Some(rest) = text.get(from..)?.trim_start().strip_prefix('(') else { continue };
        let Some((name, after)) = rest.split_once(')') else { continue };
        let body = text.len() - after.len();
        if after.trim_start().starts_with('{') {
            return Some((at, name.trim(), body));
        }
    }
}

/// Returns the length of a text up to the brace that closes its first one; strings and comments are skipped.
fn closing(text: &str) -> usize {
    let mut depth = 0_u32;
    let mut chars = text.char_indices().peekable();
    while let Some((i, c)) = chars.next() {
        match c {
            '{' => depth += 1,
            '}' => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    return i + 1;
                }
            }
            '"' | '\'' => {
                while let Some((_, inner)) = chars.next() {
                    if inner == '\\' {
                        chars.next();
                    } else if inner == c || inner == '\n' {
                        break;
                    }
                }
            }
            '/' if chars.peek().is_some_and(|(_, c)| *c == '/') => {
                while chars.next_if(|(_, c)| *c != '\n').is_some() {}
            }
            '/' if chars.peek().is_some_and(|(_, c)| *c == '*') => {
                let long =
                    text.get(i + 2..).and_then(|t| t.find("*/")).map_or(text.len(), |n| i + n + 4);
                while chars.next_if(|(at, _)| *at < long).is_some() {}
            }
            _ => {}
        }
    }
    text.len()
}

/// Returns the text between the braces.
fn inside(text: &str) -> &str {
    let text = text.trim();
    let text = text.strip_prefix('{').unwrap_or(text);
    text.strip_suffix('}').unwrap_or(text).trim_matches('\n')
}

/// Returns whether a text contains this word.
pub(crate) fn names(text: &str, word: &str) -> bool {
    let is_part = |c: char| c == '_' || c.is_alphanumeric();
    text.match_indices(word).any(|(i, _)| {
        let before = text.get(..i).and_then(|t| t.chars().next_back());
        let after = text.get(i + word.len()..).and_then(|t| t.chars().next());
        !before.is_some_and(is_part) && !after.is_some_and(is_part)
    })
}

/// Returns a C text as comment lines.
pub(crate) fn comment(text: &str, indent: &str) -> String {
    let lines = text.lines().map(|line| {
        let line = format!("{indent}//     {}", line.replace('\t', "    ").trim_end());
        format!("{}\n", line.trim_end())
    });
    lines.collect()
}
