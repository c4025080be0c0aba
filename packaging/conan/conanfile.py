# SPDX-License-Identifier: Apache-2.0
"""conan create packaging/conan: the library of this source tree, shared or static, on the CPU; -o "&:cuda=True" with a CUDA toolkit."""
import os
import re

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load

required_conan_version = ">=2.0"


class Meltsim(ConanFile):
    name = "meltsim"
    description = "Melting and flowing: particle liquid, lattice-shape-matching solids, heat"
    license = "Apache-2.0"
    topics = ("simulation", "sph", "melting", "physics", "cuda")
    package_type = "library"
    settings = "os", "compiler", "build_type", "arch"
    options = {"shared": [True, False], "cuda": [True, False]}
    default_options = {"shared": True, "cuda": False}

    def set_version(self):
        text = load(self, os.path.join(self.recipe_folder, "..", "..", "include", "meltsim", "version.hpp"))
        self.version = ".".join(re.search(rf"VERSION_{part} (\d+)", text)[1] for part in ("MAJOR", "MINOR", "PATCH"))

    def export_sources(self):
        root = os.path.join(self.recipe_folder, "..", "..")
        for pattern in ("CMakeLists.txt", "LICENSE", "cmake/*", "include/*", "src/*", "cuda/*"):
            copy(self, pattern, root, self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        for part in ("TESTS", "EXAMPLES", "BENCHMARKS"):
            toolchain.cache_variables[f"MELTSIM_BUILD_{part}"] = False
        toolchain.cache_variables["MELTSIM_CUDA"] = "ON" if self.options.cuda else "OFF"
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()

    def package_info(self):
        # The library's own CMake package is used: it knows what a static library needs.
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs.append(os.path.join("lib", "cmake", "meltsim"))
        self.cpp_info.libs = ["meltsim"]
        if self.settings.os == "Linux" and not self.options.shared:
            self.cpp_info.system_libs = ["pthread", "m"]
