//! Results of dear stages, kept under the digest of all they depend on.
//!
//! The folder is `$NAILNOISE_CACHE`, else `$XDG_CACHE_HOME/nailnoise`, else `~/.cache/nailnoise`. Files are written
//! whole and carry the digest of their content, so that a killed or a second process, or a full disk, leaves nothing
//! that could be taken for a result.

use std::path::{Path, PathBuf};

use nailnoise_meshes::write_atomic;
use sha2::{Digest as _, Sha256};

/// First bytes of every file; the number changes when the content of the same key would be read differently.
const MAGIC: &[u8] = b"nailnoise cache 1\n";

/// Length of a digest \[bytes\].
const DIGEST: usize = 32;

/// What the cache has for a key.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Kept {
    /// The bytes that were stored.
    Found(Vec<u8>),
    /// Nothing yet.
    Absent,
    /// A file that is not what was stored under this key.
    Damaged(PathBuf),
}

/// Collects what a stage depends on.
#[derive(Debug, Clone)]
pub struct Key(Sha256);

impl Key {
    /// The key of a stage; results of another version of the program are never taken.
    pub fn new(stage: &str) -> Self {
        let mut key = Self(Sha256::new());
        key.text(stage);
        key.text(env!("CARGO_PKG_VERSION"));
        key
    }

    /// Adds a text.
    pub fn text(&mut self, text: &str) {
        self.0.update((text.len() as u64).to_le_bytes());
        self.0.update(text);
    }

    /// Adds numbers, bit by bit.
    pub fn numbers(&mut self, values: impl IntoIterator<Item = f64>) {
        let bytes: Vec<u8> = values.into_iter().flat_map(f64::to_le_bytes).collect();
        self.0.update((bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
    }

    fn digest(self) -> [u8; DIGEST] {
        self.0.finalize().into()
    }
}

/// A folder of kept results; none where the user has no home.
#[derive(Debug, Clone)]
pub struct Cache {
    folder: Option<PathBuf>,
}

impl Cache {
    /// The cache of the user who runs the program.
    pub fn of_user() -> Self {
        let set = |name: &str| {
            std::env::var_os(name)
                .filter(|value| !value.is_empty())
                .map(PathBuf::from)
        };
        let folder = set("NAILNOISE_CACHE")
            .or_else(|| set("XDG_CACHE_HOME").map(|base| base.join("nailnoise")))
            .or_else(|| set("HOME").map(|home| home.join(".cache").join("nailnoise")));
        Self { folder }
    }

    /// A cache in a folder of its own.
    pub fn at(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: Some(folder.into()),
        }
    }

    /// Looks a key up.
    pub fn get(&self, stage: &str, key: &Key) -> Kept {
        let digest = key.clone().digest();
        let Some(path) = self.path(stage, &digest) else {
            return Kept::Absent;
        };
        match std::fs::read(&path) {
            Ok(bytes) => match content(&bytes, &digest) {
                Some(content) => Kept::Found(content.to_vec()),
                None => Kept::Damaged(path),
            },
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Kept::Absent,
            Err(_) => Kept::Damaged(path),
        }
    }

    /// Keeps bytes under a key.
    ///
    /// # Errors
    /// Those of the file system; the result is then computed again next time.
    pub fn put(&self, stage: &str, key: &Key, content: &[u8]) -> std::io::Result<()> {
        let digest = key.clone().digest();
        let Some(path) = self.path(stage, &digest) else {
            return Ok(());
        };
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let mut bytes = Vec::with_capacity(MAGIC.len() + 2 * DIGEST + content.len());
        bytes.extend(MAGIC);
        bytes.extend(digest);
        bytes.extend(Sha256::digest(content).as_slice());
        bytes.extend(content);
        write_atomic(&path, &bytes)
    }

    fn path(&self, stage: &str, digest: &[u8; DIGEST]) -> Option<PathBuf> {
        let name: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        let folder: &Path = self.folder.as_deref()?;
        Some(folder.join(stage).join(name))
    }
}

/// What follows the head of a file, if head and content are right.
fn content<'a>(bytes: &'a [u8], key: &[u8; DIGEST]) -> Option<&'a [u8]> {
    let rest = bytes.strip_prefix(MAGIC)?.strip_prefix(key.as_slice())?;
    let (digest, content) = rest.split_at_checked(DIGEST)?;
    (Sha256::digest(content).as_slice() == digest).then_some(content)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_kept_is_found_and_what_was_changed_is_not() {
        let folder = std::env::temp_dir().join(format!("nailnoise-cache-{}", std::process::id()));
        let cache = Cache::at(&folder);
        let mut key = Key::new("stage");
        key.numbers([1.0, -0.0]);
        let mut other = Key::new("stage");
        other.numbers([1.0, 0.0]);
        assert_eq!(cache.get("stage", &key), Kept::Absent);
        cache.put("stage", &key, b"content").unwrap();
        assert_eq!(cache.get("stage", &key), Kept::Found(b"content".to_vec()));
        assert_eq!(cache.get("stage", &other), Kept::Absent);
        let path = std::fs::read_dir(folder.join("stage"))
            .unwrap()
            .next()
            .unwrap()
            .unwrap()
            .path();
        let bytes = std::fs::read(&path).unwrap();
        // Another file under this name, a bit turned, the end missing.
        for broken in [
            b"foreign".to_vec(),
            [&bytes[..bytes.len() - 1], b"x"].concat(),
            bytes[..40].to_vec(),
        ] {
            std::fs::write(&path, broken).unwrap();
            assert_eq!(cache.get("stage", &key), Kept::Damaged(path.clone()));
        }
        cache.put("stage", &key, b"content").unwrap();
        assert_eq!(cache.get("stage", &key), Kept::Found(b"content".to_vec()));
        std::fs::remove_dir_all(folder).unwrap();
    }
}
