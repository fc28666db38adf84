//! `--watch`: the run in the terminal.

use super::feed::{Frame, Point};
use ratatui::Frame as Screen;
use ratatui::Terminal;
use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::terminal::{
    EnterAlternateScreen, LeaveAlternateScreen, disable_raw_mode, enable_raw_mode,
};
use ratatui::crossterm::{cursor, execute};
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Block, Chart, Dataset, GraphType, Paragraph};
use report::print::duration;
use runtime::statistics::Percentiles;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::process::{Signal, getpid, kill_process};
use std::fs::File;
use std::io::{IsTerminal, Stderr, stderr, stdin};
use std::os::fd::{AsFd, OwnedFd};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::thread::JoinHandle;
use std::time::Duration;
use supervise::{Error, MachineError, UsageError};

/// Longest time until a key is read.
const PATIENCE: Duration = Duration::from_millis(50);
/// Ctrl-C as a byte: a terminal in raw mode sends no signal for it.
const CONTROL_C: u8 = 3;
/// First byte of a key's escape sequence.
const ESCAPE: u8 = 0x1b;

/// Starts the view, which ends with its channel or with the terminal. It draws on standard error:
/// standard output belongs to the results.
pub fn watch(title: String, frames: Receiver<Frame>) -> Result<JoinHandle<()>, Error> {
    if !stderr().is_terminal() {
        return Err(UsageError::at("--watch", "standard error is none", "a terminal").into());
    }
    let start = || {
        let keys = Keys::open()?;
        let mut terminal = Held::take()?;
        let thread = std::thread::Builder::new().name("watch".into());
        thread.spawn(move || terminal.follow(&title, &frames, &keys))
    };
    Ok(start().map_err(MachineError::cannot("use the terminal"))?)
}

/// Request from the terminal's keyboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    /// No key, or one without a meaning.
    Nothing,
    End,
    /// The terminal is closed: end the run with it.
    Gone,
}

struct Keys(OwnedFd);

impl Keys {
    fn open() -> std::io::Result<Self> {
        if stdin().is_terminal() {
            return stdin().as_fd().try_clone_to_owned().map(Self);
        }
        File::open("/dev/tty").map(|tty| Self(tty.into()))
    }

    /// The request since the last call. Never waits.
    fn asked(&self) -> Asked {
        let mut fds = [PollFd::new(&self.0, PollFlags::IN)];
        if poll(&mut fds, Some(&Timespec::default())).is_err() {
            return Asked::Nothing;
        }
        let found = fds[0].revents();
        if !found.contains(PollFlags::IN) {
            let gone = found.intersects(PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL);
            return if gone { Asked::Gone } else { Asked::Nothing };
        }
        let mut bytes = [0; 64];
        match rustix::io::read(&self.0, &mut bytes) {
            // A closed terminal: a poll reports it as readable for ever.
            Ok(0) => Asked::Gone,
            Ok(count) => meaning(&bytes[..count]),
            Err(Errno::INTR | Errno::AGAIN) => Asked::Nothing,
            Err(_) => Asked::Gone,
        }
    }
}

fn meaning(bytes: &[u8]) -> Asked {
    let ends = bytes.first() != Some(&ESCAPE)
        && bytes.iter().any(|&byte| byte == b'q' || byte == CONTROL_C);
    if ends { Asked::End } else { Asked::Nothing }
}

/// The terminal in raw mode; dropping it restores the terminal.
struct Held(Terminal<CrosstermBackend<Stderr>>);

impl Held {
    fn take() -> std::io::Result<Self> {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            give_back();
            before(panic);
        }));
        enable_raw_mode()?;
        if let Err(error) = execute!(stderr(), EnterAlternateScreen, cursor::Hide) {
            give_back();
            return Err(error);
        }
        Terminal::new(CrosstermBackend::new(stderr())).map(Self).inspect_err(|_| give_back())
    }

    fn follow(&mut self, title: &str, frames: &Receiver<Frame>, keys: &Keys) {
        let mut newest = Frame::default();
        loop {
            match frames.recv_timeout(PATIENCE) {
                Ok(frame) => newest = frame,
                Err(RecvTimeoutError::Disconnected) => return,
                Err(RecvTimeoutError::Timeout) => {}
            }
            let asked = keys.asked();
            let gone =
                asked == Asked::Gone || self.0.draw(|screen| draw(screen, title, &newest)).is_err();
            if gone || asked == Asked::End {
                // The run ends as on any other SIGINT.
                let _ = kill_process(getpid(), Signal::INT);
            }
            if gone {
                return;
            }
        }
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        give_back();
    }
}

fn give_back() {
    // A terminal that cannot be restored is closed.
    let _ = disable_raw_mode();
    let _ = execute!(stderr(), LeaveAlternateScreen, cursor::Show);
}

fn draw(screen: &mut Screen<'_>, title: &str, newest: &Frame) {
    let [head, charts, figures, foot] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Min(9),
        Constraint::Length(STATE_LINES + 2),
        Constraint::Length(1),
    ])
    .areas(screen.area());
    let bold = Style::default().add_modifier(Modifier::BOLD);
    let time = format!("  {:.1} of {:.1} s", newest.time_s, newest.duration_s);
    screen.render_widget(Line::from(vec![Span::styled(title, bold), Span::raw(time)]), head);

    let [speed, gap, request] = Layout::vertical([Constraint::Ratio(1, 3); 3]).areas(charts);
    let ego = |value: fn(&Point) -> Option<f64>| newest.series(value);
    strip(
        screen,
        speed,
        newest,
        "speed, m/s",
        &[
            ("ego", Color::LightBlue, ego(|point| Some(point.speed_mps))),
            ("ahead", Color::Yellow, ego(|point| point.lead_speed_mps)),
        ],
    );
    strip(screen, gap, newest, "gap, m", &[("", Color::LightBlue, ego(|point| point.gap_m))]);
    strip(
        screen,
        request,
        newest,
        "acceleration, m/s²",
        &[
            ("request", Color::LightGreen, ego(|point| point.request_mps2)),
            ("is", Color::LightBlue, ego(|point| Some(point.acceleration_mps2))),
        ],
    );

    let [left, right] = Layout::horizontal([Constraint::Ratio(1, 2); 2]).areas(figures);
    screen.render_widget(Paragraph::new(state(newest)).block(Block::bordered()), left);
    let events: Vec<Line<'_>> = match newest.events.len() {
        0 => vec![Line::raw("no faults so far")],
        _ => (newest.events.iter().rev())
            .map(|event| Line::raw(format!("{:8.3} s  {}", event.t_s, event.what)))
            .collect(),
    };
    screen.render_widget(Paragraph::new(events).block(Block::bordered().title("events")), right);
    screen.render_widget(Line::raw("q ends the run"), foot);
}

const STATE_LINES: u16 = 7;

/// Mode, level of degradation and latency, in lines of at most 28 characters: half of 60 columns without
/// its border.
fn state(newest: &Frame) -> Vec<Line<'static>> {
    let answer = |name: &str, of: fn(&Percentiles) -> Option<f64>| {
        let us = newest.answer_us.as_ref().and_then(of).map_or_else(|| "–".to_owned(), duration);
        format!("{name} {us}")
    };
    let count = newest.answer_us.map_or(0, |p| p.count);
    let point = newest.points.last().copied().unwrap_or_default();
    let gap = point.gap_m.map_or_else(|| "–".to_owned(), |gap| format!("{gap:.1} m"));
    vec![
        Line::raw(format!("{:.1} m/s, gap {gap}", point.speed_mps)),
        Line::raw(format!("mode   {}", newest.mode)),
        Line::raw(format!("level  {}", newest.level)),
        Line::raw(format!("command {}", newest.quality)),
        Line::raw(answer("radar-command p50", |p| Some(p.p50))),
        Line::raw(answer("              p99", report::print::p99)),
        Line::raw(answer("              max", |p| Some(p.max)) + &format!(" (n = {count})")),
    ]
}

type Strand<'a> = (&'a str, Color, Vec<(f64, f64)>);

/// A strip chart of named curves over the window.
fn strip(screen: &mut Screen<'_>, area: Rect, newest: &Frame, title: &str, curves: &[Strand<'_>]) {
    let (from, to) = newest.window();
    let values = || curves.iter().flat_map(|curve| &curve.2).map(|point| point.1);
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (value.min(low), value.max(high))
    });
    let (low, high) = if low > high { (0.0, 1.0) } else { (low, high.max(low + 1.0)) };
    let names = curves
        .iter()
        .map(|(name, colour, _)| Span::styled(format!("  {name}"), Style::default().fg(*colour)));
    let title = Line::from_iter([Span::raw(title.to_owned())].into_iter().chain(names));
    let datasets = curves
        .iter()
        .filter(|curve| !curve.2.is_empty())
        .map(|(_, colour, points)| {
            Dataset::default()
                .marker(Marker::Braille)
                .graph_type(GraphType::Line)
                .style(Style::default().fg(*colour))
                .data(points)
        })
        .collect();
    let x =
        Axis::default().bounds([from, to]).labels([format!("{from:.0} s"), format!("{to:.0} s")]);
    let y = Axis::default().bounds([low, high]).labels([format!("{low:.1}"), format!("{high:.1}")]);
    let chart = Chart::new(datasets).block(Block::bordered().title(title)).x_axis(x).y_axis(y);
    screen.render_widget(chart, area);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::live::feed::{Frame, LiveEvent};
    use ratatui::backend::TestBackend;

    fn frame() -> Frame {
        let points = (0..100).map(|i| Point {
            t_s: f64::from(i) / 10.0,
            speed_mps: 15.0 + f64::from(i % 7),
            gap_m: (i > 50).then_some(40.0),
            request_mps2: Some(-1.25),
            ..Point::default()
        });
        Frame {
            time_s: 9.9,
            duration_s: 20.0,
            points: points.collect(),
            mode: "follow".into(),
            quality: "full",
            level: "lead-predicted",
            events: vec![LiveEvent { t_s: 3.25, what: "kill controller".into() }],
            ..Frame::default()
        }
    }

    fn picture(width: u16, height: u16, newest: &Frame) -> String {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("a backend");
        terminal.draw(|screen| draw(screen, "cacc-a · cacc-mpc", newest)).expect("drawn");
        terminal.backend().to_string()
    }

    #[test]
    fn the_run_is_on_the_screen() {
        let text = picture(100, 40, &frame());
        for part in [
            "cacc-a · cacc-mpc  9.9 of 20.0 s",
            "speed, m/s  ego  ahead",
            "gap, m",
            "acceleration, m/s²",
            "mode   follow",
            "level  lead-predicted",
            "command full",
            "3.250 s  kill controller",
            "q ends the run",
        ] {
            assert!(text.contains(part), "{part}\n{text}");
        }
        assert!(text.chars().any(|c| ('\u{2801}'..='\u{28ff}').contains(&c)), "curves\n{text}");
    }

    #[test]
    fn a_small_or_empty_screen_is_no_trouble() {
        for (width, height) in [(1, 1), (20, 5), (80, 24)] {
            let _ = picture(width, height, &frame());
            let _ = picture(width, height, &Frame::default());
        }
    }

    #[test]
    fn figures_are_whole_at_60_and_80_columns() {
        let mut newest = frame();
        let p = 123_456.7;
        let answers = Percentiles { p50: p, p90: p, p99: p, p999: p, p9999: p, max: p, count: 700 };
        newest.answer_us = Some(answers);
        for width in [60, 80] {
            let text = picture(width, 40, &newest);
            let shown = report::print::duration(p);
            for part in ["p50", "p99", "max"].map(|name| format!("{name} {shown}")) {
                assert!(text.contains(&part), "{part} at {width} columns\n{text}");
            }
        }
    }

    #[test]
    fn q_and_control_c_end_the_run() {
        assert_eq!(meaning(b"q"), Asked::End);
        assert_eq!(meaning(&[b'x', CONTROL_C]), Asked::End);
        assert_eq!(meaning(b"c"), Asked::Nothing);
        assert_eq!(meaning(b"\x1b[q"), Asked::Nothing, "a key with an escape sequence");
    }

    #[test]
    fn a_terminal_that_is_gone_is_noticed_and_never_waited_for() {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        let keys = Keys(reader.into());
        assert_eq!(keys.asked(), Asked::Nothing);
        drop(writer);
        assert_eq!(keys.asked(), Asked::Gone);
    }
}
