//! Reduces a surface to fewer and larger triangles by collapsing short edges and flipping edges between neighbours.

use super::lines::{Kind, Lines, Triangle, key};
use nalgebra::Vector3;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

/// Cosine of the largest angle between a triangle and the surface's normals at its corners: 40 degrees.
const TILT: f64 = 0.766;

/// Smallest quality of new triangles (1 for equilateral ones), unless they are at least as good as those they replace.
const QUALITY: f64 = 0.4;

/// Smallest ratio of the length of a straight edge to that of the line it replaces: 70 degrees of a circle.
const STRAIGHT: f64 = 0.94;

/// Number of rounds of collapses and flips.
const ROUNDS: usize = 4;

/// A surface that is being reduced.
pub(super) struct Collapse<'a> {
    pub(super) points: &'a [Vector3<f64>],
    pub(super) triangles: Vec<Option<Triangle>>,
    pub(super) lines: Lines,
    kinds: Vec<Kind>,
    /// Triangles around each vertex.
    around: Vec<Vec<usize>>,
    longest: f64,
}

/// Result of a collapse.
struct Left {
    /// Triangles that change.
    changed: Vec<(usize, Triangle)>,
    /// Triangles that are removed.
    gone: Vec<usize>,
    /// The vertex of the line after the removed one, and the line from there to the remaining one.
    line: Option<(usize, Vec<Vector3<f64>>)>,
    /// Worst quality among the changed triangles.
    worst: f64,
}

impl<'a> Collapse<'a> {
    pub(super) fn new(
        points: &'a [Vector3<f64>],
        (triangles, lines, kinds): (Vec<Triangle>, Lines, Vec<Kind>),
        longest: f64,
    ) -> Self {
        let mut around = vec![Vec::new(); points.len()];
        for (t, triangle) in triangles.iter().enumerate() {
            triangle.corners.iter().for_each(|&c| around[c].push(t));
        }
        Self {
            points,
            triangles: triangles.into_iter().map(Some).collect(),
            lines,
            kinds,
            around,
            longest,
        }
    }

    /// Collapses and flips until no further change is allowed.
    pub(super) fn run(&mut self) {
        for _ in 0..ROUNDS {
            if self.collapse_all() + self.flip_all() == 0 {
                break;
            }
        }
    }

    /// Collapses edges in order of length, the shortest first; returns their number.
    fn collapse_all(&mut self) -> usize {
        let mut heap = BinaryHeap::new();
        // Lengths are positive, so their bit patterns are ordered like them.
        let entry = |this: &Self, a: usize, b: usize| {
            let (a, b) = key(a, b);
            Reverse(((this.points[a] - this.points[b]).norm().to_bits(), a, b))
        };
        for a in 0..self.points.len() {
            for b in self.neighbours(a).into_iter().filter(|&b| b > a) {
                heap.push(entry(self, a, b));
            }
        }
        let mut count = 0;
        while let Some(Reverse((_, a, b))) = heap.pop() {
            if !self.neighbours(a).contains(&b) {
                continue;
            }
            let ways = [(a, b), (b, a)].map(|(u, v)| self.without(u, v).map(|left| (u, v, left)));
            let best = ways
                .into_iter()
                .flatten()
                .max_by(|x, y| x.2.worst.total_cmp(&y.2.worst));
            if let Some((u, v, left)) = best {
                self.apply(u, v, left);
                count += 1;
                for other in self.neighbours(v) {
                    for beyond in self.neighbours(other) {
                        heap.push(entry(self, other, beyond));
                    }
                }
            }
        }
        count
    }

    fn neighbours(&self, vertex: usize) -> BTreeSet<usize> {
        let triangles = self.around[vertex].iter().filter_map(|&t| self.triangles[t]);
        let mut all: BTreeSet<usize> = triangles.flat_map(|t| t.corners).collect();
        all.remove(&vertex);
        all
    }

    /// The surface with vertex `u` moved to its neighbour `v`, if allowed. The surface must stay closed: the common
    /// neighbours of the two ends are those of their common triangles (Dey et al. 1999). Lines must be preserved. No
    /// triangle may turn away from the surface or become too large or too slender.
    fn without(&self, u: usize, v: usize) -> Option<Left> {
        let on_line = self.lines.contains_key(&key(u, v));
        match self.kinds[u] {
            Kind::Smooth => {}
            Kind::Line if on_line => {}
            _ => return None,
        }
        let (gone, stay): (Vec<usize>, Vec<usize>) =
            self.around[u].iter().partition(|&&t| self.corners(t).contains(&v));
        let common = self.neighbours(u).intersection(&self.neighbours(v)).count();
        if common != gone.len() || stay.is_empty() || (self.kinds[u] == Kind::Smooth && gone.len() != 2) {
            return None;
        }
        let line = match self.kinds[u] {
            Kind::Line => Some(self.joined_line(u, v)?),
            _ => None,
        };
        let mut changed = Vec::new();
        let (mut worst, mut before) = (f64::INFINITY, f64::INFINITY);
        for &t in stay.iter().chain(&gone) {
            before = before.min(self.quality(&self.corners(t)));
        }
        for &t in &stay {
            let old = self.triangles[t]?;
            let k = old.corners.iter().position(|&c| c == u)?;
            // The removed triangle on the same side of the lines gives the normal at `v`.
            let side = gone.iter().filter_map(|&g| self.triangles[g]);
            let likeness = |g: &Triangle| normal_at(g, u).map_or(f64::NEG_INFINITY, |n| n.dot(&old.normals[k]));
            let beside = side.max_by(|x, y| likeness(x).total_cmp(&likeness(y)))?;
            let mut new = old;
            new.corners[k] = v;
            new.normals[k] = normal_at(&beside, v)?;
            if !self.allowed(&new) {
                return None;
            }
            worst = worst.min(self.quality(&new.corners));
            changed.push((t, new));
        }
        (worst >= QUALITY || worst >= before).then_some(Left {
            changed,
            gone,
            line,
            worst,
        })
    }

    /// The line through `u` after removing it, if it is straight enough and no other line connects the same vertices.
    fn joined_line(&self, u: usize, v: usize) -> Option<(usize, Vec<Vector3<f64>>)> {
        let mut others = self.neighbours(u).into_iter();
        let beyond = others.find(|&w| w != v && self.lines.contains_key(&key(u, w)))?;
        if self.lines.contains_key(&key(beyond, v)) {
            return None;
        }
        let mut line = self.line(beyond, u)?;
        line.extend(self.line(u, v)?.into_iter().skip(1));
        let length: f64 = line.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
        let chord = (self.points[beyond] - self.points[v]).norm();
        (chord >= STRAIGHT * length && chord <= self.longest).then_some((beyond, line))
    }

    /// Points along a line's edge.
    pub(super) fn line(&self, from: usize, to: usize) -> Option<Vec<Vector3<f64>>> {
        let mut line = self.lines.get(&key(from, to))?.clone();
        if from > to {
            line.reverse();
        }
        Some(line)
    }

    fn apply(&mut self, u: usize, v: usize, left: Left) {
        if let Some((beyond, mut line)) = left.line {
            self.lines.remove(&key(u, v));
            self.lines.remove(&key(u, beyond));
            if beyond > v {
                line.reverse();
            }
            self.lines.insert(key(beyond, v), line);
        }
        for t in left.gone {
            for corner in self.corners(t) {
                self.around[corner].retain(|&other| other != t);
            }
            self.triangles[t] = None;
        }
        for (t, new) in left.changed {
            self.triangles[t] = Some(new);
            self.around[v].push(t);
        }
        self.around[u].clear();
    }

    /// Flips the common edge of two neighbouring triangles if that improves the worse of them; returns the number of
    /// flips.
    fn flip_all(&mut self) -> usize {
        let mut edges: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
        for t in 0..self.triangles.len() {
            let Some(triangle) = self.triangles[t] else { continue };
            let c = triangle.corners;
            (0..3).for_each(|k| edges.entry(key(c[k], c[(k + 1) % 3])).or_default().push(t));
        }
        let pairs = edges
            .into_iter()
            .filter(|(edge, _)| !self.lines.contains_key(edge))
            .collect::<Vec<_>>();
        pairs
            .into_iter()
            .filter(|((a, b), _)| self.flip(*a, *b).is_some())
            .count()
    }

    fn flip(&mut self, a: usize, b: usize) -> Option<()> {
        let users: Vec<usize> = self.around[a]
            .iter()
            .copied()
            .filter(|&t| self.corners(t).contains(&b))
            .collect();
        let [t, q] = users[..] else { return None };
        let (one, two) = (self.triangles[t]?, self.triangles[q]?);
        let third = |of: &Triangle| of.corners.into_iter().find(|&c| c != a && c != b);
        let (c, d) = (third(&one)?, third(&two)?);
        if c == d || self.neighbours(c).contains(&d) || (self.points[c] - self.points[d]).norm() > self.longest {
            return None;
        }
        // Each triangle retains one end of the old edge and replaces the other end with the third corner of its
        // neighbour.
        let swapped = |of: &Triangle, end: usize, from: &Triangle, to: usize| {
            let mut new = *of;
            let k = new.corners.iter().position(|&corner| corner == end)?;
            new.corners[k] = to;
            new.normals[k] = normal_at(from, to)?;
            Some(new)
        };
        let (x, y) = (swapped(&one, a, &two, d)?, swapped(&two, b, &one, c)?);
        let before = self.quality(&one.corners).min(self.quality(&two.corners));
        let after = self.quality(&x.corners).min(self.quality(&y.corners));
        if after < 1.05 * before || !self.allowed(&x) || !self.allowed(&y) {
            return None;
        }
        self.triangles[t] = Some(x);
        self.triangles[q] = Some(y);
        self.around[a].retain(|&other| other != t);
        self.around[b].retain(|&other| other != q);
        self.around[d].push(t);
        self.around[c].push(q);
        Some(())
    }

    fn corners(&self, t: usize) -> [usize; 3] {
        self.triangles[t].map_or([usize::MAX; 3], |triangle| triangle.corners)
    }

    /// Whether a triangle follows the surface at its corners and has short enough sides.
    fn allowed(&self, triangle: &Triangle) -> bool {
        let [a, b, c] = triangle.corners.map(|corner| self.points[corner]);
        let normal = (b - a).cross(&(c - a)).normalize();
        let sides = [b - a, c - b, a - c];
        triangle.normals.iter().all(|n| n.dot(&normal) > TILT) && sides.iter().all(|side| side.norm() <= self.longest)
    }

    /// 4 sqrt(3) area / sum of the squared sides.
    fn quality(&self, corners: &[usize; 3]) -> f64 {
        let [a, b, c] = corners.map(|corner| self.points[corner]);
        let squares = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
        2.0 * 3f64.sqrt() * (b - a).cross(&(c - a)).norm() / squares
    }
}

fn normal_at(triangle: &Triangle, vertex: usize) -> Option<Vector3<f64>> {
    let k = triangle.corners.iter().position(|&c| c == vertex)?;
    Some(triangle.normals[k])
}
