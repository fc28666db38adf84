//! Margins against the definition, which looks at every sample of every window.

use proptest::prelude::*;
use temporal_logic::{Formula, Signal, Trace, Unit};

const SIGNALS: [Signal; 2] =
    [Signal { name: "a_m", unit: Unit::METRE }, Signal { name: "b_m", unit: Unit::METRE }];

/// A formula as a tree of this test's own.
#[derive(Clone, Debug)]
enum Tree {
    AtLeast(i8, i8),
    Not(Box<Tree>),
    And(Box<Tree>, Box<Tree>),
    Or(Box<Tree>, Box<Tree>),
    Implies(Box<Tree>, Box<Tree>),
    Always(usize, usize, Box<Tree>),
    Eventually(usize, usize, Box<Tree>),
    Once(usize, usize, Box<Tree>),
    Until(usize, usize, Box<Tree>, Box<Tree>),
}

use Tree::{Always, And, AtLeast, Eventually, Implies, Not, Once, Or, Until};

impl Tree {
    /// The text; a sample lasts 1 s.
    fn text(&self) -> String {
        match self {
            AtLeast(factor, number) => format!("{factor} * a_m - abs(b_m) >= {number}"),
            Not(a) => format!("not ({})", a.text()),
            And(a, b) => format!("({}) and ({})", a.text(), b.text()),
            Or(a, b) => format!("({}) or ({})", a.text(), b.text()),
            Implies(a, b) => format!("({}) implies ({})", a.text(), b.text()),
            Always(i, j, a) => format!("always[{i},{}] ({})", i + j, a.text()),
            Eventually(i, j, a) => format!("eventually[{i},{}] ({})", i + j, a.text()),
            Once(i, j, a) => format!("once[{i},{}] ({})", i + j, a.text()),
            Until(i, j, a, b) => format!("({}) until[{i},{}] ({})", a.text(), i + j, b.text()),
        }
    }

    /// The margin at sample `t`, by the definition.
    fn margin(&self, t: usize, a_m: &[f64], b_m: &[f64]) -> f64 {
        let at = |tree: &Tree, t: usize| tree.margin(t, a_m, b_m);
        let last = a_m.len() - 1;
        let after = |i: &usize, j: &usize| (t + i)..=(t + i + j).min(last);
        match self {
            AtLeast(factor, number) => {
                f64::from(*factor) * a_m[t] - b_m[t].abs() - f64::from(*number)
            }
            Not(a) => -at(a, t),
            And(a, b) => at(a, t).min(at(b, t)),
            Or(a, b) => at(a, t).max(at(b, t)),
            Implies(a, b) => (-at(a, t)).max(at(b, t)),
            Always(i, j, a) => after(i, j).map(|u| at(a, u)).fold(f64::INFINITY, f64::min),
            Eventually(i, j, a) => after(i, j).map(|u| at(a, u)).fold(f64::NEG_INFINITY, f64::max),
            Once(i, j, a) => (*i..=i + j)
                .filter_map(|back| t.checked_sub(back))
                .map(|u| at(a, u))
                .fold(f64::NEG_INFINITY, f64::max),
            Until(i, j, a, b) => after(i, j)
                .map(|u| (t..u).map(|v| at(a, v)).fold(at(b, u), f64::min))
                .fold(f64::NEG_INFINITY, f64::max),
        }
    }
}

fn trees() -> impl Strategy<Value = Tree> {
    let leaf = (-3_i8..4, -9_i8..10).prop_map(|(factor, number)| AtLeast(factor, number));
    leaf.prop_recursive(4, 12, 2, |inner| {
        let boxed = inner.prop_map(Box::new).boxed();
        let window = || (0_usize..5, 0_usize..6);
        prop_oneof![
            boxed.clone().prop_map(Not),
            (boxed.clone(), boxed.clone()).prop_map(|(a, b)| And(a, b)),
            (boxed.clone(), boxed.clone()).prop_map(|(a, b)| Or(a, b)),
            (boxed.clone(), boxed.clone()).prop_map(|(a, b)| Implies(a, b)),
            (window(), boxed.clone()).prop_map(|((i, j), a)| Always(i, j, a)),
            (window(), boxed.clone()).prop_map(|((i, j), a)| Eventually(i, j, a)),
            (window(), boxed.clone()).prop_map(|((i, j), a)| Once(i, j, a)),
            (window(), boxed.clone(), boxed).prop_map(|((i, j), a, b)| Until(i, j, a, b)),
        ]
    })
}

proptest! {
    #[test]
    fn margins_are_those_of_the_definition(
        tree in trees(),
        samples in prop::collection::vec((-9_i8..10, -9_i8..10), 1..14),
    ) {
        let (a_m, b_m): (Vec<f64>, Vec<f64>) =
            samples.into_iter().map(|(a, b)| (f64::from(a), f64::from(b))).unzip();
        let formula = Formula::parse(&tree.text(), &SIGNALS).expect("well formed");
        let trace = Trace { period_s: 1.0, samples: vec![&a_m, &b_m] };
        let margin = formula.margin(&trace);
        prop_assert_eq!(margin.value, tree.margin(0, &a_m, &b_m), "{}", tree.text());
        prop_assert!(margin.sample < a_m.len());
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "[ a-z_0-9\\[\\](),.<>=*+é-]{0,60}") {
        let _ = Formula::parse(&text, &SIGNALS);
    }
}
