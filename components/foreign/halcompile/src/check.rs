//! Checks that the grammar cannot express; they turn a tree into a component.

use crate::{
    Problem,
    name::{c_name, hal_format, hashes, is_c_keyword},
    options::Options,
    place::{Fault, Span, place},
    tree::{At, Body, Declaration, Function, Hal, Item, ModParam, TextKind, Tree, Value, Variable},
};
use std::collections::BTreeMap;

/// Names that the generated C text uses itself.
const RESERVED: &[&str] = &[
    "comp_id",
    "fperiod",
    "rtapi_app_main",
    "rtapi_app_exit",
    "extra_setup",
    "extra_cleanup",
    "post_export",
];

/// Fully checked component.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Name of the component.
    pub name: String,
    /// Text after the name.
    pub doc: Option<String>,
    /// Pins and parameters, in order.
    pub items: Vec<Item>,
    /// Functions of the component.
    pub functions: Vec<Function>,
    /// Variables of each instance.
    pub variables: Vec<Variable>,
    /// Module parameters.
    pub mod_params: Vec<ModParam>,
    /// Headers, with their brackets or quotes.
    pub includes: Vec<At<String>>,
    /// Texts of the declarations, in order.
    pub texts: Vec<(TextKind, String)>,
    /// Options of the component.
    pub options: Options,
    /// C text after `;;`.
    pub body: Body,
    /// Offsets of the line ends, in bytes.
    line_ends: Vec<usize>,
}

impl Component {
    /// Returns all texts of a kind.
    pub fn texts(&self, kind: TextKind) -> impl Iterator<Item = &str> {
        self.texts.iter().filter(move |(k, _)| *k == kind).map(|(_, t)| t.as_str())
    }

    /// Returns the line of a span, from 1.
    #[must_use]
    pub fn line(&self, span: Span) -> usize {
        self.line_ends.partition_point(|end| *end < span.start) + 1
    }

    /// Returns whether the instances have personalities.
    #[must_use]
    pub fn has_personality(&self) -> bool {
        self.options.place("default_personality").is_some()
            || self.items.iter().any(|i| {
                i.condition.is_some() || i.array.as_ref().is_some_and(|a| a.size.is_some())
            })
    }

    /// Returns whether the C text is the body of the component's only function.
    #[must_use]
    pub fn is_bare(&self) -> bool {
        let options = &self.options;
        !options.on("userspace")
            && !options.on("no_convenience_defines")
            && self.functions.len() == 1
            && !self.names_function()
    }

    /// Returns whether the C text may use pins anywhere: it is a program with one instance.
    pub(crate) fn has_program_inst(&self) -> bool {
        self.options.on("userspace") && self.options.on("singleton")
    }

    fn names_function(&self) -> bool {
        self.body.text.match_indices("FUNCTION").any(|(i, word)| {
            let before = self.body.text.get(..i).and_then(|t| t.chars().next_back());
            let after = self.body.text.get(i + word.len()..).unwrap_or_default();
            !before.is_some_and(|c| c == '_' || c.is_alphanumeric())
                && after.trim_start().starts_with('(')
        })
    }
}

/// Returns a fault if the C text uses the period that its functions do not have, and does not define that word itself.
pub(crate) fn misses_period(component: &Component) -> Option<Fault> {
    if component.options.on("period") {
        return None;
    }
    let span = component.options.place("period")?.span;
    let mut words = component.body.text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    let defined = component.body.text.contains("define fperiod");
    (words.any(|word| word == "fperiod") && !defined)
        .then_some(Fault { span, problem: Problem::NoPeriod })
}

/// Checks a tree completely. Returns the component and the warnings.
///
/// # Errors
/// All faults of the tree.
pub(crate) fn check(tree: Tree, source: &str) -> Result<(Component, Vec<Fault>), Vec<Fault>> {
    let mut look =
        Look { source, taken: BTreeMap::new(), hal: BTreeMap::new(), faults: Vec::new() };
    let mut doubts = Vec::new();
    let mut out = Component {
        name: tree.name.value,
        doc: tree.doc,
        items: Vec::new(),
        functions: Vec::new(),
        variables: Vec::new(),
        mod_params: Vec::new(),
        includes: Vec::new(),
        texts: Vec::new(),
        options: Options::default(),
        body: tree.body,
        line_ends: source.match_indices('\n').map(|(i, _)| i).collect(),
    };
    for declaration in tree.declarations {
        match declaration {
            Declaration::Item(item) => {
                look.item(&item);
                out.items.push(item);
            }
            Declaration::Function(function) => {
                look.name(&function.name, &c_name(&function.name.value));
                look.without_array(&function.name);
                if out.options.on("userspace") {
                    look.wrong(function.name.span, Problem::UserspaceFunction);
                }
                out.functions.push(function);
            }
            Declaration::Variable(variable) => {
                look.name(&variable.name, &variable.name.value);
                out.variables.push(variable);
            }
            Declaration::ModParam(param) => {
                look.name(&param.name, &param.name.value);
                out.mod_params.push(param);
            }
            Declaration::Option(line) => match out.options.take(&line, source) {
                Ok(doubt) => doubts.extend(doubt),
                Err(fault) => look.faults.push(fault),
            },
            Declaration::Include(header) => out.includes.push(header),
            Declaration::Text(kind, text) => out.texts.push((kind, text.value)),
        }
    }
    look.whole(&out);
    look.faults.sort_by_key(|f| f.span.start);
    if look.faults.is_empty() { Ok((out, doubts)) } else { Err(look.faults) }
}

struct Look<'a> {
    source: &'a str,
    /// Names in C, and the places of their declarations.
    taken: BTreeMap<String, Span>,
    /// HAL names that every instance has.
    hal: BTreeMap<String, Span>,
    faults: Vec<Fault>,
}

impl Look<'_> {
    fn wrong(&mut self, span: Span, problem: Problem) {
        self.faults.push(Fault { span, problem });
    }

    fn line(&self, span: Span) -> usize {
        place(self.source, span.start).0
    }

    fn name(&mut self, written: &At<String>, c: &str) {
        let name: Box<str> = written.value.as_str().into();
        if RESERVED.contains(&c) {
            self.wrong(written.span, Problem::Reserved { name });
        } else if is_c_keyword(c) {
            self.wrong(written.span, Problem::Keyword { name });
        } else if let Some(first) = self.taken.get(c) {
            let line = self.line(*first);
            self.wrong(written.span, Problem::Duplicate { name, line });
        } else {
            self.taken.insert(c.to_owned(), written.span);
        }
    }

    fn without_array(&mut self, written: &At<String>) {
        if hashes(&written.value) > 0 {
            let name = written.value.as_str().into();
            self.wrong(written.span, Problem::HashWithoutArray { name });
        }
    }

    fn item(&mut self, item: &Item) {
        let written = &item.name;
        let name: Box<str> = written.value.as_str().into();
        let c = c_name(&written.value);
        self.name(written, &c);
        match (&item.array, hashes(&written.value)) {
            (None, 0) | (Some(_), 1) => {}
            (None, _) => self.without_array(written),
            (Some(_), 0) => {
                self.wrong(written.span, Problem::ArrayWithoutHash { name: name.clone() });
            }
            (Some(_), _) => self.wrong(written.span, Problem::TwoHashes { name: name.clone() }),
        }
        if let Some(array) = item.array.as_ref().filter(|a| a.max.value == 0) {
            self.wrong(array.max.span, Problem::EmptyArray);
        }
        let hal = hal_format(&written.value);
        if hal.is_empty() || c.is_empty() {
            self.wrong(written.span, Problem::NamelessItem { name });
        } else if item.condition.is_none() {
            match self.hal.get(&hal).map(|first| self.line(*first)) {
                Some(line) if self.taken.get(&c) == Some(&written.span) => {
                    self.wrong(written.span, Problem::SameHalName { name, line });
                }
                Some(_) => {}
                None => {
                    self.hal.insert(hal, written.span);
                }
            }
        }
        if item.kind.hal == Hal::Port && !item.is_pin() {
            self.wrong(written.span, Problem::PortParam);
        }
        if let Some(default) = &item.default {
            self.default(item, default);
        }
    }

    fn default(&mut self, item: &Item, default: &At<Value>) {
        let kind = item.kind.word;
        let problem = match (&default.value, item.kind.hal, item.kind.hal.range()) {
            (_, Hal::Port, _) => Problem::NoDefault { kind },
            (Value::Whole(n), _, Some((least, most))) if *n < least || *n > most => {
                Problem::OutOfRange { value: n.to_string().into(), kind, least, most }
            }
            (Value::Real(x), Hal::Bit, _) if *x != 0.0 && *x != 1.0 => Problem::WrongValue { kind },
            (Value::Real(x), _, Some(_)) if x.fract() != 0.0 => Problem::WrongValue { kind },
            (Value::Text(_), ..) => Problem::WrongValue { kind },
            _ => return,
        };
        self.wrong(default.span, problem);
    }

    /// Checks that need the whole component.
    fn whole(&mut self, out: &Component) {
        let end = out_of_declarations(self.source);
        if out.texts(TextKind::License).next().is_none() {
            self.wrong(end, Problem::NoLicense);
        }
        if !out.items.iter().any(Item::is_pin) {
            self.wrong(end, Problem::NoPin);
        }
        let options = &out.options;
        if options.on("userspace")
            && let Some(first) = out.functions.first()
            && !self.faults.iter().any(|f| f.problem == Problem::UserspaceFunction)
        {
            self.wrong(first.name.span, Problem::UserspaceFunction);
        }
        for (one, other) in [("singleton", "count_function"), ("singleton", "default_count")] {
            let given = |name| options.on(name) || options.whole(name).is_some();
            if given(one) && given(other) {
                let span = options.place(other).map_or(end, |p| p.span);
                self.wrong(span, Problem::Apart { one, other });
            }
        }
        if options.on("userinit") && !options.on("userspace") {
            let span = options.place("userinit").map_or(end, |p| p.span);
            self.wrong(span, Problem::NeedsUserspace { name: "userinit" });
        }
        let has_code = out.body.text.chars().any(|c| !c.is_whitespace());
        let functions = out.functions.len();
        if functions > 1
            && has_code
            && !out.names_function()
            && !options.on("no_convenience_defines")
        {
            let span = out.functions.get(1).map_or(end, |f| f.name.span);
            self.wrong(span, Problem::BodyWithoutFunction { functions });
        }
    }
}

/// Returns the span of the line `;;`.
fn out_of_declarations(source: &str) -> Span {
    let mut at = 0;
    for line in source.split_inclusive('\n') {
        if line.trim_end() == ";;" {
            return Span { start: at, end: at + 2 };
        }
        at += line.len();
    }
    Span { start: at, end: at }
}
