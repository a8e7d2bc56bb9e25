//! Results stored between runs: found again, never trusted when damaged, bounded in size.

use std::cell::Cell;
use std::fs;
use std::io::{self, Read, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime};

use nailnoise_pipeline::store::{Digest, LIMIT, Store};
use nailnoise_pipeline::{Codec, Entry, Postcard, Undecodable};

use crate::folder;

/// A stage that counts how often it is computed.
fn squares(cache: &Store, n: usize, computed: &Cell<usize>) -> Vec<f64> {
    let mut key = Digest::default();
    key[..8].copy_from_slice(&(n as u64).to_le_bytes());
    cache.load::<_, Postcard>("squares", &key).unwrap_or_else(|| {
        computed.set(computed.get() + 1);
        let value = (0..n).map(|i| (i * i) as f64).collect();
        cache.save::<_, Postcard>("squares", &key, &value);
        value
    })
}

#[test]
fn a_value_is_computed_once_and_read_back_bit_by_bit() {
    let (cache, computed) = (Store::at(folder("once"), LIMIT), Cell::new(0));
    let first = squares(&cache, 1000, &computed);
    assert_eq!(squares(&cache, 1000, &computed), first);
    assert_eq!(computed.get(), 1);
    squares(&cache, 1001, &computed);
    assert_eq!(computed.get(), 2, "other inputs are computed");
    assert_eq!(cache.entries().unwrap().len(), 2);
    assert_eq!(cache.entries().unwrap()[0].stage, "squares");
    assert!(cache.take_notes().is_empty());
    assert_eq!(cache.clear().unwrap(), (2, Vec::new()));
    squares(&cache, 1000, &computed);
    assert_eq!(computed.get(), 3);
}

#[test]
fn without_a_folder_everything_is_computed() {
    let (cache, computed) = (Store::none(), Cell::new(0));
    squares(&cache, 10, &computed);
    squares(&cache, 10, &computed);
    assert_eq!(computed.get(), 2);
}

/// Every way of damage at every place: cut short, one bit turned, of another format, under another name.
#[test]
fn damage_is_detected_reported_and_repaired() {
    let (cache, computed) = (Store::at(folder("damage"), LIMIT), Cell::new(0));
    let expected = squares(&cache, 20, &computed);
    let path = cache.entries().unwrap().remove(0).path;
    let sound = fs::read(&path).unwrap();
    let cut = (0..sound.len()).map(|length| sound[..length].to_vec());
    let turned = (0..sound.len()).map(|place| {
        let mut bytes = sound.clone();
        bytes[place] ^= 1 << (place % 8);
        bytes
    });
    let other = [b"not of this program".to_vec(), [&sound[..], b"more"].concat()];
    let mut cases = 0;
    for bytes in cut.chain(turned).chain(other) {
        fs::write(&path, &bytes).unwrap();
        assert_eq!(cache.verify().unwrap().len(), 1);
        assert_eq!(squares(&cache, 20, &computed), expected);
        cases += 1;
        assert_eq!(computed.get(), 1 + cases, "a damaged entry was believed");
        let notes = cache.take_notes();
        assert!(notes.len() == 1 && notes[0].contains("computed anew"), "{notes:?}");
        assert_eq!(fs::read(&path).unwrap(), sound, "the entry is repaired");
    }
    // A sound entry under the name of another.
    squares(&cache, 21, &computed);
    let latest = cache
        .entries()
        .unwrap()
        .into_iter()
        .find(|entry| entry.path != path)
        .unwrap();
    fs::copy(&latest.path, &path).unwrap();
    assert_eq!(squares(&cache, 20, &computed), expected);
    assert!(cache.verify().unwrap().is_empty());
}

/// Bytes, the first of which is all that a reader checks.
struct First(Vec<u8>);

impl Codec<Self> for First {
    fn write(value: &Self, to: &mut dyn Write) -> io::Result<()> {
        to.write_all(&value.0)
    }

    fn read(from: &mut dyn Read, length: usize) -> Result<Self, Undecodable> {
        let mut byte = [0];
        from.read_exact(&mut byte).map_err(Undecodable::new)?;
        if length == 200 {
            Ok(Self(byte.to_vec()))
        } else {
            Err(Undecodable::new("another length"))
        }
    }
}

const KEY: Digest = [7; 32];

/// The same for a value that is decoded while it is read, by a reader that checks only a part of it.
#[test]
fn damage_of_streamed_values_is_detected() {
    let (cache, computed) = (Store::at(folder("decoded"), LIMIT), Cell::new(0));
    let content: Vec<u8> = (0..200).collect();
    let first = |cache: &Store| {
        cache.load::<First, First>("bytes", &KEY).unwrap_or_else(|| {
            computed.set(computed.get() + 1);
            let value = First(content.clone());
            cache.save::<_, First>("bytes", &KEY, &value);
            value
        })
    };
    assert_eq!(first(&cache).0[0], 0);
    assert_eq!(first(&cache).0[0], 0);
    assert_eq!(computed.get(), 1);
    let path = cache.entries().unwrap().remove(0).path;
    let sound = fs::read(&path).unwrap();
    let mut cases = 0;
    for place in 0..sound.len() {
        let mut turned = sound.clone();
        turned[place] ^= 1 << (place % 8);
        for bytes in [&turned[..], &sound[..place]] {
            fs::write(&path, bytes).unwrap();
            assert_eq!(first(&cache).0[0], 0);
            cases += 1;
            assert_eq!(computed.get(), 1 + cases, "a damaged entry was believed");
            assert_eq!(cache.take_notes().len(), 1);
            assert_eq!(fs::read(&path).unwrap(), sound, "the entry is repaired");
        }
    }
}

#[test]
fn another_type_under_the_same_name_is_not_read() {
    let cache = Store::at(folder("type"), LIMIT);
    cache.save::<_, Postcard>("stage", &KEY, &"words, many words".to_owned());
    assert_eq!(cache.load::<Vec<f64>, Postcard>("stage", &KEY), None);
    assert_eq!(cache.take_notes().len(), 1);
}

#[test]
fn the_least_recently_used_go_when_the_folder_is_full() {
    let folder = folder("bound");
    let computed = Cell::new(0);
    // An entry of 100 numbers takes 867 bytes: three fit.
    let cache = Store::at(folder, 3000);
    for n in [100, 101, 102] {
        squares(&cache, n, &computed);
        // File times of the system may be coarse.
        for entry in cache.entries().unwrap() {
            let file = fs::File::options().append(true).open(entry.path).unwrap();
            file.set_modified(entry.used - Duration::from_secs(10)).unwrap();
        }
    }
    squares(&cache, 100, &computed);
    assert_eq!(computed.get(), 3);
    squares(&cache, 103, &computed);
    assert_eq!(cache.entries().unwrap().len(), 3);
    squares(&cache, 100, &computed);
    assert_eq!(computed.get(), 4, "what was used last has stayed");
    squares(&cache, 101, &computed);
    assert_eq!(computed.get(), 5, "what was used longest ago has gone");
    let now = SystemTime::now() + Duration::from_secs(1);
    assert!(cache.entries().unwrap().iter().all(|entry| entry.used <= now));
}

#[test]
fn a_folder_that_cannot_be_written_is_a_note() {
    let folder = folder("file");
    fs::create_dir_all(folder.parent().unwrap()).unwrap();
    fs::write(&folder, "a file where the folder should be").unwrap();
    let (cache, computed) = (Store::at(folder, LIMIT), Cell::new(0));
    assert_eq!(squares(&cache, 3, &computed), [0.0, 1.0, 4.0]);
    assert!(!cache.take_notes().is_empty());
}

/// Times in the future are those of a clock that was set back since.
#[test]
fn entries_from_the_future_give_way_to_new_ones() {
    let computed = Cell::new(0);
    let cache = Store::at(folder("future"), 3000);
    let day = Duration::from_secs(86_400);
    for n in [100, 101, 102] {
        squares(&cache, n, &computed);
    }
    for entry in cache.entries().unwrap() {
        let file = fs::File::options().append(true).open(entry.path).unwrap();
        file.set_modified(SystemTime::now() + day).unwrap();
    }
    squares(&cache, 103, &computed);
    squares(&cache, 103, &computed);
    assert_eq!(computed.get(), 4, "the new entry has stayed");
    let soon = SystemTime::now() + Duration::from_secs(1);
    assert!(cache.entries().unwrap().iter().all(|entry| entry.used <= soon));
}

/// A folder that vanishes again and again costs time, and no digits.
#[test]
fn a_folder_may_vanish_at_any_moment() {
    let folder = folder("vanishing");
    let (cache, computed) = (Store::at(folder.clone(), LIMIT), Cell::new(0));
    let ended = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !ended.load(Ordering::Relaxed) {
                let _ = fs::remove_dir_all(&folder);
            }
        });
        for n in 0..300 {
            let expected: Vec<f64> = (0..n % 7).map(|i| (i * i) as f64).collect();
            assert_eq!(squares(&cache, n % 7, &computed), expected);
        }
        ended.store(true, Ordering::Relaxed);
    });
    assert!(computed.get() > 0);
}

/// Machines of different architecture read each other's entries: all bytes of a value are fixed.
#[test]
fn a_value_has_the_same_bytes_on_every_machine() {
    let mut bytes = Vec::new();
    Postcard::write(&(300_u32, 1.5_f64, -2_i64, "ab".to_owned(), 70_000_usize), &mut bytes).unwrap();
    let expected = [0xAC, 2, 0, 0, 0, 0, 0, 0, 0xF8, 0x3F, 3, 2, b'a', b'b', 0xF0, 0xA2, 4];
    assert_eq!(bytes, expected);
    let mut numbers = Vec::new();
    f32::encode(&[1.0, -2.0], &mut numbers);
    assert_eq!(numbers, [0, 0, 0x80, 0x3F, 0, 0, 0, 0xC0]);
}

#[test]
fn threads_share_a_folder() {
    let folder = folder("threads");
    let values: Vec<Vec<f64>> = std::thread::scope(|scope| {
        let work = |_| {
            let folder = folder.clone();
            scope.spawn(move || {
                let (cache, computed) = (Store::at(folder, 20_000), Cell::new(0));
                (0..40).for_each(|n| drop(squares(&cache, 100 + n % 10, &computed)));
                assert!(cache.take_notes().is_empty());
                squares(&cache, 100, &computed)
            })
        };
        let threads: Vec<_> = (0..4).map(work).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert!(values.iter().all(|value| *value == values[0]));
}
