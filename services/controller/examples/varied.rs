use controller::law::{Ego, Input, MAX_SIGNALS, Output, Phase, PhaseInterval, SignalAhead, Target};
use controller::laws::cacc::{Signals, build, config::Config, road_config::RoadConfig};
use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use scenario::controller::SpacingPolicy;
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sc {
    A,
    B,
    C,
    T,
}
fn r2(v: f64) -> f64 {
    (v * 100.0).round() / 100.0
}
fn way(s: Sc, v: f64, t: f64) -> f64 {
    match s {
        Sc::A | Sc::C => v * t,
        Sc::B => {
            let o = std::f64::consts::TAU / 10.0;
            v * t + 2.0 / o * (t - libm::sin(o * t) / o)
        }
        Sc::T => {
            let (top, a) = (0.75 * v, 2.388);
            let g = t.min(top / a);
            0.5 * a * g * g + top * (t - g)
        }
    }
}
fn variant(s: Sc, number: u32) -> (f64, f64, f64) {
    let stream = 0x6361_6363 + ((s as u64) << 32);
    let mut g = Pcg64::seed_from_u64(stream ^ u64::from(number));
    let mut draw = |low: f64, high: f64| low + (high - low) * random::uniform(&mut g);
    let v = r2(draw(8.0, 22.0));
    let (f, t) = if s == Sc::T { (8.0, 12.0) } else { (4.0, 8.0) };
    let sw = r2(draw(f, t));
    let (f, t) = if s == Sc::C { (0.0, 3.0) } else { (-1.5, 1.5) };
    let w = way(s, v, sw + draw(f, t));
    (v, sw, r2(w))
}
fn drive(
    s: Sc,
    (v0, sw, line): (f64, f64, f64),
    light: bool,
    paper: bool,
    show: bool,
) -> (Option<f64>, f64) {
    let mut config = Config::default();
    if paper {
        config.spacing_policy = if s == Sc::T {
            SpacingPolicy::MeasuredHeadway
        } else {
            SpacingPolicy::ConstantDistance
        };
    } else {
        config.buffer_m = 5.0;
        config.road = RoadConfig { standstill_gap_m: 5.0, ..config.road };
    }
    let mut law = build(if light { Signals::Used } else { Signals::Ignored }, &config).unwrap();
    let (mut x, mut v, mut a) = (0.0, if s == Sc::T { 0.0 } else { v0 }, 0.0);
    let (mut xl, mut vl) = match s {
        Sc::A | Sc::B => (1.5 * v0 + 27.0, v0),
        Sc::C => (line - 0.5, 0.0),
        Sc::T => (26.0, 0.0),
    };
    let set = if s == Sc::T { v0 } else { 33.3 };
    let mut out = Output::default();
    let mut hardest = 0.0_f64;
    let n = ((sw + 8.0) / 0.1) as usize;
    for k in 0..n {
        let t = k as f64 * 0.1;
        let al = match s {
            Sc::A => 0.0,
            Sc::B => 2.0 * libm::sin(std::f64::consts::TAU * t / 10.0),
            Sc::C | Sc::T => {
                let (st, acc, top) =
                    if s == Sc::C { (sw, 3.0, v0) } else { (0.0, 2.388, 0.75 * v0) };
                if t >= st - 1e-9 && vl < top - 1e-9 {
                    f64::min(acc, (top - vl) / 0.1)
                } else {
                    0.0
                }
            }
        };
        let (p, o) =
            if s == Sc::C { (Phase::Red, Phase::Green) } else { (Phase::Green, Phase::Red) };
        let mut sig =
            SignalAhead { id: 256, distance_m: line - x, count: 1, ..SignalAhead::default() };
        let left = sw - t;
        if left > 1e-9 {
            sig.intervals[0] = PhaseInterval { phase: p, ends_in_s: left };
            sig.intervals[1] = PhaseInterval { phase: o, ends_in_s: left + 60.0 };
            sig.count = 2;
        } else {
            sig.intervals[0] = PhaseInterval { phase: o, ends_in_s: left + 60.0 };
        }
        let mut signals = [None; MAX_SIGNALS];
        signals[0] = Some(sig);
        let input = Input {
            time_s: t,
            period_s: 0.1,
            ego: Ego { position_m: x, speed_mps: v, acceleration_mps2: a },
            target: Some(Target {
                track_id: 1,
                gap_m: xl - x,
                relative_speed_mps: vl - v,
                acceleration_mps2: al,
                age_s: 0.0,
            }),
            signals,
            set_speed_mps: set,
            speed_limit_mps: f64::INFINITY,
            ..Input::default()
        };
        law.step(&input, &mut out);
        let u = out.request_mps2();
        if show && k % 2 == 0 {
            println!(
                "t{t:5.2} x{x:7.2} to{:7.2} v{v:6.2} a{a:6.2} u{u:6.2} gap{:6.2} vl{vl:6.2} mode {} why {} figs {:.2?}",
                line - x,
                xl - x,
                out.mode,
                out.mode_reason,
                &out.figures[2..]
            );
        }
        let x0 = x;
        x += 0.1 * v;
        v += 0.1 * a;
        a += 0.2 * (u - a);
        if v < 0.0 {
            v = 0.0;
            a = a.max(0.0);
        }
        xl += 0.1 * vl;
        vl += 0.1 * al;
        hardest = hardest.min(a);
        if x >= line {
            return (Some(t + 0.1 * (line - x0) / (x - x0)), hardest);
        }
    }
    (None, hardest)
}
fn med(mut v: Vec<f64>) -> f64 {
    v.sort_by(f64::total_cmp);
    if v.is_empty() { f64::NAN } else { v[v.len() / 2] }
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let scs = [Sc::A, Sc::B, Sc::C, Sc::T];
    if args.len() > 2 {
        let s = scs[args[1].parse::<usize>().unwrap()];
        let va = variant(s, args[2].parse().unwrap());
        println!("{va:?}");
        println!("{:?}", drive(s, va, args.len() <= 3, false, true));
        return;
    }
    let n: u32 = args.get(1).map_or(25, |a| a.parse().unwrap());
    for s in scs {
        let (mut ours, mut printed, mut red, mut stops, mut pa, mut pc, mut pp) =
            (vec![], vec![], 0, 0, 0, 0, 0);
        let mut hard = 0.0_f64;
        for k in 0..n {
            let va = variant(s, k);
            let [(acc, _), (cacc, h), (xacc, _), (xcacc, _)] =
                [(false, false), (true, false), (false, true), (true, true)]
                    .map(|(l, p)| drive(s, va, l, p, false));
            let green = |t: Option<f64>, sw: f64| t.filter(|t| (*t >= sw) == (s == Sc::C));
            pa += u32::from(green(acc, va.1).is_some());
            pc += u32::from(green(cacc, va.1).is_some());
            pp += u32::from(green(xcacc, va.1).is_some());
            let isred = cacc.is_some() && green(cacc, va.1).is_none();
            let stop =
                green(acc, if s == Sc::C { va.1 } else { va.1 - 0.1 }).is_some() && cacc.is_none();
            red += u32::from(isred);
            stops += u32::from(stop);
            hard = hard.min(h);
            if let (Some(c), Some(xc), Some(ac), Some(xa)) =
                (green(cacc, va.1), green(xcacc, va.1), acc, xacc)
            {
                ours.push(ac - c);
                printed.push(xa - xc);
            }
            if isred || stop || h < -3.2 || std::env::var_os("ALL").is_some() {
                println!(
                    "{s:?} {k} {va:?} acc {acc:.2?} cacc {cacc:.2?} xacc {xacc:.2?} xcacc {xcacc:.2?} hardest {h:.2}{}{}",
                    if isred { " RED" } else { "" },
                    if stop { " STOP" } else { "" }
                );
            }
        }
        println!(
            "{s:?}: n {n} pass acc {pa} cacc {pc} printed {pp} red {red} stops {stops} gain {:.3} printed {:.3} hardest {hard:.2}",
            med(ours),
            med(printed)
        );
    }
}
