//! The page of `bench --limits`.

use super::{FILES, INSIDE, Measured, Phase, REST, Resource, SHARE};
use crate::bench::numbers::time;
use std::fmt::Write as _;

/// What each phase is, and the formula of its counts. `n` unknowns, `n_c` of them on the contact line; `N` nodes, `T`
/// triangles, `E` edges.
const PHASES: [(&str, &str, &str); 16] = [
    (
        "dissection",
        "`DofMap::new`: the nested dissection and the numbers of the unknowns",
        "each cut reads number, point and neighbours of its nodes and writes their numbers: 24 + 8 E/N bytes per node and cut, by the \
         tree of this mesh. No flops: it compares",
    ),
    (
        "assembly",
        "`System::with_springs`",
        "9 blocks `A Bᵀ D B` of 54 flops per triangle; 24 T + 24 N bytes are read, 12 per entry of `K` and 12 n written",
    ),
    (
        "analysis",
        "`SymbolicCholesky::analyse`",
        "4 bytes per entry of `K` and 12 per row below a front. No flops: it sorts",
    ),
    (
        "factorisation",
        "`Cholesky::factorise`",
        "`w³/3 + w² b + w b²` flops per front of `w` columns with `b` rows below; 12 bytes per entry of `K`, 8 per value of the \
         factor, 8 `b (b + 1)` per update, which is written and read",
    ),
    (
        "condensation",
        "the rest of `CondensedBody::factorise`: smallest pivot, `S = L_CC L_CCᵀ`, substitution of the load",
        "`n_c³ + 2 v` flops, `v` values of the factor; `8 v + 24 n + 24 n_c²` bytes. `S` is made by a dense product; the zeros of \
         `L_CC` would save two thirds of it",
    ),
    (
        "iteration",
        "`nndd::solve`, as many iterations as the whole run has",
        "`2 n_c²` flops and `8 n_c²` bytes per product or pair of substitutions: 4 per Lanczos step and per iteration, 2 per set \
         of the contact problem and 1 for its residual; `f³/3 + 2 f²` flops and `16 f²` bytes per set of `f` free nodes. The \
         interior-point steps of the first iteration are not counted, nor corrections of its rounding",
    ),
    (
        "recovery",
        "`Iterate::displacements`",
        "`2 v` flops and `8 v + 32 n` bytes, `v` values of the factor without `L_CC`",
    ),
    (
        "Neumann problems",
        "`CondensedBody::displacement_from_force` and `field::stresses`",
        "`2 v` flops and `8 v + 32 n` bytes, `v` values of the factor; 36 T + 32 N bytes for the stress, whose flops are not counted",
    ),
    (
        "EET",
        "`EquilibratedStress::recover`",
        "60 T + 48 E + 16 N bytes: mesh, stress and triangles around nodes are read, moments written. Flops are not counted: the \
         geometry of a corner has many small cases",
    ),
    (
        INSIDE,
        "`EquilibratedStress::cell` and its distance to the stress of the elements, in every triangle",
        "1278 flops per triangle, 960 of them for the stress; 48 T + 48 E + 16 N bytes",
    ),
    (
        "star set-up",
        "`StarRelaxation::new`, one body after the other",
        "1866 flops per triangle and `s³` per star of `s` unknowns; `20 + 104 (s − 3) + 4 s (s + 1)` bytes per star, 12 T + 16 N for \
         the mesh. Geometry and the sums of blocks are not counted",
    ),
    (
        "star residual",
        "`StarRelaxation::relax` without a step",
        "2250 flops per triangle, 960 of them for the stress; 48 T + 48 E + 16 N bytes, 32 per unknown of the stars (3 N + E)",
    ),
    (
        "star sweeps",
        "the steps of `StarRelaxation::relax`: its time less that of the residual",
        "a step visits each star three times (the last colour twice): `45 (s − 3) + 2 s²` flops and `20 + 104 (s − 3) + 2 s (s + 1)` \
         bytes per visit; 176 bytes and 10 flops per unknown of the stars for the vectors",
    ),
    (
        "checks",
        "`check` of the admissible pair, with the Johnson-Mercier stress of every triangle",
        "960 flops per triangle for the stress, those of the residuals not counted; bytes as Johnson-Mercier",
    ),
    (
        REST,
        "`estimate_with` less the Neumann problems, EET, the stars and the checks",
        "not counted: many small steps, of which none is public alone. Among them are a second relaxation of the body that carries λ for \
         `η_dis`, `η_NNDD`, the distances and means of the triangles, and the residual for round-off",
    ),
    (FILES, "`files::write`, ParaView files included", "the bytes of the files, against the peak of files"),
];

pub(super) fn page(measured: &Measured) -> String {
    let mut text = String::from(
        "The paper's problem with the program's default settings and two steps of relaxation. A phase needs at least the longer one \
         of two times: its flops at the peak of dense multiplication, its bytes at the peak of memory streaming, with the same number \
         of threads. Its **fraction** is this limit over its time; \"x\" marks a limit of multiplication, \"m\" one of memory, \"f\" one of \
         files.\n\n| threads | multiplication | streaming | files |\n|---|---|---|---|\n",
    );
    for peak in &measured.peaks {
        let _ = writeln!(
            text,
            "| {} | {:.1} Gflop/s | {:.1} GB/s | {:.1} GB/s |",
            peak.threads,
            1e-9 * peak.flops,
            1e-9 * peak.bytes,
            1e-9 * peak.written
        );
    }
    text.push_str(
        "\n- **multiplication**: nalgebra's `gemm` of 1000x1000 matrices, which the dense factors use; each thread has matrices of \
         its own.\n- **streaming**: `a = b + s c` over three arrays of 512 MiB, 24 bytes per entry. The lines of `a` that are read \
         before they are written (write-allocate) are not counted.\n- **files**: one thread writes 256 MiB to a file in the \
         folder that the run writes to, without waiting for the disk.\n- All are the best of 24 repetitions, half of them before \
         the phases and half after.\n- A small problem stays in the cache, so a limit of memory does not hold for it and its fraction \
         may exceed 1.\n",
    );
    for threads in measured.threads() {
        let _ = writeln!(text, "\n## {threads} thread{}\n", if threads == 1 { "" } else { "s" });
        text.push_str(&table(measured, threads));
        text.push_str(&farthest(measured, threads));
    }
    text.push_str(&counts(measured));
    text.push_str(&runs(measured));
    text.push_str(&meaning());
    text
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

/// What the phases are, and their formulas.
fn meaning() -> String {
    let mut text = String::from(
        "\n## Formulas\n\n`n` unknowns of a body, `n_c` of them on the contact line; `N` nodes, `T` triangles, `E` edges. Bytes are \
         what crosses memory if the cache keeps nothing from one pass to the next, and everything within a pass. If something of a \
         phase is not counted, its true fraction is larger.\n\n\
         | phase | what is timed | flops and bytes |\n|---|---|---|\n",
    );
    for (name, what, formula) in &PHASES {
        let _ = writeln!(text, "| {name} | {what} | {formula} |");
    }
    text.push_str(
        "\n- Times are medians; a phase is repeated with its input in place and its output in new memory, so the first access to \
         that memory is part of its time. In a run the stars of the second body take the memory of the first one's.\n\
         - **growth**: the exponent of the time in the number of unknowns, between the smallest and the largest size.\n\
         - Johnson-Mercier is part of the residual of the stars and of the checks, and so not of the sum.\n\
         - Not measured: making the meshes, choosing the roles, results and bounds after the estimate; the disk; other programs at \
         work on the same machine beyond what `limits.csv` shows as range.\n\n\
         Raw numbers: `limits.csv`, with the smallest and the largest time of each phase.\n",
    );
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
