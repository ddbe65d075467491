//! The command line that others script against: names, exit codes, what goes to which stream.
#![allow(clippy::unwrap_used)]

use moulage::error::Shown;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

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
        (&["reshape", "--template", "a.docx", "-o", "b.obj"], "a.docx is not a surface file"),
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

/// Ctrl-C on a terminal, once the progress bar tells of an iteration.
#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_writes_the_best_shape_and_is_exit_code_130() {
    let path = scratch("interrupted.obj");
    let report = scratch("report");
    let tets = scratch("interrupted.vtu");
    let command = format!(
        "stty cols 200; exec '{}' reshape '{}' --tets lattice --tet-count 6000 --tolerance 0.001 -o '{}' --report '{}' --tets-out '{}'",
        env!("CARGO_BIN_EXE_moulage"),
        example("job.toml"),
        path.shown(),
        report.shown(),
        tets.shown()
    );
    // `script` gives the program a terminal.
    let mut child = Command::new("script")
        .args(["-qefc", &command, "/dev/null"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut keyboard = child.stdin.take().unwrap();
    let mut screen = child.stdout.take().unwrap();
    let mut seen = Vec::new();
    let mut buffer = [0; 4096];
    let mut is_pressed = false;
    loop {
        let count = screen.read(&mut buffer).unwrap();
        if count == 0 {
            break;
        }
        seen.extend(&buffer[..count]);
        if !is_pressed && text(&seen).contains(", iteration 1") {
            keyboard.write_all(b"\x03").unwrap();
            is_pressed = true;
        }
    }
    let seen = text(&seen);
    assert_eq!(child.wait().unwrap().code(), Some(130), "{seen}");
    assert!(seen.contains("interrupted: what is written is the best shape so far"), "{seen}");
    let json = std::fs::read_to_string(report.join("report.json")).unwrap();
    assert!(json.contains("\"ending\": \"interrupted\""));
    assert!(path.is_file());
    let _ = std::fs::remove_file(&path);
    let _ = std::fs::remove_file(&tets);
    let _ = std::fs::remove_dir_all(&report);
}
