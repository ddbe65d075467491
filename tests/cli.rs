//! The command line that others script against: names, exit codes, what goes to which stream.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn moulage(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_moulage")).args(arguments).output().unwrap()
}

fn example(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/liver").join(name);
    path.to_string_lossy().into_owned()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn scratch(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("moulage_cli_{}_{name}", std::process::id()))
}

#[test]
fn the_flags_that_scripts_use_are_there() {
    let help = text(&moulage(&["reshape", "--help"]).stdout);
    for flag in [
        "--template",
        "--markers",
        "--landmarks",
        "--attachments",
        "--fixed",
        "--tets",
        "--tet-count",
        "--tolerance",
        "--carry",
        "-o, --out",
        "--tets-out",
        "--report",
        "--threads",
        "[JOB.toml]",
    ] {
        assert!(help.contains(flag), "{flag} is missing in\n{help}");
    }
    assert_eq!(moulage(&["--version"]).status.code(), Some(0));
}

#[test]
fn bad_input_is_exit_code_1_with_one_sentence() {
    for (arguments, expected) in [
        (&["reshape"][..], "no template is given"),
        (&["reshape", "missing.toml"], "cannot read missing.toml"),
        (&["reshape", "--template", "a.docx", "-o", "b.obj"], "a.docx is no surface file"),
        (&["check", "missing.obj"], "cannot read missing.obj"),
        (&["reshape", &example("job.toml"), "-o", "a.xyz"], "the name must end in .obj"),
    ] {
        let output = moulage(arguments);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.starts_with("moulage: ") && message.contains(expected), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    assert_eq!(moulage(&["reshape", "--no-such-flag"]).status.code(), Some(1));
}

#[test]
fn check_prints_what_is_in_the_files() {
    let files = ["template.obj", "markers.csv", "landmarks.csv", "job.toml"].map(example);
    let mut arguments = vec!["check"];
    arguments.extend(files.iter().map(String::as_str));
    let output = moulage(&arguments);
    assert_eq!(output.status.code(), Some(0));
    let said = text(&output.stdout);
    for expected in ["4002 vertices and 8000 triangles, closed", "308 markers", "4 landmarks"] {
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn tetrahedralize_writes_tets_and_prints_their_quality() {
    let path = scratch("liver.vtu");
    let out = path.to_str().unwrap();
    let output = moulage(&[
        "tetrahedralize",
        &example("template.obj"),
        "-o",
        out,
        "--tets",
        "lattice",
        "--tet-count",
        "3000",
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("dihedral angles"));
    let tets = moulage::io::read_tets(&path).unwrap().tets.len();
    std::fs::remove_file(&path).unwrap();
    assert!((2000..4500).contains(&tets), "{tets}");
}

/// An interrupt from the keyboard, as a shell sends it.
#[cfg(unix)]
#[test]
fn ctrl_c_writes_the_best_shape_and_is_exit_code_130() {
    let path = scratch("interrupted.obj");
    let report = scratch("report");
    let child = Command::new(env!("CARGO_BIN_EXE_moulage"))
        .args(["reshape", &example("job.toml"), "--tets", "lattice", "--tet-count", "6000"])
        .args(["-o", path.to_str().unwrap(), "--report", report.to_str().unwrap()])
        .args(["--tets-out", scratch("interrupted.vtu").to_str().unwrap()])
        .stderr(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(2500));
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("interrupted: what is written is the best shape so far"));
    let json = std::fs::read_to_string(report.join("report.json")).unwrap();
    assert!(json.contains("\"ending\": \"interrupted\""));
    assert!(path.is_file());
    let _ = std::fs::remove_file(&path);
    let _ = std::fs::remove_file(scratch("interrupted.vtu"));
    let _ = std::fs::remove_dir_all(&report);
}
