//! Margins against rtamt's, a monitoring library by others. `cargo test -p temporal-logic --test rtamt -- --ignored`
//! needs a `python3` with the package `rtamt`, or `TIMEGAP_RTAMT_PYTHON`, which names such an interpreter.

use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;
use std::io::Write as _;
use std::process::{Command, Stdio};
use temporal_logic::{Formula, Signal, Trace, Unit};

const SIGNALS: [Signal; 2] =
    [Signal { name: "a", unit: Unit::ONE }, Signal { name: "b", unit: Unit::ONE }];
const CASES: usize = 2_000;

/// Evaluates lines `formula TAB a's samples TAB b's samples` and prints the margin at the first sample.
const PROGRAM: &str = r#"
import sys, rtamt
for line in sys.stdin:
    text, a, b = line.rstrip("\n").split("\t")
    spec = rtamt.StlDiscreteTimeSpecification()
    for name in ("a", "b", "out"):
        spec.declare_var(name, "float")
    spec.spec = "out = " + text
    spec.parse()
    a, b = ([float(x) for x in values.split(",")] for values in (a, b))
    print(spec.evaluate({"time": list(range(len(a))), "a": a, "b": b})[0][1])
"#;

/// A formula as we write it, and as rtamt does.
fn formulas() -> impl Strategy<Value = (String, String)> {
    let leaf = (prop_oneof(), -9_i8..10).prop_map(|(left, number)| {
        let text = format!("({left} >= {number})");
        (text.clone(), text)
    });
    leaf.prop_recursive(4, 12, 2, |inner| {
        let pair = (inner.clone(), inner.clone());
        let window = (0_u8..5, 0_u8..6);
        (0_usize..8, pair, window).prop_map(|(kind, ((a, ra), (b, rb)), (i, j))| {
            let j = i + j;
            match kind {
                0 => (format!("(not {a})"), format!("(not {ra})")),
                1 => (format!("({a} and {b})"), format!("({ra} and {rb})")),
                2 => (format!("({a} or {b})"), format!("({ra} or {rb})")),
                3 => (format!("({a} implies {b})"), format!("({ra} -> {rb})")),
                4 => (format!("(always[{i},{j}] {a})"), format!("(always[{i}:{j}] {ra})")),
                5 => (format!("(eventually[{i},{j}] {a})"), format!("(eventually[{i}:{j}] {ra})")),
                6 => (format!("(once[{i},{j}] {a})"), format!("(once[{i}:{j}] {ra})")),
                _ => (format!("({a} until[{i},{j}] {b})"), format!("({ra} until[{i}:{j}] {rb})")),
            }
        })
    })
}

/// The left side of a comparison.
fn prop_oneof() -> impl Strategy<Value = &'static str> {
    proptest::sample::select(vec!["a", "b", "a + b", "a - 2 * b", "abs(a)", "a * b"])
}

#[test]
#[ignore = "needs Python with rtamt"]
fn margins_agree_with_rtamt() {
    let python = std::env::var("TIMEGAP_RTAMT_PYTHON").unwrap_or_else(|_| "python3".into());
    let mut runner = TestRunner::deterministic();
    let samples = proptest::collection::vec((-9_i8..10, -9_i8..10), 2..14);
    let (mut input, mut ours) = (String::new(), Vec::new());
    for _ in 0..CASES {
        let (text, theirs) = formulas().new_tree(&mut runner).expect("generates").current();
        let trace = samples.new_tree(&mut runner).expect("generates").current();
        let (a, b): (Vec<f64>, Vec<f64>) =
            trace.into_iter().map(|(a, b)| (f64::from(a), f64::from(b))).unzip();
        let list = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
        input += &format!("{theirs}\t{}\t{}\n", list(&a), list(&b));
        let formula = Formula::parse(&text, &SIGNALS).expect("well formed");
        let margin = formula.margin(&Trace { period_s: 1.0, samples: vec![&a, &b] });
        ours.push((text, margin.value));
    }
    let mut child = Command::new(python)
        .args(["-c", PROGRAM])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("Python starts");
    let mut stdin = child.stdin.take().expect("piped");
    let writer = std::thread::spawn(move || stdin.write_all(input.as_bytes()));
    let output = child.wait_with_output().expect("Python ends");
    writer.join().expect("no panic").expect("Python reads all");
    assert!(output.status.success(), "rtamt ran");
    let theirs = String::from_utf8(output.stdout).expect("text");
    let theirs: Vec<f64> = theirs.lines().map(|line| line.parse().expect("a number")).collect();
    assert_eq!(theirs.len(), CASES);
    for ((text, ours), theirs) in ours.iter().zip(theirs) {
        assert_eq!(*ours, theirs, "{text}");
    }
    println!("{CASES} formulas agree");
}
