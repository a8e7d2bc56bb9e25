//! How changes of levels, bands around them and the order that follows are put into words, alike in tables and pages.

/// A change of a level to a tenth, with its sign: `-0.4`, `+1.2`; `0.0` for what rounds to nothing.
pub(crate) fn change(db: f64) -> String {
    let rounded = (10.0 * db).round() / 10.0;
    if rounded == 0.0 {
        "0.0".to_owned()
    } else {
        format!("{rounded:+.1}")
    }
}

/// How much lower and how much higher than predicted a level may be: `-4.0 .. +4.0`, to a tenth and never to nothing;
/// `open` where there is no bound.
pub(crate) fn band([minus, plus]: [Option<f64>; 2]) -> String {
    let side = |sign: char, bound: Option<f64>| match bound {
        None => "open".to_owned(),
        Some(0.0) => "0.0".to_owned(),
        Some(bound) => format!("{sign}{:.1}", bound.abs().max(0.1)),
    };
    format!("{} .. {}", side('-', minus), side('+', plus))
}

/// A source in a ranking: its name, its level \[dB\] and the band around it \[dB\].
pub(crate) type Placed<'a> = (&'a str, Option<f64>, [Option<f64>; 2]);

/// Which neighbours of a ranking, loudest first, may change places because their bands overlap.
pub(crate) fn order(ranking: &[Placed<'_>]) -> String {
    let overlaps = |pair: &&[Placed<'_>]| {
        let [(_, Some(above), [minus, _]), (_, Some(below), [_, plus])] = pair else {
            return false;
        };
        let lowest = minus.map_or(f64::NEG_INFINITY, |minus| above - minus);
        plus.is_none_or(|plus| below + plus > lowest)
    };
    let open: Vec<String> = ranking
        .windows(2)
        .filter(overlaps)
        .map(|pair| format!("{} and {}", pair[0].0, pair[1].0))
        .collect();
    if open.is_empty() {
        "every place is firm: no bands of neighbours overlap".to_owned()
    } else {
        format!("may change places, as their bands overlap: {}", open.join("; "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_that_rounds_to_nothing_has_no_sign() {
        let expected = [
            (-0.04, "0.0"),
            (0.04, "0.0"),
            (0.0, "0.0"),
            (-0.06, "-0.1"),
            (1.25, "+1.3"),
        ];
        for (db, text) in expected {
            assert_eq!(change(db), text);
        }
    }

    #[test]
    fn a_bound_is_never_printed_as_nothing_and_a_missing_one_is_open() {
        assert_eq!(band([Some(4.0), Some(0.04)]), "-4.0 .. +0.1");
        assert_eq!(band([None, Some(0.0)]), "open .. 0.0");
        assert_eq!(band([None, None]), "open .. open");
    }

    #[test]
    fn neighbours_change_places_where_their_bands_overlap() {
        let table = ("workpiece", Some(100.2), [Some(0.1), Some(0.1)]);
        let exhaust = |plus: Option<f64>| ("exhaust", Some(96.6), [Some(4.0), plus]);
        let body = ("body", Some(90.0), [None, Some(2.4)]);
        assert!(order(&[table, exhaust(Some(3.4)), body]).starts_with("every place is firm"));
        assert!(order(&[table, exhaust(Some(3.6)), body]).ends_with("overlap: workpiece and exhaust"));
        assert!(order(&[table, exhaust(None), body]).ends_with("overlap: workpiece and exhaust"));
        assert!(order(&[body, ("silent", None, [None, None])]).starts_with("every place is firm"));
    }
}
