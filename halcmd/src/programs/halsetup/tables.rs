//! The tables of questions.

use super::{
    boards::NAMES,
    questions::{Form, Question, Range},
};

const fn ask(
    key: &'static str,
    text: &'static str,
    unit: &'static str,
    default: &'static str,
    form: Form,
    help: &'static str,
) -> Question {
    Question { key, text, unit, default, form, is_needed: false, help }
}

const fn need(
    key: &'static str,
    text: &'static str,
    unit: &'static str,
    default: &'static str,
    form: Form,
    help: &'static str,
) -> Question {
    Question { is_needed: true, ..ask(key, text, unit, default, form, help) }
}

const NS: Form = Form::Number(Range::Within(0.0, 1e6));
const POSITIVE: Form = Form::Number(Range::Positive);
const SIGNED: Form = Form::Number(Range::Signed);

/// Questions about the whole machine.
pub(super) const WHOLE: &[Question] = &[
    need(
        "name",
        "Name of the machine",
        "",
        "machine",
        Form::Name,
        "The folder and the files get this name.",
    ),
    ask(
        "board",
        "Board between the computer and the drives",
        "",
        "own",
        Form::OneOf(NAMES),
        "A known board answers the questions about its lines; each answer can be changed.",
    ),
    need(
        "kind",
        "What moves it",
        "",
        "steppers",
        Form::OneOf(&["steppers", "servos", "arm"]),
        "Stepper motors or servo motors with encoders, an axis each; or the six steppers of an arm.",
    ),
    need(
        "driver",
        "Its inputs and outputs",
        "",
        "parport",
        Form::OneOf(&["parport", "viagpio"]),
        "A parallel port, or the GPIO of a board with a VIA VX900.",
    ),
    ask(
        "ports",
        "Addresses and modes of the ports, with commas",
        "hexadecimal",
        "378 out",
        Form::Ports,
        "'378 out, 278 in': an address or a number 0 to f, then out (12 outputs), in (13 inputs), x or epp.",
    ),
    ask(
        "units",
        "Unit of length",
        "",
        "mm",
        Form::OneOf(&["mm", "inch"]),
        "The unit of all lengths below, and of the INI file.",
    ),
    need(
        "latency",
        "Largest jitter that latency-test showed",
        "ns",
        "50000",
        NS,
        "Run latency-test for some minutes while the computer is busy.",
    ),
    need(
        "model",
        "Model of the arm",
        "",
        "rs03n",
        Form::OneOf(&["rs03n", "rx90"]),
        "The arms that armkins knows.",
    ),
    ask(
        "axes",
        "Axes, a letter each",
        "",
        "XYZ",
        Form::Axes,
        "XYZ for a mill, XZ for a lathe, XYZA with a rotary axis.",
    ),
    ask(
        "gantry",
        "Axis with two motors (a gantry)",
        "",
        "",
        Form::Gantry,
        "The two motors share the axis and home together.",
    ),
];
pub(super) const PINS: &[Question] = &[
    ask(
        "estop",
        "E-stop chain: TRUE while it is closed",
        "",
        "",
        Form::Input,
        "With it a latch holds the e-stop until it is reset.",
    ),
    ask(
        "estop-out",
        "E-stop relay: TRUE while all is well",
        "",
        "",
        Form::Output,
        "A relay in the e-stop chain of the machine.",
    ),
    ask(
        "charge-pump",
        "Charge pump: pulses while all is well",
        "",
        "",
        Form::Output,
        "A square wave, by which a board knows that the computer lives.",
    ),
    ask(
        "enable",
        "Enable of all drives",
        "",
        "",
        Form::Output,
        "Drives that have an enable each are asked for with their motors.",
    ),
    ask("probe", "Touch probe: TRUE while it touches", "", "", Form::Input, "For G38.2 to G38.5."),
    ask(
        "setter",
        "Tool setter: TRUE while it is pressed",
        "",
        "",
        Form::Input,
        "It joins the probe: a program cannot tell them apart.",
    ),
    ask("spindle", "Spindle on", "", "", Form::Output, "A relay, or the start of an inverter."),
    ask(
        "spindle-reverse",
        "Spindle backward: TRUE for M4",
        "",
        "",
        Form::Output,
        "The direction of an inverter.",
    ),
    ask(
        "spindle-pwm",
        "Spindle speed as pulse width",
        "",
        "",
        Form::Output,
        "The board makes 0 to 10 V of it.",
    ),
];
pub(super) const SPINDLE: &[Question] = &[
    ask(
        "speed",
        "Speed of the spindle at full pulse width",
        "rpm",
        "24000",
        POSITIVE,
        "The speed at 10 V.",
    ),
    ask(
        "frequency",
        "Frequency of the pulse width",
        "Hz",
        "100",
        Form::Number(Range::Within(1.0, 1000.0)),
        "The base thread makes it: the lower, the finer the speed.",
    ),
];
pub(super) const PULSE: &[Question] = &[
    ask("length", "Length of a step", "ns", "5000", NS, "The drive's manual has it."),
    ask("space", "Space between two steps", "ns", "5000", NS, "The drive's manual has it."),
    ask(
        "hold",
        "From a step to a change of the direction",
        "ns",
        "20000",
        NS,
        "The drive's manual has it.",
    ),
    ask(
        "setup",
        "From a change of the direction to a step",
        "ns",
        "20000",
        NS,
        "The drive's manual has it.",
    ),
];
pub(super) const RANGE: &[Question] = &[
    need(
        "min",
        "Lowest position",
        "{u}",
        "-100",
        SIGNED,
        "The soft limit: 1 before the switch is usual.",
    ),
    need("max", "Highest position", "{u}", "100", SIGNED, "The soft limit at the other end."),
    need(
        "velocity",
        "Largest velocity",
        "{u}/s",
        "50",
        POSITIVE,
        "'halsetup --test AXIS' finds what an axis bears.",
    ),
    need(
        "acceleration",
        "Largest acceleration",
        "{u}/s2",
        "500",
        POSITIVE,
        "'halsetup --test AXIS' finds what an axis bears.",
    ),
];
pub(super) const JOINT: &[Question] = &[
    ask(
        "drive-acceleration",
        "Acceleration of the step generator",
        "{u}/s2",
        "",
        Form::Number(Range::PositiveOrNone),
        "None is 1.25 times the acceleration.",
    ),
    need(
        "turn",
        "Full steps of a turn of the motor, or edges of the encoder",
        "",
        "200",
        POSITIVE,
        "200 for 1.8 degrees.",
    ),
    ask("microsteps", "Microsteps of a full step", "", "1", POSITIVE, "As the drive is set."),
    ask(
        "gear",
        "Turns of the motor for a turn of the screw",
        "",
        "1",
        POSITIVE,
        "1 without a gear.",
    ),
    need("pitch", "Way of a turn of the screw", "{u}", "5", POSITIVE, "360 for a rotary axis."),
    ask(
        "home",
        "Position after homing",
        "{u}",
        "0",
        SIGNED,
        "Where it goes to when it has found its switch.",
    ),
];
pub(super) const MOTOR: &[Question] = &[
    ask(
        "step",
        "Steps, or a servo's power",
        "",
        "",
        Form::Output,
        "None for a motor that is not wired.",
    ),
    ask(
        "direction",
        "Direction",
        "",
        "",
        Form::Output,
        "'!' before it turns the motor the other way round.",
    ),
    ask("enable", "Enable of this drive", "", "", Form::Output, "None if all drives share one."),
    ask(
        "switch",
        "Limit and home switch: TRUE at the end",
        "",
        "",
        Form::Input,
        "One line for both ends and for homing.",
    ),
];
pub(super) const SEARCH: Question = need(
    "search",
    "Velocity at which homing looks for it, with its sign",
    "{u}/s",
    "-5",
    SIGNED,
    "Negative: the switch is at the lowest position.",
);
pub(super) const SERVO: &[Question] = &[
    need(
        "full-speed",
        "Speed at full power",
        "{u}/s",
        "100",
        POSITIVE,
        "What the motor reaches without a load.",
    ),
    need("a", "Encoder's A", "", "", Form::Input, "One of the two channels."),
    need("b", "Encoder's B", "", "", Form::Input, "The other one."),
];

/// Tables of questions, with the part of the machine that they are about.
pub(super) const TABLES: [(&str, &[Question]); 9] = [
    ("", WHOLE),
    ("pins", PINS),
    ("spindle", SPINDLE),
    ("pulse", PULSE),
    ("range", RANGE),
    ("joint", JOINT),
    ("joint", MOTOR),
    ("joint", std::slice::from_ref(&SEARCH)),
    ("joint", SERVO),
];
