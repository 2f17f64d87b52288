//! The pages in headless Chromium: no error, curves present, nothing cut, zoom linked, keyboard.

use std::fs;
use std::process::Command;

use scraper::{Html, Selector};
use serde_json::Value;

use super::made;
use super::others::{fleet, others};

const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];
/// Widths of a telephone and of a large screen, pixels.
const WIDTHS: [u32; 2] = [400, 1600];

/// The browser on the path; none, with the reason printed, where there is none. In CI there must be one.
fn browser() -> Option<&'static str> {
    let runs = |name: &&&str| Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success());
    let found = NAMES.iter().find(runs).copied();
    if found.is_none() {
        assert!(std::env::var_os("CI").is_none(), "none of {NAMES:?} is on the path; .ci/run installs chromium");
        println!("not looked at in a browser: none of {NAMES:?} is on the path");
    }
    found
}

/// A page that shows others in frames of those widths, asks each what it looks like, and writes that down as JSON. A window of
/// Chromium is no narrower than 500 pixels; a frame is.
fn looking(pages: &[(&str, String)]) -> String {
    // In a script no text may end it.
    let text = |page: &str| serde_json::to_string(page).unwrap().replace('<', "\\u003c");
    let pages: Vec<String> =
        pages.iter().map(|(name, page)| format!("{{ name: {name:?}, text: {} }}", text(&spied(page)))).collect();
    let (pages, script) = (pages.join(",\n"), include_str!("look.js"));
    format!(
        "<!DOCTYPE html><meta charset=\"utf-8\"><pre id=\"seen\"></pre><script>const pages = [{pages}]; const widths = \
         {WIDTHS:?};\n{script}</script>"
    )
}

/// The page with a script that remembers errors and pictures.
fn spied(page: &str) -> String {
    let remembering = "<head><script>window.errors=[];addEventListener('error',e=>errors.push(e.message));\
                       addEventListener('securitypolicyviolation',e=>errors.push(e.violatedDirective))</script>";
    let page = page.replacen("<head>", remembering, 1);
    if !page.contains("id=\"plot\"") {
        return page;
    }
    // Every picture is remembered as it is made.
    let spied = page.replacen(
        "<script>\n\"use strict\";",
        "<script>window.made=[];{const real=uPlot;uPlot=function(...a){const u=new real(...a);made.push(u);return u};\
         Object.assign(uPlot,real)}</script>\n<script>\n\"use strict\";",
        1,
    );
    assert_ne!(spied, page, "the script of the page begins otherwise");
    spied
}

/// What the browser says of the page at this place.
fn seen_by(browser: &str, file: &std::path::Path) -> Vec<Value> {
    let flags = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--enable-logging=stderr"];
    let size = ["--window-size=1700,1000", "--virtual-time-budget=30000", "--dump-dom"];
    let output =
        Command::new(browser).args(flags).args(size).arg(format!("file://{}", file.display())).output().unwrap();
    let (shown, log) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr).into_owned());
    let told: Vec<&str> = log.lines().filter(|line| line.contains(":CONSOLE")).collect();
    assert!(told.is_empty(), "{told:?}");
    let shown = Html::parse_document(&shown);
    let seen: String = shown.select(&Selector::parse("#seen").unwrap()).flat_map(|pre| pre.text()).collect();
    let seen: Value = serde_json::from_str(&seen).unwrap_or_else(|error| panic!("{error}: `{seen}`\n{log}"));
    println!("{seen:#}");
    seen.as_array().unwrap().clone()
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_browser_shows_every_page_whole_at_400_and_1600_pixels() {
    let Some(browser) = browser() else { return };
    let mut pages = vec![("diagnose", made().page.clone())];
    pages.extend(others().iter().map(|other| (other.name, other.page.clone())));
    pages.push(("fleet", fleet().to_owned()));
    let file = made().folder.join("look.html");
    fs::write(&file, looking(&pages)).unwrap();
    let seen = seen_by(browser, &file);
    assert_eq!(seen.len(), pages.len() * WIDTHS.len());
    for (of, width) in seen.iter().zip(WIDTHS.iter().cycle()) {
        let at = format!("{} at {width} pixels", of["name"]);
        assert_eq!(of["width"], *width);
        for wrong in ["errors", "cut", "beyond"] {
            assert_eq!(of[wrong], serde_json::json!([]), "{wrong}, {at}");
        }
        assert!(of["pageWidth"].as_u64().unwrap() <= u64::from(*width), "{of}");
        if of["name"] == "fleet" {
            assert_eq!((&of["pictureBottom"], &of["drawings"]), (&Value::Null, &serde_json::json!(0)), "{of}");
            continue;
        }
        let visible = of["pictureBottom"].as_f64().unwrap();
        assert!(visible < if *width == 400 { 900.0 } else { 700.0 }, "the picture ends at {visible} pixels, {at}");
        if of["name"] != "diagnose" {
            assert!(of["drawings"].as_u64().unwrap() > 0, "{of}");
            continue;
        }
        // Two recordings of four pictures each, the one at the top, three of what is left, maps.
        assert!(of["pictures"].as_u64().unwrap() >= 12 && of["empty"] == 0, "{of}");
        for linked in ["linkedByKey", "linkedByButton", "wholeAgain", "hiddenByKey"] {
            assert_eq!(of[linked], true, "{linked}, {at}");
        }
    }
}
