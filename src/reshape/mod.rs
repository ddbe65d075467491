//! A template follows markers through optimized plastic strains (Wang, Matcuk, Barbic 2021).
