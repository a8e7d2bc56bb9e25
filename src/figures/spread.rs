//! Labels on a line that would overlap are moved apart, each as little as the others allow.

/// Positions that keep `gap` between neighbours and stay within `ends`, with the least sum of squared moves from
/// `wanted`, which must not fall (pool adjacent violators on x_i - i gap; Ayer et al., 1955).
///
/// Where `ends` hold less than the labels need, the gap shrinks to what fits.
pub(super) fn spread(wanted: &[i32], gap: i32, ends: [i32; 2]) -> Vec<i32> {
    let n = wanted.len();
    if n == 0 {
        return Vec::new();
    }
    let room = f64::from(ends[1] - ends[0]) / (n.max(2) - 1) as f64;
    let gap = f64::from(gap).min(room);
    // Blocks of labels that touch: sum and number of x_i - i gap.
    let mut blocks: Vec<(f64, usize)> = Vec::new();
    for (i, &x) in wanted.iter().enumerate() {
        blocks.push((f64::from(x) - i as f64 * gap, 1));
        while let [.., (a, na), (b, nb)] = blocks[..]
            && a / na as f64 > b / nb as f64
        {
            blocks.truncate(blocks.len() - 2);
            blocks.push((a + b, na + nb));
        }
    }
    let (low, high) = (f64::from(ends[0]), f64::from(ends[1]) - (n - 1) as f64 * gap);
    let level = blocks
        .iter()
        .flat_map(|&(sum, count)| std::iter::repeat_n(sum / count as f64, count));
    level
        .enumerate()
        .map(|(i, q)| (q.clamp(low, high.max(low)) + i as f64 * gap).round() as i32)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_with_room_stay() {
        assert_eq!(spread(&[10, 50, 90], 20, [0, 100]), [10, 50, 90]);
    }

    #[test]
    fn neighbours_move_apart_by_the_same_amount() {
        assert_eq!(spread(&[50, 50], 20, [0, 100]), [40, 60]);
        assert_eq!(spread(&[10, 50, 52, 54, 90], 10, [0, 100]), [10, 42, 52, 62, 90]);
    }

    #[test]
    fn nothing_leaves_the_line_and_nothing_overlaps() {
        let placed = spread(&[0, 0, 0, 95, 99, 100], 15, [0, 100]);
        assert_eq!((placed[0], placed[5]), (0, 100));
        assert!(placed.windows(2).all(|pair| pair[1] - pair[0] >= 14), "{placed:?}");
        let tight = spread(&[50; 11], 15, [0, 100]);
        assert_eq!(tight, (0..11).map(|i| 10 * i).collect::<Vec<_>>());
    }
}
