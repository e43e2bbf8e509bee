//! Events of the kernel's interface.

/// Kinds of events.
pub(crate) mod kind {
    pub(crate) const SYN: u16 = 0;
    pub(crate) const KEY: u16 = 1;
    pub(crate) const REL: u16 = 2;
    pub(crate) const ABS: u16 = 3;
    pub(crate) const LED: u16 = 0x11;
}

/// Code of the event that ends a packet.
pub(crate) const REPORT: u16 = 0;
/// Code of the event that says that events were lost.
pub(crate) const DROPPED: u16 = 3;

/// Bytes of a time, which begins an event.
const TIME: usize = 2 * size_of::<usize>();
/// Bytes of an event.
pub(crate) const EVENT_SIZE: usize = TIME + 8;

/// Event of a device, without its time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct InputEvent {
    pub(crate) kind: u16,
    pub(crate) code: u16,
    pub(crate) value: i32,
}

impl InputEvent {
    /// End of a packet.
    pub(crate) const REPORT: Self = Self { kind: kind::SYN, code: REPORT, value: 0 };

    /// Returns the events in bytes from the kernel; what is left at the end is no event.
    pub(crate) fn decode(bytes: &[u8]) -> impl Iterator<Item = Self> {
        bytes.chunks_exact(EVENT_SIZE).filter_map(|event| {
            let (head, value) = event.get(TIME..)?.split_first_chunk::<4>()?;
            let [a, b, c, d] = *head;
            Some(Self {
                kind: u16::from_ne_bytes([a, b]),
                code: u16::from_ne_bytes([c, d]),
                value: i32::from_ne_bytes(value.try_into().ok()?),
            })
        })
    }

    /// Returns the event as the kernel reads it.
    pub(crate) fn encode(self) -> [u8; EVENT_SIZE] {
        let mut bytes = [0; EVENT_SIZE];
        let fields = self.kind.to_ne_bytes().into_iter().chain(self.code.to_ne_bytes());
        let fields = fields.chain(self.value.to_ne_bytes());
        for (to, from) in bytes.iter_mut().skip(TIME).zip(fields) {
            *to = from;
        }
        bytes
    }
}
