//! Converts the text of an assembly to the assembly.

use std::collections::BTreeSet;

use super::blocks;
use super::checks;
use super::fault::AssemblyError;
use super::keys::Keys;
use super::layers::AssemblyText;
use super::literal::Literal;
use super::resolver::Resolver;
use crate::network::assembly::Assembly;

/// An assembly, with the literals and keys that it uses.
#[derive(Debug, Clone, PartialEq)]
pub struct Resolved {
    /// The assembly.
    pub assembly: Assembly,
    /// Numbers that its files give, in the order of reading.
    pub literals: Vec<Literal>,
    /// Full names of the keys that its formulas use.
    pub keys: BTreeSet<String>,
}

impl AssemblyText {
    /// Evaluates the assembly.
    ///
    /// # Errors
    /// The first field, block or law that is wrong, with its location.
    pub fn resolve(&self, keys: &dyn Keys) -> Result<Resolved, AssemblyError> {
        let resolver = Resolver::new(self, keys)?;
        let assembly = blocks::read(&resolver)?;
        checks::run(&resolver, &assembly)?;
        let (literals, keys) = resolver.finish();
        Ok(Resolved {
            assembly,
            literals,
            keys,
        })
    }
}
