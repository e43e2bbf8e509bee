//! Search for the existing name that an unknown one was probably meant to be.

/// Beginning of the names of drivers, which scripts and people leave out.
const DRIVER: &str = "hal_";

/// Returns the name nearest to `word` at a distance of at most `most` changed characters. Upper and lower case count only
/// among names that are equally near. At least one character of a longer word
/// remains.
#[must_use]
pub fn nearest<'n>(
    word: &str,
    most: usize,
    names: impl IntoIterator<Item = &'n str>,
) -> Option<Box<str>> {
    let most = most.min(word.len().max(2) - 1);
    let lower = word.to_lowercase();
    let distance = |name: &str| {
        if name.strip_prefix(DRIVER) == Some(lower.as_str()) {
            return (0, 0);
        }
        let exact = strsim::damerau_levenshtein(word, name);
        (strsim::damerau_levenshtein(&lower, &name.to_lowercase()), exact)
    };
    names
        .into_iter()
        .filter(|n| n.len().abs_diff(word.len()) <= most.max(DRIVER.len()))
        .map(|n| (distance(n), n))
        .filter(|((d, _), _)| *d <= most)
        .min()
        .map(|(_, n)| n.into())
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn the_nearest_name_is_found_whatever_its_case() {
        let names = ["pid.0.Dgain", "pid.0.Igain", "pid.0.Pgain", "hal_parport", "and2"];
        let cases = [
            ("pid.0.pgain", Some("pid.0.Pgain")),
            ("pid.0.DGAIN", Some("pid.0.Dgain")),
            ("pid.0.Pgian", Some("pid.0.Pgain")),
            ("parport", Some("hal_parport")),
            ("Parport", Some("hal_parport")),
            ("and3", Some("and2")),
            ("xyz", None),
            ("", None),
        ];
        for (word, near) in cases {
            assert_eq!(nearest(word, 2, names).as_deref(), near, "{word}");
        }
        assert_eq!(nearest("and3", 0, names), None);
    }
}
