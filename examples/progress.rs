//! Measures the stages of a run on a torus, its longest silence, and how soon it stops.
//!
//! `cargo run --release --example progress -- FACES RATIO THREADS [STOPS]` Without `STOPS` prints for each stage its share
//! of the time, the progress reported at its end, and the longest time between two events. Otherwise stops the run at
//! `STOPS` random moments and prints the longest times to return.

use std::error::Error;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use neural_mesh::mesh::{TriMesh, shapes};
use neural_mesh::simplify::{Event, Options, SimplifyError, Size, simplify};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let numbers: Vec<f64> = std::env::args().skip(1).map(|word| word.parse()).collect::<Result<_, _>>()?;
    let &[faces, ratio, threads, ref stops @ ..] = &numbers[..] else {
        return Err("FACES RATIO THREADS [STOPS]".into());
    };
    // The torus has twice as many vertices around as across.
    let across = (faces / 4.0).sqrt().round() as u32;
    let mesh = shapes::torus(2 * across, across, 1.0, 0.4);
    let options = Options::new(Size::Ratio(ratio));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads as usize).build()?;
    let whole = pool.install(|| stages(&mesh, &options))?;
    match stops {
        [n] => pool.install(|| stop(&mesh, &options, *n as usize, whole)),
        _ => Ok(()),
    }
}

/// Reports of one stage.
struct Stage {
    name: &'static str,
    began: Instant,
    done: f32,
    silence: Duration,
    n_events: usize,
}

/// Prints the stages of a whole run; returns its duration.
fn stages(mesh: &TriMesh, options: &Options) -> Result<Duration, SimplifyError> {
    let mut stages: Vec<Stage> = Vec::new();
    let begin = Instant::now();
    let mut last = begin;
    let mut total = 0.0;
    let result = simplify(mesh, options, &mut |event: Event| {
        let now = Instant::now();
        if let Some(stage) = stages.last_mut() {
            stage.silence = stage.silence.max(now - last);
        }
        if stages.last().is_none_or(|stage| stage.name != event.stage) {
            stages.push(Stage { name: event.stage, began: now, done: 0.0, silence: Duration::ZERO, n_events: 0 });
        }
        if let Some(stage) = stages.last_mut() {
            (stage.done, stage.n_events) = (event.done, stage.n_events + 1);
        }
        (last, total) = (now, event.total);
        ControlFlow::Continue(())
    })?;
    let end = Instant::now();
    let n_faces = result.mesh.faces().len();
    let seconds = |time: Duration| time.as_secs_f64();
    println!("{} faces to {n_faces} in {:.2} s, the end at {total:.3}", mesh.faces().len(), seconds(end - begin));
    for (i, stage) in stages.iter().enumerate() {
        let over = stages.get(i + 1).map_or(end, |next| next.began);
        let silence = if i + 1 < stages.len() { stage.silence } else { stage.silence.max(end - last) };
        let share = seconds(over - stage.began) / seconds(end - begin);
        let Stage { name, done, n_events, .. } = stage;
        println!(
            "{name:10} {share:.3} of the time, done {done:.3}, {n_events} events, silent {:.3} s",
            seconds(silence)
        );
    }
    Ok(end - begin)
}

/// Stops runs at random moments of `whole` and prints the longest times to return.
fn stop(mesh: &TriMesh, options: &Options, n: usize, whole: Duration) -> Result<(), Box<dyn Error + Send + Sync>> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut times = Vec::new();
    for i in 0..n {
        let share = (i as f64 + f64::from(random.next_u32()) / f64::from(u32::MAX)) / n as f64;
        let (asked, asked_at, stage) = (AtomicBool::new(false), Mutex::new(None), Mutex::new(""));
        let result = std::thread::scope(|scope| {
            scope.spawn(|| {
                std::thread::sleep(whole.mul_f64(share));
                *asked_at.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
                asked.store(true, Relaxed);
            });
            let result = simplify(mesh, options, &mut |event: Event| {
                *stage.lock().unwrap_or_else(PoisonError::into_inner) = event.stage;
                if asked.load(Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
            (result.is_err(), Instant::now())
        });
        let asked_at = asked_at.into_inner().unwrap_or_else(PoisonError::into_inner).ok_or("never asked")?;
        if let (true, returned) = result {
            times.push((
                (returned - asked_at).as_secs_f64(),
                stage.into_inner().unwrap_or_else(PoisonError::into_inner),
            ));
        }
    }
    times.sort_by(|x, y| x.0.total_cmp(&y.0));
    let slowest: Vec<String> =
        times.iter().rev().take(5).map(|(time, stage)| format!("{time:.3} s in {stage}")).collect();
    println!("{} of {n} stopped; the slowest: {}", times.len(), slowest.join(", "));
    Ok(())
}
