//! `timegap print layouts`: the messages for other languages.

use clap::Args;
use controller::law::Descriptor;
use controller::laws;
use messages::names::{self, ENUMERATIONS};
use messages::{Field, LAYOUT_VERSION, Layout, TOPICS};
use recorder::schema;
use report::print;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use supervise::Error;

#[derive(Debug, Args)]
#[command(after_help = SUBSCRIBE)]
pub struct LayoutsArguments {
    #[command(flatten)]
    pub language: Language,
    /// The messages between timegap and a law of your own, instead of the topics' (see docs/tutorial.md)
    #[arg(long, conflicts_with = "msg")]
    pub law: bool,
}

#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
pub struct Language {
    /// A Python module of ctypes structures
    #[arg(long)]
    pub python: bool,
    /// A C11 header
    #[arg(long)]
    pub c: bool,
    /// JSON: the layouts with units, meanings and names of numbers
    #[arg(long)]
    pub json: bool,
    /// Write a ROS 2 package of .msg files, `timegap_msgs`, below this directory
    #[arg(long, value_name = "DIR")]
    pub msg: Option<PathBuf>,
}

const SUBSCRIBE: &str = "\
To listen to a run in progress from Python (pip install iceoryx2==0.10.0): write the module to \
a file, take `root` and `prefix` from live.json in the run's results, and open the topic:

    import json, ctypes, iceoryx2 as iox2, timegap_messages as messages
    live = json.load(open(\"runs/mine/live.json\"))
    config = iox2.config.default()
    config.global_cfg.prefix = iox2.FileName.new(live[\"prefix\"])
    config.global_cfg.root_path = iox2.Path.new(live[\"root\"])
    node = iox2.NodeBuilder.new().config(config).create(iox2.ServiceType.Ipc)
    topic = node.service_builder(iox2.ServiceName.new(\"vehicle/odometry\"))
    topic = topic.publish_subscribe(messages.Odometry).open()
    subscriber = topic.subscriber_builder().create()
    sample = subscriber.receive()  # None until something was sent";

pub fn run(arguments: &LayoutsArguments) -> Result<ExitCode, Error> {
    if let Some(directory) = &arguments.language.msg {
        let package = directory.join("timegap_msgs");
        for (name, text) in schema::ros2_package() {
            write(&package.join(name), &text)?;
        }
        print::out(&format!("{}\n", package.display()))?;
        return Ok(ExitCode::SUCCESS);
    }
    let text = match (&arguments.language, arguments.law) {
        (Language { python: true, .. }, false) => schema::python_module(),
        (Language { python: true, .. }, true) => schema::law_python_module(),
        (Language { c: true, .. }, false) => schema::c_header(),
        (Language { c: true, .. }, true) => schema::law_c_header(),
        (_, false) => pretty(&messages_as_json()),
        (_, true) => pretty(&law_as_json()),
    };
    print::out(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn pretty(value: &Value) -> String {
    serde_json::to_string_pretty(value).expect("plain data") + "\n"
}

fn law_as_json() -> Value {
    json!({
        "schema_version": 1,
        "layout_version": LAYOUT_VERSION,
        "question": "LawInput",
        "answer": "LawAnswer",
        "structs": schema::law_records().into_iter().map(as_json).collect::<Vec<_>>(),
    })
}

fn messages_as_json() -> Value {
    let topics: serde_json::Map<_, _> = TOPICS
        .into_iter()
        .map(|topic| (topic.name().to_owned(), json!(topic.layout().name)))
        .collect();
    let structs: Vec<_> = schema::all().into_iter().map(as_json).collect();
    let enumerations: serde_json::Map<_, _> = ENUMERATIONS
        .iter()
        .map(|enumeration| {
            let values = enumeration.values.iter();
            let values: serde_json::Map<_, _> =
                values.map(|(number, name)| (number.to_string(), json!(name))).collect();
            (enumeration.name.to_owned(), values.into())
        })
        .collect();
    let laws: Vec<_> = laws::ALL.iter().copied().flat_map(law).collect();
    json!({
        "schema_version": 1,
        "layout_version": LAYOUT_VERSION,
        "topics": topics,
        "structs": structs,
        "names": enumerations,
        "laws": laws,
    })
}

fn write(path: &Path, text: &str) -> Result<(), Error> {
    let error = Error::path("write", path);
    std::fs::create_dir_all(path.parent().expect("it has a name in a folder")).map_err(error)?;
    std::fs::write(path, text).map_err(error)
}

/// Meaning of a law's numbers, for each of its formulations.
fn law(law: &Descriptor) -> Vec<Value> {
    let formulations = law.formulations.iter();
    formulations
        .map(|formulation| {
            json!({
                "law": law.name,
                "formulation": formulation.name,
                "modes": formulation.modes,
                "reasons": formulation.reasons,
                "figures": formulation.figures,
            })
        })
        .collect()
}

fn as_json(layout: &Layout) -> Value {
    let field = |field: &Field| {
        json!({
            "name": field.name,
            "offset": field.offset,
            "type": field.shape.element.name(),
            "length": field.shape.len,
            "unit": names::unit_of(field.name),
            "meaning": field.meaning(),
            "names": names::of_field(layout.name, field.name).map(|names| names.name),
        })
    };
    json!({
        "name": layout.name,
        "type_name": layout.type_name,
        "bytes": layout.bytes,
        "fields": layout.fields.iter().map(field).collect::<Vec<_>>(),
    })
}
