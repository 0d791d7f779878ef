//! Progress of a run: bars with rate and time left on a terminal, plain lines every ten seconds elsewhere.
//!
//! One thread reads the gauges; nothing that mills ever prints.

use super::numbers::grouped;
use super::output::tell;
use crate::flow::gauges::Gauges;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How often a bar is drawn, and a line printed where there is no terminal.
const DRAW_EVERY: Duration = Duration::from_millis(100);
const LINE_EVERY: Duration = Duration::from_secs(10);

/// The thread that shows progress; it ends when this is dropped.
pub(crate) struct Progress {
    done: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Progress {
    /// Starts to show what the gauges say, on standard error.
    pub(crate) fn show(gauges: Arc<Gauges>) -> Progress {
        let done = Arc::new(AtomicBool::new(false));
        let stop = Arc::clone(&done);
        let thread = std::thread::spawn(move || {
            if std::io::stderr().is_terminal() {
                draw_bars(&gauges, &stop);
            } else {
                print_lines(&gauges, &stop);
            }
        });
        Progress { done, thread: Some(thread) }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.done.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // A panic of the drawing thread costs the drawing, not the run.
            let _ = thread.join();
        }
    }
}

fn draw_bars(gauges: &Gauges, stop: &AtomicBool) {
    let style = ProgressStyle::with_template("{prefix:<8} {bar:40.cyan/blue} {pos}/{len}   {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("━╸━");
    let mut bar: Option<(String, ProgressBar, Instant)> = None;
    loop {
        let ended = stop.load(Ordering::Relaxed);
        let phase = gauges.phase();
        if bar.as_ref().is_some_and(|(name, ..)| *name != phase)
            && let Some((_, bar, _)) = bar.take()
        {
            bar.abandon();
        }
        if !phase.is_empty() && bar.is_none() && !ended {
            let new = ProgressBar::new(0).with_style(style.clone()).with_prefix(phase.clone());
            bar = Some((phase, new, Instant::now()));
        }
        if let Some((_, bar, since)) = &bar {
            bar.set_length(gauges.clips_total.load(Ordering::Relaxed));
            bar.set_position(gauges.clips_done.load(Ordering::Relaxed));
            bar.set_message(words(gauges, since.elapsed()));
        }
        if ended {
            if let Some((_, bar, _)) = bar {
                bar.abandon();
            }
            return;
        }
        std::thread::park_timeout(DRAW_EVERY);
    }
}

fn print_lines(gauges: &Gauges, stop: &AtomicBool) {
    let start = Instant::now();
    let (mut last, mut phase, mut since) = (Instant::now(), String::new(), Instant::now());
    while !stop.load(Ordering::Relaxed) {
        std::thread::park_timeout(DRAW_EVERY);
        let now = gauges.phase();
        if now != phase {
            (phase, since) = (now, Instant::now());
        }
        if last.elapsed() >= LINE_EVERY && !phase.is_empty() {
            last = Instant::now();
            let (done, total) = (gauges.clips_done.load(Ordering::Relaxed), gauges.clips_total.load(Ordering::Relaxed));
            let words = words(gauges, since.elapsed());
            let seconds = start.elapsed().as_secs_f64();
            tell(&format!("{seconds:>5.0} s  {phase:<8} {}/{}   {words}", grouped(done), grouped(total)));
        }
    }
}

/// Frames, rate and time left, then what is being done.
fn words(gauges: &Gauges, elapsed: Duration) -> String {
    let seconds = elapsed.as_secs_f64().max(1e-3);
    let frames = gauges.frames.load(Ordering::Relaxed);
    let (done, total) = (gauges.clips_done.load(Ordering::Relaxed), gauges.clips_total.load(Ordering::Relaxed));
    let mut words = Vec::new();
    if frames > 0 {
        words.push(format!("{} frames   {} frames/s", grouped(frames), grouped((frames as f64 / seconds) as u64)));
    }
    if done > 0 && done < total {
        let left = seconds * (total - done) as f64 / done as f64;
        words.push(format!("{} left", super::numbers::duration(Duration::from_secs_f64(left))));
    }
    let detail = gauges.detail();
    if !detail.is_empty() {
        words.push(detail);
    }
    words.join("   ")
}
