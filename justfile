# `just` lists these recipes; each is one command that CONTRIBUTING.md explains.

# List the recipes.
default:
    @just --list

# Drive the README's first command.
run *ARGUMENTS:
    cargo run --release -- run {{ARGUMENTS}}

# Run all tests, as the README does.
test:
    cargo test --release --workspace

# Run one job of the checks (lint, docs, test, python), or all of them.
check *JOBS:
    .ci/run {{JOBS}}

# List the small changes of the code that a crate's own tests do not notice: in the change against main, or with `-p CRATE`.
mutants *ARGUMENTS:
    git diff main > target/mutants.diff
    cargo mutants --output target --cargo-test-arg=--lib {{ if ARGUMENTS == "" { "--in-diff target/mutants.diff" } else { ARGUMENTS } }}

# The share of small changes that the tests notice, by a random sample: `just mutants-sample --seed 2 messages`.
mutants-sample *ARGUMENTS:
    .ci/mutants sample {{ARGUMENTS}}
    .ci/mutants judge

# Build what few use: advisories, zenoh.
extended:
    .ci/extended

# Build the Python package: target/wheels/timegap-*.whl.
wheel:
    maturin build --release --locked --manifest-path python/Cargo.toml --out target/wheels

# Test the Python package, or measure it: `just python bench`.
python *ARGUMENTS:
    .ci/python {{ARGUMENTS}}

# Build the packages, and use each where nothing else is: `just packages --profile dev deb`.
packages *WHICH:
    .ci/packages {{WHICH}}

# Write the generated pages anew: keys, messages.
references:
    cargo run --release -- print reference scenario > docs/reference-scenario.md
    cargo run --release -- print reference messages > docs/reference-messages.md

# Measure this machine and the deployment on it.
bench *ARGUMENTS:
    cargo run --release -- doctor
    cargo run --release -- bench {{ARGUMENTS}}

# Count the lines of source by crate; `just lines files`: by file.
lines *WHAT:
    @.ci/lines {{WHAT}}

# Count the instructions of a simulated second by part, with valgrind: all drives, or some.
instructions *ARGUMENTS:
    @.ci/instructions {{ARGUMENTS}}

# Measure this machine and the program, and write docs/measurements.md anew: all parts, or some.
measure *PARTS:
    .ci/measure {{PARTS}}
