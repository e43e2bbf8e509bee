//! Assignment of joints to axis letters: the argument `coordinates=`.

use crate::model::{Joints, MAX_JOINTS};
use hal_component::{Error, Pose};

/// Axis letters, in the order of a pose.
const LETTERS: &str = "XYZABCUVW";

/// Requirements of a component on its letters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rule {
    /// Letters that must occur.
    pub(crate) required: &'static str,
    /// True if a letter may occur more than once.
    pub(crate) twice: bool,
    /// Maximum number of joints.
    pub(crate) most: usize,
}

/// Letter of each joint.
#[derive(Clone, Debug)]
pub(crate) struct Letters {
    of: Vec<usize>,
    first: [Option<usize>; 9],
}

impl Letters {
    /// Parses text such as `XYZBCW`, in either case; spaces are ignored.
    pub(crate) fn parse(text: &str, rule: Rule) -> Result<Self, Error> {
        let mut of = Vec::new();
        let mut first = [None; 9];
        for c in text.chars().filter(|c| *c != ' ') {
            let letter = LETTERS.chars().position(|l| l == c.to_ascii_uppercase());
            let Some(letter) = letter else {
                return Err(error(text, &format!("'{c}' is none of X Y Z A B C U V W")));
            };
            if let Some(place) = first.get_mut(letter) {
                if place.is_some() && !rule.twice {
                    return Err(error(text, &format!("'{c}' may occur only once")));
                }
                place.get_or_insert(of.len());
            }
            of.push(letter);
        }
        if of.is_empty() {
            return Err(error(text, "they name no joint, write for example XYZ"));
        }
        if of.len() > rule.most {
            let (n, most) = (of.len(), rule.most);
            return Err(error(text, &format!("they name {n} joints, at most {most} are possible")));
        }
        for c in rule.required.chars() {
            let letter = LETTERS.chars().position(|l| l == c);
            if letter.is_none_or(|l| !of.contains(&l)) {
                return Err(error(text, &format!("{c} is missing, {} are needed", rule.required)));
            }
        }
        Ok(Self { of, first })
    }

    pub(crate) const fn joints(&self) -> usize {
        self.of.len()
    }

    pub(crate) fn joint_of(&self, letter: usize) -> Option<usize> {
        self.first.get(letter).copied().flatten()
    }

    /// Copies joints to the pose letters that they drive; other letters keep the guess. Realtime.
    pub(crate) fn forward(&self, joints: &Joints, guess: &Pose) -> Pose {
        let mut pose = *guess;
        for (place, joint) in pose.iter_mut().zip(self.first) {
            if let Some(value) = joint.and_then(|j| joints.get(j)) {
                *place = *value;
            }
        }
        pose
    }

    /// Copies pose letters to the joints that follow them; other joints keep the guess. Realtime.
    pub(crate) fn inverse(&self, pose: &Pose, guess: &Joints) -> Joints {
        let mut joints = *guess;
        for (joint, letter) in joints.iter_mut().zip(&self.of) {
            if let Some(value) = pose.get(*letter) {
                *joint = *value;
            }
        }
        joints
    }
}

fn error(text: &str, why: &str) -> Error {
    Error::new(format!("coordinates '{text}': {why}"))
}

/// Rule without required letters: up to the maximum of joints, and each letter any number of times.
pub(crate) const ANY: Rule = Rule { required: "", twice: true, most: MAX_JOINTS };

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wrong_is_named() {
        let five = Rule { required: "XYZBCW", ..ANY };
        let six = Rule { twice: false, most: 6, ..ANY };
        for (text, rule, why) in [
            ("xyzq", ANY, "coordinates 'xyzq': 'q' is none of X Y Z A B C U V W"),
            (" ", ANY, "coordinates ' ': they name no joint, write for example XYZ"),
            ("XYZBC", five, "coordinates 'XYZBC': W is missing, XYZBCW are needed"),
            ("XYZABX", six, "coordinates 'XYZABX': 'X' may occur only once"),
            ("XYZABCU", six, "coordinates 'XYZABCU': they name 7 joints, at most 6 are possible"),
        ] {
            assert_eq!(Letters::parse(text, rule).unwrap_err().text(), Some(why));
        }
        let letters = Letters::parse("xyzbcwyv", five).unwrap();
        assert_eq!(letters.joints(), 8);
        assert_eq!([1, 7, 3].map(|l| letters.joint_of(l)), [Some(1), Some(7), None]);
    }
}
