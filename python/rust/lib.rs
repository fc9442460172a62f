//! Native module of the Python package `musculo_collide`.
//!
//! It converts arrays and results, releases the interpreter's lock while the library computes, and
//! passes interruptions and progress on. The classes that users see are in `src/musculo_collide`.

mod arrays;
mod call;
mod error;
mod exclusive;
mod field;
mod joint;
mod medial;
mod mesh;
mod motion;
mod plan;
mod record;
mod resolution;
mod scene;
mod step;
mod surface;
mod threads;

use pyo3::prelude::*;

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    threads::keep_process();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<plan::Plan>()?;
    module.add_class::<field::Field>()?;
    module.add_class::<step::Step>()?;
    module.add_class::<surface::Surface>()?;
    module.add_function(wrap_pyfunction!(call::computed_seconds, module)?)?;
    module.add_function(wrap_pyfunction!(mesh::read_mesh, module)?)?;
    module.add_function(wrap_pyfunction!(mesh::write_mesh, module)?)?;
    module.add_function(wrap_pyfunction!(medial::generate, module)?)?;
    Ok(())
}
