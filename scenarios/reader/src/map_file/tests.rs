use std::fs;

use proptest::prelude::*;

use super::*;
use crate::mentions::assert_mentions;

fn load(name: &str, text: &str, cell_meters: f64) -> Result<MapFile, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(name);
    fs::write(&file, text).unwrap();
    MapFile::load(&file, cell_meters).map_err(|error| error.to_string())
}

#[test]
fn a_drawing_is_read_as_drawn() {
    let map = load("a.txt", "..#\n~,.\n", 30.0).unwrap();
    assert_eq!(map, MapFile::unplaced(Terrain::from_ascii("..#\n~,.", 30.0).unwrap()));
}

#[test]
fn a_file_that_is_not_a_map_is_rejected_with_its_name() {
    let check = |name: &str, text: &str, cell_meters: f64, message: &str| {
        let error = load(name, text, cell_meters).unwrap_err();
        assert_mentions(&error, &format!("{name} .. {message}"));
    };
    check("a.txt", "..\n.x\n", 1.0, "line 2 .. column 2 .. 'x' .. allowed");
    check("a.txt", "..\n...\n", 1.0, "line 2 .. 3 .. 2");
    check("a.txt", "", 1.0, "0 rows .. 0 columns .. 1 to");
    check("a.txt", "..", f64::NAN, "cell edge .. NaN .. above 0");
    check("a.bmp", "..", 1.0, "extension .. allowed .. .txt .. .yaml");
}

#[test]
fn a_missing_file_and_invalid_text_are_rejected() {
    let error = MapFile::load(Path::new("no/such.map"), 1.0).unwrap_err().to_string();
    assert!(error.contains("no/such.map: No such file"), "{error}");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.map");
    fs::write(&file, [0xff, 0xff]).unwrap();
    let error = MapFile::load(&file, 1.0).unwrap_err().to_string();
    assert!(error.contains("a.map: no UTF-8 text"), "{error}");
    fs::File::create(&file).unwrap().set_len(MapFile::MAX_BYTES + 1).unwrap();
    let error = MapFile::load(&file, 1.0).unwrap_err().to_string();
    assert_mentions(&error, "a.map .. longer than .. 268435456 bytes");
}

proptest! {
    #[test]
    fn any_drawing_is_read_or_rejected(text in "[.#~,\n]{0,40}|\\PC{0,40}") {
        let _ = Terrain::from_ascii(&text, 1.0);
    }
}
