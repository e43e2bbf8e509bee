//! The state of the interpreter as functions of another language see it, by value.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::{
    axis::Axis,
    canon::{Direction, Plane, Unit},
    environment::Environment,
    function::{Function, Hook},
    interpret::{
        block::Block,
        codes::{GGroup, MGroup},
    },
    parameters::{COUNT, Names, system},
    remap::Code,
    state::{FeedMode, Side, State},
};

/// The state that a function sees. Lengths are in the units of the program.
#[derive(Debug, Serialize)]
pub struct View<'a> {
    /// The call.
    pub function: &'a Function,
    /// The numbered parameters that are not 0.
    pub numbered: Vec<(i32, f64)>,
    /// The local named parameters.
    pub locals: &'a Names,
    /// The global named parameters.
    pub globals: &'a Names,
    /// Fields with a number.
    pub fields: BTreeMap<&'static str, f64>,
    /// Speeds of the spindles.
    pub speed: Vec<f64>,
    /// Directions of the spindles: 1 stopped, 2 clockwise, 3 counterclockwise.
    pub turning: Vec<u8>,
    /// Offset of the tool by axis.
    pub tool_offset: BTreeMap<char, f64>,
    /// G codes in force, times ten, as the task's status has them.
    pub g_codes: Vec<u32>,
    /// The program's file.
    pub file: &'a str,
    /// The blocks whose remapped code runs, the outermost first.
    pub blocks: Vec<BlockView<'a>>,
}

/// A block whose remapped code runs.
#[derive(Debug, Serialize)]
pub struct BlockView<'a> {
    /// The words by their letters.
    pub words: BTreeMap<char, f64>,
    /// G codes times ten by their group.
    pub g_modes: Vec<(u8, u16)>,
    /// M codes by their group.
    pub m_modes: Vec<(u8, u16)>,
    /// The comment, if it means something.
    pub comment: &'a str,
    /// The line of its file, from 1.
    pub line: u32,
    /// The N number.
    pub number: Option<u32>,
    /// The code was used inside of its own subroutine.
    pub builtin_used: bool,
    /// The remap: its code, times ten for a G code.
    pub name: String,
    /// The words that it takes, as `argspec` lists them.
    pub argspec: String,
    /// The modal group.
    pub modal_group: u8,
    /// The code of motion, times ten; -1 for none.
    pub motion_code: i32,
    /// The subroutine.
    pub ngc: &'a str,
    /// The functions of the remap.
    pub hooks: &'a [(Hook, Box<str>)],
}

/// Groups of G codes with their numbers in LinuxCNC.
const G_GROUPS: [(GGroup, u8); GGroup::COUNT] = [
    (GGroup::Once, 0),
    (GGroup::Motion, 1),
    (GGroup::Plane, 2),
    (GGroup::Distance, 3),
    (GGroup::IjkDistance, 4),
    (GGroup::FeedMode, 5),
    (GGroup::Unit, 6),
    (GGroup::Compensation, 7),
    (GGroup::ToolOffset, 8),
    (GGroup::Retract, 10),
    (GGroup::System, 12),
    (GGroup::Path, 13),
    (GGroup::SpindleMode, 14),
    (GGroup::Lathe, 15),
];

/// Letters of words with a value.
const LETTERS: &str = "abcdefhijklpqrstuvwxyz";

/// Returns the number of a plane as functions know it.
fn plane(plane: Plane) -> u8 {
    match plane {
        Plane::Xy => 1,
        Plane::Yz => 2,
        Plane::Xz => 3,
        Plane::Uv => 4,
        Plane::Vw => 5,
        Plane::Uw => 6,
    }
}

impl<'a> View<'a> {
    /// Returns what the innermost level sees; `None` if it is no function.
    pub fn of(state: &'a State, env: &dyn Environment) -> Option<Self> {
        let function = state.function()?;
        let last = i32::try_from(COUNT).unwrap_or(0);
        let numbered = (1..last).map(|n| (n, system::numbered(state, n)));
        let turning = state.modal.spindles.iter().map(|s| match s.direction {
            Direction::Stopped => 1,
            Direction::Clockwise => 2,
            Direction::Counterclockwise => 3,
        });
        let remapped = state.levels.iter().filter_map(|l| l.remapped.as_ref().zip(Some(l)));
        let blocks = remapped.filter_map(|(r, level)| {
            let remap = state.settings.remaps.get(r.index)?;
            let block = &r.block;
            let argument = |a: &crate::remap::Argument| {
                let letter = char::from(a.letter);
                if a.required { letter.to_ascii_uppercase() } else { letter }
            };
            Some(BlockView {
                words: words(block),
                g_modes: G_GROUPS.iter().filter_map(|(g, n)| Some((*n, block.g(*g)?))).collect(),
                m_modes: (4u8..)
                    .zip(MGroup::ALL)
                    .filter_map(|(n, g)| Some((n, block.m(g)?)))
                    .collect(),
                comment: block.remark.as_ref().map_or("", |r| &r.1),
                line: level.cursor.line,
                number: block.number,
                builtin_used: r.builtin_used,
                name: remap.code.to_string(),
                argspec: remap.arguments.iter().map(argument).collect(),
                modal_group: remap.group,
                motion_code: match remap.code {
                    Code::G(code) => code.into(),
                    Code::M(_) | Code::Word(_) => -1,
                },
                ngc: &remap.ngc,
                hooks: &remap.hooks,
            })
        });
        Some(Self {
            function,
            numbered: numbered.filter(|(_, value)| *value != 0.0).collect(),
            locals: &state.scope()?.locals,
            globals: &state.globals,
            fields: fields(state, env),
            speed: state.modal.spindles.iter().map(|s| s.speed).collect(),
            turning: turning.collect(),
            tool_offset: Axis::ALL.map(|a| (a.letter(), state.frame.tool[a])).into(),
            g_codes: state.g_codes().into(),
            file: state.levels.first().map_or("", |l| &l.file),
            blocks: blocks.collect(),
        })
    }
}

fn words(block: &Block) -> BTreeMap<char, f64> {
    let word = |letter: char| Some((letter, block.get(u8::try_from(letter).ok()?)?));
    LETTERS.chars().filter_map(word).collect()
}

/// Returns the fields of the interpreter that are numbers.
fn fields(state: &State, env: &dyn Environment) -> BTreeMap<&'static str, f64> {
    let modal = &state.modal;
    let truth = |is: bool| f64::from(u8::from(is));
    let slot = |number: i32| if number > 0 { env.tool_slot(number).unwrap_or(-1) } else { -1 };
    let selected = state.selected.unwrap_or(-1);
    let selected_slot = if selected == 0 { 0 } else { slot(selected) };
    let mut out = BTreeMap::from([
        ("task", truth(state.settings.task)),
        ("current_tool", state.tool.number.into()),
        ("current_pocket", if state.tool.number == 0 { 0 } else { slot(state.tool.number) }.into()),
        ("selected_tool", selected.into()),
        ("selected_pocket", selected_slot.into()),
        ("feed_rate", modal.feed),
        ("motion_mode", modal.motion.into()),
        ("plane", plane(modal.plane).into()),
        ("length_units", if modal.unit == Unit::Inch { 1.0 } else { 2.0 }),
        ("distance_mode", truth(!modal.absolute)),
        ("ijk_distance_mode", truth(!modal.ijk_absolute)),
        ("retract_mode", truth(modal.retract_old)),
        ("cutter_comp_radius", state.compensation.radius),
        ("cutter_comp_orientation", state.compensation.orientation.into()),
        ("origin_index", modal.system.into()),
        ("rotation_xy", state.frame.rotation),
        ("return_value", state.returned.unwrap_or(0.0)),
        ("value_returned", truth(state.returned.is_some())),
        ("call_level", state.call_level() as f64),
        ("sequence_number", state.line.into()),
        ("num_spindles", modal.spindles.len() as f64),
        ("feed_override", truth(modal.feed_override)),
        ("mist", truth(modal.mist)),
        ("flood", truth(modal.flood)),
        ("random_toolchanger", truth(state.settings.random_changer)),
        (
            "cutter_comp_side",
            match state.compensation.side() {
                Side::Off => 0.0,
                Side::Right => 1.0,
                Side::Left => 2.0,
            },
        ),
        (
            "feed_mode",
            match modal.feed_mode {
                FeedMode::PerMinute => 0.0,
                FeedMode::InverseTime => 1.0,
                FeedMode::PerRevolution => 2.0,
            },
        ),
    ]);
    let (here, g5x, g92) = (&state.position, &state.frame.g5x, &state.frame.g92);
    for (axis, [at, origin, offset]) in Axis::ALL.into_iter().zip(PLACES) {
        out.extend([(at, here[axis]), (origin, g5x[axis]), (offset, g92[axis])]);
    }
    out
}

/// Names of the place, the offset of the coordinate system and that of G92 for each axis.
const PLACES: [[&str; 3]; 9] = [
    ["current_x", "origin_offset_x", "axis_offset_x"],
    ["current_y", "origin_offset_y", "axis_offset_y"],
    ["current_z", "origin_offset_z", "axis_offset_z"],
    ["AA_current", "AA_origin_offset", "AA_axis_offset"],
    ["BB_current", "BB_origin_offset", "BB_axis_offset"],
    ["CC_current", "CC_origin_offset", "CC_axis_offset"],
    ["u_current", "u_origin_offset", "u_axis_offset"],
    ["v_current", "v_origin_offset", "v_axis_offset"],
    ["w_current", "w_origin_offset", "w_axis_offset"],
];
