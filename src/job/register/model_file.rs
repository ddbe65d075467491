//! Shape models in scalismo's `.h5.json`: mean, orthonormal basis and variances of one mesh of all bones.
//!
//! Our modes are orthonormal under the vertex areas, scalismo's without weights. Both describe the same
//! shapes with the same probabilities; the directions differ.

use std::path::Path;

use nalgebra::{DMatrix, SymmetricEigen};

use crate::error::{Error, Result};
use crate::io::h5_json::{H5Array, H5Document};
use crate::io::{read_bytes, write_beside};
use crate::math::Vec3;
use crate::register::{ShapeModel, Skeleton};

/// Where the bone of every vertex stands; not part of scalismo's format, which passes over it.
const BONES: &str = "moulage/boneOfPoint";

/// Reads a model of the template's bones.
pub fn read_shape_model(template: &Skeleton, path: &Path) -> Result<ShapeModel> {
    let bytes = read_bytes(path)?;
    let text = std::str::from_utf8(&bytes)
        .map_err(|_| Error::parse(path, None, "not UTF-8 text; binary .h5 is not read"))?;
    parse_shape_model(template, text, path)
}

/// Reads a model from its text; `path` is for error messages.
pub fn parse_shape_model(template: &Skeleton, text: &str, path: &Path) -> Result<ShapeModel> {
    let document = H5Document::parse(text, path)?;
    let fail = |message: String| Error::parse(path, None, message);
    let array = |name: &str| {
        document.arrays.get(name).ok_or_else(|| fail(format!("the model has no \"{name}\"")))
    };
    let (mean, basis, variance) =
        (array("model/mean")?, array("model/pcaBasis")?, array("model/pcaVariance")?);
    let (rows, modes) = (mean.values.len(), variance.values.len());
    if rows != 3 * template.points.len() {
        return Err(fail(format!(
            "the model has {} vertices, the skeleton {}; it was made with another template",
            rows / 3,
            template.points.len()
        )));
    }
    if basis.shape != [rows, modes] {
        return Err(fail(format!(
            "\"model/pcaBasis\" must be {rows} x {modes}, not {:?}",
            basis.shape
        )));
    }
    if let Some(bones) = document.arrays.get(BONES) {
        let own = template.bone_of_vertex();
        if !bones.values.iter().copied().eq(own.iter().map(|&b| f64::from(b))) {
            return Err(fail("the model's bones are not in the skeleton's order".into()));
        }
    }
    if variance.values.iter().any(|&v| v < 0.0) {
        return Err(fail("a variance is below 0".into()));
    }
    let version = |part: &str| document.arrays.get(part).and_then(|a| a.values.first().copied());
    let version = [version("version/majorVersion"), version("version/minorVersion")];
    let mut factor = DMatrix::from_row_slice(rows, modes, &basis.values);
    // Version 0.8 keeps the deviations in the basis.
    if version != [Some(0.0), Some(8.0)] {
        for (mut column, variance) in factor.column_iter_mut().zip(&variance.values) {
            column *= variance.sqrt();
        }
    }
    let mean = mean.values.chunks_exact(3).map(Vec3::from_column_slice).collect();
    ShapeModel::from_factor(template, mean, &factor).map_err(|e| fail(e.to_string()))
}

/// Writes a model.
pub fn write_shape_model(path: &Path, template: &Skeleton, model: &ShapeModel) -> Result<()> {
    let text = shape_model_text(template, model);
    write_beside(path, |out| out.write_all(text.as_bytes()))
}

/// The text of a model's file, version 0.9 of the format; numbers have single precision.
pub fn shape_model_text(template: &Skeleton, model: &ShapeModel) -> String {
    let factor = model.factor();
    let eigen = SymmetricEigen::new(factor.tr_mul(&factor));
    let mut order: Vec<usize> = (0..factor.ncols()).collect();
    order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    let directions = eigen.eigenvectors.select_columns(&order);
    let variances: Vec<f64> = order.iter().map(|&k| eigen.eigenvalues[k].max(0.0)).collect();
    let mut basis = factor * directions;
    for (mut column, variance) in basis.column_iter_mut().zip(&variances) {
        if *variance > 0.0 {
            column /= variance.sqrt();
        }
    }
    let mut document = H5Document::default();
    let mut put = |name: &str, shape: &[usize], values: Vec<f64>, integer: bool| {
        document.arrays.insert(name.into(), H5Array { shape: shape.to_vec(), values, integer });
    };
    let (points, cells) = (template.points.len(), template.triangles.len());
    let flat: Vec<f64> = model.mean().iter().flat_map(|p| p.iter().copied()).collect();
    put("model/mean", &[3 * points], flat, false);
    let rows = basis.transpose().as_slice().to_vec();
    put("model/pcaBasis", &[3 * points, variances.len()], rows, false);
    put("model/pcaVariance", &[variances.len()], variances, false);
    put("model/noiseVariance", &[1], vec![0.0], false);
    let by_axis = |k: usize| template.points.iter().map(move |p| p[k]);
    let reference: Vec<f64> = (0..3).flat_map(by_axis).collect();
    put("representer/points", &[3, points], reference, false);
    let corner = |k: usize| template.triangles.iter().map(move |t| f64::from(t[k]));
    put("representer/cells", &[3, cells], (0..3).flat_map(corner).collect(), true);
    put("version/majorVersion", &[], vec![0.0], true);
    put("version/minorVersion", &[], vec![9.0], true);
    let bones = template.bone_of_vertex().iter().map(|&b| f64::from(b)).collect();
    put(BONES, &[points], bones, true);
    for (name, value) in [("name", "itkStandardMeshRepresenter"), ("datasetType", "POLYGON_MESH")] {
        document.attributes.insert(format!("representer@{name}"), value.into());
    }
    for part in ["version/majorVersion", "version/minorVersion"] {
        let value = if part.contains("major") { "0" } else { "9" };
        document.attributes.insert(format!("representer@{part}"), value.into());
    }
    document.to_text()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriMesh;

    fn template() -> Skeleton {
        let bone = |x: f64| {
            let corners = [[0., 0., 0.], [3., 0., 0.], [0., 2., 0.], [0., 0., 1.]];
            let points = corners.map(|c| Vec3::from(c) + Vec3::x() * x).to_vec();
            TriMesh::new(points, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]).unwrap()
        };
        Skeleton::new(vec![("a".into(), bone(0.0)), ("b".into(), bone(9.0))], vec![]).unwrap()
    }

    #[test]
    fn a_model_survives_the_way_there_and_back() {
        let template = template();
        let person = |a: f64, b: f64| -> Vec<Vec3> {
            template.points.iter().map(|p| Vec3::new(p.x * a, p.y * b, p.z)).collect()
        };
        let samples = [person(0.9, 1.0), person(1.1, 1.2), person(1.0, 0.7), person(1.05, 1.0)];
        let model = ShapeModel::fit(&template, &samples).unwrap();
        let text = shape_model_text(&template, &model);
        let path = Path::new("a.h5.json");
        let again = parse_shape_model(&template, &text, path).unwrap();
        let (a, b) = (model.factor(), again.factor());
        let (a, b) = (&a * a.transpose(), &b * b.transpose());
        assert!((&a - b).amax() < 1e-5 * a.amax());
        // Plain orthonormal, as scalismo expects.
        let document = H5Document::parse(&text, path).unwrap();
        let basis = &document.arrays["model/pcaBasis"];
        let basis = DMatrix::from_row_slice(basis.shape[0], basis.shape[1], &basis.values);
        let gram = basis.tr_mul(&basis);
        assert!((&gram - DMatrix::identity(gram.nrows(), gram.ncols())).amax() < 1e-5);
    }

    #[test]
    fn mistakes_are_named() {
        let template = template();
        let samples = [template.points.clone(), template.points.iter().map(|p| p * 1.1).collect()];
        let model = ShapeModel::fit(&template, &samples).unwrap();
        let text = shape_model_text(&template, &model);
        let message = |template: &Skeleton, text: &str| {
            parse_shape_model(template, text, Path::new("a.h5.json")).unwrap_err().to_string()
        };
        let one = template.bone_surface(0, &template.points);
        let other = Skeleton::new(vec![("a".into(), one)], vec![]).unwrap();
        assert!(message(&other, &text).contains("another template"));
        assert!(message(&template, &text.replace("pcaVariance", "x")).contains("pcaVariance"));
    }
}
