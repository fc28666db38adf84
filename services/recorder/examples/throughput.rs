//! Cost of writing: `cargo run --release -p recorder --example throughput [MESSAGES]` writes that many messages
//! (default 1000000) of each of three topics and prints ns and bytes per message.

use messages::{Command, Message, Odometry, Spat};
use recorder::{LawNames, Metadata, Tally, Writer};
use runtime::Mode;
use scenario::{Overrides, Scenario};
use std::error::Error;
use std::fs::File;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let messages: u64 = std::env::args().nth(1).map_or(Ok(1_000_000), |n| n.parse())?;
    measure::<Odometry>(messages)?;
    measure::<Command>(messages)?;
    measure::<Spat>(messages)
}

fn measure<T: Message>(messages: u64) -> Result<(), Box<dyn Error>> {
    let scenario = Scenario::open("cacc-a", &Overrides::new(), &|_| Ok(Default::default()))?;
    let metadata = Metadata::new(&scenario, Mode::Realtime, 0, [].into(), LawNames::default());
    let path = std::env::temp_dir().join(format!("timegap-throughput-{}", std::process::id()));
    let mut writer = Writer::begin(File::create(&path)?, &metadata)?;
    let mut message = T::zeroed();
    let begun = Instant::now();
    for k in 1..=messages {
        let header = message.header_mut();
        header.sequence = k;
        header.publish_ns += 1_000_000;
        writer.message(T::TOPIC, header.publish_ns, bytemuck::bytes_of(&message))?;
    }
    writer.finish(&Tally::default())?;
    let ns = begun.elapsed().as_secs_f64() * 1e9 / messages as f64;
    let bytes = std::fs::metadata(&path)?.len() as f64 / messages as f64;
    std::fs::remove_file(&path)?;
    println!(
        "{:<18} {:>5} bytes each: {ns:6.0} ns, {bytes:5.0} bytes in the file (n = {messages})",
        T::TOPIC.name(),
        T::TOPIC.message_bytes()
    );
    Ok(())
}
