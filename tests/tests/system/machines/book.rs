//! The manual: each block of its chapters is run, files that it shows are written, what it prints is compared, links lead somewhere,
//! and no message of motion and no finding is missing.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "tests; blocks that do not run are listed"
)]

use hal_docs::{CHAPTERS, FILES, content};
use hal_golden::check;
use hal_tests::{programs::root, scratch::Scratch};
use std::{collections::BTreeMap, fmt::Write as _, fs};

/// Reasons for which a block is not run.
const REASONS: &[&str] =
    &["needs root", "runs until Ctrl-C", "its result depends on the computer", "a part of a file"];

/// Words with which lines in blocks without a language may not begin: a command that no test would run.
const PROGRAMS: &[&str] = &[
    "$ ",
    "ferrule ",
    "halrun ",
    "halcmd ",
    "halscope ",
    "halgcode ",
    "halsetup ",
    "haltest ",
    "halcompile ",
    "sudo ",
    "apt",
    "cargo ",
];

/// Block between fences.
#[derive(Clone, Debug, PartialEq)]
struct Block {
    line: usize,
    language: String,
    /// Words behind the language: `file=NAME`, `no-run=REASON`.
    words: BTreeMap<String, String>,
    text: String,
}

fn blocks(chapter: &str) -> Vec<Block> {
    let mut found = Vec::new();
    let mut open: Option<(String, Block)> = None;
    for (n, line) in chapter.lines().enumerate() {
        let bare = line.trim_start();
        if let Some((fence, block)) = &mut open {
            if bare == fence.as_str() {
                found.extend(open.take().map(|(_, block)| block));
            } else {
                writeln!(block.text, "{line}").unwrap();
            }
        } else if let Some(info) = bare.strip_prefix("```") {
            let mut words = info.split(',');
            let language = words.next().unwrap_or_default().to_owned();
            let words = words
                .map(|w| w.split_once('=').map_or((w, ""), |pair| pair))
                .map(|(key, value)| (key.to_owned(), value.to_owned()))
                .collect();
            open = Some((
                "```".to_owned(),
                Block { line: n + 1, language, words, text: String::new() },
            ));
        }
    }
    assert!(open.is_none(), "a block without an end: {open:?}");
    found
}

/// Returns the commands of a block with the lines that are to follow each.
fn commands(text: &str) -> Vec<(String, Vec<String>)> {
    let mut found: Vec<(String, Vec<String>)> = Vec::new();
    for line in text.lines() {
        if let Some(command) = line.strip_prefix("$ ") {
            found.push((command.to_owned(), Vec::new()));
        } else if let Some((_, lines)) = found.last_mut() {
            lines.push(line.to_owned());
        }
    }
    found
}

/// Returns whether lines are as expected; `...` stands for any number of lines.
fn is_as(expected: &[String], got: &[&str]) -> bool {
    match expected {
        [] => got.is_empty(),
        [first, rest @ ..] if first == "..." => {
            (0..=got.len()).any(|n| got.get(n..).is_some_and(|after| is_as(rest, after)))
        }
        [first, rest @ ..] => got
            .split_first()
            .is_some_and(|(line, after)| line.trim_end() == first.trim_end() && is_as(rest, after)),
    }
}

/// Runs a line of a shell, and returns what it printed, in the order of a terminal, and its status.
fn shell(scratch: &Scratch, line: &str) -> (String, Option<i32>) {
    let output =
        scratch.run(scratch.command(&[], "sh").arg("-c").arg(format!("exec 2>&1; {line}")));
    (output.stdout, output.status)
}

/// Runs the blocks of a chapter in their order in one folder; returns what is wrong, and the blocks that do not run.
fn run(name: &str, chapter: &str) -> (Vec<String>, Vec<String>) {
    let scratch = Scratch::new(&format!("book-{}", name.trim_end_matches(".md")));
    let copied =
        scratch.run(scratch.command(&[], "cp").arg("-r").arg(root().join("configs")).arg("."));
    assert_eq!(copied.status, Some(0), "{}", copied.stderr);
    let (mut wrong, mut left) = (Vec::new(), Vec::new());
    for block in blocks(chapter) {
        let at = format!("{name}, line {} (with its includes)", block.line);
        if let Some(reason) = block.words.get("no-run") {
            left.push(format!("{at}: {reason}: {}", block.text.lines().next().unwrap_or_default()));
            if !REASONS.contains(&reason.as_str()) {
                wrong.push(format!("{at}: '{reason}' is no reason of the list"));
            }
            continue;
        }
        if let Some(file) = block.words.get("file") {
            scratch.write(file, &block.text);
            continue;
        }
        match block.language.as_str() {
            "console" => {
                let commands = commands(&block.text);
                if commands.is_empty() {
                    wrong.push(format!("{at}: no line begins with '$ '"));
                }
                for (command, lines) in commands {
                    let (got, status) = shell(&scratch, &command);
                    let got_lines: Vec<&str> = got.trim_end_matches('\n').lines().collect();
                    // A command that fails is shown with what it says.
                    let silent_failure = status != Some(0) && got.is_empty();
                    if silent_failure || status.is_none() || !is_as(&lines, &got_lines) {
                        wrong.push(format!(
                            "{at}: $ {command}\n-- the manual --\n{}\n-- status {status:?} --\n{got}",
                            lines.join("\n")
                        ));
                    }
                }
            }
            "sh" => {
                let (got, status) = shell(&scratch, &format!("set -e\n{}", block.text));
                if status != Some(0) {
                    wrong.push(format!("{at}: status {status:?}\n{}{got}", block.text));
                }
            }
            "hal" => {
                scratch.write("block.hal", &block.text);
                let output = scratch.halrun(&["--virtual", "-f", "block.hal"]);
                if output.status != Some(0) || !output.stderr.is_empty() {
                    wrong.push(format!("{at}: {:?} {}", output.status, output.stderr));
                }
            }
            "" => {
                let command = block
                    .text
                    .lines()
                    .find(|l| PROGRAMS.iter().any(|p| l.trim_start().starts_with(p)));
                if let Some(command) = command {
                    wrong.push(format!(
                        "{at}: '{command}' is a command in a block without a language"
                    ));
                }
            }
            other => {
                wrong.push(format!("{at}: a block of '{other}' has neither file= nor no-run="));
            }
        }
    }
    let running = scratch.left();
    if scratch.halrun(&["-U"]).status == Some(0) && !running.is_empty() {
        wrong.push(format!("{name}: an instance runs at its end"));
    }
    (wrong, left)
}

#[test]
fn every_command_of_the_manual_does_what_the_manual_shows() {
    let wanted = std::env::var("CASE").unwrap_or_default();
    let (mut wrong, mut left, mut count) = (Vec::new(), Vec::new(), 0);
    for chapter in CHAPTERS.iter().filter(|c| c.file.starts_with(&wanted)) {
        let text = chapter.text().unwrap();
        count += blocks(&text).iter().map(|b| commands(&b.text).len()).sum::<usize>();
        let (bad, unrun) = run(chapter.file, &text);
        wrong.extend(bad);
        left.extend(unrun);
    }
    println!("{count} commands; blocks that are not run:\n{}", left.join("\n"));
    assert!(wrong.is_empty(), "{} places:\n{}", wrong.len(), wrong.join("\n\n"));
    assert!(count > 60 || !wanted.is_empty(), "only {count} commands");
}

#[test]
fn a_wrong_command_and_a_wrong_output_are_found() {
    for (text, why) in [
        ("```console\n$ halcmd nonsense\n```\n", "halcmd nonsense"),
        ("```console\n$ echo one\ntwo\n```\n", "-- the manual --\ntwo"),
        ("```console\n$ false\n```\n", "status Some(1)"),
        ("```sh\nhalrun --virtual nothing.hal\n```\n", "status Some(255)"),
        ("```hal\nloadrt nothing\n```\n", "nothing"),
        ("```\nhalrun --virtual x.hal\n```\n", "a block without a language"),
        ("```ini\n[HAL]\n```\n", "neither file= nor no-run="),
        ("```sh,no-run=no time\ntrue\n```\n", "no reason of the list"),
        (
            "```console\n$ echo 'loadrt threads' > m.hal\n$ halrun --detach --virtual --hold m.hal\n```\n",
            "an instance runs",
        ),
    ] {
        let (wrong, _) = run("planted.md", text);
        assert!(wrong.len() == 1 && wrong.iter().all(|w| w.contains(why)), "{text}{wrong:?}");
    }
    let right =
        "```console\n$ printf 'a\\nb\\nc\\n'\na\n...\n```\n```sh,no-run=needs root\nfalse\n```\n";
    let (wrong, left) = run("right.md", right);
    assert!(wrong.is_empty() && left.len() == 1, "{wrong:?} {left:?}");
}

/// Returns the values of an attribute in a page.
fn values<'a>(page: &'a str, key: &'a str) -> impl Iterator<Item = &'a str> {
    page.match_indices(key)
        .filter_map(move |(at, _)| page.get(at + key.len()..)?.split_once('"'))
        .map(|(value, _)| value)
}

/// Returns the links of pages that lead nowhere, and the number of all.
fn broken(pages: &BTreeMap<&str, String>) -> (Vec<String>, usize) {
    let (mut bad, mut count) = (Vec::new(), 0);
    for (name, page) in pages.iter().filter(|(name, _)| name.ends_with(".html")) {
        for link in values(page, " href=\"").chain(values(page, " src=\"")) {
            count += 1;
            let (file, place) = link.split_once('#').map_or((link, None), |(f, p)| (f, Some(p)));
            let target = if file.is_empty() { name } else { &file };
            let there = pages.get(target).is_some_and(|page| {
                place.is_none_or(|place| values(page, " id=\"").any(|id| id == place))
            });
            if !there {
                bad.push(format!("{name}: {link}"));
            }
        }
    }
    (bad, count)
}

#[test]
fn links_lead_to_pages_pictures_and_headings() {
    let mut pages: BTreeMap<&str, String> = FILES
        .iter()
        .map(|(name, gzipped)| {
            (*name, String::from_utf8_lossy(&content(gzipped).unwrap()).into_owned())
        })
        .collect();
    let (bad, count) = broken(&pages);
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    assert!(count > 200, "only {count} links");
    for (name, text) in &pages {
        assert!(
            !text.contains("{{#") || !name.ends_with(".html"),
            "{name}: an include that nothing resolved"
        );
    }
    // Each kind of broken link is found.
    for planted in [
        "<a href=\"nowhere.html\">",
        "<a href=\"first.html#nowhere\">",
        "<img src=\"pictures/nowhere.png\" />",
    ] {
        let page = pages.get_mut("about.html").unwrap();
        page.push_str(planted);
        let (bad, _) = broken(&pages);
        assert_eq!(bad.len(), 1, "{planted}: {bad:?}");
        let page = pages.get_mut("about.html").unwrap();
        page.truncate(page.len() - planted.len());
    }
}

/// No reference `[text][name]` of a chapter lacks its definition.
#[test]
fn references_are_defined() {
    for chapter in CHAPTERS {
        let text = chapter.text().unwrap();
        let mut code = false;
        for line in text.lines() {
            code ^= line.trim_start().starts_with("```");
            for (_, rest) in
                line.match_indices("][").filter(|_| !code).map(|(at, _)| line.split_at(at + 2))
            {
                let name = rest.split(']').next().unwrap_or_default();
                let defined = text.lines().any(|l| l.starts_with(&format!("[{name}]: ")));
                assert!(defined, "{}: [{name}] is not defined", chapter.file);
            }
        }
    }
}

#[test]
fn the_manual_is_not_long() {
    let words: usize = CHAPTERS.iter().map(|c| c.text().unwrap().split_whitespace().count()).sum();
    assert!((10_000..=25_000).contains(&words), "{words} words");
}

/// Returns the parts of what `halcmd explain CODE` prints: its first line, its meaning, its remedy.
fn explained(text: &str) -> (String, String, String) {
    let mut parts = text.split("\n\n");
    let joined = |part: Option<&str>| {
        part.unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let first = joined(parts.next());
    let means = joined(parts.next());
    let remedy = parts.find_map(|p| p.strip_prefix("What to do:")).map(|p| joined(Some(p)));
    (first, means, remedy.unwrap_or_default())
}

#[test]
fn every_finding_has_its_place_in_the_manual() {
    let scratch = Scratch::new("book-findings");
    let listed = scratch.halcmd(&["explain"]).stdout;
    let mut page = "# Findings of check\n\n<!-- Written by the test of the manual: UPDATE_EXPECT=1. -->\n\n\
        `halcmd check` gives each finding a code. This is what each means and what to do; `halcmd explain CODE` has an example as well.\n"
        .to_owned();
    let mut count = 0;
    for code in listed.split_whitespace().filter(|w| w.len() == 4 && w.starts_with('H')) {
        let output = scratch.halcmd(&["explain", code]);
        let (first, means, remedy) = explained(&output.stdout);
        assert!(first.starts_with(code) && !means.is_empty() && !remedy.is_empty(), "{output:?}");
        let [means, remedy] = [means, remedy]
            .map(|text| text.replace('[', "\\[").replace('<', "\\<").replace('*', "\\*"));
        let title = first.split_once(": ").unwrap().1;
        let level = first.split_once('(').unwrap().1.split(')').next().unwrap();
        write!(page, "\n## {code}: {title}\n\n*{level}.* {means} **Do:** {remedy}\n").unwrap();
        count += 1;
    }
    assert!(count > 80, "only {count} findings");
    check(&root().join("halcmd/book/src/findings.md"), &page);
}

/// Returns the literal texts of a part of a source file, between two texts.
fn literals(file: &str, from: &str, to: &str) -> Vec<String> {
    let text = fs::read_to_string(root().join(file)).unwrap();
    let (_, after) = text.split_once(from).unwrap();
    let (part, _) = after.split_once(to).unwrap();
    let code = part.lines().filter(|l| !l.trim_start().starts_with("//"));
    let all = code.collect::<Vec<_>>().join("\n");
    let found = all.split('"').skip(1).step_by(2).filter(|t| t.len() > 3);
    found.map(str::to_owned).collect()
}

/// Parts of sources that hold messages of motion.
const MOTION: &[(&str, &str, &str)] = &[
    ("components/motion/safety/src/refused.rs", "\nreasons! {", "\n}\n"),
    ("components/motion/motion/src/homing/error.rs", "fn text(self)", "\n    }\n"),
    ("components/motion/motion/src/guards/switch_off.rs", "static ON_SWITCH", "\n\n"),
];

#[test]
fn every_message_of_motion_stands_in_the_manual() {
    let page = fs::read_to_string(root().join("halcmd/book/src/messages.md")).unwrap();
    let mut missing = Vec::new();
    let mut count = 0;
    for (file, from, to) in MOTION {
        for message in literals(file, from, to) {
            count += 1;
            let row = page.lines().find(|l| l.starts_with('|') && l.contains(message.trim()));
            let does = row.and_then(|l| l.split('|').nth(2)).unwrap_or_default();
            if does.trim().len() < 8 {
                missing.push(format!("{file}: {message}"));
            }
        }
    }
    assert!(missing.is_empty(), "no row of messages.md:\n{}", missing.join("\n"));
    assert!(count > 28, "only {count} messages");
}

#[test]
fn every_message_of_g_code_stands_in_the_manual() {
    let text =
        fs::read_to_string(root().join("components/motion/gcode/src/error/problem.rs")).unwrap();
    let (_, rows) = text.split_once("\nproblems! {\n").unwrap();
    let (rows, _) = rows.split_once("\n}\n").unwrap();
    let mut page = "| message | what to do |\n|---|---|\n".to_owned();
    let (mut count, mut given) = (0, 0);
    for row in rows.lines().map(str::trim).filter(|r| !r.is_empty() && !r.starts_with("//")) {
        let texts: Vec<&str> = row.split('"').skip(1).step_by(2).collect();
        let [message, remedy] = texts.as_slice() else { panic!("a row of another form: {row}") };
        given += 1;
        // A message that is a detail of the place alone.
        if message.starts_with('{') && message.ends_with('}') {
            continue;
        }
        let mut shown = String::new();
        for (n, part) in message.split('{').enumerate() {
            let part =
                if n == 0 { part } else { part.split_once('}').map_or(part, |(_, after)| after) };
            shown.push_str(if n == 0 { "" } else { "…" });
            shown.push_str(part);
        }
        let shown = shown.replace('|', "\\|");
        writeln!(
            page,
            "| `{shown}` | {} |",
            remedy.replace('|', "\\|").replace('<', "\\<").replace('*', "\\*")
        )
        .unwrap();
        count += 1;
    }
    assert!(count > 150 && given - count < 10, "{count} of {given} messages");
    check(&root().join("halcmd/book/gcode.md"), &page);
}
