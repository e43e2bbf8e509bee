//! Devices that are reached by packets.

use crate::Lost;
use core::time::Duration;

/// Realtime. Exchange of packets with one device.
///
/// Real devices, simulated ones and recordings implement it; a driver does not know which it has.
pub trait Exchange: Send + Sync {
    /// Sends one packet. Never waits.
    ///
    /// # Errors
    /// The device or the way to it does not take packets.
    fn send(&self, packet: &[u8]) -> Result<(), Lost>;

    /// Takes the oldest packet that has come, and waits for one at most this long. Returns its length, which may be
    /// that of a packet which was longer than `into`; 0 if no packet came.
    ///
    /// # Errors
    /// The device or the way to it does not answer any more.
    fn receive(&self, into: &mut [u8], within: Duration) -> Result<usize, Lost>;

    /// Lets the time of a simulated device go on to this moment, in nanoseconds of the machine's clock.
    fn advance(&self, _now_ns: i64) {}
}
