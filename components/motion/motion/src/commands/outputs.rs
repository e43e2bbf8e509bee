//! Realtime. Execution of commands for spindles, outputs and the feed.

use crate::{
    commands::command::{FeedChange, Output, SpindleChange},
    commands::refusal::Refusal,
    setup::put,
    state::State,
};
use hal_component::MotionSource;

impl State {
    /// Changes the speed, brake or scale of a spindle.
    pub(super) fn change_spindle(
        &mut self,
        change: SpindleChange,
        source: MotionSource,
    ) -> Result<(), Refusal> {
        // A program stops a spindle between its moves; a stop by anybody else in the middle of a path is none of the path's.
        let keeps = source != MotionSource::Task && !self.path.is_idle();
        let Some(spindle) = self.spindles.get_mut(change.spindle) else {
            return Err(Refusal::new("there is no such spindle"));
        };
        if let Some(scale) = change.scale {
            spindle.scale = scale;
        }
        if let Some(speed) = change.speed {
            spindle.command(speed, source, keeps);
        }
        if let Some(brake) = change.brake {
            spindle.brake(brake);
        }
        Ok(())
    }

    /// Sets an output, or the tool offset.
    pub(crate) fn set_output(&mut self, output: Output) {
        match output {
            Output::Digital(n, value) => put(&mut self.digital_out, n, value),
            Output::ToolOffset(offset) => {
                self.tool_offset = offset;
                self.tool_offsets = self.tool_offsets.wrapping_add(1);
            }
            Output::Analog(n, value) => put(&mut self.analog_out, n, value),
        }
    }

    /// Changes scales and holds of the feed.
    pub(super) fn change_feed(&mut self, change: FeedChange) {
        let feed = &mut self.feed;
        feed.scale = change.scale.unwrap_or(feed.scale);
        feed.rapid = change.rapid.unwrap_or(feed.rapid);
        feed.adaptive = change.adaptive.unwrap_or(feed.adaptive);
        feed.hold = change.hold.unwrap_or(feed.hold);
    }
}
