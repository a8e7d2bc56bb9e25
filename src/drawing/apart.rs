//! Positions of labels that must not touch.

/// Ascending positions with a minimum distance: the mean of shifting all labels to the right and all to the left, both
/// of which keep the distance.
pub(super) fn apart(wanted: &[i32], distance: i32, [low, high]: [i32; 2]) -> Vec<i32> {
    let pushed = |places: &mut dyn Iterator<Item = i32>| -> Vec<i32> {
        let mut last = i32::MIN / 2;
        let push = |place: i32| {
            last = place.max(last + distance);
            last
        };
        places.map(push).collect()
    };
    let to_the_right = pushed(&mut wanted.iter().copied());
    let to_the_left = pushed(&mut wanted.iter().rev().map(|place| -place));
    let mean = |(right, left): (i32, &i32)| (right - left) / 2;
    let mut placed: Vec<i32> = to_the_right
        .into_iter()
        .zip(to_the_left.iter().rev())
        .map(mean)
        .collect();
    placed = pushed(&mut placed.into_iter().map(|place| place.max(low)));
    placed = pushed(&mut placed.into_iter().rev().map(|place| -place.min(high)));
    placed.into_iter().rev().map(|place| -place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const APART: i32 = 100;

    #[test]
    fn labels_keep_apart_on_the_line_and_stay_where_they_can() {
        let ends = [0, 20 * APART];
        assert_eq!(apart(&[APART, 5 * APART], APART, ends), [APART, 5 * APART]);
        assert_eq!(apart(&[5 * APART; 3], APART, ends), [4 * APART, 5 * APART, 6 * APART]);
        let placed = apart(&[0, 0, 0, ends[1], ends[1]], APART, ends);
        assert_eq!([placed[0], placed[4]], ends);
        assert!(placed.windows(2).all(|pair| pair[1] - pair[0] >= APART), "{placed:?}");
    }
}
