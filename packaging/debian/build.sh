#!/bin/sh
# Builds the Debian packages libpliant0, libpliant-dev, pliant-tools and python3-pliant into build/debian, and prints
# their names.
#
#   usage: sh packaging/debian/build.sh [--test]
#
# --test: lintian has no errors; the libraries show names of Pliant alone; the packages are installed on this machine,
# programs of the core and of the bridge, both hellos among them, are built against them with CMake and with pkg-config,
# and run; so are the tests of the Python package.
set -eu
cd "$(dirname "$0")/../.."
. cmake/bootstrap.sh
packages="$packages
dpkg-dev        command dpkg-gensymbols
file            command file
python3-cffi    file    /usr/lib/python3/dist-packages/cffi/__init__.py
python3-numpy   file    /usr/lib/python3/dist-packages/numpy/__init__.py
python3-pytest  file    /usr/lib/python3/dist-packages/pytest/__init__.py"
[ "${1:-}" != --test ] || packages="$packages
lintian         command lintian"
install_missing

say "building the packages"
out=build/debian
mkdir -p $out
multiarch=$(dpkg-architecture -qDEB_HOST_MULTIARCH)
rm -f $out/*.deb
cmake -S . -B $out -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=ON -DCMAKE_INSTALL_PREFIX=/usr \
    -DCMAKE_INSTALL_LIBDIR="lib/$multiarch" -DCMAKE_SKIP_INSTALL_RPATH=ON -DPLIANT_BUILD_BRIDGE=ON -DPLIANT_BUILD_DEMOS=ON \
    -DPLIANT_BUILD_TESTS=OFF -DPLIANT_BUILD_PYTHON=ON -DPLIANT_DEBIAN_PACKAGES=ON >$out.log
ninja -C $out >>$out.log

# The version of the library since which a program that was linked with a name can run; the bridge, in C++, as a whole.
version=$(sed -n 's/^set(CPACK_PACKAGE_VERSION "\(.*\)")/\1/p' $out/CPackConfig.cmake)
core=$(ls $out/core/libpliant.so.*.*.*)
bridge=$(ls $out/bullet_bridge/libpliant_bullet.so.*.*.*)
mkdir -p $out/debian
printf 'Source: pliant\n\nPackage: libpliant0\nArchitecture: any\n' >$out/debian/control
(cd $out && dpkg-gensymbols -plibpliant0 -v"$version" -e"../../$core" -Osymbols -q >/dev/null)
soname() { objdump -p "$1" | sed -n 's/^ *SONAME *\(.*\)\.so\.\(.*\)/\1 \2/p'; }
for library in "$core" "$bridge"; do
    printf '%s libpliant0 (>= %s)\n' "$(soname "$library")" "$version"
done >$out/shlibs
echo 'activate-noawait ldconfig' >$out/triggers
(cd $out && cpack >>../debian.log)
ls $out/*.deb
[ "${1:-}" = --test ] || exit 0

say "testing the packages"
# The address of the maintainer is for whoever publishes them to set (PLIANT_PACKAGE_CONTACT).
lintian --fail-on error --suppress-tags bogus-mail-host,initial-upload-closes-no-bugs $out/*.deb
nm -D --defined-only "$core" >$out/names
foreign=$(awk '$3 !~ /^pli_/ {print $3}' $out/names)
[ -z "$foreign" ] || { echo "$core shows $foreign" >&2; exit 1; }
apt-get install -y -qq --allow-downgrades ./$out/*.deb >/dev/null
trap 'apt-get remove -y -qq libpliant0 libpliant-dev pliant-tools python3-pliant >/dev/null' EXIT
pliant --version
zcat /usr/share/man/man1/pliant.1.gz >/dev/null
for how in find_package pkg_config; do
    rm -rf $out/consumer_$how
    cmake -S tests/install/consumer -B $out/consumer_$how -G Ninja -DHOW=$how -DWITH_BULLET=ON \
        "-DHELLOS=$PWD/demos" >/dev/null
    ninja -C $out/consumer_$how >/dev/null
    ctest --test-dir $out/consumer_$how --no-tests=error --output-on-failure
done
# Away from the sources, so that the package is the installed one.
(cd / && PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 -m pytest -q -p no:cacheprovider "$OLDPWD/python/tests")
