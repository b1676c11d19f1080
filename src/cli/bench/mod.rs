//! `impasto bench`: measures one or all devices, checks what they compute, and writes tables and pages of it.

mod results;
mod telemetry;
