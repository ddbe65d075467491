//! Linear and nonlinear solvers.
