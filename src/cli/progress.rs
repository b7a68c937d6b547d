//! Progress on a terminal, silence in a pipe.

use indicatif::{ProgressBar, ProgressStyle};
use std::sync::Mutex;

const STEPS: f64 = 1000.0;

/// A bar from 0 to 1 with a label; indicatif hides it when stderr is not a terminal.
pub struct Bar {
    bar: ProgressBar,
    /// Finished share per part of the work.
    parts: Mutex<Vec<f64>>,
}

impl Bar {
    /// A bar over `parts` equal parts.
    pub fn new(label: &'static str, parts: usize) -> Self {
        let bar = ProgressBar::new(STEPS as u64);
        let style = ProgressStyle::with_template("{msg:12} [{bar:40}] {percent:>3} %  {elapsed} (left {eta})");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
        bar.set_message(label);
        Bar { bar, parts: Mutex::new(vec![0.0; parts.max(1)]) }
    }

    /// Part `k` is done to the share `done`.
    pub fn set(&self, k: usize, done: f64) {
        // A poisoned lock means that a worker panicked; its panic is the news, not the bar.
        let Ok(mut parts) = self.parts.lock() else { return };
        parts[k] = parts[k].max(done);
        let mean = parts.iter().sum::<f64>() / parts.len() as f64;
        self.bar.set_position((mean * STEPS) as u64);
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
