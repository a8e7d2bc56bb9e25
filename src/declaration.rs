//! Declared noise emission values: the dual-number form of ISO 4871.
//!
//! ```text
//! L     level of the design itself          K = 1.645 sigma_t          L_d = L + K
//! ```
//!
//! L and K are stated apart, each rounded to the nearest decibel. sigma_t is the standard deviation over the draws of a study:
//! inputs from their ranges and errors of the methods, in place of the scatter of measurements and of machines.

use crate::result::{Declaration, EarReport};
use crate::study::{LevelStudy, StudyResult};

/// The 95 % quantile of the standard normal distribution, by which K follows from sigma_t (ISO 4871, A.2).
const QUANTILE: f64 = 1.645;

/// Draws from which a study states percentiles; with fewer, the lowest and the highest draw count.
pub const PERCENTILES_FROM: usize = 40;

/// A level, or the uncertainty of one, as it is declared: to the nearest decibel \[dB\]. Halves are rounded up, towards more noise.
pub fn rounded(db: f64) -> i32 {
    (db + 0.5).floor() as i32
}

/// The declaration of a run whose level of sound power is this \[dB\]; no study is known to it.
pub fn declaration(lwa_db: Option<f64>, ear: &EarReport) -> Declaration {
    Declaration {
        lwa_1s_db: lwa_db.map(rounded),
        lpa_1s_db: ear.lpa_1s_db.map(rounded),
        lpc_peak_db: ear.lpc_peak_db.map(rounded),
        k_db: None,
        k_basis: None,
    }
}

/// K of a study \[dB\] and where its sigma comes from; none where draws are silent.
pub fn uncertainty(study: &StudyResult) -> Option<(i32, String)> {
    deviation(study).map(|(deviation, basis)| (rounded(QUANTILE * deviation), basis))
}

/// A result as JSON with the K of a study in its declaration.
pub fn with_uncertainty(json: &str, (k, basis): &(i32, String)) -> String {
    json.replacen("\"k_db\": null", &format!("\"k_db\": {k}"), 1).replacen(
        "\"k_basis\": null",
        &format!("\"k_basis\": \"{basis}\""),
        1,
    )
}

/// sigma_t of the total by a study \[dB\], and where it comes from.
fn deviation(study: &StudyResult) -> Option<(f64, String)> {
    let LevelStudy {
        level_db, extremes_db, ..
    } = &study.total;
    if study.draws >= PERCENTILES_FROM {
        let [low, high] = [level_db.p05.value?, level_db.p95.value?];
        let basis = format!("P5 to P95 of {} draws of inputs and methods", study.draws);
        return Some((0.5 * (high - low) / QUANTILE, basis));
    }
    let [low, high] = [extremes_db[0]?, extremes_db[1]?];
    let basis = format!("range of {} draws of inputs and methods", study.draws);
    Some(((high - low) / expected_range(study.draws)?, basis))
}

/// Expected range of n draws from a standard normal distribution, int (1 - Phi^n - (1 - Phi)^n) dx; none below two draws.
fn expected_range(draws: usize) -> Option<f64> {
    let n = i32::try_from(draws).ok().filter(|n| *n >= 2)?;
    let step = 0.01;
    let integrand = |k: i32| {
        let below = 0.5 * libm::erfc(-f64::from(k) * step / std::f64::consts::SQRT_2);
        1.0 - below.powi(n) - (1.0 - below).powi(n)
    };
    Some((-800..=800).map(integrand).sum::<f64>() * step)
}

/// The declaration in two lines. What cannot be stated says why.
pub fn lines(own: &Declaration, ear: &EarReport) -> [String; 2] {
    let level = |db: Option<i32>| db.map_or_else(|| "not stated: silent".to_owned(), |db| format!("{db} dB"));
    let k = match (own.k_db, &own.k_basis) {
        (Some(k), Some(_)) => format!("; K = {k} dB (1.645 sigma of the draws)"),
        _ => "; K not known without a study".to_owned(),
    };
    let peak = match (&ear.not_stated, ear.lpc_peak_signal_db) {
        (Some(reason), Some(known)) => format!("not stated: {reason}; with drawn phases {known:.0} dB"),
        (Some(reason), None) => format!("not stated: {reason}"),
        (None, _) => level(own.lpc_peak_db),
    };
    [
        format!(
            "L_WA,1s {}, at the ear L_pA,1s {}{k}",
            level(own.lwa_1s_db),
            level(own.lpa_1s_db)
        ),
        format!("L_pC,peak {peak}"),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_rounded_to_the_nearest_decibel() {
        assert_eq!([102.3, 102.5, 88.49, 2.47, 0.3].map(rounded), [102, 103, 88, 2, 0]);
    }

    fn ear(not_stated: Option<String>) -> EarReport {
        EarReport {
            position_m: [0.0; 3],
            lpa_1s_db: Some(91.6),
            synthetic_share: 0.1,
            lpc_peak_db: Some(128.4).filter(|_| not_stated.is_none()),
            lpc_peak_signal_db: Some(128.4),
            not_stated,
        }
    }

    #[test]
    fn a_level_that_cannot_be_stated_says_why() {
        let known = ear(None);
        let [power, peak] = lines(&declaration(Some(102.3), &known), &known);
        assert_eq!(
            power,
            "L_WA,1s 102 dB, at the ear L_pA,1s 92 dB; K not known without a study"
        );
        assert_eq!(peak, "L_pC,peak 128 dB");
        let unknown = ear(Some("body known to 1818 Hz".to_owned()));
        let [_, peak] = lines(&declaration(Some(102.3), &unknown), &unknown);
        assert_eq!(
            peak,
            "L_pC,peak not stated: body known to 1818 Hz; with drawn phases 128 dB"
        );
    }

    #[test]
    fn the_uncertainty_of_a_study_enters_a_result() {
        let json = serde_json::to_string_pretty(&declaration(Some(102.3), &ear(None))).unwrap_or_default();
        let with = with_uncertainty(&json, &(7, "range of 8 draws".to_owned()));
        let read: Option<Declaration> = serde_json::from_str(&with).ok();
        let found = read.map(|own| (own.lwa_1s_db, own.k_db, own.k_basis));
        assert_eq!(found, Some((Some(102), Some(7), Some("range of 8 draws".to_owned()))));
    }

    /// Factors d_2 of the range of small samples (ISO 7870-2, Table 2).
    #[test]
    fn the_range_of_draws_has_the_published_expectation() {
        for (draws, expected) in [(2, 1.128), (5, 2.326), (8, 2.847), (10, 3.078), (25, 3.931)] {
            let found = expected_range(draws).unwrap_or(0.0);
            assert!((found - expected).abs() < 6e-4, "{draws}: {found}");
        }
        assert_eq!(expected_range(1), None);
    }
}
