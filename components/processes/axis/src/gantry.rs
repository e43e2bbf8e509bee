//! `gantry`.
use hal_component::{
    Builder, Component, Error, Gives, In, Out, Period, Takes, Touch, Update, abi::component_flags,
};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

#[cfg(test)]
mod closed;

/// Maximum number of joints.
const MAX: i64 = 7;

/// Axis that several motors drive.
pub(crate) struct Gantry;

impl Component for Gantry {
    const NAME: &'static str = "gantry";
    const DOC: &'static str = "One axis driven by several motors, each homed to its own switch.\n\n\
        `personality=` is the number of joints, 0 to 7. All follow the command, less an offset of \
        their own. While the command moves in the direction of `search-vel`, and some but not all \
        of the switches are pressed, each joint whose switch is pressed stops: its offset grows \
        instead. `gantry.N.read` belongs before the motion controller, `gantry.N.write` after \
        it.\n\n\
        As measured on LinuxCNC 2.9: `home` and what is fed back are those of the first two joints; \
        `home` becomes true when both their switches are pressed, and false when neither is. The \
        offsets are kept in single precision.\n\n\
        # Example\n\n\
        The first joint's switch is pressed; it waits while the axis moves on by 0.5.\n\n\
        ```hal\n\
        loadrt gantry personality=2\n\
        loadrt threads name1=servo period1=1000000\n\
        addf gantry.0.read servo\n\
        addf gantry.0.write servo\n\
        setp gantry.0.search-vel -5\n\
        setp gantry.0.joint.00.home 1\n\
        setp gantry.0.position-cmd -0.5\n\
        start\n\
        run 1ms\n\
        getp gantry.0.joint.00.pos-cmd # -> 0\n\
        getp gantry.0.joint.01.pos-cmd # -> -0.5\n\
        getp gantry.0.limit # -> TRUE\n\
        ```";
    const FLAGS: u32 = component_flags::PERSONALITY | component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let n = b.size("Pin joint.##.pos-cmd", 0, MAX)?;
        let home = b.item("home", "True while the axis is at its switches.", false)?;
        let limit = b.item("limit", "True while any switch is pressed.", false)?;
        let (gives, takes) = b.shared(AtomicBool::new(true));
        let mut read = Read {
            joints: Vec::new(),
            position_fb: b.item(
                "position-fb",
                "Position feedback of the axis, in units: that of the joint that homes last, with \
                its offset.",
                0.0,
            )?,
            home,
            limit,
            homes: gives,
            told: 0,
        };
        let mut write = Write {
            joints: Vec::new(),
            position_cmd: b.item("position-cmd", "Position command of the axis, in units.", 0.0)?,
            search_vel: b.item(
                "search-vel",
                "Speed of the search for the switches; only its sign counts.",
                0.0,
            )?,
            homes: takes,
            last: 0.0,
        };
        for i in 0..n {
            let offset: Out<f64> = b.item(
                &format!("joint.{i:02}.offset"),
                "Difference of the axis's command minus this joint's, in units.",
                0.0,
            )?;
            let home = b.item(
                &format!("joint.{i:02}.home"),
                "True while this joint's home switch is pressed.",
                false,
            )?;
            let pos_fb = b.item(
                &format!("joint.{i:02}.pos-fb"),
                "Position feedback of the joint, in units.",
                0.0,
            )?;
            read.joints.push(JointState { home, pos_fb, offset });
            let pos_cmd = b.item(
                &format!("joint.{i:02}.pos-cmd"),
                "Position command of the joint, in units.",
                0.0,
            )?;
            write.joints.push(Led { home, pos_cmd, offset, sum: 0.0 });
        }
        b.function("read", "Position and switches.", read)?;
        b.function("write", "Commands of the joints.", write)
    }
}

#[derive(Touch)]
struct JointState {
    home: In<bool>,
    pos_fb: In<f64>,
    offset: Out<f64>,
}

#[derive(Touch)]
struct Read {
    joints: Vec<JointState>,
    position_fb: Out<f64>,
    home: Out<bool>,
    limit: Out<bool>,
    /// Flag for the other function: true while the axis is not at its home switches.
    homes: Gives<AtomicBool>,
    /// Joint whose position is that of the axis.
    #[state]
    told: usize,
}

impl Update for Read {
    fn update(&mut self, _: Period) {
        let pressed = |i: usize| self.joints.get(i).is_some_and(|j| j.home.get());
        let limit = self.joints.iter().any(|j| j.home.get());
        let last = if self.joints.len() > 1 { 1 } else { 0 };
        let home = match (pressed(0), pressed(last)) {
            (true, true) => true,
            (false, false) => false,
            (first, _) => {
                if !self.home.get() {
                    self.told = usize::from(first);
                }
                self.home.get()
            }
        };
        self.home.set(home);
        self.limit.set(limit);
        self.homes.store(!home, Relaxed);
        if let Some(joint) = self.joints.get(self.told) {
            self.position_fb.set(joint.pos_fb.get() + joint.offset.get());
        }
    }
}

#[derive(Touch)]
struct Led {
    home: In<bool>,
    pos_cmd: Out<f64>,
    offset: Out<f64>,
    #[state]
    sum: f32,
}

#[derive(Touch)]
struct Write {
    joints: Vec<Led>,
    position_cmd: In<f64>,
    search_vel: In<f64>,
    homes: Takes<AtomicBool>,
    #[state]
    last: f32,
}

impl Update for Write {
    #[expect(clippy::cast_possible_truncation, reason = "single precision is meant")]
    fn update(&mut self, _: Period) {
        let command = self.position_cmd.get();
        let step = (command - f64::from(self.last)) as f32;
        self.last = command as f32;
        let search = self.search_vel.get();
        let towards = (search > 0.0 && step > 0.0) || (search < 0.0 && step < 0.0);
        let homes = towards && self.homes.load(Relaxed);
        for joint in &mut self.joints {
            if homes && joint.home.get() {
                joint.sum += step;
            }
            joint.offset.set(f64::from(joint.sum));
            joint.pos_cmd.set(command - f64::from(joint.sum));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Gantry;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert!(replay::<Gantry>(include_str!("../traces/gantry.txt")) > 200);
    }

    #[test]
    fn refusals() {
        for n in ["8", "-1"] {
            let mut bench = Bench::new();
            let said = bench.load::<Gantry>(&[&format!("personality={n}")]).unwrap_err();
            assert!(said.contains(n) && said.contains('7'), "{said}");
            assert!(bench.names().is_empty());
        }
    }
}
