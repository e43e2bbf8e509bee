//! A session as its pins and `robot.status` show it.

use super::{
    cause::Cause,
    pins::{Results, SimResults},
    report::Report,
    session::Session,
};
use crate::State;

/// State of a session, from which its pins and `robot.status` follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SessionState {
    /// There is no connection.
    Closed,
    /// A thread connects.
    Connecting,
    /// The robot retracts, and has not yet said where the part zero is.
    Connected,
    /// The robot waits for a run.
    Ready,
    /// Lines are executed.
    Running,
    /// The line under way ends, and no other follows.
    Pausing,
    /// The robot stands in a pause.
    Paused,
    /// All lines are executed.
    Ended,
    /// A run or a connection has ended otherwise.
    Stopped(Cause),
}

impl SessionState {
    /// Returns whether the controller is connected, or about to be: the robot may move.
    pub(crate) const fn is_connected(self) -> bool {
        !matches!(self, Self::Closed | Self::Ended | Self::Stopped(_))
    }

    /// Returns whether the robot retracts at a connection, or is about to.
    const fn is_connecting(self) -> bool {
        matches!(self, Self::Connecting | Self::Connected)
    }

    /// Returns whether a run is in progress.
    pub(crate) const fn runs(self) -> bool {
        matches!(self, Self::Running | Self::Pausing | Self::Paused)
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::Connecting => "connecting",
            Self::Connected => "connected",
            Self::Ready => "ready",
            Self::Running => "running",
            Self::Pausing | Self::Paused => "paused",
            Self::Ended => "ended",
            Self::Stopped(_) => "stopped",
        }
    }
}

impl Session {
    /// Returns the state.
    pub(crate) const fn state(&self) -> SessionState {
        match (self.driver.state(), self.cause) {
            _ if self.opening().is_some() => SessionState::Connecting,
            (State::Connected, _) => SessionState::Connected,
            (State::Ready, _) => SessionState::Ready,
            (State::Running, _) => SessionState::Running,
            (State::Paused, _) if self.driver.awaits_line() => SessionState::Pausing,
            (State::Paused, _) => SessionState::Paused,
            (_, Some(cause)) => SessionState::Stopped(cause),
            (State::Stopped(why), None) => SessionState::Stopped(Cause::of(&why)),
            (State::Ended, None) => SessionState::Ended,
            (State::Closed, None) => SessionState::Closed,
        }
    }

    /// Returns the reason of the end of a run or a connection that did not end as it should.
    pub(crate) const fn cause(&self) -> Option<Cause> {
        match self.state() {
            SessionState::Stopped(cause) => Some(cause),
            _ => None,
        }
    }

    /// Returns the values of the pins.
    pub(crate) fn results(&self) -> Results {
        let (state, cause) = (self.state(), self.cause());
        let program = self.program.as_ref();
        let record = program.and_then(|p| p.records.get(self.line).or_else(|| p.records.last()));
        let number = |n: usize| i32::try_from(n).unwrap_or(i32::MAX);
        let [x, y, z] = self.point;
        let [zero_x, zero_y, zero_z] = self.zero.unwrap_or_default();
        let [joint_0, joint_1, joint_2, joint_3, joint_4, joint_5] = self.joints;
        Results {
            connected: state.is_connected() && state != SessionState::Connecting,
            ready: state == SessionState::Ready,
            running: state == SessionState::Running,
            paused: state == SessionState::Paused,
            busy: state.runs() || state.is_connecting(),
            connecting: state.is_connecting(),
            ended: state == SessionState::Ended,
            stopped: cause.is_some(),
            error: cause.map_or(0, Cause::number),
            line: number(self.line),
            lines: number(program.map_or(0, |p| p.records.len())),
            program_line: record.map_or(0, |r| i32::try_from(r.line).unwrap_or(i32::MAX)),
            x,
            y,
            z,
            zero_x,
            zero_y,
            zero_z,
            speed: self.speed,
            joint_0,
            joint_1,
            joint_2,
            joint_3,
            joint_4,
            joint_5,
        }
    }

    /// Returns the true state of the simulated robot.
    pub(crate) fn sim_results(&self, now: f64) -> SimResults {
        let Some(link) = &self.simulated else { return SimResults::default() };
        let robot = link.controller();
        let [x, y, z] = robot.place(now);
        let moves = i32::try_from(robot.moves().len()).unwrap_or(i32::MAX);
        SimResults { x, y, z, moving: robot.is_moving(), moves }
    }

    /// Fills in what `robot.status` tells.
    pub(crate) fn report(&self, report: &mut Report) {
        report.state = self.state().name();
        (report.zero, report.line, report.cause) = (self.zero, self.line, self.cause());
        report.program.clone_from(&self.program);
        report.problem.clone_from(&self.problem);
    }
}
