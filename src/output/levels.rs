//! `levels.csv`: one-third-octave levels of the sources.

use nailnoise_acoustics::signals::energy_level;

use super::sources::{in_order, titles};
use super::table::{level, table};
use super::{Output, RunView};
use crate::error::Error;
use crate::result::BandLevel;

/// Levels in bands.
pub(super) const LEVELS: Output = Output::of_run("levels.csv", rows);

/// One-third-octave bands of each source and of the sum of all, unweighted and A-weighted. Silence gives an empty
/// field.
fn rows(of: &RunView<'_>) -> Result<Vec<u8>, Error> {
    let sources = in_order(&of.run.result);
    let bands = sources.first().map_or(&[][..], |source| &source.bands);
    let rows = bands.iter().enumerate().map(|(index, first)| {
        let own: Vec<&BandLevel> = sources.iter().filter_map(|source| source.bands.get(index)).collect();
        let sums = [0, 1].map(|weighted| own.iter().map(|band| band.energies()[weighted]).sum());
        let levels = own.iter().flat_map(|band| [band.lw_db, band.lwa_db]);
        let levels: Vec<String> = levels.chain(sums.map(energy_level)).map(level).collect();
        [first.hz.to_string()].into_iter().chain(levels)
    });
    let header = titles(&sources, ["L_W [dB]", "L_WA [dB]"]);
    table(["band [Hz]".to_owned()].into_iter().chain(header), rows)
}
