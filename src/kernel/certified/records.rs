//! The objects as the device sees them.

use bytemuck::{Pod, Zeroable};

use crate::num::V3;
use crate::seen::{PlaneSeen, SphereLeaf, SphereSeen};

/// A sphere as the device sees it: a [`SphereSeen`], without what only a surface needs.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct SphereCertified {
    /// [`SphereLeaf::center`]
    pub center: [f32; 3],
    /// [`SphereLeaf::inner2`]
    pub inner2: f32,
    /// [`SphereLeaf::outer2`]
    pub outer2: f32,
    /// [`SphereLeaf::slack`]
    pub slack: f32,
    /// [`SphereLeaf::near_most`]
    pub near_most: f32,
    /// [`SphereSeen::is_close`]
    pub is_close: f32,
    /// [`SphereSeen::k`]
    pub k: f32,
    /// [`SphereSeen::k_error`]
    pub k_error: f32,
    /// [`SphereSeen::k_width`]
    pub k_width: f32,
    /// Fills WGSL's 16-byte alignment of the struct.
    pub padding: f32,
}

impl SphereCertified {
    /// What no ray meets.
    pub fn nowhere() -> SphereCertified {
        let SphereLeaf { inner2, outer2, slack, near_most, .. } = SphereLeaf::<f32>::nowhere();
        SphereCertified { inner2, outer2, slack, near_most, ..SphereCertified::zeroed() }
    }
}

impl From<&SphereSeen<f32>> for SphereCertified {
    fn from(seen: &SphereSeen<f32>) -> SphereCertified {
        let &SphereSeen { inner2, outer2, slack, near_most, .. } = seen;
        let &SphereSeen { center: V3(center), is_close, k, k_error, k_width, .. } = seen;
        SphereCertified {
            center,
            inner2,
            outer2,
            slack,
            near_most,
            is_close,
            k,
            k_error,
            k_width,
            padding: 0.0,
        }
    }
}

/// A plane as the device sees it: a [`PlaneSeen`], without what only a surface needs.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct PlaneCertified {
    /// [`PlaneSeen::normal`]
    pub normal: [f32; 3],
    /// [`PlaneSeen::offset`]
    pub offset: f32,
    /// [`PlaneSeen::offset_error`]
    pub offset_error: f32,
    /// [`PlaneSeen::slope_error`]
    pub slope_error: f32,
    /// Fills WGSL's 16-byte alignment of the struct.
    pub padding: [f32; 2],
}

impl PlaneCertified {
    /// What no ray meets: it runs along all of them.
    pub fn nowhere() -> PlaneCertified {
        PlaneCertified { offset: 1.0, ..PlaneCertified::zeroed() }
    }
}

impl From<&PlaneSeen<f32>> for PlaneCertified {
    fn from(seen: &PlaneSeen<f32>) -> PlaneCertified {
        let &PlaneSeen { normal: V3(normal), offset, offset_error, slope_error, .. } = seen;
        PlaneCertified { normal, offset, offset_error, slope_error, padding: [0.0; 2] }
    }
}
