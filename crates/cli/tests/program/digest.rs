//! The digest as the program prints it.

use kugelblitz::digest::PREFIX;
use kugelblitz_tests::{DIGEST_SIZE, digests};

use crate::program::{run, scene_file};

#[test]
fn the_program_prints_the_digest_alone() {
    let size = format!("{}x{}", DIGEST_SIZE[0], DIGEST_SIZE[1]);
    let (scene, expected) = (scene_file("lit/figure1"), &digests()["lit/figure1"]);
    assert!(expected.starts_with(PREFIX));
    for device in ["cpu", "gpu", "auto"] {
        let ran = run(&["digest", &scene, "--size", &size, "--device", device, "-q"], 0);
        assert_eq!(ran.text(), format!("{expected}\n"), "{device}");
    }
    let json = run(&["digest", &scene, "--size", &size, "--json"], 0).json();
    assert_eq!((&json["command"], &json["digest"]), (&"digest".into(), &expected.as_str().into()));
    assert_eq!(json["size"], serde_json::json!(DIGEST_SIZE));
    let other = |more: &[&str]| {
        let args = [&["digest", &scene, "--size", &size][..], more].concat();
        run(&args, 0).text().trim().to_string()
    };
    for more in [["--samples", "2"], ["--crop", "0,0,9,9"]] {
        assert_ne!(&other(&more), expected, "{more:?}");
    }
}
