//! Pins of the task.

use hal_component::{Builder, Error, In, Out, Touch};

/// Pins between the task and remote work.
#[derive(Debug, Touch)]
pub(crate) struct Pins {
    pub(crate) job: In<bool>,
    pub(crate) abort: Out<bool>,
    pub(crate) tool_change: In<bool>,
    pub(crate) tool_changed: Out<bool>,
}

impl Pins {
    pub(crate) fn make(b: &mut Builder<'_>) -> Result<Self, Error> {
        let item = "TRUE while a job is in progress, also while it is paused; linked to task.job.";
        Ok(Self {
            job: b.item("remote.job", item, false)?,
            abort: b.item(
                "remote.abort",
                "Rises again and again while a lost lease ends a job; linked to task.abort.",
                false,
            )?,
            tool_change: b.item(
                "remote.tool-change",
                "FALSE releases the button; linked to the request of the tool change.",
                true,
            )?,
            tool_changed: b.item(
                "remote.tool-changed",
                "Button that answers a tool change; remote.tool-changed presses it.",
                false,
            )?,
        })
    }
}
