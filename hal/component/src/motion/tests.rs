//! The service, from the side of its users.

use super::{
    Motion, MotionEnd, MotionRef, MotionRefusal, MotionSource, MotionToken, Offered, StopEpoch,
    table,
};
use crate::{
    Error, MotionStatus, TicketHandle, Touch, Uses,
    abi::{self, MotionAnswer, MotionCommand, Record, Status, Str, motion_kind, motion_source},
    service::{self, Found},
};
use std::sync::{
    Arc, Mutex,
    atomic::{AtomicBool, AtomicU32, Ordering::Relaxed},
};

/// Motion controller that notes what it receives.
#[derive(Clone, Default)]
struct Fake {
    got: Arc<Mutex<Vec<(MotionSource, u32, TicketHandle)>>>,
    room: Arc<AtomicU32>,
    claimed: Arc<AtomicBool>,
    /// Handles of refused commands, which a controller need not keep, but may.
    refused: Arc<Mutex<Vec<TicketHandle>>>,
}

impl Touch for Fake {
    fn touch(&self, _: &mut Uses) {}
}

impl Motion for Fake {
    fn push(
        &self,
        source: MotionSource,
        c: &MotionCommand,
        end: TicketHandle,
    ) -> Result<(), Error> {
        match c.kind {
            motion_kind::JOG => {
                self.refused.lock().unwrap().push(end);
                return Err(Error::new(format!("velocity is {}", c.speed)));
            }
            motion_kind::MOVE if self.room() == 0 => return Err(Error::again("full")),
            motion_kind::HOME => panic!("planted"),
            _ => {}
        }
        self.got.lock().unwrap().push((source, c.kind, end));
        Ok(())
    }
    fn room(&self) -> u32 {
        self.room.load(Relaxed)
    }
    fn claim(&self, on: bool) {
        self.claimed.store(on, Relaxed);
    }
    fn setting(&self, c: &MotionCommand) -> Result<f64, Error> {
        if c.setting == 2 { Ok(7.5) } else { Err(Error::new("none")) }
    }
    fn epoch(&self) -> u64 {
        9
    }
    fn status(&self) -> Option<MotionStatus> {
        let mut number = 0;
        Some(crate::Plain::load(&mut || {
            number += 1;
            number
        }))
    }
}

/// A service, freed at the end of a test.
struct Service {
    spec: abi::ServiceSpec,
    table: abi::Motion,
    motion: MotionRef,
    fake: Fake,
}

impl Service {
    fn new() -> Self {
        let fake = Fake::default();
        fake.room.store(10, Relaxed);
        let spec = service::offer(Offered::new(fake.clone()), table::<Fake>(), &[]);
        // SAFETY: the table lives until the service is dropped.
        let found = unsafe { Found::read(spec.table, Vec::new()) }.unwrap();
        Self { spec, table: found.table, motion: MotionRef(found), fake }
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        let free = self.spec.free.unwrap();
        // SAFETY: nothing uses the service any more.
        unsafe { free(self.spec.state) };
    }
}

#[test]
fn a_command_ends_as_the_controller_says() {
    let service = Service::new();
    let motion = &service.motion;
    let task = motion.acquire("task").unwrap();
    let enable = MotionCommand::new(motion_kind::ENABLE);
    let ids = [(); 3].map(|()| motion.push(task, &enable).unwrap());
    assert!(ids[0] < ids[1] && ids[1] < ids[2]);
    let got = service.fake.got.lock().unwrap();
    got[0].2.done();
    got[1].2.fail_with("joint {} is locked", &[2.0]);
    let ends = ids.map(|id| motion.poll(id));
    let failed = MotionEnd::Failed("joint 2 is locked".to_owned());
    assert_eq!(ends, [MotionEnd::Done, failed, MotionEnd::Pending]);
    assert_eq!(motion.poll(super::MotionId(0)), MotionEnd::Forgotten);
    assert_eq!(motion.poll(super::MotionId(u64::MAX)), MotionEnd::Forgotten);
}

#[test]
fn the_source_follows_from_the_token() {
    let service = Service::new();
    let motion = &service.motion;
    let pause = |source| MotionCommand { source, ..MotionCommand::new(motion_kind::PAUSE) };
    assert_eq!(motion.push(MotionToken(7), &pause(0)), Err(MotionRefusal::NotOwner));
    let task = motion.acquire("task").unwrap();
    let other = MotionRefusal::Refused("motion belongs to task".to_owned());
    assert_eq!(motion.acquire("panel"), Err(other));
    for source in [motion_source::TASK, motion_source::LOCAL, motion_source::REMOTE] {
        motion.push(task, &pause(source)).unwrap();
    }
    for source in [motion_source::TASK, motion_source::LOCAL, motion_source::REMOTE] {
        motion.push(MotionToken::LOCAL, &pause(source)).unwrap();
    }
    let why = MotionRefusal::Refused("there is no source 3".to_owned());
    assert_eq!(motion.push(task, &pause(3)), Err(why));
    let sources: Vec<_> = service.fake.got.lock().unwrap().iter().map(|g| g.0).collect();
    let [task_, local, remote] = [MotionSource::Task, MotionSource::Local, MotionSource::Remote];
    assert_eq!(sources, [task_, local, remote, local, local, remote]);
    assert!(motion.claim(task, true) && service.fake.claimed.load(Relaxed));
    assert!(!motion.claim(MotionToken::LOCAL, false) && service.fake.claimed.load(Relaxed));
    motion.release(MotionToken(99));
    assert!(service.fake.claimed.load(Relaxed), "a void token releases nothing");
    motion.release(task);
    assert!(!service.fake.claimed.load(Relaxed), "the claim ends with the ownership");
    assert_eq!(motion.push(task, &pause(0)), Err(MotionRefusal::NotOwner));
}

#[test]
fn a_full_controller_and_a_refusal_say_so() {
    let service = Service::new();
    let motion = &service.motion;
    let jog = MotionCommand { speed: f64::NAN, ..MotionCommand::new(motion_kind::JOG) };
    let why = MotionRefusal::Refused("velocity is NaN".to_owned());
    assert_eq!(motion.push(MotionToken::LOCAL, &jog), Err(why));
    service.fake.room.store(0, Relaxed);
    assert_eq!(motion.room(), 0);
    let line = MotionCommand::new(motion_kind::MOVE);
    assert_eq!(motion.push(MotionToken::LOCAL, &line), Err(MotionRefusal::Full));
    assert!(motion.push(MotionToken::LOCAL, &MotionCommand::new(motion_kind::ABORT)).is_ok());
    // A panic of the controller reaches nobody else, and the service goes on.
    service.fake.room.store(1, Relaxed);
    let home = MotionCommand::new(motion_kind::HOME);
    let MotionRefusal::Refused(why) = motion.push(MotionToken::LOCAL, &home).unwrap_err() else {
        panic!("not refused")
    };
    assert!(why.contains("planted"), "{why}");
    assert!(motion.push(MotionToken::LOCAL, &MotionCommand::new(motion_kind::ENABLE)).is_ok());
}

#[test]
fn the_handle_of_a_refused_command_stays_valid() {
    let service = Service::new();
    let push = |kind| service.motion.push(MotionToken::LOCAL, &MotionCommand::new(kind));
    // More refusals than there are places, so that each ticket is used again.
    for _ in 0..5000 {
        assert!(matches!(push(motion_kind::JOG), Err(MotionRefusal::Refused(_))));
    }
    let held = service.fake.refused.lock().unwrap();
    held.iter().for_each(|end| end.fail_with("late {}", &[1.0]));
    let id = push(motion_kind::ENABLE).unwrap();
    assert_eq!(
        service.motion.poll(id),
        MotionEnd::Pending,
        "a ticket that is used again is pending"
    );
    let own = service.fake.got.lock().unwrap()[0].2;
    let address = |end: &TicketHandle| core::ptr::from_ref(end.0);
    let again = held.iter().filter(|end| address(end) == address(&own)).count();
    assert!(again > 0, "the ticket was one of a refused command, and was not freed");
    own.fail("limit");
    assert_eq!(service.motion.poll(id), MotionEnd::Failed("limit".to_owned()));
}

#[test]
fn a_long_reason_is_cut_between_characters() {
    let service = Service::new();
    let name = "ä".repeat(200);
    service.motion.acquire(&name).unwrap();
    let MotionRefusal::Refused(why) = service.motion.acquire("b").unwrap_err() else { panic!() };
    assert!(why.starts_with("motion belongs to ä") && why.ends_with('ä'), "{why}");
    assert!(abi::MOTION_TEXT - 2 < why.len() && why.len() <= abi::MOTION_TEXT);
}

#[test]
fn records_that_are_none_are_refused() {
    let service = Service::new();
    let t = &service.table;
    let command = MotionCommand::new(motion_kind::ENABLE);
    let push = |ctx, command, out| {
        // SAFETY: all pointers are null or point to live values.
        unsafe { t.push.unwrap()(ctx, 0, command, out) }
    };
    let mut out = MotionAnswer::EMPTY;
    let out = &raw mut out;
    let mut short = MotionAnswer { size: 8, ..MotionAnswer::EMPTY };
    let cut = MotionCommand { size: 40, ..command };
    let (null, nowhere) = (core::ptr::null(), core::ptr::null_mut());
    assert_eq!(push(t.ctx, core::ptr::null(), out), Status::EINVAL);
    assert_eq!(push(t.ctx, &raw const command, nowhere), Status::EINVAL);
    assert_eq!(push(t.ctx, &raw const command, &raw mut short), Status::EINVAL);
    assert_eq!(push(null, &raw const command, out), Status::EINVAL);
    assert_eq!(push(t.ctx, &raw const cut, out), Status::EINVAL);
    // SAFETY: null is refused.
    assert_eq!(unsafe { t.poll.unwrap()(t.ctx, 1, nowhere) }, Status::EINVAL);
    // SAFETY: the answer is live.
    assert_eq!(unsafe { t.acquire.unwrap()(t.ctx, Str::NONE, out) }, Status::EINVAL);
    // SAFETY: null is refused.
    assert_eq!(unsafe { t.room.unwrap()(null) }, 0);
    // SAFETY: null is refused.
    assert_eq!(unsafe { t.status.unwrap()(t.ctx, core::ptr::null_mut(), 5) }, 0);
    assert!(service.fake.got.lock().unwrap().is_empty(), "nothing reached the controller");
}

#[test]
fn a_user_reads_as_many_words_as_it_knows() {
    let service = Service::new();
    let status = service.motion.status().unwrap();
    assert_eq!((status.cycle, status.time_ns, status.enabled, status.mode), (1, 2, true, 4));
    let mut words = [0_u64; 3];
    let read = service.table.status.unwrap();
    // SAFETY: the words are live.
    let all = unsafe { read(service.table.ctx, words.as_mut_ptr(), 2) };
    assert_eq!((all as usize, words), (<MotionStatus as crate::Plain>::WORDS, [1, 2, 0]));
    assert!(core::mem::offset_of!(abi::Motion, epoch) == abi::Motion::MIN);
    assert_eq!(service.motion.epoch(), StopEpoch { stops: 0, pauses: 9 });
    let named = |setting| MotionCommand { setting, ..MotionCommand::new(motion_kind::CONFIGURE) };
    assert_eq!(service.motion.setting(&named(2)), Some(7.5));
    assert_eq!(service.motion.setting(&named(3)), None);
}

#[test]
fn an_epoch_is_read_back_and_compared_beyond_its_largest_number() {
    let epoch = |stops, pauses| StopEpoch { stops, pauses };
    assert_eq!(StopEpoch::of(epoch(7, u32::MAX).number()), Some(epoch(7, u32::MAX)));
    assert_eq!(StopEpoch::of(0), None);
    for (given, now, stopped, paused) in [
        (epoch(3, 4), epoch(3, 4), false, false),
        (epoch(3, 4), epoch(4, 4), true, false),
        (epoch(3, 4), epoch(3, 5), false, true),
        // A status that is older than the order.
        (epoch(4, 5), epoch(3, 4), false, false),
        (epoch(u32::MAX, u32::MAX), epoch(1, 0), true, true),
    ] {
        assert_eq!((given.is_stopped_by(now), given.is_paused_by(now)), (stopped, paused));
    }
}
