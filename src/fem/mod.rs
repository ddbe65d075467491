//! Elastic forces and stiffness with plastic strain.
