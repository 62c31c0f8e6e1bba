//! Frames as a renderer makes them: it keeps to one order, of rays before they are traced or of hits before they are
//! shaded, and never asks what another would have taken.
//!
//! Camera rays are traced as they are generated. Every later queue is keyed, sorted and moved with all that its
//! paths carry, and stays so: shading leaves the next queues in the order of their parents, which are sorted
//! again. Nothing is brought home, since a path owns its pixel and its random numbers. `auto` does what its
//! calibration measured: paths stay where they are, rays are traced through indices, or gathered and their hits
//! brought home. All orders give the same picture, which is checked after the rounds. Lengths are learnt where a
//! method reads them.
//!
//! Within the rounds the processor does nothing but hand out work and decide: a graphics card that waits for it lowers
//! its clock, step by step, until frames take three times as long.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use anyhow::{Context, Result, bail, ensure};
use formats::bench_result::{BenchResult, RenderRow, Rows};
use formats::key::Termination;
use formats::key::method::UNSORTED;
use formats::manifest::{QueueId, Way};
use formats::metrics::speedup::{Instrument, Speedup};
use formats::ray::Kind;
use scenes::Scene;

use super::backends::{self, OnBackend};
use super::hit_orders::{HitOrder, Tally};
use super::{Runs, result};
use crate::auto::Auto;
use crate::backends::{Array, Backend, Queue, Table, collected, picture};
use crate::calibrate;
use crate::machine;
use crate::measure::{Subject, sampled};
use crate::options::RecordOptions;
use crate::output::say;
use crate::progress::Progress;
use crate::recording::prepared;
use crate::stages::setup::{MethodPlan, Setup};
use crate::stages::trace::{Order, TraceKernel};
use crate::wavefront;

/// Renders every scene in canonical order, in that of every method, with hits in several orders, and through a
/// control; a frame has all passes.
///
/// # Errors
/// One sentence on what went wrong with scene or device, or if a picture depends on the order.
pub fn run(bench: &Runs) -> Result<BenchResult> {
    let device = machine::open(&bench.run.device)?;
    let mut run = bench.run.clone();
    // What must be traced before it is sorted is no order to trace in.
    run.orders.methods.retain(|method| method.termination != Termination::Real);
    run.orders.methods.push(HitOrder::place_method()?);
    let (mut rows, mut controls) = (Vec::new(), Vec::new());
    for name in &bench.scenes {
        let scene = scenes::load(name)?;
        let setup = prepared(&device, &scene, &run)?;
        say(&scene.name);
        let kernel = device.kernel(&run.device);
        let frames = Frames { run: &run, scene: &scene, setup: &setup, kernel };
        let (of_scene, control) = backends::measure(&device, &scene, &setup, kernel, frames)?;
        rows.extend(of_scene);
        controls.push(control);
    }
    let instrument = Instrument::of(controls);
    Ok(BenchResult { instrument, ..result(&device, Rows::Render(rows)) })
}

/// Where the time of a frame went, nanoseconds.
#[derive(Clone, Copy, Debug, Default)]
struct Spent {
    /// Tracing.
    trace: u64,
    /// Keys, sorting, moving paths and learning lengths.
    reorder: u64,
    /// Generating and shading rays, and adding light.
    shade: u64,
}

impl Spent {
    fn total(&self) -> u64 {
        self.trace + self.reorder + self.shade
    }
}

struct Frames<'a> {
    run: &'a RecordOptions,
    scene: &'a Scene,
    setup: &'a Setup,
    kernel: TraceKernel,
}

impl OnBackend for Frames<'_> {
    type Output = (Vec<RenderRow>, Speedup);

    /// Rows, and what the control's frames but for moving paths come to, which must be 1.
    fn run<B: Backend>(self, backend: &mut B) -> Result<Self::Output> {
        let Self { run, setup, .. } = self;
        let methods = traced_after(setup).map(Subject::Method);
        let chosen = run.orders.auto.then_some(Subject::Auto).into_iter();
        let subjects = [Subject::Unsorted, Subject::Control].into_iter().chain(chosen).chain(methods);
        let orders: Vec<FrameOrder> =
            subjects.map(FrameOrder::Rays).chain(HitOrder::ALL.map(FrameOrder::Hits)).collect();
        let auto = match run.orders.auto {
            false => None,
            true => Some(calibrated(backend, setup, run)?),
        };
        let mut made: Vec<Made<B>> = orders.iter().map(|_| Made::<B>::new()).collect();
        let frames = sampled(orders.len(), run.repeats, run.seed, |at| {
            let mut frame = Frame::new(backend, setup, (orders[at], auto.as_ref()), &mut made[at]);
            frame.render(run)?;
            Ok(frame.spent)
        })?;
        let of = |at: usize, part: fn(&Spent) -> u64| frames[at].iter().map(part).collect::<Vec<_>>();
        let (mut tallies, mut expected) = (Vec::with_capacity(orders.len()), None);
        for (&order, made) in orders.iter().zip(&mut made) {
            let mut frame = Frame::new(backend, setup, (order, auto.as_ref()), made);
            frame.tally = Some(Tally::default());
            frame.render(run)?;
            tallies.push(frame.tally);
            let found = picture(backend, run.passes)?;
            let expected = expected.get_or_insert_with(|| found.clone());
            if self.kernel.is_ours() {
                check_same(expected, &found, order.name(&setup.methods))?;
            }
        }
        let over_unsorted = |at: usize, part: fn(&Spent) -> u64| {
            (at > 0).then(|| Speedup::of(&of(0, part), &of(at, part))).flatten()
        };
        let row = |(at, order): (usize, &FrameOrder)| RenderRow {
            scene: self.scene.name.clone(),
            method: order.name(&setup.methods).to_owned(),
            width: setup.width,
            height: setup.height,
            passes: run.passes,
            bounces: run.bounces,
            frame_ns: of(at, Spent::total),
            trace_ns: of(at, |spent| spent.trace),
            reorder_ns: of(at, |spent| spent.reorder),
            speedup: over_unsorted(at, Spent::total),
            shade_speedup: over_unsorted(at, |spent| spent.shade),
            coherence: tallies[at].and_then(|tally| tally.coherence()),
        };
        let control = Speedup::of(&of(0, Spent::total), &of(1, |spent| spent.trace + spent.shade));
        let rows = orders.iter().enumerate().map(row).collect();
        Ok((rows, control.context("no frame was measured")?))
    }
}

/// Numbers of the methods whose keys need no hits.
fn traced_after(setup: &Setup) -> impl Iterator<Item = usize> {
    (0..setup.named().len()).filter(|&number| setup.methods[number].termination != Termination::Real)
}

/// What `auto` chooses by: orders measured on passes after those of a frame.
fn calibrated<B: Backend>(backend: &mut B, setup: &Setup, run: &RecordOptions) -> Result<Auto> {
    let pass = run.passes;
    let progress = Progress::new(run.bounces, calibrate::traces(setup).to_vec());
    let auto = calibrate::calibrate(backend, setup, &progress, |backend, calibrator| {
        wavefront::run(backend, pass..pass + calibrate::PASSES, run.bounces, calibrator)
    });
    progress.finish();
    auto
}

/// What a frame sorts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FrameOrder {
    /// Rays before they are traced; nothing where they stay unsorted.
    Rays(Subject),
    /// Hits before they are shaded.
    Hits(HitOrder),
}

impl FrameOrder {
    fn name(self, methods: &[MethodPlan]) -> &str {
        match self {
            Self::Rays(subject) => subject.name(methods),
            Self::Hits(order) => order.name(),
        }
    }
}

/// A queue on its way to the tracer, as it lies or by an order that does not move its paths.
struct Ordered<B: Backend> {
    rays: B::Rays,
    order: Option<(B::Permutation, Way)>,
}

/// Permutations of the queues of one order that the processor makes: in the round that does not count.
type Made<B> = BTreeMap<QueueId, <B as Backend>::Permutation>;

/// A frame in one order.
struct Frame<'a, B: Backend> {
    backend: &'a mut B,
    setup: &'a Setup,
    order: FrameOrder,
    auto: Option<&'a Auto>,
    made: &'a mut Made<B>,
    spent: Spent,
    /// What neighbours have in common, where that is counted.
    tally: Option<Tally>,
}

impl<'a, B: Backend> Frame<'a, B> {
    fn new(
        backend: &'a mut B,
        setup: &'a Setup,
        (order, auto): (FrameOrder, Option<&'a Auto>),
        made: &'a mut Made<B>,
    ) -> Self {
        Self { backend, setup, order, auto, made, spent: Spent::default(), tally: None }
    }

    /// The loop of a renderer.
    fn render(&mut self, run: &RecordOptions) -> Result<()> {
        self.backend.restart()?;
        for pass in 0..run.passes {
            let mut queue = Ordered::<B> { rays: self.backend.generate(pass)?, order: None };
            self.spent.shade += self.backend.elapsed_ns();
            for _ in 0..run.bounces {
                if queue.rays.is_empty() {
                    break;
                }
                let mut hits = self.trace(&queue)?;
                let mut rays = queue.rays;
                if let FrameOrder::Hits(order) = self.order {
                    (rays, hits) = self.sorted_hits(order, &rays, &hits)?;
                }
                if let Some(tally) = &mut self.tally {
                    tally.add(self.backend, self.setup, &rays, &hits)?;
                }
                let shaded = self.backend.shade(&rays, &hits)?;
                self.spent.shade += self.backend.elapsed_ns();
                if !shaded.shadow.is_empty() {
                    let shadow = self.ordered(shaded.shadow)?;
                    let occlusion = self.trace(&shadow)?;
                    self.backend.add_light(&shadow.rays, &occlusion)?;
                    self.spent.shade += self.backend.elapsed_ns();
                }
                queue = self.ordered(shaded.next)?;
            }
        }
        Ok(())
    }

    /// A queue in the order in which it is traced, and goes on where its paths are moved.
    fn ordered(&mut self, rays: B::Rays) -> Result<Ordered<B>> {
        let FrameOrder::Rays(order) = self.order else { return Ok(Ordered { rays, order: None }) };
        if rays.is_empty() {
            return Ok(Ordered { rays, order: None });
        }
        let sorted;
        let permutation = match order {
            Subject::Unsorted => return Ok(Ordered { rays, order: None }),
            Subject::Shuffled | Subject::Foreign(_) => {
                bail!("a renderer sorts by methods, and knows no other order")
            }
            Subject::Control => {
                made(self.made, self.backend, rays.id(), |_| Ok((0..rays.len() as u32).collect()))?
            }
            Subject::Method(method) if !self.setup.methods[method].applies_to(rays.id().kind) => {
                return Ok(Ordered { rays, order: None });
            }
            Subject::Method(method) => {
                sorted = self.permutation(&rays, method)?;
                &sorted
            }
            Subject::Auto => {
                let auto = self.auto.context("nothing chooses an order")?;
                let (decision, taken) = auto.decide(self.backend, &rays)?;
                self.spent.reorder += taken.elapsed_ns;
                let order = match decision.order {
                    Some((method, way)) => Some((self.permutation(&rays, method)?, way)),
                    None => None,
                };
                return Ok(Ordered { rays, order });
            }
        };
        let rays = self.backend.reorder(&rays, permutation)?;
        self.spent.reorder += self.backend.elapsed_ns();
        Ok(Ordered { rays, order: None })
    }

    fn permutation(&mut self, rays: &B::Rays, method: usize) -> Result<B::Permutation> {
        let keys = self.backend.key(rays, None, method)?;
        self.spent.reorder += self.backend.elapsed_ns();
        let permutation = self.backend.sort(&keys)?;
        self.spent.reorder += self.backend.elapsed_ns();
        Ok(permutation)
    }

    /// Paths and their hits in an order of hits.
    fn sorted_hits(&mut self, order: HitOrder, rays: &B::Rays, hits: &B::Hits) -> Result<(B::Rays, B::Hits)> {
        let (keys, key_ns) = order.keys(self.backend, self.setup, rays, hits)?;
        let permutation = self.backend.sort(&keys)?;
        self.spent.reorder += key_ns + self.backend.elapsed_ns();
        let sorted = self.backend.reorder(rays, &permutation)?;
        self.spent.reorder += self.backend.elapsed_ns();
        // Scattering by the inverse of a permutation is gathering by it.
        let inverse = made(self.made, self.backend, rays.id(), |backend| {
            let indices: Vec<u32> = collected(backend, Array::Permutation(&permutation))?;
            let mut inverse = vec![0; indices.len()];
            (0..).zip(&indices).for_each(|(place, &index)| inverse[index as usize] = place);
            Ok(inverse)
        })?;
        let hits = self.backend.scatter(hits, inverse)?;
        self.spent.reorder += self.backend.elapsed_ns();
        Ok((sorted, hits))
    }

    fn trace(&mut self, Ordered { rays, order }: &Ordered<B>) -> Result<B::Hits> {
        let hits = match order {
            None => self.traced(rays, Order::Stored)?,
            Some((permutation, Way::Indices)) => self.traced(rays, Order::Indirect(permutation))?,
            Some((permutation, Way::Gathered)) => {
                let gathered = self.backend.gather(rays, permutation)?;
                self.spent.reorder += self.backend.elapsed_ns();
                let hits = self.traced(&gathered, Order::Stored)?;
                let home = self.backend.scatter(&hits, permutation)?;
                self.spent.reorder += self.backend.elapsed_ns();
                home
            }
        };
        if self.learns(rays.id().kind) {
            self.backend.accumulate(rays, &hits, Table::Learnt)?;
            self.spent.reorder += self.backend.elapsed_ns();
        }
        Ok(hits)
    }

    fn traced(&mut self, rays: &B::Rays, order: Order<&B::Permutation>) -> Result<B::Hits> {
        let hits = self.backend.trace(rays, order)?;
        self.spent.trace += self.backend.elapsed_ns();
        Ok(hits)
    }

    /// Whether the method reads the length table of a kind.
    fn learns(&self, kind: Kind) -> bool {
        let FrameOrder::Rays(Subject::Method(method)) = self.order else { return false };
        let method = &self.setup.methods[method];
        method.termination == Termination::Adaptive && method.applies_to(kind)
    }
}

/// A permutation of a queue, made when it is first asked for: its order is the same in every frame.
fn made<'a, B: Backend>(
    made: &'a mut Made<B>,
    backend: &mut B,
    id: QueueId,
    indices: impl FnOnce(&mut B) -> Result<Vec<u32>>,
) -> Result<&'a B::Permutation> {
    match made.entry(id) {
        Entry::Occupied(entry) => Ok(entry.into_mut()),
        Entry::Vacant(entry) => {
            let indices = indices(backend)?;
            Ok(entry.insert(backend.upload_permutation(&indices)?))
        }
    }
}

/// Refuses a picture that is not equal to the first one, bit for bit.
fn check_same(expected: &[[f32; 3]], found: &[[f32; 3]], order: &str) -> Result<()> {
    let bits = |pixel: &[f32; 3]| pixel.map(f32::to_bits);
    let differing =
        expected.iter().zip(found).filter(|(expected, found)| bits(expected) != bits(found)).count();
    ensure!(
        differing == 0 && expected.len() == found.len(),
        "{differing} of {} pixels differ between frames of the same picture, seen first in the order of '{order}'; \
         a path must depend on itself alone ('{UNSORTED}' is the order of pixels), so this is a fault of the driver \
         or of this program: please report it",
        expected.len()
    );
    Ok(())
}

#[cfg(test)]
mod tests {

    use formats::key::Method;
    use formats::length_table::LengthCell;

    use super::*;
    use crate::options::{AskedOrders, BackendChoice, DeviceOptions};

    struct AgainstTheLoop<'a> {
        run: &'a RecordOptions,
        setup: &'a Setup,
    }

    impl OnBackend for AgainstTheLoop<'_> {
        type Output = ();

        fn run<B: Backend>(self, backend: &mut B) -> Result<()> {
            let Self { run, setup } = self;
            let lengths = |backend: &mut B| -> [Vec<LengthCell>; 2] {
                Kind::ALL.map(|kind| collected(backend, Array::Lengths(kind)).unwrap())
            };
            wavefront::run(backend, 0..run.passes, run.bounces, &mut ()).unwrap();
            let (loops_picture, loops_lengths) = (picture(backend, run.passes).unwrap(), lengths(backend));
            assert!(loops_picture.iter().flatten().any(|&light| light > 0.0));
            let methods = traced_after(setup).map(Subject::Method);
            let auto = calibrated(backend, setup, run).unwrap();
            let subjects = [Subject::Unsorted, Subject::Control, Subject::Auto].into_iter().chain(methods);
            let orders = subjects.map(FrameOrder::Rays).chain(HitOrder::ALL.map(FrameOrder::Hits));
            // As if every order had been worth it, traced either way.
            let sure = Way::ALL.map(|way| {
                let mut calibration = auto.calibration().to_vec();
                for candidate in calibration.iter_mut().flat_map(|queue| &mut queue.candidates) {
                    (candidate.choice.way, candidate.net_low) = (way, 2.0);
                }
                Auto::new(setup, calibration).unwrap()
            });
            let sure = sure.iter().map(|auto| (FrameOrder::Rays(Subject::Auto), auto));
            for (order, auto) in orders.map(|order| (order, &auto)).chain(sure) {
                let mut made = Made::<B>::new();
                Frame::new(backend, setup, (order, Some(auto)), &mut made).render(run).unwrap();
                let mut frame = Frame::new(backend, setup, (order, Some(auto)), &mut made);
                frame.render(run).unwrap();
                let (spent, learns) = (frame.spent, Kind::ALL.map(|kind| frame.learns(kind)));
                let name = order.name(&setup.methods);
                check_same(&loops_picture, &picture(backend, run.passes).unwrap(), name).unwrap();
                assert_eq!(spent.reorder > 0, order != FrameOrder::Rays(Subject::Unsorted), "{name}");
                for ((learns, found), expected) in
                    learns.into_iter().zip(lengths(backend)).zip(&loops_lengths)
                {
                    assert_eq!(found, if learns { &expected[..] } else { &[] }, "{name}");
                }
            }
            Ok(())
        }
    }

    #[test]
    fn frames_in_any_order_are_the_picture_of_the_loop() {
        for backend in [BackendChoice::Cpu, BackendChoice::Gpu] {
            let methods = ["origin", "aila", "two-point-adaptive", "light-octahedron"];
            let methods = methods.map(|name| Method::builtin(name).unwrap()).into_iter();
            let run = RecordOptions {
                width: 97,
                height: 61,
                bounces: 4,
                passes: 2,
                orders: AskedOrders {
                    methods: methods.chain(HitOrder::place_method()).collect(),
                    auto: true,
                    ..AskedOrders::default()
                },
                device: DeviceOptions { backend, threads: Some(2), ..DeviceOptions::default() },
                ..RecordOptions::base().unwrap()
            };
            let device = machine::open(&run.device).unwrap();
            for name in ["builtin:cornell", "builtin:atrium", "builtin:apartment"] {
                let scene = scenes::load(name).unwrap();
                let setup = prepared(&device, &scene, &run).unwrap();
                let work = AgainstTheLoop { run: &run, setup: &setup };
                backends::measure(&device, &scene, &setup, device.kernel(&run.device), work).unwrap();
            }
        }
    }
}
