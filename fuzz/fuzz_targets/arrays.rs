#![no_main]
//! The C functions on any arrays: no panic, no read beyond them, errors that name the element.

use std::ptr;

use libfuzzer_sys::arbitrary::{self, Arbitrary};
use libfuzzer_sys::fuzz_target;
use moulage::capi::*;

#[derive(Arbitrary, Debug)]
struct Arrays {
    /// Small numbers make meshes that hold together; any others must be refused or borne.
    points: Vec<[i8; 3]>,
    special: Option<(u8, f64)>,
    triangles: Vec<[u8; 3]>,
    tets: Vec<[u8; 4]>,
    markers: Vec<[f32; 3]>,
    weights: Vec<f32>,
    places: Vec<u8>,
    options: (f32, f32, u8, u8),
}

fuzz_target!(|arrays: Arrays| {
    let mut points: Vec<f64> =
        arrays.points.iter().take(200).flatten().map(|&c| f64::from(c) / 16.0).collect();
    if let Some((place, value)) = arrays.special
        && let Some(slot) = points.get_mut(place as usize)
    {
        *slot = value;
    }
    let triangles: Vec<u32> = arrays.triangles.iter().flatten().map(|&v| v.into()).collect();
    let tets: Vec<u32> = arrays.tets.iter().flatten().map(|&v| v.into()).collect();
    let markers: Vec<f64> = arrays.markers.iter().flatten().map(|&c| c.into()).collect();
    let weights: Vec<f64> = arrays.weights.iter().map(|&w| w.into()).collect();
    let places: Vec<u32> = arrays.places.iter().map(|&v| v.into()).collect();
    let mut error = MlgError { status: MlgStatus::Ok, message: [0; MLG_ERROR_MESSAGE_SIZE] };
    let mut mesh = ptr::null_mut();
    // SAFETY: every pointer comes with the length of its own list.
    unsafe {
        let made = mlg_tri_mesh_new(
            points.as_ptr(),
            points.len() / 3,
            triangles.as_ptr(),
            triangles.len() / 3,
            &raw mut mesh,
            &raw mut error,
        );
        if made == MlgStatus::Ok {
            use_mesh(mesh, &points, &tets, &markers, &weights, &places, &arrays.options);
        }
        assert_ne!(made, MlgStatus::Panic);
        mlg_tri_mesh_free(mesh);
    }
});

/// Each call either works or says why not; none may panic.
unsafe fn use_mesh(
    mesh: *mut MlgTriMesh,
    points: &[f64],
    tets: &[u32],
    markers: &[f64],
    weights: &[f64],
    places: &[u32],
    numbers: &(f32, f32, u8, u8),
) {
    let no_panic = |status: MlgStatus| {
        assert_ne!(status, MlgStatus::Panic);
        status == MlgStatus::Ok
    };
    let none: *mut MlgError = ptr::null_mut();
    let count = markers.len() / 3;
    let mut buffer = vec![0.0; count.max(points.len())];
    let (mut carried, mut given, mut problem) = (ptr::null_mut(), ptr::null_mut(), ptr::null_mut());
    // SAFETY: as in the target; buffers are as long as the functions ask.
    unsafe {
        no_panic(mlg_tri_mesh_check(mesh, none.cast(), 0, none.cast(), none));
        let (m, out) = (markers.as_ptr(), buffer.as_mut_ptr());
        no_panic(mlg_tri_mesh_distances_to_points(mesh, m, count, out, none));
        no_panic(mlg_tri_mesh_distances_of_points(mesh, m, count, out, none));
        let mut matrix = [0.0; 16];
        let pairs = (points.len() / 3).min(count);
        no_panic(mlg_tri_mesh_align(
            mesh,
            numbers.2.into(),
            m,
            count,
            points.as_ptr(),
            m,
            pairs,
            matrix.as_mut_ptr(),
            none,
        ));
        let made = mlg_tet_mesh_new(
            points.as_ptr(),
            points.len() / 3,
            tets.as_ptr(),
            tets.len() / 4,
            &raw mut given,
            none,
        );
        let carries = no_panic(made)
            && no_panic(mlg_tetrahedralization_from_tets(mesh, given, &raw mut carried, none));
        if carries && no_panic(mlg_reshaping_new(carried, &raw mut problem, none)) {
            let w = if weights.len() >= count { weights.as_ptr() } else { ptr::null() };
            no_panic(mlg_reshaping_set_markers(problem, m, w, count, none));
            let vertices = places.len().min(count);
            no_panic(mlg_reshaping_set_landmarks_at_vertices(
                problem,
                places.as_ptr(),
                m,
                ptr::null(),
                vertices,
                none,
            ));
            no_panic(mlg_reshaping_set_fixed(problem, places.as_ptr(), places.len().min(2), none));
            no_panic(mlg_reshaping_check(problem, none.cast(), 0, none.cast(), none));
            let mut options = std::mem::zeroed::<MlgReshapingOptions>();
            no_panic(mlg_reshaping_options_init(&raw mut options, size_of_val(&options)));
            options.tolerance = numbers.0.into();
            options.smoothness = numbers.1.into();
            options.paper = (numbers.2 / 128).into();
            options.max_iterations = (numbers.3 % 4).into();
            options.thread_count = 1;
            let mut result = ptr::null_mut();
            if no_panic(mlg_reshaping_run(problem, &raw const options, &raw mut result, none)) {
                mlg_reshaping_result_free(result);
            }
        }
        mlg_reshaping_free(problem);
        mlg_tetrahedralization_free(carried);
        mlg_tet_mesh_free(given);
    }
}
