//! The output of `order`, as text and as lines of a script: the order of functions that the data
//! flow implies, the delay of the user's order, and the paths of values.

use crate::language::units::duration;
use hal_protocol::{DelayInfo, HopInfo, LateInfo, OrderInfo, PathInfo, ThreadOrder, WayInfo};

/// Maximum number of paths, loops and crossings in the text; `--json` has more.
const TOLD: usize = 24;
/// Maximum number of signals named for a hop.
const NAMED: usize = 4;

/// Returns the complete text.
#[must_use]
pub fn text(info: &OrderInfo) -> String {
    if info.threads.iter().all(|t| t.functs.is_empty()) {
        return "No thread runs a function.\n".to_owned();
    }
    let mut out = String::new();
    for t in info.threads.iter().rev() {
        thread(&mut out, t);
    }
    section(&mut out, "From what comes in to what goes out", &info.paths, info.more_paths, path);
    section(&mut out, "Feedback loops", &info.loops, info.more_loops, |out, l| {
        let kind = if l.handshake { " (a handshake)" } else { "" };
        out.push_str(&format!("  Around in {}{kind}{}\n", span(l.way.delay), instead(&l.way)));
        way(out, &l.way);
    });
    crossings(&mut out, &info.crossings);
    unknown(&mut out, info);
    out
}

/// Returns the lines that change the user's order to the better one.
#[must_use]
pub fn script(info: &OrderInfo) -> String {
    let mut out = String::new();
    for t in info.threads.iter().filter(|t| !t.moves.is_empty()) {
        let spared = t.late.iter().filter(|l| !l.remains).map(values).sum();
        out.push_str(&format!(
            "# {}: {}; {} no longer a cycle late.\n",
            t.name,
            count(t.moves.len(), "function moves", "functions move"),
            count(spared, "value is", "values are"),
        ));
        for hop in &t.later {
            out.push_str(&format!(
                "# {}, from {} to {}, becomes a cycle late.\n",
                carried(hop),
                hop.from,
                hop.to
            ));
        }
        t.moves.iter().for_each(|m| out.push_str(&format!("delf {} {}\n", m.funct, t.name)));
        for m in &t.moves {
            out.push_str(&format!("addf {} {} {}\n", m.funct, t.name, m.position));
        }
    }
    if out.is_empty() {
        out.push_str("# No other order is better.\n");
    }
    out
}

fn thread(out: &mut String, t: &ThreadOrder) {
    let functions = count(t.functs.len(), "function", "functions");
    out.push_str(&format!("{}, every {}, {functions}\n", t.name, duration(t.period)));
    let widest = |lengths: &mut dyn Iterator<Item = usize>| lengths.max().unwrap_or(0);
    let width = widest(&mut t.functs.iter().map(|f| f.name.chars().count()));
    let at = |f: &hal_protocol::AddedInfo| f.at.as_ref().map(ToString::to_string);
    let places: Vec<String> = t.functs.iter().map(|f| at(f).unwrap_or_default()).collect();
    let beside = widest(&mut places.iter().map(|p| p.chars().count()));
    if !t.moves.is_empty() {
        let head = format!("      {:width$}  {:beside$}", "as added", "");
        out.push_str(&format!("{head}      better\n"));
    }
    for (i, (f, place)) in t.functs.iter().zip(&places).enumerate() {
        let mut line = format!("  {:>2}  {:width$}  {place:beside$}", i + 1, f.name);
        if let Some(better) = t.better.get(i).filter(|_| !t.moves.is_empty()) {
            let moved = t.moves.iter().any(|m| m.funct == *better);
            line.push_str(&format!("  {:>2}{} {better}", i + 1, if moved { "*" } else { " " }));
        }
        out.push_str(line.trim_end());
        out.push('\n');
    }
    late(out, t);
    out.push('\n');
}

/// Writes the values of a thread that are read late, and whether another order helps.
fn late(out: &mut String, t: &ThreadOrder) {
    let (remain, spared): (Vec<&LateInfo>, Vec<&LateInfo>) = t.late.iter().partition(|l| l.remains);
    let hops = |late: &[&LateInfo]| late.iter().map(|l| l.hop.clone()).collect::<Vec<_>>();
    if t.functs.len() > 1 && t.late.is_empty() {
        out.push_str("  Nothing is read a cycle late: no order is better.\n");
    }
    let list = |out: &mut String, hops: &[HopInfo], better: bool| {
        let place = |name: &str| {
            let of_user = || t.functs.iter().position(|f| f.name == name);
            let of_better = || t.better.iter().position(|f| f == name);
            (if better { of_better() } else { of_user() }).map_or(0, |p| p + 1)
        };
        for hop in hops {
            let (from, to) = (place(&hop.from), place(&hop.to));
            out.push_str(&format!(
                "    {}: {} writes ({from}) after {} has read ({to})\n",
                carried(hop),
                hop.from,
                hop.to
            ));
        }
    };
    if !spared.is_empty() {
        out.push_str(&format!(
            "  Read a cycle ({}) late without need; 'order --script' prints the better order:\n",
            duration(t.period)
        ));
        list(out, &hops(&spared), false);
    }
    if !t.later.is_empty() {
        out.push_str(&format!(
            "  Read a cycle ({}) late in the better order, and not as added:\n",
            duration(t.period)
        ));
        list(out, &t.later, true);
    }
    if !remain.is_empty() {
        out.push_str(&format!(
            "  Read a cycle ({}) late in any order, for values that go in a circle must wait once:\n",
            duration(t.period)
        ));
        list(out, &hops(&remain), false);
    }
}

fn path(out: &mut String, p: &PathInfo) {
    let (least, most) = (p.quickest.delay, p.slowest.as_ref().unwrap_or(&p.quickest).delay);
    let both = DelayInfo { least: least.least, most: most.most };
    out.push_str(&format!("  {} to {}: {}\n", p.from, p.to, span(both)));
    if let Some(slowest) = &p.slowest {
        let head = |w: &WayInfo| format!("{}{}", span(w.delay), instead(w));
        out.push_str(&format!("    The quickest way, {}\n", head(&p.quickest)));
        way(out, &p.quickest);
        out.push_str(&format!("    The slowest way, {}\n", head(slowest)));
        way(out, slowest);
    } else {
        if !instead(&p.quickest).is_empty() {
            out.push_str(&format!("    {}\n", instead(&p.quickest).trim_start_matches("; ")));
        }
        way(out, &p.quickest);
    }
}

/// Returns the delay of a path in the better order, if it differs.
fn instead(w: &WayInfo) -> String {
    if w.better == w.delay {
        String::new()
    } else {
        format!("; in the better order {}", span(w.better))
    }
}

/// Writes the functions of a path, one per line, with the values that flow between them.
fn way(out: &mut String, w: &WayInfo) {
    let names: Vec<String> = w.hops.iter().map(carried).collect();
    let width = names.iter().map(|n| n.chars().count()).max().unwrap_or(0);
    for (i, (hop, name)) in w.hops.iter().zip(&names).enumerate() {
        if i == 0 {
            out.push_str(&format!("      {}\n", hop.from));
        }
        out.push_str(&format!("        | {name:width$}  {}\n      {}\n", arrival(hop), hop.to));
    }
}

fn crossings(out: &mut String, hops: &[HopInfo]) {
    if hops.is_empty() {
        return;
    }
    out.push_str("Between threads\n");
    for hop in hops.iter().take(TOLD) {
        let way = format!("{} to {}", hop.from, hop.to);
        out.push_str(&format!("  {way}, {}: {}\n", carried(hop), arrival(hop)));
    }
    rest(out, hops.len(), false);
    out.push('\n');
}

fn unknown(out: &mut String, info: &OrderInfo) {
    let functs = info.threads.iter().flat_map(|t| &t.functs).filter(|f| f.unknown);
    let names: Vec<&str> = functs.map(|f| f.name.as_str()).collect();
    if !names.is_empty() {
        out.push_str(
            "What these functions read and write is not known. Nothing is said of what passes \
             through them,\nand whatever is linked to them stays on its side of them:\n",
        );
        names.iter().for_each(|name| out.push_str(&format!("  {name}\n")));
        out.push('\n');
    }
}

fn section<T>(
    out: &mut String,
    title: &str,
    list: &[T],
    more: bool,
    tell: impl Fn(&mut String, &T),
) {
    if list.is_empty() {
        return;
    }
    out.push_str(&format!("{title}\n"));
    for item in list.iter().take(TOLD) {
        tell(out, item);
    }
    rest(out, list.len(), more);
    out.push('\n');
}

fn rest(out: &mut String, n: usize, more: bool) {
    if n > TOLD {
        let at_least = if more { "at least " } else { "" };
        out.push_str(&format!("  ... and {at_least}{} more, which '--json' has\n", n - TOLD));
    }
}

/// Returns the time at which the reader receives the value.
fn arrival(hop: &HopInfo) -> String {
    let DelayInfo { least, most } = hop.delay;
    match (hop.crosses, most) {
        (false, 0) => "same cycle".to_owned(),
        (false, _) => format!("next cycle, {} later", duration(most)),
        (true, 0) => format!("same moment, {}", hop.thread),
        (true, _) if least == most => format!("next cycle of {}, {}", hop.thread, duration(most)),
        (true, _) => format!("next cycle of {}, {}", hop.thread, span(hop.delay)),
    }
}

/// Returns the names of the pins and signals that carry a value.
fn carried(hop: &HopInfo) -> String {
    let named = hop.by.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
    match hop.by.len() {
        0 => "(its own state)".to_owned(),
        n if n > NAMED => format!("{named} and {} more", n - NAMED),
        _ => named,
    }
}

/// Returns the number of values that a late hop carries.
fn values(late: &LateInfo) -> usize {
    late.hop.by.len().max(1)
}

fn span(delay: DelayInfo) -> String {
    match (delay.least, delay.most) {
        (_, 0) => "no delay".to_owned(),
        (least, most) if least == most => duration(most),
        (0, most) => format!("up to {}", duration(most)),
        (least, most) => format!("{} to {}", duration(least), duration(most)),
    }
}

fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}
