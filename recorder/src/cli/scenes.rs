//! `recorder scenes`.

use anyhow::Result;
use clap::Args;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use comfy_table::{ContentArrangement, Table};

use crate::output::{print, print_json};

#[derive(Debug, Args)]
pub(super) struct ScenesArguments {
    /// Print the list as JSON on stdout.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &ScenesArguments) -> Result<()> {
    let scenes = scenes::builtin::list();
    if arguments.json {
        let list: Vec<_> = scenes
            .iter()
            .map(|scene| {
                serde_json::json!({
                    "name": scene.name,
                    "description": scene.description,
                    "default_triangles": scene.default_triangles,
                    "least_triangles": scene.least_triangles,
                    "most_triangles": scene.most_triangles,
                })
            })
            .collect();
        return print_json(&list);
    }
    let mut table = Table::new();
    table.load_style(UTF8_BORDERS_ONLY).set_content_arrangement(ContentArrangement::Dynamic);
    table.set_header(["scene", "triangles", "from", "up to", "what it shows"]);
    for scene in scenes {
        table.add_row([
            format!("builtin:{}", scene.name),
            scene.default_triangles.to_string(),
            scene.least_triangles.to_string(),
            scene.most_triangles.to_string(),
            scene.description.to_owned(),
        ]);
    }
    print(format_args!("{table}\nAsk for another size with builtin:NAME?triangles=N."))
}
