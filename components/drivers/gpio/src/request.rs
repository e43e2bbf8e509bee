//! Requests: which lines are requested from the kernel together.

use crate::config::{EncoderLines, Setting};

/// Largest number of lines of a request.
pub(crate) const MOST_TOGETHER: usize = 64;
/// Largest number of attributes of a request.
pub(crate) const MOST_ATTRIBUTES: usize = 10;
/// Number of edges that the kernel keeps for a request; it keeps no more.
pub(crate) const QUEUE: u32 = 1024;

/// Line on a chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FoundLine {
    pub(crate) chip: u32,
    pub(crate) offset: u32,
    pub(crate) setting: Setting,
}

/// Lines of one chip that are requested together, at most 64; the bit of a line is its place in the list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct LineRequest {
    pub(crate) chip: u32,
    /// Places of the lines in the list of all lines.
    pub(crate) lines: Vec<usize>,
    pub(crate) offsets: Vec<u32>,
    pub(crate) settings: Vec<Setting>,
}

impl LineRequest {
    const fn new(chip: u32) -> Self {
        Self { chip, lines: Vec::new(), offsets: Vec::new(), settings: Vec::new() }
    }

    fn push(&mut self, index: usize, line: FoundLine) {
        self.lines.push(index);
        self.offsets.push(line.offset);
        self.settings.push(line.setting);
    }

    fn has_room_for(&self, line: FoundLine) -> bool {
        let mut settings = self.settings.clone();
        settings.push(line.setting);
        settings.len() <= MOST_TOGETHER && attributes(&settings) <= MOST_ATTRIBUTES
    }

    /// Returns the bits of the lines for which `holds` is true.
    pub(crate) fn mask(&self, holds: impl Fn(&Setting) -> bool) -> u64 {
        let bit = |(at, setting): (u32, &Setting)| if holds(setting) { 1 << at } else { 0 };
        (0..64).zip(&self.settings).map(bit).sum()
    }
}

/// Returns the settings without the debounce time, each once and in order; the first is that of the request.
pub(crate) fn kinds(settings: &[Setting]) -> Vec<Setting> {
    let mut kinds: Vec<Setting> =
        settings.iter().map(|setting| Setting { debounce_us: 0, ..*setting }).collect();
    kinds.sort_unstable();
    kinds.dedup();
    kinds
}

/// Returns the debounce times, each once.
pub(crate) fn times(settings: &[Setting]) -> Vec<u32> {
    let mut times: Vec<u32> = settings.iter().map(|setting| setting.debounce_us).collect();
    times.sort_unstable();
    times.dedup();
    times.retain(|time| *time != 0);
    times
}

/// Returns the number of attributes that the kernel needs for these settings.
fn attributes(settings: &[Setting]) -> usize {
    kinds(settings).len().saturating_sub(1) + times(settings).len()
}

/// Returns the requests for all lines: one for each encoder, in their order, and as few as possible for the others.
pub(crate) fn plan(lines: &[FoundLine], encoders: &[EncoderLines]) -> Vec<LineRequest> {
    let mut requests = Vec::new();
    for encoder in encoders {
        let all = [Some(encoder.a), encoder.b, encoder.z];
        let found = all.into_iter().flatten().filter_map(|i| Some((i, *lines.get(i)?)));
        let mut request = LineRequest::new(0);
        for (index, line) in found {
            request.chip = line.chip;
            request.push(index, line);
        }
        requests.push(request);
    }
    let first = requests.len();
    for (index, line) in lines.iter().enumerate().filter(|(_, line)| !line.setting.has_edges) {
        let mut open = requests.iter_mut().skip(first);
        if let Some(request) = open.find(|r| r.chip == line.chip && r.has_room_for(*line)) {
            request.push(index, *line);
        } else {
            let mut request = LineRequest::new(line.chip);
            request.push(index, *line);
            requests.push(request);
        }
    }
    requests
}

#[cfg(test)]
mod tests {
    use super::{FoundLine, attributes, plan};
    use crate::config::{Bias, Drive, EncoderLines, Setting};

    const IN: Setting = Setting {
        is_output: false,
        is_active_low: false,
        bias: Bias::AsIs,
        drive: Drive::Both,
        debounce_us: 0,
        has_edges: false,
    };
    const OUT: Setting = Setting { is_output: true, ..IN };

    fn on(chip: u32, offset: u32, setting: Setting) -> FoundLine {
        FoundLine { chip, offset, setting }
    }

    #[test]
    fn a_chip_is_one_request_up_to_64_lines() {
        for (count, sizes) in [(1, vec![1]), (64, vec![64]), (65, vec![64, 1]), (128, vec![64, 64])]
        {
            let lines: Vec<_> =
                (0..count).map(|n| on(0, n, if n % 2 == 0 { IN } else { OUT })).collect();
            let found: Vec<_> = plan(&lines, &[]).iter().map(|r| r.lines.len()).collect();
            assert_eq!(found, sizes, "{count}");
        }
    }

    #[test]
    fn chips_and_encoders_have_requests_of_their_own() {
        let edge = Setting { has_edges: true, ..IN };
        let lines = [on(0, 5, IN), on(1, 5, OUT), on(0, 9, OUT), on(1, 2, edge), on(1, 3, edge)];
        let encoders = [EncoderLines { a: 3, b: Some(4), z: None }];
        let found: Vec<_> = plan(&lines, &encoders)
            .iter()
            .map(|r| (r.chip, r.lines.clone(), r.offsets.clone(), r.mask(|s| s.is_output)))
            .collect();
        assert_eq!(
            found,
            [
                (1, vec![3, 4], vec![2, 3], 0),
                (0, vec![0, 2], vec![5, 9], 0b10),
                (1, vec![1], vec![5], 1),
            ]
        );
    }

    /// Twelve debounce times need more than ten attributes.
    #[test]
    fn attributes_are_limited() {
        let lines: Vec<_> =
            (0..12).map(|n| on(0, n, Setting { debounce_us: 100 + n, ..IN })).collect();
        let requests = plan(&lines, &[]);
        assert_eq!(requests.iter().map(|r| r.lines.len()).collect::<Vec<_>>(), [10, 2]);
        for request in &requests {
            assert!(attributes(&request.settings) <= 10);
        }
        let mixed =
            [IN, OUT, Setting { debounce_us: 5, ..IN }, Setting { bias: Bias::PullUp, ..IN }];
        assert_eq!(attributes(&mixed), 3);
    }
}
