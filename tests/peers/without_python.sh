#!/usr/bin/env bash
# Whether the Rust part needs no Python: runs a command where no interpreter can be found.
#
#   tests/peers/without_python.sh [COMMAND ...]
#
# Without a command it shows that nothing of the default members depends on Python, and lints and documents the whole workspace, the
# Python package among them. `tests/peers/without_python.sh cargo test --release` runs all tests.
set -euo pipefail
cd "$(dirname "$0")/../.."

programs=$(mktemp -d)
trap 'rm -r "$programs"' EXIT
IFS=: read -ra folders <<<"$PATH"
for folder in "${folders[@]}"; do
    for program in "$folder"/*; do
        name=${program##*/}
        case $name in
        python* | pypy*) ;;
        *) [[ -x $program && ! -e $programs/$name ]] && ln -s "$program" "$programs/$name" ;;
        esac
    done
done
unset PYO3_PYTHON PYO3_CONFIG_FILE PYTHONHOME PYTHONPATH VIRTUAL_ENV CONDA_PREFIX
export PATH=$programs
for name in python python3; do
    if command -v "$name"; then
        echo "$name is still found" >&2
        exit 1
    fi
done

if (($#)); then
    "$@"
    exit
fi
if cargo tree --locked --edges all | grep pyo3; then
    echo "a default member depends on pyo3" >&2
    exit 1
fi
cargo clippy --release --workspace --all-targets --locked -- -D warnings
RUSTDOCFLAGS="-D warnings" cargo doc --release --workspace --no-deps --locked
