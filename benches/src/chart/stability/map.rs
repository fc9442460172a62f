//! Values over a grid of cells.

use response::stability::Scheme;

use crate::chart::axes::Axis;

/// Division of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// By value.
    Linear,
    /// By decimal logarithm.
    Logarithmic,
}

/// An axis of cells of equal width from `low` to `high`, which are values or their logarithms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridAxis {
    /// Name, with the unit in brackets.
    pub label: &'static str,
    /// Division.
    pub scale: Scale,
    /// Start of the first cell.
    pub low: f64,
    /// End of the last cell.
    pub high: f64,
    /// Number of cells.
    pub cells: u32,
}

impl GridAxis {
    /// Returns the axis of a panel.
    #[must_use]
    pub fn axis(&self) -> Axis {
        let range = [self.low, self.high];
        match (self.scale, self.high - self.low) {
            (Scale::Logarithmic, length) => {
                let step = if length >= 4.0 { 2.0 } else { 1.0 };
                Axis::new(self.label, range, step, |place| format!("1e{place:.0}"))
            }
            (Scale::Linear, length) => {
                let step = if length >= 3.0 {
                    1.0
                } else if length >= 1.0 {
                    0.5
                } else {
                    0.1
                };
                Axis::new(self.label, range, step, |place| format!("{place:.1}"))
            }
        }
    }

    /// Returns the start of a cell on the axis; for `cells`, the end of the last one.
    #[must_use]
    pub fn edge(&self, cell: u32) -> f64 {
        self.low + f64::from(cell) * self.width()
    }

    /// Returns the width of a cell on the axis.
    #[must_use]
    pub fn width(&self) -> f64 {
        (self.high - self.low) / f64::from(self.cells)
    }

    /// Returns the value at the center of a cell.
    #[must_use]
    pub fn center(&self, cell: u32) -> f64 {
        self.value(self.low + (f64::from(cell) + 0.5) * self.width())
    }

    /// Returns the value at a place on the axis.
    #[must_use]
    pub fn value(&self, place: f64) -> f64 {
        match self.scale {
            Scale::Linear => place,
            Scale::Logarithmic => 10.0_f64.powf(place),
        }
    }

    /// Returns the place of a value on the axis.
    #[must_use]
    pub fn place(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value,
            Scale::Logarithmic => value.log10(),
        }
    }
}

/// Values at the centers of all cells, for one integrator.
#[derive(Clone, Debug)]
pub struct CellMap {
    /// The integrator.
    pub scheme: Scheme,
    /// Horizontal and vertical axis.
    pub axes: [GridAxis; 2],
    /// Row by row, the lowest first.
    values: Vec<f64>,
}

impl CellMap {
    /// Evaluates a function at the center of each cell.
    ///
    /// # Errors
    ///
    /// The first error of `value`.
    pub fn new<E>(
        scheme: Scheme,
        axes: [GridAxis; 2],
        value: fn(Scheme, f64, f64) -> Result<f64, E>,
    ) -> Result<Self, E> {
        let [horizontal, vertical] = axes;
        let mut values = Vec::new();
        for j in 0..vertical.cells {
            for i in 0..horizontal.cells {
                values.push(value(scheme, horizontal.center(i), vertical.center(j))?);
            }
        }
        Ok(Self { scheme, axes, values })
    }

    /// Returns the value of a cell.
    #[must_use]
    pub fn value(&self, i: u32, j: u32) -> f64 {
        self.values[(j * self.axes[0].cells + i) as usize]
    }

    /// Returns the centers of cells with their values, row by row.
    pub fn cells(&self) -> impl Iterator<Item = [f64; 3]> {
        let [horizontal, vertical] = self.axes;
        let cells =
            (0..vertical.cells).flat_map(move |j| (0..horizontal.cells).map(move |i| [i, j]));
        cells.map(move |[i, j]| [horizontal.center(i), vertical.center(j), self.value(i, j)])
    }
}
