//! The existing name that is nearest to an unknown one.

/// Begin of the names of drivers that scripts and people leave out.
const DRIVER: &str = "hal_";

/// Returns the candidate nearest to `word`, upper and lower case apart, if one is near enough.
pub(crate) fn nearest<'n>(
    word: &str,
    names: impl IntoIterator<Item = &'n str>,
) -> Option<Box<str>> {
    // Limits the distance so that at least one character of the word remains.
    let far = (1 + word.len() / 4).min(word.len().saturating_sub(1));
    let lower = word.to_lowercase();
    let distance = |name: &str| {
        if name.strip_prefix(DRIVER) == Some(&lower) {
            return (0, 0);
        }
        let case = strsim::damerau_levenshtein(word, name);
        (strsim::damerau_levenshtein(&lower, &name.to_lowercase()), case)
    };
    names
        .into_iter()
        .filter(|n| n.len().abs_diff(word.len()) <= far.max(DRIVER.len()))
        .map(|n| (distance(n), n))
        .filter(|((d, _), _)| *d <= far)
        .min()
        .map(|(_, n)| n.into())
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn the_nearest_name_is_found_whatever_its_case() {
        let names =
            ["pid.0.Dgain", "pid.0.Igain", "pid.0.Pgain", "hal_viagpio", "hal_parport", "and2"];
        for (word, near) in [
            ("pid.0.pgain", Some("pid.0.Pgain")),
            ("pid.0.DGAIN", Some("pid.0.Dgain")),
            ("pid.0.Pgian", Some("pid.0.Pgain")),
            ("viagpio", Some("hal_viagpio")),
            ("parport", Some("hal_parport")),
            ("Parport", Some("hal_parport")),
            ("and3", Some("and2")),
            ("xyz", None),
            ("a", None),
        ] {
            assert_eq!(nearest(word, names).as_deref(), near, "{word}");
        }
    }
}
