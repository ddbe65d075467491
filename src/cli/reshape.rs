//! `moulage reshape`.

use std::path::PathBuf;
use std::process::ExitCode;

use moulage::error::Shown;
use moulage::job::{Ending, Report, ReshapeJob, run_reshape};
use moulage::measure::Spread;
use moulage::{Result, Run};

use super::progress::{Progress, stop_on_ctrl_c};

#[derive(clap::Args)]
pub struct Arguments {
    /// Job file (TOML): its keys are the flags below, with _ for -; flags win over it
    #[arg(value_name = "JOB.toml")]
    job: Option<PathBuf>,
    #[command(flatten)]
    flags: ReshapeJob,
}

/// Runs one reshaping and prints what came out.
pub fn run(arguments: Arguments) -> Result<ExitCode> {
    let job = match &arguments.job {
        Some(path) => ReshapeJob::read(path)?,
        None => ReshapeJob::default(),
    };
    let job = job.overridden_by(arguments.flags);
    let run = Run::new();
    stop_on_ctrl_c(&run);
    let progress = Progress::watch(&run);
    let result = run_reshape(&job, &run);
    drop(progress);
    let report = result?.report;
    print(&report);
    Ok(ExitCode::from(match report.ending {
        Ending::Good => 0,
        Ending::GaveUp => super::GAVE_UP,
        Ending::Interrupted => super::INTERRUPTED,
    }))
}

fn spread(s: &Spread) -> String {
    format!("mean {:.4}, largest {:.4}", s.mean, s.max)
}

fn print(report: &Report) {
    for warning in &report.warnings {
        eprintln!("note: {warning}");
    }
    println!(
        "{} markers: {} before, {} after",
        report.markers,
        spread(&report.marker_distance.before),
        spread(&report.marker_distance.after)
    );
    if let Some(refined) = &report.refinement {
        println!(
            "{} markers added by the image, {:.3} from the first result on average, confidence {:.2}; the user's markers were {} off at that point",
            refined.added,
            refined.shift.mean,
            refined.confidence.mean,
            spread(&refined.marker_distance_before)
        );
    }
    if let Some(fit) = &report.label_fit {
        println!(
            "label {}: Dice {:.4}, label to result {}, result to label {}",
            fit.label,
            fit.dice,
            spread(&fit.label_to_surface),
            spread(&fit.surface_to_label)
        );
    }
    for (pairs, what) in [(&report.landmarks, "landmarks"), (&report.attachments, "attachments")] {
        if pairs.is_empty() {
            continue;
        }
        let after: Vec<f64> = pairs.iter().map(|pair| pair.after).collect();
        println!("{} {what}: {} after", pairs.len(), spread(&Spread::of(&after)));
        for pair in pairs.iter().filter(|pair| pair.suspect) {
            println!("  suspect: '{}' is still {:.4} off", pair.label, pair.after);
        }
    }
    print_shape(report);
    let seconds: f64 = report.stages.iter().map(|stage| stage.seconds).sum();
    println!("{} iterations, {seconds:.1} s", report.iteration_count);
    for path in &report.written {
        println!("written: {}", path.shown());
    }
    match report.ending {
        Ending::Good => println!("{}", report.why),
        Ending::GaveUp => {
            eprintln!("the solver gave up, what is written is its best shape: {}", report.why);
        }
        Ending::Interrupted => {
            eprintln!("interrupted: what is written is the best shape so far");
        }
    }
}

/// The tets, and how large and how sure the result is.
fn print_shape(report: &Report) {
    for remesh in &report.remeshes {
        println!("remeshed {}", remesh.sentence());
    }
    let [low, high] = report.stretch_range;
    println!(
        "{} tets by {}: {} inverted, stretches {low:.3} to {high:.3}",
        report.tets, report.tets_made_by, report.inverted_tets
    );
    if let Some(volume) = report.volume_text() {
        println!("volume {volume}");
    }
    println!("surface area {}", report.area.text(""));
    if let Some(deviations) = &report.deviations {
        println!(
            "standard deviation across the surface: {} ({} plausible shapes)",
            spread(&deviations.sd_normal),
            deviations.samples
        );
    }
}
