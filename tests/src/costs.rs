//! The table of costs in `components/SPEED.md`, of which a component can be measured alone.

/// Returns the old table with the rows of one component replaced by those of a new one, the most expensive first. What
/// is below the rows stays.
#[must_use]
pub fn with_rows_of(old: &str, new: &str, component: &str) -> String {
    let own = format!("| `{component}` | `");
    let mut lines: Vec<&str> = old.lines().collect();
    let end = |lines: &[&str]| {
        let first = lines.iter().position(|l| l.starts_with("|---")).map_or(0, |i| i + 1);
        let rows = lines.iter().skip(first).take_while(|l| l.starts_with('|')).count();
        (first, first + rows)
    };
    let (first, last) = end(&lines);
    let mut rows: Vec<&str> =
        lines.splice(first..last, []).filter(|l| !l.starts_with(&own)).collect();
    for row in new.lines().filter(|l| l.starts_with(&own)) {
        let at = rows.iter().position(|l| nanoseconds(l) < nanoseconds(row)).unwrap_or(rows.len());
        rows.insert(at, row);
    }
    lines.splice(first..first, rows);
    lines.join("\n") + "\n"
}

/// Returns the cost in the last cell of a row; 0 for `< 1`.
fn nanoseconds(row: &str) -> f64 {
    row.trim_end_matches(" |").rsplit("| ").next().and_then(|ns| ns.parse().ok()).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::with_rows_of;

    #[test]
    fn one_component_replaces_only_its_own_rows() {
        let head = "\n\n| component | function | ns |\n|---|---|---|\n";
        let tail = "\n| library | ms |\n|---|---|\n| `a` | 1.5 |\n";
        let old = format!(
            "{head}| `a` | `a.N` | 250 |\n| `or2` | `or2.N` | 2.2 |\n| `b` | `b.N` | < 1 |\n{tail}"
        );
        let with = |rows: &str| with_rows_of(&old, &format!("{head}{rows}"), "or2");
        let row = |ns: &str| format!("| `or2` | `or2.N` | {ns} |\n");
        assert_eq!(with(&row("2.2")), old);
        assert_eq!(
            with(&row("300")),
            format!("{head}{}| `a` | `a.N` | 250 |\n| `b` | `b.N` | < 1 |\n{tail}", row("300"))
        );
        assert_eq!(
            with(&row("< 1")),
            format!("{head}| `a` | `a.N` | 250 |\n| `b` | `b.N` | < 1 |\n{}{tail}", row("< 1"))
        );
        assert_eq!(with(""), old.replace(&row("2.2"), ""));
    }
}
