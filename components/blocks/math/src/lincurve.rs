//! `lincurve`.
use hal_component::{
    Builder, Component, Error, In, Io, Out, ParamRw, Period, Touch, Update, abi::component_flags,
};

/// Maximum number of points.
const MAX: i64 = 16;
/// Default number of points.
const DEFAULT: i64 = 2;

/// Curve of straight lines.
#[derive(Touch)]
pub(crate) struct Lincurve {
    input: In<f64>,
    out: Out<f64>,
    out_io: Io<f64>,
    points: Vec<(ParamRw<f64>, ParamRw<f64>)>,
    /// Index of the line segment that the last output was on.
    #[state]
    line: usize,
}

impl Component for Lincurve {
    const NAME: &'static str = "lincurve";
    const DOC: &'static str = "A curve through points, with straight lines between them.\n\n\
        It linearises a sensor, or makes a gain depend on another value. Before the first point \
        and after the last, the output is that of the first and last point. The `x-val-##` must \
        not decrease.\n\n\
        `personality=` is the number of points, 1 to 16; 2 without it.\n\n\
        # Example\n\n\
        ```hal\n\
        # A sensor gives 0 at 0 degrees, 100 at 20, 160 at 40.\n\
        loadrt lincurve personality=3\n\
        loadrt threads name1=servo period1=1000000\n\
        addf lincurve.0 servo\n\
        start\n\
        setp lincurve.0.x-val-01 100\n\
        setp lincurve.0.y-val-01 20\n\
        setp lincurve.0.x-val-02 160\n\
        setp lincurve.0.y-val-02 40\n\
        setp lincurve.0.in 50\n\
        run 1ms\n\
        getp lincurve.0.out # -> 10\n\
        setp lincurve.0.in 130\n\
        run 1ms\n\
        getp lincurve.0.out # -> 30\n\
        setp lincurve.0.in 1000\n\
        run 1ms\n\
        getp lincurve.0.out # -> 40\n\
        ```";
    const FLAGS: u32 = component_flags::PERSONALITY | component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let n = b.size("Parameter x-val-##", DEFAULT, MAX)?;
        let input = b.item("in", "Position x on the curve, in the unit of the points' x.", 0.0)?;
        let out = b.item(
            "out",
            "Value y of the curve at this position, in the unit of the points' y.",
            0.0,
        )?;
        let doc = "Same as `out`, in its unit, for linking to a bidirectional pin, such as a gain.";
        let out_io = b.item("out-io", doc, 0.0)?;
        let mut points = Vec::new();
        for i in 0..n {
            let x = "Position x of this point, in the unit of `in`; not less than that of the \
                previous point.";
            let x = b.item(&format!("x-val-{i:02}"), x, 0.0)?;
            let y = b.item(
                &format!("y-val-{i:02}"),
                "Value y of this point, in the unit of `out`.",
                0.0,
            )?;
            points.push((x, y));
        }
        b.function("", "Evaluates the curve.", Self { input, out, out_io, points, line: 0 })
    }
}

impl Update for Lincurve {
    fn update(&mut self, _: Period) {
        let y = self.height(self.input.get());
        self.out.set(y);
        self.out_io.set(y);
    }
}

impl Lincurve {
    fn height(&mut self, x: f64) -> f64 {
        let end = |point: Option<&(ParamRw<f64>, ParamRw<f64>)>| {
            point.map_or((0.0, 0.0), |(x, y)| (x.get(), y.get()))
        };
        let (first, last) = (end(self.points.first()), end(self.points.last()));
        if x >= last.0 {
            return last.1;
        }
        if x <= first.0 {
            return first.1;
        }
        // Starts at the segment of the previous cycle; if the points are not in order, that segment is kept longest.
        while self.points.get(self.line + 1).is_some_and(|(right, _)| x > right.get()) {
            self.line += 1;
        }
        while self.line > 0 && self.points.get(self.line).is_some_and(|(left, _)| x < left.get()) {
            self.line -= 1;
        }
        let (left, right) = (end(self.points.get(self.line)), end(self.points.get(self.line + 1)));
        let share = (x - left.0) / (right.0 - left.0);
        left.1 + share * (right.1 - left.1)
    }
}

#[cfg(test)]
mod tests {
    use super::Lincurve;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn lines_between_points_and_level_beyond() {
        let rows = replay::<Lincurve>(
            "load lincurve personality=3
             set lincurve.0.x-val-00 -1
             set lincurve.0.y-val-00 10
             set lincurve.0.x-val-01 1
             set lincurve.0.y-val-01 20
             set lincurve.0.x-val-02 3
             set lincurve.0.y-val-02 0
             run lincurve.0
             in lincurve.0.in
             out lincurve.0.out lincurve.0.out-io
             -5 | 10 10
             -1 | 10 10
             0 | 15 15
             1 | 20 20
             1.5 | 15 15
             3 | 0 0
             inf | 0 0
             -inf | 10 10
             nan | nan nan",
        );
        assert_eq!(rows, 9);
    }

    #[test]
    fn one_to_sixteen_points() {
        let mut bench = Bench::new();
        bench.load::<Lincurve>(&["personality=16"]).unwrap();
        assert_eq!(bench.names().len(), 35);
        let refused = Bench::new().load::<Lincurve>(&["personality=17"]).unwrap_err();
        assert!(refused.starts_with(
            "Parameter x-val-##: Requested size 17 exceeds max size 16: personality= is 1 to "
        ));
    }
}
