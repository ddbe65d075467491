//! Three-dimensional scalar images.
