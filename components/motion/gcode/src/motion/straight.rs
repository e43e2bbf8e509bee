//! G0 and G1, and the feed of moves by time.

use crate::{
    axis::Position,
    canon::Call,
    error::Problem,
    interpret::{Run, block::Block},
    state::FeedMode,
};

impl Run<'_> {
    pub(super) fn straight(&mut self, b: &Block, rapid: bool) -> Result<(), Problem> {
        if !rapid {
            self.check_feed(b, "g1")?;
        }
        let end = self.target(b)?;
        self.state.compensation.ended = false;
        if self.state.compensation.moves_path() {
            return self.compensated_line(b, end, rapid);
        }
        let start = self.state.position;
        if !rapid {
            self.inverse_feed(b, length(start, end))?;
        }
        self.emit(if rapid { Call::StraightTraverse(end) } else { Call::StraightFeed(end) })?;
        self.state.position = end;
        Ok(())
    }

    /// Checks that a move at feed has one.
    pub(crate) fn check_feed(&self, b: &Block, code: &'static str) -> Result<(), Problem> {
        let spindle = self.state.modal.spindles.get(usize::from(self.state.modal.feed_spindle));
        let still = spindle.is_none_or(|s| s.speed == 0.0);
        match self.state.modal.feed_mode {
            FeedMode::InverseTime if !b.has(b'f') => Err(Problem::InverseFeedMissing { code }),
            FeedMode::PerMinute | FeedMode::PerRevolution if self.state.modal.feed == 0.0 => {
                Err(if code == "arc" { Problem::ZeroFeedArc } else { Problem::ZeroFeed { code } })
            }
            FeedMode::PerRevolution if still => Err(Problem::ZeroSpindleFeed),
            _ => Ok(()),
        }
    }

    /// Sets the feed rate of a move by its time.
    pub(crate) fn inverse_feed(&mut self, b: &Block, length: f64) -> Result<(), Problem> {
        if self.state.modal.feed_mode != FeedMode::InverseTime {
            return Ok(());
        }
        let rate = length * b.get(b'f').unwrap_or(0.0);
        self.emit(Call::SetFeedRate(if rate < 0.1 { 0.1 } else { rate }))
    }
}

/// Returns the length of a straight move: in XYZ, or else in UVW, or else in degrees of ABC.
pub(crate) fn length(from: Position, to: Position) -> f64 {
    let d = to - from;
    let norm = |a: f64, b: f64, c: f64| libm::sqrt(a * a + b * b + c * c);
    let xyz = norm(d.x, d.y, d.z);
    if xyz > 0.0 {
        return xyz;
    }
    let uvw = norm(d.u, d.v, d.w);
    if uvw > 0.0 { uvw } else { norm(d.a, d.b, d.c) }
}
