//! Files that no exporter writes: cut, damaged, or made to do harm. Each is an error, and the program goes on.

use dragnet_detector::network::NetworkError;
use dragnet_detector::picture::Size;
use dragnet_search::seed::{Purpose, stream};
use rand::RngExt;

use super::{load, says};

const INPUT: Size = Size { width_pixels: 32, height_pixels: 32 };

/// The example network: all that an exporter writes.
const EXAMPLE: &[u8] = include_bytes!("../../example/figures.onnx");

fn varint(mut number: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    while number > 127 {
        bytes.push(u8::try_from(number & 127).unwrap() | 128);
        number >>= 7;
    }
    bytes.push(u8::try_from(number).unwrap());
    bytes
}

/// A field with a length.
fn field(number: usize, value: &[u8]) -> Vec<u8> {
    [varint(number << 3 | 2), varint(value.len()), value.to_vec()].concat()
}

/// A field with a number.
fn number(field: usize, value: usize) -> Vec<u8> {
    [varint(field << 3), varint(value)].concat()
}

/// An input or output: its name, the number of its type (1: 32-bit floats, 7: 64-bit integers), its sides.
fn value(name: &[u8], element: usize, sides: &[usize]) -> Vec<u8> {
    let sides: Vec<u8> = sides.iter().flat_map(|&side| field(1, &number(1, side))).collect();
    let tensor = [number(1, element), field(2, &sides)].concat();
    [field(1, name), field(2, &field(1, &tensor))].concat()
}

/// Whole numbers that are part of a network.
fn constant(name: &[u8], values: &[i64]) -> Vec<u8> {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    field(5, &[number(1, values.len()), number(2, 7), field(8, name), field(9, &bytes)].concat())
}

/// A network of one operator, from its input to its output.
fn network(operator: &[u8], input: &[u8], attributes: &[u8]) -> Vec<u8> {
    network_with(operator, input, attributes, &[])
}

/// With more fields of its graph.
fn network_with(operator: &[u8], input: &[u8], more_of_node: &[u8], more: &[u8]) -> Vec<u8> {
    let node = [field(1, b"in"), field(2, b"out"), field(4, operator), more_of_node.to_vec()].concat();
    let graph = [field(1, &node), field(11, input), field(12, &field(1, b"out")), more.to_vec()].concat();
    [number(1, 8), field(7, &graph), field(8, &number(2, 17))].concat()
}

fn refused(file: &[u8]) -> NetworkError {
    load("a.onnx", file, Some(INPUT)).unwrap_err()
}

#[test]
fn what_takes_or_gives_no_image_is_rejected() {
    let with =
        |element: usize, sides: &[usize]| refused(&network(b"Relu", &value(b"in", element, sides), &[]));
    // The one that is understood fails by its output alone.
    says(&with(1, &[1, 3, 32, 32]), &["an output of shape [1, 3, 32, 32]"]);
    let wanted = "understood is one input of 32-bit floats, shape [1, 3, rows, columns]";
    says(&with(1, &[1, 4, 32, 32]), &["an input of shape [1, 4, 32, 32]", wanted]);
    says(&with(1, &[1, 32, 32, 3]), &["an input of shape [1, 32, 32, 3]", wanted]);
    says(&with(1, &[2, 3, 32, 32]), &["an input of shape [2, 3, 32, 32]", wanted]);
    says(&with(1, &[3, 32, 32]), &["an input of shape [3, 32, 32]", wanted]);
    says(&with(7, &[1, 3, 32, 32]), &["an input of other numbers", wanted]);
    says(&with(1, &[1, 3, 64, 32]), &["an input of 32 x 32 pixels", "fixed, 32 x 64"]);
    let none = [number(1, 8), field(7, &[]), field(8, &number(2, 17))].concat();
    says(&refused(&none), &["inputs and outputs: 0 and 0", wanted]);
}

#[test]
fn an_operator_that_is_not_built_in_is_named() {
    let image = value(b"in", 1, &[1, 3, 32, 32]);
    for operator in ["RandomNormalLike", "Loop", "MadeUp"] {
        says(
            &refused(&network(operator.as_bytes(), &image, &[])),
            &["not an ONNX network that can be read", operator],
        );
    }
}

/// A slice with steps of 0 makes `rten` 0.27 panic.
#[test]
fn a_runtime_that_panics_has_refused_the_network() {
    let numbers: [(&[u8], i64); 4] = [(b"start", 0), (b"end", 9), (b"axis", 0), (b"step", 0)];
    let inputs = numbers.map(|(name, _)| field(1, name)).concat();
    let constants = numbers.map(|(name, value)| constant(name, &[value])).concat();
    let file = network_with(b"Slice", &value(b"in", 1, &[1, 3, 32, 32]), &inputs, &constants);
    says(&refused(&file), &["not an ONNX network that can be read", "Slice step cannot be 0"]);
}

#[test]
fn lengths_that_lie_and_graphs_without_end_do_no_harm() {
    let damaged =
        |file: &[u8]| says(&refused(file), &["not an ONNX network", "cut off, damaged, or something else"]);
    damaged(b"\x89PNG\r\n\x1a\n");
    damaged(b"[detector]\n");
    // A text and a graph that are to be 2^50 bytes long, and a number without an end.
    let endless = [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x01];
    damaged(&[number(1, 8), vec![18], endless.to_vec()].concat());
    damaged(&[number(1, 8), vec![58], endless.to_vec(), vec![0; 1000]].concat());
    damaged(&[0xff; 100]);
    // And a name within the graph that ends behind it.
    damaged(&[number(1, 8), field(7, &[18, 100, 0]), vec![0; 200]].concat());
    says(&refused(&number(1, 8)), &["there is no graph in it"]);
    says(&refused(&[]), &["there is no graph in it"]);

    // A graph in an attribute of a node of a graph, and so on: followed to its end, it would fill the stack.
    let nested = (0..3).fold(Vec::new(), |inner, _| field(1, &field(5, &field(6, &inner))));
    let image = value(b"in", 1, &[1, 3, 32, 32]);
    says(&refused(&network(b"Relu", &image, &field(5, &field(6, &nested)))), &["graphs within its graph"]);
    let sequence = [field(1, b"in"), field(2, &field(4, &field(1, &[])))].concat();
    says(&refused(&network(b"Relu", &sequence, &[])), &["sequences"]);
}

#[test]
fn a_damaged_file_is_an_error_or_another_network() {
    for length in (0..EXAMPLE.len()).step_by(EXAMPLE.len() / 50) {
        says(&refused(&EXAMPLE[..length]), &["ONNX network"]);
    }
    // Within the names, operators and sizes at the ends of the file, and anywhere.
    let mut random = stream(1, Purpose::Truth, 0);
    let mut errors = 0;
    for round in 0..60 {
        let mut file = EXAMPLE.to_vec();
        for _ in 0..=random.random_range(0..3) {
            let at = match round % 3 {
                0 => random.random_range(0..3000),
                1 => file.len() - 1 - random.random_range(0..1000),
                _ => random.random_range(0..file.len()),
            };
            file[at] = random.random();
        }
        if let Err(error) = load("a.onnx", &file, None) {
            says(&error, &[]);
            errors += 1;
        }
    }
    assert!(errors > 20, "{errors}");
}
