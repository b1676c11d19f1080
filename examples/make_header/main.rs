//! Writes include/impasto.h: `make header`. The test `capi` finds one that is not what src/capi says.

mod header;

use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let include = root.join("include");
    std::fs::create_dir_all(&include)?;
    std::fs::write(include.join("impasto.h"), header::header(root)?)?;
    println!("include/impasto.h is written");
    Ok(())
}
