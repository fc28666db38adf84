//! A foreign law for tests. It follows like `examples/my_law.py`, or misbehaves as its first argument says. It does so
//! from the question whose number is its second argument (1 is the first). `--gain=X` or the variable GAIN is its gain
//! on speed errors.

use bytemuck::Zeroable;
use messages::{LawAnswer, LawInput};
use std::io::{Read, Write};
use std::time::Duration;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let manner = arguments.next().unwrap_or_default();
    let from: u64 = arguments.next().and_then(|word| word.parse().ok()).unwrap_or(1);
    let gain = std::env::args().find_map(|word| word.strip_prefix("--gain=").map(str::to_owned));
    let gain = gain.or_else(|| std::env::var("GAIN").ok());
    let gain: f64 = gain.and_then(|gain| gain.parse().ok()).unwrap_or(0.4);
    let mut asked = 0.0;
    if manner == "exit" {
        eprintln!("I leave at once");
        std::process::exit(3);
    }
    let (mut questions, mut answers) = (std::io::stdin().lock(), std::io::stdout().lock());
    let mut input = LawInput::zeroed();
    while questions.read_exact(bytemuck::bytes_of_mut(&mut input)).is_ok() {
        let mut answer = LawAnswer { sequence: input.sequence, ..LawAnswer::zeroed() };
        answer.request_mps2 = follow(&input, gain);
        asked += 1.0;
        (answer.mode, answer.figures[0]) = (1, input.gap_m);
        if input.sequence >= from {
            match manner.as_str() {
                "sleep" => std::thread::sleep(Duration::from_secs(600)),
                "slow" => std::thread::sleep(Duration::from_millis(150)),
                "garbage" => {
                    let _ = answers.write_all(b"hello, world\n");
                    let _ = answers.flush();
                    std::thread::sleep(Duration::from_secs(600));
                }
                "flood" => loop {
                    if answers.write_all(&[b'y'; 4096]).is_err() {
                        return;
                    }
                },
                "twice" => {
                    let _ = answers.write_all(bytemuck::bytes_of(&answer));
                }
                "die" => {
                    eprintln!("I die at question {}", input.sequence);
                    std::process::exit(7);
                }
                // A reset has no effect.
                "remember" => answer.request_mps2 -= 1e-3 * asked,
                "nan" => answer.request_mps2 = f64::NAN,
                "deaf" => loop {
                    std::thread::sleep(Duration::from_secs(600));
                },
                _ => {}
            }
        }
        if answers.write_all(bytemuck::bytes_of(&answer)).and_then(|()| answers.flush()).is_err() {
            return;
        }
    }
    if manner == "stays" {
        std::thread::sleep(Duration::from_secs(600));
    }
}

fn follow(input: &LawInput, gain: f64) -> f64 {
    let speed_mps = input.speed_mps;
    let mut request_mps2 = gain * (input.set_speed_mps.min(input.speed_limit_mps) - speed_mps);
    if input.has_target == 1 {
        let gap_error_m = input.gap_m - 5.0 - 2.0 * speed_mps;
        request_mps2 = request_mps2.min(0.2 * gap_error_m + 0.7 * input.relative_speed_mps);
    }
    request_mps2.clamp(-4.0, 2.0)
}
