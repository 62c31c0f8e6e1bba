//! Loading of scene files, from the outside: every capability and every refusal, with tiny files
//! made on the spot.

mod automatic;
mod damage;
mod fixture;
mod geometry;
mod materials;
mod nodes;
mod oracle;
mod refusals;
mod scene_files;
mod skins;
mod summaries;
mod valid;
