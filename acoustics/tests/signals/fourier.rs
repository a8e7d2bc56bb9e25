//! Fourier transform of records.

use nailnoise_acoustics::InputError;
use nailnoise_acoustics::signals::fourier::{FourierError, Transform, TransformSettings};
use std::f64::consts::PI;

fn settings(low: f64, high: f64, taper: f64) -> TransformSettings {
    TransformSettings {
        range_hz: [low, high],
        taper,
        padding: 2.0,
    }
}

#[test]
fn a_gaussian_transforms_into_a_gaussian() {
    let (dt, n, t0, s) = (1e-5, 4000, 0.02, 5e-4);
    let record: Vec<f64> = (0..n)
        .map(|i| (-0.5 * ((f64::from(i) * dt - t0) / s).powi(2)).exp())
        .collect();
    let transform = Transform::new(record.len(), dt, &settings(20.0, 1500.0, 0.0)).unwrap();
    for (f, x) in transform.frequencies().iter().zip(transform.apply(&record).unwrap()) {
        let magnitude = s * (2.0 * PI).sqrt() * (-0.5 * (2.0 * PI * f * s).powi(2)).exp();
        let (sine, cosine) = (2.0 * PI * f * t0).sin_cos();
        assert!(
            (x.re - magnitude * cosine).abs() < 1e-14 && (x.im + magnitude * sine).abs() < 1e-14,
            "{f} Hz"
        );
    }
}

#[test]
fn parseval_holds() {
    let (dt, n) = (2e-5, 3000);
    let noise = |i: u32| (f64::from(i.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24)) - 0.5;
    // A band-limited record: its mean and slow part carry next to nothing below the first bin.
    let record: Vec<f64> = (0..n)
        .map(|i| noise(i) * (2.0 * PI * 5000.0 * f64::from(i) * dt).sin())
        .collect();
    let transform = Transform::new(record.len(), dt, &settings(1e-3, 0.5 / dt, 0.0)).unwrap();
    let (df, bins) = (transform.resolution(), transform.apply(&record).unwrap());
    // The bin of half the sampling frequency occurs once in the two-sided sum, and bin 0 is not stored.
    let mean = record.iter().sum::<f64>() * dt;
    let last = bins.last().unwrap().norm_sqr();
    let spectrum = df * (2.0 * bins.iter().map(|x| x.norm_sqr()).sum::<f64>() - last + mean * mean);
    let time = dt * record.iter().map(|x| x * x).sum::<f64>();
    assert!((spectrum / time - 1.0).abs() < 1e-12, "{spectrum} {time}");
}

#[test]
fn the_taper_ends_the_record_at_rest() {
    let (dt, n) = (1e-5, 2000);
    let transform = |taper| Transform::new(n, dt, &settings(20.0, 40_000.0, taper)).unwrap();
    let record = vec![1.0; n];
    // A constant that breaks off spreads as 1/f; tapered it falls much faster.
    let high = |t: &Transform| t.apply(&record).unwrap().last().unwrap().norm();
    let start = 1.0 / (2.0 * PI * 40_000.0);
    assert!(
        high(&transform(2e-3)) < 1.6 * start,
        "only the start of the record is left"
    );
    let energy = |t: &Transform| {
        t.apply(&record)
            .unwrap()
            .iter()
            .rev()
            .take(500)
            .map(|x| x.norm_sqr())
            .sum::<f64>()
    };
    let ratio = energy(&transform(0.0)) / energy(&transform(2e-3));
    assert!((ratio - 2.0).abs() < 0.1, "two equal edges become one: {ratio}");
}

#[test]
fn impossible_transforms_are_refused_by_name() {
    let make = |n, dt, low, high| Transform::new(n, dt, &settings(low, high, 0.0)).unwrap_err();
    assert!(matches!(
        make(4, 1e-5, 20.0, 1000.0),
        FourierError::ShortRecord { found: 4, .. }
    ));
    assert!(
        matches!(make(100, 1e-5, 20.0, 60_000.0), FourierError::Range { nyquist, .. } if (nyquist - 5e4).abs() < 1e-6)
    );
    assert!(matches!(
        make(100, 0.0, 20.0, 1000.0),
        FourierError::Input(InputError::NotPositive { .. })
    ));
    let transform = Transform::new(100, 1e-5, &settings(20.0, 1000.0, 0.0)).unwrap();
    assert!(matches!(
        transform.apply(&[0.0; 99]),
        Err(FourierError::Input(InputError::Length { found: 99, .. }))
    ));
    let mut record = vec![0.0; 100];
    record[7] = f64::INFINITY;
    assert!(matches!(
        transform.apply(&record),
        Err(FourierError::Input(InputError::NotFinite { index: 7, .. }))
    ));
}
