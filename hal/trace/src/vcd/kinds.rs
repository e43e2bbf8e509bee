//! Kinds of variables and scopes that other programs write and the parser does not know.

/// Expected next word in the header.
enum Next {
    Command,
    Var,
    Scope,
    /// Free text up to `$end`.
    Text,
}

/// Returns the header with each unknown kind replaced by the nearest known one, and the bytes after
/// the header. Line numbers do not change.
pub(super) fn known(bytes: &[u8]) -> (Vec<u8>, &[u8]) {
    let (mut head, mut rest, mut next) = (Vec::new(), bytes, Next::Command);
    loop {
        let (blank, after) = cut(rest, |b| !b.is_ascii_whitespace());
        let (word, after) = cut(after, u8::is_ascii_whitespace);
        rest = after;
        head.extend_from_slice(blank);
        if word.is_empty() {
            return (head, rest);
        }
        let (written, follows) = match next {
            Next::Var => (kind(word), Next::Command),
            Next::Scope => (scope(word), Next::Command),
            Next::Text if word.windows(4).any(|w| w == b"$end") => (word, Next::Command),
            Next::Text => (word, Next::Text),
            Next::Command => match word {
                b"$var" => (word, Next::Var),
                b"$scope" => (word, Next::Scope),
                b"$comment" | b"$date" | b"$version" => (word, Next::Text),
                _ => (word, Next::Command),
            },
        };
        head.extend_from_slice(written);
        if matches!(next, Next::Command) && word == b"$enddefinitions" {
            return (head, rest);
        }
        next = follows;
    }
}

/// Splits before the first byte for which `is_end` is true.
fn cut(bytes: &[u8], is_end: impl Fn(&u8) -> bool) -> (&[u8], &[u8]) {
    bytes.split_at(bytes.iter().position(is_end).unwrap_or(bytes.len()))
}

/// Maps a variable kind to a known one. `event` stands for kinds without a numeric value.
fn kind(word: &[u8]) -> &[u8] {
    match word {
        b"event" | b"integer" | b"parameter" | b"real" | b"reg" | b"supply0" | b"supply1"
        | b"time" | b"tri" | b"triand" | b"trior" | b"trireg" | b"tri0" | b"tri1" | b"wand"
        | b"wire" | b"wor" | b"string" => word,
        b"logic" | b"bit" | b"enum" | b"port" => b"wire",
        b"int" | b"shortint" | b"longint" | b"byte" => b"integer",
        b"realtime" | b"shortreal" | b"real_parameter" => b"real",
        _ => b"event",
    }
}

fn scope(word: &[u8]) -> &[u8] {
    match word {
        b"module" | b"task" | b"function" | b"begin" | b"fork" => word,
        _ => b"module",
    }
}

#[cfg(test)]
mod tests {
    use crate::vcd::read;

    /// Returns each channel with its type and its first value, and the notes.
    fn channels(text: &str) -> (Vec<String>, Vec<String>) {
        let got = read(text.as_bytes());
        assert_eq!(got.flaw, None, "{text}");
        let t = got.trace;
        let line = |n, c: &crate::Channel| {
            let value = t.value(n, 0).map_or_else(|| "?".to_owned(), |v| v.to_string());
            format!("{} {} {value}", c.name(), c.ty().name())
        };
        (t.channels().iter().enumerate().map(|(n, c)| line(n, c)).collect(), got.notes)
    }

    #[test]
    fn each_kind_becomes_a_channel_or_a_note() {
        let kinds = [
            ("wire 1", "0", Some("bit FALSE")),
            ("reg 8", "b1010 ", Some("u32 10")),
            ("logic 1", "1", Some("bit TRUE")),
            ("logic 40", "b11 ", Some("u64 3")),
            ("bit 4", "b11 ", Some("u32 3")),
            ("enum 2", "b10 ", Some("u32 2")),
            ("port 1", "1", Some("bit TRUE")),
            ("int 32", "b11111111111111111111111111111110 ", Some("s32 -2")),
            ("integer 32", "b101 ", Some("s32 5")),
            ("byte 8", "b11111111 ", Some("s32 -1")),
            ("shortint 16", "b1111111111111101 ", Some("s32 -3")),
            ("longint 64", "b1 ", Some("s64 1")),
            ("real 64", "r0.5 ", Some("float 0.5")),
            ("realtime 64", "r1.5 ", Some("float 1.5")),
            ("shortreal 32", "r2.5 ", Some("float 2.5")),
            ("real_parameter 64", "r3.5 ", Some("float 3.5")),
            ("time 64", "b111 ", Some("u64 7")),
            ("parameter 32", "b1000 ", Some("u32 8")),
            ("supply1 1", "1", Some("bit TRUE")),
            ("event 1", "1", None),
            ("string 1", "shello ", None),
            ("sparray 8", "b1 ", None),
            ("of-tomorrow 8", "b1 ", None),
        ];
        let (mut head, mut body) = (String::from("$timescale 1ns $end\n"), String::from("#0\n"));
        let (mut want, mut notes) = (Vec::new(), Vec::new());
        for (n, (kind, value, is)) in kinds.into_iter().enumerate() {
            let code = char::from(b'!' + u8::try_from(n).unwrap());
            head.push_str(&format!("$var {kind} {code} v{n} $end\n"));
            body.push_str(&format!("{value}{code}\n"));
            match is {
                Some(is) => want.push(format!("v{n} {is}")),
                None => notes.push(format!("'v{n}' is not a number and left out")),
            }
        }
        assert_eq!(channels(&format!("{head}$enddefinitions $end\n{body}")), (want, notes));
    }

    #[test]
    fn scopes_of_other_kinds_are_scopes() {
        let text = "$comment $var x $scope y $end $scope struct s $end\n\
            $scope vhdl_architecture a $end $var\tlogic\n1 ! x $end $upscope $end\n\
            $var int 8 \" y [7:0] $end $upscope $end $enddefinitions $end\n#3\n1!\nb1 \"\n";
        assert_eq!(channels(text).0, ["s.a.x bit TRUE", "s.y s32 1"]);
    }

    #[test]
    fn what_is_wrong_after_them_keeps_its_line() {
        let head = "$var logic 1 ! x $end\n$var int\n32 \" y $end\n$enddefinitions $end\n#1\n1?\n";
        let (place, flaw) = read(head.as_bytes()).flaw.unwrap();
        assert_eq!(place, crate::Position::Line(6));
        assert_eq!(flaw.to_string(), "a value for '?', which is not declared");
    }
}
