//! Rules about the whole machine: its speed, its unit of length, and the lines that what follows needs.

use super::{
    answers::Answers,
    boards::{board, preset},
    lines::{LineWay, line, lines, used},
    questions::{Asked, Form, LARGEST, SMALLEST, is_second, joints},
    rules::beside,
    sheet::{Sheet, number},
    timing,
};
use crate::check::plausible::{is_odd, largest};

/// The joint is too fast for the computer's jitter: known as soon as its steps of a unit are.
pub(super) fn speed(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    if asked.question.key != "pitch" {
        return None;
    }
    let mut with = sheet.clone();
    with.put(&asked.key, answer);
    let answers = Answers::of(&with);
    let (joint, possible) = timing::timing(&answers).err()?;
    let latency = answers.latency;
    let velocity = answers.joint.get(joint)?.velocity;
    Some(format!(
        "joint {joint}: a velocity of {velocity} is too fast for a jitter of {latency} ns; {possible:.3} {}/s is possible",
        asked.unit
    ))
}

/// The computer's jitter and the drive's pulses allow no base period that the board bears.
pub(super) fn jitter(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let mut with = sheet.clone();
    match asked.key.as_str() {
        "latency" => {
            let board = board(sheet.get("board"))?;
            for name in ["length", "space"] {
                let key = format!("pulse.{name}");
                with.put(&key, preset(board, &key));
            }
        }
        "pulse.length" => with.put("pulse.space", "0"),
        "pulse.space" => {}
        _ => return None,
    }
    with.put(&asked.key, answer);
    let answers = Answers::of(&with);
    let (shortest, longest) = (timing::least(&answers), answers.longest);
    (longest < shortest).then(|| format!("the base period is at most {longest} ns, and this needs {shortest} ns: less jitter, shorter steps, or another board"))
}

/// Too few lines are left for the questions that follow.
pub(super) fn left(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let is_line = matches!(asked.question.form, Form::Input | Form::Output);
    let is_shape = matches!(asked.question.form, Form::Axes | Form::Gantry);
    if answer.is_empty() || !is_line && !is_shape {
        return None;
    }
    let mut with = sheet.clone();
    with.put(&asked.key, answer);
    [LineWay::Out, LineWay::In].into_iter().find_map(|way| {
        let used = used(&with);
        let free = lines(&with, way).into_iter().filter(|line| !used.contains_key(line)).count();
        let need = needed(&with, way);
        (free < need).then(|| {
            let word = way.word();
            format!("what follows needs {need} {word}s, and with this {free} are left: none here, or another port")
        })
    })
}

/// Returns the number of lines of a way that questions without an answer need.
pub(super) fn needed(sheet: &Sheet, way: LineWay) -> usize {
    let open =
        |n: usize, name: &str| usize::from(sheet.get(&format!("joint.{n}.{name}")).is_none());
    let is_some = |n: usize, name: &str| sheet.some(&format!("joint.{n}.{name}")).is_some();
    let joints = 0..joints(sheet);
    let is_servo = sheet.get("kind") == Some("servos");
    let sides = |n: usize| usize::from(is_second(sheet, n) && is_some(n - 1, "switch"));
    match way {
        LineWay::Out if is_servo => joints.map(|n| open(n, "step") + open(n, "direction")).sum(),
        LineWay::Out => match joints.clone().find(|n| is_some(*n, "step")) {
            None => 2,
            Some(_) => joints.filter(|n| is_some(*n, "step")).map(|n| open(n, "direction")).sum(),
        },
        LineWay::In => {
            let encoders = |n: usize| if is_servo { open(n, "a") + open(n, "b") } else { 0 };
            joints.map(|n| encoders(n) + sides(n) * open(n, "switch")).sum()
        }
    }
}

/// The steps of a unit of length that the files can state.
pub(super) fn scale(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let pitch = (asked.question.key == "pitch").then(|| number(answer))??;
    let factor = |name| beside(sheet, asked, name);
    let scale = factor("turn")? * factor("microsteps")? * factor("gear")? / pitch;
    let is_possible = (SMALLEST..=LARGEST).contains(&scale);
    (!is_possible).then(|| {
        format!(
            "with this a {} has {scale} steps: from {SMALLEST} to {LARGEST} are possible",
            asked.unit
        )
    })
}

/// The unit of length in which the machine would be impossibly large and fast, or small and slow.
pub(super) fn units(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let words: Vec<&str> = asked.key.split('.').collect();
    let ["joint", n, "velocity"] = words.as_slice() else { return None };
    let n: usize = n.parse().ok()?;
    let letters = sheet.letters();
    let is_linear = |n: usize| letters.get(n).is_some_and(|c| !"ABC".contains(*c));
    if sheet.get("kind") == Some("arm") || !is_linear(n) {
        return None;
    }
    let mut with = sheet.clone();
    with.put(&asked.key, answer);
    let of = |n: usize| {
        let number = |name: &str| with.number(&format!("joint.{n}.{name}"));
        Some((number("max")? - number("min")?, number("velocity")?))
    };
    let is_inch = sheet.get("units") == Some("inch");
    let all: Vec<(f64, f64)> = (0..=n).filter(|n| is_linear(*n)).filter_map(of).collect();
    // A machine in millimetres is small if each of its joints is: known at the last one.
    let is_last = !(n + 1..letters.len()).any(|n| is_linear(n) && !is_second(sheet, n));
    let is_odd = (is_inch || is_last) && is_odd(is_inch, &all);
    let (travel, speed) = largest(&all);
    let (unit, other) = if is_inch { ("inch", "mm") } else { ("mm", "inch") };
    is_odd.then(|| format!("a travel of {travel} {unit} at {speed} {unit}/s looks like {other}"))
}

/// A step that ends in its period needs a port that can end it.
pub(super) fn reset(sheet: &Sheet, asked: &Asked, answer: &str) -> Option<String> {
    let step = (asked.question.key == "step").then(|| line(answer))??;
    let ports = sheet.get("ports").filter(|_| timing::resets(&Answers::of(sheet)))?;
    let mode = ports.split(',').nth(step.port)?.split_whitespace().nth(1);
    (mode == Some("in")).then(|| {
        format!("line {}: a port in mode in cannot end a step in its period; another port, or steps of more than 5000 ns", step.text())
    })
}
