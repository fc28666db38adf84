use super::*;
use crate::library::memory::Memory;

fn variation(body: &str) -> Result<Variation, ReadError> {
    let text = format!(
        "<OpenSCENARIO>\n<FileHeader revMajor=\"1\" revMinor=\"1\"/>\n<ParameterValueDistribution>\n\
         <ScenarioFile filepath=\"./sub/a.xosc\"/>\n{body}\n</ParameterValueDistribution></OpenSCENARIO>"
    );
    Variation::open(Path::new("dir/v.xosc"), &Memory::of(&[("dir/v.xosc", &text)]))
}

fn single_of(name: &str, inside: &str) -> String {
    format!(
        "<DeterministicSingleParameterDistribution parameterName=\"{name}\">{inside}</DeterministicSingleParameterDistribution>"
    )
}

fn shown(variation: &Variation, index: usize) -> String {
    let values = variation.get(index);
    values.iter().map(|a| format!("{}={}", a.name, a.value)).collect::<Vec<_>>().join(" ")
}

#[test]
fn all_combinations_are_made_the_last_fastest() {
    let range = "<DistributionRange stepWidth=\"0.1\"><Range lowerLimit=\"0.1\" upperLimit=\"0.3\"/></DistributionRange>";
    let sets = "<DeterministicMultiParameterDistribution><ValueSetDistribution>\
        <ParameterValueSet><ParameterAssignment parameterRef=\"a\" value=\"1\"/><ParameterAssignment parameterRef=\"b\" value=\"2\"/></ParameterValueSet>\
        <ParameterValueSet><ParameterAssignment parameterRef=\"a\" value=\"3\"/><ParameterAssignment parameterRef=\"b\" value=\"4\"/></ParameterValueSet>\
        </ValueSetDistribution></DeterministicMultiParameterDistribution>";
    let body = format!("<Deterministic>{}{sets}</Deterministic>", single_of("v", range));
    let variation = variation(&body).expect("it is right");
    assert_eq!(variation.scenario, Path::new("dir/sub/a.xosc"));
    assert_eq!(variation.len(), 6);
    assert_eq!(shown(&variation, 0), "v=0.1 a=1 b=2");
    assert_eq!(shown(&variation, 1), "v=0.1 a=3 b=4");
    assert_eq!(shown(&variation, 5), "v=0.3 a=3 b=4");
}

#[test]
fn draws_repeat_and_have_their_distribution() {
    let body = |seed: u32| {
        let one = |name: &str, inside: &str| {
            format!(
                "<StochasticDistribution parameterName=\"{name}\">{inside}</StochasticDistribution>"
            )
        };
        format!(
            "<Stochastic numberOfTestRuns=\"4000\" randomSeed=\"{seed}\">{}{}{}{}{}</Stochastic>",
            one("n", "<NormalDistribution expectedValue=\"5\" variance=\"4\"/>"),
            one(
                "u",
                "<UniformDistribution><Range lowerLimit=\"1\" upperLimit=\"3\"/></UniformDistribution>"
            ),
            one("p", "<PoissonDistribution expectedValue=\"3\"/>"),
            one(
                "h",
                "<Histogram><Bin weight=\"3\"><Range lowerLimit=\"0\" upperLimit=\"1\"/></Bin><Bin weight=\"1\"><Range lowerLimit=\"1\" upperLimit=\"2\"/></Bin></Histogram>"
            ),
            one(
                "s",
                "<ProbabilityDistributionSet><Element value=\"1\" weight=\"1\"/><Element value=\"0\" weight=\"3\"/></ProbabilityDistributionSet>"
            ),
        )
    };
    let drawn = variation(&body(7)).expect("it is right");
    assert_eq!(drawn, variation(&body(7)).expect("it is right"));
    assert_ne!(drawn, variation(&body(8)).expect("it is right"));
    let column = |i: usize| -> Vec<f64> {
        (0..drawn.len()).map(|run| drawn.get(run)[i].value.parse().expect("a number")).collect()
    };
    let moments = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>();
        (mean, square / values.len() as f64)
    };
    // Five standard errors of each mean for 4000 draws.
    for (i, mean, variance, margin) in [
        (0, 5.0, 4.0, 0.16),
        (1, 2.0, 1.0 / 3.0, 0.05),
        (2, 3.0, 3.0, 0.14),
        (3, 0.75, 0.27, 0.05),
        (4, 0.25, 0.1875, 0.035),
    ] {
        let (m, v) = moments(&column(i));
        assert!((m - mean).abs() < margin, "{i}: mean {m}");
        assert!((v - variance).abs() < 0.15 * variance, "{i}: variance {v}");
    }
    assert!(column(1).iter().all(|u| (1.0..3.0).contains(u)));
}

#[test]
fn what_gives_no_runs_is_refused() {
    let step = "<DistributionRange stepWidth=\"0\"><Range lowerLimit=\"0\" upperLimit=\"1\"/></DistributionRange>";
    for (body, expected) in [
        (format!("<Deterministic>{}</Deterministic>", single_of("v", step)), "`stepWidth` of `DistributionRange`: 0, expected more than 0"),
        (format!("<Deterministic>{0}{0}</Deterministic>", single_of("v", "<DistributionSet><Element value=\"1\"/></DistributionSet>")), "parameter `v` is varied twice, expected each once"),
        (format!("<Stochastic numberOfTestRuns=\"2\">{0}{0}</Stochastic>", "<StochasticDistribution parameterName=\"a\"><UniformDistribution><Range lowerLimit=\"0\" upperLimit=\"1\"/></UniformDistribution></StochasticDistribution>"), "parameter `a` is varied twice"),
        ("<Deterministic/>".to_owned(), "no combinations"),
        ("<Stochastic numberOfTestRuns=\"0\"><StochasticDistribution parameterName=\"a\"><UniformDistribution><Range lowerLimit=\"0\" upperLimit=\"1\"/></UniformDistribution></StochasticDistribution></Stochastic>".to_owned(), "no combinations"),
        ("<Stochastic numberOfTestRuns=\"1\"><StochasticDistribution parameterName=\"a\"><NormalDistribution expectedValue=\"0\" variance=\"1\"><Range lowerLimit=\"90\" upperLimit=\"91\"/></NormalDistribution></StochasticDistribution></Stochastic>".to_owned(), "holds next to none"),
    ] {
        let shown = variation(&body).expect_err("it is wrong").to_string();
        assert!(shown.starts_with("dir/v.xosc:5:") && shown.contains(expected), "{shown}");
    }
}
