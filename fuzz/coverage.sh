#!/bin/sh
# Wrapper of rustc: coverage for what is fuzzed. See tools/fuzz.
rustc=$1
shift
case " $* " in
*" --crate-name build_script"*) exec "$rustc" "$@" ;;
*" --cfg fuzzing "*) ;;
*) exec "$rustc" "$@" ;;
esac
case " $* " in
*" --crate-name nereus "* | *" --crate-name toml "* | *" --crate-name toml_parser "* | *" --crate-name serde_json "* | *"fuzz_targets/"*)
    exec "$rustc" "$@" -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=3 \
        -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table
    ;;
esac
exec "$rustc" "$@"
