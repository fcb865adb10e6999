#!/bin/sh
# fresh.sh DIRECTORY COMMAND... - runs the command in an empty directory, so that a test finds
# nothing an earlier run left behind.
set -e
rm -rf "$1"
mkdir -p "$1"
cd "$1"
shift
exec "$@"
