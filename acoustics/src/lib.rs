//! Levels, radiation of moving surfaces and exhaust noise.
