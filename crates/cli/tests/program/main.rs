//! The program as its users run it, and what the guide says of it.

mod calculator;
mod cli;
mod explain;
mod figures;
mod films;
mod generate;
mod guide;
mod interrupt;
mod json;
mod memory;
mod outputs;
mod program;
mod readme;
mod trace;
mod words;
