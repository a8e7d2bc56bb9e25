#!/usr/bin/env bash
# Makes the meshes that ship from the ready designs; needs gmsh. Run it after changing meshes/geo/tool.geo or a dimension
# of the tool body in designs/n80cb.toml.
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo run --release -- mesh designs/n80cb.toml --body tool --remesh --write meshes/data/tool-n80cb.msh.gz
