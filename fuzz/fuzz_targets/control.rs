//! Words that change a run: what is read is written as it was meant.
#![no_main]

use libfuzzer_sys::fuzz_target;
use nereus::motion::changes::addressed;

fuzz_target!(|text: &str| {
    match addressed(text) {
        Ok((change, _)) => assert_eq!(change.to_string().parse(), Ok(change)),
        Err(fault) => assert!(!fault.to_string().contains('\u{1b}')),
    }
});
