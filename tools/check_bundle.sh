#!/usr/bin/env bash
# Runs a bundle where nothing of this machine can help it: in a root folder that holds glibc, a shell, and, for one of the
# runs, a software OpenGL driver. Usage: check_bundle.sh ARCHIVE.tar.gz (as root, or where user namespaces are allowed)
set -euo pipefail
archive=$(readlink -f "$1")
lib=/usr/lib/x86_64-linux-gnu
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT

fail() {
  echo "check_bundle: $*" >&2
  exit 1
}

# copy ROOT FILE...: files with the libraries that they need, at their own paths.
copy() {
  local root=$1 file
  shift
  for file in "$@" $(for file in "$@"; do ldd "$file" 2>/dev/null; done | grep -oE '/[^ ]+' | sort -u); do
    mkdir -p "$root$(dirname "$file")"
    cp -nL "$file" "$root$file"
  done
}

make_root() {  # a machine with glibc and a shell, without C++ and without OpenGL
  mkdir -p "$1"/{dev,proc,tmp,usr/bin,usr/lib/x86_64-linux-gnu,usr/lib64,opt,root}
  : >"$1/dev/null"  # an ordinary file does
  ln -s usr/bin usr/lib usr/lib64 "$1/"
  local tools=()
  for tool in sh readlink mktemp wc rm uname getconf; do tools+=("/usr/bin/$tool"); done
  copy "$1" "${tools[@]}"
  copy "$1" "$lib"/{libc,libm,libdl,librt,libpthread}.so.[0-9]
  tar -xzf "$archive" -C "$1/opt"
  mv "$1"/opt/crowdbench-* "$1/opt/moved"
}

add_driver() {  # Mesa's software rasteriser and its C++ run time
  copy "$1" "$lib"/libEGL_mesa.so.0 "$lib"/dri/swrast_dri.so
  mkdir -p "$1/usr/share/glvnd"
  cp -r /usr/share/glvnd/egl_vendor.d "$1/usr/share/glvnd/"
}

add_loaders() {  # glvnd
  copy "$1" "$lib"/libEGL.so.1
  for name in libOpenGL.so.0 libGL.so.1; do [ ! -e "$lib/$name" ] || copy "$1" "$lib/$name"; done
}

inside() {  # ROOT COMMAND...; /proc is there, in a mount namespace of its own
  local as_root=()
  [ "$(id -u)" -eq 0 ] || as_root=(--map-root-user)
  # shellcheck disable=SC2016
  env -i HOME=/root PATH=/usr/bin:/usr/sbin unshare --mount "${as_root[@]}" \
    sh -c 'mount --rbind /proc "$1/proc" && root=$1 && shift && exec chroot "$root" "$@"' sh "$@"
}

bare=$stage/bare
make_root "$bare"
inside "$bare" /opt/moved/crowdbench --version || fail "does not start on a machine without C++ libraries"
status=0
inside "$bare" /opt/moved/selfcheck >"$stage/said" 2>&1 || status=$?
cat "$stage/said"
[ "$status" -eq 2 ] || fail "without OpenGL: status $status instead of 2"
[ "$(wc -l <"$stage/said")" -eq 1 ] || fail "without OpenGL: more than one line"
grep -q 'a driver with OpenGL 4.5 core is needed' "$stage/said" || fail "without OpenGL: the line does not say what is needed"

full=$stage/full
make_root "$full"
add_driver "$full"
inside "$full" /opt/moved/selfcheck --device surfaceless || fail "does not draw with a driver that has no loaders in front"
add_loaders "$full"
inside "$full" /opt/moved/selfcheck --device surfaceless || fail "does not draw with Mesa's software OpenGL"
echo "check_bundle: fine"
