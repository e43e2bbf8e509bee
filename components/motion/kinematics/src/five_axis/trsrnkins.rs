//! `xyzacb_trsrn` and `xyzbca_trsrn`.

use crate::{
    five_axis::tips::{Lettered, Tip},
    instances::{COUNT, NAMES, prefixes},
    letters::{ANY, Letters},
    model::is_finite,
    names::{example, names},
    rotation::{Matrix, Vector, about, about_x, about_y, about_z},
    switch::Switched,
};
use hal_component::{Builder, Decl, Error, In, Out, Pose, Touch, pins};

macro_rules! doc {
    ($name:literal, $table:literal, $nod:literal, $plane:literal, $letters:literal, $go:literal) => {
        concat!(
            "\
Kinematics of a mill with a rotary table ", $table, " and a head that turns by C and nods by ", $nod, ".

Joints 0 to 5 are ", $letters, ". The axis of the nod slants: it leans from the upright by nut-angle in the plane
of ", $plane, " and Z: with 45 degrees, half a turn of it lays the tool level. `motion.switchkins-type`
chooses: in type 0 every joint is an axis; in type 1 the pose is the tool's tip on the work piece,
however table and head turn it; in type 2 X Y Z are along the tool when the head is at primary-angle
and secondary-angle, for work in a tilted plane (Rodrigues' rotation formula; She and Chang, Design of
a generic five-axis postprocessor, 2007). With `-` or `_` in its name it is the same.",
            example!(
                $name,
                6,
                concat!("setp ", $name, ".z-pivot 150\nsetp motion.switchkins-type 1\n"),
                concat!($go, "\nshow pin joint.*.pos-cmd\n")
            )
        )
    };
}

names! {
    doc!("xyzacb_trsrn", "A", "B", "Y", "X Y Z A C B", "motion.move x=10 a=30 b=20 c=45 --wait"),
    &[&COUNT, &NAMES], create_a;
    /// `loadrt xyzacb_trsrn`.
    XyzacbTrsrn = "xyzacb_trsrn";
    /// `loadrt xyzacb-trsrn`: the same.
    XyzacbTrsrnDashed = "xyzacb-trsrn";
}
names! {
    doc!("xyzbca_trsrn", "B", "A", "X", "X Y Z B C A", "motion.move x=10 a=20 b=30 c=45 --wait"),
    &[&COUNT, &NAMES], create_b;
    /// `loadrt xyzbca_trsrn`.
    XyzbcaTrsrn = "xyzbca_trsrn";
    /// `loadrt xyzbca-trsrn`: the same.
    XyzbcaTrsrnDashed = "xyzbca-trsrn";
}

fn create_a(b: &mut Builder<'_>) -> Result<(), Error> {
    create(b, "xyzacb", "XYZACB", Table::A)
}

fn create_b(b: &mut Builder<'_>) -> Result<(), Error> {
    create(b, "xyzbca", "XYZBCA", Table::B)
}

fn create(b: &mut Builder<'_>, name: &str, letters: &str, table: Table) -> Result<(), Error> {
    for prefix in prefixes(b, &format!("{name}-trsrn"))? {
        let _: Out<i32> = b.item(&format!("{prefix}.dummy"), "Always 0.", 0)?;
    }
    let letters = Letters::parse(letters, ANY)?;
    let name = format!("{name}_trsrn");
    let pins = Pins::make(b, &name)?;
    let letter = match table {
        Table::A => 'y',
        Table::B => 'x',
    };
    let mut float = |pin: &str, doc: &str| -> Result<In<f64>, Error> {
        b.declare(Decl::new(&format!("{name}.{letter}-{pin}"), doc), 0.0)
    };
    let across = [
        float(
            "pivot",
            "From the axis of the head's turn across to the tool, in the plane of the nod, in \
             units.",
        )?,
        float("rot-axis", "Where the table's axis is, across, in units of the machine.")?,
    ];
    let model = |along_tool| {
        let tip = Head { pins: pins.clone(), across, table, along_tool };
        Some(Lettered { tip, letters: letters.clone() })
    };
    let models = vec![None, model(false), model(true)];
    let kinematics = Switched::make(b, models, letters.clone())?;
    b.offer_kinematics(kinematics)
}

pins! {
    /// Geometry of the machine.
    struct Pins {
        /// Tool length, in units: usually from motion.tooloffset.z.
        tool: In<f64> = "tool-offset-z", 0.0;
        /// Distance from the pivot down to the tool tip when the tool length is 0, in units.
        down: In<f64> = "z-pivot", 0.0;
        /// Z of the table's axis, in machine units.
        table_z: In<f64> = "z-rot-axis", 0.0;
        /// Angle between the nutation axis and the vertical, in degrees.
        nut: In<f64> = "nut-angle", 45.0;
        /// In type 2: rotation of the plane about the tool, in degrees.
        pre_rot: In<f64> = "pre-rot", 0.0;
        /// In type 2: angle C of the head, in degrees.
        primary: In<f64> = "primary-angle", 0.0;
        /// In type 2: nutation angle of the head, in degrees.
        secondary: In<f64> = "secondary-angle", 0.0;
    }
}

/// Rotary axis of the table.
#[derive(Clone, Copy, Debug)]
enum Table {
    A,
    B,
}

#[derive(Debug, Touch)]
struct Head {
    pins: Pins,
    /// Positions, across the table's axis, of the pivot and of that axis.
    across: [In<f64>; 2],
    #[state]
    table: Table,
    #[state]
    along_tool: bool,
}

/// Tip in the head's frame, direction of the nutation axis, a point of the table's axis, and the rotation of the
/// machine's frame in type 2.
struct Geometry {
    tip: Vector,
    axis: Vector,
    table: Vector,
    seen: Matrix,
}

impl Head {
    /// Returns the offset that the head adds to X, Y and Z.
    fn head(&self, g: &Geometry, letters: &Pose) -> Vector {
        let nod = match self.table {
            Table::A => letters[4],
            Table::B => letters[3],
        };
        turned(g, letters[5], nod) * g.tip - g.tip
    }

    /// Returns the rotation of the table.
    fn table(&self, letters: &Pose) -> Matrix {
        match self.table {
            Table::A => about_x(letters[3].to_radians()),
            Table::B => about_y(letters[4].to_radians()),
        }
    }
}

fn turned(g: &Geometry, turn: f64, nod: f64) -> Matrix {
    about_z(turn.to_radians()) * about(&g.axis, nod.to_radians())
}

impl Tip for Head {
    type Geometry = Geometry;

    fn geometry(&self) -> Option<Geometry> {
        let p = &self.pins;
        let [tool, down, z] = [&p.tool, &p.down, &p.table_z].map(In::get);
        let [across, at] = [&self.across[0], &self.across[1]].map(In::get);
        let [nut, pre, primary, secondary] =
            [&p.nut, &p.pre_rot, &p.primary, &p.secondary].map(In::get);
        if !is_finite(&[tool, across, down, at, z, nut, pre, primary, secondary]) {
            return None;
        }
        // Across means Y where the table is A, and X where it is B.
        let flat = |across: f64, z: f64| match self.table {
            Table::A => Vector::new(0.0, across, z),
            Table::B => Vector::new(across, 0.0, z),
        };
        let lean = nut.to_radians();
        let mut g = Geometry {
            tip: flat(-across, -(down + tool)),
            axis: flat(libm::sin(lean), libm::cos(lean)),
            table: flat(at, z),
            seen: Matrix::identity(),
        };
        g.seen = turned(&g, primary, secondary) * about_z(pre.to_radians());
        Some(g)
    }

    fn to_work(&self, g: &Geometry, place: Vector, letters: &Pose) -> Vector {
        let tip = place + self.head(g, letters);
        if self.along_tool {
            return g.seen.transpose() * tip;
        }
        self.table(letters) * (tip - g.table) + g.table
    }

    fn to_machine(&self, g: &Geometry, tip: Vector, letters: &Pose) -> Vector {
        let tip = if self.along_tool {
            g.seen * tip
        } else {
            self.table(letters).transpose() * (tip - g.table) + g.table
        };
        tip - self.head(g, letters)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, close, serial};
    use hal_component::Component;

    fn both_ways<C: Component>(across: char) {
        let (line, turn) = (Joint::linear(300.0), Joint::rotary(360.0));
        let joints = [line, line, line, turn, turn, turn];
        let name = |p: &str| format!("{}.{p}", C::NAME);
        let values = [("tool-offset-z", 80.0), ("z-pivot", 120.0)];
        let more = [("z-rot-axis", -90.0), ("nut-angle", 50.0)];
        let angles = [("pre-rot", 20.0), ("primary-angle", 30.0), ("secondary-angle", -40.0)];
        let mut list: Vec<(String, f64)> =
            values.iter().chain(&more).chain(&angles).map(|(p, v)| (name(p), *v)).collect();
        list.push((name(&format!("{across}-pivot")), 12.0));
        list.push((name(&format!("{across}-rot-axis")), -30.0));
        let set: Vec<(&str, f64)> = list.iter().map(|(p, v)| (p.as_str(), *v)).collect();
        for switch in [1, 2] {
            let letters = &[0, 1, 2, 3, 4, 5];
            let (joints, set) = (&joints, &set);
            let space = Space { size: 600.0, joints, letters, set, switch, ..Space::DEFAULT };
            serial::<C>(&[], &space);
        }
    }

    #[test]
    fn both_ways_with_a_table_a() {
        both_ways::<XyzacbTrsrn>('y');
    }

    #[test]
    fn both_ways_with_a_table_b() {
        both_ways::<XyzbcaTrsrn>('x');
    }

    #[test]
    fn half_a_turn_of_the_nod_lays_the_tool_level() {
        let rig = Rig::new::<XyzacbTrsrn>(&[]);
        rig.set(&[("xyzacb_trsrn.z-pivot", 100.0)]);
        let joints = [0., 0., 0., 0., 0., 180.];
        assert_eq!(rig.pose(&joints), [0., 0., 0., 0., 180., 0., 0., 0., 0.]);
        assert!(rig.k.switch(1));
        close(&rig.pose(&joints)[..3], &[0., -100., 100.], 1e-9);
        // At zero nothing is added.
        assert_eq!(rig.pose(&[1., 2., 3., 0., 0., 0.])[..3], [1., 2., 3.]);
        assert!(rig.k.switch(2));
        rig.set(&[("xyzacb_trsrn.secondary-angle", 180.0)]);
        // Now along the tool: the direction is Z.
        let still = rig.pose(&[0., 0., 0., 0., 0., 180.]);
        let gone = rig.pose(&[0., 10., 0., 0., 0., 180.]);
        close(&[gone[2] - still[2]], &[10.0], 1e-9);
    }
}
