//! Finite-element meshes: built-in mesher, skin, quality and VTK output.
