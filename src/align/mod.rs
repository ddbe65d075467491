//! Best rigid and similarity fits between point sets.
