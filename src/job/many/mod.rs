//! Many cases: a study's, or one person's anatomy.

pub(crate) mod anatomy;
pub(crate) mod anatomy_page;
pub(crate) mod anatomy_report;
pub(crate) mod anatomy_spec;
pub(crate) mod batch;
pub(crate) mod batch_summary;
pub(crate) mod case;
pub(crate) mod provenance;
