//! From a surface to a tet mesh.
