//! Programs that start another one, whose name and arguments stand behind their own.

/// Program that starts another one.
pub(super) struct Starter {
    name: &'static str,
    /// Options that have a value in the next word.
    valued: &'static [&'static str],
    /// Options of an interpreter behind which stands no file, but a text that is executed.
    texts: &'static [&'static str],
    /// Number of words between its options and the other program.
    between: usize,
}

const fn interpreter(
    name: &'static str,
    valued: &'static [&'static str],
    texts: &'static [&'static str],
) -> Starter {
    Starter { name, valued, texts, between: 0 }
}

const fn starter(name: &'static str, valued: &'static [&'static str], between: usize) -> Starter {
    Starter { name, valued, texts: &[], between }
}

/// All of them.
const STARTERS: &[Starter] = &[
    interpreter("python", &["-W", "-X"], &["-c"]),
    interpreter("sh", &["-o", "+o"], &["-c"]),
    interpreter("bash", &["-o", "+o", "-O", "+O"], &["-c"]),
    interpreter("perl", &[], &["-e", "-E"]),
    starter("sudo", &["-u", "-g", "-h", "-p", "-C", "-T", "-U", "-D", "-R", "-r", "-t"], 0),
    starter("env", &["-u", "-C"], 0),
    starter("nice", &["-n"], 0),
    starter("ionice", &["-c", "-n"], 0),
    starter("nohup", &[], 0),
    starter("setsid", &[], 0),
    starter("stdbuf", &["-i", "-o", "-e"], 0),
    starter("timeout", &["-s", "-k"], 1),
    starter("taskset", &[], 1),
    starter("chrt", &["-T", "-P", "-D"], 1),
];

impl Starter {
    /// Returns what starts others by this name.
    pub(super) fn of(name: &str) -> Option<&'static Self> {
        let is_version = |rest: &str| rest.bytes().all(|b| b.is_ascii_digit() || b == b'.');
        STARTERS.iter().find(|s| match name.strip_prefix(s.name) {
            Some(rest) => rest.is_empty() || !s.texts.is_empty() && is_version(rest),
            None => false,
        })
    }

    /// Returns the place of the program that it starts, among its arguments; `None` if it executes a text.
    pub(super) fn started(&self, args: &[String]) -> Option<usize> {
        let mut words = args.iter().map(String::as_str).enumerate();
        let mut between = self.between;
        while let Some((at, word)) = words.next() {
            if self.texts.contains(&word) {
                return None;
            }
            if word == "--" || self.name == "env" && word.contains('=') {
                continue;
            }
            if self.valued.contains(&word) {
                words.next();
            } else if !word.starts_with('-') && !word.starts_with('+') {
                if between == 0 {
                    return Some(at);
                }
                between -= 1;
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use crate::language::command::Launch;

    #[test]
    fn the_program_behind_others_is_found() {
        for (line, name, args) in [
            ("hy_vfd -d x", "hy_vfd", "-d x"),
            ("/usr/bin/halui", "halui", ""),
            ("python3 -u /x/mpg.py --port=1 a", "mpg.py", "--port=1 a"),
            ("python3.11 -W ignore x.py", "x.py", ""),
            ("python", "python", ""),
            ("python3 -m pyvcp -c panel", "pyvcp", "-c panel"),
            ("python3 -c pass", "python3", "-c pass"),
            ("sh -c hal_input", "sh", "-c hal_input"),
            ("bash -x -o pipefail run.sh 1", "run.sh", "1"),
            ("sh -e run.sh 2", "run.sh", "2"),
            ("sudo -u root halui", "halui", ""),
            ("sudo -n -- nice -n -5 /usr/bin/hal_input -KR X", "hal_input", "-KR X"),
            ("env -u HOME A=1 B= gs2_vfd -r 9600", "gs2_vfd", "-r 9600"),
            ("timeout -s KILL 5 mb2hal a.ini", "mb2hal", "a.ini"),
            ("taskset -c 1 chrt -f 20 setsid nohup xhc-whb04b-6 -H", "xhc-whb04b-6", "-H"),
            ("stdbuf -o L ionice -c 2 shuttle", "shuttle", ""),
            ("shuttle -u root", "shuttle", "-u root"),
            ("pythonic x", "pythonic", "x"),
            ("sudo", "sudo", ""),
        ] {
            let mut words = line.split(' ').map(str::to_owned);
            let program = words.next().unwrap();
            let launch = Launch { program, args: words.collect(), ..Launch::default() };
            assert_eq!(
                (launch.name(), launch.own_args().join(" ")),
                (name, args.to_owned()),
                "{line}"
            );
        }
    }
}
