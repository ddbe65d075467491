//! The README's first command, with fewer tets: a real liver on real markers.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::path::Path;

use moulage::job::{Ending, ReshapeJob, run_reshape};
use moulage::mesh::TriMesh;
use moulage::{Run, io};

/// Pairs of adjacent triangles that are turned over by more than 120 degrees.
fn folds(surface: &TriMesh) -> usize {
    let mut of_edge: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for (t, &[a, b, c]) in surface.triangles.iter().enumerate() {
        for (u, v) in [(a, b), (b, c), (c, a)] {
            of_edge.entry([u.min(v), u.max(v)]).or_default().push(t);
        }
    }
    let normal = |t: usize| {
        let [a, b, c] = surface.triangles[t].map(|v| surface.points[v as usize]);
        (b - a).cross(&(c - a)).normalize()
    };
    of_edge.values().filter(|t| t.len() == 2 && normal(t[0]).dot(&normal(t[1])) < -0.5).count()
}

#[test]
fn the_liver_follows_its_markers_without_folds() {
    let folder = std::env::temp_dir().join(format!("moulage_liver_{}", std::process::id()));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/liver/job.toml");
    let out = folder.join("liver.obj");
    let job = ReshapeJob {
        tets: Some("lattice".into()),
        tet_count: Some(8000),
        out: Some(out.clone()),
        tets_out: None,
        report: None,
        ..ReshapeJob::read(&path).unwrap()
    };
    let report = run_reshape(&job, &Run::new()).unwrap().report;
    assert_eq!(report.ending, Ending::Good, "{}", report.why);
    assert_eq!(report.inverted_tets, 0);
    let after = report.marker_distance.after;
    // Clicked with noise of 0.3 mm.
    assert!(after.mean < 0.3 && after.max < 3.0, "{after:?}");

    let surface = |path: &Path| io::read_surface(path).unwrap().mesh().unwrap();
    let template = surface(&path.with_file_name("template.obj"));
    let result = surface(&out);
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(folds(&result) <= folds(&template));
}
