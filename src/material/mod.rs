//! Elastic energy densities.
