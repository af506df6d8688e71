//! KMZ: KML in a zip archive, as Google Earth saves it. Pictures and other files in the archive are ignored.

use std::io::{Cursor, Read};
use std::path::Path;

use zip::ZipArchive;

use super::Areas;
use crate::map_file::MapFileError;

/// The content of the KML file in an archive; at most [`Areas::MAX_BYTES`] are unpacked.
pub(super) fn kml(file: &Path, archive: &[u8]) -> Result<Vec<u8>, MapFileError> {
    let invalid = |error| MapFileError::syntax(file, format!("not a KMZ archive: {error}"));
    let mut archive = ZipArchive::new(Cursor::new(archive)).map_err(invalid)?;
    let is_kml = |name: &&str| {
        Path::new(name).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("kml"))
    };
    let names: Vec<String> = archive.file_names().filter(is_kml).map(ToOwned::to_owned).collect();
    // Which of several counts is not said anywhere: a no-go area may be in any of them.
    let [name] = &names[..] else {
        return Err(MapFileError::value(file, "the number of KML files in it", names.len(), "one"));
    };
    let packed = archive.by_name(name).map_err(invalid)?;
    let mut text = Vec::new();
    packed
        .take(Areas::MAX_BYTES + 1)
        .read_to_end(&mut text)
        .map_err(|error| MapFileError::syntax(file, format!("{name:?} cannot be unpacked: {error}")))?;
    if text.len() as u64 > Areas::MAX_BYTES {
        let allowed = format!("at most {} bytes", Areas::MAX_BYTES);
        return Err(MapFileError::value(file, format!("{name:?}, unpacked,"), "longer", allowed));
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use proptest::prelude::{any, prop, proptest};
    use zip::write::FileOptions;
    use zip::{CompressionMethod, ZipWriter};

    use super::*;
    use crate::Scenario;

    fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
        let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in files {
            let options = FileOptions::default().compression_method(CompressionMethod::Deflated);
            writer.start_file(*name, options).unwrap();
            writer.write_all(bytes).unwrap();
        }
        writer.finish().unwrap().into_inner()
    }

    fn shipped() -> Vec<u8> {
        let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("../maps/missing_person.kml");
        std::fs::read(map).unwrap()
    }

    fn refused(archive: &[u8]) -> String {
        Areas::from_bytes(Path::new("a.kmz"), archive.to_vec()).unwrap_err().to_string()
    }

    #[test]
    fn the_only_kml_file_of_an_archive_is_read() {
        let kml = shipped();
        let expected = Areas::from_bytes(Path::new("a.kml"), kml.clone()).unwrap();
        let packed = archive(&[("files/photo.png", b"no areas"), ("doc.kml", &kml)]);
        assert_eq!(Areas::from_bytes(Path::new("a.KMZ"), packed.clone()).unwrap(), expected);
        let folder = tempfile::tempdir().unwrap();
        let map = folder.path().join("missing person.kmz");
        std::fs::write(&map, packed).unwrap();
        let scenario = Scenario::load(&map).unwrap();
        assert_eq!((scenario.name(), scenario.areas()), ("missing_person", expected));
    }

    #[test]
    fn an_archive_without_one_kml_file_is_refused() {
        assert!(refused(b"<kml/>").contains("a.kmz: not a KMZ archive"));
        assert!(
            refused(&archive(&[("a.txt", b"")])).contains("number of KML files in it is 0; allowed is one")
        );
        assert!(refused(&archive(&[("a.kml", b""), ("b/c.KML", b"")])).contains("is 2; allowed is one"));
        assert!(refused(&archive(&[("doc.kml", b"<html/>")])).contains("root element"));
    }

    /// A million to one.
    #[test]
    fn an_archive_that_unpacks_without_end_is_refused() {
        let long = vec![b' '; usize::try_from(Areas::MAX_BYTES).unwrap() + 1];
        let packed = archive(&[("doc.kml", &long)]);
        assert!(packed.len() < 100_000, "{}", packed.len());
        assert!(
            refused(&packed).contains("\"doc.kml\", unpacked, is longer; allowed is at most 16777216 bytes")
        );
    }

    proptest! {
        /// Each is read, or refused with the file's name.
        #[test]
        fn no_damage_makes_the_reader_fail(
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
            end in any::<prop::sample::Index>(),
            is_cut in any::<bool>(),
        ) {
            let mut packed = archive(&[("doc.kml", &shipped()), ("a.txt", b"text")]);
            for (place, byte) in changes {
                let place = place.index(packed.len());
                packed[place] = byte;
            }
            if is_cut {
                packed.truncate(end.index(packed.len()));
            }
            if let Err(error) = Areas::from_bytes(Path::new("a.kmz"), packed) {
                assert!(error.to_string().starts_with("a.kmz: "), "{error}");
            }
        }
    }
}
