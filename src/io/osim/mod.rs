//! OpenSim models (`.osim`, version 4): read as bones and joints, written back with a person's shape.

pub mod edit;
pub mod function;
pub mod joint;
pub mod model;
pub mod pose;
mod xml;
