//! `kugelblitz trace` on the device: hits of few rays and of none. What it answers on the CPU stands in `tests/answers/rays.txt`.

use std::fs;

use kugelblitz::query::Kernel;
use kugelblitz_tests::{gpu, npy_of_rays, runs};

use crate::program::{file, run, scene_file};

/// The CPU's bytes, for a lecture's figure and for more spheres than are tested one after the other; no rays are no error.
#[test]
fn hits_are_those_of_the_cpu() {
    gpu();
    let folder = tempfile::tempdir().unwrap();
    let [rays, out, cloud, scene] =
        ["rays.npy", "hits.npy", "cloud.npy", "cloud.toml"].map(|name| file(&folder, name));
    run(&["generate", "--count", "300", "-o", &cloud, "--scene", &scene, "-q"], 0);
    let some: Vec<[f64; 6]> =
        (0..300).map(|i| [0.0, 1.0, 6.0, f64::from(i) * 1e-3 - 0.15, -0.1, -1.0]).collect();
    for n in [300, 0] {
        fs::write(&rays, npy_of_rays(&some[..n])).unwrap();
        for scene in [&scene_file("figure1"), &scene] {
            for kernel in [Kernel::Certified, Kernel::Double] {
                let hits = |device| {
                    let start = ["trace", scene, "--rays", &rays, "-o", &out, "--json"];
                    let more = ["--device", device, "--kernel", kernel.name()];
                    let json = run(&[&start[..], &more].concat(), 0).json();
                    assert_eq!(json["rays"]["total"], n);
                    assert_eq!(json["hits"].as_u64() > Some(0), n > 0);
                    fs::read(&out).unwrap()
                };
                let expected = hits("cpu");
                let devices = ["auto", "gpu"];
                // Not each GPU has f64.
                let n_devices = if runs(kernel) { 2 } else { 1 };
                for device in &devices[..n_devices] {
                    assert!(hits(device) == expected, "{scene}, {device}, {}", kernel.name());
                }
            }
        }
    }
}
