//! Recordings, read back.

use std::collections::BTreeMap;

/// A recording: every change of every pin.
#[derive(Clone, Debug, Default)]
pub struct Vcd {
    changes: BTreeMap<String, Vec<(i64, f64)>>,
    end: i64,
}

impl Vcd {
    /// Reads the text of a VCD file as the recorder writes it.
    pub fn parse(text: &str) -> Self {
        let (mut vcd, mut scopes) = (Self::default(), Vec::new());
        let mut names: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        for line in text.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.as_slice() {
                ["$scope", "module", name, _] => scopes.push(*name),
                ["$upscope", _] => drop(scopes.pop()),
                ["$var", _, _, code, leaf, _] => {
                    let path: Vec<&str> = scopes.iter().chain([leaf]).copied().collect();
                    names.entry(*code).or_default().push(path.join("."));
                }
                [word] if word.starts_with('#') => vcd.end = number(&word[1..]),
                [word] if word.starts_with(['0', '1']) => {
                    vcd.change(&names, &word[1..], f64::from(u8::from(word.starts_with('1'))));
                }
                [value, code] if value.starts_with('b') => {
                    let bits = u64::from_str_radix(&value[1..], 2).unwrap();
                    vcd.change(&names, code, bits as f64);
                }
                [value, code] if value.starts_with('r') => {
                    vcd.change(&names, code, value[1..].parse().unwrap());
                }
                _ => assert!(line.starts_with('$'), "VCD: {line}"),
            }
        }
        vcd
    }

    /// The changes of a pin or signal: nanoseconds and what it became. The first is what it was.
    pub fn of(&self, name: &str) -> &[(i64, f64)] {
        self.changes.get(name).unwrap_or_else(|| panic!("'{name}' is not in the recording"))
    }

    /// The names of what was recorded.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.changes.keys().map(String::as_str)
    }

    /// When the recording ends.
    pub fn end(&self) -> i64 {
        self.end
    }

    /// What a pin was at a time.
    pub fn at(&self, name: &str, time: i64) -> f64 {
        let before = self.of(name).iter().take_while(|(t, _)| *t <= time);
        before.last().unwrap_or_else(|| panic!("'{name}' was not recorded at {time}")).1
    }

    /// When a bit rose.
    pub fn rises(&self, name: &str) -> Vec<i64> {
        let changes = self.of(name);
        let later = changes.iter().skip(1);
        changes
            .iter()
            .zip(later)
            .filter(|(a, b)| a.1 == 0.0 && b.1 != 0.0)
            .map(|(_, b)| b.0)
            .collect()
    }

    /// A copy without what was before `from` and from `to` on; what held then is kept at `from`.
    pub fn between(&self, from: i64, to: i64) -> Self {
        let part = |name: &String, list: &Vec<(i64, f64)>| {
            let first = list.iter().take_while(|(t, _)| *t <= from).last().copied();
            let mut part: Vec<(i64, f64)> = first.map(|(_, v)| (from, v)).into_iter().collect();
            part.extend(list.iter().filter(|(t, _)| from < *t && *t < to));
            (name.clone(), part)
        };
        Self { changes: self.changes.iter().map(|(n, l)| part(n, l)).collect(), end: to }
    }

    /// Bits as text: a line each, with what it was at `from` and its edges up to `to`, in
    /// microseconds after `from`.
    pub fn drawing(&self, bits: &[&str], from: i64, to: i64) -> String {
        let part = self.between(from, to);
        let width = bits.iter().map(|b| b.len()).max().unwrap_or(0);
        bits.iter().fold(String::new(), |mut text, name| {
            let mut changes = part.of(name).iter();
            let first = changes.next().is_some_and(|(_, v)| *v != 0.0);
            text.push_str(&format!("{name:width$}  {}", if first { "high" } else { "low " }));
            for (time, value) in changes {
                let edge = if *value == 0.0 { "fall" } else { "rise" };
                text.push_str(&format!("  {edge} {}", (time - from) as f64 / 1e3));
            }
            text + "\n"
        })
    }

    fn change(&mut self, names: &BTreeMap<&str, Vec<String>>, code: &str, value: f64) {
        for name in names.get(code).unwrap_or_else(|| panic!("VCD: no variable {code}")) {
            self.changes.entry(name.clone()).or_default().push((self.end, value));
        }
    }
}

fn number(text: &str) -> i64 {
    text.parse().unwrap_or_else(|_| panic!("VCD: {text} is no time"))
}

#[cfg(test)]
mod tests {
    use super::Vcd;

    #[test]
    fn what_the_recorder_writes() {
        let vcd = Vcd::parse(
            "$version Ferrule $end\n$timescale 1 ns $end\n$scope module a $end\n\
             $var wire 1 ! x $end\n$var real 64 \" y $end\n$upscope $end\n$var wire 32 # n $end\n\
             $var wire 1 ! sig $end\n$enddefinitions $end\n#0\n$dumpvars\n0!\nr1.5e0 \"\nb0 #\n\
             $end\n#100\n1!\nb101 #\n#200\n0!\n#300\n1!\nr-2e-1 \"\n#400\n",
        );
        assert_eq!(vcd.rises("a.x"), [100, 300]);
        assert_eq!(vcd.of("sig"), vcd.of("a.x"));
        assert_eq!(vcd.at("a.y", 299), 1.5);
        assert_eq!(vcd.at("a.y", 300), -0.2);
        assert_eq!(vcd.at("n", 1000), 5.0);
        assert_eq!(vcd.end(), 400);
        assert_eq!(vcd.between(150, 300).of("a.x"), [(150, 1.0), (200, 0.0)]);
        let drawing = "a.x  low   rise 0.05  fall 0.15\nsig  low   rise 0.05  fall 0.15\n";
        assert_eq!(vcd.drawing(&["a.x", "sig"], 50, 250), drawing);
    }
}
