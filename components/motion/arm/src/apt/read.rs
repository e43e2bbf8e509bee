//! Statements and what they do.

use super::{
    Error, Event, MAX_POINTS, Motion, Part, Point, Problem,
    arc::Circle,
    items::{Item, Placed, items, numbers, words},
    scan::{Char, Statement, at, shown, statements},
};
use crate::rotation::Vector;
use std::collections::BTreeSet;

/// Words whose effect on the path is not supported.
const REFUSED: &[&str] = &[
    "MACRO", "CALL", "TERMAC", "LOOPST", "LOOPND", "JUMPTO", "JUMPIF", "IF", "DO", "CYCLE",
    "CUTCOM", "COPY", "TRACUT", "REFSYS", "ORIGIN", "TRANS", "POCKET", "GO", "GOFWD", "GOBACK",
    "GOLFT", "GORGT", "GOUP", "GODOWN", "GOHOME", "GODLTV", "TLLFT", "TLRGT", "TLONPS", "SCURV",
    "INCLUD", "READ", "ROTABL", "ROTATE", "ROTHED", "PPFUN", "THREAD", "NURBS", "SPLINE",
];

/// Slowest feed, in millimetres per second: below it, no path comes to its end.
const SLOWEST: f64 = 1e-3 / 60.0;

/// Words of events.
const EVENTS: &[&str] = &["CUTTER", "LOADTL", "TOOLNO", "COOLNT", "DELAY", "STOP", "OPSTOP"];

struct Reader {
    part: Part,
    unit: f64,
    axes_on: bool,
    axis: Vector,
    place: Option<Vector>,
    is_rapid: bool,
    feed: Option<Feed>,
    spindle: Option<f64>,
    circle: Option<(Circle, Char)>,
    direction: Option<Vector>,
    unknown: BTreeSet<String>,
}

/// Feed in millimetres.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Feed {
    PerMinute(f64),
    PerTurn(f64),
}

/// Reads a file.
pub(super) fn read(text: &[u8]) -> Result<Part, Error> {
    let mut reader = Reader {
        part: Part::default(),
        unit: 1.0,
        axes_on: true,
        axis: Vector::z(),
        place: None,
        is_rapid: false,
        feed: None,
        spindle: None,
        circle: None,
        direction: None,
        unknown: BTreeSet::new(),
    };
    statements(text, |statement| reader.take(statement))?;
    Ok(reader.part)
}

impl Reader {
    /// Executes a statement. Returns false after the last.
    fn take(&mut self, statement: &Statement) -> Result<bool, Error> {
        let Some(first) = statement.chars.iter().find(|c| c.byte != b' ').copied() else {
            return Ok(true);
        };
        if statement.is_text {
            self.text(statement);
            return Ok(true);
        }
        let chars = &statement.chars;
        let end = chars.iter().position(|c| !c.byte.is_ascii_alphanumeric()).unwrap_or(chars.len());
        let (head, rest) = chars.split_at_checked(end).unwrap_or((chars, &[]));
        let word = shown(head);
        if !first.byte.is_ascii_alphabetic() {
            return Err(at(&first, Problem::NoWord));
        }
        match rest.first().map(|c| c.byte) {
            Some(b'=') => return Err(at(&first, Problem::Geometry(word))),
            None | Some(b'/' | b',') => {}
            Some(byte) => return Err(at(rest.first().unwrap_or(&first), Problem::Character(byte))),
        }
        let arguments = rest.get(1..).unwrap_or_default();
        let is_goto = matches!(word.as_str(), "GOTO");
        if let Some((_, place)) = self.circle.filter(|_| !is_goto) {
            return Err(at(&place, Problem::NoGoto));
        }
        match word.as_str() {
            "FINI" | "END" => return Ok(false),
            "RAPID" => self.is_rapid = true,
            "UNITS" => self.units(&items(arguments)?, &first)?,
            "MULTAX" => self.axes_on = words(&items(arguments)?).last() != Some(&"OFF"),
            "TLAXIS" => {
                let v = numbers(&items(arguments)?, 3..=3, &first, "TLAXIS", "three numbers")?;
                self.axis = self.vector(&v, &first)?;
            }
            "FROM" | "GOTO" => {
                let (word, takes) = (if is_goto { "GOTO" } else { "FROM" }, "three or six numbers");
                let v = numbers(&items(arguments)?, 3..=6, &first, word, takes)?;
                if v.len() > 3 {
                    if v.len() != 6 {
                        return Err(at(&first, Problem::Count(word, takes)));
                    }
                    self.axis = self.vector(v.get(3..).unwrap_or_default(), &first)?;
                }
                self.go(self.point(&v), is_goto, &first)?;
            }
            "GODLTA" => self.delta(&items(arguments)?, &first)?,
            "FEDRAT" => self.feed(&items(arguments)?, &first)?,
            "SPINDL" => {
                let given = items(arguments)?;
                let speed = given.iter().find_map(|(item, _)| match item {
                    Item::Number(x) => Some(*x),
                    _ => None,
                });
                if let Some(speed) = speed {
                    self.spindle = Some(speed.abs());
                }
                self.event(chars);
            }
            "CIRCLE" => {
                let takes = "four or seven numbers";
                let v = numbers(&items(arguments)?, 4..=7, &first, "CIRCLE", takes)?;
                self.circle = Some((self.round(&v, &first, "CIRCLE", takes)?, first));
            }
            "INDIRV" => {
                let v = numbers(&items(arguments)?, 3..=3, &first, "INDIRV", "three numbers")?;
                self.direction = Some(unit(&v, &first)?);
            }
            "TLON" => self.along(&items(arguments)?, &first)?,
            "AUTOPS" | "PSIS" => {}
            _ if EVENTS.contains(&word.as_str()) => self.event(chars),
            _ if REFUSED.contains(&word.as_str()) => {
                return Err(at(&first, Problem::Refused(word)));
            }
            _ => {
                if self.unknown.insert(word.clone()) {
                    self.part.warnings.push((first.line, format!("{word} has no effect")));
                }
            }
        }
        Ok(true)
    }

    fn text(&mut self, statement: &Statement) {
        let bytes: Vec<u8> = statement.chars.iter().map(|c| c.byte).collect();
        let text = String::from_utf8_lossy(&bytes);
        let (word, rest) = text.trim().split_at_checked(6).unwrap_or_default();
        let rest = rest.trim_start_matches(['/', ' ', '\t']).trim();
        let line = statement.chars.first().map_or(0, |c| c.line);
        if word.eq_ignore_ascii_case("PARTNO") {
            rest.clone_into(&mut self.part.name);
        } else {
            let text = format!("{} {rest}", word.to_ascii_uppercase());
            self.part.events.push(Event { line, after: self.part.points.len(), text });
        }
    }

    fn event(&mut self, chars: &[Char]) {
        let text = chars.iter().map(|c| char::from(c.byte)).collect();
        let line = chars.first().map_or(0, |c| c.line);
        self.part.events.push(Event { line, after: self.part.points.len(), text });
    }

    fn units(&mut self, given: &[Placed], first: &Char) -> Result<(), Error> {
        self.unit = match *words(given) {
            ["MM"] => 1.0,
            ["INCHES" | "INCH" | "IN"] => 25.4,
            [other] => return Err(at(first, Problem::Unit(other.to_owned()))),
            _ => return Err(at(first, Problem::Count("UNITS", "MM or INCHES"))),
        };
        Ok(())
    }

    fn point(&self, v: &[f64]) -> Vector {
        let at = |n| v.get(n).copied().unwrap_or(0.0) * self.unit;
        Vector::new(at(0), at(1), at(2))
    }

    /// Returns a tool axis.
    fn vector(&self, v: &[f64], first: &Char) -> Result<Vector, Error> {
        if !self.axes_on {
            return Err(at(first, Problem::AxisOff));
        }
        unit(v, first)
    }

    fn round(
        &self,
        v: &[f64],
        first: &Char,
        word: &'static str,
        takes: &'static str,
    ) -> Result<Circle, Error> {
        let (axis, radius) = match v {
            [_, _, _, r] => (Vector::z(), *r),
            [_, _, _, axis @ .., r] if axis.len() == 3 => (unit(axis, first)?, *r),
            _ => return Err(at(first, Problem::Count(word, takes))),
        };
        Ok(Circle { centre: self.point(v), axis, radius: radius.abs() * self.unit })
    }

    fn delta(&mut self, given: &[Placed], first: &Char) -> Result<(), Error> {
        let v = numbers(given, 1..=3, first, "GODLTA", "one or three numbers")?;
        let Some(place) = self.place else { return Err(at(first, Problem::NoPosition)) };
        let by = match v.len() {
            1 => self.axis * (v.first().copied().unwrap_or(0.0) * self.unit),
            3 => self.point(&v),
            _ => return Err(at(first, Problem::Count("GODLTA", "one or three numbers"))),
        };
        self.go(place + by, true, first)
    }

    fn feed(&mut self, given: &[Placed], first: &Char) -> Result<(), Error> {
        let mut value = None;
        let mut is_per_turn = false;
        let mut unit = self.unit;
        for (item, place) in given {
            match item {
                Item::Number(x) if value.is_none() => value = Some(*x),
                Item::Word(word) => match word.as_str() {
                    "MMPM" => unit = 1.0,
                    "IPM" => unit = 25.4,
                    "PERMIN" => {}
                    "MMPR" => (is_per_turn, unit) = (true, 1.0),
                    "IPR" => (is_per_turn, unit) = (true, 25.4),
                    "PERREV" => is_per_turn = true,
                    other => return Err(at(place, Problem::Unit(other.to_owned()))),
                },
                _ => return Err(at(place, Problem::Count("FEDRAT", "a number and a unit"))),
            }
        }
        let Some(value) = value else {
            return Err(at(first, Problem::Count("FEDRAT", "a number and a unit")));
        };
        let value = value * unit;
        if value <= 0.0 || !is_per_turn && value / 60.0 < SLOWEST {
            return Err(at(first, Problem::Feed));
        }
        self.feed = Some(if is_per_turn { Feed::PerTurn(value) } else { Feed::PerMinute(value) });
        Ok(())
    }

    /// Returns the motion in force, which `RAPID` changes for one motion.
    fn motion(&mut self, first: &Char) -> Result<Motion, Error> {
        if core::mem::take(&mut self.is_rapid) {
            return Ok(Motion::Rapid);
        }
        let feed = match (self.feed, self.spindle) {
            (None, _) => return Ok(Motion::Feed(None)),
            (Some(Feed::PerMinute(f)), _) => f / 60.0,
            (Some(Feed::PerTurn(f)), Some(s)) if s > 0.0 => f * s / 60.0,
            (Some(Feed::PerTurn(_)), _) => return Err(at(first, Problem::NoSpindle)),
        };
        // A feed per revolution is as slow as the spindle.
        if feed < SLOWEST { Err(at(first, Problem::Feed)) } else { Ok(Motion::Feed(Some(feed))) }
    }

    fn go(&mut self, to: Vector, moves: bool, first: &Char) -> Result<(), Error> {
        if !moves {
            self.place = Some(to);
            return self.push(to, Motion::Start, first);
        }
        let motion = self.motion(first)?;
        let from = self.place.replace(to);
        let Some((circle, place)) = self.circle.take() else {
            let motion = if from.is_none() { Motion::Start } else { motion };
            return self.push(to, motion, first);
        };
        let Some(from) = from else { return Err(at(&place, Problem::NoPosition)) };
        for point in circle.chords(&from, &to, false, |p| at(first, p))? {
            self.push(point, motion, first)?;
        }
        Ok(())
    }

    /// Executes `TLON,GOFWD/(CIRCLE/…),ON,(LINE/…)`.
    fn along(&mut self, given: &[Placed], first: &Char) -> Result<(), Error> {
        let takes = "GOFWD/, a circle or cylinder, and the line or point where it ends";
        let groups: Vec<_> = given
            .iter()
            .filter_map(|(item, place)| match item {
                Item::Group(word, numbers) => Some((word.as_str(), numbers.as_slice(), place)),
                Item::Word(_) | Item::Number(_) => None,
            })
            .collect();
        let is_forward = words(given).first() == Some(&"GOFWD");
        let (true, [(round, v, place), (end, e, end_place)]) = (is_forward, groups.as_slice())
        else {
            return Err(at(first, Problem::Count("TLON", takes)));
        };
        let circle = match (*round, v.len()) {
            ("CIRCLE", 4 | 7) | ("CYLNDR", 7) => {
                self.round(v, place, "CIRCLE", "four or seven numbers")?
            }
            _ => return Err(at(place, Problem::Count("TLON", takes))),
        };
        let to = match (*end, e) {
            ("LINE", [_, _, _, to @ ..]) if to.len() == 3 => self.point(to),
            ("POINT", to) if to.len() == 3 => self.point(to),
            _ => return Err(at(end_place, Problem::Count("TLON", takes))),
        };
        let (Some(from), Some(direction)) = (self.place, self.direction.take()) else {
            let none =
                if self.place.is_none() { Problem::NoPosition } else { Problem::NoDirection };
            return Err(at(first, none));
        };
        let tangent = circle.axis.cross(&(from - circle.centre));
        let along = tangent.dot(&direction);
        if along.abs() <= 1e-3 * tangent.norm() {
            return Err(at(first, Problem::NoDirection));
        }
        let motion = self.motion(first)?;
        self.place = Some(to);
        for point in circle.chords(&from, &to, along < 0.0, |p| at(first, p))? {
            self.push(point, motion, first)?;
        }
        Ok(())
    }

    fn push(&mut self, place: Vector, motion: Motion, first: &Char) -> Result<(), Error> {
        if self.part.points.len() >= MAX_POINTS {
            return Err(at(first, Problem::TooManyPoints));
        }
        self.part.points.push(Point { line: first.line, place, axis: self.axis, motion });
        Ok(())
    }
}

fn unit(v: &[f64], first: &Char) -> Result<Vector, Error> {
    let at_index = |n| v.get(n).copied().unwrap_or(0.0);
    let vector = Vector::new(at_index(0), at_index(1), at_index(2));
    vector.try_normalize(1e-9).ok_or_else(|| at(first, Problem::NoVector))
}
