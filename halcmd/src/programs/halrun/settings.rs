//! The settings of an INI file as pins `ini.*`, which LinuxCNC's task makes.

use hal_protocol::{Failure, Kind, Link, Reply, Request};

/// Returns whether a HAL file names pins `ini.*`, and does not load `inihal` itself.
pub(super) fn are_missing(text: &[u8]) -> bool {
    let lines = text.split(|c| *c == b'\n').filter_map(|line| line.split(|c| *c == b'#').next());
    let words: Vec<&[u8]> = lines.flat_map(|line| line.split(u8::is_ascii_whitespace)).collect();
    words.iter().any(|word| word.starts_with(b"ini.")) && !words.contains(&&b"inihal"[..])
}

/// Loads `inihal`, unless a file has done so: LinuxCNC's task has its pins when the files of `POSTGUI_HALFILE` run.
pub(super) fn load(link: &mut dyn Link) -> Result<(), Failure> {
    let name = "inihal".to_owned();
    let found = link.call(Request::Component { name: name.clone() })?;
    let is_loaded = matches!(found, Reply::Components(found) if !found.is_empty());
    let patterns = vec!["motion.configure".to_owned()];
    let list = Request::List { kind: Kind::Commands, patterns, ty: None };
    let has_motion = matches!(link.call(list)?, Reply::Commands(list) if !list.is_empty());
    if has_motion && !is_loaded {
        link.call(Request::Load { module: name, args: Vec::new() })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::are_missing;

    #[test]
    fn pins_in_words_count_and_comments_do_not() {
        assert!(are_missing(b"loadrt or2\n  net a => ini.0.max_velocity # limit\n"));
        for text in [
            "",
            "# setp ini.0.max_velocity 3\n",
            "net a mini.0.b\n",
            "setp b.ini.0 3\n",
            "loadrt inihal\nsetp ini.0.max_velocity 3\n",
        ] {
            assert!(!are_missing(text.as_bytes()), "{text}");
        }
    }
}
