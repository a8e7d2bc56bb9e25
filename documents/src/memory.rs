//! Memory that a run may use.

use std::str::FromStr;

/// Fraction of the free memory that a run may use by default.
const SHARE: f64 = 0.75;

/// Limit on the memory of one stage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MemoryLimit {
    /// Limit \[GB\].
    pub gigabytes: f64,
    /// Whether the user set the limit, instead of the default for the machine.
    pub given: bool,
}

impl Default for MemoryLimit {
    /// Three quarters of the free memory; no limit if the system does not report it.
    fn default() -> Self {
        Self {
            gigabytes: available().map_or(f64::INFINITY, |free| SHARE * free),
            given: false,
        }
    }
}

impl MemoryLimit {
    /// Whether a stage that needs `gigabytes` \[GB\] may run.
    pub fn allows(self, gigabytes: f64) -> bool {
        gigabytes <= self.gigabytes
    }
}

impl FromStr for MemoryLimit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
        let factor = match text[digits.len()..].to_ascii_lowercase().as_str() {
            "g" | "gb" => 1.0,
            "gib" => 1.073_741_824,
            "m" | "mb" => 1e-3,
            "mib" => 1.048_576e-3,
            "t" | "tb" => 1e3,
            "tib" => 1_099.511_627_776,
            "" => return Err(format!("`{text}` has no unit; give for example 8GB, 8GiB or 500MB")),
            unit => {
                return Err(format!(
                    "`{unit}` is no unit of memory; give for example 8GB, 8GiB or 500MB"
                ));
            }
        };
        match digits.trim().parse::<f64>() {
            Ok(number) if number > 0.0 && number.is_finite() => Ok(Self {
                gigabytes: number * factor,
                given: true,
            }),
            _ => Err(format!(
                "`{text}` is no amount of memory; give for example 8GB, 8GiB or 500MB"
            )),
        }
    }
}

/// Memory available to this process \[GB\]: that of the machine, or of its control group if that is less. None if the
/// system does not report it.
pub fn available() -> Option<f64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let machine = read("/proc/meminfo").and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
        let kilobytes: f64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
        Some(1.024e-6 * kilobytes)
    })?;
    let number = |path: &str| read(path).and_then(|text| text.trim().parse::<f64>().ok());
    let group = number("/sys/fs/cgroup/memory.max").zip(number("/sys/fs/cgroup/memory.current"));
    let free = group.map_or(machine, |(most, used)| machine.min(1e-9 * (most - used).max(0.0)));
    Some(address_space().map_or(free, |most| free.min(most)))
}

/// Limit of the address space of this process (`ulimit -v`) \[GB\]; none if it is unlimited or the system does not
/// report it.
pub fn address_space() -> Option<f64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    limit_of_address_space(&limits)
}

/// Parses the soft limit from `/proc/self/limits` \[GB\]; none for `unlimited`.
fn limit_of_address_space(limits: &str) -> Option<f64> {
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let bytes: f64 = line.split_whitespace().next()?.parse().ok()?;
    Some(1e-9 * bytes)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    /// Lines as proc(5) prints them.
    #[test]
    fn the_soft_limit_of_the_address_space_is_read() {
        let head = "Limit                     Soft Limit           Hard Limit           Units     \n";
        let of = |soft: &str| {
            limit_of_address_space(&format!(
                "{head}Max address space         {soft:<20} unlimited            bytes     \nMax file \
                 locks            1  1  locks\n"
            ))
        };
        assert_eq!(of("1073741824"), Some(1.073_741_824));
        assert_eq!((of("unlimited"), limit_of_address_space("")), (None, None));
    }

    #[test]
    fn a_limit_has_a_unit() {
        for (text, gigabytes) in [("8GB", 8.0), ("8 GiB", 8.589_934_592), ("500mb", 0.5), ("1.5T", 1500.0)] {
            assert!(
                (text.parse::<MemoryLimit>().unwrap().gigabytes - gigabytes).abs() < 1e-9,
                "{text}"
            );
        }
        for text in ["8", "", "GB", "-1GB", "infGB", "8 apples", "nan GB"] {
            assert!(text.parse::<MemoryLimit>().is_err(), "{text}");
        }
    }
}
