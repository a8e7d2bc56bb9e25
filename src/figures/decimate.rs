//! Fewer points that draw the same line.

/// Width of a column in grid units; two columns make the width of a curve.
const COLUMN: i32 = 4;

/// The points of a line that are needed to draw it: of each column its first, lowest, highest and last one (M4; Jugel,
/// Jerzak, Hackenbroich and Markl, "M4: a visualization-oriented time series data aggregation", 2014), without those in
/// the middle of a straight stretch. Abscissas must not fall.
pub(super) fn decimate(points: impl IntoIterator<Item = [i32; 2]>) -> Vec<[i32; 2]> {
    let mut kept = Vec::new();
    let mut column: Option<Column> = None;
    for point in points {
        match &mut column {
            Some(column) if point[0].div_euclid(COLUMN) == column.index => column.push(point),
            _ => {
                if let Some(full) = column.replace(Column::new(point)) {
                    full.flush(&mut kept);
                }
            }
        }
    }
    if let Some(full) = column {
        full.flush(&mut kept);
    }
    kept
}

/// The points of one column that matter, with their places in it.
struct Column {
    index: i32,
    count: usize,
    first: [i32; 2],
    lowest: (usize, [i32; 2]),
    highest: (usize, [i32; 2]),
    last: [i32; 2],
}

impl Column {
    fn new(point: [i32; 2]) -> Self {
        let index = point[0].div_euclid(COLUMN);
        Self {
            index,
            count: 0,
            first: point,
            lowest: (0, point),
            highest: (0, point),
            last: point,
        }
    }

    fn push(&mut self, point: [i32; 2]) {
        self.count += 1;
        if point[1] < self.lowest.1[1] {
            self.lowest = (self.count, point);
        }
        if point[1] > self.highest.1[1] {
            self.highest = (self.count, point);
        }
        self.last = point;
    }

    fn flush(self, kept: &mut Vec<[i32; 2]>) {
        let [early, late] = if self.lowest.0 <= self.highest.0 {
            [self.lowest, self.highest]
        } else {
            [self.highest, self.lowest]
        };
        for point in [self.first, early.1, late.1, self.last] {
            extend(kept, point);
        }
    }
}

/// Appends a point; the last one goes where it lies between its neighbours on a straight line.
fn extend(kept: &mut Vec<[i32; 2]>, point: [i32; 2]) {
    if kept.last() == Some(&point) {
        return;
    }
    if let [.., a, b] = kept[..] {
        let [u, v] =
            [[b[0] - a[0], b[1] - a[1]], [point[0] - b[0], point[1] - b[1]]].map(|[x, y]| [x, y].map(i64::from));
        let straight = u[0] * v[1] == u[1] * v[0];
        if straight && u[0] * v[0] + u[1] * v[1] > 0 {
            kept.pop();
        }
    }
    kept.push(point);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_is_two_points() {
        assert_eq!(decimate((0..1000).map(|x| [x, 7])), [[0, 7], [999, 7]]);
    }

    #[test]
    fn a_spike_of_one_sample_keeps_its_height() {
        let kept = decimate((0..10_000).map(|i| [i / 10, if i == 5432 { -900 } else { i % 3 }]));
        assert!(kept.iter().any(|point| point[1] == -900));
        assert!(kept.len() < 1100, "{}", kept.len());
    }

    #[test]
    fn extremes_of_every_column_stay() {
        let wave = |i: i32| [i / 8, (1000.0 * (f64::from(i) * 0.37).sin()) as i32];
        let kept = decimate((0..40_000).map(wave));
        for column in 0..(40_000 / 8 / COLUMN) {
            let own = |points: &[[i32; 2]]| {
                let ys = points
                    .iter()
                    .filter(|p| p[0].div_euclid(COLUMN) == column)
                    .map(|p| p[1]);
                ys.fold((i32::MAX, i32::MIN), |(low, high), y| (low.min(y), high.max(y)))
            };
            let all: Vec<_> = (0..40_000).map(wave).collect();
            assert_eq!(
                own(&kept),
                own(&all[(column * 32) as usize..((column + 1) * 32) as usize])
            );
        }
    }
}
