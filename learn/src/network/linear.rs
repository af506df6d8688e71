//! Affine maps of all nodes at a time.

use std::array;

use pulp::Simd;

use super::RECTIFIER_LEAK;

/// Rows of a matrix are padded to a multiple of this: the widest vector register in use.
pub(super) const LANES: usize = 8;
/// Nodes computed together, so that a column of the matrix is read once for all of them.
const NODES: usize = 8;
/// Inputs of a node that are read with one check of its bounds.
const CHUNK: usize = 4;

/// `y = W x + b` for each node.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Linear {
    inputs: usize,
    outputs: usize,
    /// `LANES` rows of `W`, column by column: shape `[outputs / LANES, inputs, LANES]`, the last block padded with
    /// zeros.
    blocks: Vec<f32>,
    /// Shape `[outputs / LANES, LANES]`, padded likewise.
    bias: Vec<f32>,
}

impl Linear {
    /// A map with a matrix `[outputs, inputs]` and a bias `[outputs]`.
    pub(super) fn new(weight: &[f32], bias: &[f32]) -> Self {
        let outputs = bias.len();
        let inputs = weight.len() / outputs;
        let padded = outputs.next_multiple_of(LANES);
        let (mut blocks, mut padded_bias) = (vec![0.0; padded * inputs], vec![0.0; padded]);
        padded_bias[..outputs].copy_from_slice(bias);
        for output in 0..outputs {
            let (block, lane) = (output / LANES, output % LANES);
            for input in 0..inputs {
                blocks[(block * inputs + input) * LANES + lane] = weight[output * inputs + input];
            }
        }
        Self { inputs, outputs, blocks, bias: padded_bias }
    }

    /// Applies the map to concatenated inputs, each of shape `[nodes, width]`: `output` becomes `[nodes, outputs]`.
    #[inline(always)]
    pub(super) fn apply<S: Simd>(&self, simd: S, parts: &[&[f32]], output: &mut Vec<f32>) {
        self.map(simd, parts, output, |sum| sum);
    }

    /// The same through a rectifier.
    #[inline(always)]
    pub(super) fn apply_rectified<S: Simd>(&self, simd: S, parts: &[&[f32]], output: &mut Vec<f32>) {
        self.map(simd, parts, output, |sum| rectify(simd, sum));
    }

    #[inline(always)]
    fn map<S: Simd>(
        &self,
        simd: S,
        parts: &[&[f32]],
        output: &mut Vec<f32>,
        finish: impl Fn(S::f32s) -> S::f32s,
    ) {
        let nodes = parts.iter().map(|part| part.len()).sum::<usize>() / self.inputs;
        output.resize(nodes * self.outputs, 0.0);
        let together = nodes - nodes % NODES;
        for first in (0..together).step_by(NODES) {
            self.map_nodes::<S, NODES>(simd, Nodes { parts, count: nodes, first }, output, &finish);
        }
        for first in together..nodes {
            self.map_nodes::<S, 1>(simd, Nodes { parts, count: nodes, first }, output, &finish);
        }
    }

    #[inline(always)]
    fn map_nodes<S: Simd, const COUNT: usize>(
        &self,
        simd: S,
        input: Nodes<'_>,
        output: &mut [f32],
        finish: &impl Fn(S::f32s) -> S::f32s,
    ) {
        let output = &mut output[input.first * self.outputs..];
        for first in (0..self.outputs).step_by(LANES) {
            let block = self.blocks[first * self.inputs..][..LANES * self.inputs].as_chunks::<LANES>().0;
            for lane in (0..LANES).step_by(S::F32_LANES) {
                if first + lane >= self.outputs {
                    break;
                }
                let mut sums = [load::<S>(&self.bias[first + lane..]); COUNT];
                let mut columns = block;
                for part in input.parts {
                    let width = part.len() / input.count;
                    let rows: [&[f32]; COUNT] = rows(&part[input.first * width..], width);
                    let (of_part, rest) = columns.split_at(width);
                    columns = rest;
                    let (chunks, last) = of_part.as_chunks::<CHUNK>();
                    for (chunk, columns) in chunks.iter().enumerate() {
                        let mut inputs = [&[0.0; CHUNK]; COUNT];
                        for (inputs, row) in inputs.iter_mut().zip(rows) {
                            *inputs = &row.as_chunks().0[chunk];
                        }
                        add(simd, &mut sums, columns, lane, &inputs);
                    }
                    for (place, column) in (width - last.len()..).zip(last) {
                        let mut inputs = [&[0.0]; COUNT];
                        for (input, row) in inputs.iter_mut().zip(rows) {
                            *input = array::from_ref(&row[place]);
                        }
                        add(simd, &mut sums, array::from_ref(column), lane, &inputs);
                    }
                }
                let count = S::F32_LANES.min(self.outputs - first - lane);
                for (node, &sum) in sums.iter().enumerate() {
                    let output = &mut output[node * self.outputs + first + lane..];
                    if count == S::F32_LANES {
                        store::<S>(output, finish(sum));
                    } else {
                        simd.partial_store_f32s(&mut output[..count], finish(sum));
                    }
                }
            }
        }
    }
}

/// Adds columns of the matrix to the sum of each node, times its inputs.
#[inline(always)]
fn add<S: Simd, const COUNT: usize, const COLUMNS: usize>(
    simd: S,
    sums: &mut [S::f32s; COUNT],
    columns: &[[f32; LANES]; COLUMNS],
    lane: usize,
    inputs: &[&[f32; COLUMNS]; COUNT],
) {
    for place in 0..COLUMNS {
        let column = load::<S>(&columns[place][lane..]);
        for node in 0..COUNT {
            sums[node] = simd.mul_add_f32s(simd.splat_f32s(inputs[node][place]), column, sums[node]);
        }
    }
}

/// Some nodes of concatenated inputs.
#[derive(Clone, Copy)]
struct Nodes<'a> {
    /// Shape `[count, width]` each.
    parts: &'a [&'a [f32]],
    /// Of the whole inputs.
    count: usize,
    first: usize,
}

/// The first rows of a matrix of this width.
#[inline(always)]
fn rows<const COUNT: usize>(values: &[f32], width: usize) -> [&[f32]; COUNT] {
    let mut rows: [&[f32]; COUNT] = [&[]; COUNT];
    if width > 0 {
        for (row, values) in rows.iter_mut().zip(values.chunks_exact(width)) {
            *row = values;
        }
    }
    rows
}

/// A register through the rectifier.
#[inline(always)]
pub(super) fn rectify<S: Simd>(simd: S, register: S::f32s) -> S::f32s {
    simd.max_f32s(register, simd.mul_f32s(register, simd.splat_f32s(RECTIFIER_LEAK)))
}

/// The first numbers of a slice that has enough, as a register.
#[inline(always)]
pub(super) fn load<S: Simd>(values: &[f32]) -> S::f32s {
    S::as_simd_f32s(values).0[0]
}

/// Puts a register into the first numbers of a slice that has enough.
#[inline(always)]
pub(super) fn store<S: Simd>(values: &mut [f32], register: S::f32s) {
    S::as_mut_simd_f32s(values).0[0] = register;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_affine_map_of_any_width_agrees_with_its_definition() {
        for (inputs, outputs, nodes) in [(1, 1, 1), (3, 17, 5), (10, 32, 4), (62, 1, 3)] {
            let number = |index: usize| ((index * 7919) % 101) as f32 / 50.0 - 1.0;
            let weight: Vec<f32> = (0..inputs * outputs).map(number).collect();
            let bias: Vec<f32> = (0..outputs).map(|index| number(index + 13)).collect();
            let input: Vec<f32> = (0..nodes * inputs).map(|index| number(index + 29)).collect();
            let linear = Linear::new(&weight, &bias);
            let mut output = Vec::new();
            linear.apply(pulp::Scalar, &[&input], &mut output);
            assert_eq!(output.len(), nodes * outputs);
            for (place, &value) in output.iter().enumerate() {
                let (node, row) = (place / outputs, place % outputs);
                let products = (0..inputs).map(|i| weight[row * inputs + i] * input[node * inputs + i]);
                assert!((value - bias[row] - products.sum::<f32>()).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn inputs_may_stand_side_by_side() {
        let linear = Linear::new(&[1.0, 10.0, 100.0], &[0.5]);
        let mut output = Vec::new();
        linear.apply(pulp::Scalar, &[&[1.0, 2.0], &[], &[3.0, 4.0, 5.0, 6.0]], &mut output);
        assert_eq!(output, [431.5, 652.5]);
        linear.apply_rectified(pulp::Scalar, &[&[-431.5], &[0.0, 0.0]], &mut output);
        assert!((output[0] + 4.31).abs() < 1e-6 && output.len() == 1);
    }
}
