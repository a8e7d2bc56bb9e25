//! Tables as HDF5, by the crate hdf5-pure: a data set for each column, which xarray and h5py read.

use hdf5_pure::{AttrValue, FileBuilder};

use crate::error::Error;

/// Attribute of a data set with the unit of its numbers, as xarray and the CF conventions name it.
const UNITS: &str = "units";

/// A table of text in one file. A column of numbers is in double precision, with NaN for blank cells; its unit, the
/// last part of the heading in brackets, is an attribute. Any other column is text.
///
/// # Errors
/// [`Error::Hdf5`] if two columns have the same name.
pub(crate) fn table_hdf5(header: &[String], rows: &[Vec<String>]) -> Result<Vec<u8>, Error> {
    let mut file = FileBuilder::new();
    for (place, heading) in header.iter().enumerate() {
        let (name, unit) = parts(heading);
        // A slash separates groups.
        let column = file.create_dataset(&name.replace('/', " per "));
        let cells = || rows.iter().map(|row| row.get(place).map_or("", String::as_str));
        let number = |cell: &str| if cell.is_empty() { Ok(f64::NAN) } else { cell.parse() };
        match cells().map(number).collect::<Result<Vec<f64>, _>>() {
            Ok(numbers) => column.with_f64_data(&numbers),
            Err(_) => column.with_vlen_strings(&cells().collect::<Vec<_>>()),
        };
        if let Some(unit) = unit {
            column.set_attr(UNITS, AttrValue::String(unit.to_owned()));
        }
    }
    file.finish().map_err(Error::Hdf5)
}

/// Name and unit of a heading, `penetration [m]`.
fn parts(heading: &str) -> (&str, Option<&str>) {
    match heading.rsplit_once(" [") {
        Some((name, unit)) => (name, unit.strip_suffix(']')),
        None => (heading, None),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn columns_read_back_with_their_units() {
        let header = ["draw", "outcome", "speed [m/s]"].map(str::to_owned);
        let rows = [["0", "drives", "2.5e1"], ["1", "", ""]].map(|row| row.map(str::to_owned).to_vec());
        let file = hdf5_pure::File::from_bytes(table_hdf5(&header, &rows).unwrap()).unwrap();
        let column = |name: &str| file.dataset(name).unwrap();
        assert_eq!(column("draw").read_f64().unwrap(), [0.0, 1.0]);
        assert_eq!(column("outcome").read_string().unwrap(), ["drives", ""]);
        let speed = column("speed");
        let values = speed.read_f64().unwrap();
        assert!(values[0] == 25.0 && values[1].is_nan());
        assert_eq!(speed.attrs().unwrap()["units"].as_str(), Some("m/s"));
    }
}
