//! NRRD and VTI fields written and read back, and damaged files.

use std::io::Write;

use distance_field::{DistanceField, FieldGrid, Interpolation, NodeValues, Storage};
use flate2::Compression;
use flate2::write::GzEncoder;
use glam::DVec3;
use mesh_io::FieldFormat;

use crate::Random;

/// Returns a field of awkward numbers: unequal axes, a spacing and an origin without a
/// finite decimal, values of every magnitude.
fn sample() -> DistanceField {
    let grid =
        FieldGrid::new(DVec3::new(-1.0 / 3.0, 1e-7, 250.125), 0.1, [2, 3, 4]).expect("a grid");
    let values = (0_i8..24).map(|node| (f32::from(node) - 7.3) / 3.0).collect();
    DistanceField::from_values(grid, values, Storage::Float).expect("one value per node")
}

/// Returns the same in steps, the largest multiples among them.
fn sample_in_steps() -> DistanceField {
    let (step, dense) = (0.000_3, sample());
    let mut values = dense.values();
    (values[5], values[6]) = (single(32767.0 * step), single(-32767.0 * step));
    DistanceField::from_values(*dense.grid(), values, Storage::Quantized { step })
        .expect("one value per node")
}

const BOTH: [FieldFormat; 2] = [FieldFormat::Nrrd, FieldFormat::Vti];
const ALL: [FieldFormat; 3] = [FieldFormat::Nrrd, FieldFormat::GzipNrrd, FieldFormat::Vti];

#[expect(clippy::cast_possible_truncation, reason = "fields store 32-bit floats")]
fn single(value: f64) -> f32 {
    value as f32
}

/// Returns the header of a file, up to its data.
fn header(format: FieldFormat, field: &DistanceField) -> String {
    let file = format.encode(field);
    let text = String::from_utf8_lossy(&file);
    let end = match format {
        FieldFormat::Nrrd => text.find("\n\n").expect("an empty line") + 2,
        _ => text.find("\n_").expect("an underscore") + 2,
    };
    text[..end].to_owned()
}

fn same(a: &DistanceField, b: &DistanceField) -> bool {
    let settings = |field: &DistanceField| (*field.grid(), field.storage(), field.node_values());
    settings(a) == settings(b) && a.values() == b.values()
}

/// `bytes` with the first `from` in their header replaced.
fn with(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    let at = bytes.windows(from.len()).position(|window| window == from.as_bytes());
    let at = at.expect("the text to be replaced is in the file");
    [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat()
}

#[test]
fn what_is_written_reads_back_to_the_bit() {
    for (format, field) in ALL.into_iter().flat_map(|f| [(f, sample()), (f, sample_in_steps())]) {
        let again = format.decode(&format.encode(&field)).unwrap();
        assert!(same(&again, &field), "{format:?}");
        assert_eq!(format.encode(&again), format.encode(&field));
    }
}

/// Cubic interpolation depends on the kind of node values: it gives the same bits.
#[test]
fn the_kind_of_node_values_is_kept() {
    let p = DVec3::new(-0.28, 0.13, 250.29);
    let cubic = |field: &DistanceField| {
        let sample = field.evaluate(p, Interpolation::Cubic).unwrap();
        (sample.distance.to_bits(), sample.gradient.to_array().map(f64::to_bits))
    };
    for field in [sample(), sample_in_steps()] {
        let quasi = field.clone().with_node_values(NodeValues::QuasiInterpolating);
        assert_ne!(cubic(&field), cubic(&quasi));
        for (format, field) in BOTH.into_iter().flat_map(|f| [(f, &field), (f, &quasi)]) {
            let again = format.decode(&format.encode(field)).unwrap();
            assert!(same(&again, field), "{format:?} {:?}", again.node_values());
            assert_eq!(cubic(&again), cubic(field), "{format:?} {:?}", field.node_values());
        }
    }
}

/// Files of other programs have no key for the kind of node values.
#[test]
fn nodes_are_distances_where_the_file_does_not_say() {
    let quasi = sample().with_node_values(NodeValues::QuasiInterpolating);
    let [nrrd, vti] = BOTH.map(|format| format.encode(&quasi));
    let without = [
        (FieldFormat::Nrrd, with(&nrrd, "distance nodes:=quasi-interpolating\n", "")),
        (FieldFormat::Vti, with(&vti, "quasi_interpolating_nodes", "anything_else")),
    ];
    for (format, file) in without {
        assert!(same(&format.decode(&file).unwrap(), &sample()), "{format:?}");
    }
}

#[test]
fn nodes_of_an_unknown_kind_are_refused() {
    let [nrrd, vti] = BOTH.map(|format| format.encode(&sample()));
    let cases = [
        (
            FieldFormat::Nrrd,
            with(&nrrd, "nodes:=interpolating", "nodes:=guessed"),
            "field 'distance nodes': 'guessed' is neither 'interpolating' nor 'quasi-interpolating'",
        ),
        (
            FieldFormat::Vti,
            with(&vti, ">0</", ">2</"),
            "array 'quasi_interpolating_nodes': is 2, neither 0 nor 1",
        ),
        (
            FieldFormat::Vti,
            with(&vti, ">0</", ">0 1</"),
            "array 'quasi_interpolating_nodes': has 2 numbers, not one",
        ),
        (
            FieldFormat::Vti,
            with(&vti, ">0</", ">no</"),
            "array 'quasi_interpolating_nodes': 'no' is not a number",
        ),
    ];
    for (format, file, expected) in cases {
        let error = format.decode(&file).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}, not {expected}");
    }
}

/// Both formats store 16 bits per node, least byte first, and the step.
#[test]
fn steps_are_written_as_they_are_kept() {
    let field = sample_in_steps();
    let dense = sample();
    let expected: Vec<u8> = field
        .values()
        .iter()
        .map(|value| (f64::from(*value) / 0.000_3).round())
        .flat_map(|steps| format!("{steps}").parse::<i16>().unwrap().to_le_bytes())
        .collect();
    assert_eq!(expected[10..14], [0xff, 0x7f, 0x01, 0x80]);
    for (format, behind) in [(FieldFormat::Nrrd, 0), (FieldFormat::Vti, 28)] {
        let bytes = format.encode(&field);
        assert_eq!(bytes[bytes.len() - behind - 48..bytes.len() - behind], expected, "{format:?}");
    }
    // Read back it is off by half a step at most.
    for format in BOTH {
        let again = format.decode(&format.encode(&field)).unwrap();
        for (node, (a, b)) in again.values().iter().zip(dense.values()).enumerate() {
            assert!((a - b).abs() <= 0.000_151 || [5, 6].contains(&node), "{node}: {a} {b}");
        }
    }
}

#[test]
fn arbitrary_fields_read_back() {
    let mut random = Random(3);
    for round in 0..2000 {
        let dims = [2 + random.below(4), 2 + random.below(3), 2 + random.below(2)];
        // Any bits, but those of infinities and of what is not a number.
        let mut number = || {
            let value = f32::from_le_bytes(std::array::from_fn(|_| random.byte()));
            if value.is_finite() { value } else { 0.5 }
        };
        let origin = DVec3::new(number().into(), number().into(), number().into());
        let spacing = f64::from(number().abs()).clamp(1e-30, 1e30);
        let values = (0..dims.iter().product()).map(|_| number()).collect();
        let grid = FieldGrid::new(origin, spacing, dims).unwrap();
        let field =
            DistanceField::from_values(grid, values, Storage::Float).expect("one value per node");
        for format in BOTH {
            let again = format.decode(&format.encode(&field)).unwrap();
            assert!(same(&again, &field), "{format:?} in round {round}");
        }
    }
}

#[test]
fn the_headers_are_as_recorded() {
    for (name, field) in [("header", sample()), ("header_of_steps", sample_in_steps())] {
        insta::assert_snapshot!(format!("nrrd_{name}"), header(FieldFormat::Nrrd, &field));
        insta::assert_snapshot!(format!("vti_{name}"), header(FieldFormat::Vti, &field));
    }
}

#[test]
fn x_runs_fastest_in_both() {
    let field = sample();
    let last = field.node([1, 2, 3]);
    let first_of_second_row = field.node([0, 1, 0]);
    for (format, behind) in [(FieldFormat::Nrrd, 0), (FieldFormat::Vti, 28)] {
        let bytes = format.encode(&field);
        let data = &bytes[bytes.len() - behind - 96..bytes.len() - behind];
        let value = |node: usize| {
            f64::from(f32::from_le_bytes(data[4 * node..4 * node + 4].try_into().unwrap()))
        };
        let read = [value(2), value(23)].map(f64::to_bits);
        assert_eq!(read, [first_of_second_row, last].map(f64::to_bits), "{format:?}");
    }
}

/// Other programs write doubles, the other byte order, or spacings.
#[test]
fn other_ways_to_write_the_same_are_read() {
    let field = sample();
    let bytes = FieldFormat::Nrrd.encode(&field);
    let data = bytes.len() - 96;
    let double: Vec<u8> =
        field.values().iter().flat_map(|&value| f64::from(value).to_le_bytes()).collect();
    let double = [&with(&bytes[..data], "float", "double")[..], &double].concat();
    let big: Vec<u8> = field.values().iter().flat_map(|value| value.to_be_bytes()).collect();
    let big = [&with(&bytes[..data], "little", "big")[..], &big].concat();
    let directions = "space directions: (0.1,0,0) (0,0.1,0) (0,0,0.1)";
    let spacings = with(&bytes, directions, "spacings: 0.1 0.1 0.1\r\nmodality:=none");
    for file in [double, big, spacings] {
        assert!(same(&FieldFormat::Nrrd.decode(&file).unwrap(), &field));
    }
    let ascii: Vec<String> = field.values().iter().map(f32::to_string).collect();
    let vti_header = header(FieldFormat::Vti, &field);
    let vti = vti_header.split("<AppendedData").next().unwrap().to_owned() + "</VTKFile>";
    let inline = format!("format=\"ascii\">{}</DataArray>", ascii.join(" "));
    let vti = with(vti.as_bytes(), "format=\"appended\" offset=\"0\"/>", &inline);
    assert!(same(&FieldFormat::Vti.decode(&vti).unwrap(), &field));

    let field = sample_in_steps();
    let bytes = FieldFormat::Nrrd.encode(&field);
    let data = &bytes[bytes.len() - 48..];
    let swapped = data.as_chunks::<2>().0.iter().flat_map(|&[low, high]| [high, low]);
    let big =
        [&with(&bytes[..bytes.len() - 48], "little", "big")[..], &swapped.collect::<Vec<_>>()];
    assert!(same(&FieldFormat::Nrrd.decode(&big.concat()).unwrap(), &field));
    let vti_header = header(FieldFormat::Vti, &field);
    let vti = vti_header.split("<AppendedData").next().unwrap().to_owned() + "</VTKFile>";
    let steps = data.as_chunks::<2>().0.iter().map(|&b| i16::from_le_bytes(b).to_string());
    let inline = format!("format=\"ascii\">{}</DataArray>", steps.collect::<Vec<_>>().join(" "));
    let vti = with(vti.as_bytes(), "format=\"appended\" offset=\"0\"/>", &inline);
    assert!(same(&FieldFormat::Vti.decode(&vti).unwrap(), &field));
}

#[test]
fn an_extent_need_not_begin_at_0() {
    let bytes = FieldFormat::Vti.encode(&sample());
    let shifted = with(&bytes, "WholeExtent=\"0 1 0 2 0 3\"", "WholeExtent=\"10 11 0 2 -4 -1\"");
    let shifted =
        with(&shifted, "Piece Extent=\"0 1 0 2 0 3\"", "Piece Extent=\"10 11 0 2 -4 -1\"");
    let field = FieldFormat::Vti.decode(&shifted).unwrap();
    let moved = field.grid().origin() - sample().grid().origin();
    assert!((moved - DVec3::new(1.0, 0.0, -0.4)).length() < 1e-12, "{moved}");
}

/// Files without an orientation have the ends of their axes, at nodes or half a spacing outside.
#[test]
fn ends_of_axes_place_the_grid() {
    let bytes = FieldFormat::Nrrd.encode(&sample());
    let bytes =
        with(&bytes, "space directions: (0.1,0,0) (0,0.1,0) (0,0,0.1)", "spacings: 0.1 0.1 0.1");
    let head = String::from_utf8_lossy(&bytes[..data_of(&bytes)]).into_owned();
    let origin = head.lines().find(|line| line.starts_with("space origin")).expect("an origin");
    let placed = |fields: &str| FieldFormat::Nrrd.decode(&with(&bytes, origin, fields));
    let at = |fields: &str| placed(fields).expect(fields).grid().origin();

    let node = DVec3::new(1.0, -2.0, 3.0);
    let inside = node + DVec3::splat(0.05);
    let ends = "axis mins: 1 -2 3\naxis maxs: 1.1 -1.8 3.3";
    assert_eq!(at(&format!("{ends}\ncenters: node node node")), node);
    let ends_of_cells = "axis mins: 1 -2 3\naxis maxs: 1.2 -1.7 3.4\ncenters: cell cell cell";
    assert_eq!(at(ends_of_cells), inside);
    assert_eq!(at("axismins: 1 -2 3\ncenterings: cell cell cell"), inside);
    assert_eq!(at("axis mins: 1 -2 3\ncenters: cell node cell"), inside.with_y(-2.0));
    assert_eq!(at("axis mins: nan nan nan\ncenters: cell cell cell"), DVec3::ZERO);
    assert_eq!(at("spaceorigin: (1,-2,3)\ncenters: cell cell cell"), node);

    for (fields, expected) in [
        ("axis mins: 1 -2 3", "field 'centers': is missing"),
        ("axis mins: 1 -2 3\ncenters: cell ??? cell", "'cell ??? cell' is not 'cell' or 'node'"),
        ("axis mins: 1 -2\ncenters: node node node", "'1 -2' is not three positions"),
        ("axis mins: 1 nan 3\ncenters: node node node", "'1 nan 3' is not three positions"),
        ("axis maxs: 1 -2 3\ncenters: node node node", "ends of axes without 'axis mins'"),
        (&format!("{ends}\ncenters: cell cell cell"), "'1.1 -1.8 3.3' does not fit"),
        ("axis mins: 1 -2 3\nspace origin: (0,0,0)", "'axis mins' beside an origin"),
    ] {
        let error = placed(fields).expect_err(fields).to_string();
        assert!(error.contains(expected), "{error}, not {expected}");
    }
}

#[test]
fn spacings_beside_directions_have_to_agree() {
    let bytes = FieldFormat::Nrrd.encode(&sample());
    let both = |spacings: &str| {
        let fields = format!("spacings: {spacings}\nkinds:");
        FieldFormat::Nrrd.decode(&with(&bytes, "kinds:", &fields))
    };
    assert!(same(&both("0.1 0.1 0.1").unwrap(), &sample()));
    assert!(same(&both("nan nan nan").unwrap(), &sample()));
    let error = both("0.2 0.2 0.2").unwrap_err().to_string();
    assert!(error.contains("'spacings' beside other 'space directions'"), "{error}");
}

#[test]
fn cut_files_are_refused() {
    for (format, field) in BOTH.into_iter().flat_map(|f| [(f, sample()), (f, sample_in_steps())]) {
        let bytes = format.encode(&field);
        // Behind its data a VTI file holds two closing tags, which may go.
        let needed = bytes.len() - if format == FieldFormat::Vti { 29 } else { 1 };
        for length in 0..=needed {
            assert!(format.decode(&bytes[..length]).is_err(), "{format:?} cut to {length}");
        }
    }
}

#[test]
fn bad_files_are_refused_with_the_place() {
    let nrrd = FieldFormat::Nrrd.encode(&sample());
    let cases = [
        (
            with(&nrrd, "2 3 4", "2 3 5"),
            "a grid of 2 x 3 x 5 nodes needs 120 bytes of data, but the file has 96",
        ),
        (with(&nrrd, "2 3 4", "2 3 3"), "needs 72 bytes of data, but the file has 96"),
        (with(&nrrd, "2 3 4", "9999999999 9999999999 9999999999"), "but the file has 96"),
        (with(&nrrd, "2 3 4", "2 3"), "field 'sizes': '2 3' is not three counts"),
        (with(&nrrd, "2 3 4", "-2 3 4"), "field 'sizes': '-2 3 4' is not three counts"),
        (with(&nrrd, "2 3 4", "1 6 4"), "nodes per axis is 1"),
        (with(&nrrd, "NRRD0004", "NIFTI"), "line 1: does not begin with NRRD000"),
        (with(&nrrd, "NRRD0004\n", "NRRD0004\r"), "line 1: ends with a carriage return alone"),
        (with(&nrrd, "type: float", "type: uchar"), "values of type 'uchar' cannot be read"),
        (with(&nrrd, "type: float\n", ""), "field 'type': is missing"),
        (with(&nrrd, "encoding: raw", "encoding: bzip2"), "data encoded as 'bzip2'"),
        (
            with(&nrrd, "encoding: raw", "encoding: raw\ndata file: a.raw"),
            "data in another place ('data file')",
        ),
        (with(&nrrd, "dimension: 3", "dimension: 4"), "an array of dimension '4'"),
        (with(&nrrd, "left-posterior", "right-anterior"), "in the space 'right-anterior-superior'"),
        (with(&nrrd, "(0,0.1,0)", "(0,0.2,0)"), "a grid along '(0.1,0,0) (0,0.2,0)"),
        (with(&nrrd, "(0,0.1,0)", "(0.01,0.1,0)"), "a grid along '(0.1,0,0) (0.01,0.1,0)"),
        (with(&nrrd, "(0,0.1,0)", "none"), "is not three vectors"),
        (with(&nrrd, "0.1,0,0) (0,0.1,0) (0,0,0.1", "-1,0,0) (0,-1,0) (0,0,-1"), "spacing is -1"),
        (with(&nrrd, "space origin: (-", "space origin: (inf"), "space origin"),
        (with(&nrrd, "endian: little", "endian: middle"), "'middle' is neither little nor big"),
    ];
    for (file, expected) in cases {
        let error = FieldFormat::Nrrd.decode(&file).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}, not {expected}");
    }
    let vti = FieldFormat::Vti.encode(&sample());
    let cases = [
        (
            with(
                &with(&vti, "0 1 0 2 0 3", "0 1 0 2 0 4"),
                "Piece Extent=\"0 1 0 2 0 3",
                "Piece Extent=\"0 1 0 2 0 4",
            ),
            "a grid of 2 x 3 x 5 nodes needs 120 bytes of data, but the file has 96",
        ),
        (with(&vti, "0 1 0 2 0 3", "0 1 0 2 0 4"), "a part of a grid"),
        (with(&vti, "0 1 0 2 0 3", "0 1 0 2"), "WholeExtent='0 1 0 2' is not the extent of a grid"),
        (with(&vti, "ImageData", "PolyData"), "data of type 'PolyData'"),
        (with(&vti, "Float32", "UInt8"), "type 'UInt8'"),
        // Twice as many steps as there are nodes.
        (with(&vti, "Float32", "Int16"), "needs 48 bytes of data, but the file has 96"),
        (with(&vti, "offset=\"0\"", "offset=\"900\""), "offset 900 is behind the end"),
        (with(&vti, "offset=\"0\"", "offset=\"-1\""), "its offset '-1' is no count"),
        (with(&vti, "Spacing=\"0.1 0.1", "Spacing=\"0.1 0.3"), "a grid of spacings 0.1 0.3 0.1"),
        (with(&vti, "Direction=\"1 0", "Direction=\"0 1"), "a grid along [0.0, 1.0"),
        (with(&vti, "Origin=\"", "Origin=\"x"), "is not 3 numbers"),
        (
            with(&with(&vti, "PointData", "CellData"), "/PointData", "/CellData"),
            "there are no values at its points",
        ),
    ];
    for (file, expected) in cases {
        let error = FieldFormat::Vti.decode(&file).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}, not {expected}");
    }
}

#[test]
fn bad_steps_are_refused_with_the_place() {
    let [nrrd, vti] = BOTH.map(|format| format.encode(&sample_in_steps()));
    let line = "distance step:=0.0003\n";
    let least = |format: FieldFormat, behind: usize| {
        let mut bytes = format.encode(&sample_in_steps());
        let at = bytes.len() - behind - 2;
        bytes[at..at + 2].copy_from_slice(&i16::MIN.to_le_bytes());
        bytes
    };
    let cases = [
        (with(&nrrd, line, ""), "header: values of 16 bits need a line 'distance step:='"),
        (with(&nrrd, ":=0.0003", ": 0.0003"), "values of 16 bits need a line"),
        (with(&nrrd, "0.0003", "a hair"), "field 'distance step': 'a hair' is not a length"),
        (with(&nrrd, "0.0003", "-1"), "storage step is -1, but must be finite and positive"),
        (with(&nrrd, "0.0003", "0"), "storage step is 0, but must be finite and positive"),
        (with(&nrrd, "0.0003", "nan"), "node 0 is not finite"),
        (with(&nrrd, "type: short", "type: ushort"), "values of type 'ushort'"),
        (with(&nrrd, "type: short", "type: float"), "needs 96 bytes of data, but the file has 48"),
        (least(FieldFormat::Nrrd, 0), "a storage step of 0.0003 reaches 9.830"),
    ];
    for (file, expected) in cases {
        let error = FieldFormat::Nrrd.decode(&file).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}, not {expected}");
    }
    let cases = [
        (
            with(&vti, "\"distance_step", "\"step"),
            "need an array 'distance_step' in the field data",
        ),
        (with(&vti, ">0.0003<", "><"), "array 'distance_step': has 0 numbers, not one"),
        (with(&vti, ">0.0003<", ">1 2<"), "array 'distance_step': has 2 numbers, not one"),
        (with(&vti, ">0.0003<", ">a hair<"), "array 'distance_step': 'a' is not a number"),
        (with(&vti, ">0.0003<", ">-1<"), "storage step is -1, but must be finite and positive"),
        (with(&vti, "Int16", "Float32"), "needs 96 bytes of data, but the file has 48"),
        (least(FieldFormat::Vti, 28), "a storage step of 0.0003 reaches 9.830"),
    ];
    for (file, expected) in cases {
        let error = FieldFormat::Vti.decode(&file).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}, not {expected}");
    }
}

#[test]
fn a_value_that_is_not_finite_is_refused() {
    for (format, behind) in [(FieldFormat::Nrrd, 0), (FieldFormat::Vti, 28)] {
        let mut bytes = format.encode(&sample());
        let at = bytes.len() - behind - 4;
        bytes[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
        let error = format.decode(&bytes).unwrap_err().to_string();
        assert_eq!(error, "the value of node 23 is not finite", "{format:?}");
    }
}

/// Returns the place behind the header of an NRRD file.
fn data_of(file: &[u8]) -> usize {
    file.windows(2).position(|window| window == b"\n\n").expect("an empty line") + 2
}

fn gzip(content: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(content).expect("memory takes it");
    encoder.finish().expect("memory takes it")
}

/// 3D Slicer compresses by default, and names the encoding `gzip`; others name it `gz`
/// or write several members.
#[test]
fn compressed_data_are_read() {
    let field = sample();
    let file = FieldFormat::GzipNrrd.encode(&field);
    let at = data_of(&file);
    assert!(String::from_utf8_lossy(&file[..at]).contains("encoding: gzip\n"));
    assert_eq!(FieldFormat::Nrrd.compressed(), Some(FieldFormat::GzipNrrd));
    assert_eq!(FieldFormat::Vti.compressed(), None);

    let raw = FieldFormat::Nrrd.encode(&field);
    let data = &raw[raw.len() - 96..];
    let members = [&file[..at], &gzip(&data[..40]), &gzip(&data[40..])].concat();
    for file in [&file, &with(&file, "encoding: gzip", "encoding: gz"), &members] {
        assert!(same(&FieldFormat::Nrrd.decode(file).unwrap(), &field));
    }
}

#[test]
fn compressed_data_are_as_large_as_the_grid() {
    let file = FieldFormat::GzipNrrd.encode(&sample());
    let at = data_of(&file);
    let refusal = |data: &[u8]| {
        FieldFormat::Nrrd.decode(&[&file[..at], data].concat()).unwrap_err().to_string()
    };
    let more = "NRRD file: field 'encoding': the data decompress to more than 96 bytes";
    assert_eq!(refusal(&gzip(&[0; 97])), more);
    assert_eq!(refusal(&gzip(&vec![0; 200_000_000])), more);
    let fewer = "a grid of 2 x 3 x 4 nodes needs 96 bytes of data, but the file has 95";
    assert!(refusal(&gzip(&[0; 95])).contains(fewer));

    // Cut anywhere, changed, or with other bytes behind.
    for end in at..file.len() {
        assert!(FieldFormat::Nrrd.decode(&file[..end]).is_err(), "cut at {end}");
    }
    let damaged = "NRRD file: field 'encoding': the data are damaged: ";
    for data in [&b"not gzip"[..], &[&gzip(&[0; 96])[..], b"behind"].concat()] {
        assert!(refusal(data).starts_with(damaged), "{}", refusal(data));
    }
    let mut changed = file.clone();
    changed[at + 14] ^= 1;
    assert!(FieldFormat::Nrrd.decode(&changed).is_err(), "a bit of the data is changed");
}
