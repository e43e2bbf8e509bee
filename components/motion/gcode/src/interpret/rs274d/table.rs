//! The commands of RS274-D, and the names of commands that this dialect does not have.

/// A command that takes words.
pub(super) struct Command {
    /// Ten times the G code.
    pub(super) code: u16,
    pub(super) name: &'static str,
    /// The words in lower case, and as a message shows them.
    pub(super) words: &'static [u8],
    pub(super) shown: &'static str,
}

/// The commands that take words.
pub(super) const COMMANDS: [Command; 8] = [
    Command { code: 0, name: "G00", words: b"xyzf", shown: "X Y Z F" },
    Command { code: 10, name: "G01", words: b"xyzf", shown: "X Y Z F" },
    Command { code: 20, name: "G02", words: b"xyzijkrf", shown: "X Y Z I J K R F" },
    Command { code: 30, name: "G03", words: b"xyzijkrf", shown: "X Y Z I J K R F" },
    Command { code: 40, name: "G04", words: b"xp", shown: "X or P" },
    Command { code: 280, name: "G28", words: b"xyz", shown: "X Y Z" },
    Command { code: 290, name: "G29", words: b"xyz", shown: "X Y Z" },
    Command { code: 920, name: "G92", words: b"xyz", shown: "X Y Z" },
];

/// G20, G21, G90 and G91, which take no words.
pub(super) const MODES: [u16; 4] = [200, 210, 900, 910];

/// Returns the meaning of a G code of RS274-D that this dialect does not have.
pub(super) fn meaning(code: f64) -> Option<&'static str> {
    const LACKED: [(f64, &str); 19] = [
        (17.0, "plane XY"),
        (18.0, "plane XZ"),
        (19.0, "plane YZ"),
        (22.0, "stored stroke limits on"),
        (23.0, "stored stroke limits off"),
        (40.0, "cutter compensation off"),
        (41.0, "cutter compensation left"),
        (42.0, "cutter compensation right"),
        (43.0, "tool length offset"),
        (44.0, "tool length offset, negative"),
        (49.0, "tool length offset off"),
        (50.0, "scaling off"),
        (51.0, "scaling"),
        (54.0, "coordinate system 1"),
        (55.0, "coordinate system 2"),
        (56.0, "coordinate system 3"),
        (57.0, "coordinate system 4"),
        (58.0, "coordinate system 5"),
        (59.0, "coordinate system 6"),
    ];
    LACKED.iter().find(|(c, _)| *c == code).map(|(_, m)| *m)
}
