//! Finite-element modal models of the bodies and their transient response.
