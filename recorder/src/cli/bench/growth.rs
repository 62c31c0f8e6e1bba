//! `recorder bench growth`.

use clap::Args;
use comfy_table::Table;
use formats::bench_result::growth::{GrowthRow, Verdict};
use formats::metrics::growth::Exponent;

use super::{chosen, table_of};
use crate::bench::growth::{GrowthBench, Size};
use crate::options::{DeviceOptions, OptionError, RecordOptions, in_range, parse_methods};

#[derive(Debug, Args)]
pub(super) struct GrowthArguments {
    /// A .gltf or .glb file, or builtin:NAME, of all but triangles.
    #[arg(default_value = "builtin:atrium")]
    scene: String,
    /// What is to grow; all of them if not given.
    #[arg(long, value_enum, value_delimiter = ',', value_name = "LIST")]
    only: Vec<Size>,
    /// Triangles of the built-in scenes cornell and city, ascending.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "1000,3000,10000,30000,100000,300000,1000000,3000000,10000000"
    )]
    triangles: Vec<u64>,
    /// Timed repeats of each size.
    #[arg(long, default_value_t = 3)]
    repeats: u32,
    #[command(flatten)]
    device: DeviceOptions,
}

impl GrowthArguments {
    pub(super) fn bench(&self) -> Result<GrowthBench, OptionError> {
        if !self.triangles.is_sorted() {
            let message = "--triangles: found a number below the one before it, expected them ascending";
            return Err(OptionError::conflict(message));
        }
        if self.triangles.first() == self.triangles.last() {
            let message = "--triangles: found one size, expected at least two; an exponent is between sizes";
            return Err(OptionError::conflict(message));
        }
        for &count in &self.triangles {
            in_range("triangles", count, 38, 50_000_000)?;
        }
        let run = RecordOptions {
            width: 480,
            height: 270,
            repeats: self.repeats,
            orders: parse_methods("two-point-adaptive", &[])?.into(),
            device: self.device.clone(),
            ..RecordOptions::base()?
        };
        run.check()?;
        Ok(GrowthBench {
            only: chosen(&self.only),
            scene: self.scene.clone(),
            triangles: self.triangles.clone(),
            pictures: (0..=4).map(|power| [120, 68].map(|side| side << power)).collect(),
            bounces: vec![1, 2, 4, 8, 16],
            lights: vec![1, 16, 256, 4096, 65_536],
            run,
        })
    }
}

pub(super) fn table(rows: &[GrowthRow]) -> Table {
    let mut table = table_of(
        "scene | against | from | to | cost | at the least | at the most | exponent | last step | \
         n log n | growth",
    );
    for row in rows {
        let points = row.least();
        let (Some(&first), Some(&last), Some((exponent, n_log_n))) =
            (points.first(), points.last(), row.exponents())
        else {
            continue;
        };
        let step = Exponent::of(points.iter().rev().take(2).copied());
        let shown = |cost: f64| match row.unit.as_str() {
            "bytes" => format!("{:.0} MB", cost / 1e6),
            _ => format!("{:.2} ms", cost / 1e6),
        };
        table.add_row([
            row.scene.clone(),
            row.against.clone(),
            first.0.to_string(),
            last.0.to_string(),
            row.cost.clone(),
            shown(first.1),
            shown(last.1),
            match exponent.interval {
                Some((low, high)) => format!("{:.2} [{low:.2}, {high:.2}]", exponent.value),
                None => format!("{:.2}", exponent.value),
            },
            step.map_or(String::new(), |step| format!("{:.2}", step.value)),
            format!("{n_log_n:.2}"),
            row.verdict().map_or("", described).to_owned(),
        ]);
    }
    table
}

fn described(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Within => "within n log n",
        Verdict::NotShown => "not shown to be worse",
        Verdict::Worse => "WORSE than n log n",
    }
}
