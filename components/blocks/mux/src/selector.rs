//! Selector made of a number and bits, with a debounce time.
use hal_component::{Builder, Error, In, ParamRo, Period, Touch};

/// Pins of the selector, and its selection.
#[derive(Touch)]
pub(crate) struct Selector {
    number: In<u32>,
    bits: Vec<In<bool>>,
    suppress: In<bool>,
    debounce: In<u32>,
    elapsed: ParamRo<u32>,
    selected: ParamRo<u32>,
}

/// Returns the number of selector bits for `n` inputs: 0 unless `n` is a power of two, or one more.
fn bits_for(n: u32) -> u32 {
    let fits = n.is_power_of_two() || (n > 1 && (n - 1).is_power_of_two());
    if fits { n.ilog2() } else { 0 }
}

impl Selector {
    /// Declares the pins for one of `n` inputs.
    pub(crate) fn declare(b: &mut Builder<'_>, name: &str, n: u32) -> Result<Self, Error> {
        let mut bits = Vec::new();
        for i in 0..bits_for(n) {
            let doc = format!("Adds {} to `sel-int`.", 1_u32 << i);
            bits.push(b.item(&format!("{name}.sel-bit-{i:02}"), &doc, false)?);
        }
        let doc = "Number to select, from 0; a number beyond the last selects the last.";
        let number = b.item(&format!("{name}.sel-int"), doc, 0)?;
        let doc = "True keeps the selection while all selectors are 0.";
        let suppress = b.item(&format!("{name}.suppress-no-input"), doc, false)?;
        let doc = "Time for which the selectors must stay the same before they take effect, in \
            microseconds.";
        let debounce = b.item(&format!("{name}.debounce-us"), doc, 0)?;
        let doc = "Time for which the selectors have differed from the selection, in microseconds.";
        let elapsed = b.item(&format!("{name}.elapsed"), doc, 0)?;
        let selected =
            b.item(&format!("{name}.selected"), "Number of the current selection.", 0)?;
        Ok(Self { number, bits, suppress, debounce, elapsed, selected })
    }

    /// Returns the active selection; `None` means that nothing changes.
    pub(crate) fn chosen(&self, period: Period) -> Option<usize> {
        let bits = self.bits.iter().enumerate();
        let bits = bits.fold(0, |n, (i, bit)| n | u32::from(bit.get()) << i);
        let now = self.number.get().wrapping_add(bits);
        if self.suppress.get() && now == 0 {
            return None;
        }
        if now == self.selected.get() {
            self.elapsed.set(0);
        } else {
            let elapsed = self.elapsed.get();
            if elapsed < self.debounce.get() {
                let run = u32::try_from(period.ns() / 1000).unwrap_or(u32::MAX);
                self.elapsed.set(elapsed.saturating_add(run));
                return None;
            }
            self.selected.set(now);
            self.elapsed.set(0);
        }
        Some(usize::try_from(self.selected.get()).unwrap_or(usize::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::bits_for;

    #[test]
    fn bits_where_they_choose_all_or_all_but_the_last() {
        let all: Vec<u32> = (2..=17).map(bits_for).collect();
        assert_eq!(all, [1, 1, 2, 2, 0, 0, 3, 3, 0, 0, 0, 0, 0, 0, 4, 4]);
        assert_eq!(bits_for(1024), 10);
    }
}
