//! A controller of your own in Rust: build it, then `timegap run following --service controller=PROGRAM`.

use controller::law::{Descriptor, Formulation, GapPolicy, Input, Law, Output};

struct TwoSeconds;

impl Law for TwoSeconds {
    fn reset(&mut self) {}
    fn step(&mut self, input: &Input, output: &mut Output) {
        *output = Output::default();
        let speed = input.ego.speed_mps;
        let free = 0.4 * (input.set_speed_mps - speed);
        let follow = input.target.map_or(free, |target| {
            0.2 * (target.gap_m - 5.0 - 2.0 * speed) + 0.7 * target.relative_speed_mps
        });
        output.set_request(free.min(follow).clamp(-4.0, 2.0));
    }
    fn request_bounds_mps2(&self) -> (f64, f64) {
        (-4.0, 2.0)
    }
}

static ONE: Formulation =
    Formulation { name: "one", caution: None, modes: &["drive"], reasons: &[], figures: &[] };
static LAW: Descriptor = Descriptor {
    name: "two-seconds",
    description: "keeps a time headway of two seconds",
    source: "docs/tutorial.md",
    table: None,
    formulations: &[&ONE],
    formulation: |_| &ONE,
    gap: GapPolicy::Internal,
    measured_target: false,
    trucks_alone: false,
    build: |_| Ok(Box::new(TwoSeconds)),
};

fn main() -> std::process::ExitCode {
    controller::serve(&LAW)
}
