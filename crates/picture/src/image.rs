//! Raster images and their PNG encoding.

use std::io;

use crate::color::Color;

/// Raster image of colors, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: usize,
    height: usize,
    pixels: Vec<Color>,
}

impl Image {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![Color::WHITE; width * height] }
    }

    pub(crate) fn pixels_mut(&mut self) -> &mut [Color] {
        &mut self.pixels
    }

    /// Adds the rows of a picture of the same width.
    pub(crate) fn add_below(&mut self, other: &Self) {
        self.pixels.extend(&other.pixels);
        self.height += other.height;
    }

    /// Joins pictures of one height side by side.
    #[must_use]
    pub fn beside(images: &[Self]) -> Self {
        // As wide as all together, as high as the highest.
        let width = images.iter().map(|image| image.width).sum();
        let height = images.iter().map(|image| image.height).max().unwrap_or(0);
        let mut joined = Self::new(width, height);

        // Row by row, each image right of the one before.
        let mut left = 0;
        for image in images {
            for (row, colors) in image.pixels.chunks_exact(image.width).enumerate() {
                joined.pixels[row * width + left..][..image.width].copy_from_slice(colors);
            }
            left += image.width;
        }
        joined
    }

    /// Encodes the picture as a PNG file.
    ///
    /// # Errors
    ///
    /// The picture is empty or has more than 2³² pixels along a side.
    pub fn to_png(&self) -> io::Result<Vec<u8>> {
        // Eight bits per channel, in sRGB.
        let [width, height] = [self.width, self.height].map(u32::try_from);
        let [width, height] = [width.map_err(io::Error::other)?, height.map_err(io::Error::other)?];
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);

        // All pixels at once.
        let mut pixels = Vec::with_capacity(3 * self.pixels.len());
        for color in &self.pixels {
            pixels.extend(color.to_srgb());
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&pixels)?;
        writer.finish()?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_picture_reads_back() {
        let mut image = Image::new(3, 2);
        image.pixels_mut()[4] = Color::from_srgb([200, 100, 50]);
        let bytes = Image::beside(&[image.clone(), image]).to_png().unwrap();
        let mut reader = png::Decoder::new(io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!((reader.info().width, reader.info().height), (6, 2));
        assert_eq!(pixels[3 * 7..3 * 8], [200, 100, 50]);
        assert_eq!(pixels[3 * 10..3 * 11], [200, 100, 50]);
        assert_eq!(pixels[..3], [255; 3]);
    }
}
