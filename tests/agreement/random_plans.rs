//! Plans of random scenes: none panics, and all predictions are numbers.
//!
//! | variable | what it sets | default |
//! | --- | --- | --- |
//! | `NEREUS_PLANS` | how many plans | 100 times `NEREUS_CASES` |
//! | `NEREUS_SEED` | seed of the first; the others follow | 1 |
//!
//! `NEREUS_PLANS=10000 cargo test --test agreement random_plans -- --nocapture`

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::Instant;

use crate::cases::cases;
use crate::runs::{plan, scene};
use nereus::config;
use nereus::pipeline::build;

use super::random_scene::random_scene;
use super::random_scenes::{of_seeds, variable};

/// Predicted error of the plan of a seed, dB; what refuses it.
fn predicted_db(seed: u64) -> Result<f64, String> {
    let scene = random_scene(seed);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scene-{seed}.toml"));
    let run = config::parse(&scene.text, &path, &[]).map_err(|error| error.to_string())?;
    let stream = build::stream(&run, 0..run.scene.pulses).map_err(|error| error.to_string())?;
    let plan = stream.factory().plan().ok_or("there is no plan")?;
    Ok(plan.prediction.total_db())
}

#[test]
fn plans_of_random_scenes_do_not_panic() {
    let (first, count) = (variable("NEREUS_SEED", 1), variable("NEREUS_PLANS", cases(100).into()));
    let begun = Instant::now();
    let plans = of_seeds(first, count, |seed| catch_unwind(AssertUnwindSafe(|| predicted_db(seed))));
    let (mut panicked, mut no_number, mut refused) = (Vec::new(), Vec::new(), Vec::new());
    for (seed, planned) in plans {
        match planned {
            Err(_) => panicked.push(seed),
            Ok(Ok(db)) if db.is_nan() => no_number.push(seed),
            Ok(Ok(_)) => {}
            Ok(Err(why)) => {
                println!("seed {seed} refused: {why}");
                refused.push(seed);
            }
        }
    }
    println!(
        "{count} plans in {:.0} s, panicked {panicked:?}, no number {no_number:?}, refused {refused:?}",
        begun.elapsed().as_secs_f64()
    );
    assert!(panicked.is_empty(), "plans that panicked: seeds {panicked:?}");
    assert!(no_number.is_empty(), "predictions that are no numbers: seeds {no_number:?}");
    assert!(refused.is_empty(), "scenes that are not legal: seeds {refused:?}");
}

/// Light wind over coarse facets: waves whose squared variance is no number.
#[test]
fn light_wind_over_coarse_facets_is_planned() {
    for case in ["panic-wind-0.3", "panic-facet30-wind1.5"] {
        let run = scene(&format!("tests/data/cases/{case}.toml"), &[]);
        let predicted_db = plan(&run).prediction.total_db();
        assert!(!predicted_db.is_nan(), "{case}: {predicted_db}");
    }
}
