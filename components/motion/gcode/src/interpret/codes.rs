//! The tables of G and M codes with their modal groups.

use crate::error::Problem;

/// A modal group of G codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GGroup {
    /// Codes for one block.
    Once,
    /// Motion.
    Motion,
    /// Plane.
    Plane,
    /// G90 and G91.
    Distance,
    /// G90.1 and G91.1.
    IjkDistance,
    /// G93 to G95.
    FeedMode,
    /// G20 and G21.
    Unit,
    /// G40 to G42.1.
    Compensation,
    /// G43 to G49.
    ToolOffset,
    /// G98 and G99.
    Retract,
    /// G54 to G59.3.
    System,
    /// G61 to G64.
    Path,
    /// G96 and G97.
    SpindleMode,
    /// G7 and G8.
    Lathe,
}

impl GGroup {
    /// The number of groups.
    pub const COUNT: usize = 14;
}

/// A modal group of M codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MGroup {
    /// M0, M1, M2, M30, M60.
    Stop,
    /// M62 to M68.
    Io,
    /// M6 and M61.
    Tool,
    /// M3, M4, M5, M19.
    Spindle,
    /// M7 to M9.
    Coolant,
    /// M48 to M53.
    Override,
    /// M100 to M199.
    User,
    /// M70 to M73.
    Save,
    /// M98 and M99.
    Call,
}

impl MGroup {
    /// All groups.
    pub const ALL: [Self; Self::COUNT] = [
        Self::Stop,
        Self::Io,
        Self::Tool,
        Self::Spindle,
        Self::Coolant,
        Self::Override,
        Self::User,
        Self::Save,
        Self::Call,
    ];
    /// The number of groups.
    pub const COUNT: usize = 9;
}

/// Returns ten times the number of a G code.
pub fn g_code(value: f64) -> Result<u16, Problem> {
    let tenfold = libm::floor(10.0 * value + 0.5);
    if value < 0.0 {
        return Err(Problem::NegativeG);
    }
    // The largest code is 99.9.
    if !(0.0..=999.0).contains(&tenfold) {
        return Err(Problem::GRange { code: value });
    }
    if libm::fabs(tenfold - 10.0 * value) > 0.0001 * 10.0 {
        return Err(Problem::UnknownG { code: value });
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 999")]
    Ok(tenfold as u16)
}

/// Returns the group of a G code, given as ten times its number.
pub fn g_group(code: u16) -> Option<GGroup> {
    Some(match code {
        40 | 100 | 280 | 281 | 300 | 301 | 520 | 530 | 920 | 921 | 922 | 923 => GGroup::Once,
        0
        | 10
        | 20
        | 30
        | 50..=53
        | 330
        | 331
        | 382..=385
        | 700
        | 710..=712
        | 720..=722
        | 730
        | 740
        | 760
        | 800
        | 810
        | 820
        | 830
        | 840
        | 850
        | 860
        | 870
        | 880
        | 890 => GGroup::Motion,
        170 | 171 | 180 | 181 | 190 | 191 => GGroup::Plane,
        900 | 910 => GGroup::Distance,
        901 | 911 => GGroup::IjkDistance,
        930 | 940 | 950 => GGroup::FeedMode,
        200 | 210 => GGroup::Unit,
        400 | 410 | 411 | 420 | 421 => GGroup::Compensation,
        430..=432 | 490 => GGroup::ToolOffset,
        980 | 990 => GGroup::Retract,
        540 | 550 | 560 | 570 | 580 | 590..=593 => GGroup::System,
        610 | 611 | 640 => GGroup::Path,
        960 | 970 => GGroup::SpindleMode,
        70 | 80 => GGroup::Lathe,
        _ => return None,
    })
}

/// Returns the number of an M code and its group.
pub fn m_code(value: f64) -> Result<(u16, MGroup), Problem> {
    let code = crate::text::evaluate::integer(value)?;
    if code < 0 {
        return Err(Problem::NegativeM);
    }
    if code > 199 {
        return Err(Problem::MTooLarge { code });
    }
    let group = match code {
        0 | 1 | 2 | 30 | 60 => MGroup::Stop,
        3 | 4 | 5 | 19 => MGroup::Spindle,
        6 | 61 => MGroup::Tool,
        7..=9 => MGroup::Coolant,
        48..=53 => MGroup::Override,
        62..=68 => MGroup::Io,
        70..=73 => MGroup::Save,
        98 | 99 => MGroup::Call,
        100..=199 => MGroup::User,
        _ => return Err(Problem::UnknownM { code }),
    };
    Ok((u16::try_from(code).unwrap_or(0), group))
}

/// Returns a motion code as text, as messages show it.
pub fn shown(code: u16) -> &'static str {
    match code {
        0 => "g0",
        10 => "g1",
        20 => "g2",
        30 => "g3",
        50 => "g5",
        51 => "g5.1",
        52 => "g5.2",
        330 => "G33",
        331 => "G33.1",
        730 => "G73",
        740 => "G74",
        760 => "G76",
        810 => "G81",
        820 => "G82",
        830 => "G83",
        840 => "G84",
        850 => "G85",
        860 => "G86",
        870 => "G87",
        880 => "G88",
        890 => "G89",
        382 => "G38.2",
        383 => "G38.3",
        384 => "G38.4",
        385 => "G38.5",
        _ => "this code",
    }
}
