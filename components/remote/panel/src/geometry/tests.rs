//! Geometry of small programs.

use super::{Cut, Geometry, Limit, Wishes, distance, is_cutter, planned, read};
use hal_job::world;
use std::path::Path;

/// Returns the geometry of a program.
fn of(name: &str, text: &str, tolerance: f64) -> Geometry {
    let folder = std::env::temp_dir().join(format!("panel-geometry-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join(name);
    std::fs::write(&file, text).unwrap();
    let wishes = Wishes { tolerance, ..Wishes::default() };
    let geometry = read(None, &file, world::program(&file).unwrap(), wishes, &mut |_| Ok(()));
    std::fs::remove_file(&file).unwrap();
    geometry.unwrap()
}

/// Calls a function with the cell of an arm and a cutter-location file.
fn in_cell<T>(name: &str, text: &str, look: impl FnOnce(&Path, &Path) -> T) -> T {
    let folder = std::env::temp_dir().join(format!("panel-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (cell, file) = (folder.join("cell.conf"), folder.join("part.apt"));
    std::fs::write(&cell, "[ARM]\nMODEL = rx90\n[PART]\nFRAME = 500 -100 -100 0 0 30\n").unwrap();
    std::fs::write(&file, text).unwrap();
    let found = look(&cell, &file);
    std::fs::remove_dir_all(&folder).unwrap();
    found
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
    assert_eq!(u32::from_le_bytes(word(&turns, 12)), 1 | 1 << 3 | 1 << 8);
}

#[test]
fn further_axes_and_joints_follow_the_kinds() {
    let bytes = of("five.ngc", "G21 G90 F100\nG1 X1\nB3 U2\nC-5\nM2\n", 0.0).bytes();
    let n = 4;
    assert_eq!(u32::from_le_bytes(word(&bytes, 8)), n);
    // B, C and U move, and all six follow.
    let flags = u32::from_le_bytes(word(&bytes, 12));
    assert_eq!(flags, 1 | (0b00_1110 << 2) | 1 << 8);
    let first = (64 + 23 * n as usize).next_multiple_of(4);
    assert_eq!(bytes.len(), first + 24 * n as usize);
    let of_point = |point: usize| {
        [0, 1, 2, 3, 4, 5].map(|k| f32::from_le_bytes(word(&bytes, first + 24 * point + 4 * k)))
    };
    assert_eq!(of_point(1), [0.0; 6]);
    assert_eq!(of_point(2), [0.0, 3.0, 0.0, 2.0, 0.0, 0.0]);
    assert_eq!(of_point(3), [0.0, 3.0, -5.0, 2.0, 0.0, 0.0]);
    // Points between which an axis turns are not left out.
    let turns = "G21 G90 F100\nG1 X1\nX2 B1\nX3 B2\nX4 B5\nM2\n";
    assert_eq!(of("turns.ngc", turns, 0.5).points.len(), 5);
}

#[test]
fn a_cutter_location_file_has_the_joints_of_its_arm() {
    let text = "CUTTER/6,3\nFROM/0,0,100\nFEDRAT/600,MMPM\nGOTO/20,20,0\nFINI\n";
    assert!(is_cutter("a.APT") && is_cutter("b.c.cl") && !is_cutter("a.ngc") && !is_cutter("apt"));
    let [none, cut, inch] = in_cell("cutter", text, |cell, file| {
        [(None, false), (Some(cell), false), (Some(cell), true)]
            .map(|(cell, is_inch)| Cut::read(cell, file, &std::fs::read(file).unwrap(), is_inch))
    });
    assert!(none.unwrap_err().contains("--cell"));
    let (cut, inch) = (cut.unwrap(), inch.unwrap());
    assert_eq!(serde_json::json!(cut.cutters)[0]["diameter"], 6.0);
    assert_eq!(serde_json::json!(cut.cutters)[0]["is_ball"], true);
    assert_eq!(cut.frame[5].round(), 30.0);
    assert!((inch.frame[0] * 25.4 - cut.frame[0]).abs() < 1e-9);
    let (bytes, n) = (cut.geometry.bytes(), cut.geometry.points.len());
    assert_eq!(u32::from_le_bytes(word(&bytes, 12)), 1 | 0b111 << 2 | 0b11 << 8);
    let first = (64 + 23 * n).next_multiple_of(4);
    assert_eq!(bytes.len(), first + 48 * n);
    let joints = |point: usize| {
        [0, 1, 2, 3, 4, 5]
            .map(|k| f64::from(f32::from_le_bytes(word(&bytes, first + 24 * (n + point) + 4 * k))))
    };
    // The joints bring the tip to each point.
    let arm = hal_arm::Arm::RX90;
    for (n, point) in cut.geometry.points.iter().enumerate() {
        let tip = arm.flange(&joints(n)).origin;
        assert!((tip - hal_arm::rotation::Vector::from(point.at)).norm() < 1e-3, "{point:?}");
    }
    // 600 mm/min on the way down; the approach and the retract are rapid.
    let kinds: Vec<u8> = cut.geometry.points.iter().map(|p| p.kind).collect();
    assert!(kinds.contains(&2) && kinds.last() == Some(&1), "{kinds:?}");
    assert!(cut.geometry.points.iter().all(|p| p.kind != 2 || (p.feed - 600.0).abs() < 0.1));
}

#[test]
fn a_step_that_only_turns_the_tool_is_no_rapid_move() {
    let text = "FROM/0,0,100\nMULTAX/ON\nFEDRAT/600,MMPM\nGOTO/20,20,0,0,0,1\n\
                GOTO/20,20,0,0.3,0,0.95\nFINI\n";
    let cut = in_cell("turn", text, |cell, file| {
        Cut::read(Some(cell), file, &std::fs::read(file).unwrap(), false)
    })
    .unwrap();
    let turns: Vec<_> = cut.geometry.points.iter().filter(|p| p.line == 5 && p.kind != 1).collect();
    let stands = turns.windows(2).filter(|pair| pair[0].at == pair[1].at);
    assert!(stands.clone().count() > 1, "{turns:?}");
    assert!(stands.clone().all(|pair| pair[1].kind == 2 && pair[1].feed > 0.0), "{turns:?}");
}

#[test]
fn a_program_without_an_end_is_read_as_long_as_it_may_be() {
    let folder = std::env::temp_dir().join(format!("panel-endless-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for (name, text) in [
        ("quiet.ngc", "o1 repeat [2000000000]\no1 endrepeat\nM2\n"),
        ("moves.ngc", "G21 G91\no1 repeat [2000000000]\nG0 X1\nG0 X-1\no1 endrepeat\nM2\n"),
        ("call.ngc", "o<a> sub\no2 while [1]\nG4 P0\no2 endwhile\no<a> endsub\no<a> call\nM2\n"),
    ] {
        let file = folder.join(name);
        std::fs::write(&file, text).unwrap();
        let (mut looks, mut most) = (0, 0);
        let read =
            read(None, &file, world::program(&file).unwrap(), Wishes::default(), &mut |bytes| {
                looks += 1;
                most = most.max(bytes);
                if looks > 20 { Err(Limit::Gone) } else { Ok(()) }
            });
        let geometry = read.unwrap();
        assert!(looks <= 21 && geometry.error.is_some(), "{name}: {looks}");
        assert!(most < 32 << 20, "{name}: {most} bytes");
        let kept = geometry.points.len() * size_of::<super::Point>();
        assert!(geometry.memory() >= kept && geometry.memory() >= geometry.bytes().len(), "{name}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

const RATES: &str = "MAX_VELOCITY = 150\nMAX_ACCELERATION = 1500\n";

/// Returns the planned path of a program on a machine whose X, Y and Z have these lines.
fn planned_path(
    name: &str,
    axes: &str,
    program: &str,
    look: &mut dyn FnMut(usize) -> Result<(), Limit>,
) -> Geometry {
    let folder = std::env::temp_dir().join(format!("panel-planned-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let [ini, file] = ["m.ini", "p.ngc"].map(|file| folder.join(file));
    let text = format!(
        "[TRAJ]\nCOORDINATES = XYZ\nLINEAR_UNITS = mm\n[AXIS_X]\n{axes}[AXIS_Y]\n{axes}[AXIS_Z]\n{axes}"
    );
    std::fs::write(&ini, text).unwrap();
    std::fs::write(&file, program).unwrap();
    let wishes = Wishes { is_planned: true, tolerance: 0.0 };
    let geometry = read(Some(&ini), &file, world::program(&file).unwrap(), wishes, look);
    std::fs::remove_dir_all(&folder).unwrap();
    geometry.unwrap()
}

/// At a corner the planned path is as far inside as motion passes it (`components/motion/motion/CORNERS.md`), and its points have the
/// lines, kinds and feeds of the program.
#[test]
fn a_planned_path_is_rounded_as_motion_rounds_it() {
    let tail = "G1 X40\nY40\nG0 Z5\nM2\n";
    // On the exact path the corner is within 0.002 of both lines.
    let exact = 2e-3 * 2.0_f64.sqrt() + 1e-9;
    for (name, mode, [least, most]) in
        [("exact", "G61", [0.0, exact]), ("free", "G64", [0.015, 0.036])]
    {
        let program = format!("G21 G90 {mode} F600\n{tail}");
        let path = planned_path(name, RATES, &program, &mut |_| Ok(()));
        assert!(path.whole && path.error.is_none(), "{:?}", path.error);
        let missed = path.points.iter().map(|p| (p.at[0] - 40.0).hypot(p.at[1]));
        let missed = missed.fold(f64::INFINITY, f64::min);
        assert!((least..=most).contains(&missed), "{mode}: {missed}");
        let [first, .., last] = path.points.as_slice() else { panic!("{:?}", path.points) };
        assert_eq!((first.at, first.kind, first.line), ([0.0; 3], 0, 0));
        assert_eq!((last.at, last.kind, last.line, last.feed), ([40.0, 40.0, 5.0], 1, 4, 0.0));
        let cut = &path.points[1];
        assert_eq!((cut.kind, cut.line, cut.feed), (2, 2, 600.0));
        assert!(path.points.len() < 100, "{}", path.points.len());
    }
}

#[test]
fn without_the_limits_of_the_axes_nothing_is_planned() {
    let path = planned_path("none", "", "G21 G90 F600\nG1 X40\nY40\nM2\n", &mut |_| Ok(()));
    assert_eq!(path.points.len(), 0);
    assert_eq!(path.error, Some((0, planned::UNKNOWN.to_owned())));
}

/// The plan itself counts as memory, and it ends with its request.
#[test]
fn a_planned_path_ends_with_its_request() {
    let program: String = (1..5000).map(|n| format!("G1 X{} Y{}\n", n % 7, n % 5)).collect();
    let mut looks = Vec::new();
    let path =
        planned_path("ended", RATES, &format!("G21 G90 F600\n{program}M2\n"), &mut |bytes| {
            looks.push(bytes);
            if looks.len() > 20 { Err(Limit::Gone) } else { Ok(()) }
        });
    assert_eq!(looks.len(), 21);
    assert_eq!(path.error.map(|(_, why)| why), Some(Limit::Gone.to_string()));
    assert!(path.points.len() < 5000 && looks.last() > looks.first(), "{looks:?}");
}
