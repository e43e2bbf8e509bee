//! Rings between two programs: one makes it, the other attaches to it.

use crate::{Error, name::Name, observe::ring::Memory, os};
use hal_abi::MAX_WIDTH;
use hal_protocol::{StreamInfo, Type};
use std::{collections::BTreeMap, os::fd::OwnedFd};

/// Largest number of slots of such a ring.
const MAX_DEPTH: u32 = 65_536;
/// Largest number of rings that one client makes.
const MAX_RINGS: usize = 64;

#[derive(Debug)]
struct OwnRing {
    /// The client that made it, and the one that attached to it.
    owner: u64,
    attached: Option<u64>,
    info: StreamInfo,
    memory: Memory,
}

/// The rings between programs.
#[derive(Debug, Default)]
pub(crate) struct OwnRings {
    rings: BTreeMap<Name, OwnRing>,
}

impl OwnRings {
    /// Makes a ring for a client, in place of its own of this name.
    pub(crate) fn make(
        &mut self,
        client: u64,
        name: &str,
        depth: u32,
        types: Vec<Type>,
    ) -> Result<(StreamInfo, OwnedFd), Error> {
        let name = Name::parse("stream", name)?;
        let taken = self.rings.get(name.as_str()).is_some_and(|ring| ring.owner != client);
        if taken {
            return Err(Error::StreamTaken { name: name.as_str().into() });
        }
        let others = self.rings.iter().filter(|(n, ring)| ring.owner == client && **n != name);
        let is_malformed =
            depth == 0 || depth > MAX_DEPTH || types.is_empty() || types.len() > MAX_WIDTH;
        if is_malformed || types.contains(&Type::Port) || others.count() >= MAX_RINGS {
            let why = format!(
                "a ring has 1 to {MAX_DEPTH} slots and 1 to {MAX_WIDTH} values, none of them a port; a program makes at \
                 most {MAX_RINGS}"
            );
            return Err(Error::Protocol { why: why.into() });
        }
        let memory =
            Memory::of_types(depth, &types).map_err(|why| Error::Protocol { why: why.into() })?;
        let info = StreamInfo {
            name: name.as_str().to_owned(),
            out: true,
            depth,
            types,
            attached: false,
            both: true,
        };
        let ring = OwnRing { owner: client, attached: None, info, memory };
        let given = ring.give()?;
        if let Some(before) = self.rings.insert(name, ring) {
            before.memory.ring().close();
        }
        Ok(given)
    }

    /// Attaches a client to a ring; `None` if there is none of this name.
    pub(crate) fn attach(
        &mut self,
        client: u64,
        name: &str,
    ) -> Option<Result<(StreamInfo, OwnedFd), Error>> {
        let ring = self.rings.get_mut(name)?;
        if client != ring.owner {
            if ring.attached.is_some_and(|by| by != client) {
                return Some(Err(Error::StreamTaken { name: name.into() }));
            }
            ring.attached = Some(client);
        }
        Some(ring.give())
    }

    /// Removes the rings of a client that has left, and closes them for the other one.
    pub(crate) fn leave(&mut self, client: u64) {
        self.rings.retain(|_, ring| {
            if ring.owner == client {
                ring.memory.ring().close();
            }
            ring.attached.take_if(|by| *by == client);
            ring.owner != client
        });
    }
}

impl OwnRing {
    fn give(&self) -> Result<(StreamInfo, OwnedFd), Error> {
        let file = self.memory.file().map_err(|e| Error::System {
            what: "the stream cannot be handed over",
            why: os::said(&e),
        })?;
        let attached = self.attached.is_some();
        Ok((StreamInfo { attached, ..self.info.clone() }, file))
    }
}
