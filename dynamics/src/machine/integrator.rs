//! Integration of a smooth problem to an event.
//!
//! Dormand and Prince (1980, J. Comp. Appl. Math. 6), order 5 with an error of order 4. The event is met by a separate
//! step, found by the secant method within a bracket. The state there thus has the accuracy of a step rather than of an
//! interpolation: the energy balance of a drive closes to 1e-9. The problems are not stiff.

const C: [f64; 7] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
const A: [[f64; 6]; 7] = [
    [0.0; 6],
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
        0.0,
    ],
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];
const E: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// Shortest step \[s\].
const SHORTEST: f64 = 1e-15;

/// A state with its time.
pub(super) type At<const N: usize> = (f64, [f64; N]);

/// One step of length `h`, and its error.
fn step<const N: usize>(rates: &impl Fn(&[f64; N]) -> [f64; N], y: &[f64; N], h: f64) -> ([f64; N], [f64; N]) {
    let mut k = [[0.0; N]; 7];
    let mut end = *y;
    for stage in 0..7 {
        debug_assert!(C[stage] <= 1.0);
        end = std::array::from_fn(|i| y[i] + h * (0..stage).map(|j| A[stage][j] * k[j][i]).sum::<f64>());
        k[stage] = rates(&end);
    }
    // The last stage is at the end of the step.
    let error = std::array::from_fn(|i| h * (0..7).map(|j| E[j] * k[j][i]).sum::<f64>());
    (end, error)
}

/// Steps from `start` until `event` falls to zero or the time is `end`; `accepted` sees every step. Returns the last
/// state and whether it is the event; none where the step became too short.
pub(super) fn integrate<const N: usize>(
    rates: impl Fn(&[f64; N]) -> [f64; N],
    event: impl Fn(&[f64; N]) -> f64,
    start: At<N>,
    end: f64,
    (relative, scale): (f64, [f64; N]),
    mut accepted: impl FnMut(At<N>),
) -> Option<(At<N>, bool)> {
    let (mut t, mut y) = start;
    let mut h = 1e-7_f64.min(end - t);
    while end - t > SHORTEST {
        h = h.min(end - t);
        let (next, error) = step(&rates, &y, h);
        let norm = (0..N).map(|i| (error[i] / (relative * scale[i])).powi(2)).sum::<f64>() / N as f64;
        let norm = norm.sqrt();
        let factor = (0.9 * norm.max(1e-10).powf(-0.2)).clamp(0.2, 4.0);
        if norm.is_nan() || norm > 1.0 {
            h *= if norm.is_nan() { 0.2 } else { factor };
            if h < SHORTEST {
                return None;
            }
            continue;
        }
        if event(&next) <= 0.0 && event(&y) > 0.0 {
            let (mut low, mut high) = ((0.0, event(&y)), (h, event(&next)));
            let mut found = (h, next);
            for round in 0..200 {
                // Illinois: the secant, with bisections now and then.
                let mut at = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1);
                if round % 3 == 2 || !(at > low.0 && at < high.0) {
                    at = 0.5 * (low.0 + high.0);
                }
                let (state, _) = step(&rates, &y, at);
                let value = event(&state);
                found = (at, state);
                if value > 0.0 {
                    low = (at, value)
                } else {
                    high = (at, value)
                }
                if value == 0.0 || high.0 - low.0 <= 1e-15 * (t + h).abs().max(1e-6) {
                    break;
                }
            }
            let last = (t + found.0, found.1);
            accepted(last);
            return Some((last, true));
        }
        t += h;
        y = next;
        accepted((t, y));
        h *= factor;
    }
    Some(((t, y), false))
}
