//! Realtime. States of the plasma cutter, and reasons for the end of a cut.

/// States of the plasma cutter; the numbers are the values of `state-out`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum State {
    Idle = 0,
    ProbeHeight = 1,
    ProbeDown = 2,
    ProbeUp = 3,
    ZeroHeight = 4,
    PierceHeight = 5,
    TorchOn = 6,
    ArcOk = 7,
    PierceDelay = 8,
    PuddleJump = 9,
    CutHeight = 10,
    Cut = 11,
    CutByHand = 12,
    PauseAtEnd = 13,
    SafeHeight = 14,
    MaxHeight = 15,
    EndCut = 16,
    EndJob = 17,
    TorchPulse = 18,
    PausedMotion = 19,
    OhmicTest = 20,
    ProbeTest = 21,
    Scribing = 22,
    ConsumablesOut = 23,
    ConsumablesBack = 24,
    RecoveryOut = 25,
    RecoveryBack = 26,
}

/// Reasons for the end of a cut; the numbers are the values of `stop-type-out`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stop {
    None = 0,
    Job = 1,
    Cut = 2,
    Fault = 3,
}
