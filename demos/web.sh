#!/bin/sh
# The page in the browser: installs what is missing (Debian, with apt), builds libccd and Bullet from Debian's source
# packages and the scenes with Emscripten, and puts the page into build/web, which any static server can serve. The
# last line of the output is its path. A second run only does what is left.
#
#   usage: sh demos/web.sh [--test [SCENE...] | --bench | --install]
#
# With --install it only installs what --test needs. With --test headless Chromium then runs every scene, or those named: errors, hashes and pictures against the program,
# dragging. With --bench the speed of a step is compared with the program's. With either modules of the core are linked,
# unless scenes are named, and it is an error when they are too large.
set -eu
cd "$(dirname "$0")/.."
. cmake/bootstrap.sh

web_packages="cmake           command cmake
ninja-build     command ninja
pkg-config      command pkg-config
emscripten      command emcc
dpkg-dev        command dpkg-source
chromium        command chromium
chromium-driver command chromedriver
python3-selenium file /usr/lib/python3/dist-packages/selenium/__init__.py"
if [ -n "${1-}" ]; then
    packages="$packages
$web_packages
python3-skimage file /usr/lib/python3/dist-packages/skimage/__init__.py
gdb             command gdb"
else
    packages=$web_packages
fi
install_missing
[ "${1-}" != --install ] || exit 0

sources=$PWD/build/web-sources
prefix=$sources/prefix
module=build/web-module
log=build/web.log
export NODE_PATH="${NODE_PATH:+$NODE_PATH:}/usr/share/nodejs" # where Debian's Emscripten finds its modules
flags="-fwasm-exceptions -ffp-contract=off" # without SIMD: see docs/web.md
export PYTHONDONTWRITEBYTECODE=1
mkdir -p "$sources/lists/partial" "$sources/cache/archives/partial"

quietly() { # COMMAND...: its output is shown only when it fails
    "$@" >"$log" 2>&1 || {
        tail -n 30 "$log" >&2
        exit 1
    }
}

# With lists of its own: those of the system stay as they are.
get_sources() { # PACKAGE...
    # Where the system has its packages from.
    keyring=/usr/share/keyrings/debian-archive-keyring.gpg
    apt-get indextargets --format "deb-src [signed-by=$keyring] \$(REPO_URI) \$(RELEASE) \$(COMPONENT)" \
        'Created-By: Packages' | sort -u >"$sources/sources.list"
    apt="apt-get -o Dir::Etc::sourcelist=$sources/sources.list -o Dir::Etc::sourceparts=/dev/null
        -o Dir::State::lists=$sources/lists -o Dir::Cache=$sources/cache -o APT::Sandbox::User=$(id -un)"
    # shellcheck disable=SC2086 # a list of words
    quietly $apt update
    # shellcheck disable=SC2086
    (cd "$sources" && log=$OLDPWD/$log && quietly $apt source "$@")
}

build_library() { # FOLDER OPTION...
    folder=$(echo "$sources/$1"-[0-9]*/)
    shift
    quietly emcmake cmake -G Ninja -S "$folder" -B "$folder/build-web" -DCMAKE_BUILD_TYPE=Release \
        -DCMAKE_INSTALL_PREFIX="$prefix" -DCMAKE_INSTALL_LIBDIR=lib -DBUILD_SHARED_LIBS=OFF \
        "-DCMAKE_C_FLAGS=$flags" "-DCMAKE_CXX_FLAGS=$flags" "$@"
    quietly cmake --build "$folder/build-web" --target install -j "$(nproc)"
}

if [ ! -e "$prefix/lib/pkgconfig/ccd.pc" ]; then
    say "building libccd"
    [ -n "$(find "$sources" -maxdepth 1 -name 'libccd-*' -type d)" ] || get_sources libccd bullet
    # In double precision, as Debian builds it; the mathematical library is part of Emscripten.
    build_library libccd -DENABLE_DOUBLE_PRECISION=ON -DLIBM_LIBRARY=m -DBUILD_TESTING=OFF
fi
if [ ! -e "$prefix/lib/pkgconfig/bullet.pc" ]; then
    say "building Bullet"
    build_library bullet "-DCMAKE_PROJECT_INCLUDE=$PWD/demos/web/bullet_unity.cmake" \
        -DCMAKE_UNITY_BUILD_BATCH_SIZE=0 -DUSE_DOUBLE_PRECISION=OFF -DBUILD_EXTRAS=OFF -DBUILD_BULLET2_DEMOS=OFF \
        -DBUILD_OPENGL3_DEMOS=OFF -DBUILD_CPU_DEMOS=OFF -DBUILD_UNIT_TESTS=OFF -DBUILD_BULLET3=OFF \
        -DBUILD_PYBULLET=OFF -DINSTALL_LIBS=ON
fi

say "building the module"
export PKG_CONFIG_LIBDIR="$prefix/lib/pkgconfig"
quietly emcmake cmake -G Ninja -S . -B $module -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON \
    -DCMAKE_UNITY_BUILD_BATCH_SIZE=0 -DCMAKE_FIND_ROOT_PATH_MODE_LIBRARY=BOTH \
    -DPLIANT_BUILD_TESTS=OFF -DPLIANT_BUILD_PYTHON=OFF -DPLIANT_INSTALL=OFF -DPLIANT_BUILD_BRIDGE=ON -DPLIANT_WERROR=OFF \
    -DCMAKE_C_FLAGS=-msimd128 "-DCMAKE_CXX_FLAGS=-msimd128 -fwasm-exceptions" \
    "-DCMAKE_C_FLAGS_RELEASE=-Oz -sINLINING_LIMIT=0 -flto -DNDEBUG" # the core: see docs/web.md
quietly cmake --build $module --target pliant_web -j "$(nproc)"
unset PKG_CONFIG_LIBDIR

mkdir -p build/web/data
cp demos/web/page/* $module/demos/web/pliant_web.mjs $module/demos/web/pliant_web.wasm build/web/
cp demos/data/bunny.obj demos/data/tetra_*.node demos/data/tetra_*.ele demos/data/tetra_*.face build/web/data/
if [ ! -e build/web/pictures/complete ]; then
    say "drawing the gallery's pictures"
    scenes=
    [ "${1-}" != --test ] || scenes=$(shift && echo "$*")
    # shellcheck disable=SC2086 # a list of words
    quietly /usr/bin/python3 demos/web/pictures.py build/web $scenes
fi

measure_core() {
    say "sizes of the core"
    /usr/bin/python3 demos/web/core_size.py $module/core/libpliant.a "$prefix/lib/libccd.a" \
        build/release/demos/app/pliant build/web-core
}

if [ "${1-}" = --bench ]; then
    build_preset release pliant_program
    say "measuring"
    /usr/bin/python3 demos/web/bench.py build/web build/release/demos/app/pliant
    measure_core
elif [ "${1-}" = --test ]; then
    build_preset release pliant_program
    cc -O2 -fno-builtin -ffp-contract=off -shared -fPIC demos/web/float_math.c -o build/web-float-math.so -lm
    shift
    [ $# -gt 0 ] || measure_core
    say "running scenes in the browser"
    /usr/bin/python3 demos/web/test_page.py build/web build/release/demos/app/pliant \
        "$PWD/build/web-float-math.so" build/web-test "$@"
else
    echo "$PWD/build/web/index.html"
fi
