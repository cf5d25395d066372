//! The study as a command: what it measures, what it finds, what it writes, and bad input. Nothing
//! here asserts a speed.

use std::fs;
use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::{Arc, Mutex};

use serde_json::Value;

/// The report's lattice at coarser spacings, against one point source, with its own step.
const CURVE: [&str; 6] = [
    "--set",
    "exact={\"name\":\"point_source_in_box\"}",
    "--set",
    "output={}",
    "--set",
    "time.step=116800*spacing^2",
];

/// One run of each setting, and time enough for all of them.
const ONCE: [&str; 6] = ["--backend", "cpu", "--repeat", "1", "--budget", "10min"];

fn diffusph(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_diffusph"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the binary starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("output is UTF-8")
}

/// The report of a study that must succeed, having said nothing else.
fn study(folder: &Path, arguments: &[&str]) -> Value {
    let output = diffusph(folder, &[&["study"], arguments, &["--json"]].concat());
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    assert!(output.stderr.is_empty(), "no progress but to a terminal: {}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("standard output is the report alone")
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().unwrap_or_else(|| panic!("no list {key} in {value}"))
}

fn number(value: &Value, pointer: &str) -> f64 {
    value.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("no {pointer}"))
}

fn order<'a>(report: &'a Value, varies: &str, series: &str) -> &'a Value {
    let is_it = |order: &&Value| order["varies"] == varies && order["series"] == series;
    let found = list(report, "orders").iter().find(is_it);
    found.unwrap_or_else(|| panic!("no order of {series} over {varies} in {}", report["orders"]))
}

#[test]
fn the_error_curve_of_the_gaussian_has_order_two_with_the_correction_alone() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let vary = ["--vary", "correction=none,moment", "--vary", "spacing=50/20,50/26,50/36,50/50"];
    let flags = ["--no-output"];
    let report = study(folder.path(), &[&["gaussian"], &CURVE[..], &ONCE, &vary, &flags].concat());
    assert_eq!((&report["study_version"], &report["case"]), (&1.into(), &"gaussian".into()));
    let slope = |series: &str| number(order(&report, "spacing", series), "/all/l2_relative");
    assert!((slope("corrected") - 2.0).abs() <= 0.05, "corrected: {}", slope("corrected"));
    // It is 0 below a spacing of 0.6 m alone, where nothing is left but the error of Deff.
    assert!(slope("plain") < 1.0, "plain: {}", slope("plain"));
    let finest = number(order(&report, "spacing", "plain"), "/finest/l2_relative");
    assert!(finest < 0.35, "plain, finest: {finest}");
    let against = report["against"].as_str().expect("errors are against something");
    assert!(against.contains("point_source_in_box"), "{against}");
    for point in list(&report, "points") {
        // The parts add up, and Deff has one where nothing corrects it.
        let split = &point["result"]["split"]["probes"][0];
        let parts = list(split, "parts");
        let sum: f64 = parts.iter().map(|part| number(part, "/value")).sum();
        let all = number(split, "/value") - number(split, "/exact");
        assert!((sum - all).abs() < 1e-12, "{sum:e} and {all:e}");
        let deff = parts.iter().find(|part| part["name"] == "Deff").expect("a part");
        let is_plain = point["label"].as_str().is_some_and(|label| label.starts_with("plain"));
        let expected = if is_plain { -0.0293 } else { 0.0 };
        let found = number(deff, "/relative");
        assert!((found - expected).abs() < 1e-3, "{}: {found}", point["label"]);
    }
    assert!(!folder.path().join("out").exists(), "--no-output writes nothing");
}

#[test]
fn a_wrong_kernel_is_found_out() {
    // The correction takes the moment of the support that it is told: with a wider one in its place
    // the plain sum has another Deff, and the curve another floor.
    let folder = tempfile::tempdir().expect("a temporary folder");
    let vary = ["--vary", "support_ratio=2,2.6", "--vary", "correction=none"];
    let set = ["--set", "particles.spacing=1"];
    let report = study(
        folder.path(),
        &[&["gaussian"], &CURVE[..], &set, &ONCE, &vary, &["--no-output"]].concat(),
    );
    let deff = |index: usize| {
        let parts = list(&report["points"][index]["result"]["split"]["probes"][0], "parts");
        number(parts.iter().find(|part| part["name"] == "Deff").expect("a part"), "/relative")
    };
    // Deff / D is 1.0200 at H/dx = 2 and .99348 at 2.6.
    let mut found = [deff(0), deff(1)];
    found.sort_by(f64::total_cmp);
    assert!((found[0] + 0.0293).abs() < 2e-4 && (found[1] - 0.0098).abs() < 3e-4, "{found:?}");
}

#[test]
fn steps_have_their_order_in_time() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let of = |method: &str| {
        let step = ["--vary", "step=2*year/60,2*year/120,2*year/240"];
        let method = format!("method={method}");
        let vary = ["--vary", &method];
        let flags =
            [&["gaussian_small", "--no-output"], &CURVE[2..4], &ONCE[..], &vary, &step].concat();
        let report = study(folder.path(), &flags);
        list(&report, "orders").iter().find(|of| of["varies"] == "step").cloned().expect("an order")
    };
    let euler = number(&of("euler"), "/time_part");
    assert!((euler - 1.0).abs() < 0.05, "euler: {euler}");
    let heun = number(&of("heun"), "/time_part");
    assert!((heun - 2.0).abs() < 0.1, "heun: {heun}");
}

#[test]
fn what_is_written_is_read_back_and_repeats() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let vary = ["--vary", "spacing=48/12,48/16", "--vary", "correction=none,moment"];
    let flags = ["--backend", "cpu", "--repeat", "2", "--out", "s", "--vary", "path=list,lattice"];
    let report = study(folder.path(), &[&["gaussian_small"], &vary[..], &flags].concat());
    let points = list(&report, "points");
    assert_eq!(points.len(), 8);
    let read = |name: &str| fs::read_to_string(folder.path().join("s").join(name)).expect(name);
    let json: Value = serde_json::from_str(&read("study.json")).expect("JSON");
    assert_eq!(json, report, "study.json is what --json prints");
    let lines = read("study.csv");
    let mut table = csv::Reader::from_reader(lines.as_bytes());
    let header: Vec<String> =
        table.headers().expect("a header").iter().map(str::to_owned).collect();
    let rows: Vec<csv::StringRecord> = table.records().map(|row| row.expect("a row")).collect();
    assert_eq!(rows.len(), points.len());
    let column = |name: &str| header.iter().position(|column| column == name).expect(name);
    for (row, point) in rows.iter().zip(points) {
        let result = &point["result"];
        let cell = |name: &str| row[column(name)].parse::<f64>().expect(name);
        assert_eq!(cell("l2_relative"), number(result, "/error/l2_relative"));
        assert_eq!(cell("solve_s"), number(result, "/solve_s/median"));
        assert_eq!(row[column("path")], *result["path"].as_str().expect("a path"));
        let runs = list(result, "runs");
        assert_eq!(runs.len(), 3, "a warm-up and two that count");
        assert_eq!((&runs[0]["warm_up"], &runs[1]["warm_up"]), (&true.into(), &false.into()));
    }
    // The command of a point gives its very error.
    let point = &points[5];
    let command = point["command"].as_str().expect("a command");
    let arguments: Vec<&str> = command.split(' ').skip(1).chain(["--json"]).collect();
    let again = diffusph(folder.path(), &arguments);
    let again: Value = serde_json::from_slice(&again.stdout).expect("a report");
    assert_eq!(number(&again, "/error/l2_relative"), number(point, "/result/error/l2_relative"));
    let page = read("study.html");
    for outside in ["http", "src=", "url(", "@import", "<script", "<link"] {
        assert!(!page.contains(outside), "{outside} in the page");
    }
    assert!(page.contains(&command.replace('\'', "&#39;")), "the page has the command");
    for name in
        ["error_time", "error_applications", "error_spacing", "error_particles", "throughput"]
    {
        assert!(read(&format!("{name}.svg")).contains("</svg>"), "{name}");
    }
    assert_eq!(page.matches("<svg").count(), 5);
    assert!(!page.contains("poster"), "nothing is known elsewhere of this case");
}

#[test]
fn the_rod_is_far_below_the_law_that_is_known_of_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flags = ["--backend", "cpu", "--repeat", "1", "--budget", "20s", "--out", "s"];
    let report = study(folder.path(), &[&["rod"], &flags[..]].concat());
    let [law] = list(&report, "reference_laws") else { panic!("{}", report["reference_laws"]) };
    let (factor, order_of_law) = (number(law, "/factor"), number(law, "/order"));
    assert_eq!((factor, order_of_law), (0.0715, 0.75));
    let measured = list(&report, "points").iter().filter(|point| !point["result"].is_null());
    let errors: Vec<(f64, f64)> = measured
        .map(|point| (number(point, "/particles"), number(point, "/result/error/l2_relative")))
        .collect();
    assert!(errors.len() >= 12, "{}", errors.len());
    for (n, error) in errors {
        assert!(error < 0.5 * factor * n.powf(-order_of_law), "n = {n}: {error:e}");
    }
    let series = "euler at 0.2 dx2/alpha, corrected";
    let slope = number(order(&report, "spacing", series), "/all/l2_relative");
    assert!((slope - 2.0).abs() < 0.1, "{slope}");
    let picture = fs::read_to_string(folder.path().join("s/error_particles.svg")).expect("drawn");
    let page = fs::read_to_string(folder.path().join("s/study.html")).expect("the page");
    assert!(picture.contains("poster: 0.0715 n^-0.75") && page.contains("poster: 0.0715 n^-0.75"));
    // What the user varies is another study: nothing is known of it.
    let vary = ["--vary", "spacing=0.1/20,0.1/40", "--no-output", "--repeat", "1"];
    let own = study(folder.path(), &[&["rod", "--backend", "cpu"], &vary[..]].concat());
    assert!(list(&own, "reference_laws").is_empty());
}

#[test]
fn what_there_is_no_time_for_is_left_out_and_said_so() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flags = ["--backend", "cpu", "--budget", "3s", "--no-output"];
    let vary = ["--vary", "spacing=48/12,0.25", "--vary", "step=116800*spacing^2"];
    let report = study(folder.path(), &[&["gaussian_small"], &flags[..], &vary].concat());
    assert_eq!(list(&report, "points").len(), 1, "{report}");
    let [skipped] = list(&report, "skipped") else { panic!("{}", report["skipped"]) };
    let why = skipped["why"].as_str().expect("a reason");
    assert!(why.contains("of the time allowed"), "{why}");
    assert!(number(skipped, "/expected_s") > 3.0, "{skipped}");
    assert!(skipped["command"].as_str().is_some_and(|command| command.contains("spacing=0.25")));
    assert!(number(&report, "/elapsed_s") < 10.0, "{}", report["elapsed_s"]);
}

#[test]
fn what_fails_is_kept_with_its_error() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flags = ["gaussian_small", "--no-output"];
    let vary = ["--vary", "step=467200,9e6"];
    let report = study(folder.path(), &[&flags[..], &ONCE, &vary].concat());
    let failed: Vec<&Value> =
        list(&report, "points").iter().filter(|point| point["result"].is_null()).collect();
    let [failed] = failed[..] else { panic!("{}", report["points"]) };
    let why = failed["failure"].as_str().expect("a reason");
    assert!(why.contains("limit"), "{why}");
    let only = ["study", "gaussian_small", "--no-output", "--backend", "cpu", "--vary", "step=9e6"];
    let output = diffusph(folder.path(), &only);
    assert_eq!(output.status.code(), Some(1), "nothing ran");
    assert!(text(&output.stderr).contains("no setting has a result"), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("failed: "), "{}", text(&output.stdout));
}

#[test]
fn without_an_exact_solution_the_finest_run_counts_and_that_is_said() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flags = [
        "gaussian_small",
        "--no-output",
        "--set",
        "exact=null",
        "--set",
        "operator.correction=moment",
    ];
    let vary = ["--vary", "spacing=48/12,48/16,48/24,48/32"];
    let report = study(folder.path(), &[&flags[..], &CURVE[2..], &ONCE, &vary].concat());
    let against = report["against"].as_str().expect("errors are against something");
    assert!(against.contains("finest run, number 4") && against.contains("no exact"), "{against}");
    let errors: Vec<&Value> =
        list(&report, "points").iter().map(|point| &point["result"]["error"]).collect();
    assert!(errors[3].is_null(), "the finest has none of its own");
    assert!(errors[..3].iter().all(|error| number(error, "/l2_relative") > 0.0));
    let why = report["points"][0]["result"]["no_split"].as_str().expect("a reason");
    assert!(why.contains("no exact solution"), "{why}");
}

#[test]
fn other_programs_are_beside_and_it_is_said_where_they_win() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let peers = r#"{"peers_version": 1, "machine": "two cores", "points": [
        {"tool": "an oracle", "version": "1", "command": "ask", "setting": "32^3", "particles": 1,
         "setup_s": [1e-6], "solve_s": [1e-6, 2e-6], "l2_relative": 1e-9, "against": "the truth"}]}"#;
    fs::write(folder.path().join("peers.json"), peers).expect("written");
    let flags =
        ["study", "gaussian_small", "--with", "peers.json", "--vary", "spacing=48/12,48/16"];
    let output = diffusph(folder.path(), &[&flags[..], &ONCE, &["--out", "s"]].concat());
    let table = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    for part in
        ["an oracle 1 32^3 WINS", "No setting here is as fast and as accurate as: an oracle"]
    {
        assert!(table.contains(part), "no `{part}` in\n{table}");
    }
    let page = fs::read_to_string(folder.path().join("s/study.html")).expect("the page");
    assert!(page.contains("an oracle 1 32^3 WINS") && page.contains("two cores"));
}

#[test]
fn bad_input_is_refused_with_what_is_wrong() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(
        folder.path().join("bad.json"),
        r#"{"peers_version": 7, "machine": "", "points": []}"#,
    )
    .expect("written");
    for (flags, named) in [
        (&["no_such_case"][..], &["no_such_case"][..]),
        (&["gaussian_smal"], &["did you mean \"gaussian_small\""]),
        (&["gaussian_small", "--vary", "spacng=1"], &["spacng", "did you mean \"spacing\""]),
        (&["gaussian_small", "--vary", "spacing"], &["name=value,value"]),
        (&["gaussian_small", "--vary", "method=eulr,rkl2"], &["eulr", "did you mean \"euler\""]),
        (&["gaussian_small", "--vary", "precision=f23"], &["f23", "did you mean \"f32\""]),
        (&["gaussian_small", "--vary", "time.stp=1"], &["time.stp", "did you mean \"step\""]),
        (&["gaussian_small", "--vary", "spacing=-1"], &["particles.spacing", "must be positive"]),
        (&["gaussian_small", "--budget", "soon"], &["--budget", "soon"]),
        (&["gaussian_small", "--repeat", "0"], &["--repeat"]),
        (&["gaussian_small", "--with", "bad.json"], &["bad.json", "peers_version", "must be 1"]),
        (&["gaussian_small", "--with", "none.json"], &["--with", "none.json"]),
        (&["gaussian_small", "--backend", "cpu", "--precision", "f32"], &["f64 only"]),
    ] {
        let output = diffusph(folder.path(), &[&["study"], flags].concat());
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{flags:?}: {message}");
        assert!(output.stdout.is_empty(), "{flags:?}: {}", text(&output.stdout));
        for part in named {
            assert!(message.contains(part), "{flags:?}: no `{part}` in {message}");
        }
        assert!(!folder.path().join("out").exists(), "{flags:?} left files");
    }
}

#[test]
#[cfg(unix)]
fn an_interrupted_study_writes_what_there_is() {
    use std::process::Stdio;
    use std::time::{Duration, Instant};

    let folder = tempfile::tempdir().expect("a temporary folder");
    let flags = ["study", "gaussian_small", "--vary", "spacing=48/12,48/16,48/24", "--out", "s"];
    let child = Command::new(env!("CARGO_BIN_EXE_diffusph"))
        .args(flags)
        .args(["--backend", "cpu", "--repeat", "1000", "--budget", "1h"])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary starts");
    std::thread::sleep(Duration::from_secs(3));
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.expect("kill starts").success());
    let asked = Instant::now();
    let output = child.wait_with_output().expect("it ends");
    assert!(asked.elapsed() < Duration::from_secs(20));
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("interrupted"), "{}", text(&output.stderr));
    let report = fs::read_to_string(folder.path().join("s/study.json")).expect("it is written");
    let report: Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(report["interrupted"], true);
    assert!(!list(&report, "points").is_empty(), "what was measured is kept");
}

/// The requests that come to a proxy, one line each.
struct Proxy {
    port: u16,
    requests: Arc<Mutex<Vec<String>>>,
}

impl Proxy {
    fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let port = listener.local_addr().expect("it has an address").port();
        let requests = Arc::new(Mutex::new(Vec::new()));
        let kept = Arc::clone(&requests);
        // It ends with the test.
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let mut line = String::new();
                // A browser may connect and ask for nothing.
                let read = BufReader::new(stream).read_line(&mut line);
                if read.is_ok_and(|length| length > 0) {
                    kept.lock().expect("no thread fails").push(line);
                }
            }
        });
        Self { port, requests }
    }

    /// What came so far, but for what a browser asks its maker.
    fn taken(&self) -> Vec<String> {
        let own = ["google.com", "googleapis.com", "gvt1.com", "gstatic.com"];
        let requests = self.requests.lock().expect("no thread fails");
        let of_page = requests.iter().filter(|line| !own.iter().any(|host| line.contains(host)));
        of_page.cloned().collect()
    }
}

/// What a browser says of a page on its console, and how many pictures it shows.
fn browse(browser: &str, page: &Path, profile: &Path, proxy: &Proxy) -> (Vec<String>, usize) {
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"])
        .args(["--disable-background-networking", "--disable-component-update"])
        .args(["--enable-logging=stderr", "--virtual-time-budget=2000", "--dump-dom"])
        .arg(format!("--proxy-server=127.0.0.1:{}", proxy.port))
        .arg("--proxy-bypass-list=<-loopback>")
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("the browser starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let log = String::from_utf8_lossy(&output.stderr).into_owned();
    let console = log.lines().filter(|line| line.contains("CONSOLE")).map(str::to_owned);
    (console.collect(), text(&output.stdout).matches("<svg").count())
}

/// Where there is a Chromium, the page is opened in it. Elsewhere the other tests are all there is.
#[test]
fn a_browser_shows_the_page_and_fetches_nothing() {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let starts = |name: &&&str| Command::new(name).arg("--version").output().is_ok();
    let Some(browser) = names.iter().find(starts) else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flags = ["gaussian_small", "--out", "s", "--vary", "spacing=48/12,48/16"];
    study(folder.path(), &[&flags[..], &ONCE].concat());
    let (proxy, profile) = (Proxy::start(), folder.path().join("profile"));
    let page = folder.path().join("s/study.html");
    assert_eq!(browse(browser, &page, &profile, &proxy), (Vec::new(), 5));
    assert_eq!(proxy.taken(), Vec::<String>::new(), "nothing is fetched");
    // A page that says something and fetches something is noticed.
    let other = folder.path().join("other.html");
    let loud = "<img src=\"http://example.invalid/a.png\"><script>console.error(1)</script>";
    fs::write(&other, loud).expect("written");
    assert_eq!(browse(browser, &other, &profile, &proxy).0.len(), 1);
    assert!(
        proxy.taken().iter().any(|line| line.contains("example.invalid")),
        "{:?}",
        proxy.taken()
    );
}
