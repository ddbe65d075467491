//! Motions of a skeleton in files: OpenSim's .mot and .sto, and .bvh.

use std::path::Path;

use super::bvh_motion::{bvh_of_motion, motion_of_bvh};
use crate::error::{Error, Result, Shown};
use crate::io::bvh::{read_bvh, write_bvh};
use crate::io::has_extension;
use crate::io::mot::{self, MotionTable, write_motion};
use crate::register::Skeleton;
use crate::register::animation::Motion;

/// Reads a motion, OpenSim's or a BVH of the skeleton's bones; the angles named in `flip` change their
/// sign.
pub fn read_motion(path: &Path, skeleton: &Skeleton, flip: &[String]) -> Result<Motion> {
    let mut motion = if has_extension(path, "bvh") {
        motion_of_bvh(skeleton, &read_bvh(path)?, path)?
    } else {
        let table = mot::read_motion(path)?;
        Motion { names: table.names, times: table.times, frames: table.rows }
    };
    for name in flip {
        let column = motion.names.iter().position(|n| n == name).ok_or_else(|| {
            Error::invalid(format!("--flip {name}: {} has no such column", path.shown()))
        })?;
        for row in &mut motion.frames {
            row[column] = -row[column];
        }
    }
    Ok(motion)
}

/// Writes a motion of a skeleton: `.bvh`, or OpenSim's `.mot`.
pub fn write_motion_file(path: &Path, skeleton: &Skeleton, motion: &Motion) -> Result<()> {
    if has_extension(path, "bvh") {
        return write_bvh(path, &bvh_of_motion(skeleton, motion)?);
    }
    let Motion { names, times, frames } = motion.clone();
    write_motion(path, &MotionTable { names, times, rows: frames })
}
