//! `cargo xtask bench`: criterion suites and whole-process timings, written to `bench-results/<date>-<machine>/`.

use crate::workspace::{Outcome, Workspace, output, read, stream};
use clap::Args;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Instant, SystemTime};

/// What `bench` takes from the command line.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Let criterion stop as soon as its estimate settles
    #[arg(long)]
    quick: bool,
    /// Time 1280x640 cells per body as well: minutes, and several GiB of memory
    #[arg(long)]
    large: bool,
}

impl Arguments {
    fn flags(&self) -> String {
        let flags = [(self.quick, " --quick"), (self.large, " --large")];
        flags.into_iter().filter_map(|(given, flag)| given.then_some(flag)).collect()
    }
}

/// The case timed as a whole process, as it is and on finer meshes with the program's default settings.
const CASE: &str = "tests/cases/paper.toml";
/// Cells per body of the finer meshes; the last one only when asked for.
const CELLS: [[usize; 2]; 5] = [[18, 9], [80, 36], [320, 160], [640, 320], [1280, 640]];
/// Settings that undo the paper's, so that the defaults are timed.
const DEFAULTS: [&str; 6] = [
    "solver.imposed=auto",
    "solver.theta=auto",
    "solver.weights=stiffness",
    "solver.acceleration=anderson",
    "estimator.every=0",
    "output.vtu=false",
];
/// The parts of a run's time, as report.json names them.
const PHASES: [&str; 7] = ["mesh", "assembly", "factorisation", "iterations", "estimate", "write", "total"];
/// How often each is timed, after one run that is thrown away.
const RUNS: usize = 5;
/// GNU time, which reports the peak memory of a process.
const TIME: &str = "/usr/bin/time";
/// The packages whose versions decide the numbers.
const NUMERIC: [&str; 4] = ["faer", "clarabel", "nalgebra", "rayon"];
/// What a reader must not look for in these numbers.
const NOT_MEASURED: &str = "\
- compile times, and the first run after a build (one run is thrown away; files are in the page cache);
- scaling with the number of threads: every run uses the program's default;
- other machines, other compilers, other sizes than the cases named;
- other programs at work on the same machine, beyond what shows as spread.
";

/// One benchmark of criterion, times in nanoseconds.
#[derive(Debug, PartialEq)]
struct Estimate {
    name: String,
    median: f64,
    lower: f64,
    upper: f64,
    level: f64,
}

/// Repeated runs of the program on one case.
#[derive(Debug, PartialEq)]
struct Process {
    case: String,
    /// Wall times in seconds, ascending.
    seconds: Vec<f64>,
    /// Peak memory in kibibytes, ascending; empty where it could not be measured.
    memory: Vec<f64>,
    /// Median seconds of each of [`PHASES`].
    phases: Vec<f64>,
}

/// The cases of whole processes: what they are called, and the settings they need.
fn cases(large: bool) -> Vec<(String, Vec<String>)> {
    let mut cases = vec![("paper.toml".to_owned(), Vec::new())];
    let meshes = if large { CELLS.len() } else { CELLS.len() - 1 };
    for [nx, ny] in &CELLS[..meshes] {
        let cells = (0..2).map(|body| format!("body.{body}.generator.cells=[{nx},{ny}]"));
        let settings = cells.chain(DEFAULTS.iter().map(|s| (*s).to_owned())).collect();
        cases.push((format!("{nx}x{ny} cells per body, defaults"), settings));
    }
    cases
}

/// Runs the suites and writes the results.
pub(crate) fn run(workspace: &Workspace, arguments: &Arguments) -> Outcome<()> {
    let started = SystemTime::now();
    // All of the workspace at once, with the features the tests use: otherwise each crate compiles its own numeric stack.
    let mut command = workspace.cargo(&["bench", "--workspace"]);
    for bench in workspace.packages.iter().filter(|p| p.is_crate()).flat_map(|p| &p.benches) {
        command.args(["--bench", bench]);
    }
    if arguments.quick {
        command.args(["--", "--quick"]);
    }
    if stream(&mut command)? != Some(0) {
        return Err("a benchmark failed".to_owned());
    }
    let mut files = vec![];
    find_estimates(&workspace.target.join("criterion"), started, &mut files);
    let mut estimates = files.iter().map(|f| estimate_at(f)).collect::<Outcome<Vec<_>>>()?;
    estimates.sort_by(|a, b| a.name.cmp(&b.name));

    if stream(&mut workspace.cargo(&["build", "--release", "--bin", "nndd"]))? != Some(0) {
        return Err("the program does not build".to_owned());
    }
    let processes = cases(arguments.large)
        .iter()
        .map(|(name, settings)| time_process(workspace, name, settings))
        .collect::<Outcome<Vec<_>>>()?;

    let machine = Machine::look();
    let date = jiff::Timestamp::now().strftime("%Y-%m-%d").to_string();
    let folder = workspace.root.join("bench-results").join(format!("{date}-{}", machine.slug()));
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", workspace.shown(&folder)))?;
    let readme = readme(workspace, arguments, &date, &machine, &estimates, &processes)?;
    for (name, text) in [
        ("README.md", readme),
        ("criterion.csv", criterion_csv(&estimates)),
        ("whole-process.csv", process_csv(&processes)),
        ("phases.csv", phases_csv(&processes)),
    ] {
        let path = folder.join(name);
        std::fs::write(&path, text).map_err(|e| format!("{}: {e}", workspace.shown(&path)))?;
        println!("wrote {}", workspace.shown(&path));
    }
    print!("\n{}", summary(&estimates, &processes));
    Ok(())
}

/// Collects the files `new/estimates.json` below a folder that were written since `started`.
fn find_estimates(folder: &Path, started: SystemTime, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.filter_map(Result::ok).map(|e| e.path()) {
        if path.is_dir() {
            find_estimates(&path, started, found);
        } else if path.ends_with("new/estimates.json") {
            let written = path.metadata().and_then(|m| m.modified());
            if written.is_ok_and(|w| w >= started) {
                found.push(path);
            }
        }
    }
}

/// Reads an estimate and, from the file beside it, its name.
fn estimate_at(path: &Path) -> Outcome<Estimate> {
    let about = read(&path.with_file_name("benchmark.json"))?;
    parse_estimate(&about, &read(path)?).map_err(|e| format!("{}: {e}", path.display()))
}

/// Reads criterion's `benchmark.json` and `estimates.json`.
fn parse_estimate(benchmark: &str, estimates: &str) -> Outcome<Estimate> {
    let benchmark: Value = serde_json::from_str(benchmark).map_err(|e| e.to_string())?;
    let estimates: Value = serde_json::from_str(estimates).map_err(|e| e.to_string())?;
    let median = &estimates["median"];
    let interval = &median["confidence_interval"];
    let number =
        |v: &Value, key: &str| v[key].as_f64().ok_or_else(|| format!("found no number {key} of the median"));
    Ok(Estimate {
        name: benchmark["full_id"].as_str().ok_or("found no full_id")?.to_owned(),
        median: number(median, "point_estimate")?,
        lower: number(interval, "lower_bound")?,
        upper: number(interval, "upper_bound")?,
        level: number(interval, "confidence_level")?,
    })
}

/// Times the program on one case: once thrown away, then wall times, then peak memory where GNU time is there.
fn time_process(workspace: &Workspace, case: &str, settings: &[String]) -> Outcome<Process> {
    let out = workspace.target.join("bench");
    std::fs::create_dir_all(&out).map_err(|e| format!("{}: {e}", workspace.shown(&out)))?;
    let run = |mut command: Command| -> Outcome<(f64, String)> {
        command
            .current_dir(&workspace.root)
            .args(["solve", CASE])
            .args(settings.iter().flat_map(|setting| ["--set", setting]))
            .arg("--out")
            .arg(&out)
            .args(["--force", "--quiet"]);
        let start = Instant::now();
        let done = command.stdin(Stdio::null()).output().map_err(|e| format!("nndd: {e}"))?;
        let seconds = start.elapsed().as_secs_f64();
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        if done.status.success() {
            Ok((seconds, said))
        } else {
            Err(format!("{case}: {}: {}", done.status, said.trim()))
        }
    };
    println!("timing {case}");
    run(Command::new(workspace.nndd()))?;
    let mut seconds = vec![];
    let mut phases = vec![vec![]; PHASES.len()];
    for _ in 0..RUNS {
        seconds.push(run(Command::new(workspace.nndd()))?.0);
        let report: Value = serde_json::from_str(&read(&out.join("report.json"))?)
            .map_err(|e| format!("report.json of {case}: {e}"))?;
        for (times, phase) in phases.iter_mut().zip(PHASES) {
            times.extend(report["timings"][phase].as_f64());
        }
    }
    let middle = |mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        spread(&times).map_or(f64::NAN, |[median, ..]| median)
    };
    let phases = phases.into_iter().map(middle).collect();
    let mut memory = vec![];
    if Path::new(TIME).exists() {
        for _ in 0..RUNS {
            let mut command = Command::new(TIME);
            command.arg("-v").arg(workspace.nndd());
            // Not every program of this name is GNU's; then there is no number.
            memory.extend(run(command).ok().and_then(|(_, said)| peak_memory(&said)));
        }
    }
    seconds.sort_by(f64::total_cmp);
    memory.sort_by(f64::total_cmp);
    Ok(Process { case: case.to_owned(), seconds, memory, phases })
}

/// The peak memory in kibibytes in what GNU time says.
fn peak_memory(said: &str) -> Option<f64> {
    let line = said.lines().find(|l| l.trim().starts_with("Maximum resident set size"))?;
    line.rsplit(':').next()?.trim().parse().ok()
}

/// The middle of some ascending numbers, with the smallest and the largest.
fn spread(sorted: &[f64]) -> Option<[f64; 3]> {
    let n = sorted.len();
    let median = 0.5 * (sorted.get(n.checked_sub(1)? / 2)? + sorted.get(n / 2)?);
    Some([median, *sorted.first()?, *sorted.last()?])
}

/// The machine, without its name.
struct Machine {
    model: String,
    cores: usize,
}

impl Machine {
    fn look() -> Machine {
        let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        Machine { model: cpu_model(&info).unwrap_or("unknown processor").to_owned(), cores }
    }

    /// A short name for a folder, such as `xeon-2c`.
    fn slug(&self) -> String {
        let plain = self.model.to_lowercase().replace("(r)", " ").replace("(tm)", " ");
        let dull = |w: &str| {
            ["intel", "amd", "cpu", "processor", "with", "graphics", "core", "unknown"].contains(&w)
                || w.ends_with("ghz")
                || w.ends_with("-core")
        };
        let words = plain.split(|c: char| !c.is_ascii_alphanumeric() && c != '-' && c != '.');
        let kept: Vec<String> =
            words.filter(|w| !w.is_empty() && !dull(w)).take(4).map(|w| w.replace('.', "-")).collect();
        let name = if kept.is_empty() { "cpu".to_owned() } else { kept.join("-") };
        format!("{name}-{}c", self.cores)
    }
}

/// The processor's name in the text of `/proc/cpuinfo`.
fn cpu_model(info: &str) -> Option<&str> {
    let line = info.lines().find(|l| l.starts_with("model name"))?;
    line.split_once(':').map(|(_, name)| name.trim()).filter(|name| !name.is_empty())
}

/// Versions of some packages in the text of `Cargo.lock`, in the order asked for.
fn locked_versions(lock: &str, names: &[&str]) -> Outcome<Vec<(String, String)>> {
    let lock: toml::Table = lock.parse().map_err(|e| format!("Cargo.lock: {e}"))?;
    let packages = lock.get("package").and_then(toml::Value::as_array).map_or(&[][..], Vec::as_slice);
    let text = |p: &toml::Value, key: &str| p.get(key).and_then(toml::Value::as_str).map(str::to_owned);
    let versions_of = |name: &str| -> String {
        let found: Vec<String> = packages
            .iter()
            .filter(|p| text(p, "name").as_deref() == Some(name))
            .filter_map(|p| text(p, "version"))
            .collect();
        if found.is_empty() { "none".to_owned() } else { found.join(" and ") }
    };
    Ok(names.iter().map(|n| ((*n).to_owned(), versions_of(n))).collect())
}

/// The page that says what was measured, where and how.
fn readme(
    workspace: &Workspace,
    arguments: &Arguments,
    date: &str,
    machine: &Machine,
    estimates: &[Estimate],
    processes: &[Process],
) -> Outcome<String> {
    let commit =
        output(&mut workspace.git(&["rev-parse", "HEAD"])).map_or("none".to_owned(), |h| h.trim().to_owned());
    let tree = match output(&mut workspace.git(&["status", "--porcelain"])) {
        Ok(changes) if changes.trim().is_empty() => "clean",
        Ok(_) => "with uncommitted changes",
        Err(_) => "unknown",
    };
    let rustc = output(Command::new("rustc").arg("--version"))?;
    let cargo = output(&mut workspace.cargo(&["--version"]))?;
    let versions = locked_versions(&read(&workspace.root.join("Cargo.lock"))?, &NUMERIC)?;
    let versions: Vec<String> = versions.into_iter().map(|(n, v)| format!("{n} {v}")).collect();
    let mut text = format!("# Benchmarks of {date} on {}\n\n", machine.slug());
    let rows = [
        ("command", format!("`cargo xtask bench{}`", arguments.flags())),
        ("commit", format!("{commit}, tree {tree}")),
        ("compiler", format!("{}, {}", rustc.trim(), cargo.trim())),
        ("packages", versions.join(", ")),
        ("processor", format!("{}, {} cores available", machine.model, machine.cores)),
    ];
    text.push_str("| what | value |\n|---|---|\n");
    for (what, value) in rows {
        let _ = writeln!(text, "| {what} | {value} |");
    }
    let _ = write!(text, "\n## Summary\n\n{}", summary(estimates, processes));
    let _ = write!(text, "\n## Noise\n\n{}", noise(estimates, processes));
    let _ = write!(text, "\n## Not measured\n\n{NOT_MEASURED}");
    if processes.iter().any(|p| p.memory.is_empty()) {
        text.push_str("- peak memory: GNU time was not there.\n");
    }
    text.push_str(
        "\nRaw numbers: `criterion.csv` (nanoseconds), `whole-process.csv` (seconds, kibibytes), \
         `phases.csv` (seconds).\n",
    );
    Ok(text)
}

/// The two tables of results.
fn summary(estimates: &[Estimate], processes: &[Process]) -> String {
    let mut text = String::from(
        "| whole process | median | smallest | largest | peak memory |\n|---|---|---|---|---|\n",
    );
    for p in processes {
        let [median, least, most] =
            spread(&p.seconds).map_or(["-"; 3].map(str::to_owned), |s| s.map(|t| time(t * 1e9)));
        let memory =
            spread(&p.memory).map_or("not measured".to_owned(), |m| format!("{:.1} MiB", m[0] / 1024.0));
        let _ = writeln!(text, "| {} | {median} | {least} | {most} | {memory} |", p.case);
    }
    let _ = writeln!(
        text,
        "\n| phases, median s | {} |\n|---{}|",
        PHASES.join(" | "),
        "|---".repeat(PHASES.len())
    );
    for p in processes {
        let times: Vec<String> = p.phases.iter().map(|t| format!("{t:.4}")).collect();
        let _ = writeln!(text, "| {} | {} |", p.case, times.join(" | "));
    }
    if estimates.is_empty() {
        text.push_str("\nNo crate has a criterion suite.\n");
        return text;
    }
    text.push_str("\n| criterion | median | confidence interval |\n|---|---|---|\n");
    for e in estimates {
        let name = e.name.replace('|', "\\|");
        let _ = writeln!(
            text,
            "| {name} | {} | {} to {} ({:.0} %) |",
            time(e.median),
            time(e.lower),
            time(e.upper),
            100.0 * e.level
        );
    }
    text
}

/// How far repeated measurements lie apart.
fn noise(estimates: &[Estimate], processes: &[Process]) -> String {
    let mut text = String::new();
    for p in processes {
        if let Some([median, least, most]) = spread(&p.seconds) {
            let percent = 100.0 * (most - least) / median;
            let _ = writeln!(
                text,
                "- `{}`: {} to {} over {} runs, {percent:.1} % of the median. Smaller differences say nothing.",
                p.case,
                time(least * 1e9),
                time(most * 1e9),
                p.seconds.len()
            );
        }
    }
    let widest = estimates.iter().max_by(|a, b| width(a).total_cmp(&width(b)));
    if let Some(e) = widest {
        let _ = writeln!(
            text,
            "- criterion: the widest confidence interval is {:.1} % of its median ({}).",
            100.0 * width(e),
            e.name
        );
    }
    text
}

fn width(e: &Estimate) -> f64 {
    (e.upper - e.lower) / e.median
}

/// Nanoseconds as a reader likes them.
fn time(ns: f64) -> String {
    match ns {
        _ if ns < 1e3 => format!("{ns:.1} ns"),
        _ if ns < 1e6 => format!("{:.2} µs", ns * 1e-3),
        _ if ns < 1e9 => format!("{:.2} ms", ns * 1e-6),
        _ => format!("{:.3} s", ns * 1e-9),
    }
}

fn criterion_csv(estimates: &[Estimate]) -> String {
    let mut text = String::from("benchmark,median_ns,lower_ns,upper_ns,confidence_level\n");
    for e in estimates {
        let _ = writeln!(text, "{},{},{},{},{}", quoted(&e.name), e.median, e.lower, e.upper, e.level);
    }
    text
}

fn process_csv(processes: &[Process]) -> String {
    let mut text = String::from("case,quantity,unit,median,smallest,largest,runs\n");
    for p in processes {
        for (quantity, unit, values) in [("wall time", "s", &p.seconds), ("peak memory", "KiB", &p.memory)] {
            if let Some([median, least, most]) = spread(values) {
                let _ = writeln!(
                    text,
                    "{},{quantity},{unit},{median},{least},{most},{}",
                    quoted(&p.case),
                    values.len()
                );
            }
        }
    }
    text
}

/// A field of a comma-separated table, in quotes where it needs them.
/// The phases of every case, median seconds.
fn phases_csv(processes: &[Process]) -> String {
    let mut text = format!("case,{}\n", PHASES.map(|phase| format!("{phase} [s]")).join(","));
    for p in processes {
        let times: Vec<String> = p.phases.iter().map(|t| format!("{t:.6}")).collect();
        let _ = writeln!(text, "{},{}", quoted(&p.case), times.join(","));
    }
    text
}

fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate() -> Estimate {
        let benchmark = r#"{"group_id": "condense", "full_id": "condense/body, fine"}"#;
        let estimates = r#"{"mean": {"point_estimate": 9.0},
            "median": {"confidence_interval": {"confidence_level": 0.95, "lower_bound": 1150.5, "upper_bound": 1250.0},
                       "point_estimate": 1200.25, "standard_error": 3.0}}"#;
        parse_estimate(benchmark, estimates).unwrap()
    }

    #[test]
    fn estimates_are_read() {
        let expected = Estimate {
            name: "condense/body, fine".into(),
            median: 1200.25,
            lower: 1150.5,
            upper: 1250.0,
            level: 0.95,
        };
        assert_eq!(estimate(), expected);
    }

    #[test]
    fn estimates_without_a_median_are_refused() {
        assert!(parse_estimate(r#"{"full_id": "a"}"#, r#"{"mean": {}}"#).is_err());
        assert!(parse_estimate("{}", r#"{"median": {}}"#).is_err());
        assert!(parse_estimate("{", "{}").is_err());
    }

    #[test]
    fn estimates_are_found_by_age() {
        let folder = std::env::temp_dir().join(format!("xtask-estimates-{}", std::process::id()));
        let new = folder.join("group").join("name").join("new");
        std::fs::create_dir_all(&new).unwrap();
        std::fs::write(new.join("estimates.json"), "{}").unwrap();
        let count = |since| {
            let mut found = vec![];
            find_estimates(&folder, since, &mut found);
            found.len()
        };
        assert_eq!(count(SystemTime::UNIX_EPOCH), 1);
        assert_eq!(count(SystemTime::now() + std::time::Duration::from_secs(3600)), 0);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn spread_of_few_numbers() {
        assert_eq!(spread(&[]), None);
        assert_eq!(spread(&[2.0]), Some([2.0; 3]));
        assert_eq!(spread(&[1.0, 2.0, 4.0, 9.0]), Some([3.0, 1.0, 9.0]));
        assert_eq!(spread(&[1.0, 2.0, 9.0]), Some([2.0, 1.0, 9.0]));
    }

    #[test]
    fn machines_have_short_names() {
        let slug = |model: &str, cores| Machine { model: model.into(), cores }.slug();
        assert_eq!(slug("Intel(R) Xeon(R) Processor", 2), "xeon-2c");
        assert_eq!(slug("Intel(R) Xeon(R) Platinum 8375C CPU @ 2.90GHz", 8), "xeon-platinum-8375c-8c");
        assert_eq!(slug("AMD EPYC 7B13", 4), "epyc-7b13-4c");
        assert_eq!(slug("unknown processor", 1), "cpu-1c");
        assert_eq!(cpu_model("processor : 0\nmodel name\t: A B\n"), Some("A B"));
        assert_eq!(cpu_model("processor : 0\n"), None);
    }

    #[test]
    fn peak_memory_is_read_from_gnu_time() {
        let said = "\tElapsed (wall clock) time (h:mm:ss or m:ss): 0:00.10\n\tMaximum resident set size (kbytes): 20480\n";
        assert_eq!(peak_memory(said), Some(20480.0));
        assert_eq!(peak_memory("usage: time"), None);
    }

    #[test]
    fn versions_are_read_from_the_lock_file() {
        let lock = "[[package]]\nname = \"faer\"\nversion = \"0.24.4\"\n[[package]]\nname = \"rayon\"\nversion = \"1.12.0\"\n";
        let found = locked_versions(lock, &["faer", "clarabel"]).unwrap();
        assert_eq!(found, [("faer".into(), "0.24.4".into()), ("clarabel".into(), "none".into())]);
    }

    #[test]
    fn tables_hold_every_result() {
        let processes = [Process {
            case: "paper.toml".into(),
            seconds: vec![0.1, 0.12, 0.2],
            memory: vec![],
            phases: vec![],
        }];
        let text = summary(&[estimate()], &processes);
        assert!(text.contains("| 120.00 ms | 100.00 ms | 200.00 ms | not measured |"), "{text}");
        assert!(text.contains("| condense/body, fine | 1.20 µs | 1.15 µs to 1.25 µs (95 %) |"), "{text}");
        assert!(criterion_csv(&[estimate()]).ends_with("\"condense/body, fine\",1200.25,1150.5,1250,0.95\n"));
        assert_eq!(process_csv(&processes).lines().count(), 2);
        assert!(noise(&[estimate()], &processes).contains("83.3 %"));
        assert!(summary(&[], &processes).contains("No crate has a criterion suite"));
    }
}
