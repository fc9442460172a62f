//! Values over two axes of equal cells.

use response::stability::Scheme;

/// How an axis is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// By the value.
    Linear,
    /// By its decimal logarithm.
    Logarithmic,
}

/// One axis: `cells` of equal width from `low` to `high`, which are values or
/// their logarithms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Name, with the unit in brackets.
    pub label: &'static str,
    /// How it is divided.
    pub scale: Scale,
    /// Where it begins.
    pub low: f64,
    /// Where it ends.
    pub high: f64,
    /// How many cells.
    pub cells: u32,
}

impl Axis {
    /// Where a cell begins on the axis; where the last ends, for `cells`.
    #[must_use]
    pub fn edge(&self, cell: u32) -> f64 {
        self.low + f64::from(cell) * self.width()
    }

    /// Where its middle is.
    #[must_use]
    pub fn centre(&self, cell: u32) -> f64 {
        self.low + (f64::from(cell) + 0.5) * self.width()
    }

    /// Of a cell.
    #[must_use]
    pub fn width(&self) -> f64 {
        (self.high - self.low) / f64::from(self.cells)
    }

    /// The value at a place of the axis.
    #[must_use]
    pub fn value(&self, place: f64) -> f64 {
        match self.scale {
            Scale::Linear => place,
            Scale::Logarithmic => 10.0_f64.powf(place),
        }
    }

    /// The place of a value on the axis.
    #[must_use]
    pub fn place(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value,
            Scale::Logarithmic => value.log10(),
        }
    }
}

/// A value in the middle of every cell.
#[derive(Clone, Debug)]
pub struct Map {
    /// The integrator.
    pub scheme: Scheme,
    /// Across and up.
    pub axes: [Axis; 2],
    /// Row by row, the lowest first.
    values: Vec<f64>,
}

impl Map {
    /// Asks for the value of each cell.
    ///
    /// # Errors
    ///
    /// The first that `value` returns.
    pub fn new<E>(
        scheme: Scheme,
        axes: [Axis; 2],
        value: impl Fn(f64, f64) -> Result<f64, E>,
    ) -> Result<Self, E> {
        let [across, up] = axes;
        let cells = (0..up.cells).flat_map(|j| (0..across.cells).map(move |i| (i, j)));
        let values = cells
            .map(|(i, j)| value(across.value(across.centre(i)), up.value(up.centre(j))))
            .collect::<Result<_, E>>()?;
        Ok(Self { scheme, axes, values })
    }

    /// The value of a cell.
    #[must_use]
    pub fn value(&self, i: u32, j: u32) -> f64 {
        self.values[(j * self.axes[0].cells + i) as usize]
    }

    /// Middles of cells with their values, row by row.
    pub fn cells(&self) -> impl Iterator<Item = [f64; 3]> {
        let [across, up] = self.axes;
        let cells = (0..up.cells).flat_map(move |j| (0..across.cells).map(move |i| (i, j)));
        cells.map(move |(i, j)| {
            let at = [across.value(across.centre(i)), up.value(up.centre(j))];
            [at[0], at[1], self.value(i, j)]
        })
    }
}
