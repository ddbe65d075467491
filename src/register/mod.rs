//! A template skeleton follows a surface or a medical image (Gilles, Reveret, Pai 2010).
