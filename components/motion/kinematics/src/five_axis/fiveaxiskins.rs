//! `5axiskins`.

use crate::{
    five_axis::tips::{Lettered, Tip},
    letters::{Letters, Rule},
    model::is_finite,
    names::{example, names},
    rotation::Vector,
    switch::{IDENTITY_FIRST, Switched},
};
use hal_component::{Arg, Builder, Error, In, Pose, abi::ArgSpec, pins};
use libm::{cos, sin};

const DOC: &str = concat!(
    "\
Kinematics of a bridge mill whose head turns by C and tilts by B.

The tool hangs `pivot-length` and W below the pivot; tilted by B in the direction C, its tip goes
aside by that length times the sine of B, and up. Joints follow the letters of `coordinates=`:
without it joints 0 to 5 are X Y Z B C W. A letter may occur more than once, and A, U and V may be
there and are joints of their own (spherical coordinates; She and Chang, Design of a generic
five-axis postprocessor, 2007).

In types 1 and 2 every joint is an axis; `motion.switchkins-type` says which type is in force.",
    example!(
        "5axiskins",
        6,
        "setp 5axiskins.pivot-length 200\n",
        "motion.move x=10 b=30 c=45 --wait\nshow pin joint.*.pos-cmd\n"
    )
);

const ARGS: &[&ArgSpec] = &[
    &Arg::text(
        "coordinates",
        "The letter of each joint, out of X Y Z A B C U V W in either case; X Y Z B C W are needed.",
    )
    .or("XYZBCW"),
    &IDENTITY_FIRST,
];

names! {
    DOC, ARGS, create;
    /// `loadrt 5axiskins`.
    FiveAxiskins = "5axiskins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    let rule = Rule { required: "XYZBCW", twice: true, most: 9 };
    let letters = Letters::parse(&b.arg_text("coordinates").unwrap_or_default(), rule)?;
    let tip = Pins::make(b, "5axiskins")?;
    let own = Lettered { tip, letters: letters.clone() };
    let kinematics = Switched::usual(b, own, letters)?;
    b.offer_kinematics(kinematics)
}

pins! {
    /// Geometry of the machine.
    struct Pins {
        /// Distance from the pivot of the head to the tool tip when W is 0, in units; may be 0 or negative. A change
        /// takes effect at once on the joints or on the pose.
        pivot: In<f64> = "pivot-length", 250.0;
    }
}

/// Returns the offset that the head adds to X, Y and Z.
fn head(pivot: f64, letters: &Pose) -> Vector {
    let (b, c) = (letters[4].to_radians(), letters[5].to_radians());
    let length = pivot + letters[8];
    let aside = length * sin(b);
    Vector::new(aside * cos(c), aside * sin(c), pivot - length * cos(b))
}

impl Tip for Pins {
    type Geometry = f64;

    fn geometry(&self) -> Option<f64> {
        let pivot = self.pivot.get();
        is_finite(&[pivot]).then_some(pivot)
    }

    fn to_work(&self, pivot: &f64, place: Vector, letters: &Pose) -> Vector {
        place + head(*pivot, letters)
    }

    fn to_machine(&self, pivot: &f64, tip: Vector, letters: &Pose) -> Vector {
        tip - head(*pivot, letters)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, close, serial};

    #[test]
    fn both_ways() {
        let (line, turn) = (Joint::linear(500.0), Joint::rotary(360.0));
        let joints = [line, line, line, turn, turn, line];
        let letters = &[0, 1, 2, 4, 5, 8];
        serial::<FiveAxiskins>(
            &[],
            &Space { size: 1000.0, joints: &joints, letters, ..Space::DEFAULT },
        );
    }

    #[test]
    fn the_tip_swings_about_the_pivot() {
        let rig = Rig::new::<FiveAxiskins>(&[]);
        close(&rig.pose(&[0., 0., 0., 90., 0., 10.])[..3], &[260.0, 0.0, 250.0], 1e-12);
        close(&rig.pose(&[0., 0., 0., 90., 90., 0.])[..3], &[0.0, 250.0, 250.0], 1e-12);
        close(&rig.joints([0., 0., 0., 0., 90., 90., 0., 0., 0.])[..3], &[0., -250., -250.], 1e-12);
    }

    #[test]
    fn letters_and_types() {
        let rig = Rig::new::<FiveAxiskins>(&["coordinates=xyzbcwyv"]);
        assert_eq!((rig.k.joints(), rig.k.types()), (8, 3));
        let joints = rig.joints([1., 2., 3., 4., 0., 0., 7., 8., 9.]);
        assert_eq!(joints[..8], [1., 2., 12., 0., 0., 9., 2., 8.]);
        assert!(rig.k.switch(1) && !rig.k.switch(3));
        assert_eq!(
            rig.joints([1., 2., 3., 4., 5., 6., 7., 8., 9.])[..8],
            [1., 2., 3., 5., 6., 9., 2., 8.]
        );
        let shown = || [0, 1, 2].map(|n| rig.bench.get::<bool>(&format!("kinstype.is-{n}")));
        assert_eq!(shown(), [false, true, false]);
        assert!(rig.k.switch(2));
        assert_eq!(shown(), [false, false, true]);
        rig.pose(&[1.0; 8]);
        assert_eq!(["fct", "ict"].map(|n| rig.bench.get::<i32>(&format!("userk.{n}"))), [1, 0]);
        let rig = Rig::new::<FiveAxiskins>(&["sparm=identityfirst"]);
        assert_eq!(rig.pose(&[0., 0., 0., 90., 0., 0.])[..3], [0.0; 3]);
    }
}
