//! Tables in the units of a reader.

use super::{Cell, Table};
use crate::units::{Conversion, Units, decimals_of_cells, largest, numbers, renamed, unit_of};

impl Table {
    /// The table in these units. A unit ends the heading of its column, or is in square brackets at the end of the
    /// first cell of its row.
    pub(crate) fn in_units(mut self, units: Units) -> Self {
        if units == Units::Si {
            return self;
        }
        let text = |text: &mut String| *text = units.text(text).into_owned();
        for (place, column) in self.columns.iter_mut().enumerate() {
            let cells = self.rows.iter().filter_map(|row| row.get(place));
            match of_heading(units, &column.heading, cells) {
                None => text(&mut column.heading),
                Some(conversion) => {
                    column.heading = renamed(&column.heading, conversion);
                    in_column(
                        self.rows.iter_mut().filter_map(|row| row.get_mut(place)).collect(),
                        conversion,
                    );
                }
            }
        }
        for row in &mut self.rows {
            if let Some((first, cells)) = row.split_first_mut()
                && first.text.ends_with(']')
                && let Some(conversion) = of_heading(units, &first.text, cells.iter())
            {
                first.text = renamed(&first.text, conversion);
                in_column(cells.iter_mut().collect(), conversion);
            }
            for cell in row {
                text(&mut cell.text);
                text(&mut cell.spread);
            }
        }
        self.legend.iter_mut().for_each(text);
        self
    }
}

/// The conversion of the cells below or next to a heading with a unit; `None` if a cell has digits that are not plain
/// numbers, because the heading would no longer be true for it.
fn of_heading<'a>(units: Units, heading: &str, cells: impl Iterator<Item = &'a Cell>) -> Option<Conversion> {
    let mut most = 0.0_f64;
    for cell in cells.filter(|cell| cell.text.contains(|letter: char| letter.is_ascii_digit())) {
        most = most.max(largest(&cell.text)?);
    }
    units.conversion(unit_of(heading), most)
}

/// Converts cells with one unit, whose numbers have the same decimals if possible.
fn in_column(cells: Vec<&mut Cell>, conversion: Conversion) {
    let decimals = decimals_of_cells(cells.iter().map(|cell| cell.text.as_str()), conversion);
    for cell in cells {
        if let Some(shown) = numbers(&cell.text, conversion, decimals) {
            cell.text = shown;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::Column;

    fn texts(table: &Table) -> Vec<Vec<&str>> {
        table
            .rows
            .iter()
            .map(|row| row.iter().map(|cell| cell.text.as_str()).collect())
            .collect()
    }

    #[test]
    fn columns_and_cells_have_the_units_of_the_reader() {
        let columns = [
            Column::words("point"),
            Column::number("head mm"),
            Column::number("total dB"),
        ];
        let rows = [
            vec!["at 4.0 mm".into(), "4.0".into(), "100.2".into()],
            vec!["none".into(), "-".into(), "8.0 .. 9.0 J".into()],
        ];
        let table = Table::new(columns, rows);
        assert_eq!(table.clone().in_units(Units::Si), table);
        let shown = table.in_units(Units::Us);
        let headings: Vec<&str> = shown.columns.iter().map(|column| column.heading.as_str()).collect();
        assert_eq!(headings, ["point", "head in", "total dB"]);
        assert_eq!(
            texts(&shown),
            [["at 0.157 in", "0.157", "100.2"], ["none", "-", "5.90 .. 6.64 ft-lbf"]]
        );
    }

    #[test]
    fn a_heading_changes_only_with_all_of_its_numbers() {
        let rows = [vec!["8.0".into()], vec!["8.0 (7.0 .. 9.0)".into()]];
        let table = Table::new([Column::number("energy J")], rows);
        assert_eq!(table.clone().in_units(Units::Us), table);
    }

    #[test]
    fn the_numbers_of_a_column_have_the_same_decimals() {
        let rows = ["1.6", "5.3", "0.0", "12.4"].map(|text| vec![text.into()]);
        let shown = Table::new([Column::number("head mm")], rows).in_units(Units::Us);
        assert_eq!(texts(&shown), [["0.063"], ["0.209"], ["0.000"], ["0.488"]]);
    }

    #[test]
    fn a_check_has_its_unit_in_brackets() {
        let columns = [Column::words("check"), Column::number("value"), Column::number("limit")];
        let rows = [vec!["momentum balance [N s]".into(), "1.00e0".into(), "1e1".into()]];
        let shown = Table::new(columns, rows).in_units(Units::Us);
        assert_eq!(texts(&shown), [["momentum balance [lbf s]", "0.2248", "2.248"]]);
    }

    #[test]
    fn a_row_has_the_unit_of_its_name() {
        let columns = [Column::words("key"), Column::number("a"), Column::number("b")];
        let rows = [vec!["supply.pressure [Pa]".into(), "763200".into(), "689475.7".into()]];
        let shown = Table::new(columns, rows).in_units(Units::Us);
        assert_eq!(texts(&shown), [["supply.pressure [psi]", "110.69", "100.00"]]);
    }
}
