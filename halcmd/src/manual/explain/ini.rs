//! Explanations of findings about INI files.

use super::explanation::Explanation;
use hal_protocol::Code;

/// A machine with one joint. The arguments are the entries of `[HAL]` and of `[JOINT_0]`.
macro_rules! machine {
    ($hal:literal, $joint:literal) => {
        concat!(
            "loadrt trivkins\n",
            "loadrt motmod base_period_nsec=100000 servo_period_nsec=1000000 num_joints=1\n",
            "loadrt stepgen step_type=0\n",
            "addf stepgen.make-pulses base-thread\n",
            "addf stepgen.capture-position servo-thread\n",
            "addf motion-command-handler servo-thread\n",
            "addf motion-controller servo-thread\n",
            "addf stepgen.update-freq servo-thread\n",
            "setp stepgen.0.position-scale [JOINT_0]SCALE\n",
            "setp stepgen.0.maxaccel [JOINT_0]STEPGEN_MAXACCEL\n",
            "net xpos-cmd joint.0.motor-pos-cmd => stepgen.0.position-cmd\n",
            "net xpos-fb stepgen.0.position-fb => joint.0.motor-pos-fb\n",
            "net xenable joint.0.amp-enable-out => stepgen.0.enable\n",
            "net estop-loop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in\n",
            "--- m.ini\n",
            "[EMCIO]\nCYCLE_TIME = 0.1\n[KINS]\nJOINTS = 1\n[TRAJ]\nLINEAR_UNITS = mm\n",
            "[HAL]\nHALFILE = m.hal\n",
            $hal,
            "[JOINT_0]\nSCALE = 100\nSTEPGEN_MAXACCEL = 1500\n",
            $joint
        )
    };
}

/// A machine without mistakes.
const PLAIN: &str = machine!("", "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\n");

/// The machine with tools that nobody has to change.
const TOOLS: &str = concat!(
    machine!(
        "HALFILE = tools.hal\n",
        "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\n[EMCIO]\nTOOL_TABLE = m.tbl\n"
    ),
    "--- m.tbl\nT1 P1\n",
    "--- tools.hal\n",
    "net tool-ready iocontrol.0.tool-prepare => iocontrol.0.tool-prepared\n",
    "net tool-done iocontrol.0.tool-change => iocontrol.0.tool-changed\n"
);

pub(super) const ROWS: &[Explanation] = &[
    Explanation {
        code: Code::IniUnreadable,
        means: "The INI file cannot be opened, or it is no INI file: it has no [SECTION], a section without \
                an end, or bytes that are no text.",
        matters: "halrun does not start.",
        remedy: "Comments begin with # or ; and have lines of their own.",
        wrong: "print ready\n--- m.ini\n[EMCIO\n# <--\nCYCLE_TIME = 0.1\n[HAL]\nHALFILE = m.hal\n",
        right: PLAIN,
    },
    Explanation {
        code: Code::NoHalfile,
        means: "A HALFILE is neither beside the INI file nor in the libraries of HAL files.",
        matters: "halrun stops before it has wired the machine.",
        remedy: "Correct the name, or make the file. LIB:NAME is looked for in HALLIB_PATH only.",
        wrong: machine!(
            "HALFILE = custom.hal\n# <--\n",
            "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\n"
        ),
        right: concat!(
            machine!("HALFILE = custom.hal\n", "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\n"),
            "--- custom.hal\nprint wiring\n"
        ),
    },
    Explanation {
        code: Code::NoPostgui,
        means: "A POSTGUI_HALFILE is not there.",
        matters: "The machine starts without what the file would have wired.",
        remedy: "Make the file, or take the entry out.",
        wrong: machine!(
            "POSTGUI_HALFILE = panel.hal\n# <--\n",
            "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\n"
        ),
        right: PLAIN,
    },
    Explanation {
        code: Code::IniUnused,
        means: "An entry of a joint, axis or spindle is read by no script, and neither motion nor a program \
                that is known reads it.",
        matters: "It has no effect: it may be misspelt, and another value counts in its place.",
        remedy: "Correct the name, use it in a script, or take it out.",
        wrong: machine!("", "COLOUR = red\n# <--\n"),
        right: PLAIN,
    },
    Explanation {
        code: Code::SectionRepeated,
        means: "The section is in the file more than once.",
        matters: "Its entries are added to the first; of an entry that is in both, the first \
                  counts.",
        remedy: "Put the entries together.",
        wrong: machine!("", "MAX_VELOCITY = 20\n[JOINT_0]\n# <--\nMAX_ACCELERATION = 1000\n"),
        right: PLAIN,
    },
    Explanation {
        code: Code::JointTooFast,
        means: "The joint's MAX_VELOCITY times the scale is more steps in a second than its step \
                generator can make in the base period, or more than the step generator's maxvel.",
        matters: "The motor stays behind in the first fast move: a following error.",
        remedy: "A lower MAX_VELOCITY, a shorter BASE_PERIOD, less microstepping, or a higher maxvel.",
        wrong: machine!("", "MAX_VELOCITY = 90\n# <--\nMAX_ACCELERATION = 1000\n"),
        right: machine!("", "MAX_VELOCITY = 40\nMAX_ACCELERATION = 1000\n"),
    },
    Explanation {
        code: Code::MotionRefuses,
        means: "An entry of the INI file is not a value that the motion controller accepts.",
        matters: "halrun stops there.",
        remedy: "The sentence says what is wrong.",
        wrong: machine!("", "MIN_LIMIT = 100\n# <--\nMAX_LIMIT = 0\n"),
        right: machine!(
            "",
            "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\nMIN_LIMIT = 0\nMAX_LIMIT = 100\n"
        ),
    },
    Explanation {
        code: Code::StepgenSlower,
        means: "The joint's MAX_ACCELERATION is more than the step generator's maxaccel.",
        matters: "The step generator cannot follow the planner: a following error in fast moves.",
        remedy: "Let maxaccel be a quarter more than MAX_ACCELERATION.",
        wrong: machine!("", "MAX_VELOCITY = 20\nMAX_ACCELERATION = 2000\n# <--\n"),
        right: PLAIN,
    },
    Explanation {
        code: Code::EntryMissing,
        means: "An entry that motion needs is missing or has no value.",
        matters: "Motion uses a default that seldom suits the machine: a joint without \
                  MAX_ACCELERATION accelerates with one unit in a second squared.",
        remedy: "Write the entry. A limit that no joint has is not missed.",
        wrong: machine!("", "MAX_VELOCITY = 20\nMAX_ACCELERATION =\n# <--\n"),
        right: PLAIN,
    },
    Explanation {
        code: Code::EntryMisplaced,
        means: "Nothing reads the entry, and its name is nearly that of an entry which is read, or \
                that of an entry of another section.",
        matters: "It has no effect: a default counts in its place.",
        remedy: "Correct the name, or move the entry to its section.",
        wrong: machine!("", "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\nMAX_LIMTI = 9\n# <--\n"),
        right: machine!("", "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\nMAX_LIMIT = 9\n"),
    },
    Explanation {
        code: Code::EntriesDisagree,
        means: "An entry contradicts another one or the wiring: HOME is outside the travel limits, \
                a search for a home switch has no switch or no latch velocity, HOME_SEQUENCE has a gap, \
                FERROR is less than a step, than the way of one servo period or than MIN_FERROR, both travel \
                limits are the same, BACKLASH is more than a millimetre or a degree, TYPE is not that of the \
                joint's axis, LINEAR_UNITS does not fit the joints' travel and speed, a value is no finite \
                number.",
        matters: "The machine starts, and fails when it homes or moves. Sections of joints that the \
                  machine does not have are a note.",
        remedy: "Correct the one that is wrong.",
        wrong: machine!(
            "",
            "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\nMAX_LIMIT = 9\nHOME = 10\n# <--\n"
        ),
        right: machine!(
            "",
            "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\nMAX_LIMIT = 9\nHOME = 5\n"
        ),
    },
    Explanation {
        code: Code::IniIgnored,
        means: "A line of the INI file is no entry NAME = VALUE, stands before the first [SECTION], or \
                includes a file that is not there; or text follows a [SECTION] on its line.",
        matters: "The machine starts without it, as in LinuxCNC: a default counts in the place of an entry \
                  that was meant.",
        remedy: "Correct the line, or make it a comment, with # or ; at its beginning.",
        wrong: machine!("", "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\nHOME 5\n# <--\n"),
        right: PLAIN,
    },
    Explanation {
        code: Code::EntryTwice,
        means: "A section in which each name stands for one value has the entry twice, with different \
                values.",
        matters: "The first counts; whoever changes the second one changes nothing.",
        remedy: "Keep the one that is meant.",
        wrong: machine!(
            "",
            "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\nMAX_VELOCITY = 30\n# <--\n"
        ),
        right: PLAIN,
    },
    Explanation {
        code: Code::CoordinatesOdd,
        means: "A letter is repeated in [TRAJ]COORDINATES or in coordinates= of the kinematics, as for an axis \
                that two joints move, and the other place or the number of joints does not agree.",
        matters: "Motion takes the wrong joints for an axis, or refuses to start.",
        remedy: "Write each letter as often as joints move that axis.",
        wrong: machine!(
            "",
            "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\n[TRAJ]\nCOORDINATES = XX\n# <--\n"
        ),
        right: machine!(
            "",
            "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\n[TRAJ]\nCOORDINATES = X\n"
        ),
    },
    Explanation {
        code: Code::NoToolTable,
        means: "The file of [EMCIO]TOOL_TABLE is neither beside the INI file nor where its path says.",
        matters: "The machine starts without tools: no tool has a length or a diameter.",
        remedy: "Make the file, or correct its name.",
        wrong: machine!(
            "",
            "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\n[EMCIO]\nTOOL_TABLE = m.tbl\n# <--\n"
        ),
        right: TOOLS,
    },
    Explanation {
        code: Code::NoProgramFolder,
        means: "The folder of [DISPLAY]PROGRAM_PREFIX is neither beside the INI file nor where its path says. A machine that \
                was copied from another computer often names a folder of its user there.",
        matters: "The panel and remote programs list and open no program; files of other programs and user codes are not \
                  found there.",
        remedy: "Write a folder of this computer, such as ~/linuxcnc/nc_files, or nc_files for one beside the INI file.",
        wrong: machine!(
            "",
            "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\n[DISPLAY]\nPROGRAM_PREFIX = /home/another/nc_files\n# <--\n"
        ),
        right: machine!(
            "",
            "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\n[DISPLAY]\nPROGRAM_PREFIX = .\n"
        ),
    },
];

/// Wiring that only the machine's INI file shows to be wrong.
pub(super) const WIRING: &[Explanation] = &[Explanation {
    code: Code::ToolChangeOpen,
    means: "The machine has a tool table, and the request for a tool and the pin that answers it are not \
                linked.",
    matters: "The first T or M6 of a program waits for ever.",
    remedy: "Link what changes tools, such as hal_manualtoolchange; or link each request to its answer.",
    wrong: concat!(
        machine!(
            "",
            "MAX_VELOCITY = 20\nMAX_ACCELERATION = 1000\n[EMCIO]\nTOOL_TABLE = m.tbl\n# <--\n"
        ),
        "--- m.tbl\nT1 P1\n"
    ),
    right: TOOLS,
}];
