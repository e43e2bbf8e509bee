//! Pseudo-random numbers, the same in every run.

pub use hal_bench::Random;

/// Returns a text for the argument of a command. A file of this name cannot be written: it would be where the test runs.
pub fn text_argument(name: &str, random: &mut Random) -> &'static str {
    if name == "file" {
        return "/dev/null/none";
    }
    random.one(&["x", "y", "all", "0", "free", "teleop", "coord"])
}
