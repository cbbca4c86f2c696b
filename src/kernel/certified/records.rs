//! The objects as the device sees them.

use bytemuck::{Pod, Zeroable};

/// A sphere as the device sees it, in f32 or f64.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C)]
pub struct SphereCertified<R = f32> {
    /// Centre relative to the reference point, high part.
    pub center: [R; 3],
    /// [`crate::guard::Guard::inner2`]
    pub inner2: R,
    /// Centre relative to the reference point, low part.
    pub center_low: [R; 3],
    /// [`crate::guard::Guard::outer2`]
    pub outer2: R,
    /// [`crate::guard::Guard::slack`]
    pub slack: R,
    /// Pixels: lower bound of the magnitude of `q = 1/k`, with the sign of `k = l·l − r²`; 0 on
    /// the surface.
    pub q_low: R,
    /// Pixels: the same, upper bound. Lists, which have no `k` beforehand: `r²`.
    pub q_high_or_r2: R,
    /// Lists: [`crate::guard::Guard::k_error`].
    pub k_error: R,
}

/// A sphere in a leaf of a hierarchy: for rays that start at the reference point, far from it; for
/// parallel rays, anywhere.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct SphereFar {
    /// Centre relative to the reference point.
    pub center: [f32; 3],
    /// [`crate::guard::Guard::inner2`]
    pub inner2: f32,
    /// [`crate::guard::Guard::outer2`]
    pub outer2: f32,
    /// Upper bound of `1/k` with the slack in it; for parallel rays
    /// [`crate::guard::Guard::slack`].
    pub q_or_slack: f32,
    /// The object's id.
    pub id: u32,
    /// Fills two texels of 16 bytes.
    pub padding: u32,
}

/// A plane as the device sees it, in f32 or f64.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C)]
pub struct PlaneCertified<R = f32> {
    /// Point of the plane relative to the reference point, high part.
    pub offset: [R; 3],
    /// Pixels: lower bound of `q = 1/((a − o)·n)`, positive; 0 in the plane.
    pub q_low: R,
    /// Point of the plane relative to the reference point, low part.
    pub offset_low: [R; 3],
    /// Pixels: upper bound of `q`.
    pub q_high: R,
    /// Normal, scaled by a power of two to a largest component in `1..2`; for pixels it points
    /// away from the eye.
    pub normal: [R; 3],
    /// [`crate::guard::plane_direction_error`]
    pub direction_error: R,
    /// Lists: [`crate::guard::plane_offset_error`].
    pub n_offset_error: R,
    /// Fills WGSL's alignment of the struct, four numbers.
    pub padding: [R; 3],
}

// SAFETY: twelve numbers of one type one after the other, so that nothing is between them.
#[allow(unsafe_code)]
unsafe impl<R: Pod> Pod for SphereCertified<R> {}

// SAFETY: sixteen numbers of one type one after the other.
#[allow(unsafe_code)]
unsafe impl<R: Pod> Pod for PlaneCertified<R> {}
