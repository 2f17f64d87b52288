//! Well-formed, linked within itself, loading nothing, with the figures of the JSON.

use std::collections::HashSet;

use scraper::{ElementRef, Html, Selector};

use super::{lab, made};

pub fn all<'a>(page: &'a Html, what: &str) -> Vec<ElementRef<'a>> {
    page.select(&Selector::parse(what).unwrap()).collect()
}

pub fn text(element: ElementRef) -> String {
    element.text().collect::<String>().replace('\u{a0}', " ").trim().to_owned()
}

/// The cells of the table of that caption, without its head.
pub fn cells(page: &Html, caption: &str) -> Vec<Vec<String>> {
    let has = |table: &ElementRef| {
        table.select(&Selector::parse("caption").unwrap()).any(|found| text(found).starts_with(caption))
    };
    let table = all(page, "table").into_iter().find(has).unwrap_or_else(|| panic!("no table `{caption}`"));
    let rows = Selector::parse("tbody tr").unwrap();
    let cell = Selector::parse("th, td").unwrap();
    table.select(&rows).map(|row| row.select(&cell).map(text).collect()).collect()
}

/// Whether a number on the page is the one of the JSON, to the digits that the page shows.
pub fn same(shown: &str, value: f64) {
    let number = shown.trim_end_matches('%').trim();
    let decimals = number.split('e').next().unwrap().split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let exponent: i32 = number.split_once('e').map_or(0, |(_, exponent)| exponent.parse().unwrap());
    let within = 10.0_f64.powi(exponent - decimals as i32);
    let found: f64 = number.parse().unwrap_or_else(|_| panic!("`{shown}` is no number"));
    assert!((found - value).abs() <= 1.01 * within, "{shown} on the page, {value} in the JSON");
}

/// Well-formed, every link leads somewhere, nothing is loaded, and everything that scrolls is named and moved by the keyboard.
pub fn is_in_dress(page: &Html) {
    links_lead_somewhere(page);
    loads_nothing_and_names_what_scrolls(page);
}

fn links_lead_somewhere(page: &Html) {
    assert!(page.errors.is_empty(), "{:?}", page.errors);
    let ids: Vec<&str> = all(page, "[id]").iter().map(|element| element.value().attr("id").unwrap()).collect();
    let unique: HashSet<&str> = ids.iter().copied().collect();
    assert_eq!(ids.len(), unique.len(), "{ids:?}");
    let links = all(page, "[href]");
    assert!(links.len() > 4, "a table of contents");
    for link in &links {
        let target = link.value().attr("href").unwrap();
        assert!(target.strip_prefix('#').is_some_and(|id| unique.contains(id)), "{target}");
    }
    for labelled in all(page, "[aria-labelledby]") {
        assert!(unique.contains(labelled.value().attr("aria-labelledby").unwrap()));
    }
    // Every section is in the contents, in its order.
    let contents: Vec<String> = all(page, "nav a").into_iter().map(text).collect();
    let headings: Vec<String> = all(page, "section > h2").into_iter().map(text).collect();
    assert_eq!(contents, headings);
    assert_eq!(headings.last().map(String::as_str), Some("How to reproduce this page"));
}

fn loads_nothing_and_names_what_scrolls(page: &Html) {
    for loading in ["[src]", "link", "iframe", "object", "embed", "img", "video", "audio", "form"] {
        assert!(all(page, loading).is_empty(), "{loading}");
    }
    let styles: String = all(page, "style").into_iter().map(text).collect();
    assert!(!styles.contains("url(") && !styles.contains("@import"));
    for table in all(page, ".table, .drawing, pre") {
        let named = table.value().attr("aria-label").is_some_and(|label| !label.is_empty());
        assert!(named && table.value().attr("tabindex") == Some("0"), "a wide table is moved by the keyboard");
    }
    assert_eq!(all(page, "h1").len(), 1);
    assert_eq!(all(page, "html[lang=en] main").len(), 1);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn the_page_of_a_diagnosis_is_well_formed_loads_nothing_and_says_what_belongs_into_it() {
    let page = Html::parse_document(&made().page);
    is_in_dress(&page);
    let headings: Vec<String> = all(&page, "section > h2").into_iter().map(text).collect();
    assert!(headings.len() > 7, "{headings:?}");
    for heading in
        ["How well it fits", "Is what is left noise?", "Equation of the improved model", "How to reproduce this page"]
    {
        assert!(headings.iter().any(|found| found == heading), "{heading} in {headings:?}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn the_figures_are_those_of_the_json() {
    let (page, answer) = (Html::parse_document(&made().page), &made().answer);
    let articles = all(&page, "#effects ~ article");
    let effects = answer["effects"].as_array().unwrap();
    assert!(!effects.is_empty() && articles.len() == effects.len(), "{answer:#}");
    for (article, effect) in articles.iter().zip(effects) {
        let rows = Selector::parse("tbody tr").unwrap();
        let cell = Selector::parse("th, td").unwrap();
        let shown: Vec<Vec<String>> = article.select(&rows).map(|row| row.select(&cell).map(text).collect()).collect();
        let parameters = effect["parameters"].as_array().unwrap();
        assert_eq!(shown.len(), parameters.len());
        for (row, parameter) in shown.iter().zip(parameters) {
            assert_eq!(row[0], parameter["id"].as_str().unwrap());
            same(&row[1], parameter["value"].as_f64().unwrap());
            let (low, high) = row[2].split_once(" to ").unwrap();
            same(low, parameter["low"].as_f64().unwrap());
            same(high, parameter["high"].as_f64().unwrap());
            match parameter["nominal"].as_f64() {
                Some(nominal) => same(&row[3], nominal),
                None => assert_eq!(row[3], ""),
            }
            assert_eq!(row[4], parameter["unit"].as_str().unwrap());
        }
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn the_figures_of_the_fit_and_of_other_models_are_those_of_the_json() {
    let (page, answer) = (Html::parse_document(&made().page), &made().answer);
    let fit = |key: &str| answer["fit"][key].as_f64().unwrap();
    let shown = cells(&page, "Recorded less simulated position");
    let factor = 10.0_f64.powf((shown[0][1].parse::<f64>().unwrap() / fit("before_rms")).log10().round());
    for (row, keys) in shown.iter().zip([
        ["before_rms", "after_rms", "noise_floor_rms"],
        ["heldout_before_rms", "heldout_after_rms", "heldout_floor_rms"],
    ]) {
        for (cell, key) in [&row[1], &row[2], &row[4]].into_iter().zip(keys) {
            same(cell, factor * fit(key));
        }
        same(&row[3], 100.0 * (1.0 - fit(keys[1]) / fit(keys[0])));
    }
    for (index, other) in answer["alternatives"].as_array().into_iter().flatten().enumerate() {
        let shown = cells(&page, &format!("Alternative {}:", index + 1));
        let values = other["effects"].as_array().unwrap().iter().flat_map(|of| of["parameters"].as_array().unwrap());
        shown.iter().zip(values).for_each(|(row, value)| same(&row[2], value["value"].as_f64().unwrap()));
    }
    let matrix = answer["correlation"]["matrix"].as_array().expect("two values at least");
    for (row, values) in cells(&page, "Correlation of the errors").iter().zip(matrix) {
        row[1..].iter().zip(values.as_array().unwrap()).for_each(|(shown, value)| same(shown, value.as_f64().unwrap()));
    }
    let hashes = cells(&page, "Files that were read");
    let inputs = answer["provenance"]["inputs"].as_array().unwrap();
    assert_eq!(hashes.len(), inputs.len());
    hashes.iter().zip(inputs).for_each(|(row, input)| assert_eq!(row[1], input["sha256"].as_str().unwrap()));
}

/// Whether a share of the JSON is what a cell shows, to a percent.
fn same_share(shown: &str, share: &serde_json::Value) {
    same(shown.trim_end_matches(" %"), 100.0 * share.as_f64().unwrap());
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn where_the_nominal_model_fails_is_that_of_the_json() {
    let (page, answer) = (Html::parse_document(&made().page), &made().answer);
    let spans = cells(&page, "Spans of time in which the nominal model fails most");
    let locations = answer["locations"].as_array().unwrap();
    assert!(!locations.is_empty() && spans.len() == locations.len(), "{answer:#}");
    for (row, location) in spans.iter().zip(locations) {
        assert_eq!(row[0], location["recording"].as_str().unwrap());
        let (start, end) = row[1].split_once(" to ").unwrap();
        same(start, location["start_s"].as_f64().unwrap());
        same(end, location["end_s"].as_f64().unwrap());
        same_share(&row[2], &location["share"]);
        assert_eq!(row[3], location["text"].as_str().unwrap());
    }
    let ranges = cells(&page, "Ranges of state in which the nominal model fails most");
    let regions = answer["regions"].as_array().unwrap();
    assert!(!regions.is_empty() && ranges.len() == regions.len(), "{answer:#}");
    for (row, region) in ranges.iter().zip(regions) {
        assert_eq!(row[0], region["channel"].as_str().unwrap());
        let (low, high) = row[1].split_once(" to ").unwrap();
        same(low, region["low"].as_f64().unwrap());
        same(high, region["high"].as_f64().unwrap());
        same_share(&row[2], &region["share"]);
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn what_is_left_is_that_of_the_json() {
    let folder = &made().folder;
    // With nothing to name it by, the missing friction is left.
    let asked = "diagnose --machine machine.toml --only torque_ripple steps.csv";
    lab(folder, &format!("{asked} --html left.html --json left.json"));
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let page = Html::parse_document(&read("left.html"));
    let answer: serde_json::Value = serde_json::from_str(&read("left.json")).unwrap();
    let left = &answer["remainder"];
    let words = text(all(&page, "section[aria-labelledby=left]")[0]);
    let rms = words.split("stand in for ").nth(1).unwrap().split(' ').next().unwrap();
    same(rms, left["effort_rms"].as_f64().unwrap_or_else(|| panic!("{answer:#}")));
    let rows = cells(&page, "Channels that predict part of it");
    let predictors = left["predictors"].as_array().unwrap();
    assert!(!predictors.is_empty() && rows.len() == predictors.len(), "{left:#}");
    for (row, predictor) in rows.iter().zip(predictors) {
        assert_eq!(row[0], predictor["channel"].as_str().unwrap());
        same_share(&row[1], &predictor["share"]);
        if let Some(rms) = predictor["effort_rms"].as_f64() {
            same(row[2].split(' ').next().unwrap(), rms);
        }
    }
}
