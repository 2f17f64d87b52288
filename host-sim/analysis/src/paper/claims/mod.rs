//! What the paper claims, and what became of it: one file for each group of claims.

mod brake;
mod claim;
mod delays;
mod design;
mod joint;
mod law;
mod nonlinear;
mod region;
mod robustness;

pub(in crate::paper) use claim::trim_zeros;
pub use claim::{Claim, RARELY, Verdict};
pub(in crate::paper) use joint::{Joint, search as joint_search};
pub(in crate::paper) use law::{VISCOSITIES, field_for_kv_mm, speeds_rad_s, torque_nm};
pub(in crate::paper) use region::plant as linear_plant;

use super::scan::Scan;
use progress::Progress;
use recording::Error;

/// Tests every claim, in the order of the paper.
///
/// # Errors
/// A value the law, the plant or the stability analysis does not take.
pub(in crate::paper) fn test_all(scan: &Scan, joint: Option<&Joint>, progress: &Progress) -> Result<Vec<Claim>, Error> {
    let groups: [&dyn Fn() -> Result<Vec<Claim>, Error>; GROUPS as usize] = [
        &law::claims,
        &brake::claims,
        &region::claims,
        &robustness::claims,
        &nonlinear::claims,
        &design::claims,
        &|| delays::claims(scan),
        &|| Ok(joint::claims(joint)),
    ];
    let mut claims = Vec::new();
    for group in groups {
        claims.extend(group()?);
        progress.advance(1);
    }
    Ok(claims)
}

/// Number of groups, for the progress.
pub const GROUPS: u64 = 8;
