//! Text about the intervals of a run, the same for the terminal and the page. A terminal breaks a line where its text
//! does.

use super::tolerance::{STATED_FROM, content, next_within};
use crate::result::{Ends, RunResult, RunStudy, StudySummary};

/// Headings of the columns that a study adds to the table of sources: interval, and probability of being the loudest.
pub fn headings(study: &StudySummary) -> [String; 2] {
    match study.ends {
        Ends::Percentiles => ["90 % of draws dB".to_owned(), "P(first)".to_owned()],
        Ends::Extremes => [format!("{} draws dB", study.draws), "loudest in".to_owned()],
    }
}

/// Cells of these columns for a source, or for the total.
pub fn cells(study: &StudySummary, source: &str) -> [String; 2] {
    let spread = study.spread(source);
    let first = match (spread.first, study.ends) {
        (None, _) if !study.outside.is_empty() || spread.source == study.total.source => String::new(),
        (None, _) => "-".to_owned(),
        (Some(share), Ends::Percentiles) => format!("{share:.2}"),
        (Some(share), Ends::Extremes) => format!("{:.0} of {}", share * study.draws as f64, study.draws),
    };
    [interval(study, source), first]
}

fn interval(study: &StudySummary, source: &str) -> String {
    let spread = study.spread(source);
    let [low, high] = [spread.low_db, spread.high_db].map(level);
    format!("{low} .. {high}")
}

/// A level with one decimal; a dash for silence.
fn level(db: Option<f64>) -> String {
    db.map_or_else(|| "-".to_owned(), |db| format!("{db:.1}"))
}

/// A fraction of the draws in percent, or as a count if they are few.
fn of_draws(share: f64, study: &StudySummary) -> String {
    match study.ends {
        Ends::Percentiles => format!("{:.0} % of the draws", 100.0 * share),
        Ends::Extremes => format!("{:.0} of {} draws", share * study.draws as f64, study.draws),
    }
}

/// Explanation of the columns; without a study, the reason.
pub fn legend(result: &RunResult) -> Vec<String> {
    match &result.study {
        RunStudy::Known(study) => of_study(study, result),
        RunStudy::Absent(none) if none.unmet.is_some() => vec![none.reason.clone()],
        RunStudy::Absent(none) => vec![format!("how sure these levels are is not known: {}", none.reason)],
    }
}

fn of_study(study: &StudySummary, result: &RunResult) -> Vec<String> {
    let mut lines = vec![basis(study)];
    lines.extend(study.provided.as_ref().map(|own| {
        let made = format!(
            "this study comes with the program: `{}`, version {}",
            own.command, own.version
        );
        match own.current {
            true => made,
            false => format!(
                "{made};\nthe code has changed since, so that its levels may differ from those of today; \
                 the command makes it anew"
            ),
        }
    }));
    if !study.outside.is_empty() {
        let level_of = |name: &str| {
            let own = result.ranking.iter().find(|own| own.source == name);
            level(own.map_or(result.total.lwa_db, |own| own.lwa_db))
        };
        let outside = study.outside.iter();
        let outside = outside.map(|name| format!("{name} {} dB, draws {} dB", level_of(name), interval(study, name)));
        lines.push(format!(
            "the design lies outside its own interval: {};\nits values and ranges contradict each other, so that \
             no P(first), no order and no K are stated;\n`nailnoise study` lists the values at an end of their range",
            outside.collect::<Vec<_>>().join("; ")
        ));
    }
    lines.extend(orders(study));
    lines.extend(deciding(study));
    lines
}

/// The draws from which the intervals follow.
fn basis(study: &StudySummary) -> String {
    let structures = match study.structures {
        0 => "structures as in the design".to_owned(),
        count => format!("{count} structures"),
    };
    let condition = match study.require.as_slice() {
        [] => String::new(),
        outcomes => format!(", outcome {}", outcomes.join(" or ").replace('_', " ")),
    };
    match (&study.weighting, study.ends) {
        (Some(weighting), _) => format!(
            "90 % of draws, P(first): {} draws of {}, weighted for other ranges of {}: worth {:.0} draws;\n\
             {structures}{condition}; `nailnoise study` makes draws of this design",
            weighting.draws,
            study.design.name,
            weighting.keys.join(", "),
            weighting.effective
        ),
        (None, Ends::Percentiles) => format!(
            "90 % of draws, P(first): {} draws from the ranges, {structures}{condition};\n\
             `nailnoise study` has the details",
            study.draws
        ),
        (None, Ends::Extremes) => {
            let content = content(study.draws).map_or_else(String::new, |share| {
                format!(
                    ", and with 90 % confidence at least {:.0} % of all do (Wilks 1941)",
                    (100.0 * share).floor()
                )
            });
            format!(
                "{} draws: lowest and highest level of draws from the ranges and of the design, \
                 {structures}{condition};\n\
                 a further draw lies between with a probability of {:.0} %{content};\n\
                 percentiles, P(first) and K need {STATED_FROM} draws: `nailnoise study`, \
                 which also says which inputs decide",
                study.draws,
                100.0 * next_within(study.draws)
            )
        }
    }
}

/// The two most frequent orders; none for a single source.
fn orders(study: &StudySummary) -> Option<String> {
    let (first, rest) = study.orders.split_first().filter(|(first, _)| first.order.len() > 1)?;
    // If eight draws out of eight agree, the probability of another order is up to 31 %, at 95 % confidence.
    let certain = match study.ends {
        Ends::Percentiles if first.share >= 0.95 => "",
        _ => "not certain: ",
    };
    let next = rest.first().map_or_else(String::new, |next| {
        format!(",\n  {} in {}", next.order.join(" > "), of_draws(next.share, study))
    });
    Some(format!(
        "ranking {certain}{} in {}{next}",
        first.order.join(" > "),
        of_draws(first.share, study)
    ))
}

/// The inputs that affect the total most.
fn deciding(study: &StudySummary) -> Option<String> {
    let named = study.deciding.iter().map(|own| {
        let error = own.half_width;
        let error = error.map_or_else(String::new, |half| format!(" +-{:.0}", 100.0 * half));
        format!("`{}` ({:.0}{error} %)", own.variable, 100.0 * own.first_order)
    });
    let named: Vec<String> = named.collect();
    (!named.is_empty()).then(|| format!("inputs that decide the total: {}", named.join(", ")))
}
