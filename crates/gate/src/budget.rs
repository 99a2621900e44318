//! The memory that a reader may allocate for a file.
//!
//! budget = 64 x bytes of the file + 64 MiB. A reader subtracts from the budget before it allocates. So a wrong length in a file
//! cannot exhaust the memory. The constant 64 MiB allows small valid files that need much memory.

/// Bytes of memory allowed per byte of a file.
const MEMORY_BYTES_PER_FILE_BYTE: usize = 64;
/// Constant term of the budget, bytes: allowed for a file of any length.
const ALLOWANCE_BYTES: usize = 64 << 20;

/// The memory that a reader may allocate: the whole budget and what remains of it, bytes.
#[derive(Clone, Debug)]
pub struct Budget {
    all: usize,
    left: usize,
}

impl Budget {
    /// The budget for a file of `bytes` bytes.
    pub fn of(bytes: usize) -> Budget {
        let all = bytes.saturating_mul(MEMORY_BYTES_PER_FILE_BYTE).saturating_add(ALLOWANCE_BYTES);
        Budget { all, left: all }
    }

    /// Increases the budget by the amount for `bytes` further bytes that were read, of this file or of another file of the log.
    pub fn grow(&mut self, bytes: usize) {
        let more = bytes.saturating_mul(MEMORY_BYTES_PER_FILE_BYTE);
        (self.all, self.left) = (self.all.saturating_add(more), self.left.saturating_add(more));
    }

    /// The whole budget with all increases, whether used or not, bytes.
    pub fn whole(&self) -> usize {
        self.all
    }

    /// The remaining budget, bytes.
    pub fn left(&self) -> usize {
        self.left
    }

    /// Subtracts `bytes` from the remaining budget, before they are allocated.
    ///
    /// Fails if fewer bytes remain; the message states the whole budget.
    pub fn draw(&mut self, bytes: usize) -> Result<(), String> {
        let all = self.all;
        self.left = self.left.checked_sub(bytes).ok_or_else(|| {
            format!("it unfolds to more than {all} bytes, which is 64 times the file and 64 MiB: no measurement does; cut it into parts or store it unpacked")
        })?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_drawn_is_gone() {
        let mut budget = Budget::of(2);
        assert_eq!(budget.left(), 128 + (64 << 20));
        assert!(budget.draw(64 << 20).is_ok() && budget.draw(128).is_ok());
        assert!(budget.draw(1).unwrap_err().contains("more than 67108992 bytes"));
        budget.grow(1);
        assert!(budget.draw(64).is_ok() && budget.draw(1).is_err());
        assert_eq!(Budget::of(usize::MAX).left(), usize::MAX);
    }
}
