//! Realtime. Assignment of joints to axis letters.

use hal_component::Pose;

/// Axis letters, in the order of a pose.
const LETTERS: &str = "XYZABCUVW";
/// Maximum number of joints.
const MAX_JOINTS: usize = 16;

/// Letter of each joint.
#[derive(Clone, Debug)]
pub(crate) struct Map {
    letters: Vec<usize>,
    /// First joint of each letter, or [`NONE`].
    first: [u8; 9],
}

/// Number of no joint.
const NONE: u8 = u8::MAX;

impl Map {
    /// Parses text such as `XYYZ`.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let mut letters = Vec::new();
        let mut first = [NONE; 9];
        for c in text.chars().filter(|c| *c != ' ') {
            let letter = LETTERS.chars().position(|l| l == c.to_ascii_uppercase());
            let Some(letter) = letter else {
                return Err(format!("coordinates '{text}': '{c}' is none of X Y Z A B C U V W"));
            };
            if let Some(place) = first.get_mut(letter).filter(|place| **place == NONE) {
                *place = u8::try_from(letters.len()).unwrap_or(NONE);
            }
            letters.push(letter);
        }
        match letters.len() {
            0 => Err(format!("coordinates '{text}' name no joint, write for example XYZ")),
            1..=MAX_JOINTS => Ok(Self { letters, first }),
            n => Err(format!(
                "coordinates '{text}' name {n} joints, at most {MAX_JOINTS} are possible"
            )),
        }
    }

    pub(crate) const fn joints(&self) -> usize {
        self.letters.len()
    }

    pub(crate) fn joint_of(&self, letter: usize) -> Option<usize> {
        self.first.get(letter).filter(|joint| **joint != NONE).map(|joint| usize::from(*joint))
    }

    /// Copies joints to the pose; letters that no joint drives keep their values.
    pub(crate) fn forward(&self, joints: &[f64], pose: &mut Pose) {
        for (place, joint) in pose.iter_mut().zip(&self.first) {
            // There are at most sixteen joints, so that none has the number of no joint.
            if let Some(value) = joints.get(usize::from(*joint)) {
                *place = *value;
            }
        }
    }

    /// Copies the pose to the joints; joints beyond the map keep their values.
    pub(crate) fn inverse(&self, pose: &Pose, joints: &mut [f64]) {
        for (joint, letter) in joints.iter_mut().zip(&self.letters) {
            if let Some(value) = pose.get(*letter) {
                *joint = *value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses() {
        for (text, letters) in [
            ("xyz", &[0, 1, 2][..]),
            ("X Y Z", &[0, 1, 2]),
            ("XYYZ", &[0, 1, 1, 2]),
            ("zw", &[2, 8]),
            ("XYZABCUVWXYZABCU", &[0, 1, 2, 3, 4, 5, 6, 7, 8, 0, 1, 2, 3, 4, 5, 6]),
        ] {
            assert_eq!(Map::parse(text).unwrap().letters, letters, "{text}");
        }
        assert!(Map::parse(" ").is_err());
        assert_eq!(Map::parse("XYYZ").unwrap().joint_of(1), Some(1));
        assert_eq!(Map::parse("XYYZ").unwrap().joint_of(3), None);
    }
}
