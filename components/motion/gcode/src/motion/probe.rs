//! G38.2 to G38.5: probing moves.

use crate::{
    axis::{Axis, Position},
    canon::Call,
    error::Problem,
    interpret::{Run, block::Block},
    parameters::number,
    question::Request,
    state::FeedMode,
};

impl Run<'_> {
    pub(super) fn probe(&mut self, b: &Block, code: u16) -> Result<Request, Problem> {
        if self.state.compensation.is_on() {
            return Err(Problem::ProbeComp);
        }
        if self.state.modal.feed_mode == FeedMode::InverseTime {
            return Err(Problem::ProbeInverse);
        }
        if self.state.modal.feed == 0.0 {
            return Err(Problem::ProbeFeed);
        }
        let end = self.target(b)?;
        let way = end - self.state.position;
        if Axis::ALL.iter().all(|a| way[*a] == 0.0) {
            return Err(Problem::ProbeStart);
        }
        self.emit(Call::TurnProbeOn)?;
        let (away, must_trip) = (code >= 384, code.is_multiple_of(2));
        self.emit(Call::StraightProbe { end, away, must_trip })?;
        self.emit(Call::TurnProbeOff)?;
        self.state.position = end;
        Ok(Request::Probe)
    }

    /// Takes the result of a probing move, in machine coordinates of millimetres and degrees.
    pub(crate) fn probed(&mut self, tripped_at: Position, stopped_at: Position, tripped: bool) {
        let frame = self.state.frame;
        let k = 1.0 / frame.unit.millimetres();
        let result = frame.program(tripped_at.scaled(k));
        for axis in Axis::ALL {
            let index = number::PROBE + i32::from(axis.index());
            self.state.numbered.put(index, result[axis]);
        }
        self.state.numbered.put(number::PROBE_TRIPPED, if tripped { 1.0 } else { 0.0 });
        self.state.position = frame.program(stopped_at.scaled(k));
    }
}
