//! Machines with a deliberate fault: small scripts whose faulty line is marked.

use crate::scratch::Scratch;
use hal_protocol::{At, Code, Finding, Level, Reply};

/// Mark of the faulty line: at its end, or alone on the line below it.
const MARK: &str = "# <--";

/// A machine in files: the first is `m.hal`, each further one begins with `--- NAME`.
#[derive(Clone, Debug)]
pub struct Planted {
    files: Vec<(String, String)>,
    /// Position of the mark.
    pub at: Option<At>,
}

impl Planted {
    /// Parses a machine.
    pub fn parse(text: &str) -> Self {
        let mut files: Vec<(String, String)> = vec![("m.hal".to_owned(), String::new())];
        for line in text.split_inclusive('\n') {
            match line.strip_prefix("--- ") {
                Some(name) => files.push((name.trim().to_owned(), String::new())),
                None => files.last_mut().unwrap().1.push_str(line),
            }
        }
        let at = files.iter().find_map(|(name, text)| {
            let mut lines = text.lines().zip(1_u32..);
            let (line, number) = lines.find(|(line, _)| line.contains(MARK))?;
            Some(At::new(name, if line.trim() == MARK { number - 1 } else { number }))
        });
        Self { files, at }
    }

    /// Runs `halcmd check` and returns its exit status and findings: on the INI file if it names HAL files, else on the
    /// script, together with the INI file if there is one.
    pub fn check(&self, name: &str) -> (Option<i32>, Vec<Finding>) {
        let scratch = Scratch::new(name);
        for (file, text) in &self.files {
            scratch.write(file, text);
            if file.ends_with(".comp") {
                let mut halcompile = scratch.command(&[], "halcompile");
                let made = scratch.run(halcompile.args(["--compile", file]));
                assert_eq!(made.status, Some(0), "{file}: {}", made.stderr);
            }
        }
        let ini = self.files.iter().find(|(name, _)| name == "m.ini").map(|(_, text)| text);
        let words: &[&str] = match ini {
            None => &["check", "--json", "m.hal"],
            Some(text) if text.contains("[EMCIO]") => &["check", "--json", "m.ini"],
            Some(_) => &["check", "--json", "-i", "m.ini", "m.hal"],
        };
        let mut halcmd = scratch.command(&[], "halcmd");
        let output = scratch.run(halcmd.env("HAL_RTMOD_DIR", scratch.path()).args(words));
        let Ok(Reply::Findings(list)) = serde_json::from_str(&output.stdout) else {
            panic!("{name}: {}{}", output.stdout, output.stderr)
        };
        (output.status, list)
    }
}

/// Returns the mistakes: the faulty machine must have the finding at the mark and the status of its worst finding; the
/// correct one must have neither that finding nor any error or warning.
pub fn mistakes(name: &str, code: Code, wrong: &str, right: &str) -> Vec<String> {
    let mut out = Vec::new();
    let planted = Planted::parse(wrong);
    let (status, found) = planted.check(name);
    if !found.iter().any(|f| f.code == code && f.at == planted.at) {
        out.push(format!("{name}: no {code} at {:?}:\n{}", planted.at, shown(&found)));
    }
    let worst = found.iter().map(|f| f.level).max().map_or(0, |l| l as i32);
    if status != Some(worst) {
        out.push(format!("{name}: status {status:?}, not {worst}"));
    }
    let (status, found) = Planted::parse(right).check(name);
    let bad = |f: &&Finding| f.level > Level::Note || f.code == code;
    if found.iter().any(|f| bad(&f)) || status != Some(0) {
        out.push(format!("{name}: put right, status {status:?}, and still:\n{}", shown(&found)));
    }
    out
}

fn shown(found: &[Finding]) -> String {
    let line = |f: &Finding| {
        let at = f.at.as_ref().map(ToString::to_string).unwrap_or_default();
        format!("  {at} {}[{}] {}: {}\n", f.level.name(), f.code, f.subject, f.text)
    };
    found.iter().map(line).collect()
}
