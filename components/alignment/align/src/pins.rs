//! Pins of the component.

use crate::eye::{Results, Scene};
use hal_component::{Builder, Error, In, Out, Touch};

/// The pins.
#[derive(Debug, Touch)]
pub(crate) struct EyePins {
    pub(crate) pos_x: In<f64>,
    pub(crate) pos_y: In<f64>,
    pub(crate) still: In<bool>,
    pub(crate) mark: In<f64>,
    pub(crate) look: In<bool>,
    pub(crate) solve: In<bool>,
    pub(crate) clear: In<bool>,
    pub(crate) busy: Out<bool>,
    found: Out<bool>,
    error: Out<i32>,
    pub(crate) looks: Out<u32>,
    x: Out<f64>,
    y: Out<f64>,
    dx: Out<f64>,
    dy: Out<f64>,
    angle: Out<f64>,
    scatter: Out<f64>,
    uncertainty: Out<f64>,
    aim_x: Out<f64>,
    aim_y: Out<f64>,
    marks: Out<i32>,
    valid: Out<bool>,
    theta: Out<f64>,
    sx: Out<f64>,
    sy: Out<f64>,
    shear: Out<f64>,
    tx: Out<f64>,
    ty: Out<f64>,
    rms: Out<f64>,
    live: Out<bool>,
    live_theta: Out<f64>,
    live_x: Out<f64>,
    live_y: Out<f64>,
    simulated: Option<Simulated>,
}

/// Pins of the simulated camera.
#[derive(Debug, Touch)]
struct Simulated {
    light: In<f64>,
    x: In<f64>,
    y: In<f64>,
    stall: In<bool>,
}

impl EyePins {
    /// Creates the pins.
    pub(crate) fn make(b: &mut Builder<'_>) -> Result<Self, Error> {
        Ok(Self {
            pos_x: b.item("align.pos-x", "X of the machine, in mm.", 0.0)?,
            pos_y: b.item("align.pos-y", "Y of the machine, in mm.", 0.0)?,
            still: b.item("align.still", "TRUE while the machine stands.", true)?,
            mark: b.item("align.mark", "Number of the selected mark, from 1; a float, as the analog outputs of programs are.", 1.0)?,
            look: b.item("align.look", "A rising edge finds the selected mark; while busy it has no effect.", false)?,
            solve: b.item("align.solve", "A rising edge computes the place of the part; while busy it has no effect.", false)?,
            clear: b.item("align.clear", "A rising edge forgets all marks; while busy it has no effect.", false)?,
            busy: b.item("align.busy", "TRUE from an edge or a command until its result.", false)?,
            found: b.item("align.found", "TRUE if the last look found the mark.", false)?,
            error: b.item("align.error", "Reason why the last action failed, 0 if it did not.", 0)?,
            looks: b.item("align.looks", "Number of actions that are done.", 0)?,
            x: b.item("align.x", "X of the last mark found, on the machine, in mm.", 0.0)?,
            y: b.item("align.y", "Y of the last mark found, on the machine, in mm.", 0.0)?,
            dx: b.item("align.dx", "Move in X that brings the last mark to the middle of the picture, in mm.", 0.0)?,
            dy: b.item("align.dy", "Move in Y that brings the last mark to the middle of the picture, in mm.", 0.0)?,
            angle: b.item("align.angle", "Angle of the last mark if it is a square, on the machine, in degrees from -45 to 45.", 0.0)?,
            scatter: b.item("align.scatter", "Largest distance of a picture of the last mark from their mean, in pixels.", 0.0)?,
            uncertainty: b.item("align.uncertainty", "Standard deviation of the place of the last mark, in mm, from the noise of the pictures.", 0.0)?,
            aim_x: b.item("align.aim-x", "X at which the camera should see the selected mark, in mm.", 0.0)?,
            aim_y: b.item("align.aim-y", "Y at which the camera should see the selected mark, in mm.", 0.0)?,
            marks: b.item("align.marks", "Number of marks that are measured.", 0)?,
            valid: b.item("align.valid", "TRUE while the place of the part holds; a new or forgotten mark ends it.", false)?,
            theta: b.item("align.theta", "Turn of the part, in degrees.", 0.0)?,
            sx: b.item("align.sx", "Scale of the part along X.", 1.0)?,
            sy: b.item("align.sy", "Scale of the part along Y; negative if it is mirrored.", 1.0)?,
            shear: b.item("align.shear", "Squareness error of the part, in degrees.", 0.0)?,
            tx: b.item("align.tx", "X of the file's origin on the machine, in mm.", 0.0)?,
            ty: b.item("align.ty", "Y of the file's origin on the machine, in mm.", 0.0)?,
            rms: b.item("align.rms", "Root of the mean square of the residuals, in mm.", 0.0)?,
            live: b.item("align.live", "TRUE if turn and shift alone fit, so that a coordinate system can hold them.", false)?,
            live_theta: b.item("align.live-theta", "Turn for G10 L2 R, in degrees.", 0.0)?,
            live_x: b.item("align.live-x", "X for G10 L2, in mm.", 0.0)?,
            live_y: b.item("align.live-y", "Y for G10 L2, in mm.", 0.0)?,
            simulated: if b.is_simulated() { Some(Simulated::make(b)?) } else { None },
        })
    }

    /// Realtime. Returns what the simulated camera sees.
    pub(crate) fn scene(&self) -> Scene {
        self.simulated.as_ref().map_or(Scene { light: 1.0, x: 0.0, y: 0.0, stalls: false }, |s| {
            Scene { light: s.light.get(), x: s.x.get(), y: s.y.get(), stalls: s.stall.get() }
        })
    }

    /// Realtime. Writes the results.
    pub(crate) fn show(&self, r: &Results, is_busy: bool) {
        self.busy.set(is_busy);
        self.looks.set(r.number);
        self.error.set(r.error);
        self.found.set(r.found);
        self.x.set(r.x);
        self.y.set(r.y);
        self.dx.set(r.dx);
        self.dy.set(r.dy);
        self.angle.set(r.angle);
        self.scatter.set(r.scatter);
        self.uncertainty.set(r.uncertainty);
        self.aim_x.set(r.aim_x);
        self.aim_y.set(r.aim_y);
        self.marks.set(r.marks);
        self.valid.set(r.valid);
        self.theta.set(r.theta);
        self.sx.set(r.sx);
        self.sy.set(r.sy);
        self.shear.set(r.shear);
        self.tx.set(r.tx);
        self.ty.set(r.ty);
        self.rms.set(r.rms);
        self.live.set(r.live);
        self.live_theta.set(r.live_theta);
        self.live_x.set(r.live_x);
        self.live_y.set(r.live_y);
    }
}

impl Simulated {
    fn make(b: &mut Builder<'_>) -> Result<Self, Error> {
        Ok(Self {
            light: b.item(
                "align.sim.light",
                "Light on the simulated table, 0 to 2; 1 is usual.",
                1.0,
            )?,
            x: b.item("align.sim.x", "Shift of the part on the simulated table in X, in mm.", 0.0)?,
            y: b.item("align.sim.y", "Shift of the part on the simulated table in Y, in mm.", 0.0)?,
            stall: b.item(
                "align.sim.stall",
                "TRUE: the simulated camera takes no picture.",
                false,
            )?,
        })
    }
}
