//! Every kernel of a run, compiled once for its scene and methods.

use anyhow::{Context, Result, bail, ensure};
use clap::ValueEnum;
use formats::ray::Kind;
use formats::unit_space::UnitSpace;
use rayon::prelude::*;

use crate::device::{Gpu, ItemKernel, Module, Rounding, limits};
use crate::machine::self_check;
use crate::stages::setup::{MethodPlan, Setup};
use crate::stages::trace::variant::TraceVariant;
use crate::stages::trace::{LeafForm, Order, Precision, TraceKernel};
use crate::stages::{accumulate, compact, compare, gather, generate, key, scatter, shade, sort};

/// The kernels that do not trace or sort.
pub struct Kernels {
    pub(super) generate: ItemKernel,
    pub(super) surface: ItemKernel,
    pub(super) shadow: ItemKernel,
    pub(super) next: ItemKernel,
    /// Of rays, of their paths.
    pub(super) compact: [ItemKernel; 2],
    pub(super) add_light: ItemKernel,
    /// Of rays, then of what their paths carry.
    pub(super) gather: [ItemKernel; 2],
    /// By kind.
    pub(super) accumulate: [ItemKernel; 2],
    /// By method and kind; `None` where the method does not apply.
    pub(super) key: Vec<[Option<ItemKernel>; 2]>,
    /// By kind.
    pub(super) compare: [ItemKernel; 2],
    /// By kind.
    pub(super) scatter: [ItemKernel; 2],
}

/// Refuses numbers that kernels are made with and WGSL cannot write.
fn check_finite(setup: &Setup) -> Result<()> {
    let UnitSpace { min, scale, sides } = setup.unit;
    let is_finite = [min, sides, [scale; 3]].iter().flatten().all(|value| value.is_finite());
    ensure!(
        is_finite,
        "the scene begins at {min:?} and is scaled by {scale} to {sides:?}, which kernels cannot be made \
         with; the bounds must be finite numbers whose differences are, too"
    );
    let wrong = setup.methods.iter().find(|method| !method.two_point_length.is_finite());
    if let Some(MethodPlan { name, two_point_length, .. }) = wrong {
        bail!("the length that method '{name}' assumes is {two_point_length}; it must be a finite number");
    }
    Ok(())
}

/// Refuses keys that are made from more arrays than a kernel may bind: light, path, table and wide keys at once.
fn check_bindings(modules: &[Module]) -> Result<()> {
    match modules.iter().find(|module| module.storage_buffers() > limits::STORAGE_BUFFERS as usize) {
        None => Ok(()),
        Some(module) => bail!(
            "{} needs {} arrays at once, and a kernel has {}; sort by fewer of lights, tiles and @adaptive lengths, \
             by keys of up to 32 bits, or with --backend cpu",
            module.label(),
            module.storage_buffers(),
            limits::STORAGE_BUFFERS
        ),
    }
}

/// All modules of a run but those that trace and sort, in the order in which [`Kernels`] takes them.
pub fn modules(setup: &Setup) -> Vec<Module> {
    let mut modules = vec![
        generate::gpu::module(),
        shade::gpu::surface_module(&setup.features),
        shade::gpu::shadow_module(&setup.features),
        shade::gpu::next_module(&setup.features),
        compact::queue::ray_module(),
        compact::queue::path_module(),
        shade::gpu::add_light_module(),
        gather::gpu::ray_module(),
        gather::gpu::path_module(),
    ];
    for kind in Kind::ALL {
        modules.push(accumulate::gpu::module(kind, &setup.unit, &setup.table_layout, setup.table_bits));
        modules.push(compare::gpu::module(kind));
        modules.push(scatter::gpu::module(kind));
        let applicable = setup.methods.iter().filter(|method| method.applies_to(kind));
        modules.extend(applicable.map(|method| key::gpu::module(setup, method, kind)));
    }
    modules
}

impl Kernels {
    /// Compiles all of them, as many at a time as there are threads.
    ///
    /// # Errors
    /// If the driver refuses one, or a number that is written into kernels is not finite.
    pub fn new(gpu: &Gpu, setup: &Setup) -> Result<Self> {
        check_finite(setup)?;
        let modules = modules(setup);
        check_bindings(&modules)?;
        let compiled = modules.into_par_iter().map(|module| module.compile(gpu));
        let mut compiled = compiled.collect::<Result<Vec<_>, _>>()?.into_iter();
        let mut next = || compiled.next().context("there are fewer kernels than modules");
        let (generate, surface, shadow, next_ray) = (next()?, next()?, next()?, next()?);
        let (compact, add_light, gather) = ([next()?, next()?], next()?, [next()?, next()?]);
        let mut key = vec![[None, None]; setup.methods.len()];
        let mut of_kind = |kind: Kind| -> Result<[ItemKernel; 3]> {
            let shared = [next()?, next()?, next()?];
            for (kernels, method) in key.iter_mut().zip(&setup.methods) {
                kernels[kind as usize] = method.applies_to(kind).then(&mut next).transpose()?;
            }
            Ok(shared)
        };
        let [accumulate_closest, compare_closest, scatter_closest] = of_kind(Kind::Closest)?;
        let [accumulate_shadow, compare_shadow, scatter_shadow] = of_kind(Kind::Shadow)?;
        Ok(Self {
            generate,
            surface,
            shadow,
            next: next_ray,
            compact,
            add_light,
            gather,
            accumulate: [accumulate_closest, accumulate_shadow],
            key,
            compare: [compare_closest, compare_shadow],
            scatter: [scatter_closest, scatter_shadow],
        })
    }
}

/// Label and WGSL of every module that a run can compile: scenes with all features and with none,
/// all methods at 32 and 64 bits, every trace kernel, both ways to sort. For tests that look at all
/// of them.
pub fn all_shader_sources() -> Vec<(String, String)> {
    let modules = every_module();
    let every_guard = Rounding { contracts: true, divides_roughly: true };
    let numbered = modules
        .iter()
        .enumerate()
        .map(|(number, module)| (format!("{} #{number}", module.label()), module.wgsl(every_guard)));
    let mut sources: Vec<_> = numbered.collect();
    sources.extend(sort::gpu::sources());
    sources.push(("compact::places".to_owned(), compact::gpu::wgsl()));
    sources.push(("self_check".to_owned(), self_check::wgsl(every_guard)));
    sources
}

/// Modules for made-up runs that between them need every line of WGSL.
fn every_module() -> Vec<Module> {
    let mut modules = Vec::new();
    for all_features in [false, true] {
        for key_bits in [32, 64] {
            modules.extend(self::modules(&Setup::made_up(all_features, key_bits)));
        }
        for &kernel in TraceKernel::value_variants().iter().filter(|kernel| kernel.is_for_gpus()) {
            for kind in Kind::ALL {
                for order in [Order::Stored, Order::Indirect(())] {
                    for precision in Precision::ALL {
                        let (masks, count_work) = (all_features, all_features);
                        for leaves in [LeafForm::Gathered, LeafForm::Indexed] {
                            let variant =
                                TraceVariant { kernel, kind, order, leaves, masks, count_work, precision };
                            modules.push(variant.module());
                        }
                    }
                }
            }
        }
    }
    modules
}

#[cfg(test)]
mod tests {
    use formats::key::{LayoutText, Termination};
    use scenes::features::Features;

    use super::*;
    use crate::device::{AdapterRequest, skipped, test_gpu};

    #[test]
    fn every_module_compiles_here() {
        let plain = test_gpu();
        let has_ray_query = plain.adapter().ray_query;
        let with_queries = has_ray_query.then(|| Gpu::open_with_ray_query(&AdapterRequest::Any).unwrap());
        let gpu = with_queries.as_ref().unwrap_or(plain);
        if !has_ray_query {
            skipped("compiling kernels with ray queries", "the adapter has none");
        }
        for module in every_module() {
            if module.label().starts_with("trace::ray-query") && !has_ray_query {
                continue;
            }
            module.compile(gpu).unwrap();
        }
    }

    #[test]
    fn numbers_that_wgsl_cannot_write_are_refused_before_a_kernel_is_made() {
        let sound = Setup::made_up(false, 32);
        for bound in [f32::NAN, f32::INFINITY, -f32::INFINITY, f32::MAX] {
            let unit = UnitSpace::from_bounds([-f32::MAX; 3], [bound; 3]);
            let error = Kernels::new(test_gpu(), &Setup { unit, ..sound.clone() }).err().unwrap();
            assert!(error.to_string().contains("must be finite"), "{bound}: {error}");
        }
        let plan = MethodPlan { two_point_length: f32::NAN, ..sound.methods[0].clone() };
        let error = Kernels::new(test_gpu(), &Setup { methods: vec![plan], ..sound }).err().unwrap();
        assert!(error.to_string().contains("assumes is NaN"), "{error}");
    }

    /// Every module for every set of features and methods that bind most, whatever this adapter offers.
    #[test]
    fn no_kernel_binds_more_storage_buffers_than_webgpu_promises() {
        let mut modules = every_module();
        let each = Features::each();
        for set in 0..1u32 << each.len() {
            let used = (0..).zip(&each).filter(|(place, _)| set >> place & 1 == 1);
            let features = used.fold(Features::default(), |all, (_, (_, one))| all.union(*one));
            modules.extend([shade::gpu::surface_module(&features), shade::gpu::shadow_module(&features)]);
            modules.push(shade::gpu::next_module(&features));
        }
        let setup = Setup::made_up(true, 64);
        let key_modules = |text: &str, termination| {
            let layout = LayoutText::parse(text).unwrap().expand(setup.extent()).unwrap();
            let method = MethodPlan { layout, termination, ..setup.methods[0].clone() };
            Kind::ALL.map(|kind| key::gpu::module(&setup, &method, kind))
        };
        for termination in [Termination::Fixed, Termination::Adaptive, Termination::Real] {
            modules.extend(key_modules("light ex lu", termination));
            modules.extend(key_modules("tile(8x8) ex", termination));
        }
        let most = modules.iter().max_by_key(|module| module.storage_buffers()).unwrap();
        assert_eq!(most.storage_buffers(), limits::STORAGE_BUFFERS as usize, "of {}", most.label());
        let error = check_bindings(&key_modules("light ex lu tile(8x8)", Termination::Adaptive)).unwrap_err();
        assert!(error.to_string().contains("needs 9 arrays at once, and a kernel has 8"), "{error}");
    }
}
