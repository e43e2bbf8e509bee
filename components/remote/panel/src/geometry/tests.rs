//! Geometry of small programs.

use super::{Geometry, distance, read};

/// Returns the geometry of a program.
fn of(name: &str, text: &str, tolerance: f64) -> Geometry {
    let folder = std::env::temp_dir().join(format!("panel-geometry-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join(name);
    std::fs::write(&file, text).unwrap();
    let geometry = read(None, &file, tolerance);
    std::fs::remove_file(&file).unwrap();
    geometry.unwrap()
}

fn word<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    bytes[at..at + N].try_into().unwrap()
}

#[test]
fn bytes_are_laid_out_as_the_document_says() {
    let program = "G21 G90\nG0 X10 Y20\nG1 F300 Z-1\nG38.3 Z-3\nM2\n";
    let bytes = of("layout.ngc", program, 0.0).bytes();
    assert_eq!(word(&bytes, 0), *b"FERPATH1");
    let n = u32::from_le_bytes(word(&bytes, 8)) as usize;
    assert_eq!((n, u32::from_le_bytes(word(&bytes, 12))), (4, 1));
    assert_eq!(bytes.len(), 64 + 23 * n);
    let origin = [16, 24, 32].map(|at| f64::from_le_bytes(word(&bytes, at)));
    let place = |point: usize| {
        [0, 1, 2].map(|i| {
            let near = f32::from_le_bytes(word(&bytes, 64 + 12 * point + 4 * i));
            f64::from(near) + origin[i]
        })
    };
    assert_eq!(place(0), [0.0, 0.0, 0.0]);
    assert_eq!(place(1), [10.0, 20.0, 0.0]);
    assert_eq!(place(3), [10.0, 20.0, -3.0]);
    let line = |point: usize| u32::from_le_bytes(word(&bytes, 64 + 12 * n + 4 * point));
    assert_eq!([0, 1, 2, 3].map(line), [0, 2, 3, 4]);
    let feed = |point: usize| f32::from_le_bytes(word(&bytes, 64 + 16 * n + 4 * point));
    assert_eq!([1, 2].map(feed), [0.0, 300.0]);
    let tool = |point: usize| u16::from_le_bytes(word(&bytes, 64 + 20 * n + 2 * point));
    assert_eq!([1, 2].map(tool), [0, 0]);
    assert_eq!(bytes[64 + 22 * n..], [0, 1, 2, 4]);
}

#[test]
fn points_are_left_out_within_the_tolerance() {
    let mut program = "G21 G90 F100\n".to_owned();
    for i in 0..1000_u32 {
        let x = f64::from(i) * 0.1;
        program += &format!("G1 X{x:.4} Y{:.6}\n", (x * 0.1).sin() * 5.0);
    }
    let whole = of("whole.ngc", &program, 0.0);
    let less = of("less.ngc", &program, 0.05);
    assert!(less.points.len() * 4 < whole.points.len(), "{}", less.points.len());
    assert!(less.reduced && !whole.reduced);
    assert_eq!(less.points.last(), whole.points.last());
    for point in &whole.points {
        let near = less.points.windows(2).map(|pair| distance(point.at, pair[0].at, pair[1].at));
        assert!(near.fold(f64::INFINITY, f64::min) <= 0.05 + 1e-9, "{point:?}");
    }
}

#[test]
fn a_program_with_an_error_has_what_precedes_it() {
    let geometry = of("error.ngc", "G21 G90\nG1 F100 X1\nG1 X(\nX3\n", 0.0);
    assert_eq!(geometry.points.len(), 2);
    assert!(!geometry.whole);
    assert_eq!(geometry.error.map(|(line, _)| line), Some(3));
}

#[test]
fn offsets_of_the_tool_and_further_axes_are_told() {
    let program = "G21 G90 F100\nG43.1 Z5\nG0 X1\nX2\nG43.1 Z5\nX3\nG49\nG0 X0\nM2\n";
    let geometry = of("offset.ngc", program, 0.0);
    assert_eq!(geometry.changes(), [(1, [0.0, 0.0, 5.0]), (4, [0.0; 3])]);
    let bytes = geometry.bytes();
    let (n, at) = (geometry.points.len(), (64 + 23 * geometry.points.len()).next_multiple_of(4));
    assert_eq!((n, bytes.len()), (5, at + 32));
    assert_eq!(u32::from_le_bytes(word(&bytes, 12)), 1);
    assert_eq!([at, at + 16].map(|at| u32::from_le_bytes(word(&bytes, at))), [1, 4]);
    assert_eq!(f32::from_le_bytes(word(&bytes, at + 12)), 5.0);
    // Points are not left out across a change.
    assert_eq!(of("across.ngc", program, 0.05).changes().len(), 2);
    // B moves: bit 1 of A B C U V W, from bit 2 on.
    let turns = of("turns.ngc", "G21 G90 F100\nG1 X1\nB3\nM2\n", 0.0).bytes();
    assert_eq!(u32::from_le_bytes(word(&turns, 12)), 1 | 1 << 3);
}
