//! A session as its pins and `robot.status` show it.

use super::{
    cause::Cause,
    pins::{Results, SimResults},
    report::Report,
    session::Session,
};
use crate::State;

impl Session {
    /// Returns whether the robot retracts at a connection, or is about to.
    pub(crate) fn is_connecting(&self) -> bool {
        self.is_opening() || self.driver.state() == State::Connected
    }

    /// Returns whether a run is paused and the robot stands.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.driver.state() == State::Paused && !self.driver.awaits_line()
    }

    /// Returns the values of the pins.
    pub(crate) fn results(&self) -> Results {
        let state = self.driver.state();
        let cause = self.cause();
        let program = self.program.as_ref();
        let record = program.and_then(|p| p.records.get(self.line).or_else(|| p.records.last()));
        let number = |n: usize| i32::try_from(n).unwrap_or(i32::MAX);
        let [x, y, z] = self.point;
        let [zero_x, zero_y, zero_z] = self.zero.unwrap_or_default();
        let [joint_0, joint_1, joint_2, joint_3, joint_4, joint_5] = self.joints;
        Results {
            connected: self.is_driven(),
            ready: state == State::Ready,
            running: state == State::Running,
            paused: self.is_at_rest(),
            busy: self.runs() || self.is_connecting(),
            connecting: self.is_connecting(),
            ended: state == State::Ended && cause.is_none(),
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
        report.state = match (self.cause(), self.driver.state()) {
            _ if self.is_opening() => "connecting",
            (Some(_), _) | (None, State::Stopped(_)) => "stopped",
            (None, State::Closed) => "closed",
            (None, State::Connected) => "connected",
            (None, State::Ready) => "ready",
            (None, State::Running) => "running",
            (None, State::Paused) => "paused",
            (None, State::Ended) => "ended",
        };
        (report.zero, report.line, report.cause) = (self.zero, self.line, self.cause());
        report.program.clone_from(&self.program);
        report.problem.clone_from(&self.problem);
    }
}
