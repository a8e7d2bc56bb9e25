//! Declared noise emission values: the dual-number form of ISO 4871.
//!
//! ```text
//! L     level of the design itself          K = 1.645 sigma_t          L_d = L + K
//! ```
//!
//! L and K are stated separately, each rounded to the nearest decibel. sigma_t is the standard deviation over the draws
//! of a study: inputs from their ranges and errors of the methods replace the scatter of measurements and of machines.

use crate::result::{Declaration, EarReport};
use crate::study::StudyResult;
use crate::study::tolerance::STATED_FROM;

/// The 95 % quantile of the standard normal distribution, by which K follows from sigma_t (ISO 4871, A.2).
const QUANTILE: f64 = 1.645;

/// Text that replaces K below [`STATED_FROM`] draws, or if a study contradicts the design.
pub const NO_K: &str = "K not stated";

/// A level, or the uncertainty of one, in its declared form: to the nearest decibel \[dB\]. Halves are rounded up,
/// towards more noise.
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

/// K of a study \[dB\] and the origin of its sigma; none below [`STATED_FROM`] draws, or if draws are silent.
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

/// sigma_t of the total by a study \[dB\], and its origin.
fn deviation(study: &StudyResult) -> Option<(f64, String)> {
    let level = &study.total.level_db;
    let [low, high] = [level.p05.value?, level.p95.value?];
    let basis = format!("P5 to P95 of {} draws of inputs and methods", study.draws);
    (study.draws >= STATED_FROM).then(|| (0.5 * (high - low) / QUANTILE, basis))
}

/// The declaration in two lines. A missing statement is replaced by its reason.
pub fn lines(own: &Declaration, ear: &EarReport) -> [String; 2] {
    let level = |db: Option<i32>| db.map_or_else(|| "not stated: silent".to_owned(), |db| format!("{db} dB"));
    let k = match (own.k_db, &own.k_basis) {
        (Some(k), Some(_)) => format!("; K = {k} dB (1.645 sigma of the draws)"),
        _ => format!("; {NO_K}"),
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
        assert_eq!(power, "L_WA,1s 102 dB, at the ear L_pA,1s 92 dB; K not stated");
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
}
