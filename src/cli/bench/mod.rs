//! `impasto bench`: measures one or all devices, checks what they compute, and writes tables and pages of it.
//!
//! ```text
//! measuring -> Results -+-> report: parts -> text (terminal), markdown, page (HTML)
//! old bench.json ----> compare      |
//!                       +-----------+-> bench.json, csv
//! ```
#![allow(dead_code)]

mod compare;
mod csv;
mod environment;
#[cfg(test)]
mod example;
mod markdown;
mod outputs;
mod page;
mod plots;
mod previous;
mod report;
mod results;
mod tables;
mod text;
