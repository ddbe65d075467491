#!/usr/bin/env bash
# The number of tests that a log tells of: those of cargo, of unittest, and programs that end with "NAME: good".
#   tests/count.sh LOG
awk '
    /^test result: .* [0-9]+ passed/ { sub(/.*: ok\. |.*: FAILED\. /, ""); count += $1 }
    /^Ran [0-9]+ tests? in/ { count += $2 }
    /^[a-z_+]+: good/ { count += 1 }
    END { print count + 0 }' "$1"
