//! The other ends of a measurement: further processes of the benchmark's program.

use radio::{Carrier, Role};
use scenario::carrier::CarrierAddress;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::Instant;

/// A router, until its input ends.
pub fn router(address: &str) {
    let address: CarrierAddress = address.parse().expect("an address");
    let _router = Carrier::open(&address, Role::Vehicle).expect("a router");
    println!("ready");
    // A broken input is an ended one.
    let _ = std::io::stdin().read_to_end(&mut Vec::new());
}

/// This program again, in another role.
pub struct Peer {
    child: Child,
    output: BufReader<ChildStdout>,
}

impl Peer {
    /// Starts it and waits until it is ready.
    pub fn start(arguments: &[&str]) -> Self {
        let mut child = Command::new(std::env::current_exe().expect("it runs"))
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("it can start again");
        let mut output = BufReader::new(child.stdout.take().expect("it is piped"));
        let begun = Instant::now();
        let mut line = String::new();
        output.read_line(&mut line).expect("it says that it is ready");
        assert_eq!(line, "ready\n", "after {:?}", begun.elapsed());
        Self { child, output }
    }

    /// Closes its input and reads its line.
    pub fn finish(&mut self) -> String {
        drop(self.child.stdin.take());
        let mut line = String::new();
        self.output.read_line(&mut line).expect("its line");
        line.trim_end().to_owned()
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        drop(self.child.stdin.take());
        // It ends with its input.
        let _ = self.child.wait();
    }
}
