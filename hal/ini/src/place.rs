//! Places of files that values name.

use std::path::{Path, PathBuf};

/// Returns the path of a file or folder that a value names: `~` and `~/…` lie in the user's home, other relative paths in
/// `folder`, that of the INI file. White space around the name is no part of it. Without `HOME` a `~` is a name like any
/// other.
#[must_use]
pub fn beside(folder: &Path, name: &str) -> PathBuf {
    place(folder, name.trim(), std::env::var_os("HOME").map(PathBuf::from))
}

fn place(folder: &Path, name: &str, home: Option<PathBuf>) -> PathBuf {
    let rest = name.strip_prefix('~').filter(|rest| rest.is_empty() || rest.starts_with('/'));
    match (rest, home.filter(|home| home.is_absolute())) {
        (Some(rest), Some(home)) => match rest.trim_start_matches('/') {
            "" => home,
            inside => home.join(inside),
        },
        _ => folder.join(name),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_lies_in_the_folder_in_the_home_or_where_it_says() {
        let home = Some("/home/u");
        for (name, home, want) in [
            ("x.tbl", home, "/m/x.tbl"),
            ("../x", home, "/m/../x"),
            ("/x/y", home, "/x/y"),
            ("~", home, "/home/u"),
            ("~/", home, "/home/u"),
            ("~/x", home, "/home/u/x"),
            ("~//x", home, "/home/u/x"),
            // Another user's home, and a name that only begins so.
            ("~v/x", home, "/m/~v/x"),
            ("x~", home, "/m/x~"),
            ("~/x", None, "/m/~/x"),
            ("~/x", Some("relative"), "/m/~/x"),
        ] {
            let got = place(Path::new("/m"), name, home.map(PathBuf::from));
            assert_eq!(got.to_str(), Some(want), "{name} {home:?}");
        }
        assert_eq!(beside(Path::new("/m"), "  x.tbl "), Path::new("/m/x.tbl"));
    }
}
