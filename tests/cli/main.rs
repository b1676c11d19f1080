//! The program `impasto`, run as a person runs it.

#[path = "../common/mod.rs"]
mod common;

mod animate;
mod bad;
mod bench;
mod calm;
mod coherence;
mod demo;
mod good;
mod measure;
mod metric_tests;
mod odd;
mod render;
mod support;
mod techniques;
