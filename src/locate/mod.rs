//! Closest points and embedding.
