//! PNG files in memory.

/// A picture of `width` x `height` pixels, each red, green, blue, row by row from the top.
pub(crate) fn png(width: usize, height: usize, pixels: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().expect("a header fits into memory");
    writer.write_image_data(pixels).expect("the pixels fill the size given above");
    writer.finish().expect("the end fits into memory");
    file
}
