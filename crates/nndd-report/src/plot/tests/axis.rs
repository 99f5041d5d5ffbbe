//! Axes and their numbers.

use crate::plot::axis::{Axis, short};

#[test]
fn ticks_are_readable() {
    let written = |axis: Axis| -> Vec<String> { axis.major().iter().map(|m| m.1.clone()).collect() };
    assert_eq!(written(Axis::linear(0.0, 1.0, 5)), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
    assert_eq!(written(Axis::linear(0.0, 3e-7, 3)), ["0", "1e-7", "2e-7", "3e-7"]);
    assert_eq!(written(Axis::log(1e-4, 1.0, 8)), ["1e-4", "1e-3", "1e-2", "1e-1", "1e0"]);
    assert_eq!(written(Axis::log(0.09, 1.1, 8)), ["1e-1", "2e-1", "5e-1", "1e0"]);
    assert_eq!(written(Axis::whole(1, 4, 12)), ["1", "2", "3", "4"]);
    for (lo, hi) in [(1.0, 1.0), (0.0, 0.0), (-1e100, 1e100), (1e9, 1e9 + 1e-7), (0.0, 1e-160)] {
        let ticks = written(Axis::padded(lo, hi, 8)).len();
        assert!((2..=20).contains(&ticks), "{ticks} ticks between {lo} and {hi}");
    }
    for (lo, hi) in [(1.0, 1.0), (1e-100, 1e100), (0.95, 1.0), (2.0, 2.0000001), (3.0, 30.0)] {
        let ticks = written(Axis::log_padded(lo, hi, 8)).len();
        assert!((2..=20).contains(&ticks), "{ticks} ticks between {lo} and {hi}");
    }
}

#[test]
fn short_numbers() {
    for (value, text) in
        [(0.0, "0"), (0.45, "0.45"), (5.0, "5"), (1e5, "1e5"), (2.5e-7, "2.5e-7"), (-12.345, "-12.35")]
    {
        assert_eq!(short(value), text);
    }
}
