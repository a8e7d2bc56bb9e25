//! Points that no other betters.

/// Places of the points that no other betters in all objectives, by the first objective; of equal ones the first.
/// All objectives are minimised.
pub fn front(objectives: &[Vec<f64>]) -> Vec<usize> {
    let betters = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a <= b);
    let mut found: Vec<usize> = (0..objectives.len())
        .filter(|&place| {
            let own = &objectives[place];
            !objectives.iter().enumerate().any(|(other, values)| {
                let earlier_or_better = other < place || values != own;
                other != place && betters(values, own) && earlier_or_better
            })
        })
        .collect();
    found.sort_by(|&a, &b| objectives[a][0].total_cmp(&objectives[b][0]));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_has_what_no_other_betters() {
        let points = [[1.0, 4.0], [2.0, 2.0], [3.0, 3.0], [4.0, 1.0], [2.0, 2.0], [0.5, 4.0]].map(|own| own.to_vec());
        assert_eq!(front(&points), [5, 1, 3]);
    }

    #[test]
    fn one_objective_has_one_best() {
        assert_eq!(front(&[3.0, 1.0, 2.0, 1.0].map(|own| vec![own])), [1]);
        assert!(front(&[]).is_empty());
    }
}
