# Sourced by tools/gaitslam, tools/test.sh and .ci/*. Installs missing packages and builds; $root is the project folder.
# All output goes to stderr.

say() { echo "gaitslam: $*" >&2; }

# missing_packages LIST...: prints the packages in these lists that are not installed.
missing_packages() {
  command -v dpkg-query >/dev/null || return 0  # not Debian: CMake reports what is missing
  packages=$(sed 's/#.*//' "$@")
  installed=" $(dpkg-query -W -f '${db:Status-Status}=${Package} ' $packages 2>/dev/null || true) "
  for package in $packages; do
    case $installed in *" installed=$package "*) continue ;; esac
    command -v "$package" >/dev/null || echo "$package"  # installed by other means, such as npm
  done
}

# install_packages LIST...
install_packages() {
  missing=$(missing_packages "$@" | tr '\n' ' ')
  [ -n "$missing" ] || return 0
  if [ "$(id -u)" = 0 ]; then
    say "installing $missing"
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -qq >&2 && apt-get install -y -qq --no-install-recommends $missing >&2 && return 0
    say "packages could not be installed; once the network is available, run this:"
    say "  apt-get update && apt-get install -y --no-install-recommends $missing"
  else
    say "packages are missing; run this once:"
    say "  sudo apt-get update && sudo apt-get install -y --no-install-recommends $missing"
  fi
  exit 2
}

# Installs the npm packages that tests use into build/interop, at the versions in the lock file. If this
# fails, these tests are skipped; with $CI set, the script fails instead.
install_interop() {
  source=$root/tests/interop folder=$root/build/interop
  cmp -s "$source/package-lock.json" "$folder/node_modules/.installed" && return 0
  mkdir -p "$folder"
  cp "$source/package.json" "$source/package-lock.json" "$folder"
  (cd "$folder" && npm ci --no-audit --no-fund --ignore-scripts >install.log 2>&1) || {
    cat "$folder/install.log" >&2
    [ -z "${CI:-}" ] || { say "npm packages could not be installed; once the network is available, run this again"; exit 2; }
    say "npm packages could not be installed: the tests that need them are skipped"
    return 0
  }
  cp "$source/package-lock.json" "$folder/node_modules/.installed"
}

# build PRESET [TARGET...]: configures a new build folder and runs ninja.
build() {
  folder=$root/build/$1
  mkdir -p "$folder" || { say "$folder cannot be written"; exit 2; }
  exec 9>"$folder/.lock"
  flock 9  # one build at a time per folder
  if [ ! -f "$folder/build.ninja" ] || [ "$root/CMakePresets.json" -nt "$folder/build.ninja" ]; then  # new compiler?
    say "building in build/$1 (the first build takes a few minutes)"
    if command -v ccache >/dev/null; then export CMAKE_CXX_COMPILER_LAUNCHER=ccache; fi
    (cd "$root" && cmake --fresh --preset "$1" >"$folder/configure.log" 2>&1) || {
      cat "$folder/configure.log" >&2
      rm -f "$folder/build.ninja"
      say "configuring failed"
      exit 2
    }
  fi
  shift
  export CCACHE_SLOPPINESS=pch_defines,time_macros  # caches files with precompiled headers
  ninja -C "$folder" "$@" >&2 || { say "the build failed"; exit 2; }
  exec 9>&-
}
