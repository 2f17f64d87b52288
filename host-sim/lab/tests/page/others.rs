//! The pages of the other commands: the same dress, and the figures of what each prints or writes beside.

use std::fs;
use std::sync::OnceLock;

use scraper::{Html, Selector};
use serde_json::Value;

use super::structure::{all, cells, is_in_dress, same, text};
use super::{Made, lab, made};

/// A page of a command, and what it printed.
pub struct Other {
    pub name: &'static str,
    pub page: String,
    printed: String,
}

/// In the place of the tool that is proved: it answers at once, the same to everything.
const STAND_IN: &str = "#!/bin/sh\ncat > \"$5\" <<'END'\n{\"verdict\": \"named\", \"effects\": [{\"id\": \"coulomb_friction\", \
                        \"parameters\": [{\"id\": \"coulomb_nm\", \"value\": 1.0, \"low\": 0.4, \"high\": 1.1, \"unit\": \
                        \"N m\"}]}]}\nEND\n";

/// The pages, made once for all tests, beside the one of the diagnosis.
pub fn others() -> &'static [Other] {
    static MADE: OnceLock<Vec<Other>> = OnceLock::new();
    MADE.get_or_init(|| {
        let folder = &made().folder;
        let mut lines = vec![
            ("compare", "compare --machine machine.toml --improved truth.toml steps.csv held.csv --plots pictures"),
            ("stability", "stability --json stability.json"),
            ("tune", "tune --machine truth.toml --out tuned"),
            ("paper", "paper --out paper"),
            ("beyond", "paper --beyond --out beyond"),
        ];
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            fs::write(folder.join("tool"), STAND_IN).unwrap();
            fs::set_permissions(folder.join("tool"), fs::Permissions::from_mode(0o755)).unwrap();
            lines.push((
                "prove",
                "prove --arm single --count 60 --no-rivals --program tool --json prove.json --out proof",
            ));
        }
        let make = |(name, line): (&'static str, &str)| {
            let printed = lab(folder, &format!("{line} --html {name}.html"));
            Other { name, page: fs::read_to_string(folder.join(format!("{name}.html"))).unwrap(), printed }
        };
        lines.into_iter().map(make).collect()
    })
}

/// The page of a fleet of two, which is of tables only, made once for all tests.
pub fn fleet() -> &'static str {
    static MADE: OnceLock<String> = OnceLock::new();
    MADE.get_or_init(|| {
        let folder = &made().folder;
        let rows = "machine,recordings,date\nmachine.toml,steps.csv,2026-03-30\nmachine.toml,held.csv,2026-03-31\n";
        fs::write(folder.join("fleet.csv"), rows).unwrap();
        lab(folder, "fleet fleet.csv -o fleet.parquet --html fleet.html");
        fs::read_to_string(folder.join("fleet.html")).unwrap()
    })
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn the_page_of_a_fleet_is_in_the_same_dress() {
    let page = Html::parse_document(fleet());
    is_in_dress(&page);
    let effects = cells(&page, "Effects in machines");
    let viscous = effects.iter().find(|row| row[1] == "viscous_friction").unwrap_or_else(|| panic!("{effects:?}"));
    assert_eq!(viscous[2..], ["2 of 2", "2, 3"]);
}

fn page(name: &str) -> (Html, &'static Other) {
    let other = others().iter().find(|other| other.name == name).unwrap();
    (Html::parse_document(&other.page), other)
}

fn json(name: &str) -> Value {
    let Made { folder, .. } = made();
    serde_json::from_str(&fs::read_to_string(folder.join(name)).unwrap()).unwrap()
}

/// The number behind these words in a text.
fn behind(printed: &str, words: &str) -> f64 {
    let rest = printed.split(words).nth(1).unwrap_or_else(|| panic!("no `{words}` in {printed}"));
    let number = rest.trim_start().split([' ', ',', ';', '\n']).next().unwrap();
    number.parse().unwrap_or_else(|_| panic!("`{number}` behind `{words}`"))
}

/// The cell of a table behind the one that begins its row.
fn cell(rows: &[Vec<String>], first: &str) -> String {
    let row = rows.iter().find(|row| row[0] == first).unwrap_or_else(|| panic!("no row `{first}` in {rows:?}"));
    row[1].clone()
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn every_page_is_in_the_same_dress() {
    for other in others() {
        println!("{}: {} kB", other.name, other.page.len() / 1000);
        let page = Html::parse_document(&other.page);
        is_in_dress(&page);
        assert!(!other.page.contains("<script"), "{}: nothing runs", other.name);
        let first = all(&page, "#picture svg[role=img]");
        assert!(first.len() == 1, "{}: a picture at the top", other.name);
        for drawing in all(&page, ".drawing") {
            let svg = drawing.select(&Selector::parse("svg").unwrap()).next().unwrap();
            assert!(svg.value().attr("aria-label").unwrap().contains(" over "), "{}", other.name);
            let drawn = svg.select(&Selector::parse("polyline, circle").unwrap()).count();
            assert!(drawn > 0, "{}: a curve in each picture", other.name);
        }
        let command = format!("servo-lab {} ", if other.name == "beyond" { "paper --beyond" } else { other.name });
        let again: String = all(&page, "pre").into_iter().map(text).collect();
        assert!(again.contains(&command) && again.contains("git checkout"), "{again}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_comparison_has_the_figures_that_it_prints() {
    let (page, other) = page("compare");
    let shown = cells(&page, "Recorded less simulated position, rms in mrad");
    let lines: Vec<&str> = other.printed.lines().filter(|line| line.contains("ms windows  residual")).collect();
    let (nominal, improved): (Vec<&str>, Vec<&str>) = lines.iter().partition(|line| line.contains("as a torque"));
    assert_eq!((shown.len(), nominal.len(), improved.len()), (4, 4, 4), "{}", other.printed);
    for ((row, nominal), improved) in shown.iter().zip(nominal).zip(improved) {
        // The text has four digits.
        same(&format!("{:.3}", row[3].parse::<f64>().unwrap()), 1e3 * behind(nominal, "residual"));
        same(&row[5], behind(nominal, "rms,"));
        same(&row[6], behind(nominal, "as a torque"));
        same(&row[8], behind(improved, "the noise,"));
    }
    let names: Vec<String> = all(&page, "details h3").into_iter().map(text).collect();
    assert_eq!(names, ["steps.csv", "held.csv"]);
    assert!(other.printed.contains("speed"), "{}", other.printed);
    same(cell(&cells(&page, "Share of the residual torque of steps.csv"), "speed").trim_end_matches(" %"), {
        let line = other.printed.lines().find(|line| line.contains("%  speed")).unwrap();
        line.split_whitespace().next().unwrap().parse().unwrap()
    });
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn the_stability_has_the_figures_of_the_json() {
    let ((page, _), answer) = (page("stability"), json("stability.json"));
    let shown = cells(&page, "Of the loop opened at the control torque");
    let margins = &answer["margins"];
    for (row, key, scale) in [
        ("gain: torque times this loses the loop", "gain", 1.0),
        ("phase: so much more lag loses the loop", "phase_deg", 1.0),
        ("delay: so much more loses the loop", "delay_s", 1e3),
        ("the same over L: L may grow by this factor", "delay_factor", 1.0),
    ] {
        same(&cell(&shown, row), scale * margins[key].as_f64().unwrap());
    }
    let areas = cells(&page, "Within K_p*");
    let regions = answer["regions"].as_array().unwrap();
    assert_eq!(areas.len(), regions.len());
    areas.iter().zip(regions).for_each(|(row, region)| same(&row[1], region["area"].as_f64().unwrap()));
    let tolerances = cells(&page, "Each alone");
    for (row, tolerance) in tolerances.iter().zip(answer["tolerances"].as_array().unwrap()) {
        if let Some(factor) = tolerance["upper"]["factor"].as_f64() {
            same(&row[5], factor);
        }
    }
    assert_eq!(text(all(&page, "h1 .verdict")[0]), if answer["inside"] == true { "stable" } else { "unstable" });
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn the_tuned_gains_are_those_that_are_printed_and_of_the_machine_file() {
    let (page, other) = page("tune");
    let shown = cells(&page, "What each pair of gains keeps, and does");
    let file: toml::Table = fs::read_to_string(made().folder.join("tuned/tuned.toml")).unwrap().parse().unwrap();
    let controller = |key: &str| file["controller"][key].as_float().unwrap();
    same(&cell(&shown, "K_P (N m/rad)"), controller("kp_nm_rad"));
    same(&cell(&shown, "K_D (N m s/rad)"), controller("kd_nm_s_rad"));
    for (row, words) in [
        ("least margin over the one demanded (1)", "keeps"),
        ("phase margin (degrees)", "margins: phase"),
        ("settling of the large step (ms)", "settles"),
        ("moved by a push of 8 N m (mrad)", "push moves it"),
    ] {
        // The text has one or two decimals.
        let (shown, printed) = (cell(&shown, row).parse::<f64>().unwrap(), behind(&other.printed, words));
        assert!((shown - printed).abs() < 0.051, "{row}: {shown} on the page, {printed} printed");
    }
    let levels = cells(&page, "The best of ");
    assert!(levels.len() > 8 && other.printed.contains("level   mean settling"));
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn the_paper_has_its_claims_and_all_its_figures() {
    let (page, other) = page("paper");
    let folder = made().folder.join("paper");
    let claims = fs::read_to_string(folder.join("claims.md")).unwrap();
    let table: Vec<&str> = claims.lines().filter(|line| line.starts_with("| ")).skip(1).collect();
    let shown = cells(&page, "The claims in the order of the paper");
    assert!(shown.len() == table.len() && shown.len() > 10);
    for (row, line) in shown.iter().zip(table) {
        assert!(
            line.contains(&format!("**{}**", row[2])) && line.contains(row[1].split('|').next().unwrap()),
            "{row:?}: {line}"
        );
        assert!(other.printed.contains(&row[2].to_uppercase()));
    }
    let files = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
    let figures: Vec<_> = files.filter(|file| file.extension().unwrap() == "svg").collect();
    // The one at the top is among them.
    assert_eq!(all(&page, ".drawing svg").len(), figures.len() + 1);
    // Nothing was measured.
    assert!(figures.iter().all(|file| !fs::read_to_string(file).unwrap().contains("measured")));
    let (page, other) = self::page("beyond");
    let shown = cells(&page, "With the delays that were told");
    let lines: Vec<&str> = other.printed.lines().filter(|line| line.contains(" / ")).collect();
    for row in shown {
        let line = lines.iter().find(|line| line.contains(&row[0])).unwrap();
        let printed = line.split('|').nth(2).unwrap();
        for (shown, printed) in row[1].split(" / ").zip(printed.split(" / ")) {
            let (shown, printed): (f64, f64) = (shown.parse().unwrap(), printed.trim().parse().unwrap());
            assert!((shown - printed).abs() <= 0.051 + 1e-3 * printed, "{row:?}: {line}");
        }
    }
}

#[cfg(unix)]
#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn the_proof_has_the_counts_of_the_json() {
    let ((page, _), results) = (page("prove"), json("prove.json"));
    let (pass, shown) =
        (results["score"]["pass"].as_array().unwrap(), cells(&page, "What is asked, and what was found"));
    assert_eq!(shown.len(), pass.len());
    for (row, line) in shown.iter().zip(pass) {
        assert_eq!(row[0], line["what"].as_str().unwrap());
        match line["measured"].as_f64() {
            Some(value) => same(&row[2], value),
            None => assert_eq!(row[2], "not asked"),
        }
    }
    let arms = cells(&page, "Counts by arm");
    let counted = results["score"]["arms"].as_array().unwrap();
    assert_eq!(arms.len(), counted.len());
    for (row, arm) in arms.iter().zip(counted) {
        assert_eq!(row[7], format!("{}/{}", arm["named"]["holds"], arm["named"]["of"]));
    }
    assert_eq!(all(&page, "#power ~ .grid .drawing").len(), results["score"]["power"].as_array().unwrap().len());
    let again: String = all(&page, "section table td").into_iter().map(text).collect();
    assert!(again.contains(results["origin"]["program"].as_str().unwrap()));
}
