//! `xyzab_tdr_kins`.

use crate::{
    five_axis::tips::{Lettered, Tip},
    instances::{COUNT, NAMES, prefixes},
    letters::{ANY, Letters},
    model::is_finite,
    names::{example, names},
    rotation::{Vector, about_x, about_y},
    switch::Switched,
};
use hal_component::{Builder, Error, In, Out, Pose, pins};

const DOC: &str = concat!(
    "\
Kinematics of a mill with two rotary tables, B on top of A.

Joints 0 to 4 are X Y Z A B. In type 0 every joint is an axis; in type 1, chosen by
`motion.switchkins-type`, the pose is the tool's tip on the work piece, however the tables turn it
(She and Chang, Design of a generic five-axis postprocessor, 2007). With `-` or `_` in its name it is
the same.",
    example!(
        "xyzab_tdr_kins",
        5,
        "setp xyzab_tdr_kins.z-offset 20\nsetp motion.switchkins-type 1\n",
        "motion.move x=10 a=30 b=45 --wait\nshow pin joint.*.pos-cmd\n"
    )
);

names! {
    DOC, &[&COUNT, &NAMES], create;
    /// `loadrt xyzab_tdr_kins`.
    XyzabTdr = "xyzab_tdr_kins";
    /// `loadrt xyzab-tdr-kins`: the same.
    XyzabTdrDashed = "xyzab-tdr-kins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    for prefix in prefixes(b, "xyzab-tdr-kins")? {
        let _: Out<i32> = b.item(&format!("{prefix}.dummy"), "Always 0.", 0)?;
    }
    let letters = Letters::parse("XYZAB", ANY)?;
    let tip = Pins::make(b, "xyzab_tdr_kins")?;
    let own = Lettered { tip, letters: letters.clone() };
    let kinematics = Switched::make(b, vec![None, Some(own)], letters)?;
    b.offer_kinematics(kinematics)
}

pins! {
    /// Positions of the table axes.
    struct Pins {
        /// Tool length, in units: usually from motion.tooloffset.z.
        tool: In<f64> = "tool-offset-z", 0.0;
        /// X offset from the point about which A turns to the axis of B, in units.
        x: In<f64> = "x-offset", 0.0;
        /// Z offset from the point about which A turns to the axis of B, in units.
        z: In<f64> = "z-offset", 0.0;
        /// X of the point about which the tables turn, in machine units.
        x_rot: In<f64> = "x-rot-point", 0.0;
        /// Y of the point about which the tables turn, in machine units.
        y_rot: In<f64> = "y-rot-point", 0.0;
        /// Z of the point about which the tables turn, in machine units.
        z_rot: In<f64> = "z-rot-point", 0.0;
    }
}

/// Point about which the tables turn, offset of the axis of B, and the tool.
struct Geometry {
    point: Vector,
    offset: Vector,
    tool: Vector,
}

impl Tip for Pins {
    type Geometry = Geometry;

    fn geometry(&self) -> Option<Geometry> {
        let [px, py, pz] = [&self.x_rot, &self.y_rot, &self.z_rot].map(In::get);
        let [x, z, tool] = [&self.x, &self.z, &self.tool].map(In::get);
        is_finite(&[px, py, pz, x, z, tool]).then_some(Geometry {
            point: Vector::new(px, py, pz),
            offset: Vector::new(x, 0.0, z),
            tool: Vector::new(0.0, 0.0, tool),
        })
    }

    fn to_work(&self, g: &Geometry, place: Vector, letters: &Pose) -> Vector {
        let (a, b) = (about_x(letters[3].to_radians()), about_y(letters[4].to_radians()));
        a * (b * (place - g.point - g.tool) - g.offset) + g.offset + g.point + g.tool
    }

    fn to_machine(&self, g: &Geometry, tip: Vector, letters: &Pose) -> Vector {
        let (a, b) = (about_x(letters[3].to_radians()), about_y(letters[4].to_radians()));
        let on_table = a.transpose() * (tip - g.point - g.tool - g.offset) + g.offset;
        b.transpose() * on_table + g.tool + g.point
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, close, serial};

    #[test]
    fn both_ways() {
        let (line, turn) = (Joint::linear(300.0), Joint::rotary(360.0));
        let joints = [line, line, line, turn, turn];
        let letters = &[0, 1, 2, 3, 4];
        let space = Space { size: 600.0, joints: &joints, letters, switch: 1, ..Space::DEFAULT };
        serial::<XyzabTdr>(&[], &space);
    }

    #[test]
    fn the_tip_follows_the_tables_in_type_1() {
        let rig = Rig::new::<XyzabTdr>(&["count=2"]);
        assert_eq!(rig.k.types(), 2);
        assert_eq!(rig.pose(&[1., 2., 3., 4., 5.])[..5], [1., 2., 3., 4., 5.]);
        assert!(rig.k.switch(1));
        close(&rig.pose(&[0., 0., 5., 90., 0.])[..3], &[0., -5., 0.], 1e-12);
        close(&rig.pose(&[0., 0., 5., 0., 90.])[..3], &[5., 0., 0.], 1e-12);
        let set: Vec<(String, f64)> = ["tool-offset-z", "x-offset", "z-offset", "y-rot-point"]
            .iter()
            .zip(1..)
            .map(|(p, n)| (format!("xyzab_tdr_kins.{p}"), f64::from(n) * 11.0))
            .collect();
        for (name, value) in &set {
            rig.bench.set(name, *value);
        }
        let pose = rig.pose(&[10., 20., 30., 40., 50.]);
        close(&rig.joints(pose)[..5], &[10., 20., 30., 40., 50.], 1e-12);
        assert!(rig.bench.names().contains(&"xyzab-tdr-kins.1.dummy s32 OUT".to_owned()));
    }
}
