//! Tools and tool table files.

use serde::{Deserialize, Serialize};

use crate::axis::{Axis, Position};

/// A tool of the table, in the table's unit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tool {
    /// The tool's number.
    pub number: i32,
    /// The pocket.
    pub pocket: i32,
    /// The offset.
    pub offset: Position,
    /// The diameter.
    pub diameter: f64,
    /// The front angle of a lathe tool.
    pub front: f64,
    /// The back angle of a lathe tool.
    pub back: f64,
    /// The orientation of a lathe tool, 1 to 9; 0 for a mill's.
    pub orientation: u8,
    /// The remark of its line.
    pub remark: Box<str>,
}

/// Something wrong in a tool table; the rest was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finding {
    /// The line has no T word or a word that is none.
    Malformed {
        /// The line, from 1.
        line: u32,
    },
    /// The tool's number came before; the first one counts.
    Duplicate {
        /// The line, from 1.
        line: u32,
    },
}

/// A tool table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ToolTable {
    /// The tools in the order of the file.
    pub tools: Vec<Tool>,
}

impl ToolTable {
    /// Parses the text of a tool table in the layout of words (`T1 P1 Z0.5 D3 ;end mill`) or in the old one of
    /// columns (tool, pocket, length, diameter, remark; a lathe's has eight).
    pub fn parse(text: &str) -> (Self, Vec<Finding>) {
        let mut out = Self::default();
        let mut findings = Vec::new();
        for (line, text) in (1u32..).zip(text.lines()) {
            let (words, remark) = text.split_once(';').unwrap_or((text, ""));
            if words.trim().is_empty() {
                continue;
            }
            let tool = if words.trim_start().starts_with(|c: char| c.is_ascii_digit()) {
                columns(words)
            } else if words.trim_start().to_ascii_lowercase().starts_with("poc") {
                // The old layout begins with a line of titles.
                continue;
            } else {
                by_words(words)
            };
            match tool {
                Some(t) if out.find(t.number).is_some() => {
                    findings.push(Finding::Duplicate { line });
                }
                Some(mut t) => {
                    if t.remark.is_empty() {
                        t.remark = remark.trim().into();
                    }
                    out.tools.push(t);
                }
                None => findings.push(Finding::Malformed { line }),
            }
        }
        (out, findings)
    }

    /// Returns the tool with this number.
    pub fn find(&self, number: i32) -> Option<&Tool> {
        self.tools.iter().find(|t| t.number == number)
    }

    /// Returns the text of the table in the layout of words.
    pub fn print(&self) -> String {
        let mut out = String::new();
        for tool in &self.tools {
            out.push_str(&format!("T{} P{} D{:+.6}", tool.number, tool.pocket, tool.diameter));
            for axis in Axis::ALL {
                let letter = axis.letter().to_ascii_uppercase();
                out.push_str(&format!(" {letter}{:+.6}", tool.offset[axis]));
            }
            out.push_str(&format!(
                " I{:+.6} J{:+.6} Q{} ;{}\n",
                tool.front, tool.back, tool.orientation, tool.remark
            ));
        }
        out
    }
}

fn by_words(text: &str) -> Option<Tool> {
    let mut tool = Tool::default();
    let mut named = false;
    for word in text.split_whitespace() {
        let letter = word.chars().next()?.to_ascii_lowercase();
        let value: f64 = word.get(letter.len_utf8()..)?.parse().ok()?;
        if !value.is_finite() {
            return None;
        }
        let integer = || crate::text::evaluate::integer(value).ok();
        match letter {
            't' => {
                tool.number = integer()?;
                named = true;
            }
            'p' => tool.pocket = integer()?,
            'd' => tool.diameter = value,
            'i' => tool.front = value,
            'j' => tool.back = value,
            'q' => tool.orientation = u8::try_from(integer()?).ok().filter(|q| *q <= 9)?,
            _ => {
                let axis = Axis::ALL.into_iter().find(|a| a.letter() == letter)?;
                tool.offset[axis] = value;
            }
        }
    }
    named.then_some(tool)
}

fn columns(text: &str) -> Option<Tool> {
    let all: Vec<&str> = text.split_whitespace().collect();
    let value = |i: usize| all.get(i).and_then(|t| t.parse::<f64>().ok());
    let whole = |i: usize| value(i).and_then(|v| crate::text::evaluate::integer(v).ok());
    let (number, pocket) = (whole(0)?, whole(1)?);
    let z = value(2)?;
    let mut tool = Tool { number, pocket, ..Tool::default() };
    tool.offset.z = z;
    if let (Some(diameter), Some(front)) = (value(4), value(5)) {
        tool.offset.x = value(3)?;
        tool.diameter = diameter;
        tool.front = front;
        tool.back = value(6)?;
        tool.orientation = u8::try_from(whole(7)?).ok().filter(|q| *q <= 9)?;
        tool.remark = all.get(8..).unwrap_or_default().join(" ").into();
    } else {
        tool.diameter = value(3)?;
        tool.remark = all.get(4..).unwrap_or_default().join(" ").into();
    }
    Some(tool)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_layouts_are_read_and_what_is_wrong_is_told() {
        let text = "POC FMS LEN DIAM\n1 1 0.5 0.25 drill\n2 2 0 1 0.03 95 155 2 lathe\n\
                    T3 P3 Z-0.5 D6 ;mill\nT3 P4\nQ5\n";
        let (table, findings) = ToolTable::parse(text);
        assert_eq!(table.tools.len(), 3);
        assert_eq!(table.tools[0].offset.z, 0.5);
        assert_eq!(&*table.tools[0].remark, "drill");
        assert_eq!(table.tools[1].orientation, 2);
        assert_eq!(&*table.tools[2].remark, "mill");
        let wanted = [Finding::Duplicate { line: 5 }, Finding::Malformed { line: 6 }];
        assert_eq!(findings, wanted);
        let (again, findings) = ToolTable::parse(&table.print());
        assert_eq!((again, findings.len()), (table, 0));
        for (text, good) in [
            ("T1 P1 Q9", true),
            ("T1 P1 Q10", false),
            ("T1 P1 Q-1", false),
            ("1 1 1 0 1 0 0 9", true),
            ("1 1 1 0 1 0 0 10", false),
            ("T1 P1 Zinf", false),
            ("T1.5 P1", false),
        ] {
            assert_eq!(ToolTable::parse(text).1.is_empty(), good, "{text}");
        }
    }
}
