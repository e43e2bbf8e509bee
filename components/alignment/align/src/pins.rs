//! Pins of the component.

use crate::eye::Station;
use hal_component::{Builder, Error, In, Out, Plain, Touch};

/// Results of the worker, each with the pin of its name: field, type, first value, documentation.
macro_rules! results {
    ($($name:ident: $ty:ident = $first:tt, $doc:tt;)*) => {
        /// Latest results.
        #[derive(Clone, Copy, Debug, Plain)]
        pub(crate) struct Results {
            $(#[doc = $doc] pub(crate) $name: $ty,)*
        }

        impl Default for Results {
            fn default() -> Self {
                Self { $($name: $first,)* }
            }
        }

        /// Pins that show them.
        #[derive(Debug, Touch)]
        struct Shown {
            $($name: Out<$ty>,)*
        }

        impl Shown {
            fn make(b: &mut Builder<'_>) -> Result<Self, Error> {
                Ok(Self {
                    $($name: {
                        let pin = format!("align.{}", stringify!($name).replace('_', "-"));
                        b.item(&pin, $doc, $first)?
                    },)*
                })
            }

            /// Realtime.
            fn set(&self, results: &Results) {
                $(self.$name.set(results.$name);)*
            }
        }
    };
}

results! {
    looks: u32 = 0, "Number of actions that are done.";
    found: bool = false, "TRUE if the last look found the mark.";
    error: i32 = 0, "Reason why the last action failed, 0 if it did not.";
    x: f64 = 0.0, "X of the last mark found, on the machine, in mm.";
    y: f64 = 0.0, "Y of the last mark found, on the machine, in mm.";
    dx: f64 = 0.0, "Move in X that brings the last mark to the middle of the picture, in mm.";
    dy: f64 = 0.0, "Move in Y that brings the last mark to the middle of the picture, in mm.";
    angle: f64 = 0.0, "Angle of the last mark if it is a square, on the machine, in degrees from -45 to 45.";
    scatter: f64 = 0.0, "Largest distance of a picture of the last mark from their mean, in pixels.";
    uncertainty: f64 = 0.0, "Standard deviation of the place of the last mark, in mm, from the noise of the pictures.";
    aim_x: f64 = 0.0, "X at which the camera should see the selected mark, in mm.";
    aim_y: f64 = 0.0, "Y at which the camera should see the selected mark, in mm.";
    marks: i32 = 0, "Number of marks that are measured.";
    valid: bool = false, "TRUE while the place of the part holds; a new or forgotten mark ends it.";
    theta: f64 = 0.0, "Turn of the part, in degrees.";
    sx: f64 = 1.0, "Scale of the part along X.";
    sy: f64 = 1.0, "Scale of the part along Y; negative if it is mirrored.";
    shear: f64 = 0.0, "Squareness error of the part, in degrees.";
    tx: f64 = 0.0, "X of the file's origin on the machine, in mm.";
    ty: f64 = 0.0, "Y of the file's origin on the machine, in mm.";
    rms: f64 = 0.0, "Root of the mean square of the residuals, in mm.";
    live: bool = false, "TRUE if turn and shift alone fit, so that a coordinate system can hold them.";
    live_theta: f64 = 0.0, "Turn for G10 L2 R, in degrees.";
    live_x: f64 = 0.0, "X for G10 L2, in mm.";
    live_y: f64 = 0.0, "Y for G10 L2, in mm.";
}

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
    busy: Out<bool>,
    shown: Shown,
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
            shown: Shown::make(b)?,
            simulated: if b.is_simulated() { Some(Simulated::make(b)?) } else { None },
        })
    }

    /// Realtime. Returns the place of the machine, and what the simulated camera sees there.
    pub(crate) fn station(&self) -> Station {
        let (x, y) = (self.pos_x.get(), self.pos_y.get());
        let default = Station { x, y, light: 1.0, part_x: 0.0, part_y: 0.0, stalls: false };
        self.simulated.as_ref().map_or(default, |s| Station {
            light: s.light.get(),
            part_x: s.x.get(),
            part_y: s.y.get(),
            stalls: s.stall.get(),
            ..default
        })
    }

    /// Realtime. Writes the results.
    pub(crate) fn show(&self, r: &Results, is_busy: bool) {
        self.busy.set(is_busy);
        self.shown.set(r);
    }
}

impl Simulated {
    fn make(b: &mut Builder<'_>) -> Result<Self, Error> {
        Ok(Self {
            light: b.item(
                "align.sim.light",
                "Light on the simulated table, 0 to 2; 1 by default.",
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
