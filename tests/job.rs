//! Jobs from files to files: what is written, what survives, what is said.
#![allow(clippy::unwrap_used)]

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use moulage::error::Shown;
use moulage::job::{Ending, Inputs, ReshapeJob, check_file, run_reshape};
use moulage::{Result, Run, io};

/// Files of one test, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let folder =
            std::env::temp_dir().join(format!("moulage_job_{name}_{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.join(name);
        fs::write(&path, text).unwrap();
        path
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.0.join(name)).unwrap()
    }

    /// A ball of radius 10, and markers on an ellipsoid of half axes 13, 10 and 9.
    fn with_ball(name: &str) -> Self {
        Self::with_ball_of(name, 12, 20)
    }

    /// The same with so many rings of so many vertices.
    fn with_ball_of(name: &str, rings: usize, around: usize) -> Self {
        let folder = Self::new(name);
        let point = |ring: usize, step: usize| {
            let (up, turn) = (ring as f64 / rings as f64, step as f64 / around as f64);
            let (theta, phi) = (up * std::f64::consts::PI, turn * std::f64::consts::TAU);
            [libm::sin(theta) * libm::cos(phi), libm::sin(theta) * libm::sin(phi), libm::cos(theta)]
        };
        let mut obj = String::from("# a ball\ng ball\nv 0 0 10\n");
        let mut markers = String::from("x,y,z\n");
        for ring in 1..rings {
            for step in 0..around {
                let [x, y, z] = point(ring, step);
                writeln!(obj, "v {:.6} {:.6} {:.6} 0.5 0.5 0.5", 10.0 * x, 10.0 * y, 10.0 * z)
                    .unwrap();
                if ring % 2 == 0 && step % 2 == 0 {
                    writeln!(markers, "{},{},{}", 13.0 * x, 10.0 * y, 9.0 * z).unwrap();
                }
            }
        }
        obj.push_str("v 0 0 -10\nusemtl skin\n");
        let id = |ring: usize, step: usize| match ring {
            0 => 1,
            _ if ring == rings => 2 + (rings - 1) * around,
            _ => 2 + (ring - 1) * around + step % around,
        };
        for ring in 0..rings {
            for step in 0..around {
                let (a, b) = (id(ring, step), id(ring, step + 1));
                let (c, d) = (id(ring + 1, step + 1), id(ring + 1, step));
                let face = match ring {
                    0 => format!("f {a} {d} {c}\n"),
                    _ if ring + 1 == rings => format!("f {a} {d} {b}\n"),
                    _ => format!("f {a} {d} {c} {b}\n"),
                };
                obj.push_str(&face);
            }
        }
        folder.write("ball.obj", &obj);
        folder.write("markers.csv", &markers);
        folder.write("inside.obj", "v 0 0 0\nv 3 0 0\nv 0 3 0\nf 1 2 3\n");
        folder
    }

    /// The usual job with the keys of `more`.
    fn job(&self, more: &str) -> ReshapeJob {
        let usual = "template = 'ball.obj'\nmarkers = 'markers.csv'\ntolerance = 0.05\n\
                     tets = 'lattice'\ntet_count = 1500\nout = 'out.obj'\n";
        let path = self.write("job.toml", usual);
        let more = ReshapeJob::parse(more, &path).unwrap();
        ReshapeJob::read(&path).unwrap().overridden_by(more)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn a_job_writes_all_it_promises_and_keeps_what_is_not_shape() {
    let folder = Folder::with_ball("all");
    let more = "carry = 'inside.obj'\ntets_out = 'tets.vtu'\nreport = 'report'\n";
    let result = run_reshape(&folder.job(more), &Run::new()).unwrap();
    let report = &result.report;
    assert_eq!(report.ending, Ending::Good, "{}", report.why);
    assert_eq!(report.inverted_tets, 0);
    assert!(report.marker_distance.before.mean > 0.8);
    assert!(report.marker_distance.after.mean < 0.1, "{:?}", report.marker_distance.after);
    for path in &report.written {
        assert!(path.is_file(), "{}", path.shown());
    }
    let (old, new) = (folder.read("ball.obj"), folder.read("out.obj"));
    for (old, new) in old.lines().zip(new.lines()) {
        if old.starts_with("v ") {
            assert!(old.ends_with(" 0.5 0.5 0.5") == new.ends_with(" 0.5 0.5 0.5"));
        } else {
            assert_eq!(old, new);
        }
    }
    assert_eq!(io::read_tets(&folder.0.join("tets.vtu")).unwrap().tets.len(), report.tets);
    let carried = io::read_surface(&folder.0.join("out_inside.obj")).unwrap().mesh().unwrap();
    let reach = (carried.points[1] - carried.points[0]).norm();
    assert!((3.3..4.5).contains(&reach), "the carried mesh stretches along x too: {reach}");
    let page = folder.read("report/report.html");
    assert!(page.contains("data:image/png;base64,") && page.contains("<svg"));
    assert!(!page.contains("no plot") && !page.contains("src=\"http"));
    let json: serde_json::Value = serde_json::from_str(&folder.read("report/report.json")).unwrap();
    assert_eq!(json["ending"], "good");
}

#[test]
fn a_job_says_how_sure_its_result_is() {
    let folder = Folder::with_ball("sure");
    let job = folder.job("report = 'report'\nsamples = 8\nsamples_out = 'shapes'\n");
    let report = run_reshape(&job, &Run::new()).unwrap().report;
    let (volume, area) = (report.volume.unwrap(), report.area);
    // The person's half axes are 15, 8 and 10.
    let truth = 4.0 / 3.0 * std::f64::consts::PI * 15.0 * 8.0 * 10.0;
    assert!((volume.value / truth - 1.0).abs() < 0.1, "{} {truth}", volume.value);
    assert!((1e-4..0.1).contains(&(volume.sd.unwrap() / volume.value)), "{volume:?}");
    assert!((1e-4..0.1).contains(&(area.sd.unwrap() / area.value)), "{area:?}");
    let deviations = report.deviations.unwrap();
    assert_eq!(deviations.samples, 8);
    assert!((0.001..0.5).contains(&deviations.sd_normal.mean), "{deviations:?}");
    let header = fs::read(folder.0.join("report/result.ply")).unwrap();
    assert!(String::from_utf8_lossy(&header).contains("property float sd_normal"));
    assert!(folder.read("report/report.html").contains("How sure it is"));
    let best = io::read_surface(&folder.0.join("out.obj")).unwrap().mesh().unwrap();
    for i in 1..=8 {
        let shape = folder.0.join(format!("shapes/shape_{i:03}.obj"));
        let shape = io::read_surface(&shape).unwrap().mesh().unwrap();
        assert_eq!(shape.triangles, best.triangles);
        let change = shape.points.iter().zip(&best.points).map(|(a, b)| (a - b).norm());
        assert!(change.sum::<f64>() > 0.0);
    }
    assert!(!folder.0.join("shapes/shape_009.obj").exists());

    let report = run_reshape(&folder.job("samples = 0\n"), &Run::new()).unwrap().report;
    assert!(report.deviations.is_none() && report.area.sd.is_none());
}

#[test]
fn the_noise_of_a_marker_in_the_file_is_heeded() {
    let folder = Folder::with_ball("noise");
    // The same markers once more, a little farther out, with and without their noise.
    let good = folder.read("markers.csv");
    let far = |noise: &str| {
        let mut text = String::from("x,y,z,sigma\n");
        for line in good.lines().skip(1) {
            let p: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
            writeln!(text, "{},{},{},", p[0], p[1], p[2]).unwrap();
            writeln!(text, "{},{},{},{noise}", 1.05 * p[0], 1.05 * p[1], 1.05 * p[2]).unwrap();
        }
        folder.write("mixed.csv", &text);
        let mut job = folder.job("");
        job.markers = Some(vec![folder.0.join("mixed.csv")]);
        let distances = run_reshape(&job, &Run::new()).unwrap().report.marker_distances.after;
        distances.iter().step_by(2).sum::<f64>() / (0.5 * distances.len() as f64)
    };
    let (unknown, known) = (far(""), far("0.5"));
    assert!(known < 0.3 * unknown, "{known} {unknown}");
}

#[test]
fn a_template_that_lies_elsewhere_is_brought_there_first() {
    let folder = Folder::with_ball("elsewhere");
    let shifted: String = folder.read("markers.csv").replace("x,y,z", "y,z,x");
    folder.write("turned.csv", &shifted);
    let mut job = folder.job("align = 'rigid'\n");
    job.markers = Some(vec![folder.0.join("turned.csv")]);
    job.template = Some(folder.write("far.obj", &moved_far(&folder.read("ball.obj"))));
    let report = run_reshape(&job, &Run::new()).unwrap().report;
    assert!(report.marker_distance.before.mean < 1.5, "{:?}", report.marker_distance);
    assert!(report.marker_distance.after.mean < 0.1, "{:?}", report.marker_distance);
    job.align = None;
    job.max_iterations = Some(1);
    let warnings = run_reshape(&job, &Run::new()).unwrap().report.warnings;
    assert!(warnings.iter().any(|w| w.contains("more than half its size")), "{warnings:?}");
}

/// The same OBJ text 40 to the right.
fn moved_far(obj: &str) -> String {
    let shift = |line: &str| match line.strip_prefix("v ").and_then(|rest| rest.split_once(' ')) {
        Some((x, rest)) => format!("v {} {rest}", x.parse::<f64>().unwrap() + 40.0),
        None => line.to_owned(),
    };
    obj.lines().map(shift).collect::<Vec<_>>().join("\n")
}

#[test]
fn bones_near_the_template_become_attachments_that_keep_their_gap() {
    let folder = Folder::with_ball("bones");
    folder.write("bone.obj", "v 11 0 0\nv 0 11 0\nv 0 0 11\nv 30 0 0\nf 1 2 3\nf 1 2 4\n");
    folder.write("moved.obj", "v 16 0 0\nv 5 11 0\nv 5 0 11\nv 35 0 0\nf 1 2 3\nf 1 2 4\n");
    let job = folder.job(
        "attachments = 'bone.obj'\nattachment_targets = 'moved.obj'\nattachment_distance = 2\n",
    );
    let attachments = Inputs::read(&job).unwrap().attachments;
    assert_eq!(attachments.len(), 3);
    for attachment in &attachments {
        assert!((attachment.position.norm() - 10.0).abs() < 0.2);
        let shift = attachment.target - attachment.position;
        assert!((shift.x - 5.0).abs() < 1e-9 && shift.yz().norm() < 1e-9, "{shift}");
    }
    let job = folder.job("attachments = 'bone.obj'\nattachment_distance = 0.001\n");
    let error = Inputs::read(&job).unwrap_err().to_string();
    assert!(error.contains("no vertex of ") && error.contains("within 0.001"), "{error}");
}

#[test]
fn one_and_two_threads_give_the_same_bytes() {
    let folder = Folder::with_ball("threads");
    let mut texts = Vec::new();
    for threads in [1, 2] {
        let result = run_reshape(&folder.job(&format!("threads = {threads}\n")), &Run::new());
        assert!(result.unwrap().is_good());
        texts.push(folder.read("out.obj"));
    }
    assert_eq!(texts[0], texts[1]);
}

#[test]
fn an_interrupted_job_writes_its_best_shape_and_says_so() {
    let folder = Folder::with_ball("interrupted");
    let run = Run::new();
    let watcher = run.clone();
    // Far from its end when it is cancelled, however late that comes.
    let job = folder.job("tolerance = 0.0001\ntet_count = 4000\n");
    let worker = std::thread::spawn(move || run_reshape(&job, &run));
    while watcher.progress().iteration < 1 && !worker.is_finished() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    watcher.cancel();
    let report = worker.join().unwrap().unwrap().report;
    assert_eq!(report.ending, Ending::Interrupted);
    assert!(folder.0.join("out.obj").is_file());
}

#[test]
fn bad_input_is_one_sentence_and_nothing_is_written() {
    let folder = Folder::with_ball("bad");
    let fails = |more: &str| -> String {
        let result: Result<_> = run_reshape(&folder.job(more), &Run::new());
        result.unwrap_err().to_string()
    };
    folder.write("metres.csv", "x,y,z\n0.01,0,0\n0,0.01,0\n0,0,0.01\n-0.01,0,0\n");
    folder.write("empty.csv", "x,y,z\n");
    folder.write("one.csv", "x,y,z\n1,2,3\n");
    folder.write("fixed.csv", "vertex\n5000\n");
    for (flag, expected) in [
        ("tets = 'cubes'\n", "tets = 'cubes' is not known"),
        ("fixed = 'fixed.csv'\n", "fixed.csv, line 2: vertex 5000 is not on the template"),
        ("attachments = 'inside.obj'\n", "say with attachment_distance"),
        ("landmarks = ['a.csv', 'b.csv', 'c.csv']\n", "3 landmark files are given"),
        ("carry = 'missing.obj'\n", "missing.obj: No such file"),
        ("tets_out = 'a.vtk'\n", "--tets-out"),
        ("report = 'ball.obj/report'\n", "cannot write"),
        ("samples = 1\n", "1 plausible shapes do not tell how far shapes differ"),
        ("samples = 0\nsamples_out = 'shapes'\n", "none are asked for"),
        ("max_iterations = 5\nthreads = 1\npoisson = 0.5\n", "Poisson's ratio"),
    ] {
        let message = fails(flag);
        assert!(message.contains(expected) && !message.contains('\n'), "{message}");
    }
    for (markers, expected) in [
        ("empty.csv", "the file holds no markers"),
        ("one.csv", "1 markers, 0 landmarks and 0 attachments do not determine a shape"),
        ("metres.csv", "as with metres beside millimetres"),
    ] {
        let mut job = folder.job("");
        job.markers = Some(vec![folder.0.join(markers)]);
        let message = run_reshape(&job, &Run::new()).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
    assert!(!folder.0.join("out.obj").exists());
}

#[test]
fn check_says_what_files_are() {
    let folder = Folder::with_ball("check");
    folder.job("");
    let content = |name: &str| check_file(&folder.0.join(name)).unwrap();
    assert!(content("ball.obj").content.contains("222 vertices and 440 triangles, closed"));
    assert!(content("markers.csv").content.starts_with("50 markers"));
    assert!(content("job.toml").content.starts_with("a job: template of 222 vertices, 50 markers"));
    assert!(content("inside.obj").findings[0].contains("3 edges border a hole"));
    let error = check_file(Path::new("a.docx")).unwrap_err().to_string();
    assert!(error.starts_with("a.docx: this kind of file is not known"), "{error}");
}

#[test]
fn a_sphere_becomes_a_liver_on_new_tets() {
    let folder = Folder::with_ball_of("remesh", 18, 36);
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/liver/template.obj");
    let liver = io::read_surface(&example).unwrap().mesh().unwrap();
    let mut markers = String::from("x,y,z\n");
    for p in liver.points.iter().step_by(10) {
        writeln!(markers, "{},{},{}", p.x, p.y, p.z).unwrap();
    }
    folder.write("markers.csv", &markers);
    let center = liver.points.iter().sum::<moulage::math::Vec3>() / liver.points.len() as f64;
    let radius = libm::cbrt(liver.volume() * 0.75 / std::f64::consts::PI);
    let mut sphere = String::new();
    for line in folder.read("ball.obj").lines() {
        let numbers: Vec<f64> = line.split(' ').filter_map(|word| word.parse().ok()).collect();
        if line.starts_with("v ") {
            let p = center + moulage::math::Vec3::from_column_slice(&numbers[..3]) * radius / 10.0;
            writeln!(sphere, "v {} {} {}", p.x, p.y, p.z).unwrap();
        } else {
            writeln!(sphere, "{line}").unwrap();
        }
    }
    folder.write("ball.obj", &sphere);
    folder.write("inside.obj", &sphere);
    let more = "tet_count = 2000\ncarry = 'inside.obj'\ntets_out = 'tets.vtu'\nreport = 'report'\n";
    let job = ReshapeJob { tolerance: None, ..folder.job(more) };
    let report = run_reshape(&job, &Run::new()).unwrap().report;
    assert_eq!(report.ending, Ending::Good, "{}", report.why);
    assert_eq!(report.inverted_tets, 0);
    let distance = report.marker_distance;
    assert!(distance.before.mean > 15.0 && distance.after.mean < 0.4, "{distance:?}");
    assert!(report.stretch_range[1] > 2.0, "the whole change is told: {:?}", report.stretch_range);
    assert!(!report.remeshes.is_empty());
    let page = folder.read("report/report.html");
    assert_eq!(page.matches("Remeshed").count(), report.remeshes.len());
    let json: serde_json::Value = serde_json::from_str(&folder.read("report/report.json")).unwrap();
    assert_eq!(json["remeshes"].as_array().unwrap().len(), report.remeshes.len());

    // What lies on the template goes where the template goes, through all tets.
    let points =
        |name: &str| io::read_surface(&folder.0.join(name)).unwrap().mesh().unwrap().points;
    let gaps = points("out.obj").into_iter().zip(points("out_inside.obj"));
    let gap = gaps.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(gap < 1e-3, "{gap}");
}
