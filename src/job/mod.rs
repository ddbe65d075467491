//! A run described as data: read, run, write, report.
