//! The page of `bench --limits`.

use super::{Measured, Phase, Resource, SHARE};
use crate::bench::numbers::time;
use std::fmt::Write as _;

/// The page: what was measured, and which flops and bytes are counted.
const PAGE: &str = include_str!("page.md");

pub(super) fn page(measured: &Measured) -> String {
    let peaks = measured.peaks.iter().map(|peak| {
        let [flops, bytes, written] = [peak.flops, peak.bytes, peak.written].map(|rate| 1e-9 * rate);
        format!("| {} | {flops:.1} Gflop/s | {bytes:.1} GB/s | {written:.1} GB/s |\n", peak.threads)
    });
    let phases = measured.threads().into_iter().map(|threads| {
        let head = format!("\n## {threads} thread{}\n\n", if threads == 1 { "" } else { "s" });
        head + &table(measured, threads) + &farthest(measured, threads)
    });
    PAGE.replace("{peaks}", &peaks.collect::<String>())
        .replace("{phases}", &phases.collect::<String>())
        .replace("{counts}", &counts(measured))
        .replace("{runs}", &runs(measured))
}

/// Times and fractions.
fn table(measured: &Measured, threads: usize) -> String {
    let meshes = measured.meshes();
    let mut text = String::from("| phase |");
    for what in ["time", "fraction"] {
        for (_, unknowns) in &meshes {
            let _ = write!(text, " {what}, {} |", size(*unknowns));
        }
    }
    let _ = writeln!(text, " growth |\n|---|{}", "---|".repeat(2 * meshes.len() + 1));
    for name in measured.names() {
        let _ = write!(text, "| {name} |");
        let own = || meshes.iter().map(|(cells, _)| measured.phase(name, *cells, threads));
        for phase in own() {
            let _ = write!(text, " {} |", phase.map_or("-".to_owned(), |p| time(1e9 * p.seconds[0])));
        }
        for phase in own() {
            let _ =
                write!(text, " {} |", phase.and_then(|p| fraction(measured, p)).unwrap_or("-".to_owned()));
        }
        let growth = measured.growth(name, threads).map_or("-".to_owned(), |p| format!("{p:.2}"));
        let _ = writeln!(text, " {growth} |");
    }
    text.push_str("| sum |");
    for (cells, _) in &meshes {
        let _ = write!(text, " {} |", time(1e9 * measured.total(*cells, threads)));
    }
    let _ = writeln!(text, "{}", " |".repeat(meshes.len() + 1));
    text
}

fn fraction(measured: &Measured, phase: &Phase) -> Option<String> {
    let mark = match measured.limit(phase)?.1 {
        Resource::Multiplication => "x",
        Resource::Memory => "m",
        Resource::Files => "f",
    };
    Some(format!("{:.3} {mark}", measured.fraction(phase)?))
}

fn farthest(measured: &Measured, threads: usize) -> String {
    let named = measured.farthest(threads).into_iter().map(|(phase, part)| {
        format!("**{}** ({:.1} % of its limit, {})", phase.name, 100.0 * part, time(1e9 * phase.seconds[0]))
    });
    let named: Vec<String> = named.collect();
    format!(
        "\nFarthest from their limits at the largest size, of the phases that take at least {:.0} % of the sum: {}.\n",
        100.0 * SHARE,
        named.join(", ")
    )
}

/// Operations and bytes of the phases.
fn counts(measured: &Measured) -> String {
    let meshes = measured.meshes();
    let threads = measured.threads().first().copied().unwrap_or(1);
    let mut text = String::from("\n## Counts\n\n| phase |");
    for (what, unit) in [("flops", "10⁹"), ("bytes", "10⁹")] {
        for (_, unknowns) in &meshes {
            let _ = write!(text, " {what} [{unit}], {} |", size(*unknowns));
        }
    }
    let _ = writeln!(text, "\n|---|{}", "---|".repeat(2 * meshes.len()));
    let figure = |x: f64| if x > 0.0 { format!("{:.4}", 1e-9 * x) } else { "-".to_owned() };
    for name in measured.names() {
        let _ = write!(text, "| {name} |");
        for of in [|p: &Phase| p.flops, |p: &Phase| p.bytes] {
            for (cells, _) in &meshes {
                let phase = measured.phase(name, *cells, threads);
                let _ = write!(text, " {} |", phase.map_or("-".to_owned(), |p| figure(of(p))));
            }
        }
        text.push('\n');
    }
    text
}

/// The whole runs, to compare with the sums.
fn runs(measured: &Measured) -> String {
    const PARTS: [&str; 7] =
        ["mesh", "assembly", "factorisation", "iterations", "estimate", "write", "total"];
    let mut text = String::from(
        "\n## Whole runs\n\nThe same problem in one run without interruption, one time, by its report; its assembly contains the \
         dissection, its factorisation the analysis and the condensation. Its criterion may ask for several estimates; the phases have one.\n\n\
         | cells | threads | iterations | estimates |",
    );
    for part in PARTS {
        let _ = write!(text, " {part} |");
    }
    let _ = writeln!(text, " sum of the phases |\n|---|---|---|---|{}", "---|".repeat(PARTS.len() + 1));
    for run in &measured.runs {
        let [a, b] = run.cells;
        let _ = write!(text, "| {a}x{b} | {} | {} | {} |", run.threads, run.iterations, run.estimates);
        for part in PARTS {
            let _ =
                write!(text, " {} |", run.timings[part].as_f64().map_or("-".to_owned(), |s| time(1e9 * s)));
        }
        let _ = writeln!(text, " {} |", time(1e9 * measured.total(run.cells, run.threads)));
    }
    text
}

/// Unknowns as a heading has them.
fn size(unknowns: f64) -> String {
    match unknowns {
        _ if unknowns < 1e4 => format!("{unknowns:.0}"),
        _ if unknowns < 1e6 => format!("{:.0} k", 1e-3 * unknowns),
        _ => format!("{:.1} M", 1e-6 * unknowns),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_has_times_fractions_and_counts() {
        let text = page(&super::super::tests::measured());
        assert!(text.contains("| 1 | 10.0 Gflop/s | 0.1 GB/s | 0.1 GB/s |"), "{text}");
        assert!(text.contains("| factorisation | 2.000 s | 8.000 s | 0.500 x | 0.500 x | 1.00 |"), "{text}");
        assert!(text.contains("| EET | 10.00 ms | 40.00 ms | 0.001 m | 0.001 m | 1.00 |"), "{text}");
        assert!(
            text.contains("**files** (20.0 % of its limit, 2.000 s), **factorisation** (50.0 %"),
            "{text}"
        );
        assert!(text.contains("| factorisation | 10.0000 | 40.0000 | 0.0100 | 0.0400 |"), "{text}");
        assert!(text.contains("| 8x4 | 1 | 7 | 2 | 1.500 s |"), "{text}");
    }

    #[test]
    fn unknowns_are_short() {
        assert_eq!([580.0, 12_000.0, 3.3e6].map(size), ["580", "12 k", "3.3 M"]);
    }
}
