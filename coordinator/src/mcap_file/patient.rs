//! A writer that buffers while its disk is full: pending bytes stay in memory, in order, until they can be written.

use std::io::{self, ErrorKind, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Maximum number of pending bytes; beyond them the file has failed.
const MOST_BYTES: usize = 64 * 1024 * 1024;

/// A buffering writer.
pub(crate) struct Patient<W> {
    state: Arc<Mutex<State<W>>>,
}

/// Observes a file that another owner writes to.
pub(crate) struct Watch<W> {
    state: Arc<Mutex<State<W>>>,
}

struct State<W> {
    file: W,
    waiting: Vec<u8>,
    /// Number of pending bytes that have been written.
    written: usize,
    /// Why writing fails, if it does.
    failure: Option<io::Error>,
    max_bytes: usize,
    /// Too many bytes were pending: some are missing, and the following ones are useless.
    is_lost: bool,
}

impl<W: Write> Patient<W> {
    pub(crate) fn new(file: W) -> (Self, Watch<W>) {
        Self::with_room(file, MOST_BYTES)
    }

    fn with_room(file: W, max_bytes: usize) -> (Self, Watch<W>) {
        let (waiting, written, failure, is_lost) = (Vec::new(), 0, None, false);
        let state = Arc::new(Mutex::new(State { file, waiting, written, failure, max_bytes, is_lost }));
        (Self { state: Arc::clone(&state) }, Watch { state })
    }
}

impl<W: Write> Watch<W> {
    /// Writes the pending bytes, if possible; returns why not all could be written.
    pub(crate) fn settle(&self) -> Option<String> {
        lock(&self.state).write_out();
        self.failure()
    }
}

impl<W> Watch<W> {
    /// Why writing fails now, if it does.
    pub(crate) fn failure(&self) -> Option<String> {
        lock(&self.state).failure.as_ref().map(ToString::to_string)
    }
}

fn lock<W>(state: &Mutex<State<W>>) -> MutexGuard<'_, State<W>> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<W: Write> Write for Patient<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        lock(&self.state).take(bytes)
    }

    /// Tries again. A full disk is not an error here: see [`Watch::failure`].
    fn flush(&mut self) -> io::Result<()> {
        let mut state = lock(&self.state);
        if state.is_lost {
            return Err(state.error());
        }
        state.write_out();
        Ok(())
    }
}

impl<W: Write> State<W> {
    fn take(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.is_lost |= self.waiting.len() - self.written + bytes.len() > self.max_bytes;
        if self.is_lost {
            return Err(self.error());
        }
        self.waiting.extend_from_slice(bytes);
        // After a failure, writing is retried on flush only, not for each byte.
        if self.failure.is_none() {
            self.write_out();
        }
        Ok(bytes.len())
    }

    fn write_out(&mut self) {
        self.failure = None;
        while self.written < self.waiting.len() {
            match self.file.write(&self.waiting[self.written..]) {
                Ok(0) => self.failure = Some(ErrorKind::WriteZero.into()),
                Ok(count) => self.written += count,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => self.failure = Some(error),
            }
            if self.failure.is_some() {
                break;
            }
        }
        self.waiting.drain(..self.written);
        self.written = 0;
        if self.failure.is_none()
            && let Err(error) = self.file.flush()
        {
            self.failure = Some(error);
        }
    }

    fn error(&self) -> io::Error {
        match &self.failure {
            Some(failure) => io::Error::new(failure.kind(), failure.to_string()),
            None => ErrorKind::StorageFull.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disk with limited space.
    struct Disk {
        bytes: Vec<u8>,
        room: usize,
    }

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let room = self.room - self.bytes.len();
            if room == 0 {
                return Err(ErrorKind::StorageFull.into());
            }
            let taken = &bytes[..bytes.len().min(room)];
            self.bytes.extend_from_slice(taken);
            Ok(taken.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn patient(room: usize, max_bytes: usize) -> (Patient<Disk>, Watch<Disk>) {
        Patient::with_room(Disk { bytes: Vec::new(), room }, max_bytes)
    }

    #[test]
    fn pending_data_are_written_in_order_without_loss() {
        let (mut file, watch) = patient(10, 100);
        for chunk in ["0123456", "789abcd", "efgh"] {
            file.write_all(chunk.as_bytes()).unwrap();
            file.flush().unwrap();
        }
        assert_eq!(lock(&file.state).file.bytes, b"0123456789");
        assert!(watch.failure().is_some());
        lock(&file.state).file.room = 15;
        file.flush().unwrap();
        assert!(watch.failure().is_some(), "there is not room for all");
        lock(&file.state).file.room = 100;
        file.write_all(b"ij").unwrap();
        file.flush().unwrap();
        assert_eq!(watch.failure(), None);
        assert_eq!(lock(&file.state).file.bytes, b"0123456789abcdefghij");
    }

    #[test]
    fn when_too_much_waits_the_file_has_failed_for_good() {
        let (mut file, _) = patient(10, 20);
        file.write_all(&[1; 30]).unwrap_err();
        file.write_all(&[1; 5]).unwrap_err();
        lock(&file.state).file.room = 100;
        file.flush().unwrap_err();
        assert!(lock(&file.state).file.bytes.is_empty());
    }
}
