//! Comments that allow a finding: `# check: allow H403 why`, on the same line or above it.

use super::texts::Texts;
use crate::language::lex::without_comment;
use hal_protocol::{At, Code, Finding, Level};

const MARK: &str = "check: allow ";

/// Findings that comments allow.
#[derive(Clone, Debug, Default)]
pub struct Allowed {
    list: Vec<Allowance>,
}

#[derive(Clone, Debug)]
struct Allowance {
    /// Position of the comment.
    at: At,
    /// Line of the finding that it allows.
    line: u32,
    word: String,
    code: Option<Code>,
    used: bool,
}

impl Allowed {
    /// Parses the comments of the files.
    #[must_use]
    pub fn of(texts: &Texts) -> Self {
        let mut list = Vec::new();
        for (file, lines) in texts {
            for (line, text) in (1..).zip(lines) {
                // A line of an INI file may have half a quote: then at the first '#'.
                let before = without_comment(text);
                let before = before.unwrap_or_else(|_| text.split('#').next().unwrap_or_default());
                let Some(comment) = text.get(before.len() + 1..) else { continue };
                let Some(rest) = comment.trim_start().strip_prefix(MARK) else { continue };
                let alone = before.trim().is_empty();
                let about = if alone { next_line(lines, line) } else { line };
                let words = rest.split_whitespace().next().unwrap_or_default();
                for word in words.split(',') {
                    list.push(Allowance {
                        at: At::new(file, line),
                        line: about,
                        word: word.to_owned(),
                        code: Code::parse(word),
                        used: false,
                    });
                }
            }
        }
        Self { list }
    }

    /// Returns whether a comment allows the finding. Errors cannot be allowed.
    pub fn takes(&mut self, finding: &Finding) -> bool {
        let Some(at) = finding.at.as_ref().filter(|_| finding.level != Level::Error) else {
            return false;
        };
        let mut taken = false;
        for a in &mut self.list {
            if a.at.file == at.file && a.line == at.line && a.code == Some(finding.code) {
                a.used = true;
                taken = true;
            }
        }
        taken
    }

    /// Returns a note for each comment that allowed nothing.
    pub fn idle(&self) -> impl Iterator<Item = Finding> {
        self.list.iter().filter(|a| !a.used).map(|a| {
            let text = match a.code {
                None => format!("'{}' is not the code of a finding", a.word),
                Some(code) if code.level() == Level::Error => {
                    format!("{code} is an error, and cannot be allowed")
                }
                Some(code) => format!("there is no {code} on line {}", a.line),
            };
            Finding::new(Code::IdleAllowance, &a.word, text)
                .at(Some(a.at.clone()))
                .remedy("take the comment out, or move it to its line")
        })
    }
}

/// Returns the next line that is neither empty nor a comment.
fn next_line(lines: &[String], line: u32) -> u32 {
    let rest = (line + 1..).zip(lines.iter().skip(line as usize));
    let mut code = rest.filter(|(_, text)| {
        let text = text.trim_start();
        !text.is_empty() && !text.starts_with(['#', ';'])
    });
    code.next().map_or(line, |(n, _)| n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_allow_their_own_line_or_the_next() {
        let text = "setp a 1 # check: allow H403 tried out by hand\n\
                    # check: allow H306,h307 nobody is there yet\n\
                    \n# more\nnet b c\n# check: allow X1\n# check: allow H301 no\n\
                    print \"a # check: allow H306\" # check: allow H403 both are meant\n";
        let lines = text.lines().map(str::to_owned).collect();
        let mut allowed = Allowed::of(&Texts::from([("f".to_owned(), lines)]));
        let at = |code, line| Finding::new(code, "x", String::new()).at(Some(At::new("f", line)));
        assert!(allowed.takes(&at(Code::SetTwice, 1)));
        assert!(!allowed.takes(&at(Code::SetTwice, 5)));
        assert!(allowed.takes(&at(Code::NoReader, 5)));
        assert!(!allowed.takes(&at(Code::TypeMismatch, 7)));
        // A '#' in quotes begins no comment.
        assert!(allowed.takes(&at(Code::SetTwice, 8)));
        assert!(!allowed.takes(&at(Code::NoReader, 8)));
        let idle: Vec<String> =
            allowed.idle().map(|f| format!("{} {}", f.at.unwrap().line, f.text)).collect();
        assert_eq!(
            idle,
            [
                "2 there is no H307 on line 5",
                "6 'X1' is not the code of a finding",
                "7 H301 is an error, and cannot be allowed"
            ]
        );
    }
}
