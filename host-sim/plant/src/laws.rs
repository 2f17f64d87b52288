//! The force laws by themselves, for whoever propagates something other than one state, such as the belief of an estimator:
//! the very functions that [`crate::Mechanics`] integrates.

pub use crate::effects::friction::Friction;
pub use crate::effects::position::{PositionTorque, Ripple};
pub use crate::effects::shaft::ShaftLaw;
pub use crate::mechanics::room;
