//! Parsing and showing; all work is done by the library.
//!
//! Exit codes: 0 good, 1 bad input, 2 the solver gave up (the result is written), 130 interrupted.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod anatomy;
mod batch;
mod check;
mod convert;
mod images;
mod model;
mod progress;
mod register;
mod reshape;
mod separate;
mod tetrahedralize;
mod track;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// The input cannot be worked with.
const BAD_INPUT: u8 = 1;
/// The solver gave up; its best shape is written.
const GAVE_UP: u8 = 2;
/// Interrupted; the best shape so far is written.
const INTERRUPTED: u8 = 130;

/// Puts a template of an organ, bone or skeleton into one person's shape.
#[derive(Parser)]
#[command(version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Put a template into the shape that markers on a scan show
    Reshape(Box<reshape::Arguments>),
    /// Put a template skeleton with joints on one person's bones
    Register(Box<moulage::job::RegisterJob>),
    /// Run many job files; what is done already is kept, and a case that fails stops no other
    Batch(moulage::job::BatchJob),
    /// Put all organs or muscles of one person into shape: bones, each object, no overlaps
    Anatomy(anatomy::Arguments),
    /// Push apart bodies of tets that overlap each other or bones
    Separate(moulage::job::SeparateJob),
    /// Fill a surface with tets and print their quality
    Tetrahedralize(tetrahedralize::Arguments),
    /// Follow one person's bones through images of other poses
    Track(moulage::job::TrackJob),
    /// Draw a slice of a medical image, with cuts of surfaces and markers over it
    Slice(moulage::job::SliceJob),
    /// Mark the outlines of a label map's label, as a person would click them
    Markers(moulage::job::MarkersJob),
    /// Compare a surface with a label map, and draw it on slices of an image
    Compare(moulage::job::CompareJob),
    /// Shape statistics of a skeleton's bones
    #[command(subcommand)]
    Model(model::Command),
    /// Turn a skeleton file or a motion into another format
    Convert(moulage::job::Conversion),
    /// Say in words what is wrong with meshes, marker files, images or jobs
    Check(check::Arguments),
}

/// Runs the program.
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version are no errors; clap's own code for wrong flags means something
            // else here.
            let code = if error.use_stderr() { BAD_INPUT } else { 0 };
            let _ = error.print();
            return ExitCode::from(code);
        }
    };
    let code = match arguments.command {
        Command::Reshape(arguments) => reshape::run(*arguments),
        Command::Register(job) => register::run(&job),
        Command::Batch(job) => batch::run(&job),
        Command::Anatomy(arguments) => anatomy::run(&arguments),
        Command::Separate(job) => separate::run(&job),
        Command::Tetrahedralize(arguments) => tetrahedralize::run(&arguments),
        Command::Track(job) => track::run(&job),
        Command::Slice(job) => images::slice(&job),
        Command::Markers(job) => images::markers(&job),
        Command::Compare(job) => images::compare(&job),
        Command::Model(command) => model::run(&command),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Check(arguments) => Ok(check::run(&arguments)),
    };
    code.unwrap_or_else(|error| {
        eprintln!("moulage: {error}");
        ExitCode::from(match error {
            moulage::Error::Cancelled => INTERRUPTED,
            moulage::Error::Diverged(_) | moulage::Error::Singular(_) => GAVE_UP,
            _ => BAD_INPUT,
        })
    })
}
