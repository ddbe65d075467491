//! Skeletons from one format to another.

use std::path::{Path, PathBuf};

use super::osim_read::read_osim_skeleton;
use super::osim_write::write_osim;
use crate::error::{Error, Result, Shown};
use crate::io::gltf::write_glb;
use crate::io::{file_name, has_extension, stem, write_beside, write_surface};
use crate::job::register::motion_files::{read_motion, write_motion_file};
use crate::job::register::scene::{metres_per_unit, scene};
use crate::job::register::skeleton_files::{read_skeleton, read_tissues};
use crate::register::animation::unknown_angles;

/// One conversion; what is needed depends on the formats.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct Conversion {
    /// .osim, .skeleton.json, or a motion: .mot, .sto, .bvh
    #[cfg_attr(feature = "cli", arg(value_name = "FROM"))]
    pub from: PathBuf,
    /// .skeleton.json (from .osim), .glb or .osim (from .skeleton.json), .bvh or .mot (from a motion)
    #[cfg_attr(feature = "cli", arg(value_name = "TO"))]
    pub to: PathBuf,
    /// Skeleton that a motion belongs to
    #[cfg_attr(feature = "cli", arg(long, value_name = "SKELETON"))]
    pub skeleton: Option<PathBuf>,
    /// Motion to put into the .glb
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE"))]
    pub motion: Option<PathBuf>,
    /// Angles of the motion whose sign is the opposite of the skeleton's
    #[cfg_attr(feature = "cli", arg(long, value_name = "NAME", num_args = 1..))]
    pub flip: Vec<String>,
    /// OpenSim model that the skeleton's template was converted from, for writing .osim
    #[cfg_attr(feature = "cli", arg(long, value_name = "OSIM"))]
    pub model: Option<PathBuf>,
    /// Mass of the person, for writing .osim, kg [default: the template's density]
    #[cfg_attr(feature = "cli", arg(long, value_name = "KG"))]
    pub mass: Option<f64>,
}

/// Converts a skeleton or a motion. Bones of a skeleton lie beside its file in `bones/`, meshes of an
/// OpenSim model in `Geometry/`. Returns notes on what was left out.
pub fn convert(job: &Conversion) -> Result<Vec<String>> {
    let (from, to) = (job.from.as_path(), job.to.as_path());
    let ends = |path: &Path, ends: &[&str]| {
        let name = path.to_string_lossy().to_lowercase();
        ends.iter().any(|end| name.ends_with(end))
    };
    if ends(from, &[".osim"]) && ends(to, &[".skeleton.json"]) {
        return write_osim_skeleton(from, to);
    }
    if ends(from, &[".json"]) && ends(to, &[".glb"]) {
        let files = read_skeleton(from)?;
        let unit = metres_per_unit(files.document.units.as_deref());
        let motion = job.motion.as_deref();
        let motion = motion.map(|m| read_motion(m, &files.skeleton, &job.flip)).transpose()?;
        let tissues = read_tissues(from, &files.document)?;
        write_glb(to, &scene(&files.skeleton, &tissues, motion.as_ref(), unit)?)?;
        return Ok(Vec::new());
    }
    if ends(from, &[".json"]) && ends(to, &[".osim"]) {
        let model = job.model.as_deref().ok_or_else(|| {
            Error::invalid(
                "--model is missing: the OpenSim model that the template was converted from",
            )
        })?;
        let person = read_skeleton(from)?;
        return write_osim(model, &person.skeleton, &person.document, job.mass, to);
    }
    if ends(from, &[".mot", ".sto", ".bvh"]) && ends(to, &[".mot", ".bvh"]) {
        return convert_motion(job);
    }
    Err(Error::Unsupported(format!(
        "cannot convert {} to {}: .osim to .skeleton.json, .skeleton.json to .glb or .osim, and motions \
         (.mot, .sto, .bvh) to .mot or .bvh are known",
        from.shown(),
        to.shown()
    )))
}

fn convert_motion(job: &Conversion) -> Result<Vec<String>> {
    let skeleton = job.skeleton.as_deref().ok_or_else(|| {
        Error::invalid(
            "--skeleton is missing: the skeleton whose bones and angles the motion names",
        )
    })?;
    let skeleton = read_skeleton(skeleton)?.skeleton;
    let motion = read_motion(&job.from, &skeleton, &job.flip)?;
    write_motion_file(&job.to, &skeleton, &motion)?;
    Ok(if has_extension(&job.to, "bvh") {
        unknown_angles(&skeleton, &motion).into_iter().collect()
    } else {
        Vec::new()
    })
}

fn write_osim_skeleton(from: &Path, to: &Path) -> Result<Vec<String>> {
    let (mut document, meshes, notes) = read_osim_skeleton(from)?;
    let folder = to.parent().unwrap_or(Path::new(""));
    // Several models may be converted into one folder.
    let own = stem(to).trim_end_matches(".skeleton").to_string();
    document.name_surfaces(&format!("bones/{}", file_name(&own)));
    for (bone, mesh) in document.bones.iter().zip(&meshes) {
        write_surface(&folder.join(&bone.mesh), mesh)?;
    }
    let text = document.to_text()?;
    write_beside(to, |out| out.write_all(text.as_bytes()))?;
    Ok(notes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_opensim_model_becomes_a_skeleton_and_a_scene() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let job = |from: &str, to: &str| Conversion {
            from: at(from),
            to: at(to),
            ..Conversion::default()
        };
        let model = r#"<OpenSimDocument Version="40000"><Model><BodySet><objects>
          <Body name="a"><Mesh><mesh_file>a.obj</mesh_file></Mesh></Body>
          <Body name="b"><Mesh><mesh_file>b.obj</mesh_file></Mesh></Body></objects></BodySet>
          <JointSet><objects><PinJoint name="ab"><socket_parent_frame>f</socket_parent_frame>
          <socket_child_frame>/bodyset/b</socket_child_frame>
          <coordinates><Coordinate name="bend"><range>-1 1</range></Coordinate></coordinates>
          <frames><PhysicalOffsetFrame name="f"><socket_parent>/bodyset/a</socket_parent>
          <translation>2 0 0</translation></PhysicalOffsetFrame></frames></PinJoint>
          <WeldJoint name="g"><socket_parent_frame>/ground</socket_parent_frame>
          <socket_child_frame>/bodyset/a</socket_child_frame></WeldJoint></objects></JointSet></Model></OpenSimDocument>"#;
        std::fs::write(at("m.osim"), model).unwrap();
        std::fs::create_dir(at("Geometry")).unwrap();
        let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        std::fs::write(at("a.obj"), triangle).unwrap();
        assert!(convert(&job("m.osim", "m.skeleton.json")).is_err());
        std::fs::write(at("Geometry/b.obj"), triangle).unwrap();
        let notes = convert(&job("m.osim", "m.skeleton.json")).unwrap();
        assert!(notes.is_empty(), "{notes:?}");
        let skeleton = read_skeleton(&at("m.skeleton.json")).unwrap().skeleton;
        assert_eq!(skeleton.joints[0].coordinates[0].name, "bend");
        assert!((skeleton.points[3].x - 2.0).abs() < 1e-9);
        convert(&job("m.skeleton.json", "m.glb")).unwrap();
        assert!(std::fs::read(at("m.glb")).unwrap().starts_with(b"glTF"));
        assert!(convert(&job("m.glb", "m.osim")).is_err());

        // A motion of the model and back.
        let walk = "x\ninDegrees=yes\nendheader\ntime bend other\n0 10 1\n0.5 -20 1\n";
        std::fs::write(at("walk.mot"), walk).unwrap();
        assert!(
            convert(&job("walk.mot", "walk.bvh")).unwrap_err().to_string().contains("--skeleton")
        );
        let with = |from: &str, to: &str| Conversion {
            skeleton: Some(at("m.skeleton.json")),
            ..job(from, to)
        };
        assert_eq!(convert(&with("walk.mot", "walk.bvh")).unwrap().len(), 1);
        assert!(convert(&with("walk.bvh", "again.mot")).unwrap().is_empty());
        let again = crate::io::mot::read_motion(&at("again.mot")).unwrap();
        assert_eq!(
            (again.names.as_slice(), again.times.as_slice()),
            (&["bend".into()][..], &[0.0, 0.5][..])
        );
        assert!((again.rows[1][0].to_degrees() + 20.0).abs() < 1e-9);
        let moving = Conversion { motion: Some(at("walk.bvh")), ..job("m.skeleton.json", "w.glb") };
        convert(&moving).unwrap();
        assert!(
            std::fs::metadata(at("w.glb")).unwrap().len()
                > std::fs::metadata(at("m.glb")).unwrap().len()
        );
    }
}
