//! A sample's ring, mapped into this process: records with number, time and values.

use crate::{ChannelInfo, SampleInfo, Value, stream::Mapping};
use hal_abi::{Consumer, Got};
use std::os::fd::OwnedFd;

/// Which sample was taken, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// Its number, from 0; those that were lost are counted too.
    pub number: u64,
    /// Machine time of its cycle, in nanoseconds.
    pub time: i64,
    /// How many samples were lost between the one before and this one.
    pub lost: u64,
}

/// The reading end of a sample.
#[derive(Debug)]
pub struct Samples {
    info: SampleInfo,
    consumer: Consumer,
    next: u64,
    lost: u64,
    // Last: the consumer points into it.
    #[expect(dead_code, reason = "held so that the ring stays mapped")]
    mapping: Mapping,
}

impl Samples {
    /// Maps the ring that came with this description.
    ///
    /// # Errors
    /// What came is not that ring.
    pub fn map(fd: &OwnedFd, info: SampleInfo) -> Result<Self, String> {
        let width = u32::try_from(info.channels.len() + 1).map_err(|e| e.to_string())?;
        let depth = info.depth.checked_add(1).ok_or("the ring is too long")?;
        let mapping = Mapping::new(fd, depth, width)?;
        // SAFETY: the mapping lives as long as this; the engine admits one program.
        let consumer = unsafe { Consumer::new(mapping.ring(), depth, width) };
        Ok(Self { info, consumer, next: 0, lost: 0, mapping })
    }

    /// What is sampled, and when.
    #[must_use]
    pub const fn info(&self) -> &SampleInfo {
        &self.info
    }

    /// What each record has, in order.
    #[must_use]
    pub fn channels(&self) -> &[ChannelInfo] {
        &self.info.channels
    }

    /// Takes the oldest sample, its values into `out`; `None` when there is none.
    pub fn take(&mut self, out: &mut Vec<Value>) -> Option<Stamp> {
        out.clear();
        let (consumer, channels) = (&mut self.consumer, &self.info.channels);
        consumer.follow();
        let mut time = 0;
        let got = consumer.take(|i, bits| match i.checked_sub(1).map(|i| channels.get(i)) {
            None => time = bits.cast_signed(),
            Some(Some(channel)) => out.push(Value::from_bits(channel.ty, bits)),
            Some(None) => {}
        });
        self.stamp(got, time)
    }

    /// As [`Self::take`], with the values' bits.
    pub fn take_bits(&mut self, out: &mut Vec<u64>) -> Option<Stamp> {
        out.clear();
        self.consumer.follow();
        let mut time = 0;
        let got = self.consumer.take(|i, bits| match i {
            0 => time = bits.cast_signed(),
            _ => out.push(bits),
        });
        self.stamp(got, time)
    }

    const fn stamp(&mut self, got: Got, time: i64) -> Option<Stamp> {
        let Got::Sample(n) = got else { return None };
        // The ring counts from 1.
        let number = n.wrapping_sub(1);
        let lost = number.wrapping_sub(self.next);
        self.next = n;
        self.lost = self.lost.wrapping_add(lost);
        Some(Stamp { number, time, lost })
    }

    /// How many samples wait.
    #[must_use]
    pub fn waiting(&self) -> u32 {
        self.consumer.waiting()
    }

    /// How many samples were lost before the last one that was taken.
    #[must_use]
    pub const fn lost(&self) -> u64 {
        self.lost
    }

    /// Whether nothing waits and nothing more will come. The engine says why:
    /// [`crate::Request::SampleState`]. An engine that has gone says nothing.
    #[must_use]
    pub fn is_over(&self) -> bool {
        // In this order: what was written before the end is seen.
        self.consumer.lost_and_closed().1 && self.consumer.waiting() == 0
    }

    /// How many samples were lost after the last one that was taken; right when [`Self::is_over`].
    #[must_use]
    pub fn lost_at_end(&self) -> u64 {
        self.consumer.lost_and_closed().0.saturating_sub(self.lost)
    }
}
