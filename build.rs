//! Tells the program which sources, crates and compiler it is built from, so that sweeps can say
//! what two builds differ in. Nothing of the machine enters.

use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=LAMPYRIS_SOURCES={:032x}", digest(&["Cargo.toml", "data", "src"]));
    println!("cargo::rustc-env=LAMPYRIS_COMPILER={}", compiler());
}

/// FNV-1a, 128 bits, over names and contents: it tells versions apart, and guards against nobody.
fn digest(places: &[&str]) -> u128 {
    let mut files = Vec::new();
    for place in places {
        println!("cargo::rerun-if-changed={place}");
        collect(Path::new(place), &mut files);
    }
    files.sort();
    let mut digest = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    for file in files {
        let name = file.to_string_lossy().replace('\\', "/");
        let content = std::fs::read(&file).unwrap_or_default();
        for byte in name.bytes().chain([0]).chain(content).chain([0]) {
            digest =
                (digest ^ u128::from(byte)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
        }
    }
    digest
}

fn collect(place: &Path, files: &mut Vec<PathBuf>) {
    match std::fs::read_dir(place) {
        Ok(entries) => entries.flatten().for_each(|entry| collect(&entry.path(), files)),
        Err(_) => files.push(place.to_owned()),
    }
}

/// Version, target and profile.
fn compiler() -> String {
    let variable = |name: &str| std::env::var(name).unwrap_or_default();
    let version = Command::new(variable("RUSTC")).arg("--version").output();
    let version = version.map(|said| String::from_utf8_lossy(&said.stdout).trim().to_owned());
    let version = version.unwrap_or_default();
    format!("{version}, {}, {}", variable("TARGET"), variable("PROFILE"))
}
