# Sourced by ./run and ./check: what Halflight is built with on Debian, and how it is brought in.
# Works on Debian 12 and 13 and on Ubuntu releases that carry the same packages.

build_packages=(
  g++ cmake ninja-build pkg-config
  libembree-dev libtbb-dev libglfw3-dev libimgui-dev
  libgl-dev libegl-dev libegl-mesa0 libgl1-mesa-dri libopengl-dev libosmesa6
  nlohmann-json3-dev libdraco-dev libmeshoptimizer-dev libwebp-dev
  fonts-dejavu-core libopenexr-dev libstb-dev libglm-dev libfmt-dev libcli11-dev
  gnuplot-nox
)
test_packages=(libtinygltf-dev libgtest-dev python3 xvfb xauth xdotool imagemagick)

say() { printf '%s\n' "$*" >&2; }

# missing_packages NAME...: those of them that are not installed.
missing_packages() {
  local name
  for name in "$@"; do
    dpkg-query -W -f='${db:Status-Status}\n' "$name" 2>/dev/null | grep -qx installed || printf '%s\n' "$name"
  done
}

# install_packages NAME...: brings in what is missing, or says why it cannot and stops.
install_packages() {
  if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    say "This system has no apt. Install the counterparts of these Debian packages, then build with"
    say "'cmake --preset release && cmake --build --preset release':"
    say "  $*"
    exit 1
  fi
  local missing
  mapfile -t missing < <(missing_packages "$@")
  [ ${#missing[@]} -eq 0 ] && return 0

  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null || ! sudo -n true 2>/dev/null && ! [ -t 0 ]; then
      say "These Debian packages are missing and installing them needs root:"
      say "  ${missing[*]}"
      say "Install them with: apt-get install ${missing[*]}"
      exit 1
    fi
    as_root=(sudo)
  fi
  say "Installing ${#missing[@]} Debian packages: ${missing[*]}"
  # Both steps write their progress away from standard output: that belongs to the program's own results.
  "${as_root[@]}" apt-get update -qq >&2 &&
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >&2 || {
    say "Installing failed; apt's messages are above. Needed: ${missing[*]}"
    exit 1
  }
}

# build PRESET [TARGET...]: configures (once) and builds; a few lines, or the whole log when it fails.
build() {
  local preset=$1 log
  shift
  log=$(mktemp)
  say "Building $preset${*:+ ($*)} …"
  local targets=()
  [ $# -gt 0 ] && targets=(--target "$@")
  if ! { cmake --preset "$preset" && cmake --build --preset "$preset" "${targets[@]}"; } >"$log" 2>&1; then
    cat "$log" >&2
    rm -f "$log"
    say "Building failed."
    exit 1
  fi
  rm -f "$log"
}
