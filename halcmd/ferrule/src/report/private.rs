//! Private details of a text: who the user is, which computer this is, where it is on the network, and secrets.

use std::net::IpAddr;

/// Parts of names of INI entries whose values are secrets.
const SECRETS: [&str; 5] = ["PASSWORD", "PASSWD", "TOKEN", "SECRET", "KEY"];

/// Private words, each with the sign that stands for it.
pub(super) struct Private {
    words: Vec<(String, &'static str)>,
}

impl Private {
    /// Returns the details of this user and this computer.
    pub(super) fn of_this_user() -> Self {
        let named = |name: &str| std::env::var(name).unwrap_or_default();
        let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
        Self::new(&named("HOME"), &named("USER"), host.trim())
    }

    fn new(home: &str, user: &str, host: &str) -> Self {
        // The home folder goes first, since its name has the user's in it.
        let words = [(home, "~"), (user, "USER"), (host, "HOST")];
        // A name that is as short as a word of a script, or root, would spoil the text and hides nobody.
        let words = words
            .into_iter()
            .filter(|(word, _)| word.len() > 2 && !matches!(*word, "root" | "/root"));
        Self { words: words.map(|(word, sign)| (word.to_owned(), sign)).collect() }
    }

    /// Returns a text without them.
    pub(super) fn without(&self, text: &str) -> String {
        text.lines().map(|line| self.line(line) + "\n").collect()
    }

    fn line(&self, line: &str) -> String {
        if let Some((name, _)) = line.split_once('=')
            && let upper = name.trim().to_uppercase()
            && !upper.contains(char::is_whitespace)
            && SECRETS.iter().any(|secret| upper.ends_with(secret))
        {
            return format!("{}= (left out)", name);
        }
        let mut line = line.to_owned();
        for (word, sign) in &self.words {
            line = line.replace(word, sign);
        }
        addresses(&line)
    }
}

/// Returns a line with a sign for each network address but those that every computer has.
fn addresses(line: &str) -> String {
    let is_part = |c: char| c.is_ascii_hexdigit() || c == '.' || c == ':';
    let mut out = String::new();
    let mut rest = line;
    while let Some(begin) = rest.find(is_part) {
        let (before, from) = rest.split_at(begin);
        let end = from.find(|c| !is_part(c)).unwrap_or(from.len());
        let (word, after) = from.split_at(end);
        out.push_str(before);
        out.push_str(if is_private(word) { "ADDRESS" } else { word });
        rest = after;
    }
    out + rest
}

fn is_private(word: &str) -> bool {
    let word = word.trim_end_matches(['.', ':']);
    let host = word.rsplit_once(':').map_or(word, |(host, _)| host);
    let address: Option<IpAddr> = word.parse().ok().or_else(|| host.parse().ok());
    let is_card = word.split(':').count() == 6 && word.split(':').all(|part| part.len() == 2);
    is_card || address.is_some_and(|a| !a.is_loopback() && !a.is_unspecified())
}

#[cfg(test)]
mod tests {
    use super::Private;

    #[test]
    fn private_details_are_left_out() {
        let private = Private::new("/home/nobody-else", "nobody-else", "workshop");
        for (text, want) in [
            ("PROGRAM_PREFIX = /home/nobody-else/nc", "PROGRAM_PREFIX = ~/nc"),
            ("owner nobody-else on workshop", "owner USER on HOST"),
            ("net x 10.10.10.10:27181 and 127.0.0.1:7776", "net x ADDRESS and 127.0.0.1:7776"),
            ("2001:db8::7 up", "ADDRESS up"),
            ("mac 00:1b:21:aa:bb:cc", "mac ADDRESS"),
            (
                "1.5.2 is a version, 12:30:01 a time, 3.25 a number",
                "1.5.2 is a version, 12:30:01 a time, 3.25 a number",
            ),
            ("WIFI_PASSWORD = hunter2", "WIFI_PASSWORD = (left out)"),
            ("api_token=abc", "api_token= (left out)"),
            ("setp key 1 = 2", "setp key 1 = 2"),
        ] {
            assert_eq!(private.without(text), format!("{want}\n"), "{text}");
        }
        let root = Private::new("/root", "root", "pc");
        assert_eq!(root.without("root of /root on pc"), "root of /root on pc\n");
    }
}
