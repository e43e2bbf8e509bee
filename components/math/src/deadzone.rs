//! `deadzone`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// A number that stays at its centre while it is near.
#[derive(Component)]
pub(crate) struct Deadzone {
    /// The number.
    in_: In<f64>,
    /// `center` within the zone; beyond it, the number less half of its width.
    out: Out<f64>,
    /// The middle of the zone.
    center: ParamRw<f64>,
    /// The width of the zone.
    #[hal(default = 1.0)]
    threshold: ParamRw<f64>,
}

impl Update for Deadzone {
    fn update(&mut self, _: Period) {
        let (x, center, half) = (self.in_.get(), self.center.get(), self.threshold.get() / 2.0);
        self.out.set(if x < center - half {
            x + half
        } else if x > center + half {
            x - half
        } else {
            center
        });
    }
}

#[cfg(test)]
mod tests {
    use super::Deadzone;
    use hal_component::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Deadzone>(include_str!("../traces/deadzone.txt")), 85);
    }
}
