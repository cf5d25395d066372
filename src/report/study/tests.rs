use super::*;
use crate::report::run::{ErrorReport, ProbeReport};

fn error(norm: f64) -> ErrorReport {
    ErrorReport {
        against: "point_source_in_box".to_owned(),
        l1: norm,
        l2: norm,
        linf: 2.0 * norm,
        l2_relative: norm,
        mean_square: norm * norm,
        root_mean_square: norm,
    }
}

fn spread(seconds: f64) -> Spread {
    Spread::of([0.9 * seconds, seconds, 1.2 * seconds])
}

fn split(value: f64) -> Split {
    let part =
        |name: &str, value: f64| Part { name: name.to_owned(), value, relative: Some(value / 2.0) };
    let parts = vec![part("Deff", -0.03), part("step", value - 1.97)];
    Split {
        space_l2_relative: Some(1e-3),
        probes: vec![ProbeSplit { name: "centre".to_owned(), value, exact: 2.0, parts }],
        remarks: vec!["edges <free>".to_owned()],
    }
}

/// A point of a series with a spacing.
pub(crate) fn point(number: usize, correction: &str, spacing: f64, time: f64, norm: f64) -> Point {
    let setting = |name: &str, value: String| Setting { name: name.to_owned(), value };
    let settings = vec![
        setting("correction", correction.to_owned()),
        setting("spacing", format!("{spacing}")),
    ];
    let result = Measured {
        backend: "cpu".to_owned(),
        adapter: None,
        precision: "f64".to_owned(),
        path: "lattice".to_owned(),
        method: "euler".to_owned(),
        steps: 100,
        dt: Some(spacing * spacing),
        operator_applications: (100.0 / spacing) as u64,
        updates_per_s: 1e8,
        memory_bytes: 1000,
        runs: vec![TimedRun {
            warm_up: false,
            setup_s: 0.0,
            solve_s: time,
            output_s: 0.0,
            updates_per_s: 1e8,
            command_s: time,
        }],
        setup_s: spread(0.1 * time),
        solve_s: spread(time),
        output_s: spread(0.01),
        total_s: spread(1.1 * time),
        error: Some(error(norm)),
        probes: vec![ProbeReport {
            name: "centre".to_owned(),
            at: vec![1.0],
            time: 1.0,
            value: 1.9,
            exact: Some(2.0),
        }],
        split: Some(split(1.9)),
        no_split: None,
        pareto: false,
        warnings: Vec::new(),
    };
    Point {
        number,
        label: label(&settings, spacing),
        settings,
        command: format!("diffusph run a --set 'x={number}'"),
        spacing,
        particles: (1.0 / spacing).powi(3) as u64,
        result: Some(result),
        failure: None,
    }
}

pub(crate) fn report() -> StudyReport {
    let mut points = vec![
        point(1, "none", 0.5, 0.01, 2.1e-2),
        point(2, "moment", 0.5, 0.01, 8e-3),
        point(3, "none", 0.25, 0.1, 2e-2),
        point(4, "moment", 0.25, 0.1, 2e-3),
        point(5, "moment", 0.125, 1.0, 5e-4),
    ];
    points[1].result.as_mut().expect("it ran").pareto = true;
    points.push(Point {
        number: 6,
        result: None,
        failure: Some("diverged at step 3 <of> 9".to_owned()),
        ..point(6, "none", 1.0, 1.0, 1.0)
    });
    StudyReport {
        study_version: STUDY_VERSION,
        diffusph_version: "1.2.3".to_owned(),
        case: "a".to_owned(),
        title: "A & B".to_owned(),
        dimension: 3,
        machine: StudyMachine {
            processor: "a processor".to_owned(),
            threads: 2,
            backend: "cpu".to_owned(),
            adapter: None,
        },
        against: Some("against the exact solution x".to_owned()),
        repeat: 3,
        budget_s: 60.0,
        elapsed_s: 12.0,
        interrupted: false,
        points,
        skipped: vec![Skipped {
            label: "dx 0.01".to_owned(),
            command: "diffusph run b".to_owned(),
            expected_s: 100.0,
            why: "expected to take 100 s".to_owned(),
        }],
        orders: vec![Order {
            varies: "spacing".to_owned(),
            series: "corrected".to_owned(),
            points: vec![5, 4, 2],
            from: 0.125,
            to: 0.5,
            all: Slopes { l2_relative: Some(2.0), ..Slopes::default() },
            finest: Slopes { l2_relative: Some(2.0), ..Slopes::default() },
            time_part: None,
        }],
        recommendations: vec![Recommendation {
            target: 1e-2,
            point: Some(2),
            total_s: Some(0.011),
            text: "For 1 %: corrected, dx 0.5.".to_owned(),
        }],
        reference_laws: vec![ReferenceLaw {
            label: "theirs <1990>".to_owned(),
            factor: 0.5,
            order: 1.5,
        }],
        peers: Some(Peers::parse(PEERS).expect("peers")),
        peers_ahead: vec!["0.1 %: scipy WINS".to_owned()],
        remarks: vec!["a remark".to_owned()],
    }
}

const PEERS: &str = r#"{"peers_version": 1, "machine": "two cores", "points": [
    {"tool": "scipy", "version": "1.14", "setting": "50^3", "setup_s": [0.1, 0.3, 0.2],
     "solve_s": [1.0], "l2_relative": 0.0077, "against": "mirrored point source"}]}"#;

#[test]
fn the_report_is_read_back_as_it_was_written() {
    let text = serde_json::to_string(&report()).expect("it is JSON");
    let read: StudyReport = serde_json::from_str(&text).expect("it is a study");
    assert_eq!(read, report());
}

#[test]
fn the_csv_has_a_line_a_point_and_is_read_back() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    report().write_csv(folder.path()).expect("written");
    let mut table = ::csv::Reader::from_path(folder.path().join("study.csv")).expect("readable");
    let header: Vec<String> =
        table.headers().expect("a header").iter().map(str::to_owned).collect();
    assert_eq!(header, CSV_COLUMNS);
    let rows: Vec<Vec<String>> = table
        .records()
        .map(|row| row.expect("a row").iter().map(str::to_owned).collect())
        .collect();
    assert_eq!(rows.len(), 6);
    let cell = |row: usize, name: &str| {
        let column = CSV_COLUMNS.iter().position(|column| *column == name).expect(name);
        rows[row][column].clone()
    };
    assert_eq!(cell(1, "l2_relative").parse(), Ok(8e-3));
    assert_eq!(cell(1, "settings"), "correction=moment; spacing=0.5");
    assert_eq!(cell(1, "pareto"), "true");
    assert_eq!(
        (cell(5, "solve_s"), cell(5, "failure")),
        (String::new(), "diverged at step 3 <of> 9".to_owned())
    );
}

#[test]
fn the_table_says_all_that_there_is() {
    let text = report().table();
    for part in [
        "A & B (a)\n",
        "a processor, 2 threads, backend cpu\n",
        "5 settings ran, 1 failed, 1 left out; 12 s of the 60 s allowed\n",
        "2*  corrected, dx 0.5",
        "failed: diverged at step 3",
        "observed orders\n  corrected, spacing 0.125 to 0.5 m (3 points): relative L2 2.00",
        "what the error consists of, at the probe \"centre\"",
        "left out\n  dx 0.01: expected to take 100 s\n",
        "For 1 %: corrected, dx 0.5.\n",
        "0.1 %: scipy WINS\n",
        "note  a remark\n",
    ] {
        assert!(text.contains(part), "no `{part}` in\n{text}");
    }
}

#[test]
fn the_page_needs_nothing_else_and_has_every_picture() {
    let text = report().page().expect("drawn");
    for outside in ["http", "src=", "url(", "@import", "<script", "<link"] {
        assert!(!text.contains(outside), "{outside} in the page");
    }
    assert_eq!(text.matches("<svg").count(), 5);
    for part in [
        "Error against run time: A &amp; B",
        "error against spacing",
        "error against the number of particles",
        "theirs &lt;1990&gt;: 0.5 n^-1.5",
        "corrected: slope 2.00 (finest 2.00)",
        "Pareto front",
        "diverged at step 3 &lt;of&gt; 9",
        "edges &lt;free&gt;",
        "diffusph run a --set &#39;x=2&#39;",
        "# left out: dx 0.01",
        "scipy 1.14 50^3",
    ] {
        assert!(text.contains(part), "no `{part}`");
    }
    // Without errors there is the throughput alone.
    let mut plain = StudyReport { peers: None, ..report() };
    for point in &mut plain.points {
        point.result.iter_mut().for_each(|of| of.error = None);
    }
    assert_eq!(plain.page().expect("drawn").matches("<svg").count(), 1);
}

#[test]
fn a_picture_labels_each_point() {
    let pictures = report().pictures().expect("drawn");
    let names: Vec<&str> = pictures.iter().map(|picture| picture.name).collect();
    let expected =
        ["error_time", "error_applications", "error_spacing", "error_particles", "throughput"];
    assert_eq!(names, expected);
    let svg = &pictures[0].svg;
    let has = |label: &str| svg.lines().any(|line| line.trim() == label);
    for label in ["1", "2: dx 0.5", "3", "4", "5", "50^3", "scipy"] {
        assert!(has(label), "no label {label}");
    }
    assert!(!has("6"), "what failed has no place");
}

#[test]
fn a_law_is_a_dashed_line_that_the_axis_has_room_for() {
    let picture = |report: &StudyReport| {
        let pictures = report.pictures().expect("drawn");
        let it = pictures.into_iter().find(|picture| picture.name == "error_particles");
        it.expect("a picture").svg
    };
    let with = report();
    let without = StudyReport { reference_laws: Vec::new(), ..report() };
    let (drawn, plain) = (picture(&with), picture(&without));
    assert!(drawn.contains("theirs") && !plain.contains("theirs"));
    let lines = |svg: &str| svg.matches("<polyline").count() + svg.matches("<line").count();
    assert!(lines(&drawn) > lines(&plain) + 10, "{} and {}", lines(&drawn), lines(&plain));
    // Errors are 5e-4 to 2e-2: a law of 1 to 2 has the axis reach up to it.
    let mut far = report();
    far.reference_laws[0] =
        ReferenceLaw { factor: 4.0, order: 0.5, ..far.reference_laws[0].clone() };
    let has_one = |svg: &str| svg.lines().any(|line| line.trim() == "10⁰");
    assert!(has_one(&picture(&far)) && !has_one(&plain));
    // In three dimensions n is the third root of the number.
    assert!((with.along_an_axis(64) - 4.0).abs() < 1e-12);
    assert!((StudyReport { dimension: 1, ..report() }.along_an_axis(64) - 64.0).abs() < 1e-12);
    // A report of before there were laws is read.
    let mut json = serde_json::to_value(&with).expect("JSON");
    json.as_object_mut().expect("an object").remove("reference_laws");
    assert_eq!(serde_json::from_value::<StudyReport>(json).expect("a report"), without);
}

#[test]
fn files_of_peers_are_checked() {
    let refused = |text: &str| Peers::parse(text).expect_err(text);
    assert!(refused("{").contains("EOF"));
    let wrong = |from: &str, to: &str| refused(&PEERS.replacen(from, to, 1));
    assert!(wrong("\"peers_version\": 1", "\"peers_version\": 2").contains("must be 1"));
    assert!(wrong("[0.1, 0.3, 0.2]", "[]").contains("points[0].setup_s: must be a list of times"));
    assert!(wrong("[1.0]", "\"1\"").contains("points[0].solve_s"));
    assert!(wrong("0.0077", "-1").contains("points[0].l2_relative"));
    let peers = Peers::parse(PEERS).expect("peers");
    assert!((peers.points[0].total_s() - 1.2).abs() < 1e-12, "medians");
    assert_eq!(peers.points[0].name(), "scipy 1.14 50^3");
}

#[test]
fn the_middle_of_several_measurements() {
    assert_eq!(Spread::of([3.0, 1.0, 2.0]), Spread { median: 2.0, least: 1.0, greatest: 3.0 });
    assert_eq!(Spread::of([1.0, 2.0]).median, 1.5);
    assert!(Spread::of([]).median.is_nan());
}
