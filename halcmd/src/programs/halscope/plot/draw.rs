//! A picture of a trace: a lane for each channel above one time axis.

use super::lane::Lane;
use crate::programs::{
    halscope::{
        figures::{figures, unit_of},
        names::Chosen,
    },
    picture::{Area, COLOURS, INK, LARGEST, MARK, PALE, Painted, Picture, text},
};
use hal_trace::Trace;
use plotters::{
    backend::DrawingBackend,
    chart::ChartBuilder,
    element::{PathElement, Rectangle},
    style::{
        Color, RGBColor, ShapeStyle, WHITE,
        text_anchor::{HPos, Pos, VPos},
    },
};

const TOP: u32 = 46;
const BOTTOM: u32 = 54;
/// Space for names, and for the numbers of a scale.
const NAMES: u32 = 210;
const SCALE: u32 = 62;
const RIGHT: u32 = 24;
const BIT: u32 = 52;
const NUMBER: u32 = 130;

/// Content and size of a picture.
#[derive(Debug)]
pub(super) struct Plot<'t> {
    trace: &'t Trace,
    chosen: Vec<Chosen>,
    from: i64,
    to: i64,
    title: String,
    is_pixels: bool,
    /// Time of the axis's 0.
    pub(super) zero: i64,
    pub(super) measures: bool,
    pub(super) width: u32,
    /// Height in pixels; 0 for the height that the channels need.
    pub(super) height: u32,
}

impl<'t> Plot<'t> {
    /// Selects channels and a time window. The 0 of the axis is a trigger within the window, or
    /// else the beginning of machine time.
    pub(super) fn new(
        trace: &'t Trace,
        chosen: Vec<Chosen>,
        from: i64,
        to: i64,
        title: String,
    ) -> Self {
        let within = |at: i64| from <= at && at <= to;
        let trigger =
            trace.markers().iter().find(|m| within(m.at) && m.text.starts_with("trigger"));
        let zero = trigger.map_or(0, |m| m.at);
        Self {
            trace,
            chosen,
            from,
            to,
            title,
            is_pixels: false,
            zero,
            measures: false,
            width: 1200,
            height: 0,
        }
    }

    /// Returns the picture as SVG.
    pub(super) fn svg(&mut self) -> Result<String, String> {
        self.is_pixels = false;
        self.to_svg()
    }

    /// Returns the picture as PNG.
    pub(super) fn png(&mut self) -> Result<Vec<u8>, String> {
        self.is_pixels = true;
        self.to_png()
    }
}

impl Picture for Plot<'_> {
    fn size(&self) -> (u32, u32) {
        let is_bit = |c: &Chosen| {
            self.trace.channels().get(c.channel).is_some_and(|c| c.ty() == hal_protocol::Type::Bit)
        };
        let lanes = self.chosen.iter().map(|c| if is_bit(c) { BIT } else { NUMBER });
        let needed = lanes.fold(TOP + BOTTOM, u32::saturating_add).min(LARGEST);
        (self.width, if self.height == 0 { needed } else { self.height })
    }

    fn paint<D: DrawingBackend>(&self, root: &Area<'_, D>) -> Painted<D> {
        let (width, height) = self.size();
        root.fill(&WHITE)?;
        let title = text(19, INK).pos(Pos::new(HPos::Left, VPos::Top));
        root.draw_text(&self.title, &title, (16, 12))?;
        let columns = width.saturating_sub(NAMES + SCALE + RIGHT) as usize;
        let lanes =
            self.chosen.iter().map(|c| Lane::new(self.trace, c, self.from, self.to, columns));
        let lanes: Vec<Lane> = lanes.collect();
        let weight = |l: &Lane| if l.is_bit { BIT } else { NUMBER };
        let total = lanes.iter().map(weight).sum::<u32>().max(1);
        let room = height.saturating_sub(TOP + BOTTOM);
        let mut done = 0;
        for (i, lane) in lanes.iter().enumerate() {
            // Each lane's share of the height, exact to the pixel.
            let top = TOP + share(room, done, total);
            done += weight(lane);
            let bottom = TOP + share(room, done, total);
            let is_last = i + 1 == lanes.len();
            let colour = COLOURS.iter().cycle().nth(i).copied().unwrap_or(INK);
            let end = if is_last { height } else { bottom };
            let (_, below) = root.split_vertically(top);
            let (area, _) = below.split_vertically(end.saturating_sub(top));
            self.lane(&area, lane, colour, bottom.saturating_sub(top), is_last)?;
        }
        self.markers(root, room)
    }
}

impl Plot<'_> {
    fn lane<D: DrawingBackend>(
        &self,
        area: &Area<'_, D>,
        lane: &Lane,
        colour: RGBColor,
        height: u32,
        is_last: bool,
    ) -> Painted<D> {
        let base = self.trace.base();
        let seconds = |ticks: i64| base.seconds(ticks.saturating_sub(self.zero));
        let (from, to) = (seconds(self.from), seconds(self.to));
        let (factor, unit) = unit_of(from.abs().max(to.abs()), "s");
        let mut chart = ChartBuilder::on(area);
        chart.margin_left(NAMES).margin_right(RIGHT).margin_top(3).y_label_area_size(SCALE);
        chart.x_label_area_size(if is_last { BOTTOM } else { 3 });
        let scale = lane.scale.0..lane.scale.1;
        let mut chart = chart.build_cartesian_2d(from * factor..to * factor, scale)?;
        let mut mesh = chart.configure_mesh();
        mesh.axis_style(PALE.mix(0.5))
            .light_line_style(WHITE.mix(0.0))
            .bold_line_style(PALE.mix(0.18));
        mesh.label_style(text(12, INK)).x_labels(10);
        let number = |v: &f64| figures(*v);
        let described = self.axis(&unit);
        mesh.y_labels(if lane.is_bit { 0 } else { 4 }).y_label_formatter(&number);
        let nothing = |_: &f64| String::new();
        let label: &dyn Fn(&f64) -> String = if is_last { &number } else { &nothing };
        mesh.x_label_formatter(label).axis_desc_style(text(13, INK));
        if is_last {
            mesh.x_desc(&described);
        }
        if lane.is_bit {
            mesh.disable_y_mesh();
        }
        mesh.draw()?;
        for piece in &lane.pieces {
            let points: Vec<(f64, f64)> =
                piece.iter().map(|(at, v)| (seconds(*at) * factor, *v)).collect();
            let style = ShapeStyle { color: colour.to_rgba(), filled: false, stroke_width: 2 };
            // Thick pixel lines lose edges that are closer than a pixel, so each segment is drawn
            // as a line of its own.
            let count = if self.is_pixels { 2 } else { points.len() };
            let lines = points.windows(count).map(|p| PathElement::new(p.to_vec(), style));
            chart.draw_series(lines)?;
        }
        self.gaps(&mut |a, b| {
            let corners =
                [(seconds(a) * factor, lane.scale.0), (seconds(b) * factor, lane.scale.1)];
            let band = Rectangle::new(corners, MARK.mix(0.15).filled());
            chart.draw_series(std::iter::once(band)).map(|_| ())
        })?;
        self.beside(area, lane, colour, height)
    }

    /// Draws the name, further names, and the measurements.
    fn beside<D: DrawingBackend>(
        &self,
        area: &Area<'_, D>,
        lane: &Lane,
        colour: RGBColor,
        height: u32,
    ) -> Painted<D> {
        let mut lines = vec![(text(14, colour), lane.name.clone())];
        lines.extend(lane.other.iter().map(|other| (text(12, PALE), format!("= {other}"))));
        if self.measures {
            lines.extend(summary(lane).map(|line| (text(12, PALE), line)));
        }
        let step = 15;
        let (height, count) = (pixels(height), i32::try_from(lines.len()).unwrap_or(0));
        for (i, (style, line)) in (0..).zip(&lines) {
            let style = style.pos(Pos::new(HPos::Left, VPos::Center));
            area.draw_text(line, &style, (16, (height - (count - 1) * step) / 2 + i * step))?;
        }
        Ok(())
    }

    /// Returns the description of the axis.
    fn axis(&self, unit: &str) -> String {
        let zero = self.trace.base().seconds(self.zero);
        let (factor, of) = unit_of(zero.abs(), "s");
        match self.zero {
            0 => format!("machine time, {unit}"),
            _ => format!("time, {unit}; 0 is at {} {of} of machine time", figures(zero * factor)),
        }
    }

    /// Draws each interval before which samples are missing.
    fn gaps<E>(&self, paint: &mut dyn FnMut(i64, i64) -> Result<(), E>) -> Result<(), E> {
        let times = self.trace.times();
        for gap in self.trace.gaps() {
            let before = gap.sample.checked_sub(1).and_then(|s| times.get(s));
            let (Some(before), Some(after)) = (before, times.get(gap.sample)) else { continue };
            if before < self.to && after > self.from {
                paint(before.max(self.from), after.min(self.to))?;
            }
        }
        Ok(())
    }

    /// Draws markers: a line through all lanes, with the text above.
    fn markers<D: DrawingBackend>(&self, root: &Area<'_, D>, room: u32) -> Painted<D> {
        let (left, right) = (NAMES + SCALE, self.width.saturating_sub(RIGHT));
        let span = (self.to - self.from).max(1) as f64;
        let within = |at: i64| self.from <= at && at <= self.to;
        for marker in self.trace.markers().iter().filter(|m| within(m.at)) {
            let share = (marker.at - self.from) as f64 / span;
            let x = f64::from(left) + share * f64::from(right.saturating_sub(left));
            #[expect(clippy::cast_possible_truncation, reason = "within the picture's width")]
            let x = x.round() as i32;
            let line = vec![(x, pixels(TOP) - 6), (x, pixels(TOP + room))];
            root.draw(&PathElement::new(line, MARK.mix(0.8).stroke_width(1)))?;
            // A text that would leave the picture stands on the other side of the line.
            let is_late = share > 0.6;
            let side = if is_late { HPos::Right } else { HPos::Left };
            let style = text(12, MARK).pos(Pos::new(side, VPos::Bottom));
            root.draw_text(&marker.text, &style, (x + if is_late { -5 } else { 5 }, pixels(TOP)))?;
        }
        Ok(())
    }
}

fn share(room: u32, part: u32, total: u32) -> u32 {
    u32::try_from(u64::from(room) * u64::from(part) / u64::from(total)).unwrap_or(room)
}

fn pixels(n: u32) -> i32 {
    i32::try_from(n).unwrap_or(i32::MAX)
}

/// Describes the measurements in a line.
fn summary(lane: &Lane) -> Option<String> {
    let m = &lane.measures;
    match (m.frequency.zip(m.duty), m.min.zip(m.max)) {
        (Some((frequency, duty)), _) if lane.is_bit => {
            let (factor, unit) = unit_of(frequency, "Hz");
            Some(format!(
                "{} {unit}, high {} %",
                figures(frequency * factor),
                figures(duty * 100.0)
            ))
        }
        (None, Some(_)) if lane.is_bit => Some(format!("{} rises, {} falls", m.rises, m.falls)),
        (_, range) => range.map(|(min, max)| format!("{} to {}", figures(min), figures(max))),
    }
}

#[cfg(test)]
mod tests {
    use super::{NAMES, Plot, RIGHT, SCALE};
    use crate::programs::halscope::names::chosen;
    use hal_protocol::Type;
    use hal_trace::Trace;

    /// A trace with a bit that rises after a quarter of the time, and a number.
    fn trace() -> Trace {
        let mut t = Trace::default();
        t.add("a.bit", Type::Bit);
        t.add("a<number>", Type::Float);
        t.also(0, "signal");
        for i in 0..=100_u32 {
            let number = f64::from(i) / 2.0;
            t.push(i64::from(i) * 1000, &[u64::from(i >= 25), number.to_bits()]).unwrap();
        }
        t.mark(50_000, "trigger: a.bit is 1");
        t
    }

    fn plot(trace: &Trace, words: &[&str]) -> String {
        let words: Vec<String> = words.iter().map(|w| (*w).to_owned()).collect();
        let chosen = chosen(trace, &words, "t").unwrap();
        let mut plot = Plot::new(trace, chosen, 0, 100_000, "A title".to_owned());
        plot.measures = true;
        plot.svg().unwrap()
    }

    #[test]
    fn an_edge_is_drawn_where_it_is() {
        let svg = plot(&trace(), &["signal"]);
        let line = svg.lines().filter(|l| l.contains("polyline") && l.contains("#0072B2"));
        let points: Vec<&str> =
            line.flat_map(|l| l.split('"')).filter(|p| p.contains(',')).collect();
        let points: Vec<f64> = points[0]
            .split_whitespace()
            .map(|p| p.split(',').next().unwrap().parse().unwrap())
            .collect();
        let (left, right) = (f64::from(NAMES + SCALE), f64::from(1200 - RIGHT));
        let edge = left + (right - left) / 4.0;
        assert_eq!(points.len(), 4, "two levels: {points:?}");
        assert!(points[1..3].iter().all(|x| (x - edge).abs() <= 1.5), "{points:?}, {edge}");
        assert!((points[3] - right).abs() <= 1.5, "{points:?}, {right}");
    }

    #[test]
    fn a_picture_says_what_it_shows() {
        let svg = plot(&trace(), &[]);
        for text in [
            "A title",
            "a.bit",
            "= signal",
            "a&lt;number&gt;",
            "1 rises, 0 falls",
            "0 to 50",
            "trigger",
        ] {
            assert!(svg.contains(text), "{text}: {svg}");
        }
        assert!(svg.contains("time, µs; 0 is at 50 µs of machine time"), "{svg}");
        assert_eq!(plot(&trace(), &[]), svg, "the same on every run");
    }

    /// Returns width, height, and three bytes for each pixel.
    fn pixels(plot: &mut Plot<'_>) -> (usize, usize, Vec<u8>) {
        let bytes = plot.png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        (info.width as usize, info.height as usize, pixels)
    }

    #[test]
    fn a_png_has_the_size_and_is_not_white() {
        let trace = trace();
        let mut plot =
            Plot::new(&trace, chosen(&trace, &[], "t").unwrap(), 0, 100_000, String::new());
        (plot.width, plot.height) = (640, 300);
        let (width, height, pixels) = pixels(&mut plot);
        assert_eq!((width, height), (640, 300));
        assert!(pixels.chunks(3).any(|p| p == [0, 114, 178]), "a line has its colour");
    }

    #[test]
    fn a_pulse_that_is_thinner_than_a_pixel_is_drawn() {
        let mut t = Trace::default();
        t.add("b", Type::Bit);
        for (at, bit) in [(0, 0), (500_000, 1), (500_001, 0), (1_000_000, 0)] {
            t.push(at, &[bit]).unwrap();
        }
        let mut plot = Plot::new(&t, chosen(&t, &[], "t").unwrap(), 0, 1_000_000, String::new());
        let (width, _, pixels) = pixels(&mut plot);
        let column = width - RIGHT as usize - (width - (NAMES + SCALE + RIGHT) as usize) / 2;
        let lines = pixels.chunks(width * 3).filter(|line| {
            let near = &line[(column - 3) * 3..(column + 3) * 3];
            near.chunks(3).any(|p| p[0] < 128 && p[2] > 128)
        });
        assert!(lines.count() > 25, "a line from low to high");
    }
}
