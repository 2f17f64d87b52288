//! Figures of the plots as pictures of a page: the same drawing as in the SVG files.

use super::escape::text;
use crate::Error;
use crate::plot::{Figure, Panel};

/// The figure with its caption; markup. A narrow window moves it, by the keyboard too, rather than making its words too small to
/// read.
///
/// # Errors
/// What the drawing library says.
pub(crate) fn figure(figure: &Figure, caption: &str) -> Result<String, Error> {
    let svg = figure.to_svg().map_err(Error::Usage)?;
    let words = text(&description(figure));
    let named = svg.trim().replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{words}\" "), 1);
    let title = text(&figure.title);
    Ok(format!(
        "<figure><figcaption>{}</figcaption><div class=\"drawing\" role=\"region\" tabindex=\"0\" aria-label=\"{title}, a \
         picture\">{named}</div></figure>\n",
        text(caption)
    ))
}

/// The figure that is seen first.
///
/// # Errors
/// As [`figure`].
pub(crate) fn picture(of: &Figure, caption: &str) -> Result<String, Error> {
    Ok(figure(of, caption)?.replacen("<figure>", "<figure id=\"picture\">", 1))
}

/// What a picture shows, for who does not see it.
fn description(figure: &Figure) -> String {
    let panel = |panel: &Panel| {
        let names: Vec<&str> =
            panel.series.iter().map(|one| one.name.as_str()).filter(|name| !name.is_empty()).collect();
        let of = if names.is_empty() { String::new() } else { format!(": {}", names.join(", ")) };
        format!("{} over {}{of}", panel.y_label, panel.x_label)
    };
    let panels: Vec<String> = figure.panels.iter().map(panel).collect();
    format!("{}. {}. The figures are in the tables of this page.", figure.title, panels.join("; "))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::plot::{Mark, Series};

    #[test]
    fn a_picture_says_what_it_shows() {
        let series = vec![Series::new("a<b", Mark::Line, [(0.0, 1.0), (1.0, 2.0)])];
        let of = Figure { title: "Step".to_owned(), panels: vec![Panel::new("time (s)", "error (rad)", series)] };
        let markup = picture(&of, "One & two").unwrap();
        assert!(markup.starts_with("<figure id=\"picture\"><figcaption>One &amp; two</figcaption>"), "{markup}");
        assert!(markup.contains("aria-label=\"Step. error (rad) over time (s): a&lt;b. The figures"), "{markup}");
        assert!(markup.contains("tabindex=\"0\"") && markup.contains("</svg></div></figure>"));
    }
}
