//! Realtime. Switchable kinematics: the machine's own type, and types whose joints are axes.

use crate::{
    letters::{ANY, Letters, Rule},
    model::{self, Found, Joints, Model},
};
use hal_component::{
    Arg, Builder, Decl, Error, Io, Kinematics, KinematicsKind, Out, Pose, Solution, Solved, Touch,
    Uses, Ways, abi::ArgSpec,
};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Argument `coordinates=`, which only the types with joints as axes use.
pub(crate) const COORDINATES: ArgSpec = Arg::text(
    "coordinates",
    "The letter of each joint in the types where joints are axes, out of X Y Z A B C U V W in \
     either case.",
);

/// Argument `sparm=` of kinematics whose type 0 is always their own.
pub(crate) const SPARM: ArgSpec = Arg::text("sparm", "Accepted for scripts that give it.").or("");

/// Argument `sparm=` of kinematics whose type 0 may be the identity.
pub(crate) const IDENTITY_FIRST: ArgSpec = Arg::text(
    "sparm",
    "With 'identityfirst' type 0 is the one where joints are axes, and type 1 the kinematics' own.",
)
.or("");

/// Pins that show the active type.
#[derive(Debug, Touch)]
pub(crate) struct Types {
    shown: Vec<Out<bool>>,
    #[state]
    is: AtomicU32,
}

impl Types {
    /// Makes the pins `kinstype.is-0` and so on.
    pub(crate) fn make(b: &mut Builder<'_>, n: usize) -> Result<Self, Error> {
        let mut shown = Vec::new();
        for i in 0..n {
            let doc = format!(
                "TRUE while kinematics of type {i} are in force; motion.switchkins-type says which."
            );
            shown.push(b.declare(Decl::new(&format!("kinstype.is-{i}"), &doc), i == 0)?);
        }
        Ok(Self { shown, is: AtomicU32::new(0) })
    }

    /// Returns the number of types.
    pub(crate) fn count(&self) -> u32 {
        u32::try_from(self.shown.len()).unwrap_or(1)
    }

    /// Returns the active type.
    pub(crate) fn now(&self) -> u32 {
        self.is.load(Relaxed)
    }

    /// Activates a type. Returns false if it does not exist.
    pub(crate) fn switch(&self, to: u32) -> bool {
        if to >= self.count() {
            return false;
        }
        self.is.store(to, Relaxed);
        for (n, pin) in (0..).zip(&self.shown) {
            pin.set(n == to);
        }
        true
    }
}

/// Counters of type 2, which is reserved for the user's kinematics.
#[derive(Debug, Touch)]
struct Counts {
    forward: Io<i32>,
    inverse: Io<i32>,
}

impl Counts {
    fn make(b: &mut Builder<'_>) -> Result<Self, Error> {
        let mut count = |name, what: &str| {
            let doc = format!("How often {what} were computed in type 2; it wraps.");
            b.declare(Decl::new(name, &doc), 0)
        };
        Ok(Self { forward: count("userk.fct", "poses")?, inverse: count("userk.ict", "joints")? })
    }
}

/// Kinematics of several types; in a type without a model, joints are axes.
#[derive(Debug)]
pub(crate) struct Switched<M> {
    models: Vec<Option<M>>,
    axes: Axes,
    types: Types,
    counts: Option<Counts>,
}

impl<M: Model> Switched<M> {
    /// Makes the machine's own type, two types with joints as axes, and their common pins.
    pub(crate) fn usual(b: &mut Builder<'_>, own: M, letters: Letters) -> Result<Self, Error> {
        let first = b.arg_text("sparm").is_some_and(|s| s.contains("identityfirst"));
        let models = if first { vec![None, Some(own), None] } else { vec![Some(own), None, None] };
        let mut made = Self::make(b, models, letters)?;
        made.counts = Some(Counts::make(b)?);
        Ok(made)
    }

    /// Offers kinematics of six joints, each of which is an axis in the other types.
    pub(crate) fn offer_six(
        b: &mut Builder<'_>,
        own: impl FnOnce(&mut Builder<'_>) -> Result<M, Error>,
    ) -> Result<(), Error> {
        let rule = Rule { twice: false, most: 6, ..ANY };
        let letters = Letters::parse(&b.arg_text("coordinates").unwrap_or_default(), rule)?;
        let own = own(b)?;
        let kinematics = Self::usual(b, own, letters)?;
        b.offer_kinematics(kinematics)
    }

    /// Makes one type per model.
    pub(crate) fn make(
        b: &mut Builder<'_>,
        models: Vec<Option<M>>,
        letters: Letters,
    ) -> Result<Self, Error> {
        let types = Types::make(b, models.len())?;
        Ok(Self { models, axes: Axes(letters), types, counts: None })
    }

    /// Returns the active model, or `None` where joints are axes.
    fn own(&self) -> Option<&M> {
        self.models.iter().zip(0..).find(|(_, n)| *n == self.types.now())?.0.as_ref()
    }

    fn count(&self, pin: fn(&Counts) -> &Io<i32>) {
        if let Some(counts) = self.counts.as_ref().filter(|_| self.types.now() == 2) {
            let pin = pin(counts);
            pin.set(pin.get().wrapping_add(1));
        }
    }
}

impl<M: Touch> Touch for Switched<M> {
    fn touch(&self, uses: &mut Uses) {
        self.models.touch(uses);
        self.types.touch(uses);
        self.counts.touch(uses);
    }
}

impl<M: Model> Kinematics for Switched<M> {
    fn joints(&self) -> usize {
        let own = self.models.iter().flatten().map(Model::joints);
        own.fold(self.axes.joints(), usize::max)
    }

    fn kind(&self) -> KinematicsKind {
        KinematicsKind::Both
    }

    fn joint_of(&self, letter: usize) -> Option<usize> {
        self.models.iter().flatten().find_map(|m| m.joint_of(letter))
    }

    fn forward(&self, joints: &[f64], pose: &mut Pose) -> Solution {
        self.count(|c| &c.forward);
        match self.own() {
            Some(own) => model::forward(own, joints, pose),
            None => model::forward(&self.axes, joints, pose),
        }
    }

    fn inverse(&self, pose: &Pose, joints: &mut [f64]) -> Solution {
        self.count(|c| &c.inverse);
        match self.own() {
            Some(own) => model::inverse(own, pose, joints),
            None => model::inverse(&self.axes, pose, joints),
        }
    }

    fn solutions(&self, pose: &Pose, ways: &mut Ways<'_>) -> Solution {
        match self.own() {
            Some(own) => model::solutions(own, pose, ways),
            None => model::solutions(&self.axes, pose, ways),
        }
    }

    fn types(&self) -> u32 {
        self.types.count()
    }

    fn switch(&self, to: u32) -> bool {
        self.types.switch(to)
    }
}

/// Kinematics whose joints are axes.
#[derive(Debug)]
pub(crate) struct Axes(pub(crate) Letters);

impl Touch for Axes {
    fn touch(&self, _: &mut Uses) {}
}

impl Model for Axes {
    type Geometry = ();

    fn joints(&self) -> usize {
        self.0.joints()
    }

    fn joint_of(&self, letter: usize) -> Option<usize> {
        self.0.joint_of(letter)
    }

    fn geometry(&self) -> Option<()> {
        Some(())
    }

    fn forward(&self, (): &(), joints: &Joints, guess: &Pose) -> Found<Pose> {
        Ok((self.0.forward(joints, guess), Solved::Regular))
    }

    fn inverse(&self, (): &(), pose: &Pose, guess: &Joints) -> Found<Joints> {
        Ok((self.0.inverse(pose, guess), Solved::Regular))
    }
}
