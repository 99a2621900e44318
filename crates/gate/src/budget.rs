//! How much memory a reader may take for the bytes of a file.
//!
//! budget = 64 x bytes of the file + 64 MiB. What a file claims is not believed beyond it: a reader draws before it
//! allocates. The second term is for honest files that are small.

/// A byte of a file may become so many in memory.
const TIMES: usize = 64;
/// Every file may take so many bytes more.
const ALLOWANCE_BYTES: usize = 64 << 20;

/// The bytes that a reader may still take.
#[derive(Clone, Debug)]
pub struct Budget {
    all: usize,
    left: usize,
}

impl Budget {
    /// The budget of a file of this many bytes.
    pub fn of(bytes: usize) -> Budget {
        let all = bytes.saturating_mul(TIMES).saturating_add(ALLOWANCE_BYTES);
        Budget { all, left: all }
    }

    /// More bytes of the file, or another file of the same log, were read.
    pub fn grow(&mut self, bytes: usize) {
        let more = bytes.saturating_mul(TIMES);
        (self.all, self.left) = (self.all.saturating_add(more), self.left.saturating_add(more));
    }

    /// Bytes that there were in all.
    pub fn whole(&self) -> usize {
        self.all
    }

    /// Bytes that are left.
    pub fn left(&self) -> usize {
        self.left
    }

    /// Takes some bytes away.
    ///
    /// Fails where fewer are left, with both figures.
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
