//! Extents of previews.
#![expect(clippy::indexing_slicing, reason = "coordinates, below three")]

use pyo3::{exceptions::PyTypeError, prelude::*, types::PyTuple};

/// Coordinate of a box that holds nothing.
const NOWHERE: f64 = 9e99;

/// Lowest and highest corner of a box, first without the tool's offset, then with it.
type Corners = ([f64; 3], [f64; 3], [f64; 3], [f64; 3]);

/// `calc_extents(LIST, …)`: returns the corners of the box around all lines of previews: lowest and highest of the lines, and
/// lowest and highest with the tool's offset added. A line is (number, from, to, …, offset).
#[pyfunction]
#[pyo3(signature = (*lists))]
pub(super) fn calc_extents(lists: &Bound<'_, PyTuple>) -> PyResult<Corners> {
    let (mut low, mut high) = ([NOWHERE; 3], [-NOWHERE; 3]);
    let (mut low_tool, mut high_tool) = (low, high);
    for list in lists {
        for line in list.try_iter()? {
            let line = line?.cast_into::<PyTuple>()?;
            let last = line.len().checked_sub(1).filter(|n| *n >= 3);
            let last =
                last.ok_or_else(|| PyTypeError::new_err("a line has at least four items"))?;
            let offset: Vec<f64> = line.get_item(last)?.extract()?;
            for place in [line.get_item(1)?, line.get_item(2)?] {
                let place: Vec<f64> = place.extract()?;
                for (i, (at, add)) in place.iter().zip(&offset).take(3).enumerate() {
                    low[i] = low[i].min(*at);
                    high[i] = high[i].max(*at);
                    low_tool[i] = low_tool[i].min(at + add);
                    high_tool[i] = high_tool[i].max(at + add);
                }
            }
        }
    }
    Ok((low, high, low_tool, high_tool))
}
