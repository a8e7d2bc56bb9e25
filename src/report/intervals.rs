//! Intervals of the levels of a run.

/// Intervals of the levels of a run, as the command prints them.
pub struct Intervals {
    /// Headings of interval and probability.
    pub headings: [String; 2],
    /// Source or total, interval \[dB\] and probability of being the loudest.
    pub rows: Vec<[String; 3]>,
    /// Contents and omissions of the columns.
    pub legend: String,
}
