//! Catches the panics of decoders.
//!
//! The crate `parquet` panics on some damaged pages (an unknown page type, counts that disagree), where a recording must
//! give one message. The panic is caught here, and its report to standard error kept back on this thread only.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// What `decode` gives; none where it panicked. `decode` must own all it changes, as its state is lost then.
pub(crate) fn caught<T>(decode: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let report = panic::take_hook();
        panic::set_hook(Box::new(move |what| {
            if !QUIET.get() {
                report(what);
            }
        }));
    });
    let before = QUIET.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(decode));
    QUIET.set(before);
    result.ok()
}
