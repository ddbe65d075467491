//! Every reader on damaged files: an error or a value, never a panic or a flood of memory.
#![allow(clippy::unwrap_used)]

mod image_files;

use std::path::Path;

use moulage::Result;
use moulage::io;

/// A reader; what it read, in words.
type Reader = Box<dyn Fn(&[u8]) -> Result<String>>;

/// A name, a reader, and a good file to start from.
type Case = (&'static str, Reader, Vec<u8>);

fn in_words<T: std::fmt::Debug>(result: Result<T>) -> Result<String> {
    result.map(|content| format!("{content:?}"))
}

fn surface(name: &'static str) -> Reader {
    Box::new(move |bytes| {
        in_words(io::parse_surface(bytes.to_vec(), Path::new(name)).and_then(|file| file.mesh()))
    })
}

fn markers(name: &'static str) -> Reader {
    Box::new(move |bytes| in_words(io::parse_markers(bytes, Path::new(name))))
}

/// The first byte of a fuzz input chooses the format in the same order (fuzz_targets/volumes.rs).
fn image(kind: usize) -> Reader {
    let path = Path::new("a");
    Box::new(move |bytes| {
        in_words(match kind {
            0 => io::parse_nifti(bytes, path),
            1 => io::parse_nrrd(bytes, path),
            2 => io::parse_meta_image(bytes, path),
            _ => io::parse_dicom(&[(bytes.to_vec(), path.into())], path).map(|(v, _)| v),
        })
    })
}

fn skeleton(bytes: &[u8]) -> Result<String> {
    let text = std::str::from_utf8(bytes).unwrap_or_default();
    in_words(io::skeleton::SkeletonDocument::parse(text, Path::new("a")))
}

fn binary_ply() -> Vec<u8> {
    let mut bytes = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n\
        property float y\nproperty float z\nelement face 1\n\
        property list uint int vertex_indices\nend_header\n"
        .to_vec();
    let points = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0_f32];
    bytes.extend(points.into_iter().flat_map(f32::to_le_bytes));
    bytes.extend([3, 0, 1, 2_i32].into_iter().flat_map(i32::to_le_bytes));
    bytes
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend(1_u32.to_le_bytes());
    let numbers = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0_f32];
    bytes.extend(numbers.into_iter().flat_map(f32::to_le_bytes));
    bytes.extend([0, 0]);
    bytes
}

#[allow(clippy::too_many_lines)] // A table.
fn cases() -> Vec<Case> {
    let path = Path::new("a");
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0 \\\n\nvt 0 0\nvn 0 0 1\nf 1/1/1 -2//1 3\n";
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n\
        property double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let stl = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
        vertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
    let csv = "label,x,y,z,weight\na,1,2,3,1\n\"b,c\",4,5,6,\n";
    let json = r#"{"markups":[{"coordinateSystem":"LPS","coordinateUnits":"mm",
        "controlPoints":[{"label":"a","position":[1,2,3],"positionStatus":"defined"}]}]}"#;
    let fcsv = "# CoordinateSystem = LPS\n# columns = id,x,y,z,label\n1,1,2,3,a\n";
    let pp = "<!DOCTYPE PickedPoints>\n<PickedPoints><point x=\"1\" y=\"2\" z=\"3\" \
        active=\"1\" name=\"a\"/></PickedPoints>";
    let landmarks = "label,vertex,template_x,template_y,template_z,target_x,target_y,target_z\n\
        a,1,0,0,0,1,1,1\n";
    let attachments = "type,bone,muscle_x,muscle_y,muscle_z,template_bone_x,template_bone_y,\
        template_bone_z,target_bone_x,target_bone_y,target_bone_z,in_fov\n\
        origin,hip,0,0,0,1,1,1,2,2,2,1\n";
    let nodes = "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
    let elements = b"1 4 0\n1 1 2 3 4\n";
    let veg = "*VERTICES\n4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n*ELEMENTS\nTET\n1 4 0\n\
        1 1 2 3 4\n";
    let msh = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n\
        0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n\
        $EndElements\n";
    let vtu = r#"<VTKFile type="UnstructuredGrid" byte_order="LittleEndian"><UnstructuredGrid>
        <Piece><Points><DataArray type="Float64" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray>
        </Points><Cells><DataArray type="Int32" Name="connectivity" format="binary">EAAAAAAAAAABAAAAAgAAAAMAAAA=</DataArray>
        <DataArray type="Int32" Name="offsets" format="ascii">4</DataArray>
        <DataArray type="UInt8" Name="types" format="ascii">10</DataArray></Cells></Piece>
        </UnstructuredGrid></VTKFile>"#;
    let profiles = r#"{"format":"intensity-profiles","version":1,"step_mm":0.5,"half":1,"values":"AACAPwAAAEAAAEBA"}"#;
    let skeleton_file = r#"{"format":"anatomical-skeleton","version":1,"bones":[{"name":"a","mesh":"a.obj"},
        {"name":"b","mesh":"b.obj"}],"joints":[{"name":"ab","parent":"a","child":"b",
        "limits":{"rot_deg":{"neg":[1,2,3],"pos":[1,null,3]}}}]}"#;
    let motion = "a\ninDegrees=yes\nendheader\ntime knee\n0 1\n1 2\n";
    let bvh = "HIERARCHY\nROOT hip\n{\nOFFSET 0 1 0\nCHANNELS 6 Xposition Yposition Zposition \
        Zrotation Xrotation Yrotation\nJOINT knee\n{\nOFFSET 0 -4 0\nCHANNELS 1 Xrotation\n\
        End Site\n{\nOFFSET 0 -4 0\n}\n}\n}\nMOTION\nFrames: 1\nFrame Time: 0.01\n\
        0 0 0 10 20 30 -5\n";
    let h5_json = r#"{"root":"r","groups":{"r":{"attributes":[{"name":"n","value":"v"}],"links":
        [{"title":"a","collection":"datasets","id":"d"}]}},"datasets":{"d":{"shape":{"class":
        "H5S_SIMPLE","dims":[2,1]},"type":{"class":"H5T_FLOAT"},"value":[[1],[2]]}}}"#;
    let text = |text: &str| text.as_bytes().to_vec();
    vec![
        ("obj", surface("a.obj"), text(obj)),
        ("ply", surface("a.ply"), text(ply)),
        ("binary ply", surface("a.ply"), binary_ply()),
        ("stl", surface("a.stl"), text(stl)),
        ("binary stl", surface("a.stl"), binary_stl()),
        ("csv", markers("a.csv"), text(csv)),
        ("xyz", markers("a.xyz"), text("1 2 3\n4 5 6\n")),
        ("nifti", image(0), image_files::nifti()),
        ("compressed nifti", image(0), image_files::gzip(&image_files::nifti())),
        ("nrrd", image(1), image_files::nrrd("gzip")),
        ("ascii nrrd", image(1), image_files::nrrd("ascii")),
        ("meta image", image(2), image_files::meta_image(true)),
        ("dicom", image(3), image_files::single_dicom()),
        ("markups", markers("a.mrk.json"), text(json)),
        ("fcsv", markers("a.fcsv"), text(fcsv)),
        ("pp", markers("a.pp"), text(pp)),
        ("landmarks", Box::new(move |b| in_words(io::parse_landmarks(b, path))), text(landmarks)),
        (
            "attachments",
            Box::new(move |b| in_words(io::parse_attachments(b, path))),
            text(attachments),
        ),
        ("fixed", Box::new(move |b| in_words(io::parse_fixed(b, path))), text("vertex\n1\n")),
        (
            "tetgen",
            Box::new(move |b| in_words(io::parse_tetgen(b, path, elements, path))),
            text(nodes),
        ),
        ("veg", Box::new(move |b| in_words(io::parse_veg(b, path))), text(veg)),
        ("msh", Box::new(move |b| in_words(io::parse_gmsh(b, path))), text(msh)),
        ("bvh", Box::new(move |b| in_words(io::bvh::parse_bvh(b, path))), text(bvh)),
        (
            "h5 json",
            Box::new(move |b| {
                in_words(io::h5_json::H5Document::parse(&String::from_utf8_lossy(b), path))
            }),
            text(h5_json),
        ),
        ("vtu", Box::new(move |b| in_words(io::parse_vtu(b, path))), text(vtu)),
        ("profiles", Box::new(move |b| in_words(io::parse_profiles(b, path))), text(profiles)),
        ("skeleton", Box::new(skeleton), text(skeleton_file)),
        ("motion", Box::new(move |b| in_words(io::mot::parse_motion(b, path))), text(motion)),
    ]
}

/// Numbers that look random, the same in every run (`SplitMix64`).
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % bound.max(1) as u64) as usize
    }
}

/// Cuts, flips, doubles, or puts in a number that lies.
fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    let lies: [&[u8]; 8] =
        [b"-1", b"nan", b"1e999", b"4294967295", b"99999999999999999999", b"", b"\n", b"\xff\xff"];
    let at = random.below(bytes.len());
    match random.below(4) {
        0 => bytes.truncate(at),
        1 if at < bytes.len() => bytes[at] = random.below(256) as u8,
        2 => {
            let piece = bytes[at..(at + 20).min(bytes.len())].to_vec();
            bytes.splice(at..at, piece);
        }
        _ => {
            let end = (at + random.below(4)).min(bytes.len());
            bytes.splice(at..end, lies[random.below(lies.len())].iter().copied());
        }
    }
}

#[test]
fn the_files_are_good_before_they_are_damaged() {
    for (name, read, file) in cases() {
        read(&file).unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}

#[test]
fn line_ends_of_windows_change_nothing_that_is_read_and_no_line_that_is_named() {
    for (name, read, file) in cases() {
        let Ok(text) = String::from_utf8(file) else { continue };
        let compare = |text: &str| {
            let read = |text: &str| read(text.as_bytes()).map_err(|e| e.to_string());
            assert_eq!(read(&text.replace('\n', "\r\n")), read(text), "{name}");
        };
        compare(&text);
        for (at, _) in text.match_indices(|c: char| c.is_ascii_digit()) {
            compare(&format!("{}q{}", &text[..at], &text[at + 1..]));
        }
    }
}

#[test]
fn no_damage_makes_a_reader_panic_and_every_error_is_one_sentence() {
    let mut random = Random(7);
    for (name, read, file) in cases() {
        for _ in 0..3000 {
            let mut damaged = file.clone();
            for _ in 0..=random.below(3) {
                damage(&mut damaged, &mut random);
            }
            if let Err(error) = read(&damaged) {
                let sentence = error.to_string();
                assert!(!sentence.contains('\n') && sentence.len() < 500, "{name}: {sentence}");
            }
        }
    }
}

/// Found by fuzzing: the DICOM crates read an unknown kind of element with a length of four bytes, and
/// filled memory for more than 70 seconds for a file of 427 bytes.
#[test]
fn a_dicom_element_of_an_unknown_kind_is_checked_with_its_long_length() {
    let mut file = image_files::single_dicom();
    let intercept = [0x28, 0, 0x52, 0x10, b'D', b'S'];
    let at = file.windows(6).position(|w| w == intercept).unwrap();
    file[at + 5] = b'O';
    let error = image(3)(&file).unwrap_err().to_string();
    assert!(error.contains("(0028,1052) claims"), "{error}");
}
