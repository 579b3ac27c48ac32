"""Runs the vcpkg port and the Conan recipe as far as that goes without vcpkg and Conan. usage: check_recipes.py ROOT WORK

The port is run by CMake with functions in place of vcpkg's, the recipe by Python with classes in place of Conan's: the
sources that the recipe exports are configured, built and installed with its settings. Versions and features of both are
those of the project."""

import json
import re
import shutil
import subprocess
import sys
import types
from pathlib import Path

root, work = Path(sys.argv[1]), Path(sys.argv[2])


def run(*command):
    subprocess.run([str(each) for each in command], check=True, stdout=subprocess.DEVNULL)


def check_port(version):
    port = root / "packaging/vcpkg/pliant"
    manifest = json.loads((port / "vcpkg.json").read_text())
    assert manifest["version-semver"] == version
    assert set(manifest["features"]) == {"bullet", "ccd"}
    run("cmake", "-D", f"PORT={port}/portfile.cmake", "-D", f"BUILD={work}/vcpkg", "-D", "FEATURES=ccd",
        "-P", root / "tests/install/vcpkg_functions.cmake")


class Options(dict):
    __getattr__ = dict.__getitem__

    def rm_safe(self, name):
        self.pop(name, None)


class Recorder:
    """In place of Conan's generators and of CMake: knows what it was told."""

    def __init__(self, recipe):
        self.cache_variables, self.properties, recipe.made = {}, {}, [*getattr(recipe, "made", []), self]

    def set_property(self, *words):
        self.properties[words[:-1]] = words[-1]

    def generate(self):
        pass


class Component(Recorder):
    def __init__(self):
        super().__init__(types.SimpleNamespace())
        self.components = {}


def copy(recipe, pattern, source, target):
    found = [path for path in Path(source).glob(pattern.removesuffix("*") + ("**/*" if pattern.endswith("*") else ""))
             if path.is_file()]
    assert found, f"{pattern}: nothing to export"
    for path in found:
        place = Path(target) / path.relative_to(source)
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, place)


def load_recipe():
    names = {"conan": {"ConanFile": object}, "conan.tools": {}, "conan.tools.files": {"copy": copy},
             "conan.tools.gnu": {"PkgConfigDeps": Recorder},
             "conan.tools.cmake": {"CMake": Recorder, "CMakeDeps": Recorder, "CMakeToolchain": Recorder,
                                   "cmake_layout": lambda recipe: None}}
    for name, members in names.items():
        sys.modules[name] = types.ModuleType(name)
        vars(sys.modules[name]).update(members)
    path = root / "packaging/conan/conanfile.py"
    module = {}
    exec(compile(path.read_text(), str(path), "exec"), module)
    return module["Pliant"], path.parent


def check_recipe(version):
    kind, folder = load_recipe()
    recipe = kind()
    recipe.recipe_folder, recipe.export_sources_folder = str(folder), str(work / "conan/sources")
    recipe.options, recipe.settings, recipe.cpp_info = Options(kind.default_options), Options(), Component()
    recipe.cpp_info.components = {name: Component() for name in ("core", "bullet")}
    assert kind.version == version
    assert set(kind.options) == set(kind.default_options)
    recipe.export_sources()
    recipe.configure()
    recipe.requirements()
    recipe.generate()
    settings = [f"-D{name}={'ON' if value else 'OFF'}" for each in recipe.made
                for name, value in each.cache_variables.items()]
    assert len(settings) == 6
    run("cmake", "-S", work / "conan/sources", "-B", work / "conan/build", "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Debug",
        "-DCMAKE_UNITY_BUILD=ON", "-DCMAKE_UNITY_BUILD_BATCH_SIZE=0",
        f"-DCMAKE_INSTALL_PREFIX={work}/conan/package", "-DCMAKE_INSTALL_LIBDIR=lib", *settings)
    run("cmake", "--build", work / "conan/build", "--target", "install")
    recipe.package_info()
    core = recipe.cpp_info.components["core"]
    for library in core.libs:
        assert (work / f"conan/package/lib/lib{library}.a").exists()
    assert core.properties[("cmake_target_name",)] == "pliant::pliant"


shutil.rmtree(work, ignore_errors=True)
project_version = re.search(r"project\(pliant VERSION ([\d.]+)", (root / "CMakeLists.txt").read_text())[1]
check_port(project_version)
check_recipe(project_version)
print("the port and the recipe build and install the library")
