//! The page in headless Chromium: no error, curves present, nothing cut, zoom linked, keyboard.

use std::fs;
use std::process::Command;

use scraper::{Html, Selector};
use serde_json::Value;

use super::made;

const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];
/// Widths of a telephone and of a large screen, pixels.
const WIDTHS: [u32; 2] = [400, 1600];

/// The browser on the path; none, with the reason printed.
fn browser() -> Option<&'static str> {
    let runs = |name: &&&str| Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success());
    let found = NAMES.iter().find(runs).copied();
    if found.is_none() {
        println!("not looked at in a browser: none of {NAMES:?} is on the path");
    }
    found
}

/// A page that shows another one in frames of those widths, asks each what it looks like, and writes that down as JSON. A window
/// of Chromium is no narrower than 500 pixels; a frame is.
fn looking(page: &str) -> String {
    // Every picture is remembered as it is made.
    let spied = page.replacen(
        "<script>\n\"use strict\";",
        "<script>window.made=[];{const real=uPlot;uPlot=function(...a){const u=new real(...a);made.push(u);return u};\
         Object.assign(uPlot,real)}</script>\n<script>\n\"use strict\";",
        1,
    );
    assert_ne!(spied, page, "the script of the page begins otherwise");
    let spied = spied.replacen(
        "<head>",
        "<head><script>window.errors=[];addEventListener('error',e=>errors.push(e.message));\
         addEventListener('securitypolicyviolation',e=>errors.push(e.violatedDirective))</script>",
        1,
    );
    // In a script no text may end it.
    let text = serde_json::to_string(&spied).unwrap().replace('<', "\\u003c");
    let script = include_str!("look.js");
    format!(
        "<!DOCTYPE html><meta charset=\"utf-8\"><pre id=\"seen\"></pre><script>const page = {text}; const widths = {WIDTHS:?};\n\
         {script}</script>"
    )
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_browser_shows_it_whole_at_400_and_1600_pixels() {
    let Some(browser) = browser() else { return };
    let file = made().folder.join("look.html");
    fs::write(&file, looking(&made().page)).unwrap();
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
    for (of, width) in seen.as_array().unwrap().iter().zip(WIDTHS) {
        assert_eq!(of["width"], width);
        assert_eq!(of["errors"], serde_json::json!([]), "at {width} pixels");
        assert_eq!(of["cut"], serde_json::json!([]), "at {width} pixels");
        assert!(of["pageWidth"].as_u64().unwrap() <= u64::from(width), "{of}");
        // Two recordings of four pictures each, the one at the top, three of what is left, maps.
        assert!(of["pictures"].as_u64().unwrap() >= 12 && of["empty"] == 0, "{of}");
        let visible = of["pictureBottom"].as_f64().unwrap();
        assert!(visible < if width == 400 { 900.0 } else { 700.0 }, "the picture ends at {visible} pixels");
        for linked in ["linkedByKey", "linkedByButton", "wholeAgain", "hiddenByKey"] {
            assert_eq!(of[linked], true, "{linked} at {width} pixels");
        }
    }
}
