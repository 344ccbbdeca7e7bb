use super::*;
use crate::color::{Photometry, rec709_from_xyz};
use crate::image::{Region, SpectralImage};
use crate::output::scratch::ScratchFolder;
use crate::spectrum::WavelengthGrid;

/// Values from subnormal to 1e31, whose tristimulus values fit too.
fn image(grid: WavelengthGrid) -> SpectralImage {
    let mut image = SpectralImage::new(37, 21, grid, Photometry::Relative);
    let mut state = 1u32;
    for value in &mut image.bands {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *value = f32::from_bits(state % 0x7300_0000);
    }
    image.error = Some((0..37 * 21).map(|i| i as f32 * 0.1).collect());
    image.samples = Some(vec![4.0; 37 * 21]);
    for (key, value) in [("script", "전조등.lua"), ("view", "azimuth 15°"), ("version", "0.1")]
    {
        image.metadata.insert(key.to_owned(), value.to_owned());
    }
    image
}

#[test]
fn bands_are_counted() {
    let scratch = ScratchFolder::new();
    let path = scratch.path("i.exr");
    for (bands, count) in [(ExrBands::None, 0), (ExrBands::Half, 21)] {
        write_exr_as(&path, &image(WavelengthGrid::Step20), bands).unwrap();
        assert_eq!(exr_band_count(&path).unwrap(), Some(count));
    }
    std::fs::write(&path, "v").unwrap();
    assert_eq!(exr_band_count(&path).unwrap(), None);
}

#[test]
fn reads_back_bit_for_bit() {
    let scratch = ScratchFolder::new();
    for grid in [WavelengthGrid::Step5, WavelengthGrid::Step10, WavelengthGrid::Step20] {
        let path = scratch.path("i.exr");
        let written = image(grid);
        write_exr(&path, &written).unwrap();
        assert_eq!(read_exr(&path).unwrap(), written);
    }
}

#[test]
fn layers_read_back_in_parts() {
    let scratch = ScratchFolder::new();
    let (path, again) = (scratch.path("i.exr"), scratch.path("again.exr"));
    let mut written = image(WavelengthGrid::Step20);
    for (name, value) in [("light 1", 0.25f32), ("빛 2", 3.0)] {
        let bands = vec![value; written.bands.len()];
        written.layers.push(crate::image::Layer { name: name.to_owned(), bands });
    }
    for bands in [ExrBands::Float, ExrBands::Half] {
        write_exr_as(&path, &written, bands).unwrap();
        let read = read_exr(&path).unwrap();
        assert_eq!(read.layers, written.layers);
        assert_eq!(read.metadata, written.metadata);
    }
    write_exr(&path, &written).unwrap();
    assert_eq!(read_exr(&path).unwrap(), written);
    write_exr(&again, &read_exr(&path).unwrap()).unwrap();
    assert!(std::fs::read(&path).unwrap() == std::fs::read(&again).unwrap());
}

#[test]
fn equal_images_give_equal_bytes() {
    let scratch = ScratchFolder::new();
    let bytes = |name: &str| {
        let path = scratch.path(name);
        write_exr(&path, &image(WavelengthGrid::Step20)).unwrap();
        std::fs::read(path).unwrap()
    };
    // The crate's hash map would give two orders in all but one run of 5040.
    assert!(bytes("a.exr") == bytes("b.exr"));
}

#[test]
fn layout_is_the_spectral_one() {
    let scratch = ScratchFolder::new();
    let path = scratch.path("i.exr");
    write_exr(&path, &image(WavelengthGrid::Step5)).unwrap();
    let info = read_exr_info(&path).unwrap();
    assert_eq!((info.width, info.height, info.channels.len()), (37, 21, 6 + 81 + 2));
    for name in ["CIE.X", "CIE.Y", "CIE.Z", "R", "G", "B", "S0.380,000000nm", "S0.555,000000nm"] {
        assert!(info.channels.iter().any(|c| c == name), "{name}");
    }
    assert_eq!(info.wavelengths_nm.len(), 81);
    let attribute = |key: &str| info.attributes[key].as_str();
    assert_eq!(attribute("spectralLayoutVersion"), "1.0");
    assert_eq!(attribute("emissiveUnits"), "W.m^-2.sr^-1");
    assert_eq!(attribute("spectralDensity"), "per nm, relative: without an absolute unit");
    assert_eq!(attribute("lampyris.photometry"), "relative");
    assert_eq!(attribute("lampyris.script"), "전조등.lua");
}

#[test]
fn xyz_channels_are_the_sums_of_the_bands() {
    let scratch = ScratchFolder::new();
    let path = scratch.path("i.exr");
    let mut flat = SpectralImage::new(2, 1, WavelengthGrid::Step5, Photometry::Absolute);
    flat.bands[81..].fill(0.01);
    write_exr(&path, &flat).unwrap();
    let exr = ::exr::prelude::read_first_flat_layer_from_file(&path).unwrap();
    let value = |name: &str| {
        let channels = &exr.layer_data.channel_data.list;
        let channel = channels.iter().find(|c| string(&c.name) == name).unwrap();
        channel.sample_data.values_as_f32().nth(1).unwrap()
    };
    let xyz = flat.mean_xyz(Region::pixel(1, 0)).unwrap();
    let rgb = rec709_from_xyz(xyz);
    let names = ["CIE.X", "CIE.Y", "CIE.Z", "G"];
    for (name, expected) in names.into_iter().zip([xyz.x, xyz.y, xyz.z, rgb[1]]) {
        // One rounding to f32.
        assert!((f64::from(value(name)) - expected).abs() <= 1e-7 * expected, "{name}");
    }
}

#[test]
fn colors_say_what_they_are() {
    let scratch = ScratchFolder::new();
    let path = scratch.path("i.exr");
    for (photometry, luminance) in [(Photometry::Absolute, Some(1.0)), (Photometry::Relative, None)]
    {
        let image = SpectralImage::new(2, 1, WavelengthGrid::Step20, photometry);
        write_exr(&path, &image).unwrap();
        let exr = ::exr::prelude::read_first_flat_layer_from_file(&path).unwrap();
        assert_eq!(exr.layer_data.attributes.white_luminance, luminance);
        let chromaticities = exr.attributes.chromaticities.unwrap();
        assert_eq!(chromaticities.red, ::exr::math::Vec2(0.64, 0.33));
    }
}

#[test]
fn small_files_keep_what_they_say() {
    let scratch = ScratchFolder::new();
    let path = scratch.path("i.exr");
    let mut written = SpectralImage::new(31, 9, WavelengthGrid::Step20, Photometry::Absolute);
    for (at, value) in written.bands.iter_mut().enumerate() {
        *value = 3e-9 * 1.013f32.powi((at % 1500) as i32);
    }
    for (bands, tolerance) in [(ExrBands::Half, 4.9e-4), (ExrBands::Pxr24, 1.54e-5)] {
        write_exr_as(&path, &written, bands).unwrap();
        let read = read_exr(&path).unwrap();
        let largest = written.bands.iter().copied().fold(0.0, f32::max);
        for (read, value) in read.bands.iter().zip(&written.bands) {
            // Below its normal numbers a half has fewer bits.
            let allowed = tolerance * value.max(largest * 2e-9);
            assert!((read - value).abs() <= allowed, "{bands:?}: {value} became {read}");
        }
        assert_eq!(read.metadata, written.metadata);
    }
    write_exr_as(&path, &written, ExrBands::None).unwrap();
    assert!(read_exr(&path).unwrap_err().to_string().contains("has no spectral bands"));
}

#[test]
fn other_files_are_refused() {
    let scratch = ScratchFolder::new();
    let path = scratch.path("i.exr");
    std::fs::write(&path, "not an image").unwrap();
    let message = read_exr(&path).unwrap_err().to_string();
    assert!(message.contains("i.exr: not a readable EXR file"), "{message}");
    ::exr::prelude::write_rgb_file(&path, 2, 2, |_, _| (0.0f32, 0.0f32, 0.0f32)).unwrap();
    let message = read_exr(&path).unwrap_err().to_string();
    assert!(
        message
            .ends_with("has no spectral bands, expected 380 to 780 nm in steps of 5, 10 or 20 nm")
    );
    let empty = SpectralImage::new(0, 4, WavelengthGrid::Step5, Photometry::Relative);
    assert!(write_exr(&path, &empty).is_err());
}
