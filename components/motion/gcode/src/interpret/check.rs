//! Checks of a block before it is run: which motion it makes, and words that nothing uses.

use super::{
    Run,
    block::Block,
    codes::{GGroup, MGroup},
};
use crate::{
    canon::Plane,
    error::Problem,
    remap::{Code, Remap},
    text::evaluate::integer,
};

impl Run<'_> {
    /// Finds the motion of a block and checks its words.
    pub(crate) fn prepare(&mut self, block: &mut Block) -> Result<(), Problem> {
        // G7 and G8 hold for the X of their own line.
        let diameter = match block.g(GGroup::Lathe) {
            None => self.state.modal.diameter,
            Some(code) => code == 70,
        };
        if diameter && let Some(x) = block.get(b'x') {
            block.set(b'x', Some(x / 2.0));
        }
        self.check_axes(block)?;
        let motion = find_motion(block, self.state.modal.motion)?;
        block.motion = motion;
        self.check_polar(block)?;
        if block.g(GGroup::Once) == Some(530) && !matches!(motion, Some(0 | 10)) {
            return Err(Problem::G53Motion);
        }
        if let (Some(20 | 30), Some(turns)) = (motion, block.get(b'p')) {
            let turns = integer(turns).map_err(|_| Problem::TurnsNotInteger)?;
            if turns < 1 {
                return Err(Problem::ArcTurns);
            }
        }
        if block.m_count() > 4 {
            return Err(Problem::TooManyM);
        }
        self.check_words(block)
    }

    /// Checks that polar words stand with a motion in the plane XY that they can give an end to.
    fn check_polar(&self, block: &Block) -> Result<(), Problem> {
        if !block.has_any(b"@^") {
            return Ok(());
        }
        if self.state.modal.plane != Plane::Xy {
            return Err(Problem::PolarPlane);
        }
        for (word, letter) in [(b'x', 'X'), (b'y', 'Y')] {
            if block.has(word) {
                return Err(Problem::PolarAndAxis { letter });
            }
        }
        if block.g(GGroup::Once) == Some(530) {
            return Err(Problem::PolarG53);
        }
        if matches!(block.motion, None | Some(800)) {
            return Err(Problem::PolarNoMotion);
        }
        Ok(())
    }

    pub(super) fn check_axes(&self, block: &Block) -> Result<(), Problem> {
        for axis in crate::axis::Axis::ALL {
            let letter = axis.letter() as u8;
            if block.has(letter) && !self.state.settings.axes.has(axis) {
                return Err(Problem::of_byte(Some(letter)));
            }
        }
        Ok(())
    }

    /// Tells whether a code of the line is remapped.
    fn has_remap(&self, b: &Block) -> bool {
        let on_line = |remap: &Remap| match remap.code {
            Code::G(code) => b.motion == Some(code),
            Code::M(code) => MGroup::ALL.iter().any(|g| b.m(*g) == Some(code)),
            Code::Word(letter) => b.has(letter),
        };
        self.state.settings.remaps.iter().any(on_line)
    }

    fn check_words(&self, b: &Block) -> Result<(), Problem> {
        let motion = b.motion;
        let once = b.g(GGroup::Once);
        let io = b.m(MGroup::Io);
        let save = b.m(MGroup::User).is_some() || b.m(MGroup::Call).is_some();
        let cycle = matches!(motion, Some(730 | 740 | 760 | 810..=890));
        let profile = matches!(motion, Some(700..=722));
        let comp = b.g(GGroup::Compensation).is_some_and(|c| c != 400);
        let arc = matches!(motion, Some(20 | 30));
        let g10 = once == Some(100);
        // A remapped code takes what it wants of the words.
        let remapped = self.has_remap(b);
        let refuse = |letter: u8, with: &'static str, allowed: bool| {
            if b.has(letter) && !allowed && !remapped {
                let letter = char::from(letter.to_ascii_uppercase());
                return Err(Problem::UnusedWord { letter, with });
            }
            Ok(())
        };
        let spline = matches!(motion, Some(50..=53));
        let spindle = b.m(MGroup::Spindle);
        let g96 = b.g(GGroup::SpindleMode) == Some(960);
        refuse(
            b'd',
            "G41, G41.1, G42, G42.1, G71, G71.1, G71.2 or G96 to use it",
            comp || g96 || profile,
        )?;
        refuse(
            b'e',
            "G70, G76, M66, M67 or M68 to use it",
            matches!(io, Some(66..=68)) || motion == Some(760) || profile,
        )?;
        refuse(
            b'h',
            "G43 or G76 to use it",
            b.g(GGroup::ToolOffset).is_some_and(|c| c != 490) || motion == Some(760),
        )?;
        let ij = arc || spline || matches!(motion, Some(870 | 760)) || profile || g10;
        refuse(
            b'i',
            "G2, G3, G5, G5.1, G10, G33.1, G76, or G87 to use it",
            ij || motion == Some(331),
        )?;
        refuse(b'j', "G2, G3, G5, G5.1, G10, G76 or G87 to use it", ij)?;
        let k = arc || matches!(motion, Some(330 | 331 | 760 | 870)) || profile;
        refuse(b'k', "G2, G3, G33, G33.1, G76, or G87 to use it", k)?;
        let l = cycle || g10 || motion == Some(52) || io == Some(66) || comp || save || profile;
        refuse(
            b'l',
            "G10, cutter compensation, canned cycle, digital/analog input, or NURBS code",
            l,
        )?;
        let override_code = matches!(b.m(MGroup::Override), Some(50..=53));
        let dwells = matches!(motion, Some(740 | 760 | 820 | 840 | 860 | 880 | 890));
        let p = dwells
            || g10
            || once == Some(40)
            || arc
            || spline
            || profile
            || save
            || io.is_some()
            || override_code
            || b.g(GGroup::Path) == Some(640)
            || spindle == Some(19);
        refuse(
            b'p',
            "G2 G3 G4 G10 G64 G5 G5.2 G76 G82 G86 G88 G89 or M50 M51 M52 M53 M62 M63 M64 M65 M66 or user M code to use it",
            p,
        )?;
        let q = matches!(motion, Some(50 | 830 | 730 | 760))
            || g10
            || b.g(GGroup::Path) == Some(640)
            || profile
            || save
            || matches!(io, Some(66..=68))
            || b.m(MGroup::Tool) == Some(61)
            || spindle == Some(19);
        refuse(
            b'q',
            "G5, G10, G64, G73, G76, G83, M19, M66, M67, M68 or user M code that uses it",
            q,
        )?;
        let r = arc || cycle || g10 || profile || spindle == Some(19);
        refuse(b'r', "G code that uses it", r)
    }
}

/// Returns the motion of a block.
fn find_motion(b: &Block, modal: u16) -> Result<Option<u16>, Problem> {
    let axes = b.has_axes();
    let once = b.g(GGroup::Once);
    let once_uses_axes = matches!(once, Some(100 | 280 | 300 | 520 | 920))
        || matches!(b.g(GGroup::ToolOffset), Some(431 | 432));
    let straight = b.has_any(b"xyzabcuvw");
    if matches!(once, Some(520 | 920)) && !axes || once == Some(520) && !straight {
        return Err(Problem::AxesMissingG52OrG92);
    }
    if let Some(motion) = b.g(GGroup::Motion) {
        if motion == 800 {
            if axes && !once_uses_axes {
                return Err(Problem::AxisWithG80);
            }
            return Ok(Some(motion));
        }
        if once_uses_axes {
            return Err(Problem::TwoAxisCodes);
        }
        let remapped = super::codes::g_group(motion).is_none();
        let free = remapped || matches!(motion, 0 | 10 | 20 | 30 | 52 | 53 | 700..=722);
        if !axes && !free {
            return Err(Problem::AxesMissing);
        }
        return Ok(Some(motion));
    }
    let centre = matches!(modal, 20 | 30) && b.has_any(b"ijk");
    if once_uses_axes || !(axes || centre) {
        return Ok(None);
    }
    if modal == 800 {
        return Err(Problem::AxisWithoutCode);
    }
    Ok(Some(modal))
}
