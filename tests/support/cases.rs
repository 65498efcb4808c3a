//! How many cases a test has.
#![allow(dead_code, reason = "not every test has cases of each kind")]

use proptest::prelude::ProptestConfig;

/// `n` cases, scaled by the factor in `NEREUS_CASES` (1 without it): at least one.
pub fn cases(n: u32) -> u32 {
    let factor = std::env::var("NEREUS_CASES").map_or(1.0, |text| {
        let factor = text.parse().ok().filter(|factor: &f64| factor.is_finite() && *factor > 0.0);
        factor.unwrap_or_else(|| panic!("NEREUS_CASES: {text}; allowed: a factor above 0, such as 0.1 or 10"))
    });
    (f64::from(n) * factor).round().max(1.0) as u32
}

/// The first [`cases`] of a list: what shows most in least time stands first.
pub fn some_of<I: IntoIterator<IntoIter: ExactSizeIterator>>(list: I) -> impl Iterator<Item = I::Item> {
    let list = list.into_iter();
    let count = cases(list.len() as u32) as usize;
    list.take(count)
}

/// What is as large as it should be, or enough where there are to be fewer [`cases`].
pub fn sized<T>(whole: T, enough: T) -> T {
    if cases(100) < 100 { enough } else { whole }
}

/// The settings of a `proptest!` with so many [`cases`].
pub fn proptests(n: u32) -> ProptestConfig {
    ProptestConfig::with_cases(cases(n))
}
