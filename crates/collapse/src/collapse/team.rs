//! Threads: independent pieces of work on the threads of the caller's rayon pool, which stay between phases.
//!
//! Pieces depend on the size of the mesh alone, never on the number of threads, so results do not either.

#[cfg(feature = "threads")]
use std::sync::{Mutex, PoisonError};

use crate::collapse::options::Heartbeat;

/// Vertices per piece.
pub(crate) const STRETCH: usize = 1 << 15;

/// The number of threads that work on pieces, and the caller's heartbeat.
#[derive(Clone, Copy)]
pub(crate) struct Team<'a> {
    pub n_threads: usize,
    pub heartbeat: Heartbeat<'a>,
}

impl<'a> Team<'a> {
    /// Returns a team of `n_threads`; 0 is all of the current pool.
    #[cfg(feature = "threads")]
    pub(crate) fn new(n_threads: usize, heartbeat: Heartbeat<'a>) -> Team<'a> {
        Team { n_threads: if n_threads == 0 { rayon::current_num_threads() } else { n_threads }, heartbeat }
    }

    /// Returns a team of one.
    #[cfg(not(feature = "threads"))]
    pub(crate) fn new(_: usize, heartbeat: Heartbeat<'a>) -> Team<'a> {
        Team { n_threads: 1, heartbeat }
    }

    /// Returns a team of one without a heartbeat.
    #[cfg(test)]
    pub(crate) fn alone() -> Team<'static> {
        Team { n_threads: 1, heartbeat: Heartbeat::NONE }
    }

    /// Calls `work` once for each piece, on several threads if there are several pieces.
    pub(crate) fn run<T: Send>(self, pieces: Vec<T>, work: impl Fn(T) + Sync) {
        #[cfg(feature = "threads")]
        if self.n_threads.min(pieces.len()) > 1 {
            return self.share(pieces, work);
        }
        for piece in pieces {
            self.heartbeat.beat(0);
            work(piece);
        }
    }

    #[cfg(feature = "threads")]
    fn share<T: Send>(self, pieces: Vec<T>, work: impl Fn(T) + Sync) {
        let n_threads = self.n_threads.min(pieces.len());
        let waiting = Mutex::new(pieces.into_iter());
        let take_pieces = || {
            loop {
                let next = waiting.lock().unwrap_or_else(PoisonError::into_inner).next();
                let Some(piece) = next else { break };
                self.heartbeat.beat(0);
                work(piece);
            }
        };
        rayon::scope(|scope| {
            for _ in 1..n_threads {
                scope.spawn(|_| take_pieces());
            }
            take_pieces();
        });
    }
}

/// Cuts a slice into pieces of the given lengths, one after the other.
pub(crate) fn split<T>(mut rest: &mut [T], lengths: impl Iterator<Item = usize>) -> Vec<&mut [T]> {
    let mut pieces = Vec::new();
    for length in lengths {
        let (piece, behind) = rest.split_at_mut(length);
        pieces.push(piece);
        rest = behind;
    }
    pieces
}
