//! `xyzac-trt-kins` and `xyzbc-trt-kins`.

use crate::{
    five_axis::tips::{Lettered, Tip},
    letters::{Letters, Rule},
    model::is_finite,
    names::{example, names},
    rotation::{Matrix, Vector, about_x, about_y, about_z},
    switch::{IDENTITY_FIRST, Switched},
};
use hal_component::{Arg, Builder, Error, In, Pose, Touch, abi::ArgSpec, pins};

macro_rules! doc {
    ($name:literal, $tilt:literal, $letters:literal, $move:literal) => {
        concat!(
            "\
Kinematics of a mill with a table that tilts by ", $tilt, " and carries a rotary table C.

The pose is the tool's tip on the work piece, however the tables turn it. Joints follow the letters
of `coordinates=`, without it joints 0 to 4 are ", $letters, "; a letter may occur more than once.
The offsets say where the axes of the tables are. The chain of rotations is that of Jung, Lee, Kim
and Mok (NC post-processor for 5-axis milling of table-rotating/tilting type, 2002). A positive
angle turns the table so that the tool goes the other way round on the work piece;
`conventional-directions` changes that.

In types 1 and 2 every joint is an axis; `motion.switchkins-type` says which type is in force. With
`sparm=identityfirst` that is type 0, and the tip follows the tables in type 1. With `-` or `_` in
its name it is the same.",
            example!(
                $name,
                5,
                concat!("setp ", $name, ".z-offset 20\n"),
                concat!($move, "\nshow pin joint.*.pos-cmd\n")
            )
        )
    };
}

macro_rules! args {
    ($letters:literal) => {
        &[
            &Arg::text(
                "coordinates",
                concat!(
                    "The letter of each joint, out of X Y Z A B C U V W in either case; ",
                    $letters,
                    " are needed."
                ),
            )
            .or($letters),
            &IDENTITY_FIRST,
        ]
    };
}

const XYZAC: &[&ArgSpec] = args!("XYZAC");
const XYZBC: &[&ArgSpec] = args!("XYZBC");

names! {
    doc!("xyzac-trt-kins", "A", "X Y Z A C", "motion.move x=10 a=30 c=45 --wait"), XYZAC, create_a;
    /// `loadrt xyzac-trt-kins`.
    XyzacTrt = "xyzac-trt-kins";
    /// `loadrt xyzac_trt_kins`: the same.
    XyzacTrtPlain = "xyzac_trt_kins";
}
names! {
    doc!("xyzbc-trt-kins", "B", "X Y Z B C", "motion.move x=10 b=30 c=45 --wait"), XYZBC, create_b;
    /// `loadrt xyzbc-trt-kins`.
    XyzbcTrt = "xyzbc-trt-kins";
    /// `loadrt xyzbc_trt_kins`: the same.
    XyzbcTrtPlain = "xyzbc_trt_kins";
}

fn create_a(b: &mut Builder<'_>) -> Result<(), Error> {
    create(b, "xyzac-trt-kins", "XYZAC", Tilt::A)
}

fn create_b(b: &mut Builder<'_>) -> Result<(), Error> {
    create(b, "xyzbc-trt-kins", "XYZBC", Tilt::B)
}

fn create(
    b: &mut Builder<'_>,
    name: &str,
    required: &'static str,
    tilt: Tilt,
) -> Result<(), Error> {
    let rule = Rule { required, twice: true, most: 9 };
    let letters = Letters::parse(&b.arg_text("coordinates").unwrap_or_default(), rule)?;
    let pins = Pins::make(b, name)?;
    let own = Lettered { tip: Tables { pins, tilt }, letters: letters.clone() };
    let kinematics = Switched::usual(b, own, letters)?;
    b.offer_kinematics(kinematics)
}

pins! {
    /// Positions of the table axes.
    struct Pins {
        /// X of the rotary table's axis, in machine units.
        x_rot: In<f64> = "x-rot-point", 0.0;
        /// Y of the rotary table's axis, in machine units.
        y_rot: In<f64> = "y-rot-point", 0.0;
        /// Z of the point about which the tables turn, in machine units.
        z_rot: In<f64> = "z-rot-point", 0.0;
        /// X offset from that point to the tilt axis, in units; used where the table tilts by B.
        x: In<f64> = "x-offset", 0.0;
        /// Y offset from that point to the tilt axis, in units; used where the table tilts by A.
        y: In<f64> = "y-offset", 0.0;
        /// Z offset from that point to the tilt axis, in units.
        z: In<f64> = "z-offset", 0.0;
        /// Tool length, in units: usually from motion.tooloffset.z.
        tool: In<f64> = "tool-offset", 0.0;
        /// TRUE: the rotary axes count in the opposite direction.
        conventional: In<bool> = "conventional-directions", false;
    }
}

/// Tilt axis of the table.
#[derive(Clone, Copy, Debug)]
enum Tilt {
    A,
    B,
}

#[derive(Debug, Touch)]
struct Tables {
    pins: Pins,
    #[state]
    tilt: Tilt,
}

/// Point about which the tables turn, offset of the tilt axis, tool, and the sign of the angles.
struct Geometry {
    point: Vector,
    offset: Vector,
    tool: Vector,
    sign: f64,
}

impl Tables {
    /// Returns the rotations of the tilting table and of the rotary table.
    fn turned(&self, g: &Geometry, letters: &Pose) -> (Matrix, Matrix) {
        let angle = |letter: f64| (g.sign * letter).to_radians();
        let tilted = match self.tilt {
            Tilt::A => about_x(angle(letters[3])),
            Tilt::B => about_y(angle(letters[4])),
        };
        (tilted, about_z(angle(letters[5])))
    }
}

impl Tip for Tables {
    type Geometry = Geometry;

    fn geometry(&self) -> Option<Geometry> {
        let p = &self.pins;
        let [px, py, pz] = [&p.x_rot, &p.y_rot, &p.z_rot].map(In::get);
        let [x, y, z, tool] = [&p.x, &p.y, &p.z, &p.tool].map(In::get);
        let sign = if p.conventional.get() { 1.0 } else { -1.0 };
        is_finite(&[px, py, pz, x, y, z, tool]).then_some(Geometry {
            point: Vector::new(px, py, pz),
            offset: Vector::new(x, y, z),
            tool: Vector::new(0.0, 0.0, tool),
            sign,
        })
    }

    fn to_work(&self, g: &Geometry, place: Vector, letters: &Pose) -> Vector {
        let (tilted, round) = self.turned(g, letters);
        let from_tilt = place - g.point - g.tool - g.offset;
        round * (tilted * from_tilt + g.offset) + g.point + g.tool
    }

    fn to_machine(&self, g: &Geometry, tip: Vector, letters: &Pose) -> Vector {
        let (tilted, round) = self.turned(g, letters);
        let on_table = round.transpose() * (tip - g.point - g.tool) - g.offset;
        tilted.transpose() * on_table + g.offset + g.tool + g.point
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, close, serial};
    use hal_component::Component;

    fn both_ways<C: Component>(letters: &[usize]) {
        let (line, turn) = (Joint::linear(300.0), Joint::rotary(360.0));
        let joints = [line, line, line, turn, turn];
        let pins =
            ["x-rot-point", "y-rot-point", "z-rot-point", "x-offset", "y-offset", "z-offset"];
        let pins: Vec<String> = pins.iter().map(|p| format!("{}.{p}", C::NAME)).collect();
        let set: Vec<(&str, f64)> =
            pins.iter().zip(1..).map(|(p, n)| (p.as_str(), f64::from(n) * 7.0 - 20.0)).collect();
        let space = Space { size: 600.0, joints: &joints, letters, set: &set, ..Space::DEFAULT };
        serial::<C>(&[], &space);
    }

    #[test]
    fn both_tilting_about_a() {
        both_ways::<XyzacTrt>(&[0, 1, 2, 3, 5]);
    }

    #[test]
    fn both_tilting_about_b() {
        both_ways::<XyzbcTrt>(&[0, 1, 2, 4, 5]);
    }

    #[test]
    fn a_quarter_turn_of_each_table() {
        let rig = Rig::new::<XyzacTrt>(&[]);
        close(&rig.pose(&[0., 0., 5., 90., 0.])[..3], &[0., 5., 0.], 1e-12);
        close(&rig.pose(&[0., 5., 0., 0., 90.])[..3], &[5., 0., 0.], 1e-12);
        rig.bench.set("xyzac-trt-kins.conventional-directions", true);
        close(&rig.pose(&[0., 5., 0., 0., 90.])[..3], &[-5., 0., 0.], 1e-12);
        // The tool length does not turn: there is no jump at zero.
        let rig = Rig::new::<XyzbcTrt>(&[]);
        rig.bench.set("xyzbc-trt-kins.tool-offset", 40.0);
        assert_eq!(rig.pose(&[1., 2., 3., 0., 0.])[..3], [1., 2., 3.]);
    }
}
