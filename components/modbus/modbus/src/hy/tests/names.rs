//! Names, types and directions, compared with those of LinuxCNC's program.

use super::HyVfd;
use hal_bench::Bench;

/// Pins and parameters that `halcmd show` lists for LinuxCNC 2.9's `hy_vfd`.
const LINUXCNC: &str = "
float OUT ACV CNST CNTR Cont DCV OutA OutF Rott SetF Tmp base-freq freq-lower-limit frequency-command max-freq
float OUT rated-motor-current rated-motor-rev rated-motor-voltage spindle-speed-fb
bit OUT CNST-bracking CNST-command-rf CNST-jog CNST-jogging CNST-run CNST-running CNST-running-rf CNST-track-start
bit OUT hycomm-ok spindle-at-speed
bit IN enable spindle-forward spindle-on spindle-reverse
float IN speed-command spindle-at-speed-tolerance
u32 OUT motor-poles
s32 RW error-count
float RW retval
";

#[test]
fn all_names_of_linuxcnc_are_there() {
    let mut bench = Bench::new();
    bench.load::<HyVfd>(&[]).unwrap();
    let names = bench.names();
    let mut seen = 0;
    for line in LINUXCNC.lines().filter(|line| !line.is_empty()) {
        let mut words = line.split(' ');
        let (ty, dir) = (words.next().unwrap(), words.next().unwrap());
        for pin in words {
            let wanted = format!("hy_vfd.{pin} {ty} {dir}");
            assert!(names.contains(&wanted), "{wanted} is not among {names:#?}");
            seen += 1;
        }
    }
    assert_eq!(seen, 37);
    let tolerance: f64 = bench.get("hy_vfd.spindle-at-speed-tolerance");
    assert_eq!(tolerance, 0.02);
}
