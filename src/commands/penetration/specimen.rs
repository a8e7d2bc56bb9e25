//! Woods and nails of `penetration law`: those of the published tests, and all others that designs can name.

use nailnoise_penetration::{NailSize, WOODS, WoodKind};

use crate::design::{self, Named, Value};
use crate::error::Error;
use crate::penetration::{self, PenetrationError};
use crate::scaling::Fastener;

/// The wood with this name among those of the published tests and of `nailnoise list woods`.
///
/// # Errors
/// [`PenetrationError::Unknown`] with all names.
pub(super) fn wood(name: &str) -> Result<&'static WoodKind, Error> {
    let unknown = match penetration::wood(name) {
        Ok(found) => return Ok(found),
        Err(unknown) => unknown,
    };
    let others = further_woods()?;
    let plain = |text: &str| text.trim().to_lowercase().replace(['-', '_', ' '], "");
    let names: Vec<&str> = others.iter().map(|own| own.name).collect();
    match others.iter().find(|own| plain(own.name) == plain(name)) {
        // The laws borrow their specimens for the whole process, which evaluates a few of them and ends.
        Some(own) => Ok(Box::leak(Box::new(*own))),
        None => Err(with(unknown, &format!(", {}", names.join(", "))).into()),
    }
}

/// Woods that designs can name and the published tests have not, by the keys of the catalogue.
pub(super) fn further_woods() -> Result<Vec<WoodKind>, Error> {
    let published = |own: &Named| WOODS.iter().any(|wood| wood.name.eq_ignore_ascii_case(own.name));
    let kind = |own: &Named| {
        let number = |key: &str| match own.sets.iter().find(|value| value.key == key)?.value {
            Value::Number(number) => Some(number),
            _ => None,
        };
        Some(WoodKind {
            name: own.name,
            hardness_modulus: number("wood.hardness_modulus")?,
            density: number("wood.density")?,
            moisture: number("wood.moisture").unwrap_or(f64::NAN),
        })
    };
    let all = design::woods()?;
    Ok(all.iter().filter(|own| !published(own)).filter_map(kind).collect())
}

/// The nail with this penny size, a fastener of `nailnoise list nails`, or one of length and diameter as "57 x 2.5 mm".
/// The flag says whether the published tests had this size.
///
/// # Errors
/// [`PenetrationError::Unknown`] with the sizes of the tests.
pub(super) fn nail(name: &str) -> Result<(&'static NailSize, bool), Error> {
    let unknown = match penetration::nail(name) {
        Ok(found) => return Ok((found, true)),
        Err(unknown) => unknown,
    };
    let own: Fastener = match name.parse() {
        Ok(own) => own,
        Err(_) => {
            let more = "; or a name of `nailnoise list nails`, or length and diameter as \"57 x 2.5 mm\"";
            return Err(with(unknown, more).into());
        }
    };
    let (length, diameter) = (own.length(), own.diameter());
    Ok((
        // See `wood`.
        Box::leak(Box::new(NailSize {
            name: Box::leak(own.words().into_boxed_str()),
            length,
            diameter,
            helical_diameter: Some(diameter),
        })),
        false,
    ))
}

/// An unknown name with more names to choose from.
fn with(unknown: PenetrationError, more: &str) -> PenetrationError {
    match unknown {
        PenetrationError::Unknown {
            what,
            name,
            nearest,
            known,
        } => PenetrationError::Unknown {
            what,
            name,
            nearest,
            known: known + more,
        },
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn woods_of_designs_are_woods_of_the_laws() {
        for (name, found) in [("pine", "pine"), ("Red-Oak", "red oak"), ("spruce", "spruce")] {
            let own = wood(name).unwrap();
            assert_eq!(own.name, found);
            assert!(
                own.hardness_modulus > 1e5 && (300.0..1000.0).contains(&own.density),
                "{own:?}"
            );
        }
        let error = wood("oka").unwrap_err().to_string();
        assert!(error.contains("no wood \"oka\""), "{error}");
    }

    #[test]
    fn a_nail_is_a_size_of_the_tests_a_name_or_two_lengths() {
        let (penny, tested) = nail("8d").unwrap();
        assert!(tested && penny.name == "8d");
        let (own, tested) = nail("57 x 2.5 mm").unwrap();
        assert!(!tested && own.name == "57 mm x 2.5 mm");
        assert!((own.length - 0.057).abs() < 1e-12 && (own.diameter - 0.0025).abs() < 1e-12);
        let (named, _) = nail("16ga finish 64").unwrap();
        assert!((named.length - 0.064).abs() < 1e-3, "{named:?}");
        assert!(nail("large").is_err());
    }
}
