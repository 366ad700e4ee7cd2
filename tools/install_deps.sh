#!/usr/bin/env bash
# Installs what a set of targets needs and the system lacks: install_deps.sh build|test|exr|extra [COMPILER].
# Silent and quick when nothing is missing. Where apt may not be used, names the exact command and fails.
set -u
set=${1:?build, test or extra}
compiler=${2:-g++}
compiler=${compiler%% *}
missing=()

need() {  # need PACKAGE CONDITION...: the package is missing unless the condition holds
  local package=$1
  shift
  "$@" >/dev/null 2>&1 || missing+=("$package")
}
tool() { command -v "$1"; }
header() { [ -e "/usr/include/$1" ] || [ -e "/usr/local/include/$1" ]; }
clang_runtime() { compgen -G '/usr/lib/llvm-*/lib/clang/*/lib/linux/libclang_rt.fuzzer-*.a'; }

check() {
  missing=()
  case $set in
    build)
      case $compiler in
        clang++*) need clang tool "$compiler" ;;
        aarch64*) need g++-aarch64-linux-gnu tool "$compiler" ;;
        *) need g++ tool "$compiler" ;;
      esac
      need libglm-dev header glm/glm.hpp
      need libfmt-dev header fmt/format.h
      need libpng-dev header png.h
      need libcli11-dev header CLI/CLI.hpp
      ;;
    test)
      need catch2 header catch2/catch.hpp
      need valgrind tool valgrind
      need strace tool strace
      need binutils tool nm
      ;;
    exr)
      need libopenexr-dev header OpenEXR/ImfOutputFile.h
      ;;
    extra)
      need clang tool clang++
      need libclang-rt-14-dev clang_runtime
      need clang-format tool clang-format
      need clang-tidy tool clang-tidy
      need qemu-user tool qemu-aarch64
      need g++-aarch64-linux-gnu tool aarch64-linux-gnu-g++
      ;;
    *)
      echo "install_deps.sh: unknown set '$set': build, test, exr or extra" >&2
      exit 2
      ;;
  esac
}

check
[ ${#missing[@]} -eq 0 ] && exit 0

install=(apt-get install -y --no-install-recommends "${missing[@]}")
if ! command -v apt-get >/dev/null; then
  echo "Missing, and there is no apt-get here; the Debian packages are: ${missing[*]}" >&2
  exit 1
fi
if [ "$(id -u)" -eq 0 ]; then
  as_root=()
elif sudo -n true 2>/dev/null; then
  as_root=(sudo -n)
else
  echo "Missing packages; run: sudo ${install[*]}" >&2
  exit 1
fi
echo "Installing ${missing[*]}"
log=$(mktemp)
if ! { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update &&
       "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive "${install[@]}"; } >"$log" 2>&1; then
  tail -n 20 "$log" >&2
  echo "Could not install; the command was: ${install[*]}" >&2
  rm -f "$log"
  exit 1
fi
rm -f "$log"
check
if [ ${#missing[@]} -ne 0 ]; then
  echo "Still missing after installation: ${missing[*]}" >&2
  exit 1
fi
