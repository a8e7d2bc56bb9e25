//! Identity of a design in a result.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Name and content digest of a design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DesignId {
    /// Name of the file without its extension.
    pub name: String,
    /// SHA-256 of every value on which the result depends.
    #[schemars(regex(pattern = "^[0-9a-f]{64}$"))]
    pub digest: String,
}
