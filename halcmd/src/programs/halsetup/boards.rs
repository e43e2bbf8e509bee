//! Boards that are known: what is wired on them, so that it need not be answered. Only what is documented stands here.

/// A motor's outputs: steps, direction, and its own enable.
pub(super) type Motor = (&'static str, &'static str, &'static str);

/// A board with its wiring.
#[derive(Debug)]
pub(super) struct Board {
    pub(super) name: &'static str,
    /// Source of the wiring, for the help of the question.
    pub(super) about: &'static str,
    pub(super) driver: &'static str,
    /// Length, space, hold and setup of steps, in nanoseconds.
    pub(super) pulse: [&'static str; 4],
    /// Outputs of the motors, joint by joint.
    pub(super) motors: &'static [Motor],
    /// Lines of the whole machine, by the keys of `[pins]`.
    pub(super) pins: &'static [(&'static str, &'static str)],
    /// Time of the longest base period, in nanoseconds.
    pub(super) longest: f64,
}

/// Pulse times where nothing else is known.
const USUAL: [&str; 4] = ["5000", "5000", "20000", "20000"];
/// Longest base period, in nanoseconds.
const LONGEST: f64 = 100_000.0;
/// Step and direction in pairs from pin 2, as most boards have them.
const PAIRS: &[Motor] = &[("2", "3", ""), ("4", "5", ""), ("6", "7", ""), ("8", "9", "")];
/// Direction and step in pairs from pin 2.
const SWAPPED: &[Motor] = &[("3", "2", ""), ("5", "4", ""), ("7", "6", ""), ("9", "8", "")];

/// The boards. The first is none of the others: every line is answered.
pub(super) const BOARDS: &[Board] = &[
    Board {
        name: "own",
        about: "none of these: you answer each line",
        driver: "parport",
        pulse: USUAL,
        motors: &[],
        pins: &[],
        longest: LONGEST,
    },
    Board {
        name: "printer",
        about: "the VIA board of configs/printer: four inputs, four outputs, one motor on 6 and 5",
        driver: "viagpio",
        pulse: USUAL,
        motors: &[("6", "5", "")],
        pins: &[],
        longest: LONGEST,
    },
    Board {
        name: "gecko-g540",
        about: "four drives, 2/3 to 8/9; charge pump on 16, which wants a base period of 50 us at most (LinuxCNC's sample Gecko_540B4)",
        driver: "parport",
        pulse: ["5000", "5000", "10000", "10000"],
        motors: PAIRS,
        pins: &[("charge-pump", "16")],
        longest: 50_000.0,
    },
    Board {
        name: "xylotex",
        about: "Xylotex 8S-3: step and direction 2/3 to 8/9 (LinuxCNC's xylotex_pinout.hal)",
        driver: "parport",
        pulse: ["2000", "1000", "200", "200"],
        motors: PAIRS,
        pins: &[],
        longest: LONGEST,
    },
    Board {
        name: "sherline",
        about: "Sherline's drive: direction and step 2/3 to 8/9, slow pulses, e-stop on 10 (LinuxCNC's sample Sherline4Axis)",
        driver: "parport",
        pulse: ["22000", "22000", "100000", "100000"],
        motors: SWAPPED,
        pins: &[("estop", "10")],
        longest: LONGEST,
    },
    Board {
        name: "tb6560",
        about: "blue TB6560 board with three drives, each with an enable, spindle on 2 (LinuxCNC's preset)",
        driver: "parport",
        pulse: USUAL,
        motors: &[("1", "16", "4"), ("14", "7", "17"), ("3", "6", "5")],
        pins: &[("spindle", "2")],
        longest: LONGEST,
    },
    Board {
        name: "stepcraft",
        about: "Stepcraft: direction and step 2/3 to 8/9, spindle on 1, e-stop on 11, tool setter on 10",
        driver: "parport",
        pulse: USUAL,
        motors: SWAPPED,
        pins: &[("spindle", "1"), ("estop", "11"), ("setter", "10")],
        longest: LONGEST,
    },
];

/// Names of the boards.
pub(super) const NAMES: &[&str] =
    &["own", "printer", "gecko-g540", "xylotex", "sherline", "tb6560", "stepcraft"];

/// Returns the board of this name; the first for any other name.
pub(super) fn board(name: Option<&str>) -> Option<&'static Board> {
    BOARDS.iter().find(|b| Some(b.name) == name).or(BOARDS.first())
}

/// Returns what the board has for a key, or nothing.
pub(super) fn preset(board: &Board, key: &str) -> &'static str {
    let of_pulse = |name| {
        let n = ["length", "space", "hold", "setup"].iter().position(|n| *n == name);
        n.and_then(|n| board.pulse.get(n).copied()).unwrap_or_default()
    };
    let words: Vec<&str> = key.split('.').collect();
    match words.as_slice() {
        ["driver"] => board.driver,
        ["pulse", name] => of_pulse(*name),
        ["pins", name] => board.pins.iter().find(|(n, _)| n == name).map_or("", |(_, line)| *line),
        ["joint", n, name] => {
            let motor = n.parse().ok().and_then(|n: usize| board.motors.get(n));
            motor.map_or("", |(step, direction, enable)| match *name {
                "step" => step,
                "direction" => direction,
                "enable" => enable,
                _ => "",
            })
        }
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::{BOARDS, NAMES};

    #[test]
    fn each_board_has_its_name_in_the_list() {
        assert_eq!(BOARDS.iter().map(|b| b.name).collect::<Vec<_>>(), NAMES);
    }
}
