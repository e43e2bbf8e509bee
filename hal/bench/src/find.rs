//! Services that components on a bench offer, as other components find them.

use crate::Bench;
use core::{any::Any, marker::PhantomData};
use hal_component::{
    Builder, Component, Error, IoControlRef, KinematicsRef, MotionRef, OperatorRef,
    abi::component_flags,
};
use std::cell::RefCell;

thread_local! {
    static FOUND: RefCell<Option<Box<dyn Any>>> = const { RefCell::new(None) };
}

/// Service that a component can find.
pub trait Service: Sized + 'static {
    /// Finds the service, if a component offers it.
    ///
    /// # Errors
    /// The builder's.
    fn find(b: &mut Builder<'_>) -> Result<Option<Self>, Error>;
}

impl Service for KinematicsRef {
    fn find(b: &mut Builder<'_>) -> Result<Option<Self>, Error> {
        b.kinematics().map(Some)
    }
}

impl Service for MotionRef {
    fn find(b: &mut Builder<'_>) -> Result<Option<Self>, Error> {
        b.motion()
    }
}

impl Service for OperatorRef {
    fn find(b: &mut Builder<'_>) -> Result<Option<Self>, Error> {
        b.operator()
    }
}

impl Service for IoControlRef {
    fn find(b: &mut Builder<'_>) -> Result<Option<Self>, Error> {
        b.iocontrol()
    }
}

/// Component that finds a service, and has nothing of its own.
struct Finder<S>(PhantomData<S>);

impl<S: Service> Component for Finder<S> {
    const NAME: &'static str = "finder";
    const DOC: &'static str = "Finds a service.";
    const FLAGS: u32 = component_flags::ONCE;
    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let found = S::find(b)?;
        FOUND.with(|at| *at.borrow_mut() = found.map(|s| Box::new(s) as Box<dyn Any>));
        Ok(())
    }
}

#[expect(clippy::unwrap_used, reason = "a bench for tests")]
impl Bench {
    /// Returns a service that a component on the bench offers, as `motmod` finds kinematics.
    pub fn find<S: Service>(&mut self) -> S {
        self.create::<Finder<S>>(&[]).unwrap();
        *FOUND.take().unwrap().downcast().unwrap()
    }
}
