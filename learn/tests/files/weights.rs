//! Weights files.

use std::fs;

use dragnet_learn::network::Network;
use dragnet_learn::shape::Shape;
use dragnet_learn::weights::{Recipe, Weights};
use dragnet_search::seed::{Purpose, stream};
use rand::{Rng, RngExt};
use safetensors::Dtype;
use serde_json::{Value, json};
use tempfile::tempdir;

use crate::mentions::assert_mentions;
use crate::parts::{Part, Parts, changed};

fn weights(shape: Shape) -> Weights {
    let mut random = stream(7, Purpose::Training, 0);
    let recipe = Recipe {
        expert: "path".to_owned(),
        scenarios: vec!["süd \"west\"".to_owned(), "a\\b\n".to_owned()],
        decisions: u64::MAX,
        seed: 7,
        epochs: 3,
        held_out_loss: 0.1 + 0.2,
        program: "0.1.0".to_owned(),
        within_cells: (shape.levels > 0).then_some(5.0),
        own_searches: Some(4000),
    };
    let fill = |_: &str, shape: &[usize]| {
        (0..shape.iter().product()).map(|_| random.random_range(-1.0..1.0)).collect()
    };
    Weights::build(shape, recipe, fill).unwrap()
}

fn file() -> Vec<u8> {
    weights(Shape::DEFAULT).to_bytes().unwrap()
}

/// The file is rejected, with these words.
fn refuse(file: &[u8], expected: &str) {
    let error = Weights::from_bytes(file).unwrap_err();
    assert_mentions(&error, expected);
}

#[test]
fn weights_come_back_from_a_file_byte_for_byte() {
    let pathless = Shape { hidden: 64, layers: 1, decay_channels: 0, sum_channels: 0, ..Shape::DEFAULT };
    for shape in [Shape::DEFAULT, pathless, Shape::PLANNING] {
        let weights = weights(shape);
        let bytes = weights.to_bytes().unwrap();
        let read = Weights::from_bytes(&bytes).unwrap();
        assert_eq!(read, weights);
        assert_eq!(read.to_bytes().unwrap(), bytes);
        assert_eq!(Network::new(&read), Network::new(&weights));
        for parameter in shape.parameters() {
            assert_eq!(read.get(&parameter.name).len(), parameter.shape.iter().product::<usize>());
        }
    }
    // An unchanged file is valid.
    assert!(Weights::from_bytes(&changed(&file(), |_| ())).unwrap() == weights(Shape::DEFAULT));
}

#[test]
fn built_in_files_without_levels_are_written_as_they_are_read() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/weights");
    let files = fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
    let files = files.filter(|path| path.extension().is_some_and(|it| it == "safetensors"));
    let mut without_levels = 0;
    for path in files {
        let bytes = fs::read(&path).unwrap();
        let weights = Weights::from_bytes(&bytes).unwrap();
        if weights.shape().levels == 0 {
            without_levels += 1;
            assert!(weights.to_bytes().unwrap() == bytes, "{}", path.display());
        }
    }
    assert_eq!(without_levels, 7);
}

#[test]
fn a_truncated_file_is_rejected_wherever_it_ends() {
    let file = file();
    assert!(file.len() > 20_000);
    for end in (0..file.len()).step_by(64).chain([file.len() - 1]) {
        refuse(&file[..end], "truncated");
    }
}

#[test]
fn a_file_with_trailing_data_is_rejected() {
    let mut file = file();
    file.push(0);
    refuse(&file, "no weights file");
}

#[test]
fn random_bytes_are_rejected() {
    let mut random = stream(1, Purpose::Training, 0);
    for length in 0..300 {
        let mut bytes = vec![0; length];
        random.fill_bytes(&mut bytes);
        refuse(&bytes, "no weights file");
        // A plausible header length, followed by random bytes.
        if length >= 8 {
            bytes[..8].copy_from_slice(&(length as u64 - 8).to_le_bytes());
            refuse(&bytes, "no weights file");
        }
    }
}

#[test]
fn a_contradictory_header_is_rejected() {
    let file = file();
    let check = |pointer: &str, value: Value, expected: &str| {
        let changed = changed(&file, |parts| *parts.header.pointer_mut(pointer).unwrap() = value);
        refuse(&changed, expected);
    };
    check("/format", json!("dragnet-weights-9"), "\"dragnet-weights-9\"");
    check("/features/3", json!("luck"), "features .. probability, log_odds, entropy, luck");
    check("/features", json!(["luck"]), "features .. luck .. probability");
    check("/shape/hidden", json!(64), "encoder.weight .. F32 [32, 10] .. F32 [64, 10]");
    check("/shape/layers", json!(4), "attention.3.weight .. missing");
    check("/shape/layers", json!(2), "parameters .. a network of these sizes");
    check("/shape/decay_channels", json!(0), "mix.weight .. F32 [32, 48] .. F32 [32, 32]");
    check("/shape/sum_channels", json!(5), "sum.weight .. F32 [4, 32] .. F32 [5, 32]");
    for (size, value) in [
        ("hidden", json!(0)),
        ("hidden", json!(33)),
        ("hidden", json!(usize::MAX)),
        ("hidden", json!(1_u64 << 40)),
        ("layers", json!(0)),
        ("layers", json!(1_u64 << 40)),
        ("decay_channels", json!(1_u64 << 40)),
        ("sum_channels", json!(usize::MAX)),
    ] {
        let expected = format!("{size}: {value}");
        let error = Weights::from_bytes(&changed(&file, |parts| parts.header["shape"][size] = value));
        let error = error.unwrap_err();
        assert!(error.starts_with("no network has the sizes") && error.contains(&expected), "{error}");
    }
    check("/shape/hidden", json!(-32), "\"dragnet\" .. `-32`");
    check("/shape", json!({"hidden": 32, "heads": 2}), "\"dragnet\" .. `heads`");
    check("/recipe", json!(null), "\"dragnet\" .. null");
    refuse(&changed(&file, |parts| parts.header = json!([])), "\"dragnet\"");
    let other = safetensors::serialize(Vec::<(&str, safetensors::tensor::TensorView<'_>)>::new(), None);
    refuse(&other.unwrap(), "no weights .. \"dragnet\"");
}

#[test]
fn parameters_that_do_not_fit_are_rejected() {
    let file = file();
    let check = |change: &dyn Fn(&mut Parts), expected: &str| refuse(&changed(&file, change), expected);
    check(
        &|parts| parts.get("mix.bias").bytes[12..16].copy_from_slice(&f32::NAN.to_le_bytes()),
        "mix.bias .. NaN .. 3",
    );
    check(
        &|parts| parts.get("head.weight").bytes[..4].copy_from_slice(&f32::NEG_INFINITY.to_le_bytes()),
        "head.weight .. -inf .. 0",
    );
    check(&|parts| parts.tensors.retain(|part| part.name != "decay.factor"), "decay.factor .. missing");
    let extra = || Part { name: "more".to_owned(), dtype: Dtype::F32, shape: vec![1], bytes: vec![0; 4] };
    let count = Parts::of(&file).tensors.len();
    check(&|parts| parts.tensors.push(extra()), &format!("{} parameters .. {count}", count + 1));
    check(
        &|parts| parts.get("encoder.weight").shape.reverse(),
        "encoder.weight .. F32 [10, 32] .. F32 [32, 10]",
    );
    check(&|parts| parts.get("encoder.bias").dtype = Dtype::I32, "encoder.bias .. I32 [32] .. F32 [32]");
}

#[test]
fn weights_are_built_whole_or_not_at_all() {
    let build = |shape: Shape, values: fn(usize) -> Vec<f32>| {
        let fill = |_: &str, shape: &[usize]| values(shape.iter().product());
        Weights::build(shape, Recipe::default(), fill).unwrap_err()
    };
    let check = |error: String, expected: &str| assert_mentions(&error, expected);
    check(build(Shape::DEFAULT, |count| vec![0.0; count + 1]), "encoder.weight .. 321 .. 320");
    check(build(Shape::DEFAULT, |count| vec![f32::NAN; count]), "encoder.weight .. NaN .. 0");
    let too_large = Shape { layers: usize::MAX, ..Shape::DEFAULT };
    check(build(too_large, |_| Vec::new()), "no network has the sizes");
}

#[test]
fn errors_name_the_file() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("mine.safetensors");
    let error = Weights::load(&path).unwrap_err().to_string();
    assert_mentions(&error, "mine.safetensors .. No such file");
    fs::File::create(&path).unwrap().set_len((1 << 26) + 1).unwrap();
    let error = Weights::load(&path).unwrap_err().to_string();
    let expected = "mine.safetensors .. longer than .. 67108864 bytes";
    assert_mentions(&error, expected);
    fs::write(&path, &file()[..1000]).unwrap();
    let error = Weights::load(&path).unwrap_err().to_string();
    assert_mentions(&error, "mine.safetensors .. truncated");
    fs::write(&path, file()).unwrap();
    assert_eq!(Weights::load(&path).unwrap(), weights(Shape::DEFAULT));
}
