//! Where the examples put their pictures.

use std::error::Error;
use std::path::PathBuf;

use wzvi::plot::{Figure, Sheet};

/// Draws figures, `columns` to a row, each `size` pixels, into `target/wzvi/<example>/<name>.svg` under the working
/// directory, and says so.
pub(crate) fn save(
    example: &str,
    name: &str,
    columns: usize,
    size: (u32, u32),
    figures: &[Figure],
) -> Result<(), Box<dyn Error>> {
    let file = ["target", "wzvi", example].iter().collect::<PathBuf>().join(format!("{name}.svg"));
    figures.iter().cloned().fold(Sheet::new(columns, size), Sheet::with).write(&file)?;
    println!("  {}", file.display());
    Ok(())
}
