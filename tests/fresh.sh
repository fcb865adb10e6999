#!/bin/sh
# fresh.sh DIRECTORY COMMAND... - runs the command in an empty directory, so that a test finds no
# files of an earlier run.
set -e
rm -rf "$1"
mkdir -p "$1"
cd "$1"
shift
exec "$@"
