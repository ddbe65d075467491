//! A template follows markers through optimized plastic strains (Wang, Matcuk, Barbic 2021).

mod gauss_newton;

pub use gauss_newton::{Direction, Linearization, Row, Rows};
