//! Many jobs at once: a broken one stops no other, and what is done is done once.
#![allow(clippy::unwrap_used)]

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use moulage::job::{BatchJob, Case, Status, run_batch};
use moulage::{Error, Run, io};

/// A block of 3 x 2 x 1, `n` cells along each edge of a face.
fn block(n: usize) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let size = [3.0, 2.0, 1.0];
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    let mut number = std::collections::BTreeMap::new();
    for axis in 0..3 {
        for side in [0, n] {
            let mut corner = |i: usize, j: usize| {
                let mut cell = [0; 3];
                (cell[axis], cell[(axis + 1) % 3], cell[(axis + 2) % 3]) = (side, i, j);
                *number.entry(cell).or_insert_with(|| {
                    points.push([0, 1, 2].map(|k| size[k] * cell[k] as f64 / n as f64));
                    points.len()
                })
            };
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let [a, b] = [corner(i, j), corner(i + 1, j)];
                let [c, d] = [corner(i + 1, j + 1), corner(i, j + 1)];
                let two = [[a, b, c], [a, c, d]];
                triangles.extend(if side == 0 { two.map(|[p, q, r]| [p, r, q]) } else { two });
            }
        }
    }
    (points, triangles)
}

/// A study of blocks of different lengths, in a folder that is removed at the end.
struct Study(PathBuf);

impl Study {
    fn new(name: &str, lengths: &[f64]) -> Self {
        let folder =
            std::env::temp_dir().join(format!("moulage_batch_{name}_{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let study = Self(folder);
        let (points, triangles) = block(6);
        let mut obj = String::new();
        for [x, y, z] in &points {
            writeln!(obj, "v {x} {y} {z}").unwrap();
        }
        for [a, b, c] in &triangles {
            writeln!(obj, "f {a} {b} {c}").unwrap();
        }
        study.write("template.obj", &obj);
        for (k, length) in lengths.iter().enumerate() {
            let mut markers = String::from("x,y,z\n");
            for [x, y, z] in &points {
                writeln!(markers, "{},{y},{z}", x * length).unwrap();
            }
            study.write(&format!("markers_{k}.csv"), &markers);
            study.write(
                &format!("case_{k}.toml"),
                &format!(
                    "template = 'template.obj'\nmarkers = 'markers_{k}.csv'\ntets = 'lattice'\n\
                     tet_count = 400\ntolerance = 0.05\n"
                ),
            );
        }
        study
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.0.join(name), text).unwrap();
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.0.join(name)).unwrap()
    }

    fn batch(&self, cases: &[&str]) -> Vec<Case> {
        run_batch(&self.job(cases), &Run::new()).unwrap()
    }

    fn job(&self, cases: &[&str]) -> BatchJob {
        BatchJob {
            cases: cases.iter().map(|name| self.0.join(name)).collect(),
            out: self.0.join("out"),
            jobs: 2,
            no_summary: false,
        }
    }
}

impl Drop for Study {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn outcomes(cases: &[Case]) -> Vec<(&str, Status, bool)> {
    cases.iter().map(|c| (c.record.name.as_str(), c.record.status, c.kept)).collect()
}

fn length(path: &Path) -> f64 {
    let points = io::read_surface(path).unwrap().mesh().unwrap().points;
    points.iter().map(|p| p.x).fold(f64::MIN, f64::max)
        - points.iter().map(|p| p.x).fold(f64::MAX, f64::min)
}

#[test]
fn a_broken_case_stops_no_other_and_only_what_changed_is_done_again() {
    let study = Study::new("resume", &[1.0, 1.2, 1.5]);
    study.write("broken.toml", "template = 'no_such_file.obj'\nmarkers = 'markers_0.csv'\n");
    let files = ["broken.toml", "case_0.toml", "case_1.toml", "case_2.toml"];
    let (good, failed) = (Status::Good, Status::Failed);

    let first = study.batch(&files);
    let all = [("broken", failed), ("case_0", good), ("case_1", good), ("case_2", good)];
    assert_eq!(outcomes(&first), all.map(|(name, status)| (name, status, false)));
    assert!(first[0].record.message.contains("no_such_file.obj"), "{}", first[0].record.message);
    let table = study.read("out/table.csv");
    assert!(table.lines().nth(1).unwrap().starts_with("broken,failed,"), "{table}");
    assert!(study.read("out/index.html").contains("4 cases: 3 good, 0 doubtful, 1 failed"));

    let second = study.batch(&files);
    let kept = all.map(|(name, status)| (name, status, status == good));
    assert_eq!(outcomes(&second), kept);
    assert_eq!(study.read("out/table.csv"), table);

    // One case's markers, and one's result, are changed: these two are done again.
    fs::copy(study.0.join("markers_2.csv"), study.0.join("markers_1.csv")).unwrap();
    fs::remove_file(study.0.join("out/case_0/result.obj")).unwrap();
    let third = study.batch(&files[1..]);
    let again = [("case_0", good, false), ("case_1", good, false), ("case_2", good, true)];
    assert_eq!(outcomes(&third), again);
    assert_ne!(third[1].record.key, first[2].record.key);
    let results = ["out/case_1/result.obj", "out/case_2/result.obj"].map(|name| study.read(name));
    assert_eq!(results[0], results[1]);
}

#[test]
fn statistics_find_the_one_way_in_which_the_cases_differ() {
    let study = Study::new("statistics", &[0.8, 1.0, 1.2]);
    let cases = study.batch(&["case_0.toml", "case_1.toml", "case_2.toml"]);
    for case in &cases {
        assert_eq!(case.record.status, Status::Good, "{}", case.record.message);
    }
    let mean = length(&study.0.join("out/statistics/result/mean.obj"));
    let lengths = [0, 1, 2].map(|k| length(&study.0.join(format!("out/case_{k}/result.obj"))));
    assert!((mean - lengths.iter().sum::<f64>() / 3.0).abs() < 0.02, "{mean} of {lengths:?}");
    let modes = study.read("out/statistics/result/modes.csv");
    let share: f64 = modes.lines().nth(1).unwrap().split(',').nth(1).unwrap().parse().unwrap();
    assert!(share > 0.95, "{modes}");
    assert_eq!(study.read("out/statistics/result/scores.csv").lines().count(), 4);
}

#[test]
fn a_cancelled_batch_finishes_no_case_and_two_cases_of_one_name_are_refused() {
    let study = Study::new("refused", &[1.1]);
    let run = Run::new();
    run.cancel();
    let error = run_batch(&study.job(&["case_0.toml"]), &run).unwrap_err();
    assert!(matches!(error, Error::Cancelled));
    assert!(!study.0.join("out/case_0/provenance.json").exists());
    let twice = study.job(&["case_0.toml", "case_0.toml"]);
    let error = run_batch(&twice, &Run::new()).unwrap_err().to_string();
    assert!(error.contains("would share the folder 'case_0'"), "{error}");
}
