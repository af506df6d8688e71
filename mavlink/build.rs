//! Makes types of the messages in `dialect/common.xml`.

use std::env;
use std::error::Error;
use std::path::Path;

use mavlink_bindgen::XmlDefinitions;

const DIALECT: &str = "dialect/common.xml";

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed={DIALECT}");
    // The features of the crate `mavlink` that what is generated asks for, and the one that it has here.
    println!(
        "cargo::rustc-check-cfg=cfg(feature, values(\"arbitrary\", \"dialect-common\", \"serde\", \"ts-rs\"))"
    );
    println!("cargo::rustc-cfg=feature=\"dialect-common\"");
    mavlink_bindgen::generate(XmlDefinitions::Files(vec![DIALECT]), Path::new(&env::var("OUT_DIR")?))?;
    Ok(())
}
