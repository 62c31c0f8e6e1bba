//! A figure's files in a folder.

use std::fs;
use std::path::{Path, PathBuf};

use super::model::Figure;
use super::style::Width;
use super::{FigureError, csv, draw, pgfplots, raster};

/// Makes the folder, and all that lead to it, if it is not there.
///
/// # Errors
/// If it cannot be made or nothing can be written in it.
pub fn make_folder(folder: &Path) -> Result<(), FigureError> {
    fs::create_dir_all(folder).map_err(|cause| FigureError::Io { path: folder.to_owned(), cause })
}

/// Writes NAME.svg, .pdf, .png, .csv, .txt and .tex, what the .tex reads, and NAME.caption.tex, into a folder that
/// exists; gives their paths. All are made before the first is written.
///
/// # Errors
/// If a file cannot be made or written; the error names it.
pub fn write(figure: &Figure, width: Width, folder: &Path) -> Result<Vec<PathBuf>, FigureError> {
    let drawing = draw::draw(figure, width)?;
    let name = |extension: &str| format!("{}.{extension}", figure.name);
    let mut files = vec![
        (name("pdf"), raster::pdf(&drawing)?),
        (name("png"), raster::png(&drawing)?),
        (name("csv"), csv::write(figure)?),
        (name("txt"), caption(figure).into_bytes()),
        (name("caption.tex"), latex_caption(figure).into_bytes()),
        (name("svg"), drawing.into_bytes()),
    ];
    files.extend(pgfplots::files(figure, width)?);
    files.into_iter().map(|(name, bytes)| replace(&folder.join(name), &bytes)).collect()
}

/// Title, caption and settings as plain text, for whoever puts it into a paper.
fn caption(figure: &Figure) -> String {
    let mut text = format!("{}\n\n{}\n\n", figure.title, figure.caption);
    text.extend(figure.settings.iter().flat_map(|line| [line.as_str(), "\n"]));
    text
}

/// The same in a paragraph, for `\caption{\input{NAME.caption}}`.
fn latex_caption(figure: &Figure) -> String {
    let Figure { title, caption, settings, .. } = figure;
    pgfplots::escape(&format!("{title}. {caption} {}.\n", settings.join("; ")))
}

/// Writes a file whole or not at all; gives its path.
///
/// # Errors
/// If it cannot be written.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<PathBuf, FigureError> {
    let written = formats::files::replace(path, |file| file.write_all(bytes));
    written.map_err(|cause| FigureError::Io { path: path.to_owned(), cause })?;
    Ok(path.to_owned())
}
