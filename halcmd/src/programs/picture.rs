//! Pictures for reports, in SVG and PNG: the formats, the colours and the font.

use plotters::{
    backend::{BitMapBackend, DrawingBackend, SVGBackend},
    coord::Shift,
    drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea},
    style::{Color, FontStyle, IntoFont, RGBColor, TextStyle, register_font},
};
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, DrawingErrorKind};
use std::path::Path;

/// Colours that eyes of all kinds tell apart (Okabe and Ito, 2008), without their yellow.
pub(crate) const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
];
/// The colour of text.
pub(crate) const INK: RGBColor = RGBColor(31, 41, 51);
/// The colour of axes and remarks.
pub(crate) const PALE: RGBColor = RGBColor(107, 114, 128);
/// The colour of limits and markers.
pub(crate) const MARK: RGBColor = RGBColor(160, 30, 60);
const FONT: &str = "DejaVu Sans";

/// The largest side in pixels.
pub(crate) const LARGEST: u32 = 16_384;

/// An area of a picture.
pub(crate) type Area<'a, D> = DrawingArea<D, Shift>;

/// The result of painting.
pub(crate) type Painted<D> = Result<(), DrawingAreaErrorKind<<D as DrawingBackend>::ErrorType>>;

/// A picture that knows its size.
pub(crate) trait Picture {
    /// Returns width and height in pixels.
    fn size(&self) -> (u32, u32);

    /// Paints it.
    ///
    /// # Errors
    /// The backend refuses.
    fn paint<D: DrawingBackend>(&self, root: &Area<'_, D>) -> Painted<D>;

    /// Returns the picture as SVG.
    ///
    /// # Errors
    /// The picture cannot be drawn.
    fn to_svg(&self) -> Result<String, String> {
        let mut text = String::new();
        self.draw(SVGBackend::with_string(&mut text, self.size()))?;
        Ok(text)
    }

    /// Returns the picture as PNG.
    ///
    /// # Errors
    /// The picture cannot be drawn.
    fn to_png(&self) -> Result<Vec<u8>, String> {
        let (width, height) = self.size();
        let mut pixels = vec![0; width as usize * height as usize * 3];
        self.draw(Smooth(BitMapBackend::with_buffer(&mut pixels, (width, height))))?;
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let written = encoder.write_header().and_then(|mut w| w.write_image_data(&pixels));
        written.map_err(|e| e.to_string())?;
        Ok(bytes)
    }

    /// Draws the picture with a backend.
    ///
    /// # Errors
    /// The picture cannot be drawn.
    fn draw<D: DrawingBackend>(&self, backend: D) -> Result<(), String> {
        register_font(FONT, FontStyle::Normal, dejavu::sans::regular())
            .map_err(|_| "the font cannot be read")?;
        let root = backend.into_drawing_area();
        self.paint(&root).map_err(|e| e.to_string())?;
        root.present().map_err(|e| e.to_string())
    }
}

/// A bitmap with anti-aliased thin lines. Those of `BitMapBackend` lack the last pixel where they fall, so that curves of
/// short lines look dashed.
struct Smooth<'a>(BitMapBackend<'a>);

type Failed<'a> = DrawingErrorKind<<BitMapBackend<'a> as DrawingBackend>::ErrorType>;

impl<'a> DrawingBackend for Smooth<'a> {
    type ErrorType = <BitMapBackend<'a> as DrawingBackend>::ErrorType;

    fn get_size(&self) -> (u32, u32) {
        self.0.get_size()
    }

    fn ensure_prepared(&mut self) -> Result<(), Failed<'a>> {
        self.0.ensure_prepared()
    }

    fn present(&mut self) -> Result<(), Failed<'a>> {
        self.0.present()
    }

    fn draw_pixel(&mut self, at: BackendCoord, colour: BackendColor) -> Result<(), Failed<'a>> {
        self.0.draw_pixel(at, colour)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Result<(), Failed<'a>> {
        let straight = from.0 == to.0 || from.1 == to.1;
        if straight || style.stroke_width() != 1 || style.color().alpha == 0.0 {
            return self.0.draw_line(from, to, style);
        }
        // Coordinates of points far outside the picture are saturated, so their differences may exceed an i32.
        let steep = to.0.abs_diff(from.0) < to.1.abs_diff(from.1);
        let turned = |(x, y): BackendCoord| if steep { (y, x) } else { (x, y) };
        let (a, b) = (turned(from), turned(to));
        let (a, b) = if a.0 < b.0 { (a, b) } else { (b, a) };
        let slope = (f64::from(b.1) - f64::from(a.1)) / (f64::from(b.0) - f64::from(a.0));
        let (width, height) = self.get_size();
        let end = i32::try_from(if steep { height } else { width }).unwrap_or(i32::MAX);
        for x in a.0.max(0)..=b.0.min(end) {
            let y = f64::from(a.1) + slope * (f64::from(x) - f64::from(a.0));
            #[expect(clippy::cast_possible_truncation, reason = "between two coordinates")]
            let below = y.floor() as i32;
            let share = y - y.floor();
            // A line between two rows of pixels shares its colour between them.
            for (row, part) in [(below, 1.0 - share), (below.saturating_add(1), share)] {
                if part > 0.0 {
                    let colour = style.color();
                    let colour = BackendColor { alpha: colour.alpha * part, ..colour };
                    self.0.draw_pixel(turned((x, row)), colour)?;
                }
            }
        }
        Ok(())
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        upper_left: BackendCoord,
        bottom_right: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Result<(), Failed<'a>> {
        self.0.draw_rect(upper_left, bottom_right, style, fill)
    }
}

/// The format of a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind {
    /// SVG.
    Svg,
    /// PNG.
    Png,
}

impl Kind {
    /// Returns the format that the ending of a file's name says.
    ///
    /// # Errors
    /// It says none.
    pub(crate) fn of(path: &Path) -> Result<Self, String> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("svg") => Ok(Self::Svg),
            Some("png") => Ok(Self::Png),
            _ => Err(format!("{}: a picture ends in .svg or .png", path.display())),
        }
    }

    /// Returns the bytes of a picture in this format.
    ///
    /// # Errors
    /// The picture cannot be drawn.
    pub(crate) fn bytes(self, picture: &impl Picture) -> Result<Vec<u8>, String> {
        match self {
            Self::Svg => picture.to_svg().map(String::into_bytes),
            Self::Png => picture.to_png(),
        }
    }
}

/// Returns the size that a text states as `WIDTHxHEIGHT`.
///
/// # Errors
/// It states none, or one out of range.
pub(crate) fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |t: &str| t.trim().parse().ok().filter(|n| (100..=LARGEST).contains(n));
    let sides = text.split_once('x').and_then(|(w, h)| side(w).zip(side(h)));
    sides.ok_or_else(|| format!("'{text}' is not a size: WIDTHxHEIGHT, each from 100 to {LARGEST}"))
}

/// Returns the style of a text.
pub(crate) fn text(size: i32, colour: RGBColor) -> TextStyle<'static> {
    let mut style = TextStyle::from((FONT, size).into_font());
    style.color = colour.to_backend_color();
    style
}
