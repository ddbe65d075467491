//! One person's bones and muscles by one job: attached, reshaped, parted; what is done is done once.
#![allow(clippy::unwrap_used)]

use std::fmt::Write;
use std::fs;
use std::path::PathBuf;

use moulage::job::{AnatomyJob, AnatomyReport, Status, run_anatomy};
use moulage::locate::triangles_cross;
use moulage::math::Vec3;
use moulage::{Run, TriMesh, io};

/// A block of 3 x 2 x 1 whose corner is at `corner`, `n` cells along each edge of a face.
fn block(n: usize, corner: [f64; 3]) -> TriMesh {
    let size = [3.0, 2.0, 1.0];
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    let mut number = std::collections::BTreeMap::new();
    for axis in 0..3 {
        for side in [0, n] {
            let mut vertex = |i: usize, j: usize| {
                let mut cell = [0; 3];
                (cell[axis], cell[(axis + 1) % 3], cell[(axis + 2) % 3]) = (side, i, j);
                *number.entry(cell).or_insert_with(|| {
                    let at = [0, 1, 2].map(|k| corner[k] + size[k] * cell[k] as f64 / n as f64);
                    points.push(Vec3::from(at));
                    points.len() as u32 - 1
                })
            };
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let [a, b] = [vertex(i, j), vertex(i + 1, j)];
                let [c, d] = [vertex(i + 1, j + 1), vertex(i, j + 1)];
                let two = [[a, b, c], [a, c, d]];
                triangles.extend(if side == 0 { two.map(|[p, q, r]| [p, r, q]) } else { two });
            }
        }
    }
    TriMesh::new(points, triangles).unwrap()
}

/// Two muscles, one on the other, and a bone at the end of the first, in a folder that is removed at
/// the end. The person is longer, and the markers of the upper muscle reach into the lower one.
struct Person(PathBuf);

const DEPTH: f64 = 0.15;

impl Person {
    fn new(name: &str, more: &str) -> Self {
        let folder =
            std::env::temp_dir().join(format!("moulage_anatomy_{name}_{}", std::process::id()));
        for part in ["bones", "template_bones"] {
            fs::create_dir_all(folder.join(part)).unwrap();
        }
        let person = Self(folder);
        let (lower, upper) = (block(6, [0.0; 3]), block(6, [0.0, 0.0, 1.0]));
        person.surface("lower.obj", &lower);
        person.surface("upper.obj", &upper);
        person.markers("lower.csv", &lower, |p| Vec3::new(1.2 * p.x, p.y, p.z));
        person.markers("upper.csv", &upper, |p| Vec3::new(p.x, p.y, p.z - DEPTH));
        person.surface("template_bones/radius.obj", &block(6, [3.05, 0.0, 0.0]));
        person.surface("bones/radius.obj", &block(6, [3.65, 0.0, 0.0]));
        let job = format!(
            "bones = 'bones'\ntemplate_bones = 'template_bones'\nout = 'out'\n\
             [defaults]\ntets = 'lattice'\ntet_count = 400\ntolerance = 0.03\nattachment_distance = 0.1\n\
             [[object]]\nname = 'lower'\ntemplate = 'lower.obj'\nmarkers = 'lower.csv'\nattached_to = ['radius']\n\
             [[object]]\nname = 'upper'\ntemplate = 'upper.obj'\nmarkers = 'upper.csv'\n{more}"
        );
        fs::write(person.0.join("job.toml"), job).unwrap();
        person
    }

    fn surface(&self, name: &str, mesh: &TriMesh) {
        let mut text = String::new();
        for p in &mesh.points {
            writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
        }
        for t in &mesh.triangles {
            writeln!(text, "f {} {} {}", t[0] + 1, t[1] + 1, t[2] + 1).unwrap();
        }
        fs::write(self.0.join(name), text).unwrap();
    }

    fn markers(&self, name: &str, mesh: &TriMesh, place: impl Fn(&Vec3) -> Vec3) {
        let mut text = String::from("x,y,z\n");
        for p in mesh.points.iter().map(place) {
            writeln!(text, "{},{},{}", p.x, p.y, p.z).unwrap();
        }
        fs::write(self.0.join(name), text).unwrap();
    }

    fn run(&self, run: &Run) -> AnatomyReport {
        run_anatomy(&AnatomyJob::read(&self.0.join("job.toml")).unwrap(), run).unwrap()
    }

    fn result(&self, name: &str) -> TriMesh {
        io::read_surface(&self.0.join("out").join(name)).unwrap().mesh().unwrap()
    }
}

impl Drop for Person {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn statuses(report: &AnatomyReport) -> Vec<(&str, Option<Status>, bool)> {
    report.objects.iter().map(|o| (o.name.as_str(), o.status, o.kept)).collect()
}

fn cross(a: &TriMesh, b: &TriMesh) -> bool {
    let corners = |mesh: &TriMesh| {
        let list = mesh.triangles.iter().map(|t| t.map(|v| mesh.points[v as usize]));
        list.collect::<Vec<_>>()
    };
    let second = corners(b);
    corners(a).iter().any(|t| second.iter().any(|u| triangles_cross(t, u)))
}

#[test]
fn muscles_are_attached_reshaped_and_parted_and_a_broken_one_stops_no_other() {
    let more =
        "[[object]]\nname = 'broken'\ntemplate = 'no_such_file.obj'\nmarkers = 'lower.csv'\n";
    let person = Person::new("whole", more);
    let first = person.run(&Run::new());
    let (good, failed) = (Some(Status::Good), Some(Status::Failed));
    let expected = [("lower", good, false), ("upper", good, false), ("broken", failed, false)];
    assert_eq!(statuses(&first), expected);
    assert!(first.objects[2].message.contains("no_such_file.obj"), "{}", first.objects[2].message);
    assert!(!first.is_good() && !first.interrupted);

    let figures = first.objects[0].figures.as_ref().unwrap();
    assert!(figures.attachments.len() > 20, "{}", figures.attachments.len());
    assert!(figures.attachments.iter().all(|a| a.after < 0.06), "{:?}", figures.attachments);

    let [lower, upper] =
        ["objects/lower/result.obj", "objects/upper/result.obj"].map(|n| person.result(n));
    assert!(cross(&lower, &upper), "there would be nothing to part");
    let separation = first.separation.as_ref().unwrap();
    assert!(separation.summary.separated, "{:?}", separation.summary.overlaps);
    assert!(
        (separation.summary.overlaps[0].depth[0] - DEPTH).abs() < 0.08,
        "{:?}",
        separation.summary.overlaps
    );
    let [lower, upper] = ["separated/lower.obj", "separated/upper.obj"].map(|n| person.result(n));
    assert!(!cross(&lower, &upper) && !cross(&lower, &block(6, [3.65, 0.0, 0.0])));
    let end = lower.points.iter().map(|p| p.x).fold(f64::MIN, f64::max);
    assert!((end - 3.6).abs() < 0.06, "{end}");

    let page = fs::read_to_string(person.0.join("out/report.html")).unwrap();
    assert!(page.contains("2 objects are good, 0 doubtful, 1 failed, 0 not done"), "{page}");
    assert!(page.contains("no_such_file.obj") && page.contains("objects/lower/report/report.html"));

    // The broken one is mended: only this one is worked on.
    person.surface("no_such_file.obj", &block(6, [0.0, 5.0, 0.0]));
    person.markers("lower.csv", &block(6, [0.0, 5.0, 0.0]), |p| *p);
    let job = fs::read_to_string(person.0.join("job.toml")).unwrap();
    let job = job.replacen("markers = 'lower.csv'", "markers = 'first.csv'", 1);
    person.markers("first.csv", &block(6, [0.0; 3]), |p| Vec3::new(1.2 * p.x, p.y, p.z));
    fs::write(person.0.join("job.toml"), job).unwrap();
    let second = person.run(&Run::new());
    let expected = [("lower", good, false), ("upper", good, true), ("broken", good, false)];
    assert_eq!(statuses(&second), expected);
    assert!(second.is_good(), "{:?}", second.warnings);
    let names = ["separated/lower.obj", "separated/upper.obj"];
    let [lower, upper] = names.map(|name| person.result(name));
    assert!(!cross(&lower, &upper));
}

#[test]
fn a_stopped_run_keeps_what_is_ready_and_says_what_is_not() {
    let person = Person::new("stopped", "");
    let run = Run::new();
    let report = std::thread::scope(|scope| {
        let worker = scope.spawn(|| person.run(&run));
        while !person.0.join("out/objects/lower/provenance.json").exists() && !worker.is_finished()
        {
            std::thread::yield_now();
        }
        run.cancel();
        worker.join().unwrap()
    });
    assert!(report.interrupted && !report.is_good());
    assert_eq!(report.objects[0].status, Some(Status::Good));
    let page = fs::read_to_string(person.0.join("out/report.html")).unwrap();
    assert!(page.contains("The run was stopped.") || report.objects[1].status.is_some());
    let again = person.run(&Run::new());
    assert!(again.objects[0].kept && again.is_good(), "{:?}", again.warnings);

    let run = Run::new();
    run.cancel();
    fs::remove_dir_all(person.0.join("out")).unwrap();
    let report = person.run(&run);
    assert_eq!(statuses(&report), [("lower", None, false), ("upper", None, false)]);
    assert!(!person.0.join("out/separated").exists());
}

#[test]
fn an_object_on_an_unknown_bone_is_named() {
    let more = "[[object]]\nname = 'lost'\ntemplate = 'lower.obj'\nmarkers = 'lower.csv'\nattached_to = ['ulna']\n";
    let person = Person::new("lost", more);
    let report = person.run(&Run::new());
    let lost = &report.objects[2];
    assert_eq!(lost.status, Some(Status::Failed));
    assert!(lost.message.contains("'ulna', which is not a bone of this job"), "{}", lost.message);
    assert_eq!(report.count(Status::Good), 2);
}
