//! `--watch`: the run in the terminal.

use super::feed::{Point, Update};
use super::history::History;
use group::Error;
use ratatui::Frame as Screen;
use ratatui::Terminal;
use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
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
use rustix::process::{Signal, getpid, kill_process};
use std::io::{IsTerminal, Stderr, stderr};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Longest time that a key waits.
const PATIENCE: Duration = Duration::from_millis(50);

/// Starts the view, which ends with its channel or the run. It draws on standard error: standard
/// output belongs to the results.
pub fn watch(title: String, updates: Receiver<Update>) -> Result<JoinHandle<()>, Error> {
    if !stderr().is_terminal() {
        return Err(Error::Usage("--watch needs a terminal".into()));
    }
    let failed = |error| Error::Machine(format!("cannot use the terminal: {error}"));
    let mut terminal = Held::take().map_err(failed)?;
    let thread = std::thread::Builder::new().name("watch".into());
    thread.spawn(move || terminal.follow(&title, &updates)).map_err(failed)
}

/// The terminal while it is ours; whatever happens it is given back.
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

    fn follow(&mut self, title: &str, updates: &Receiver<Update>) {
        let mut history = History::default();
        loop {
            match updates.recv_timeout(PATIENCE) {
                Ok(Update::Frame(frame)) => history.take(&frame),
                Ok(Update::Ended(_)) | Err(RecvTimeoutError::Disconnected) => return,
                Err(RecvTimeoutError::Timeout) => {}
            }
            while event::poll(Duration::ZERO).unwrap_or(false) {
                if let Ok(Event::Key(key)) = event::read()
                    && ends(key)
                {
                    // The way that everybody else's wish for an end takes as well.
                    let _ = kill_process(getpid(), Signal::INT);
                }
            }
            if self.0.draw(|screen| draw(screen, title, &history)).is_err() {
                // The terminal is gone; the run is not.
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
    // Who cannot restore the terminal can tell nobody either.
    let _ = disable_raw_mode();
    let _ = execute!(stderr(), LeaveAlternateScreen, cursor::Show);
}

fn ends(key: KeyEvent) -> bool {
    let control_c = key.code == KeyCode::Char('c') && key.modifiers.contains(KeyModifiers::CONTROL);
    key.kind == KeyEventKind::Press && (key.code == KeyCode::Char('q') || control_c)
}

/// One picture of the run.
fn draw(screen: &mut Screen<'_>, title: &str, history: &History) {
    let [head, charts, figures, foot] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Min(9),
        Constraint::Length(7),
        Constraint::Length(1),
    ])
    .areas(screen.area());
    let bold = Style::default().add_modifier(Modifier::BOLD);
    let time = format!("  {:.1} s", history.newest.time_s);
    screen.render_widget(Line::from(vec![Span::styled(title, bold), Span::raw(time)]), head);

    let [speed, gap, request] = Layout::vertical([Constraint::Ratio(1, 3); 3]).areas(charts);
    let ego = |value: fn(&Point) -> Option<f64>| history.series(value);
    strip(
        screen,
        speed,
        history,
        "speed, m/s",
        &[
            ("ego", Color::LightBlue, ego(|point| Some(point.speed_mps))),
            ("ahead", Color::Yellow, ego(|point| point.lead_speed_mps)),
        ],
    );
    strip(screen, gap, history, "gap, m", &[("", Color::LightBlue, ego(|point| point.gap_m))]);
    strip(
        screen,
        request,
        history,
        "acceleration, m/s²",
        &[
            ("request", Color::LightGreen, ego(|point| point.request_mps2)),
            ("is", Color::LightBlue, ego(|point| Some(point.acceleration_mps2))),
        ],
    );

    let [left, right] = Layout::horizontal([Constraint::Ratio(1, 2); 2]).areas(figures);
    screen.render_widget(Paragraph::new(state(history)).block(Block::bordered()), left);
    let events: Vec<Line<'_>> = match history.events.len() {
        0 => vec![Line::raw("nothing went wrong so far")],
        _ => (history.events.iter().rev())
            .map(|event| Line::raw(format!("{:8.3} s  {}", event.t_s, event.what)))
            .collect(),
    };
    screen.render_widget(Paragraph::new(events).block(Block::bordered().title("events")), right);
    screen.render_widget(Line::raw("q ends the run"), foot);
}

/// Mode, quality and latency.
fn state(history: &History) -> Vec<Line<'static>> {
    let newest = &history.newest;
    let answer = newest.answer_us.map_or_else(
        || "radar to answer  –".to_owned(),
        |p| format!("radar to answer  p50 {}, p99 {}", duration(p.p50), duration(p.p99)),
    );
    let worst = newest.answer_us.map_or_else(String::new, |p| {
        format!("                 max {} (n = {})", duration(p.max), p.count)
    });
    let point = history.points.back().copied().unwrap_or_default();
    let gap = point.gap_m.map_or_else(|| "–".to_owned(), |gap| format!("{gap:.1} m"));
    vec![
        Line::raw(format!("speed {:.1} m/s, gap {gap}", point.speed_mps)),
        Line::raw(format!("mode  {}", newest.mode)),
        Line::raw(format!("rung  {}, commands {}", newest.rung, newest.quality)),
        Line::raw(answer),
        Line::raw(worst),
    ]
}

/// A named curve with its colour.
type Strand<'a> = (&'a str, Color, Vec<(f64, f64)>);

/// A strip chart of named curves over the window.
fn strip(
    screen: &mut Screen<'_>,
    area: Rect,
    history: &History,
    title: &str,
    curves: &[Strand<'_>],
) {
    let (from, to) = history.window();
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

    fn history() -> History {
        let mut history = History::default();
        let points = (0..100).map(|i| Point {
            t_s: f64::from(i) / 10.0,
            speed_mps: 15.0 + f64::from(i % 7),
            gap_m: (i > 50).then_some(40.0),
            request_mps2: Some(-1.25),
            ..Point::default()
        });
        history.take(&Frame {
            time_s: 9.9,
            points: points.collect(),
            mode: "follow".into(),
            quality: "full",
            rung: "lead-predicted",
            events: vec![LiveEvent { t_s: 3.25, what: "kill controller".into() }],
            ..Frame::default()
        });
        history
    }

    fn picture(width: u16, height: u16, history: &History) -> String {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("a backend");
        terminal.draw(|screen| draw(screen, "cacc-a · cacc-mpc", history)).expect("drawn");
        terminal.backend().to_string()
    }

    #[test]
    fn the_run_is_on_the_screen() {
        let text = picture(100, 40, &history());
        for part in [
            "cacc-a · cacc-mpc  9.9 s",
            "speed, m/s  ego  ahead",
            "gap, m",
            "acceleration, m/s²",
            "mode  follow",
            "rung  lead-predicted, commands full",
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
            let _ = picture(width, height, &history());
            let _ = picture(width, height, &History::default());
        }
    }

    #[test]
    fn q_and_control_c_end_the_run() {
        assert!(ends(KeyEvent::new(KeyCode::Char('q'), KeyModifiers::NONE)));
        assert!(ends(KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL)));
        assert!(!ends(KeyEvent::new(KeyCode::Char('c'), KeyModifiers::NONE)));
    }
}
