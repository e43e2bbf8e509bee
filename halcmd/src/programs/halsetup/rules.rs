//! The rules of answers. Each answer is judged when it is given, in the terminal and in a file alike: what no rule refuses
//! makes a machine.

use super::{
    lines::{LineWay, refuse},
    questions::{Asked, Form, LARGEST, Range, SMALLEST, is_second, joints},
    sheet::{Sheet, number},
    whole::{jitter, left, reset, scale, speed, units},
};

/// Largest number of parallel ports.
const MAX_PORTS: usize = 8;
/// Largest number of joints.
const MAX_JOINTS: usize = 9;
/// Letters of axes.
const LETTERS: &str = "XYZABCUVW";

/// A rule: its name, and why it refuses an answer.
pub(super) struct Rule {
    /// Name, for the test that breaks each rule.
    #[cfg_attr(not(test), expect(dead_code, reason = "the test's"))]
    pub(super) name: &'static str,
    pub(super) refuses: fn(&Sheet, &Asked, &str) -> Option<String>,
    /// Questions before, to which a person may want to go back, where the rule is about them too.
    back: &'static str,
}

const fn rule(name: &'static str, refuses: fn(&Sheet, &Asked, &str) -> Option<String>) -> Rule {
    Rule { name, refuses, back: "" }
}

/// All rules.
pub(super) const RULES: &[Rule] = &[
    rule("none", nothing),
    rule("name", name),
    rule("number", range),
    rule("word", word),
    rule("ports", ports),
    rule("axes", axes),
    rule("gantry", gantry),
    rule("line", of_the_board),
    rule("order", order),
    rule("home", home),
    rule("search", search),
    rule("drive", drive),
    Rule { back: "the step", ..rule("pair", pair) },
    rule("motor", some_motor),
    rule("sides", both_sides),
    Rule { back: "the velocity", ..rule("speed", speed) },
    rule("driver", driver),
    rule("jitter", jitter),
    Rule { back: "the ports", ..rule("left", left) },
    rule("scale", scale),
    Rule { back: "the travel and, further, to the unit", ..rule("units", units) },
    rule("reset", reset),
];

/// Returns why an answer cannot be.
pub(super) fn refusal(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    refused(sheet, asked, answer).map(|(_, text)| text)
}

/// Returns why an answer of a person in the conversation cannot be, and where 'back' leads then.
pub(super) fn told(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let (rule, text) = refused(sheet, asked, answer)?;
    Some(match rule.back {
        "" => text,
        place => format!("{text} ('back' returns to {place})"),
    })
}

fn refused(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<(&'static Rule, String)> {
    RULES.iter().find_map(|rule| Some((rule, (rule.refuses)(sheet, asked, answer)?)))
}

fn nothing(_: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    (answer.is_empty() && !asked.may_be_none()).then(|| match asked.question.key {
        "step" | "a" | "b" => format!("a servo needs {}", asked.question.key),
        _ => "an answer is needed".to_owned(),
    })
}

fn name(_: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    let is_name = answer.chars().all(is_plain) && !answer.starts_with('-') && answer.len() <= 64;
    (asked.question.form == Form::Name && !is_name).then(|| {
        format!(
            "name '{answer}': letters, digits, '-' and '_' make the name of a machine, 64 at most"
        )
    })
}

fn range(_: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let Form::Number(range) = asked.question.form else { return None };
    if answer.is_empty() {
        return None;
    }
    let unit = if asked.unit.is_empty() { String::new() } else { format!(" {}", asked.unit) };
    let Some(value) = number(answer) else {
        let unit = if asked.unit.is_empty() { "" } else { &format!(" in {}", asked.unit) };
        return Some(format!("'{answer}' is not a number{unit}, as 5 or 0.25"));
    };
    let (least, most) = match range {
        Range::Within(least, most) => (least, most),
        Range::Signed => (-LARGEST, LARGEST),
        Range::Positive | Range::PositiveOrNone => (SMALLEST, LARGEST),
    };
    let is_in = least <= value && value <= most;
    (!is_in)
        .then(|| format!("{} {answer}: a number from {least} to {most}{unit}", asked.question.key))
}

fn word(_: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let Form::OneOf(words) = asked.question.form else { return None };
    (!words.contains(&answer)).then(|| format!("'{answer}' is none of: {}", words.join(", ")))
}

/// An address in hexadecimal digits and perhaps a mode. Anything else could be more than the argument that it becomes.
fn ports(_: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    if asked.question.form != Form::Ports {
        return None;
    }
    let list: Vec<&str> = answer.split(',').map(str::trim).collect();
    let is_port = |text: &&str| {
        let mut words = text.split(' ').filter(|word| !word.is_empty());
        let address = words.next().unwrap_or_default().trim_start_matches("0x");
        let mode = words.next().unwrap_or("out");
        (1..=4).contains(&address.len())
            && address.bytes().all(|b| b.is_ascii_hexdigit())
            && ["out", "in", "x", "epp"].contains(&mode)
            && words.next().is_none()
    };
    let mut addresses: Vec<&str> = list.iter().filter_map(|port| port.split(' ').next()).collect();
    addresses.sort_unstable();
    if !(1..=MAX_PORTS).contains(&list.len()) || !list.iter().all(is_port) {
        return Some(format!(
            "ports: 1 to {MAX_PORTS} of a form as '378 out': an address in hexadecimal digits, then out, in, x or epp"
        ));
    }
    let is_twice = addresses.windows(2).any(|two| matches!(two, [a, b] if a == b));
    is_twice.then(|| "ports: each address once".to_owned())
}

fn axes(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    if asked.question.form != Form::Axes {
        return None;
    }
    let wrong = answer.chars().find(|c| !LETTERS.contains(*c));
    if let Some(letter) = wrong {
        return Some(format!("axis '{letter}': one of X Y Z A B C U V W"));
    }
    let twice =
        answer.char_indices().find(|(n, c)| answer.get(..*n).is_some_and(|b| b.contains(*c)));
    if let Some((_, letter)) = twice {
        return Some(format!(
            "axis {letter} is there twice; an axis with two motors is a gantry, which is asked for next"
        ));
    }
    let is_arm = sheet.get("kind") == Some("arm");
    (is_arm && !"XYZ".chars().all(|c| answer.contains(c)))
        .then(|| "an arm needs its work volume: at least X, Y and Z".to_owned())
}

fn gantry(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    if asked.question.form != Form::Gantry || answer.is_empty() {
        return None;
    }
    let axes = sheet.get("axes").unwrap_or_default();
    if answer.len() != 1 || !axes.contains(answer) {
        return Some(format!("'{answer}' is none of the axes {axes}"));
    }
    (axes.len() >= MAX_JOINTS).then(|| format!("a machine has at most {MAX_JOINTS} motors"))
}

fn of_the_board(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let way = match asked.question.form {
        Form::Input => LineWay::In,
        Form::Output => LineWay::Out,
        _ => return None,
    };
    if answer.is_empty() { None } else { refuse(sheet, &asked.key, answer, way) }
}

/// Returns the number that another question of the same joint or axis has.
pub(super) fn beside(sheet: &Sheet, asked: &Asked, name: &str) -> Option<f64> {
    let (before, _) = asked.key.rsplit_once('.')?;
    sheet.number(&format!("{before}.{name}"))
}

fn order(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let min = (asked.question.key == "max").then(|| beside(sheet, asked, "min"))??;
    let max = number(answer)?;
    (max - min < SMALLEST).then(|| {
        format!(
            "max {max:?} is not above min (by {SMALLEST} at least), which is {min:?} {}",
            asked.unit
        )
    })
}

fn home(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let at = (asked.question.key == "home").then(|| number(answer))??;
    let (min, max) = (beside(sheet, asked, "min")?, beside(sheet, asked, "max")?);
    let is_inside = min <= at && at <= max;
    (!is_inside).then(|| format!("home {at:?} is outside of {min:?} to {max:?} {}", asked.unit))
}

fn search(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let search = (asked.question.key == "search").then(|| number(answer))??;
    let most = beside(sheet, asked, "velocity")?;
    let is_possible = search != 0.0 && search.abs() <= most;
    (!is_possible).then(|| {
        format!("search {search:?}: not 0, and at most {most:?} {} to either side", asked.unit)
    })
}

fn drive(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let drive = (asked.question.key == "drive-acceleration").then(|| number(answer))??;
    let own = beside(sheet, asked, "acceleration")?;
    (drive < own).then(|| format!("drive-acceleration {drive:?} is below the acceleration, {own:?} {}: the steps could not follow", asked.unit))
}

/// Returns the answer of the same joint to another question.
fn text_beside<'a>(sheet: &'a Sheet, asked: &Asked, name: &str) -> Option<&'a str> {
    let (before, _) = asked.key.rsplit_once('.')?;
    sheet.get(&format!("{before}.{name}"))
}

fn pair(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    if asked.question.key == "step" {
        let is_servo = sheet.get("kind") == Some("servos");
        return (is_servo && answer.is_empty())
            .then(|| "a servo needs step, the output of its power".to_owned());
    }
    let step = (asked.question.key == "direction").then(|| text_beside(sheet, asked, "step"))??;
    (step.is_empty() != answer.is_empty())
        .then(|| "step and direction belong together: both, or none".to_owned())
}

fn some_motor(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let last = joints(sheet).checked_sub(1)?;
    let is_last = asked.key == format!("joint.{last}.step") && answer.is_empty();
    let is_wired = (0..last).any(|n| sheet.some(&format!("joint.{n}.step")).is_some());
    (is_last && !is_wired)
        .then(|| "no motor has an output yet, and this is the last one".to_owned())
}

fn both_sides(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let words: Vec<&str> = asked.key.split('.').collect();
    let ["joint", n, "switch"] = words.as_slice() else { return None };
    let n: usize = n.parse().ok()?;
    let first = sheet.get(&format!("joint.{}.switch", n.checked_sub(1)?))?;
    (is_second(sheet, n) && first.is_empty() != answer.is_empty())
        .then(|| "both motors of a gantry have a switch, or none".to_owned())
}

fn driver(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let kind =
        (asked.question.key == "driver" && answer == "viagpio").then(|| sheet.get("kind"))??;
    (kind != "steppers").then(|| {
        let text = if kind == "arm" { "an arm" } else { "a servo" };
        format!("viagpio has four outputs and four inputs, too few for {text}: parport")
    })
}

#[cfg(test)]
mod tests {
    use super::{
        super::{
            boards,
            dialog::{Dialog, Ending},
            given,
            lines::{LineWay, lines, used},
            questions::{Asked, Form, Range, is_second, sequence},
            sheet::Sheet,
        },
        RULES, refusal,
    };
    use std::collections::{BTreeMap, BTreeSet};

    /// Answers that break a rule at a question, if one can there.
    fn breaks(rule: &str, sheet: &Sheet, asked: &Asked) -> Vec<String> {
        let key = asked.question.key;
        let list = |texts: &[&str]| texts.iter().map(|t| (*t).to_owned()).collect::<Vec<_>>();
        let number = |name: &str| {
            let (before, _) = asked.key.rsplit_once('.').unwrap_or(("", ""));
            sheet.number(&format!("{before}.{name}"))
        };
        let way = match asked.question.form {
            Form::Input => Some(LineWay::In),
            Form::Output => Some(LineWay::Out),
            _ => None,
        };
        match rule {
            "none" if !asked.may_be_none() => list(&[""]),
            "name" if asked.question.form == Form::Name => {
                list(&["a b", "../x", "-x", "x\"", "\u{e4}"])
                    .into_iter()
                    .chain(["x".repeat(65)])
                    .collect()
            }
            "number" => match asked.question.form {
                Form::Number(Range::Within(..)) => {
                    list(&["-1", "1e9", "nan", "x", "1 # 2", "1\n2"])
                }
                Form::Number(Range::Signed) => list(&["1e300", "inf", "-inf", "five", ".5"]),
                Form::Number(Range::Positive | Range::PositiveOrNone) => {
                    list(&["0", "-3", "1e300", "nan", "1e-310", "1e-9"])
                }
                _ => Vec::new(),
            },
            "word" if matches!(asked.question.form, Form::OneOf(_)) => list(&["other", "MM"]),
            "ports" if asked.question.form == Form::Ports => list(&[
                "378 outs",
                "[HAL]X",
                "0,1,2,3,4,5,6,7,8",
                "378 out, 378 in",
                "378 out\"",
                "378 out in",
                "12345",
            ]),
            "axes" if asked.question.form == Form::Axes => list(&["XQ", "XX", "X Y", "xyz"]),
            "gantry" if asked.question.form == Form::Gantry => list(&["Q", "XY"]),
            "line" => {
                let Some(way) = way else { return Vec::new() };
                let other = if way == LineWay::In { LineWay::Out } else { LineWay::In };
                let mut to = list(&["zero", "41", "9.1", "1.", "-2", "1.2.3"]);
                // The right kind of line: an output is no input. And a line once.
                to.extend(lines(sheet, other).into_iter().map(|(port, n)| format!("{port}.{n}")));
                let mine = lines(sheet, way);
                let used = used(sheet).into_keys().filter(|line| mine.contains(line));
                to.extend(used.map(|(port, n)| format!("!{port}.{n}")));
                to
            }
            "order" if key == "max" => number("min")
                .map(|m| vec![format!("{m:?}"), format!("{:?}", m - 1.0)])
                .unwrap_or_default(),
            "home" if key == "home" => {
                number("max").map(|m| vec![format!("{:?}", m + 1.0)]).unwrap_or_default()
            }
            "search" if key == "search" => number("velocity")
                .map(|v| vec!["0".to_owned(), format!("{:?}", 2.0 * v)])
                .unwrap_or_default(),
            "drive" if key == "drive-acceleration" => {
                number("acceleration").map(|a| vec![format!("{:?}", a / 2.0)]).unwrap_or_default()
            }
            "pair" if key == "direction" => {
                let is_none = super::text_beside(sheet, asked, "step") == Some("");
                let free =
                    lines(sheet, LineWay::Out).into_iter().find(|l| !used(sheet).contains_key(l));
                match free {
                    Some((port, n)) if is_none => vec![format!("{port}.{n}")],
                    _ if !is_none => vec![String::new()],
                    _ => Vec::new(),
                }
            }
            "motor" if key == "step" && super::some_motor(sheet, asked, "").is_some() => {
                list(&[""])
            }
            "sides" if key == "switch" => {
                let n = asked.key.split('.').nth(1).and_then(|n| n.parse().ok()).unwrap_or(0);
                let has = n > 0 && sheet.some(&format!("joint.{}.switch", n - 1)).is_some();
                if is_second(sheet, n) && has { vec![String::new()] } else { Vec::new() }
            }
            "speed" if key == "pitch" => list(&["1e-6"]),
            "scale" if key == "pitch" => number("turn")
                .filter(|turn| *turn < 1000.0)
                .map(|_| list(&["1e9"]))
                .unwrap_or_default(),
            "reset" if key == "step" => {
                let is_it = |text: &&str| super::reset(sheet, asked, text).is_some();
                list(&["1.1", "1.14", "1.16", "1.17"])
                    .into_iter()
                    .filter(|t| is_it(&&**t))
                    .collect()
            }
            "units" if key == "velocity" && super::units(sheet, asked, "1e6").is_some() => {
                list(&["1e6"])
            }
            "units" if key == "velocity" && super::units(sheet, asked, "1").is_some() => {
                list(&["1"])
            }
            "driver" if key == "driver" && sheet.get("kind") != Some("steppers") => {
                list(&["viagpio"])
            }
            // Lines that leave too few for what follows.
            "left" => {
                let each: Vec<String> = match asked.question.form {
                    Form::Axes => list(&["XYZABCUVW"]),
                    Form::Gantry => {
                        sheet.get("axes").unwrap_or("").chars().map(|c| c.to_string()).collect()
                    }
                    _ => way.map_or_else(Vec::new, |way| {
                        let used = used(sheet);
                        let free = lines(sheet, way).into_iter().filter(|l| !used.contains_key(l));
                        free.map(|(port, n)| format!("{port}.{n}")).collect()
                    }),
                };
                let is_left = |answer: &String| super::left(sheet, asked, answer).is_some();
                each.into_iter().filter(is_left).collect()
            }
            "jitter" if key == "latency" || key == "length" || key == "space" => list(&["999999"]),
            _ => Vec::new(),
        }
    }

    /// A good answer, as a person who wants everything gives it: a free line where one is asked for.
    fn good(sheet: &Sheet, asked: &Asked, wants: &BTreeMap<&str, &str>) -> String {
        if let Some(answer) = wants.get(asked.question.key) {
            return (*answer).to_owned();
        }
        let way = match asked.question.form {
            Form::Input => LineWay::In,
            Form::Output => LineWay::Out,
            _ => return asked.default.clone(),
        };
        let used = used(sheet);
        let free = lines(sheet, way).into_iter().find(|line| !used.contains_key(line));
        let each = [
            asked.default.clone(),
            free.map_or(String::new(), |(p, n)| format!("{p}.{n}")),
            String::new(),
        ];
        each.into_iter()
            .find(|a| refusal(sheet, asked, a).is_none() && !(a.is_empty() && free.is_some()))
            .unwrap_or_default()
    }

    #[test]
    fn each_rule_refuses_at_its_question_and_loses_nothing() {
        let ports = "378 out, 278 in, 3bc out";
        let machines: Vec<BTreeMap<&str, &str>> = vec![
            [("kind", "steppers"), ("ports", ports), ("gantry", "Y")].into(),
            [("kind", "servos"), ("ports", ports), ("axes", "XZ")].into(),
            [("kind", "arm"), ("ports", ports), ("axes", "XYZABC")].into(),
            [
                ("kind", "steppers"),
                ("driver", "viagpio"),
                ("axes", "X"),
                ("estop-out", ""),
                ("charge-pump", ""),
                ("enable", ""),
            ]
            .into(),
            [
                ("kind", "steppers"),
                ("axes", "X"),
                ("units", "inch"),
                ("min", "0"),
                ("max", "300"),
                ("estop-out", ""),
            ]
            .into(),
            [("kind", "steppers"), ("axes", "XA"), ("min", "0"), ("max", "50")].into(),
        ];
        // Each machine on a board of its own, and each board with the first machine.
        let own = machines.iter().map(|machine| ("own", machine));
        let known = boards::NAMES.iter().skip(1).map(|board| (*board, &machines[0]));
        let all = own.chain(known);
        let mut broken: BTreeMap<&str, usize> = BTreeMap::new();
        let (mut questions, mut refusals) = (BTreeSet::new(), 0);
        for (board, machine) in all {
            let mut wants = machine.clone();
            wants.insert("board", board);
            let mut sheet = Sheet::default();
            loop {
                let open = sequence(&sheet).into_iter().find(|a| sheet.get(&a.key).is_none());
                let Some(asked) = open else { break };
                questions.insert(asked.question.key);
                for rule in RULES {
                    let answers = breaks(rule.name, &sheet, &asked);
                    for (n, answer) in answers.iter().enumerate() {
                        let why = (rule.refuses)(&sheet, &asked, answer).unwrap_or_else(|| {
                            panic!("{} takes {answer:?} ({})", asked.key, rule.name)
                        });
                        assert!(why.len() > 10, "{}: {why}", asked.key);
                        *broken.entry(rule.name).or_default() += 1;
                        refusals += 1;
                        if n + 1 < answers.len() {
                            continue;
                        }
                        // In the conversation the question comes again, with the reason before it.
                        let mut lines =
                            [if answer.is_empty() { "none" } else { answer }, "save"].into_iter();
                        let (mut shown, mut kept) = (Vec::new(), 0);
                        let mut after = sheet.clone();
                        let end = Dialog {
                            ask: &mut |prompt| {
                                shown.push(prompt.to_owned());
                                Ok(lines.next().map(str::to_owned))
                            },
                            keep: &mut |_| {
                                kept += 1;
                                Ok(())
                            },
                            taken: &mut |_| None,
                        }
                        .questions(&mut after);
                        assert_eq!(
                            (end, kept, &after),
                            (Ok(Ending::Saved), 0, &sheet),
                            "{} {answer:?}",
                            asked.key
                        );
                        let prompt = asked.prompt(&sheet);
                        assert!(
                            shown[1].ends_with(&prompt) && shown[1].len() > prompt.len() + 10,
                            "{shown:?}"
                        );
                    }
                }
                let answer = good(&sheet, &asked, &wants);
                assert_eq!(
                    refusal(&sheet, &asked, &answer),
                    None,
                    "{board}: {} {answer:?}",
                    asked.key
                );
                sheet.put(&asked.key, &answer);
            }
            // What the questions have taken, the file takes; and it says the same.
            for is_finished in [false, true] {
                let text = sheet.text(is_finished);
                let read = given::given(&text).unwrap();
                assert_eq!(read.wrong, [], "{text}");
                assert_eq!(read.sheet, sheet, "{text}");
            }
        }
        let never: Vec<&str> =
            RULES.iter().map(|r| r.name).filter(|n| !broken.contains_key(n)).collect();
        assert_eq!(never, Vec::<&str>::new(), "rules that no answer broke");
        let all: BTreeSet<&str> = super::super::tables::TABLES
            .iter()
            .flat_map(|(_, t)| t.iter().map(|q| q.key))
            .collect();
        assert_eq!(questions, all, "questions that were never asked");
        assert!(refusals > 2000, "{refusals}");
    }

    #[test]
    fn back_and_help_lose_nothing() {
        let said = ["m", "?", "", "back", "back", "n", "", "", "", "", "", "", "save"];
        let mut lines = said.into_iter();
        let (mut shown, mut kept) = (String::new(), Vec::new());
        let mut sheet = Sheet::default();
        let end = Dialog {
            ask: &mut |prompt| {
                shown.push_str(prompt);
                Ok(lines.next().map(str::to_owned))
            },
            keep: &mut |sheet| {
                kept.push(sheet.text(false));
                Ok(())
            },
            taken: &mut |_| None,
        }
        .questions(&mut sheet);
        assert_eq!(end, Ok(Ending::Saved));
        assert_eq!((sheet.get("name"), sheet.get("latency")), (Some("n"), Some("50000")));
        assert!(
            shown.contains("(letters, digits, '-' and '_') [m]: "),
            "the former answer is offered: {shown}"
        );
        assert!(shown.contains("gecko-g540  four drives"), "{shown}");
        let read = given::given(kept.last().unwrap()).unwrap();
        assert!(
            read.is_unfinished && read.only_lacks && read.assumed.len() > 20,
            "{:?}",
            read.wrong
        );
    }
}
