#!/bin/sh
# fresh.sh DIRECTORY COMMAND... - runs the command in an empty directory, so that a test finds no
# files of an earlier run. DIRECTORY.mpi is for the files of Open MPI: it removes a directory with the
# last of its processes, and a process of another test that starts at that moment would fail.
set -e
rm -rf "$1" "$1.mpi"
mkdir -p "$1" "$1.mpi"
export OMPI_MCA_orte_tmpdir_base="$1.mpi"
cd "$1"
shift
exec "$@"
