//! Declared noise emission values: the dual-number form of ISO 4871.
//!
//! ```text
//! L     level of the design itself          K = 1.645 sigma_t          L_d = L + K
//! ```
//!
//! L and K are stated separately, each rounded to the nearest decibel. The standard deviation sigma_t is that over the
//! draws of a study. The ranges of inputs and the errors of methods take the role of the scatter of measurements and
//! machines.

use serde::Deserialize;

use crate::comparison::Input;
use crate::result::{Declaration, DesignId, EarReport, Ends, Performance, RunStudy, StudySummary, Total};
use crate::study::tolerance::STATED_FROM;

/// The 95 % quantile of the standard normal distribution, with which K is derived from sigma_t (ISO 4871, A.2).
const QUANTILE: f64 = 1.645;

/// A finished result as far as a declaration needs it.
#[derive(Debug, Clone, Deserialize)]
pub struct Finished {
    /// The design.
    pub(crate) design: DesignId,
    /// Its values.
    pub(crate) inputs: Vec<Input>,
    /// How the shot ended.
    pub(crate) outcome: String,
    /// Level of all sources together.
    pub(crate) total: Total,
    /// Reserve of the drive, air per shot, and rate; none in a result of an earlier version.
    #[serde(default)]
    pub(crate) performance: Option<Performance>,
    /// Sound pressure at the operator's ear.
    pub(crate) ear: EarReport,
    /// The declared levels.
    pub(crate) declaration: Declaration,
}

/// How a tool is used: an input of the levels of a working day.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Use {
    /// Shots a second \[Hz\].
    pub rate: f64,
    /// Shots of a working day.
    pub shots_a_day: f64,
}

/// Levels in use \[dB\]; none when silent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelsInUse {
    /// L_WA at the rate of shots \[dB re 1 pW\].
    pub power_db: Option<f64>,
    /// L_pA at the operator's ear at that rate \[dB re 20 uPa\].
    pub pressure_db: Option<f64>,
    /// L_EX,8h at the ear by the shots of the day \[dB re 20 uPa\].
    pub exposure_db: Option<f64>,
}

/// Duration of the working day of a daily noise exposure level (ISO 1999, 3.6) \[s\].
const WORKING_DAY: f64 = 28_800.0;

impl Use {
    /// Levels in use from L_WA,1s \[dB re 1 pW s\] and L_pA,1s \[dB re 20 uPa\] of one shot.
    pub fn levels(self, lwa_1s_db: Option<f64>, lpa_1s_db: Option<f64>) -> LevelsInUse {
        let more = |level: Option<f64>, shots: f64| level.map(|level| level + 10.0 * shots.log10());
        LevelsInUse {
            power_db: more(lwa_1s_db, self.rate),
            pressure_db: more(lpa_1s_db, self.rate),
            exposure_db: more(lpa_1s_db, self.shots_a_day / WORKING_DAY),
        }
    }
}

/// A level, or the uncertainty of one, in its declared form: to the nearest decibel \[dB\]. Halves are rounded up,
/// towards more noise.
pub fn rounded(db: f64) -> i32 {
    (db + 0.5).floor() as i32
}

/// The declaration of a run with this sound power level \[dB\], with K from its study.
pub fn declaration(lwa_db: Option<f64>, ear: &EarReport, study: &RunStudy) -> Declaration {
    let (k, k_not_stated) = match uncertainty(study) {
        Ok(k) => (Some(k), None),
        Err(reason) => (None, Some(reason)),
    };
    let (k_db, k_basis) = k.unzip();
    Declaration {
        lwa_1s_db: lwa_db.map(rounded),
        lpa_1s_db: ear.lpa_1s_db.map(rounded),
        lpc_peak_db: ear.lpc_peak_db.map(rounded),
        k_db,
        k_basis,
        k_not_stated,
    }
}

/// K \[dB\] and the origin of its sigma, or the reason why K is not stated.
fn uncertainty(study: &RunStudy) -> Result<(i32, String), String> {
    let study: &StudySummary = match study {
        RunStudy::Known(study) => study,
        RunStudy::Absent(none) => return Err(none.reason.clone()),
    };
    if !study.outside.is_empty() {
        return Err("the design lies outside its own interval of draws".to_owned());
    }
    if study.ends == Ends::Extremes {
        return Err(format!("K needs {STATED_FROM} draws, there are {}", study.draws));
    }
    let (Some(low), Some(high)) = (study.total.low_db, study.total.high_db) else {
        return Err("some draws are silent".to_owned());
    };
    let deviation = 0.5 * (high - low) / QUANTILE;
    let basis = format!("P5 to P95 of {} draws of inputs and methods", study.draws);
    Ok((rounded(QUANTILE * deviation), basis))
}

/// The declaration in two lines. A missing value is replaced by the reason.
pub fn lines(own: &Declaration, ear: &EarReport) -> [String; 2] {
    let level = |db: Option<i32>| db.map_or_else(|| "not stated: silent".to_owned(), |db| format!("{db} dB"));
    let k = match (own.k_db, &own.k_basis) {
        (Some(k), Some(_)) => format!("; K = {k} dB (1.645 sigma of the draws)"),
        _ => "; K not stated".to_owned(),
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
    use crate::result::LevelSpread;

    /// One shot per second has the levels of one shot; ten shots per second have 10 dB more. 28 800 shots a day are one
    /// per second.
    #[test]
    fn energies_of_shots_add() {
        let use_of = |rate, shots_a_day| Use { rate, shots_a_day }.levels(Some(102.0), Some(95.0));
        let once = use_of(1.0, WORKING_DAY);
        assert_eq!(
            (once.power_db, once.pressure_db, once.exposure_db),
            (Some(102.0), Some(95.0), Some(95.0))
        );
        let often = use_of(10.0, 0.1 * WORKING_DAY);
        assert_eq!((often.power_db, often.exposure_db), (Some(112.0), Some(85.0)));
        assert_eq!(
            Use {
                rate: 1.0,
                shots_a_day: 1.0
            }
            .levels(None, None)
            .exposure_db,
            None
        );
    }

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
            loudness: Vec::new(),
        }
    }

    #[test]
    fn a_level_that_cannot_be_stated_says_why() {
        let known = ear(None);
        let [power, peak] = lines(&declaration(Some(102.3), &known, &RunStudy::absent("")), &known);
        assert_eq!(power, "L_WA,1s 102 dB, at the ear L_pA,1s 92 dB; K not stated");
        assert_eq!(peak, "L_pC,peak 128 dB");
        let unknown = ear(Some("body known to 1818 Hz".to_owned()));
        let [_, peak] = lines(&declaration(Some(102.3), &unknown, &RunStudy::absent("")), &unknown);
        assert_eq!(
            peak,
            "L_pC,peak not stated: body known to 1818 Hz; with drawn phases 128 dB"
        );
    }

    fn study(draws: usize, ends: Ends, outside: &[&str]) -> RunStudy {
        let total = LevelSpread {
            source: "total".to_owned(),
            low_db: Some(95.0),
            median_db: Some(101.0),
            high_db: Some(105.4),
            first: None,
            silencing_db: None,
        };
        RunStudy::Known(Box::new(StudySummary {
            design: DesignId {
                name: "own".to_owned(),
                digest: String::new(),
            },
            draws,
            ends,
            structures: 0,
            require: Vec::new(),
            provided: None,
            weighting: None,
            sources: Vec::new(),
            total,
            outside: outside.iter().map(|name| (*name).to_owned()).collect(),
            orders: Vec::new(),
            deciding: Vec::new(),
        }))
    }

    /// Either K is stated or its absence has a reason, never both.
    #[test]
    fn k_is_half_the_interval_of_a_study_that_states_percentiles() {
        let of = |study: &RunStudy| declaration(Some(102.3), &ear(None), study);
        let own = of(&study(128, Ends::Percentiles, &[]));
        assert_eq!((own.k_db, &own.k_not_stated), (Some(5), &None));
        assert!(own.k_basis.is_some_and(|basis| basis.contains("128 draws")));
        for (study, reason) in [
            (study(8, Ends::Extremes, &[]), "needs 32 draws"),
            (study(128, Ends::Percentiles, &["body"]), "outside"),
            (RunStudy::absent("no draws"), "no draws"),
        ] {
            let own = of(&study);
            assert_eq!((own.k_db, own.k_basis), (None, None));
            assert!(own.k_not_stated.is_some_and(|text| text.contains(reason)), "{reason}");
        }
    }
}
