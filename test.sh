#!/usr/bin/env bash
# Builds contourd into build/ and runs all its tests. Arguments go to ctest, such as -R REGEX.
set -euo pipefail
cd "$(dirname "$0")"
.ci/install-packages
.ci/build build
exec .ci/run-tests build "$@"
