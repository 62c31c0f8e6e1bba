//! Turns and rounds, and what a backend is asked for in them.

use std::sync::Arc;

use anyhow::bail;
use formats::manifest::{self, CalibrationRecord, Candidate, Choice};
use formats::ray::Ray;

use super::*;
use crate::auto;
use crate::backends::cpu::CpuBackend;
use crate::backends::{Array, RecordedRays, Shaded, Sink};
use crate::stages::setup::Setup;

#[test]
fn what_can_be_traced_in_two_ways_takes_two_turns() {
    let subjects =
        [Subject::Unsorted, Subject::Control, Subject::Method(3), Subject::Auto, Subject::Shuffled];
    let ordered = |subject| Ordered { subject, source: None::<Source<()>>, mismatches: 0 };
    let orders = Orders(subjects.map(ordered).into());
    let [gathered, indices] = Way::ALL;
    let of_two_ways = |at| [(at, gathered), (at, indices)];
    let expected = [&[(0, gathered), (1, gathered)][..], &of_two_ways(2), &[(3, gathered)], &of_two_ways(4)];
    assert_eq!(orders.turns(), expected.concat());
}

#[test]
fn each_takes_its_turn_once_a_round_and_nothing_always_follows_the_same() {
    let mut turns = Vec::new();
    in_rounds(3, 40, 7, |at, round| {
        turns.push((round, at));
        Ok(())
    })
    .unwrap();
    let mut orders = std::collections::BTreeSet::new();
    for (number, round) in turns.chunks(3).enumerate() {
        assert!(round.iter().all(|turn| turn.0 == (number as u32).checked_sub(1)), "{round:?}");
        let order: Vec<usize> = round.iter().map(|turn| turn.1).collect();
        assert_eq!(order.iter().sum::<usize>(), 3, "each of 0, 1 and 2: {order:?}");
        orders.insert(order);
    }
    assert_eq!((turns.len(), orders.len()), (3 * 41, 6), "{orders:?}");
    let samples = sampled(2, 3, 0, |at| Ok(at + 5)).unwrap();
    assert_eq!(samples, [[5; 3], [6; 3]], "the first round does not count");
}

/// Notes the verbs of a turn.
struct Noting {
    backend: CpuBackend,
    verbs: Vec<&'static str>,
}

/// Those that are noted by their names.
const NOTED: [&str; 6] = ["forget", "key", "sort", "gather", "trace", "scatter"];

type Rays = <CpuBackend as Backend>::Rays;
type Hits = <CpuBackend as Backend>::Hits;
type Keys = <CpuBackend as Backend>::Keys;
type Permutation = <CpuBackend as Backend>::Permutation;

macro_rules! handed_on {
    ($($verb:ident($($name:ident: $type:ty),*) -> $given:ty;)*) => {
        $(fn $verb(&mut self, $($name: $type),*) -> Result<$given> {
            self.verbs.extend(NOTED.iter().find(|noted| **noted == stringify!($verb)));
            self.backend.$verb($($name),*)
        })*
    };
}

impl Backend for Noting {
    type Rays = Rays;
    type Hits = Hits;
    type Keys = Keys;
    type Permutation = Permutation;

    fn sample(&self) -> Sample {
        self.backend.sample()
    }

    handed_on! {
        restart() -> ();
        generate(pass: u32) -> Rays;
        upload(queue: RecordedRays<'_>) -> Rays;
        upload_permutation(indices: &[u32]) -> Permutation;
        upload_keys(keys: &[u64], bits: u32) -> Keys;
        trace(rays: &Rays, order: Order<&Permutation>) -> Hits;
        forget(rays: &Rays) -> ();
        accumulate(rays: &Rays, hits: &Hits, table: Table) -> ();
        shade(rays: &Rays, hits: &Hits) -> Shaded<Rays>;
        add_light(rays: &Rays, hits: &Hits) -> ();
        key(rays: &Rays, hits: Option<&Hits>, method: usize) -> Keys;
        sort(keys: &Keys) -> Permutation;
        scatter(hits: &Hits, permutation: &Permutation) -> Hits;
        gather(rays: &Rays, permutation: &Permutation) -> Rays;
        reorder(rays: &Rays, permutation: &Permutation) -> Rays;
        differences(hits: &Hits, others: &Hits) -> u64;
    }

    fn read(&mut self, array: Array<'_, Self>, sink: &mut Sink<'_>) -> Result<()> {
        let Array::Sample(rays) = array else { bail!("a turn reads nothing but a sample") };
        self.verbs.push("decide");
        self.backend.read(Array::Sample(rays), sink)
    }
}

/// What is asked for in the turns of measuring a queue whose order a calibration of another bounce decides: canonical
/// order, the control, what was chosen and a method.
fn turns(calibration: Vec<CalibrationRecord>) -> BTreeMap<String, usize> {
    let setup = Setup::made_up(false, 32);
    let candidates = auto::candidates(manifest::Backend::Cpu, &calibration, setup.extent(), 0.25).unwrap();
    let setup = Arc::new(setup.with_candidates(candidates));
    let mut backend = Noting { backend: CpuBackend::in_cornell(setup.clone()), verbs: Vec::new() };
    let ray = Ray { origin: [0.0; 3], t_min: 0.0, direction: [0.0, 0.0, 1.0], t_max: 1.0 };
    let rays = backend.backend.shadow_queue(0, &[ray; 100]);
    let hits = backend.trace(&rays, Order::Stored).unwrap();
    let auto = Auto::new(&setup, calibration).unwrap();
    let orders = vec![Subject::Unsorted, Subject::Control, Subject::Auto, Subject::Method(2)];
    let measured = Measured { orders, repeats: 3, seed: 0 };
    let queue = Queued { rays: &rays, hits: &hits, methods: &setup.methods, foreign: &[], auto: Some(&auto) };
    let orders = queue.warm_up(&mut backend, &measured, |_, _, _, _| Ok(())).unwrap();
    backend.verbs.clear();
    queue.measure(&mut backend, &measured, &orders).unwrap();
    let mut turns = BTreeMap::new();
    let mut verbs = backend.verbs.into_iter().peekable();
    while let Some(first) = verbs.next() {
        let mut turn = vec![first];
        let is_begun = |turn: &[&str], verb: &str| verb == "decide" || verb == "forget" && turn != ["decide"];
        while let Some(verb) = verbs.next_if(|verb| !is_begun(&turn, verb)) {
            turn.push(verb);
        }
        *turns.entry(turn.join(" ")).or_default() += 1;
    }
    turns
}

/// A decision after `forget` would slow the trace that follows: its clock disturbs the caches.
#[test]
fn a_turn_decides_then_forgets_then_does_what_is_timed() {
    let candidate = |way| {
        let choice = Choice { method: "aila".to_owned(), key_bits: 15, way };
        Candidate { choice, net: 1.5, net_low: 1.4 }
    };
    // As many rays and the area of rays that are all alike, so that a look says which one the queue is like.
    let alike =
        |candidates| CalibrationRecord { bounce: 7, kind: Kind::Shadow, rays: 100, area: 0.0, candidates };
    let unlike = |candidates| CalibrationRecord { area: 1e9, ..alike(candidates) };
    let cases = [
        (vec![alike(Vec::new()), unlike(vec![candidate(Way::Gathered)])], "decide forget trace"),
        (vec![alike(vec![candidate(Way::Gathered)])], "decide forget key sort gather trace scatter"),
        (vec![alike(vec![candidate(Way::Indices)])], "decide forget key sort trace"),
    ];
    for (calibration, decided) in cases {
        let expected = [
            decided,
            "forget gather trace scatter",
            "forget key sort gather trace scatter",
            "forget key sort trace",
            "forget trace",
        ];
        assert_eq!(turns(calibration), expected.map(|turn| (turn.to_owned(), 4)).into());
    }
}

#[test]
fn a_queue_of_a_calibrated_bounce_and_length_gets_its_order_without_a_look() {
    let choice = Choice { method: "aila".to_owned(), key_bits: 15, way: Way::Indices };
    let candidates = vec![Candidate { choice, net: 1.5, net_low: 1.4 }];
    let known = CalibrationRecord { bounce: 1, kind: Kind::Shadow, rays: 110, area: 1e9, candidates };
    // `auto` and the method through indices; canonical order; the control; the method gathered.
    let expected = [
        ("forget key sort trace", 8),
        ("forget trace", 4),
        ("forget gather trace scatter", 4),
        ("forget key sort gather trace scatter", 4),
    ];
    assert_eq!(turns(vec![known]), expected.map(|(turn, count)| (turn.to_owned(), count)).into());
}
