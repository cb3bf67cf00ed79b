//! Tables that are made once for all who ask for the same one, and dropped with the last of them.

use std::sync::{Arc, Mutex, OnceLock, Weak};

/// A table that the first who needs it makes.
pub(crate) type Table<T> = Arc<OnceLock<T>>;

/// Tables by what they are of.
#[derive(Debug)]
pub(crate) struct SharedTables<K, T>(Mutex<Vec<(K, Weak<OnceLock<T>>)>>);

impl<K: PartialEq, T> SharedTables<K, T> {
    /// None yet.
    pub(crate) const fn new() -> Self {
        Self(Mutex::new(vec![]))
    }

    /// The table of `key`: the same as long as anybody holds it. It is not made here, so that nobody waits for a table of another
    /// key.
    pub(crate) fn of(&self, key: K) -> Table<T> {
        // What another thread has left here while it panicked is whole: only the list itself is changed under the lock.
        let mut tables = self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        tables.retain(|(_, table)| table.strong_count() > 0);
        if let Some(table) = tables.iter().find(|(of, _)| *of == key).and_then(|(_, table)| table.upgrade()) {
            return table;
        }
        let table = Arc::new(OnceLock::new());
        tables.push((key, Arc::downgrade(&table)));
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_shared_by_key_and_dropped_with_their_last_holder() {
        let tables = SharedTables::<u32, String>::new();
        let (one, same, other) = (tables.of(1), tables.of(1), tables.of(2));
        assert_eq!(one.get_or_init(|| "one".into()), same.get_or_init(|| unreachable!()));
        assert!(other.get().is_none());
        drop((one, same));
        assert!(tables.of(1).get().is_none() && tables.0.lock().unwrap().len() == 2);
    }
}
