//! The scripts with which shells complete.

const BASH: &str = include_str!("shell/halcmd.bash");
const ZSH: &str = include_str!("shell/_halcmd");
const FISH: &str = include_str!("shell/halcmd.fish");

/// The supported shells and their files.
pub(crate) const SHELLS: &[(&str, &str)] = &[("bash", BASH), ("zsh", ZSH), ("fish", FISH)];

/// Returns the script with which a shell completes the programs.
#[must_use]
pub fn script(shell: &str) -> Option<&'static str> {
    SHELLS.iter().find(|(name, _)| *name == shell).map(|(_, text)| *text)
}
