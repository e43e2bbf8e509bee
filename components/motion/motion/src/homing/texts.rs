//! Messages about a homing module of a user, made as it is loaded.

use hal_component::lasting;

/// Messages for the operator, with the name of the module, and `{}` for the joint.
#[derive(Debug)]
pub(crate) struct Texts {
    pub(crate) not_finite: &'static str,
    pub(crate) inconsistent: &'static str,
    pub(crate) unasked: &'static str,
    pub(crate) unfinished: &'static str,
}

impl Texts {
    /// Makes the messages, which live as long as the process.
    pub(crate) fn new(name: &str) -> Self {
        let name = name.replace(['{', '}'], "");
        let text = |what: &str| lasting(format!("joint {{}}: the homing module '{name}' {what}"));
        Self {
            not_finite: text("wrote a number that is not finite; the machine is switched off"),
            inconsistent: text(
                "changed pos_cmd, pos_fb, motor_offset and curr_pos in a way that would make the joint \
                 jump, or wrote a velocity below 0; the machine is switched off",
            ),
            unasked: text(
                "moves or renames the joint without motion.home; the machine is switched off",
            ),
            unfinished: text("ended without homing it"),
        }
    }
}
