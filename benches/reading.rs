//! Reading scenes.

use std::fmt::Write;
use std::path::Path;

use criterion::Throughput;
use kugelblitz::scene::parse_scene;
use kugelblitz::{Error, Result};

use kugelblitz_benches::{Candidate, compare, criterion};

const N_SPHERES: usize = 10_000;

/// A field of spheres.
fn many_spheres() -> String {
    let mut text = String::new();
    for i in 0..N_SPHERES {
        let (x, z) = (i % 100, i / 100);
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "[[sphere]]\ncenter = [{x}.25, 0.5, -{z}.75]\nradius = 0.375\ncolor = \"#d62728\"\n"
        );
    }
    text
}

fn candidate<'a>(name: &str, text: &'a str) -> Result<Candidate<'a>> {
    let path = Path::new("memory.toml");
    parse_scene(text, path)?;
    let bytes = Throughput::Bytes(text.len() as u64);
    Ok(Candidate::new(name, bytes, move || parse_scene(text, path)))
}

fn main() -> Result<()> {
    let path = kugelblitz_tests::root().join("scenes/figure2.toml");
    let figure2 = std::fs::read_to_string(&path).map_err(Error::io(&path))?;
    let many = many_spheres();
    let others = vec![candidate("10000 spheres", &many)?];
    let mut criterion = criterion();
    compare(&mut criterion, "reading a scene", candidate("figure 2", &figure2)?, others)?;
    criterion.final_summary();
    Ok(())
}
