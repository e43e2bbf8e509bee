//! Parser for the text of a trigger, and its errors.

use super::{
    When,
    lex::{Kind, Word, words},
};
use hal_protocol::{Type, Value, ValueError};

/// Maximum nesting depth of parentheses.
const DEEPEST: usize = 50;

/// Error in the text of a trigger. Its message marks the wrong word.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConditionError {
    text: Box<str>,
    at: usize,
    length: usize,
    why: Box<str>,
}

impl ConditionError {
    pub(super) fn new(text: &str, at: usize, length: usize, why: impl Into<Box<str>>) -> Self {
        Self { text: text.into(), at, length, why: why.into() }
    }

    /// Returns the reason, without the text.
    #[must_use]
    pub fn why(&self) -> &str {
        &self.why
    }

    /// Returns the wrong part of the text: its first byte and its length in bytes.
    #[must_use]
    pub const fn place(&self) -> (usize, usize) {
        (self.at, self.length)
    }
}

impl core::fmt::Display for ConditionError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let shown: String =
            self.text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        let letters = |bytes: usize| self.text.get(..bytes).map_or(0, |t| t.chars().count());
        let (from, to) = (letters(self.at), letters(self.at + self.length));
        let marks = "^".repeat(to.saturating_sub(from).max(1));
        write!(f, "trigger: {}\n    {shown}\n    {}{marks}", self.why, " ".repeat(from))
    }
}

impl core::error::Error for ConditionError {}

/// Comparison operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compare {
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Equal,
    Unequal,
}

/// Test of one name. Values are still texts, with their positions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Said {
    True,
    Rises,
    Falls,
    Toggles,
    Changes,
    RisesThrough(Spot),
    FallsThrough(Spot),
    Crosses(Spot),
    Compare(Compare, Spot),
    In(Spot, Spot),
    Outside(Spot, Spot),
}

/// A part of the text and its position.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Spot {
    pub(super) text: String,
    pub(super) at: usize,
    pub(super) length: usize,
}

impl From<Word<'_>> for Spot {
    fn from(w: Word<'_>) -> Self {
        Self { text: w.text.to_owned(), at: w.at, length: w.length }
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Tree {
    Any(Vec<Tree>),
    All(Vec<Tree>),
    Not(Box<Tree>),
    Leaf(Spot, Said),
}

/// A parsed trigger condition that has not been checked against channels yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Condition {
    pub(super) text: String,
    pub(super) tree: Tree,
}

impl Condition {
    /// Parses a text.
    ///
    /// # Errors
    /// The position and reason of the syntax error.
    pub fn parse(text: &str) -> Result<Self, ConditionError> {
        let found = words(text)?;
        if let [all] = &found[..]
            && all.kind == Kind::Quoted
            && all.text.contains(char::is_whitespace)
        {
            // A script leaves the quotes around the whole text.
            return Self::parse(all.text);
        }
        let mut parser = Parser { text, words: found, next: 0, depth: 0 };
        let tree = parser.any()?;
        match parser.peek() {
            None => Ok(Self { text: text.trim().to_owned(), tree }),
            Some(w) => Err(parser.wrong(Some(w), "expected 'and', 'or' or the end")),
        }
    }

    /// Returns the text.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns all names in the condition, each once.
    #[must_use]
    pub fn names(&self) -> Vec<&str> {
        fn collect<'a>(tree: &'a Tree, names: &mut Vec<&'a str>) {
            match tree {
                Tree::Any(list) | Tree::All(list) => list.iter().for_each(|t| collect(t, names)),
                Tree::Not(tree) => collect(tree, names),
                Tree::Leaf(name, _) => {
                    if !names.contains(&&*name.text) {
                        names.push(&name.text);
                    }
                }
            }
        }
        let mut names = Vec::new();
        collect(&self.tree, &mut names);
        names
    }

    /// Checks the condition against the channels of a record: their names and types in order.
    ///
    /// # Errors
    /// A name does not exist, or its type does not allow the test.
    pub fn bind(&self, channels: &[(String, Type)]) -> Result<When, ConditionError> {
        When::bind(self, channels)
    }

    pub(super) fn wrong(&self, spot: &Spot, why: impl Into<Box<str>>) -> ConditionError {
        ConditionError::new(&self.text, spot.at, spot.length, why)
    }

    /// Parses a value of a type.
    pub(super) fn value(&self, ty: Type, spot: &Spot) -> Result<Value, ConditionError> {
        Value::parse(ty, &spot.text).map_err(|e| {
            let expects = ty.expects();
            let why = match e {
                ValueError::Invalid => {
                    format!("'{}' is not of type {}: {expects}", spot.text, ty.name())
                }
                ValueError::Range => {
                    format!("'{}' is out of the range of {}: {expects}", spot.text, ty.name())
                }
            };
            self.wrong(spot, why)
        })
    }
}

struct Parser<'a> {
    text: &'a str,
    words: Vec<Word<'a>>,
    next: usize,
    depth: usize,
}

impl<'a> Parser<'a> {
    fn peek(&self) -> Option<Word<'a>> {
        self.words.get(self.next).copied()
    }

    /// Consumes the next word if it is one of these. Returns whether it is.
    fn takes(&mut self, options: &[&str]) -> bool {
        let found =
            self.peek().is_some_and(|w| w.kind != Kind::Quoted && options.contains(&w.text));
        self.next += usize::from(found);
        found
    }

    fn wrong(&self, word: Option<Word<'_>>, why: &str) -> ConditionError {
        let (at, length) = word.map_or((self.text.trim_end().len(), 1), |w| (w.at, w.length));
        ConditionError::new(self.text, at, length, why)
    }

    fn any(&mut self) -> Result<Tree, ConditionError> {
        let mut list = vec![self.all()?];
        while self.takes(&["or", "||"]) {
            list.push(self.all()?);
        }
        Ok(if list.len() == 1 { list.remove(0) } else { Tree::Any(list) })
    }

    fn all(&mut self) -> Result<Tree, ConditionError> {
        let mut list = vec![self.one()?];
        while self.takes(&["and", "&&"]) {
            list.push(self.one()?);
        }
        Ok(if list.len() == 1 { list.remove(0) } else { Tree::All(list) })
    }

    fn one(&mut self) -> Result<Tree, ConditionError> {
        let word = self.peek();
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.wrong(word, "this is nested too deeply"));
        }
        let tree = if self.takes(&["not", "!"]) {
            Tree::Not(Box::new(self.one()?))
        } else if self.takes(&["("]) {
            let tree = self.any()?;
            if !self.takes(&[")"]) {
                return Err(self.wrong(self.peek(), "expected ')'"));
            }
            tree
        } else {
            self.leaf()?
        };
        self.depth -= 1;
        Ok(tree)
    }

    fn leaf(&mut self) -> Result<Tree, ConditionError> {
        let name = self.peek().filter(|w| w.kind != Kind::Sign && !is_word_of_language(*w));
        let Some(name) = name else {
            return Err(self.wrong(self.peek(), "expected the name of a pin, signal or parameter"));
        };
        self.next += 1;
        let said = if self.takes(&["rises"]) {
            if self.takes(&["through"]) { Said::RisesThrough(self.number()?) } else { Said::Rises }
        } else if self.takes(&["falls"]) {
            if self.takes(&["through"]) { Said::FallsThrough(self.number()?) } else { Said::Falls }
        } else if self.takes(&["toggles"]) {
            Said::Toggles
        } else if self.takes(&["changes"]) {
            Said::Changes
        } else if self.takes(&["crosses"]) {
            Said::Crosses(self.number()?)
        } else if self.takes(&["in"]) {
            let (low, high) = self.range()?;
            Said::In(low, high)
        } else if self.takes(&["outside"]) {
            let (low, high) = self.range()?;
            Said::Outside(low, high)
        } else {
            self.comparison()?
        };
        Ok(Tree::Leaf(name.into(), said))
    }

    fn comparison(&mut self) -> Result<Said, ConditionError> {
        let signs = [
            ("<=", Compare::LessOrEqual),
            (">=", Compare::GreaterOrEqual),
            ("==", Compare::Equal),
            ("=", Compare::Equal),
            ("!=", Compare::Unequal),
            ("<>", Compare::Unequal),
            ("<", Compare::Less),
            (">", Compare::Greater),
        ];
        for (sign, compare) in signs {
            if self.takes(&[sign]) {
                return Ok(Said::Compare(compare, self.number()?));
            }
        }
        match self.peek() {
            Some(w) if w.kind != Kind::Sign && !["and", "or"].contains(&w.text) => Err(self.wrong(
                Some(w),
                "expected rises, falls, toggles, changes, crosses, in, outside or a comparison",
            )),
            _ => Ok(Said::True),
        }
    }

    fn number(&mut self) -> Result<Spot, ConditionError> {
        let word = self.peek().filter(|w| w.kind == Kind::Word);
        let word = word.ok_or_else(|| self.wrong(self.peek(), "expected a value"))?;
        self.next += 1;
        Ok(word.into())
    }

    /// Parses a range such as `-1..1`.
    fn range(&mut self) -> Result<(Spot, Spot), ConditionError> {
        let word = self.peek();
        let spot = self.number()?;
        let Some((low, high)) =
            spot.text.split_once("..").filter(|(l, h)| !l.is_empty() && !h.is_empty())
        else {
            return Err(self.wrong(word, "expected a range such as -1..1"));
        };
        let high_at = spot.at + low.len() + 2;
        let low = Spot { text: low.to_owned(), at: spot.at, length: low.len() };
        Ok((low, Spot { text: high.to_owned(), at: high_at, length: high.len() }))
    }
}

fn is_word_of_language(word: Word<'_>) -> bool {
    let words = [
        "and", "or", "not", "rises", "falls", "through", "toggles", "changes", "crosses", "in",
        "outside",
    ];
    word.kind == Kind::Word && words.contains(&word.text)
}
