//! `moulage slice`, `moulage markers`, `moulage compare`.

use std::process::ExitCode;

use moulage::Result;
use moulage::error::Shown;
use moulage::job::{CompareJob, MarkersJob, SliceJob, run_compare, run_markers, run_slice};
use moulage::measure::Spread;

/// Draws one slice.
pub fn slice(job: &SliceJob) -> Result<ExitCode> {
    for sentence in run_slice(job)? {
        println!("{sentence}");
    }
    println!("written: {}", job.out.shown());
    Ok(ExitCode::SUCCESS)
}

/// Marks one label.
pub fn markers(job: &MarkersJob) -> Result<ExitCode> {
    println!("{} markers written: {}", run_markers(job)?, job.out.shown());
    Ok(ExitCode::SUCCESS)
}

/// Compares a surface with a label, and draws it on slices.
pub fn compare(job: &CompareJob) -> Result<ExitCode> {
    let (fit, written) = run_compare(job)?;
    if let Some(fit) = fit {
        let spread =
            |s: &Spread| format!("mean {:.3}, 95 % {:.3}, largest {:.3} mm", s.mean, s.p95, s.max);
        println!("label {}: Dice {:.4}", fit.label, fit.dice);
        println!("label to surface: {}", spread(&fit.label_to_surface));
        println!("surface to label: {}", spread(&fit.surface_to_label));
        println!(
            "within the image: label {:.2} ml, surface {:.2} ml",
            fit.label_ml, fit.surface_ml
        );
    }
    for path in written {
        println!("written: {}", path.shown());
    }
    Ok(ExitCode::SUCCESS)
}
