//! Selection of channels of a trace.

use crate::language::hint::nearest;
use hal_protocol::Patterns;
use hal_trace::Trace;

/// A channel, and the name under which it was selected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Chosen {
    pub(super) channel: usize,
    pub(super) name: String,
}

/// Returns the channels that the arguments select, in the order of the arguments. An argument that
/// is the name of a channel selects it; any other is a pattern. Without arguments, all channels are
/// selected.
///
/// # Errors
/// An argument selects nothing. The message has the nearest name.
pub(super) fn chosen(trace: &Trace, words: &[String], file: &str) -> Result<Vec<Chosen>, String> {
    if words.is_empty() {
        return Ok(matching(trace, &[]));
    }
    let mut chosen: Vec<Chosen> = Vec::new();
    for word in words {
        let exact = trace.find(word).map(|channel| vec![Chosen { channel, name: word.clone() }]);
        let found = exact.unwrap_or_else(|| matching(trace, core::slice::from_ref(word)));
        if found.is_empty() {
            let names = trace.channels().iter().flat_map(hal_trace::Channel::names);
            let near = nearest(word, names.map(String::as_str));
            let near = near.map_or_else(String::new, |near| format!("; did you mean {near}?"));
            return Err(format!("{file}: it has no '{word}'{near}"));
        }
        for one in found {
            if chosen.iter().all(|c| c.channel != one.channel) {
                chosen.push(one);
            }
        }
    }
    Ok(chosen)
}

/// Returns the channels with a name that matches, under that name.
fn matching(trace: &Trace, words: &[String]) -> Vec<Chosen> {
    let patterns = Patterns::new(words);
    let names = trace.channels().iter().map(|c| c.names().iter().find(|n| patterns.matches(n)));
    let chosen =
        |(channel, name): (usize, Option<&String>)| Some(Chosen { channel, name: name?.clone() });
    names.enumerate().filter_map(chosen).collect()
}

#[cfg(test)]
mod tests {
    use super::chosen;
    use hal_protocol::Type;
    use hal_trace::Trace;

    #[test]
    fn channels_come_in_the_order_of_the_words() {
        let mut trace = Trace::default();
        for name in ["x.step", "x.step2", "x.dir", "y.step"] {
            trace.add(name, Type::Bit);
        }
        trace.also(2, "xdir");
        let chosen = |words: &[&str]| -> Result<(Vec<usize>, Vec<String>), String> {
            let words: Vec<String> = words.iter().map(|w| (*w).to_owned()).collect();
            let chosen = chosen(&trace, &words, "a.vcd")?;
            Ok(chosen.into_iter().map(|c| (c.channel, c.name)).unzip())
        };
        let (channels, names) =
            (|words| Ok::<_, String>(chosen(words)?.0), |words| chosen(words).unwrap().1);
        assert_eq!(channels(&[]), Ok(vec![0, 1, 2, 3]));
        assert_eq!(channels(&["y", "x.step"]), Ok(vec![3, 0]), "a name is not a beginning");
        assert_eq!(channels(&["*.step", "xdir", "x."]), Ok(vec![0, 3, 2, 1]));
        assert_eq!(names(&["xd", "x.step"]), ["xdir", "x.step"]);
        let unknown = "a.vcd: it has no 'y.stp'; did you mean y.step?";
        assert_eq!(channels(&["y.stp"]), Err(unknown.to_owned()));
    }
}
