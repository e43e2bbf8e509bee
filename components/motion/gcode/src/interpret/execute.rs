//! The order in which the parts of a block are run.

use super::block::Block;
use crate::{
    canon::{Call, Issued},
    environment::Environment,
    error::Problem,
    interpret::codes::{GGroup, MGroup},
    parameters::number,
    question::{Answer, Request},
    state::State,
    text::expression::Left,
};

/// The run of one block: the state it changes and the calls it makes.
pub struct Run<'a> {
    pub(crate) state: &'a mut State,
    pub(crate) env: &'a dyn Environment,
    pub(crate) out: &'a mut Vec<Issued>,
    pub(crate) line: u32,
    pub(crate) number: Option<u32>,
    pub(crate) focus: Option<Left>,
}

/// The reason why a block is not finished.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Pause {
    /// A question.
    Ask(Request),
    /// A remapped code, by its place in the settings.
    Remap(usize),
    /// A cycle along a profile.
    Profile,
}

/// A pause and the step that made it.
pub(crate) type Asked = Option<(Pause, u8)>;

/// The part of a block that a step runs, for the place of its errors.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Part {
    Remark,
    Word(u8),
    G(GGroup),
    M(MGroup),
}

type StepFn = fn(&mut Run<'_>, &mut Block) -> Result<Option<Request>, Problem>;

/// The steps of a block in their order.
const STEPS: [(Part, StepFn); 27] = [
    (Part::Remark, |r, b| r.remark(b)),
    (Part::G(GGroup::SpindleMode), |r, b| r.spindle_mode(b)),
    (Part::G(GGroup::FeedMode), |r, b| r.feed_mode(b)),
    (Part::Word(b'f'), |r, b| r.feed_rate(b)),
    (Part::Word(b's'), |r, b| r.spindle_speed(b)),
    (Part::Word(b't'), |r, b| r.select_tool(b)),
    (Part::M(MGroup::Io), |r, b| r.inputs_and_outputs(b)),
    (Part::M(MGroup::Tool), |r, b| r.change_tool(b)),
    (Part::M(MGroup::Spindle), |r, b| r.turn_spindle(b)),
    (Part::M(MGroup::Save), |r, b| r.save_or_restore(b)),
    (Part::M(MGroup::Coolant), |r, b| r.coolant(b)),
    (Part::M(MGroup::Override), |r, b| r.overrides(b)),
    (Part::M(MGroup::User), |r, b| r.user_code(b)),
    (Part::G(GGroup::Once), |r, b| r.dwell(b)),
    (Part::G(GGroup::Plane), |r, b| r.plane(b)),
    (Part::G(GGroup::Unit), |r, b| r.unit(b)),
    (Part::G(GGroup::Lathe), |r, b| r.lathe_mode(b)),
    (Part::G(GGroup::Compensation), |r, b| r.compensation(b)),
    (Part::G(GGroup::ToolOffset), |r, b| r.tool_offset(b)),
    (Part::G(GGroup::System), |r, b| r.coordinate_system(b)),
    (Part::G(GGroup::Path), |r, b| r.path_mode(b)),
    (Part::G(GGroup::Distance), |r, b| r.distance(b)),
    (Part::G(GGroup::IjkDistance), |r, b| r.ijk_distance(b)),
    (Part::G(GGroup::Retract), |r, b| r.retract(b)),
    (Part::G(GGroup::Once), |r, b| r.once(b)),
    (Part::G(GGroup::Motion), |r, b| r.motion(b)),
    (Part::M(MGroup::Stop), |r, b| r.stop(b)),
];

impl<'a> Run<'a> {
    /// Returns the run of a block of the line in execution.
    pub(crate) fn new(
        state: &'a mut State,
        env: &'a dyn Environment,
        out: &'a mut Vec<Issued>,
    ) -> Self {
        let line = state.line;
        Run { state, env, out, line, number: None, focus: None }
    }

    /// Runs the steps of a block from `first` on, until one asks.
    pub(crate) fn execute(&mut self, block: &mut Block, first: u8) -> Result<Asked, Problem> {
        for (index, (part, step)) in (0u8..).zip(STEPS).skip(usize::from(first)) {
            let place = match part {
                Part::Remark => block.remark.is_some().then_some(None),
                Part::Word(letter) => block.has(letter).then(|| Some(block.place(letter))),
                // A motion may be modal.
                Part::G(GGroup::Motion) => block.motion.map(|_| block.g_place(GGroup::Motion)),
                Part::G(group) => block.g_place(group).map(Some),
                Part::M(group) => block.m_place(group).map(Some),
            };
            // A step without its word does nothing.
            let Some(place) = place else { continue };
            self.focus = place;
            if let Some(remap) = self.remap_of(part, block)? {
                return Ok(Some((Pause::Remap(remap), index)));
            }
            let profile = matches!(block.motion, Some(700..=722));
            if profile && part == Part::G(GGroup::Motion) {
                return Ok(Some((Pause::Profile, index)));
            }
            if let Some(request) = step(self, block)? {
                self.flush_compensation();
                return Ok(Some((Pause::Ask(request), index)));
            }
        }
        self.focus = None;
        Ok(None)
    }

    /// Hands a call out, or keeps it behind moves whose ends are not known yet.
    pub(crate) fn emit(&mut self, call: Call) -> Result<(), Problem> {
        let issued = Issued { call, line: self.line, number: self.number };
        let limit = self.state.settings.limits.calls;
        // Messages do not wait for the end of a move.
        let message = matches!(issued.call, Call::Print(_) | Call::Message(_) | Call::Log(_));
        if self.state.compensation.holds() && !message {
            if self.state.compensation.queue.len() >= limit {
                return Err(Problem::OutputTooLarge { limit });
            }
            self.state.compensation.queue.push(issued);
            return Ok(());
        }
        if self.out.len() >= limit {
            return Err(Problem::OutputTooLarge { limit });
        }
        let call = self.of_the_tip(issued.call);
        self.out.push(Issued { call, ..issued });
        Ok(())
    }

    /// Hands a remark of the interpreter out.
    pub(crate) fn note(&mut self, text: &str) -> Result<(), Problem> {
        self.emit(Call::Comment(format!("interpreter: {text}").into()))
    }

    /// Takes the answer to a request into the state.
    pub(crate) fn take_answer(
        &mut self,
        request: &Request,
        answer: &Answer,
    ) -> Result<(), Problem> {
        match (request, answer) {
            (request, Answer::Failed(reason)) => Err(failed(request, reason.clone())),
            (Request::Probe, Answer::Probe { tripped_at, stopped_at, tripped }) => {
                self.probed(*tripped_at, *stopped_at, *tripped);
                Ok(())
            }
            (Request::ToolChange { .. }, Answer::ToolChange { position }) => {
                if let Some(position) = position {
                    let frame = &self.state.frame;
                    let machine = position.scaled(1.0 / frame.unit.millimetres());
                    self.state.position = frame.program(machine);
                }
                Ok(())
            }
            (Request::Input { .. }, Answer::Input(value)) => {
                self.state.numbered.put(number::INPUT, *value);
                Ok(())
            }
            (Request::UserCode { .. } | Request::Finish, Answer::Done) => Ok(()),
            _ => Err(Problem::WrongAnswer),
        }
    }
}

/// Returns the problem of a request that the machine could not carry out.
pub(super) fn failed(request: &Request, reason: Box<str>) -> Problem {
    match request {
        Request::Probe => Problem::ProbeFailed { reason },
        Request::ToolChange { .. } => Problem::ToolChangeFailed { reason },
        Request::Input { .. } => Problem::InputFailed { reason },
        Request::Hal { .. } => Problem::HalFailed { reason },
        Request::UserCode { code, .. } => Problem::UserCodeFailed { code: *code, reason },
        Request::Function { name } => Problem::HookFailed { name: name.clone(), reason },
        Request::Finish => Problem::FinishFailed { reason },
    }
}
