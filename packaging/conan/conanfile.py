"""Recipe of this tree for Conan 2: conan create packaging/conan"""

from pathlib import Path

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy
from conan.tools.gnu import PkgConfigDeps


class Pliant(ConanFile):
    name = "pliant"
    version = "0.1.0"
    description = "Soft-body dynamics in C17: cloth, ropes, balloons and solids, with a bridge to Bullet"
    license = "Zlib"
    topics = ("physics", "soft-body", "cloth", "simulation")
    settings = "os", "arch", "compiler", "build_type"
    options = {"shared": [True, False], "fPIC": [True, False], "with_bullet": [True, False], "with_ccd": [True, False]}
    default_options = {"shared": False, "fPIC": True, "with_bullet": False, "with_ccd": False}
    package_type = "library"

    def export_sources(self):
        root = str(Path(self.recipe_folder).parents[1])
        for pattern in ("CMakeLists.txt", "LICENSE", "cmake/*", "core/*", "bullet_bridge/*", "packaging/amalgamation/*",
                        "python/CMakeLists.txt"):
            copy(self, pattern, root, self.export_sources_folder)

    def configure(self):
        if self.options.shared:
            self.options.rm_safe("fPIC")
        if not self.options.with_bullet:  # all of it is C then
            self.settings.rm_safe("compiler.cppstd")
            self.settings.rm_safe("compiler.libcxx")

    def requirements(self):
        if self.options.with_bullet:
            self.requires("bullet3/3.25", transitive_headers=True)
        if self.options.with_ccd:
            self.requires("libccd/2.1")

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables.update({
            "PLIANT_BUILD_BRIDGE": bool(self.options.with_bullet),
            "PLIANT_WITH_CCD": bool(self.options.with_ccd),
            "PLIANT_BUILD_DEMOS": False,
            "PLIANT_BUILD_TESTS": False,
            "PLIANT_BUILD_PYTHON": False,
            "PLIANT_WERROR": False,
        })
        toolchain.generate()
        CMakeDeps(self).generate()
        dependencies = PkgConfigDeps(self)  # by which Pliant finds them
        if self.options.with_bullet:
            dependencies.set_property("bullet3", "pkg_config_name", "bullet")
        if self.options.with_ccd:
            dependencies.set_property("libccd", "pkg_config_name", "ccd")
        dependencies.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()
        copy(self, "LICENSE", self.source_folder, str(Path(self.package_folder) / "licenses"))

    def package_info(self):
        self.cpp_info.set_property("cmake_file_name", "pliant")
        core = self.cpp_info.components["core"]
        core.libs = ["pliant"]
        core.system_libs = ["m", "pthread"]
        core.set_property("cmake_target_name", "pliant::pliant")
        core.set_property("pkg_config_name", "pliant")
        if self.options.shared:
            core.defines = ["PLIANT_SHARED"]
        if self.options.with_ccd:
            core.requires = ["libccd::libccd"]
        if self.options.with_bullet:
            bridge = self.cpp_info.components["bullet"]
            bridge.libs = ["pliant_bullet"]
            bridge.requires = ["core", "bullet3::bullet3"]
            bridge.set_property("cmake_target_name", "pliant::bullet")
            bridge.set_property("pkg_config_name", "pliant-bullet")
