//! A storage in memory whose power can be cut, and a host that can hold the medium.

use hal_storage::{Bay, Gadget, NotEjected, Phase, Rules, Side, Storage, StorageEvent};
use std::{
    cell::RefCell,
    collections::BTreeMap,
    io::{self, ErrorKind, Read, Seek, SeekFrom, Write},
    rc::Rc,
};

/// Size of an image in the tests.
pub(crate) const SIZE: u64 = 36 << 20;
const PAGE: u64 = 4096;

/// Everything that survives a power cut.
#[derive(Default, Clone)]
pub(crate) struct Kept {
    pages: [BTreeMap<u64, Vec<u8>>; 2],
    pub(crate) state: Option<Vec<u8>>,
    pub(crate) jobs: BTreeMap<String, Vec<u8>>,
    /// Number of writes before the power is cut.
    pub(crate) power: Option<u64>,
    /// Number of writes so far.
    pub(crate) writes: u64,
    /// Fault: every byte that is written to this image from this place on is lost.
    pub(crate) lost_after: Option<(Side, u64)>,
}

impl Kept {
    /// Counts a write; it fails after the power cut.
    fn write(&mut self) -> io::Result<()> {
        self.writes += 1;
        match &mut self.power {
            Some(0) => Err(io::Error::other("the power is cut")),
            Some(n) => {
                *n -= 1;
                Ok(())
            }
            None => Ok(()),
        }
    }
}

#[derive(Clone, Default)]
pub(crate) struct Memory(pub(crate) Rc<RefCell<Kept>>);

pub(crate) struct MemoryImage {
    kept: Rc<RefCell<Kept>>,
    side: Side,
    at: u64,
}

impl Read for MemoryImage {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let kept = self.kept.borrow();
        let from = usize::try_from(self.at % PAGE).unwrap();
        let most = usize::try_from((SIZE - self.at).min(PAGE)).unwrap();
        let len = out.len().min(4096 - from).min(most);
        match kept.pages[self.side as usize].get(&(self.at / PAGE)) {
            Some(page) => out[..len].copy_from_slice(&page[from..from + len]),
            None => out[..len].fill(0),
        }
        self.at += len as u64;
        Ok(len)
    }
}

impl Write for MemoryImage {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut kept = self.kept.borrow_mut();
        kept.write()?;
        let from = usize::try_from(self.at % PAGE).unwrap();
        let len = bytes.len().min(4096 - from);
        if self.at + len as u64 > SIZE {
            return Err(io::Error::from(ErrorKind::StorageFull));
        }
        let is_lost = kept.lost_after.is_some_and(|(side, at)| side == self.side && self.at >= at);
        let pages = &mut kept.pages[self.side as usize];
        let is_new = !pages.contains_key(&(self.at / PAGE));
        if !(is_lost || is_new && bytes[..len].iter().all(|b| *b == 0)) {
            let page = pages.entry(self.at / PAGE).or_insert_with(|| vec![0; 4096]);
            page[from..from + len].copy_from_slice(&bytes[..len]);
        }
        self.at += len as u64;
        Ok(len)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for MemoryImage {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let at = match to {
            SeekFrom::Start(n) => n.cast_signed(),
            SeekFrom::End(n) => SIZE.cast_signed() + n,
            SeekFrom::Current(n) => self.at.cast_signed() + n,
        };
        self.at = u64::try_from(at).map_err(|_| io::Error::from(ErrorKind::InvalidInput))?;
        Ok(self.at)
    }
}

impl Memory {
    pub(crate) fn disk(&self, side: Side) -> MemoryImage {
        MemoryImage { kept: self.0.clone(), side, at: 0 }
    }

    /// Returns the last place of some bytes that lie within a page.
    pub(crate) fn find(&self, side: Side, bytes: &[u8]) -> u64 {
        let kept = self.0.borrow();
        let within = |page: &Vec<u8>| page.windows(bytes.len()).position(|w| w == bytes);
        let mut pages = kept.pages[side as usize].iter().rev();
        pages.find_map(|(n, page)| Some(n * PAGE + within(page)? as u64)).unwrap()
    }

    /// Overwrites bytes of an image.
    pub(crate) fn damage(&self, side: Side, at: u64, bytes: &[u8]) {
        let mut disk = self.disk(side);
        disk.seek(SeekFrom::Start(at)).unwrap();
        disk.write_all(bytes).unwrap();
    }
}

impl Bay for Memory {
    type Image = MemoryImage;

    fn blank(&mut self, side: Side) -> io::Result<()> {
        let mut kept = self.0.borrow_mut();
        kept.write()?;
        kept.pages[side as usize].clear();
        Ok(())
    }
    fn image(&mut self, side: Side) -> io::Result<MemoryImage> {
        Ok(self.disk(side))
    }
    fn flush(&mut self, _: Side) -> io::Result<()> {
        Ok(())
    }
    fn state(&mut self) -> io::Result<Option<Vec<u8>>> {
        Ok(self.0.borrow().state.clone())
    }
    fn set_state(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut kept = self.0.borrow_mut();
        kept.write()?;
        kept.state = Some(bytes.to_vec());
        Ok(())
    }
    fn waiting(&mut self) -> io::Result<Vec<String>> {
        Ok(self.0.borrow().jobs.keys().cloned().collect())
    }
    fn job(&mut self, name: &str) -> io::Result<Vec<u8>> {
        let kept = self.0.borrow();
        kept.jobs.get(name).cloned().ok_or_else(|| io::Error::from(ErrorKind::NotFound))
    }
    fn keep(&mut self, name: &str, bytes: &[u8]) -> io::Result<()> {
        let mut kept = self.0.borrow_mut();
        kept.write()?;
        kept.jobs.insert(name.to_owned(), bytes.to_vec());
        Ok(())
    }
    fn forget(&mut self, name: &str) -> io::Result<()> {
        let mut kept = self.0.borrow_mut();
        kept.write()?;
        kept.jobs.remove(name);
        Ok(())
    }
}

/// Host that sees an image, and may hold it.
#[derive(Default)]
pub(crate) struct Host {
    pub(crate) sees: Option<Side>,
    pub(crate) is_busy: bool,
    pub(crate) is_broken: bool,
    pub(crate) forced: u32,
    /// Number of attempts to eject.
    pub(crate) asked: u32,
}

impl Gadget for Host {
    fn present(&mut self, side: Side) -> io::Result<()> {
        if self.is_broken {
            return Err(io::Error::other("no such device"));
        }
        assert_eq!(self.sees, None, "two images at once");
        self.sees = Some(side);
        Ok(())
    }
    fn eject(&mut self) -> Result<(), NotEjected> {
        self.asked += 1;
        if self.is_broken {
            return Err(NotEjected::Failed(io::Error::other("no such device")));
        }
        if self.is_busy {
            return Err(NotEjected::Busy);
        }
        self.sees = None;
        Ok(())
    }
    fn force_eject(&mut self) -> io::Result<()> {
        self.forced += 1;
        (self.sees, self.is_busy) = (None, false);
        Ok(())
    }
}

pub(crate) const RULES: Rules = Rules { size: SIZE, may_force: false };

/// Runs steps at one moment until there is nothing to do; returns the events as text.
pub(crate) fn settle(storage: &mut Storage<Memory>, host: &mut Host, now: f64) -> Vec<String> {
    for _ in 0..10_000 {
        let before = storage.phase();
        let more = storage.step(host, now, true);
        if !more && storage.phase() == before {
            break;
        }
    }
    reported(storage)
}

/// Returns the events so far as text.
pub(crate) fn reported(storage: &mut Storage<Memory>) -> Vec<String> {
    let text = |event| match event {
        StorageEvent::Presented(side) => format!("presented {side}"),
        StorageEvent::Deleted(name) => format!("deleted {name}"),
        StorageEvent::Forced(side) => format!("forced {side}"),
        StorageEvent::Failed(why) => why.to_string(),
    };
    core::iter::from_fn(|| storage.event()).map(text).collect()
}

/// Returns the names of the files on an image.
pub(crate) fn files(memory: &Memory, side: Side) -> Vec<String> {
    hal_storage::image::list(memory.disk(side)).unwrap().into_iter().map(|f| f.name).collect()
}

pub(crate) fn read(memory: &Memory, side: Side, name: &str) -> Vec<u8> {
    hal_storage::image::read(memory.disk(side), name, 1 << 24).unwrap()
}

/// Opens a storage and presents its image.
pub(crate) fn served(memory: &Memory, rules: Rules) -> (Storage<Memory>, Host) {
    let mut storage = Storage::open(memory.clone(), rules).unwrap();
    let mut host = Host::default();
    settle(&mut storage, &mut host, 0.0);
    assert_eq!(storage.phase(), Phase::Serving);
    (storage, host)
}
