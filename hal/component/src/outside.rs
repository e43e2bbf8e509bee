//! Builder functions for shared things: rings with programs, state and queues between functions,
//! services.

use crate::{
    Builder, Error, Gives, HomingRef, Interlock, InterlockRef, IoControl, IoControlRef, Kinematics,
    KinematicsRef, Motion, MotionRef, Operator, OperatorRef, Receiver, Sender, StreamIn, StreamOut,
    Takes, Touch,
    abi::{self, ServiceRef, Status, Str, StreamSpec, host_flags},
    builder::check,
    interlock, iocontrol, kinematics, motion, operator,
    service::{self, Found, Table},
};
use core::ffi::c_void;
use crossbeam::queue::ArrayQueue;
use std::sync::Arc;

type Ring = abi::StreamRef;

impl Builder<'_> {
    fn stream(
        &mut self,
        name: &str,
        direction: u32,
        depth: u32,
        types: &[u8],
    ) -> Result<Ring, Error> {
        let name = self.full(name);
        let mut padded = [0; 24];
        for (to, from) in padded.iter_mut().zip(types) {
            *to = *from;
        }
        let spec = StreamSpec {
            size: abi::size::<StreamSpec>(),
            direction,
            name: Str::borrow(&name),
            depth,
            width: u32::try_from(types.len()).unwrap_or(u32::MAX),
            types: padded,
        };
        let mut out = Ring { ring: core::ptr::null(), depth: 0, width: 0 };
        let stream = self.host.stream.ok_or(Error::engine(Status::EINVAL))?;
        // SAFETY: this is the engine's function; `spec` and `out` live for the duration of the
        // call.
        check(unsafe { stream(self.host.ctx, &raw const spec, &raw mut out) })?;
        if out.ring.is_null() { Err(Error::engine(Status::ENOMEM)) } else { Ok(out) }
    }

    /// Creates a ring that the component writes and a program reads. `types` are the type codes of
    /// the values of a record, at most [`abi::MAX_WIDTH`].
    ///
    /// # Errors
    /// The name is taken, the shape is invalid, or the engine is out of memory.
    pub fn stream_out(&mut self, name: &str, depth: u32, types: &[u8]) -> Result<StreamOut, Error> {
        let r = self.stream(name, abi::stream_direction::OUT, depth, types)?;
        // SAFETY: the engine created the ring in this shape for this component alone.
        Ok(StreamOut(unsafe { abi::Producer::new(r.ring, r.depth, r.width) }))
    }

    /// Creates a ring that a program writes and the component reads.
    ///
    /// # Errors
    /// As [`Self::stream_out`].
    pub fn stream_in(&mut self, name: &str, depth: u32, types: &[u8]) -> Result<StreamIn, Error> {
        let r = self.stream(name, abi::stream_direction::IN, depth, types)?;
        // SAFETY: the engine created the ring in this shape for this component alone.
        Ok(StreamIn(unsafe { abi::Consumer::new(r.ring, r.depth, r.width) }))
    }

    /// Creates state (atomics) that one function passes to others. The two ends declare which
    /// functions write and which read it.
    #[must_use]
    pub fn shared<T: Send + Sync>(&mut self, state: T) -> (Gives<T>, Takes<T>) {
        let state = Arc::new(state);
        (Gives(state.clone()), Takes(state))
    }

    /// Creates a bounded queue of `room` values, from a command or task to a function or back.
    #[must_use]
    pub fn queue<T: Copy + Send>(&mut self, room: usize) -> (Sender<T>, Receiver<T>) {
        let queue = Arc::new(ArrayQueue::new(if room == 0 { 1 } else { room }));
        (Sender(queue.clone()), Receiver(queue))
    }

    /// Offers kinematics to other plugins.
    ///
    /// # Errors
    /// Other kinematics are already loaded.
    pub fn offer_kinematics<K: Kinematics>(&mut self, k: K) -> Result<(), Error> {
        let table = kinematics::table(&k);
        self.offer(k, table)
    }

    /// Offers the e-stop state to realtime functions of other plugins.
    ///
    /// # Errors
    /// Another interlock is already loaded.
    pub fn offer_interlock<I: Interlock>(&mut self, interlock: I) -> Result<(), Error> {
        self.offer(interlock, interlock::table::<I>())
    }

    /// Offers the motion controller to other plugins.
    ///
    /// # Errors
    /// Another motion controller is already loaded.
    pub fn offer_motion<M: Motion>(&mut self, motion: M) -> Result<(), Error> {
        self.offer(motion::Offered::new(motion), motion::table::<M>())
    }

    fn offer<T, F>(&self, value: T, table: F) -> Result<(), Error>
    where
        T: Touch + Send + Sync + 'static,
        F: Table,
    {
        let offer = self.host.offer.ok_or(Error::engine(Status::EINVAL))?;
        let uses = self.uses(&value);
        let spec = service::offer(value, table, &uses);
        // SAFETY: this is the engine's function; ownership of the state passes with the call.
        check(unsafe { offer(self.host.ctx, &raw const spec) })
    }

    /// Returns the loaded kinematics. Functions declared afterwards inherit the pins that they
    /// access.
    ///
    /// # Errors
    /// No kinematics are loaded.
    pub fn kinematics(&mut self) -> Result<KinematicsRef, Error> {
        let find = self.host.find.ok_or(Error::engine(Status::EINVAL))?;
        let mut table: *const c_void = core::ptr::null();
        // SAFETY: this is the engine's function; `table` lives for the duration of the call.
        check(unsafe {
            let (name, version) = (abi::Kinematics::NAME, abi::Kinematics::VERSION);
            find(self.host.ctx, Str::new(name), version, &raw mut table)
        })?;
        // SAFETY: the engine found a table of this name and version.
        let found = unsafe { Found::read(table, []) };
        found.map(KinematicsRef).ok_or(Error::engine(Status::EINVAL))
    }

    /// Returns the loaded interlock, if there is one. A function that holds it inherits the pins
    /// that it accesses.
    ///
    /// # Errors
    /// The loaded interlock has another version.
    pub fn interlock(&mut self) -> Result<Option<InterlockRef>, Error> {
        Ok(self.bind()?.map(InterlockRef))
    }

    /// Returns the loaded homing module, if there is one, prepared for these joints; the last `extra`
    /// are not moved by the kinematics. Its pins become those of this component.
    ///
    /// # Errors
    /// It has another version, or cannot create its pins.
    pub fn homing(
        &mut self,
        period: f64,
        joints: usize,
        extra: usize,
    ) -> Result<Option<HomingRef>, Error> {
        let Some(found) = self.bind()?.map(HomingRef) else { return Ok(None) };
        let [joints, extra] = [joints, extra].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
        check(found.open(self.host, period, joints, extra))?;
        Ok(Some(found))
    }

    /// Returns the loaded motion controller, if there is one. It stays loaded as long as this
    /// component.
    ///
    /// # Errors
    /// The loaded motion controller has another version.
    pub fn motion(&mut self) -> Result<Option<MotionRef>, Error> {
        Ok(self.bind()?.map(MotionRef))
    }

    /// Offers buttons and lamps of an operator to the task.
    ///
    /// # Errors
    /// Another component offers them already.
    pub fn offer_operator<O: Operator>(&mut self, operator: O) -> Result<(), Error> {
        self.offer(operator, operator::table::<O>())
    }

    /// Returns the loaded buttons and lamps of an operator, if there are any. For the task.
    ///
    /// # Errors
    /// They have another version.
    pub fn operator(&mut self) -> Result<Option<OperatorRef>, Error> {
        Ok(self.bind()?.map(OperatorRef))
    }

    /// Looks up a service, with what its functions access. An unreadable table is an error, so that
    /// a machine never runs without its interlock.
    fn bind<F: Table>(&self) -> Result<Option<Found<F>>, Error> {
        let bind = self.host.bind.ok_or(Error::engine(Status::EINVAL))?;
        let mut found = ServiceRef { table: core::ptr::null(), uses: core::ptr::null(), n_uses: 0 };
        // SAFETY: this is the engine's function; `found` lives for the duration of the call.
        check(unsafe { bind(self.host.ctx, Str::new(F::NAME), F::VERSION, &raw mut found) })?;
        if found.table.is_null() {
            return Ok(None);
        }
        let uses = if found.n_uses == 0 || found.uses.is_null() {
            Vec::new()
        } else {
            // SAFETY: this is the engine's list, valid until `create` returns.
            unsafe { core::slice::from_raw_parts(found.uses, found.n_uses) }.to_vec()
        };
        // SAFETY: the engine found a table of this name and version.
        let found = unsafe { Found::read(found.table, uses) };
        found.ok_or(Error::engine(Status::EINVAL)).map(Some)
    }

    /// Offers e-stop, coolant and tool changer to the worker of another plugin that controls jobs.
    ///
    /// # Errors
    /// Another component offers them already.
    pub fn offer_iocontrol<C: IoControl>(&mut self, control: C) -> Result<(), Error> {
        self.offer(control, iocontrol::table::<C>())
    }

    /// Returns the loaded controls of e-stop, coolant and tool changer, if there are any.
    ///
    /// # Errors
    /// The loaded controls have another version.
    pub fn iocontrol(&mut self) -> Result<Option<IoControlRef>, Error> {
        Ok(self.bind()?.map(IoControlRef))
    }

    /// Returns whether the instance is a machine from an INI file. Motion then needs an interlock.
    #[must_use]
    pub const fn needs_interlock(&self) -> bool {
        self.host.flags & host_flags::INTERLOCK != 0
    }
}
