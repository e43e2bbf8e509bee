//! The judgement of a cut in machine time, and the table of all.

use super::eye::Seen;
use std::{collections::BTreeMap, fmt::Write as _};

/// Longest time from a cut to the begin of braking, in milliseconds.
const LIMIT_MS: f64 = 100.0;
/// Largest age of the returned number while a jog lasts, in milliseconds: 95, and the cycle that sees it.
const AGE_MS: u32 = 96;
/// Period of the servo thread in milliseconds.
const PERIOD_MS: f64 = 1.0;
/// Difference of velocities that rounding explains, in millimetres per second.
const SAME: f64 = 1e-6;
/// Acceleration of X in millimetres per second squared.
const ACCELERATION: f64 = 1350.0;

/// A jog that was cut.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub(super) way: &'static str,
    /// Detail of the cut.
    note: String,
    speed: f64,
    /// Time within which the test made the cut, in milliseconds.
    cut_ms: f64,
    /// Time from the begin of the cut to the begin of braking, and to rest, in milliseconds.
    braking_ms: f64,
    rest_ms: f64,
    /// Age of the returned number when the braking began, in milliseconds.
    age: u32,
    distance: f64,
    most: f64,
    /// Time by which the computer's own lateness exceeded a period, in milliseconds.
    late_ms: f64,
}

/// Judges the samples of a cut, from the last before it to the rest. `after` is the place of the first sample that is
/// known to be later than the cut.
///
/// # Errors
/// The jog lasted too long, or went too far.
pub(super) fn judge(
    way: &'static str,
    note: String,
    seen: &[Seen],
    after: usize,
) -> Result<Row, String> {
    let ms = |from: &Seen, to: &Seen| (to.ns - from.ns) as f64 * 1e-6;
    let first = &seen[0];
    let speed = first.v.abs();
    let begin = seen.iter().position(|s| s.v.abs() < speed - SAME).ok_or("it does not brake")?;
    let rest = begin + seen[begin..].iter().position(|s| s.v == 0.0).ok_or("it does not rest")?;
    // A computer that gives the servo thread no processor makes it late; the joint stands still meanwhile.
    let gaps = seen[..=rest].windows(2).map(|pair| ms(&pair[0], &pair[1]) - PERIOD_MS);
    let late_ms = gaps.filter(|gap| PERIOD_MS < *gap).fold(0.0, |sum, gap| sum + gap);
    // The time that the test itself needed for the cut.
    let unsure_ms = ms(first, &seen[after.min(rest)]);
    let row = Row {
        way,
        note,
        speed,
        cut_ms: unsure_ms,
        braking_ms: ms(first, &seen[begin]),
        rest_ms: ms(first, &seen[rest]),
        age: seen[begin].age,
        distance: (seen[rest].x - first.x).abs(),
        most: speed * (LIMIT_MS + unsure_ms + late_ms) * 1e-3
            + speed * speed / (2.0 * ACCELERATION),
        late_ms,
    };
    // Motion takes the stop in the same cycle, and its status shows it one cycle later.
    let oldest = seen[..begin].iter().map(|s| s.age).max().unwrap_or(0);
    let allowed = f64::from(AGE_MS) + late_ms + PERIOD_MS;
    if f64::from(oldest) > allowed {
        return Err(format!("the jog lasted with a number {oldest} ms old: {row:?}"));
    }
    let limit = LIMIT_MS + unsure_ms + late_ms;
    if row.braking_ms > limit || row.distance > row.most {
        return Err(format!("braking began later than {limit} ms, or it went too far: {row:?}"));
    }
    Ok(row)
}

/// Returns the table of all cuts, and a summary by their ways.
pub(super) fn table(rows: &[Row], repeated: u32) -> String {
    let mut ways: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    for row in rows {
        ways.entry(row.way).or_default().push(row);
    }
    let most =
        |rows: &[&Row], value: fn(&Row) -> f64| rows.iter().map(|r| value(r)).fold(0.0, f64::max);
    let mut text = format!(
        "# Cuts of the connection during a held jog of X\n\n\
         {} cuts, judged in machine time by samples of every servo cycle. Each ended the jog within {LIMIT_MS} ms and the\n\
         braking; nothing moved after the reconnect. Times count from the sample before the cut. *Cut* is the time within which the\n\
         test made it: that of a tab that is closed or hidden is long. *Late* is the time for which the computer gave the servo thread no\n\
         processor, which is not counted. {repeated} jogs ended before their cut because the computer was busy, and were repeated.\n\n\
         | cut | number | longest cut, ms | longest to braking, ms | longest to rest, ms | farthest, mm | share of what is allowed | late, ms |\n\
         |---|---|---|---|---|---|---|---|\n",
        rows.len()
    );
    for (way, rows) in &ways {
        writeln!(
            text,
            "| {way} | {} | {:.1} | {:.1} | {:.1} | {:.2} | {:.0} % | {:.1} |",
            rows.len(),
            most(rows, |r| r.cut_ms),
            most(rows, |r| r.braking_ms),
            most(rows, |r| r.rest_ms),
            most(rows, |r| r.distance),
            most(rows, |r| 100.0 * r.distance / r.most),
            most(rows, |r| r.late_ms),
        )
        .unwrap();
    }
    text.push_str("\n| | cut | mm/s | cut, ms | to braking, ms | to rest, ms | age, ms | distance, mm | allowed, mm | late, ms |\n|---|---|---|---|---|---|---|---|---|---|\n");
    for (n, r) in rows.iter().enumerate() {
        writeln!(
            text,
            "| {} | {}{} | {:.0} | {:.1} | {:.1} | {:.1} | {} | {:.3} | {:.3} | {:.1} |",
            n + 1,
            r.way,
            r.note,
            r.speed,
            r.cut_ms,
            r.braking_ms,
            r.rest_ms,
            r.age,
            r.distance,
            r.most,
            r.late_ms
        )
        .unwrap();
    }
    text
}

#[test]
fn a_jog_that_goes_on_is_judged_so() {
    let jog = |beats_ms: i64, cut_ms: i64| -> Vec<Seen> {
        let (mut x, mut v, mut seen) = (0.0, 60.0, Vec::new());
        for ms in 0..400_i64 {
            let beat = beats_ms.min(ms);
            if ms >= cut_ms {
                v = f64::max(0.0, v - 1.35);
            }
            x += v * 1e-3;
            seen.push(Seen { ns: ms * 1_000_000, age: u32::try_from(ms - beat).unwrap(), x, v });
        }
        seen
    };
    let row = judge("a cut", String::new(), &jog(0, 96), 1).unwrap();
    assert!((row.braking_ms - 96.0).abs() < 1e-9 && (6.5..7.2).contains(&row.distance), "{row:?}");
    // Beats go on, but the jog outlasts the limit; and the number is too old.
    assert!(judge("a cut", String::new(), &jog(90, 130), 1).unwrap_err().contains("later than"));
    assert!(
        judge("a cut", String::new(), &jog(0, 130), 1).unwrap_err().contains("130 ms old")
            || judge("a cut", String::new(), &jog(0, 130), 1).unwrap_err().contains("129 ms old")
    );
    assert!(
        judge("a cut", String::new(), &jog(0, 1000), 1).unwrap_err().contains("does not brake")
    );
    // The same, on a computer that ran nothing for 50 ms.
    let mut late = jog(0, 130);
    late.drain(40..90);
    judge("a cut", String::new(), &late, 1).unwrap();
}
