//! Cells of a CSV file as text and numbers, whichever country's program wrote them.

use std::borrow::Cow;

/// The text of a cell: UTF-8, or that of Windows where it is none. There no bytes are without a meaning.
pub(super) fn text(cell: &[u8]) -> Cow<'_, str> {
    std::str::from_utf8(cell)
        .map_or_else(|_| encoding_rs::WINDOWS_1252.decode_without_bom_handling(cell).0, Cow::Borrowed)
}

/// The cell as a number, with a decimal point or comma.
pub(super) fn is_number(cell: &str) -> bool {
    with_decimal_point(cell).trim().parse::<f64>().is_ok()
}

/// A number with a decimal comma as one with a point; anything else as it is.
pub(super) fn with_decimal_point(cell: &str) -> Cow<'_, str> {
    let Some((whole, fraction)) = cell.split_once(',') else { return Cow::Borrowed(cell) };
    let number = format!("{whole}.{fraction}");
    // A point and a comma together are a separator of thousands, of which there are two kinds.
    let is_number = !cell.contains('.') && number.trim().parse::<f64>().is_ok();
    if is_number { Cow::Owned(number) } else { Cow::Borrowed(cell) }
}

/// Whether these cells of a file that separates them by commas have decimal commas, in quotes. `1,234` alone may as well be a
/// thousand and some: another number must tell, and none may have a decimal point.
pub(super) fn have_decimal_commas<'a>(cells: impl IntoIterator<Item = &'a String>) -> bool {
    let mut told = false;
    for cell in cells {
        let has_point = cell.contains('.') && cell.parse::<f64>().is_ok();
        if has_point {
            return false;
        }
        told |= cell.contains(',') && is_number(cell) && !may_be_thousands(cell);
    }
    told
}

fn may_be_thousands(cell: &str) -> bool {
    let cell = cell.trim_start_matches(['+', '-']);
    let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    cell.split_once(',').is_some_and(|(whole, rest)| {
        (1..=3).contains(&whole.len()) && !whole.starts_with('0') && rest.len() == 3 && digits(whole) && digits(rest)
    })
}
