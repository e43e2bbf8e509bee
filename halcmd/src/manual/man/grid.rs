//! A Markdown table in columns for a terminal.

use crate::manual::wrap::{WIDTH, wrapped};

/// Number of spaces between two columns.
const GAP: usize = 2;
/// Minimum width of a wrapped column.
const LEAST: usize = 16;

/// Formats a table in columns, indented by `by`. If the table is too wide, wraps the widest column.
pub(super) fn grid(lines: &[&str], by: usize) -> String {
    let rows: Vec<Vec<String>> = lines.iter().map(|line| cells(line)).collect();
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let is_rule = |row: &Vec<String>| row.iter().all(|c| c.chars().all(|c| "-: ".contains(c)));
    let mut widths = vec![0; columns];
    for row in rows.iter().filter(|row| !is_rule(row)) {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = cell.chars().count().max(*width);
        }
    }
    let all = by + widths.iter().sum::<usize>() + GAP * columns.saturating_sub(1);
    if let Some(widest) = widths.iter_mut().max().filter(|_| all > WIDTH) {
        *widest = widest.saturating_sub(all - WIDTH).max(LEAST);
    }
    let mut out = String::new();
    for row in &rows {
        if is_rule(row) {
            let rule: Vec<String> = widths.iter().map(|w| "-".repeat(*w)).collect();
            line(&mut out, by, &rule, &widths);
            continue;
        }
        let wrapped: Vec<Vec<String>> =
            row.iter().zip(&widths).map(|(cell, width)| narrow(cell, *width)).collect();
        for i in 0..wrapped.iter().map(Vec::len).max().unwrap_or(0) {
            let part: Vec<String> =
                wrapped.iter().map(|c| c.get(i).cloned().unwrap_or_default()).collect();
            line(&mut out, by, &part, &widths);
        }
    }
    out
}

fn line(out: &mut String, by: usize, cells: &[String], widths: &[usize]) {
    let mut text = " ".repeat(by);
    for (cell, width) in cells.iter().zip(widths) {
        let rest = width.saturating_sub(cell.chars().count()) + GAP;
        text.push_str(cell);
        text.push_str(&" ".repeat(rest));
    }
    out.push_str(text.trim_end());
    out.push('\n');
}

/// Wraps a cell to lines of this width.
fn narrow(cell: &str, width: usize) -> Vec<String> {
    let by = WIDTH.saturating_sub(width);
    wrapped(cell, by).lines().map(|l| l.trim().to_owned()).collect()
}

/// Splits a line into cells. `\|` does not end a cell.
fn cells(line: &str) -> Vec<String> {
    let inner = line.trim().trim_start_matches('|').trim_end_matches('|');
    let parts = inner.replace("\\|", "\0");
    parts.split('|').map(|c| c.replace('\0', "|").replace('`', "").trim().to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::grid;

    #[test]
    fn columns_stand_below_each_other() {
        let table = ["| type | outputs |", "|---|---|", "| `0` | step, dir |", "| 15 | a\\|b |"];
        let wanted = "    type  outputs\n    ----  ---------\n    0     step, dir\n    15    a|b\n";
        assert_eq!(grid(&table, 4), wanted);
    }

    #[test]
    fn the_widest_column_is_wrapped() {
        let long = ["word"; 30].join(" ");
        let row = format!("| a | {long} | z |");
        let text = grid(&["| x | y | z |", "|---|---|---|", &row], 4);
        assert!(text.lines().all(|l| l.chars().count() <= 79), "{text}");
        assert_eq!(text.matches("word").count(), 30);
        assert_eq!(text.lines().filter(|l| l.contains('a') || l.contains("  z")).count(), 2);
    }
}
