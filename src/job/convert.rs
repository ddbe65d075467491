//! Skeletons from one format to another.

use std::path::{Path, PathBuf};

use nalgebra::Point3;

use super::register_job::read_skeleton;
use super::register_output::{file_name, scene};
use crate::error::{Error, Result};
use crate::io::gltf::write_glb;
use crate::io::osim::{OsimModel, parse_osim};
use crate::io::skeleton::SkeletonDocument;
use crate::io::vtp::read_vtp;
use crate::io::{read_bytes, read_surface, write_beside, write_surface};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// Metres per unit of a skeleton file that says its unit; millimetres otherwise.
pub fn metres_per_unit(units: Option<&str>) -> f64 {
    match units {
        Some("m") => 1.0,
        Some("cm") => 0.01,
        _ => 0.001,
    }
}

/// Converts a skeleton: `.osim` to `.skeleton.json` (bones beside it in `bones/`), or
/// `.skeleton.json` to `.glb`. Returns notes on what was left out.
pub fn convert_skeleton(from: &Path, to: &Path) -> Result<Vec<String>> {
    let ends = |path: &Path, end: &str| path.to_string_lossy().to_lowercase().ends_with(end);
    if ends(from, ".osim") && ends(to, ".skeleton.json") {
        return write_osim_skeleton(from, to);
    }
    if ends(from, ".json") && ends(to, ".glb") {
        let files = read_skeleton(from)?;
        let unit = metres_per_unit(files.document.units.as_deref());
        write_glb(to, &scene(&files.skeleton, None, unit)?)?;
        return Ok(Vec::new());
    }
    Err(Error::Unsupported(format!(
        "cannot convert {} to {}: .osim to .skeleton.json and .skeleton.json to .glb are known",
        from.display(),
        to.display()
    )))
}

/// Reads an OpenSim model: its skeleton, the surface of each bone in the default pose, metres, and
/// notes on what was left out.
pub fn read_osim_skeleton(path: &Path) -> Result<(SkeletonDocument, Vec<TriMesh>, Vec<String>)> {
    let bytes = read_bytes(path)?;
    let model = parse_osim(&String::from_utf8_lossy(&bytes), path)?;
    let OsimModel { mut document, world_from_body, mesh_scale, notes } = model;
    let mut meshes = Vec::new();
    for (k, bone) in document.bones.iter_mut().enumerate() {
        let mut mesh = read_mesh(&find_mesh(path, &bone.mesh)?)?;
        let scale = Vec3::from(mesh_scale[k]);
        for p in &mut mesh.points {
            *p = (world_from_body[k] * Point3::from(p.component_mul(&scale))).coords;
        }
        bone.mesh = format!("bones/{}.obj", file_name(&bone.name));
        meshes.push(mesh);
    }
    Ok((document, meshes, notes))
}

fn write_osim_skeleton(from: &Path, to: &Path) -> Result<Vec<String>> {
    let (document, meshes, notes) = read_osim_skeleton(from)?;
    let folder = to.parent().unwrap_or(Path::new(""));
    for (bone, mesh) in document.bones.iter().zip(&meshes) {
        write_surface(&folder.join(&bone.mesh), mesh)?;
    }
    let text = document.to_text()?;
    write_beside(to, |out| out.write_all(text.as_bytes()))?;
    Ok(notes)
}

/// A mesh beside the model, or in `Geometry/` as OpenSim looks it up.
fn find_mesh(model: &Path, name: &str) -> Result<PathBuf> {
    let folder = model.parent().unwrap_or(Path::new(""));
    let places = [folder.join(name), folder.join("Geometry").join(name)];
    places.into_iter().find(|p| p.is_file()).ok_or_else(|| {
        Error::invalid(format!(
            "the mesh {name} of {} lies neither beside it nor in Geometry/",
            model.display()
        ))
    })
}

fn read_mesh(path: &Path) -> Result<TriMesh> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("vtp")) {
        return read_vtp(path);
    }
    read_surface(path)?.mesh()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_opensim_model_becomes_a_skeleton_and_a_scene() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
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
        assert!(convert_skeleton(&at("m.osim"), &at("m.skeleton.json")).is_err());
        std::fs::write(at("Geometry/b.obj"), triangle).unwrap();
        let notes = convert_skeleton(&at("m.osim"), &at("m.skeleton.json")).unwrap();
        assert_eq!(notes.len(), 1);
        let skeleton = read_skeleton(&at("m.skeleton.json")).unwrap().skeleton;
        assert_eq!(skeleton.joints[0].coordinates[0].name, "bend");
        assert!((skeleton.points[3].x - 2.0).abs() < 1e-9);
        convert_skeleton(&at("m.skeleton.json"), &at("m.glb")).unwrap();
        assert!(std::fs::read(at("m.glb")).unwrap().starts_with(b"glTF"));
        assert!(convert_skeleton(&at("m.glb"), &at("m.osim")).is_err());
    }
}
