#!/usr/bin/env bash
# One relocatable archive of the driver and the libraries that it needs to render, measure and write PNG, for an x86-64
# Linux without this project's packages. Usage: bundle.sh [--with-tests] BUILD_DIR OUT.tar.gz
# --with-tests: also gpu_check with what it needs: test_renderers, the golden pictures, figures.sh.
#
# What comes from the target machine and is never bundled: glibc (its parts must match the loader's), OpenGL drivers, and X11
# (only `view` needs it). The loaders in front of the drivers (libEGL, libOpenGL, libGLdispatch: glvnd) are in lib/glvnd and
# used where the machine has none. The modules that bring OpenImageIO and FFmpeg are
# left out; the driver says so when something asks for them.
# A command whose reader leaves early ends by a signal, and pipefail takes that for a failure: every reader here reads on.
set -euo pipefail
limit_mib=48

fail() {
  echo "bundle: $*" >&2
  exit 2
}
with_tests=
if [ "${1:-}" = --with-tests ]; then
  with_tests=yes
  shift
fi
[ $# -eq 2 ] || fail "usage: bundle.sh [--with-tests] BUILD_DIR OUT.tar.gz"
source_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$(cd "$1" && pwd) || fail "no build folder $1"
mkdir -p "$(dirname "$2")"
out=$(cd "$(dirname "$2")" && pwd)/$(basename "$2")
driver=$build/bin/crowdbench
[ -x "$driver" ] || fail "no driver in $build/bin; run ./run build first"
for tool in patchelf ldd strip readelf cc dpkg-query; do
  command -v "$tool" >/dev/null || fail "$tool is missing; packages.txt names what brings it"
done

stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT
name=crowdbench-$("$driver" --version | cut -d' ' -f2)-x86_64-linux
top=$stage/$name
mkdir -p "$top/bin" "$top/lib/fallback" "$top/licences"

# ---- what goes in -----------------------------------------------------------------------------------------------------

from_target() {  # names of libraries that the target machine provides
  case "$1" in
    linux-vdso.so.* | ld-linux* | libc.so.* | libm.so.* | libdl.so.* | librt.so.* | libpthread.so.* | libresolv.so.*) ;;
    libEGL.so.* | libGL.so.* | libGLX.so.* | libOpenGL.so.* | libGLdispatch.so.* | libgbm.so.* | libdrm*.so.*) ;;
    libX*.so.* | libxcb*.so.* | libwayland*.so.* | libbsd.so.*) ;;
    *) return 1 ;;
  esac
}

# Libraries that the target's OpenGL driver may need in a newer version than ours: used only where they are missing there.
fallback() {
  case "$1" in
    libstdc++.so.6 | libgcc_s.so.1 | libz.so.1) ;;
    *) return 1 ;;
  esac
}

objects=("$driver")
for module in window draco assimp; do
  [ -f "$build/bin/crowdbench_$module.so" ] || fail "no crowdbench_$module.so in $build/bin; run ./run build first"
  objects+=("$build/bin/crowdbench_$module.so")
done
if [ -n "$with_tests" ]; then
  [ -x "$build/bin/test_renderers" ] || fail "no test_renderers in $build/bin; build it first"
  objects+=("$build/bin/test_renderers")
fi
install -m 755 "${objects[@]}" "$top/bin/"

copied=()
while read -r soname _ path _; do
  [ -n "$soname" ] || continue
  from_target "$soname" && continue
  [ -f "$path" ] || fail "$soname: not found by the loader"
  place=$top/lib/$soname
  fallback "$soname" && place=$top/lib/fallback/$soname
  [ -e "$place" ] && continue
  install -m 755 "$path" "$place"
  copied+=("$path")
done < <(ldd "${objects[@]}" | grep '=>' | grep -v '^/' | sort -u)

mkdir -p "$top/lib/glvnd"
for soname in libEGL.so.1 libOpenGL.so.0 libGLdispatch.so.0; do
  path=$(ldconfig -p | awk -v name="$soname" '$1 == name && /x86-64/ && !n++ { print $NF }')
  [ -n "$path" ] || fail "$soname is missing (libegl1, libopengl0, libglvnd0)"
  install -m 755 "$path" "$top/lib/glvnd/$soname"
  copied+=("$path")
done

# Debian's OpenCV asks for libGLX (and with it X11) for three functions that only its OpenCL interoperation calls. A
# stand-in of another name gives it those, so that a machine without X11 can load it and nothing shadows a real libGLX.
for library in "$top"/lib/*.so*; do
  if readelf -d "$library" | grep -q 'NEEDED.*\[libGLX\.so\.0\]'; then
    if [ ! -e "$top/lib/libcrowdbench_noglx.so" ]; then
      printf 'void *%s(void) { return 0; }\n' glXGetCurrentContext glXGetCurrentDisplay glXGetProcAddressARB |
        cc -shared -fPIC -O1 -Wl,-soname,libcrowdbench_noglx.so -o "$top/lib/libcrowdbench_noglx.so" -x c -
    fi
    patchelf --replace-needed libGLX.so.0 libcrowdbench_noglx.so "$library"
  fi
done

# Everything is found from where the archive was unpacked. RPATH, not RUNPATH: it also serves the libraries' own needs
# and is not overruled by LD_LIBRARY_PATH.
strip --strip-unneeded "$top"/bin/* "$top"/lib/*.so* "$top"/lib/fallback/* "$top"/lib/glvnd/*
for object in "$top"/bin/*; do
  # shellcheck disable=SC2016
  patchelf --force-rpath --set-rpath '$ORIGIN/../lib' "$object"
done
for library in "$top"/lib/*.so*; do
  # shellcheck disable=SC2016
  patchelf --force-rpath --set-rpath '$ORIGIN' "$library"
done

# The licences of what is passed on.
cp "$source_dir/LICENSE" "$top/LICENSE"
for path in "${copied[@]}"; do
  # By the file's name: a package may list it below /lib, the link it was found by lies below /usr/lib.
  package=$(dpkg-query -S "*/$(basename "$(readlink -f "$path")")" | awk -F: 'NR == 1 { print $1 }') || package=
  [ -r "/usr/share/doc/$package/copyright" ] || fail "no licence found for $path"
  install -m 644 "/usr/share/doc/$package/copyright" "$top/licences/$package"
done

glibc=$(find "$top/bin" "$top/lib" -type f -exec readelf -V {} + 2>/dev/null | grep -oE 'GLIBC_[0-9]+\.[0-9]+' |
  cut -d_ -f2 | sort -uV | tail -n 1)

cat >"$top/README.txt" <<TEXT
crowdbench, as one folder for an x86-64 Linux with glibc $glibc or newer and a system OpenGL driver with EGL.

  ./selfcheck                        draws a crowd, or says in one line what is missing
  ./crowdbench info                  the device that will draw
  ./crowdbench --help                everything else

Nothing needs to be installed; move the folder where you like. The OpenGL driver is the machine's; so are libEGL and
libOpenGL (or libGL), unless it has none: then those in lib/glvnd serve. Bakes are kept in \${XDG_CACHE_HOME:-~/.cache}/crowdbench; CROWDBENCH_CACHE_DIR moves them.
Left out, because they are large and drawing does not need them: OpenImageIO (EXR files and pictures other than PNG) and
FFmpeg (clips). A command that needs one says so. Licences of the libraries in lib/: licences/.
TEXT

cat >"$top/start" <<TEXT
# Read by crowdbench and test_renderers, with \$here: this folder, and \$program: what of bin/ to start.
has() (  # one of these files, in a folder where libraries lie
  IFS=:
  for folder in \${LD_LIBRARY_PATH:-} /usr/lib/x86_64-linux-gnu /lib/x86_64-linux-gnu /usr/lib64 /lib64 /usr/lib /lib \
    /usr/local/lib /usr/local/lib64 /usr/local/nvidia/lib64 /run/opengl-driver/lib; do
    for file in "\$@"; do [ ! -e "\$folder/\$file" ] || exit 0; done
  done
  exit 1
)
# The machine's own OpenGL loaders where it has them.
if ! has libEGL.so.1 || ! has libOpenGL.so.0 libGL.so.1; then
  export LD_LIBRARY_PATH="\$here/lib/glvnd\${LD_LIBRARY_PATH:+:\$LD_LIBRARY_PATH}"
fi
# glvnd finds drivers by descriptions; a container often has NVIDIA's driver without its description.
if [ -z "\${__EGL_VENDOR_LIBRARY_FILENAMES:-}\${__EGL_VENDOR_LIBRARY_DIRS:-}" ] && has libEGL_nvidia.so.0 &&
  ! ls /etc/glvnd/egl_vendor.d/*nvidia* /usr/share/glvnd/egl_vendor.d/*nvidia* >/dev/null 2>&1; then
  export __EGL_VENDOR_LIBRARY_FILENAMES="\$here/lib/glvnd/10_nvidia.json"
  for file in /etc/glvnd/egl_vendor.d/*.json /usr/share/glvnd/egl_vendor.d/*.json; do
    [ ! -e "\$file" ] || __EGL_VENDOR_LIBRARY_FILENAMES="\$__EGL_VENDOR_LIBRARY_FILENAMES:\$file"
  done
fi
# Its C++ run time is the machine's own where that is new enough, because the machine's OpenGL driver may need it; else the
# one in lib/fallback.
if "\$here/bin/crowdbench" --version >/dev/null 2>&1; then
  exec "\$here/bin/\$program" "\$@"
fi
export LD_LIBRARY_PATH="\$here/lib/fallback\${LD_LIBRARY_PATH:+:\$LD_LIBRARY_PATH}"
if "\$here/bin/crowdbench" --version >/dev/null 2>&1; then
  exec "\$here/bin/\$program" "\$@"
fi
echo "\$program: this bundle needs an x86-64 Linux with glibc $glibc or newer; this is \$(uname -m) with \$(
  getconf GNU_LIBC_VERSION 2>/dev/null || echo another C library)" >&2
exit 2
TEXT
cat >"$top/lib/glvnd/10_nvidia.json" <<'TEXT'
{ "file_format_version": "1.0.0", "ICD": { "library_path": "libEGL_nvidia.so.0" } }
TEXT

starter() {  # PROGRAM
  cat >"$top/$1" <<TEXT
#!/bin/sh
# Starts bin/$1.
self=\$(readlink -f -- "\$0")
here=\${self%/*}
program=$1
. "\$here/start"
TEXT
  chmod 755 "$top/$1"
}
starter crowdbench
if [ -n "$with_tests" ]; then
  starter test_renderers
  mkdir -p "$top/tests/data"
  cp -r "$source_dir/tests/data/golden" "$top/tests/data/"
  install -m 755 "$source_dir/tools/gpu_check.sh" "$top/gpu_check"
  install -m 755 "$source_dir/tools/figures.sh" "$top/figures.sh"
fi

cat >"$top/selfcheck" <<'TEXT'
#!/bin/sh
# Draws a small crowd on this machine and checks that something came out. Arguments go to crowdbench (--device N, say).
self=$(readlink -f -- "$0")
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
"${self%/*}/crowdbench" render --agents 20 --size 320x240 "$@" --out "$work/crowd.png" || exit
size=$(wc -c <"$work/crowd.png")
if [ "$size" -lt 5000 ]; then  # an empty picture of this size has about 1,000 bytes
  echo "selfcheck: the picture is empty" >&2
  exit 1
fi
echo "selfcheck: fine"
TEXT
chmod 755 "$top/selfcheck"

# ---- proof and archive ------------------------------------------------------------------------------------------------

# From another place and without any path of this machine in the environment, everything but what the target provides
# must come out of the folder.
moved=$stage/elsewhere
mv "$top" "$moved"
outside=$(env -i ldd "$moved"/bin/* | awk -v inside="$moved/" '$2 == "=>" && index($3, inside) != 1 {print $1}' |
  sort -u | while read -r soname; do from_target "$soname" || fallback "$soname" || echo "$soname"; done)
[ -z "$outside" ] || fail "these would come from outside of the bundle:" $outside
env -i "$moved/crowdbench" --version >/dev/null || fail "the bundled driver does not start"
mv "$moved" "$top"

rm -f "$out"
tar -C "$stage" --sort=name --owner=0 --group=0 --numeric-owner --mtime='2020-01-01 00:00Z' -cf - "$name" |
  gzip -9n >"$out.part"
bytes=$(stat -c %s "$out.part")
if [ "$bytes" -ge $((limit_mib * 1024 * 1024)) ]; then
  rm -f "$out.part"
  fail "the archive has $bytes bytes, more than $limit_mib MiB"
fi
mv "$out.part" "$out"
echo "bundle: $((bytes / 1024)) KiB, $(find "$top/lib" -type f | wc -l) libraries, needs glibc $glibc" >&2
echo "$out"
