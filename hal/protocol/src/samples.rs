//! A sample's ring, mapped into this process: records with number, time and values.

use crate::{ChannelInfo, SampleInfo, Value, stream::Mapping};
use hal_abi::{Consumer, Got};
use std::os::fd::OwnedFd;

/// Number and time of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// Sample number, from 0. Lost samples are counted too.
    pub number: u64,
    /// Machine time of the cycle, in nanoseconds.
    pub time: i64,
    /// Number of samples lost between the previous one and this one.
    pub lost: u64,
}

/// The reading end of a sample.
#[derive(Debug)]
pub struct Samples {
    info: SampleInfo,
    consumer: Consumer,
    next: u64,
    lost: u64,
    // Last field, because the consumer points into it and must be dropped first.
    #[expect(dead_code, reason = "held so that the ring stays mapped")]
    mapping: Mapping,
}

impl Samples {
    /// Maps the ring that the engine sent with this description.
    ///
    /// # Errors
    /// The file descriptor is not such a ring.
    pub fn map(fd: &OwnedFd, info: SampleInfo) -> Result<Self, String> {
        let width = u32::try_from(info.channels.len() + 1).map_err(|e| e.to_string())?;
        let depth = info.depth.checked_add(1).ok_or("the ring is too long")?;
        let mapping = Mapping::new(fd, depth, width)?;
        // SAFETY: the mapping lives as long as `Self`; the engine admits only one program to the
        // ring.
        let consumer = unsafe { Consumer::new(mapping.ring(), depth, width) };
        Ok(Self { info, consumer, next: 0, lost: 0, mapping })
    }

    /// Returns the description of the sample.
    #[must_use]
    pub const fn info(&self) -> &SampleInfo {
        &self.info
    }

    /// Returns the values of a record, in order.
    #[must_use]
    pub fn channels(&self) -> &[ChannelInfo] {
        &self.info.channels
    }

    /// Takes the oldest sample and puts its values into `out`. Returns `None` if there is none.
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

    /// As [`Self::take`], with the raw bits of the values.
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
        // The ring counts from 1, samples from 0.
        let number = n.wrapping_sub(1);
        let lost = number.wrapping_sub(self.next);
        self.next = n;
        self.lost = self.lost.wrapping_add(lost);
        Some(Stamp { number, time, lost })
    }

    /// Returns the number of samples waiting in the ring.
    #[must_use]
    pub fn waiting(&self) -> u32 {
        self.consumer.waiting()
    }

    /// Returns the number of samples lost before the last one that was taken.
    #[must_use]
    pub const fn lost(&self) -> u64 {
        self.lost
    }

    /// Returns whether the ring is empty and closed. [`crate::Request::SampleState`] returns the
    /// reason, as long as the engine still runs.
    #[must_use]
    pub fn is_over(&self) -> bool {
        // This order matters: a record written before the ring was closed is then seen.
        self.consumer.lost_and_closed().1 && self.consumer.waiting() == 0
    }

    /// Returns the number of samples lost after the last one that was taken. Valid only when
    /// [`Self::is_over`].
    #[must_use]
    pub fn lost_at_end(&self) -> u64 {
        self.consumer.lost_and_closed().0.saturating_sub(self.lost)
    }
}
