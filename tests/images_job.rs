//! From a label map alone to a person's organ: markers, reshaping, report, comparison.
#![allow(clippy::unwrap_used)]

mod sphere;

use std::path::{Path, PathBuf};

use moulage::Run;
use moulage::io::{read_markers, read_surface, write_surface};
use moulage::job::{
    CompareJob, MarkersJob, ReshapeJob, SliceJob, check_file, run_compare, run_markers,
    run_reshape, run_slice,
};
use moulage::math::Vec3;
use sphere::sphere;

const SIDE: i32 = 40;
/// Half axes of the organ, mm.
const AXES: [f64; 3] = [26.0, 20.0, 23.0];

/// Two NIfTI files of 2 mm voxels around (10, -20, 30): labels (7 inside an ellipsoid), and a smooth
/// image of it.
fn write_images(folder: &Path) -> [PathBuf; 2] {
    let mut header = vec![0_u8; 352];
    let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348_i32.to_le_bytes());
    for (d, n) in [3, SIDE as i16, SIDE as i16, SIDE as i16, 1, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * d, &n.to_le_bytes());
    }
    put(70, &4_i16.to_le_bytes());
    put(108, &352.0_f32.to_le_bytes());
    put(254, &1_i16.to_le_bytes());
    for (row, middle) in [10.0, -20.0, 30.0_f32].into_iter().enumerate() {
        put(280 + 20 * row, &2.0_f32.to_le_bytes());
        put(292 + 16 * row, &(middle - (SIDE as f32 - 1.0)).to_le_bytes());
    }
    put(344, b"n+1\0");
    let (mut labels, mut image) = (header.clone(), header);
    for k in 0..SIDE {
        for j in 0..SIDE {
            for i in 0..SIDE {
                let p = [i, j, k].map(|x| f64::from(2 * x - SIDE + 1));
                let radius: f64 = (0..3).map(|a| (p[a] / AXES[a]).powi(2)).sum::<f64>().sqrt();
                let grey = 400.0 / (1.0 + libm::exp((radius - 1.0) * 15.0)) - 100.0
                    + f64::from((i * 7 + j * 5 + k * 3) % 11);
                labels.extend(i16::from(radius < 1.0).wrapping_mul(7).to_le_bytes());
                image.extend((grey as i16).to_le_bytes());
            }
        }
    }
    let paths = ["labels.nii", "image.nii"].map(|name| folder.join(name));
    std::fs::write(&paths[0], labels).unwrap();
    std::fs::write(&paths[1], image).unwrap();
    paths
}

/// A sphere of radius 20 near the organ.
fn write_template(path: &Path) {
    let surface = sphere(Vec3::new(11.0, -19.0, 29.0), 20.0, 16, 24);
    write_surface(path, &surface).unwrap();
}

#[test]
fn a_label_map_alone_gives_the_organ_with_a_report_on_its_image() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let [labels, image] = write_images(folder.path());
    write_template(&at("sphere.obj"));
    let said = check_file(&labels).unwrap().content;
    assert!(
        said.contains("40 x 40 x 40 voxels of 2.000 x 2.000 x 2.000 mm")
            && said.contains("labels 7 ("),
        "{said}"
    );
    let job =
        MarkersJob { labels: Some(labels.clone()), out: at("m.csv"), ..MarkersJob::default() };
    let count = run_markers(&job).unwrap();
    assert_eq!(read_markers(&at("m.csv")).unwrap().len(), count);

    let job = ReshapeJob {
        template: Some(at("sphere.obj")),
        markers: Some(vec![at("m.csv")]),
        tets: Some("lattice".into()),
        tet_count: Some(2500),
        tolerance: Some(0.3),
        volume: Some(image.clone()),
        label_map: Some(labels.clone()),
        report: Some(at("report")),
        out: Some(at("organ.obj")),
        ..ReshapeJob::default()
    };
    let report = run_reshape(&job, &Run::new()).unwrap().report;
    let fit = report.label_fit.unwrap();
    assert!(fit.label == 7 && fit.dice > 0.97 && fit.label_to_surface.mean < 0.6, "{fit:?}");
    assert!(report.refinement.is_none());
    let page = std::fs::read_to_string(at("report/report.html")).unwrap();
    assert!(page.contains("On the image") && page.contains("coronal, y = "), "no slices");
    let json = std::fs::read_to_string(at("report/report.json")).unwrap();
    assert!(json.contains("\"dice\""));

    let job = CompareJob {
        surface: at("organ.obj"),
        labels: Some(labels.clone()),
        volume: Some(image.clone()),
        out: Some(at("pictures")),
        ..CompareJob::default()
    };
    let (again, written) = run_compare(&job).unwrap();
    assert!((again.unwrap().dice - fit.dice).abs() < 1e-3);
    assert_eq!(written.len(), 9);

    let job = SliceJob {
        volume: image,
        mesh: vec![at("organ.obj")],
        markers: vec![at("m.csv")],
        out: at("s.png"),
        ..SliceJob::default()
    };
    run_slice(&job).unwrap();
    assert!(std::fs::read(at("s.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn the_image_adds_what_few_markers_leave_out() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let [labels, image] = write_images(folder.path());
    write_template(&at("sphere.obj"));
    // A person who marked the front half only.
    let job =
        MarkersJob { labels: Some(labels.clone()), out: at("all.csv"), ..MarkersJob::default() };
    run_markers(&job).unwrap();
    let mut markers = read_markers(&at("all.csv")).unwrap();
    markers.retain(|m| m.position.y > -20.0);
    moulage::io::write_markers(&at("half.csv"), &markers).unwrap();
    let run = |refine| {
        let job = ReshapeJob {
            template: Some(at("sphere.obj")),
            markers: Some(vec![at("half.csv")]),
            tets: Some("lattice".into()),
            tet_count: Some(2500),
            tolerance: Some(0.3),
            volume: Some(image.clone()),
            label_map: Some(labels.clone()),
            refine: Some(refine),
            out: Some(at("organ.obj")),
            ..ReshapeJob::default()
        };
        run_reshape(&job, &Run::new()).unwrap().report
    };
    let without = run(false);
    // The half that was not marked does not collapse; the person's organ is 1.5 times as large as the template.
    let volume = |name: &str| read_surface(&at(name)).unwrap().mesh().unwrap().volume();
    let growth = volume("organ.obj") / volume("sphere.obj");
    assert!((1.2..1.8).contains(&growth), "{growth}");
    let with = run(true);
    let found = with.refinement.unwrap();
    assert!(found.added > 5 && found.confidence.mean > 0.2, "{found:?}");
    let [before, after] =
        [without.label_fit, with.label_fit].map(|fit| fit.unwrap().label_to_surface.mean);
    assert!(after < 0.8 * before, "{before} to {after}");
    let job = ReshapeJob { refine: Some(true), out: Some(at("x.obj")), ..ReshapeJob::default() };
    assert!(run_reshape(&job, &Run::new()).is_err());
}
