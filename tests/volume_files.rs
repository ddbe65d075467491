//! Every image format gives the same volume, in the same place; headers that lie give an error.
#![allow(clippy::unwrap_used)]

mod image_files;

use std::path::{Path, PathBuf};

use image_files::{
    DicomSlice, ORIGIN, SIZE, STEPS, dicom_slice, gzip, meta_image, nifti, nrrd, value,
};
use moulage::Result;
use moulage::io;
use moulage::math::Vec3;
use moulage::volume::Volume;

fn dicom(slices: &[DicomSlice]) -> Result<(Volume, Vec<String>)> {
    let file = |(k, slice): (usize, &DicomSlice)| (slice.bytes(), PathBuf::from(format!("s{k}")));
    let files: Vec<_> = slices.iter().enumerate().map(file).collect();
    io::parse_dicom(&files, Path::new("series"))
}

/// The error's sentence; a good result is a failure.
fn sentence<T>(result: Result<T>) -> String {
    let text = result.err().unwrap().to_string();
    assert!(!text.contains('\n') && text.len() < 500, "{text}");
    text
}

fn check(volume: &Volume, name: &str) {
    check_within(volume, name, 1e-6);
}

fn check_within(volume: &Volume, name: &str, tolerance: f64) {
    assert_eq!(volume.size(), SIZE, "{name}");
    for k in 0..3 {
        let step: Vec3 = volume.world_from_voxel().column(k).into();
        assert!((step - Vec3::from(STEPS[k])).norm() < tolerance, "{name}: step {k} is {step:?}");
    }
    assert!((volume.origin() - Vec3::from(ORIGIN)).norm() < 1e-5, "{name}");
    for (v, found) in volume.values().iter().enumerate() {
        assert!((found - f32::from(value(v))).abs() < 1e-6, "{name}, voxel {v}: {found}");
    }
}

#[test]
fn labels_have_the_names_of_their_file() {
    let table = b"<LabelTable><Label Key='5'><![CDATA[liver]]></Label></LabelTable>";
    let mut named = nifti();
    let begin = f32::from_le_bytes([named[108], named[109], named[110], named[111]]);
    named.splice(352..352, [&[0; 8][..], table].concat());
    named[108..112].copy_from_slice(&(begin + 8.0 + table.len() as f32).to_le_bytes());
    // What comes after the extensions names nothing.
    named.extend(b"<LabelTable><Label Key='9'>no</Label></LabelTable>");
    let split = nrrd("raw").windows(2).position(|pair| pair == b"\n\n").unwrap();
    let mut segments = nrrd("raw");
    let lines = b"\nSegment0_Name:=liver\r\nSegment0_LabelValue:=5";
    segments.splice(split..split, lines.iter().copied());
    for (name, file) in
        [("a.nii", named.clone()), ("a.nii.gz", gzip(&named)), ("a.seg.nrrd", segments)]
    {
        let path = std::env::temp_dir().join(format!("moulage-{}-{name}", std::process::id()));
        std::fs::write(&path, file).unwrap();
        let read = io::read_volume(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        check(&read.volume, name);
        assert_eq!(read.label_names, io::LabelNames::from([(5, "liver".to_owned())]), "{name}");
    }
}

#[test]
fn all_formats_give_one_volume() {
    let path = Path::new("a");
    check(&io::parse_nifti(&nifti(), path).unwrap(), "nii");
    check(&io::parse_nifti(&gzip(&nifti()), path).unwrap(), "nii.gz");
    for encoding in ["raw", "gzip", "ascii"] {
        check(&io::parse_nrrd(&nrrd(encoding), path).unwrap(), encoding);
    }
    check(&io::parse_meta_image(&meta_image(false), path).unwrap(), "mha");
    check(&io::parse_meta_image(&meta_image(true), path).unwrap(), "compressed mha");
    // A DICOM stack runs along its normal, whatever order the files are in; here it is the image
    // turned around: this image is left-handed, the stack's slices come in the opposite order.
    let slices = [1, 2, 0].map(dicom_slice);
    let (volume, notes) = dicom(&slices).unwrap();
    assert!(notes.is_empty(), "{notes:?}");
    let same = io::parse_nifti(&nifti(), path).unwrap();
    for k in 0..SIZE[2] {
        for j in 0..SIZE[1] {
            for i in 0..SIZE[0] {
                let world = same.world(&Vec3::new(i as f64, j as f64, k as f64));
                let found = volume.sample(&world).unwrap();
                assert!((found - same.at([i, j, k])).abs() < 0.02, "{i} {j} {k}: {found}");
            }
        }
    }
}

#[test]
fn a_qform_leads_to_the_same_place_as_an_sform() {
    let mut file = nifti();
    // The rotation of STEPS, with the third axis turned (qfac -1) because it is left-handed.
    let turn = nalgebra::Matrix3::from_columns(&[
        Vec3::from(STEPS[0]),
        Vec3::from(STEPS[1]) / 2.0,
        -Vec3::from(STEPS[2]) / 3.0,
    ]);
    assert!((turn.determinant() - 1.0).abs() < 1e-12);
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(turn);
    let mut q = nalgebra::UnitQuaternion::from_rotation_matrix(&rotation).into_inner();
    if q.w < 0.0 {
        q = -q;
    }
    let mut put = |at: usize, x: f64| file[at..at + 4].copy_from_slice(&(x as f32).to_le_bytes());
    put(76, -1.0);
    for (k, x) in [q.i, q.j, q.k, ORIGIN[0], ORIGIN[1], ORIGIN[2]].into_iter().enumerate() {
        put(256 + 4 * k, x);
    }
    file[252] = 1;
    file[254] = 0;
    // The header holds the rotation without its real part, in single precision: for turns near
    // 180 degrees, as here, half of the digits are lost.
    check_within(&io::parse_nifti(&file, Path::new("a")).unwrap(), "qform", 1e-3);
    file[252] = 0;
    let text = sentence(io::parse_nifti(&file, Path::new("a.nii")));
    assert!(text.starts_with("a.nii: the header says nothing about orientation"), "{text}");
}

#[test]
fn slices_missing_doubled_tilted_or_of_two_series_are_noticed() {
    let text = sentence(dicom(&[dicom_slice(0), dicom_slice(1), dicom_slice(2), dicom_slice(4)]));
    assert!(text.contains("6.000 mm apart, other slices 3.000 mm: slices are missing"), "{text}");
    let text = sentence(dicom(&[dicom_slice(0), dicom_slice(1), dicom_slice(1)]));
    assert!(text.contains("lie at the same place; the series has several images"), "{text}");
    let other = DicomSlice { series: "1.2.4", ..dicom_slice(1) };
    let text = sentence(dicom(&[dicom_slice(0), other]));
    assert!(text.contains("2 series; give a file of the one you want: s0"), "{text}");
    let tilted = [0, 1, 2].map(|k| {
        let mut slice = dicom_slice(k);
        slice.position[1] += 0.5 * k as f64;
        slice
    });
    let (volume, notes) = dicom(&tilted).unwrap();
    assert!(notes[0].contains("tilted gantry, 9.5 degrees"), "{notes:?}");
    // Sheared, as it is: the last slice is where its header says (index 0 or 2 along the stack).
    let corner = Vec3::new(-tilted[2].position[0], -tilted[2].position[1], tilted[2].position[2]);
    assert_eq!(volume.sample(&corner), Some(f32::from(value(40))));
    let crooked = [0, 1, 2].map(|k| {
        let mut slice = dicom_slice(k);
        slice.position[1] += [0.0, 4.0, 0.0][k];
        slice
    });
    let text = sentence(dicom(&crooked));
    assert!(text.contains("4.00 mm off a straight line"), "{text}");
}

#[test]
fn headers_that_promise_more_than_there_is_cost_no_memory() {
    let path = Path::new("a");
    let with = |mut file: Vec<u8>, at: usize, bytes: &[u8]| {
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    let large = [0xff_u8, 0x7f];
    let text = sentence(io::parse_nifti(&with(nifti(), 42, &large), path));
    assert!(text.contains("the voxels end after 120 of 786408 bytes"), "{text}");
    let huge = with(with(with(nifti(), 42, &large), 44, &large), 46, &large);
    let text = sentence(io::parse_nifti(&huge, path));
    assert!(text.contains("32767 x 32767 x 32767 voxels, more than"), "{text}");
    let cut = gzip(&nifti());
    let text = sentence(io::parse_nifti(&cut[..cut.len() - 20], path));
    assert!(text.contains("the compressed voxels are broken"), "{text}");
    let replace = |file: Vec<u8>, from: &str, to: &str| {
        let text = String::from_utf8_lossy(&file).into_owned();
        assert!(text.contains(from));
        text.replace(from, to).into_bytes()
    };
    let ascii = || nrrd("ascii");
    for (file, expected) in [
        (replace(ascii(), "sizes: 5 4 3", "sizes: 5 4 4"), "60 values, but its sizes need 80"),
        (replace(ascii(), "sizes: 5 4 3", "sizes: 5 4 99999999999"), "more than"),
        (replace(ascii(), "space: left-posterior-superior\n", ""), "names no space"),
        (replace(ascii(), "left-posterior-superior", "scanner-xyz"), "the space is 'scanner-xyz'"),
        (replace(ascii(), "type: short", "type: block"), "voxels of type 'block'"),
        (replace(ascii(), "dimension: 3", "dimension: 4"), "line 4: the image has 4 dimensions"),
    ] {
        let text = sentence(io::parse_nrrd(&file, path));
        assert!(text.contains(expected), "{text}");
    }
    let mut slice = dicom_slice(0).bytes();
    let pixels = slice.len() - 40 - 4;
    slice[pixels..pixels + 4].copy_from_slice(&0xffff_fff0_u32.to_le_bytes());
    let text = sentence(io::parse_dicom(&[(slice, "s".into())], path));
    assert!(text.contains("(7fe0,0010) claims 4294967280 bytes, but the file ends"), "{text}");
}

#[test]
fn folders_headers_with_a_file_beside_and_single_slices_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let series = at("series");
    std::fs::create_dir(&series).unwrap();
    for k in 0..3 {
        std::fs::write(series.join(format!("{}", 9 - k)), dicom_slice(k).bytes()).unwrap();
    }
    std::fs::write(series.join("README"), "no slice").unwrap();
    let file = io::read_volume(&series).unwrap();
    assert_eq!((file.format, file.volume.size()), ("DICOM", SIZE));
    assert!(file.notes[0].ends_with("1 files are not slices and were skipped"), "{:?}", file.notes);
    let other = DicomSlice { series: "1.2.4", ..dicom_slice(7) };
    std::fs::write(series.join("other.dcm"), other.bytes()).unwrap();
    assert!(sentence(io::read_volume(&series)).contains("2 series"));
    assert_eq!(io::read_volume(&series.join("8")).unwrap().volume.size(), SIZE);

    let head = |file: Vec<u8>, end: &str, line: &str| {
        let text = String::from_utf8_lossy(&file).into_owned();
        text[..text.find(end).unwrap()].to_owned() + line
    };
    let mhd = head(meta_image(false), "ElementDataFile", "ElementDataFile = a.raw\n");
    std::fs::write(at("a.mhd"), mhd).unwrap();
    std::fs::write(at("a.nhdr"), head(nrrd("raw"), "key:=", "data file: a.raw\n")).unwrap();
    std::fs::write(at("a.raw"), image_files::voxels(false)).unwrap();
    check(&io::read_volume(&at("a.mhd")).unwrap().volume, "mhd");
    check(&io::read_volume(&at("a.nhdr")).unwrap().volume, "nhdr");
    assert!(sentence(io::read_volume(&at("a.raw"))).contains("is not a volume: .nii"));
}
