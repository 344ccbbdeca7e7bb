//! Acceptance tests: one module a claim of the model or the paper.

mod closed_cases;
mod determinism;
mod displays;
mod emitters;
mod example;
mod goldens;
mod intensity;
mod interfaces;
mod interreflection;
mod layers;
mod lens_colors;
mod light_check;
mod measured_sources;
mod mesh_files;
mod stacks;
mod stage;
mod surroundings;
mod target_error;
mod why_black;
