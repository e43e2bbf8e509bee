//! Pins of `genhexkins`.

use hal_component::{Builder, Decl, Error, In, InSet, Out, Pose, Touch, pins};

pins! {
    /// Pins for the whole machine.
    pub(crate) struct General {
        /// Offset added to Z of both ends of every strut, in units: moves the origin to the spindle.
        spindle_offset: In<f64> = "spindle-offset", 0.0;
        /// Extension of a strut per turn of its screw, in units; below 0: left-handed thread, 0: struts do not turn.
        screw_lead: In<f64> = "screw-lead", 0.0;
        /// Tool length along Z, from the platform to the tool tip, in units; the pose is that of the tip. Change it
        /// only while the platform is level.
        tool: In<f64> = "tool-offset", 0.0;
        /// Error, summed over the lengths of all struts, at which a search succeeds, in units; above 0.
        criterion: In<f64> = "convergence-criterion", 1e-9;
        /// Maximum number of steps of a search from lengths to a pose; values above 1000 count as 1000.
        limit_iterations: In<u32> = "limit-iterations", 120;
        /// Error, summed over the lengths of all struts, above which a search fails, in units; above 0.
        max_error: In<f64> = "max-error", 500.0;
        /// Number of steps of the last successful search.
        last_iterations: Out<u32> = "last-iterations", 0;
        /// Largest number of steps of any search.
        max_iterations: Out<u32> = "max-iterations", 0;
        /// TRUE if the last search from lengths to a pose failed.
        failed: Out<bool> = "fwd-kins-fail", false;
    }
}

/// Pins of one strut.
#[derive(Debug, Touch)]
pub(crate) struct StrutPins {
    pub(crate) base: [In<f64>; 3],
    pub(crate) platform: [In<f64>; 3],
    pub(crate) base_axis: [In<f64>; 3],
    pub(crate) platform_axis: [In<f64>; 3],
    pub(crate) correction: Out<f64>,
}

/// All pins.
#[derive(Debug, Touch)]
pub(crate) struct Pins {
    pub(crate) general: General,
    pub(crate) struts: Vec<StrutPins>,
    /// Last pose found, published twice: for programs that draw the machine.
    shown: Vec<InSet<f64>>,
}

/// Defaults: ends of each strut on base and platform, and the axes of the joints there.
#[expect(clippy::approx_constant, reason = "as LinuxCNC has them, to six places")]
const FIRST: [[[f64; 3]; 4]; 6] = {
    const S: f64 = 0.707107;
    const C: f64 = 0.866025;
    [
        [[-22.95, 13.25, 0.0], [-1.0, 11.5, 0.0], [S, 0.0, S], [-1.0, 0.0, 0.0]],
        [[22.95, 13.25, 0.0], [1.0, 11.5, 0.0], [0.0, -S, S], [C, 0.5, 0.0]],
        [[22.95, 13.25, 0.0], [10.459, -4.884, 0.0], [-S, 0.0, S], [C, 0.5, 0.0]],
        [[0.0, -26.5, 0.0], [9.459, -6.616, 0.0], [-S, 0.0, S], [C, -0.5, 0.0]],
        [[0.0, -26.5, 0.0], [-9.459, -6.616, 0.0], [0.0, S, S], [C, -0.5, 0.0]],
        [[-22.95, 13.25, 0.0], [-10.459, -4.884, 0.0], [S, 0.0, S], [-1.0, 0.0, 0.0]],
    ]
};

impl Pins {
    pub(crate) fn make(b: &mut Builder<'_>) -> Result<Self, Error> {
        let general = General::make(b, "genhexkins")?;
        let mut struts = Vec::new();
        for (n, [base, platform, base_axis, platform_axis]) in FIRST.iter().enumerate() {
            let mut point = |name: &str, what: &str, first: &[f64; 3]| {
                let mut one = |letter: char, first: f64| {
                    let doc = format!("{} {what}.", letter.to_ascii_uppercase());
                    let name = format!("genhexkins.{name}.{n}.{letter}");
                    b.declare(Decl::new(&name, &doc), first)
                };
                let [x, y, z] = *first;
                Ok::<_, Error>([one('x', x)?, one('y', y)?, one('z', z)?])
            };
            let on_base = format!("of the end of strut {n} on the base, in units");
            let on_platform =
                format!("of the end of strut {n} on the platform, from its middle, in units");
            let axis = "of the direction, without a unit, of the axis of the strut's joint";
            let base = point("base", &on_base, base)?;
            let platform = point("platform", &on_platform, platform)?;
            let base_axis = point("base-n", &format!("{axis} at the base"), base_axis)?;
            let platform_axis =
                point("platform-n", &format!("{axis} at the platform"), platform_axis)?;
            let correction = b.declare(
                Decl::new(
                    &format!("genhexkins.correction.{n}"),
                    "How much longer the screw has made the strut, in units.",
                ),
                0.0,
            )?;
            struts.push(StrutPins { base, platform, base_axis, platform_axis, correction });
        }
        let mut shown = Vec::new();
        for prefix in ["genhexkins", "skgui"] {
            for letter in ["x", "y", "z", "a", "b", "c"] {
                let doc = format!(
                    "{} of the pose that was found last, in units or degrees; it is written, not \
                     read.",
                    letter.to_ascii_uppercase()
                );
                shown.push(b.declare(Decl::new(&format!("{prefix}.{letter}"), &doc), 0.0)?);
            }
        }
        Ok(Self { general, struts, shown })
    }

    /// Publishes the pose that was found.
    pub(crate) fn show(&self, pose: &Pose) {
        for (pin, value) in self.shown.iter().zip(pose.iter().take(6).cycle()) {
            pin.set_own(*value);
        }
    }

    /// Publishes the number of steps of a search.
    pub(crate) fn note_steps(&self, took: u32) {
        let g = &self.general;
        g.last_iterations.set(took);
        if took > g.max_iterations.get() {
            g.max_iterations.set(took);
        }
    }
}
