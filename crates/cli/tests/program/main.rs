//! The program as its users run it, and what the guide says of it.

mod calculator;
mod cli;
mod explain;
mod figures;
mod from_data;
mod generate;
mod guide;
mod interrupt;
mod judge;
mod memory;
mod outputs;
mod papers;
mod program;
mod readme;
mod show;
mod trace;
mod words;
