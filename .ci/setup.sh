# Sourced by quickstart and check, in the root of the source tree.

# need_packages PACKAGE... - installs missing Debian packages; on other systems, or without the right to
# install, prints their names and continues.
need_packages() {
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "Not a Debian system: make sure you have what these Debian packages hold: $*"
    return
  fi
  local package missing=() sudo=()
  for package in "$@"; do
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] ||
      missing+=("$package")
  done
  if [ ${#missing[@]} -eq 0 ]; then return; fi

  if [ "$(id -u)" -ne 0 ]; then sudo=(sudo); fi
  if [ "$(id -u)" -ne 0 ] && ! command -v sudo >/dev/null; then
    echo "Neither root nor sudo: please have these packages installed: ${missing[*]}"
    return
  fi
  echo "Installing ${missing[*]}"
  if ! { "${sudo[@]}" apt-get update -qq &&
         "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive \
           apt-get install -y -qq --no-install-recommends "${missing[@]}"; } </dev/null; then
    echo "apt-get failed; going on without some of: ${missing[*]}"
  fi
}

build_packages=(petsc-dev libhypre-dev libhdf5-mpi-dev libmuparser-dev
                libopenmpi-dev openmpi-bin gcc make cmake pkg-config)
picture_packages=(python3 python3-h5py python3-matplotlib python3-numpy)
check_packages=(libcmocka-dev clang-format python3 python3-vtk9)

# picture_python - prints an interpreter with h5py and matplotlib; the first python3 of the PATH may lack them.
picture_python() {
  local python
  for python in python3 /usr/bin/python3; do
    if "$python" -c 'import h5py, matplotlib' 2>/dev/null; then
      echo "$python"
      return
    fi
  done
  return 1
}

# Open MPI refuses to start as root, the user of a container, without these two settings.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1
