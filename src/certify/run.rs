//! Neighbours that see one object.

/// Neighbours in a row that hit one object.
#[derive(Clone, Copy, Default)]
pub struct Run {
    pub id: u32,
    /// Where in the part they begin.
    pub at: usize,
    pub n: usize,
    /// [`crate::rays::Pixels::offset2`] of the first one, where they are pixels.
    pub offset: (i64, i64),
}

/// How many ids at the beginning are the same.
pub fn run_length(ids: &[u32]) -> usize {
    // So many are compared at a time.
    const BLOCK: usize = 16;
    let Some(&id) = ids.first() else { return 0 };
    let is_one = |ids: &&[u32]| ids.iter().fold(0, |other, &next| other | (next ^ id)) == 0;
    let n = BLOCK * ids.chunks_exact(BLOCK).take_while(is_one).count();
    n + ids[n..].iter().take_while(|&&next| next == id).count()
}
