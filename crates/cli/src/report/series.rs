//! Time series of VTP files, which `ParaView` opens as one.

use std::fmt::Write;

use super::table::escaped;

/// Files of all frames of a motion.
#[derive(Debug, Default)]
pub(crate) struct Series {
    /// Data sets of the collection, as XML.
    entries: String,
}

impl Series {
    /// Name of the file that lists a series.
    pub(crate) const FILE_NAME: &str = "frames.pvd";

    /// Adds a file of a frame, each as a part of its own.
    pub(crate) fn add(&mut self, time: f64, part: usize, file: &str) {
        let file = escaped(file);
        let entry = format!("    <DataSet timestep=\"{time}\" part=\"{part}\" file=\"{file}\"/>");
        writeln!(self.entries, "{entry}").expect("text takes what is written");
    }

    /// Returns the content of the file that lists the series.
    pub(crate) fn to_pvd(&self) -> String {
        format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n  \
             <Collection>\n{}  </Collection>\n</VTKFile>\n",
            self.entries
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_lists_its_files_by_time() {
        let mut series = Series::default();
        series.add(0.0, 0, "femur_0000.vtp");
        series.add(0.5, 1, "a&b\"<_0001.vtp");
        let expected = r#"<?xml version="1.0"?>
<VTKFile type="Collection" version="0.1">
  <Collection>
    <DataSet timestep="0" part="0" file="femur_0000.vtp"/>
    <DataSet timestep="0.5" part="1" file="a&amp;b&quot;&lt;_0001.vtp"/>
  </Collection>
</VTKFile>
"#;
        assert_eq!(series.to_pvd(), expected);
    }
}
