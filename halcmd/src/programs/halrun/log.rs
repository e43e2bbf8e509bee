//! The log on standard error: messages of components and of the engine, as `--log` selects them.

use crate::{Error, session::prompt::Aside};
use std::fmt;
use tracing::{
    Event, Subscriber,
    field::{Field, Visit},
    level_filters::LevelFilter,
};
use tracing_subscriber::{
    Layer,
    fmt::format::debug_fn,
    layer::{Context, SubscriberExt},
    util::SubscriberInitExt,
};

/// Prints messages of components and of the engine on standard error as they come. The engine
/// decides from which level on components send them (`debug LEVEL`).
pub(super) fn listen(selection: Selection) {
    let text_alone = debug_fn(|to, field: &Field, value| match field.name() {
        "message" => write!(to, "{value:?}"),
        _ => Ok(()),
    });
    let lines = tracing_subscriber::fmt::layer()
        .fmt_fields(text_alone)
        .with_writer(Aside::default)
        .with_ansi(false)
        .with_level(false)
        .with_target(false)
        .without_time()
        // A failed write to standard error would be reported there as well, and end the machine.
        .log_internal_errors(false);
    let log = tracing_subscriber::registry().with(lines).with(LevelFilter::DEBUG).with(selection);
    // A program that uses this crate as a library may have installed another subscriber.
    drop(log.try_init());
}

/// Components and threads whose messages are shown. An empty list selects all of its kind, and a
/// message that names neither is always shown.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Selection {
    components: Vec<String>,
    threads: Vec<String>,
}

impl Selection {
    /// Parses words such as `component=stepgen thread=servo`.
    pub(super) fn parse(words: &str) -> Result<Self, Error> {
        let mut selection = Self::default();
        for word in words.split_whitespace() {
            let (key, name) = word.split_once('=').unwrap_or((word, ""));
            let list = match key {
                "component" if !name.is_empty() => &mut selection.components,
                "thread" if !name.is_empty() => &mut selection.threads,
                _ => {
                    return Err(Error::OptionValue {
                        program: "halrun",
                        option: "--log".into(),
                        value: word.into(),
                        why: "expected component=NAME or thread=NAME".into(),
                    });
                }
            };
            list.push(name.to_owned());
        }
        Ok(selection)
    }

    fn shows(&self, about: &About) -> bool {
        let fits = |wanted: &[String], name: &Option<String>| {
            wanted.is_empty() || name.as_ref().is_none_or(|name| wanted.contains(name))
        };
        fits(&self.components, &about.component) && fits(&self.threads, &about.thread)
    }
}

impl<S: Subscriber> Layer<S> for Selection {
    fn event_enabled(&self, event: &Event<'_>, _: Context<'_, S>) -> bool {
        let mut about = About::default();
        event.record(&mut about);
        self.shows(&about)
    }
}

/// Component and thread that a message names in its fields.
#[derive(Debug, Default)]
struct About {
    component: Option<String>,
    thread: Option<String>,
}

impl Visit for About {
    fn record_str(&mut self, field: &Field, value: &str) {
        match field.name() {
            "component" => self.component = Some(value.to_owned()),
            "thread" => self.thread = Some(value.to_owned()),
            _ => {}
        }
    }

    fn record_debug(&mut self, _: &Field, _: &dyn fmt::Debug) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_select_and_what_names_nothing_is_shown() {
        let shown = |words: &str, component: Option<&str>, thread: Option<&str>| {
            let selection = Selection::parse(words).unwrap();
            let about = About {
                component: component.map(str::to_owned),
                thread: thread.map(str::to_owned),
            };
            selection.shows(&about)
        };
        assert!(shown("", Some("pid"), Some("servo")));
        assert!(shown("component=pid component=motmod", Some("motmod"), None));
        assert!(!shown("component=pid", Some("motmod"), None));
        assert!(!shown("component=pid", Some("pi"), None));
        assert!(shown("component=pid", None, None));
        assert!(shown("component=pid thread=servo", Some("pid"), Some("servo")));
        assert!(!shown("component=pid thread=servo", Some("pid"), Some("base")));
        assert!(!shown("component=pid thread=servo", Some("motmod"), Some("servo")));
    }

    #[test]
    fn other_words_are_refused_with_what_would_be_right() {
        for word in ["pid", "component", "component=", "funct=x", "=pid"] {
            let error = Selection::parse(&format!("thread=a {word}")).unwrap_err().to_string();
            let want = "expected component=NAME or thread=NAME";
            assert!(error.contains(&format!("'{word}'")) && error.contains(want), "{error}");
        }
    }
}
