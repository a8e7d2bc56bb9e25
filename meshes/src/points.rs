//! Serialises points as triples of numbers.

use nalgebra::Point3;
use serde::{Deserialize as _, Deserializer, Serializer};

pub(crate) fn serialize<S: Serializer>(points: &[Point3<f64>], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(points.iter().map(|p| [p.x, p.y, p.z]))
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Point3<f64>>, D::Error> {
    let triples = Vec::<[f64; 3]>::deserialize(deserializer)?;
    Ok(triples.into_iter().map(Point3::from).collect())
}
