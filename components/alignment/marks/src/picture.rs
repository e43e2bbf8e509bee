//! Grey pictures.

use core::fmt;
use std::io::Cursor;
use zune_core::{colorspace::ColorSpace, options::DecoderOptions};
use zune_jpeg::JpegDecoder;

/// Largest width and height of a picture, in pixels.
pub const MAX_SIDE: u32 = 8192;
/// Largest size of a picture's file, in bytes.
pub const MAX_BYTES: usize = 32 << 20;
/// Largest memory for decoding, in bytes.
const MAX_MEMORY: usize = 256 << 20;

/// Grey picture: rows from the top, 0 is black.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}

/// Reason why bytes are no usable picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureProblem {
    /// Neither a JPEG nor a PNG file.
    Format,
    /// More bytes than are allowed.
    Large,
    /// A JPEG file with this number of colours, which is neither grey nor red, green and blue.
    Colours(u8),
    /// A side of 0 or too many pixels.
    Sides(u32, u32),
    /// A file that is cut off or broken.
    Broken,
}

impl fmt::Display for PictureProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Format => f.write_str("the picture is neither JPEG nor PNG"),
            Self::Large => write!(f, "the picture has more than {MAX_BYTES} bytes"),
            Self::Colours(n) => {
                write!(f, "the picture has {n} colours: 1 (grey) or 3 (red, green, blue) are read")
            }
            Self::Sides(w, h) => write!(
                f,
                "the picture has {w} x {h} pixels: each side must be between 1 and {MAX_SIDE}"
            ),
            Self::Broken => f.write_str("the picture is cut off or broken"),
        }
    }
}

impl Picture {
    /// Returns a picture with these pixels. Rows that are missing are black.
    #[must_use]
    pub fn new(width: usize, height: usize, mut pixels: Vec<u8>) -> Self {
        pixels.resize(width.saturating_mul(height), 0);
        Self { width, height, pixels }
    }

    /// Decodes a JPEG or PNG file.
    ///
    /// # Errors
    /// The bytes are no such file, too many, or broken.
    pub fn decode(bytes: &[u8]) -> Result<Self, PictureProblem> {
        if bytes.len() > MAX_BYTES {
            return Err(PictureProblem::Large);
        }
        match bytes {
            [0xff, 0xd8, 0xff, ..] => jpeg(bytes),
            [0x89, b'P', b'N', b'G', ..] => png(bytes),
            _ => Err(PictureProblem::Format),
        }
    }

    /// Returns the picture as a PNG file.
    #[must_use]
    pub fn png(&self) -> Vec<u8> {
        let side = |n: usize| u32::try_from(n).unwrap_or(0);
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, side(self.width), side(self.height));
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Eight);
        let written = encoder.write_header().and_then(|mut w| w.write_image_data(&self.pixels));
        // An empty picture is no PNG file.
        if written.is_ok() { out } else { Vec::new() }
    }

    /// Returns its width in pixels.
    #[must_use]
    pub const fn width(&self) -> usize {
        self.width
    }

    /// Returns its height in pixels.
    #[must_use]
    pub const fn height(&self) -> usize {
        self.height
    }

    /// Returns its pixels, row by row from the top.
    #[must_use]
    pub fn pixels(&self) -> &[u8] {
        &self.pixels
    }

    /// Returns a pixel; beyond the border, the one nearest to it.
    #[must_use]
    pub fn at(&self, x: usize, y: usize) -> u8 {
        let x = x.min(self.width.saturating_sub(1));
        let y = y.min(self.height.saturating_sub(1));
        self.pixels.get(y * self.width + x).copied().unwrap_or(0)
    }
}

/// Checks the sides of a picture.
fn sides(width: u32, height: u32) -> Result<(usize, usize), PictureProblem> {
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
        return Err(PictureProblem::Sides(width, height));
    }
    let side = |n: u32| usize::try_from(n).unwrap_or(0);
    Ok((side(width), side(height)))
}

/// Decodes a JPEG file.
fn jpeg(bytes: &[u8]) -> Result<Picture, PictureProblem> {
    // The decoder fills the rest of a cut file with grey: its end mark tells.
    let end = bytes.iter().rposition(|b| *b != 0).map_or(0, |n| n + 1);
    if !bytes.get(..end).is_some_and(|whole| whole.ends_with(&[0xff, 0xd9])) {
        return Err(PictureProblem::Broken);
    }
    // Any side that a file can state: `sides` refuses it by its number.
    let side = usize::from(u16::MAX);
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .set_max_width(side)
        .set_max_height(side)
        .jpeg_set_out_colorspace(ColorSpace::Luma);
    let mut decoder = JpegDecoder::new_with_options(Cursor::new(bytes), options);
    decoder.decode_headers().map_err(|_| PictureProblem::Broken)?;
    let info = decoder.info().ok_or(PictureProblem::Broken)?;
    let (width, height) = sides(info.width.into(), info.height.into())?;
    if !matches!(info.components, 1 | 3) {
        return Err(PictureProblem::Colours(info.components));
    }
    let pixels = decoder.decode().map_err(|_| PictureProblem::Broken)?;
    if pixels.len() != width * height {
        return Err(PictureProblem::Broken);
    }
    Ok(Picture { width, height, pixels })
}

/// Decodes a PNG file.
fn png(bytes: &[u8]) -> Result<Picture, PictureProblem> {
    let broken = |_| PictureProblem::Broken;
    let limits = png::Limits { bytes: MAX_MEMORY };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    let header = decoder.read_header_info().map_err(broken)?;
    let (width, height) = sides(header.width, header.height)?;
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(broken)?;
    let size = reader.output_buffer_size().filter(|n| *n <= MAX_MEMORY);
    let mut data = vec![0; size.ok_or(PictureProblem::Broken)?];
    reader.next_frame(&mut data).map_err(broken)?;
    let channels = match reader.output_color_type().0 {
        png::ColorType::Grayscale | png::ColorType::Indexed => 1,
        png::ColorType::GrayscaleAlpha => 2,
        png::ColorType::Rgb => 3,
        png::ColorType::Rgba => 4,
    };
    let grey = |p: &[u8]| match *p {
        // Weights of the three colours, as television has them (Recommendation BT.601).
        [r, g, b, ..] => {
            let sum = 299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b);
            u8::try_from((sum + 500) / 1000).unwrap_or(u8::MAX)
        }
        [v, ..] => v,
        [] => 0,
    };
    let pixels: Vec<u8> = data.chunks_exact(channels).map(grey).collect();
    if pixels.len() != width * height {
        return Err(PictureProblem::Broken);
    }
    Ok(Picture { width, height, pixels })
}

/// Returns a picture smoothed by a Gaussian of this deviation in pixels.
pub(crate) fn smooth(values: &[f32], width: usize, height: usize, sigma: f64) -> Vec<f32> {
    let reach = [1_usize, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12];
    let reach = reach.iter().copied().find(|n| *n as f64 >= 3.0 * sigma).unwrap_or(12);
    let weight = |n: usize| libm::exp(-((n * n) as f64) / (2.0 * sigma * sigma));
    let sum = 1.0 + 2.0 * (1..=reach).map(weight).sum::<f64>();
    #[expect(clippy::cast_possible_truncation, reason = "pixels need no more digits")]
    let weights: Vec<f32> = (0..=reach).map(|n| (weight(n) / sum) as f32).collect();
    let pass = |from: &[f32], length: usize, lines: usize, step: usize, stride: usize| {
        let mut out = vec![0.0_f32; from.len()];
        for line in 0..lines {
            for n in 0..length {
                let value =
                    |at: usize| from.get(line * stride + at * step).copied().unwrap_or_default();
                let mut total = 0.0;
                for (k, weight) in weights.iter().enumerate() {
                    let low = value(n.saturating_sub(k));
                    total += weight * low;
                    if k > 0 {
                        total += weight * value((n + k).min(length - 1));
                    }
                }
                if let Some(to) = out.get_mut(line * stride + n * step) {
                    *to = total;
                }
            }
        }
        out
    };
    let rows = pass(values, width, height, 1, width);
    pass(&rows, height, width, width, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> Picture {
        let pixels = (0..60 * 40).map(|n| u8::try_from(n % 251).unwrap()).collect();
        Picture::new(60, 40, pixels)
    }

    fn jpeg_of(picture: &Picture) -> Vec<u8> {
        let mut out = Vec::new();
        let sides = [picture.width, picture.height].map(|n| u16::try_from(n).unwrap());
        let encoder = jpeg_encoder::Encoder::new(&mut out, 90);
        let colour = jpeg_encoder::ColorType::Luma;
        encoder.encode(&picture.pixels, sides[0], sides[1], colour).unwrap();
        out
    }

    #[test]
    fn files_are_read_as_they_were_written() {
        assert_eq!(Picture::decode(&picture().png()).unwrap(), picture());
        let jpeg = Picture::decode(&jpeg_of(&picture())).unwrap();
        assert_eq!((jpeg.width(), jpeg.height()), (60, 40));
    }

    #[test]
    fn garbage_is_refused_by_name() {
        assert_eq!(Picture::decode(b""), Err(PictureProblem::Format));
        assert_eq!(Picture::decode(b"GIF89a..."), Err(PictureProblem::Format));
        assert_eq!(Picture::decode(&[0xff, 0xd8, 0xff, 0xd9]), Err(PictureProblem::Broken));
        for file in [jpeg_of(&picture()), picture().png()] {
            for end in (4..file.len()).step_by(7) {
                assert!(Picture::decode(&file[..end]).is_err(), "{end} of {}", file.len());
            }
            // A changed byte may leave a picture; it must not panic.
            for at in 4..file.len() {
                let mut bad = file.clone();
                bad[at] ^= 0x55;
                let _ = Picture::decode(&bad).map(|p| p.pixels().len());
            }
        }
        let mut jpeg = jpeg_of(&picture());
        let frame = jpeg.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
        jpeg[frame + 5..frame + 9].fill(0xff);
        assert_eq!(Picture::decode(&jpeg), Err(PictureProblem::Sides(65535, 65535)));
        let mut cmyk = Vec::new();
        let encoder = jpeg_encoder::Encoder::new(&mut cmyk, 90);
        encoder.encode(&[9; 64 * 4], 8, 8, jpeg_encoder::ColorType::Cmyk).unwrap();
        assert_eq!(Picture::decode(&cmyk), Err(PictureProblem::Colours(4)));
        let many = vec![0xff; MAX_BYTES + 1];
        assert_eq!(Picture::decode(&many), Err(PictureProblem::Large));
    }

    #[test]
    fn a_picture_with_too_many_pixels_is_refused_before_it_is_decoded() {
        let mut png = picture().png();
        // The width in the header, and its checksum.
        png[16..20].copy_from_slice(&20_000_u32.to_be_bytes());
        let header = png[12..29].to_vec();
        let crc = header.iter().fold(u32::MAX, |crc, b| {
            (0..8).fold(crc ^ u32::from(*b), |c, _| {
                if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 }
            })
        });
        png[29..33].copy_from_slice(&(!crc).to_be_bytes());
        assert_eq!(Picture::decode(&png), Err(PictureProblem::Sides(20_000, 40)));
    }
}
