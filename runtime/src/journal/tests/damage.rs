//! Damaged journals, especially in the first page, and other files.

use super::*;

/// A journal of some observations, as bytes.
fn written(shelf: &Shelf) -> Vec<u8> {
    let (mut journal, _) = shelf.open(1, 0).unwrap();
    journal.note((0..200).map(|sequence| shelf.observation(1, 0, sequence)).collect());
    journal.commit();
    drop(journal);
    let bytes = std::fs::read(shelf.path()).unwrap();
    std::fs::remove_file(shelf.path()).unwrap();
    bytes
}

/// The robot starts, with its stored state or without; if without, the file is kept.
fn check_starts(shelf: &Shelf, bytes: &[u8], what: &str) -> bool {
    std::fs::write(shelf.path(), bytes).unwrap();
    let prospect = shelf.peek(1).map_err(|error| format!("{what}: {error}")).unwrap();
    assert_eq!(std::fs::read(shelf.path()).unwrap(), bytes, "{what}");
    let (journal, memory) = shelf.open(1, 5).map_err(|error| format!("{what}: {error}")).unwrap();
    let aside = shelf.folder.path().join("robot.journal.damaged");
    let is_set_aside = aside.exists();
    assert_eq!(matches!(prospect, Prospect::SetAside { .. }), is_set_aside, "{what}: {prospect:?}");
    if is_set_aside {
        assert_eq!(memory, memory_of(5, Vec::new()), "{what}");
        assert_eq!(std::fs::read(&aside).unwrap(), bytes, "{what}");
        std::fs::remove_file(&aside).unwrap();
    }
    drop(journal);
    std::fs::remove_file(shelf.path()).unwrap();
    is_set_aside
}

#[test]
fn a_first_page_that_is_lost_or_wrong_in_any_byte_stops_no_robot() {
    let shelf = Shelf::new();
    let bytes = written(&shelf);
    let page = bytes[..4096].to_vec();
    let with = |page: &[u8]| [page, &bytes[page.len()..]].concat();
    assert!(check_starts(&shelf, &[0; 4096], "a blank page and nothing else"));
    assert!(check_starts(&shelf, &with(&[0; 4096]), "a blank page"));
    assert!(check_starts(&shelf, &with(&[0x41; 4096]), "a page of something else"));
    let used = page.iter().rposition(|&byte| byte != 0).unwrap();
    let mut set_aside = 0;
    for place in 0..=used {
        let mut page = page.clone();
        page[place] ^= 0x55;
        set_aside += u32::from(check_starts(&shelf, &with(&page), &format!("byte {place}")));
    }
    assert!(set_aside > 20, "{set_aside}");
    for length in [6, 9, 100, 4095, 4096, 4097, bytes.len() / 2, bytes.len() - 1] {
        check_starts(&shelf, &bytes[..length], &format!("{length} bytes"));
    }
}

#[test]
fn a_file_that_is_not_a_journal_is_not_changed() {
    let shelf = Shelf::new();
    let letter = b"a letter to somebody, which is no journal at all".to_vec();
    let table = [b"SQLite format 3\0".as_slice(), &[7; 8176]].concat();
    for content in [letter, table] {
        std::fs::write(shelf.path(), &content).unwrap();
        for error in [shelf.peek(1).err(), shelf.open(1, 0).err()] {
            let error = error.unwrap().to_string();
            assert!(error.contains("robot.journal: no journal, nor what is left of one"), "{error}");
        }
        assert_eq!(std::fs::read(shelf.path()).unwrap(), content);
    }
}

#[test]
fn a_folder_is_no_journal() {
    let shelf = Shelf::new();
    std::fs::create_dir(shelf.path()).unwrap();
    for error in [shelf.peek(1).err(), shelf.open(1, 0).err()] {
        let error = error.unwrap().to_string();
        assert!(error.contains("robot.journal: no plain file, as a journal is"), "{error}");
    }
}
